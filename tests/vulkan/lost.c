/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* ddof_render() whose device is lost or out of memory in mid-frame: never a wrong picture that is said to be right,
 * nothing left over, and a new device for the next frame. The linker (--wrap) puts the tap between the backend and its
 * device. */
#include "../library/allocator.h"
#include "tap.h"

#include "vulkan/loader.h"

#include <string.h>

bool __real_vulkan_open(vulkan_session *s, int index, ddof_status *status, char *text, size_t size);
bool __wrap_vulkan_open(vulkan_session *s, int index, ddof_status *status, char *text, size_t size);
PFN_vkVoidFunction __real_vulkan_function(const vulkan_session *s, const char *name);
PFN_vkVoidFunction __wrap_vulkan_function(const vulkan_session *s, const char *name);
ddof_status __real_ddof_vulkan_record(ddof_vulkan_frame *frame, VkCommandBuffer commands, const ddof_vulkan_view *view,
                                      const ddof_settings *settings, ddof_vulkan_stats *stats);
ddof_status __wrap_ddof_vulkan_record(ddof_vulkan_frame *frame, VkCommandBuffer commands, const ddof_vulkan_view *view,
                                      const ddof_settings *settings, ddof_vulkan_stats *stats);

static ddof_vulkan_stats recorded;

bool __wrap_vulkan_open(vulkan_session *s, int index, ddof_status *status, char *text, size_t size) {
    if (!__real_vulkan_open(s, index, status, text, size)) return false;
    own.get_instance_proc_addr = s->get_instance_proc_addr;
    own.instance = s->instance;
    s->get_instance_proc_addr = tap_get_instance_proc_addr;
    return true;
}

PFN_vkVoidFunction __wrap_vulkan_function(const vulkan_session *s, const char *name) {
    return tap_function(name, __real_vulkan_function(s, name));
}

ddof_status __wrap_ddof_vulkan_record(ddof_vulkan_frame *frame, VkCommandBuffer commands, const ddof_vulkan_view *view,
                                      const ddof_settings *settings, ddof_vulkan_stats *stats) {
    const ddof_status status = __real_ddof_vulkan_record(frame, commands, view, settings, &recorded);
    if (stats) *stats = recorded;
    return status;
}

enum { WIDTH = 70, HEIGHT = 50, VALUES = WIDTH * HEIGHT * 4 };

/* A scene, and what it becomes. */
typedef struct example {
    scene s;
    ddof_frame frame;
    float *right;
} example;

static example example_make(void) {
    rng r = {1};
    example e = {.s = scene_fill(WIDTH, HEIGHT, COC_SMOOTH, COLOR_RANDOM, &r),
                 .right = fenced(VALUES * sizeof(float), true)};
    e.frame = scene_frame(&e.s);
    return e;
}

static void example_free(example *e) {
    fenced_free(e->right);
    scene_free(&e->s);
}

static void assert_right(ddof_context *ctx, example *e, const ddof_settings *settings, int at) {
    memset(e->s.output, 0, VALUES * sizeof(float));
    render(ctx, &e->frame, settings);
    assert_same_bits(e->s.output, e->right, VALUES, "after a failure at %d", at);
}

/* Wherever in a frame the device is lost: while work is submitted, or waited for. */
static void lost(void **state) {
    (void)state;
    const ddof_settings settings = {.surface = DDOF_SURFACE_RGBA32F};
    example e = example_make();
    tap_forget();
    ddof_context *ctx = gpu_context(DDOF_BACKEND_VULKAN);
    render(ctx, &e.frame, &settings);
    memcpy(e.right, e.s.output, VALUES * sizeof(float));
    tap.waits = 0;
    render(ctx, &e.frame, &settings);
    const int waits = tap.waits;
    assert_true(waits >= 2);
    for (int at = 1; at <= waits; at++) {
        ddof_stats stats;
        tap.waits = 0;
        tap.wait_at = at;
        tap.fail_with = VK_ERROR_DEVICE_LOST;
        assert_int_equal(ddof_render(ctx, &e.frame, &settings, &stats), DDOF_ERROR_DEVICE);
        assert_non_null(strstr(ddof_error(ctx), "lost"));
        assert_null(stats.device);
        tap.wait_at = 0;
        assert_right(ctx, &e, &settings, at);
    }
    DESTROY(ctx);
    assert_int_equal(tap.live, 0);
    assert_string_equal(tap.untapped, "");
    example_free(&e);
}

/* Whichever call that makes or allocates something fails: no context or no frame; all is given back. */
static void calls_fail(void **state) {
    static const struct {
        VkResult result;
        ddof_status status;
    } failures[] = {{VK_ERROR_OUT_OF_HOST_MEMORY, DDOF_ERROR_MEMORY},
                    {VK_ERROR_OUT_OF_DEVICE_MEMORY, DDOF_ERROR_DEVICE},
                    {VK_ERROR_DEVICE_LOST, DDOF_ERROR_DEVICE}};
    (void)state;
    const ddof_settings settings = {.solver = DDOF_SOLVER_LINE};
    example e = example_make();
    tap_forget();
    ddof_context *ctx = gpu_context(DDOF_BACKEND_VULKAN);
    render(ctx, &e.frame, &settings);
    memcpy(e.right, e.s.output, VALUES * sizeof(float));
    DESTROY(ctx);
    const int calls = tap.calls;
    assert_int_equal(tap.live, 0);
    assert_true(calls > 10);
    for (int k = 0; k < COUNT(failures); k++)
        for (int at = 1; at <= calls; at += GPU_STEP) {
            const ddof_config config = {.backend = DDOF_BACKEND_VULKAN};
            tap_forget();
            tap.fail_at = at;
            tap.fail_with = failures[k].result;
            ddof_status status = ddof_create(&ctx, &config);
            if (status == DDOF_OK) {
                status = ddof_render(ctx, &e.frame, &settings, NULL);
                assert_true(ddof_error(ctx)[0] != 0);
                assert_right(ctx, &e, &settings, at);
            } else {
                assert_null(ctx);
            }
            if (status != failures[k].status)
                fail_msg("result %d at call %d: %s", failures[k].result, at, ddof_status_text(status));
            DESTROY(ctx);
            assert_int_equal(tap.live, 0);
        }
    example_free(&e);
}

static void allocator_fails(void **state) {
    (void)state;
    const ddof_settings settings = {.surface = DDOF_SURFACE_RGBA32F};
    example e = example_make();
    bool done = false;
    for (int at = 1; !done; at++) {
        allocator memory = {.fail_at = at};
        const ddof_config config = {.backend = DDOF_BACKEND_VULKAN,
                                    .allocate = allocator_allocate,
                                    .release = allocator_release,
                                    .memory_user = &memory};
        ddof_context *ctx = NULL;
        tap_forget();
        ddof_status status = ddof_create(&ctx, &config);
        if (status == DDOF_OK) status = ddof_render(ctx, &e.frame, &settings, NULL);
        done = memory.calls < at;
        assert_int_equal(status, done ? DDOF_OK : DDOF_ERROR_MEMORY);
        if (ctx) render(ctx, &e.frame, &settings);
        DESTROY(ctx);
        assert_int_equal(memory.live, 0);
        assert_false(memory.wrong);
        assert_int_equal(tap.live, 0);
    }
    example_free(&e);
}

static int stop(void *user, double done) {
    return done >= *(double *)user;
}

static void cancelled(void **state) {
    (void)state;
    example e = example_make();
    for (double at = 0; at < 1; at += 0.25) {
        double until = at;
        const ddof_config config = {.backend = DDOF_BACKEND_VULKAN, .progress = stop, .progress_user = &until};
        ddof_context *ctx = NULL;
        assert_int_equal(ddof_create(&ctx, &config), DDOF_OK);
        assert_int_equal(ddof_render(ctx, &e.frame, &(ddof_settings){0}, NULL), DDOF_ERROR_CANCELLED);
        until = 2;
        render(ctx, &e.frame, &(ddof_settings){0});
        DESTROY(ctx);
        assert_int_equal(tap.live, 0);
    }
    example_free(&e);
}

/* The second frame of a size makes nothing, and a smaller footprint remains after ddof_trim(). */
static void kept(void **state) {
    (void)state;
    example e = example_make();
    tap_forget();
    ddof_context *ctx = gpu_context(DDOF_BACKEND_VULKAN);
    for (int surface = 0; surface < 3; surface++) {
        const ddof_settings settings = {.surface = (ddof_surface)surface};
        render(ctx, &e.frame, &settings);
        const int calls = tap.calls, live = tap.live;
        memcpy(e.right, e.s.output, VALUES * sizeof(float));
        assert_right(ctx, &e, &settings, 0);
        assert_int_equal(tap.calls, calls);
        assert_int_equal(tap.live, live);
        assert_int_equal(ddof_trim(ctx), DDOF_OK);
        assert_true(tap.live < live);
        assert_right(ctx, &e, &settings, 1);
    }
    DESTROY(ctx);
    assert_int_equal(tap.live, 0);
    example_free(&e);
}

/* ddof_render() uses the subgroups that ddof_devices() tells of. */
static void subgroups(void **state) {
    (void)state;
    example e = example_make();
    ddof_device device;
    assert_true(ddof_devices(DDOF_BACKEND_VULKAN, &device, 1) >= 1);
    ddof_context *ctx = gpu_context(DDOF_BACKEND_VULKAN);
    memset(&recorded, 0xff, sizeof recorded);
    const ddof_stats stats = render(ctx, &e.frame, &(ddof_settings){0});
    assert_string_equal(stats.device, device.name);
    assert_int_equal(recorded.solver, DDOF_SOLVER_LINE);
    assert_int_equal(recorded.dispatches, 2);
    assert_int_equal(recorded.scratch_bytes, 0); /* in place */
    if (device.subgroup_most > 1)
        assert_in_range((unsigned)recorded.subgroup, device.subgroup_least, device.subgroup_most);
    else
        assert_int_equal(recorded.subgroup, 1);
    DESTROY(ctx);
    example_free(&e);
}

static void devices(void **state) {
    (void)state;
    ddof_device all[8];
    memset(all, 0xff, sizeof all);
    const int count = ddof_devices(DDOF_BACKEND_VULKAN, all, COUNT(all));
    assert_true(count >= 1);
    assert_int_equal(ddof_devices(DDOF_BACKEND_VULKAN, NULL, 0), count);
    for (int i = 0; i < count && i < COUNT(all); i++) {
        const ddof_device *d = &all[i];
        assert_true(memchr(d->name, 0, sizeof d->name) && memchr(d->driver, 0, sizeof d->driver));
        for (int k = 0; k < COUNT(d->reserved); k++)
            assert_int_equal(d->reserved[k], 0);
        ddof_context *ctx = NULL;
        const ddof_config config = {.backend = DDOF_BACKEND_VULKAN, .device = i};
        assert_int_equal(ddof_create(&ctx, &config), d->refused[0] ? DDOF_ERROR_UNSUPPORTED : DDOF_OK);
        DESTROY(ctx);
        if (d->refused[0]) continue;
        assert_true(d->name[0] != 0);
        assert_true(d->max_side >= 4096 && d->max_workgroup >= 128 && d->shared_bytes >= 16384 && d->memory_bytes > 0);
        assert_true(d->is_software == 0 || d->is_software == 1);
        assert_true(d->subgroup_least <= d->subgroup_most);
    }
    ddof_context *ctx = (ddof_context *)&own;
    const ddof_config beyond = {.backend = DDOF_BACKEND_VULKAN, .device = count};
    assert_int_equal(ddof_create(&ctx, &beyond), DDOF_ERROR_INVALID);
    assert_null(ctx);
}

int main(void) {
    static const struct CMUnitTest tests[] = {
        cmocka_unit_test(lost),      cmocka_unit_test(calls_fail), cmocka_unit_test(allocator_fails),
        cmocka_unit_test(cancelled), cmocka_unit_test(kept),       cmocka_unit_test(subgroups),
        cmocka_unit_test(devices),
    };
    return run_gpu_tests("vulkan lost", tests, COUNT(tests), gpu_missing(DDOF_BACKEND_VULKAN));
}
