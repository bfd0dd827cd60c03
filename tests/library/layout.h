/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Pictures in every arrangement of memory that a ddof_image can describe, and half floats by arithmetic. */
#ifndef TESTS_LIBRARY_LAYOUT_H
#define TESTS_LIBRARY_LAYOUT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <ddof/ddof.h>

typedef enum layout {
    LAYOUT_TIGHT,      /* interleaved, up to the last byte before a trap */
    LAYOUT_ALIGNED,    /* interleaved, rows on 64 bytes */
    LAYOUT_PADDED,     /* interleaved, rows an odd number of values apart */
    LAYOUT_OFFSET,     /* interleaved, one value off any alignment */
    LAYOUT_OFFSET_16,  /* interleaved, rows on 16 bytes but not on 32 */
    LAYOUT_BOTTOM_UP,  /* negative row stride */
    LAYOUT_MIRRORED,   /* negative pixel stride */
    LAYOUT_SPACED,     /* interleaved among other channels */
    LAYOUT_REVERSED,   /* ABGR */
    LAYOUT_PLANAR,     /* an array per channel */
    LAYOUT_LAST_APART, /* interleaved but for the last channel, which has its own memory */
    LAYOUT_ROWS_APART, /* a row of each channel in turn, as many codecs give them */
    LAYOUTS
} layout;

typedef struct stored {
    ddof_image image;
    unsigned char *memory;
    size_t bytes;
    layout arrangement;
} stored;

/* half: bit c set where channel c is DDOF_HALF. */
stored stored_make(layout arrangement, int width, int height, int channels, unsigned half);
void stored_free(stored *s);
/* From and to `step` floats a pixel, of which the image has the first channels. */
void stored_put(const stored *s, const float *values, int step);
void stored_get(const stored *s, float *values, int step);
/* Fails where a byte between the pixels was written. */
void assert_gaps_intact(const stored *s);

double half_value(uint16_t half);
/* To the nearest, ties to even. */
uint16_t half_nearest(double value);

#endif
