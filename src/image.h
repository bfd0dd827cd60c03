/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Access to described images: single values, and spans of a row to and from RGBA float. */
#ifndef DDOF_IMAGE_H
#define DDOF_IMAGE_H

#include <stdbool.h>

#include <ddof/ddof.h>

#include "cpu/kernels.h"

/* Fills in the strides that were left 0. */
void image_resolve(ddof_image *image);

/* Four float channels interleaved, premultiplied: rows can be used as they are. Strides resolved. */
bool image_is_rgba(const ddof_image *image);
/* A float channel without gaps. */
bool plane_is_tight(const ddof_plane *plane);

static inline bool finite_value(float v) {
    return v - v == 0;
}

static inline void *image_at(const ddof_image *image, int channel, int x, int y) {
    const ddof_plane *p = &image->plane[channel];
    return (char *)p->data + p->row_stride * y + p->pixel_stride * x;
}

/* One value, as double. Strides resolved or not. */
double image_value(const ddof_image *image, int channel, int x, int y);
void image_set_value(const ddof_image *image, int channel, int x, int y, double value);

/* `count` values of one channel from (x, y) as floats, and back. */
void plane_load(const ddof_image *image, int channel, int x, int y, int count, float *out, const pixel_kernels *k);
void plane_store(const ddof_image *image, int channel, int x, int y, int count, const float *in,
                 const pixel_kernels *k);

/* `count` pixels from (x, y) as RGBA floats (missing channels 0), and back (missing channels dropped).
 * straight: colour is multiplied by alpha on the way in, divided on the way out. */
void span_load(const ddof_image *image, int x, int y, int count, float *rgba, bool straight, const pixel_kernels *k);
void span_store(const ddof_image *image, int x, int y, int count, const float *rgba, bool straight,
                const pixel_kernels *k);

#endif
