// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// A sprite as its pixels are told of it, and its rectangle, for the shaders of vertices and of geometry.

layout(location = 0) flat out vec4 sprite_middle; // in pixels of the target; CoC; the row its part begins with
layout(location = 1) flat out vec4 sprite_light;  // over its sum
layout(location = 2) flat out vec4 sprite_mask;   // diameters of red, green, blue, in pixels of the target; weight
layout(location = 3) flat out ivec3 sprite_level; // of the image's table, of each
layout(location = 4) flat out vec2 sprite_cat;    // c t of the cat's eye

struct Sprite {
    vec4 middle, light, mask;
    ivec3 level;
    vec2 cat;
};

float cats_gain_of(vec2 cat) {
    float at = min(length(cat), 1.0) * 64.0, node = min(floor(at), 63.0);
    return mix(cats_gain[int(node)], cats_gain[int(node) + 1], at - node);
}

Sprite sprite_of(uint i) {
    uvec2 place = list[sprite_at(i)];
    ivec2 p = sprite_pixel(place);
    float d = uintBitsToFloat(place.y), side = d < 0.0 ? -1.0 : 1.0, size = HALF_SIZE != 0 ? 0.5 : 1.0;
    Sprite s;
    s.middle = vec4(HALF_SIZE != 0 ? 0.5 * vec2(p) - 0.25 : vec2(p), d, FULL != 0 && d < 0.0 ? target_height : 0);
    s.cat = cats_eye * per_diagonal * vec2(float(p.x) - middle.x, (middle.y - float(p.y)) / iris_aspect);
    s.light = FULL != 0 ? color_of(p) : vec4(uintBitsToFloat(uvec3(list[3u * i + 1u], list[3u * i + 2u].x)), 0.0);
    float whole = FULL != 0 ? bokeh_share(d) : 1.0, gain = cats_eye != 0.0 ? cats_gain_of(s.cat) : 1.0;
    s.light *= whole;
    for (int c = 0; c < 3; c++) {
        float node = iris_node(abs(d) * (1.0 + side * fringe * float(1 - c)));
        float one = inverse_sum[int(node)] * gain;
        s.mask[c] = size * iris_diameter(node);
        s.level[c] = iris_level(node, HALF_SIZE != 0);
        s.light[c] *= one;
        if (c == 1) {
            s.light.a *= one;
            s.mask.w = whole * one;
        }
    }
    return s;
}

// Corner 0 to 3 of the pixels that it may cover, cut off where its part of the target ends.
vec4 sprite_corner(Sprite s, int corner) {
    float radius = 0.5 * max(s.mask.x, max(s.mask.y, s.mask.z));
    vec2 reach = vec2(radius / iris_squeeze + 2.0, (radius + 1.0) * iris_aspect + 1.0);
    vec2 sign = vec2(corner & 1, corner >> 1) * 2.0 - 1.0;
    vec2 size = vec2(target_width, target_height);
    vec2 at = clamp(s.middle.xy + 0.5 + sign * reach, vec2(0.0), size) + vec2(0.0, s.middle.w);
    return vec4(at / (size * vec2(1.0, FULL != 0 ? 2.0 : 1.0)) * 2.0 - 1.0, 0.0, 1.0);
}

void tell(Sprite s) {
    sprite_middle = s.middle;
    sprite_light = s.light;
    sprite_mask = s.mask;
    sprite_level = s.level;
    sprite_cat = s.cat;
}
