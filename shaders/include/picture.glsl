// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// The picture as the rows of a solver, made on the fly. One source for both directions, and for all APIs, which bring
//   color_texel(), map_texel()   one texel of the colour, and of depth or CoC
// and the constants
//   VERTICAL  lines are columns
//   ALPHA     0: the fourth channel is not looked at, and 1
//   HALF      colour is kept in half floats

vec4 color_texel(ivec2 p);
float map_texel(ivec2 p);

#ifndef VULKAN // there they lie in the push constants
uniform int unknowns;     // of a line, on the level that rows are read from
uniform float scale;      // conductance of a link of 1 px
uniform bool coc_decides; // whether a pixel without a CoC is a hole
#endif

ivec2 pixel(int i, int line) {
    return VERTICAL != 0 ? ivec2(line, i) : ivec2(i, line);
}

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

float link(float d, float e) {
    return conductance(d, e, scale);
}

// Colour of pixel i of a line whose |CoC| is d; nothing() where it is a hole.
vec4 color_at(int i, int line, float d) {
    vec4 x = color_texel(pixel(clamp(i, 0, unknowns - 1), line));
    if (ALPHA == 0) x.w = 1.0;
    bool hole = !is_finite(x) || (coc_decides && d > COC_LIMIT);
    return hole ? nothing() : storable(x);
}

// Row i, whose links have conductances `before` and `after` and whose own |CoC| is d.
Row picture_row(int i, int line, float before, float after, float d) {
    vec4 x = color_at(i, line, d);
    bool hole = floatBitsToUint(x.x) == NOTHING;
    return Row(-before, hole ? 0.0 : 1.0, -after, hole ? vec4(0.0) : x);
}

Row picture_row(int i, int line) {
    float d = coc_at(i, line);
    return picture_row(i, line, link(coc_at(i - 1, line), d), link(d, coc_at(i + 1, line)), d);
}

// Rows i - 1, i, i + 1.
void picture_three(int i, int line, out Row p, out Row r, out Row n) {
    float d_2 = coc_at(i - 2, line), d_1 = coc_at(i - 1, line), d0 = coc_at(i, line);
    float d1 = coc_at(i + 1, line), d2 = coc_at(i + 2, line);
    float before = link(d_1, d0), after = link(d0, d1);
    p = picture_row(i - 1, line, link(d_2, d_1), before, d_1);
    r = picture_row(i, line, before, after, d0);
    n = picture_row(i + 1, line, after, link(d1, d2), d1);
}
