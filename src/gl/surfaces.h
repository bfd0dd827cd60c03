/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The textures of a solver: which there are, how large, how many bytes. Counted are all of them; the caller's picture,
 * its depth or CoC and the result are not among them. Bytes per pixel with rgba16f, for a large picture:
 *
 *                  abc or packed   x   y   both directions   horizontally diffused picture   sum
 *     cr                16         8   6         60                       8                   68
 *     cr+pack           16         -   6         44                       8                   52
 *     cr4                8         4   3         30                       8                   38
 *     cr4+pack           8         -   3         22                       8                   30
 *
 * y needs two surfaces, for the levels in turn: once a level is solved, the one before it is spent. A shared chain
 * serves both directions. */
#ifndef DDOF_GL_SURFACES_H
#define DDOF_GL_SURFACES_H

#include "functions.h"

enum { GL_LEVELS = 20, GL_TARGETS = 2 * GL_LEVELS + 10, PCR_UNKNOWNS = 64 };

/* A texture, or two that are written together, and the framebuffer to write them. */
typedef struct gl_target {
    int width, height;
    GLenum format[2]; /* 0: no second one */
    GLuint texture[2], framebuffer;
} gl_target;

/* The levels of one direction, from the first that is stored on. */
typedef struct gl_chain {
    int lines, length; /* of the picture */
    int levels;
    int unknowns[GL_LEVELS];
    gl_target *rows[GL_LEVELS];
    gl_target *y[2];   /* of levels 0, 2, 4 ... and 1, 3, 5 ... */
    gl_target *pcr[2]; /* cr+pcr: rows under way */
} gl_chain;

typedef struct gl_layout {
    int width, height, max_size;
    ddof_solver solver;
    ddof_surface surface;
    bool shared;
} gl_layout;

typedef struct gl_surfaces {
    gl_layout layout;
    gl_target target[GL_TARGETS];
    int targets;
    gl_chain chain[2];  /* along rows, along columns */
    gl_target *picture; /* horizontally diffused */
    gl_target *abc;     /* cr-vanilla: full resolution */
    size_t bytes;
} gl_surfaces;

struct ddof_gl;

bool solver_packs(ddof_solver solver);
bool solver_is_cr4(ddof_solver solver);

gl_layout gl_layout_make(int width, int height, int max_size, const ddof_settings *settings);

/* Makes its textures and framebuffer; what it has made is the caller's to delete also where it fails. */
ddof_status gl_target_make(struct ddof_gl *gl, gl_target *t);
void gl_target_delete(struct ddof_gl *gl, gl_target *t);
GLuint gl_texture_make(struct ddof_gl *gl, GLenum format, int width, int height);

/* Plans the surfaces; needs no GL. */
void gl_surfaces_plan(gl_surfaces *s, const gl_layout *layout);

/* Makes those of `layout`, unless they are there already. */
ddof_status gl_surfaces_make(struct ddof_gl *gl, const gl_layout *layout);
void gl_surfaces_delete(struct ddof_gl *gl);

#endif
