/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* What the disc kernel is, by school algebra in long double: the constants of docs/disc.md, each line a tridiagonal
 * matrix, the textbook's elimination. Shares nothing with the library. */
#ifndef TESTS_LIBRARY_DISC_ORACLE_H
#define TESTS_LIBRARY_DISC_ORACLE_H

#include <stdbool.h>

#include <ddof/ddof.h>

typedef struct disc_oracle {
    int width, height;
    ddof_quality quality;
    double aspect;    /* of a pixel, width / height */
    const float *coc; /* not a number where unknown: such a link follows the other end */
    const bool *hole; /* NULL: none */
} disc_oracle;

/* One channel, width * height values, replaced by its blur. */
void disc_oracle_blur(const disc_oracle *o, double *values);

#endif
