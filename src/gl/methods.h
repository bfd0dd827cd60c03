/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The classical methods (../methods.h) in pixel shaders: two passes each. */
#ifndef DDOF_GL_METHODS_H
#define DDOF_GL_METHODS_H

#include "programs.h"
#include "surfaces.h"

typedef struct gl_methods {
    gl_target target; /* of the first pass. HEXAGON: two textures */
    gl_programs programs;
    size_t bytes;
} gl_methods;

struct ddof_gl;
struct gl_frame;

/* From frame->color to frame->output; the map holds CoC, and there are no holes. State is the caller's to save. */
ddof_status gl_gaussian_render(struct ddof_gl *gl, const struct gl_frame *frame);
ddof_status gl_hexagon_render(struct ddof_gl *gl, const struct gl_frame *frame);

/* The target; programs stay. */
void gl_methods_delete(struct ddof_gl *gl);

#endif
