// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// A quad for every pixel, as large as its sprite; where it is none, off the screen. The target holds one picture, or two: `second`
// is where the one of the near sprites begins.
uniform int first_row;
uniform ivec2 target_size; // of one picture
uniform ivec2 second;      // 0: the same
uniform vec2 screen;       // both
uniform vec3 cats_eye;     // the middle of the whole picture, in pixels of this one; what of half a diagonal a pixel is, times cats_eye

flat out vec4 light;   // divided by the sum of the mask
flat out float one;    // FULL: what it weighs
flat out vec3 node;    // of the diameters of red, green, blue
flat out vec2 middle;  // in pixels of the target, from the middle of the first
flat out float coc;
flat out vec2 cat;
flat out ivec2 corner; // of its picture in the target

// The node next to a diameter: log2() alone may miss it by one.
float node_of(float d) {
    const float half_node = 1.0054299011128028; // exp2(1/128)
    float n = iris_node(d), at = table(DIAMETER, int(n));
    return clamp(d >= at * half_node ? n + 1.0 : d * half_node < at ? n - 1.0 : n, 0.0, 13.0 * IRIS_OCTAVE);
}

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
    corner = ivec2(0);
    if (part <= 0.0) return;

    coc = clamp(c.x, -largest, largest);
    float d = abs(coc), side = coc < 0.0 ? -1.0 : 1.0, scale = HALF_SIZE != 0 ? 0.5 : 1.0;
    node = vec3(node_of(d));
#if FRINGE
    node.r = node_of(d * (1.0 + side * iris_fringe));
    node.b = node_of(d * (1.0 - side * iris_fringe));
#endif
    cat = (vec2(p) - cats_eye.xy) * vec2(cats_eye.z, -cats_eye.z / iris_aspect);
    vec4 x = color_texel(p);
    float gain = part * cats_gain();
    vec3 inverse = vec3(table(INVERSE_SUM, int(node.r)), table(INVERSE_SUM, int(node.g)), table(INVERSE_SUM, int(node.b)));
#if FULL
    light = vec4(x.rgb * inverse, x.a * inverse.g) * gain;
    one = gain * inverse.g;
#else
    light = vec4(x.rgb * colors * inverse * gain, 0.0);
#endif
    ivec2 at = HALF_SIZE != 0 ? p / 2 : p;
    vec2 off = HALF_SIZE != 0 ? vec2(p - 2 * at) * 0.5 - 0.25 : vec2(0.0); // of the sprite from that pixel
    middle = vec2(at) + off;

    float diameter = table(DIAMETER, int(max(node.r, max(node.g, node.b)))) * scale;
    vec2 reach = sprite_reach(diameter);
    vec2 low = vec2(float(at.x) - reach.x, ceil(middle.y - reach.y));
    vec2 high = vec2(float(at.x) + reach.x, floor(middle.y + reach.y)) + 1.0;
    corner = coc < 0.0 ? second : ivec2(0);
    vec2 ends = vec2((gl_VertexID & 1) == 0 ? low.x : high.x, gl_VertexID < 2 ? low.y : high.y);
    ends = clamp(ends, vec2(0.0), vec2(target_size)) + vec2(corner);
    gl_Position = vec4(2.0 * ends / screen - 1.0, 0.0, 1.0);
}
