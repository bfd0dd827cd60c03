// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// What the sprites have added up to, laid on the picture.
uniform ivec2 target_size, second;
layout(location = 0) out highp vec4 picture_target;

// At a pixel of the picture whose `corner` lies there.
vec4 sum_at(highp sampler2D map, ivec2 p, ivec2 corner) {
#if HALF_SIZE
    ivec2 before = (p - 1) >> 1, from = max(before, 0), to = min(before + 1, target_size - 1);
    vec2 share = vec2((p.x & 1) == 1 ? 0.25 : 0.75, (p.y & 1) == 1 ? 0.25 : 0.75);
    vec4 above = mix(texelFetch(map, corner + from, 0), texelFetch(map, corner + ivec2(to.x, from.y), 0), share.x);
    vec4 below = mix(texelFetch(map, corner + ivec2(from.x, to.y), 0), texelFetch(map, corner + to, 0), share.x);
    return 0.25 * mix(above, below, share.y);
#else
    return texelFetch(map, corner + p, 0);
#endif
}

#if FULL
uniform highp sampler2D weight_map;

void main() {
    ivec2 p = ivec2(gl_FragCoord.xy);
    float d = texelFetch(coc_map, p, 0).x, own = is_known(d) ? bokeh_share(d) : 0.0;
    float f = sum_at(weight_map, p, ivec2(0)).x, n = sum_at(weight_map, p, second).x;
    vec4 x = color_texel(p), far = sum_at(sum_map, p, ivec2(0)) / max(f, BOKEH_EMPTY);
    vec4 near = sum_at(sum_map, p, second) / max(n, BOKEH_EMPTY);
    if (d > 0.0 && f > BOKEH_EMPTY) x = mix(x, far, own);
    if (d < 0.0 && n > BOKEH_EMPTY) x = mix(x, near, own);
    if (n > BOKEH_EMPTY) x = mix(x, near, min(n, 1.0));
    if (ALPHA == 0) x.w = 1.0;
    picture_target = written(x);
}
#else
void main() {
    ivec2 p = ivec2(gl_FragCoord.xy);
    vec4 x = color_texel(p);
    x.rgb += colors * sum_at(sum_map, p, ivec2(0)).rgb;
    picture_target = written(x);
}
#endif
