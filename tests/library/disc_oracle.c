/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "disc_oracle.h"

#include <complex.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef long double complex number;

typedef struct constants {
    int components, directions, substeps;
    long double fade;
    long double beta[2][2], offset[2][2], weight[2][2]; /* real, imaginary */
} constants;

/* From docs/disc.md. */
static const constants models[] = {
    [DDOF_QUALITY_DRAFT] = {1, 2, 1, 0, {{0.0146618L, -0.0348723L}}, {{0.0197902L, -0.1624852L}}, {{1, 0.4648333L}}},
    [DDOF_QUALITY_GOOD] = {2, 4, 1, 8.060688L, {{0.0098316L, 0.0099269L}, {0, -0.0098219L}},
                           {{-0.1043853L, 0.0690196L}, {-0.15L, -0.107426L}},
                           {{1.491419L, -1.952798L}, {-0.491419L, -0.2848962L}}},
    [DDOF_QUALITY_BEST] = {2, 4, 2, 12, {{0.013551L, -0.0101849L}, {0, -0.0115604L}},
                           {{-0.1046951L, -0.0798702L}, {-0.1435999L, -0.1966454L}},
                           {{1.266083L, 1.407232L}, {-0.266083L, -0.0206861L}}},
};

static const long double FAINT = 1e-14L, LARGEST_COC = 1e5L;
/* Neighbour of a pixel in each direction: rows, columns, diagonal, antidiagonal. */
static const int step_x[] = {1, 0, 1, -1}, step_y[] = {0, 1, 1, 1};

static const constants *model_of(ddof_quality quality) {
    return &models[quality == DDOF_QUALITY_DEFAULT ? DDOF_QUALITY_GOOD : quality];
}

static number total(const constants *m, int j, long double u) {
    const long double v = fmaxl(u, 1);
    long double beta = 0, offset = 0;
    for (int k = 0; k < m->components; k++) {
        beta += m->weight[k][0] * m->beta[k][0] - m->weight[k][1] * m->beta[k][1];
        offset += m->weight[k][0] * m->offset[k][0] - m->weight[k][1] * m->offset[k][1];
    }
    return u / (v + offset / beta) * (m->beta[j][0] * v + m->offset[j][0] + (m->beta[j][1] * v + m->offset[j][1]) * I);
}

static number conductance(const disc_oracle *o, const constants *m, int j, int direction, float c0, float c1) {
    const long double p = isfinite(c0) ? fabsl((long double)c0) : LARGEST_COC,
                      q = isfinite(c1) ? fabsl((long double)c1) : LARGEST_COC, d = fminl(fminl(p, q), LARGEST_COC),
                      a2 = o->aspect * o->aspect, u = d * d, v = fmaxl(u, 1), t = v / (v + m->fade);
    const number b = total(m, j, u), diagonal = m->directions == 2 ? 0 : fminl(1, a2) * b * t / 4;
    const number part[4] = {b - 2 * diagonal, a2 * b - 2 * diagonal, diagonal, diagonal};
    return part[direction] / m->substeps + FAINT;
}

/* The picture as a network: node i has capacity g[i], holds values[i], and is linked to j by link[i n + j]. Node after node is
 * taken out of it (star to mesh): Gaussian elimination without a subtraction, so that links of 1e8 beside links of 1e-14
 * keep their digits. */
static void eliminate(number *link, number *g, number *values, int n) {
    number *sum = calloc((size_t)n, sizeof *sum);
    for (int i = 0; i < n; i++)
        values[i] *= g[i];
    for (int k = 0; k < n; k++) {
        sum[k] = g[k];
        for (int j = k + 1; j < n; j++)
            sum[k] += link[k * n + j];
        for (int i = k + 1; i < n; i++) {
            const number part = link[i * n + k] / sum[k];
            if (part == 0) continue;
            g[i] += part * g[k];
            values[i] += part * values[k];
            for (int j = k + 1; j < n; j++)
                if (j != i) link[i * n + j] += part * link[k * n + j];
        }
    }
    for (int k = n - 1; k >= 0; k--) {
        for (int j = k + 1; j < n; j++)
            values[k] += link[k * n + j] * values[j];
        values[k] /= sum[k];
    }
    free(sum);
}

/* Whether the line of this pixel in a direction is holes from end to end. */
static bool line_of_holes(const disc_oracle *o, const bool *hole, int direction, int x, int y) {
    for (int sign = -1; sign <= 1; sign += 2)
        for (int i = x, j = y; i >= 0 && j >= 0 && i < o->width && j < o->height;
             i += sign * step_x[direction], j += sign * step_y[direction])
            if (!hole[j * o->width + i]) return false;
    return true;
}

/* One direction of one component, the whole picture as one system. Lines of nothing but holes stay as they are. */
static void diffuse(const disc_oracle *o, const constants *m, int j, int direction, const bool *hole, number *values) {
    const int n = o->width * o->height;
    number *link = calloc((size_t)n * (size_t)(n + 1), sizeof *link), *g = link + n * n;
    for (int y = 0; y < o->height; y++)
        for (int x = 0; x < o->width; x++) {
            const int at = y * o->width + x, x1 = x + step_x[direction], y1 = y + step_y[direction], to = y1 * o->width + x1;
            const bool lost = line_of_holes(o, hole, direction, x, y);
            g[at] = lost || !hole[at] ? 1 : 0;
            if (lost || x1 < 0 || x1 >= o->width || y1 >= o->height) continue;
            link[at * n + to] = link[to * n + at] = conductance(o, m, j, direction, o->coc[at], o->coc[to]);
        }
    eliminate(link, g, values, n);
    free(link);
}

/* What the rows, then the columns, have not reached. */
static void fill(const disc_oracle *o, int direction, bool *hole) {
    bool *left = calloc((size_t)(o->width * o->height), sizeof *left);
    for (int y = 0; y < o->height && direction == 0; y++)
        for (int x = 0; x < o->width; x++)
            left[y * o->width + x] = line_of_holes(o, hole, 0, x, y);
    memcpy(hole, left, (size_t)(o->width * o->height) * sizeof *hole);
    free(left);
}

void disc_oracle_blur(const disc_oracle *o, long double *values) {
    const constants *m = model_of(o->quality);
    const int n = o->width * o->height;
    number *a = calloc((size_t)n, sizeof *a);
    long double *sum = calloc((size_t)n, sizeof *sum);
    bool *hole = calloc((size_t)n, sizeof *hole);
    for (int j = 0; j < m->components; j++) {
        if (o->hole) memcpy(hole, o->hole, (size_t)n * sizeof *hole);
        for (int i = 0; i < n; i++)
            a[i] = hole[i] ? 0 : values[i];
        for (int step = 0; step < m->substeps; step++)
            for (int direction = 0; direction < m->directions; direction++) {
                diffuse(o, m, j, direction, hole, a);
                fill(o, direction, hole);
            }
        for (int i = 0; i < n; i++)
            sum[i] += creall((m->weight[j][0] + m->weight[j][1] * I) * a[i]);
    }
    memcpy(values, sum, (size_t)n * sizeof *sum);
    free(a);
    free(sum);
    free(hole);
}

/* A link of conductance b in each of several steps adds 2 b to the variance; a diagonal adds it to both axes. */
long double disc_oracle_variance(ddof_quality quality, long double d) {
    const constants *m = model_of(quality);
    number sum = 0;
    for (int j = 0; j < m->components; j++)
        sum += (m->weight[j][0] + m->weight[j][1] * I) * total(m, j, d * d);
    return 2 * creall(sum);
}
