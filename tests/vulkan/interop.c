/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* ddof/vulkan.h on a device of the test's own: formats, sizes, places, settings, against the float64 reference. */
#include "pictures.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const VkFormat color_formats[] = {VK_FORMAT_R32G32B32A32_SFLOAT,
                                         VK_FORMAT_R16G16B16A16_SFLOAT,
                                         VK_FORMAT_B10G11R11_UFLOAT_PACK32,
                                         VK_FORMAT_E5B9G9R9_UFLOAT_PACK32,
                                         VK_FORMAT_A2B10G10R10_UNORM_PACK32,
                                         VK_FORMAT_R8G8B8A8_UNORM,
                                         VK_FORMAT_B8G8R8A8_UNORM,
                                         VK_FORMAT_R8G8B8A8_SRGB,
                                         VK_FORMAT_B8G8R8A8_SRGB};
static const VkFormat depth_formats[] = {
    VK_FORMAT_D16_UNORM,          VK_FORMAT_X8_D24_UNORM_PACK32, VK_FORMAT_D24_UNORM_S8_UINT, VK_FORMAT_D32_SFLOAT,
    VK_FORMAT_D32_SFLOAT_S8_UINT, VK_FORMAT_R32_SFLOAT,          VK_FORMAT_R16_SFLOAT};
static const VkFormat output_formats[] = {VK_FORMAT_R32G32B32A32_SFLOAT,     VK_FORMAT_R16G16B16A16_SFLOAT,
                                          VK_FORMAT_B10G11R11_UFLOAT_PACK32, VK_FORMAT_A2B10G10R10_UNORM_PACK32,
                                          VK_FORMAT_R8G8B8A8_UNORM,          VK_FORMAT_B8G8R8A8_UNORM};

/* A test of its own for each format, so that one the device lacks is counted as skipped. */
typedef struct format_case {
    VkFormat format;
} format_case;

static VkFormat format_of(void **state) {
    return ((const format_case *)*state)->format;
}

static void color_format(void **state) {
    const VkFormat format = format_of(state);
    ddof_vulkan *vk = create();
    const bool possible = picture_possible(format, VK_IMAGE_USAGE_SAMPLED_BIT);
    assert_int_equal(ddof_vulkan_can_sample(vk, format), possible);
    if (!possible) {
        destroy(&vk);
        skip();
    }
    for (int channels = 3; channels <= 4; channels++) {
        frame_set set = set_make((frame_kind){.width = 61,
                                              .height = 45,
                                              .color = format,
                                              .output = VK_FORMAT_R32G32B32A32_SFLOAT,
                                              .coc = COC_SMOOTH,
                                              .channels = channels},
                                 1);
        set_check(vk, &set, NULL, &(ddof_settings){.surface = DDOF_SURFACE_RGBA32F}, "colour");
        set_free(&set);
    }
    destroy(&vk);
}

static void depth_format(void **state) {
    const VkFormat format = format_of(state);
    const bool possible = picture_possible(format, VK_IMAGE_USAGE_SAMPLED_BIT);
    ddof_vulkan *vk = create();
    ddof_settings settings = depth_settings;
    assert_int_equal(ddof_vulkan_can_sample(vk, format), possible);
    if (!possible) {
        destroy(&vk);
        skip();
    }
    settings.surface = DDOF_SURFACE_RGBA32F;
    for (int half = 0; half < 2; half++) {
        frame_set set = set_make((frame_kind){.width = 61,
                                              .height = 45,
                                              .map = format,
                                              .is_depth = true,
                                              .half_map = half,
                                              .output = VK_FORMAT_R32G32B32A32_SFLOAT},
                                 2);
        set_check(vk, &set, NULL, &settings, "depth");
        set_free(&set);
    }
    destroy(&vk);
}

static void output_format(void **state) {
    const VkFormat format = format_of(state);
    ddof_vulkan *vk = create();
    const bool possible = picture_possible(format, VK_IMAGE_USAGE_STORAGE_BIT);
    assert_int_equal(ddof_vulkan_can_output(vk, format), possible);
    if (!possible) {
        destroy(&vk);
        skip();
    }
    for (int surface = 0; surface < 3; surface++)
        for (int k = 0; k < METHODS; k++) {
            const ddof_settings settings = method(k, (ddof_surface)surface);
            frame_set set = set_make((frame_kind){.width = 59, .height = 70, .output = format, .coc = COC_SMOOTH}, 3);
            set_check(vk, &set, NULL, &settings, "output");
            set_free(&set);
        }
    destroy(&vk);
}

/* color is output. */
static void in_place(void **state) {
    const VkFormat format = format_of(state);
    ddof_vulkan *vk = create();
    if (!ddof_vulkan_can_output(vk, format) || !ddof_vulkan_can_sample(vk, format)) {
        destroy(&vk);
        skip();
    }
    const bool wide = format == VK_FORMAT_R32G32B32A32_SFLOAT, half = format == VK_FORMAT_R16G16B16A16_SFLOAT;
    for (int surface = 0; surface < 3; surface++)
        for (int k = 0; k < METHODS; k++) {
            const ddof_settings settings =
                heat_method(k, (ddof_surface)surface, DDOF_CONDUCTANCE_MATCHED, k == 2 ? 2 : 0);
            frame_set set = set_make((frame_kind){.width = 71, .height = 50, .color = format, .coc = COC_SMOOTH}, 4);
            const ddof_vulkan_stats stats = set_check(vk, &set, NULL, &settings, "in place");
            const bool none = wide || (half && surface != DDOF_SURFACE_RGBA32F);
            if (k == 0 && (stats.scratch_bytes == 0) != none)
                fail_msg("%s in place, surface %d: %zu bytes of scratch", format_name(format), surface,
                         stats.scratch_bytes);
            set_free(&set);
        }
    destroy(&vk);
}

/* Solvers, surfaces, substeps, conductances; CoC of every pattern. */
static void settings_all(void **state) {
    (void)state;
    ddof_vulkan *vk = create();
    for (int k = 0; k < METHODS * COC_PATTERNS; k += GPU_STEP) {
        const int how = k + k / COC_PATTERNS,
                  more = how % METHODS < SOLVERS ? k / 6 % 2 * 39 : 0; /* drivers compile for long: not for more sizes */
        frame_set set = set_make((frame_kind){.width = 90 + more,
                                              .height = 130 - 2 * more,
                                              .output = VK_FORMAT_R32G32B32A32_SFLOAT,
                                              .coc = (coc_pattern)(k % COC_PATTERNS),
                                              .pattern = (color_pattern)(k % 3)},
                                 5 + (uint64_t)k);
        for (int i = 0; i < 6; i++) {
            const ddof_settings settings = heat_method(how, i % 2 ? DDOF_SURFACE_RGBA32F : DDOF_SURFACE_RGBA16F,
                                                       (ddof_conductance)((k / 2 + i) % 2), i / 2 + 1);
            set_check(vk, &set, NULL, &settings, "settings");
            if (settings.kernel && i) break;
        }
        set_free(&set);
    }
    destroy(&vk);
}

/* An image that is a part of a larger picture, with pixels that are not square. */
static void part_of_picture(void **state) {
    (void)state;
    ddof_vulkan *vk = create();
    static const ddof_vulkan_view views[] = {
        {.pixel_aspect = 2},
        {.pixel_aspect = 0.5},
        {.picture_width = 200, .picture_height = 100, .offset_x = 31, .offset_y = -7},
        {.picture_width = 50, .picture_height = 40, .offset_x = -9, .offset_y = -3, .pixel_aspect = 1.25},
    };
    for (int i = 0; i < COUNT(views); i++)
        for (int kind = DDOF_DEPTH_PLANAR; kind <= DDOF_DEPTH_DEVICE; kind++) {
            ddof_settings settings = depth_settings;
            settings.depth.kind = (ddof_depth_kind)kind;
            settings.surface = DDOF_SURFACE_RGBA32F;
            settings.lens.focus_distance = 0.7;
            frame_set set = set_make(
                (frame_kind){.width = 81, .height = 63, .is_depth = true, .output = VK_FORMAT_R32G32B32A32_SFLOAT}, 6);
            for (int p = 0; p < 81 * 63; p++)
                set.values.coc[p] = set.values.coc[p] * 0.8f + 0.2f;
            set_upload(&set);
            set_check(vk, &set, &views[i], &settings, "part of a picture");
            set_free(&set);
        }
    destroy(&vk);
}

/* Each texel of a map of half size serves 2 x 2 pixels, at borders of odd sizes less. */
static void half_maps(void **state) {
    (void)state;
    ddof_vulkan *vk = create();
    for (int n = 1; n <= 33; n += GPU_STEP)
        for (int k = 0; k < METHODS; k++) {
            const ddof_settings settings = method(k, DDOF_SURFACE_RGBA32F);
            frame_set set = set_make((frame_kind){.width = n,
                                                  .height = n % 2 ? 34 - n : 17 + k,
                                                  .half_map = true,
                                                  .coc = n % 3 ? COC_RANDOM : COC_SMALL,
                                                  .map = n % 4 ? VK_FORMAT_R32_SFLOAT : VK_FORMAT_R16_SFLOAT,
                                                  .output = VK_FORMAT_R32G32B32A32_SFLOAT},
                                     7 + (uint64_t)n);
            set_check(vk, &set, NULL, &settings, "half map");
            set_free(&set);
        }
    destroy(&vk);
}

/* A level and a layer of an image: those beside them are not touched. */
static void levels_and_layers(void **state) {
    (void)state;
    ddof_vulkan *vk = create();
    for (int k = 0; k < 6; k++) {
        frame_set set = set_make((frame_kind){.width = 40,
                                              .height = 33,
                                              .parts = true,
                                              .is_depth = k % 2,
                                              .map = k % 2 ? VK_FORMAT_D32_SFLOAT : VK_FORMAT_R32_SFLOAT,
                                              .color = VK_FORMAT_R16G16B16A16_SFLOAT,
                                              .output = k / 2 == 0   ? VK_FORMAT_UNDEFINED
                                                        : k / 2 == 1 ? VK_FORMAT_R16G16B16A16_SFLOAT
                                                                     : VK_FORMAT_R8G8B8A8_UNORM},
                                 8);
        const picture *output = set.kind.output ? &set.output : &set.color;
        unsigned char *other = fenced(picture_bytes(output, 0), true), *now = fenced(picture_bytes(output, 0), true);
        for (uint32_t i = 0; i < 12; i++) { /* any bytes but those of a NaN */
            memset(other, 0x35, picture_bytes(output, i / 4));
            if (i / 4 != 1 || i % 4 != 2) picture_write(output, i / 4, i % 4, other);
        }
        set_check(vk, &set, NULL, k % 2 ? &depth_settings : &(ddof_settings){0}, "level and layer");
        for (uint32_t i = 0; i < 12; i++) {
            if (i / 4 == 1 && i % 4 == 2) continue;
            picture_read(output, i / 4, i % 4, now);
            for (size_t b = 0; b < picture_bytes(output, i / 4); b++)
                if (now[b] != 0x35) fail_msg("level %u, layer %u was written", i / 4, i % 4);
        }
        fenced_free(other);
        fenced_free(now);
        set_free(&set);
    }
    destroy(&vk);
}

/* In every layout that may be stated: were it changed, the next transition would not find it so (validation). */
static void layouts(void **state) {
    static const VkImageLayout color[] = {VK_IMAGE_LAYOUT_GENERAL, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL,
                                          VK_IMAGE_LAYOUT_READ_ONLY_OPTIMAL};
    static const VkImageLayout depth[] = {VK_IMAGE_LAYOUT_DEPTH_STENCIL_READ_ONLY_OPTIMAL,
                                          VK_IMAGE_LAYOUT_DEPTH_READ_ONLY_OPTIMAL};
    (void)state;
    ddof_vulkan *vk = create();
    for (int k = 0; k < COUNT(color) + COUNT(depth); k++) {
        frame_kind kind = {.width = 30, .height = 20, .is_depth = true, .output = VK_FORMAT_R16G16B16A16_SFLOAT};
        kind.map = k < COUNT(color) ? VK_FORMAT_R32_SFLOAT : VK_FORMAT_D32_SFLOAT;
        kind.layout = k < COUNT(color) ? color[k] : VK_IMAGE_LAYOUT_GENERAL;
        frame_set set = set_make(kind, 9);
        if (k >= COUNT(color)) {
            picture_free(&set.map);
            set.map = picture_make(kind.map, 30, 20, VK_IMAGE_USAGE_SAMPLED_BIT, depth[k - COUNT(color)]);
            set.images.depth = set.map.d;
            set_upload(&set);
        }
        set_check(vk, &set, NULL, &depth_settings, "layout");
        set_free(&set);
    }
    destroy(&vk);
}

/* As ddof_render() does; and an alpha that is not looked at may hold anything. */
static void holes(void **state) {
    (void)state;
    ddof_vulkan *vk = create();
    for (int k = 0; k < 4 * METHODS; k++) {
        rng r = {10 + (uint64_t)k};
        frame_set set =
            set_make((frame_kind){.width = 57,
                                  .height = 48,
                                  .color = k % 2 ? VK_FORMAT_R16G16B16A16_SFLOAT : VK_FORMAT_R32G32B32A32_SFLOAT,
                                  .coc = k % 4 ? COC_SMOOTH : COC_ZERO,
                                  .channels = k % 3 ? 4 : 3,
                                  .output = k % 5 ? VK_FORMAT_R32G32B32A32_SFLOAT : VK_FORMAT_UNDEFINED},
                     10 + (uint64_t)k);
        for (int p = 0; p < 57 * 48; p++) {
            if (rng_bits(&r) % 8 == 0 || p / 57 == k % 16) set.values.color[4 * p + p % 3] = p % 2 ? NAN : -INFINITY;
            if (rng_bits(&r) % 8 == 0) set.values.coc[p] = NAN;
            if (k % 3 == 0) set.values.color[4 * p + 3] = NAN;
        }
        set_upload(&set);
        for (int surface = DDOF_SURFACE_RGBA16F; surface <= DDOF_SURFACE_RGBA32F; surface++) {
            const ddof_settings settings = method(k / 4, (ddof_surface)surface);
            set_upload(&set);
            set_check(vk, &set, NULL, &settings, "holes");
        }
        set_free(&set);
    }
    destroy(&vk);
}

enum { MOST_TESTS = 60 };
static struct CMUnitTest tests[MOST_TESTS];
static format_case cases[MOST_TESTS];
static char names[MOST_TESTS][60];
static int count;

static void add(const char *name, CMUnitTestFunction run, const VkFormat *formats, int format_count) {
    for (int i = 0; i < format_count; i++, count++) {
        cases[count].format = formats ? formats[i] : VK_FORMAT_UNDEFINED;
        snprintf(names[count], sizeof *names, "%s%s%s", name, formats ? " " : "",
                 formats ? format_name(formats[i]) : "");
        tests[count] = (struct CMUnitTest){names[count], run, NULL, NULL, &cases[count]};
    }
}

int main(void) {
    add("colour", color_format, color_formats, COUNT(color_formats));
    add("depth", depth_format, depth_formats, COUNT(depth_formats));
    add("output", output_format, output_formats, COUNT(output_formats));
    add("in place", in_place, output_formats, COUNT(output_formats));
    add("settings", settings_all, NULL, 1);
    add("part of a picture", part_of_picture, NULL, 1);
    add("half maps", half_maps, NULL, 1);
    add("levels and layers", levels_and_layers, NULL, 1);
    add("layouts", layouts, NULL, 1);
    add("holes", holes, NULL, 1);
    return run_with_own("vulkan interop", tests, count);
}
