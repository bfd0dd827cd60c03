/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The algebra of rows: a y_{i-1} + b y_i + c y_{i+1} = x, kept as (a, g, c) with the row's sum g = a + b + c. Why, says
 * ddof/tridiag.h: for diffusion, where a, c <= 0 <= g, no sum below has terms of different sign.
 * Compiled once for each number type; the shaders have the same names. */
#ifndef DDOF_TRIDIAG_ROW_H
#define DDOF_TRIDIAG_ROW_H

#ifndef DDOF_REAL
#error "compile with -DDDOF_REAL=float or double"
#endif
typedef DDOF_REAL real;

#define REAL_JOIN(name, type) tridiag_##name##_##type
#define REAL_NAME(name, type) REAL_JOIN(name, type)
#define REAL(name)            REAL_NAME(name, DDOF_REAL)

typedef struct row {
    real a, g, c;
} row;

static inline real diagonal(row r) {
    return r.g - r.a - r.c;
}

/* A pivot of 0 stands for the equation 0 = 0 and its unknown for 0. */
static inline real quotient(real p, real q) {
    return q != 0 ? p / q : 0;
}

/* Row i without the unknowns i-1 and i+1, and by how much its neighbours were added to it: x' = x + k1 x_p + k2 x_n. */
typedef struct reduction {
    row r;
    real k1, k2;
} reduction;

static inline reduction reduce(row p, row r, row n) {
    const real k1 = quotient(-r.a, diagonal(p)), k2 = quotient(-r.c, diagonal(n));
    const reduction result = {{k1 * p.a, r.g + k1 * p.g + k2 * n.g, k2 * n.c}, k1, k2};
    return result;
}

/* The unknown of a row whose diagonal is b and whose neighbours are known (equation 8.9 of Gruen 2011, corrected). */
static inline real substitute(row r, real b, real x, real y_p, real y_n) {
    return quotient(x - r.a * y_p - r.c * y_n, b);
}

/* A row times a factor, so that its diagonal b is 1: Cramer's products must not leave the range of floats. */
static inline row normalised(row r, real b) {
    const row scaled = {quotient(r.a, b), quotient(r.g, b), quotient(r.c, b)};
    return scaled;
}

/* Two rows with an unknown each, by Cramer's rule. The determinant b0 b1 - c0 a1 is written so that it
 * cannot cancel, and returned. */
static inline real solve_two(const row r[2], const real x[2], real y[2]) {
    const real b0 = r[0].g - r[0].c, b1 = r[1].g - r[1].a;
    const real det = r[0].g * b1 - r[0].c * r[1].g;
    y[0] = quotient(b1 * x[0] - r[0].c * x[1], det);
    y[1] = quotient(b0 * x[1] - r[1].a * x[0], det);
    return det;
}

/* Three of them. m12 and m01 are the minors of the lower and the upper two. */
static inline real solve_three(const row r[3], const real x[3], real y[3]) {
    const real a1 = r[1].a, a2 = r[2].a, c0 = r[0].c, c1 = r[1].c;
    const real b0 = r[0].g - c0, b2 = r[2].g - a2;
    const real m12 = (r[1].g - a1) * b2 - c1 * r[2].g;
    const real m01 = (r[1].g - c1) * b0 - a1 * r[0].g;
    const real det = r[0].g * m12 - c0 * (r[1].g * b2 - c1 * r[2].g);
    y[0] = quotient(m12 * x[0] - c0 * (b2 * x[1] - c1 * x[2]), det);
    y[1] = quotient(b0 * (b2 * x[1] - c1 * x[2]) - a1 * b2 * x[0], det);
    y[2] = quotient(m01 * x[2] - a2 * (b0 * x[1] - a1 * x[0]), det);
    return det;
}

/* For those Cramer's rule does not know (determinant 0, because holes are cut off from the rest): elimination, as in a
 * sweep. */
static inline void solve_singular(int n, const row *r, const real *x, real *y) {
    real share = 0, pivot[3];
    for (int i = 0; i < n; i++) {
        const real w = r[i].g - r[i].a * share;
        pivot[i] = w - r[i].c;
        share = quotient(w, pivot[i]);
        y[i] = quotient(i > 0 ? x[i] - r[i].a * y[i - 1] : x[i], pivot[i]);
    }
    for (int i = n - 2; i >= 0; i--)
        y[i] = y[i] - quotient(r[i].c, pivot[i]) * y[i + 1];
}

#endif
