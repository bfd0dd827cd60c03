/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The float64 disc kernel against an oracle that shares nothing with it: the whole matrix of each direction. */
#include "disc_oracle.h"
#include "disc_support.h"

#include <math.h>
#include <stdlib.h>

/* The reference's output is float: what is asked of it is to be the rounding of a number that near to the oracle's. */
static void check(ddof_context *ctx, const scene *s, disc_oracle *o, double tolerance) {
    const ddof_settings settings = disc_settings(o->quality);
    const int pixels = s->width * s->height;
    long double *values = malloc((size_t)pixels * sizeof *values);
    ddof_frame frame = scene_frame(s);
    frame.pixel_aspect = (double)o->aspect;
    o->width = s->width;
    o->height = s->height;
    o->coc = s->coc;
    render(ctx, &frame, &settings);
    for (int c = 0; c < 4; c++) {
        for (int i = 0; i < pixels; i++)
            values[i] = (long double)s->color[4 * i + c];
        disc_oracle_blur(o, values);
        for (int i = 0; i < pixels; i++) {
            const float got = s->output[4 * i + c], low = (float)(values[i] - (long double)tolerance),
                        high = (float)(values[i] + (long double)tolerance);
            if (!(got >= low && got <= high))
                fail_msg("%d x %d, %s, aspect %g: value %d is %.9g, not %.17Lg within %g", s->width, s->height,
                         disc_quality_names[o->quality], (double)o->aspect, 4 * i + c, got, values[i], tolerance);
        }
    }
    free(values);
}

static disc_oracle oracle_of(int i) {
    return (disc_oracle){.quality = disc_qualities[i % 3], .aspect = (long double[]){1, 0.5L, 2, 1.25L}[i / 3 % 4]};
}

static void any(void **state) {
    (void)state;
    rng r = {60};
    ddof_context *ctx = reference_context();
    for (int i = 0; i < 240; i++) {
        disc_oracle o = oracle_of(i);
        scene s = scene_fill(rng_range(&r, 1, 8), rng_range(&r, 1, 7), (coc_pattern)(i % COC_PATTERNS),
                             (color_pattern)rng_range(&r, 0, COLOR_SIGNED), &r);
        check(ctx, &s, &o, 1e-9);
        scene_free(&s);
    }
    DESTROY(ctx);
}

/* Where the real part of a conductance is below 0 and where it grows: 0.5 to 30 pixels. */
static void usual(void **state) {
    (void)state;
    rng r = {61};
    ddof_context *ctx = reference_context();
    for (int i = 0; i < 120; i++) {
        disc_oracle o = oracle_of(i);
        scene s = scene_fill(rng_range(&r, 2, 9), rng_range(&r, 2, 7), COC_ZERO, COLOR_SIGNED, &r);
        for (int k = 0; k < s.width * s.height; k++)
            s.coc[k] = (float)((rng_bits(&r) & 1 ? 1 : -1) * (i % 2 ? 0.5 + 2.5 * rng_unit(&r) : 30 * rng_unit(&r)));
        check(ctx, &s, &o, 2e-13);
        scene_free(&s);
    }
    DESTROY(ctx);
}

/* Holes by colour and by CoC, in the way ddof.h tells, whole rows of them too. */
static void holes(void **state) {
    (void)state;
    rng r = {62};
    ddof_context *ctx = reference_context();
    for (int i = 0; i < 240; i++) {
        scene s = scene_fill(rng_range(&r, 1, 7), rng_range(&r, 1, 7), (coc_pattern)(i % COC_BEYOND), COLOR_RANDOM, &r);
        bool *hole = calloc((size_t)(s.width * s.height), sizeof *hole);
        disc_oracle o = oracle_of(i);
        o.hole = hole;
        const uint32_t rarity = 1u << rng_range(&r, 0, 4);
        const int row = rng_range(&r, -5, s.height - 1);
        for (int k = 1; k < s.width * s.height; k++) { /* but the first pixel: something must be left */
            hole[k] = rng_bits(&r) % rarity == 0 || k / s.width == row;
            if (!hole[k]) continue;
            if (rng_bits(&r) % 2)
                s.coc[k] = rng_bits(&r) % 2 ? NAN : INFINITY;
            else
                s.color[4 * k + rng_range(&r, 0, 3)] = rng_bits(&r) % 2 ? NAN : -INFINITY;
        }
        check(ctx, &s, &o, 1e-8);
        free(hole);
        scene_free(&s);
    }
    DESTROY(ctx);
}

int main(void) {
    static const test tests[] = {
        {"the whole matrix, any CoC: 1e-9", any, false, 0, 0},
        {"the whole matrix, CoC up to 30 px: 2e-13", usual, false, 0, 0},
        {"holes: 1e-8", holes, false, 0, 0},
    };
    return run_library_tests("disc_reference", tests, COUNT(tests));
}
