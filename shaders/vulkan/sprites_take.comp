#version 450
// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// Highlights of a picture that is blurred in place: takes their light out of it.

#define STATE readonly
#define LIST readonly
#include "sprites.glsl"
#include "../include/row.glsl"
#include "../include/pack.glsl"

layout(local_size_x = 64) in;
layout(set = 0, binding = 2) uniform writeonly image2D target_map;

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= min(ARGUMENTS != 0 ? arguments[POINTS != 0 ? 0 : 1] : count, most)) return;
    ivec2 p = sprite_pixel(list[3u * i]);
    vec4 color = color_of(p);
    vec2 rest = uintBitsToFloat(list[3u * i + 2u]);
    color.rgb -= rest.y * vec3(uintBitsToFloat(list[3u * i + 1u]), rest.x);
    if (TARGET_HALF != 0) color = nearest_half(clamp(color, -65504.0, 65504.0));
    imageStore(target_map, color_place + p, color);
}
