/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The standard solver of Gruen 2011: coefficients of full resolution are computed on the fly and never stored, and 2:1
 * steps end at two or three unknowns, which Cramer's rule solves. */
#include "chain.h"
#include "solvers.h"

static void cyclic_reduction(system_of *s, level_maker make) {
    level chain[CHAIN];
    chain[0] = REAL(level_input)(s);
    const int last = reduce_chain(s, chain, 0, 3, make);
    REAL(solve_step)(s, &chain[last]);
    substitute_chain(s, chain, 0, last);
}

void REAL(cr)(system_of *s) {
    cyclic_reduction(s, REAL(level_table));
}

/* A row and its right-hand sides share a record (listing 8.3), solutions are halves. */
void REAL(cr_pack)(system_of *s) {
    cyclic_reduction(s, REAL(level_packed));
}
