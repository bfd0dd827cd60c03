/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Sprites drawn on the CPU: in bands of rows, each by one thread, the sprites of a pixel always in the same order. */
#ifndef DDOF_SCATTER_H
#define DDOF_SCATTER_H

#include "bokeh.h"

enum { SCATTER_BAND = 16 /* rows of the target */ };

typedef struct scatter_target {
    float *rgba;
    float *weight;        /* NULL: not wanted */
    ptrdiff_t row_stride; /* of rgba, bytes; weight is tight */
} scatter_target;

/* Masks a worker has made of the row of sprites under work. */
typedef struct scatter_masks {
    float *mask;
    int *made; /* by node, side and place: the row it was made for */
    float *spare;
    int row;
} scatter_masks;

typedef struct scatter {
    const ddof_context *ctx;
    const iris *iris;
    const float *coc;    /* of the picture, tight, signed */
    int width, height;   /* of the picture */
    int target_width, target_height;
    bool half, fringe;
    float middle_x, middle_y, per_diagonal, aspect; /* of the cat's eye: the whole picture's middle, in this one's pixels */
    scatter_target far, near; /* near: may be the same */
    int nodes;                /* that occur */
    int mask[IRIS_NODES + 1]; /* where a node's masks begin, floats */
    scatter_masks *worker;
} scatter;

/* Plans it: all but coc, the targets and the memory. */
void scatter_plan(scatter *s, const ddof_context *ctx, const frame_job *job, const bokeh_limits *limits);
/* The workers' memory; base NULL: only counts. Returns bytes. */
size_t scatter_take(scatter *s, void *base, int workers);

/* How many rows of the picture a sprite may reach above and below its own. */
int scatter_reach(const scatter *s, float largest);

/* Draws sprites of one row of the picture, `count` of them, on rows y0 to y1 - 1 of the target. */
void scatter_row(const scatter *s, int worker, const bokeh_sprite *sprite, int count, int y0, int y1);

#endif
