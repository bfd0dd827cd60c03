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

Sums drawn_at(ivec2 q) {
    return Sums(texelFetch(light_map, q, 0), FULL != 0 ? texelFetch(weight_map, q, 0).x : 0.0);
}

Sums mixed(Sums a, Sums b, float share) {
    return Sums(mix(a.light, b.light, share), mix(a.weight, b.weight, share));
}

// What was drawn over pixel p: the sums of all levels, interpolated.
Sums drawn(ivec2 p, int part) {
    Sums all = Sums(vec4(0.0), 0.0);
    ivec2 origin = ivec2(0, part * part_height); // as level_origin()
    for (int level = HALF_SIZE; level < levels; level++) {
        ivec2 here = origin, last = level_size(level) - 1;
        origin += level == HALF_SIZE ? ivec2(0, last.y + 1) : ivec2(last.x + 1, 0);
        if ((used_levels & 1u << level) == 0u) continue;
        float size = exp2(-float(level));
        vec2 at = (vec2(p) + 0.5) * size - 0.5, share = fract(at);
        ivec2 q0 = ivec2(floor(at)), q1 = here + min(q0 + 1, last);
        q0 = here + max(q0, ivec2(0));
        Sums above = drawn_at(q0), below;
        if (level > 0) {
            above = mixed(above, drawn_at(ivec2(q1.x, q0.y)), share.x);
            below = mixed(drawn_at(ivec2(q0.x, q1.y)), drawn_at(q1), share.x);
            above = mixed(above, below, share.y);
        }
        all.light += size * size * above.light;
        all.weight += size * size * above.weight;
    }
    return all;
}

vec4 composed(ivec2 p) {
    vec4 color;
    float d;
    filled(p, color, d);
    Sums far = drawn(p, 0), near = drawn(p, 1);
    float share = bokeh_share(d);
    bool some_near = near.weight > BOKEH_EMPTY;
    if (d > 0.0 && far.weight > BOKEH_EMPTY) color = mix(color, far.light / far.weight, share);
    if (d < 0.0 && some_near) color = mix(color, near.light / near.weight, share);
    if (some_near) color = mix(color, near.light / near.weight, min(near.weight, 1.0));
    return color;
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
