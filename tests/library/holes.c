/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Values that are not finite: counted exactly, filled from their row (their column, where the whole row is holes),
 * never passed on; the same as the float64 reference does. */
#include "support.h"

#include <math.h>
#include <string.h>
#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

static const float bad_values[] = {NAN, INFINITY, -INFINITY, -NAN};

typedef struct pair {
    ddof_context *fast, *reference;
} pair;

static size_t pixels_of(const scene *s) {
    return (size_t)s->width * (size_t)s->height;
}

/* Renders with both; they must agree, in every pixel, on the count, and that all is finite. */
static void check(const pair *p, const scene *s, const ddof_settings *settings, int64_t holes, const char *what) {
    const size_t n = 4 * pixels_of(s);
    double most = 0;
    float *want = fenced(n * sizeof *want, true);
    ddof_frame frame = scene_frame(s);
    for (size_t v = 0; v < n; v++)
        if (isfinite(s->color[v])) most = fmax(most, fabs(s->color[v]));
    assert_int_equal(render(p->fast, &frame, settings).nonfinite_pixels, holes);
    frame.output = ddof_image_interleaved(want, s->width, s->height, 4, DDOF_FLOAT, 0);
    assert_int_equal(render(p->reference, &frame, settings).nonfinite_pixels, holes);
    for (size_t v = 0; v < n; v++)
        if (!isfinite(s->output[v]))
            fail_msg("%s, %d x %d: value %zu is %g", what, s->width, s->height, v, s->output[v]);
    assert_close(s->output, want, n, fmax(tolerance_of(s, settings, 1), 2e-5) * most,
                 "%s, %d x %d, conductance %d, %d substeps", what, s->width, s->height, settings->conductance,
                 settings->substeps);
    fenced_free(want);
}

static bool is_hole(const scene *s, size_t p) {
    const float *c = s->color + 4 * p;
    return !(isfinite(c[0]) && isfinite(c[1]) && isfinite(c[2]) && isfinite(c[3]) && isfinite(s->coc[p]));
}

static int64_t count_holes(const scene *s) {
    int64_t count = 0;
    for (size_t p = 0; p < pixels_of(s); p++)
        count += is_hole(s, p);
    return count;
}

/* One to five values of the pixel. */
static void make_hole(scene *s, size_t p, rng *r) {
    const unsigned which = 1 + rng_bits(r) % 31;
    for (int c = 0; c < 4; c++)
        if (which >> c & 1) s->color[4 * p + (size_t)c] = bad_values[rng_range(r, 0, 3)];
    if (which >> 4 & 1) s->coc[p] = bad_values[rng_range(r, 0, 3)];
}

/* Few holes, many, nearly nothing else; all patterns of CoC. */
static void scattered(void **state) {
    rng r = {50};
    pair p = {context_of(test_parameters(state).isa, 2), reference_context()};
    for (int i = 0; i < 240; i++) {
        const ddof_settings settings = {.conductance = (ddof_conductance)(i % 2), .substeps = i % 3 + 1};
        scene s =
            scene_fill(rng_range(&r, 1, 120), rng_range(&r, 1, 60), (coc_pattern)(i % COC_PATTERNS), COLOR_SIGNED, &r);
        const double density = (double[]){0.002, 0.05, 0.5, 0.97}[i / 3 % 4];
        for (size_t k = 0; k < pixels_of(&s); k++)
            if (rng_unit(&r) < density) make_hole(&s, k, &r);
        check(&p, &s, &settings, count_holes(&s), "scattered");
        scene_free(&s);
    }
    DESTROY(p.fast);
    DESTROY(p.reference);
}

/* A block of holes anywhere, at the borders too: value 0 any; 1 whole rows; 2 whole columns. */
static void blocks(void **state) {
    const int kind = test_parameters(state).value;
    rng r = {51};
    pair p = {context_of(test_parameters(state).isa, 2), reference_context()};
    for (int i = 0; i < 150; i++) {
        const ddof_settings settings = {.conductance = (ddof_conductance)(i % 2), .substeps = i % 3 + 1};
        scene s =
            scene_fill(rng_range(&r, 1, 120), rng_range(&r, 1, 60), (coc_pattern)(i % COC_PATTERNS), COLOR_RANDOM, &r);
        const bool left = rng_bits(&r) & 1, top = rng_bits(&r) & 1;
        const int x0 = kind == 1 || left ? 0 : rng_range(&r, 0, s.width - 1),
                  y0 = kind == 2 || top ? 0 : rng_range(&r, 0, s.height - 1);
        const int x1 = kind == 1 ? s.width : rng_range(&r, x0, s.width),
                  y1 = kind == 2 ? s.height : rng_range(&r, y0, s.height);
        for (int y = y0; y < y1; y++)
            for (int x = x0; x < x1; x++)
                make_hole(&s, (size_t)y * (size_t)s.width + (size_t)x, &r);
        check(&p, &s, &settings, count_holes(&s), "block");
        scene_free(&s);
    }
    DESTROY(p.fast);
    DESTROY(p.reference);
}

/* A picture of holes gives zeros; but for one pixel, the colour of that one, wherever its CoC is large. */
static void everywhere(void **state) {
    static const int sizes[][2] = {{1, 1}, {1, 40}, {40, 1}, {17, 16}, {100, 70}};
    rng r = {52};
    ddof_context *ctx = context_of(test_parameters(state).isa, 2);
    for (int i = 0; i < COUNT(sizes) * 6; i++) {
        const ddof_settings settings = {.conductance = (ddof_conductance)(i % 2), .substeps = i % 3 + 1};
        scene s = scene_fill(sizes[i / 6][0], sizes[i / 6][1], COC_HUGE, COLOR_RANDOM, &r);
        for (size_t k = 0; k < pixels_of(&s); k++)
            make_hole(&s, k, &r);
        ddof_frame frame = scene_frame(&s);
        assert_int_equal(render(ctx, &frame, &settings).nonfinite_pixels, pixels_of(&s));
        for (size_t v = 0; v < 4 * pixels_of(&s); v++)
            assert_true(s.output[v] == 0);

        const size_t one = rng_bits(&r) % pixels_of(&s);
        const float color[4] = {1, -0.5f, 0, 1000};
        memcpy(s.color + 4 * one, color, sizeof color);
        s.coc[one] = 1e4f;
        assert_int_equal(render(ctx, &frame, &settings).nonfinite_pixels, pixels_of(&s) - 1);
        for (size_t k = 0; k < pixels_of(&s); k++)
            for (int c = 0; c < 4; c++)
                assert_close(&s.output[4 * k + (size_t)c], &color[c], 1, 1e-5 * fabsf(color[c]),
                             "%d x %d, one pixel left", s.width, s.height);
        scene_free(&s);
    }
    DESTROY(ctx);
}

/* As games do for speed: denormal numbers become 0 (x86 only). */
static void flush_denormals(bool flush) {
#if defined(__SSE2__)
    _mm_setcsr(flush ? _mm_getcsr() | 0x8040 : _mm_getcsr() & ~0x8040u);
#else
    (void)flush;
#endif
}

/* In a sharp picture a hole becomes the straight line between its neighbours in the row, and at the border its
 * neighbour; however long: a chain of links that hardly conduct. value: without denormal numbers. */
static void bridges(void **state) {
    rng r = {53};
    ddof_context *ctx = context_of(test_parameters(state).isa, 1);
    flush_denormals(test_parameters(state).value);
    for (int i = 0; i < 60; i++) {
        const ddof_settings settings = {0};
        const int longest = i < 50 ? 40 : 8000, left = rng_range(&r, 0, 3), holes = rng_range(&r, 1, longest),
                  right = rng_range(&r, 0, 3);
        if (left + right == 0) continue;
        scene s = scene_fill(left + holes + right, rng_range(&r, 1, 3), COC_ZERO, COLOR_RANDOM, &r);
        const float a = left ? 1 : 3, b = right ? 3 : 1;
        for (size_t p = 0; p < pixels_of(&s); p++) {
            const int x = (int)(p % (size_t)s.width);
            for (int c = 0; c < 4; c++)
                s.color[4 * p + (size_t)c] = x < left ? a : x < left + holes ? NAN : b;
        }
        ddof_frame frame = scene_frame(&s);
        render(ctx, &frame, &settings);
        for (size_t p = 0; p < pixels_of(&s); p++) {
            const int x = (int)(p % (size_t)s.width), step = x - left + 1;
            const float want = x < left ? a : x >= left + holes ? b : (float)(a + (b - a) * (double)step / (holes + 1));
            assert_close(&s.output[4 * p], &want, 1, 1e-5 + 1e-8 * holes, "%d, %d holes, %d: pixel %d", left, holes,
                         right, x);
        }
        scene_free(&s);
    }
    flush_denormals(false);
    DESTROY(ctx);
}

/* What lies in a sharp region beside holes stays to the last bit or nearly so; and no pixel of a picture without holes
 * in its own row and column differs at all. */
static void contained(void **state) {
    rng r = {54};
    ddof_context *ctx = context_of(test_parameters(state).isa, 2);
    for (int i = 0; i < 40; i++) {
        const ddof_settings settings = {.conductance = (ddof_conductance)(i % 2)};
        scene s = scene_fill(rng_range(&r, 20, 120), rng_range(&r, 20, 80), COC_ZERO, COLOR_RANDOM, &r);
        float *before = fenced(4 * pixels_of(&s) * sizeof *before, true);
        ddof_frame frame = scene_frame(&s);
        render(ctx, &frame, &settings);
        memcpy(before, s.output, 4 * pixels_of(&s) * sizeof *before);
        const int x0 = rng_range(&r, 0, s.width - 5), y0 = rng_range(&r, 0, s.height - 5);
        for (int k = 0; k < 25; k++)
            make_hole(&s, (size_t)(y0 + k / 5) * (size_t)s.width + (size_t)(x0 + k % 5), &r);
        render(ctx, &frame, &settings);
        for (size_t p = 0; p < pixels_of(&s); p++) {
            const int x = (int)(p % (size_t)s.width), y = (int)(p / (size_t)s.width);
            if (is_hole(&s, p)) continue;
            assert_close(s.output + 4 * p, before + 4 * p, 4, 1e-6, "%d x %d: pixel %d, %d", s.width, s.height, x, y);
            if ((x < x0 - 1 || x > x0 + 5) && (y < y0 - 1 || y > y0 + 5))
                assert_same_bits(s.output + 4 * p, before + 4 * p, 4, "%d x %d: pixel %d, %d", s.width, s.height, x, y);
        }
        fenced_free(before);
        scene_free(&s);
    }
    DESTROY(ctx);
}

/* A hole without a CoC blurs as its neighbours do: one in a blurred surface leaves no mark. */
static void unknown_coc(void **state) {
    rng r = {55};
    ddof_context *ctx = context_of(test_parameters(state).isa, 1);
    const ddof_settings settings = {0};
    scene s = scene_fill(101, 61, COC_ZERO, COLOR_RANDOM, &r);
    for (size_t p = 0; p < pixels_of(&s); p++) {
        s.coc[p] = 20;
        for (int c = 0; c < 4; c++)
            s.color[4 * p + (size_t)c] = 0.5f;
    }
    for (int i = 0; i < 40; i++)
        s.coc[rng_bits(&r) % pixels_of(&s)] = NAN;
    ddof_frame frame = scene_frame(&s);
    render(ctx, &frame, &settings);
    for (size_t v = 0; v < 4 * pixels_of(&s); v++)
        assert_close(&s.output[v], &(float){0.5f}, 1, 1e-6, "value %zu", v);
    scene_free(&s);
    DESTROY(ctx);
}

/* ---- depth */

/* NaN is a hole, infinity and nothing (0) are far away; with INVERSE infinity is a hole too. */
static void depth(void **state) {
    const bool inverse = test_parameters(state).value;
    rng r = {56};
    pair p = {context_of(test_parameters(state).isa, 2), reference_context()};
    for (int i = 0; i < 40; i++) {
        ddof_settings settings = {.lens = {.focal_length = 85, .f_number = 1.4, .focus_distance = 3}};
        scene s = scene_fill(rng_range(&r, 1, 120), rng_range(&r, 1, 60), COC_ZERO, COLOR_RANDOM, &r);
        int64_t holes = 0;
        if (inverse) settings.depth.kind = DDOF_DEPTH_INVERSE;
        for (size_t k = 0; k < pixels_of(&s); k++) {
            const float value[] = {NAN, INFINITY, -INFINITY, 0, -1};
            const int which = rng_range(&r, 0, 60);
            s.coc[k] = which < 5 ? value[which] : inverse ? (float)rng_unit(&r) : (float)(1 + 9 * rng_unit(&r));
            const bool bad = rng_range(&r, 0, 60) == 0;
            if (bad) s.color[4 * k + 2] = NAN;
            holes += bad || which == 0 || (inverse && which == 1);
        }
        ddof_frame frame = scene_frame(&s);
        frame.depth = frame.coc;
        frame.coc.channels = 0;
        float *want = fenced(4 * pixels_of(&s) * sizeof *want, true);
        assert_int_equal(render(p.fast, &frame, &settings).nonfinite_pixels, holes);
        frame.output = ddof_image_interleaved(want, s.width, s.height, 4, DDOF_FLOAT, 0);
        assert_int_equal(render(p.reference, &frame, &settings).nonfinite_pixels, holes);
        assert_close(s.output, want, 4 * pixels_of(&s), 2e-5, "%d x %d", s.width, s.height);
        fenced_free(want);
        scene_free(&s);
    }
    DESTROY(p.fast);
    DESTROY(p.reference);
}

int main(void) {
    static const test tests[] = {
        {"scattered", scattered, true, 0, 0},
        {"blocks", blocks, true, 0, 0},
        {"whole rows", blocks, true, 1, 0},
        {"whole columns", blocks, true, 2, 0},
        {"the whole picture", everywhere, true, 0, 0},
        {"bridged in a sharp picture", bridges, true, 0, 0},
        {"bridged, denormals flushed", bridges, true, 1, 0},
        {"contained in a sharp picture", contained, true, 0, 0},
        {"unknown CoC", unknown_coc, true, 0, 0},
        {"unknown depth", depth, true, 0, 0},
        {"unknown disparity", depth, true, 1, 0},
    };
    return run_library_tests("holes", tests, COUNT(tests));
}
