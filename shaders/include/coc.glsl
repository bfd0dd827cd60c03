// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// From a value of the depth map to the signed circle of confusion, in pixels: src/lens.c, and the rules of ddof_depth in
// ddof/ddof.h. What is not a number is told by its bits: isnan() may be optimised away.

// DEPTH: 0: the map holds CoC; else 1 + ddof_depth_kind. A constant, not a uniform: drivers may run all branches.
#ifndef VULKAN // there they lie in the push constants
uniform vec2 depth_linear; // offset, slope: NORMALIZED: z = offset + slope v; DEVICE: 1/z = offset + slope v
uniform vec4 depth_axis;   // RAY: the optical axis x, y in pixels of this image; tangent of the angle of a pixel, x and y
uniform vec4 lens_curve;   // q_far, q_near, gain_far, gain_near
uniform vec2 lens_limit;   // far, near; pixels
#endif

const float NO_COC = 2e5;    // a pixel whose CoC is not known
const float COC_LIMIT = 1e5; // as in src/coc_limits.h
const float BETA_FLOOR = 1e-14;

bool is_finite(float v) {
    return (floatBitsToUint(v) & 0x7f800000u) != 0x7f800000u;
}

bool is_finite(vec4 v) {
    return all(notEqual(floatBitsToUint(v) & 0x7f800000u, uvec4(0x7f800000u)));
}

float reciprocal(float v) { // what is not in front of the camera is infinitely far
    return v > 0.0 ? 1.0 / v : 0.0;
}

// 1/z of a value that is a number. p: the pixel's centre.
float inverse_depth(float v, vec2 p) {
    if (DEPTH == 2) { // RAY
        vec2 t = (p - depth_axis.xy) * depth_axis.zw;
        return sqrt(1.0 + dot(t, t)) * reciprocal(v);
    }
    if (DEPTH == 3) return max(v, 0.0); // INVERSE
    if (DEPTH == 4) return reciprocal(depth_linear.x + depth_linear.y * v); // NORMALIZED
    if (DEPTH == 5) return max(depth_linear.x + depth_linear.y * v, 0.0); // DEVICE
    return reciprocal(v);
}

// The CoC of an inverse depth.
float lens_coc(float q) {
    float far = min(lens_curve.z * (lens_curve.x - q), lens_limit.x);
    float near = max(lens_curve.w * (lens_curve.y - q), -lens_limit.y);
    return q < lens_curve.x ? far : q > lens_curve.y ? near : 0.0;
}

// Signed CoC of a depth value; NaN for one that makes a hole.
float depth_coc(float v, vec2 p) {
    uint magnitude = floatBitsToUint(v) & 0x7fffffffu;
    float q = magnitude < 0x7f800000u ? inverse_depth(v, p) : 0.0;
    float d = lens_coc(is_finite(q) ? q : 0.0);
    bool hole = magnitude > 0x7f800000u || (DEPTH == 3 && floatBitsToUint(v) == 0x7f800000u);
    return hole ? uintBitsToFloat(0x7fc00000u) : d;
}

// Heat conductance of the link between two pixels whose |CoC| are d, e: from the smaller one. Below 0: outside the picture,
// which is an insulator. A pixel without a CoC follows the other. `scale`: the conductance of a link of 1 px.
float conductance(float d, float e, float scale) {
    float smaller = min(min(d, e), COC_LIMIT);
    return smaller < 0.0 ? 0.0 : max(scale * smaller * smaller, BETA_FLOOR);
}
