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
    .fade = 6.6362,
    .component = {{0.0097026, 0.0085109, -0.0736597, 0.0836522, 1.598982, -2.07739},
                  {0, -0.0104698, -0.15, -0.1387213, -0.598982, -0.1699166}},
};

static const disc_kernel best = {
    .components = 2,
    .directions = 4,
    .substeps = 2,
    .fade = 12,
    .component = {{0.0135893, -0.0066307, -0.0552749, -0.0761667, 1.283361, 2.109098},
                  {0, -0.0122841, -0.15, -0.2371251, -0.283361, 0.0572824}},
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
