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

static GLuint compile(ddof_gl *gl, GLenum type, const char *const *part, int parts, const char *name,
                      ddof_status *status) {
    char log[256] = "";
    GLint ok = 0;
    GLuint shader = gl->f.CreateShader(type);
    gl->f.ShaderSource(shader, parts, part, NULL);
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

static GLuint build(ddof_gl *gl, const gl_variant *v, ddof_status *status) {
    static const char version[] = "#version 300 es\n"
                                  "precision highp float;\n"
                                  "precision highp int;\n";
    char defines[512];
    snprintf(
        defines, sizeof defines,
        "#define ROWS %d\n#define VERTICAL %d\n#define SHARED %d\n#define ALPHA %d\n#define DEPTH %d\n#define HALF %d\n"
        "#define TO_ROWS %d\n#define TO_PACKED %d\n#define TO_PICTURE %d\n#define TO_HALF %d\n#define LAST %d\n",
        v->rows, v->vertical, v->shared, v->alpha, v->depth, v->half, v->to_rows, v->to_packed, v->to_picture,
        v->to_half, v->last);
    const char *name = stage_file[v->stage];
    const char *vertex_part[] = {version, shader_text("gl/triangle.glsl")};
    const char *fragment_part[] = {version,
                                   defines,
                                   shader_text("include/coc.glsl"),
                                   shader_text("include/row.glsl"),
                                   shader_text("include/pack.glsl"),
                                   shader_text("include/pixels.glsl"),
                                   shader_text("include/picture.glsl"),
                                   shader_text("gl/surfaces.glsl"),
                                   shader_text(name)};
    GLuint program = 0, fragment = 0,
           vertex = compile(gl, GL_VERTEX_SHADER, vertex_part, 2, "gl/triangle.glsl", status);
    if (vertex) fragment = compile(gl, GL_FRAGMENT_SHADER, fragment_part, 9, name, status);
    if (fragment) program = link_program(gl, vertex, fragment, name, status);
    if (vertex) gl->f.DeleteShader(vertex);
    if (fragment) gl->f.DeleteShader(fragment);
    return program;
}

static bool make_room(ddof_gl *gl, ddof_status *status) {
    gl_programs *p = &gl->programs;
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

const gl_program *gl_program_get(ddof_gl *gl, const gl_variant *v, ddof_status *status) {
    gl_programs *p = &gl->programs;
    const unsigned key = variant_key(v);
    for (int i = 0; i < p->count; i++)
        if (p->program[i].key == key) return &p->program[i];
    if (!make_room(gl, status)) return NULL;
    gl_program *made = &p->program[p->count];
    made->key = key;
    made->name = build(gl, v, status);
    if (!made->name) return NULL;
    p->count++;
    gl->objects++;
    for (int i = 0; i < GL_UNIFORMS; i++)
        made->uniform[i] = gl->f.GetUniformLocation(made->name, uniform_name[i]);
    gl->f.UseProgram(made->name);
    for (int i = 0; i < GL_UNITS; i++)
        gl->f.Uniform1i(gl->f.GetUniformLocation(made->name, sampler_name[i]), i);
    return made;
}

void gl_programs_delete(ddof_gl *gl) {
    gl_programs *p = &gl->programs;
    for (int i = 0; i < p->count; i++)
        gl->f.DeleteProgram(p->program[i].name);
    if (p->program) gl->config.release(gl->config.memory_user, p->program);
    *p = (gl_programs){NULL, 0, 0};
}
