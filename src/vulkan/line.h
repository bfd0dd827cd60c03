/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* How the solver LINE cuts lines into pieces for threads. */
#ifndef DDOF_VULKAN_LINE_H
#define DDOF_VULKAN_LINE_H

#include <stdbool.h>

/* What the device offers. */
typedef struct line_limits {
    int workgroup; /* most threads, in one dimension */
    int shared_bytes;
    int subgroup;  /* size that can be asked for, with shuffles; 1: none */
    int subgroups; /* most in a workgroup */
} line_limits;

typedef struct line_plan {
    int k;         /* pixels of a thread */
    int workgroup; /* threads: those of a line times strip */
    int strip;     /* lines side by side in a workgroup */
    int subgroup;  /* 1: not used */
} line_plan;

/* For lines of up to `length` pixels, `strip` side by side where that can be. False: they are too long. Complex numbers
 * take twice the room. */
bool line_plan_make(line_plan *plan, const line_limits *limits, bool is_complex, int length, int strip);

#endif
