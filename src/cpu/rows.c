/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Stage rows: one implicit step of heat diffusion along every row of a block, a row per vector lane.
 * Coefficients are vectors of rows; pixels are vectors of GROUP rows x RGBA, four to a column. */
#include "conductance.h"
#include "isa.h"

#define PREFETCH 64 /* pixels ahead: rows are separate streams, too many of them for the hardware's prefetchers */

/* GROUP columns of all rows, from rows to columns: out[j][k] is column j of the rows GROUP*k and up. */
static inline void load_columns(const cpu_block *b, int x, vfloat out[GROUP][4]) {
    for (int k = 0; k < 4; k++) {
        vfloat v[GROUP];
        for (int i = 0; i < GROUP; i++) v[i] = v_load(b->pixel[k * GROUP + i] + 4 * (ptrdiff_t)x);
        v_transpose_pixels(v);
        for (int j = 0; j < GROUP; j++) out[j][k] = v[j];
    }
}

/* The last columns, where a vector would run over the end of the row. */
static inline void load_columns_short(const cpu_block *b, int x, vfloat out[GROUP][4]) {
    float part[4 * GROUP] = {0};
    for (int k = 0; k < 4; k++) {
        vfloat v[GROUP];
        for (int i = 0; i < GROUP; i++) {
            memcpy(part, b->pixel[k * GROUP + i] + 4 * (ptrdiff_t)x, (size_t)(b->width - x) * 4 * sizeof(float));
            v[i] = v_load(part);
        }
        v_transpose_pixels(v);
        for (int j = 0; j < GROUP; j++) out[j][k] = v[j];
    }
}

/* Conductances of LANES links to the right, [column][row]; clears the lanes of `good` that saw a CoC not finite. */
static inline void load_conductance(const cpu_block *b, int x, vfloat beta[LANES], vint *good) {
    const vfloat scale = v_set(b->row_scale);
    int left = b->width - x;
    for (int i = 0; i < LANES; i++) {
        const float *d = b->coc[i] + x;
        float part[LANES + 1] = {0};
        if (left <= LANES) {
            memcpy(part, d, (size_t)left * sizeof(float));
            d = part;
        }
        vfloat magnitude = v_abs(v_load(d));
        *good &= (vint)(magnitude <= v_set(COC_LIMIT));
        beta[i] = conductance(v_min(magnitude, v_set(COC_LIMIT)), coc_magnitude(v_load(d + 1)), scale);
    }
    v_transpose(beta);
    if (left <= LANES) beta[left - 1] = v_set(BETA_BORDER);
}

typedef struct row_state {
    elimination e; /* of the pixel before, per row */
    vfloat u[4];   /* the pixel before, eliminated */
} row_state;

static inline __attribute__((always_inline)) void row_step(row_state *s, vfloat g, vfloat beta, const vfloat pixel[4],
                                                           float *restrict u, float *restrict c) {
    elimination e = eliminate(reaching(s->e, g), beta);
    vfloat a = s->e.beta * e.inverse;
    v_store(c, beta * e.inverse);
    s->u[0] = v_fma(V_EXPAND(a, 0), s->u[0], V_EXPAND(e.inverse, 0) * pixel[0]);
    s->u[1] = v_fma(V_EXPAND(a, 1), s->u[1], V_EXPAND(e.inverse, 1) * pixel[1]);
    s->u[2] = v_fma(V_EXPAND(a, 2), s->u[2], V_EXPAND(e.inverse, 2) * pixel[2]);
    s->u[3] = v_fma(V_EXPAND(a, 3), s->u[3], V_EXPAND(e.inverse, 3) * pixel[3]);
    for (int k = 0; k < 4; k++) v_store(u + k * LANES, s->u[k]);
    s->e = e;
}

static inline void prefetch_rows(const cpu_block *b, int x) {
    if (x + PREFETCH >= b->width) return;
    for (int i = 0; i < LANES; i++) __builtin_prefetch(b->pixel[i] + 4 * ((ptrdiff_t)x + PREFETCH));
}

/* Returns the lanes in which everything was finite. capacity NULL: no holes. */
static inline __attribute__((always_inline)) vint forward(const cpu_block *b, const float *capacity) {
    vint good = ~(vint){0};
    row_state s = {0};
    const int width = b->width;
    float *restrict u = b->u, *restrict c = b->c;

    s.e.inverse = v_set(1.0f);
    for (int x0 = 0; x0 < width; x0 += LANES) {
        vfloat beta[LANES];
        load_conductance(b, x0, beta, &good);
        for (int j = 0; j < LANES; j += GROUP) {
            vfloat pixel[GROUP][4];
            const int x = x0 + j;
            if (x >= width) break;
            if (x % 4 == 0) prefetch_rows(b, x);
            if (x + GROUP <= width)
                load_columns(b, x, pixel);
            else
                load_columns_short(b, x, pixel);
            for (int i = 0; i < GROUP; i++) {
                vfloat g = capacity ? v_load(capacity + (ptrdiff_t)(x + i) * LANES) : v_set(1.0f);
                row_step(&s, g, beta[j + i], pixel[i], u, c);
                u += 4 * LANES;
                c += LANES;
            }
        }
    }
    /* u carries anything not finite to the end of its row: one look there is enough */
    for (int k = 0; k < 4; k++) good &= (vint)(v_abs(s.u[k]) <= v_set(3.4e38f));
    return good;
}

static bool rows_forward(cpu_block *b) {
    vint good = b->capacity ? forward(b, b->capacity) : forward(b, NULL);
    int ok = 1;
    for (int i = 0; i < LANES; i++) ok &= good[i] != 0;
    return ok;
}

static void rows_backward(cpu_block *b, int x0, int x1) {
    vfloat y[4];
    for (int k = 0; k < 4; k++) y[k] = v_load(b->carry[k]);
    for (int x = x0 + (x1 - x0 - 1) / GROUP * GROUP; x >= x0; x -= GROUP) {
        vfloat v[4][GROUP];
        for (int i = GROUP - 1; i >= 0; i--) {
            const float *u = b->u + (ptrdiff_t)(x + i) * 4 * LANES;
            vfloat c = v_load(b->c + (ptrdiff_t)(x + i) * LANES);
            v[0][i] = y[0] = v_fma(V_EXPAND(c, 0), y[0], v_load(u));
            v[1][i] = y[1] = v_fma(V_EXPAND(c, 1), y[1], v_load(u + LANES));
            v[2][i] = y[2] = v_fma(V_EXPAND(c, 2), y[2], v_load(u + 2 * LANES));
            v[3][i] = y[3] = v_fma(V_EXPAND(c, 3), y[3], v_load(u + 3 * LANES));
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
