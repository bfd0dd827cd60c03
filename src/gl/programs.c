/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "programs.h"

#include <stdio.h>
#include <string.h>

#include "device.h"
#include "shaders.h"

static const char *const stage_file[GL_STAGES] = {
    "stages/coc.glsl", "stages/construct.glsl", "stages/reduce.glsl",     "stages/initial_reduce4.glsl",
    "stages/pcr.glsl", "stages/solve.glsl",     "stages/substitute.glsl", "stages/final_solve4.glsl",
};

static const char *const uniform_name[GL_UNIFORMS] = {
    "depth_linear", "depth_axis",  "lens_curve", "lens_limit", "unknowns",    "known",
    "scale",        "coc_decides", "rows_fold",  "y_fold",     "target_fold", "stride",
};

static const char *const sampler_name[GL_UNITS] = {"color_map", "coc_map", "abc_map", "x_map", "packed_map", "y_map"};

static unsigned variant_key(const gl_variant *v) {
    return (unsigned)v->stage | (unsigned)v->rows << 4 | (unsigned)v->vertical << 6 | (unsigned)v->shared << 7 |
           (unsigned)v->alpha << 8 | (unsigned)v->half << 10 | (unsigned)v->to_rows << 11 |
           (unsigned)v->to_packed << 12 | (unsigned)v->to_picture << 13 | (unsigned)v->last << 14 |
           (unsigned)v->to_half << 15 | (unsigned)v->depth << 16;
}

/* `part`: up to NULL. */
static GLuint compile(ddof_gl *gl, GLenum type, const char *const *part, const char *name, ddof_status *status) {
    const char *text[16] = {"#version 300 es\n"
                            "precision highp float;\n"
                            "precision highp int;\n"};
    char log[256] = "";
    GLint ok = 0;
    int parts = 1;
    for (; *part; part++) text[parts++] = *part;
    GLuint shader = gl->f.CreateShader(type);
    gl->f.ShaderSource(shader, parts, text, NULL);
    gl->f.CompileShader(shader);
    gl->f.GetShaderiv(shader, GL_COMPILE_STATUS, &ok);
    if (ok) return shader;
    gl->f.GetShaderInfoLog(shader, sizeof log, NULL, log);
    gl->f.DeleteShader(shader);
    *status = context_fail(gl->owner, DDOF_ERROR_UNSUPPORTED, "this GL (%s) does not compile the shader %s: %s",
                           gl->renderer, name, log);
    return 0;
}

static GLuint link_program(ddof_gl *gl, GLuint vertex, GLuint fragment, const char *name, ddof_status *status) {
    char log[256] = "";
    GLint ok = 0;
    GLuint program = gl->f.CreateProgram();
    gl->f.AttachShader(program, vertex);
    gl->f.AttachShader(program, fragment);
    gl->f.LinkProgram(program);
    gl->f.GetProgramiv(program, GL_LINK_STATUS, &ok);
    if (ok) return program;
    gl->f.GetProgramInfoLog(program, sizeof log, NULL, log);
    gl->f.DeleteProgram(program);
    *status = context_fail(gl->owner, DDOF_ERROR_UNSUPPORTED, "this GL (%s) does not link the shader %s: %s",
                           gl->renderer, name, log);
    return 0;
}

static GLuint build(ddof_gl *gl, const gl_source *s, ddof_status *status) {
    GLuint program = 0, fragment = 0, vertex = compile(gl, GL_VERTEX_SHADER, s->vertex, s->vertex_name, status);
    if (vertex) fragment = compile(gl, GL_FRAGMENT_SHADER, s->fragment, s->name, status);
    if (fragment) program = link_program(gl, vertex, fragment, s->name, status);
    if (vertex) gl->f.DeleteShader(vertex);
    if (fragment) gl->f.DeleteShader(fragment);
    return program;
}

static bool make_room(ddof_gl *gl, gl_programs *p, ddof_status *status) {
    if (p->count < p->room) return true;
    const int room = p->room ? 2 * p->room : 32;
    gl_program *more = gl->config.allocate(gl->config.memory_user, sizeof *more * (size_t)room);
    if (!more) {
        *status = context_fail(gl->owner, DDOF_ERROR_MEMORY, "out of memory for a list of shaders");
        return false;
    }
    if (p->program) {
        memcpy(more, p->program, sizeof *more * (size_t)p->count);
        gl->config.release(gl->config.memory_user, p->program);
    }
    p->program = more;
    p->room = room;
    return true;
}

const gl_program *gl_program_find(const gl_programs *p, unsigned key) {
    for (int i = 0; i < p->count; i++)
        if (p->program[i].key == key) return &p->program[i];
    return NULL;
}

const gl_program *gl_program_make(ddof_gl *gl, gl_programs *p, unsigned key, const gl_source *s, ddof_status *status) {
    if (!make_room(gl, p, status)) return NULL;
    gl_program *made = &p->program[p->count];
    made->key = key;
    made->name = build(gl, s, status);
    if (!made->name) return NULL;
    p->count++;
    gl->objects++;
    for (int i = 0; i < s->uniform_count; i++)
        made->uniform[i] = gl->f.GetUniformLocation(made->name, s->uniforms[i]);
    gl->f.UseProgram(made->name);
    for (int i = 0; i < s->sampler_count; i++)
        gl->f.Uniform1i(gl->f.GetUniformLocation(made->name, s->samplers[i]), i);
    return made;
}

const gl_program *gl_program_get(ddof_gl *gl, const gl_variant *v, ddof_status *status) {
    const unsigned key = variant_key(v);
    const gl_program *found = gl_program_find(&gl->programs, key);
    char defines[512];
    if (found) return found;
    snprintf(
        defines, sizeof defines,
        "#define ROWS %d\n#define VERTICAL %d\n#define SHARED %d\n#define ALPHA %d\n#define DEPTH %d\n#define HALF %d\n"
        "#define TO_ROWS %d\n#define TO_PACKED %d\n#define TO_PICTURE %d\n#define TO_HALF %d\n#define LAST %d\n",
        v->rows, v->vertical, v->shared, v->alpha, v->depth, v->half, v->to_rows, v->to_packed, v->to_picture,
        v->to_half, v->last);
    const gl_source source = {
        .name = stage_file[v->stage],
        .vertex_name = "gl/triangle.glsl",
        .vertex = {shader_text("gl/triangle.glsl")},
        .fragment = {defines, shader_text("include/coc.glsl"), shader_text("include/row.glsl"),
                     shader_text("include/pack.glsl"), shader_text("include/pixels.glsl"),
                     shader_text("include/picture.glsl"), shader_text("gl/surfaces.glsl"),
                     shader_text(stage_file[v->stage])},
        .uniforms = uniform_name,
        .samplers = sampler_name,
        .uniform_count = GL_UNIFORMS,
        .sampler_count = GL_UNITS};
    return gl_program_make(gl, &gl->programs, key, &source, status);
}

void gl_programs_delete(ddof_gl *gl, gl_programs *p) {
    for (int i = 0; i < p->count; i++)
        gl->f.DeleteProgram(p->program[i].name);
    if (p->program) gl->config.release(gl->config.memory_user, p->program);
    *p = (gl_programs){NULL, 0, 0};
}
