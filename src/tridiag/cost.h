/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* What solvers cost, from the sizes alone. Not compiled for a number type. */
#ifndef DDOF_TRIDIAG_COST_H
#define DDOF_TRIDIAG_COST_H

#include <stdbool.h>

#include <ddof/tridiag.h>

enum { PACKED_GROUP = 3, PCR_SIZE = 64 };

size_t tridiag_nrhs(const ddof_tridiag *batch);
size_t tridiag_pcr_size(const ddof_tridiag *batch);
bool tridiag_packed(ddof_tridiag_solver solver);

/* Of a batch that is right. Writes the unknowns of each step to `unknowns`, as far as `capacity` goes. */
ddof_tridiag_cost tridiag_cost(const ddof_tridiag *batch, size_t number_size, size_t *unknowns, size_t capacity);

#endif
