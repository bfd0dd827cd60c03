#version 450
// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// Highlights: counts candidates, and adds up what they will cover, by how bright they are.

#define STATE
#define LIST readonly
#include "sprites.glsl"
#include "sprite_candidate.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

const int TILE = 32; // pixels on each side, of a workgroup: its bins are cleared and added up once

shared uint group_count[BINS], group_area[BINS], group_large;

void main() {
    uint me = gl_LocalInvocationIndex;
    for (uint i = me; i < BINS; i += 64u) group_count[i] = group_area[i] = 0u;
    if (me == 0u) group_large = 0u;
    barrier();
    ivec2 first = TILE * ivec2(gl_WorkGroupID.xy) + ivec2(gl_LocalInvocationID.xy);
    for (int i = 0; i < TILE * TILE / 64; i++) {
        ivec2 p = first + 8 * ivec2(i % (TILE / 8), i / (TILE / 8));
        if (p.x >= width || p.y >= height) continue;
        Candidate c = candidate_of(p);
        if (c.large) atomicAdd(group_large, 1u);
        if (c.share > 0.0) {
            int bin = bokeh_bin(c.v, threshold);
            float node = iris_node(abs(c.d)), across = diameter[int(node)] / float(1 << bokeh_level(node, HALF_SIZE != 0));
            atomicAdd(group_count[bin], 1u);
            atomicAdd(group_area[bin], uint(across * across * 16.0)); // at most 2^16 each
        }
    }
    barrier();
    for (uint i = me; i < BINS; i += 64u) {
        if (group_count[i] == 0u) continue;
        uint area = group_area[i];
        atomicAdd(bin_count[i], group_count[i]);
        if (atomicAdd(bin_area_low[i], area) + area < area) atomicAdd(bin_area_high[i], 1u);
    }
    if (me == 0u && group_large > 0u) atomicAdd(large, group_large);
}
