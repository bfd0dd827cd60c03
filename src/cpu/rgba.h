/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* A pixel as a vector of four, whatever the instruction set. */
#ifndef DDOF_CPU_RGBA_H
#define DDOF_CPU_RGBA_H

#include <string.h>

typedef float pixel __attribute__((vector_size(16)));

static inline pixel load(const float *p) {
    pixel v;
    memcpy(&v, p, sizeof v);
    return v;
}

static inline void store(float *p, pixel v) {
    memcpy(p, &v, sizeof v);
}

#endif
