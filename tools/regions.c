/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "regions.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

static bool edge_between(float c, float d) {
    return fabsf(c - d) > fmaxf(1, 0.25f * fmaxf(fabsf(c), fabsf(d))); /* false for NaN */
}

/* at: -reach^2 of a pixel at an edge, INFINITY elsewhere. */
static void mark_pair(double *at, const float *coc, size_t p, size_t q) {
    if (!isfinite(coc[p]) || !isfinite(coc[q]) || !edge_between(coc[p], coc[q])) return;
    const double reach = fmax(fabs((double)coc[p]), fabs((double)coc[q]));
    at[p] = fmin(at[p], -reach * reach);
    at[q] = fmin(at[q], -reach * reach);
}

static void mark_edges(double *at, const float *coc, int width, int height) {
    const size_t w = (size_t)width, h = (size_t)height;
    for (size_t i = 0; i < w * h; i++)
        at[i] = INFINITY;
    for (size_t y = 0; y < h; y++)
        for (size_t x = 0; x < w; x++) {
            const size_t i = y * w + x;
            if (x + 1 < w) mark_pair(at, coc, i, i + 1);
            if (y + 1 < h) mark_pair(at, coc, i, i + w);
        }
}

typedef struct scratch {
    double *value, *from; /* of the line; where a parabola begins to be the lowest */
    int *apex;
} scratch;

/* f[i] becomes the least of (i - j)^2 + f[j] over j, in linear time by the lower envelope of these parabolas
 * (Felzenszwalb and Huttenlocher, "Distance transforms of sampled functions", 2012). */
static void spread_line(double *f, size_t stride, int n, scratch *s) {
    int parabolas = 0;
    for (int i = 0; i < n; i++) {
        const double v = s->value[i] = f[(size_t)i * stride];
        if (isinf(v)) continue;
        double from = -INFINITY;
        while (parabolas > 0) {
            const int j = s->apex[parabolas - 1];
            from = (v - s->value[j] + (double)i * i - (double)j * j) / (2.0 * (i - j));
            if (from > s->from[parabolas - 1]) break;
            parabolas--;
            from = -INFINITY;
        }
        s->apex[parabolas] = i;
        s->from[parabolas++] = from;
    }
    for (int i = 0, k = 0; parabolas > 0 && i < n; i++) {
        while (k + 1 < parabolas && s->from[k + 1] < i)
            k++;
        const double d = i - s->apex[k];
        f[(size_t)i * stride] = d * d + s->value[s->apex[k]];
    }
}

int regions_divide(unsigned char *region, const float *coc, int width, int height) {
    const size_t w = (size_t)width, h = (size_t)height, longest = w > h ? w : h;
    double *at = malloc(w * h * sizeof *at);
    scratch s = {malloc(longest * sizeof *s.value), malloc(longest * sizeof *s.from), malloc(longest * sizeof *s.apex)};
    const int status = !at || !s.value || !s.from || !s.apex;
    if (!status) {
        mark_edges(at, coc, width, height);
        for (size_t y = 0; y < h; y++)
            spread_line(at + y * w, 1, width, &s);
        for (size_t x = 0; x < w; x++)
            spread_line(at + x, w, height, &s);
        for (size_t i = 0; i < w * h; i++)
            region[i] = (unsigned char)(!isfinite(coc[i])   ? REGION_NONE
                                        : at[i] <= 0        ? REGION_SILHOUETTE
                                        : fabsf(coc[i]) < 1 ? REGION_IN_FOCUS
                                                            : REGION_DEFOCUSED);
    }
    free(at);
    free(s.value);
    free(s.from);
    free(s.apex);
    return status;
}
