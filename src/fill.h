/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Stage fill: what is not known of a picture is taken from what is known around it, from near by rather than from afar. */
#ifndef DDOF_FILL_H
#define DDOF_FILL_H

#include "context.h"

/* A picture whose pixels are made as they are needed, which is twice: that costs less than keeping them. */
typedef struct fill_picture {
    int channels, width, height; /* channels: 1 or 4 */
    /* Writes `count` pixels of row y from x: interleaved values, finite also where the weight is 0; and how well a pixel is
     * known: 0 not at all, 1 fully, between a mixture. Any thread. */
    void (*load)(void *user, int x, int y, int count, float *value, float *weight);
    void *user;
    bool whole; /* all weights are 1 */
} fill_picture;

/* Scratch memory for pictures up to that size. */
size_t fill_bytes(int channels, int width, int height);

/* Writes weight * value + (1 - weight) * what lies around to `out`, whose rows are `stride` bytes apart. A picture of which
 * nothing is known becomes 0. A pixel is written after it was loaded for the last time. MEMORY when the caller's loop could
 * not run, CANCELLED. */
ddof_status fill_unknown(ddof_context *ctx, const fill_picture *picture, float *out, ptrdiff_t stride, void *scratch);

#endif
