/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* ddof_render() on a backend with a device against the float64 reference: every solver on every surface. */
#ifndef TESTS_GPU_RENDER_H
#define TESTS_GPU_RENDER_H

#include "support.h"

/* What a backend promises, defined by the program that tests it. */
typedef struct gpu_promise {
    ddof_backend backend;
    ddof_solver solvers[8];
    int solver_count;
    int patterns; /* of CoC */
    void (*fill_coc)(float *coc, int width, int height, int pattern, rng *r);
    /* The error allowed, of the range of the colours. */
    double (*tolerance)(const scene *s, const ddof_settings *settings, double aspect);
    double coc_difference; /* between blurring from depth and from the CoC made of it */
    bool shared_chain;     /* there is one to ask for */
    int step;              /* 1: all sizes */
} gpu_promise;
extern const gpu_promise promise;

typedef struct pair {
    ddof_context *gpu, *reference;
} pair;
pair pair_make(void);
void pair_destroy(pair *p);

scene gpu_scene(int width, int height, int pattern, color_pattern color, rng *r);

/* Renders on the device; fails where it is farther from `want`, RGBA, than `allowed` of the range. */
void gpu_compare(const pair *p, const scene *s, const ddof_frame *frame, const ddof_settings *settings,
                 const float *want, double allowed);

/* The same for all solvers on both surfaces, to what is promised. */
void gpu_all_solvers(const pair *p, const scene *s, const ddof_frame *frame, ddof_settings settings, rng *r);

/* What the reference makes of the frame, RGBA; fenced_free() it. */
float *gpu_wanted(const pair *p, const ddof_frame *frame, const ddof_settings *settings);

/* ---- tests */

void gpu_sizes(void **state);    /* 1..67 along rows, along columns, and both */
void gpu_patterns(void **state); /* every pattern of CoC with every one of colours */
void gpu_ramp(void **state);     /* no band */
void gpu_depth(void **state);    /* depth, lens and CoC say the same */
void gpu_holes(void **state);
void gpu_brightness(void **state);
void gpu_images(void **state); /* channels, straight alpha, half floats, planes, upside down, in place */

#endif
