/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Where rows lie. Level 0 of a system is the caller's input and output, its rows made on the fly; other levels are
 * tables or packed records. Rows outside are those of an insulator, as the shaders have it. */
#ifndef DDOF_TRIDIAG_LEVEL_H
#define DDOF_TRIDIAG_LEVEL_H

#include <stdbool.h>
#include <stddef.h>

#include "pack.h"

/* One system of the batch with one group of its right-hand sides. */
typedef struct system_of {
    size_t n, nrhs;
    bool diffusion;
    const real *a, *b, *c; /* of a general system */
    const real *beta, *g;  /* of a diffusion system; g may be NULL: 1 */
    const real *x;
    real *y;
    ptrdiff_t row_stride, x_row_stride, x_rhs_stride;
    size_t pcr_size;
    char *scratch; /* what is left of the scratch memory */
    real *v;       /* nrhs numbers: a row's right-hand sides under way */
} system_of;

typedef struct level {
    size_t n;
    row *abc;            /* n; NULL: fetch from the system */
    real *x, *y;         /* n times nrhs; NULL likewise */
    record *packed;      /* n, instead of abc and x */
    uint16_t (*half)[4]; /* n, instead of y */
} level;

void *REAL(take)(system_of *s, size_t bytes);
level REAL(level_input)(const system_of *s);
level REAL(level_scratch)(system_of *s, size_t n); /* for coefficients and right-hand sides */
level REAL(level_table)(system_of *s, size_t n);   /* and solutions */
level REAL(level_packed)(system_of *s, size_t n);

static inline row input_row(const system_of *s, size_t i) {
    const ptrdiff_t at = (ptrdiff_t)i * s->row_stride;
    row r;
    if (s->diffusion) {
        r.a = i > 0 ? -s->beta[at - s->row_stride] : 0;
        r.c = i + 1 < s->n ? -s->beta[at] : 0;
        r.g = s->g ? s->g[at] : 1;
    } else {
        r.a = i > 0 ? s->a[at] : 0;
        r.c = i + 1 < s->n ? s->c[at] : 0;
        r.g = s->b[at] + (r.a + r.c);
    }
    return r;
}

static inline real input_x(const system_of *s, size_t i, size_t rhs) {
    const real x = s->x[(ptrdiff_t)i * s->x_row_stride + (ptrdiff_t)rhs * s->x_rhs_stride];
    if (!s->diffusion || !s->g) return x;
    const real g = s->g[(ptrdiff_t)i * s->row_stride];
    return g != 0 ? g * x : 0;
}

/* Row i of a level; i may lie outside. */
static inline row fetch_row(const system_of *s, const level *l, ptrdiff_t i) {
    const row outside = {0, 1, 0};
    if (i < 0 || (size_t)i >= l->n) return outside;
    return l->packed ? unpack_row(l->packed[i]) : l->abc ? l->abc[i] : input_row(s, (size_t)i);
}

static inline real fetch_x(const system_of *s, const level *l, ptrdiff_t i, size_t rhs) {
    if (i < 0 || (size_t)i >= l->n) return 0;
    if (l->packed) return unpack_x(l->packed[i], unpack_row(l->packed[i]), rhs);
    return l->x ? l->x[(size_t)i * s->nrhs + rhs] : input_x(s, (size_t)i, rhs);
}

static inline real fetch_y(const system_of *s, const level *l, ptrdiff_t i, size_t rhs) {
    if (i < 0 || (size_t)i >= l->n) return 0;
    if (l->half) return (real)half_value(l->half[i][rhs]);
    return l->y ? l->y[(size_t)i * s->nrhs + rhs] : s->y[i * s->x_row_stride + (ptrdiff_t)rhs * s->x_rhs_stride];
}

/* Stores row i and its right-hand sides, s->v. */
static inline void store_row(const system_of *s, level *l, size_t i, row r) {
    if (l->packed) {
        l->packed[i] = pack(r, s->v, s->nrhs);
        return;
    }
    l->abc[i] = r;
    for (size_t rhs = 0; rhs < s->nrhs; rhs++)
        l->x[i * s->nrhs + rhs] = s->v[rhs];
}

static inline void store_y(const system_of *s, level *l, size_t i, size_t rhs, real y) {
    if (l->half)
        l->half[i][rhs] = (uint16_t)half_bits((float)y);
    else if (l->y)
        l->y[i * s->nrhs + rhs] = y;
    else
        s->y[(ptrdiff_t)i * s->x_row_stride + (ptrdiff_t)rhs * s->x_rhs_stride] = y;
}

#endif
