/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "lens.h"

#include <math.h>
#include <stdbool.h>

#include "coc_limits.h"

static double sensor_width(const ddof_lens *lens) {
    return lens->sensor_width > 0 ? lens->sensor_width : 36;
}

static double focal_length(const ddof_lens *lens) { /* in scene units */
    return lens->focal_length / (lens->unit > 0 ? lens->unit : 1000);
}

static double picture_width(const ddof_frame *frame) {
    if (frame->picture_width > 0) return frame->picture_width;
    return frame->depth.channels ? frame->depth.width : frame->coc.width;
}

static double picture_height(const ddof_frame *frame) {
    if (frame->picture_height > 0) return frame->picture_height;
    return frame->depth.channels ? frame->depth.height : frame->coc.height;
}

static bool positive(double v) {
    return isfinite(v) && v > 0;
}

static bool optional(double v) {
    return isfinite(v) && v >= 0;
}

static const char *check_depth(const ddof_lens *lens, const ddof_depth *depth) {
    const double a = depth->z_at_0, b = depth->z_at_1;
    switch (depth->kind) {
    case DDOF_DEPTH_PLANAR:
    case DDOF_DEPTH_INVERSE: return NULL;
    case DDOF_DEPTH_RAY:
        return positive(lens->focal_length) ? NULL : "lens.focal_length must be above 0 millimetres for ray depth";
    case DDOF_DEPTH_NORMALIZED:
        if (!positive(a) || !positive(b) || a == b)
            return "depth.z_at_0 and depth.z_at_1 must be finite, above 0 and different for normalised depth";
        return NULL;
    case DDOF_DEPTH_DEVICE:
        if (!(a > 0) || !(b > 0) || a == b)
            return "depth.z_at_0 and depth.z_at_1 must be above 0 and different for device depth (one may be infinite)";
        return NULL;
    }
    return "depth.kind is none of ddof_depth_kind";
}

const char *lens_check_focus(const ddof_lens *lens, double s) {
    if (!(s > 0)) return "the focus distance must be above 0";
    if (lens->kind == DDOF_LENS_ARTIST) return isfinite(s) ? NULL : "the focus distance must be finite for artist controls";
    if (!(s > focal_length(lens)))
        return "the focus distance lies inside the focal length: focus farther away, or check the scene's unit";
    return NULL;
}

const char *lens_check(const ddof_lens *lens, const ddof_depth *depth) {
    for (size_t i = 0; i < sizeof lens->reserved / sizeof *lens->reserved; i++)
        if (lens->reserved[i]) return "lens.reserved must be 0";
    for (size_t i = 0; i < sizeof depth->reserved / sizeof *depth->reserved; i++)
        if (depth->reserved[i]) return "depth.reserved must be 0";
    if (lens->kind != DDOF_LENS_THIN && lens->kind != DDOF_LENS_ARTIST) return "lens.kind is none of ddof_lens_kind";
    if (!optional(lens->sensor_width)) return "lens.sensor_width must be above 0 millimetres";
    if (!optional(lens->unit)) return "lens.unit must be above 0 millimetres";
    if (!optional(lens->in_focus_range)) return "lens.in_focus_range must be 0 or above";
    if (!optional(lens->limit_near)) return "lens.limit_near must be 0 or above";
    if (!optional(lens->limit_far)) return "lens.limit_far must be 0 or above";
    if (lens->kind == DDOF_LENS_THIN) {
        if (!positive(lens->focal_length)) return "lens.focal_length must be above 0 millimetres";
        if (!positive(lens->f_number)) return "lens.f_number must be above 0";
    } else {
        if (!optional(lens->max_coc_near)) return "lens.max_coc_near must be 0 or above";
        if (!optional(lens->max_coc_far)) return "lens.max_coc_far must be 0 or above";
    }
    if (lens->focus == DDOF_FOCUS_DISTANCE) {
        const char *wrong = lens_check_focus(lens, lens->focus_distance);
        if (wrong) return wrong;
    } else if (lens->focus != DDOF_FOCUS_PIXEL) {
        return "lens.focus is none of ddof_focus_kind";
    }
    return check_depth(lens, depth);
}

void lens_curve_depth(lens_curve *curve, const ddof_frame *frame, const ddof_settings *settings) {
    const ddof_depth *depth = &settings->depth;
    const double aspect = frame->pixel_aspect > 0 ? frame->pixel_aspect : 1;
    *curve = (lens_curve){.kind = depth->kind};
    if (depth->kind == DDOF_DEPTH_NORMALIZED) {
        curve->offset = (float)depth->z_at_0;
        curve->slope = (float)(depth->z_at_1 - depth->z_at_0);
    } else if (depth->kind == DDOF_DEPTH_DEVICE) {
        curve->offset = (float)(1 / depth->z_at_0);
        curve->slope = (float)(1 / depth->z_at_1 - 1 / depth->z_at_0);
    } else if (depth->kind == DDOF_DEPTH_RAY) {
        double pixel = sensor_width(&settings->lens) / picture_width(frame) / settings->lens.focal_length;
        curve->x_center = (float)(picture_width(frame) / 2);
        curve->y_center = (float)(picture_height(frame) / 2);
        curve->x_tangent = (float)pixel;
        curve->y_tangent = (float)(pixel / aspect);
    }
}

/* The largest diameter allowed on one side, in pixels. */
static float limit(double fraction, double width) {
    return (float)fmin(fraction > 0 ? fraction * width : COC_LIMIT, COC_LIMIT);
}

void lens_curve_focus(lens_curve *curve, const ddof_frame *frame, const ddof_lens *lens, double s) {
    const double width = picture_width(frame), f = focal_length(lens);
    const double s_near = isinf(s) ? s : s - lens->in_focus_range / 2, s_far = s + lens->in_focus_range / 2;

    curve->q_far = (float)(1 / s_far);
    curve->q_near = s_near > 0 ? (float)(1 / s_near) : INFINITY; /* nothing is nearer than such a focus */
    curve->limit_far = limit(lens->limit_far, width);
    curve->limit_near = limit(lens->limit_near, width);
    if (lens->kind == DDOF_LENS_ARTIST) {
        curve->gain_far = (float)(lens->max_coc_far * width * s_far);
        curve->gain_near = s_near > 0 ? (float)(lens->max_coc_near * width * s_near) : 0;
        curve->limit_near = fminf(curve->limit_near, (float)(lens->max_coc_near * width));
        return;
    }
    /* amplitude = (f/N) f/(s - f) W/sensor, times s0 or s1; as s goes to infinity (f/N) f W/sensor */
    double one = f / lens->f_number * f * width / sensor_width(lens) * (lens->unit > 0 ? lens->unit : 1000);
    double gain = isinf(s) ? one : one / (s - f);
    curve->gain_far = (float)(isinf(s) ? gain : gain * s_far);
    curve->gain_near = (float)(isinf(s) ? gain : s_near > 0 ? gain * s_near : 0);
}

double lens_inverse_depth(const lens_curve *c, double v, double x, double y) {
    double q = 0, p, t;
    if (isnan(v)) return NAN;
    switch (c->kind) {
    case DDOF_DEPTH_PLANAR: q = 1 / v; break;
    case DDOF_DEPTH_RAY:
        p = (x + 0.5 - c->x_center) * c->x_tangent;
        t = (y + 0.5 - c->y_center) * c->y_tangent;
        q = sqrt(1 + p * p + t * t) / v;
        break;
    case DDOF_DEPTH_INVERSE:
        if (v == INFINITY) return NAN;
        q = v;
        break;
    case DDOF_DEPTH_NORMALIZED: q = 1 / (c->offset + c->slope * v); break;
    case DDOF_DEPTH_DEVICE: q = c->offset + c->slope * v; break;
    }
    return q > 0 && isfinite(q) ? q : 0;
}

double lens_coc(const lens_curve *c, double q) {
    if (isnan(q)) return NAN;
    if (q < c->q_far) return fmin(c->gain_far * (c->q_far - q), c->limit_far);
    if (q > c->q_near) return fmax(c->gain_near * (c->q_near - q), -c->limit_near);
    return 0;
}
