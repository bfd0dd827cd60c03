/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* A part of the images as the picture: nothing outside it is read, nothing outside it is written. */
#include "pictures.h"

#include <math.h>
#include <string.h>

enum { W = 96, H = 80 };

static bool inside(const ddof_vulkan_view *v, int x, int y) {
    return x >= v->x && x < v->x + v->width && y >= v->y && y < v->y + v->height;
}

/* What is outside of the view: NaN, and what the view has for a map of half size stays. */
static void poison(frame_set *set, const ddof_vulkan_view *v) {
    for (int y = 0; y < H; y++)
        for (int x = 0; x < W; x++) {
            const int p = y * W + x, first = (y / 2 * 2) * W + x / 2 * 2;
            if (inside(v, x, y)) continue;
            for (int c = 0; c < 4; c++)
                set->values.color[4 * p + c] = NAN;
            if (!set->kind.half_map)
                set->values.coc[p] = NAN;
            else if (!inside(v, first % W, first / W))
                set->values.coc[p] = NAN;
        }
    set_upload(set);
}

/* The output before: so that what is left alone can be told. */
static void paint(const picture *output, unsigned char *texels) {
    memset(texels, 0x35, picture_bytes(output, output->d.mip_level));
    picture_write(output, output->d.mip_level, output->d.array_layer, texels);
}

static void assert_rest(const frame_set *set, const ddof_vulkan_view *v, const unsigned char *before) {
    const picture *output = set->kind.output ? &set->output : &set->color;
    const size_t step = texel_bytes(output->d.format);
    unsigned char *after = fenced(picture_bytes(output, 0), true);
    picture_read(output, 0, 0, after);
    for (int p = 0; p < W * H; p++)
        if (!inside(v, p % W, p / W) && memcmp(after + (size_t)p * step, before + (size_t)p * step, step))
            fail_msg("view %d x %d at (%d, %d): (%d, %d) was written", v->width, v->height, v->x, v->y, p % W, p / W);
    fenced_free(after);
}

static void check_view(ddof_vulkan *vk, frame_kind kind, const ddof_vulkan_view *v, int how, uint64_t seed) {
    ddof_settings settings = method(how, seed % 2 ? DDOF_SURFACE_RGBA32F : DDOF_SURFACE_RGBA16F);
    if (kind.is_depth) settings.lens = depth_settings.lens, settings.depth = depth_settings.depth;
    frame_set set = set_make(kind, seed);
    const picture *output = kind.output ? &set.output : &set.color;
    unsigned char *before = fenced(picture_bytes(output, 0), true);
    poison(&set, v);
    if (kind.output)
        paint(output, before);
    else
        picture_read(output, 0, 0, before);
    set_check(vk, &set, v, &settings, "view");
    assert_rest(&set, v, before);
    fenced_free(before);
    set_free(&set);
}

static frame_kind kind_of(int k) {
    static const VkFormat outputs[] = {VK_FORMAT_R32G32B32A32_SFLOAT, VK_FORMAT_UNDEFINED,
                                       VK_FORMAT_R16G16B16A16_SFLOAT, VK_FORMAT_R8G8B8A8_UNORM};
    return (frame_kind){.width = W,
                        .height = H,
                        .color = k / 4 % 2 ? VK_FORMAT_R16G16B16A16_SFLOAT : VK_FORMAT_R32G32B32A32_SFLOAT,
                        .output = outputs[k % 4],
                        .is_depth = k % 3 == 0,
                        .coc = k % 3 == 1 ? COC_SMOOTH : COC_RANDOM};
}

/* Corners, single rows, columns and pixels, odd places and sizes. */
static void places(void **state) {
    static const ddof_vulkan_view views[] = {
        {.x = 0, .y = 0, .width = 1, .height = 1},    {.x = 95, .y = 79, .width = 1, .height = 1},
        {.x = 1, .y = 1, .width = 94, .height = 78},  {.x = 0, .y = 7, .width = 96, .height = 1},
        {.x = 13, .y = 0, .width = 1, .height = 80},  {.x = 31, .y = 5, .width = 65, .height = 33},
        {.x = 3, .y = 17, .width = 32, .height = 63}, {.x = 17, .y = 9, .width = 7, .height = 13},
        {.x = 0, .y = 0, .width = 95, .height = 79},  {.x = 1, .y = 0, .width = 2, .height = 3}};
    (void)state;
    ddof_vulkan *vk = create();
    for (int i = 0; i < COUNT(views); i++)
        for (int k = 0; k < METHODS; k++)
            check_view(vk, kind_of(i + k), &views[i], k, 20 + (uint64_t)(i * 4 + k));
    destroy(&vk);
}

static void random_places(void **state) {
    (void)state;
    rng r = {21};
    ddof_vulkan *vk = create();
    for (int i = 0; i < 40; i += GPU_STEP) {
        ddof_vulkan_view v = {.x = rng_range(&r, 0, W - 1), .y = rng_range(&r, 0, H - 1)};
        v.width = rng_range(&r, 1, W - v.x);
        v.height = rng_range(&r, 1, H - v.y);
        if (i % 3 == 0) v.pixel_aspect = 1.4;
        check_view(vk, kind_of(i), &v, i / 4, 22 + (uint64_t)i);
    }
    destroy(&vk);
}

/* With a map of half size x and y are even, width and height anything. */
static void half_map(void **state) {
    (void)state;
    rng r = {23};
    ddof_vulkan *vk = create();
    for (int i = 0; i < 40; i += GPU_STEP) {
        ddof_vulkan_view v = {.x = 2 * rng_range(&r, 0, W / 2 - 1), .y = 2 * rng_range(&r, 0, H / 2 - 1)};
        v.width = rng_range(&r, 1, W - v.x);
        v.height = rng_range(&r, 1, H - v.y);
        frame_kind kind = kind_of(i);
        kind.half_map = true;
        check_view(vk, kind, &v, i / 4, 24 + (uint64_t)i);
    }
    destroy(&vk);
}

/* A view says where it lies in the camera's picture, whose edge its own is not. */
static void in_the_picture(void **state) {
    (void)state;
    ddof_vulkan *vk = create();
    ddof_settings settings = depth_settings;
    settings.depth.kind = DDOF_DEPTH_RAY;
    settings.lens.focus_distance = 0.7;
    settings.surface = DDOF_SURFACE_RGBA32F;
    frame_kind kind = kind_of(0);
    const ddof_vulkan_view v = {.x = 11,
                                .y = 5,
                                .width = 61,
                                .height = 70,
                                .picture_width = 400,
                                .picture_height = 300,
                                .offset_x = 71,
                                .offset_y = -5,
                                .pixel_aspect = 1.1};
    frame_set set = set_make(kind, 25);
    for (int p = 0; p < W * H; p++)
        set.values.coc[p] = set.values.coc[p] * 0.8f + 0.2f;
    poison(&set, &v);
    set_check(vk, &set, &v, &settings, "view of rays");
    set_free(&set);
    destroy(&vk);
}

/* One frame object, another view each time, as dynamic resolution has it; a larger one after a smaller one, too. */
static void changing(void **state) {
    (void)state;
    ddof_vulkan *vk = create();
    rng r = {26};
    for (int how = 0; how < METHODS; how++) {
        frame_set set =
            set_make((frame_kind){.width = W,
                                  .height = H,
                                  .output = how % 2 ? VK_FORMAT_R8G8B8A8_UNORM : VK_FORMAT_R32G32B32A32_SFLOAT,
                                  .coc = COC_SMOOTH},
                     26);
        const ddof_settings made = method(how, DDOF_SURFACE_RGBA32F);
        ddof_vulkan_frame *frame = frame_of(vk, &set, &made);
        for (int i = 0; i < 12; i++) {
            const ddof_settings settings = heat_method(how, made.surface, (ddof_conductance)(i % 2), i % 3 + 1);
            ddof_vulkan_view v = {.width = rng_range(&r, 1, W), .height = rng_range(&r, 1, H)};
            v.x = rng_range(&r, 0, W - v.width);
            v.y = rng_range(&r, 0, H - v.height);
            float *want = set_want(&set, &v, &settings);
            VkCommandBuffer commands = own_begin();
            record(frame, commands, &v, &settings, NULL);
            own_finish(commands);
            set_compare(&set, &v, want, tolerance(&set, &settings, 1), "view %d of one frame", i);
            fenced_free(want);
        }
        ddof_vulkan_frame_destroy(&frame);
        set_free(&set);
    }
    destroy(&vk);
}

int main(void) {
    static const struct CMUnitTest tests[] = {
        cmocka_unit_test(places),   cmocka_unit_test(random_places),  cmocka_unit_test(half_map),
        cmocka_unit_test(changing), cmocka_unit_test(in_the_picture),
    };
    return run_with_own("vulkan views", tests, COUNT(tests));
}
