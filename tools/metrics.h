/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* How alike two pictures are.
 *   PSNR = 10 log10(1 / MSE), over all pixels counted and R, G, B; peak 1 (diffuse white) scene-linear, and tone-mapped.
 *   SSIM (Wang et al. 2004): on luma (0.2126 R + 0.7152 G + 0.0722 B), Gaussian window of sigma 1.5 px cut at 5 px, borders
 *     mirrored, K1 = 0.01, K2 = 0.03, L = 1; the mean of its map over the pixels counted.
 *   Tone map: x/(1 + x) of max(x, 0), then the sRGB curve.
 * Pixels in which either picture is not finite are left out, and counted; for the window they are black. */
#ifndef TOOLS_METRICS_H
#define TOOLS_METRICS_H

#include <stddef.h>

typedef struct metrics_result {
    double psnr, ssim;                     /* scene-linear; psnr is INFINITY for equal pictures */
    double psnr_tonemapped, ssim_tonemapped;
    double max_error;                      /* largest absolute difference of a channel, scene-linear */
    size_t pixels, nonfinite;              /* counted; left out */
} metrics_result;

/* a, b: width x height x RGB, interleaved. mask: width x height, nonzero counts; NULL: all. Nonzero: out of memory. Where
 * nothing is counted the figures are NAN. */
int metrics_compare(metrics_result *result, const float *a, const float *b, int width, int height,
                    const unsigned char *mask);

/* The tone map above, for one value. */
float metrics_tone_map(float linear);

#endif
