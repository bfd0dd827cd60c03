/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* What every report of `ddof bench` needs: medians, and where they were measured. */
#ifndef TOOLS_BENCH_REPORT_H
#define TOOLS_BENCH_REPORT_H

#include <stddef.h>

typedef struct spread {
    double least, quarter, median, three_quarters, most;
} spread; /* milliseconds */

/* Sorts the times. */
spread spread_of(double *times, int count);

void processor_name(char *name, size_t size);
const char *compiler_name(void);

#endif
