/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Parallel cyclic reduction (Hockney and Jesshope 1981; Zhang, Cohen and Owens 2010): every row is reduced in every
 * step, which splits each system into two of half the size, until each is one row. */
#include "solvers.h"
#include "steps.h"

void REAL(pcr_solve)(system_of *s, level *l) {
    level table[2];
    const level *from = l;
    int next = 0;
    for (size_t distance = 1; distance < l->n; distance *= 2) {
        if (distance <= 2) table[next] = REAL(level_scratch)(s, l->n);
        REAL(pcr_step)(s, distance, from, &table[next]);
        from = &table[next];
        next = !next;
    }
    REAL(divide_step)(s, from, l);
}

void REAL(pcr)(system_of *s) {
    level l = REAL(level_input)(s);
    REAL(pcr_solve)(s, &l);
}
