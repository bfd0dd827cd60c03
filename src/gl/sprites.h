/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Stage bokeh in pixel shaders (docs/gl.md, Sprites): what the sprites need beyond the solver. */
#ifndef DDOF_GL_SPRITES_H
#define DDOF_GL_SPRITES_H

#include "../bokeh.h"
#include "programs.h"
#include "surfaces.h"

enum { SPRITE_BLOCK = 16, SPRITE_SUMS = 4 /* levels of sums by blocks of 16 x 16 */, SPRITE_FILLS = 17 };
enum { SPRITE_TARGETS = 3 + SPRITE_SUMS + 2 + 2 * SPRITE_FILLS };
enum { SPRITE_UNIT_TABLE = 4 }; /* texture unit of the table */

typedef struct sprite_layout {
    int width, height;
    ddof_surface surface; /* of the picture without highlights */
    bool full, fills;     /* fills: holes, of FULL */
    int first, levels;    /* of the pictures that sprites are added up in (bokeh.h) */
    bool blends;          /* floats of 32 bits are added up; else of 16 */
} sprite_layout;

typedef struct gl_sprites {
    sprite_layout layout;
    gl_target pixels;             /* CoC, and of HIGHLIGHTS the candidates */
    gl_target rest;               /* HIGHLIGHTS: the picture without their light, then diffused */
    gl_target light;              /* sums of the sprites, and of FULL of what they weigh */
    GLint place[BOKEH_LEVELS][4]; /* of the levels in it, width and height */
    GLint second[2];              /* where those of the near sprites begin */
    gl_target sums[SPRITE_SUMS];  /* by blocks */
    int sum_levels;
    gl_target budget[2];                                          /* the search for the threshold, in turn */
    gl_target filled_from[SPRITE_FILLS], filled_to[SPRITE_FILLS]; /* from level 1 on, and from the picture on */
    int fills;                                                    /* the last level */
    GLuint table;                                                 /* of the iris */
    iris_shape shape;                                             /* that it holds */
    bool filled;
    size_t bytes;
    gl_programs programs;
} gl_sprites;

struct ddof_gl;
struct gl_frame;

/* sprite_surfaces.c. Plans the surfaces; needs no GL. holes: there may be some. max_size: of a texture. */
void gl_sprites_plan(gl_sprites *s, const frame_job *job, bool holes, int max_size, bool blends);
/* Makes them, unless they are there already; fills the table, unless it is. */
ddof_status gl_sprites_make(struct ddof_gl *gl, const frame_job *job, bool holes);
void gl_sprites_fill_table(struct ddof_gl *gl, const iris *from);
void gl_sprites_delete(struct ddof_gl *gl);

/* From frame->color to frame->output, with the diffusion in between where the job has highlights. State is the caller's
 * to save, blending with it. */
ddof_status gl_sprites_render(struct ddof_gl *gl, const struct gl_frame *frame);

/* Waits for it and fills in what the job counts. Changes what is bound to read from. */
ddof_status gl_sprites_count(struct ddof_gl *gl, const struct gl_frame *frame);

#endif
