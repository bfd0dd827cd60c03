// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// Where rows and unknowns lie: the picture, whose rows are made on the fly, and the levels of the chain. One source for both
// directions. Every fetch is of one exact texel, clamped to the line: rows at the ends have a = 0 or c = 0, so what lies
// beyond them is multiplied by 0.

#define FROM_PICTURE 0 // level 0, made on the fly
#define FROM_TABLE 1   // a level: abc and x
#define FROM_PACKED 2  // a level: one texel
#define FROM_BOTH 3    // level 0 of cr-vanilla: abc from a surface, x from the picture

uniform highp sampler2D color_map;
uniform highp sampler2D coc_map;     // depth or CoC
uniform highp sampler2D abc_map;     // (a, g, c, -)
uniform highp sampler2D x_map;
uniform highp usampler2D packed_map;
uniform highp sampler2D y_map;       // what is known, on the next level

uniform int known; // of a line, on the level that y is read from
uniform ivec2 rows_fold, y_fold, target_fold;

// The place of unknown i of a line. A surface that both directions share (SHARED) has the shape of the horizontal
// level; the vertical one lies in it cut into strips: fold = width of a strip, unknowns of a line.
ivec2 texel(int i, int line, ivec2 fold) {
#if VERTICAL && SHARED
    int strip = int((float(line) + 0.5) / float(fold.x));
    return ivec2(line - strip * fold.x, i + strip * fold.y);
#elif VERTICAL
    return ivec2(line, i);
#else
    return ivec2(i, line);
#endif
}

// (i, line) of this fragment.
ivec2 target() {
    ivec2 p = ivec2(gl_FragCoord.xy);
#if VERTICAL && SHARED && !TO_PICTURE
    int strip = int((float(p.y) + 0.5) / float(target_fold.y));
    return ivec2(p.y - strip * target_fold.y, p.x + strip * target_fold.x);
#elif VERTICAL
    return p.yx;
#else
    return p;
#endif
}

vec4 color_texel(ivec2 p) {
    return texelFetch(color_map, p, 0);
}

float map_texel(ivec2 p) {
    return texelFetch(coc_map, p, 0).x;
}

// ---- the levels

#if ROWS == FROM_PACKED
Row fetch_row(int i, int line) {
    return unpack(texelFetch(packed_map, texel(clamp(i, 0, unknowns - 1), line, rows_fold), 0));
}
#elif ROWS == FROM_TABLE
Row fetch_row(int i, int line) {
    ivec2 p = texel(clamp(i, 0, unknowns - 1), line, rows_fold);
    vec4 abc = texelFetch(abc_map, p, 0);
    return Row(abc.x, abc.y, abc.z, texelFetch(x_map, p, 0));
}
#elif ROWS == FROM_BOTH
Row fetch_row(int i, int line) {
    vec4 abc = texelFetch(abc_map, pixel(clamp(i, 0, unknowns - 1), line), 0);
    Row r = picture_row(i, line, -abc.x, -abc.z, 0.0);
    r.g = abc.y;
    return r;
}
#else
Row fetch_row(int i, int line) {
    return picture_row(i, line);
}
#endif

// Rows i - 1, i, i + 1.
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
    return texelFetch(y_map, texel(clamp(i, 0, known - 1), line, y_fold), 0);
}

// ---- what is written

vec4 rounded(vec4 x) {
#if TO_HALF
    return nearest_half(x);
#else
    return x;
#endif
}

#if TO_ROWS && TO_PACKED
layout(location = 0) out highp uvec4 packed_target;

void store_row(Row r) {
    packed_target = pack(r);
}
#elif TO_ROWS
layout(location = 0) out highp vec4 abc_target;
layout(location = 1) out highp vec4 x_target;

void store_row(Row r) {
    abc_target = vec4(r.a, r.g, r.c, 0.0);
    x_target = rounded(r.x);
}
#else
layout(location = 0) out highp vec4 y_target;

// LAST: no pass follows that could fill a picture of holes.
void store_y(vec4 y) {
#if LAST
    if (floatBitsToUint(y.x) == NOTHING) y = vec4(0.0);
#endif
    y_target = rounded(y);
}
#endif
