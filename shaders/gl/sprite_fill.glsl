// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// Holes filled from around, before every pixel becomes a sprite: the pyramid of src/fill.c, for colour and CoC at once.
//   STEP     0 push: a pixel of a level from the four below it; 1 pull: what it lacks from the level above; 2 the same of the
//            last level, of one pixel, which has none above
//   PICTURE  what is read (push) or filled (pull) is the picture
uniform ivec2 summed;                         // size of the level that is read from, pull: of the one above
uniform highp sampler2D above_map;            // weighted sums of the level above
uniform highp sampler2D above_known_map;      // of CoC; weights of CoC and colour
uniform highp sampler2D filled_map;           // and what it was filled to
uniform highp sampler2D filled_coc_map;

layout(location = 0) out highp vec4 color_target;
layout(location = 1) out highp vec4 known_target; // pull: CoC

// known: of CoC; weights of CoC and of colour.
void load(ivec2 p, out vec4 color, out vec3 known) {
#if PICTURE
    float d = texelFetch(coc_map, p, 0).x;
    color = color_texel(p);
    bool has_coc = is_known(d), whole = has_coc && is_finite(color);
    if (!whole) color = vec4(0.0);
    known = vec3(has_coc ? d : 0.0, has_coc, whole);
#else
    color = texelFetch(color_map, p, 0);
    known = texelFetch(coc_map, p, 0).xyz;
#endif
}

#if STEP == 0
void main() {
    ivec2 from = 2 * ivec2(gl_FragCoord.xy), to = min(from + 2, summed);
    vec4 color = vec4(0.0), one;
    vec3 known = vec3(0.0), one_known;
    for (int y = from.y; y < to.y; y++)
        for (int x = from.x; x < to.x; x++) {
            load(ivec2(x, y), one, one_known);
            color += one;
            known += one_known;
        }
    color_target = color / max(known.z, 1.0);
    known_target = vec4(known.x / max(known.y, 1.0), min(known.yz, 1.0), 0.0);
}
#elif STEP == 1
vec4 between(highp sampler2D map, ivec2 from, ivec2 to, vec2 share) {
    vec4 top = mix(texelFetch(map, from, 0), texelFetch(map, ivec2(to.x, from.y), 0), share.x);
    vec4 bottom = mix(texelFetch(map, ivec2(from.x, to.y), 0), texelFetch(map, to, 0), share.x);
    return mix(top, bottom, share.y);
}

// How much is taken of the means that are known above, and of what these got themselves. TRUST of cpu/fill.c is 4.
vec2 takes(float above, float weight) {
    float lack = 1.0 - weight, trust = min(4.0 * above, 1.0);
    return vec2(above > 1e-30 ? lack * trust / above : 0.0, lack * (1.0 - trust));
}

void main() {
    ivec2 p = ivec2(gl_FragCoord.xy), before = (p - 1) >> 1, from = max(before, 0), to = min(before + 1, summed - 1);
    vec2 share = vec2((p.x & 1) == 1 ? 0.25 : 0.75, (p.y & 1) == 1 ? 0.25 : 0.75);
    vec4 color;
    vec3 known;
    load(p, color, known);
    vec3 above = between(above_known_map, from, to, share).xyz;
    vec2 coc = takes(above.y, known.y), colored = takes(above.z, known.z);
    color += colored.x * between(above_map, from, to, share) + colored.y * between(filled_map, from, to, share);
    known.x += coc.x * above.x + coc.y * between(filled_coc_map, from, to, share).x;
    color_target = PICTURE != 0 ? written(color) : color;
    known_target = vec4(known.x, 0.0, 0.0, 0.0);
}
#else
void main() {
    vec4 color;
    vec3 known;
    load(ivec2(gl_FragCoord.xy), color, known);
    color_target = known.z > 0.0 ? color / known.z : vec4(0.0);
    known_target = vec4(known.y > 0.0 ? known.x / known.y : 0.0, 0.0, 0.0, 0.0);
}
#endif
