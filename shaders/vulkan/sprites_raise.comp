#version 450
// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// Highlights: the threshold that keeps within the limits, from the brightest bin down. One workgroup.

#define STATE
#define LIST readonly
#include "sprites.glsl"

layout(local_size_x = 64) in;

shared uint counts[BINS], lows[BINS], highs[BINS];

void main() {
    for (uint i = gl_LocalInvocationIndex; i < BINS; i += 64u) {
        counts[i] = bin_count[i];
        lows[i] = bin_area_low[i];
        highs[i] = bin_area_high[i];
    }
    barrier();
    if (gl_LocalInvocationIndex != 0u) return;
    uint taken = 0u, low = 0u, high = 0u, left = 0u;
    int bin = BINS;
    for (; bin > 0; bin--) {
        uint next_low = low + lows[bin - 1], next_high = high + highs[bin - 1] + (next_low < low ? 1u : 0u);
        bool fits = next_high < most_area_high || (next_high == most_area_high && next_low <= most_area_low);
        if (counts[bin - 1] > most - taken || !fits) break;
        taken += counts[bin - 1];
        low = next_low;
        high = next_high;
    }
    for (int i = 0; i < bin; i++) left += counts[i];
    raised_bin = bin;
    raised = bokeh_edge(bin, threshold);
    dropped = left;
}
