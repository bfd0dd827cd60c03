/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "oracle.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A hole between sharp pixels is still filled by them: its links conduct a little, and how little does not matter. */
static const long double FAINT = 1e-14L, LARGEST_COC = 1e5L;

/* A line of n unknowns: g y + sum of beta (y - neighbour) = g x. */
typedef struct line {
    int n;
    long double *beta; /* [i]: between i and i + 1 */
    long double *g, *x, *y;
} line;

/* (b_i) y_i + a_i y_{i-1} + c_i y_{i+1} = d_i, as in every textbook. */
static void thomas(const line *l) {
    long double *c = calloc((size_t)l->n, sizeof *c), *d = calloc((size_t)l->n, sizeof *d);
    for (int i = 0; i < l->n; i++) {
        long double ai = i > 0 ? -l->beta[i - 1] : 0, ci = i + 1 < l->n ? -l->beta[i] : 0, bi = l->g[i] - ai - ci;
        long double m = i > 0 ? bi - ai * c[i - 1] : bi;
        c[i] = ci / m;
        d[i] = (l->g[i] * l->x[i] - (i > 0 ? ai * d[i - 1] : 0)) / m;
    }
    for (int i = l->n - 1; i >= 0; i--)
        l->y[i] = d[i] - (i + 1 < l->n ? c[i] * l->y[i + 1] : 0);
    free(c);
    free(d);
}

/* Even nodes first. */
static int elimination_order(int i, int n) {
    return i % 2 ? (n + 1) / 2 + i / 2 : i / 2;
}

/* The line as a network of conductances, node after node taken out of it (star to mesh): dense, in an order of its own,
 * and without a subtraction, so that links of 1e10 next to links of 1e-20 keep their digits. */
static void network(const line *l) {
    const int n = l->n;
    long double *w = calloc((size_t)n * (size_t)n, sizeof *w); /* [a][b], numbered in the order of elimination */
    long double *g = calloc(3 * (size_t)n, sizeof *g), *b = g + n, *sum = b + n;
    for (int i = 0; i < n; i++) {
        const int k = elimination_order(i, n), next = elimination_order(i + 1, n);
        g[k] = l->g[i];
        b[k] = l->g[i] * l->x[i];
        if (i + 1 < n) w[k * n + next] = w[next * n + k] = l->beta[i];
    }
    for (int k = 0; k < n; k++) {
        sum[k] = g[k];
        for (int j = k + 1; j < n; j++)
            sum[k] += w[k * n + j];
        for (int i = k + 1; i < n; i++) {
            const long double part = w[i * n + k] / sum[k];
            g[i] += part * g[k];
            b[i] += part * b[k];
            for (int j = k + 1; j < n; j++)
                if (j != i) w[i * n + j] += part * w[k * n + j];
        }
    }
    for (int k = n - 1; k >= 0; k--) {
        for (int j = k + 1; j < n; j++)
            b[k] += w[k * n + j] * b[j];
        b[k] /= sum[k];
    }
    for (int i = 0; i < n; i++)
        l->y[i] = b[elimination_order(i, n)];
    free(w);
    free(g);
}

static long double conductance(float a, float b, long double scale) {
    long double p = isfinite(a) ? fabsl((long double)a) : LARGEST_COC,
                q = isfinite(b) ? fabsl((long double)b) : LARGEST_COC;
    long double d = fminl(fminl(p, q), LARGEST_COC);
    return fmaxl(scale * d * d, FAINT);
}

/* One line of the picture, `stride` apart, from `first` on; g all 0: left alone. */
static void blur_line(const oracle *o, line *l, const bool *hole, long double scale, int first, int stride,
                      long double *values) {
    bool any = false;
    for (int i = 0; i < l->n; i++) {
        int at = first + i * stride;
        l->x[i] = values[at];
        l->g[i] = !(hole && hole[at]);
        any = any || l->g[i] > 0;
        if (i + 1 < l->n) l->beta[i] = conductance(o->coc[at], o->coc[at + stride], scale);
    }
    if (!any) return;
    if (o->solver == ORACLE_NETWORK)
        network(l);
    else
        thomas(l);
    for (int i = 0; i < l->n; i++)
        values[first + i * stride] = l->y[i];
}

/* Rows fill holes; a row of nothing but holes is left to the columns. */
static void unfilled_rows(const oracle *o, bool *hole) {
    for (int y = 0; y < o->height; y++) {
        bool all = true;
        for (int x = 0; x < o->width; x++)
            all = all && hole[y * o->width + x];
        for (int x = 0; x < o->width; x++)
            hole[y * o->width + x] = all;
    }
}

void oracle_blur(const oracle *o, long double *values) {
    const int pixels = o->width * o->height, longest = o->width > o->height ? o->width : o->height;
    const long double row_scale = o->scale / o->substeps, column_scale = row_scale * o->aspect * o->aspect;
    long double *room = calloc(4 * (size_t)longest, sizeof *room);
    bool *hole = calloc((size_t)pixels, sizeof *hole);
    line l = {.beta = room, .g = room + longest, .x = room + 2 * longest, .y = room + 3 * longest};
    if (o->hole) memcpy(hole, o->hole, (size_t)pixels * sizeof *hole);
    for (int i = 0; i < pixels; i++)
        if (hole[i]) values[i] = 0;
    for (int step = 0; step < o->substeps; step++) {
        l.n = o->width;
        for (int y = 0; y < o->height; y++)
            blur_line(o, &l, hole, row_scale, y * o->width, 1, values);
        unfilled_rows(o, hole);
        l.n = o->height;
        for (int x = 0; x < o->width; x++)
            blur_line(o, &l, hole, column_scale, x, o->width, values);
        memset(hole, 0, (size_t)pixels * sizeof *hole);
    }
    free(hole);
    free(room);
}
