/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "line.h"

enum { MOST = 64 }; /* pixels of a thread; more would take minutes to compile */

typedef struct line_cost {
    int few;           /* pixels of a thread that any GPU holds in registers, and enough to make the rest cheap */
    int many;          /* beyond it they spill: rather fewer lines side by side */
    int unknown_bytes; /* of shared memory: shared_x, shared_left_x, shared_a, _g, _c of line.comp */
} line_cost;

static const line_cost real = {8, 24, 44}, complex = {4, 12, 88};

static int round_up(int n, int unit) {
    return (n + unit - 1) / unit * unit;
}

/* With this strip, or false. Workgroups are whole subgroups. */
static bool try_strip(line_plan *plan, const line_limits *limits, const line_cost *cost, int length, int strip) {
    const int subgroup = limits->subgroup % strip == 0 ? limits->subgroup : 1;
    const int unit = subgroup > strip ? subgroup : strip, span = subgroup > strip ? subgroup / strip : 1;
    int most = limits->workgroup / unit * unit; /* threads */
    if (subgroup > 1 && most / subgroup > limits->subgroups) most = limits->subgroups * subgroup;
    if (most / span * cost->unknown_bytes > limits->shared_bytes)
        most = limits->shared_bytes / cost->unknown_bytes * span / unit * unit;
    if (most < unit) return false;
    const int k = (length + most / strip - 1) / (most / strip);
    if (k > MOST || (strip > 1 && k > cost->many)) return false;
    *plan = (line_plan){k > cost->few ? k : cost->few, 0, strip, subgroup};
    plan->workgroup = round_up((length + plan->k - 1) / plan->k * strip, unit);
    return true;
}

bool line_plan_make(line_plan *plan, const line_limits *limits, bool is_complex, int length, int strip) {
    for (; strip >= 1; strip /= 2)
        if (try_strip(plan, limits, is_complex ? &complex : &real, length, strip)) return true;
    return false;
}
