/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Complex arithmetic of the disc kernel: the conductance of a link, and the elimination of conductance.h carried over.
 */
#ifndef DDOF_CPU_COMPLEX_H
#define DDOF_CPU_COMPLEX_H

#include "conductance.h"
#include "kernels.h"

typedef struct vcomplex {
    vfloat re, im;
} vcomplex;

/* B of disc.h and the floor, between pixels with CoC of magnitude d0, d1. A magnitude of -1 is a pixel that does not
 * exist: nothing is conducted to it, not even by the floor. */
static inline vcomplex disc_conductance(vfloat d0, vfloat d1, const disc_link *link) {
    const vfloat d = v_min(d0, d1), u = v_max(d, v_set(0)) * d, v = v_max(u, v_set(1));
    const vfloat share = u * v_fma(v_set(link->linear), v, v_set(link->constant)) / ((v + link->excess) * (v + link->fade));
    const vfloat floor = (vfloat)((vint)(d >= 0) & (vint)v_set((float)BETA_FLOOR));
    return (vcomplex){v_fma(share, v_fma(v_set(link->beta_re), v, v_set(link->offset_re)), floor),
                      share * v_fma(v_set(link->beta_im), v, v_set(link->offset_im))};
}

/* From a to b by t. Exact where t is 1. */
static inline vcomplex complex_lerp(vcomplex a, vcomplex b, vcomplex t) {
    vfloat re = v_fma(t.re, b.re, v_remaining(a.re, t.re)), im = v_fma(t.re, b.im, v_remaining(a.im, t.re));
    re = v_fma_minus(t.im, b.im, v_fma(t.im, a.im, re));
    im = v_fma(t.im, b.re, v_fma_minus(t.im, a.re, im));
    return (vcomplex){re, im};
}

/* The same to a real b. */
static inline vcomplex complex_lerp_real(vcomplex a, vfloat b, vcomplex t) {
    vfloat re = v_fma(t.re, b, v_remaining(a.re, t.re)), im = v_remaining(a.im, t.re);
    re = v_fma(t.im, a.im, re);
    im = v_fma(t.im, b, v_fma_minus(t.im, a.re, im));
    return (vcomplex){re, im};
}

#define EXPAND_COMPLEX(c, k) ((vcomplex){V_EXPAND((c).re, k), V_EXPAND((c).im, k)})

/* `elimination` of conductance.h, complex. Re w > 0 always, for Re(1 + b L) > 0 (docs/disc.md, stability). */
typedef struct disc_elimination {
    vcomplex own, keep, rest;
} disc_elimination;

/* 2^-e for a number of magnitude 2^e, by its exponent bits; exact, so scaling by it changes no result's bits. */
static inline vfloat power_to_one(vfloat magnitude) {
    return (vfloat)(0x7f000000 - ((vint)magnitude & 0x7f800000));
}

/* With n the lesser of w and b, p = n/(w + b): keep is p or 1 - p, and rest = w b/(w + b) is n (1 - p) either way, so
 * that nothing is rounded that is near 1. holes: g may be 0, and w then so small that its square is no float. */
static inline __attribute__((always_inline)) disc_elimination disc_eliminate(vcomplex rest, vfloat g, vcomplex b,
                                                                             bool holes) {
    disc_elimination e;
    vcomplex w = {g + rest.re, rest.im};
    vfloat square = v_fma(w.re, w.re, w.im * w.im);
    vfloat inverse = g / (holes ? v_max(square, v_set(1e-30f)) : square);
    e.own = (vcomplex){w.re * inverse, -w.im * inverse};

    vfloat back = v_set(1);
    if (holes) {
        const vfloat most = v_max(v_max(w.re, v_abs(w.im)), v_max(v_abs(b.re), v_abs(b.im)));
        const vfloat scale = power_to_one(most);
        w.re *= scale, w.im *= scale, b.re *= scale, b.im *= scale;
        square = v_fma(w.re, w.re, w.im * w.im);
        back = 1 / scale;
    }
    const vcomplex sum = {w.re + b.re, w.im + b.im};
    vfloat sum_square = v_fma(sum.re, sum.re, sum.im * sum.im);
    if (holes) sum_square = v_max(sum_square, v_set(1e-30f));
    const vfloat one_over = 1 / sum_square;
    const vint kept = (vint)(square < v_fma(b.re, b.re, b.im * b.im));
    const vcomplex n = {v_select(kept, w.re, b.re), v_select(kept, w.im, b.im)};
    const vcomplex p = {v_fma(n.re, sum.re, n.im * sum.im) * one_over,
                        v_fma_minus(n.re, sum.im, n.im * sum.re) * one_over};
    e.rest.re = v_fma(n.im, p.im, v_fma_minus(n.re, p.re, n.re));
    e.rest.im = v_fma_minus(n.re, p.im, v_fma_minus(n.im, p.re, n.im));
    if (holes) e.rest.re *= back, e.rest.im *= back;
    e.keep.re = v_select(kept, p.re, 1 - p.re);
    e.keep.im = v_select(kept, p.im, -p.im);
    return e;
}

#endif
