/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The classical methods, which gather: a pixel becomes a mean of pixels on lines through it (docs/methods.md). What is below is
 * one definition for all backends: cpu/gather.c and cpu/methods.c, shaders/include/gather.glsl and gl/methods.c.
 *
 * A line goes from column to column, or straight up or down from row to row; t counts these steps. A tap that falls between two rows is two
 * taps, with the shares of linear interpolation. Taps outside the picture do not count. CoC c is signed. How a tap q is blurred where it is
 * seen at p:
 *     over   c_q < -|c_p|: nearer than p and more blurred: it lies over p, as wide as its own CoC says      d = |c_q|
 *     else   it lies behind p, or p is more blurred: it is not wider than either of them                    d = min(|c_p|, |c_q|)
 * so what is sharp bleeds nowhere, and what is far does not spread over what is in focus. The result is sum(w q) / sum(w). With `size` of the
 * line, the steps that a CoC of 1 means:
 *     GAUSSIAN  to both sides; sigma = size d, reach = 2.5 sigma
 *               w = step exp(-t^2 / (2 sigma^2)) min(1, 1 / (sqrt(2 pi) sigma)) clamp((reach - t) / step + 1, 0, 1)
 *     BOX       to one side; reach = size d
 *               w = step clamp((reach - t) / step + 1/2, 0, 1) / max(1/2, reach), and step/2 / max(1/2, reach) at t = 0: boxes of opposite
 *               lines share that pixel
 * Every `step`th tap is looked at, the smallest power of two for which GATHER_TAPS - 1 of them are as long as the reach of |c_p|, or, for
 * taps over p, that of the nearest pixel of the picture; a reach never counts as longer than the picture.
 *
 * DDOF_METHOD_GAUSSIAN  GAUSSIAN along rows, then along columns, size 1/4: sigma is the standard deviation of the disc.
 * DDOF_METHOD_HEXAGON   its corners lie on the circle of the CoC, one of them at the top. BOX, as long as its sides: |CoC| / 2; U up, L to the
 *                       lower left, R to the lower right, 30 degrees below the horizontal.
 *                           V = U(picture)    X = (V + L(picture)) / 2    result = (L(V) + 2 R(X)) / 3
 *                       which is the rhombus of U and L and those of U and R and of L and R.
 * Where pixels are not square, a length along a row is pixel_aspect times as many rows. */
#ifndef DDOF_METHODS_H
#define DDOF_METHODS_H

#include "filled.h"

enum { GATHER_TAPS = 64 /* to one side, at most */ };
#define GAUSSIAN_REACH 2.5f /* standard deviations */

typedef struct gather_line {
    bool gaussian; /* else a box */
    float size;    /* of the kernel for a CoC of 1, in steps along the line */
    int dx;        /* columns of a step */
    float dy;      /* rows of a step */
    float longest; /* no reach is more */
    float over_step; /* for taps that lie over a pixel */
    int over_taps;
} gather_line;

/* How far a CoC reaches, as a multiple of size, and over how many steps its end fades. */
static inline float gather_reach(const gather_line *l) {
    return l->gaussian ? GAUSSIAN_REACH : 1.0f;
}
static inline float gather_edge(const gather_line *l) {
    return l->gaussian ? 1.0f : 0.5f;
}

/* The step for a CoC; how many taps there are. */
static inline float gather_step(const gather_line *l, float coc, int *taps) {
    float reach = gather_reach(l) * l->size * coc, step = 1;
    reach = reach < l->longest ? reach : l->longest;
    while (reach > (GATHER_TAPS - 1) * step) step *= 2;
    *taps = (int)(reach / step + gather_edge(l));
    return step;
}

/* The lines of a method. */
enum { LINE_ROW, LINE_COLUMN, GAUSSIAN_LINES };
enum { LINE_UP, LINE_LEFT, LINE_RIGHT, HEXAGON_LINES };
void gaussian_lines(gather_line line[GAUSSIAN_LINES], const frame_job *job, const filled_picture *picture);
void hexagon_lines(gather_line line[HEXAGON_LINES], const frame_job *job, const filled_picture *picture);

#endif
