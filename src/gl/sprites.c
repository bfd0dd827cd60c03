/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The passes of the sprites, in order:
 *     find    the CoC of every pixel; HIGHLIGHTS: which are candidates
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

typedef enum sprite_pass { PASS_FIND, PASS_COUNT, PASS_SUM, PASS_TEST, PASS_TAKE, PASS_DRAW, PASS_LAY } sprite_pass;

static const char *const pass_file[] = {"gl/sprite_find.glsl",   "gl/sprite_budget.glsl", "gl/sprite_budget.glsl",
                                        "gl/sprite_budget.glsl", "gl/sprite_take.glsl",   "gl/sprite_draw.glsl",
                                        "gl/sprite_lay.glsl"};

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
    S_TURN,
    S_UNIFORMS
};

/* Up to the lens those of solver.c. */
static const char *const uniform_name[S_UNIFORMS] = {
    "depth_linear", "depth_axis",  "lens_curve",     "lens_limit", "size",         "colors",      "threshold",   "largest",
    "summed",       "most",        "final",          "first_row",  "first_level",  "levels",      "place",       "second",
    "screen",       "cats_eye",    "iris_blades",    "iris_curvature", "iris_edge", "iris_squeeze", "iris_aspect", "iris_fringe",
    "iris_turn",
};

enum { UNIT_CANDIDATE = 2, UNIT_BUDGET, UNIT_TABLE, UNIT_SUM, UNIT_WEIGHT = UNIT_BUDGET /* of the last pass, which has no other */ };

static const char *const sampler_name[GL_UNITS] = {"color_map",  "coc_map",   "candidate_map",
                                                   "budget_map", "table_map", "sum_map"};

/* ---- textures */

enum { TABLE_WIDTH = 1024, ROW_DIAMETER = 2, ROW_EDGE, ROW_CATS, ROW_TEXEL, TABLE_HEIGHT = ROW_TEXEL + IRIS_TEXELS / TABLE_WIDTH + 1 };

static size_t texel_bytes(GLenum format) {
    switch (format) {
    case GL_RGBA32F: return 16;
    case GL_RGBA16F:
    case GL_RG32F: return 8;
    case GL_R32F: return 4;
    case GL_R16F: return 2;
    default: return 0;
    }
}

static gl_target planned(gl_sprites *s, int width, int height, GLenum format, GLenum second) {
    s->bytes += (size_t)width * (size_t)height * (texel_bytes(format) + texel_bytes(second));
    return (gl_target){.width = width, .height = height, .format = {format, second}};
}

static sprite_layout layout_of(const frame_job *job, bool blends) {
    const bokeh_limits limits = bokeh_limits_of(job);
    sprite_layout l;
    memset(&l, 0, sizeof l); /* layouts are compared by their bytes */
    l.width = job->frame->color.width;
    l.height = job->frame->color.height;
    l.surface = job->settings->surface == DDOF_SURFACE_RGBA32F ? DDOF_SURFACE_RGBA32F : DDOF_SURFACE_RGBA16F;
    l.full = job->method == DDOF_METHOD_SCATTER;
    l.first = limits.half;
    l.levels = bokeh_level(iris_node(limits.largest), limits.half) + 1;
    l.blends = blends;
    return l;
}

/* The levels in one target: the first, below it the others in a row, below them the same again for the near sprites of FULL;
 * `beside`: all that turned on its side. */
static gl_target place_levels(gl_sprites *s, bool beside) {
    const sprite_layout *l = &s->layout;
    int along = 0, across = 0;
    for (int i = l->first; i < l->levels; i++) {
        const int size[2] = {(l->width + (1 << i) - 1) >> i, (l->height + (1 << i) - 1) >> i};
        GLint *place = s->place[i];
        place[beside] = i == l->first ? 0 : across;
        place[!beside] = i == l->first ? 0 : s->place[l->first][3 - beside];
        place[2] = size[0];
        place[3] = size[1];
        if (i > l->first) across += size[beside];
        if (place[!beside] + size[!beside] > along) along = place[!beside] + size[!beside];
    }
    if (s->place[l->first][2 + beside] > across) across = s->place[l->first][2 + beside];
    s->second[beside] = 0;
    s->second[!beside] = l->full ? along : 0;
    along *= l->full ? 2 : 1;
    return (gl_target){.width = beside ? along : across, .height = beside ? across : along};
}

void gl_sprites_plan(gl_sprites *s, const frame_job *job, int max_size, bool blends) {
    const sprite_layout l = layout_of(job, blends);
    const GLenum color = l.surface == DDOF_SURFACE_RGBA32F ? GL_RGBA32F : GL_RGBA16F;
    const gl_programs programs = s->programs;
    memset(s, 0, sizeof *s);
    s->programs = programs;
    s->layout = l;
    s->pixels = planned(s, l.width, l.height, GL_R32F, l.full ? 0 : GL_RG32F);
    if (!l.full) s->rest = planned(s, l.width, l.height, color, 0);
    gl_target light = place_levels(s, false);
    if (light.height > max_size) light = place_levels(s, true);
    s->light = planned(s, light.width, light.height, blends ? GL_RGBA32F : GL_RGBA16F, !l.full ? 0 : blends ? GL_R32F : GL_R16F);
    int w = l.width, h = l.height;
    do {
        w = (w + SPRITE_BLOCK - 1) / SPRITE_BLOCK;
        h = (h + SPRITE_BLOCK - 1) / SPRITE_BLOCK;
        s->sums[s->sum_levels++] = planned(s, w, h, GL_RGBA32F, 0);
    } while ((w > SPRITE_BLOCK || h > SPRITE_BLOCK) && s->sum_levels < SPRITE_SUMS);
    for (int i = 0; i < 2; i++) s->budget[i] = planned(s, 1, 1, GL_RGBA32F, 0);
    s->bytes += (size_t)TABLE_WIDTH * TABLE_HEIGHT * texel_bytes(GL_R32F);
}

void gl_sprites_delete(ddof_gl *gl) {
    gl_sprites *s = &gl->sprites;
    const gl_programs programs = s->programs;
    gl_target_delete(gl, &s->pixels);
    gl_target_delete(gl, &s->rest);
    gl_target_delete(gl, &s->light);
    for (int i = 0; i < s->sum_levels; i++) gl_target_delete(gl, &s->sums[i]);
    for (int i = 0; i < 2; i++) gl_target_delete(gl, &s->budget[i]);
    gl->f.DeleteTextures(1, &s->table);
    memset(s, 0, sizeof *s);
    s->programs = programs;
}

static ddof_status make(ddof_gl *gl, const frame_job *job) {
    gl_sprites *s = &gl->sprites;
    const sprite_layout layout = layout_of(job, gl->blends);
    if (memcmp(&s->layout, &layout, sizeof layout) == 0) return DDOF_OK;
    gl_sprites_delete(gl);
    gl_sprites_plan(s, job, gl->max_size, gl->blends);
    if (s->light.width > gl->max_size || s->light.height > gl->max_size) {
        const int width = s->light.width, height = s->light.height;
        gl_sprites_delete(gl);
        return context_fail(gl->owner, DDOF_ERROR_UNSUPPORTED,
                            "the sprites need a surface of %d x %d, and this GL (%s) allows %d: let sprites.resolution be half",
                            width, height, gl->renderer, gl->max_size);
    }
    gl->f.ActiveTexture(GL_TEXTURE0);
    ddof_status status = gl_target_make(gl, &s->pixels);
    if (status == DDOF_OK && !layout.full) status = gl_target_make(gl, &s->rest);
    if (status == DDOF_OK) status = gl_target_make(gl, &s->light);
    for (int i = 0; i < s->sum_levels && status == DDOF_OK; i++) status = gl_target_make(gl, &s->sums[i]);
    for (int i = 0; i < 2 && status == DDOF_OK; i++) status = gl_target_make(gl, &s->budget[i]);
    if (status == DDOF_OK) {
        s->table = gl_texture_make(gl, GL_R32F, TABLE_WIDTH, TABLE_HEIGHT);
        status = gl_device_check(gl);
    }
    if (status != DDOF_OK) gl_sprites_delete(gl);
    return status;
}

static void fill_row(const gl_functions *f, int row, int count, const float *values) {
    f->TexSubImage2D(GL_TEXTURE_2D, 0, 0, row, count, 1, GL_RED, GL_FLOAT, values);
}

/* As iris_make(): an image is read anew each time. */
static void fill_table(ddof_gl *gl, const iris *from) {
    gl_sprites *s = &gl->sprites;
    const gl_functions *f = &gl->f;
    float edge[BOKEH_BINS + 1];
    const bool image = from->shape.kind == DDOF_IRIS_IMAGE, same = s->filled && !memcmp(&s->shape, &from->shape, sizeof s->shape);
    if (same && !image) return;
    for (int bin = 0; bin <= BOKEH_BINS; bin++) edge[bin] = bokeh_edge(bin, 1);
    gl_bind(f, UNIT_TABLE, s->table);
    for (int half = 0; half < 2; half++) fill_row(f, half, IRIS_NODES, from->inverse_sum[half]);
    fill_row(f, ROW_DIAMETER, IRIS_NODES, from->diameter);
    fill_row(f, ROW_EDGE, BOKEH_BINS + 1, edge);
    fill_row(f, ROW_CATS, IRIS_CATS, from->cats_gain);
    for (int i = 0; i < IRIS_TEXELS && image; i += TABLE_WIDTH)
        fill_row(f, ROW_TEXEL + i / TABLE_WIDTH, IRIS_TEXELS - i < TABLE_WIDTH ? IRIS_TEXELS - i : TABLE_WIDTH, from->texel + i);
    s->shape = from->shape;
    s->filled = true;
}

/* ---- programs */

typedef struct variant {
    sprite_pass pass;
    int depth, iris; /* as in gl_variant; iris: ddof_iris_shape */
    bool full, alpha, to_half, fringe;
} variant;

static const gl_program *program_of(ddof_gl *gl, const variant *v, ddof_status *status) {
    gl_programs *list = &gl->sprites.programs;
    const unsigned key = (unsigned)v->pass | (unsigned)v->depth << 3 | (unsigned)v->iris << 6 | (unsigned)v->full << 8 |
                         (unsigned)v->alpha << 9 | (unsigned)v->to_half << 10 | (unsigned)v->fringe << 11;
    const gl_program *found = gl_program_find(list, key);
    const bool draws = v->pass == PASS_DRAW;
    char defines[256];
    if (found) return found;
    snprintf(defines, sizeof defines,
             "#define DEPTH %d\n#define IRIS %d\n#define FULL %d\n#define ALPHA %d\n#define TO_HALF %d\n"
             "#define FRINGE %d\n#define STEP %d\n",
             v->depth, v->iris, v->full, v->alpha, v->to_half, v->fringe, (int)v->pass - (int)PASS_COUNT);
    const char *coc = shader_text("include/coc.glsl"), *bokeh = shader_text("include/bokeh.glsl");
    const char *shared = shader_text("gl/sprites.glsl"), *shape = shader_text("gl/sprite_shape.glsl");
    const char *iris_text = shader_text("include/iris.glsl");
    gl_source source = {.name = pass_file[v->pass],
                        .vertex_name = draws ? "gl/sprite_vertex.glsl" : "gl/triangle.glsl",
                        .vertex = {shader_text("gl/triangle.glsl")},
                        .fragment = {defines, coc, shader_text("include/row.glsl"), shader_text("include/pack.glsl"), bokeh,
                                     shared, shape, iris_text, shader_text("gl/written.glsl"), shader_text(pass_file[v->pass])},
                        .uniforms = uniform_name,
                        .samplers = sampler_name,
                        .uniform_count = S_UNIFORMS,
                        .sampler_count = GL_UNITS};
    const char *const vertex[] = {defines, coc, bokeh, shared, shape, iris_text, shader_text("gl/sprite_vertex.glsl")};
    if (draws) memcpy(source.vertex, vertex, sizeof vertex);
    const gl_program *made = gl_program_make(gl, list, key, &source, status);
    if (made) gl->f.Uniform1i(gl->f.GetUniformLocation(made->name, "weight_map"), UNIT_WEIGHT);
    return made;
}

/* ---- passes */

typedef struct work {
    ddof_gl *gl;
    const gl_frame *frame;
    gl_sprites *s;
    bokeh_limits limits;
    GLuint color;  /* texture that is read */
    GLuint budget; /* likewise */
    ddof_status status;
} work;

static work work_of(ddof_gl *gl, const gl_frame *frame) {
    gl_sprites *s = &gl->sprites;
    return (work){.gl = gl, .frame = frame, .s = s, .limits = bokeh_limits_of(frame->job), .color = frame->color, .budget = s->budget[0].texture[0]};
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
    gl_bind(f, UNIT_COC, pass == PASS_FIND ? w->frame->map : w->s->pixels.texture[0]);
    gl_bind(f, UNIT_CANDIDATE, pass == PASS_FIND ? 0 : w->s->pixels.texture[1]);
    gl_bind(f, UNIT_BUDGET, pass == PASS_LAY ? w->s->light.texture[1] : w->budget);
    gl_bind(f, UNIT_TABLE, w->s->table);
    gl_bind(f, UNIT_SUM, pass == PASS_LAY ? w->s->light.texture[0] : 0);
    if (v.depth) gl_set_lens(f, program->uniform, w->frame);
    set_picture(w, program->uniform);
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

/* All bins at first, then nine times half of what is left of 512; an even number, so that the first texture has the last word. */
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
    set_iris(w, u);
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
        w->status = context_fail(w->gl->owner, DDOF_ERROR_INVALID, "frame.output: this GL cannot render to that texture");
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
    ddof_status status = make(gl, frame->job);
    if (status != DDOF_OK) return status;
    fill_table(gl, frame->job->iris);
    work w = work_of(gl, frame);
    pass(&w, PASS_FIND, w.s->pixels.framebuffer);
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
    count(&w, true);
    if (w.status != DDOF_OK) return w.status;
    gl->f.BindFramebuffer(GL_READ_FRAMEBUFFER, last->framebuffer);
    gl->f.ReadPixels(0, 0, last->width, last->height, GL_RGBA, GL_FLOAT, sums);
    const ddof_status status = gl_device_check(gl);
    for (int i = 0; i < last->width * last->height * 4 && status == DDOF_OK; i++) sum[i % 4] += (double)sums[i];
    frame->job->sprites = (int64_t)sum[0];
    if (!frame->job->highlights) return status;
    frame->job->sprites_dropped = (int64_t)(sum[2] - sum[1]);
    frame->job->sprites_large = (int64_t)sum[3];
    return status;
}
