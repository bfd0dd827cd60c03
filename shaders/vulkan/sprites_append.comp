#version 450
// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// Lists the sprites. Of highlights it also writes what is left of each pixel, unless colour and target are one image, whose pixels
// neighbours still look at: then sprites_take.comp does that.

#define STATE
#define LIST
#include "sprites.glsl"
#include "../include/row.glsl"
#include "../include/pack.glsl"
#include "sprite_candidate.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 2) uniform writeonly image2D target_map;

shared uint group_count, group_first, group_room;

// A place in the list, or `most`: it is full. All threads of a workgroup call it.
uint place_in_list(bool wanted) {
    if (ARGUMENTS != 0) {
        if (!wanted) return most;
        uint i = atomicAdd(arguments[POINTS != 0 ? 0 : 1], 1u);
        if (i >= most) atomicAdd(arguments[POINTS != 0 ? 0 : 1], 0xffffffffu);
        return min(i, most);
    }
    if (gl_LocalInvocationIndex == 0u) group_count = 0u;
    barrier();
    uint mine = wanted ? atomicAdd(group_count, 1u) : 0u;
    barrier();
    if (gl_LocalInvocationIndex == 0u) {
        group_first = atomicAdd(count, group_count);
        group_room = group_first < most ? min(most - group_first, group_count) : 0u;
        if (group_room < group_count) atomicAdd(count, group_room - group_count);
    }
    barrier();
    return wanted && mine < group_room ? group_first + mine : most;
}

void use_level(float d) {
    uint bit = 1u << bokeh_level(iris_node(d), HALF_SIZE != 0);
    if ((used_levels & bit) == 0u) atomicOr(used_levels, bit);
}

void append_full(ivec2 p, bool inside) {
    vec4 color = vec4(0.0);
    float d = 0.0;
    if (inside) filled(p, color, d);
    uint i = place_in_list(bokeh_share(d) > 0.0);
    if (i >= most) return;
    list[i] = sprite_place(p, d);
    use_level(abs(d));
}

void append_highlight(ivec2 p, bool inside) {
    Candidate c = Candidate(vec4(0.0), 0.0, 0.0, 0.0, false);
    if (inside) c = candidate_of(p);
    // the bin decides, as it has been counted; at its edge rounding may leave nothing
    bool wanted = c.share > 0.0 && bokeh_bin(c.v, threshold) >= raised_bin && c.v > raised;
    uint i = place_in_list(wanted);
    if (wanted && i >= most) atomicAdd(dropped, 1u);
    float below = raised / c.v;
    vec3 shining = c.color.rgb * (c.share * (1.0 - below * below)) * vec3(1.0, colors > 1, colors > 2);
    if (i < most) {
        list[3u * i] = sprite_place(p, c.d);
        float taken = bokeh_inside(p, ivec2(width, height), diameter[int(iris_node(abs(c.d)))], iris_aspect);
        list[3u * i + 1u] = floatBitsToUint(shining.rg);
        list[3u * i + 2u] = floatBitsToUint(vec2(shining.b, taken));
        c.color.rgb -= taken * shining;
        use_level(abs(c.d));
    }
    if (REMAINDER == 0 || !inside) return;
    if (TARGET_HALF != 0 && is_finite(c.color)) c.color = nearest_half(clamp(c.color, -65504.0, 65504.0));
    imageStore(target_map, color_place + p, c.color);
}

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    bool inside = p.x < width && p.y < height;
    if (FULL != 0)
        append_full(p, inside);
    else
        append_highlight(p, inside);
}
