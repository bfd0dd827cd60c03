// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// The CoC of every pixel, and which are candidates: bright ones, with the CoC of the brightest pixel around.
layout(location = 0) out highp float coc_target;

// FULL: limited.
float coc_of(ivec2 p) {
    float d = texelFetch(coc_map, p, 0).x;
#if DEPTH
    d = depth_coc(d, vec2(p) + 0.5);
#endif
    float most = FULL != 0 ? largest : COC_LIMIT;
    return is_finite(d) ? clamp(d, -most, most) : NO_COC;
}

#if FULL
void main() {
    coc_target = coc_of(ivec2(gl_FragCoord.xy));
}
#else
layout(location = 1) out highp vec2 candidate_target;

float brightest_coc(ivec2 p) {
    ivec2 from = max(p - BOKEH_REACH, 0), to = min(p + BOKEH_REACH, size - 1);
    float most = -1.0, found = 0.0;
    for (int y = from.y; y <= to.y; y++)
        for (int x = from.x; x <= to.x; x++) {
            vec4 color = color_texel(ivec2(x, y));
            float v = brightness(color);
            if (!(v > most) || !is_finite(color)) continue;
            float d = coc_of(ivec2(x, y));
            if (!is_known(d)) continue;
            most = v;
            found = d;
        }
    return found;
}

void main() {
    ivec2 p = ivec2(gl_FragCoord.xy);
    vec4 color = color_texel(p);
    float v = brightness(color), d = coc_of(p);
    coc_target = d;
    candidate_target = vec2(0.0);
    if (v > threshold && is_finite(color) && is_known(d)) {
        float found = brightest_coc(p);
        if (bokeh_share(found) > 0.0) candidate_target = vec2(found, v);
    }
}
#endif
