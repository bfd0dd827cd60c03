// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// CoC and colour of the pixels of a line, for all APIs, which bring
//   color_texel(), map_texel()   one texel of the colour, and of depth or CoC
//   pixel()                      where pixel i of a line lies
// and the constants
//   ALPHA     0: the fourth channel is not looked at, and 1
//   HALF      colour is kept in half floats

vec4 color_texel(ivec2 p);
float map_texel(ivec2 p);
ivec2 pixel(int i, int line);

#ifndef VULKAN // there they lie in the push constants
uniform int unknowns;     // of a line, on the level that rows are read from
uniform bool coc_decides; // whether a pixel without a CoC is a hole
#endif

// What half floats can hold: beyond it, colour would become an infinity.
vec4 storable(vec4 x) {
    return HALF != 0 ? clamp(x, -65504.0, 65504.0) : x;
}

// |CoC| of pixel i of a line; below 0 outside, NO_COC where it is not known.
float coc_at(int i, int line) {
    ivec2 p = pixel(clamp(i, 0, unknowns - 1), line);
    float d = map_texel(p);
    if (DEPTH != 0) d = depth_coc(d, vec2(p) + 0.5);
    d = is_finite(d) ? min(abs(d), COC_LIMIT) : NO_COC;
    return i < 0 || i >= unknowns ? -1.0 : d;
}

// Colour of pixel i of a line whose |CoC| is d; nothing() where it is a hole.
vec4 color_at(int i, int line, float d) {
    vec4 x = color_texel(pixel(clamp(i, 0, unknowns - 1), line));
    if (ALPHA == 0) x.w = 1.0;
    bool hole = !is_finite(x) || (coc_decides && d > COC_LIMIT);
    return hole ? nothing() : storable(x);
}
