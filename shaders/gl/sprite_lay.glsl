// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// What the sprites have added up to, laid on the picture.
layout(location = 0) out highp vec4 picture_target;

// At a pixel of the picture, all levels; `corner`: 0, or where the near ones begin.
vec4 sum_at(highp sampler2D map, ivec2 p, ivec2 corner) {
    vec4 sum = vec4(0.0);
    for (int level = first_level; level < levels; level++) {
        float scale = 1.0 / float(1 << level);
        vec2 at = (vec2(p) + 0.5) * scale - 0.5, before = floor(at), share = at - before;
        ivec2 from = max(ivec2(before), 0), to = min(ivec2(before) + 1, place[level].zw - 1), base = corner + place[level].xy;
        vec4 above = mix(texelFetch(map, base + from, 0), texelFetch(map, base + ivec2(to.x, from.y), 0), share.x);
        vec4 below = mix(texelFetch(map, base + ivec2(from.x, to.y), 0), texelFetch(map, base + to, 0), share.x);
        sum += scale * scale * mix(above, below, share.y);
    }
    return sum;
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
