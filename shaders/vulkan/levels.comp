// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT
#version 450
#extension GL_GOOGLE_include_directive : require

// The stages of shaders/stages as compute passes: a thread for each unknown of a band of lines. What lies between two passes is in
// scratch memory: the levels of the chain.
//   ROWS        where rows come from: the picture, made on the fly; a table (a, g, c, -), x; packed
//   TO_ROWS     rows are written, in a table or packed (TO_PACKED); else unknowns: of the picture (TO_PICTURE) or of a level

#include "pass.glsl"

#define FROM_PICTURE 0
#define FROM_TABLE 1
#define FROM_PACKED 2

layout(set = 0, binding = 3, std430) readonly buffer LevelsIn { uvec4 levels_in[]; };
layout(set = 0, binding = 3, std430) readonly buffer ColorsIn { uvec2 colors_in[]; };
layout(set = 0, binding = 4, std430) writeonly buffer LevelsOut { uvec4 levels_out[]; };
layout(set = 0, binding = 4, std430) writeonly buffer ColorsOut { uvec2 colors_out[]; };

// Index of unknown i of a line on a level with n of them: neighbouring threads meet neighbouring memory.
uint place(int i, int line, int n) {
    return uint(VERTICAL != 0 ? i * lines + line - first_line : (line - first_line) * n + i);
}

// (i, line) of this thread.
ivec2 target() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    return VERTICAL != 0 ? ivec2(p.y, p.x + first_line) : ivec2(p.x, p.y + first_line);
}

Row fetch_row(int i, int line) {
#if ROWS == FROM_PICTURE
    return picture_row(i, line);
#else
    uint at = place(clamp(i, 0, unknowns - 1), line, unknowns);
#if ROWS == FROM_PACKED
    return unpack(levels_in[rows_at + at]);
#else
    vec3 agc = uintBitsToFloat(levels_in[rows_at + 2u * at].xyz);
    return Row(agc.x, agc.y, agc.z, uintBitsToFloat(levels_in[rows_at + 2u * at + 1u]));
#endif
#endif
}

void fetch_three(int i, int line, out Row p, out Row r, out Row n) {
#if ROWS == FROM_PICTURE
    picture_three(i, line, p, r, n);
#else
    p = fetch_row(i - 1, line);
    r = fetch_row(i, line);
    n = fetch_row(i + 1, line);
#endif
}

vec4 fetch_y(int i, int line) {
    return unpack_color(colors_in[2u * y_at + place(clamp(i, 0, known - 1), line, known)]);
}

#if TO_ROWS
void store_row(Row r) {
    ivec2 p = target();
    uint at = place(p.x, p.y, to_unknowns);
#if TO_PACKED
    levels_out[to_at + at] = pack(r);
#else
    levels_out[to_at + 2u * at] = uvec4(floatBitsToUint(vec3(r.a, r.g, r.c)), 0u);
    levels_out[to_at + 2u * at + 1u] = floatBitsToUint(r.x);
#endif
}
#else
void store_y(vec4 y) {
    ivec2 p = target();
#if TO_PICTURE
    store_pixel(p.x, p.y, y);
#else
    colors_out[2u * to_at + place(p.x, p.y, to_unknowns)] = pack_color(y);
#endif
}
#endif

#define main stage
#if defined(STAGE_PCR)
#include "../stages/pcr.glsl"
#elif defined(STAGE_INITIAL_REDUCE4)
#include "../stages/initial_reduce4.glsl"
#elif defined(STAGE_REDUCE)
#include "../stages/reduce.glsl"
#elif defined(STAGE_SOLVE)
#include "../stages/solve.glsl"
#elif defined(STAGE_SUBSTITUTE)
#include "../stages/substitute.glsl"
#else
#include "../stages/final_solve4.glsl"
#endif
#undef main

void main() {
    ivec2 p = target();
    if (p.x < to_unknowns && p.y < first_line + lines) stage();
}
