/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Every way to call ddof/vulkan.h wrongly: the status and a sentence that names the argument; and what was being
 * recorded goes on. */
#include "pictures.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { W = 40, H = 30 };

static const ddof_settings plain;

static void assert_sentence(const char *text, const char *part) {
    if (!text[0] || strchr(text, '\n') || !strstr(text, part)) fail_msg("\"%s\" says nothing of \"%s\"", text, part);
}

/* ---- ddof_vulkan_create */

static void not_created(const ddof_vulkan_config *config, ddof_status status, const char *part) {
    ddof_vulkan *vk = (ddof_vulkan *)&tap;
    said[0] = 0;
    const ddof_status got = ddof_vulkan_create(&vk, config);
    if (got != status) fail_msg("%s: %s, not %s", part, ddof_status_text(got), ddof_status_text(status));
    assert_null(vk);
    assert_sentence(said, part);
    assert_int_equal(tap.live, 0);
}

static void *allocate_nothing(void *user, size_t bytes) {
    (void)user, (void)bytes;
    return NULL;
}

static void release_nothing(void *user, void *memory) {
    (void)user, (void)memory;
}

static void configs(void **state) {
    (void)state;
    tap_forget();
    ddof_vulkan_config c = tap_config();
    ddof_vulkan *vk = (ddof_vulkan *)&tap;
    assert_int_equal(ddof_vulkan_create(NULL, &c), DDOF_ERROR_INVALID);
    assert_int_equal(ddof_vulkan_create(NULL, NULL), DDOF_ERROR_INVALID);
    assert_int_equal(ddof_vulkan_create(&vk, NULL), DDOF_ERROR_INVALID);
    assert_null(vk);
    c.instance = NULL, not_created(&c, DDOF_ERROR_INVALID, "config.instance"), c = tap_config();
    c.physical_device = NULL, not_created(&c, DDOF_ERROR_INVALID, "physical_device"), c = tap_config();
    c.device = NULL, not_created(&c, DDOF_ERROR_INVALID, "device"), c = tap_config();
    c.get_instance_proc_addr = NULL, not_created(&c, DDOF_ERROR_INVALID, "config.get_instance_proc_addr");
    for (int i = 0; i < COUNT(c.reserved); i++)
        c = tap_config(), c.reserved[i] = 1, not_created(&c, DDOF_ERROR_INVALID, "config.reserved");
    c = tap_config(), c.release = release_nothing, not_created(&c, DDOF_ERROR_INVALID, "config.release");
    c = tap_config(), c.allocate = allocate_nothing, not_created(&c, DDOF_ERROR_INVALID, "config.allocate");
    c = tap_config(), c.queue_family = 99, not_created(&c, DDOF_ERROR_UNSUPPORTED, "config.queue_family");
    ddof_vulkan_destroy(NULL);
    vk = NULL;
    ddof_vulkan_destroy(&vk);
    vk = create();
    assert_int_equal(ddof_vulkan_can_output(vk, VK_FORMAT_UNDEFINED), 0);
    assert_int_equal(ddof_vulkan_can_sample(vk, VK_FORMAT_R8G8B8A8_UINT), 0);
    assert_int_equal(ddof_vulkan_can_output(vk, VK_FORMAT_R8G8B8A8_SRGB), 0);
    assert_int_equal(ddof_vulkan_can_output(vk, VK_FORMAT_MAX_ENUM), 0);
    destroy(&vk);
}

/* The features that are needed, as they may be told. */
static void features(void **state) {
    (void)state;
    tap_forget();
    ddof_vulkan_config c = tap_config();
    VkPhysicalDeviceSynchronization2Features none = {.sType =
                                                         VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SYNCHRONIZATION_2_FEATURES};
    VkPhysicalDeviceVulkan13Features core = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES};
    VkPhysicalDeviceFeatures2 f = own.features;
    c.features = &f;
    f.pNext = &none, not_created(&c, DDOF_ERROR_UNSUPPORTED, "synchronization2");
    f.pNext = &core, not_created(&c, DDOF_ERROR_UNSUPPORTED, "synchronization2");
    f.pNext = NULL, not_created(&c, DDOF_ERROR_UNSUPPORTED, "synchronization2");
    f = own.features;
    f.features.shaderStorageImageWriteWithoutFormat = VK_FALSE;
    not_created(&c, DDOF_ERROR_UNSUPPORTED, "shaderStorageImageWriteWithoutFormat");
    ddof_vulkan *vk = NULL;
    core.synchronization2 = VK_TRUE;
    none.pNext = &core; /* behind one that is of no use */
    none.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_16BIT_STORAGE_FEATURES;
    f = own.features, f.pNext = &none;
    assert_int_equal(ddof_vulkan_create(&vk, &c), DDOF_OK);
    destroy(&vk);
}

/* ---- images */

static void refused(ddof_vulkan *vk, const ddof_vulkan_images *images, const ddof_settings *settings,
                    ddof_status status, const char *part) {
    ddof_vulkan_frame *frame = (ddof_vulkan_frame *)&tap;
    const int live = tap.live;
    const ddof_status got = ddof_vulkan_frame_create(vk, &frame, images, settings);
    if (got != status) fail_msg("\"%s\": %s, not %s", part, ddof_status_text(got), ddof_status_text(status));
    assert_null(frame);
    assert_sentence(ddof_vulkan_error(vk), part);
    assert_int_equal(tap.live, live);
}

/* By ddof_vulkan_scratch() as well. */
static void refused_by_both(ddof_vulkan *vk, const ddof_vulkan_images *images, const ddof_settings *settings,
                            ddof_status status, const char *part) {
    VkMemoryRequirements needs;
    refused(vk, images, settings, status, part);
    const ddof_status got = ddof_vulkan_scratch(vk, images, settings, &needs);
    if (got != status) fail_msg("scratch, \"%s\": %s, not %s", part, ddof_status_text(got), ddof_status_text(status));
    assert_sentence(ddof_vulkan_error(vk), part);
}

static void bad_images(void **state) {
    (void)state;
    ddof_vulkan *vk = create();
    frame_set set = set_make((frame_kind){.width = W, .height = H, .output = VK_FORMAT_R16G16B16A16_SFLOAT}, 40);
    const ddof_vulkan_images good = set.images;
    const ddof_status bad = DDOF_ERROR_INVALID;
    ddof_vulkan_images i;
    i = good, i.color.format = 0, refused_by_both(vk, &i, &plain, bad, "color");
    i = good, i.output.format = 0, refused_by_both(vk, &i, &plain, bad, "output");
    i = good, i.color.image = NULL, refused(vk, &i, &plain, bad, "color");
    i = good, i.coc.image = NULL, refused(vk, &i, &plain, bad, "coc");
    i = good, i.output.image = NULL, refused(vk, &i, &plain, bad, "output");
    i = good, i.coc.format = 0, refused_by_both(vk, &i, &plain, bad, "exactly one");
    i = good, i.depth = good.coc, refused_by_both(vk, &i, &plain, bad, "exactly one");
    i = good, i.color.format = VK_FORMAT_R32_SFLOAT, refused_by_both(vk, &i, &plain, bad, "color");
    i = good, i.color.format = VK_FORMAT_D32_SFLOAT, refused_by_both(vk, &i, &plain, bad, "color");
    i = good, i.color.format = VK_FORMAT_MAX_ENUM, refused_by_both(vk, &i, &plain, bad, "color");
    i = good, i.coc.format = VK_FORMAT_D32_SFLOAT, refused_by_both(vk, &i, &plain, bad, "coc");
    i = good, i.coc.format = VK_FORMAT_R16G16B16A16_SFLOAT, refused_by_both(vk, &i, &plain, bad, "coc");
    i = good, i.output.format = VK_FORMAT_R8G8B8A8_SRGB, refused_by_both(vk, &i, &plain, bad, "output");
    i = good, i.output.format = VK_FORMAT_R32_SFLOAT, refused_by_both(vk, &i, &plain, bad, "output");
    i = good, i.color.width = 0, refused_by_both(vk, &i, &plain, bad, "color");
    i = good, i.color.height = 0, refused_by_both(vk, &i, &plain, bad, "color");
    i = good, i.color.width = UINT32_MAX, refused_by_both(vk, &i, &plain, DDOF_ERROR_UNSUPPORTED, "color");
    i = good, i.color.width = W - 1, refused_by_both(vk, &i, &plain, bad, "color");
    i = good, i.output.height = H + 1, refused_by_both(vk, &i, &plain, bad, "output");
    i = good, i.coc.width = W - 1, refused_by_both(vk, &i, &plain, bad, "coc");
    i = good, i.coc.width = W / 2, refused_by_both(vk, &i, &plain, bad, "coc");
    i = good, i.coc.height = H / 2, refused_by_both(vk, &i, &plain, bad, "coc");
    i = good, i.coc.height = 0, refused_by_both(vk, &i, &plain, bad, "coc");
    i = good, i.color.usage = VK_IMAGE_USAGE_STORAGE_BIT, refused_by_both(vk, &i, &plain, bad, "color");
    i = good, i.coc.usage = VK_IMAGE_USAGE_TRANSFER_DST_BIT, refused_by_both(vk, &i, &plain, bad, "coc");
    i = good, i.output.usage = VK_IMAGE_USAGE_SAMPLED_BIT, refused_by_both(vk, &i, &plain, bad, "output");
    i = good, i.output.usage = VK_IMAGE_USAGE_STORAGE_BIT, refused_by_both(vk, &i, &plain, bad, "output");
    i = good, i.color.layout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, refused_by_both(vk, &i, &plain, bad, "color");
    i = good, i.coc.layout = VK_IMAGE_LAYOUT_DEPTH_READ_ONLY_OPTIMAL, refused_by_both(vk, &i, &plain, bad, "coc");
    i = good, i.channels = 1, refused_by_both(vk, &i, &plain, bad, "channels");
    i = good, i.channels = 5, refused_by_both(vk, &i, &plain, bad, "channels");
    i = good, i.channels = -4, refused_by_both(vk, &i, &plain, bad, "channels");
    i = good, i.next = &i, refused_by_both(vk, &i, &plain, bad, "next");
    for (int k = 0; k < COUNT(i.reserved); k++)
        i = good, i.reserved[k] = 1, refused_by_both(vk, &i, &plain, bad, "reserved");
    i = good, i.coc.image = good.output.image, refused(vk, &i, &plain, bad, "output");
    i = good, i.color.image = good.output.image, refused(vk, &i, &plain, bad, "output"); /* of another format */
    i = good, i.depth = good.coc, i.coc = (ddof_vulkan_image){0}, i.depth.format = VK_FORMAT_R8_UNORM;
    refused_by_both(vk, &i, &depth_settings, bad, "depth");
    set_check(vk, &set, NULL, &plain, "after all that");
    set_free(&set);
    destroy(&vk);
}

/* Half a map is rounded up. */
static void odd_half_map(void **state) {
    (void)state;
    ddof_vulkan *vk = create();
    frame_set set = set_make(
        (frame_kind){.width = 41, .height = 31, .half_map = true, .output = VK_FORMAT_R16G16B16A16_SFLOAT}, 41);
    ddof_vulkan_images i = set.images;
    i.coc.width = 20, refused_by_both(vk, &i, &plain, DDOF_ERROR_INVALID, "coc"), i = set.images;
    i.coc.height = 15, refused_by_both(vk, &i, &plain, DDOF_ERROR_INVALID, "coc"), i = set.images;
    i.coc.width = 41, refused_by_both(vk, &i, &plain, DDOF_ERROR_INVALID, "coc");
    set_check(vk, &set, NULL, &plain, "half map");
    set_free(&set);
    destroy(&vk);
}

static void bad_scratch(void **state) {
    (void)state;
    ddof_vulkan *vk = create();
    const ddof_settings settings = {.surface = DDOF_SURFACE_RGBA32F};
    frame_set set = set_make((frame_kind){.width = W, .height = H, .output = VK_FORMAT_R16G16B16A16_SFLOAT}, 42);
    const ddof_vulkan_images good = set.images;
    VkMemoryRequirements needs;
    assert_int_equal(ddof_vulkan_scratch(vk, &good, &settings, &needs), DDOF_OK);
    set.images.scratch_memory = own_memory(4 * needs.size, needs.memoryTypeBits, 0);
    ddof_vulkan_images i = set.images;
    i.scratch_size = needs.size - 1, refused(vk, &i, &settings, DDOF_ERROR_INVALID, "scratch");
    if (needs.alignment > 1)
        i = set.images, i.scratch_offset = 1, refused(vk, &i, &settings, DDOF_ERROR_INVALID, "scratch_offset");
    set_check(vk, &set, NULL, &settings, "own scratch");
    VK(vkFreeMemory)(own.device, set.images.scratch_memory, NULL);
    set_free(&set);
    destroy(&vk);
}

static void bad_settings(void **state) {
    (void)state;
    ddof_vulkan *vk = create();
    frame_set set = set_make((frame_kind){.width = W, .height = H, .output = VK_FORMAT_R16G16B16A16_SFLOAT}, 43);
    const ddof_vulkan_images *i = &set.images;
    VkMemoryRequirements needs;
    ddof_vulkan_frame *frame = (ddof_vulkan_frame *)&tap;
    for (int solver = DDOF_SOLVER_CR_VANILLA; solver <= DDOF_SOLVER_CR_PCR; solver++)
        if (solver != DDOF_SOLVER_CR4_PACK)
            refused_by_both(vk, i, &(ddof_settings){.solver = (ddof_solver)solver}, DDOF_ERROR_UNSUPPORTED, "solver");
    refused_by_both(vk, i, &(ddof_settings){.solver = (ddof_solver)10}, DDOF_ERROR_INVALID, "solver");
    refused_by_both(vk, i, &(ddof_settings){.solver = (ddof_solver)-1}, DDOF_ERROR_INVALID, "solver");
    refused_by_both(vk, i, &(ddof_settings){.surface = (ddof_surface)3}, DDOF_ERROR_INVALID, "surface");
    refused_by_both(vk, i, &(ddof_settings){.surface = (ddof_surface)-1}, DDOF_ERROR_INVALID, "surface");
    refused_by_both(vk, i, &(ddof_settings){.reserved = {0, 1}}, DDOF_ERROR_INVALID, "reserved");
    refused_by_both(vk, i, NULL, DDOF_ERROR_INVALID, "settings");
    refused_by_both(vk, NULL, &plain, DDOF_ERROR_INVALID, "images");
    for (int k = 1; k < SOLVERS; k++) {
        ddof_settings disc = method(k, DDOF_SURFACE_DEFAULT);
        disc.kernel = DDOF_KERNEL_DISC, refused_by_both(vk, i, &disc, DDOF_ERROR_UNSUPPORTED, "solver");
    }
    refused_by_both(vk, i, &(ddof_settings){.layers = DDOF_LAYERS_AUTO}, DDOF_ERROR_UNSUPPORTED, "layers");
    refused_by_both(vk, i, &(ddof_settings){.kernel = (ddof_kernel)2}, DDOF_ERROR_INVALID, "kernel");
    refused_by_both(vk, i, &(ddof_settings){.quality = DDOF_QUALITY_GOOD}, DDOF_ERROR_INVALID, "quality");
    refused_by_both(vk, i, &(ddof_settings){.kernel = DDOF_KERNEL_DISC, .substeps = 2}, DDOF_ERROR_INVALID, "substeps");
    assert_int_equal(ddof_vulkan_frame_create(NULL, &frame, i, &plain), DDOF_ERROR_INVALID);
    assert_null(frame);
    assert_int_equal(ddof_vulkan_frame_create(vk, NULL, i, &plain), DDOF_ERROR_INVALID);
    assert_int_equal(ddof_vulkan_scratch(NULL, i, &plain, &needs), DDOF_ERROR_INVALID);
    assert_int_equal(ddof_vulkan_scratch(vk, i, &plain, NULL), DDOF_ERROR_INVALID);
    ddof_vulkan_frame_destroy(NULL);
    frame = NULL;
    ddof_vulkan_frame_destroy(&frame);
    set_free(&set);
    destroy(&vk);
}

/* ---- recording */

typedef struct recording {
    ddof_vulkan_frame *frame;
    VkCommandBuffer commands;
} recording;

static void not_recorded(const recording *r, const ddof_vulkan_view *view, const ddof_settings *settings,
                         const char *part) {
    static const ddof_vulkan_stats none;
    ddof_vulkan_stats stats;
    const int dispatches = tap.dispatches;
    memset(&stats, 0xff, sizeof stats);
    const ddof_status got = ddof_vulkan_record(r->frame, r->commands, view, settings, &stats);
    if (got != DDOF_ERROR_INVALID) fail_msg("\"%s\": %s", part, ddof_status_text(got));
    assert_sentence(ddof_vulkan_frame_error(r->frame), part);
    assert_memory_equal(&stats, &none, sizeof stats);
    assert_int_equal(tap.dispatches, dispatches);
}

static void bad_views(const recording *r, const ddof_settings *s) {
    static const ddof_vulkan_view bad[] = {
        {.x = -1, .width = 4, .height = 4},
        {.y = -1, .width = 4, .height = 4},
        {.width = W + 1, .height = 4},
        {.width = 4, .height = H + 1},
        {.x = 1, .width = W, .height = 4},
        {.y = 1, .width = 4, .height = H},
        {.x = W, .width = 1, .height = 1},
        {.width = 4},
        {.height = 4},
        {.width = -4, .height = -4},
        {.x = INT32_MAX, .width = INT32_MAX, .height = 4},
        {.y = 4, .width = 4, .height = INT32_MAX},
        {.x = 2},
        {.y = 2},
    };
    ddof_vulkan_view v;
    for (int k = 0; k < COUNT(bad); k++)
        not_recorded(r, &bad[k], s, "view");
    v = (ddof_vulkan_view){.next = &v}, not_recorded(r, &v, s, "next");
    for (int k = 0; k < COUNT(v.reserved); k++)
        v = (ddof_vulkan_view){0}, v.reserved[k] = 1, not_recorded(r, &v, s, "reserved");
    v = (ddof_vulkan_view){.offset_x = 1}, not_recorded(r, &v, s, "offset");
    v = (ddof_vulkan_view){.picture_width = 100}, not_recorded(r, &v, s, "picture");
    v = (ddof_vulkan_view){.picture_width = -1, .picture_height = -1}, not_recorded(r, &v, s, "picture");
    v = (ddof_vulkan_view){.pixel_aspect = -1}, not_recorded(r, &v, s, "pixel_aspect");
    v = (ddof_vulkan_view){.pixel_aspect = NAN}, not_recorded(r, &v, s, "pixel_aspect");
    v = (ddof_vulkan_view){.pixel_aspect = 1e9}, not_recorded(r, &v, s, "pixel_aspect");
}

static void bad_record_settings(const recording *r, const ddof_settings *good) {
    ddof_settings s;
    s = *good, s.solver = DDOF_SOLVER_PCR, not_recorded(r, NULL, &s, "solver");
    s = *good, s.solver = (ddof_solver)99, not_recorded(r, NULL, &s, "solver");
    s = *good, s.surface = DDOF_SURFACE_RGBA32F, not_recorded(r, NULL, &s, "surface");
    s = *good, s.kernel = DDOF_KERNEL_DISC, not_recorded(r, NULL, &s, "kernel");
    s = *good, s.depth.kind = DDOF_DEPTH_PLANAR, not_recorded(r, NULL, &s, "depth.kind");
    s = *good, s.depth.z_at_0 = 0, not_recorded(r, NULL, &s, "z_at_0");
    s = *good, s.lens.focus = DDOF_FOCUS_PIXEL, not_recorded(r, NULL, &s, "focus");
    s = *good, s.lens.f_number = 0, not_recorded(r, NULL, &s, "f_number");
    s = *good, s.lens.focus_distance = NAN, not_recorded(r, NULL, &s, "focus");
    s = *good, s.lens.reserved[3] = 1, not_recorded(r, NULL, &s, "reserved");
    s = *good, s.depth.reserved[3] = 1, not_recorded(r, NULL, &s, "reserved");
    s = *good, s.reserved[COUNT(s.reserved) - 1] = 1, not_recorded(r, NULL, &s, "reserved");
    s = *good, s.substeps = 65, not_recorded(r, NULL, &s, "substeps");
    s = *good, s.substeps = -1, not_recorded(r, NULL, &s, "substeps");
    s = *good, s.conductance = (ddof_conductance)2, not_recorded(r, NULL, &s, "conductance");
    not_recorded(r, NULL, NULL, "settings");
}

/* GOOD is the default, and no other quality is that of the frame object. */
static void other_quality(void **state) {
    (void)state;
    ddof_vulkan *vk = create();
    const ddof_settings made = {.kernel = DDOF_KERNEL_DISC};
    frame_set set = set_make((frame_kind){.width = W, .height = H, .output = VK_FORMAT_R16G16B16A16_SFLOAT}, 45);
    recording r = {frame_of(vk, &set, &made), own_begin()};
    ddof_settings s = made;
    s.quality = DDOF_QUALITY_DRAFT, not_recorded(&r, NULL, &s, "quality");
    s.quality = DDOF_QUALITY_BEST, not_recorded(&r, NULL, &s, "quality");
    s = made, s.kernel = DDOF_KERNEL_HEAT, not_recorded(&r, NULL, &s, "kernel");
    s = made, s.conductance = DDOF_CONDUCTANCE_CLASSIC, not_recorded(&r, NULL, &s, "conductance");
    s = made, s.quality = DDOF_QUALITY_GOOD, record(r.frame, r.commands, NULL, &s, NULL);
    own_finish(r.commands);
    ddof_vulkan_frame_destroy(&r.frame);
    set_free(&set);
    destroy(&vk);
}

/* After each of them the command buffer takes the blur, and does it. */
static void bad_recordings(void **state) {
    (void)state;
    ddof_vulkan *vk = create();
    const ddof_settings settings = depth_settings;
    ddof_vulkan_stats stats;
    for (int half = 0; half < 2; half++) {
        frame_set set = set_make(
            (frame_kind){
                .width = W, .height = H, .is_depth = true, .half_map = half, .output = VK_FORMAT_R32G32B32A32_SFLOAT},
            44);
        float *want = set_want(&set, NULL, &settings);
        recording r = {frame_of(vk, &set, &settings), own_begin()};
        bad_views(&r, &settings);
        bad_record_settings(&r, &settings);
        const recording nowhere = {r.frame, VK_NULL_HANDLE};
        not_recorded(&nowhere, NULL, &settings, "commands");
        assert_int_equal(ddof_vulkan_record(NULL, r.commands, NULL, &settings, &stats), DDOF_ERROR_INVALID);
        assert_int_equal(stats.dispatches, 0);
        for (int k = 0; half && k < 3; k++)
            not_recorded(&r, &(ddof_vulkan_view){.x = k != 1, .y = k != 0, .width = 8, .height = 8}, &settings, "even");
        record(r.frame, r.commands, NULL, &settings, NULL);
        own_finish(r.commands);
        set_compare(&set, NULL, want, 2e-3, "after all that");
        ddof_vulkan_frame_destroy(&r.frame);
        fenced_free(want);
        set_free(&set);
    }
    destroy(&vk);
}

int main(void) {
    static const struct CMUnitTest tests[] = {
        cmocka_unit_test(configs),        cmocka_unit_test(features),      cmocka_unit_test(bad_images),
        cmocka_unit_test(odd_half_map),   cmocka_unit_test(bad_scratch),   cmocka_unit_test(bad_settings),
        cmocka_unit_test(bad_recordings), cmocka_unit_test(other_quality),
    };
    return run_with_own("vulkan invalid", tests, COUNT(tests));
}
