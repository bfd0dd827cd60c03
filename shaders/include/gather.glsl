// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// Means along lines: the formulas of src/methods.h.
//   GAUSSIAN  1: of a Gaussian, to both sides; 0: of a box, to one

uniform highp sampler2D coc_map;
uniform float nearest; // the largest |CoC| of what is nearer than the focus

// size, columns and rows of a step
struct Line {
    float size;
    int dx;
    float dy;
};

const float REACH = GAUSSIAN != 0 ? 2.5 : 1.0, EDGE = GAUSSIAN != 0 ? 1.0 : 0.5;
const float MOST_STEPS = 63.0;

struct Sum {
    vec4 color; // less the pixel's own: a constant stays
    float weight;
};

float tap_weight(float size, float t, float skip, float d) {
    float reach = size * d;
    if (GAUSSIAN != 0) {
        float inverse = 1.0 / max(reach, 1e-3), x = t * inverse;
        float cover = clamp((REACH * reach - t) / skip + 1.0, 0.0, 1.0);
        return cover * min(inverse * 0.3989422804, 1.0) * exp2(-min(x * x * 0.7213475204, 100.0));
    }
    return (t > 0.0 ? clamp((reach - t) / skip + 0.5, 0.0, 1.0) : 0.5) / max(reach, 0.5);
}

void add_tap(inout Sum sum, highp sampler2D map, ivec2 size, ivec2 q, float share, float own, vec4 color, float t, float skip, float line_size,
             bool over) {
    if (any(lessThan(q, ivec2(0))) || any(greaterThanEqual(q, size))) return;
    float d = texelFetch(coc_map, q, 0).x;
    if ((d < -own) != over) return;
    float weight = share * skip * tap_weight(line_size, t, skip, over ? abs(d) : min(abs(d), own));
    sum.color += weight * (texelFetch(map, q, 0) - color);
    sum.weight += weight;
}

// Taps that lie over the pixel, or all others, as far as a CoC of `widest` reaches.
void add_taps(inout Sum sum, highp sampler2D map, Line line, ivec2 p, float own, vec4 color, float widest, bool over) {
    ivec2 size = textureSize(map, 0);
    float reach = min(REACH * line.size * widest, float(line.dx != 0 ? size.x : size.y)), skip = 1.0;
    while (reach > MOST_STEPS * skip) skip *= 2.0;
    int taps = int(reach / skip + EDGE);
    for (int i = GAUSSIAN != 0 ? -taps : 0; i <= taps; i++) {
        float along = float(i) * skip, down = line.dy * along, row = floor(down);
        ivec2 q = p + ivec2(line.dx * i * int(skip), int(row));
        add_tap(sum, map, size, q, 1.0 - (down - row), own, color, abs(along), skip, line.size, over);
        if (down > row) add_tap(sum, map, size, q + ivec2(0, 1), down - row, own, color, abs(along), skip, line.size, over);
    }
}

vec4 gather(highp sampler2D map, Line line) {
    ivec2 p = ivec2(gl_FragCoord.xy);
    float own = abs(texelFetch(coc_map, p, 0).x);
    vec4 color = texelFetch(map, p, 0);
    Sum sum = Sum(vec4(0.0), 0.0);
    add_taps(sum, map, line, p, own, color, own, false);
    if (nearest > own) add_taps(sum, map, line, p, own, color, nearest, true);
    return color + sum.color / sum.weight;
}
