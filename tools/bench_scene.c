/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "bench_scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "bokeh.h"
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

static void set_color(const scene *s, int x, int y, int channel, float value) {
    const size_t pixels = (size_t)s->width * (size_t)s->height, pixel = (size_t)y * (size_t)s->width + (size_t)x;
    const size_t at = s->planar ? (size_t)channel * pixels + pixel : pixel * (size_t)s->channels + (size_t)channel;
    if (s->type == DDOF_HALF)
        ((uint16_t *)s->color)[at] = half_of_float(value);
    else
        ((float *)s->color)[at] = value;
}

static void fill_color(const scene *s, float most) {
    for (int y = 0; y < s->height; y++)
        for (int x = 0; x < s->width; x++)
            for (int c = 0; c < s->channels; c++)
                set_color(s, x, y, c, fminf(color_at(x, y, c), most));
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

/* Squares of 3x3 pixels, 20 to a row: as bright as a lamp, and where they are the blur is the largest there is. */
static void add_highlights(const scene *s, float largest) {
    enum { ACROSS = 20, DOWN = SCENE_HIGHLIGHTS / ACROSS, SIDE = 3 };
    const float value = 50;
    for (int i = 0; i < SCENE_HIGHLIGHTS; i++) {
        const int left = (2 * (i % ACROSS) + 1) * s->width / (2 * ACROSS),
                  top = (2 * (i / ACROSS) + 1) * s->height / (2 * DOWN);
        const bool near_side = 2 * left < s->width;
        const float blur = s->depth    ? (near_side ? 2 : INFINITY)
                           : near_side ? -largest
                                       : largest; /* 2: half the focus distance */
        for (int y = top; y < top + SIDE && y < s->height; y++)
            for (int x = left; x < left + SIDE && x < s->width; x++) {
                for (int c = 0; c < s->channels; c++)
                    set_color(s, x, y, c, value);
                s->blur[(size_t)y * (size_t)s->width + (size_t)x] = blur;
            }
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
    const bool highlights = bokeh_of_options(o) == DDOF_BOKEH_HIGHLIGHTS;
    fill_color(s, highlights ? 1 : INFINITY);
    fill_blur(s, (float)largest);
    if (highlights) add_highlights(s, (float)largest);
    s->frame.color = describe(s, s->color);
    s->frame.output = describe(s, s->in_place ? s->color : s->result);
    ddof_image blur = ddof_image_interleaved(s->blur, s->width, s->height, 1, DDOF_FLOAT, 0);
    *(s->depth ? &s->frame.depth : &s->frame.coc) = blur;
    s->settings.lens = (ddof_lens){.kind = DDOF_LENS_ARTIST,
                                   .focus_distance = 4,
                                   .max_coc_near = largest / s->width,
                                   .max_coc_far = largest / s->width};
    method_settings(&s->settings, o);
    status = iris_read(&s->iris, option_text(o, OPT_IRIS), NULL);
    return status ? status : bokeh_settings(&s->settings, o, &s->iris, s->width);
}

void scene_destroy(scene *s) {
    free(s->color);
    free(s->result);
    free(s->blur);
    iris_close(&s->iris);
}
