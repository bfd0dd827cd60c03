/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "steps.h"

/* s->v: the right-hand sides of row i after reduction with the rows `distance` away. */
static void reduce_x(const system_of *s, const level *l, reduction q, ptrdiff_t i, ptrdiff_t distance) {
    for (size_t rhs = 0; rhs < s->nrhs; rhs++)
        s->v[rhs] =
            fetch_x(s, l, i, rhs) + q.k1 * fetch_x(s, l, i - distance, rhs) + q.k2 * fetch_x(s, l, i + distance, rhs);
}

static reduction reduce_at(const system_of *s, const level *l, ptrdiff_t i, ptrdiff_t distance) {
    return reduce(fetch_row(s, l, i - distance), fetch_row(s, l, i), fetch_row(s, l, i + distance));
}

void REAL(reduce_step)(const system_of *s, const level *from, level *to) {
    for (size_t k = 0; k < to->n; k++) {
        const ptrdiff_t i = 2 * (ptrdiff_t)k + 1;
        const reduction q = reduce_at(s, from, i, 1);
        reduce_x(s, from, q, i, 1);
        store_row(s, to, k, q.r);
    }
}

void REAL(pcr_step)(const system_of *s, size_t distance, const level *from, level *to) {
    for (size_t i = 0; i < to->n; i++) {
        const reduction q = reduce_at(s, from, (ptrdiff_t)i, (ptrdiff_t)distance);
        reduce_x(s, from, q, (ptrdiff_t)i, (ptrdiff_t)distance);
        store_row(s, to, i, q.r);
    }
}

void REAL(substitute_step)(const system_of *s, const level *from, level *to) {
    for (size_t i = 0; i < to->n; i++) {
        const ptrdiff_t k = (ptrdiff_t)(i / 2); /* y_{i+1}, or y_i when i is odd */
        if (i % 2 == 1) {
            for (size_t rhs = 0; rhs < s->nrhs; rhs++)
                store_y(s, to, i, rhs, fetch_y(s, from, k, rhs));
            continue;
        }
        const row r = fetch_row(s, to, (ptrdiff_t)i);
        const real b = diagonal(r);
        for (size_t rhs = 0; rhs < s->nrhs; rhs++) {
            const real x = fetch_x(s, to, (ptrdiff_t)i, rhs);
            store_y(s, to, i, rhs, substitute(r, b, x, fetch_y(s, from, k - 1, rhs), fetch_y(s, from, k, rhs)));
        }
    }
}

void REAL(divide_step)(const system_of *s, const level *from, level *to) {
    for (size_t i = 0; i < to->n; i++) {
        const real b = diagonal(fetch_row(s, from, (ptrdiff_t)i));
        for (size_t rhs = 0; rhs < s->nrhs; rhs++)
            store_y(s, to, i, rhs, quotient(fetch_x(s, from, (ptrdiff_t)i, rhs), b));
    }
}

void REAL(solve_step)(const system_of *s, level *l) {
    row r[3];
    real b[3];
    if (l->n == 1) {
        REAL(divide_step)(s, l, l);
        return;
    }
    for (size_t i = 0; i < l->n; i++) {
        const row given = fetch_row(s, l, (ptrdiff_t)i);
        b[i] = diagonal(given);
        r[i] = normalised(given, b[i]);
    }
    for (size_t rhs = 0; rhs < s->nrhs; rhs++) {
        real x[3], y[3];
        for (size_t i = 0; i < l->n; i++)
            x[i] = quotient(fetch_x(s, l, (ptrdiff_t)i, rhs), b[i]);
        const real det = l->n == 2 ? solve_two(r, x, y) : solve_three(r, x, y);
        if (det == 0) solve_singular((int)l->n, r, x, y);
        for (size_t i = 0; i < l->n; i++)
            store_y(s, l, i, rhs, y[i]);
    }
}
