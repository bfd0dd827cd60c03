/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#ifndef DDOF_CPU_ENGINE_H
#define DDOF_CPU_ENGINE_H

#include "../context.h"
#include "kernels.h"

size_t cpu_scratch_bytes(const ddof_context *ctx, const frame_job *job);
ddof_status cpu_diffuse(ddof_context *ctx, frame_job *job, void *scratch);
/* methods.c: gaussian and hexagon, and the scratch memory of both. */
ddof_status cpu_gaussian(ddof_context *ctx, frame_job *job, void *scratch);
ddof_status cpu_hexagon(ddof_context *ctx, frame_job *job, void *scratch);
size_t cpu_method_bytes(const frame_job *job);

ddof_status cpu_coc(ddof_context *ctx, frame_job *job, void *scratch);

/* The instruction sets of this machine and build, and the widest of them that the mask allows (dispatch.c). */
unsigned cpu_flags(void);
const cpu_kernels *cpu_kernels_pick(unsigned mask);

#endif
