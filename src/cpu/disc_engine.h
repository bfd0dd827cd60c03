/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#ifndef DDOF_CPU_DISC_ENGINE_H
#define DDOF_CPU_DISC_ENGINE_H

#include "block.h"

/* cpu_scratch_bytes() and cpu_diffuse() of jobs with the disc kernel. */
size_t disc_scratch_bytes(const ddof_context *ctx, const frame_job *job);
ddof_status disc_diffuse(ddof_context *ctx, frame_job *job, void *scratch);

#endif
