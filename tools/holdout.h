/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The mask of --holdout. */
#ifndef TOOLS_HOLDOUT_H
#define TOOLS_HOLDOUT_H

#include <ddof/ddof.h>
#include <picture.h>

typedef struct holdout {
    io_picture *picture;
    float *converted; /* integers, as the library takes them */
    ddof_image image;
} holdout;

/* Reads FILE[:CHANNEL]; `in` is the file that ":CHANNEL" means, `like` the picture whose size it must have. Returns 0
 * or an exit code; holdout_close() is wanted either way. */
int holdout_read(holdout *h, const char *text, const char *in, const ddof_image *like, const io_options *reading);
void holdout_close(holdout *h);

#endif
