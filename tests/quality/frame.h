/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* What the programs of `make quality` share: pictures in memory, and the disc that a lens makes of a point. Test code:
 * simple, slow, and without a way back from an error. */
#ifndef QUALITY_FRAME_H
#define QUALITY_FRAME_H

#include <picture.h>

typedef struct frame {
    int width, height;
    float *rgb; /* interleaved, scene-linear; holes are black */
    float *coc; /* signed diameter in pixels, negative is near; NULL: not read */
} frame;

/* Ends the program, after a line on standard error. */
void die(const char *what, const char *which);
void *allocate(size_t count, size_t size); /* zeroed */

frame frame_read(const char *path, io_meaning meaning);
/* Of the same size. */
void frame_read_coc(frame *f, const char *path);
/* R G B: EXR as float, PNG of 16 bits. */
void frame_write(const frame *f, const char *path, io_meaning meaning);
void frame_free(frame *f);

/* How much of a pixel at this distance from the centre of a disc is covered, 0 to 1: the border is one pixel soft.
 * Below a diameter of 1 a disc is the pixel itself. */
static inline float disc_cover(float distance, float radius) {
    const float c = (radius > 0.5f ? radius : 0.5f) + 0.5f - distance;
    return c < 0 ? 0 : c > 1 ? 1 : c;
}

/* Sum of the covers of all pixels of a disc: a table of sixteenths of a pixel up to the radius given. */
float *disc_areas(float largest_radius);
static inline float disc_area(const float *areas, float radius) {
    const float at = radius * 16;
    const int i = (int)at;
    return areas[i] + (at - (float)i) * (areas[i + 1] - areas[i]);
}

void gather(const frame *in, float *out);  /* gather.c */
void scatter(const frame *in, float *out); /* scatter.c */

#endif
