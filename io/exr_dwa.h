/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* DWA through the OpenEXR C++ library: the C library has no such codec before version 3.3. */
#ifndef IO_EXR_DWA_H
#define IO_EXR_DWA_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct io_exr_slice {
    const char *name;
    int type; /* 0 uint, 1 half, 2 float, as in the file */
    int x_sampling, y_sampling, width;
    void *data; /* planar, tightly packed */
} io_exr_slice;

/* Decodes an EXR file in memory, of one flat part with one level, whose data window is width x height at (x, y), into
 * `count` of its channels. 0, or -1 with a reason. */
int io_exr_dwa_decode(const void *file, size_t size, int x, int y, int height, const io_exr_slice *slices, int count,
                      int threads, char *reason, size_t reason_size);

#ifdef __cplusplus
}
#endif

#endif
