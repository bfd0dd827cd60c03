/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Stage fill: what is not known of a picture is taken from what is known around it, from near by rather than from afar. */
#ifndef DDOF_FILL_H
#define DDOF_FILL_H

#include "context.h"

/* Of the caller's picture: interleaved floats, `channels` 1 or 4 of them, rows `stride` pixels apart. */
typedef struct fill_picture {
    float *value;
    const float *weight; /* how well a pixel is known: 0 not at all, 1 fully, between a mixture; same stride */
    int channels, width, height;
    ptrdiff_t stride;
} fill_picture;

/* Scratch memory for pictures up to that size. */
size_t fill_bytes(int channels, int width, int height);

/* Replaces value by weight * value + (1 - weight) * what lies around. A picture of which nothing is known becomes 0. Values
 * must be finite, also where the weight is 0. MEMORY when the caller's loop could not run, CANCELLED. */
ddof_status fill_unknown(ddof_context *ctx, const fill_picture *picture, void *scratch);

#endif
