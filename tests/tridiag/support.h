/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* What the tests of the tridiagonal solvers share: systems with a known solution, layouts in memory, one call for all
 * of them. */
#ifndef TESTS_TRIDIAG_SUPPORT_H
#define TESTS_TRIDIAG_SUPPORT_H

/* cmocka.h wants these before it. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <ddof/tridiag.h>

#define COUNT(array) (sizeof(array) / sizeof *(array))

typedef struct rng {
    uint64_t state;
} rng;

double rng_unit(rng *r); /* [0, 1), a multiple of 2^-24 */

typedef enum kind {
    DOMINANT,      /* any signs, |b| > |a| + |c|, not symmetric */
    M_MATRIX,      /* a, c <= 0, row sums down to 1e-3 of b, not symmetric */
    DIFFUSION_200, /* beta = d^2 of CoC 0 .. 200 */
    DIFFUSION_1E4, /* beta = d^2 of CoC up to 1e4, with sharp pixels */
    DIFFUSION_1E5, /* nothing below CoC 1e3: what ddof_render() limits CoC to */
    WIDE,          /* CoC 1000 everywhere: roundings add up along the line */
    HOLES,         /* half of the capacities 0, every link conducts */
    SOFT,          /* capacities 0 .. 1 */
    CUT,           /* holes and pixels that nothing is linked to */
    RAMP,          /* x rises from 0 to 1 along CoC 48 */
    KINDS
} kind;

extern const char *const kind_name[KINDS];

/* Tight arrays. All numbers but y can be held by a float. */
typedef struct problem {
    size_t count, n, nrhs;
    bool diffusion;
    double *a, *b, *c; /* of diffusion too, as the oracle sees them */
    double *beta, *g, *x;
    double *y;    /* the solution, by Thomas in long double */
    double range; /* of x for diffusion, of y otherwise: what errors are measured by */
} problem;

problem problem_make(kind which, size_t count, size_t n, size_t nrhs, rng *r);
void problem_free(problem *p);

typedef enum layout {
    TIGHT,
    IN_PLACE,
    RGBA,     /* gaps between rows */
    PLANAR,   /* right-hand sides apart */
    COLUMNS,  /* systems interleaved, in place */
    BACKWARD, /* negative strides */
    LAYOUTS
} layout;

/* Solves with numbers of 4 or 8 bytes in the given layout, checks that nothing but y was written, and returns the
 * solution as a tight array, to be freed. */
double *solve(const problem *p, ddof_tridiag_solver solver, size_t number_size, layout how, ddof_tridiag_cost *cost);

/* The largest error in units of the range. */
double error_of(const problem *p, const double *y);

#endif
