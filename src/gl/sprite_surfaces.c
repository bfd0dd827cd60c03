/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The textures of the sprites: which there are, how large, how many bytes. */
#include <math.h>
#include <string.h>

#include "device.h"
#include "sprites.h"

enum {
    TABLE_WIDTH = 1024,
    ROW_DIAMETER = IRIS_SUMS,
    ROW_EDGE,
    ROW_CATS,
    ROW_TEXEL,
    TABLE_HEIGHT = ROW_TEXEL + IRIS_TEXELS / TABLE_WIDTH + 1
};

static size_t texel_bytes(GLenum format) {
    switch (format) {
    case GL_RGBA32F:
        return 16;
    case GL_RGBA16F:
    case GL_RG32F:
        return 8;
    case GL_R32F:
        return 4;
    case GL_R16F:
        return 2;
    default:
        return 0;
    }
}

static gl_target planned(gl_sprites *s, int width, int height, GLenum format, GLenum second) {
    s->bytes += (size_t)width * (size_t)height * (texel_bytes(format) + texel_bytes(second));
    return (gl_target){.width = width, .height = height, .format = {format, second}};
}

static sprite_layout layout_of(const frame_job *job, bool holes, bool blends) {
    const bokeh_limits limits = bokeh_limits_of(job);
    sprite_layout l;
    memset(&l, 0, sizeof l); /* layouts are compared by their bytes */
    l.width = job->frame->color.width;
    l.height = job->frame->color.height;
    l.surface = job->settings->surface == DDOF_SURFACE_RGBA32F ? DDOF_SURFACE_RGBA32F : DDOF_SURFACE_RGBA16F;
    l.full = job->method == DDOF_METHOD_SCATTER;
    l.first = limits.half;
    l.levels = bokeh_level(iris_node(limits.largest), limits.half) + 1;
    l.fills = l.full && holes;
    l.blends = blends;
    return l;
}

/* The levels in one target: the first, below it the others in a row, below them the same again for the near sprites of
 * FULL; `beside`: all that turned on its side. */
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

/* The picture filled, and a pyramid above it, up to one pixel. */
static void plan_fill(gl_sprites *s, GLenum color) {
    const sprite_layout *l = &s->layout;
    int w = l->width, h = l->height;
    if (!l->fills) return;
    s->filled_to[0] = planned(s, w, h, color, GL_R32F);
    do {
        w = (w + 1) / 2;
        h = (h + 1) / 2;
        s->fills++;
        s->filled_from[s->fills] = planned(s, w, h, GL_RGBA32F, GL_RGBA32F);
        s->filled_to[s->fills] = planned(s, w, h, GL_RGBA32F, GL_R32F);
    } while ((w > 1 || h > 1) && s->fills + 1 < SPRITE_FILLS);
}

void gl_sprites_plan(gl_sprites *s, const frame_job *job, bool holes, int max_size, bool blends) {
    const sprite_layout l = layout_of(job, holes, blends);
    const GLenum color = l.surface == DDOF_SURFACE_RGBA32F ? GL_RGBA32F : GL_RGBA16F;
    const gl_programs programs = s->programs;
    memset(s, 0, sizeof *s);
    s->programs = programs;
    s->layout = l;
    s->pixels = planned(s, l.width, l.height, GL_R32F, l.full ? 0 : GL_RG32F);
    if (!l.full) s->rest = planned(s, l.width, l.height, color, 0);
    gl_target light = place_levels(s, false);
    if (light.height > max_size) light = place_levels(s, true);
    s->light = planned(s, light.width, light.height, blends ? GL_RGBA32F : GL_RGBA16F,
                       !l.full  ? 0
                       : blends ? GL_R32F
                                : GL_R16F);
    plan_fill(s, color);
    int w = l.width, h = l.height;
    do {
        w = (w + SPRITE_BLOCK - 1) / SPRITE_BLOCK;
        h = (h + SPRITE_BLOCK - 1) / SPRITE_BLOCK;
        s->sums[s->sum_levels++] = planned(s, w, h, GL_RGBA32F, 0);
    } while ((w > SPRITE_BLOCK || h > SPRITE_BLOCK) && s->sum_levels < SPRITE_SUMS);
    for (int i = 0; i < 2; i++)
        s->budget[i] = planned(s, 1, 1, GL_RGBA32F, 0);
    s->bytes += (size_t)TABLE_WIDTH * TABLE_HEIGHT * texel_bytes(GL_R32F);
}

/* All that may have been planned. */
static int targets(gl_sprites *s, gl_target *out[SPRITE_TARGETS]) {
    int n = 0;
    out[n++] = &s->pixels;
    out[n++] = &s->rest;
    out[n++] = &s->light;
    for (int i = 0; i < SPRITE_SUMS; i++)
        out[n++] = &s->sums[i];
    for (int i = 0; i < 2; i++)
        out[n++] = &s->budget[i];
    for (int i = 0; i < SPRITE_FILLS; i++) {
        out[n++] = &s->filled_from[i];
        out[n++] = &s->filled_to[i];
    }
    return n;
}

void gl_sprites_delete(ddof_gl *gl) {
    gl_sprites *s = &gl->sprites;
    const gl_programs programs = s->programs;
    gl_target *all[SPRITE_TARGETS];
    const int n = targets(s, all);
    for (int i = 0; i < n; i++)
        if (all[i]->framebuffer) gl_target_delete(gl, all[i]);
    if (s->table) gl->f.DeleteTextures(1, &s->table);
    memset(s, 0, sizeof *s);
    s->programs = programs;
}

ddof_status gl_sprites_make(ddof_gl *gl, const frame_job *job, bool holes) {
    gl_sprites *s = &gl->sprites;
    const sprite_layout layout = layout_of(job, holes, gl->blends);
    if (memcmp(&s->layout, &layout, sizeof layout) == 0) return DDOF_OK;
    gl_sprites_delete(gl);
    gl_sprites_plan(s, job, holes, gl->max_size, gl->blends);
    if (s->light.width > gl->max_size || s->light.height > gl->max_size) {
        const int width = s->light.width, height = s->light.height;
        gl_sprites_delete(gl);
        return context_fail(
            gl->owner, DDOF_ERROR_UNSUPPORTED,
            "the sprites need a surface of %d x %d, and this GL (%s) allows %d: let sprites.resolution be half", width,
            height, gl->renderer, gl->max_size);
    }
    gl->f.ActiveTexture(GL_TEXTURE0);
    gl_target *all[SPRITE_TARGETS];
    const int n = targets(s, all);
    ddof_status status = DDOF_OK;
    for (int i = 0; i < n && status == DDOF_OK; i++)
        if (all[i]->width) status = gl_target_make(gl, all[i]);
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

/* An image may be another with the same shape. */
void gl_sprites_fill_table(ddof_gl *gl, const iris *from) {
    gl_sprites *s = &gl->sprites;
    const gl_functions *f = &gl->f;
    float edge[BOKEH_BINS + 1];
    const bool image = from->shape.kind == DDOF_IRIS_IMAGE,
               same = s->filled && !memcmp(&s->shape, &from->shape, sizeof s->shape);
    if (same && !image) return;
    for (int bin = 0; bin < BOKEH_BINS; bin++)
        edge[bin] = bokeh_edge(bin, 1);
    edge[BOKEH_BINS] = INFINITY; /* as bokeh_raise() */
    gl_bind(f, SPRITE_UNIT_TABLE, s->table);
    for (int i = 0; i < IRIS_SUMS; i++)
        fill_row(f, i, IRIS_NODES, from->inverse_sum[i]);
    fill_row(f, ROW_DIAMETER, IRIS_NODES, from->diameter);
    fill_row(f, ROW_EDGE, BOKEH_BINS + 1, edge);
    fill_row(f, ROW_CATS, IRIS_CATS, from->cats_gain);
    for (int i = 0; i < IRIS_TEXELS && image; i += TABLE_WIDTH)
        fill_row(f, ROW_TEXEL + i / TABLE_WIDTH, IRIS_TEXELS - i < TABLE_WIDTH ? IRIS_TEXELS - i : TABLE_WIDTH,
                 from->texel + i);
    s->shape = from->shape;
    s->filled = true;
}
