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
    .fade = 6.5219,
    .component = {{0.0112865, 0.0081638, -0.0752629, 0.0858985, 1.508501, -1.846305},
                  {0, -0.0114327, -0.15, -0.16916, -0.508501, 0.0148006}},
};

static const disc_kernel best = {
    .components = 2,
    .directions = 4,
    .substeps = 2,
    .fade = 12,
    .component = {{0.0149647, -0.0068326, -0.064065, -0.0818118, 1.232821, 1.859031},
                  {0, -0.0130196, -0.15, -0.266684, -0.232821, 0.1087343}},
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
