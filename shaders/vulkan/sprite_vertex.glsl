// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// A sprite as its pixels are told of it, and its rectangle, for the shaders of vertices and of geometry.

layout(location = 0) flat out vec3 sprite_middle; // in pixels of its level; CoC
layout(location = 1) flat out vec4 sprite_light;  // over its sum
layout(location = 2) flat out vec4 sprite_mask;   // diameters of red, green, blue, in pixels of its level; weight
layout(location = 3) flat out ivec3 sprite_level; // of the image's table, of each
layout(location = 4) flat out vec2 sprite_cat;    // c t of the cat's eye
layout(location = 5) flat out ivec3 sprite_origin; // of its level; the level

struct Sprite {
    vec3 middle;
    vec4 light, mask;
    ivec3 level;
    vec2 cat;
    ivec2 origin;
    int size; // its level
};

float cats_gain_of(vec2 cat) {
    float at = min(length(cat), 1.0) * 64.0, node = min(floor(at), 63.0);
    return mix(cats_gain[int(node)], cats_gain[int(node) + 1], at - node);
}

Sprite sprite_of(uint i) {
    uvec2 place = list[sprite_at(i)];
    ivec2 p = sprite_pixel(place);
    float d = uintBitsToFloat(place.y), side = d < 0.0 ? -1.0 : 1.0, whole = 1.0, unknown;
    Sprite s;
    if (FULL != 0) {
        whole = bokeh_share(d);
        filled(p, s.light, unknown);
        s.light *= whole;
    } else {
        s.light = vec4(uintBitsToFloat(uvec3(list[3u * i + 1u], list[3u * i + 2u].x)), 0.0);
    }
    s.size = bokeh_level(iris_node(abs(d)), HALF_SIZE != 0);
    s.origin = level_origin(s.size) + ivec2(0, FULL != 0 && d < 0.0 ? part_height : 0);
    s.middle = vec3(s.size > 0 ? 0.5 * vec2(p >> (s.size - 1)) - 0.25 : vec2(p), d);
    s.cat = cats_eye * per_diagonal * vec2(float(p.x) - middle.x, (middle.y - float(p.y)) / iris_aspect);
    float gain = cats_eye != 0.0 ? cats_gain_of(s.cat) : 1.0;
    ivec2 place_at = s.size > 0 ? (p >> (s.size - 1)) & 1 : ivec2(0); // iris_sum() of src/iris.h
    int sums = (d < 0.0 ? 5 : 0) + (s.size > 0 ? 1 + place_at.x + 2 * place_at.y : 0);
    for (int c = 0; c < 3; c++) {
        int node = int(iris_node(abs(d) * (1.0 + side * fringe * float(1 - c)))) - 64 * max(s.size - 1, 0);
        float one = inverse_sum[833 * sums + node] * gain;
        s.mask[c] = diameter[node] * (s.size > 0 ? 0.5 : 1.0);
        s.level[c] = iris_level(float(node), s.size > 0);
        s.light[c] *= one;
        if (c != 1) continue;
        s.light.a *= one;
        s.mask.w = whole * one;
    }
    return s;
}

// Corner 0 to 3 of the pixels that it may cover, cut off where its level ends.
vec4 sprite_corner(Sprite s, int corner) {
    float radius = 0.5 * iris_reach * max(s.mask.x, max(s.mask.y, s.mask.z));
    vec2 reach = vec2(radius / iris_squeeze + 2.0, (radius + 1.0) * iris_aspect + 1.0);
    vec2 way = vec2(corner & 1, corner >> 1) * 2.0 - 1.0;
    vec2 at = clamp(s.middle.xy + 0.5 + way * reach, vec2(0.0), vec2(level_size(s.size))) + vec2(s.origin);
    return vec4(at / vec2(target_width, FULL != 0 ? 2 * part_height : part_height) * 2.0 - 1.0, 0.0, 1.0);
}

void tell(Sprite s) {
    sprite_middle = s.middle;
    sprite_light = s.light;
    sprite_mask = s.mask;
    sprite_level = s.level;
    sprite_cat = s.cat;
    sprite_origin = ivec3(s.origin, s.size);
}
