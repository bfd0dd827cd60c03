/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Sprites in recorded commands: pictures of every kind against the CPU's, what is made and what recording makes, and
 * what is refused. */
#include "../library/allocator.h"
#include "pictures.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static ddof_settings settings_of(ddof_bokeh bokeh) {
    return (ddof_settings){.surface = DDOF_SURFACE_RGBA32F, .bokeh = bokeh, .sprites = {.threshold = 0.5, .limit = 1}};
}

/* With CoC of which the sprites' part is large, and that lie on nodes of the iris's tables. */
static frame_set sprite_set(frame_kind kind, uint64_t seed) {
    kind.coc = COC_SMALL;
    kind.sampled = true;
    frame_set set = set_make(kind, seed);
    for (int i = 0; i < kind.width * kind.height && !kind.is_depth; i++) {
        const int x = i % kind.width / 2 * 2,
                  y = i / kind.width / 2 * 2; /* one for 2 x 2 pixels: the map may be of half size */
        const float d = exp2f((float)((x * 5 + y * 3) % 4 + 2));
        set.values.coc[i] = (x / 16 + y / 16) % 3 == 0 ? 0 : (x / 16) % 2 ? -d : d;
    }
    set_upload(&set);
    return set;
}

/* ---- pictures */

static void check(ddof_vulkan *vk, frame_set *set, const ddof_vulkan_view *view, const ddof_settings *settings,
                  double allowed, const char *what) {
    float *want = set_want(set, view, settings);
    set_render(vk, set, view, settings);
    set_compare(set, view, want, allowed, "%s, bokeh %d, %s to %s", what, settings->bokeh, format_name(set->kind.color),
                format_name(set->kind.output));
    fenced_free(want);
}

/* Outputs that hold floats or not, in place, inputs of few bits, maps of half size, depth. */
static void formats(void **state) {
    static const frame_kind kinds[] = {
        {.output = VK_FORMAT_R32G32B32A32_SFLOAT},
        {.output = VK_FORMAT_UNDEFINED},
        {.output = VK_FORMAT_UNDEFINED, .color = VK_FORMAT_R16G16B16A16_SFLOAT, .channels = 3},
        {.output = VK_FORMAT_R16G16B16A16_SFLOAT, .color = VK_FORMAT_R8G8B8A8_UNORM, .half_map = true, .parts = true},
        {.output = VK_FORMAT_R8G8B8A8_UNORM, .color = VK_FORMAT_R16G16B16A16_SFLOAT, .channels = 3},
    };
    (void)state;
    ddof_vulkan *vk = create();
    for (int k = 0; k < 2 * COUNT(kinds); k++) {
        frame_kind kind = kinds[k / 2];
        kind.width = 75;
        kind.height = 50;
        if (kind.output && !ddof_vulkan_can_output(vk, kind.output)) continue;
        frame_set set = sprite_set(kind, 600);
        const ddof_settings settings = settings_of(k % 2 ? DDOF_BOKEH_FULL : DDOF_BOKEH_HIGHLIGHTS);
        /* an output of eight bits rounds what is blurred, and once more with the highlights */
        check(vk, &set, NULL, &settings, kind.output == VK_FORMAT_R8G8B8A8_UNORM ? 0.5 / 255 : 1e-3, "format");
        set_free(&set);
    }
    destroy(&vk);
}

/* The disc kernel's components, which all begin with what the highlights leave. */
static void disc(void **state) {
    (void)state;
    ddof_vulkan *vk = create();
    frame_set set = sprite_set((frame_kind){.width = 40, .height = 30, .output = VK_FORMAT_R32G32B32A32_SFLOAT}, 611);
    ddof_settings settings = settings_of(DDOF_BOKEH_HIGHLIGHTS);
    settings.kernel = DDOF_KERNEL_DISC;
    check(vk, &set, NULL, &settings, 1e-3, "disc");
    set_free(&set);
    destroy(&vk);
}

static void depth(void **state) {
    (void)state;
    ddof_vulkan *vk = create();
    for (int k = 0; k < 2; k++) {
        frame_set set = sprite_set((frame_kind){.width = 75,
                                                .height = 50,
                                                .output = VK_FORMAT_R32G32B32A32_SFLOAT,
                                                .map = VK_FORMAT_D32_SFLOAT,
                                                .is_depth = true},
                                   601);
        ddof_settings settings = settings_of(k ? DDOF_BOKEH_FULL : DDOF_BOKEH_HIGHLIGHTS);
        settings.depth = depth_settings.depth;
        settings.lens = depth_settings.lens;
        settings.lens.f_number = 0.3;
        check(vk, &set, NULL, &settings, 1e-2,
              "depth"); /* of a CoC for each pixel, some lie between two nodes: 1 % of a sprite */
        set_free(&set);
    }
    destroy(&vk);
}

/* A part of the images is the picture, and a part of another one. */
static void views(void **state) {
    static const ddof_vulkan_view view[] = {{.x = 10, .y = 6, .width = 41, .height = 30},
                                            {.width = 75, .height = 1},
                                            {.x = 74, .y = 49, .width = 1, .height = 1},
                                            {.x = 2,
                                             .y = 2,
                                             .width = 60,
                                             .height = 44,
                                             .picture_width = 200,
                                             .picture_height = 100,
                                             .offset_x = 30,
                                             .offset_y = 20,
                                             .pixel_aspect = 0.8}};
    (void)state;
    ddof_vulkan *vk = create();
    for (int k = 0; k < 2; k++) {
        ddof_settings settings = settings_of(k ? DDOF_BOKEH_FULL : DDOF_BOKEH_HIGHLIGHTS);
        settings.iris = (ddof_iris){.cats_eye = 0.5};
        frame_set set =
            sprite_set((frame_kind){.width = 75, .height = 50, .output = VK_FORMAT_R32G32B32A32_SFLOAT}, 602);
        ddof_vulkan_frame *frame = frame_of(vk, &set, &settings);
        for (int i = 0; i < COUNT(view); i++) {
            float *want = set_want(&set, &view[i], &settings);
            VkCommandBuffer commands = own_begin();
            record(frame, commands, &view[i], &settings, NULL);
            own_finish(commands);
            set_compare(&set, &view[i], want, 1e-3, "view %d, bokeh %d", i, settings.bokeh);
            fenced_free(want);
        }
        ddof_vulkan_frame_destroy(&frame);
        set_free(&set);
    }
    destroy(&vk);
}

/* The iris changes with every recording, an image of it by its values alone; two of them in one command buffer. */
static void irises(void **state) {
    (void)state;
    float image[8 * 8];
    ddof_vulkan *vk = create();
    const ddof_settings plain = settings_of(DDOF_BOKEH_HIGHLIGHTS);
    ddof_settings settings = plain;
    frame_set set = sprite_set((frame_kind){.width = 75, .height = 50, .output = VK_FORMAT_R32G32B32A32_SFLOAT}, 603);
    ddof_vulkan_frame *frame = frame_of(vk, &set, &settings);
    for (int i = 0; i < 4; i++) {
        for (int k = 0; k < 64; k++)
            image[k] = k % 8 > 2 * i ? 1 : 0.2f;
        settings.iris =
            (ddof_iris){.shape = DDOF_IRIS_IMAGE, .image = ddof_image_interleaved(image, 8, 8, 1, DDOF_FLOAT, 0)};
        if (i == 3) settings.iris = (ddof_iris){.shape = DDOF_IRIS_POLYGON, .blades = 4};
        float *want = set_want(&set, NULL, &settings);
        VkCommandBuffer commands = own_begin();
        record(frame, commands, NULL, &plain, NULL);
        const VkMemoryBarrier again = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
                                       .srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT,
                                       .dstAccessMask = VK_ACCESS_SHADER_WRITE_BIT};
        VK(vkCmdPipelineBarrier)
        (commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, 0, 1, &again, 0, NULL, 0,
         NULL);
        record(frame, commands, NULL, &settings, NULL);
        own_finish(commands);
        set_compare(&set, NULL, want, 1e-3, "iris %d", i);
        fenced_free(want);
    }
    memset(image, 0, sizeof image);
    settings.iris =
        (ddof_iris){.shape = DDOF_IRIS_IMAGE, .image = ddof_image_interleaved(image, 8, 8, 1, DDOF_FLOAT, 0)};
    VkCommandBuffer commands = own_begin();
    assert_int_equal(ddof_vulkan_record(frame, commands, NULL, &settings, NULL), DDOF_ERROR_INVALID);
    assert_non_null(strstr(ddof_vulkan_frame_error(frame), "iris.image"));
    own_finish(commands);
    ddof_vulkan_frame_destroy(&frame);
    set_free(&set);
    destroy(&vk);
}

/* ---- objects */

/* Two frame objects that share their scratch memory, one with sprites and one without, in turn. */
static void shared_scratch(void **state) {
    (void)state;
    ddof_vulkan *vk = create();
    const ddof_settings settings[2] = {settings_of(DDOF_BOKEH_HIGHLIGHTS), {.surface = DDOF_SURFACE_RGBA32F}};
    const frame_kind kind = {.width = 70, .height = 61, .output = VK_FORMAT_R16G16B16A16_SFLOAT};
    frame_set set[2] = {sprite_set(kind, 604), sprite_set(kind, 605)};
    VkMemoryRequirements needs[2];
    ddof_vulkan_frame *frame[2];
    float *want[2];
    for (int i = 0; i < 2; i++)
        assert_int_equal(ddof_vulkan_scratch(vk, &set[i].images, &settings[i], &needs[i]), DDOF_OK);
    assert_true(needs[0].size > needs[1].size && needs[1].size > 0);
    const VkDeviceMemory memory = own_memory(needs[0].size, needs[0].memoryTypeBits & needs[1].memoryTypeBits, 0);
    for (int i = 0; i < 2; i++) {
        set[i].images.scratch_memory = memory;
        set[i].images.scratch_size = needs[0].size;
        frame[i] = frame_of(vk, &set[i], &settings[i]);
        want[i] = set_want(&set[i], NULL, &settings[i]);
    }
    VkCommandBuffer commands = own_begin();
    for (int i = 0; i < 4; i++) {
        ddof_vulkan_stats stats;
        const VkMemoryBarrier again = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
                                       .srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT,
                                       .dstAccessMask = VK_ACCESS_SHADER_WRITE_BIT};
        if (i > 1) VK(vkCmdPipelineBarrier)
        (commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, 0, 1, &again, 0, NULL, 0,
         NULL);
        record(frame[i % 2], commands, NULL, &settings[i % 2], &stats);
        assert_int_equal(stats.scratch_bytes, needs[i % 2].size);
    }
    own_finish(commands);
    for (int i = 0; i < 2; i++) {
        set_compare(&set[i], NULL, want[i], 1e-3, "shared, %d", i);
        ddof_vulkan_frame_destroy(&frame[i]);
        fenced_free(want[i]);
        set_free(&set[i]);
    }
    VK(vkFreeMemory)(own.device, memory, NULL);
    destroy(&vk);
}

/* No recording allocates or makes anything; the dispatches are those of the documentation. */
static void recording(void **state) {
    (void)state;
    for (int k = 0; k < 4; k++) {
        const bool full = k % 2, in_place = k / 2;
        host_memory host = {0};
        allocator memory = {0};
        const VkAllocationCallbacks callbacks = host_callbacks(&host);
        ddof_vulkan_config config = tap_config();
        config.allocator = &callbacks;
        config.allocate = allocator_allocate;
        config.release = allocator_release;
        config.memory_user = &memory;
        ddof_vulkan *vk = NULL;
        tap_forget();
        assert_int_equal(ddof_vulkan_create(&vk, &config), DDOF_OK);
        ddof_settings settings = settings_of(full ? DDOF_BOKEH_FULL : DDOF_BOKEH_HIGHLIGHTS);
        settings.sprites.append = in_place ? DDOF_APPEND_ARGUMENTS : DDOF_APPEND_COUNTER;
        frame_set set = sprite_set(
            (frame_kind){.width = 64, .height = 40, .output = in_place ? 0 : VK_FORMAT_R32G32B32A32_SFLOAT}, 606);
        ddof_vulkan_frame *frame = frame_of(vk, &set, &settings);
        const int calls = tap.calls, live = tap.live, allocations = host.allocations, blocks = memory.calls;
        for (int i = 0; i < 3; i++) {
            ddof_vulkan_stats stats;
            settings.iris.edge = i * 0.2;
            settings.sprites.threshold = 0.4 + 0.1 * i;
            VkCommandBuffer commands = own_begin();
            tap.dispatches = 0;
            record(frame, commands, NULL, &settings, &stats);
            own_finish(commands);
            assert_int_equal(stats.dispatches, tap.dispatches);
            assert_int_equal(stats.dispatches, full ? 2 : 6 + in_place);
            assert_int_equal(tap.calls, calls);
            assert_int_equal(tap.live, live);
            assert_int_equal(host.allocations, allocations);
            assert_int_equal(memory.calls, blocks);
        }
        ddof_vulkan_frame_destroy(&frame);
        set_free(&set);
        destroy(&vk);
        assert_int_equal(host.live, 0);
        assert_int_equal(memory.live, 0);
        assert_false(memory.wrong);
    }
}

/* Whichever call fails, the frame object is not made and nothing of it is left over. */
static void frames_fail(void **state) {
    (void)state;
    for (int k = 0; k < 2; k++) {
        ddof_settings settings = settings_of(k ? DDOF_BOKEH_FULL : DDOF_BOKEH_HIGHLIGHTS);
        if (k && own.features.features.geometryShader) settings.sprites.quads = DDOF_QUADS_GEOMETRY;
        frame_set set = sprite_set((frame_kind){.width = 40, .height = 30, .output = VK_FORMAT_R8G8B8A8_UNORM}, 607);
        ddof_vulkan *vk = create();
        ddof_vulkan_frame *frame = frame_of(vk, &set, &settings); /* what all frames share is there from now on */
        ddof_vulkan_frame_destroy(&frame);
        const int live = tap.live;
        tap.calls = 0;
        frame = frame_of(vk, &set, &settings);
        ddof_vulkan_frame_destroy(&frame);
        const int calls = tap.calls;
        assert_int_equal(tap.live, live);
        assert_true(calls > 15);
        for (int at = 1; at <= calls; at += GPU_STEP) {
            frame = (ddof_vulkan_frame *)&tap;
            tap.calls = 0;
            tap.fail_at = at;
            tap.fail_with = at % 2 ? VK_ERROR_OUT_OF_HOST_MEMORY : VK_ERROR_OUT_OF_DEVICE_MEMORY;
            const ddof_status status = ddof_vulkan_frame_create(vk, &frame, &set.images, &settings);
            if (status != (at % 2 ? DDOF_ERROR_MEMORY : DDOF_ERROR_DEVICE))
                fail_msg("call %d: %s", at, ddof_status_text(status));
            assert_null(frame);
            if (!strstr(ddof_vulkan_error(vk), "memory")) fail_msg("call %d: \"%s\"", at, ddof_vulkan_error(vk));
            assert_int_equal(tap.live, live);
        }
        tap.fail_at = 0;
        destroy(&vk);
        set_free(&set);
    }
}

/* ---- what is refused */

static void refused(ddof_vulkan *vk, const ddof_vulkan_images *images, const ddof_settings *settings,
                    ddof_status status, const char *part) {
    ddof_vulkan_frame *frame = (ddof_vulkan_frame *)&tap;
    VkMemoryRequirements needs;
    const int live = tap.live;
    for (int i = 0; i < 2; i++) {
        const ddof_status got = i ? ddof_vulkan_scratch(vk, images, settings, &needs)
                                  : ddof_vulkan_frame_create(vk, &frame, images, settings);
        if (got != status) fail_msg("\"%s\": %s, not %s", part, ddof_status_text(got), ddof_status_text(status));
        if (!strstr(ddof_vulkan_error(vk), part))
            fail_msg("\"%s\" says nothing of \"%s\"", ddof_vulkan_error(vk), part);
        assert_null(frame);
        assert_int_equal(tap.live, live);
    }
}

static void devices(void **state) {
    const ddof_status unsupported = DDOF_ERROR_UNSUPPORTED;
    (void)state;
    frame_set set = sprite_set((frame_kind){.width = 75, .height = 50, .output = VK_FORMAT_R32G32B32A32_SFLOAT}, 608);
    ddof_settings highlights = settings_of(DDOF_BOKEH_HIGHLIGHTS), full = settings_of(DDOF_BOKEH_FULL);
    ddof_vulkan *vk = NULL;

    tap_forget();
    tap.no_graphics = true;
    assert_int_equal(try_create(&vk), DDOF_OK);
    refused(vk, &set.images, &highlights, unsupported, "graphics");
    refused(vk, &set.images, &full, unsupported, "graphics");
    refused(vk, &set.images, &(ddof_settings){.method = DDOF_METHOD_SCATTER}, unsupported, "graphics");
    set_render(vk, &set, NULL, &(ddof_settings){0});
    destroy(&vk);

    vk = create();
    tap.no_blending = VK_FORMAT_R32G32B32A32_SFLOAT;
    refused(vk, &set.images, &full, unsupported, "blend");
    highlights.sprites.threshold = 0.95; /* few: each addition rounds */
    check(vk, &set, NULL, &highlights, 2e-3, "half floats are blended");
    tap.no_blending = 0;
    full.sprites.resolution = DDOF_RESOLUTION_FULL;
    for (int m = DDOF_METHOD_GAUSSIAN; m <= DDOF_METHOD_HEXAGON; m++)
        refused(vk, &set.images, &(ddof_settings){.method = (ddof_method)m}, unsupported, "settings.method");
    highlights.sprites.max_sprites = -1;
    refused(vk, &set.images, &highlights, DDOF_ERROR_INVALID, "max_sprites");
    set.images.output.usage = VK_IMAGE_USAGE_STORAGE_BIT;
    refused(vk, &set.images, &(ddof_settings){.bokeh = DDOF_BOKEH_HIGHLIGHTS}, DDOF_ERROR_INVALID, "usage");
    set.images.output.usage = 0;
    destroy(&vk);

    tap_forget();
    tap.max_side = 100;
    assert_int_equal(try_create(&vk), DDOF_OK);
    refused(vk, &set.images, &full, unsupported, "78 x 150");
    destroy(&vk);

    tap_forget();
    tap.buffer_range = 75 * 50 * 8 - 1;
    assert_int_equal(try_create(&vk), DDOF_OK);
    refused(vk, &set.images, &full, unsupported, "list of sprites");
    destroy(&vk);

    tap_forget();
    ddof_vulkan_config config = tap_config();
    VkPhysicalDeviceFeatures2 few = own.features;
    few.features.geometryShader = VK_FALSE;
    config.features = &few;
    assert_int_equal(ddof_vulkan_create(&vk, &config), DDOF_OK);
    full.sprites.quads = DDOF_QUADS_GEOMETRY;
    refused(vk, &set.images, &full, unsupported, "geometryShader");
    destroy(&vk);
    set_free(&set);
}

/* What is fixed with the frame object, and what is not. */
static void other_settings(void **state) {
    (void)state;
    ddof_vulkan *vk = create();
    frame_set set = sprite_set((frame_kind){.width = 75, .height = 50, .output = VK_FORMAT_R32G32B32A32_SFLOAT}, 609);
    const ddof_settings good = settings_of(DDOF_BOKEH_HIGHLIGHTS);
    ddof_vulkan_frame *frame = frame_of(vk, &set, &good);
    VkCommandBuffer commands = own_begin();
    ddof_settings s[7];
    for (int i = 0; i < COUNT(s); i++)
        s[i] = good;
    s[0].bokeh = DDOF_BOKEH_OFF;
    s[1].bokeh = DDOF_BOKEH_FULL;
    s[2].sprites.resolution = DDOF_RESOLUTION_HALF;
    s[3].sprites.max_sprites = 10;
    s[4].sprites.append = DDOF_APPEND_ARGUMENTS;
    s[5].sprites.quads = DDOF_QUADS_GEOMETRY;
    s[6].method = DDOF_METHOD_SCATTER;
    static const char *const part[] = {
        "bokeh", "bokeh", "sprites.resolution", "sprites.max_sprites", "sprites.append", "sprites.quads", "bokeh"};
    for (int i = 0; i < COUNT(s); i++) {
        assert_int_equal(ddof_vulkan_record(frame, commands, NULL, &s[i], NULL), DDOF_ERROR_INVALID);
        if (!strstr(ddof_vulkan_frame_error(frame), part[i]))
            fail_msg("\"%s\": %s", part[i], ddof_vulkan_frame_error(frame));
    }
    ddof_settings other = good;
    other.method = DDOF_METHOD_HEXAGON;
    other.bokeh = DDOF_BOKEH_OFF;
    assert_int_equal(ddof_vulkan_record(frame, commands, NULL, &other, NULL), DDOF_ERROR_UNSUPPORTED);
    other = good;
    other.sprites.resolution = DDOF_RESOLUTION_FULL; /* what 0 means, said */
    other.sprites.max_sprites = 65536;
    other.sprites.append = DDOF_APPEND_COUNTER;
    other.sprites.quads = DDOF_QUADS_INSTANCED;
    other.sprites.threshold = 0.9;
    other.sprites.limit = 0.1;
    other.sprites.max_area = 1;
    record(frame, commands, NULL, &other, NULL);
    own_finish(commands);
    ddof_vulkan_frame_destroy(&frame);
    set_free(&set);
    destroy(&vk);
}

/* Four times, none before the one before it. */
static void timestamps(void **state) {
    (void)state;
    VkQueryPool pool;
    uint64_t ticks[5] = {0};
    const VkQueryPoolCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO, .queryType = VK_QUERY_TYPE_TIMESTAMP, .queryCount = 5};
    ddof_vulkan *vk = create();
    frame_set set = sprite_set((frame_kind){.width = 75, .height = 50, .output = VK_FORMAT_R32G32B32A32_SFLOAT}, 610);
    const ddof_settings settings = settings_of(DDOF_BOKEH_HIGHLIGHTS), none = {0};
    CHECK(VK(vkCreateQueryPool)(own.device, &info, NULL, &pool));
    ddof_vulkan_frame *frame = frame_of(vk, &set, &none);
    assert_int_equal(ddof_vulkan_frame_timestamps(frame, pool, 1), DDOF_ERROR_INVALID);
    assert_non_null(strstr(ddof_vulkan_frame_error(frame), "sprites"));
    assert_int_equal(ddof_vulkan_frame_timestamps(NULL, pool, 1), DDOF_ERROR_INVALID);
    ddof_vulkan_frame_destroy(&frame);
    frame = frame_of(vk, &set, &settings);
    assert_int_equal(ddof_vulkan_frame_timestamps(frame, pool, 1), DDOF_OK);
    VkCommandBuffer commands = own_begin();
    VK(vkCmdResetQueryPool)(commands, pool, 0, 5);
    record(frame, commands, NULL, &settings, NULL);
    own_finish(commands);
    CHECK(VK(vkGetQueryPoolResults)(own.device, pool, 1, 4, sizeof ticks - sizeof *ticks, ticks + 1, sizeof *ticks,
                                    VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT));
    for (int i = 2; i < 5; i++)
        assert_true(ticks[i] >= ticks[i - 1]);
    assert_true(ticks[4] > ticks[1]);
    ddof_vulkan_frame_destroy(&frame);
    VK(vkDestroyQueryPool)(own.device, pool, NULL);
    set_free(&set);
    destroy(&vk);
}

int main(void) {
    static const struct CMUnitTest tests[] = {
        cmocka_unit_test(formats),        cmocka_unit_test(disc),        cmocka_unit_test(depth),
        cmocka_unit_test(views),          cmocka_unit_test(irises),      cmocka_unit_test(shared_scratch),
        cmocka_unit_test(recording),      cmocka_unit_test(frames_fail), cmocka_unit_test(devices),
        cmocka_unit_test(other_settings), cmocka_unit_test(timestamps),
    };
    return run_with_own("vulkan sprites", tests, COUNT(tests));
}
