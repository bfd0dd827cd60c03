/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The shaders: one program for each stage and variant, made when it is first needed. */
#ifndef DDOF_GL_PROGRAMS_H
#define DDOF_GL_PROGRAMS_H

#include "functions.h"

/* Stages have the names of their files in shaders/gl. */
typedef enum gl_stage {
    STAGE_COC,
    STAGE_CONSTRUCT,
    STAGE_REDUCE,
    STAGE_INITIAL_REDUCE4,
    STAGE_PCR,
    STAGE_SOLVE,
    STAGE_SUBSTITUTE,
    STAGE_FINAL_SOLVE4,
    GL_STAGES
} gl_stage;

/* Where rows come from, as in shaders/gl/surfaces.glsl. */
typedef enum gl_rows { FROM_PICTURE, FROM_TABLE, FROM_PACKED, FROM_BOTH } gl_rows;

/* The #defines of a program. */
typedef struct gl_variant {
    gl_stage stage;
    gl_rows rows;
    bool vertical, shared, alpha, half;
    int depth; /* 0: the map holds CoC; else 1 + ddof_depth_kind */
    bool to_rows, to_packed, to_picture, to_half, last;
} gl_variant;

/* Texture units of the samplers. */
enum { UNIT_COLOR, UNIT_COC, UNIT_ABC, UNIT_X, UNIT_PACKED, UNIT_Y, GL_UNITS };

typedef enum gl_uniform {
    U_DEPTH_LINEAR,
    U_DEPTH_AXIS,
    U_LENS_CURVE,
    U_LENS_LIMIT,
    U_UNKNOWNS,
    U_KNOWN,
    U_SCALE,
    U_COC_DECIDES,
    U_ROWS_FOLD,
    U_Y_FOLD,
    U_TARGET_FOLD,
    U_STRIDE,
    GL_UNIFORMS
} gl_uniform;

enum { GL_UNIFORMS_MOST = 32 };

typedef struct gl_program {
    unsigned key;
    GLuint name;
    GLint uniform[GL_UNIFORMS_MOST]; /* -1: not in this one */
} gl_program;

typedef struct gl_programs {
    gl_program *program;
    int count, room;
} gl_programs;

struct ddof_gl;

/* The program of a variant, or NULL with the status and the text of what is wrong set. */
const gl_program *gl_program_get(struct ddof_gl *gl, const gl_variant *variant, ddof_status *status);

/* A program to be made, for a list: the parts of its shaders (NULL after the last, GLSL's version not among them), the names of
 * its uniforms, and those of its samplers by unit. */
typedef struct gl_source {
    const char *name, *vertex_name; /* of the files, for messages */
    const char *vertex[12], *fragment[12];
    const char *const *uniforms, *const *samplers;
    int uniform_count, sampler_count;
} gl_source;

/* NULL: it is not in the list. */
const gl_program *gl_program_find(const gl_programs *list, unsigned key);
/* Makes it and adds it to the list, or NULL, likewise. */
const gl_program *gl_program_make(struct ddof_gl *gl, gl_programs *list, unsigned key, const gl_source *source,
                                  ddof_status *status);
void gl_programs_delete(struct ddof_gl *gl, gl_programs *list);

#endif
