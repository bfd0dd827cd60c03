#version 450
// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// A vertex is a sprite; sprites.geom does the rest.

layout(location = 0) flat out uint sprite_index;

void main() {
    sprite_index = uint(gl_VertexIndex);
    gl_Position = vec4(0.0, 0.0, 0.0, 1.0);
}
