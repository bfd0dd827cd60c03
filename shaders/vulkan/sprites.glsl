// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// What the passes of the sprites share (src/vulkan/sprites.h, whose names these are): constants, push constants and what is bound.
// Whoever includes this has said what of it is only read, by STATE and LIST: readonly, or nothing.

#extension GL_EXT_samplerless_texture_functions : require

layout(constant_id = 1) const int FULL = 0;      // every pixel out of focus; else highlights
layout(constant_id = 2) const int DEPTH = 0;     // as in pass.glsl, as are the next two
layout(constant_id = 3) const int ALPHA = 1;
layout(constant_id = 4) const int TARGET_HALF = 0;
layout(constant_id = 5) const int HALF_SIZE = 0; // of the first level that sprites are drawn into
layout(constant_id = 6) const int ARGUMENTS = 0; // sprites are counted in the arguments of the draw
layout(constant_id = 7) const int POINTS = 0;    // a sprite is a vertex; else an instance
layout(constant_id = 8) const int REMAINDER = 0; // highlights: what is left of every pixel is written

layout(push_constant) uniform Push {
    vec4 lens_curve, depth_axis; // as in include/coc.glsl
    vec2 depth_linear, lens_limit;
    ivec2 color_place, map_place; // as in pass.glsl
    int map_shift;
    int width, height;            // of the picture
    int target_width, part_height; // of what sprites are drawn into; FULL: of each of its two parts
    int levels;                   // that there are
    int colors;                   // channels that shine
    float threshold, largest;     // largest |CoC|
    uint most;                    // sprites
    uint most_area_low, most_area_high; // in 1/16 pixels
};

layout(set = 0, binding = 0) uniform texture2D color_map;
layout(set = 0, binding = 1) uniform texture2D coc_map;

const int BINS = 512;

layout(set = 0, binding = 4, std430) STATE buffer State {
    uint arguments[4]; // of vkCmdDrawIndirect()
    uint count, dropped, large;
    float raised;      // threshold
    int raised_bin;
    uint used_levels;  // a bit for each that has sprites
    uint unused[6];
    uint bin_count[BINS], bin_area_low[BINS], bin_area_high[BINS];
};

// Of highlights three vectors a sprite: place and CoC; what shines of the colour; and how much of that is taken from the picture.
// FULL: place and CoC.
layout(set = 0, binding = 5, std430) LIST buffer List {
    uvec2 list[];
};

layout(set = 0, binding = 6, std430) readonly buffer Tables {
    int iris_kind;
    float iris_blades, iris_curvature, iris_edge;
    float cats_eye, iris_squeeze, fringe, iris_aspect;
    vec2 iris_turn, middle; // middle: of the whole picture, in pixels of this one
    float per_diagonal;     // half diagonals that a pixel width is
    float iris_reach;       // radii, to either side
    float spare[2];
    float diameter[833], inverse_sum[10 * 833], cats_gain[65], texel[21824];
};

#include "../include/coc.glsl"
#include "../include/bokeh.glsl"

// The image's levels lie one after the other, the largest first.
float iris_texel(int level, ivec2 at) {
    int side = 128 >> level;
    return texel[(65536 - 4 * side * side) / 3 + at.y * side + at.x];
}

#include "../include/iris.glsl"

// Colour as diffusion takes it.
vec4 color_of(ivec2 p) {
    vec4 x = texelFetch(color_map, color_place + p, 0);
    if (ALPHA == 0) x.w = 1.0;
    return x;
}

// Signed CoC, limited; not a number where it is not known.
float coc_of(ivec2 p) {
    float d = texelFetch(coc_map, map_place + (p >> map_shift), 0).x;
    if (DEPTH != 0) d = depth_coc(d, vec2(p) + 0.5);
    float limit = FULL != 0 ? largest : COC_LIMIT;
    return is_finite(d) ? clamp(d, -limit, limit) : uintBitsToFloat(0x7fc00000u);
}

// Of those channels that shine.
float brightness_of(vec4 x) {
    return max(x.r, max(colors > 1 ? x.g : x.r, colors > 2 ? x.b : x.r));
}

uvec2 sprite_place(ivec2 p, float d) {
    return uvec2(uint(p.x) | uint(p.y) << 16, floatBitsToUint(d));
}

ivec2 sprite_pixel(uvec2 place) {
    return ivec2(place.x & 0xffffu, place.x >> 16);
}

// Where a sprite's data begin.
uint sprite_at(uint i) {
    return FULL != 0 ? i : 3u * i;
}

// ---- where sprites are drawn: the levels of bokeh.glsl, the first above the others, which lie side by side

ivec2 level_size(int level) {
    return (ivec2(width, height) + (1 << level) - 1) >> level;
}

ivec2 level_origin(int level) {
    ivec2 origin = ivec2(0);
    if (level > HALF_SIZE) origin.y = level_size(HALF_SIZE).y;
    for (int l = HALF_SIZE + 1; l < level; l++) origin.x += level_size(l).x;
    return origin;
}

// ---- FULL: holes

const int HOLE_REACH = 64;

// Colour and CoC of a pixel; in a hole, the mean of what is known in eight directions, by 1/distance.
void filled(ivec2 p, out vec4 color, out float d) {
    color = color_of(p);
    d = coc_of(p);
    if (is_finite(color) && is_finite(d)) return;
    vec4 sum = vec4(0.0);
    float sum_d = 0.0, weight = 0.0;
    for (int way = 0; way < 9; way++) {
        ivec2 way_by = ivec2(way % 3 - 1, way / 3 - 1);
        for (int i = 1; i <= HOLE_REACH && way != 4; i++) {
            ivec2 q = p + i * way_by;
            if (any(lessThan(q, ivec2(0))) || q.x >= width || q.y >= height) break;
            vec4 there = color_of(q);
            float there_d = coc_of(q);
            if (!is_finite(there) || !is_finite(there_d)) continue;
            float share = 1.0 / (float(i) * length(vec2(way_by)));
            sum += share * there;
            sum_d += share * there_d;
            weight += share;
            break;
        }
    }
    color = weight > 0.0 ? sum / weight : vec4(0.0);
    d = is_finite(d) ? d : weight > 0.0 ? sum_d / weight : 0.0;
}
