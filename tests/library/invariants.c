/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* What must hold for any picture, as ddof.h guarantees it: constants to 1e-6, the sum to 1e-5 (more where a pixel
 * reaches very far, see support.h), output within the range of the input to 1e-6 of it; and what follows from the
 * mathematics: symmetry, mirrors, linearity, the width of the blur. */
#include "support.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const int sizes[][2] = {{1, 1},    {1, 50},   {50, 1},   {16, 16},  {67, 33},
                               {130, 71}, {2000, 3}, {3, 2000}, {8192, 1}, {1, 8192}};

static size_t values_of(const scene *s) {
    return (size_t)s->width * (size_t)s->height * 4;
}

/* Calls `check` on a rendered scene of every size, pattern and setting. */
typedef void (*scene_check)(const scene *s, const ddof_settings *settings, const char *what);

static void for_all(unsigned isa, color_pattern color, uint64_t seed, scene_check check) {
    rng r = {seed};
    ddof_context *ctx = context_of(isa, 1);
    for (int i = 0; i < COUNT(sizes); i++)
        for (int coc = 0; coc < COC_BEYOND; coc++)
            for (int k = 0; k < 4; k++) {
                ddof_settings settings = {.conductance = (ddof_conductance)(k % 2), .substeps = k / 2 * 2};
                scene s = scene_fill(sizes[i][0], sizes[i][1], (coc_pattern)coc, color, &r);
                ddof_frame frame = scene_frame(&s);
                render(ctx, &frame, &settings);
                char what[80];
                snprintf(what, sizeof what, "%d x %d, CoC pattern %d, conductance %d, %d substeps", s.width, s.height,
                         coc, k % 2, settings.substeps);
                check(&s, &settings, what);
                scene_free(&s);
            }
    DESTROY(ctx);
}

/* ---- guarantees */

static void constant(void **state) {
    static const float value[4] = {1, 0.1f, -3.3f, 65504};
    rng r = {20};
    ddof_context *ctx = context_of(test_parameters(state).isa, 1);
    for (int i = 0; i < COUNT(sizes); i++)
        for (int coc = 0; coc < COC_PATTERNS; coc++)
            for (int k = 0; k < 4; k++) {
                ddof_settings settings = {.conductance = (ddof_conductance)(k % 2), .substeps = k / 2 * 2};
                scene s = scene_fill(sizes[i][0], sizes[i][1], (coc_pattern)coc, COLOR_RANDOM, &r);
                for (size_t v = 0; v < values_of(&s); v++)
                    s.color[v] = value[v % 4];
                ddof_frame frame = scene_frame(&s);
                render(ctx, &frame, &settings);
                for (size_t v = 0; v < values_of(&s); v++)
                    if (!(fabs((double)s.output[v] / value[v % 4] - 1) <= 1e-6))
                        fail_msg("%d x %d, CoC pattern %d, conductance %d, %d substeps: %.9g became %.9g (off by %.2g)",
                                 s.width, s.height, coc, k % 2, settings.substeps, value[v % 4], s.output[v],
                                 (double)s.output[v] / value[v % 4] - 1);
                scene_free(&s);
            }
    DESTROY(ctx);
}

static void check_sum(const scene *s, const ddof_settings *settings, const char *what) {
    const double tolerance = tolerance_of(s, settings, 1);
    for (int c = 0; c < 4; c++) {
        double before = 0, after = 0, all = 0;
        for (size_t i = (size_t)c; i < values_of(s); i += 4) {
            before += s->color[i];
            after += s->output[i];
            all += fabs(s->color[i]);
        }
        if (!(fabs(after - before) <= tolerance * all)) fail_msg("%s: the sum %.9g became %.9g", what, before, after);
    }
}

static void check_range(const scene *s, const ddof_settings *settings, const char *what) {
    (void)settings;
    for (int c = 0; c < 4; c++) {
        double low = INFINITY, high = -INFINITY;
        for (size_t i = (size_t)c; i < values_of(s); i += 4) {
            low = fmin(low, s->color[i]);
            high = fmax(high, s->color[i]);
        }
        double slack = 1e-6 * fmax(high - low, fmax(fabs(low), fabs(high)));
        for (size_t i = (size_t)c; i < values_of(s); i += 4)
            if (!(s->output[i] >= low - slack && s->output[i] <= high + slack))
                fail_msg("%s: %.9g left the range %.9g..%.9g", what, s->output[i], low, high);
    }
}

static void sum(void **state) {
    for (int color = 0; color < COLOR_PATTERNS; color++)
        for_all(test_parameters(state).isa, (color_pattern)color, 21, check_sum);
}

static void range(void **state) {
    for (int color = 0; color < COLOR_PATTERNS; color++)
        for_all(test_parameters(state).isa, (color_pattern)color, 22, check_range);
}

/* ---- the matrix */

static double dot(const float *a, const float *b, size_t count) {
    double total = 0;
    for (size_t i = 0; i < count; i++)
        total += (double)a[i] * b[i];
    return total;
}

/* One direction is a symmetric matrix A: <A x, y> = <x, A y>. */
static void symmetry(void **state) {
    rng r = {23};
    ddof_context *ctx = context_of(test_parameters(state).isa, 1);
    for (int i = 0; i < 100; i++) {
        const int n = rng_range(&r, 1, 3000), coc = i % COC_BEYOND;
        const ddof_settings settings = {.conductance = (ddof_conductance)(i / 2 % 2)};
        scene a = scene_fill(i % 2 ? n : 1, i % 2 ? 1 : n, (coc_pattern)coc, COLOR_SIGNED, &r);
        scene b = scene_fill(a.width, a.height, (coc_pattern)coc, COLOR_SIGNED, &r);
        memcpy(b.coc, a.coc, (size_t)n * sizeof *a.coc);
        ddof_frame frame_a = scene_frame(&a), frame_b = scene_frame(&b);
        render(ctx, &frame_a, &settings);
        render(ctx, &frame_b, &settings);
        double left = dot(a.output, b.color, values_of(&a)), right = dot(a.color, b.output, values_of(&a));
        double size = sqrt(dot(a.color, a.color, values_of(&a)) * dot(b.color, b.color, values_of(&b)));
        if (!(fabs(left - right) <= 1e-6 * size))
            fail_msg("%d x %d, CoC pattern %d: <Ax,y> = %.9g, <x,Ay> = %.9g", a.width, a.height, coc, left, right);
        scene_free(&a);
        scene_free(&b);
    }
    DESTROY(ctx);
}

/* The picture seen in a mirror, left to right (across) or top to bottom. */
static void reflect(float *to, const float *from, int width, int height, int channels, bool across) {
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            ptrdiff_t at = across ? (ptrdiff_t)y * width + width - 1 - x : (ptrdiff_t)(height - 1 - y) * width + x;
            memcpy(to + at * channels, from + ((ptrdiff_t)y * width + x) * channels, (size_t)channels * sizeof *to);
        }
}

/* The blur of a mirrored picture is the mirrored blur. */
static void mirror(void **state) {
    const bool across = test_parameters(state).value;
    rng r = {24};
    ddof_context *ctx = context_of(test_parameters(state).isa, 1);
    for (int i = 0; i < 60; i++) {
        const ddof_settings settings = {.conductance = (ddof_conductance)(i % 2), .substeps = i % 3 + 1};
        scene s = scene_fill(rng_range(&r, 1, 150), rng_range(&r, 1, 150), (coc_pattern)(i % COC_BEYOND),
                             (color_pattern)(i % COLOR_PATTERNS), &r);
        scene m = scene_make(s.width, s.height, true);
        reflect(m.color, s.color, s.width, s.height, 4, across);
        reflect(m.coc, s.coc, s.width, s.height, 1, across);
        ddof_frame frame = scene_frame(&s), other = scene_frame(&m);
        render(ctx, &frame, &settings);
        render(ctx, &other, &settings);
        reflect(m.color, s.output, s.width, s.height, 4, across);
        assert_close(m.output, m.color, values_of(&s), 5e-6 * magnitude(s.color, values_of(&s)),
                     "%d x %d, CoC pattern %d", s.width, s.height, i % COC_BEYOND);
        scene_free(&s);
        scene_free(&m);
    }
    DESTROY(ctx);
}

/* A line blurs alike, lying and standing. */
static void turned(void **state) {
    rng r = {25};
    ddof_context *ctx = context_of(test_parameters(state).isa, 1);
    for (int i = 0; i < 60; i++) {
        const int n = rng_range(&r, 1, 700);
        const ddof_settings settings = {.conductance = (ddof_conductance)(i % 2)};
        scene s = scene_fill(n, 1, (coc_pattern)(i % COC_BEYOND), COLOR_RANDOM, &r);
        ddof_frame frame = scene_frame(&s);
        float *standing = fenced(values_of(&s) * sizeof(float), true);
        render(ctx, &frame, &settings);
        frame.color = ddof_image_interleaved(s.color, 1, n, 4, DDOF_FLOAT, 0);
        frame.coc = ddof_image_interleaved(s.coc, 1, n, 1, DDOF_FLOAT, 0);
        frame.output = ddof_image_interleaved(standing, 1, n, 4, DDOF_FLOAT, 0);
        render(ctx, &frame, &settings);
        assert_close(standing, s.output, values_of(&s), 5e-6, "line of %d, CoC pattern %d", n, i % COC_BEYOND);
        fenced_free(standing);
        scene_free(&s);
    }
    DESTROY(ctx);
}

static void linear(void **state) {
    rng r = {26};
    ddof_context *ctx = context_of(test_parameters(state).isa, 1);
    for (int i = 0; i < 40; i++) {
        const ddof_settings settings = {.conductance = (ddof_conductance)(i % 2), .substeps = i % 3 + 1};
        const double k = 4 * rng_unit(&r) - 2;
        scene a =
            scene_fill(rng_range(&r, 1, 200), rng_range(&r, 1, 200), (coc_pattern)(i % COC_BEYOND), COLOR_SIGNED, &r);
        scene b = scene_fill(a.width, a.height, COC_ZERO, COLOR_SIGNED, &r);
        scene both = scene_make(a.width, a.height, false);
        const size_t n = values_of(&a);
        memcpy(b.coc, a.coc, n / 4 * sizeof(float));
        memcpy(both.coc, a.coc, n / 4 * sizeof(float));
        for (size_t v = 0; v < n; v++)
            both.color[v] = (float)(a.color[v] + k * b.color[v]);
        ddof_frame frame_a = scene_frame(&a), frame_b = scene_frame(&b), frame = scene_frame(&both);
        render(ctx, &frame_a, &settings);
        render(ctx, &frame_b, &settings);
        render(ctx, &frame, &settings);
        for (size_t v = 0; v < n; v++)
            a.output[v] = (float)(a.output[v] + k * b.output[v]);
        assert_close(both.output, a.output, n, 5e-6, "%d x %d, CoC pattern %d", a.width, a.height, i % COC_BEYOND);
        scene_free(&a);
        scene_free(&b);
        scene_free(&both);
    }
    DESTROY(ctx);
}

/* ---- the blur */

/* In focus nothing changes, and nothing crosses a sharp pixel of a line. */
static void sharp(void **state) {
    rng r = {27};
    ddof_context *ctx = context_of(test_parameters(state).isa, 1);
    const ddof_settings settings = {.conductance = DDOF_CONDUCTANCE_CLASSIC};
    for (int i = 0; i < 20; i++) {
        scene s = scene_fill(rng_range(&r, 1, 200), rng_range(&r, 1, 100), COC_ZERO, COLOR_LIGHTS, &r);
        ddof_frame frame = scene_frame(&s);
        render(ctx, &frame, &settings);
        assert_close(s.output, s.color, values_of(&s), 1e-6, "%d x %d", s.width, s.height);
        scene_free(&s);

        scene line = scene_fill(i % 2 ? 301 : 1, i % 2 ? 1 : 301, COC_HUGE, COLOR_RANDOM, &r);
        frame = scene_frame(&line);
        line.coc[150] = 0;
        for (size_t v = 0; v < values_of(&line); v++)
            line.color[v] = v / 4 < 150 ? 1.0f : v / 4 == 150 ? 0.5f : 0.0f;
        render(ctx, &frame, &settings);
        assert_close(line.output, line.color, values_of(&line), 1e-6, "a line with a sharp pixel");
        scene_free(&line);
    }
    DESTROY(ctx);
}

/* Variance of the blur of one light along a direction, in pixels^2. */
static double variance(const scene *s, bool across) {
    double total = 0, moment = 0;
    for (int y = 0; y < s->height; y++)
        for (int x = 0; x < s->width; x++) {
            double v = s->output[((size_t)y * (size_t)s->width + (size_t)x) * 4],
                   d = across ? x - s->width / 2 : y - s->height / 2;
            total += v;
            moment += v * d * d;
        }
    return moment / total;
}

/* The blur of a light is as wide as a disc of diameter d: variance d^2/16 along either axis, whatever the substeps. The
 * literature's convention: 2 d^2. Across pixels that are not square: round on the screen. */
static void width(void **state) {
    rng r = {28};
    ddof_context *ctx = context_of(test_parameters(state).isa, 2);
    for (int i = 0; i < 16; i++) {
        const bool classic = i % 2;
        const double d = classic ? 2.5 : 14, want = classic ? 2 * d * d : d * d / 16, aspect = i < 8 ? 1 : 1.5;
        const ddof_settings settings = {.conductance = (ddof_conductance)classic, .substeps = i / 2 % 4 + 1};
        scene s = scene_fill(241, 301, COC_ZERO, COLOR_RANDOM, &r);
        ddof_frame frame = scene_frame(&s);
        frame.pixel_aspect = aspect;
        for (size_t v = 0; v < values_of(&s); v++)
            s.color[v] = 0;
        for (size_t p = 0; p < values_of(&s) / 4; p++)
            s.coc[p] = (float)d;
        s.color[((size_t)(s.height / 2) * (size_t)s.width + (size_t)(s.width / 2)) * 4] = 1;
        render(ctx, &frame, &settings);
        if (fabs(variance(&s, true) / want - 1) > 1e-3 || fabs(variance(&s, false) / want / aspect / aspect - 1) > 1e-3)
            fail_msg("conductance %d, %d substeps, aspect %g: variances %.6g, %.6g, not %.6g", classic,
                     settings.substeps, aspect, variance(&s, true), variance(&s, false), want);
        scene_free(&s);
    }
    DESTROY(ctx);
}

/* The sign of the CoC and its own limit do not matter to the blur. */
static void sign(void **state) {
    rng r = {29};
    ddof_context *ctx = context_of(test_parameters(state).isa, 1);
    const ddof_settings settings = {0};
    scene s = scene_fill(97, 61, COC_BEYOND, COLOR_RANDOM, &r);
    const size_t n = values_of(&s);
    float *want = fenced(n * sizeof *want, true);
    ddof_frame frame = scene_frame(&s);
    for (size_t p = 0; p < n / 4; p += 2)
        s.coc[p] = (float)rng_unit(&r);
    render(ctx, &frame, &settings);
    memcpy(want, s.output, n * sizeof *want);
    for (size_t p = 0; p < n / 4; p++)
        s.coc[p] = -fminf(s.coc[p], 1e5f);
    render(ctx, &frame, &settings);
    assert_same_bits(s.output, want, n, "negative CoC");
    fenced_free(want);
    scene_free(&s);
    DESTROY(ctx);
}

int main(void) {
    static const test tests[] = {
        {"constants to 1e-6", constant, true, 0, 0},
        {"sums to 1e-5", sum, true, 0, 0},
        {"range to 1e-6", range, true, 0, 0},
        {"a direction is symmetric", symmetry, true, 0, 0},
        {"mirrored left to right", mirror, true, 1, 0},
        {"mirrored top to bottom", mirror, true, 0, 0},
        {"rows and columns alike", turned, true, 0, 0},
        {"linear", linear, true, 0, 0},
        {"sharp stays sharp", sharp, true, 0, 0},
        {"as wide as the disc", width, true, 0, 0},
        {"sign and limit of the CoC", sign, true, 0, 0},
    };
    return run_library_tests("invariants", tests, COUNT(tests));
}
