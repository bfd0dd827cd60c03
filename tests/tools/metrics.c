/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "metrics.h"

static float *pixels(int width, int height) {
    float *p = calloc((size_t)width * (size_t)height * 3, sizeof *p);
    assert_non_null(p);
    return p;
}

static float noise(uint32_t *state) {
    *state = *state * 1664525u + 1013904223u;
    return (float)(*state >> 8) / 16777216;
}

static metrics_result compare(const float *a, const float *b, int width, int height, const unsigned char *mask) {
    metrics_result result;
    assert_int_equal(metrics_compare(&result, a, b, width, height, mask), 0);
    return result;
}

/* ------------------------------------------------------------------------- the definitions, the slow way */

static double tone_map(double x) {
    x = x > 0 ? x / (1 + x) : 0;
    return x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1 / 2.4) - 0.055;
}

static double luma_at(const float *p, int mapped) {
    const double r = p[0], g = p[1], b = p[2];
    return mapped ? 0.2126 * tone_map(r) + 0.7152 * tone_map(g) + 0.0722 * tone_map(b)
                  : 0.2126 * r + 0.7152 * g + 0.0722 * b;
}

static int mirrored(int i, int n) {
    const int period = 2 * n, m = ((i % period) + period) % period;
    return m < n ? m : period - 1 - m;
}

/* One window of 121 pixels at a time. */
static double slow_ssim_at(const float *a, const float *b, int width, int height, int x, int y, int mapped) {
    double weight = 0, m[5] = {0};
    for (int j = -5; j <= 5; j++)
        for (int i = -5; i <= 5; i++) {
            const size_t at = 3 * ((size_t)mirrored(y + j, height) * (size_t)width + (size_t)mirrored(x + i, width));
            const double w = exp(-(i * i + j * j) / 4.5), u = luma_at(a + at, mapped), v = luma_at(b + at, mapped);
            weight += w;
            m[0] += w * u, m[1] += w * v, m[2] += w * u * u, m[3] += w * v * v, m[4] += w * u * v;
        }
    for (int i = 0; i < 5; i++)
        m[i] /= weight;
    const double mu = m[0], nu = m[1], uu = m[2] - mu * mu, vv = m[3] - nu * nu, uv = m[4] - mu * nu;
    return (2 * mu * nu + 0.0001) * (2 * uv + 0.0009) / ((mu * mu + nu * nu + 0.0001) * (uu + vv + 0.0009));
}

static double slow_ssim(const float *a, const float *b, int width, int height, const unsigned char *mask, int mapped) {
    double sum = 0;
    int count = 0;
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++)
            if (!mask || mask[y * width + x]) {
                sum += slow_ssim_at(a, b, width, height, x, y, mapped);
                count++;
            }
    return sum / count;
}

static double slow_psnr(const float *a, const float *b, int width, int height, const unsigned char *mask, int mapped) {
    double sum = 0;
    int count = 0;
    for (int i = 0; i < 3 * width * height; i++)
        if (!mask || mask[i / 3]) {
            const double d = mapped ? tone_map(a[i]) - tone_map(b[i]) : (double)a[i] - (double)b[i];
            sum += d * d;
            count++;
        }
    return 10 * log10(count / sum);
}

/* ------------------------------------------------------------------------- tests */

static void test_tone_map(void **state) {
    (void)state;
    assert_true(metrics_tone_map(0) == 0 && metrics_tone_map(-3) == 0 && metrics_tone_map(NAN) == 0);
    assert_float_equal(metrics_tone_map(1), 0.7353569, 1e-6); /* sRGB of one half */
    assert_float_equal(metrics_tone_map(INFINITY), 1, 1e-6);
    for (float x = 1e-5f; x < 1e6f; x *= 1.3f)
        assert_float_equal(metrics_tone_map(x), tone_map(x), 1e-6);
}

static void test_known_errors(void **state) {
    (void)state;
    float *a = pixels(20, 10), *b = pixels(20, 10);
    for (int i = 0; i < 600; i++) {
        a[i] = 0.5f;
        b[i] = 0.6f;
    }
    metrics_result r = compare(a, b, 20, 10, NULL);
    assert_float_equal(r.psnr, 20, 1e-5); /* an error of a tenth of the peak everywhere */
    assert_float_equal(r.max_error, 0.1, 1e-7);
    assert_float_equal(r.ssim, (2 * 0.5 * 0.6 + 1e-4) / (0.25 + 0.36 + 1e-4),
                       1e-6); /* flat pictures: luminance alone */
    assert_int_equal(r.pixels, 200);
    assert_int_equal(r.nonfinite, 0);
    b[3 * 50] = 3.5f; /* brighter than white: far above the peak */
    assert_float_equal(compare(a, b, 20, 10, NULL).max_error, 3, 1e-7);
    r = compare(a, a, 20, 10, NULL);
    assert_true(isinf(r.psnr) && r.psnr > 0 && isinf(r.psnr_tonemapped) && r.max_error == 0);
    assert_float_equal(r.ssim, 1, 1e-12);
    assert_float_equal(r.ssim_tonemapped, 1, 1e-12);
    free(a);
    free(b);
}

/* The figures are scikit-image's (0.19.3) for the same picture: structural_similarity with gaussian_weights,
 * use_sample_covariance off, data_range 1, mean of the full map; peak_signal_noise_ratio with data_range 1. */
static void test_published_implementation(void **state) {
    (void)state;
    enum { WIDTH = 64, HEIGHT = 48 };
    float *a = pixels(WIDTH, HEIGHT), *b = pixels(WIDTH, HEIGHT);
    unsigned char mask[WIDTH * HEIGHT] = {0};
    memset(mask, 1, sizeof mask / 2);
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++)
            for (int c = 0; c < 3; c++) {
                const double v = (x * (7 + c) + y * (5 + 2 * c) + c * 11) % 64 / 64.0;
                const double light = (x - 20) * (x - 20) + (y - 15) * (y - 15) < 36 ? 4 : 0;
                a[3 * (y * WIDTH + x) + c] = (float)(v + light);
                b[3 * (y * WIDTH + x) + c] = (float)(v * 0.875 + (x * 3 + y * 13 + c) % 16 / 128.0 - 1 / 64.0 + light);
            }
    metrics_result r = compare(a, b, WIDTH, HEIGHT, NULL);
    assert_float_equal(r.psnr, 25.334615378, 1e-6);
    assert_float_equal(r.ssim, 0.976927327, 1e-6);
    assert_float_equal(r.psnr_tonemapped, 27.095944143, 1e-4);
    assert_float_equal(r.ssim_tonemapped, 0.951156669, 1e-6);
    assert_float_equal(r.max_error, 0.13671875, 1e-7);
    r = compare(a, b, WIDTH, HEIGHT, mask);
    assert_float_equal(r.ssim, 0.978718788, 1e-6);
    assert_float_equal(r.ssim_tonemapped, 0.952513103, 1e-6);
    assert_int_equal(r.pixels, WIDTH * HEIGHT / 2);
    free(a);
    free(b);
}

static void test_sizes(void **state) {
    (void)state;
    static const int sizes[][2] = {{1, 1},   {1, 7},  {9, 1},   {2, 2},   {3, 4},
                                   {10, 11}, {12, 5}, {11, 11}, {33, 17}, {1, 40}};
    uint32_t seed = 1;
    for (size_t s = 0; s < sizeof sizes / sizeof sizes[0]; s++)
        for (int masked = 0; masked < 2; masked++) {
            const int width = sizes[s][0], height = sizes[s][1], count = width * height;
            float *a = pixels(width, height), *b = pixels(width, height);
            unsigned char *mask = calloc((size_t)count, 1);
            for (int i = 0; i < 3 * count; i++) {
                a[i] = 3 * noise(&seed);
                b[i] = a[i] + noise(&seed) - 0.5f;
            }
            for (int i = 0; i < count; i++)
                mask[i] = i % 3 != 1 ? 200 : 0;
            const unsigned char *used = masked ? mask : NULL;
            const metrics_result r = compare(a, b, width, height, used);
            assert_float_equal(r.psnr, slow_psnr(a, b, width, height, used, 0), 1e-6);
            assert_float_equal(r.psnr_tonemapped, slow_psnr(a, b, width, height, used, 1), 1e-3);
            assert_float_equal(r.ssim, slow_ssim(a, b, width, height, used, 0), 2e-6);
            assert_float_equal(r.ssim_tonemapped, slow_ssim(a, b, width, height, used, 1), 2e-6);
            free(a);
            free(b);
            free(mask);
        }
}

static void test_pixels_that_do_not_count(void **state) {
    (void)state;
    enum { WIDTH = 23, HEIGHT = 19, COUNT = WIDTH * HEIGHT };
    float *a = pixels(WIDTH, HEIGHT), *b = pixels(WIDTH, HEIGHT);
    unsigned char mask[COUNT], fine[COUNT];
    uint32_t seed = 7;
    size_t expected = 0;
    memset(mask, 1, sizeof mask);
    for (int i = 0; i < 3 * COUNT; i++) {
        a[i] = noise(&seed);
        b[i] = noise(&seed);
    }
    for (int i = 0; i < COUNT; i++) {
        fine[i] = i % 17 != 3 && i % 13 != 5;
        expected += fine[i];
        for (int c = 0; c < 3 && !fine[i]; c++)
            a[3 * i + c] = b[3 * i + c] = 0;
    }
    /* Black in both and left out is what a pixel becomes that is not finite in one channel of one of them. */
    const double psnr = slow_psnr(a, b, WIDTH, HEIGHT, fine, 0), ssim = slow_ssim(a, b, WIDTH, HEIGHT, fine, 0);
    const double mapped = slow_ssim(a, b, WIDTH, HEIGHT, fine, 1);
    for (int i = 0; i < COUNT; i++)
        if (!fine[i]) {
            (i % 2 ? a : b)[3 * i + i % 3] = i % 5 ? NAN : -INFINITY;
            a[3 * i + (i + 1) % 3] = 100;
        }
    metrics_result r = compare(a, b, WIDTH, HEIGHT, NULL);
    assert_int_equal(r.pixels, expected);
    assert_int_equal(r.nonfinite, COUNT - expected);
    assert_float_equal(r.psnr, psnr, 1e-6);
    assert_float_equal(r.ssim, ssim, 2e-6);
    assert_float_equal(r.ssim_tonemapped, mapped, 2e-6);
    assert_true(r.max_error < 1);
    mask[3] = 0; /* one that is not finite and not asked for */
    assert_int_equal(compare(a, b, WIDTH, HEIGHT, mask).nonfinite, COUNT - expected - 1);
    memset(mask, 0, sizeof mask);
    r = compare(a, b, WIDTH, HEIGHT, mask);
    assert_int_equal(r.pixels, 0);
    assert_true(isnan(r.psnr) && isnan(r.ssim) && isnan(r.psnr_tonemapped) && isnan(r.ssim_tonemapped) &&
                isnan(r.max_error));
    free(a);
    free(b);
}

/* Highlights a million times white must not drown what the moments are made of. */
static void test_bright_pictures(void **state) {
    (void)state;
    enum { WIDTH = 30, HEIGHT = 30 };
    float *a = pixels(WIDTH, HEIGHT), *b = pixels(WIDTH, HEIGHT);
    uint32_t seed = 3;
    for (int i = 0; i < 3 * WIDTH * HEIGHT; i++) {
        a[i] = 1e6f * noise(&seed) * (float)(i % 100 == 0) + noise(&seed);
        b[i] = a[i] * 1.01f;
    }
    const metrics_result r = compare(a, b, WIDTH, HEIGHT, NULL);
    assert_true(r.psnr < 0);
    assert_float_equal(r.ssim, slow_ssim(a, b, WIDTH, HEIGHT, NULL, 0), 1e-4);
    assert_float_equal(r.ssim_tonemapped, slow_ssim(a, b, WIDTH, HEIGHT, NULL, 1), 1e-5);
    free(a);
    free(b);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_tone_map),
        cmocka_unit_test(test_known_errors),
        cmocka_unit_test(test_published_implementation),
        cmocka_unit_test(test_sizes),
        cmocka_unit_test(test_pixels_that_do_not_count),
        cmocka_unit_test(test_bright_pictures),
    };
    return cmocka_run_group_tests_name("metrics", tests, NULL, NULL);
}
