#version 450
// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// An instance is a sprite, and its four vertices the corners.

#define STATE readonly
#define LIST readonly
#include "sprites.glsl"
#include "sprite_vertex.glsl"

void main() {
    Sprite s = sprite_of(uint(gl_InstanceIndex));
    gl_Position = sprite_corner(s, gl_VertexIndex);
    tell(s);
}
