// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// Which pixels become sprites, and over what they are seen: the formulas of src/bokeh.h. Whoever includes this has coc.glsl's is_finite().

const float BOKEH_LEAST = 2.0, BOKEH_WHOLE = 4.0, BOKEH_EMPTY = 1e-6;
const int BOKEH_REACH = 2, BOKEH_BINS = 512;
const float BOKEH_BIN_OCTAVE = 16.0;

// How much of a pixel of CoC d is a sprite.
float bokeh_share(float d) {
    return smoothstep(BOKEH_LEAST, BOKEH_WHOLE, abs(d));
}

// The level that a sprite of a node of iris.glsl is drawn at, in a target of 1/2^level of the size.
int bokeh_level(float node, bool half_size) {
    return clamp(int(floor(node / 64.0)) - 5, half_size ? 1 : 0, 7);
}

float bokeh_brightness(vec3 color) {
    return max(color.r, max(color.g, color.b));
}

float bokeh_edge(int bin, float threshold) {
    return threshold * exp2(float(bin) / BOKEH_BIN_OCTAVE);
}

// By the edges themselves, as in src/bokeh.c.
int bokeh_bin(float v, float threshold) {
    int bin = clamp(int(floor(log2(v / threshold) * BOKEH_BIN_OCTAVE)), 0, BOKEH_BINS - 1);
    if (bin > 0 && v <= bokeh_edge(bin, threshold)) return bin - 1;
    return bin < BOKEH_BINS - 1 && v > bokeh_edge(bin + 1, threshold) ? bin + 1 : bin;
}

float bokeh_visible(float p, float s) {
    float ratio = s > 0.0 ? p / s : p >= s ? 1.0 : s / p;
    return smoothstep(0.25, 0.75, ratio);
}

// Of a disc, what lies on the near side of a line at a distance of `at` radii.
float bokeh_segment(float at) {
    float h = clamp(at, -1.0, 1.0), up = sqrt(1.0 - h * h);
    return 0.5 + (h * up + atan(h, up)) * 0.318309886; // asin() of some drivers is only exact to 1e-4
}

// How much of a disc of this diameter around `pixel` lies in a picture of `size`; of an ellipse that is `aspect` times as tall.
float bokeh_inside(ivec2 pixel, ivec2 size, float diameter, float aspect) {
    vec2 per = vec2(2.0, 2.0 / aspect) / diameter, at = vec2(pixel) + 0.5, beyond = vec2(size) - at;
    float across = bokeh_segment(at.x * per.x) + bokeh_segment(beyond.x * per.x) - 1.0;
    return across * (bokeh_segment(at.y * per.y) + bokeh_segment(beyond.y * per.y) - 1.0);
}
