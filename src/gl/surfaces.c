/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "surfaces.h"

#include <string.h>

#include "device.h"

bool solver_packs(ddof_solver solver) {
    return solver == DDOF_SOLVER_CR_PACK || solver == DDOF_SOLVER_CR4_PACK;
}

bool solver_is_cr4(ddof_solver solver) {
    return solver == DDOF_SOLVER_CR4 || solver == DDOF_SOLVER_CR4_PACK;
}

gl_layout gl_layout_make(int width, int height, int max_size, const ddof_settings *settings) {
    gl_layout l;
    memset(&l, 0, sizeof l); /* layouts are compared by their bytes */
    l.width = width;
    l.height = height;
    l.max_size = max_size;
    l.solver = settings->solver == DDOF_SOLVER_DEFAULT ? DDOF_SOLVER_CR4_PACK : settings->solver;
    l.surface = settings->surface == DDOF_SURFACE_DEFAULT ? DDOF_SURFACE_RGBA16F : settings->surface;
    l.shared = settings->shared_chain != 0;
    return l;
}

/* The largest number of unknowns that is solved as it is. */
static int few(ddof_solver solver) {
    return solver == DDOF_SOLVER_CR_VANILLA ? 1 : solver == DDOF_SOLVER_CR_PCR ? PCR_UNKNOWNS : 3;
}

/* Rows 2k + 1 stay, or in the first step of cr4 rows 4k + 3. */
static void plan_chain(gl_chain *c, const gl_layout *l, int length, int lines) {
    int n = length;
    memset(c, 0, sizeof *c);
    c->length = length;
    c->lines = lines;
    if (solver_is_cr4(l->solver) && n > few(l->solver)) c->unknowns[c->levels++] = n /= 4;
    while (n > few(l->solver))
        c->unknowns[c->levels++] = n /= 2;
}

static gl_target *add(gl_surfaces *s, int width, int height, GLenum format, GLenum second) {
    gl_target *t = &s->target[s->targets++];
    const size_t texels = (size_t)width * (size_t)height;
    *t = (gl_target){.width = width, .height = height, .format = {format, second}};
    s->bytes += texels * (format == GL_RGBA16F ? 8 : 16);
    if (second) s->bytes += texels * (second == GL_RGBA16F ? 8 : 16);
    return t;
}

/* A surface for `across` unknowns of every row, or for `down` of every column, or, where both are given, for the one
 * after the other: the second then in strips as wide as the first. */
static gl_target *add_level(gl_surfaces *s, int across, int down, GLenum format, GLenum second) {
    const int w = s->layout.width, h = s->layout.height;
    if (!down) return add(s, across, h, format, second);
    if (!across) return add(s, w, down, format, second);
    int width = across, height;
    for (;; width = width < w / 2 ? 2 * width : w) {
        const int strips = (w + width - 1) / width, need = strips * down;
        height = need > h ? need : h;
        if (height <= s->layout.max_size || width == w) break;
    }
    return add(s, width, height, format, second);
}

/* The surfaces of one chain, or of both when they share. */
static void add_chain(gl_surfaces *s, gl_chain *h, gl_chain *v) {
    const GLenum x = s->layout.surface == DDOF_SURFACE_RGBA32F ? GL_RGBA32F : GL_RGBA16F;
    const bool packs = solver_packs(s->layout.solver);
    for (int k = 0; (h && k < h->levels) || (v && k < v->levels); k++) {
        const int across = h ? h->unknowns[k] : 0, down = v ? v->unknowns[k] : 0;
        gl_target *rows = add_level(s, across, down, packs ? GL_RGBA32UI : GL_RGBA32F, packs ? 0 : x);
        gl_target *y = k < 2 ? add_level(s, across, down, x, 0) : NULL;
        if (h && across) h->rows[k] = rows;
        if (v && down) v->rows[k] = rows;
        if (h && k < 2) h->y[k] = y;
        if (v && k < 2) v->y[k] = y;
    }
    if (s->layout.solver != DDOF_SOLVER_CR_PCR) return;
    const int across = !h ? 0 : h->levels ? h->unknowns[h->levels - 1] : h->length;
    const int down = !v ? 0 : v->levels ? v->unknowns[v->levels - 1] : v->length;
    /* Floats, whatever the surface: PCR rounds every unknown in every step. */
    for (int i = 0; i < 2; i++) {
        gl_target *pcr = add_level(s, across, down, GL_RGBA32F, GL_RGBA32F);
        if (h) h->pcr[i] = pcr;
        if (v) v->pcr[i] = pcr;
    }
}

void gl_surfaces_plan(gl_surfaces *s, const gl_layout *l) {
    memset(s, 0, sizeof *s);
    s->layout = *l;
    plan_chain(&s->chain[0], l, l->width, l->height);
    plan_chain(&s->chain[1], l, l->height, l->width);
    s->picture = add(s, l->width, l->height, l->surface == DDOF_SURFACE_RGBA32F ? GL_RGBA32F : GL_RGBA16F, 0);
    if (l->solver == DDOF_SOLVER_CR_VANILLA) s->abc = add(s, l->width, l->height, GL_RGBA32F, 0);
    if (l->shared) {
        add_chain(s, &s->chain[0], &s->chain[1]);
    } else {
        add_chain(s, &s->chain[0], NULL);
        add_chain(s, NULL, &s->chain[1]);
    }
}

GLuint gl_texture_make(ddof_gl *gl, GLenum format, int width, int height) {
    GLuint name = 0;
    gl->f.GenTextures(1, &name);
    gl->f.BindTexture(GL_TEXTURE_2D, name);
    gl->f.TexStorage2D(GL_TEXTURE_2D, 1, format, width, height);
    gl->objects++;
    return name;
}

ddof_status gl_target_make(ddof_gl *gl, gl_target *t) {
    static const GLenum buffers[2] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
    const int count = t->format[1] ? 2 : 1;
    gl->f.GenFramebuffers(1, &t->framebuffer);
    gl->f.BindFramebuffer(GL_DRAW_FRAMEBUFFER, t->framebuffer);
    gl->objects++;
    for (int i = 0; i < count; i++) {
        t->texture[i] = gl_texture_make(gl, t->format[i], t->width, t->height);
        gl->f.FramebufferTexture2D(GL_DRAW_FRAMEBUFFER, buffers[i], GL_TEXTURE_2D, t->texture[i], 0);
    }
    gl->f.DrawBuffers(count, buffers);
    ddof_status status = gl_device_check(gl);
    if (status != DDOF_OK) return status;
    if (gl->f.CheckFramebufferStatus(GL_DRAW_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE) return DDOF_OK;
    return context_fail(gl->owner, DDOF_ERROR_UNSUPPORTED, "this GL (%s) does not render to a float surface of %d x %d",
                        gl->renderer, t->width, t->height);
}

void gl_target_delete(ddof_gl *gl, gl_target *t) {
    gl->f.DeleteFramebuffers(1, &t->framebuffer); /* 0 is no name and ignored */
    gl->f.DeleteTextures(2, t->texture);
}

ddof_status gl_surfaces_make(ddof_gl *gl, const gl_layout *l) {
    gl_surfaces *s = &gl->surfaces;
    if (memcmp(&s->layout, l, sizeof *l) == 0) return DDOF_OK;
    gl_surfaces_delete(gl);
    gl_surfaces_plan(s, l);
    gl->f.ActiveTexture(GL_TEXTURE0);
    ddof_status status = DDOF_OK;
    for (int i = 0; i < s->targets; i++)
        if (s->target[i].width > l->max_size || s->target[i].height > l->max_size)
            status = context_fail(gl->owner, DDOF_ERROR_UNSUPPORTED,
                                  "a surface of %d x %d is larger than the %d that this GL (%s) allows",
                                  s->target[i].width, s->target[i].height, l->max_size, gl->renderer);
    for (int i = 0; i < s->targets && status == DDOF_OK; i++)
        status = gl_target_make(gl, &s->target[i]);
    if (status != DDOF_OK) gl_surfaces_delete(gl);
    return status;
}

void gl_surfaces_delete(ddof_gl *gl) {
    gl_surfaces *s = &gl->surfaces;
    for (int i = 0; i < s->targets; i++) gl_target_delete(gl, &s->target[i]);
    memset(s, 0, sizeof *s);
}
