// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// A pixel of a sprite, to be added.
flat in vec4 light;
flat in float one;
flat in vec3 node;
flat in vec2 middle;
flat in float coc;
flat in vec2 cat;
flat in int level;
flat in ivec2 corner;

layout(location = 0) out highp vec4 light_target;
#if FULL
layout(location = 1) out highp vec4 weight_target;
#endif

float mask_of(vec2 offset, float n) {
    float diameter = diameter_of(n, level);
#if FRINGE
    vec2 reach = sprite_reach(diameter);
    if (abs(floor(offset.x + 0.5)) > reach.x || abs(offset.y) > reach.y) return 0.0;
#endif
    return iris_mask(offset, diameter, coc < 0.0 ? -1.0 : 1.0, cat, iris_level(n, level > 0));
}

void main() {
    ivec2 p = ivec2(gl_FragCoord.xy) - corner;
    vec2 offset = vec2(p) - middle;
    vec3 mask = vec3(mask_of(offset, node.g));
#if FRINGE
    mask.r = mask_of(offset, node.r);
    mask.b = mask_of(offset, node.b);
#endif
    mask *= bokeh_visible(texelFetch(coc_map, p << level, 0).x, coc);
    light_target = light * vec4(mask, mask.g);
#if FULL
    weight_target = vec4(one * mask.g);
#endif
}
