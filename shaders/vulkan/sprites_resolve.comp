#version 450
// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// Adds what was drawn to the blurred picture; FULL: lays far, in focus and near over each other (src/bokeh.h).

#define STATE readonly
#define LIST readonly
#include "sprites.glsl"
#include "../include/row.glsl"
#include "../include/pack.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 3) uniform writeonly image2D output_map;
layout(set = 0, binding = 7) uniform texture2D blurred_map;
layout(set = 0, binding = 8) uniform texture2D light_map;
layout(set = 0, binding = 9) uniform texture2D weight_map;

struct Sums {
    vec4 light;
    float weight;
};

Sums drawn_at(ivec2 q, int part) {
    q = clamp(q, ivec2(0), ivec2(target_width, target_height) - 1) + ivec2(0, part * target_height);
    return Sums(texelFetch(light_map, q, 0), FULL != 0 ? texelFetch(weight_map, q, 0).x : 0.0);
}

// What was drawn over pixel p; of half the size: a quarter of it, interpolated between the four nearest.
Sums drawn(ivec2 p, int part) {
    if (HALF_SIZE == 0) return drawn_at(p, part);
    ivec2 q = p / 2, beside = q + 2 * (p & 1) - 1; // p lies at p/2 - 1/4 between their middles
    Sums a = drawn_at(q, part), b = drawn_at(ivec2(beside.x, q.y), part);
    Sums c = drawn_at(ivec2(q.x, beside.y), part), d = drawn_at(beside, part);
    return Sums((9.0 * a.light + 3.0 * (b.light + c.light) + d.light) / 64.0,
                (9.0 * a.weight + 3.0 * (b.weight + c.weight) + d.weight) / 64.0);
}

vec4 composed(ivec2 p) {
    Sums far = drawn(p, 0), near = drawn(p, 1);
    vec4 base = color_of(p);
    float d = coc_of(p);
    bool known = is_finite(base) && is_finite(d);
    float t = known ? bokeh_share(d) : 1.0;
    if (!known) base = vec4(0.0);
    if (!(d < 0.0) && far.weight > BOKEH_EMPTY) base = mix(base, far.light / far.weight, t);
    if (d < 0.0 && near.weight > BOKEH_EMPTY) base = mix(base, near.light / near.weight, t);
    if (near.weight > BOKEH_EMPTY) base = mix(base, near.light / near.weight, min(near.weight, 1.0));
    return base;
}

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (p.x >= width || p.y >= height) return;
    vec4 y;
    if (FULL != 0)
        y = composed(p);
    else
        y = texelFetch(blurred_map, color_place + p, 0) + vec4(drawn(p, 0).light.rgb, 0.0);
    if (TARGET_HALF != 0 && is_finite(y)) y = nearest_half(clamp(y, -65504.0, 65504.0));
    imageStore(output_map, color_place + p, y);
}
