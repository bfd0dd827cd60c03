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
    .fade = 8.060688,
    .component = {{0.0098316, 0.0099269, -0.1043853, 0.0690196, 1.491419, -1.952798},
                  {0, -0.0098219, -0.15, -0.107426, -0.491419, -0.2848962}},
};

static const disc_kernel best = {
    .components = 2,
    .directions = 4,
    .substeps = 2,
    .fade = 12,
    .component = {{0.013551, -0.0101849, -0.1046951, -0.0798702, 1.266083, 1.407232},
                  {0, -0.0115604, -0.1435999, -0.1966454, -0.266083, -0.0206861}},
};

const disc_kernel *disc_kernel_pick(ddof_quality quality) {
    switch (quality) {
    case DDOF_QUALITY_DRAFT: return &draft;
    case DDOF_QUALITY_BEST: return &best;
    default: return &good;
    }
}

double disc_excess(const disc_kernel *kernel) {
    double offset = 0, beta = 0;
    for (int j = 0; j < kernel->components; j++) {
        const disc_component *c = &kernel->component[j];
        offset += c->weight_re * c->offset_re - c->weight_im * c->offset_im;
        beta += c->weight_re * c->beta_re - c->weight_im * c->beta_im;
    }
    return offset / beta;
}

disc_share disc_direction(const disc_kernel *kernel, int direction, double aspect) {
    const double a2 = aspect * aspect, n = kernel->substeps, diagonal = (a2 < 1 ? a2 : 1) / 4;
    if (kernel->directions == 2) return (disc_share){(direction == DISC_COLUMNS ? a2 : 1) / n, 0};
    if (direction >= DISC_DIAGONAL) return (disc_share){0, -diagonal / n};
    return (disc_share){(direction == DISC_COLUMNS ? a2 : 1) / n, 2 * diagonal / n};
}
