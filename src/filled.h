/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* A frame as plain floats without holes: premultiplied RGBA and signed CoC, what is not finite taken from around (fill.h). */
#ifndef DDOF_FILLED_H
#define DDOF_FILLED_H

#include "context.h"

typedef struct filled_picture {
    int width, height;
    float *rgba; /* rows without gaps; channels that are missing are 0 */
    float *coc;  /* limited to COC_LIMIT */
    float nearest; /* the largest |CoC| of what is nearer than the focus; 0: nothing is */
} filled_picture;

/* Scratch memory to fill holes with. */
size_t filled_bytes(const frame_job *job);

/* Makes it of job->frame->color and job->coc_source, in memory that is given. Counts the holes in the job, and `height` units
 * of progress. MEMORY when the caller's loop could not run, CANCELLED. */
ddof_status filled_load(ddof_context *ctx, frame_job *job, filled_picture *picture, void *scratch);

/* Runs rows(user, y0, y1) over bands of all rows, each by one worker; counts each row as a unit of progress. As above. */
ddof_status filled_rows(ddof_context *ctx, int height, void (*rows)(void *user, int y0, int y1), void *user);

#endif
