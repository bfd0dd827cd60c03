// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT
#version 450
#extension GL_GOOGLE_include_directive : require
#if SUBGROUPS == 1
#extension GL_KHR_shader_subgroup_shuffle : require
#endif

// A workgroup solves whole lines (docs/vulkan.md): each pixel is read once and written once, and nothing else.
//   k:1   a thread eliminates its K pixels but the last one, in registers
//   S:1   PCR by shuffles eliminates the unknowns of a subgroup but the last one
//   PCR   in shared memory, over what is left
// and back. A run of pixels between two unknowns, seen from outside, is a Link: three conductances, and two colours.
//
// Columns are solved STRIP side by side, so that neighbouring threads read neighbouring pixels.

#include "pass.glsl"

layout(constant_id = 7) const int K = 8;        // pixels of a thread
layout(constant_id = 8) const int STRIP = 1;    // lines of a workgroup
layout(constant_id = 9) const int SUBGROUP = 1; // its size, a multiple of STRIP; 1: subgroups are not used

// Threads of a subgroup that stand in one line, and the unknowns of the workgroup that shared memory holds.
const int SPAN = SUBGROUP > STRIP ? SUBGROUP / STRIP : 1;
const int ROWS = int(gl_WorkGroupSize.x) / SPAN;

shared vec4 shared_x[ROWS], shared_left_x[ROWS];
shared float shared_a[ROWS], shared_g[ROWS], shared_c[ROWS];

// How a run of pixels hangs between the unknown before it and its own last one, which is not part of it.
struct Link {
    float through; // conductance between the two
    float before;  // from the unknown before to the run's pixels
    vec4 x;        // their mean colour, as seen from there
};

float share(float part, float sum) {
    return part / max(sum, 1e-35);
}

// The pixels of this thread. A hole has the colour nothing().
#define KEEP_HALF (HALF != 0)
uvec2 kept_half[HALF != 0 ? K : 1];
vec4 kept_float[HALF != 0 ? 1 : K];
float beta[K]; // link to the next pixel

vec4 kept(int k) {
    return KEEP_HALF ? unpack_color(kept_half[k]) : kept_float[k];
}

void keep(int k, vec4 x) {
    if (KEEP_HALF)
        kept_half[k] = pack_color(x);
    else
        kept_float[k] = x;
}

float capacity(vec4 x) {
    return floatBitsToUint(x.x) == NOTHING ? 0.0 : 1.0;
}

vec4 color_of(vec4 x) { // of a hole: anything finite, its weight is 0
    return floatBitsToUint(x.x) == NOTHING ? vec4(0.0) : x;
}

// Beyond the end of the line hang holes, which take the last pixel's value and change nothing.
float padded_coc(int i, int line) {
    float d = coc_at(i, line); // read in any case: many reads under way at once, none behind a branch
    return i < unknowns ? d : NO_COC;
}

// Reads the pixels from `first` on. Returns the conductance of the link before them.
float load(int first, int line) {
    float d = padded_coc(first, line), before = link(padded_coc(first - 1, line), d);
    for (int k = 0; k < K; k++) {
        int i = first + k;
        float e = padded_coc(i + 1, line);
        vec4 x = color_at(i, line, d);
        if (i >= unknowns) x = nothing();
        beta[k] = link(d, e);
        keep(k, x);
        d = e;
    }
    return before;
}

// k:1. The last pixel's row, without its link to the next thread (c = 0), and how the others hang before it.
Row eliminate(float before, out Link run) {
    vec4 x = kept(0);
    float w = capacity(x);
    vec4 m = color_of(x);
    run = Link(before, 0.0, vec4(0.0));
    for (int k = 0; k < K - 1; k++) {
        float s = 1.0 / max(run.through + beta[k] + w, 1e-35), part = w * s; // no product of two links: it may vanish
        float left = run.through * part, right = beta[k] * part;
        run.through *= beta[k] * s;
        run.before += left;
        run.x = lerp(run.x, m, share(left, run.before));
        x = kept(k + 1);
        float g = capacity(x);
        w = g + right;
        m = lerp(m, color_of(x), share(g, w));
    }
    return Row(-run.through, w, 0.0, m);
}

// 1:k. y_before and y_last are known.
void substitute_run(int first, int line, float before, vec4 y_before, vec4 y_last) {
    vec4 m = y_before;
    float rest = before; // what the pixel is held by, besides itself
    for (int k = 0; k < K - 1; k++) {
        vec4 x = kept(k);
        float g = capacity(x), w = g + rest;
        float part = w / max(w + beta[k], 1e-35);
        m = lerp(m, color_of(x), share(g, w));
        rest = part < 0.5 ? w * (1.0 - part) : part * beta[k];
        keep(k, m);
        beta[k] = part;
    }
    vec4 y = y_last;
    if (first + K - 1 < unknowns) store_pixel(first + K - 1, line, y);
    for (int k = K - 2; k >= 0; k--) {
        y = lerp(y, kept(k), beta[k]);
        if (first + k < unknowns) store_pixel(first + k, line, y);
    }
}

// Row r beside which a run hangs after it.
Row add_after(Row r, Link run) {
    float g = r.g + run.before;
    return Row(r.a, g, -run.through, lerp(r.x, run.x, share(run.before, g)));
}

// SUBGROUPS: 0: none. 2: shuffles through shared memory, for tests: subgroups of sizes that no device at hand has.
#if SUBGROUPS == 1
int own_index() {
    return int(gl_SubgroupID) * SUBGROUP + int(gl_SubgroupInvocationID);
}

vec4 shuffle(vec4 v, uint lane) {
    return subgroupShuffle(v, lane);
}
#else
int own_index() {
    return int(gl_LocalInvocationIndex);
}
#endif

#if SUBGROUPS == 2
shared vec4 shuffled[gl_WorkGroupSize.x];

vec4 shuffle(vec4 v, uint lane) {
    int index = own_index();
    barrier();
    shuffled[index] = v;
    barrier();
    return shuffled[index / SUBGROUP * SUBGROUP + int(lane)];
}
#endif

#if SUBGROUPS
Row shuffle(Row r, uint lane) {
    vec4 agc = shuffle(vec4(r.a, r.g, r.c, 0.0), lane);
    return Row(agc.x, agc.y, agc.z, shuffle(r.x, lane));
}

Link shuffle(Link l, uint lane) {
    vec4 both = shuffle(vec4(l.through, l.before, 0.0, 0.0), lane);
    return Link(both.x, both.y, shuffle(l.x, lane));
}

// S:1. In: the rows of the threads with their runs before them. Each thread but the last of the span is left with a row that
// knows only the unknowns at both ends of the span; the last one gets its row and the first one the run as the unknown
// before the span sees it.
Row eliminate_span(Row r, inout Link run, int place, uint lane) {
    bool inner = place < SPAN - 1;
    Link next = shuffle(run, inner ? lane + STRIP : lane);
    if (inner) r = add_after(r, next);
    for (int step = 1; step < SPAN - 1; step *= 2) {
        bool has_p = inner && place >= step, has_n = inner && place + step < SPAN - 1;
        Row p = shuffle(r, has_p ? lane - STRIP * step : lane), n = shuffle(r, has_n ? lane + STRIP * step : lane);
        float k1 = has_p ? -r.a / diagonal(p) : 0.0, k2 = has_n ? -r.c / diagonal(n) : 0.0;
        vec3 weight = vec3(r.g, k1 * p.g, k2 * n.g);
        float g = weight.x + weight.y + weight.z;
        r = Row(has_p ? k1 * p.a : r.a, g, has_n ? k2 * n.c : r.c, mean(weight, g, r.x, p.x, n.x));
    }
    Row p = shuffle(r, place == SPAN - 1 ? lane - STRIP : lane);
    if (!inner) { // the last unknown without the one before it
        float k = -r.a / diagonal(p), g = r.g + k * p.g;
        r = Row(k * p.a, g, r.c, lerp(r.x, p.x, share(k * p.g, g)));
    } else if (place == 0) { // what the unknown before the span sees
        float k = run.through / diagonal(r), before = run.before + k * r.g;
        run.x = lerp(run.x, r.x, share(k * r.g, before));
        run.before = before;
        run.through = -k * r.c;
    }
    return r;
}
#endif

void to_shared(int i, Row r) {
    shared_a[i] = r.a;
    shared_g[i] = r.g;
    shared_c[i] = r.c;
    shared_x[i] = r.x;
}

Row from_shared(int i) {
    return Row(shared_a[i], shared_g[i], shared_c[i], shared_x[i]);
}

// PCR over ROWS / STRIP unknowns of each of STRIP lines. Leaves the unknowns in shared_x. All threads come here.
void solve_shared(int index) {
    barrier();
    bool mine = index < ROWS;
    Row r;
    if (mine) {
        r = from_shared(index);
        // shared_c, shared_left_x: the run before each row; the one before the next row is this row's run after it
        Link next = Link(0.0, 0.0, vec4(0.0));
        if (index + STRIP < ROWS) next = Link(-shared_a[index + STRIP], shared_c[index + STRIP], shared_left_x[index + STRIP]);
        r = add_after(r, next);
    }
    barrier();
    if (mine) to_shared(index, r);
    barrier();
    for (int step = STRIP; step < ROWS; step *= 2) {
        if (mine) {
            bool has_p = index >= step, has_n = index + step < ROWS;
            Row p = from_shared(has_p ? index - step : index), n = from_shared(has_n ? index + step : index);
            // The rows at the ends have a = 0, c = 0: what is read in the place of a neighbour is multiplied by 0.
            r = reduce(p, r, n);
        }
        barrier();
        if (mine) to_shared(index, r);
        barrier();
    }
    if (mine) shared_x[index] = solve_one(r);
    barrier();
}

void main() {
    int index = own_index();
    int column = index % STRIP, thread = index / STRIP; // its line in the strip, its place in the line
    int line = first_line + int(gl_WorkGroupID.x) * STRIP + column;
    bool outside = line >= first_line + lines;
    if (outside) line = first_line + lines - 1;
    int first = thread * K;

    float before = load(first, line);
    Link run;
    Row r = eliminate(before, run);
    int place = thread % SPAN, span = (thread / SPAN) * STRIP + column;
#if SUBGROUPS
    uint lane = uint(index % SUBGROUP);
    if (SPAN > 1) r = eliminate_span(r, run, place, lane);
#endif
    if (place == 0) {
        shared_c[span] = run.before;
        shared_left_x[span] = run.x;
    }
    if (place == SPAN - 1) {
        shared_a[span] = r.a;
        shared_g[span] = r.g;
        shared_x[span] = r.x;
    }
    solve_shared(index);

    vec4 y_before = span >= STRIP ? shared_x[span - STRIP] : vec4(0.0), y_last = shared_x[span];
    bool holes = floatBitsToUint(y_last.x) == NOTHING; // the whole line
#if SUBGROUPS
    if (SPAN > 1) {
        vec4 y = place == SPAN - 1 || holes ? y_last : mean(vec3(r.g, -r.a, -r.c), diagonal(r), r.x, y_before, y_last);
        vec4 y_left = shuffle(y, place == 0 ? lane : lane - STRIP);
        if (place > 0) y_before = y_left;
        y_last = y;
    }
#endif
    if (outside) return;
    if (holes)
        for (int k = 0; k < K && first + k < unknowns; k++) store_pixel(first + k, line, nothing());
    else
        substitute_run(first, line, before, y_before, y_last);
}
