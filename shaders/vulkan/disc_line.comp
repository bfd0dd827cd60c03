// SPDX-FileCopyrightText: 2026 The ddof authors
// SPDX-License-Identifier: MIT
#version 450
#extension GL_GOOGLE_include_directive : require
#if SUBGROUPS == 1
#extension GL_KHR_shader_subgroup_shuffle : require
#endif

// The disc kernel (src/disc.h): one component along one direction, by the elimination of line.comp with complex numbers. What
// differs: sums of complex terms may vanish, so colours are kept as sources (q = sum of weight x), not as means; what is divided
// by is a diagonal element of a system with fewer unknowns, which cannot vanish: it lies between the directions of the
// conductances and of 1, less than half a turn apart.
//
// Diagonals are the columns of a sheared picture, which enters again on one side what leaves it on the other: as many lines as
// columns, as long, and neighbouring threads read neighbouring pixels. The link across the border conducts nothing.

#define DISC
#include "pass.glsl"
#include "../include/complex.glsl"
#include "../include/disc.glsl"

layout(constant_id = 7) const int K = 4;          // pixels of a thread
layout(constant_id = 8) const int STRIP = 1;      // lines of a workgroup
layout(constant_id = 9) const int SUBGROUP = 1;   // its size, a multiple of STRIP; 1: subgroups are not used
layout(constant_id = 10) const int FROM_REAL = 0; // what is read is the picture; else the component under way
layout(constant_id = 11) const int ADD = 0;       // LAST: to the sum of the components before

layout(set = 0, binding = 5) uniform texture2D imaginary_map;
layout(set = 0, binding = 6) uniform writeonly image2D target_imaginary_map;
layout(set = 0, binding = 7) uniform texture2D sum_map;

// Threads of a subgroup that stand in one line, and the unknowns of the workgroup that shared memory holds.
const int SPAN = SUBGROUP > STRIP ? SUBGROUP / STRIP : 1;
const int ROWS = int(gl_WorkGroupSize.x) / SPAN;

shared Color shared_q[ROWS], shared_left_q[ROWS];
shared vec2 shared_a[ROWS], shared_g[ROWS], shared_c[ROWS];

// a y_before + (g - a - c) y + c y_after = q.
struct Equation {
    vec2 a, g, c;
    Color q;
};

// How a run of pixels hangs between the unknown before it and its own last one, which is not part of it.
struct Run {
    vec2 through; // conductance between the two
    vec2 before;  // from the unknown before to the run's pixels
    Color q;      // what the pixels send there
};

vec2 diagonal(Equation r) {
    return r.g - r.a - r.c;
}

// ---- pixels

const int DIAGONAL = 2, ANTIDIAGONAL = 3; // values of VERTICAL

// `lines` is the width of the picture where lines are not rows.
ivec2 pixel(int i, int line) {
    if (VERTICAL == 0) return ivec2(i, line);
    if (VERTICAL == DIAGONAL) return ivec2((line + i) % lines, i);
    if (VERTICAL == ANTIDIAGONAL) return ivec2(lines - 1 - (lines - 1 - line + i) % lines, i);
    return ivec2(line, i);
}

// The link before pixel i, between pixels whose |CoC| are d, e.
vec2 link(int i, int line, float d, float e) {
    bool border = VERTICAL >= DIAGONAL && i < unknowns && pixel(i, line).x == (VERTICAL == DIAGONAL ? 0 : lines - 1);
    return border ? vec2(0.0) : disc_conductance(d, e);
}

// The pixels of this thread. A hole has the real part nothing().
#define KEEP_HALF (HALF != 0)
uvec4 kept_half[HALF != 0 ? K : 1];
Color kept_float[HALF != 0 ? 1 : K];
vec2 after[K]; // link to the next pixel

Color kept(int k) {
    return KEEP_HALF ? Color(unpack_color(kept_half[k].xy), unpack_color(kept_half[k].zw)) : kept_float[k];
}

void keep(int k, Color x) {
    if (KEEP_HALF)
        kept_half[k] = uvec4(pack_color(x.re), pack_color(x.im));
    else
        kept_float[k] = x;
}

vec2 capacity(Color x) {
    return vec2(floatBitsToUint(x.re.x) == NOTHING ? 0.0 : 1.0, 0.0);
}

Color color_of(Color x) { // what a pixel is a source of: a hole, of nothing
    return floatBitsToUint(x.re.x) == NOTHING ? BLACK : x;
}

// Beyond the end of the line hang holes, which take the last pixel's value and change nothing.
float padded_coc(int i, int line) {
    float d = coc_at(i, line); // read in any case: many reads under way at once, none behind a branch
    return i < unknowns ? d : NO_COC;
}

vec4 imaginary_at(int i, int line) {
    if (FROM_REAL != 0) return vec4(0.0);
    vec4 x = texelFetch(imaginary_map, color_place + pixel(min(i, unknowns - 1), line), 0);
    return ALPHA == 0 ? vec4(x.xyz, 0.0) : x;
}

// Reads the pixels from `first` on. Returns the conductance of the link before them.
vec2 load(int first, int line) {
    float d = padded_coc(first, line);
    vec2 before = link(first, line, padded_coc(first - 1, line), d);
    for (int k = 0; k < K; k++) {
        int i = first + k;
        float e = padded_coc(i + 1, line);
        Color x = Color(color_at(i, line, d), imaginary_at(i, line));
        if (i >= unknowns) x.re = nothing();
        after[k] = link(i + 1, line, d, e);
        keep(k, x);
        d = e;
    }
    return before;
}

vec4 stored(vec4 y) {
    return TARGET_HALF != 0 && is_finite(y) ? nearest_half(clamp(y, -65504.0, 65504.0)) : y;
}

// The solution at pixel i of a line. In a picture of holes there is none.
void store_pixel(int i, int line, Color y) {
    ivec2 p = color_place + pixel(i, line);
    if (LAST == 0) {
        imageStore(target_map, p, stored(y.re));
        imageStore(target_imaginary_map, p, stored(y.im));
        return;
    }
    y = color_of(y);
    vec4 result = disc_weight.x * y.re - disc_weight.y * y.im;
    if (ADD != 0) result += texelFetch(sum_map, p, 0);
    if (ALPHA == 0) result.w = 1.0;
    imageStore(target_map, p, stored(result));
}

// ---- k:1 and back, in registers

// The last pixel's equation, without its link to the next thread (c = 0), and how the others hang before it.
Equation eliminate(vec2 before, out Run run) {
    Color x = kept(0), q = color_of(x);
    vec2 w = capacity(x);
    run = Run(before, vec2(0.0), BLACK);
    for (int k = 0; k < K - 1; k++) {
        vec2 s = inverse_of(run.through + after[k] + w), left = times(run.through, s), right = times(after[k], s);
        run.through = times(run.through, right);
        run.before += times(left, w);
        run.q = plus(run.q, times(left, q));
        x = kept(k + 1);
        q = plus(color_of(x), times(right, q));
        w = capacity(x) + times(right, w);
    }
    return Equation(-run.through, w, vec2(0.0), q);
}

// y_before and y_last are known. What lies before a pixel is kept as a mean: half floats hold it, however small its share.
void substitute_run(int first, int line, vec2 before, Color y_before, Color y_last) {
    Color m = y_before;
    vec2 rest = before; // what the pixel is held by, besides itself
    for (int k = 0; k < K - 1; k++) {
        Color x = kept(k);
        vec2 g = capacity(x), w = g + rest;
        m = blend(m, color_of(x), times(g, inverse_of(w)));
        vec2 s = inverse_of(w + after[k]), part = times(w, s), other = times(after[k], s);
        rest = size(part) < size(other) ? times(w, other) : times(part, after[k]);
        keep(k, Color(storable(m.re), storable(m.im)));
        after[k] = part;
    }
    Color y = y_last;
    if (first + K - 1 < unknowns) store_pixel(first + K - 1, line, y);
    for (int k = K - 2; k >= 0; k--) {
        y = blend(y, kept(k), after[k]);
        if (first + k < unknowns) store_pixel(first + k, line, y);
    }
}

// ---- S:1, in subgroups

// Equation r beside which a run hangs after it.
Equation add_after(Equation r, Run run) {
    return Equation(r.a, r.g + run.before, -run.through, plus(r.q, run.q));
}

// Equation r without the unknown of p before it, without the one of n after it.
Equation without_before(Equation r, Equation p) {
    vec2 k = -times(r.a, inverse_of(diagonal(p)));
    return Equation(times(k, p.a), r.g + times(k, p.g), r.c, plus(r.q, times(k, p.q)));
}

Equation without_after(Equation r, Equation n) {
    vec2 k = -times(r.c, inverse_of(diagonal(n)));
    return Equation(r.a, r.g + times(k, n.g), times(k, n.c), plus(r.q, times(k, n.q)));
}

// The unknown of r, with its neighbours known.
Color solution(Equation r, Color y_before, Color y_after) {
    Color q = plus(r.q, plus(times(-r.a, y_before), times(-r.c, y_after)));
    return times(inverse_of(diagonal(r)), q);
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
Color shuffle(Color x, uint lane) {
    vec4 re = shuffle(x.re, lane);
    return Color(re, shuffle(x.im, lane));
}

Equation shuffle(Equation r, uint lane) {
    vec4 ag = shuffle(vec4(r.a, r.g), lane), c = shuffle(vec4(r.c, 0.0, 0.0), lane);
    return Equation(ag.xy, ag.zw, c.xy, shuffle(r.q, lane));
}

Run shuffle(Run l, uint lane) {
    vec4 both = shuffle(vec4(l.through, l.before), lane);
    return Run(both.xy, both.zw, shuffle(l.q, lane));
}

// In: the equations of the threads with their runs before them. Each thread but the last of the span is left with one that
// knows only the unknowns at both ends of the span; the last one gets its equation and the first one the run as the unknown
// before the span sees it.
Equation eliminate_span(Equation r, inout Run run, int place, uint lane) {
    bool inner = place < SPAN - 1;
    Run next = shuffle(run, inner ? lane + STRIP : lane);
    if (inner) r = add_after(r, next);
    for (int step = 1; step < SPAN - 1; step *= 2) {
        bool has_p = inner && place >= step, has_n = inner && place + step < SPAN - 1;
        Equation p = shuffle(r, has_p ? lane - STRIP * step : lane), n = shuffle(r, has_n ? lane + STRIP * step : lane);
        if (has_p) r = without_before(r, p);
        if (has_n) r = without_after(r, n);
    }
    Equation p = shuffle(r, place == SPAN - 1 ? lane - STRIP : lane);
    if (!inner) {
        r = without_before(r, p);
    } else if (place == 0) {
        vec2 k = times(run.through, inverse_of(diagonal(r)));
        run = Run(-times(k, r.c), run.before + times(k, r.g), plus(run.q, times(k, r.q)));
    }
    return r;
}
#endif

// ---- PCR, in shared memory

void to_shared(int i, Equation r) {
    shared_a[i] = r.a;
    shared_g[i] = r.g;
    shared_c[i] = r.c;
    shared_q[i] = r.q;
}

Equation from_shared(int i) {
    return Equation(shared_a[i], shared_g[i], shared_c[i], shared_q[i]);
}

// Over ROWS / STRIP unknowns of each of STRIP lines. Leaves the unknowns in shared_q. All threads come here.
void solve_shared(int index) {
    barrier();
    bool mine = index < ROWS;
    Equation r;
    if (mine) {
        r = from_shared(index);
        // shared_c, shared_left_q: the run before each unknown; the one before the next unknown is this one's run after it
        Run next = Run(vec2(0.0), vec2(0.0), BLACK);
        if (index + STRIP < ROWS)
            next = Run(-shared_a[index + STRIP], shared_c[index + STRIP], shared_left_q[index + STRIP]);
        r = add_after(r, next);
    }
    barrier();
    if (mine) to_shared(index, r);
    barrier();
    for (int step = STRIP; step < ROWS; step *= 2) {
        if (mine) {
            if (index >= step) r = without_before(r, from_shared(index - step));
            if (index + step < ROWS) r = without_after(r, from_shared(index + step));
        }
        barrier();
        if (mine) to_shared(index, r);
        barrier();
    }
    if (mine) {
        shared_q[index] = times(inverse_of(r.g), r.q);
        if (!(size(r.g) > 0.0)) shared_q[index].re = nothing();
    }
    barrier();
}

void main() {
    int index = own_index();
    int column = index % STRIP, thread = index / STRIP; // its line in the strip, its place in the line
    int line = first_line + int(gl_WorkGroupID.x) * STRIP + column;
    bool outside = line >= first_line + lines;
    if (outside) line = first_line + lines - 1;
    int first = thread * K;

    vec2 before = load(first, line);
    Run run;
    Equation r = eliminate(before, run);
    int place = thread % SPAN, span = (thread / SPAN) * STRIP + column;
#if SUBGROUPS
    uint lane = uint(index % SUBGROUP);
    if (SPAN > 1) r = eliminate_span(r, run, place, lane);
#endif
    if (place == 0) {
        shared_c[span] = run.before;
        shared_left_q[span] = run.q;
    }
    if (place == SPAN - 1) {
        shared_a[span] = r.a;
        shared_g[span] = r.g;
        shared_q[span] = r.q;
    }
    solve_shared(index);

    Color y_before = BLACK, y_last = shared_q[span];
    if (span >= STRIP) y_before = shared_q[span - STRIP];
    bool holes = floatBitsToUint(y_last.re.x) == NOTHING; // the whole line
#if SUBGROUPS
    if (SPAN > 1) {
        Color y = y_last;
        if (place < SPAN - 1 && !holes) y = solution(r, y_before, y_last);
        Color y_left = shuffle(y, place == 0 ? lane : lane - STRIP);
        if (place > 0) y_before = y_left;
        y_last = y;
    }
#endif
    if (outside) return;
    if (holes)
        for (int k = 0; k < K && first + k < unknowns; k++) store_pixel(first + k, line, Color(nothing(), vec4(0.0)));
    else
        substitute_run(first, line, before, y_before, y_last);
}
