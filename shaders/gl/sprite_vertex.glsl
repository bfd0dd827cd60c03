// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// A quad for every pixel, as large as its sprite; where it is none, off the screen.
uniform int first_row;
uniform vec2 screen;   // the target
uniform vec3 cats_eye; // the middle of the whole picture, in pixels of this one; what of half a diagonal a pixel is, times cats_eye

flat out vec4 light;   // divided by the sum of the mask
flat out float one;    // FULL: what it weighs
flat out vec3 node;    // of the tables, for red, green, blue
flat out vec2 middle;  // in pixels of the level, from the middle of the first
flat out float coc;
flat out vec2 cat;
flat out int level;
flat out ivec2 corner; // of the level, in the target

float cats_gain() {
    float at = min(length(cat), 1.0) * 64.0, n = min(floor(at), 63.0);
    return cat == vec2(0.0) ? 1.0 : mix(table(CATS_GAIN, int(n)), table(CATS_GAIN, int(n) + 1), at - n);
}

void main() {
    ivec2 p = ivec2(gl_InstanceID % size.x, first_row + gl_InstanceID / size.x);
    vec2 c = candidate(p);
    float part = c.x == 0.0 ? 0.0 : taken(c, FULL != 0 ? 0.0 : raised());
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    light = vec4(0.0);
    one = 0.0;
    node = vec3(0.0);
    middle = vec2(0.0);
    coc = 1.0;
    cat = vec2(0.0);
    level = 0;
    corner = ivec2(0);
    if (part <= 0.0) return;

    coc = c.x;
    float d = abs(coc), side = coc < 0.0 ? -1.0 : 1.0;
    node = vec3(node_of(d));
    level = bokeh_level(node.g, first_level > 0);
#if FRINGE
    node.r = node_of(d * (1.0 + side * iris_fringe));
    node.b = node_of(d * (1.0 - side * iris_fringe));
#endif
    node -= 64.0 * float(max(level - 1, 0)); // from level 1 on the tables of half the size serve
    cat = (vec2(p) - cats_eye.xy) * vec2(cats_eye.z, -cats_eye.z / iris_aspect);
    ivec2 at = p >> level, quarter = (p >> max(level - 1, 0)) & 1;
    int row = INVERSE_SUM + (coc < 0.0 ? 5 : 0) + (level > 0 ? 1 + quarter.x + 2 * quarter.y : 0); // iris_sum()
    vec3 inverse = vec3(table(row, int(node.r)), table(row, int(node.g)), table(row, int(node.b)));
    vec4 x = color_texel(p);
    float gain = part * cats_gain();
#if FULL
    light = vec4(x.rgb * inverse, x.a * inverse.g) * gain;
    one = gain * inverse.g;
#else
    light = vec4(x.rgb * colors * inverse * gain, 0.0);
#endif
    middle = vec2(at) + (level > 0 ? vec2(quarter) * 0.5 - 0.25 : vec2(0.0));

    vec2 reach = sprite_reach(diameter_of(max(node.r, max(node.g, node.b)), level));
    vec2 low = vec2(float(at.x) - reach.x, ceil(middle.y - reach.y));
    vec2 high = vec2(float(at.x) + reach.x, floor(middle.y + reach.y)) + 1.0;
    corner = place[level].xy + (coc < 0.0 ? second : ivec2(0));
    vec2 ends = vec2((gl_VertexID & 1) == 0 ? low.x : high.x, gl_VertexID < 2 ? low.y : high.y);
    ends = clamp(ends, vec2(0.0), vec2(place[level].zw)) + vec2(corner);
    gl_Position = vec4(2.0 * ends / screen - 1.0, 0.0, 1.0);
}
