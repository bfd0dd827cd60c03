/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The table of solvers, and the checks of a batch. */
#include <string.h>

#include "cost.h"

static const ddof_tridiag_info table[DDOF_TRIDIAG_SOLVERS] = {
    [DDOF_TRIDIAG_THOMAS] = {"thomas", "one sweep down, one up; serial", "Thomas 1949"},
    [DDOF_TRIDIAG_CR_VANILLA] = {"cr-vanilla", "2:1 to one unknown, all coefficients stored",
                                 "Kass, Lefohn, Owens 2006; Hockney 1965"},
    [DDOF_TRIDIAG_CR] = {"cr", "2:1 to two or three unknowns, full-resolution coefficients on the fly", "Gruen 2011"},
    [DDOF_TRIDIAG_CR_PACK] = {"cr+pack", "the same, a row and three right-hand sides in 128 bits", "Gruen 2011"},
    [DDOF_TRIDIAG_CR4] = {"cr4", "4:1, 2:1 to two or three unknowns, last step 1:4", "Gruen 2011"},
    [DDOF_TRIDIAG_CR4_PACK] = {"cr4+pack", "the same, a row and three right-hand sides in 128 bits", "Gruen 2011"},
    [DDOF_TRIDIAG_CR_PCR] = {"cr+pcr", "2:1 to a chosen size, PCR there", "Zhang, Cohen, Owens 2010"},
    [DDOF_TRIDIAG_PCR] = {"pcr", "every row reduced in every step", "Hockney, Jesshope 1981; Zhang, Cohen, Owens 2010"},
    [DDOF_TRIDIAG_PCR3_SWEEP] = {"pcr3+sweep", "three steps of PCR, a sweep over each of 8 interleaved systems",
                                 "Shishkovtsov, Rege 2010"},
};

const ddof_tridiag_info *ddof_tridiag_about(ddof_tridiag_solver solver) {
    return (unsigned)solver < DDOF_TRIDIAG_SOLVERS ? &table[solver] : NULL;
}

ddof_tridiag_solver ddof_tridiag_by_name(const char *name) {
    int solver = 0;
    while (solver < DDOF_TRIDIAG_SOLVERS && (!name || strcmp(table[solver].name, name) != 0))
        solver++;
    return (ddof_tridiag_solver)solver;
}

const char *ddof_tridiag_wrong(const ddof_tridiag *batch) {
    static const size_t most_n = (size_t)1 << 26, most_nrhs = 65536;
    if (!batch) return "batch is NULL";
    if (!ddof_tridiag_about(batch->solver)) return "batch.solver is none of ddof_tridiag_solver";
    if (batch->n < 1 || batch->n > most_n) return "batch.n must be 1 to 2^26";
    if (batch->nrhs > most_nrhs) return "batch.nrhs must be 0 (1) to 65536";
    if (!batch->allocate != !batch->release) return "batch.allocate and batch.release must both be given, or neither";
    for (size_t i = 0; i < sizeof batch->reserved / sizeof *batch->reserved; i++)
        if (batch->reserved[i]) return "batch.reserved must be 0";
    return NULL;
}

ddof_status ddof_tridiag_cost_of(const ddof_tridiag *batch, size_t number_size, ddof_tridiag_cost *cost) {
    if (!cost) return DDOF_ERROR_INVALID;
    memset(cost, 0, sizeof *cost);
    if (ddof_tridiag_wrong(batch) || (number_size != 4 && number_size != 8)) return DDOF_ERROR_INVALID;
    *cost = tridiag_cost(batch, number_size, NULL, 0);
    return DDOF_OK;
}

size_t ddof_tridiag_steps(const ddof_tridiag *batch, size_t *unknowns, size_t capacity) {
    if (ddof_tridiag_wrong(batch)) return 0;
    return (size_t)tridiag_cost(batch, sizeof(float), unknowns, capacity).steps;
}
