/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "metrics.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { RADIUS = 5, WINDOW = 2 * RADIUS + 1, MOMENTS = 5 };

/* ------------------------------------------------------------------------- pixels */

float metrics_tone_map(float linear) {
    float x = linear > 0 ? linear : 0;
    x = isinf(x) ? 1 : x / (1 + x);
    return x <= 0.0031308f ? 12.92f * x : 1.055f * powf(x, 1 / 2.4f) - 0.055f;
}

static float luma(const float *rgb) {
    return (float)(0.2126 * (double)rgb[0] + 0.7152 * (double)rgb[1] + 0.0722 * (double)rgb[2]);
}

static int finite_pixel(const float *p) {
    return isfinite(p[0]) && isfinite(p[1]) && isfinite(p[2]);
}

typedef struct pair {
    const float *a, *b;
    int width, height;
    unsigned char *state; /* of each pixel, the bits below */
    float *luma_a, *luma_b;
    double *scratch;
} pair;

enum { FINITE = 1, COUNTED = 2 };

static void classify(metrics_result *r, pair *p, const unsigned char *mask) {
    const size_t count = (size_t)p->width * (size_t)p->height;
    for (size_t i = 0; i < count; i++) {
        const int finite = finite_pixel(p->a + 3 * i) && finite_pixel(p->b + 3 * i), wanted = !mask || mask[i];
        p->state[i] = (unsigned char)((finite ? FINITE : 0) | (finite && wanted ? COUNTED : 0));
        r->pixels += finite && wanted;
        r->nonfinite += !finite && wanted;
    }
}

/* Lumas of both pictures, tone-mapped or not; returns the PSNR. */
static double compare_pixels(pair *p, int tone_map, size_t pixels, double *max_error) {
    const size_t count = (size_t)p->width * (size_t)p->height;
    double squares = 0, most = 0;
    for (size_t i = 0; i < count; i++) {
        float a[3] = {0}, b[3] = {0};
        for (size_t c = 0; c < 3 && p->state[i]; c++) {
            a[c] = tone_map ? metrics_tone_map(p->a[3 * i + c]) : p->a[3 * i + c];
            b[c] = tone_map ? metrics_tone_map(p->b[3 * i + c]) : p->b[3 * i + c];
            const double d = fabs((double)a[c] - (double)b[c]);
            if (!(p->state[i] & COUNTED)) continue;
            squares += d * d;
            if (d > most) most = d;
        }
        p->luma_a[i] = luma(a);
        p->luma_b[i] = luma(b);
    }
    if (max_error) *max_error = most;
    const double mse = squares / (3 * (double)pixels);
    return mse > 0 ? -10 * log10(mse) : INFINITY;
}

/* ------------------------------------------------------------------------- structural similarity */

static int mirror(int i, int n) {
    while (i < 0 || i >= n)
        i = i < 0 ? -1 - i : 2 * n - 1 - i; /* again where the picture is smaller than the window */
    return i;
}

/* weights[k]: at a distance of k pixels. */
static void make_window(double weights[RADIUS + 1]) {
    double sum = 0;
    for (int k = 0; k <= RADIUS; k++) {
        weights[k] = exp(-k * k / (2 * 1.5 * 1.5));
        sum += k ? 2 * weights[k] : weights[k];
    }
    for (int k = 0; k <= RADIUS; k++)
        weights[k] /= sum;
}

/* a, b, aa, bb, ab of a row, one array after the other. */
static void products(const float *restrict a, const float *restrict b, int width, double *restrict out) {
    const size_t n = (size_t)width;
    for (size_t x = 0; x < n; x++) {
        const double u = (double)a[x], v = (double)b[x];
        out[x] = u;
        out[n + x] = v;
        out[2 * n + x] = u * u;
        out[3 * n + x] = v * v;
        out[4 * n + x] = u * v;
    }
}

/* The window along columns: one row of `count` values out of eleven. */
static void filter_down(const double *const row[WINDOW], const double *weights, double *restrict out, size_t count) {
    const double *restrict m5 = row[0], *restrict m4 = row[1], *restrict m3 = row[2], *restrict m2 = row[3];
    const double *restrict m1 = row[4], *restrict c = row[5], *restrict p1 = row[6], *restrict p2 = row[7];
    const double *restrict p3 = row[8], *restrict p4 = row[9], *restrict p5 = row[10];
    const double w0 = weights[0], w1 = weights[1], w2 = weights[2], w3 = weights[3], w4 = weights[4], w5 = weights[5];
    for (size_t x = 0; x < count; x++)
        out[x] = w0 * c[x] + w1 * (m1[x] + p1[x]) + w2 * (m2[x] + p2[x]) + w3 * (m3[x] + p3[x]) + w4 * (m4[x] + p4[x]) +
                 w5 * (m5[x] + p5[x]);
}

/* The window along a row. padded: RADIUS more values on either side, filled here. */
static void filter_across(double *restrict padded, const double *weights, double *restrict out, int width) {
    for (int k = 1; k <= RADIUS; k++) {
        padded[RADIUS - k] = padded[RADIUS + mirror(-k, width)];
        padded[RADIUS + width - 1 + k] = padded[RADIUS + mirror(width - 1 + k, width)];
    }
    const double w0 = weights[0], w1 = weights[1], w2 = weights[2], w3 = weights[3], w4 = weights[4], w5 = weights[5];
    const double *p = padded;
    for (int x = 0; x < width; x++, p++)
        out[x] = w0 * p[5] + w1 * (p[4] + p[6]) + w2 * (p[3] + p[7]) + w3 * (p[2] + p[8]) + w4 * (p[1] + p[9]) +
                 w5 * (p[0] + p[10]);
}

/* Sum of the map over the pixels of a row that count. m: the five moments, one array after the other. */
static double sum_row(const double *m, int width, const unsigned char *state) {
    const double c1 = 0.01 * 0.01, c2 = 0.03 * 0.03;
    const size_t n = (size_t)width;
    double sum = 0;
    for (size_t x = 0; x < n; x++) {
        if (!(state[x] & COUNTED)) continue;
        const double a = m[x], b = m[n + x];
        const double aa = m[2 * n + x] - a * a, bb = m[3 * n + x] - b * b, ab = m[4 * n + x] - a * b;
        sum += (2 * a * b + c1) * (2 * ab + c2) / ((a * a + b * b + c1) * (aa + bb + c2));
    }
    return sum;
}

/* scratch: the products of eleven rows, a row of all moments, a padded row. */
static size_t scratch_values(int width) {
    return (size_t)width * MOMENTS * (WINDOW + 1) + (size_t)width + 2 * RADIUS;
}

static double ssim(const pair *p, size_t pixels) {
    const int width = p->width, height = p->height;
    const size_t row_values = (size_t)width * MOMENTS;
    double weights[RADIUS + 1], sum = 0;
    double *const moments = p->scratch + row_values * WINDOW, *const padded = moments + row_values;
    make_window(weights);
    for (int y = 0, loaded = 0; y < height; y++) {
        for (; loaded < height && loaded <= y + RADIUS; loaded++) {
            const size_t at = (size_t)loaded * (size_t)width;
            products(p->luma_a + at, p->luma_b + at, width, p->scratch + row_values * (size_t)(loaded % WINDOW));
        }
        for (size_t i = 0; i < MOMENTS; i++) {
            const double *row[WINDOW];
            for (int k = 0; k < WINDOW; k++)
                row[k] =
                    p->scratch + row_values * (size_t)(mirror(y + k - RADIUS, height) % WINDOW) + i * (size_t)width;
            filter_down(row, weights, padded + RADIUS, (size_t)width);
            filter_across(padded, weights, moments + i * (size_t)width, width);
        }
        sum += sum_row(moments, width, p->state + (size_t)y * (size_t)width);
    }
    return sum / (double)pixels;
}

/* ------------------------------------------------------------------------- both */

int metrics_compare(metrics_result *result, const float *a, const float *b, int width, int height,
                    const unsigned char *mask) {
    const size_t count = (size_t)width * (size_t)height;
    pair p = {.a = a, .b = b, .width = width, .height = height};
    p.state = malloc(count);
    p.luma_a = malloc(count * sizeof *p.luma_a);
    p.luma_b = malloc(count * sizeof *p.luma_b);
    p.scratch = malloc(scratch_values(width) * sizeof *p.scratch);
    const int status = !p.state || !p.luma_a || !p.luma_b || !p.scratch;
    *result =
        (metrics_result){.psnr = NAN, .ssim = NAN, .psnr_tonemapped = NAN, .ssim_tonemapped = NAN, .max_error = NAN};
    if (!status) classify(result, &p, mask);
    if (!status && result->pixels > 0) {
        result->psnr = compare_pixels(&p, 0, result->pixels, &result->max_error);
        result->ssim = ssim(&p, result->pixels);
        result->psnr_tonemapped = compare_pixels(&p, 1, result->pixels, NULL);
        result->ssim_tonemapped = ssim(&p, result->pixels);
    }
    free(p.state);
    free(p.luma_a);
    free(p.luma_b);
    free(p.scratch);
    return status;
}
