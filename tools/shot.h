/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The frames of a shot: some at a time, each on a thread with a context of its own, so that one is decoded while another is
 * solved and a third encoded. Reports come in the order of the frames. */
#ifndef TOOLS_SHOT_H
#define TOOLS_SHOT_H

#include "frame.h"

/* Prints a line for each frame and one for all of them. Returns an exit code: that of the first frame that failed. */
int shot_run(const options *o, frame_work *work, double start);

#endif
