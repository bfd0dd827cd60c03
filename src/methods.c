/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "methods.h"

#define COSINE_30 0.86602540378443865
#define TANGENT_30 0.57735026918962576

static gather_line line_of(const filled_picture *p, bool gaussian, double size, int dx, double dy) {
    gather_line l = {.gaussian = gaussian, .size = (float)size, .dx = dx, .dy = (float)dy};
    l.longest = (float)(dx ? p->width : p->height);
    l.over_step = gather_step(&l, p->nearest, &l.over_taps);
    return l;
}

void gaussian_lines(gather_line line[GAUSSIAN_LINES], const frame_job *job, const filled_picture *p) {
    line[LINE_ROW] = line_of(p, true, 0.25, 1, 0);
    line[LINE_COLUMN] = line_of(p, true, 0.25 * job->pixel_aspect, 0, 1);
}

void hexagon_lines(gather_line line[HEXAGON_LINES], const frame_job *job, const filled_picture *p) {
    const double aspect = job->pixel_aspect;
    line[LINE_UP] = line_of(p, false, 0.5 * aspect, 0, -1);
    line[LINE_LEFT] = line_of(p, false, 0.5 * COSINE_30, -1, TANGENT_30 * aspect);
    line[LINE_RIGHT] = line_of(p, false, 0.5 * COSINE_30, 1, TANGENT_30 * aspect);
}
