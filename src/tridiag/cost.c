/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* A walk over the steps each solver takes, counting what the functions of row.h, steps.c, cr4.c and thomas.c do in
 * them. The test `counts` runs these very functions on numbers that count. */
#include "cost.h"

typedef struct walk {
    ddof_tridiag_cost cost;
    size_t *unknowns, capacity;
    uint64_t nrhs; /* all of them: groups differ in nothing that is counted by right-hand side */
    uint64_t groups;
    bool packed;
} walk;

/* One step that works out `count` unknowns or rows. */
static void step(walk *w, size_t count) {
    if (w->unknowns && (size_t)w->cost.steps < w->capacity) w->unknowns[w->cost.steps] = count;
    w->cost.steps++;
}

/* Operations done `times` times for the coefficients ... */
static void per_row(walk *w, uint64_t times, uint64_t adds, uint64_t muls, uint64_t divisions) {
    w->cost.adds += w->groups * times * adds;
    w->cost.muls += w->groups * times * muls;
    w->cost.divisions += w->groups * times * divisions;
}

/* ... and for every right-hand side. */
static void per_x(walk *w, uint64_t times, uint64_t adds, uint64_t muls, uint64_t divisions) {
    w->cost.adds += w->nrhs * times * adds;
    w->cost.muls += w->nrhs * times * muls;
    w->cost.divisions += w->nrhs * times * divisions;
}

static void diagonals(walk *w, uint64_t times) {
    per_row(w, times, 2, 0, 0);
    w->cost.diagonal_adds += w->groups * times * 2;
}

static void reductions(walk *w, uint64_t times) {
    diagonals(w, 2 * times);
    per_row(w, times, 2, 4, 2);
    per_x(w, times, 2, 2, 0);
}

static void substitutions(walk *w, uint64_t times) {
    diagonals(w, times);
    per_x(w, times, 2, 2, 1);
}

/* Right-hand sides of packed rows are multiplied by g when fetched, divided by it when stored. */
static void fetched(walk *w, size_t from_rows, bool input) {
    if (w->packed && !input) per_x(w, from_rows, 0, 1, 0);
}

static void make_level(walk *w, size_t n) {
    if (w->packed) {
        w->cost.records += n;
        w->cost.half_rows += n;
        per_x(w, n, 0, 0, 1);
    } else {
        w->cost.rows += n;
        w->cost.x_rows += n;
        w->cost.y_rows += n;
    }
}

static void make_scratch(walk *w, size_t n) {
    w->cost.rows += n;
    w->cost.x_rows += n;
}

static void reduce_step(walk *w, size_t n, bool input) {
    const size_t m = n / 2;
    make_level(w, m);
    reductions(w, m);
    fetched(w, 3 * m - (n % 2 == 0), input);
    step(w, m);
}

static void substitute_step(walk *w, size_t n, bool input) {
    const size_t even = n - n / 2;
    substitutions(w, even);
    fetched(w, even, input);
    step(w, n);
}

static void divide_step(walk *w, size_t n, bool input) {
    diagonals(w, n);
    per_x(w, n, 0, 0, 1);
    fetched(w, n, input);
    step(w, n);
}

static void solve_step(walk *w, size_t n, bool input) {
    if (n == 1) {
        divide_step(w, n, input);
        return;
    }
    diagonals(w, n);
    per_row(w, n, 0, 0, 3);
    if (n == 2)
        per_x(w, 1, 5, 6, 2 + 2);
    else
        per_x(w, 1, 14, 21, 3 + 3);
    w->cost.diagonal_adds += w->nrhs * (n == 2 ? 2 : 4);
    fetched(w, n, input);
    step(w, n);
}

static void pcr_step(walk *w, size_t n) {
    reductions(w, n);
    step(w, n);
}

static void sweeps(walk *w, size_t n, size_t systems) {
    const size_t used = n < systems ? n : systems, longest = (n + systems - 1) / systems;
    w->cost.numbers += n;
    per_row(w, n, 3, 1, 1);
    w->cost.diagonal_adds += 2 * n;
    per_x(w, n, 3, 2, 1);
    for (size_t k = 0; k < longest; k++)
        step(w, k + 1 < longest ? used : n - k * systems);
    for (size_t k = longest; k-- > 0;)
        step(w, k + 1 < longest ? used : n - k * systems);
}

static void pcr_solve(walk *w, size_t n) {
    for (size_t distance = 1; distance < n; distance *= 2) {
        if (distance <= 2) make_scratch(w, n);
        pcr_step(w, n);
    }
    divide_step(w, n, true);
}

/* Down from a level of n unknowns until there are `few`, then PCR or a direct solve, and up again. */
static void cyclic_reduction(walk *w, size_t n, bool input, size_t few, bool pcr) {
    if (n > few) {
        reduce_step(w, n, input);
        cyclic_reduction(w, n / 2, false, few, pcr);
        substitute_step(w, n, input);
    } else if (pcr) {
        pcr_solve(w, n);
    } else {
        solve_step(w, n, input);
    }
}

static void cyclic_reduction4(walk *w, size_t n) {
    const size_t m = n / 4, blocks = (n + 3) / 4;
    if (n <= 3) {
        solve_step(w, n, true);
        return;
    }
    make_level(w, m);
    reductions(w, 4 * m);
    step(w, m);
    cyclic_reduction(w, m, false, 3, false);
    reductions(w, blocks);
    substitutions(w, 3 * blocks);
    step(w, n);
}

static void walk_solver(walk *w, const ddof_tridiag *batch) {
    const size_t n = batch->n;
    switch (batch->solver) {
    case DDOF_TRIDIAG_CR_VANILLA:
        w->cost.rows += n;
        step(w, n); /* construct */
        cyclic_reduction(w, n, true, 1, false);
        break;
    case DDOF_TRIDIAG_CR:
    case DDOF_TRIDIAG_CR_PACK:
        cyclic_reduction(w, n, true, 3, false);
        break;
    case DDOF_TRIDIAG_CR4:
    case DDOF_TRIDIAG_CR4_PACK:
        cyclic_reduction4(w, n);
        break;
    case DDOF_TRIDIAG_CR_PCR:
        cyclic_reduction(w, n, true, tridiag_pcr_size(batch), true);
        break;
    case DDOF_TRIDIAG_PCR:
        pcr_solve(w, n);
        break;
    case DDOF_TRIDIAG_PCR3_SWEEP:
        for (size_t distance = 1; distance < 8; distance *= 2) {
            if (distance <= 2) make_scratch(w, n);
            pcr_step(w, n);
        }
        sweeps(w, n, 8);
        break;
    default:
        sweeps(w, n, 1);
        break;
    }
}

size_t tridiag_nrhs(const ddof_tridiag *batch) {
    return batch->nrhs ? batch->nrhs : 1;
}

size_t tridiag_pcr_size(const ddof_tridiag *batch) {
    return batch->pcr_size ? batch->pcr_size : PCR_SIZE;
}

bool tridiag_packed(ddof_tridiag_solver solver) {
    return solver == DDOF_TRIDIAG_CR_PACK || solver == DDOF_TRIDIAG_CR4_PACK;
}

ddof_tridiag_cost tridiag_cost(const ddof_tridiag *batch, size_t number_size, size_t *unknowns, size_t capacity) {
    const size_t nrhs = tridiag_nrhs(batch);
    const bool packed = tridiag_packed(batch->solver);
    walk w = {.unknowns = unknowns,
              .capacity = capacity,
              .nrhs = nrhs,
              .packed = packed,
              .groups = packed ? (nrhs + PACKED_GROUP - 1) / PACKED_GROUP : 1};
    walk_solver(&w, batch);
    const ddof_tridiag_cost *c = &w.cost;
    w.cost.bytes = (size_t)((3 * c->rows + nrhs * (c->x_rows + c->y_rows) + c->numbers) * number_size +
                            16 * c->records + 8 * c->half_rows);
    return w.cost;
}
