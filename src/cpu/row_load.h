/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* RGBA pixels of LANES rows, from memory where they lie in rows to vectors in which they stand in columns. */
#ifndef DDOF_CPU_ROW_LOAD_H
#define DDOF_CPU_ROW_LOAD_H

#include <stdbool.h>
#include <stddef.h>

#include "vec.h"

#define PREFETCH 32 /* pixels ahead: a block reads more rows at once than the hardware follows streams */

/* The last columns, where a vector would run over the end of the row; zeros beyond it. */
static inline vfloat load_pixels_short(const float *pixel, int left) {
    float part[4 * GROUP] = {0};
    if (left > 0) memcpy(part, pixel, (size_t)left * 4 * sizeof(float));
    return v_load(part);
}

/* GROUP columns from x of all rows: out[j][k] is column j of the rows GROUP*k and up. */
static inline __attribute__((always_inline)) void load_columns(const float *const *row, int x, int width,
                                                               vfloat out[GROUP][4]) {
    const bool whole = x + GROUP <= width;
    for (int k = 0; k < 4; k++) {
        vfloat v[GROUP];
        for (int i = 0; i < GROUP; i++) {
            const float *pixel = row[k * GROUP + i] + 4 * (ptrdiff_t)x;
            v[i] = whole ? v_load(pixel) : load_pixels_short(pixel, width - x);
        }
        v_transpose_pixels(v);
        for (int j = 0; j < GROUP; j++)
            out[j][k] = v[j];
    }
}

static inline void prefetch_rows(const float *const *row, int x, int width) {
    if (x + PREFETCH >= width) return;
    for (int i = 0; i < LANES; i++)
        __builtin_prefetch(row[i] + 4 * ((ptrdiff_t)x + PREFETCH), 0, 2);
}

#endif
