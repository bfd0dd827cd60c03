/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* ddof/vulkan.h where Vulkan, the device or the memory do not do what they should: functions that are not there, calls
 * that fail, devices that can less. */
#include "../library/allocator.h"
#include "pictures.h"

#include <string.h>

static frame_set small_set(VkFormat output) {
    return set_make((frame_kind){.width = 70, .height = 50, .output = output, .coc = COC_SMOOTH}, 50);
}

/* ---- functions that are not there */

static void hidden_functions(void **state) {
    (void)state;
    const char *names[TAP_NAMES];
    ddof_vulkan *vk = create();
    const int count = tap_name_count;
    assert_true(count > 20 && count < TAP_NAMES);
    memcpy(names, tap_names, sizeof names);
    destroy(&vk);
    for (int i = 0; i < count; i++) {
        tap_forget();
        tap.hidden = names[i];
        vk = (ddof_vulkan *)&tap;
        const ddof_status status = try_create(&vk);
        if (status != DDOF_ERROR_UNSUPPORTED) fail_msg("without %s: %s", names[i], ddof_status_text(status));
        assert_null(vk);
        if (!strstr(said, names[i])) fail_msg("without %s: \"%s\"", names[i], said);
        assert_int_equal(tap.live, 0);
    }
    tap_forget();
    vk = create();
    destroy(&vk);
}

/* ---- calls that fail */

typedef struct failure {
    VkResult result;
    ddof_status status;
    const char *part; /* of the sentence */
} failure;
static const failure failures[] = {{VK_ERROR_OUT_OF_HOST_MEMORY, DDOF_ERROR_MEMORY, "memory"},
                                   {VK_ERROR_OUT_OF_DEVICE_MEMORY, DDOF_ERROR_DEVICE, "memory"},
                                   {VK_ERROR_DEVICE_LOST, DDOF_ERROR_DEVICE, "lost"}};

static void create_fails(void **state) {
    (void)state;
    for (int k = 0; k < COUNT(failures); k++) {
        ddof_vulkan *vk = create();
        const int calls = tap.calls;
        destroy(&vk);
        assert_true(calls > 0);
        for (int at = 1; at <= calls; at++) {
            tap_forget();
            tap.fail_at = at;
            tap.fail_with = failures[k].result;
            vk = (ddof_vulkan *)&tap;
            const ddof_status status = try_create(&vk);
            if (status != failures[k].status) fail_msg("call %d: %s", at, ddof_status_text(status));
            assert_null(vk);
            if (!strstr(said, failures[k].part)) fail_msg("call %d: \"%s\"", at, said);
            assert_int_equal(tap.live, 0);
        }
    }
}

/* Whichever of its calls fails, the frame object is not made, nothing is left over, and the next time it goes well. */
static void frame_fails(const ddof_settings *settings, VkFormat output, const failure *f) {
    frame_set set = small_set(output);
    int calls = 1;
    for (int at = 1; at <= calls; at += GPU_STEP) {
        ddof_vulkan *vk = create();
        const int live = tap.live;
        ddof_vulkan_frame *frame = (ddof_vulkan_frame *)&tap;
        tap.calls = 0;
        tap.fail_at = at;
        tap.fail_with = f->result;
        const ddof_status status = ddof_vulkan_frame_create(vk, &frame, &set.images, settings);
        if (status != f->status)
            fail_msg("%s, call %d: %s", solver_name(settings->solver), at, ddof_status_text(status));
        assert_null(frame);
        if (!strstr(ddof_vulkan_error(vk), f->part)) fail_msg("call %d: \"%s\"", at, ddof_vulkan_error(vk));
        tap.fail_at = 0;
        tap.calls = 0;
        if (at == 1 || at % 4 == 2) { /* the first time counts the calls */
            frame = frame_of(vk, &set, settings);
            ddof_vulkan_frame_destroy(&frame);
        }
        if (at == 1) {
            calls = tap.calls;
            set_check(vk, &set, NULL, settings, "after a failure");
        }
        assert_true(tap.live >= live); /* pipelines are kept */
        destroy(&vk);
    }
    assert_true(calls > 3);
    set_free(&set);
}

static void frames_fail(void **state) {
    static const VkFormat outputs[] = {VK_FORMAT_R8G8B8A8_UNORM, VK_FORMAT_R16G16B16A16_SFLOAT,
                                       VK_FORMAT_R8G8B8A8_UNORM};
    (void)state;
    for (int k = 0; k < METHODS + 1; k++) { /* LINE: in each way, the others, which compile long, in one */
        const ddof_settings settings = method(k < 3 ? 0 : k - 2, DDOF_SURFACE_RGBA32F);
        frame_fails(&settings, outputs[k % 3], &failures[k % 3]);
    }
}

/* Objects of a frame go with it; those that are kept are not made again. */
static void objects_are_kept(void **state) {
    (void)state;
    ddof_vulkan *vk = create();
    frame_set set = small_set(VK_FORMAT_R8G8B8A8_UNORM);
    for (int k = 0; k < METHODS; k++) {
        const ddof_settings settings = method(k, DDOF_SURFACE_DEFAULT);
        int live = 0;
        for (int i = 0; i < 4; i++) {
            ddof_vulkan_frame *frame = frame_of(vk, &set, &settings);
            ddof_vulkan_frame_destroy(&frame);
            assert_null(frame);
            if (i == 0) live = tap.live;
            assert_int_equal(tap.live, live);
        }
    }
    set_free(&set);
    destroy(&vk);
}

static void pipeline_cache_fails(void **state) {
    (void)state;
    ddof_vulkan *vk = create();
    unsigned char data[4096];
    for (int k = 0; k < COUNT(failures); k++) {
        size_t size = sizeof data;
        tap.calls = 0;
        tap.fail_at = 1;
        tap.fail_with = failures[k].result;
        assert_int_equal(ddof_vulkan_pipeline_cache(vk, data, &size), failures[k].status);
        assert_non_null(strstr(ddof_vulkan_error(vk), failures[k].part));
    }
    tap.fail_at = 0;
    size_t size = 0;
    assert_int_equal(ddof_vulkan_pipeline_cache(vk, NULL, &size), DDOF_OK);
    assert_string_equal(ddof_vulkan_error(vk), "");
    destroy(&vk);
}

/* ---- the caller's allocator */

static void allocator_fails(void **state) {
    (void)state;
    frame_set set = small_set(VK_FORMAT_R8G8B8A8_UNORM);
    for (int k = 0; k < METHODS; k++) {
        const ddof_settings settings = method(k, DDOF_SURFACE_DEFAULT);
        bool done = false;
        for (int at = 1; !done; at++) {
            allocator memory = {.fail_at = at};
            ddof_vulkan_config config = tap_config();
            ddof_vulkan *vk = (ddof_vulkan *)&tap;
            ddof_vulkan_frame *frame = (ddof_vulkan_frame *)&tap;
            config.allocate = allocator_allocate;
            config.release = allocator_release;
            config.memory_user = &memory;
            tap_forget();
            said[0] = 0;
            ddof_status status = ddof_vulkan_create(&vk, &config);
            if (status != DDOF_OK) {
                assert_null(vk);
                assert_non_null(strstr(said, "memory"));
            } else {
                status = ddof_vulkan_frame_create(vk, &frame, &set.images, &settings);
                if (status != DDOF_OK) {
                    assert_null(frame);
                    assert_non_null(strstr(ddof_vulkan_error(vk), "memory"));
                    set_check(vk, &set, NULL, &settings, "after a failure"); /* the allocator fails once */
                }
                ddof_vulkan_frame_destroy(&frame);
            }
            assert_int_equal(status, memory.calls >= at ? DDOF_ERROR_MEMORY : DDOF_OK);
            done = status == DDOF_OK;
            if (done) assert_true(at > 1);
            ddof_vulkan_destroy(&vk);
            assert_int_equal(tap.live, 0);
            assert_int_equal(memory.live, 0);
            assert_false(memory.wrong);
        }
    }
    set_free(&set);
}

/* ---- devices that can less */

/* Created with the tap as it is, which stays so. */
static ddof_vulkan *lied_to(void) {
    ddof_vulkan *vk = NULL;
    tap.live = 0; /* what a test that failed has left behind */
    if (try_create(&vk) != DDOF_OK) fail_msg("ddof_vulkan_create: %s", said);
    return vk;
}

static void unfit_devices(void **state) {
    (void)state;
    ddof_vulkan *vk = NULL;
    tap_forget();
    tap.no_compute = true;
    assert_int_equal(try_create(&vk), DDOF_ERROR_UNSUPPORTED);
    assert_non_null(strstr(said, "queue_family"));
    tap_forget();
    tap.api_version = VK_API_VERSION_1_0;
    assert_int_equal(try_create(&vk), DDOF_ERROR_UNSUPPORTED);
    assert_non_null(strstr(said, "1.1"));
    tap_forget();
    tap.max_side = 64;
    vk = lied_to();
    frame_set set = small_set(VK_FORMAT_R16G16B16A16_SFLOAT); /* 70 wide */
    ddof_vulkan_frame *frame = NULL;
    assert_int_equal(ddof_vulkan_frame_create(vk, &frame, &set.images, &(ddof_settings){0}), DDOF_ERROR_UNSUPPORTED);
    assert_non_null(strstr(ddof_vulkan_error(vk), "70"));
    set_free(&set);
    destroy(&vk);
}

static void unfit_formats(void **state) {
    static const VkFormat outputs[] = {VK_FORMAT_R16G16B16A16_SFLOAT, VK_FORMAT_B10G11R11_UFLOAT_PACK32,
                                       VK_FORMAT_R8G8B8A8_UNORM};
    (void)state;
    for (int k = 0; k < 2 * COUNT(outputs); k++) {
        const VkFormat format = outputs[k / 2];
        ddof_vulkan_frame *frame = (ddof_vulkan_frame *)&tap;
        tap_forget();
        *(k % 2 ? &tap.no_sampling : &tap.no_storage) = format;
        ddof_vulkan *vk = lied_to();
        frame_set set = small_set(VK_FORMAT_R32G32B32A32_SFLOAT);
        assert_int_equal(ddof_vulkan_can_output(vk, format) && ddof_vulkan_can_sample(vk, format), 0);
        *(k % 2 ? &set.images.color.format : &set.images.output.format) = format; /* it is not looked at any more */
        assert_int_equal(ddof_vulkan_frame_create(vk, &frame, &set.images, &(ddof_settings){0}),
                         DDOF_ERROR_UNSUPPORTED);
        assert_null(frame);
        assert_non_null(strstr(ddof_vulkan_error(vk), k % 2 ? "color" : "output"));
        set_free(&set);
        destroy(&vk);
    }
}

/* LINE needs a workgroup that holds a line: where it does not, PCR3_SWEEP does it, and is as right. */
static void long_lines(void **state) {
    static const int sizes[][2] = {{8200, 5}, {5, 8200}};
    (void)state;
    for (int k = 0; k < 8; k++) {
        tap_forget();
        if (k / 2 < 2) tap.invocations = k / 2 ? 64 : 32;
        if (k / 2 == 2) tap.shared_bytes = 256;
        ddof_vulkan *vk = lied_to();
        const ddof_settings settings = {.solver = (k % 2) ? DDOF_SOLVER_LINE : DDOF_SOLVER_DEFAULT,
                                        .surface = DDOF_SURFACE_RGBA32F};
        for (int i = 0; i < COUNT(sizes); i++) {
            frame_set set = set_make((frame_kind){.width = sizes[i][0],
                                                  .height = sizes[i][1],
                                                  .output = VK_FORMAT_R32G32B32A32_SFLOAT,
                                                  .coc = COC_SMOOTH},
                                     51);
            const ddof_vulkan_stats stats = set_check(vk, &set, NULL, &settings, "long lines");
            if (k / 2 < 2) {
                assert_int_equal(stats.solver, DDOF_SOLVER_PCR3_SWEEP);
                assert_int_equal(stats.workgroup, 0);
                assert_int_equal(stats.pixels_per_thread, 0);
                assert_int_equal(stats.strip, 0);
                assert_int_equal(stats.subgroup, 0);
            }
            set_free(&set);
        }
        destroy(&vk);
    }
}

/* Sizes that such small workgroups do hold stay with LINE. */
static void small_workgroups(void **state) {
    static const uint32_t invocations[] = {32, 64, 128, 256};
    (void)state;
    for (int k = 0; k < COUNT(invocations); k++) {
        tap_forget();
        tap.invocations = invocations[k];
        ddof_vulkan *vk = lied_to();
        for (int n = 1; n < 200; n = n * 2 + 1) {
            frame_set set = set_make(
                (frame_kind){
                    .width = n, .height = 64 - n / 4, .output = VK_FORMAT_R32G32B32A32_SFLOAT, .coc = COC_SMOOTH},
                52);
            const ddof_vulkan_stats stats =
                set_check(vk, &set, NULL, &(ddof_settings){.surface = DDOF_SURFACE_RGBA32F}, "small workgroups");
            if (n <= 64) assert_int_equal(stats.solver, DDOF_SOLVER_LINE);
            if (stats.solver == DDOF_SOLVER_LINE) {
                assert_true(stats.workgroup <= (int)invocations[k]);
                assert_true(stats.workgroup / stats.strip * stats.pixels_per_thread >= n);
            }
            set_free(&set);
        }
        destroy(&vk);
    }
}

/* Subgroups are used only where all of it is there. */
static void no_subgroups(void **state) {
    (void)state;
    for (int k = 0; k < 4; k++) {
        ddof_vulkan_config config = tap_config();
        VkPhysicalDeviceSubgroupSizeControlFeatures half = own.size_control;
        VkPhysicalDeviceSynchronization2Features synchronization2 = own.synchronization2;
        VkPhysicalDeviceFeatures2 features = own.features;
        features.pNext = &synchronization2;
        synchronization2.pNext = &half;
        half.computeFullSubgroups = VK_FALSE; /* enabled, but not said to be */
        tap_forget();
        tap.no_shuffle = k == 0;
        tap.no_compute_subgroup = k == 1;
        tap.no_required_size = k == 2;
        if (k == 3) config.features = &features;
        ddof_vulkan *vk = NULL;
        assert_int_equal(ddof_vulkan_create(&vk, &config), DDOF_OK);
        frame_set set = set_make(
            (frame_kind){.width = 301, .height = 200, .output = VK_FORMAT_R32G32B32A32_SFLOAT, .coc = COC_SMOOTH}, 53);
        const ddof_vulkan_stats stats =
            set_check(vk, &set, NULL, &(ddof_settings){.surface = DDOF_SURFACE_RGBA32F}, "no subgroups");
        assert_int_equal(stats.solver, DDOF_SOLVER_LINE);
        assert_int_equal(stats.subgroup, 1);
        set_free(&set);
        destroy(&vk);
    }
}

/* The disc kernel has no other solver: small workgroups and no subgroups will do, but lines that are too long are
 * refused. */
static void disc_on_small_devices(void **state) {
    static const struct {
        uint32_t invocations;
        int width, height;
        ddof_quality quality;
        bool fits;
    } cases[] = {{32, 150, 90, DDOF_QUALITY_GOOD, true},   {256, 300, 230, DDOF_QUALITY_BEST, true},
                 {256, 7680, 3, DDOF_QUALITY_DRAFT, true}, {256, 3, 7680, DDOF_QUALITY_DRAFT, true},
                 {32, 2100, 5, DDOF_QUALITY_DRAFT, false}, {32, 5, 2100, DDOF_QUALITY_DRAFT, false}};
    (void)state;
    for (int k = 0; k < COUNT(cases); k++) {
        tap_forget();
        tap.invocations = cases[k].invocations;
        tap.no_shuffle = true;
        ddof_vulkan *vk = lied_to();
        const ddof_settings settings = {
            .kernel = DDOF_KERNEL_DISC, .quality = cases[k].quality, .surface = DDOF_SURFACE_RGBA32F};
        frame_set set = set_make((frame_kind){.width = cases[k].width,
                                              .height = cases[k].height,
                                              .output = VK_FORMAT_R32G32B32A32_SFLOAT,
                                              .coc = COC_SMOOTH},
                                 54);
        if (cases[k].fits) {
            const ddof_vulkan_stats stats = set_check(vk, &set, NULL, &settings, "disc on a small device");
            assert_int_equal(stats.solver, DDOF_SOLVER_LINE);
            assert_int_equal(stats.subgroup, 1);
        } else {
            ddof_vulkan_frame *frame = (ddof_vulkan_frame *)&tap;
            assert_int_equal(ddof_vulkan_frame_create(vk, &frame, &set.images, &settings), DDOF_ERROR_UNSUPPORTED);
            assert_null(frame);
            assert_non_null(strstr(ddof_vulkan_error(vk), "too long"));
        }
        set_free(&set);
        destroy(&vk);
    }
}

int main(void) {
    static const struct CMUnitTest tests[] = {
        cmocka_unit_test(hidden_functions),     cmocka_unit_test(create_fails),
        cmocka_unit_test(frames_fail),          cmocka_unit_test(objects_are_kept),
        cmocka_unit_test(allocator_fails),      cmocka_unit_test(unfit_devices),
        cmocka_unit_test(pipeline_cache_fails), cmocka_unit_test(unfit_formats),
        cmocka_unit_test(long_lines),           cmocka_unit_test(small_workgroups),
        cmocka_unit_test(no_subgroups),         cmocka_unit_test(disc_on_small_devices),
    };
    return run_with_own("vulkan failures", tests, COUNT(tests));
}
