/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "level.h"

#include "solvers.h"

void *REAL(take)(system_of *s, size_t bytes) {
    void *memory = s->scratch;
    s->scratch += scratch_round(bytes);
    return memory;
}

level REAL(level_input)(const system_of *s) {
    level l = {s->n, NULL, NULL, NULL, NULL, NULL};
    return l;
}

level REAL(level_scratch)(system_of *s, size_t n) {
    level l = {n, NULL, NULL, NULL, NULL, NULL};
    l.abc = (row *)REAL(take)(s, n * sizeof(row));
    l.x = (real *)REAL(take)(s, n * s->nrhs * sizeof(real));
    return l;
}

level REAL(level_table)(system_of *s, size_t n) {
    level l = REAL(level_scratch)(s, n);
    l.y = (real *)REAL(take)(s, n * s->nrhs * sizeof(real));
    return l;
}

level REAL(level_packed)(system_of *s, size_t n) {
    level l = {n, NULL, NULL, NULL, NULL, NULL};
    l.packed = (record *)REAL(take)(s, n * sizeof(record));
    l.half = (uint16_t(*)[4])REAL(take)(s, n * sizeof(*l.half));
    return l;
}
