/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The float64 reference against the oracle. Its output is float, so what is asked of every value is to be the rounding
 * of a number within `tolerance` of the oracle's: of many values, an error much above the tolerance misrounds some. */
#include "oracle.h"
#include "support.h"

#include <math.h>
#include <stdlib.h>

static void assert_rounding(float got, long double want, double tolerance, const scene *s, int at) {
    float low = (float)(want - (long double)tolerance), high = (float)(want + (long double)tolerance);
    if (!(got >= low && got <= high))
        fail_msg("%d x %d: value %d is %.9g, not %.17Lg within %g", s->width, s->height, at, got, want, tolerance);
}

static void check(ddof_context *ctx, const scene *s, const ddof_settings *settings, oracle *o, double tolerance) {
    const int pixels = s->width * s->height;
    long double *values = malloc((size_t)pixels * sizeof *values);
    ddof_frame frame = scene_frame(s);
    frame.pixel_aspect = (double)o->aspect;
    o->width = s->width;
    o->height = s->height;
    o->scale = settings->conductance == DDOF_CONDUCTANCE_CLASSIC ? 1 : 1 / 32.0L;
    o->substeps = settings->substeps;
    o->coc = s->coc;
    render(ctx, &frame, settings);
    for (int c = 0; c < 4; c++) {
        for (int i = 0; i < pixels; i++)
            values[i] = (long double)s->color[4 * i + c];
        oracle_blur(o, values);
        for (int i = 0; i < pixels; i++)
            assert_rounding(s->output[4 * i + c], values[i], tolerance, s, 4 * i + c);
    }
    free(values);
}

/* Moderate CoC, where the textbook's elimination keeps its digits. */
static void textbook(void **state) {
    static const coc_pattern cocs[] = {COC_ZERO, COC_SMALL, COC_SMOOTH};
    (void)state;
    rng r = {10};
    ddof_context *ctx = reference_context();
    for (int i = 0; i < 120; i++) {
        oracle o = {.solver = ORACLE_THOMAS, .aspect = (long double[]){1, 2, 0.5L, 1.25L}[i % 4]};
        ddof_settings settings = {.conductance = (ddof_conductance)(i % 2), .substeps = i % 5 + 1};
        scene s = scene_fill(rng_range(&r, 1, 150), rng_range(&r, 1, 150), cocs[i % 3],
                             (color_pattern)rng_range(&r, 0, COLOR_SIGNED), &r);
        check(ctx, &s, &settings, &o, 2e-12);
        scene_free(&s);
    }
    DESTROY(ctx);
}

/* All of the matrix, every pattern, lines short enough for it. */
static void whole_matrix(void **state) {
    (void)state;
    rng r = {11};
    ddof_context *ctx = reference_context();
    for (int i = 0; i < 150; i++) {
        oracle o = {.solver = ORACLE_NETWORK, .aspect = 1};
        ddof_settings settings = {.conductance = (ddof_conductance)(i % 2), .substeps = i % 3 + 1};
        scene s =
            scene_fill(rng_range(&r, 1, 24), rng_range(&r, 1, 24), (coc_pattern)(i % COC_BEYOND), COLOR_RANDOM, &r);
        check(ctx, &s, &settings, &o, 2e-12);
        scene_free(&s);
    }
    DESTROY(ctx);
}

/* CoC beyond its limit counts as the limit. */
static void limit(void **state) {
    (void)state;
    rng r = {12};
    ddof_context *ctx = reference_context();
    for (int i = 0; i < 20; i++) {
        oracle o = {.solver = ORACLE_NETWORK, .aspect = 1};
        ddof_settings settings = {.conductance = (ddof_conductance)(i % 2), .substeps = 1};
        scene s = scene_fill(rng_range(&r, 1, 16), rng_range(&r, 1, 16), COC_BEYOND, COLOR_RANDOM, &r);
        check(ctx, &s, &settings, &o, 2e-12);
        scene_free(&s);
    }
    DESTROY(ctx);
}

/* Holes by colour and by CoC, in the way ddof.h tells. */
static void holes(void **state) {
    (void)state;
    rng r = {13};
    ddof_context *ctx = reference_context();
    for (int i = 0; i < 200; i++) {
        ddof_settings settings = {.conductance = (ddof_conductance)(i % 2), .substeps = i % 3 + 1};
        scene s =
            scene_fill(rng_range(&r, 1, 14), rng_range(&r, 1, 14), (coc_pattern)(i % COC_BEYOND), COLOR_RANDOM, &r);
        bool *hole = calloc((size_t)(s.width * s.height), sizeof *hole);
        oracle o = {.solver = ORACLE_NETWORK, .aspect = 1, .hole = hole};
        const uint32_t rarity = 1u << rng_range(&r, 0, 4);
        int row = rng_range(&r, -10, s.height - 1);
        for (int k = 1; k < s.width * s.height; k++) { /* but the first pixel: something must be left */
            hole[k] = rng_bits(&r) % rarity == 0 || k / s.width == row;
            if (!hole[k]) continue;
            if (rng_bits(&r) % 2)
                s.coc[k] = rng_bits(&r) % 2 ? NAN : INFINITY;
            else
                s.color[4 * k + rng_range(&r, 0, 3)] = rng_bits(&r) % 2 ? NAN : -INFINITY;
        }
        check(ctx, &s, &settings, &o, 2e-12);
        free(hole);
        scene_free(&s);
    }
    DESTROY(ctx);
}

int main(void) {
    static const test tests[] = {
        {"textbook elimination, moderate CoC: 2e-12", textbook, false, 0, 0},
        {"the whole matrix, any CoC: 2e-12", whole_matrix, false, 0, 0},
        {"CoC beyond the limit", limit, false, 0, 0},
        {"holes", holes, false, 0, 0},
    };
    return run_library_tests("reference", tests, COUNT(tests));
}
