#version 450
// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// Highlights: counts candidates, and adds up their CoC^2, by how bright they are.

#define STATE
#define LIST readonly
#include "sprites.glsl"
#include "sprite_candidate.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

shared uint group_count[BINS], group_area_low[BINS], group_area_high[BINS], group_large;

void main() {
    uint me = gl_LocalInvocationIndex;
    for (uint i = me; i < BINS; i += 64u) group_count[i] = group_area_low[i] = group_area_high[i] = 0u;
    if (me == 0u) group_large = 0u;
    barrier();
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (p.x < width && p.y < height) {
        Candidate c = candidate_of(p);
        if (c.large) atomicAdd(group_large, 1u);
        if (c.share > 0.0) {
            int bin = bokeh_bin(c.v, threshold);
            uint area = uint(c.d * c.d * 64.0 + 0.5); // |d| <= 4096: 2^30
            atomicAdd(group_count[bin], 1u);
            if (atomicAdd(group_area_low[bin], area) + area < area) atomicAdd(group_area_high[bin], 1u);
        }
    }
    barrier();
    for (uint i = me; i < BINS; i += 64u) {
        if (group_count[i] == 0u) continue;
        uint area = group_area_low[i];
        uint carry = atomicAdd(bin_area_low[i], area) + area < area ? 1u : 0u;
        atomicAdd(bin_count[i], group_count[i]);
        if (group_area_high[i] + carry > 0u) atomicAdd(bin_area_high[i], group_area_high[i] + carry);
    }
    if (me == 0u && group_large > 0u) atomicAdd(large, group_large);
}
