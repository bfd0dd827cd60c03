/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The yardstick of `ddof bench`: a copy of the picture in memory by the same number of threads. */
#ifndef TOOLS_BENCH_COPY_H
#define TOOLS_BENCH_COPY_H

#include <stddef.h>

typedef struct copy_crew copy_crew;

/* Threads that wait for copies; NULL when they cannot be had. */
copy_crew *copy_crew_create(int threads);
void copy_crew_destroy(copy_crew *crew);

/* One memcpy, or one per thread over equal parts. Returns milliseconds from the first thread's start to the last one's
 * end: waking the threads is not counted, which makes the yardstick as strict as it can be. */
double copy_crew_run(copy_crew *crew, void *to, const void *from, size_t bytes);

#endif
