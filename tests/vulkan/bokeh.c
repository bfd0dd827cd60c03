/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Sprites of ddof_render() on the Vulkan backend against those of the CPU backend. */
#include "support.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static ddof_context *gpu, *cpu;

static int set_up(void **state) {
    (void)state;
    gpu = gpu_context(DDOF_BACKEND_VULKAN);
    cpu = context_of(0, 2);
    return 0;
}

static int tear_down(void **state) {
    (void)state;
    DESTROY(gpu);
    DESTROY(cpu);
    return 0;
}

/* ---- scenes */

/* A dim picture with `lights` pixels of up to `brightest`; CoC in stripes of -widest to widest, with nodes of the iris's tables
 * (exp2(k/64)), so that no driver's logarithm can tell a neighbouring one. */
static scene lights_scene(int width, int height, int lights, float brightest, float widest, uint64_t seed) {
    rng r = {seed};
    scene s = scene_make(width, height, true);
    fill_color(s.color, width, height, COLOR_RANDOM, &r);
    for (int i = 0; i < width * height; i++) {
        const int stripe = 8 * (i % width) / width;
        const float part = exp2f(-(float)(stripe % 4)) * (stripe < 4 ? -1 : 1);
        s.coc[i] = stripe == 3 ? 0 : exp2f(floorf(64 * log2f(widest)) / 64) * part;
        for (int c = 0; c < 4; c++) s.color[4 * i + c] *= c < 3 ? 0.5f : 1;
    }
    for (int i = 0; i < lights; i++) {
        const int at = rng_range(&r, 0, width * height - 1);
        float *p = s.color + 4 * (ptrdiff_t)at;
        if (s.coc[at] == 0) continue; /* the brightest of the result would be one that stays sharp */
        for (int c = 0; c < 3; c++) p[c] = brightest * (float)(0.3 + 0.7 * rng_unit(&r));
        p[3] = 1;
    }
    return s;
}

typedef struct comparison {
    double error; /* the largest, of the largest value that is wanted */
    ddof_stats got, want;
} comparison;

static comparison compare(const scene *s, const ddof_frame *frame, const ddof_settings *settings) {
    const size_t n = (size_t)s->width * (size_t)s->height * 4;
    float *want = fenced(n * sizeof *want, true);
    comparison c;
    c.want = render(cpu, frame, settings);
    memcpy(want, s->output, n * sizeof *want);
    memset(s->output, 0xff, n * sizeof *want);
    c.got = render(gpu, frame, settings);
    double worst = 0;
    for (size_t i = 0; i < n; i++) {
        if ((int)(i % 4) >= frame->color.channels) continue;
        const double d = fabs((double)s->output[i] - (double)want[i]);
        if (!(d <= worst)) worst = d;
    }
    c.error = worst / magnitude(want, n);
    fenced_free(want);
    return c;
}

static void check(const scene *s, const ddof_frame *frame, ddof_settings settings, double allowed, const char *what) {
    const comparison c = compare(s, frame, &settings);
    printf("# %s %dx%d: error %.3g sprites %lld %lld large %lld dropped %lld\n", what, s->width, s->height, c.error, (long long)c.got.sprites, (long long)c.want.sprites, (long long)c.want.sprites_large, (long long)c.want.sprites_dropped);
    if (!(c.error <= allowed)) fail_msg("%s, %d x %d: the error is %.3g of the brightest, allowed %.3g", what, s->width, s->height, c.error, allowed);
    if (settings.bokeh == DDOF_BOKEH_HIGHLIGHTS) assert_int_equal(c.got.sprites, c.want.sprites);
    assert_int_equal(c.got.sprites_dropped, c.want.sprites_dropped);
    assert_int_equal(c.got.sprites_large, c.want.sprites_large);
}

static void shapes(void **state) {
    static const ddof_bokeh bokeh[] = {DDOF_BOKEH_HIGHLIGHTS, DDOF_BOKEH_FULL};
    (void)state;
    float image[24 * 20];
    for (int i = 0; i < 24 * 20; i++) image[i] = (float)(1 + i % 24) * (i / 24 > 3 && i / 24 < 16 ? 1 : 0.2f);
    const struct {
        const char *name;
        ddof_iris iris;
    } shape[] = {
        {"disc", {0}},
        {"polygon", {.shape = DDOF_IRIS_POLYGON, .blades = 5, .rotation = 20}},
        {"curved polygon", {.shape = DDOF_IRIS_POLYGON, .blades = 3, .rotation = -70, .curvature = 0.4}},
        {"image", {.shape = DDOF_IRIS_IMAGE, .image = ddof_image_interleaved(image, 24, 20, 1, DDOF_FLOAT, 0)}},
        {"cat's eye", {.cats_eye = 0.7}},
        {"edge", {.edge = 0.6}},
        {"squeeze", {.squeeze = 2, .rotation = 30}},
        {"fringe", {.fringe = 0.2}},
        {"all", {.shape = DDOF_IRIS_POLYGON, .blades = 7, .rotation = 5, .curvature = 0.3, .edge = -0.4, .cats_eye = 0.5, .squeeze = 1.5, .fringe = -0.1}},
    };
    for (int i = 0; i < COUNT(shape); i++)
        for (int k = 0; k < 4; k++) {
            scene s = lights_scene(160 - i, 90 + i, 12, 50, 30, 400 + (uint64_t)i);
            const ddof_frame frame = scene_frame(&s);
            const ddof_settings settings = {.surface = DDOF_SURFACE_RGBA32F,
                                            .bokeh = bokeh[k / 2],
                                            .sprites.resolution = k % 2 ? DDOF_RESOLUTION_HALF : DDOF_RESOLUTION_FULL,
                                            .iris = shape[i].iris};
            check(&s, &frame, settings, 1e-3, shape[i].name);
            scene_free(&s);
        }
}

int main(void) {
    static const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(shapes, set_up, tear_down),
    };
    return run_gpu_tests("vulkan bokeh", tests, COUNT(tests), gpu_missing(DDOF_BACKEND_VULKAN));
}
