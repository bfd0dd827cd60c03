/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Stage `lens`: from depth and lens to the signed circle of confusion, in pixels.
 *
 * Every depth kind is turned into q = 1/z, every lens into one curve over q, in float64, once a frame; what is left to do
 * per pixel is the same for all:
 *     coc = gain_far (q_far - q) where q < q_far,  gain_near (q_near - q) where q > q_near,  0 between, limited.
 * With q_far = q_near = 1/s and gain = (f/N) f s/(s - f) W/sensor this is the thin lens, in the form that keeps its
 * precision near the focus and needs no special case at infinity. */
#ifndef DDOF_LENS_H
#define DDOF_LENS_H

#include <ddof/ddof.h>

typedef struct lens_curve {
    ddof_depth_kind kind;
    float offset, slope;       /* NORMALIZED: z = offset + slope v; DEVICE: q = offset + slope v */
    float x_center, y_center;  /* RAY: the optical axis, in pixels of the picture */
    float x_tangent, y_tangent; /* RAY: tangent of the angle a pixel spans at the axis */
    float q_far, q_near, gain_far, gain_near;
    float limit_far, limit_near; /* pixels, > 0 */
} lens_curve;

/* q_near for shaders, which need not know infinities: such a limit is out of every depth's reach. */
static inline float lens_q_near(const lens_curve *curve) {
    return curve->q_near < 3e38f ? curve->q_near : 3e38f;
}

/* 1/z of one value of the depth image, at (x, y) in the picture; NaN for what makes a hole. */
double lens_inverse_depth(const lens_curve *curve, double value, double x, double y);

/* Signed CoC of an inverse depth. */
double lens_coc(const lens_curve *curve, double q);

/* What is wrong with lens and depth (a sentence without full stop that names the member and the remedy), or NULL. */
const char *lens_check(const ddof_lens *lens, const ddof_depth *depth);

/* The part of the curve that turns values into q. */
void lens_curve_depth(lens_curve *curve, const ddof_frame *frame, const ddof_settings *settings);

/* The rest, for a focus distance. */
void lens_curve_focus(lens_curve *curve, const ddof_frame *frame, const ddof_lens *lens, double focus_distance);

/* Whether this lens can focus at this distance: NULL, or what is wrong. */
const char *lens_check_focus(const ddof_lens *lens, double focus_distance);

#endif
