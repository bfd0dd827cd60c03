/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Stage `conductance`: from the CoC of two neighbouring pixels to the conductance of the link between them,
 *     beta = scale * min(|d_i|, |d_i+1|)^2      (Kass et al. 2006: the sharper pixel decides)
 * scale = 1/32 matches the variance of the lens's disc, 1 is the convention of the literature; both divided by the
 * number of substeps (docs/method.md). */
#ifndef DDOF_CPU_CONDUCTANCE_H
#define DDOF_CPU_CONDUCTANCE_H

#include "../coc_limits.h"
#include "vec.h"

/* |d|, limited; what is not a number counts as the limit: such a pixel is a hole and leaves the decision to its
 * neighbour. */
static inline vfloat coc_limited(vfloat magnitude) {
    return v_min(magnitude, v_set(COC_LIMIT));
}
static inline vfloat coc_magnitude(vfloat d) {
    return coc_limited(v_abs(d));
}

static inline vfloat conductance(vfloat d0, vfloat d1, vfloat scale) {
    vfloat d = v_min(d0, d1);
    return v_max(scale * (d * d), v_set(BETA_FLOOR));
}

/* A border link: nothing flows, for there is nothing beyond, not even out of a hole that hangs by the floor; and no
 * division below is 0/0 where a whole line is holes. */
#define BETA_BORDER 1e-30f

/* From a to b by t. Exact where t is 0 or 1 and where a = b, however far apart the two are (a + t (b - a) is not). */
static inline vfloat lerp(vfloat a, vfloat b, vfloat t) {
    return v_fma(t, b, v_remaining(a, t));
}

/* One pixel of the elimination (docs/method.md, section 3), in the form that neither cancels nor drifts: the unknowns
 * before a pixel are summed up by a mean m and the weight w with which it holds,
 *     w = g + w_before',   own = g/w,           m = lerp(m_before, x, own)
 *     keep = w/(w + beta), w' = w (1 - keep),   and back: y = lerp(y_next, m, keep)
 * with g the heat capacity, 1, or 0 for a hole. */
typedef struct elimination {
    vfloat own;  /* share of the pixel itself in the mean */
    vfloat keep; /* share of that mean in the solution; the rest is the next pixel's */
    vfloat rest; /* w', what the next pixel is reached by */
} elimination;

static inline elimination eliminate(vfloat rest, vfloat g, vfloat beta) {
    elimination e;
    vfloat w = g + rest;
    e.own = g / v_max(w, v_set(BETA_BORDER));
    e.keep = w / (w + beta);
    /* w (1 - keep) is keep beta: each where it is the one that rounds less */
    e.rest = v_select((vint)(e.keep < 0.5f), v_remaining(w, e.keep), e.keep * beta);
    return e;
}

#endif
