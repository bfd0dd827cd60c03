// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT
#version 450
#extension GL_GOOGLE_include_directive : require

// After three steps of PCR the rows of a line are `stride` interleaved systems: a thread sweeps along one of them and back,
// serially (src/tridiag/pcr3_sweep.c). Its pad holds the mean of what lies before a row, and the share of it that the row keeps.

#include "pass.glsl"

layout(set = 0, binding = 3, std430) readonly buffer LevelsIn { vec4 levels_in[]; };
layout(set = 0, binding = 4, std430) buffer Pad { vec4 pad[]; };

void main() {
    // Threads that stand side by side take neighbouring systems of a line; of columns, the same one of neighbouring lines.
    int id = int(gl_GlobalInvocationID.x);
    int first = VERTICAL != 0 ? int(gl_GlobalInvocationID.y) : id % stride;
    int line = VERTICAL != 0 ? id : id / stride;
    if (line >= lines || first >= stride || first >= unknowns) return;

    float rest = 0.0; // what the row is held by, through those before it
    bool holes = true;
    vec4 m = vec4(0.0);
    int i = first;
    for (; i < unknowns; i += stride) {
        uint at = 2u * uint(VERTICAL != 0 ? i * lines + line : line * unknowns + i);
        vec4 agc = levels_in[rows_at + at], x = levels_in[rows_at + at + 1u];
        float w = agc.y + rest, beta = -agc.z, part = w / max(w + beta, 1e-35);
        m = lerp(m, x, agc.y / max(w, 1e-35));
        pad[to_at + at] = vec4(part);
        pad[to_at + at + 1u] = m;
        holes = holes && !(agc.y > 0.0);
        rest = part < 0.5 ? w * (1.0 - part) : part * beta;
    }
    vec4 y = m;
    for (i -= stride; i >= 0; i -= stride) {
        uint at = 2u * uint(VERTICAL != 0 ? i * lines + line : line * unknowns + i);
        float part = pad[to_at + at].x;
        y = lerp(y, pad[to_at + at + 1u], part);
        store_pixel(i, first_line + line, holes ? nothing() : y);
    }
}
