// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT

// The search for the raised threshold, by halving: of two bins, and those between, it is the edge of one. Three passes in turn: candidates are
// counted by blocks of BLOCK x BLOCK pixels, the sums are summed until one block is left, and what it says halves the range. Sums
// of the few of a block are exact, and need no blending.
const int BLOCK = 16;
uniform ivec2 summed; // how many sums there are
uniform vec2 most;    // sprites, and their area
uniform bool final;   // the threshold is known: count what is above it

layout(location = 0) out highp vec4 sum_target;

// The bin under test; all first, which nearly always suffices. z: whether a test has been made.
float tested(vec4 budget) {
    return budget.z == 0.0 ? budget.x : floor((budget.x + budget.y) * 0.5);
}

vec4 sum_of_block(ivec2 from) {
    ivec2 to = min(from + BLOCK, summed);
    vec4 sum = vec4(0.0);
    for (int y = from.y; y < to.y; y++)
        for (int x = from.x; x < to.x; x++) sum += texelFetch(sum_map, ivec2(x, y), 0);
    return sum;
}

#if STEP == 0
// The square around a sprite, where it is drawn, in sixteenths of a pixel, cut off as on the CPU.
float area_of(float coc) {
    float node = node_of(abs(coc)), across = table(DIAMETER, int(node)) / float(1 << bokeh_level(node, first_level > 0));
    return floor(across * across * 16.0) * 0.0625;
}

// Those above the edge, and their area; all; those too large.
vec4 count_of(vec2 c, float edge) {
    if (c.x == 0.0) return vec4(0.0);
#if !FULL
    if (abs(c.x) > largest) return vec4(0.0, 0.0, 0.0, 1.0);
#endif
    return c.y > edge || FULL != 0 ? vec4(1.0, area_of(c.x), 1.0, 0.0) : vec4(0.0, 0.0, 1.0, 0.0);
}

void main() {
    vec4 budget = texelFetch(budget_map, ivec2(0), 0);
    float edge = edge_of(final ? budget.y : tested(budget));
    ivec2 from = ivec2(gl_FragCoord.xy) * BLOCK, to = min(from + BLOCK, size);
    if (!final && budget.x == budget.y) to = from; // found already
    vec4 sum = vec4(0.0);
    for (int y = from.y; y < to.y; y++)
        for (int x = from.x; x < to.x; x++) sum += count_of(candidate(ivec2(x, y)), edge);
    sum_target = sum;
}
#elif STEP == 1
void main() {
    sum_target = sum_of_block(ivec2(gl_FragCoord.xy) * BLOCK);
}
#else
void main() {
    vec4 budget = texelFetch(budget_map, ivec2(0), 0), sum = sum_of_block(ivec2(0));
    float bin = tested(budget);
    bool fits = sum.x <= most.x && sum.y <= most.y;
    vec2 range = fits ? vec2(budget.x, bin) : vec2(bin + 1.0, budget.y);
    sum_target = vec4(budget.x < budget.y ? range : budget.xy, 1.0, 0.0);
}
#endif
