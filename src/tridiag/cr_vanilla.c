/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Cyclic reduction (Hockney 1965) as Kass, Lefohn and Owens 2006 have it: all coefficients are constructed first, then
 * 2:1 down to one unknown and back. */
#include "chain.h"
#include "solvers.h"

static level construct(system_of *s) {
    level l = REAL(level_input)(s);
    row *abc = (row *)REAL(take)(s, s->n * sizeof(row));
    for (size_t i = 0; i < s->n; i++)
        abc[i] = input_row(s, i);
    l.abc = abc;
    return l;
}

void REAL(cr_vanilla)(system_of *s) {
    level chain[CHAIN];
    chain[0] = construct(s);
    const int last = reduce_chain(s, chain, 0, 1, REAL(level_table));
    REAL(solve_step)(s, &chain[last]);
    substitute_chain(s, chain, 0, last);
}
