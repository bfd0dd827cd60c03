/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Stage `conductance`: from the CoC of two neighbouring pixels to the conductance of the link between them,
 *     beta = scale * min(|d_i|, |d_i+1|)^2      (Kass et al. 2006: the sharper pixel decides)
 * scale = 1/32 matches the variance of the lens's disc, 1 is the convention of the literature; both divided by the
 * number of substeps (docs/method.md). */
#ifndef DDOF_CPU_CONDUCTANCE_H
#define DDOF_CPU_CONDUCTANCE_H

#include "vec.h"

#define COC_LIMIT 1e5f /* pixels; beyond it a picture is one colour anyway, and float32 still holds every step */

/* Two pixels in focus, at least this: a hole between sharp neighbours must still be reached by them, and nothing else
 * can be told from zero (1 + 1e-20 == 1). */
#define BETA_FLOOR 1e-20f

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

/* A border link: nothing flows, for there is nothing beyond; and den below stays above 0 where a whole line is holes. */
#define BETA_BORDER BETA_FLOOR

/* One pixel of the elimination that cannot cancel (docs/method.md, section 3). With w what reaches this pixel from before
 * plus its own heat capacity g (1, or 0 for a hole):
 *     den = w + beta,  c = beta/den,  w' = g' + c w,  u = (g x + beta_before u_before)/den.
 * c w is `passed` * `inverse`, so that the chain from pixel to pixel is one fma, one addition, one division. */
typedef struct elimination {
    vfloat inverse; /* 1/den */
    vfloat passed;  /* beta w */
    vfloat beta;    /* of the link to the next pixel */
} elimination;

static inline elimination eliminate(vfloat w, vfloat beta) {
    return (elimination){1.0f / (w + beta), beta * w, beta};
}

static inline vfloat reaching(elimination e, vfloat g) {
    return v_fma(e.passed, e.inverse, g);
}

#endif
