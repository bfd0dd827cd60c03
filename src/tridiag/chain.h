/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* What the solvers by cyclic reduction share: the chain of levels, each half as long as the one before. */
#ifndef DDOF_TRIDIAG_CHAIN_H
#define DDOF_TRIDIAG_CHAIN_H

#include "steps.h"

enum { CHAIN = 32 };

typedef level (*level_maker)(system_of *s, size_t n);

/* From chain[first] on, 2:1 until a level has at most `few` unknowns; returns that level's place. */
static inline int reduce_chain(system_of *s, level *chain, int first, size_t few, level_maker make) {
    int last = first;
    for (; chain[last].n > few; last++) {
        chain[last + 1] = make(s, chain[last].n / 2);
        REAL(reduce_step)(s, &chain[last], &chain[last + 1]);
    }
    return last;
}

/* From the solved chain[last] back to chain[first]. */
static inline void substitute_chain(const system_of *s, level *chain, int first, int last) {
    for (; last > first; last--)
        REAL(substitute_step)(s, &chain[last], &chain[last - 1]);
}

#endif
