/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The focus distance as the median, in dioptres, of the depth in a region of the picture, and its mean over neighbouring
 * frames. Each frame's depth is measured once in a process, from its own file, whether the frame is rendered here or not.
 * Thread-safety: any threads. */
#ifndef TOOLS_AUTOFOCUS_H
#define TOOLS_AUTOFOCUS_H

#include "animate.h"

typedef struct autofocus autofocus;

/* `frames`: NULL for one picture; `keys`: NULL, or what else changes (ray depth needs the focal length). Both, and the options,
 * must outlive it. Returns 0 or an exit code; *result is NULL on failure. */
int autofocus_open(autofocus **result, const options *o, const sequence *frames, const animation *keys);
void autofocus_close(autofocus *a); /* NULL is allowed */

/* The distance to focus on, in the unit of the frame's depth; may be INFINITY. Returns 0 or an exit code. */
int autofocus_distance(autofocus *a, const frame_options *f, int frame, double *distance);

/* Sets --focus to it. Returns 0 or an exit code. */
int autofocus_apply(autofocus *a, frame_options *f, int frame);

#endif
