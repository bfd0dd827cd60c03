/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The hybrid of Zhang, Cohen and Owens 2010: 2:1 steps to a size that still keeps a machine busy, then PCR there. */
#include "chain.h"
#include "solvers.h"

void REAL(cr_pcr)(system_of *s) {
    level chain[CHAIN];
    chain[0] = REAL(level_input)(s);
    const int last = reduce_chain(s, chain, 0, s->pcr_size, REAL(level_table));
    REAL(pcr_solve)(s, &chain[last]);
    substitute_chain(s, chain, 0, last);
}
