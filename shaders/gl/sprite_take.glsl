// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// The picture without the light that becomes sprites: what is diffused. What would fall out of the picture stays.
layout(location = 0) out highp vec4 rest_target;

void main() {
    ivec2 p = ivec2(gl_FragCoord.xy);
    vec4 x = color_texel(p);
    vec2 c = candidate(p);
    if (c.x != 0.0) {
        float inside = bokeh_inside(p, size, table(DIAMETER, int(node_of(abs(c.x)))), iris_aspect);
        x.rgb -= x.rgb * colors * (taken(c, raised()) * inside);
    }
    rest_target = is_finite(x) ? written(x) : nothing();
}
