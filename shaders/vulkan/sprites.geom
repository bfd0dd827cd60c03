#version 450
// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// A point is a sprite; it becomes the four corners.

#define STATE readonly
#define LIST readonly
#include "sprites.glsl"
#include "sprite_vertex.glsl"

layout(points) in;
layout(triangle_strip, max_vertices = 4) out;
layout(location = 0) flat in uint sprite_index[];

void main() {
    Sprite s = sprite_of(sprite_index[0]);
    for (int corner = 0; corner < 4; corner++) {
        gl_Position = sprite_corner(s, corner);
        tell(s);
        EmitVertex();
    }
    EndPrimitive();
}
