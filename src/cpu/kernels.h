/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The CPU engine's stages as one instruction set implements them. rows.c, columns.c and pixels.c are compiled
 * once per instruction set; engine.c picks a table and drives it.
 *
 * The engine works on a BLOCK of as many rows as the vectors have lanes: every row is solved, one row per lane, and the
 * column elimination of these rows follows at once, while they are in the cache. */
#ifndef DDOF_CPU_KERNELS_H
#define DDOF_CPU_KERNELS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <ddof/ddof.h>

#include "../lens.h"

enum {
    MAX_LANES = 16, /* rows of a block, at most */
    TILE = 64,      /* pixels; rows are handed from the row stage to the column stage in tiles of this width */
    PAD = 16        /* every scratch row is this many pixels longer, so that vectors may run over the end */
};

/* A block under work. Rows are RGBA float; rows beyond `count` repeat the last one and are not written. */
typedef struct cpu_block {
    int width, count;
    const float *pixel[MAX_LANES];   /* rows of the source */
    const float *coc[MAX_LANES];     /* their CoC, pixels */
    const float *coc_below;          /* CoC of the row below the block; NULL where there is none */
    const float *capacity;           /* heat capacity g, [x][lane]; NULL: 1 everywhere */
    float row_alive[MAX_LANES];      /* g of a row in the column stage: 0 when all of it was holes */
    float row_scale, column_scale;   /* conductance of d = 1 along rows and columns */
    float *mean;                     /* scratch: (width + PAD) * lanes * 4, [x][4][lane] */
    float *keep;                     /* scratch: (width + PAD) * lanes, [x][lane] */
    float *tile;                     /* scratch: lanes rows of TILE pixels */
    float carry[4][MAX_LANES];       /* row stage: the solution right of the tile */
} cpu_block;

/* The column elimination between blocks: what the rows above leave behind, for each column. */
typedef struct column_state {
    float *rest; /* the weight they reach the next row with */
    float *mean; /* their mean, RGBA */
} column_state;

/* Stage rows (rows.c). */
typedef struct row_kernels {
    /* Down: eliminates all rows of the block from left to right. False when a value was not finite: then the caller says
     * by `capacity` where the holes are, and calls again. */
    bool (*forward)(const cpu_block *block);
    /* Back: substitutes pixels [x0, x1) from right to left into block->tile. x0 is a multiple of TILE; the last tile comes
     * first, with a carry of zeros. */
    void (*backward)(cpu_block *block, int x0, int x1);
} row_kernels;

/* Stage columns (columns.c). */
typedef struct column_kernels {
    /* Down: takes block->tile through the elimination of the columns; writes the mean to out[row] and keep to keep[row], both
     * pointing at pixel x0. stream: past the caches; out and keep are then aligned to 64 bytes. */
    void (*down)(const cpu_block *block, const column_state *state, int x0, int x1, float *const *out, float *const *keep,
                 bool stream);
    /* Up, in place: row = lerp(below, row, keep), `count` pixels. */
    void (*up)(float *row, const float *keep, const float *below, int count);
} column_kernels;

/* Stages lens and input/output (pixels.c). */
typedef struct pixel_kernels {
    /* A row of depth values to signed CoC. x, y: position of its first pixel in the whole picture. */
    void (*lens)(const lens_curve *curve, const float *depth, float *coc, int count, int x, int y);
    void (*half_to_float)(const uint16_t *in, float *out, int count);
    void (*float_to_half)(const float *in, uint16_t *out, int count);
} pixel_kernels;

typedef struct cpu_kernels {
    const char *name;
    unsigned flag; /* DDOF_CPU_* */
    int lanes;
    const row_kernels *rows;
    const column_kernels *columns;
    const pixel_kernels *pixels;
} cpu_kernels;

extern const cpu_kernels cpu_kernels_baseline; /* always there; the others are picked in dispatch.c */

#endif
