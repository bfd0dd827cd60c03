/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The passes of the sprites, in order:
 *     find    the CoC of every pixel; HIGHLIGHTS: which are candidates
 *     fill    FULL: holes, from around
 *     budget  HIGHLIGHTS: the threshold that leaves few enough of them
 *     take    HIGHLIGHTS: their light is taken out, and the rest diffused (solver.c)
 *     draw    a quad for every pixel, added up
 *     lay     what that gives, on the picture */
#include "sprites.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "device.h"
#include "shaders.h"

typedef enum sprite_pass {
    PASS_FIND,
    PASS_COUNT,
    PASS_SUM,
    PASS_TEST,
    PASS_TAKE,
    PASS_DRAW,
    PASS_LAY,
    PASS_PUSH,
    PASS_PULL,
    PASS_TOP
} sprite_pass;

static const char *const pass_file[] = {"gl/sprite_find.glsl",   "gl/sprite_budget.glsl", "gl/sprite_budget.glsl",
                                        "gl/sprite_budget.glsl", "gl/sprite_take.glsl",   "gl/sprite_draw.glsl",
                                        "gl/sprite_lay.glsl",    "gl/sprite_fill.glsl",   "gl/sprite_fill.glsl",
                                        "gl/sprite_fill.glsl"};
static const int pass_step[] = {0, 0, 1, 2, 0, 0, 0, 0, 1, 2};

enum {
    S_SIZE = U_LENS_LIMIT + 1,
    S_COLORS,
    S_THRESHOLD,
    S_LARGEST,
    S_SUMMED,
    S_MOST,
    S_FINAL,
    S_FIRST_ROW,
    S_FIRST_LEVEL,
    S_LEVELS,
    S_PLACE,
    S_SECOND,
    S_SCREEN,
    S_CATS_EYE,
    S_BLADES,
    S_CURVATURE,
    S_EDGE,
    S_SQUEEZE,
    S_ASPECT,
    S_FRINGE,
    S_REACH,
    S_TURN,
    S_UNIFORMS
};

/* Up to the lens those of solver.c. */
static const char *const uniform_name[S_UNIFORMS] = {
    "depth_linear", "depth_axis",  "lens_curve",  "lens_limit", "size",        "colors",         "threshold",
    "largest",      "summed",      "most",        "final",      "first_row",   "first_level",    "levels",
    "place",        "second",      "screen",      "cats_eye",   "iris_blades", "iris_curvature", "iris_edge",
    "iris_squeeze", "iris_aspect", "iris_fringe", "iris_reach", "iris_turn",
};

enum { UNIT_CANDIDATE = 2, UNIT_BUDGET, UNIT_TABLE = SPRITE_UNIT_TABLE, UNIT_SUM };
enum { UNIT_WEIGHT = UNIT_BUDGET };                                      /* of the last pass */
enum { UNIT_ABOVE = 2, UNIT_ABOVE_KNOWN, UNIT_FILLED, UNIT_FILLED_COC }; /* of those that fill */

static const char *const sampler_name[GL_UNITS] = {"color_map",  "coc_map",   "candidate_map",
                                                   "budget_map", "table_map", "sum_map"};
static const char *const lay_sampler_name[GL_UNITS] = {"color_map",  "coc_map",   "candidate_map",
                                                       "weight_map", "table_map", "sum_map"};
static const char *const fill_sampler_name[GL_UNITS] = {"color_map",       "coc_map",    "above_map",
                                                        "above_known_map", "filled_map", "filled_coc_map"};

/* ---- programs */

typedef struct variant {
    sprite_pass pass;
    int depth, iris;                            /* as in gl_variant; iris: ddof_iris_shape */
    bool full, alpha, to_half, fringe, picture; /* picture: of the passes that fill */
} variant;

static const gl_program *program_of(ddof_gl *gl, const variant *v, ddof_status *status) {
    gl_programs *list = &gl->sprites.programs;
    const unsigned key = (unsigned)v->pass | (unsigned)v->depth << 4 | (unsigned)v->iris << 7 | (unsigned)v->full << 9 |
                         (unsigned)v->alpha << 10 | (unsigned)v->to_half << 11 | (unsigned)v->fringe << 12 |
                         (unsigned)v->picture << 13;
    const gl_program *found = gl_program_find(list, key);
    const bool draws = v->pass == PASS_DRAW;
    char defines[256];
    if (found) return found;
    snprintf(defines, sizeof defines,
             "#define DEPTH %d\n#define IRIS %d\n#define FULL %d\n#define ALPHA %d\n#define TO_HALF %d\n"
             "#define FRINGE %d\n#define PICTURE %d\n#define STEP %d\n",
             v->depth, v->iris, v->full, v->alpha, v->to_half, v->fringe, v->picture, pass_step[v->pass]);
    const char *coc = shader_text("include/coc.glsl"), *bokeh = shader_text("include/bokeh.glsl");
    const char *shared = shader_text("gl/sprites.glsl"), *shape = shader_text("gl/sprite_shape.glsl");
    const char *iris_text = shader_text("include/iris.glsl");
    gl_source source = {.name = pass_file[v->pass],
                        .vertex_name = draws ? "gl/sprite_vertex.glsl" : "gl/triangle.glsl",
                        .vertex = {shader_text("gl/triangle.glsl")},
                        .fragment = {defines, coc, shader_text("include/row.glsl"), shader_text("include/pack.glsl"),
                                     bokeh, shared, shape, iris_text, shader_text("gl/written.glsl"),
                                     shader_text(pass_file[v->pass])},
                        .uniforms = uniform_name,
                        .samplers = v->pass == PASS_LAY  ? lay_sampler_name
                                    : v->pass > PASS_LAY ? fill_sampler_name
                                                         : sampler_name,
                        .uniform_count = S_UNIFORMS,
                        .sampler_count = GL_UNITS};
    const char *const vertex[] = {defines, coc, bokeh, shared, shape, iris_text, shader_text("gl/sprite_vertex.glsl")};
    if (draws) memcpy(source.vertex, vertex, sizeof vertex);
    return gl_program_make(gl, list, key, &source, status);
}

/* ---- passes */

typedef struct work {
    ddof_gl *gl;
    const gl_frame *frame;
    gl_sprites *s;
    bokeh_limits limits;
    GLuint color, coc, budget; /* textures that are read */
    int fill;                  /* level that is filled */
    ddof_status status;
} work;

static work work_of(ddof_gl *gl, const gl_frame *frame) {
    gl_sprites *s = &gl->sprites;
    return (work){.gl = gl,
                  .frame = frame,
                  .s = s,
                  .limits = bokeh_limits_of(frame->job),
                  .color = frame->color,
                  .coc = s->pixels.texture[0],
                  .budget = s->budget[0].texture[0]};
}

static variant variant_of(const work *w, sprite_pass pass) {
    const frame_job *job = w->frame->job;
    variant v;
    memset(&v, 0, sizeof v);
    v.pass = pass;
    v.full = w->s->layout.full;
    v.alpha = w->frame->alpha;
    if (pass == PASS_FIND && job->is_depth) v.depth = 1 + (int)job->curve.kind;
    if (pass == PASS_TAKE) v.to_half = w->s->rest.format[0] == GL_RGBA16F;
    if (pass == PASS_LAY) v.to_half = w->frame->half_output;
    v.picture = (pass == PASS_PUSH && w->fill == 1) || (pass == PASS_PULL && w->fill == 0);
    if (pass == PASS_PULL && v.picture) v.to_half = w->s->filled_to[0].format[0] == GL_RGBA16F;
    if (pass != PASS_DRAW) return v;
    v.iris = job->iris->shape.kind;
    v.fringe = job->iris->shape.fringe != 0 && w->frame->colors > 2;
    return v;
}

static void set_picture(const work *w, const GLint *u) {
    const gl_functions *f = &w->gl->f;
    const gl_sprites *s = w->s;
    const sprite_layout *l = &s->layout;
    const int colors = w->frame->colors;
    f->Uniform2i(u[S_SIZE], l->width, l->height);
    f->Uniform3f(u[S_COLORS], 1, colors > 1, colors > 2);
    f->Uniform1f(u[S_THRESHOLD], w->limits.threshold * w->frame->gain);
    f->Uniform1f(u[S_LARGEST], w->limits.largest);
    f->Uniform2f(u[S_MOST], (float)w->limits.max_sprites, (float)w->limits.max_area);
    f->Uniform1i(u[S_FIRST_LEVEL], l->first);
    f->Uniform1i(u[S_LEVELS], l->levels);
    f->Uniform4iv(u[S_PLACE], BOKEH_LEVELS, s->place[0]);
    f->Uniform2i(u[S_SECOND], s->second[0], s->second[1]);
    f->Uniform2f(u[S_SCREEN], (float)s->light.width, (float)s->light.height);
}

static void set_iris(const work *w, const GLint *u) {
    const gl_functions *f = &w->gl->f;
    const frame_job *job = w->frame->job;
    const iris_shape *shape = &job->iris->shape;
    const ddof_frame *in = job->frame;
    const double width = in->picture_width ? in->picture_width : in->color.width;
    const double height = in->picture_width ? in->picture_height : in->color.height;
    f->Uniform3f(u[S_CATS_EYE], (float)(0.5 * (width - 1) - in->offset_x), (float)(0.5 * (height - 1) - in->offset_y),
                 (float)(2 / hypot(width, height / job->pixel_aspect)) * shape->cats_eye);
    f->Uniform1f(u[S_BLADES], (float)shape->blades);
    f->Uniform1f(u[S_CURVATURE], shape->curvature);
    f->Uniform1f(u[S_EDGE], shape->edge);
    f->Uniform1f(u[S_SQUEEZE], shape->squeeze);
    f->Uniform1f(u[S_ASPECT], shape->aspect);
    f->Uniform1f(u[S_FRINGE], shape->fringe);
    f->Uniform1f(u[S_REACH], job->iris->reach);
    f->Uniform2f(u[S_TURN], shape->cosine, shape->sine);
}

/* Binds all that a pass reads and where it draws; NULL: it cannot. */
static const GLint *begin(work *w, sprite_pass pass, GLuint framebuffer, int width, int height) {
    const gl_functions *f = &w->gl->f;
    const variant v = variant_of(w, pass);
    if (w->status != DDOF_OK) return NULL;
    const gl_program *program = program_of(w->gl, &v, &w->status);
    if (!program) return NULL;
    f->UseProgram(program->name);
    gl_bind(f, UNIT_COLOR, w->color);
    gl_bind(f, UNIT_COC, pass == PASS_FIND ? w->frame->map : w->coc);
    gl_bind(f, UNIT_CANDIDATE, pass == PASS_FIND ? 0 : w->s->pixels.texture[1]);
    gl_bind(f, pass == PASS_LAY ? UNIT_WEIGHT : UNIT_BUDGET, pass == PASS_LAY ? w->s->light.texture[1] : w->budget);
    gl_bind(f, UNIT_TABLE, w->s->table);
    gl_bind(f, UNIT_SUM, pass == PASS_LAY ? w->s->light.texture[0] : 0);
    if (v.depth) gl_set_lens(f, program->uniform, w->frame);
    set_picture(w, program->uniform);
    set_iris(w, program->uniform);
    f->BindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffer);
    f->Viewport(0, 0, width, height);
    return program->uniform;
}

static void draw(work *w) {
    w->gl->f.DrawArrays(GL_TRIANGLES, 0, 3);
    w->gl->draws++;
}

static void pass(work *w, sprite_pass which, GLuint framebuffer) {
    if (begin(w, which, framebuffer, w->s->layout.width, w->s->layout.height)) draw(w);
}

/* ---- holes */

/* A level is `from` sums and weights of what is known there, and filled `to` what it lacks. Of the picture the first
 * are its colour and CoC. */
static void fill_level(work *w, sprite_pass which, const gl_target *read, const gl_target *to, const gl_target *above) {
    const gl_functions *f = &w->gl->f;
    const gl_sprites *s = w->s;
    const GLint *u = begin(w, which, to->framebuffer, to->width, to->height);
    if (!u) return;
    if (read != &s->pixels) {
        gl_bind(f, UNIT_COLOR, read->texture[0]);
        gl_bind(f, UNIT_COC, read->texture[1]);
    }
    f->Uniform2i(u[S_SUMMED], read->width, read->height);
    if (above) {
        f->Uniform2i(u[S_SUMMED], above->width, above->height);
        gl_bind(f, UNIT_ABOVE, above->texture[0]);
        gl_bind(f, UNIT_ABOVE_KNOWN, above->texture[1]);
        gl_bind(f, UNIT_FILLED, s->filled_to[w->fill + 1].texture[0]);
        gl_bind(f, UNIT_FILLED_COC, s->filled_to[w->fill + 1].texture[1]);
    }
    draw(w);
}

static void fill_holes(work *w) {
    gl_sprites *s = w->s;
    for (w->fill = 1; w->fill <= s->fills; w->fill++)
        fill_level(w, PASS_PUSH, w->fill == 1 ? &s->pixels : &s->filled_from[w->fill - 1], &s->filled_from[w->fill],
                   NULL);
    w->fill = s->fills;
    fill_level(w, PASS_TOP, &s->filled_from[s->fills], &s->filled_to[s->fills], NULL);
    for (w->fill = s->fills - 1; w->fill >= 0; w->fill--)
        fill_level(w, PASS_PULL, w->fill ? &s->filled_from[w->fill] : &s->pixels, &s->filled_to[w->fill],
                   &s->filled_from[w->fill + 1]);
    w->color = s->filled_to[0].texture[0];
    w->coc = s->filled_to[0].texture[1];
}

/* ---- budget */

/* Sums by blocks, up to the last level. */
static void count(work *w, bool final) {
    const gl_sprites *s = w->s;
    const GLint *u = begin(w, PASS_COUNT, s->sums[0].framebuffer, s->sums[0].width, s->sums[0].height);
    if (!u) return;
    w->gl->f.Uniform1i(u[S_FINAL], final);
    draw(w);
    for (int i = 1; i < s->sum_levels; i++) {
        const gl_target *from = &s->sums[i - 1], *to = &s->sums[i];
        u = begin(w, PASS_SUM, to->framebuffer, to->width, to->height);
        if (!u) return;
        w->gl->f.Uniform2i(u[S_SUMMED], from->width, from->height);
        gl_bind(&w->gl->f, UNIT_SUM, from->texture[0]);
        draw(w);
    }
}

/* All bins at first, then nine times half of what is left of 512; an even number, so that the first texture has the
 * last word. */
enum { TESTS = 10 };

static void find_threshold(work *w) {
    static const float start[4] = {0, BOKEH_BINS, 0, 0};
    const gl_functions *f = &w->gl->f;
    const gl_target *last = &w->s->sums[w->s->sum_levels - 1];
    f->BindFramebuffer(GL_DRAW_FRAMEBUFFER, w->s->budget[0].framebuffer);
    f->ClearBufferfv(GL_COLOR, 0, start);
    for (int i = 0; i < TESTS; i++) {
        w->budget = w->s->budget[i % 2].texture[0];
        count(w, false);
        const GLint *u = begin(w, PASS_TEST, w->s->budget[(i + 1) % 2].framebuffer, 1, 1);
        if (!u) return;
        f->Uniform2i(u[S_SUMMED], last->width, last->height);
        gl_bind(f, UNIT_SUM, last->texture[0]);
        draw(w);
    }
    w->budget = w->s->budget[0].texture[0];
}

/* ---- sprites */

enum { MOST_INSTANCES = 1 << 20 /* of a draw, so that none takes long */ };

static void draw_sprites(work *w) {
    static const float none[4] = {0, 0, 0, 0};
    const gl_functions *f = &w->gl->f;
    const sprite_layout *l = &w->s->layout;
    const int rows = l->width < MOST_INSTANCES ? MOST_INSTANCES / l->width : 1;
    const GLint *u = begin(w, PASS_DRAW, w->s->light.framebuffer, w->s->light.width, w->s->light.height);
    if (!u) return;
    f->ClearBufferfv(GL_COLOR, 0, none);
    if (l->full) f->ClearBufferfv(GL_COLOR, 1, none);
    f->Enable(GL_BLEND);
    f->BlendEquationSeparate(GL_FUNC_ADD, GL_FUNC_ADD);
    f->BlendFuncSeparate(GL_ONE, GL_ONE, GL_ONE, GL_ONE);
    for (int y = 0; y < l->height; y += rows) {
        f->Uniform1i(u[S_FIRST_ROW], y);
        f->DrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, l->width * (l->height - y < rows ? l->height - y : rows));
        w->gl->draws++;
    }
    f->Disable(GL_BLEND);
}

static void lay(work *w) {
    if (gl_attach_output(w->gl, w->frame->output))
        pass(w, PASS_LAY, w->gl->output);
    else
        w->status =
            context_fail(w->gl->owner, DDOF_ERROR_INVALID, "frame.output: this GL cannot render to that texture");
    gl_detach_output(w->gl);
}

/* In place, in the texture of the rest. */
static ddof_status diffuse_rest(ddof_gl *gl, const gl_frame *frame) {
    gl_frame rest = *frame;
    rest.color = rest.output = gl->sprites.rest.texture[0];
    rest.half_output = gl->sprites.rest.format[0] == GL_RGBA16F;
    return gl_solve(gl, &rest);
}

ddof_status gl_sprites_render(ddof_gl *gl, const gl_frame *frame) {
    ddof_status status = gl_sprites_make(gl, frame->job, frame->holes);
    if (status != DDOF_OK) return status;
    gl_sprites_fill_table(gl, frame->job->iris);
    work w = work_of(gl, frame);
    pass(&w, PASS_FIND, w.s->pixels.framebuffer);
    if (w.s->layout.fills) fill_holes(&w);
    if (frame->job->highlights) {
        find_threshold(&w);
        pass(&w, PASS_TAKE, w.s->rest.framebuffer);
        if (w.status == DDOF_OK) w.status = diffuse_rest(gl, frame);
    }
    draw_sprites(&w);
    if (frame->job->highlights) w.color = w.s->rest.texture[0];
    if (w.status == DDOF_OK) lay(&w);
    return w.status != DDOF_OK ? w.status : gl_device_check(gl);
}

ddof_status gl_sprites_count(ddof_gl *gl, const gl_frame *frame) {
    float sums[SPRITE_BLOCK * SPRITE_BLOCK * 4];
    double sum[4] = {0, 0, 0, 0};
    work w = work_of(gl, frame);
    const gl_target *last = &w.s->sums[w.s->sum_levels - 1];
    if (w.s->layout.fills) w.color = w.s->filled_to[0].texture[0], w.coc = w.s->filled_to[0].texture[1];
    count(&w, true);
    if (w.status != DDOF_OK) return w.status;
    gl->f.BindFramebuffer(GL_READ_FRAMEBUFFER, last->framebuffer);
    gl->f.ReadPixels(0, 0, last->width, last->height, GL_RGBA, GL_FLOAT, sums);
    const ddof_status status = gl_device_check(gl);
    for (int i = 0; i < last->width * last->height * 4 && status == DDOF_OK; i++)
        sum[i % 4] += (double)sums[i];
    frame->job->sprites = (int64_t)sum[0];
    if (!frame->job->highlights) return status;
    frame->job->sprites_dropped = (int64_t)(sum[2] - sum[0]);
    frame->job->sprites_large = (int64_t)sum[3];
    return status;
}
