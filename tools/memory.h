/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* What a picture needs, against --max-memory. */
#ifndef TOOLS_MEMORY_H
#define TOOLS_MEMORY_H

#include "job.h"

/* When the headers are read, before any pixel is: decides whether large blocks go into files (scratch.h). Refuses limits
 * that nothing could be done in, and GPUs where the picture does not fit. `rewrite`: as for job_open. Returns 0 or an exit
 * code. */
int memory_plan(const job *j, const options *o, const session *s, const io_format *rewrite);

#endif
