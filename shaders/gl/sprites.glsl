// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// Sprites: what all of their passes share (src/gl/sprites.c). The constants that are put in front:
//   FULL      every pixel is a sprite; else the highlights are
//   ALPHA     0: the fourth channel is not looked at, and 1
//   TO_HALF   half floats are written

uniform highp sampler2D color_map;
uniform highp sampler2D coc_map;       // CoC, NO_COC where it is not known; to find candidates: depth or CoC as it comes
uniform highp sampler2D candidate_map; // CoC of the sprite that a pixel may become, 0: of none; its brightness
uniform highp sampler2D budget_map;    // one texel: between which bins the threshold is looked for
uniform highp sampler2D table_map;     // of the iris
uniform highp sampler2D sum_map;

uniform ivec2 size;      // of the picture
uniform vec3 colors;     // 1 for each channel that is colour, else 0
uniform float threshold; // as asked for
uniform float largest;   // |CoC|

// Sprites are added up in pictures of 1/2^level of the size, all in one target.
uniform int first_level, levels;
uniform ivec4 place[8]; // of a level in it, width and height
uniform ivec2 second;   // where the near ones begin; 0: among the far ones

// Rows of the table.
const int INVERSE_SUM = 0, DIAMETER = 10, EDGE = 11, CATS_GAIN = 12, TEXEL = 13;

float table(int row, int at) {
    return texelFetch(table_map, ivec2(at, row), 0).x;
}

// The node next to a diameter: log2() alone may miss it by one.
float iris_node(float diameter);
float node_of(float d) {
    const float half_node = 1.0054299011128028; // exp2(1/128)
    float n = iris_node(d), at = table(DIAMETER, int(n));
    return clamp(d >= at * half_node ? n + 1.0 : d * half_node < at ? n - 1.0 : n, 0.0, 832.0);
}

vec4 color_texel(ivec2 p) {
    vec4 x = texelFetch(color_map, p, 0);
    if (ALPHA == 0) x.w = 1.0;
    return x;
}

float brightness(vec4 x) {
    return bokeh_brightness(x.rgb * colors);
}

bool is_known(float coc) {
    return coc <= COC_LIMIT;
}

// (CoC, brightness) of the sprite that a pixel may become; CoC 0: it becomes none.
vec2 candidate(ivec2 p) {
#if FULL
    float d = texelFetch(coc_map, p, 0).x;
    return is_known(d) && bokeh_share(d) > 0.0 && is_finite(color_texel(p)) ? vec2(d, 1.0) : vec2(0.0);
#else
    return texelFetch(candidate_map, p, 0).xy;
#endif
}

float edge_of(float bin) {
    return threshold * table(EDGE, int(bin));
}

// The raised threshold.
float raised() {
    return edge_of(texelFetch(budget_map, ivec2(0), 0).y);
}

// How much of a candidate's colour its sprite takes.
float taken(vec2 c, float above) {
#if FULL
    return bokeh_share(c.x);
#else
    float left = above / c.y;
    return abs(c.x) <= largest && left < 1.0 ? bokeh_share(c.x) * (1.0 - left * left) : 0.0;
#endif
}
