/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Every pixel p looks at all pixels q near enough to reach it, brute force. A pixel of CoC d spreads its light evenly
 * over its disc, so it leaves cover/area at p. Signed CoC grows with depth, so it also says who is in front: q nearer
 * than p: its disc lies over p. Their sum is the cover of what is in front, at most 1. q as far as p: the same surface,
 * by its own disc. q farther than p: it is seen through p's blur, as far as p's disc goes; beside a sharp p it is not
 * seen at all. What is in front is laid over the mean of the rest; where nothing else is known behind it, that mean is
 * what it hides. */
#include <math.h>
#include <stdlib.h>

#include "frame.h"

typedef struct layer {
    float rgb[3], weight;
} layer;

static void add(layer *l, const float *rgb, float weight) {
    for (int c = 0; c < 3; c++)
        l->rgb[c] += weight * rgb[c];
    l->weight += weight;
}

static void gather_pixel(const frame *in, const float *areas, const float *distance, int reach, int x, int y,
                         float *out) {
    const size_t width = (size_t)in->width, p = (size_t)y * width + (size_t)x;
    const int side = 2 * reach + 1;
    layer front = {0}, rest = {0};
    for (int v = y - reach < 0 ? 0 : y - reach; v <= y + reach && v < in->height; v++)
        for (int u = x - reach < 0 ? 0 : x - reach; u <= x + reach && u < in->width; u++) {
            const size_t q = (size_t)v * width + (size_t)u;
            const float ours = fabsf(in->coc[p]), theirs = fabsf(in->coc[q]), apart = in->coc[p] - in->coc[q];
            const float same = fmaxf(1, 0.25f * fmaxf(ours, theirs)); /* the depth edge of tools/regions.h */
            const float radius = 0.5f * (apart < -same ? ours : theirs);
            const float cover = disc_cover(distance[(v - y + reach) * side + (u - x + reach)], radius);
            if (cover > 0) add(apart > same ? &front : &rest, in->rgb + 3 * q, cover / disc_area(areas, radius));
        }
    const float over = fminf(front.weight, 1);
    for (int c = 0; c < 3; c++)
        out[c] = (1 - over) * rest.rgb[c] / rest.weight + (over > 0 ? over * front.rgb[c] / front.weight : 0);
}

void gather(const frame *in, float *out) {
    float largest = 0;
    for (size_t i = 0; i < (size_t)in->width * (size_t)in->height; i++)
        largest = fmaxf(largest, 0.5f * fabsf(in->coc[i]));
    const int reach = (int)largest + 1, side = 2 * reach + 1;
    float *areas = disc_areas(largest), *distance = allocate((size_t)side * (size_t)side, sizeof *distance);
    for (int j = 0; j < side; j++)
        for (int i = 0; i < side; i++)
            distance[j * side + i] = hypotf((float)(i - reach), (float)(j - reach));
    for (int y = 0; y < in->height; y++)
        for (int x = 0; x < in->width; x++)
            gather_pixel(in, areas, distance, reach, x, y, out + 3 * ((size_t)y * (size_t)in->width + (size_t)x));
    free(areas);
    free(distance);
}
