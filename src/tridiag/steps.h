/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The parallel steps that solvers are made of; each is a pass of a GPU. */
#ifndef DDOF_TRIDIAG_STEPS_H
#define DDOF_TRIDIAG_STEPS_H

#include "level.h"

/* 2:1. Row k of `to` is row 2k + 1 of `from` without its neighbours. */
void REAL(reduce_step)(const system_of *s, const level *from, level *to);

/* 1:2. The unknowns of `to` from every second one, known on `from`; those with odd indices are copied. */
void REAL(substitute_step)(const system_of *s, const level *from, level *to);

/* 4:1 from the input: rows 4k + 3. */
void REAL(initial_reduce4)(const system_of *s, const level *from, level *to);

/* 1:4 to the output. */
void REAL(final_solve4)(const system_of *s, const level *from, level *to);

/* Every row without the neighbours `distance` away, so that those 2 distance away become its neighbours. */
void REAL(pcr_step)(const system_of *s, size_t distance, const level *from, level *to);

/* All unknowns of a level of rows without neighbours. */
void REAL(divide_step)(const system_of *s, const level *from, level *to);

/* The one, two or three unknowns of a level. */
void REAL(solve_step)(const system_of *s, level *l);

/* PCR from `l` on: down to rows without neighbours. */
void REAL(pcr_solve)(system_of *s, level *l);

/* Thomas over the rows first, first + stride ...; `pad`: a number for each row of the level, for their sums. */
void REAL(sweep)(const system_of *s, const level *from, level *to, size_t first, size_t stride, real *pad);

#endif
