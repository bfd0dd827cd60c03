/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "bench_scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "lens.h"
#include "message.h"

static uint16_t half_of_float(float value) {
    /* for values between 2^-14 and 65504 only, which is all there is here; rounded down */
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return (uint16_t)((bits >> 13) - (112u << 10));
}

static float color_at(int x, int y, int channel) {
    uint32_t noise = (uint32_t)x * 73856093u ^ (uint32_t)y * 19349663u ^ (uint32_t)channel * 83492791u;
    noise = (noise ^ noise >> 13) * 0x5bd1e995u;
    float value = 0.05f + (float)(noise >> 8) * 0x1p-24f;
    return noise % 997 == 0 ? value * 50 : value; /* highlights */
}

static void fill_color(const scene *s) {
    const size_t pixels = (size_t)s->width * (size_t)s->height;
    for (int y = 0; y < s->height; y++)
        for (int x = 0; x < s->width; x++)
            for (int c = 0; c < s->channels; c++) {
                const size_t pixel = (size_t)y * (size_t)s->width + (size_t)x;
                const size_t at = s->planar ? (size_t)c * pixels + pixel : pixel * (size_t)s->channels + (size_t)c;
                const float value = color_at(x, y, c);
                if (s->type == DDOF_HALF)
                    ((uint16_t *)s->color)[at] = half_of_float(value);
                else
                    ((float *)s->color)[at] = value;
            }
}

/* Sharp in a disc in the middle, nearer on the left, farther on the right: smooth, with values of both signs. */
static void fill_blur(const scene *s, float largest) {
    const float radius = 0.2f * (float)s->height;
    for (int y = 0; y < s->height; y++)
        for (int x = 0; x < s->width; x++) {
            const float u = (float)x - 0.5f * (float)s->width, v = (float)y - 0.5f * (float)s->height;
            const float beyond = fmaxf(sqrtf(u * u + v * v) - radius, 0) / (0.5f * (float)s->width);
            float value = copysignf(largest * fminf(beyond, 1), u);
            if (s->depth) value = 4 * exp2f(3 * copysignf(fminf(beyond, 1), u)); /* 0.5 to 32 around the focus of 4 */
            s->blur[(size_t)y * (size_t)s->width + (size_t)x] = value;
        }
}

static ddof_image describe(const scene *s, void *data) {
    if (!s->planar) return ddof_image_interleaved(data, s->width, s->height, s->channels, s->type, 0);
    void *plane[4];
    for (int c = 0; c < s->channels; c++)
        plane[c] = (char *)data + s->bytes / (size_t)s->channels * (size_t)c;
    return ddof_image_planar(plane, s->width, s->height, s->channels, s->type, 0);
}

/* Whole pages, touched: the first use of memory must not be timed. */
static void *touched_memory(size_t bytes) {
    void *memory = NULL;
    if (posix_memalign(&memory, 4096, bytes) != 0) return NULL;
    memset(memory, 1, bytes);
    return memory;
}

static int check_memory(const scene *s) {
    const double need = 2 * (double)s->bytes + 8.0 * s->width * s->height;
    const double have = (double)sysconf(_SC_PHYS_PAGES) * (double)sysconf(_SC_PAGESIZE);
    if (need < 0.9 * have) return 0;
    return fail_usage("--size: %dx%d needs %.1f GB of memory, this machine has %.1f; make it smaller", s->width,
                      s->height, need * 1e-9, have * 1e-9);
}

int scene_create(scene *s, const options *o, int width, int height) {
    *s = (scene){.width = width,
                 .height = height,
                 .channels = (int)option_number(o, OPT_CHANNELS, 4),
                 .type = (ddof_type)option_number(o, OPT_TYPE, DDOF_FLOAT),
                 .planar = option_number(o, OPT_LAYOUT, 0) == 1,
                 .in_place = option_given(o, OPT_IN_PLACE),
                 .depth = option_given(o, OPT_BENCH_DEPTH)};
    const size_t pixels = (size_t)s->width * (size_t)s->height;
    s->bytes = pixels * (size_t)s->channels * (s->type == DDOF_HALF ? 2 : 4);
    int status = check_memory(s);
    if (status) return status;
    s->color = touched_memory(s->bytes);
    s->result = touched_memory(s->bytes);
    s->blur = touched_memory(pixels * sizeof(float));
    if (!s->color || !s->result || !s->blur) return fail("--size: out of memory; make it smaller");
    const double largest = option_number(o, OPT_BENCH_COC, 48);
    fill_color(s);
    fill_blur(s, (float)largest);
    s->frame.color = describe(s, s->color);
    s->frame.output = describe(s, s->in_place ? s->color : s->result);
    ddof_image blur = ddof_image_interleaved(s->blur, s->width, s->height, 1, DDOF_FLOAT, 0);
    *(s->depth ? &s->frame.depth : &s->frame.coc) = blur;
    s->settings.lens = (ddof_lens){.kind = DDOF_LENS_ARTIST,
                                   .focus_distance = 4,
                                   .max_coc_near = largest / s->width,
                                   .max_coc_far = largest / s->width};
    method_settings(&s->settings, o);
    return 0;
}

void scene_destroy(scene *s) {
    free(s->color);
    free(s->result);
    free(s->blur);
}
