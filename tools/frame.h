/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* One frame of a command, as a picture by itself or as one of a shot. */
#ifndef TOOLS_FRAME_H
#define TOOLS_FRAME_H

#include "json.h"
#include "options.h"
#include "session.h"

/* What there is to tell of it: members for --json, or lines for people. */
typedef struct frame_report {
    cJSON *object; /* NULL without --json */
    char *text;    /* NULL with --json, --quiet, or of a shot */
} frame_report;

/* Reads, works, writes, and fills a zeroed report. `start`: when the work began, in the time of now_ms(). Returns 0 or an exit
 * code. */
typedef int frame_work(const options *o, session *s, double start, frame_report *report);

/* The command on its one picture, or on all frames of a shot (tools/shot.c). Returns an exit code. */
int frame_run(const options *o, frame_work *work, double start);

#endif
