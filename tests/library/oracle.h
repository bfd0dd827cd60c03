/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* What the blur is, by school algebra in long double: the heat step of every line written down as a matrix and solved.
 * Shares nothing with the library. */
#ifndef TESTS_LIBRARY_ORACLE_H
#define TESTS_LIBRARY_ORACLE_H

#include <stdbool.h>

typedef enum oracle_solver {
    ORACLE_THOMAS, /* the textbook's elimination of a tridiagonal matrix: no holes, loses digits as CoC^2 grows */
    ORACLE_NETWORK /* the whole matrix, without cancellation: holes and any CoC, short lines */
} oracle_solver;

typedef struct oracle {
    int width, height;
    oracle_solver solver;
    long double scale; /* conductance of d = 1, all substeps together: 1/32 or 1 */
    int substeps;
    long double aspect; /* of a pixel, width / height */
    const float *coc;   /* NaN where unknown: such a link follows the other end */
    const bool *hole;   /* NULL: none */
} oracle;

/* One channel, width * height values, replaced by its blur. */
void oracle_blur(const oracle *o, long double *values);

#endif
