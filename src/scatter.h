/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Sprites drawn on the CPU: in bands of rows, each by one thread, the sprites of a pixel always in the same order. */
#ifndef DDOF_SCATTER_H
#define DDOF_SCATTER_H

#include "bokeh.h"

enum { SCATTER_BAND = 16 /* rows of the target */ };

/* What is drawn into at a level. */
typedef struct scatter_target {
    float *rgba;
    float *weight;        /* NULL: not wanted */
    ptrdiff_t row_stride; /* of rgba, bytes; weight is tight */
} scatter_target;

typedef struct scatter_level {
    int width, height;
    scatter_target far, near; /* near: may be the same */
    int *begin, *end;         /* of what was drawn on each row, pixels; begin >= end: nothing */
} scatter_level;

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
    bool half, fringe;
    float middle_x, middle_y, per_diagonal, aspect; /* of the cat's eye: the whole picture's middle, in this one's pixels */
    int levels, first;                              /* the first is 1 where half */
    scatter_level level[BOKEH_LEVELS];
    float largest;            /* CoC of any channel, pixels */
    float radii;              /* iris_reach() */
    int nodes;                /* that occur */
    short reach[2][IRIS_NODES]; /* pixels from a sprite's middle to the ends of its masks, at level 0 and above */
    int mask[IRIS_NODES + 1]; /* where a node's masks begin, floats */
    scatter_masks *worker;
} scatter;

/* Plans it: all but coc, the targets and the memory. */
void scatter_plan(scatter *s, const ddof_context *ctx, const frame_job *job, const bokeh_limits *limits);
/* The workers' memory; base NULL: only counts. Returns bytes. */
size_t scatter_take(scatter *s, void *base, int workers);

/* How many rows of the picture a sprite may lie above and below what it is drawn on, at a level. */
int scatter_reach(const scatter *s, int level);

/* Draws those sprites of a row of the picture that belong to a level on rows y0 to y1 - 1 of it. */
void scatter_row(const scatter *s, int worker, int level, const bokeh_sprite *sprite, int count, int y0, int y1);

/* Adds the sums of level `first` and up to a row of the picture: of colour, and where not NULL of weight. */
void scatter_sum_row(const scatter *s, int first, bool near, int y, float *rgba, float *weight);

#endif
