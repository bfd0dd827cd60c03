// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// The algebra of rows: a y[i-1] + b y[i] + c y[i+1] = g x, with g = a + b + c kept instead of b. For diffusion a, c <= 0 <= g,
// so that no sum below has terms of different sign, however large the CoC; and x is a mean of colours, never
// outside their range. The same names: src/tridiag/row.h, pack.h. A pixel that is a hole has g = 0.

struct Row {
    float a, g, c;
    vec4 x;
};

// Of a row for which nothing is known: an infinity, which is no colour. It marks lines that consist of holes.
const uint NOTHING = 0x7f800000u;

vec4 nothing() {
    return vec4(uintBitsToFloat(NOTHING));
}

float diagonal(Row r) {
    return max(r.g - r.a - r.c, 1e-35); // 0 only where a, c and x are 0, too
}

// The mean of x, y, z by their weights, which are >= 0 and have this sum.
vec4 mean(vec3 weight, float sum, vec4 x, vec4 y, vec4 z) {
    vec3 share = weight / max(sum, 1e-35);
    return share.x * x + share.y * y + share.z * z;
}

// From a to b by t; exact where t is 0 or 1, however far apart they are.
vec4 lerp(vec4 a, vec4 b, float t) {
    return a * (1.0 - t) + b * t;
}

// Row r without the unknowns of its neighbours p and n.
Row reduce(Row p, Row r, Row n) {
    float k1 = -r.a / diagonal(p), k2 = -r.c / diagonal(n);
    vec3 weight = vec3(r.g, k1 * p.g, k2 * n.g);
    float g = weight.x + weight.y + weight.z;
    return Row(k1 * p.a, g, k2 * n.c, mean(weight, g, r.x, p.x, n.x));
}

// The unknown of a row whose neighbours are known (equation 8.9, corrected). In a line of holes they are not.
vec4 substitute(Row r, vec4 y_p, vec4 y_n) {
    bool holes = floatBitsToUint(y_p.x) == NOTHING || floatBitsToUint(y_n.x) == NOTHING;
    return holes ? nothing() : mean(vec3(r.g, -r.a, -r.c), diagonal(r), r.x, y_p, y_n);
}

vec4 solve_one(Row r) {
    return r.g > 0.0 ? r.x : nothing();
}

// Rows times a factor, so that the diagonal is 1: products of the three of a line of holes would leave the range of floats.
Row normalised(Row r) {
    float b = diagonal(r);
    return Row(r.a / b, r.g / b, r.c / b, r.x);
}

vec4 solved(vec3 weight, vec4 x, vec4 y, vec4 z) {
    float sum = weight.x + weight.y + weight.z;
    return sum > 0.0 ? mean(weight, sum, x, y, z) : nothing();
}

// Unknown `which` of two, by Cramer's rule. What divides is b0 b1 - c0 a1, written as a sum of the weights.
vec4 solve_two(Row r, Row s, int which) {
    r = normalised(r);
    s = normalised(s);
    vec2 weight = which == 0 ? vec2((s.g - s.a) * r.g, -r.c * s.g) : vec2(-s.a * r.g, (r.g - r.c) * s.g);
    return solved(vec3(weight, 0.0), r.x, s.x, vec4(0.0));
}

// Unknown `which` of three. m12 and m01 are the minors of the lower and the upper two.
vec4 solve_three(Row r, Row s, Row t, int which) {
    r = normalised(r);
    s = normalised(s);
    t = normalised(t);
    float b0 = r.g - r.c, b2 = t.g - t.a;
    float m12 = (s.g - s.a) * b2 - s.c * t.g, m01 = (s.g - s.c) * b0 - s.a * r.g;
    vec3 weight = which == 0   ? vec3(m12, -r.c * b2, r.c * s.c)
                  : which == 1 ? vec3(-s.a * b2, b0 * b2, -s.c * b0)
                               : vec3(s.a * t.a, -t.a * b0, m01);
    return solved(weight * vec3(r.g, s.g, t.g), r.x, s.x, t.x);
}
