/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The GL solvers of `ddof bench --table`, timed alone: textures go in, a texture comes out, nothing is uploaded or read
 * back in between. One picture, one renderer for each solver, so that none makes surfaces while it is timed. */
#ifndef TOOLS_BENCH_GL_H
#define TOOLS_BENCH_GL_H

#include <ddof/gl.h>

#include "bench_scene.h"

typedef struct bench_gl bench_gl;

/* Uploads the scene's picture (float, interleaved, 4 channels). NULL: `why` says so. Its GL context is current until
 * bench_gl_destroy(); one at a time. */
bench_gl *bench_gl_create(const scene *s, ddof_surface surface, char *why, size_t size);
void bench_gl_destroy(bench_gl **gl);

/* One solve by the renderer of `slot` (0 to BENCH_GL_SLOTS - 1, made when first used), from its call to the end of
 * glFinish(). Returns 0, or an exit code after saying why. */
enum { BENCH_GL_SLOTS = 8 };
int bench_gl_solve(bench_gl *gl, int slot, const ddof_settings *settings, double *ms, ddof_gl_stats *stats);

#endif
