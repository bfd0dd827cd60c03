/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "flip.h"
#include "regions.h"

static float *pixels(int width, int height, int channels) {
    float *p = calloc((size_t)width * (size_t)height * (size_t)channels, sizeof *p);
    assert_non_null(p);
    return p;
}

static float noise(uint32_t *state) {
    *state = *state * 1664525u + 1013904223u;
    return (float)(*state >> 8) / 16777216;
}

static flip_view view_of(flip_tone tone, double ppd) {
    return (flip_view){.ppd = ppd, .tone = tone, .threads = 1};
}

static void fill(float *p, int count, float r, float g, float b) {
    for (int i = 0; i < count; i++) {
        p[3 * i] = r;
        p[3 * i + 1] = g;
        p[3 * i + 2] = b;
    }
}

/* ------------------------------------------------------------------------- known values */

/* The picture of tests/tools/metrics.c; the figures are printed by tests/tools/flip.py (float64, two-dimensional
 * kernels, no code shared). */
enum { WIDTH = 64, HEIGHT = 48 };

static void formula(float *a, float *b) {
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++)
            for (int c = 0; c < 3; c++) {
                const double v = (x * (7 + c) + y * (5 + 2 * c) + c * 11) % 64 / 64.0;
                const double light = (x - 20) * (x - 20) + (y - 15) * (y - 15) < 36 ? 4 : 0;
                a[3 * (y * WIDTH + x) + c] = (float)(v + light);
                b[3 * (y * WIDTH + x) + c] = (float)(v * 0.875 + (x * 3 + y * 13 + c) % 16 / 128.0 - 1 / 64.0 + light);
            }
}

static void test_figures(void **state) {
    (void)state;
    static const struct {
        double ppd, compact, at_20_15, at_63_47, display, hdr, hdr_at_20_15;
    } right[] = {{67, 0.0722525, 0.0076016, 0.1174848, 0.1201812, 0.1249497, 0.0103970},
                 {20, 0.1584976, 0.0212136, 0.1954403, 0.2353466, 0.2465464, 0.0251670}};
    float *a = pixels(WIDTH, HEIGHT, 3), *b = pixels(WIDTH, HEIGHT, 3), *map = pixels(WIDTH, HEIGHT, 1);
    formula(a, b);
    for (size_t i = 0; i < 2; i++) {
        flip_view view = view_of(FLIP_COMPACT, right[i].ppd);
        flip_exposures used;
        assert_int_equal(flip_ldr(map, a, b, WIDTH, HEIGHT, &view), 0);
        assert_float_equal(flip_mean(map, NULL, WIDTH, HEIGHT), right[i].compact, 5e-6);
        assert_float_equal(map[15 * WIDTH + 20], right[i].at_20_15, 3e-5);
        assert_float_equal(map[47 * WIDTH + 63], right[i].at_63_47, 3e-5);
        view.tone = FLIP_DISPLAY;
        assert_int_equal(flip_ldr(map, a, b, WIDTH, HEIGHT, &view), 0);
        assert_float_equal(flip_mean(map, NULL, WIDTH, HEIGHT), right[i].display, 5e-6);
        assert_int_equal(flip_hdr(map, a, b, WIDTH, HEIGHT, &view, &used), 0);
        assert_float_equal(flip_mean(map, NULL, WIDTH, HEIGHT), right[i].hdr, 1e-5);
        assert_float_equal(map[15 * WIDTH + 20], right[i].hdr_at_20_15, 3e-5);
        assert_int_equal(used.count, 4);
        assert_float_equal(used.start, -1.2118133, 1e-6);
        assert_float_equal(used.stop, 2.1316739, 1e-6);
    }
    free(a);
    free(b);
    free(map);
}

/* The root of the feature difference shows rounding: hence 5e-5.
 * Flat pictures have no features and filters leave them alone: what is left is the colour's difference alone, which for
 * greys is that of L. Y = 0.18 has L = 49.4961, Y = 0.25 has L = 57.0754: 7.5793^0.7 = 4.1280, and the knee is 0.4 of
 * the largest difference 203.3017^0.7 = 41.2761: 0.95 4.1280 / 16.5104 = 0.23752. */
static void test_flat_greys(void **state) {
    (void)state;
    float a[3 * 20 * 9], b[3 * 20 * 9], map[20 * 9];
    fill(a, 20 * 9, 0.18f, 0.18f, 0.18f);
    fill(b, 20 * 9, 0.25f, 0.25f, 0.25f);
    const flip_view view = view_of(FLIP_DISPLAY, 67);
    assert_int_equal(flip_ldr(map, a, b, 20, 9, &view), 0);
    for (int i = 0; i < 20 * 9; i++)
        assert_float_equal(map[i], 0.23752, 5e-5);
}

/* Nothing is farther apart than pure green and pure blue: 1. Black and white: L differs by 100, 100^0.7 = 25.1189,
 * above the knee: 0.95 + 0.05 (25.1189 - 16.5104)/(41.2761 - 16.5104) = 0.96738. */
static void test_largest_differences(void **state) {
    (void)state;
    float a[3 * 64], b[3 * 64], map[64];
    const flip_view view = view_of(FLIP_DISPLAY, 67);
    fill(a, 64, 0, 1, 0);
    fill(b, 64, 0, 0, 1);
    assert_int_equal(flip_ldr(map, a, b, 8, 8, &view), 0);
    assert_float_equal(map[9], 1, 1e-5);
    fill(a, 64, 0, 0, 0);
    fill(b, 64, 1, 1, 1);
    assert_int_equal(flip_ldr(map, a, b, 8, 8, &view), 0);
    assert_float_equal(map[9], 0.96738, 2e-5);
    fill(b, 64, 7, 9, 1e30f); /* brighter than the display's white is white */
    assert_int_equal(flip_ldr(map, a, b, 8, 8, &view), 0);
    assert_float_equal(map[9], 0.96738, 2e-5);
}

static void test_exposures(void **state) {
    (void)state;
    /* the fit reaches 0.85 at x = 2.11887: (0.9036 x^2 + 0.018 x)/(0.8748 x^2 + 0.354 x + 0.14) */
    const double at_one = log2(2.11887);
    float p[3 * 5];
    flip_exposures e;
    for (int i = 0; i < 5; i++)
        fill(p + 3 * i, 1, 1, 1, 1);
    assert_int_equal(flip_choose_exposures(&e, p, 5, 1), 0);
    assert_float_equal(e.start, at_one, 1e-4);
    assert_float_equal(e.stop, at_one, 1e-4);
    assert_int_equal(e.count, 2);
    fill(p, 1, 1024, 1024, 1024);
    fill(p + 3, 1, 0.25f, 0.25f, 0.25f);
    fill(p + 6, 1, 0.25f, 0.25f, 0.25f);
    fill(p + 9, 1, -1, 0, -5); /* black */
    fill(p + 12, 1, NAN, 1e9f, 1e9f);
    assert_int_equal(flip_choose_exposures(&e, p, 5, 1), 0);
    assert_float_equal(e.start, at_one - 10, 1e-4);
    assert_float_equal(e.stop, at_one + 2, 1e-4);
    assert_int_equal(e.count, 12);
    fill(p + 3, 3, 0, 0, 0); /* more than half is black */
    assert_int_equal(flip_choose_exposures(&e, p, 5, 1), 0);
    assert_float_equal(e.stop, at_one - 10, 1e-4);
    fill(p, 5, 0, 0, 0);
    assert_int_equal(flip_choose_exposures(&e, p, 5, 1), 0);
    assert_true(e.start == 0 && e.stop == 0 && e.count == 2);
}

/* ------------------------------------------------------------------------- invariants */

static void test_invariants(void **state) {
    (void)state;
    static const int sizes[][2] = {{1, 1}, {1, 9}, {40, 1}, {7, 5}, {21, 33}, {50, 90}};
    uint32_t seed = 5;
    for (size_t s = 0; s < sizeof sizes / sizeof sizes[0]; s++)
        for (int ppd = 1; ppd < 200; ppd += 66) {
            const int width = sizes[s][0], height = sizes[s][1], count = width * height;
            float *a = pixels(width, height, 3), *b = pixels(width, height, 3);
            float *map = pixels(width, height, 1), *other = pixels(width, height, 1);
            for (int i = 0; i < 3 * count; i++) {
                a[i] = noise(&seed) < 0.05f ? 50 * noise(&seed) : noise(&seed) - 0.1f;
                b[i] = noise(&seed);
            }
            flip_view view = view_of(FLIP_COMPACT, ppd);
            assert_int_equal(flip_ldr(map, a, a, width, height, &view), 0);
            assert_int_equal(flip_hdr(other, a, a, width, height, &view, NULL), 0);
            for (int i = 0; i < count; i++)
                assert_true(map[i] == 0 && other[i] == 0);
            assert_int_equal(flip_hdr(map, a, b, width, height, &view, NULL), 0);
            for (int i = 0; i < count; i++)
                assert_true(map[i] >= 0 && map[i] <= 1);
            assert_int_equal(flip_ldr(map, a, b, width, height, &view), 0);
            assert_int_equal(flip_ldr(other, b, a, width, height, &view), 0);
            assert_memory_equal(map, other, (size_t)count * sizeof *map); /* LDR-FLIP is symmetric */
            view.threads = 3;
            assert_int_equal(flip_ldr(other, a, b, width, height, &view), 0);
            assert_memory_equal(map, other, (size_t)count * sizeof *map);
            free(a);
            free(b);
            free(map);
            free(other);
        }
}

static void test_pixels_that_do_not_count(void **state) {
    (void)state;
    float *a = pixels(WIDTH, HEIGHT, 3), *b = pixels(WIDTH, HEIGHT, 3);
    float *map = pixels(WIDTH, HEIGHT, 1), *holes = pixels(WIDTH, HEIGHT, 1);
    unsigned char mask[WIDTH * HEIGHT];
    memset(mask, 1, sizeof mask);
    const flip_view view = view_of(FLIP_COMPACT, 67);
    const size_t hole = 20 * WIDTH + 30;
    formula(a, b);
    fill(a + 3 * hole, 1, 0, 0, 0);
    fill(b + 3 * hole, 1, 0, 0, 0);
    assert_int_equal(flip_ldr(map, a, b, WIDTH, HEIGHT, &view), 0);
    a[3 * hole + 1] = INFINITY;
    b[3 * hole + 2] = 5;
    assert_int_equal(flip_ldr(holes, a, b, WIDTH, HEIGHT, &view), 0);
    assert_true(isnan(holes[hole]));
    holes[hole] = map[hole];
    assert_memory_equal(map, holes, WIDTH * HEIGHT * sizeof *map); /* as if both were black there */
    holes[hole] = NAN;
    mask[hole] = 0;
    assert_true(flip_mean(holes, NULL, WIDTH, HEIGHT) == flip_mean(map, mask, WIDTH, HEIGHT));
    memset(mask, 0, sizeof mask);
    assert_true(isnan(flip_mean(map, mask, WIDTH, HEIGHT)));
    free(a);
    free(b);
    free(map);
    free(holes);
}

/* ------------------------------------------------------------------------- regions */

static bool is_edge(float c, float d) {
    return fabs((double)c - (double)d) > fmax(1, 0.25 * fmax(fabs((double)c), fabs((double)d)));
}

/* Every pixel against every edge. */
static int slow_region(const float *coc, int width, int height, int x, int y) {
    if (!isfinite(coc[y * width + x])) return REGION_NONE;
    for (int j = 0; j < height; j++)
        for (int i = 0; i < width; i++)
            for (int k = 0; k < 4; k++) {
                const int u = i + (k == 0) - (k == 1), v = j + (k == 2) - (k == 3);
                if (u < 0 || v < 0 || u >= width || v >= height) continue;
                const float c = coc[j * width + i], d = coc[v * width + u];
                if (!isfinite(c) || !isfinite(d) || !is_edge(c, d)) continue;
                const double reach = fmax(fabs((double)c), fabs((double)d));
                if ((x - i) * (x - i) + (y - j) * (y - j) <= reach * reach) return REGION_SILHOUETTE;
            }
    return fabs((double)coc[y * width + x]) < 1 ? REGION_IN_FOCUS : REGION_DEFOCUSED;
}

static void test_regions(void **state) {
    (void)state;
    static const int sizes[][2] = {{1, 1}, {1, 30}, {30, 1}, {40, 25}, {17, 44}};
    uint32_t seed = 9;
    int found[REGION_COUNT] = {0};
    for (size_t s = 0; s < sizeof sizes / sizeof sizes[0]; s++)
        for (int round = 0; round < 4; round++) {
            const int width = sizes[s][0], height = sizes[s][1];
            float *coc = pixels(width, height, 1);
            unsigned char *region = calloc((size_t)width * (size_t)height, 1);
            const float ground = round % 2 ? 0.5f : 12.25f;
            for (int i = 0; i < width * height; i++) {
                const float n = noise(&seed);
                coc[i] = n < 0.004f ? -6.5f : n < 0.008f ? 3.25f : n < 0.01f ? NAN : ground;
            }
            assert_int_equal(regions_divide(region, coc, width, height), 0);
            for (int i = 0; i < width * height; i++) {
                assert_int_equal(region[i], slow_region(coc, width, height, i % width, i / width));
                found[region[i]]++;
            }
            free(coc);
            free(region);
        }
    for (int r = 0; r < REGION_COUNT; r++)
        assert_true(found[r] > 0);
}

/* A step from 0.5 to -5 between columns 19 and 20: 5 pixels on either side. Where a ramp climbs no pixel is an edge. */
static void test_known_regions(void **state) {
    (void)state;
    float coc[40];
    unsigned char region[40];
    for (int x = 0; x < 40; x++)
        coc[x] = x < 20 ? 0.5f : -5;
    assert_int_equal(regions_divide(region, coc, 40, 1), 0);
    for (int x = 0; x < 40; x++)
        assert_int_equal(region[x], x < 14 ? REGION_IN_FOCUS : x < 26 ? REGION_SILHOUETTE : REGION_DEFOCUSED);
    for (int x = 0; x < 40; x++)
        coc[x] = (float)(x - 20);
    assert_int_equal(regions_divide(region, coc, 40, 1), 0);
    for (int x = 0; x < 40; x++)
        assert_int_equal(region[x], x == 20 ? REGION_IN_FOCUS : REGION_DEFOCUSED);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_figures),
        cmocka_unit_test(test_flat_greys),
        cmocka_unit_test(test_largest_differences),
        cmocka_unit_test(test_exposures),
        cmocka_unit_test(test_invariants),
        cmocka_unit_test(test_pixels_that_do_not_count),
        cmocka_unit_test(test_regions),
        cmocka_unit_test(test_known_regions),
    };
    return cmocka_run_group_tests_name("flip", tests, NULL, NULL);
}
