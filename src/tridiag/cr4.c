/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The solver of Gruen 2011, section 8.2: the first step reduces 4:1 and the last solves 1:4, both from the input, so
 * that coefficients exist from quarter resolution down. */
#include "chain.h"
#include "solvers.h"

/* Listing 8.1. Rows are named by their distance to i, the row that stays: _ is minus. */
void REAL(initial_reduce4)(const system_of *s, const level *from, level *to) {
    for (size_t k = 0; k < to->n; k++) {
        const ptrdiff_t i = 4 * (ptrdiff_t)k + 3;

        /* Phase 1: gather. */
        row r[7];
        for (int j = 0; j < 7; j++)
            r[j] = fetch_row(s, from, i + j - 3);

        /* Phase 2: the 2:1 reductions around the previous, the current and the next row that stay for half a moment. */
        const reduction p = reduce(r[0], r[1], r[2]);
        const reduction c = reduce(r[2], r[3], r[4]);
        const reduction n = reduce(r[4], r[5], r[6]);

        /* Phase 3: one more. */
        const reduction q = reduce(p.r, c.r, n.r);
        for (size_t rhs = 0; rhs < s->nrhs; rhs++) {
            real x[7];
            for (int j = 0; j < 7; j++)
                x[j] = fetch_x(s, from, i + j - 3, rhs);
            const real x_p = x[1] + p.k1 * x[0] + p.k2 * x[2];
            const real x_c = x[3] + c.k1 * x[2] + c.k2 * x[4];
            const real x_n = x[5] + n.k1 * x[4] + n.k2 * x[6];
            s->v[rhs] = x_c + q.k1 * x_p + q.k2 * x_n;
        }
        store_row(s, to, k, q.r);
    }
}

/* Listing 8.2, without what it computes and does not use. */
void REAL(final_solve4)(const system_of *s, const level *from, level *to) {
    for (size_t k = 0; 4 * k < to->n; k++) {
        const ptrdiff_t i = 4 * (ptrdiff_t)k + 3;

        /* Phase 1: the row of half resolution between two known ones. */
        const row r_3 = fetch_row(s, to, i - 3), r_2 = fetch_row(s, to, i - 2), r_1 = fetch_row(s, to, i - 1);
        const reduction p = reduce(r_3, r_2, r_1);
        const real b_3 = diagonal(r_3), b_2 = diagonal(p.r), b_1 = diagonal(r_1);

        for (size_t rhs = 0; rhs < s->nrhs; rhs++) {
            const real x_3 = fetch_x(s, to, i - 3, rhs), x_1 = fetch_x(s, to, i - 1, rhs);
            const real x_p = fetch_x(s, to, i - 2, rhs) + p.k1 * x_3 + p.k2 * x_1;

            /* Phase 2: its unknown. */
            const real y_4 = fetch_y(s, from, (ptrdiff_t)k - 1, rhs), y0 = fetch_y(s, from, (ptrdiff_t)k, rhs);
            const real y_2 = substitute(p.r, b_2, x_p, y_4, y0);

            /* Phase 3: those beside it. */
            const real result[4] = {substitute(r_3, b_3, x_3, y_4, y_2), y_2, substitute(r_1, b_1, x_1, y_2, y0), y0};
            for (size_t j = 0; j < 4 && 4 * k + j < to->n; j++)
                store_y(s, to, 4 * k + j, rhs, result[j]);
        }
    }
}

static void cyclic_reduction4(system_of *s, level_maker make) {
    level chain[CHAIN];
    chain[0] = REAL(level_input)(s);
    if (s->n <= 3) {
        REAL(solve_step)(s, &chain[0]);
        return;
    }
    chain[1] = make(s, s->n / 4);
    REAL(initial_reduce4)(s, &chain[0], &chain[1]);
    const int last = reduce_chain(s, chain, 1, 3, make);
    REAL(solve_step)(s, &chain[last]);
    substitute_chain(s, chain, 1, last);
    REAL(final_solve4)(s, &chain[1], &chain[0]);
}

void REAL(cr4)(system_of *s) {
    cyclic_reduction4(s, REAL(level_table));
}

void REAL(cr4_pack)(system_of *s) {
    cyclic_reduction4(s, REAL(level_packed));
}
