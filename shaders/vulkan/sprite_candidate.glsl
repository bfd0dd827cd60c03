// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// Which pixels are candidates for highlights (src/bokeh.h). Each of the two passes that ask comes to the same answer.

struct Candidate {
    vec4 color;
    float v, d; // the largest of R, G, B; CoC of the brightest pixel near it
    float share; // what of the light is a sprite's; 0: none
    bool large;  // it would be one, but for its size
};

// The CoC of the brightest pixel around p, which is one of them.
float brightest_coc(ivec2 p) {
    float best = uintBitsToFloat(0xff800000u), found = 0.0;
    for (int y = max(p.y - BOKEH_REACH, 0); y <= min(p.y + BOKEH_REACH, height - 1); y++)
        for (int x = max(p.x - BOKEH_REACH, 0); x <= min(p.x + BOKEH_REACH, width - 1); x++) {
            vec4 color = color_of(ivec2(x, y));
            float d = coc_of(ivec2(x, y)), v = brightness_of(color);
            if (is_finite(color) && is_finite(d) && v > best) {
                best = v;
                found = d;
            }
        }
    return found;
}

Candidate candidate_of(ivec2 p) {
    Candidate c = Candidate(color_of(p), 0.0, 0.0, 0.0, false);
    c.v = brightness_of(c.color);
    if (!is_finite(c.color) || !(c.v > threshold) || !is_finite(coc_of(p))) return c;
    c.d = brightest_coc(p);
    float share = bokeh_share(c.d);
    c.large = share > 0.0 && abs(c.d) > largest;
    c.share = c.large ? 0.0 : share;
    return c;
}
