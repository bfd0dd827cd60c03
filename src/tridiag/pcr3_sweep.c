/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The hybrid of Shishkovtsov and Rege 2010: three steps of PCR make 8 interleaved systems, each solved by a serial
 * sweep that keeps its modified coefficients in a scratch pad. */
#include "solvers.h"
#include "steps.h"

enum { SYSTEMS = 8 };

void REAL(pcr3_sweep)(system_of *s) {
    level l = REAL(level_input)(s), table[2];
    const level *from = &l;
    int next = 0;
    for (size_t distance = 1; distance < SYSTEMS; distance *= 2) {
        if (distance <= 2) table[next] = REAL(level_scratch)(s, s->n);
        REAL(pcr_step)(s, distance, from, &table[next]);
        from = &table[next];
        next = !next;
    }
    real *pad = (real *)REAL(take)(s, s->n * sizeof(real));
    for (size_t first = 0; first < SYSTEMS; first++)
        REAL(sweep)(s, from, &l, first, SYSTEMS, pad);
}
