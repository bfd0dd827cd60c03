/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* What both kernels' engines share: scratch memory, the rows of a block as the caller has them, and waiting for one
 * another. */
#ifndef DDOF_CPU_BLOCK_H
#define DDOF_CPU_BLOCK_H

#include <stdatomic.h>

#include "../context.h"
#include "../image.h"
#include "kernels.h"

enum { LINE = 64 /* bytes of a cache line */ };

/* Scratch memory is handed out in order; with a NULL base only sizes are counted. */
typedef struct arena {
    char *base;
    size_t used;
} arena;

void *arena_take(arena *a, size_t bytes);

/* A frame, and how its rows are read. */
typedef struct cpu_frame {
    ddof_context *ctx;
    frame_job *job;
    const cpu_kernels *k;
    int width, height, lanes;
    ddof_image source; /* strides resolved, alpha premultiplied: straight_in says what it is */
    const float *const *rows; /* job.source_rows, while the source is the job's */
    bool straight_in;
    bool source_direct; /* rows are used where they lie */
    bool coc_direct;
} cpu_frame;

/* Room for a block that cannot be used where it lies. */
typedef struct block_room {
    float *pixels;   /* lanes rows of width + PAD pixels */
    float *coc;      /* lanes + 1 rows of width + PAD values */
    float *capacity; /* where the holes are: (width + PAD + 1) * lanes */
} block_room;

int block_count(int height, int rows);
void block_room_take(block_room *room, arena *a, int width, int lanes);

/* CoC of row y, in the caller's memory where it is fit for that, else in `room`. */
const float *block_coc_row(const cpu_frame *f, int y, float *room);

/* Rows [y, y + count) of the source, and their CoC. */
void block_load_pixels(const cpu_frame *f, cpu_rows *in, const block_room *room, int y, int count);
void block_load_coc(const cpu_frame *f, cpu_rows *in, const block_room *room, int y);

/* Something in this block was not finite: copies its rows with zeros in the holes and says where they are. How many. */
int64_t block_find_holes(const cpu_frame *f, cpu_rows *in, const block_room *room);

/* Until `done` is at least `wanted`. False when the frame was cancelled. */
bool block_wait(const ddof_context *ctx, const atomic_int *done, int wanted);

#endif
