/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "support.h"

double vulkan_tolerance(const scene *s, const ddof_settings *settings, double aspect) {
    if (settings->surface != DDOF_SURFACE_RGBA32F || settings->solver == DDOF_SOLVER_CR4_PACK) return 2e-3;
    return tolerance_of(s, settings, aspect);
}

void vulkan_fill_coc(float *coc, int width, int height, int pattern, rng *r) {
    fill_coc(coc, width, height, (coc_pattern)pattern, r);
}

const gpu_promise promise = {
    .backend = DDOF_BACKEND_VULKAN,
    .solvers = {DDOF_SOLVER_LINE, DDOF_SOLVER_PCR, DDOF_SOLVER_PCR3_SWEEP, DDOF_SOLVER_CR4_PACK},
    .solver_count = 4,
    .patterns = COC_PATTERNS,
    .fill_coc = vulkan_fill_coc,
    .tolerance = vulkan_tolerance,
    .coc_difference = 1e-5, /* the CoC is made by the GPU in the one case, by the CPU in the other */
    .step = GPU_STEP,
};
