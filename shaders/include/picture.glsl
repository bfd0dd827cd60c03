// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// The picture as the rows of a solver, made on the fly. One source for both directions:
//   VERTICAL  lines are columns

#ifndef VULKAN // there it lies in the push constants
uniform float scale; // conductance of a link of 1 px
#endif

ivec2 pixel(int i, int line) {
    return VERTICAL != 0 ? ivec2(line, i) : ivec2(i, line);
}

float link(float d, float e) {
    return conductance(d, e, scale);
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
