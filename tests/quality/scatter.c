/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Every pixel is drawn as its disc, from far to near. Energy: the weights of a disc have the sum 1, so a point keeps
 * its light however large it becomes. Order: signed CoC grows with depth; pixels whose CoC lies between two whole
 * numbers are one slice, whose discs are added up, and slices are laid over one another from the farthest to the
 * nearest: what lies below keeps the room that is left. So a surface across many slices adds up to 1, and only what is
 * in front of something else hides it. This is done twice, for what is blurred before the focus and for all the rest;
 * what the rest lacks, being hidden, is filled smoothly from around the hole, and the near picture is laid over that.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "frame.h"

static void splat(const frame *in, size_t at, const float *areas, float *slice) {
    const int x = (int)(at % (size_t)in->width), y = (int)(at / (size_t)in->width);
    const float radius = 0.5f * fabsf(in->coc[at]), share = 1 / disc_area(areas, radius);
    const int reach = (int)radius + 1;
    for (int v = y - reach < 0 ? 0 : y - reach; v <= y + reach && v < in->height; v++)
        for (int u = x - reach < 0 ? 0 : x - reach; u <= x + reach && u < in->width; u++) {
            const float weight = share * disc_cover(sqrtf((float)((u - x) * (u - x) + (v - y) * (v - y))), radius);
            float *to = slice + 4 * ((size_t)v * (size_t)in->width + (size_t)u);
            for (int c = 0; c < 3; c++)
                to[c] += weight * in->rgb[3 * at + (size_t)c];
            to[3] += weight;
        }
}

/* More than full cover comes from rounding and from where discs of several sizes crowd: it is scaled back to 1. */
static void lay_over(float *below, const float *slice, size_t count) {
    for (size_t i = 0; i < 4 * count; i += 4) {
        const float scale = slice[i + 3] > 1 ? 1 / slice[i + 3] : 1, room = 1 - scale * slice[i + 3];
        const float keep = below[i + 3] > room ? room / below[i + 3] : 1;
        for (size_t c = 0; c < 4; c++)
            below[i + c] = scale * slice[i + c] + keep * below[i + c];
    }
}

/* Slices from `high` down to `low`; picture: premultiplied, slice: scratch. weights: sum of all, NULL: not asked for.
 */
static void draw(const frame *in, const float *areas, int high, int low, float *picture, float *slice) {
    const size_t count = (size_t)in->width * (size_t)in->height;
    for (int k = high; k >= low; k--) {
        memset(slice, 0, count * 4 * sizeof *slice);
        for (size_t i = 0; i < count; i++)
            if ((int)floorf(in->coc[i]) == k) splat(in, i, areas, slice);
        lay_over(picture, slice, count);
    }
}

/* What is missing of a premultiplied picture comes from one of half the size, and so on. */
static void fill(float *picture, int width, int height) {
    if (width == 1 && height == 1) return;
    const int w = (width + 1) / 2, h = (height + 1) / 2;
    float *half = allocate((size_t)w * (size_t)h, 4 * sizeof *half);
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++)
            for (int c = 0; c < 4; c++)
                half[4 * (y / 2 * w + x / 2) + c] += picture[4 * (y * width + x) + c];
    for (int i = 0; i < w * h; i++) {
        const float cover = half[4 * i + 3];
        for (int c = 0; c < 4 && cover > 1; c++)
            half[4 * i + c] /= cover;
    }
    fill(half, w, h);
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            float *to = picture + 4 * (y * width + x);
            const float lacks = 1 - to[3];
            /* bilinear: three quarters of the pixel it lies in, a quarter of the next one */
            const int x0 = x / 2, y0 = y / 2, x1 = x % 2 ? x0 + 1 : x0 - 1, y1 = y % 2 ? y0 + 1 : y0 - 1;
            const int u = x1 < 0 || x1 >= w ? x0 : x1, v = y1 < 0 || y1 >= h ? y0 : y1;
            for (int c = 0; c < 4 && lacks > 0; c++)
                to[c] += lacks *
                         (9 * half[4 * (y0 * w + x0) + c] + 3 * half[4 * (y0 * w + u) + c] +
                          3 * half[4 * (v * w + x0) + c] + half[4 * (v * w + u) + c]) /
                         16;
        }
    free(half);
}

void scatter(const frame *in, float *out) {
    const size_t count = (size_t)in->width * (size_t)in->height;
    float low = 0, high = 0;
    for (size_t i = 0; i < count; i++) {
        low = fminf(low, in->coc[i]);
        high = fmaxf(high, in->coc[i]);
    }
    float *areas = disc_areas(0.5f * fmaxf(-low, high)), *slice = allocate(count, 4 * sizeof *slice);
    float *near = allocate(count, 4 * sizeof *near), *rest = allocate(count, 4 * sizeof *rest);
    draw(in, areas, (int)floorf(high), -1, rest, slice);
    draw(in, areas, -2, (int)floorf(low), near, slice);
    fill(rest, in->width, in->height);
    lay_over(rest, near, count);
    for (size_t i = 0; i < count; i++)
        for (size_t c = 0; c < 3; c++)
            out[3 * i + c] = rest[4 * i + 3] > 0 ? rest[4 * i + c] / rest[4 * i + 3] : 0;
    free(areas);
    free(slice);
    free(near);
    free(rest);
}
