/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Stage rows: one implicit step of heat diffusion along every row of a block, a row per vector lane.
 * Coefficients are vectors of rows; pixels are vectors of GROUP rows x RGBA, four to a column. */
#include "conductance.h"
#include "isa.h"
#include "row_load.h"

/* Magnitudes of the CoC of LANES columns, [column][row]; zeros beyond the row's end. */
static inline void load_coc(const cpu_block *b, int x, vfloat d[LANES]) {
    const int left = b->in.width - x;
    for (int i = 0; i < LANES; i++) {
        if (left >= LANES) {
            d[i] = v_abs(v_load(b->in.coc[i] + x));
        } else {
            float part[LANES] = {0};
            if (left > 0) memcpy(part, b->in.coc[i] + x, (size_t)left * sizeof(float));
            d[i] = v_abs(v_load(part));
        }
    }
    v_transpose(d);
}

typedef struct row_state {
    vfloat rest;    /* weight that reaches the next pixel, per row */
    vfloat mean[4]; /* of the pixels so far, per row and channel */
} row_state;

static inline __attribute__((always_inline)) void row_step(row_state *s, vfloat g, vfloat beta, const vfloat pixel[4],
                                                           float *restrict mean, float *restrict keep) {
    elimination e = eliminate(s->rest, g, beta);
    s->rest = e.rest;
    v_store(keep, e.keep);
    s->mean[0] = lerp(s->mean[0], pixel[0], V_EXPAND(e.own, 0));
    s->mean[1] = lerp(s->mean[1], pixel[1], V_EXPAND(e.own, 1));
    s->mean[2] = lerp(s->mean[2], pixel[2], V_EXPAND(e.own, 2));
    s->mean[3] = lerp(s->mean[3], pixel[3], V_EXPAND(e.own, 3));
    for (int k = 0; k < 4; k++) v_store(mean + k * LANES, s->mean[k]);
}

/* GROUP columns from x, whose conductances to the right are beta. */
static inline __attribute__((always_inline)) void forward_columns(const cpu_block *b, row_state *s, int x,
                                                                  const vfloat beta[GROUP], const float *capacity) {
    vfloat pixel[GROUP][4];
    if (x % 4 == 0) prefetch_rows(b->in.pixel, x, b->in.width);
    load_columns(b->in.pixel, x, b->in.width, pixel);
    for (int i = 0; i < GROUP; i++) {
        ptrdiff_t at = (ptrdiff_t)(x + i) * LANES;
        vfloat g = capacity ? v_load(capacity + at) : v_set(1.0f);
        row_step(s, g, beta[i], pixel[i], b->mean + 4 * at, b->keep + at);
    }
}

/* Whether everything was finite. capacity NULL: no holes. */
static inline __attribute__((always_inline)) bool forward(const cpu_block *block, const float *capacity) {
    const cpu_block b = *block; /* a copy, which stores to scratch cannot change */
    const vfloat scale = v_set(b.row_scale);
    vfloat d[2][LANES];
    vint worst = {0};
    row_state s = {0};

    load_coc(&b, 0, d[0]);
    for (int x0 = 0, now = 0; x0 < b.in.width; x0 += LANES, now = !now) {
        vfloat *here = d[now], *next = d[!now];
        load_coc(&b, x0 + LANES, next);
        for (int j = 0; j < LANES; j += GROUP) {
            vfloat beta[GROUP];
            if (x0 + j >= b.in.width) break;
            for (int i = 0; i < GROUP; i++) {
                worst = v_max_bits(worst, here[j + i]);
                vfloat right = j + i + 1 < LANES ? here[j + i + 1] : next[0];
                beta[i] = conductance(coc_limited(here[j + i]), coc_limited(right), scale);
                if (x0 + j + i == b.in.width - 1) beta[i] = v_set(BETA_BORDER);
            }
            forward_columns(&b, &s, x0 + j, beta, capacity);
        }
    }
    /* what is not finite stays in the mean to the end of its row: one look there is enough */
    for (int k = 0; k < 4; k++) worst = v_max_bits(worst, v_abs(s.mean[k]));
    int finite = 1;
    for (int i = 0; i < LANES; i++) finite &= worst[i] < 0x7f800000;
    return finite;
}

static bool rows_forward(const cpu_block *b) {
    return b->in.capacity ? forward(b, b->in.capacity) : forward(b, NULL);
}

static void rows_backward(cpu_block *b, int x0, int x1) {
    vfloat y[4];
    for (int k = 0; k < 4; k++) y[k] = v_load(b->carry[k]);
    for (int x = x0 + (x1 - x0 - 1) / GROUP * GROUP; x >= x0; x -= GROUP) {
        vfloat v[4][GROUP];
        for (int i = GROUP - 1; i >= 0; i--) {
            const float *mean = b->mean + (ptrdiff_t)(x + i) * 4 * LANES;
            vfloat keep = v_load(b->keep + (ptrdiff_t)(x + i) * LANES);
            v[0][i] = y[0] = lerp(y[0], v_load(mean), V_EXPAND(keep, 0));
            v[1][i] = y[1] = lerp(y[1], v_load(mean + LANES), V_EXPAND(keep, 1));
            v[2][i] = y[2] = lerp(y[2], v_load(mean + 2 * LANES), V_EXPAND(keep, 2));
            v[3][i] = y[3] = lerp(y[3], v_load(mean + 3 * LANES), V_EXPAND(keep, 3));
        }
        for (int k = 0; k < 4; k++) {
            v_transpose_pixels(v[k]);
            for (int i = 0; i < GROUP; i++)
                v_store(b->tile + (ptrdiff_t)(k * GROUP + i) * TILE * 4 + 4 * (x - x0), v[k][i]);
        }
    }
    for (int k = 0; k < 4; k++) v_store(b->carry[k], y[k]);
}

const row_kernels ISA(row_kernels) = {rows_forward, rows_backward};
