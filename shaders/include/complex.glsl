// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// Complex numbers (re, im), and colours of them.

struct Color {
    vec4 re, im;
};

const Color BLACK = Color(vec4(0.0), vec4(0.0));

float size(vec2 v) { // which no square lets vanish
    return max(abs(v.x), abs(v.y));
}

vec2 times(vec2 a, vec2 b) {
    return vec2(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x);
}

// 1/v, for sizes from 1e-35 to 1e35: v is first brought to size 1. Of 0: 0.
vec2 inverse_of(vec2 v) {
    float s = 1.0 / max(size(v), 1e-35);
    vec2 n = v * s;
    return vec2(n.x, -n.y) / max(dot(n, n), 0.5) * s;
}

Color times(vec2 a, Color x) {
    return Color(a.x * x.re - a.y * x.im, a.x * x.im + a.y * x.re);
}

Color plus(Color x, Color y) {
    return Color(x.re + y.re, x.im + y.im);
}

// From x to y by t; exact where t is 0 or 1.
Color blend(Color x, Color y, vec2 t) {
    return plus(times(vec2(1.0 - t.x, -t.y), x), times(t, y));
}
