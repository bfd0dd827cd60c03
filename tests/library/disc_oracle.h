/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* What the disc kernel is, by school algebra in long double: docs/disc.md and disc.h written down once more, the matrix
 * of a direction of the whole picture at once, solved densely. Small pictures. Shares nothing with the library. */
#ifndef TESTS_LIBRARY_DISC_ORACLE_H
#define TESTS_LIBRARY_DISC_ORACLE_H

#include <stdbool.h>

#include <ddof/ddof.h>

typedef struct disc_oracle {
    int width, height;
    ddof_quality quality;
    long double aspect; /* of a pixel, width / height */
    const float *coc;   /* NaN where unknown: such a link follows the other end */
    const bool *hole;   /* NULL: none */
} disc_oracle;

/* One channel, width * height values, replaced by its blur. */
void disc_oracle_blur(const disc_oracle *o, long double *values);

/* Variance of what a point becomes on a plane of CoC d, along rows, pixels^2; along columns aspect^2 times that. */
long double disc_oracle_variance(ddof_quality quality, long double d);

#endif
