/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Half and float, one to four channels, alpha: each must be exactly the float RGBA result, rounded, cut or divided. And
 * every half there is, through the conversions of each instruction set. */
#include "layout.h"
#include "support.h"

#include <math.h>
#include <string.h>

static size_t pixels_of(const scene *s) {
    return (size_t)s->width * (size_t)s->height;
}

static scene scene_of(int i, rng *r) {
    scene s = scene_fill(rng_range(r, 1, 150), rng_range(r, 1, 70), (coc_pattern)(i % COC_PATTERNS), COLOR_SIGNED, r);
    for (size_t v = 0; v < 4 * pixels_of(&s); v++)
        s.color[v] = (float)half_value(half_nearest(s.color[v]));
    return s;
}

/* The values that `half` channels would hold. */
static void round_channels(float *values, size_t pixels, unsigned half) {
    for (size_t v = 0; v < 4 * pixels; v++)
        if (half >> v % 4 & 1) values[v] = (float)half_value(half_nearest(values[v]));
}

/* Each mixture of types in and out against the float result. */
static void halves(void **state) {
    rng r = {40};
    ddof_context *ctx = context_of(test_parameters(state).isa, 2);
    for (int i = 0; i < 120; i += TEST_STEP) {
        const ddof_settings settings = {.conductance = (ddof_conductance)(i % 2), .substeps = i % 3 + 1};
        const unsigned half_in = i % 3 ? 15 : rng_bits(&r) & 15, half_out = i % 5 ? 15 : rng_bits(&r) & 15;
        scene s = scene_of(i, &r);
        stored in = stored_make((layout)rng_range(&r, 0, LAYOUTS - 1), s.width, s.height, 4, half_in);
        stored out = stored_make((layout)rng_range(&r, 0, LAYOUTS - 1), s.width, s.height, 4, half_out);
        float *got = fenced(4 * pixels_of(&s) * sizeof *got, true);
        ddof_frame frame = scene_frame(&s);
        render(ctx, &frame, &settings);
        round_channels(s.output, pixels_of(&s), half_out);
        stored_put(&in, s.color, 4);
        frame.color = in.image;
        frame.output = out.image;
        render(ctx, &frame, &settings);
        stored_get(&out, got, 4);
        assert_same_bits(got, s.output, 4 * pixels_of(&s), "%d x %d, half in %x, out %x", s.width, s.height, half_in,
                         half_out);
        assert_gaps_intact(&out);
        stored_free(&in);
        stored_free(&out);
        fenced_free(got);
        scene_free(&s);
    }
    DESTROY(ctx);
}

/* A CoC in half is that number. */
static void half_coc(void **state) {
    rng r = {41};
    ddof_context *ctx = context_of(test_parameters(state).isa, 1);
    const ddof_settings settings = {0};
    for (int i = 0; i < 40; i += TEST_STEP) {
        scene s = scene_fill(rng_range(&r, 1, 150), rng_range(&r, 1, 70), COC_RANDOM, COLOR_RANDOM, &r);
        stored map = stored_make((layout)(i % LAYOUT_PLANAR), s.width, s.height, 1, 1);
        float *want = fenced(4 * pixels_of(&s) * sizeof *want, true);
        for (size_t p = 0; p < pixels_of(&s); p++)
            s.coc[p] = (float)half_value(half_nearest(s.coc[p]));
        stored_put(&map, s.coc, 1);
        ddof_frame frame = scene_frame(&s);
        render(ctx, &frame, &settings);
        memcpy(want, s.output, 4 * pixels_of(&s) * sizeof *want);
        frame.coc = map.image;
        render(ctx, &frame, &settings);
        assert_same_bits(s.output, want, 4 * pixels_of(&s), "%d x %d", s.width, s.height);
        stored_free(&map);
        fenced_free(want);
        scene_free(&s);
    }
    DESTROY(ctx);
}

/* Fewer channels are the first of four. */
static void channels(void **state) {
    const int count = test_parameters(state).value;
    rng r = {42};
    ddof_context *ctx = context_of(test_parameters(state).isa, 2);
    for (int i = 0; i < 60; i += TEST_STEP) {
        const ddof_settings settings = {.conductance = (ddof_conductance)(i % 2), .substeps = i % 3 + 1};
        const int arrangement = rng_range(&r, 0, count == 1 ? LAYOUT_REVERSED : LAYOUTS - 1);
        scene s = scene_of(i, &r);
        stored in = stored_make((layout)arrangement, s.width, s.height, count, i % 2 ? 15 : 0);
        stored out = stored_make((layout)arrangement, s.width, s.height, count, 0);
        float *got = fenced(4 * pixels_of(&s) * sizeof *got, true);
        memset(got, 0, 4 * pixels_of(&s) * sizeof *got);
        for (size_t v = 0; v < 4 * pixels_of(&s); v++)
            if ((int)(v % 4) >= count) s.color[v] = 0;
        ddof_frame frame = scene_frame(&s);
        render(ctx, &frame, &settings);
        stored_put(&in, s.color, 4);
        frame.color = in.image;
        frame.output = out.image;
        render(ctx, &frame, &settings);
        stored_get(&out, got, 4);
        assert_close(got, s.output, 4 * pixels_of(&s), 0, "%d x %d, %d channels", s.width, s.height, count);
        assert_gaps_intact(&out);
        stored_free(&in);
        stored_free(&out);
        fenced_free(got);
        scene_free(&s);
    }
    DESTROY(ctx);
}

/* ---- alpha */

/* Random alpha, 0 and 1 among it, in the last of `count` channels. */
static void put_alpha(scene *s, int count, rng *r) {
    for (size_t p = 0; p < pixels_of(s); p++) {
        int kind = rng_range(r, 0, 3);
        s->color[4 * p + (size_t)count - 1] = kind == 0 ? 0 : kind == 1 ? 1 : (float)rng_unit(r);
    }
}

static void scale_by_alpha(float *to, const float *from, size_t pixels, int count, bool divide) {
    for (size_t v = 0; v < 4 * pixels; v++) {
        const float alpha = from[v / 4 * 4 + (size_t)count - 1];
        to[v] = from[v];
        if ((int)(v % 4) >= count - 1) continue;
        if (divide)
            to[v] = alpha != 0 ? from[v] / alpha : 0;
        else
            to[v] = from[v] * alpha;
    }
}

/* Straight colour is multiplied, blurred, divided. */
static void straight_alpha(void **state) {
    const int count = test_parameters(state).value;
    rng r = {43};
    ddof_context *ctx = context_of(test_parameters(state).isa, 2);
    for (int i = 0; i < 60; i += TEST_STEP) {
        const ddof_settings settings = {.conductance = (ddof_conductance)(i % 2), .substeps = i % 3 + 1};
        scene s = scene_of(i, &r), times = scene_make(s.width, s.height, true);
        const size_t n = 4 * pixels_of(&s);
        put_alpha(&s, count, &r);
        if (i % 10 == 9)
            for (size_t p = 0; p < pixels_of(&s); p++)
                s.color[4 * p + (size_t)count - 1] = 0;
        scale_by_alpha(times.color, s.color, pixels_of(&s), count, false);
        for (size_t v = 0; v < n; v++)
            if ((int)(v % 4) >= count) times.color[v] = 0;
        memcpy(times.coc, s.coc, pixels_of(&s) * sizeof(float));
        ddof_frame frame = scene_frame(&times);
        render(ctx, &frame, &settings);
        scale_by_alpha(times.color, times.output, pixels_of(&s), count, true);

        stored in = stored_make((layout)rng_range(&r, 0, LAYOUTS - 1), s.width, s.height, count, 0);
        stored out = stored_make((layout)rng_range(&r, 0, LAYOUTS - 1), s.width, s.height, count, i % 3 ? 0 : 15);
        stored_put(&in, s.color, 4);
        frame.color = in.image;
        frame.color.alpha = DDOF_ALPHA_STRAIGHT;
        frame.output = out.image;
        render(ctx, &frame, &settings);
        memset(s.output, 0, n * sizeof(float));
        stored_get(&out, s.output, 4);
        if (i % 3 == 0) round_channels(times.color, pixels_of(&s), 15);
        assert_close(s.output, times.color, n, 0, "%d x %d, %d channels", s.width, s.height, count);
        assert_gaps_intact(&out);
        stored_free(&in);
        stored_free(&out);
        scene_free(&s);
        scene_free(&times);
    }
    DESTROY(ctx);
}

/* A colour that is the same wherever there is any stays that colour however it is blurred. */
static void one_straight_colour(void **state) {
    rng r = {44};
    ddof_context *ctx = context_of(test_parameters(state).isa, 2);
    for (int i = 0; i < 30; i += TEST_STEP) {
        const ddof_settings settings = {.conductance = DDOF_CONDUCTANCE_MATCHED};
        scene s = scene_fill(rng_range(&r, 1, 150), rng_range(&r, 1, 70), COC_SMOOTH, COLOR_RANDOM, &r);
        put_alpha(&s, 4, &r);
        for (size_t v = 0; v < 4 * pixels_of(&s); v++)
            if (v % 4 < 3)
                s.color[v] = s.color[v / 4 * 4 + 3] > 0 ? 0.25f + (float)(v % 4) : 1e6f * (float)rng_unit(&r);
        ddof_frame frame = scene_frame(&s);
        frame.color.alpha = DDOF_ALPHA_STRAIGHT;
        render(ctx, &frame, &settings);
        for (size_t v = 0; v < 4 * pixels_of(&s); v++) {
            if (v % 4 == 3 || s.output[v / 4 * 4 + 3] < 1e-12f) continue;
            const float want = 0.25f + (float)(v % 4);
            assert_close(&s.output[v], &want, 1, 1e-5 * want, "%d x %d, alpha %g", s.width, s.height,
                         s.output[v / 4 * 4 + 3]);
        }
        scene_free(&s);
    }
    DESTROY(ctx);
}

/* ---- every half, through ddof_coc(), which writes what it reads */

/* Strides of 2 bytes and of more, and rows of a length that leaves remainders. */
static void all_halves(void **state) {
    static const int widths[] = {65536, 1, 7, 9, 64, 257};
    ddof_context *ctx = context_of(test_parameters(state).isa, 1);
    const ddof_settings settings = {0};
    for (int i = 0; i < 2 * COUNT(widths); i++) {
        const int width = widths[i / 2], height = 65536 / width;
        const size_t n = (size_t)width * (size_t)height;
        stored in = stored_make(i % 2 ? LAYOUT_SPACED : LAYOUT_TIGHT, width, height, 1, 1);
        float *got = fenced(n * sizeof *got, true);
        const ptrdiff_t step = in.image.plane[0].pixel_stride;
        for (size_t h = 0; h < n; h++)
            memcpy((char *)in.image.plane[0].data + (ptrdiff_t)h * step, &(uint16_t){(uint16_t)h}, 2);
        ddof_frame frame = {.coc = in.image, .output = ddof_image_interleaved(got, width, height, 1, DDOF_FLOAT, 0)};
        write_coc(ctx, &frame, &settings);
        for (size_t h = 0; h < n; h++) {
            const double want = half_value((uint16_t)h);
            if (isnan(want) ? !isnan(got[h]) : got[h] != want || !signbit(got[h]) != !signbit(want))
                fail_msg("half %04zx, width %d: %.9g, not %.9g", h, width, got[h], want);
        }
        stored_free(&in);
        fenced_free(got);
    }
    DESTROY(ctx);
}

/* Every half, the middle to its neighbour, the float on either side of both, and what has no half. */
static size_t fill_floats(float *values) {
    static const float others[] = {65519.996f, 65520,    65536,           1e5f,     3e38f, 1e-30f,
                                   1e-45f,     0x1p-25f, 0x1.000002p-25f, INFINITY, NAN};
    size_t n = 0;
    for (uint16_t h = 0; h < 0x7c00; h++) {
        const float low = (float)half_value(h), middle = (float)((half_value(h) + half_value((uint16_t)(h + 1))) / 2);
        const float nearby[] = {low,    nextafterf(low, INFINITY),    nextafterf(low, -INFINITY),
                                middle, nextafterf(middle, INFINITY), nextafterf(middle, -INFINITY)};
        for (int i = 0; h < 0x7bff && i < COUNT(nearby); i++)
            values[n++] = nearby[i];
    }
    for (int i = 0; i < COUNT(others); i++)
        values[n++] = others[i];
    for (size_t i = 0, positive = n; i < positive; i++)
        values[n++] = -values[i];
    return n;
}

static void all_roundings(void **state) {
    ddof_context *ctx = context_of(test_parameters(state).isa, 1);
    const ddof_settings settings = {0};
    float *values = fenced(400000 * sizeof *values, true);
    const int n = (int)fill_floats(values);
    for (int i = 0; i < 2; i++) {
        stored out = stored_make(i ? LAYOUT_SPACED : LAYOUT_TIGHT, n, 1, 1, 1);
        ddof_frame frame = {.coc = ddof_image_interleaved(values, n, 1, 1, DDOF_FLOAT, 0), .output = out.image};
        write_coc(ctx, &frame, &settings);
        for (int v = 0; v < n; v++) {
            uint16_t got, want = half_nearest(values[v]);
            memcpy(&got, (char *)out.image.plane[0].data + v * out.image.plane[0].pixel_stride, 2);
            if (isnan(values[v]) ? !isnan(half_value(got)) : got != want)
                fail_msg("%.9g became half %04x, not %04x", values[v], got, want);
        }
        stored_free(&out);
    }
    fenced_free(values);
    DESTROY(ctx);
}

/* Beyond the range of half a result is infinite, of its sign. */
static void overflow(void **state) {
    ddof_context *ctx = context_of(test_parameters(state).isa, 1);
    const ddof_settings settings = {0};
    float color[4] = {65519, 65520, -1e9f, -65504}, coc = 0;
    uint16_t output[4];
    ddof_frame frame = {.color = ddof_image_interleaved(color, 1, 1, 4, DDOF_FLOAT, 0),
                        .coc = ddof_image_interleaved(&coc, 1, 1, 1, DDOF_FLOAT, 0),
                        .output = ddof_image_interleaved(output, 1, 1, 4, DDOF_HALF, 0)};
    render(ctx, &frame, &settings);
    assert_int_equal(output[0], 0x7bff);
    assert_int_equal(output[1], 0x7c00);
    assert_int_equal(output[2], 0xfc00);
    assert_int_equal(output[3], 0xfbff);
    DESTROY(ctx);
}

int main(void) {
    static const test tests[] = {
        {"half and float, any mixture", halves, true, 0, 0},
        {"CoC in half", half_coc, true, 0, 0},
        {"1 channel", channels, true, 1, 0},
        {"2 channels", channels, true, 2, 0},
        {"3 channels", channels, true, 3, 0},
        {"straight alpha, 2 channels", straight_alpha, true, 2, 0},
        {"straight alpha, 4 channels", straight_alpha, true, 4, 0},
        {"one straight colour stays", one_straight_colour, true, 0, 0},
        {"every half to float", all_halves, true, 0, 0},
        {"every rounding to half", all_roundings, true, 0, 0},
        {"beyond the range of half", overflow, true, 0, 0},
    };
    return run_library_tests("types", tests, COUNT(tests));
}
