// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// What every pass of the Vulkan backend shares: constants, push constants, and where the picture is read and written. The
// values of the constants: src/vulkan/pipelines.h.

#extension GL_EXT_samplerless_texture_functions : require

layout(local_size_x_id = 0) in;
layout(constant_id = 1) const int VERTICAL = 0; // lines are columns; 2, 3: diagonals (disc_line.comp)
layout(constant_id = 2) const int DEPTH = 0;
layout(constant_id = 3) const int ALPHA = 1;
layout(constant_id = 4) const int HALF = 0;        // colour under way in half floats: in registers, or packed
layout(constant_id = 5) const int TARGET_HALF = 0; // the target is an image of half floats
layout(constant_id = 6) const int LAST = 0;        // no pass follows that could fill a picture of holes

layout(push_constant) uniform Push {
    vec4 lens_curve, depth_axis; // as in include/coc.glsl
    vec2 depth_linear, lens_limit;
    ivec2 color_place, map_place; // of pixel (0, 0), in the images of colour and target; of depth or CoC
    int map_shift;                // 1: the map has half the size
    int unknowns;                 // of a line, on the level that rows are read from
    int lines, first_line;        // that this dispatch works on, and the first of them
    int first_pass;               // a pixel without a CoC is a hole
#ifdef DISC
    float disc_fade;              // pixels^2; src/disc.h has the formulas
    vec2 disc_beta, disc_offset;  // of the component
    vec2 disc_weight;
    float disc_level, disc_slope; // of the direction
    float disc_excess;            // pixels^2
#else
    float scale;                  // conductance of a link of 1 px
    int known;                    // of a line, on the level that y is read from
    int to_unknowns;              // of a line, on the level written
    int stride;
    uint rows_at, y_at, to_at;    // where those levels begin in scratch memory, in 16 bytes
#endif
};
#define coc_decides (first_pass != 0)

layout(set = 0, binding = 0) uniform texture2D color_map;
layout(set = 0, binding = 1) uniform texture2D coc_map;
layout(set = 0, binding = 2) uniform writeonly image2D target_map;

#include "../include/coc.glsl"
#include "../include/row.glsl"
#include "../include/pack.glsl"
#include "../include/pixels.glsl"
#ifndef DISC
#include "../include/picture.glsl"
#endif

// Four half floats. nothing() is packed by hand: not every device has infinities in packHalf2x16() (SwiftShader has none).
const uint NOTHING_HALVES = 0x7c007c00u;

uvec2 pack_color(vec4 x) {
    x = nearest_half(x);
    bool none = floatBitsToUint(x.x) == NOTHING;
    return none ? uvec2(NOTHING_HALVES) : uvec2(packHalf2x16(x.xy), packHalf2x16(x.zw));
}

vec4 unpack_color(uvec2 h) {
    return h.x == NOTHING_HALVES ? nothing() : vec4(unpackHalf2x16(h.x), unpackHalf2x16(h.y));
}

vec4 color_texel(ivec2 p) {
    return texelFetch(color_map, color_place + p, 0);
}

float map_texel(ivec2 p) {
    return texelFetch(coc_map, map_place + (p >> map_shift), 0).x;
}

#ifndef DISC
// The result of pixel i of a line.
void store_pixel(int i, int line, vec4 y) {
    ivec2 p = pixel(i, line);
    if (LAST != 0 && floatBitsToUint(y.x) == NOTHING) y = vec4(0.0);
    if (TARGET_HALF != 0 && is_finite(y)) y = nearest_half(clamp(y, -65504.0, 65504.0));
    imageStore(target_map, color_place + p, y);
}
#endif
