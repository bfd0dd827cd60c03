/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The public functions, for one number type: a batch, system by system. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "cost.h"
#include "solvers.h"

#define PUBLIC_JOIN(name, suffix) name##_##suffix
#define PUBLIC_NAME(name, suffix) PUBLIC_JOIN(name, suffix)
#define PUBLIC(name)              PUBLIC_NAME(name, DDOF_REAL_SUFFIX)

static void (*const solvers[DDOF_TRIDIAG_SOLVERS])(system_of *) = {
    [DDOF_TRIDIAG_THOMAS] = REAL(thomas),
    [DDOF_TRIDIAG_CR_VANILLA] = REAL(cr_vanilla),
    [DDOF_TRIDIAG_CR] = REAL(cr),
    [DDOF_TRIDIAG_CR_PACK] = REAL(cr_pack),
    [DDOF_TRIDIAG_CR4] = REAL(cr4),
    [DDOF_TRIDIAG_CR4_PACK] = REAL(cr4_pack),
    [DDOF_TRIDIAG_CR_PCR] = REAL(cr_pcr),
    [DDOF_TRIDIAG_PCR] = REAL(pcr),
    [DDOF_TRIDIAG_PCR3_SWEEP] = REAL(pcr3_sweep),
};

static ptrdiff_t stride_or(ptrdiff_t stride, size_t tight, ptrdiff_t of) {
    return stride ? stride : (ptrdiff_t)tight * (of < 0 ? -of : of);
}

/* One group of right-hand sides of one system. */
static void solve_group(system_of s, ddof_tridiag_solver solver, size_t first, size_t count, char *scratch) {
    s.x += (ptrdiff_t)first * s.x_rhs_stride;
    s.y += (ptrdiff_t)first * s.x_rhs_stride;
    s.nrhs = count;
    s.scratch = scratch;
    s.v = (real *)REAL(take)(&s, count * sizeof(real));
    solvers[solver](&s);
}

static void solve_all(const ddof_tridiag *batch, const system_of *pattern, char *scratch) {
    const size_t nrhs = pattern->nrhs, group = tridiag_packed(batch->solver) ? PACKED_GROUP : nrhs;
    const ptrdiff_t step = stride_or(batch->system_stride, batch->n, pattern->row_stride);
    const ptrdiff_t x_step = stride_or(batch->x_system_stride, batch->n, pattern->x_row_stride);
    for (size_t i = 0; i < batch->count; i++) {
        const ptrdiff_t at = (ptrdiff_t)i * step, x_at = (ptrdiff_t)i * x_step;
        system_of s = *pattern;
        const real **coefficients[] = {&s.a, &s.b, &s.c, &s.beta, &s.g};
        for (size_t k = 0; k < sizeof coefficients / sizeof *coefficients; k++)
            if (*coefficients[k]) *coefficients[k] += at;
        s.x += x_at;
        s.y += x_at;
        for (size_t first = 0; first < nrhs; first += group)
            solve_group(s, batch->solver, first, nrhs - first < group ? nrhs - first : group, scratch);
    }
}

/* Scratch memory for one system: what is stored, with every piece rounded up, and a row's right-hand sides. */
static void *get_scratch(const ddof_tridiag *batch, const ddof_tridiag_cost *cost, size_t nrhs) {
    enum { MOST_PIECES = 128 };
    const uint64_t bytes = (uint64_t)cost->bytes + nrhs * sizeof(real) + MOST_PIECES * scratch_round(1);
    if (bytes > PTRDIFF_MAX) return NULL;
    return batch->allocate ? batch->allocate(batch->memory_user, (size_t)bytes) : malloc((size_t)bytes);
}

static ddof_status solve_batch(const ddof_tridiag *batch, const system_of *given, ddof_tridiag_cost *cost) {
    system_of s = *given;
    ddof_tridiag_cost taken = tridiag_cost(batch, sizeof(real), NULL, 0);
    s.n = batch->n;
    s.nrhs = tridiag_nrhs(batch);
    s.pcr_size = tridiag_pcr_size(batch);
    s.row_stride = stride_or(batch->row_stride, 1, 1);
    s.x_rhs_stride = stride_or(batch->x_rhs_stride, 1, 1);
    s.x_row_stride = stride_or(batch->x_row_stride, s.nrhs, s.x_rhs_stride);
    void *scratch = get_scratch(batch, &taken, s.nrhs);
    if (!scratch) return DDOF_ERROR_MEMORY;
    solve_all(batch, &s, scratch);
    if (batch->release)
        batch->release(batch->memory_user, scratch);
    else
        free(scratch);
    if (cost) *cost = taken;
    return DDOF_OK;
}

ddof_status PUBLIC(ddof_tridiag_solve)(const ddof_tridiag *batch, const real *a, const real *b, const real *c,
                                       const real *x, real *y, ddof_tridiag_cost *cost) {
    const system_of s = {.a = a, .b = b, .c = c, .x = x, .y = y};
    if (cost) memset(cost, 0, sizeof *cost);
    if (ddof_tridiag_wrong(batch) || !a || !b || !c || !x || !y) return DDOF_ERROR_INVALID;
    return solve_batch(batch, &s, cost);
}

ddof_status PUBLIC(ddof_tridiag_diffuse)(const ddof_tridiag *batch, const real *beta, const real *g, const real *x,
                                         real *y, ddof_tridiag_cost *cost) {
    const system_of s = {.diffusion = true, .beta = beta, .g = g, .x = x, .y = y};
    if (cost) memset(cost, 0, sizeof *cost);
    if (ddof_tridiag_wrong(batch) || !beta || !x || !y) return DDOF_ERROR_INVALID;
    return solve_batch(batch, &s, cost);
}
