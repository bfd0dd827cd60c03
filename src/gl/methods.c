/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "methods.h"

#include <stdio.h>
#include <string.h>

#include "../methods.h"
#include "device.h"
#include "shaders.h"

enum { UNIT_BOTH = UNIT_ABC }; /* beside UNIT_COLOR and UNIT_COC */

enum { M_NEAREST, M_FIRST_LINE, M_SECOND_LINE, M_UNIFORMS };
static const char *const uniform_name[M_UNIFORMS] = {"nearest", "first_line", "second_line"};
static const char *const sampler_name[] = {"color_map", "coc_map", "both_map"};

/* ---- the target of the first pass */

void gl_methods_delete(ddof_gl *gl) {
    gl_methods *m = &gl->methods;
    gl_target_delete(gl, &m->target);
    memset(&m->target, 0, sizeof m->target);
    m->bytes = 0;
}

static ddof_status make_target(ddof_gl *gl, const gl_frame *frame, bool two) {
    gl_methods *m = &gl->methods;
    const GLenum format = frame->settings->surface == DDOF_SURFACE_RGBA32F ? GL_RGBA32F : GL_RGBA16F;
    const gl_target want = {.width = frame->width, .height = frame->height, .format = {format, two ? format : 0}};
    const gl_target *t = &m->target;
    if (t->framebuffer && t->width == want.width && t->height == want.height && t->format[0] == want.format[0] &&
        t->format[1] == want.format[1])
        return DDOF_OK;
    gl_methods_delete(gl);
    m->target = want;
    gl->f.ActiveTexture(GL_TEXTURE0);
    const ddof_status status = gl_target_make(gl, &m->target);
    m->bytes = (size_t)want.width * (size_t)want.height * (format == GL_RGBA16F ? 8 : 16) * (two ? 2 : 1);
    if (status != DDOF_OK) gl_methods_delete(gl);
    return status;
}

/* ---- a pass */

typedef struct pass {
    bool gaussian, last;
    GLuint color, both; /* textures; both: 0: is not read */
    const gather_line *first, *second;
} pass;

static const gl_program *program_of(ddof_gl *gl, const pass *p, bool half, ddof_status *status) {
    gl_programs *list = &gl->methods.programs;
    const unsigned key = (unsigned)p->gaussian | (unsigned)p->last << 1 | (unsigned)half << 2;
    const char *name = p->gaussian ? "stages/gaussian.glsl" : "stages/hexagon.glsl";
    const gl_program *found = gl_program_find(list, key);
    char defines[128];
    if (found) return found;
    snprintf(defines, sizeof defines, "#define GAUSSIAN %d\n#define LAST %d\n#define TO_HALF %d\n#define ALPHA 1\n", p->gaussian, p->last, half);
    const gl_source source = {.name = name,
                              .vertex_name = "gl/triangle.glsl",
                              .vertex = {shader_text("gl/triangle.glsl")},
                              .fragment = {defines, shader_text("include/row.glsl"), shader_text("include/pack.glsl"),
                                           shader_text("gl/written.glsl"), shader_text("include/gather.glsl"), shader_text(name)},
                              .uniforms = uniform_name,
                              .samplers = sampler_name,
                              .uniform_count = M_UNIFORMS,
                              .sampler_count = sizeof sampler_name / sizeof *sampler_name};
    return gl_program_make(gl, list, key, &source, status);
}

static void set_line(const gl_functions *f, GLint uniform, const gather_line *l) {
    if (l) f->Uniform3f(uniform, l->size, (float)l->dx, l->dy);
}

static ddof_status draw(ddof_gl *gl, const gl_frame *frame, const pass *p) {
    const gl_functions *f = &gl->f;
    ddof_status status = DDOF_OK;
    const bool half = p->last ? frame->half_output : gl->methods.target.format[0] == GL_RGBA16F;
    const gl_program *program = program_of(gl, p, half, &status);
    if (!program) return status;
    f->UseProgram(program->name);
    f->Uniform1f(program->uniform[M_NEAREST], frame->job->nearest);
    set_line(f, program->uniform[M_FIRST_LINE], p->first);
    set_line(f, program->uniform[M_SECOND_LINE], p->second);
    gl_bind(f, UNIT_COLOR, p->color);
    gl_bind(f, UNIT_COC, frame->map);
    if (p->both) gl_bind(f, UNIT_BOTH, p->both);
    f->Viewport(0, 0, frame->width, frame->height);
    f->DrawArrays(GL_TRIANGLES, 0, 3);
    gl->draws++;
    return DDOF_OK;
}

/* Both passes: to the target, and from there to the output. */
static ddof_status draw_both(ddof_gl *gl, const gl_frame *frame, const pass *first, const pass *last) {
    gl->f.BindFramebuffer(GL_DRAW_FRAMEBUFFER, gl->methods.target.framebuffer);
    ddof_status status = draw(gl, frame, first);
    if (status == DDOF_OK && !gl_attach_output(gl, frame->output))
        status = context_fail(gl->owner, DDOF_ERROR_INVALID, "frame.output: this GL cannot render to that texture");
    if (status == DDOF_OK) status = draw(gl, frame, last);
    gl_detach_output(gl);
    return status == DDOF_OK ? gl_device_check(gl) : status;
}

/* ---- the methods */

static filled_picture picture_of(const gl_frame *frame) {
    return (filled_picture){.width = frame->width, .height = frame->height, .nearest = frame->job->nearest};
}

ddof_status gl_gaussian_render(ddof_gl *gl, const gl_frame *frame) {
    gather_line line[GAUSSIAN_LINES];
    const filled_picture p = picture_of(frame);
    const ddof_status status = make_target(gl, frame, false);
    if (status != DDOF_OK) return status;
    gaussian_lines(line, frame->job, &p);
    const GLuint *made = gl->methods.target.texture;
    return draw_both(gl, frame, &(pass){.gaussian = true, .color = frame->color, .first = &line[LINE_ROW]},
                     &(pass){.gaussian = true, .last = true, .color = made[0], .first = &line[LINE_COLUMN]});
}

ddof_status gl_hexagon_render(ddof_gl *gl, const gl_frame *frame) {
    gather_line line[HEXAGON_LINES];
    const filled_picture p = picture_of(frame);
    const ddof_status status = make_target(gl, frame, true);
    if (status != DDOF_OK) return status;
    hexagon_lines(line, frame->job, &p);
    const GLuint *made = gl->methods.target.texture;
    return draw_both(gl, frame, &(pass){.color = frame->color, .first = &line[LINE_UP], .second = &line[LINE_LEFT]},
                     &(pass){.last = true, .color = made[0], .both = made[1], .first = &line[LINE_LEFT], .second = &line[LINE_RIGHT]});
}
