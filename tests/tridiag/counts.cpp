/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

// The solvers' own sources on numbers that count: ddof_tridiag_cost_of() must say exactly what they do and store.
#include "counted.hpp"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <ddof/tridiag.h>

#define DDOF_REAL counted
#include "tridiag/cr.c"
#include "tridiag/cr4.c"
#include "tridiag/cr_pcr.c"
#include "tridiag/cr_vanilla.c"
#include "tridiag/level.c"
#include "tridiag/pcr.c"
#include "tridiag/pcr3_sweep.c"
#include "tridiag/steps.c"
#include "tridiag/thomas.c"

tally counted_tally;

static void (*const solvers[DDOF_TRIDIAG_SOLVERS])(system_of *) = {
    REAL(thomas),   REAL(cr_vanilla), REAL(cr),  REAL(cr_pack),    REAL(cr4),
    REAL(cr4_pack), REAL(cr_pcr),     REAL(pcr), REAL(pcr3_sweep),
};

static const size_t MOST_N = 300, MOST_NRHS = 7;

static size_t group_of(ddof_tridiag_solver solver, size_t nrhs) {
    return solver == DDOF_TRIDIAG_CR_PACK || solver == DDOF_TRIDIAG_CR4_PACK ? 3 : nrhs;
}

// Runs one solver; returns the bytes of scratch it took, rounded as it rounds.
static size_t run(ddof_tridiag_solver solver, size_t n, size_t nrhs, char *scratch) {
    static counted beta[MOST_N], x[MOST_N * MOST_NRHS];
    size_t taken = 0;
    for (size_t i = 0; i < n; i++)
        beta[i] = counted(1.0 + static_cast<double>(i % 5));
    for (size_t i = 0; i < n * nrhs; i++)
        x[i] = counted(0.5);
    counted_tally = tally();
    for (size_t first = 0; first < nrhs; first += group_of(solver, nrhs)) {
        counted v[MOST_NRHS];
        system_of s = system_of();
        s.n = n;
        s.nrhs = nrhs - first < group_of(solver, nrhs) ? nrhs - first : group_of(solver, nrhs);
        s.diffusion = true; // with g = 1: nothing is computed in turning input into rows
        s.beta = beta;
        s.x = x + first;
        s.y = x + first;
        s.row_stride = s.x_rhs_stride = 1;
        s.x_row_stride = static_cast<ptrdiff_t>(nrhs);
        s.pcr_size = 20;
        s.scratch = scratch;
        s.v = v;
        solvers[solver](&s);
        taken = static_cast<size_t>(s.scratch - scratch);
    }
    for (size_t i = 0; i < n * nrhs; i++)
        if (fabs(x[i].v - 0.5) > 1e-12) return 0; // a constant must stay one
    return taken;
}

// The same with every piece in multiples of 16 bytes, as scratch_round() has it, is at most 16 bytes for each more.
static bool matches(ddof_tridiag_solver solver, size_t n, size_t nrhs, char *scratch) {
    ddof_tridiag batch = ddof_tridiag();
    ddof_tridiag_cost cost;
    batch.solver = solver;
    batch.n = n;
    batch.nrhs = nrhs;
    batch.pcr_size = 20;
    if (ddof_tridiag_cost_of(&batch, sizeof(double), &cost) != DDOF_OK) return false;
    const size_t taken = run(solver, n, nrhs, scratch);
    const bool same = counted_tally.adds == cost.adds && counted_tally.muls == cost.muls &&
                      counted_tally.divisions == cost.divisions && taken >= cost.bytes && taken <= cost.bytes + 16 * 40;
    if (!same)
        printf("# n %zu, nrhs %zu: +%llu *%llu /%llu, %zu bytes; expected +%llu *%llu /%llu, %zu bytes\n", n, nrhs,
               counted_tally.adds, counted_tally.muls, counted_tally.divisions, taken,
               static_cast<unsigned long long>(cost.adds), static_cast<unsigned long long>(cost.muls),
               static_cast<unsigned long long>(cost.divisions), cost.bytes);
    return same;
}

int main() {
    char *scratch = static_cast<char *>(malloc(4 << 20));
    int failed = !scratch;
    printf("1..%d\n", static_cast<int>(DDOF_TRIDIAG_SOLVERS));
    for (int i = 0; scratch && i < DDOF_TRIDIAG_SOLVERS; i++) {
        const ddof_tridiag_solver solver = static_cast<ddof_tridiag_solver>(i);
        bool good = true;
        for (size_t n = 1; n <= MOST_N && good; n++)
            for (size_t nrhs = 1; nrhs <= MOST_NRHS && good; nrhs++)
                good = matches(solver, n, nrhs, scratch);
        printf("%s %d - %s does what its cost says\n", good ? "ok" : "not ok", i + 1, ddof_tridiag_about(solver)->name);
        failed |= !good;
    }
    free(scratch);
    return failed;
}
