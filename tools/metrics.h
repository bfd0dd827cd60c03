/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* How alike two pictures are.
 *   Tone map: x/(1 + x) of max(x, 0), then the sRGB curve (IEC 61966-2-1), for each channel.
 *   PSNR = 10 log10(1 / MSE), the mean taken over R, G and B of the pixels counted. The peak is 1 in both: scene-linear
 *     that is diffuse white, so highlights can push it below 0 dB; tone-mapped it is the most there can be.
 *   SSIM (Wang, Bovik, Sheikh and Simoncelli 2004): on luma, 0.2126 R + 0.7152 G + 0.0722 B (tone-mapped: of the mapped
 *     channels); window: Gaussian of sigma 1.5 pixels cut at 3.5 sigma, 11 x 11, normalised; variances are the window's
 *     (no N - 1); K1 = 0.01, K2 = 0.03, L = 1. Borders are mirrored with the outermost pixel repeated (b a | a b c),
 * and the mean of the map is taken over all pixels counted, the border's too. Luma is float, moments and sums are
 * double. Not counted: pixels outside the mask, which still lie in the windows of their neighbours; and pixels that are
 * not finite in one of the pictures, which are black there in both. */
#ifndef TOOLS_METRICS_H
#define TOOLS_METRICS_H

#include <stddef.h>

typedef struct metrics_result {
    double psnr, ssim; /* scene-linear; psnr is INFINITY for equal pictures */
    double psnr_tonemapped, ssim_tonemapped;
    double max_error;         /* largest absolute difference of a channel, scene-linear */
    size_t pixels, nonfinite; /* counted; left out although the mask has them */
} metrics_result;

/* a, b: width x height x RGB, interleaved. mask: width x height, nonzero counts; NULL: all. Nonzero: out of memory.
 * Where nothing is counted the figures are NAN. Thread-safety: any thread. */
int metrics_compare(metrics_result *result, const float *a, const float *b, int width, int height,
                    const unsigned char *mask);

/* The tone map above, for one value; 0 for NaN, 1 for infinity. */
float metrics_tone_map(float linear);

#endif
