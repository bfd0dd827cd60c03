/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* What of the lens changes from frame to frame: keyframes (--animate), and the focus found on a region (--autofocus). Both set
 * options of a frame before anything of it is opened, and depend on nothing but the frame's number and the files of the shot:
 * not on which frames this process works on. Thread-safety: pull_apply() on any threads. */
#ifndef TOOLS_PULL_H
#define TOOLS_PULL_H

#include "animate.h"
#include "autofocus.h"

typedef struct pull {
    animation *keys;  /* NULL without --animate */
    autofocus *focus; /* NULL without --autofocus */
} pull;

/* `frames`: NULL when the command works on one picture; else, like the options, it must outlive the pull. Returns 0 or an exit
 * code. */
int pull_open(pull *p, const options *o, const sequence *frames);
void pull_close(pull *p);

/* Returns 0 or an exit code. */
int pull_apply(const pull *p, frame_options *f);

#endif
