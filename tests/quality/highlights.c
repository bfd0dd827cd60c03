/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* How well the discs of bright points match those of a real lens, by themselves: over the pixels that a point brighter than 1
 * in the input reaches, its CoC being 4 pixels or more, with 3 pixels of room, after both pictures were exposed so that the truth's
 * mean luma there is 0.18.
 *
 * quality_highlights OURS.exr TRUTH.exr INPUT.exr COC.exr: SSIM tone-mapped and linear, PSNR tone-mapped, and the light there and in the
 *     whole picture as shares of the truth's. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "frame.h"
#include "metrics.h"

static const float BRIGHT = 1, LEAST_COC = 4, ROOM = 3;

static float brightness(const float *rgb) {
    return fmaxf(rgb[0], fmaxf(rgb[1], rgb[2]));
}

static void mark(unsigned char *mask, const frame *input, int x, int y, float radius) {
    const int reach = (int)radius;
    for (int v = y - reach < 0 ? 0 : y - reach; v <= y + reach && v < input->height; v++)
        for (int u = x - reach < 0 ? 0 : x - reach; u <= x + reach && u < input->width; u++)
            if ((float)((u - x) * (u - x) + (v - y) * (v - y)) <= radius * radius) mask[(size_t)v * (size_t)input->width + (size_t)u] = 1;
}

static unsigned char *regions(const frame *input) {
    unsigned char *mask = allocate((size_t)input->width * (size_t)input->height, 1);
    for (int y = 0; y < input->height; y++)
        for (int x = 0; x < input->width; x++) {
            const size_t i = (size_t)y * (size_t)input->width + (size_t)x;
            const float coc = fabsf(input->coc[i]);
            if (brightness(input->rgb + 3 * i) > BRIGHT && coc >= LEAST_COC) mark(mask, input, x, y, coc / 2 + ROOM);
        }
    return mask;
}

/* Mean luma of the pixels in the mask; NULL: of all. */
static double mean_luma(const frame *f, const unsigned char *mask) {
    double sum = 0, count = 0;
    for (size_t i = 0; i < (size_t)f->width * (size_t)f->height; i++) {
        if (mask && !mask[i]) continue;
        sum += 0.2126 * (double)f->rgb[3 * i] + 0.7152 * (double)f->rgb[3 * i + 1] + 0.0722 * (double)f->rgb[3 * i + 2];
        count++;
    }
    return count > 0 ? sum / count : 0;
}

int main(int words, char **word) {
    metrics_result r;
    if (words != 5) die("usage: OURS TRUTH INPUT COC", word[0]);
    frame ours = frame_read(word[1], IO_COLOR), truth = frame_read(word[2], IO_COLOR), input = frame_read(word[3], IO_COLOR);
    frame_read_coc(&input, word[4]);
    if (ours.width != truth.width || ours.height != truth.height || ours.width != input.width || ours.height != input.height)
        die("pictures of different sizes", word[0]);
    unsigned char *mask = regions(&input);
    const double here = mean_luma(&truth, mask), whole = mean_luma(&truth, NULL);
    if (!(here > 0)) die("has no highlights", word[3]);
    const double share = mean_luma(&ours, mask) / here, all = mean_luma(&ours, NULL) / whole;
    for (size_t i = 0; i < 3 * (size_t)ours.width * (size_t)ours.height; i++) {
        ours.rgb[i] *= (float)(0.18 / here);
        truth.rgb[i] *= (float)(0.18 / here);
    }
    if (metrics_compare(&r, ours.rgb, truth.rgb, ours.width, ours.height, mask)) die("out of memory", word[0]);
    printf("highlights: %zu pixels, SSIM %.4f (linear %.4f), PSNR %.2f dB, light %.4f of the truth's, in all %.4f\n", r.pixels,
           r.ssim_tonemapped, r.ssim, r.psnr_tonemapped, share, all);
    return 0; /* memory goes with the program */
}
