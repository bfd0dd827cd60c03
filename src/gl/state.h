/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* All state of the caller's context that a frame touches. */
#ifndef DDOF_GL_STATE_H
#define DDOF_GL_STATE_H

#include "device.h"

enum { STATE_CAPS = 10, STATE_BUFFERS = 8, STATE_BLENDS = 6, STATE_UNPACKS = 4 };

typedef struct gl_state {
    GLint program, vertex_array, framebuffer, active_texture, viewport[4];
    GLint texture[GL_UNITS], sampler[GL_UNITS];
    GLboolean cap[STATE_CAPS], mask[4];
    int buffers; /* whose blending and masks are set one by one; 0: this context cannot */
    GLboolean blend[STATE_BUFFERS], buffer_mask[STATE_BUFFERS][4];
    GLint blending[STATE_BUFFERS][STATE_BLENDS]; /* the first alone where `buffers` is 0 */
    GLint unpack_buffer, unpack[STATE_UNPACKS];
} gl_state;

void gl_state_save(const ddof_gl *gl, gl_state *s);
/* Sets what the passes want, other than program, targets and textures. */
void gl_state_set(const ddof_gl *gl);
void gl_state_restore(const ddof_gl *gl, const gl_state *s);

#endif
