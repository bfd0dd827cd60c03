/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Stage rows of the disc kernel: rows.c with complex numbers. Coefficients are vectors of rows; pixels are vectors of
 * GROUP rows x RGBA, four to a column, once for the real and once for the imaginary parts. */
#include "complex.h"
#include "isa.h"
#include "row_load.h"

/* Magnitudes of LANES columns, [column][row]. */
static inline void load_magnitudes(const disc_block *b, int x, vfloat d[LANES]) {
    for (int i = 0; i < LANES; i++)
        d[i] = v_load(b->in.coc[i] + x);
    v_transpose(d);
}

typedef struct row_state {
    vcomplex rest;
    vcomplex mean[4];
} row_state;

static inline __attribute__((always_inline)) void row_step(row_state *s, vfloat g, vcomplex b, bool holes,
                                                           const vfloat re[4], const vfloat im[4], float *restrict mean,
                                                           float *restrict keep) {
    disc_elimination e = disc_eliminate(s->rest, g, b, holes);
    s->rest = e.rest;
    v_store(keep, e.keep.re);
    v_store(keep + LANES, e.keep.im);
#define STEP(k)                                                                                                        \
    s->mean[k] = im ? complex_lerp(s->mean[k], (vcomplex){re[k], im[k]}, EXPAND_COMPLEX(e.own, k))                     \
                    : complex_lerp_real(s->mean[k], re[k], EXPAND_COMPLEX(e.own, k))
    STEP(0), STEP(1), STEP(2), STEP(3);
#undef STEP
    for (int k = 0; k < 4; k++)
        v_store(mean + k * LANES, s->mean[k].re), v_store(mean + (4 + k) * LANES, s->mean[k].im);
}

/* GROUP columns from x, whose conductances to the right are b. */
static inline __attribute__((always_inline)) void forward_columns(const disc_block *b, row_state *s, int x,
                                                                  const vcomplex conductance[GROUP],
                                                                  bool complex_source, const float *capacity) {
    vfloat re[GROUP][4], im[GROUP][4];
    if (x % 4 == 0) {
        prefetch_rows(b->in.pixel, x, b->in.width);
        if (complex_source) prefetch_rows(b->imaginary, x, b->in.width);
    }
    load_columns(b->in.pixel, x, b->in.width, re);
    if (complex_source) load_columns(b->imaginary, x, b->in.width, im);
    for (int i = 0; i < GROUP; i++) {
        const ptrdiff_t at = (ptrdiff_t)(x + i) * LANES;
        vfloat g = capacity ? v_load(capacity + at) : v_set(1);
        row_step(s, g, conductance[i], capacity != NULL, re[i], complex_source ? im[i] : NULL, b->mean + 8 * at,
                 b->keep + 2 * at);
    }
}

static inline __attribute__((always_inline)) bool forward(const disc_block *block, const disc_link *to,
                                                          bool complex_source, const float *capacity) {
    const disc_block b = *block; /* copies, which stores to scratch cannot change */
    const disc_link link = *to;
    vfloat d[2][LANES];
    row_state s = {0};

    load_magnitudes(&b, 0, d[0]);
    for (int x0 = 0, now = 0; x0 < b.in.width; x0 += LANES, now = !now) {
        vfloat *here = d[now], *next = d[!now];
        load_magnitudes(&b, x0 + LANES, next);
        for (int j = 0; j < LANES; j += GROUP) { /* columns beyond the width too: their links conduct nothing */
            vcomplex conductance[GROUP];
            for (int i = 0; i < GROUP; i++)
                conductance[i] = disc_conductance(here[j + i], j + i + 1 < LANES ? here[j + i + 1] : next[0], &link);
            forward_columns(&b, &s, x0 + j, conductance, complex_source, capacity);
        }
    }
    /* what is not finite stays in the mean to the end of its row: one look there is enough */
    vint worst = {0};
    for (int k = 0; k < 4; k++)
        worst = v_max_bits(worst, v_abs(s.mean[k].re));
    int finite = 1;
    for (int i = 0; i < LANES; i++)
        finite &= worst[i] < 0x7f800000;
    return finite;
}

bool ISA(disc_forward)(const disc_block *b, const disc_link *link) {
    if (b->imaginary[0]) return forward(b, link, true, NULL);
    return b->in.capacity ? forward(b, link, false, b->in.capacity) : forward(b, link, false, NULL);
}

void ISA(disc_backward)(disc_block *b, int x0, int x1) {
    vcomplex y[4];
    for (int k = 0; k < 4; k++)
        y[k] = (vcomplex){v_load(b->carry[k]), v_load(b->carry[4 + k])};
    for (int x = x0 + (x1 - x0 - 1) / GROUP * GROUP; x >= x0; x -= GROUP) {
        vfloat re[4][GROUP], im[4][GROUP];
        for (int i = GROUP - 1; i >= 0; i--) {
            const float *mean = b->mean + (ptrdiff_t)(x + i) * 8 * LANES,
                        *at = b->keep + (ptrdiff_t)(x + i) * 2 * LANES;
            const vcomplex keep = {v_load(at), v_load(at + LANES)};
#define STEP(k)                                                                                                        \
    y[k] = complex_lerp(y[k], (vcomplex){v_load(mean + (k)*LANES), v_load(mean + (4 + (k)) * LANES)},                  \
                        EXPAND_COMPLEX(keep, k)),                                                                      \
    re[k][i] = y[k].re, im[k][i] = y[k].im
            STEP(0), STEP(1), STEP(2), STEP(3);
#undef STEP
        }
        for (int k = 0; k < 4; k++) {
            v_transpose_pixels(re[k]);
            v_transpose_pixels(im[k]);
            for (int i = 0; i < GROUP; i++) {
                const ptrdiff_t at = (ptrdiff_t)(k * GROUP + i) * TILE * 4 + 4 * (x - x0);
                v_store(b->tile_re + at, re[k][i]);
                v_store(b->tile_im + at, im[k][i]);
            }
        }
    }
    for (int k = 0; k < 4; k++)
        v_store(b->carry[k], y[k].re), v_store(b->carry[4 + k], y[k].im);
}
