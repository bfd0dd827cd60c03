/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "support.h"

const char *gl_missing(void) {
    return gpu_missing(DDOF_BACKEND_GL);
}

ddof_context *gl_context(void) {
    return gpu_context(DDOF_BACKEND_GL);
}

static bool packs(ddof_solver solver) {
    return solver == DDOF_SOLVER_DEFAULT || solver == DDOF_SOLVER_CR_PACK || solver == DDOF_SOLVER_CR4_PACK;
}

double solver_tolerance(const ddof_settings *settings) {
    return settings->surface == DDOF_SURFACE_RGBA32F && !packs(settings->solver) ? 1e-4 : 2e-3;
}
