/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Stage layers: takes the picture apart by depth, lets the backend diffuse each layer, and lays them over each other. */
#ifndef DDOF_LAYERS_H
#define DDOF_LAYERS_H

#include "context.h"

/* Whether this frame asks for the stage: layers, or a holdout mask, which needs its means. */
bool layers_wanted(const frame_job *job);

/* All scratch memory of such a frame, that of the backend included. */
size_t layers_scratch_bytes(const ddof_context *ctx, const frame_job *job);

/* In the place of backend.diffuse. */
ddof_status layers_diffuse(ddof_context *ctx, frame_job *job, void *scratch);

#endif
