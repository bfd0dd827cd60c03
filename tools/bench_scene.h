/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* What `ddof bench` works on: a made-up picture, and its blur. */
#ifndef TOOLS_BENCH_SCENE_H
#define TOOLS_BENCH_SCENE_H

#include <ddof/ddof.h>
#include <stdbool.h>

#include "iris.h"
#include "options.h"

enum { SCENE_HIGHLIGHTS = 200 };

typedef struct scene {
    int width, height, channels;
    ddof_type type;
    bool planar, in_place, depth;
    size_t bytes;         /* of the picture */
    void *color, *result; /* result: where the copy and, unless in place, the picture goes */
    float *blur;          /* CoC or depth */
    iris_input iris;
    ddof_frame frame;
    ddof_settings settings;
} scene;

/* Of --channels, --type, --layout, --in-place, --coc, --depth and the options of the method. With --bokeh highlights
 * nothing is brighter than 1 but SCENE_HIGHLIGHTS squares that are as far out of focus as can be. Returns 0 or an exit code;
 * to be destroyed either way. */
int scene_create(scene *s, const options *o, int width, int height);
void scene_destroy(scene *s);

#endif
