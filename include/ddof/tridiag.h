/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The tridiagonal solvers of the diffusion depth-of-field literature, for batches of systems: readable, exact about
 * what they compute and store, any number of unknowns. ddof_render() does not use them: it has a faster one.
 *
 *     float x[64 * 1000 * 3];     // 64 lines of 1000 pixels, RGB interleaved; overwritten by the result
 *     float beta[64 * 1000];      // conductance of the link from each pixel to the next
 *     ddof_tridiag batch = {.solver = DDOF_TRIDIAG_CR4_PACK, .count = 64, .n = 1000, .nrhs = 3};
 *     if (ddof_tridiag_diffuse_f(&batch, beta, NULL, x, x, NULL) != DDOF_OK) puts(ddof_tridiag_wrong(&batch));
 *
 * Two forms of system, for unknowns y_0 .. y_{n-1}:
 *
 *     solve      a_i y_{i-1} + b_i y_i + c_i y_{i+1} = x_i
 *     diffuse    -beta_{i-1} y_{i-1} + (g_i + beta_{i-1} + beta_i) y_i - beta_i y_{i+1} = g_i x_i
 *
 * solve: any coefficients; a_0 and c_{n-1} are not used.
 * diffuse: one implicit step of heat diffusion along a line with insulated ends, by conductances beta >= 0 of the links
 * (beta_{n-1} is not used) and heat capacities g >= 0. Kass, Lefohn and Owens 2006 have g = 1. g = 0 makes a hole,
 * which the neighbours fill; its x is not used.
 *
 * Numerics. Inside, a row is kept as (a, g, c) with its sum g = a + b + c, and b = g - a - c is derived. To reduce it:
 *
 *     k1 = -a_i / b_{i-1}    a' = k1 a_{i-1}    g' = g_i + k1 g_{i-1} + k2 g_{i+1}
 *     k2 = -c_i / b_{i+1}    c' = k2 c_{i+1}    x' = x_i + k1 x_{i-1} + k2 x_{i+1}
 *
 * For diffusion (a, c <= 0 <= g) no sum has terms of different sign, so nothing cancels: float stays within 1e-6 of the
 * range of x for beta up to 1e10. (THOMAS and PCR3_SWEEP add up roundings along the line: 1e-5 for 4000 unknowns, 5e-4
 * for a million of beta 1e10.) The textbook keeps b and computes b' = b + k1 c_{i-1} + k2 a_{i+1}; in float it has lost
 * all of g = 1 in the rounding of b when beta reaches 1e7. It is also why packing is harmless here: six bits less of g
 * are not six bits less of b. Prefer diffuse to solve where there is a choice: solve must form a + b + c first.
 *
 * No solver pivots. They are accurate where the matrix is diagonally dominant, |b| >= |a| + |c|. A pivot of exactly 0
 * (a line of holes; a singular matrix) counts as the equation 0 = 0 and its unknown as 0. NaN and infinity spread
 * within their system and nowhere else. Numbers between 1e-30 and 1e30 are safe in float.
 *
 * Packed solvers keep a, g, c as float with 17 mantissa bits and right-hand sides and solutions as binary16, whatever
 * the type of the call: results are within 2e-3 of the range. What is kept of x is x/g, for diffusion a weighted mean
 * of temperatures, which stays in their range (x itself where g = 0). x/g and y become infinite beyond 65504, so a
 * matrix whose row sums are tiny against its right-hand sides wants another solver.
 *
 * Thread-safety: any thread, no state is kept. Each call works alone; share a batch out by calling on parts of it.
 */
#ifndef DDOF_TRIDIAG_H
#define DDOF_TRIDIAG_H

#include <ddof/ddof.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum ddof_tridiag_solver {
    DDOF_TRIDIAG_THOMAS = 0,     /* one sweep down, one up; serial */
    DDOF_TRIDIAG_CR_VANILLA = 1, /* cyclic reduction 2:1 to one unknown, all coefficients stored */
    DDOF_TRIDIAG_CR = 2,         /* 2:1 to two or three unknowns; full-resolution coefficients made on the fly */
    DDOF_TRIDIAG_CR_PACK = 3,    /* the same, a row and three right-hand sides in 128 bits */
    DDOF_TRIDIAG_CR4 = 4,        /* first step 4:1 and last 1:4: half-resolution coefficients never stored either */
    DDOF_TRIDIAG_CR4_PACK = 5,   /* the same, packed */
    DDOF_TRIDIAG_CR_PCR = 6,     /* 2:1 to at most pcr_size unknowns, which PCR solves */
    DDOF_TRIDIAG_PCR = 7,        /* parallel cyclic reduction: every unknown in every step */
    DDOF_TRIDIAG_PCR3_SWEEP = 8, /* three steps of PCR, then a sweep over each of 8 interleaved systems */
    DDOF_TRIDIAG_SOLVERS = 9     /* how many there are */
} ddof_tridiag_solver;

/* A batch of systems of one size. Strides are in elements, may be negative; 0 means tight.
 *   coefficient of row i of system s:                 s * system_stride + i * row_stride
 *   right-hand side r of row i of system s, and y:    s * x_system_stride + i * x_row_stride + r * x_rhs_stride
 * Of a picture of interleaved RGBA whose RGB is blurred (nrhs = 3):
 *   rows       count = height, n = width, x_row_stride = 4
 *   columns    count = width, n = height, row_stride = width, system_stride = 1, x_row_stride = 4 * width,
 *              x_system_stride = 4 */
typedef struct ddof_tridiag {
    ddof_tridiag_solver solver;
    size_t count;            /* systems; may be 0 */
    size_t n;                /* unknowns in each, 1 to 2^26 */
    size_t nrhs;             /* right-hand sides of each, 1 to 65536; 0: 1. Packed solvers take them in groups of three,
                                with a chain of coefficients for each group */
    ptrdiff_t row_stride;    /* 0: 1 */
    ptrdiff_t system_stride; /* 0: n * |row_stride| */
    ptrdiff_t x_rhs_stride;  /* 0: 1 */
    ptrdiff_t x_row_stride;  /* 0: nrhs * |x_rhs_stride| */
    ptrdiff_t x_system_stride; /* 0: n * |x_row_stride| */
    size_t pcr_size;           /* CR_PCR: as many unknowns at most are left to PCR; 0: 64 */

    /* Memory for one system at a time, got once and released once in a call. Both or neither; default malloc/free.
     * `allocate` returns memory aligned to 64 bytes or NULL. */
    void *(*allocate)(void *user, size_t bytes);
    void (*release)(void *user, void *memory);
    void *memory_user;
    uint64_t reserved[4];
} ddof_tridiag;

/* What ONE system of a batch costs: exact, and the same whatever the values, as long as no pivot is 0. Operations leave
 * out what turns the input into rows, a + b + c or g x. */
typedef struct ddof_tridiag_cost {
    int steps;     /* parallel steps, each needing the one before: the passes of a GPU. Sweeps: one per unknown */
    uint64_t adds; /* additions and subtractions */
    uint64_t muls; /* multiplications */
    uint64_t divisions;
    uint64_t diagonal_adds; /* of `adds`: those that derive b = g - a - c; what the textbook form does not need */
    uint64_t rows;          /* rows of coefficients (a, g, c) stored */
    uint64_t x_rows;        /* rows of right-hand sides stored, nrhs numbers each */
    uint64_t y_rows;        /* rows of solutions stored beside the output, nrhs numbers each */
    uint64_t records;       /* packed rows stored, 16 bytes each; groups take turns in them */
    uint64_t half_rows;     /* rows of solutions stored as four halves, 8 bytes each; likewise */
    uint64_t numbers;       /* single numbers stored: the sweeps' sums of rows */
    size_t bytes;           /* all of these in memory */
    uint64_t reserved[4];   /* written as 0 */
} ddof_tridiag_cost;

typedef struct ddof_tridiag_info {
    const char *name;   /* as on the command line: "cr4+pack" */
    const char *title;  /* one line */
    const char *source; /* the paper */
} ddof_tridiag_info;

/* NULL when there is no such solver. The texts are constants. */
DDOF_API const ddof_tridiag_info *ddof_tridiag_about(ddof_tridiag_solver solver);

/* By its name; DDOF_TRIDIAG_SOLVERS when there is none such (or name is NULL). */
DDOF_API ddof_tridiag_solver ddof_tridiag_by_name(const char *name);

/* What is wrong with a batch: a sentence that names the member, or NULL when nothing is. A constant. */
DDOF_API const char *ddof_tridiag_wrong(const ddof_tridiag *batch);

/* What one system of the batch costs, in float (number_size 4) or double (8). Of the batch, only solver, n, nrhs and
 * pcr_size matter. Errors: INVALID. */
DDOF_API ddof_status ddof_tridiag_cost_of(const ddof_tridiag *batch, size_t number_size, ddof_tridiag_cost *cost);

/* How many unknowns each step works out or keeps: writes up to `capacity` numbers to `unknowns` (which may be NULL) and
 * returns how many steps there are; 0 for a batch that is wrong. */
DDOF_API size_t ddof_tridiag_steps(const ddof_tridiag *batch, size_t *unknowns, size_t capacity);

/* Solve every system of the batch. x and y have the same strides; y is x itself (in place) or overlaps nothing.
 * Coefficients are read only and must not overlap y. g may be NULL: 1 everywhere. cost may be NULL; it gets what one
 * system took, and is zeroed on failure. Errors: INVALID (see ddof_tridiag_wrong(); or a pointer is NULL), MEMORY; y is
 * untouched then. */
DDOF_API ddof_status ddof_tridiag_solve_f(const ddof_tridiag *batch, const float *a, const float *b, const float *c,
                                          const float *x, float *y, ddof_tridiag_cost *cost);
DDOF_API ddof_status ddof_tridiag_solve_d(const ddof_tridiag *batch, const double *a, const double *b, const double *c,
                                          const double *x, double *y, ddof_tridiag_cost *cost);
DDOF_API ddof_status ddof_tridiag_diffuse_f(const ddof_tridiag *batch, const float *beta, const float *g,
                                            const float *x, float *y, ddof_tridiag_cost *cost);
DDOF_API ddof_status ddof_tridiag_diffuse_d(const ddof_tridiag *batch, const double *beta, const double *g,
                                            const double *x, double *y, ddof_tridiag_cost *cost);

#ifdef __cplusplus
}
#endif

#endif
