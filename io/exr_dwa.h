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

/* Decodes lines `top` to `bottom` (in the file's coordinates; whole chunks for speed) of an EXR file in memory, of one
 * flat part with one level, into `count` of its channels, whose first samples are those at (x, y), the corner of the
 * data window. 0, or -1 with a reason. Thread-safety: any number of calls at once, also on the same file. */
int io_exr_dwa_decode(const void *file, size_t size, int x, int y, int top, int bottom, const io_exr_slice *slices,
                      int count, char *reason, size_t reason_size);

#ifdef __cplusplus
}
#endif

#endif
