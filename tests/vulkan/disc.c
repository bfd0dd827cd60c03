/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* ddof_render() with the disc kernel on the Vulkan backend against the float64 reference: every quality on both
 * surfaces. */
#include "support.h"

#include <math.h>
#include <string.h>

enum { HALF = 1 << DDOF_SURFACE_RGBA16F, FLOAT = 1 << DDOF_SURFACE_RGBA32F };

static void check_on(int surfaces, const pair *p, const scene *s, const ddof_frame *frame, ddof_settings settings,
                     int quality) {
    settings.kernel = DDOF_KERNEL_DISC;
    settings.quality = (ddof_quality)quality;
    float *want = gpu_wanted(p, frame, &settings);
    for (int surface = DDOF_SURFACE_RGBA16F; surface <= DDOF_SURFACE_RGBA32F; surface++) {
        if (!(surfaces & 1 << surface)) continue;
        settings.surface = (ddof_surface)surface;
        gpu_compare(p, s, frame, &settings, want, disc_tolerance(settings.surface));
    }
    fenced_free(want);
}

static void check(const pair *p, const scene *s, const ddof_frame *frame, ddof_settings settings, int quality) {
    check_on(HALF | FLOAT, p, s, frame, settings, quality);
}

/* Along rows, along columns, and both. Drivers compile anew for every eight pixels, and for long: not for all of them.
 */
static void sizes(void **state) {
    (void)state;
    rng r = {200};
    pair p = pair_make();
    for (int n = 1; n <= 67; n += n < 17 ? GPU_STEP : 67 - 17)
        for (int shape = 0; shape < 3; shape++) {
            scene s = gpu_scene(shape == 1 ? 5 : n, shape == 0 ? 5 : n, rng_range(&r, 0, promise.patterns - 1),
                                (color_pattern)rng_range(&r, 0, COLOR_RAMP), &r);
            ddof_frame frame = scene_frame(&s);
            check_on(n < 9 ? HALF | FLOAT : FLOAT, &p, &s, &frame, (ddof_settings){0}, 1 + (n + shape) % 3);
            scene_free(&s);
        }
    pair_destroy(&p);
}

/* Every pattern of CoC and of colours, pixels that are not square. */
static void patterns(void **state) {
    static const double aspect[] = {1, 1.25, 0.6};
    (void)state;
    rng r = {201};
    pair p = pair_make();
    for (int k = 0; k < promise.patterns * COLOR_PATTERNS; k += GPU_STEP) {
        scene s = gpu_scene(131, 90, k / COLOR_PATTERNS, (color_pattern)(k % COLOR_PATTERNS), &r);
        ddof_frame frame = scene_frame(&s);
        frame.pixel_aspect = aspect[k / 4 % 3];
        check(&p, &s, &frame, (ddof_settings){0}, 1 + k % 3);
        scene_free(&s);
    }
    pair_destroy(&p);
}

/* Blur of the usual sizes, where phases turn the most, beside 10,000 px; lines of some hundred pixels. */
static void pictures(void **state) {
    (void)state;
    rng r = {202};
    pair p = pair_make();
    static const ddof_quality quality[] = {DDOF_QUALITY_GOOD, DDOF_QUALITY_BEST, DDOF_QUALITY_DRAFT, DDOF_QUALITY_GOOD};
    for (int k = 0; k < COUNT(quality); k++) {
        scene s = gpu_scene(640 - k, 480 - k, COC_RANDOM, COLOR_RANDOM, &r);
        for (int i = 0; k % 2 && i < s.width * s.height; i++)
            s.coc[i] = (float)(60 * sin(i % s.width * 0.05 + i / s.width * 0.03));
        ddof_frame frame = scene_frame(&s);
        check(&p, &s, &frame, (ddof_settings){0}, (int)quality[k]);
        scene_free(&s);
    }
    pair_destroy(&p);
}

/* Where depth depends on where a pixel lies, diagonals included. */
static void rays(void **state) {
    (void)state;
    rng r = {203};
    pair p = pair_make();
    for (int quality = DDOF_QUALITY_DRAFT; quality <= DDOF_QUALITY_BEST; quality++) {
        scene s = gpu_scene(40, 16, COC_ZERO, COLOR_RANDOM, &r);
        for (int i = 0; i < 40 * 16; i++)
            s.coc[i] = (float)(3 + 2 * rng_unit(&r));
        ddof_frame frame = scene_frame(&s);
        frame.depth = frame.coc;
        frame.coc = (ddof_image){0};
        const ddof_settings settings = {.depth = {.kind = DDOF_DEPTH_RAY},
                                        .lens = {.focal_length = 20, .f_number = 0.1, .focus_distance = 4}};
        check(&p, &s, &frame, settings, quality);
        scene_free(&s);
    }
    pair_destroy(&p);
}

/* Holes of colour and of CoC: scattered, a row and a column, all but one pixel, all. */
static void holes(void **state) {
    (void)state;
    rng r = {204};
    pair p = pair_make();
    for (int k = 0; k < 40; k += GPU_STEP) {
        const int w = rng_range(&r, 1, 32), h = rng_range(&r, 1, 16), column = rng_range(&r, 0, w - 1),
                  row = rng_range(&r, 0, h - 1);
        scene s = gpu_scene(w, h, k / 4 % promise.patterns, COLOR_RANDOM, &r);
        for (int i = 0; i < w * h; i++) {
            const bool line = i % w == column || i / w == row;
            const bool hole[4] = {rng_bits(&r) % 4 == 0, line, i != row * w + column, true};
            if (hole[k % 4]) s.color[4 * i + i % 4] = i % 3 ? NAN : -INFINITY;
            if (k % 4 < 2 && rng_bits(&r) % 5 == 0) s.coc[i] = NAN;
        }
        ddof_frame frame = scene_frame(&s);
        check(&p, &s, &frame, (ddof_settings){0}, 1 + k % 3);
        for (int i = 0; i < w * h * 4; i++)
            assert_true(isfinite(s.output[i]));
        scene_free(&s);
    }
    pair_destroy(&p);
}

/* Holes between sharp pixels are sources of 1e-14 of a colour: of a dark one, too. */
static void brightness(void **state) {
    (void)state;
    rng r = {205};
    pair p = pair_make();
    for (double most = 1e-30; most < 1e31; most *= 1e10) {
        scene s = gpu_scene(39, 16, COC_SMALL, COLOR_RANDOM, &r);
        for (int i = 0; i < 39 * 16; i++) {
            for (int c = 0; c < 4; c++)
                s.color[4 * i + c] *= (float)most;
            if (i % 5 == 0) s.color[4 * i] = NAN;
        }
        ddof_frame frame = scene_frame(&s);
        check(&p, &s, &frame, (ddof_settings){0}, DDOF_QUALITY_GOOD);
        scene_free(&s);
    }
    pair_destroy(&p);
}

/* In place, and with one context for both kernels and every quality: the second time as the first. */
static void in_place(void **state) {
    (void)state;
    rng r = {206};
    ddof_context *gpu = gpu_context(promise.backend);
    scene s = gpu_scene(37, 15, COC_SMOOTH, COLOR_RANDOM, &r);
    const size_t n = 37 * 15 * 4;
    float *input = fenced(n * sizeof *input, true), *first = fenced(n * sizeof *first, true);
    memcpy(input, s.color, n * sizeof *input);
    for (int k = 0; k < 6; k++) {
        ddof_frame frame = scene_frame(&s);
        ddof_settings settings = {.kernel = k % 2 ? DDOF_KERNEL_DISC : DDOF_KERNEL_HEAT};
        if (k % 2) settings.quality = (ddof_quality)(1 + k / 2);
        memcpy(s.color, input, n * sizeof *input);
        render(gpu, &frame, &settings);
        memcpy(first, s.output, n * sizeof *first);
        frame.output = frame.color;
        render(gpu, &frame, &settings);
        assert_memory_equal(s.color, first, n * sizeof *first);
    }
    fenced_free(input);
    fenced_free(first);
    scene_free(&s);
    DESTROY(gpu);
}

static void other_solvers(void **state) {
    (void)state;
    rng r = {207};
    ddof_context *gpu = gpu_context(promise.backend);
    scene s = gpu_scene(40, 30, COC_SMOOTH, COLOR_RANDOM, &r);
    ddof_frame frame = scene_frame(&s);
    for (int k = 1; k < promise.solver_count; k++) {
        const ddof_settings settings = {.kernel = DDOF_KERNEL_DISC, .solver = promise.solvers[k]};
        assert_int_equal(ddof_render(gpu, &frame, &settings, NULL), DDOF_ERROR_UNSUPPORTED);
        assert_non_null(strstr(ddof_error(gpu), "LINE"));
    }
    render(gpu, &frame, &(ddof_settings){.kernel = DDOF_KERNEL_DISC, .solver = DDOF_SOLVER_LINE});
    scene_free(&s);
    DESTROY(gpu);
}

int main(void) {
    static const struct CMUnitTest tests[] = {
        cmocka_unit_test(sizes),    cmocka_unit_test(patterns),      cmocka_unit_test(pictures),
        cmocka_unit_test(rays),     cmocka_unit_test(holes),         cmocka_unit_test(brightness),
        cmocka_unit_test(in_place), cmocka_unit_test(other_solvers),
    };
    return run_gpu_tests("vulkan disc", tests, COUNT(tests), gpu_missing(DDOF_BACKEND_VULKAN));
}
