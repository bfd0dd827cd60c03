/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The tridiagonal matrix algorithm of Thomas, 1949: one sweep down, one up.
 * Down goes reduction with the row before only; its sum w is kept, and x takes y's place. Up goes
 *     y_i = (x_i - c_i y_{i+1}) / (w_i - c_i),  written as  y_{i+1} + (x_i - w_i y_{i+1}) / (w_i - c_i):
 * where conductance is large the factor c/(w - c) is nearly -1, and n roundings of it would add up. */
#include "solvers.h"
#include "steps.h"

static void sweep_down(const system_of *s, const level *from, level *to, size_t first, size_t stride, real *pad) {
    real w = 0, pivot = 1;
    for (size_t i = first; i < from->n; i += stride) {
        const row r = fetch_row(s, from, (ptrdiff_t)i);
        const real k = quotient(-r.a, pivot);
        w = r.g + k * w;
        pivot = w - r.c;
        pad[i] = w;
        for (size_t rhs = 0; rhs < s->nrhs; rhs++) {
            const real before = i >= stride ? fetch_y(s, to, (ptrdiff_t)(i - stride), rhs) : 0;
            store_y(s, to, i, rhs, fetch_x(s, from, (ptrdiff_t)i, rhs) + k * before);
        }
    }
}

static void sweep_up(const system_of *s, const level *from, level *to, size_t first, size_t stride, const real *pad) {
    const size_t count = (from->n - first + stride - 1) / stride;
    for (size_t k = count; k-- > 0;) {
        const size_t i = first + k * stride;
        const real w = pad[i], pivot = w - fetch_row(s, from, (ptrdiff_t)i).c;
        for (size_t rhs = 0; rhs < s->nrhs; rhs++) {
            const real x = fetch_y(s, to, (ptrdiff_t)i, rhs), below = fetch_y(s, to, (ptrdiff_t)(i + stride), rhs);
            store_y(s, to, i, rhs, pivot != 0 ? below + (x - w * below) / pivot : 0);
        }
    }
}

void REAL(sweep)(const system_of *s, const level *from, level *to, size_t first, size_t stride, real *pad) {
    if (first >= from->n) return;
    sweep_down(s, from, to, first, stride, pad);
    sweep_up(s, from, to, first, stride, pad);
}

void REAL(thomas)(system_of *s) {
    level l = REAL(level_input)(s);
    real *pad = (real *)REAL(take)(s, s->n * sizeof(real));
    REAL(sweep)(s, &l, &l, 0, 1, pad);
}
