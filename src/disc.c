/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The disc kernel's constants, found by bench/disc/fit.py; docs/disc.md says how, and what they reach. */
#include "disc.h"

static const disc_kernel draft = {
    .components = 1,
    .directions = 2,
    .substeps = 1,
    .fade = 0,
    .component = {{0.0146618, -0.0348723, 0.0197902, -0.1624852, 1, 0.4648333}},
};

static const disc_kernel good = {
    .components = 2,
    .directions = 4,
    .substeps = 1,
    .fade = 12,
    .component = {{0.0099893, 0.0095402, -0.0970743, 0.077204, 1.570337, -1.825557},
                  {0, -0.0106438, -0.15, -0.113635, -0.570337, -0.162695}},
};

static const disc_kernel best = {
    .components = 2,
    .directions = 4,
    .substeps = 2,
    .fade = 12,
    .component = {{0.0136778, -0.0088572, -0.1010171, -0.0848784, 1.278649, 1.576326},
                  {0, -0.0119912, -0.15, -0.1995637, -0.278649, 0.0207762}},
};

const disc_kernel *disc_kernel_pick(ddof_quality quality) {
    switch (quality) {
    case DDOF_QUALITY_DRAFT: return &draft;
    case DDOF_QUALITY_BEST: return &best;
    default: return &good;
    }
}

disc_share disc_direction(const disc_kernel *kernel, int direction, double aspect) {
    const double a2 = aspect * aspect, n = kernel->substeps, diagonal = (a2 < 1 ? a2 : 1) / 4;
    if (kernel->directions == 2) return (disc_share){(direction == DISC_COLUMNS ? a2 : 1) / n, 0};
    if (direction >= DISC_DIAGONAL) return (disc_share){0, -diagonal / n};
    return (disc_share){(direction == DISC_COLUMNS ? a2 : 1) / n, 2 * diagonal / n};
}
