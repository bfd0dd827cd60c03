/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The solvers, for each number type, and what the batch functions of that type need. */
#ifndef DDOF_TRIDIAG_SOLVERS_H
#define DDOF_TRIDIAG_SOLVERS_H

#include <stddef.h>

#include "level.h"

/* What each piece of scratch memory is rounded up to. */
static inline size_t scratch_round(size_t bytes) {
    return (bytes + 15) / 16 * 16;
}

void REAL(thomas)(system_of *s);
void REAL(cr_vanilla)(system_of *s);
void REAL(cr)(system_of *s);
void REAL(cr_pack)(system_of *s);
void REAL(cr4)(system_of *s);
void REAL(cr4_pack)(system_of *s);
void REAL(cr_pcr)(system_of *s);
void REAL(pcr)(system_of *s);
void REAL(pcr3_sweep)(system_of *s);

#endif
