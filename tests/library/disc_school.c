/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "disc_school.h"

#include <assert.h>
#include <complex.h>
#include <math.h>
#include <stdlib.h>

typedef long double complex number;

typedef struct constants {
    int components, directions, substeps;
    long double fade;
    double beta[2][2], offset[2][2], weight[2][2]; /* of each component, real and imaginary part */
} constants;

static const constants table[] = {
    {1, 2, 1, 0, {{0.0146618, -0.0348723}}, {{0.0197902, -0.1624852}}, {{1, 0.4648333}}},
    {2, 4, 1, 8.060688L,
     {{0.0098316, 0.0099269}, {0, -0.0098219}},
     {{-0.1043853, 0.0690196}, {-0.15, -0.107426}},
     {{1.491419, -1.952798}, {-0.491419, -0.2848962}}},
    {2, 4, 2, 12,
     {{0.013551, -0.0101849}, {0, -0.0115604}},
     {{-0.1046951, -0.0798702}, {-0.1435999, -0.1966454}},
     {{1.266083, 1.407232}, {-0.266083, -0.0206861}}},
};

static number of_parts(const double parts[2]) {
    return parts[0] + (long double)parts[1] * I;
}

static long double coc_of(float d) {
    return isfinite(d) ? fminl(fabsl((long double)d), 1e5L) : 1e5L;
}

/* What a link conducts to its side (0), to the row below (1) or along a diagonal (2). */
static number link(const constants *k, int component, int direction, long double aspect, float d0, float d1) {
    const long double d = fminl(coc_of(d0), coc_of(d1)), u = d * d, v = fmaxl(1, u), a2 = aspect * aspect;
    number beta = 0, offset = 0;
    for (int j = 0; j < k->components; j++) {
        beta += of_parts(k->weight[j]) * of_parts(k->beta[j]);
        offset += of_parts(k->weight[j]) * of_parts(k->offset[j]);
    }
    const number b = u * (of_parts(k->beta[component]) * v + of_parts(k->offset[component])) / (v + creall(offset) / creall(beta));
    const number diagonal = k->directions == 4 ? fminl(1, a2) * b * (v / (v + k->fade)) / 4 : 0;
    const number share = direction == 0 ? b - 2 * diagonal : direction == 1 ? a2 * b - 2 * diagonal : diagonal;
    return share / k->substeps + 1e-14L;
}

/* One implicit step along the line through the pixels at[0..count-1]: the pivot is w + b1, with w the weight of the pixel and all
 * before it, which holes between links of very different size do not cancel. */
static void solve_line(const int *at, int count, const number *links, const long double *g, number *x) {
    number *upper = malloc((size_t)count * sizeof *upper), before = 0, w = 0;
    assert(upper);
    for (int i = 0; i < count; i++) {
        const number b0 = i > 0 ? links[i - 1] : 0, b1 = i + 1 < count ? links[i] : 0;
        w = g[at[i]] + (i > 0 ? b0 * w / (w + b0) : 0);
        const bool empty = w + b1 == 0; /* the end of a line of holes */
        upper[i] = empty ? 0 : b1 / (w + b1);
        before = empty ? 0 : (g[at[i]] * x[at[i]] + b0 * before) / (w + b1);
        x[at[i]] = before;
    }
    for (int i = count - 2; i >= 0; i--) x[at[i]] += upper[i] * x[at[i + 1]];
    free(upper);
}

static void solve_direction(const disc_school *o, const constants *k, int component, int direction, const long double *g,
                            number *x) {
    static const int step[4][2] = {{1, 0}, {0, 1}, {1, 1}, {-1, 1}};
    const int dx = step[direction][0], dy = step[direction][1], most = o->width + o->height;
    int *at = malloc((size_t)most * sizeof *at);
    number *links = malloc((size_t)most * sizeof *links);
    assert(at && links);
    for (int y = 0; y < o->height; y++)
        for (int x0 = 0; x0 < o->width; x0++) {
            const int px = x0 - dx, py = y - dy;
            if (px >= 0 && px < o->width && py >= 0) continue; /* not the first pixel of its line */
            int count = 0;
            for (int i = x0, j = y; i >= 0 && i < o->width && j < o->height; i += dx, j += dy) at[count++] = j * o->width + i;
            for (int i = 0; i + 1 < count; i++)
                links[i] = link(k, component, direction < 2 ? direction : 2, o->aspect, o->coc[at[i]], o->coc[at[i + 1]]);
            solve_line(at, count, links, g, x);
        }
    free(links);
    free(at);
}

/* After the rows a hole is filled, unless all of its row was holes. */
static void fill_rows(const disc_school *o, long double *g) {
    for (int y = 0; y < o->height; y++) {
        long double *row = g + (size_t)y * (size_t)o->width, any = 0;
        for (int x = 0; x < o->width; x++) any = fmaxl(any, row[x]);
        for (int x = 0; x < o->width; x++) row[x] = any;
    }
}

void disc_school_blur(const disc_school *o, double *values) {
    const constants *k = &table[o->quality == DDOF_QUALITY_DRAFT ? 0 : o->quality == DDOF_QUALITY_BEST ? 2 : 1];
    const size_t n = (size_t)o->width * (size_t)o->height;
    number *x = malloc(n * sizeof *x);
    long double *g = malloc(n * sizeof *g), *sum = calloc(n, sizeof *sum);
    assert(x && g && sum);
    for (int j = 0; j < k->components; j++) {
        for (size_t i = 0; i < n; i++) {
            g[i] = !(o->hole && o->hole[i]);
            x[i] = g[i] > 0 ? (long double)values[i] : 0;
        }
        for (int s = 0; s < k->substeps; s++)
            for (int direction = 0; direction < k->directions; direction++) {
                solve_direction(o, k, j, direction, g, x);
                if (s == 0 && direction == 0) fill_rows(o, g);
                if (direction == 1)
                    for (size_t i = 0; i < n; i++) g[i] = 1;
            }
        for (size_t i = 0; i < n; i++) sum[i] += creall(of_parts(k->weight[j]) * x[i]);
    }
    for (size_t i = 0; i < n; i++) values[i] = (double)sum[i];
    free(sum);
    free(g);
    free(x);
}
