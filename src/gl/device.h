/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* What a ddof_gl holds. The parts: functions (of GL), programs (the shaders), surfaces (textures of the solver), methods (the classical ones), state
 * (of the caller's context), solver (the method), interop (ddof/gl.h), and for the backend of ddof_render() egl and
 * backend. */
#ifndef DDOF_GL_DEVICE_H
#define DDOF_GL_DEVICE_H

#include "../context.h"
#include "functions.h"
#include "methods.h"
#include "programs.h"
#include "sprites.h"
#include "surfaces.h"

enum { GL_CONTEXT_WAS_LOST = 0x0507 }; /* an error of ES 3.2 and KHR_robustness */

struct ddof_gl {
    ddof_gl_config config; /* all callbacks filled in, but log */
    ddof_context *owner;   /* whose error text and log are used: &shell, or the context this is the backend of */
    ddof_context shell;
    gl_functions f;
    char renderer[128];
    int max_size; /* of a texture */
    GLuint vertex_array, sampler;
    GLuint output; /* framebuffer of the caller's texture */
    GLuint probe;  /* framebuffer to look at the caller's inputs with */
    gl_programs programs;
    gl_surfaces surfaces;
    gl_methods methods;
    gl_sprites sprites;
    bool blends; /* floats of 32 bits, too */
    int64_t objects, draws;
    bool lost;
};

/* What one frame is, in GL's terms: all has been checked. */
typedef struct gl_frame {
    frame_job *job;
    const ddof_settings *settings;
    int width, height;
    GLuint color, map; /* map: depth or CoC */
    GLuint output;
    bool alpha, half_output;
    bool holes; /* there may be some */
    int colors; /* of the channels, how many are colour */
    float gain; /* what the colours are multiplied by */
} gl_frame;

/* device.c: everything but surfaces. The context must be current. On failure *gl is NULL and `text` says why. */
ddof_status gl_device_create(ddof_gl **gl, const ddof_gl_config *config, ddof_context *owner, char *text, size_t size);
void gl_device_destroy(ddof_gl **gl);
/* Marks it as lost and says so. */
ddof_status gl_device_lost(ddof_gl *gl);
/* DDOF_OK, or what GL has to complain about. */
ddof_status gl_device_check(ddof_gl *gl);
/* Forgets the errors that lie there already. */
void gl_device_clear_errors(ddof_gl *gl);

/* solver.c. Whether GL has the solver that is asked for: DDOF_OK, or UNSUPPORTED, said to the owner. */
ddof_status gl_check_solver(ddof_context *owner, const ddof_settings *settings);

/* State is the caller's to save. gl_solve: from frame->color to frame->output. gl_coc: frame->map to the
 * output, of type R32F. */
ddof_status gl_solve(ddof_gl *gl, const gl_frame *frame);
ddof_status gl_coc(ddof_gl *gl, const gl_frame *frame);

/* What passes have in common. gl_set_lens: the first four of gl_uniform. gl_attach_output: false: GL cannot draw to that texture. */
void gl_set_lens(const gl_functions *f, const GLint *uniform, const gl_frame *frame);
void gl_bind(const gl_functions *f, GLuint unit, GLuint texture);
bool gl_attach_output(ddof_gl *gl, GLuint texture);
void gl_detach_output(ddof_gl *gl);

#endif
