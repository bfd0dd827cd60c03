// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// What iris.glsl asks for, and how far a sprite reaches.
const int iris_kind = IRIS; // of the passes that draw
uniform float iris_blades, iris_curvature, iris_edge, iris_squeeze, iris_aspect, iris_fringe, iris_reach;
uniform vec2 iris_turn;

float iris_texel(int level, ivec2 at) {
    int side = 128 >> level, n = (65536 - (65536 >> (2 * level))) / 3 + at.y * side + at.x; // all levels, the largest first
    return table(TEXEL + (n >> 10), n & 1023);
}

// Of a node of the tables, in pixels of a level.
float diameter_of(float node, int level) {
    return table(DIAMETER, int(node)) * (level > 0 ? 0.5 : 1.0);
}

// Pixels of the level to the left and right of that of its middle, and above and below its middle.
vec2 sprite_reach(float diameter) {
    float radius = 0.5 * diameter * iris_reach;
    return vec2(floor(radius) + 2.0, radius * iris_aspect + 1.0 + iris_aspect);
}
