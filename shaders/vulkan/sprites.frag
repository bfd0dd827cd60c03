#version 450
// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// What of a sprite's light falls on a pixel; the blending adds it up. WEIGHT: and of 1, for FULL.

#define STATE readonly
#define LIST readonly
#include "sprites.glsl"

layout(location = 0) flat in vec3 sprite_middle; // as in sprite_vertex.glsl
layout(location = 1) flat in vec4 sprite_light;
layout(location = 2) flat in vec4 sprite_mask;
layout(location = 3) flat in ivec3 sprite_level;
layout(location = 4) flat in vec2 sprite_cat;
layout(location = 5) flat in ivec3 sprite_origin;
layout(location = 0) out vec4 light;
#ifdef WEIGHT
layout(location = 1) out float weight;
#endif

// A hole hides nothing of a highlight.
float visible(ivec2 p, float sprite) {
    vec4 color;
    float d = coc_of(p);
    if (FULL != 0 && !is_finite(d)) filled(p, color, d);
    return is_finite(d) ? bokeh_visible(d, sprite) : 1.0;
}

void main() {
    ivec2 q = ivec2(gl_FragCoord.xy) - sprite_origin.xy;
    vec2 offset = vec2(q) - sprite_middle.xy;
    float d = sprite_middle.z, side = d < 0.0 ? -1.0 : 1.0;
    vec3 mask = vec3(iris_mask(offset, sprite_mask.y, side, sprite_cat, sprite_level.y));
    if (fringe != 0.0) {
        mask.r = iris_mask(offset, sprite_mask.x, side, sprite_cat, sprite_level.x);
        mask.b = iris_mask(offset, sprite_mask.z, side, sprite_cat, sprite_level.z);
    }
    if (mask == vec3(0.0)) discard;
    mask *= visible(q << sprite_origin.z, d);
    light = sprite_light * mask.rgbg;
#ifdef WEIGHT
    weight = sprite_mask.w * mask.g;
#endif
}
