/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Between the described images and a GPU's: rows pass through scratch memory, a few at a time, as premultiplied RGBA and
 * depth or CoC. */
#ifndef DDOF_STAGING_H
#define DDOF_STAGING_H

#include "context.h"

enum { STAGING_ROWS = 16 };

/* Scratch memory. */
typedef struct staging {
    float *pixels;  /* STAGING_ROWS rows of RGBA */
    float *map;     /* and of depth or CoC */
    uint16_t *half; /* rows of RGBA */
    float gain;     /* colours times this, a power of two, fill the range of half floats; 1 at first */
} staging;

/* As backend.scratch_bytes. */
size_t staging_bytes(const ddof_context *ctx, const frame_job *job);

/* Also fills in the strides of job->coc_source. */
staging staging_lay_out(frame_job *job, void *scratch);

/* Looks for the gain: reads the whole picture. */
void staging_find_gain(const ddof_context *ctx, const frame_job *job, staging *s);

/* Loads rows y .. y + rows - 1 into s->pixels, times the gain, and s->map; `half`: into s->half as well. Holes are counted
 * in the job, and their colours become infinities, which is how the shaders know them. */
void staging_load(const ddof_context *ctx, frame_job *job, const staging *s, int y, int rows, bool half);

/* The stage `coc`, as the CPU engine computes it: the bits that it hands back are the same, and reading values back from a
 * GPU would take longer than computing them. */
ddof_status staging_coc(ddof_context *ctx, frame_job *job, void *scratch);

/* Stores s->pixels, which are divided by the gain, as rows y .. y + rows - 1 of the output. */
void staging_store(const ddof_context *ctx, const frame_job *job, const staging *s, int y, int rows);

#endif
