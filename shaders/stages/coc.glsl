// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// The CoC alone, signed, as the solvers use it; what is not finite marks a hole.
void main() {
    ivec2 p = ivec2(gl_FragCoord.xy);
    float d = texelFetch(coc_map, p, 0).x;
#if DEPTH
    d = depth_coc(d, vec2(p) + 0.5);
#endif
    store_y(vec4(d, 0.0, 0.0, 1.0));
}
