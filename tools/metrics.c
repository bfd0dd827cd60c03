/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "metrics.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { RADIUS = 5, MOMENTS = 5 };

float metrics_tone_map(float linear) {
    float x = linear > 0 ? linear : 0;
    x = isinf(x) ? 1 : x / (1 + x);
    return x <= 0.0031308f ? 12.92f * x : 1.055f * powf(x, 1 / 2.4f) - 0.055f;
}

static float luma(const float *rgb) {
    return 0.2126f * rgb[0] + 0.7152f * rgb[1] + 0.0722f * rgb[2];
}

static int finite_pixel(const float *p) {
    return isfinite(p[0]) && isfinite(p[1]) && isfinite(p[2]);
}

/* The luma of both pictures, and which pixels count. */
static void prepare(metrics_result *r, const float *a, const float *b, size_t count, const unsigned char *mask,
                    unsigned char *counted, float *la, float *lb) {
    for (size_t i = 0; i < count; i++) {
        int fine = finite_pixel(a + 3 * i) && finite_pixel(b + 3 * i);
        counted[i] = (unsigned char)(fine && (!mask || mask[i]));
        if (!fine && (!mask || mask[i])) r->nonfinite++;
        la[i] = fine ? luma(a + 3 * i) : 0;
        lb[i] = fine ? luma(b + 3 * i) : 0;
        r->pixels += counted[i];
    }
}

static double psnr(double squares, size_t pixels) {
    double mse = squares / (3.0 * (double)pixels);
    return mse > 0 ? -10 * log10(mse) : INFINITY;
}

static void differences(metrics_result *r, const float *a, const float *b, size_t count, const unsigned char *counted) {
    double linear = 0, mapped = 0;
    for (size_t i = 0; i < count; i++)
        for (size_t c = 3 * i; counted[i] && c < 3 * i + 3; c++) {
            double d = fabs((double)a[c] - b[c]), t = (double)metrics_tone_map(a[c]) - metrics_tone_map(b[c]);
            linear += d * d;
            mapped += t * t;
            if (d > r->max_error) r->max_error = d;
        }
    r->psnr = psnr(linear, r->pixels);
    r->psnr_tonemapped = psnr(mapped, r->pixels);
}

/* Mirrored at the border, without repeating the outermost pixel twice over in pictures narrower than the window. */
static int mirror(int i, int n) {
    while (i < 0 || i >= n) i = i < 0 ? -1 - i : 2 * n - 1 - i;
    return i;
}

static void window(double w[2 * RADIUS + 1]) {
    double sum = 0;
    for (int i = -RADIUS; i <= RADIUS; i++) sum += w[i + RADIUS] = exp(-i * i / (2 * 1.5 * 1.5));
    for (int i = 0; i <= 2 * RADIUS; i++) w[i] /= sum;
}

/* E[a], E[b], E[aa], E[bb], E[ab] of a row of the window's columns. */
static void moments_of_row(const float *la, const float *lb, int width, int height, int y, const double *w, double *down) {
    memset(down, 0, sizeof *down * MOMENTS * (size_t)width);
    for (int k = -RADIUS; k <= RADIUS; k++) {
        size_t row = (size_t)mirror(y + k, height) * (size_t)width;
        for (int x = 0; x < width; x++) {
            double a = la[row + (size_t)x], b = lb[row + (size_t)x], weight = w[k + RADIUS];
            double *m = down + MOMENTS * (size_t)x;
            m[0] += weight * a, m[1] += weight * b;
            m[2] += weight * a * a, m[3] += weight * b * b, m[4] += weight * a * b;
        }
    }
}

static double ssim_at(const double *down, int x, int width, const double *w) {
    const double c1 = 0.01 * 0.01, c2 = 0.03 * 0.03;
    double m[MOMENTS] = {0};
    for (int k = -RADIUS; k <= RADIUS; k++) {
        const double *from = down + MOMENTS * (size_t)mirror(x + k, width);
        for (int i = 0; i < MOMENTS; i++) m[i] += w[k + RADIUS] * from[i];
    }
    double va = m[2] - m[0] * m[0], vb = m[3] - m[1] * m[1], cov = m[4] - m[0] * m[1];
    return (2 * m[0] * m[1] + c1) * (2 * cov + c2) / ((m[0] * m[0] + m[1] * m[1] + c1) * (va + vb + c2));
}

static double ssim(const float *la, const float *lb, int width, int height, const unsigned char *counted, double *down) {
    double w[2 * RADIUS + 1], sum = 0, n = 0;
    window(w);
    for (int y = 0; y < height; y++) {
        moments_of_row(la, lb, width, height, y, w, down);
        for (int x = 0; x < width; x++)
            if (counted[(size_t)y * (size_t)width + (size_t)x]) {
                sum += ssim_at(down, x, width, w);
                n++;
            }
    }
    return sum / n;
}

/* Luma of the tone-mapped picture: tone-mapped channels, then weights. */
static void tone_mapped_luma(const float *rgb, float *l, size_t count) {
    for (size_t i = 0; i < count; i++) {
        float mapped[3];
        for (int c = 0; c < 3; c++) mapped[c] = isfinite(rgb[3 * i + (size_t)c]) ? metrics_tone_map(rgb[3 * i + (size_t)c]) : 0;
        l[i] = luma(mapped);
    }
}

int metrics_compare(metrics_result *result, const float *a, const float *b, int width, int height,
                    const unsigned char *mask) {
    const size_t count = (size_t)width * (size_t)height;
    float *la = malloc(count * sizeof *la), *lb = malloc(count * sizeof *lb);
    double *down = malloc((size_t)width * MOMENTS * sizeof *down);
    unsigned char *counted = malloc(count);
    int status = !la || !lb || !down || !counted;
    if (!status) {
        *result = (metrics_result){0};
        prepare(result, a, b, count, mask, counted, la, lb);
        if (result->pixels) {
            differences(result, a, b, count, counted);
            result->ssim = ssim(la, lb, width, height, counted, down);
            tone_mapped_luma(a, la, count);
            tone_mapped_luma(b, lb, count);
            result->ssim_tonemapped = ssim(la, lb, width, height, counted, down);
        } else {
            result->psnr = result->ssim = result->psnr_tonemapped = result->ssim_tonemapped = result->max_error = NAN;
        }
    }
    free(la);
    free(lb);
    free(down);
    free(counted);
    return status;
}
