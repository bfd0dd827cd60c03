// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// The iris's image, as include/iris.glsl reads it: the levels of its table lie one after the other, the largest first.

float iris_texel(int level, ivec2 at) {
    int side = 128 >> level;
    return texel[(65536 - 4 * side * side) / 3 + at.y * side + at.x];
}

#include "../include/iris.glsl"
