/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "bench_gl.h"

#include <GLES3/gl3.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "gl/egl.h"
#include "message.h"

typedef struct functions {
    PFNGLBINDTEXTUREPROC BindTexture;
    PFNGLDELETETEXTURESPROC DeleteTextures;
    PFNGLFINISHPROC Finish;
    PFNGLGENTEXTURESPROC GenTextures;
    PFNGLGETERRORPROC GetError;
    PFNGLTEXIMAGE2DPROC TexImage2D;
} functions;

enum { COLOR, MAP, OUTPUT, TEXTURES };

struct bench_gl {
    egl_session egl;
    bool current;
    functions f;
    GLuint texture[TEXTURES];
    ddof_gl *renderer[BENCH_GL_SLOTS];
    ddof_gl_frame frame;
    char said[512]; /* the library's last error */
};

/* A function's type is the same size whatever it takes; the cast goes by way of memory, as ISO C asks. */
static bool look_up(bench_gl *gl, const char *name, void *function, size_t size) {
    const ddof_gl_function found = egl_get_proc(&gl->egl, name);
    memcpy(function, &found, size);
    return found != NULL;
}
#define LOOK_UP(name) look_up(gl, "gl" #name, &gl->f.name, sizeof gl->f.name)

static bool load(bench_gl *gl) {
    return LOOK_UP(BindTexture) && LOOK_UP(DeleteTextures) && LOOK_UP(Finish) && LOOK_UP(GenTextures) &&
           LOOK_UP(GetError) && LOOK_UP(TexImage2D);
}

static void upload(bench_gl *gl, int which, const scene *s, GLenum format, GLenum channels, const void *data) {
    gl->f.BindTexture(GL_TEXTURE_2D, gl->texture[which]);
    gl->f.TexImage2D(GL_TEXTURE_2D, 0, (GLint)format, s->width, s->height, 0, channels, GL_FLOAT, data);
}

static bool upload_all(bench_gl *gl, const scene *s, ddof_surface surface) {
    const GLenum format = surface == DDOF_SURFACE_RGBA32F ? GL_RGBA32F : GL_RGBA16F;
    gl->f.GenTextures(TEXTURES, gl->texture);
    upload(gl, COLOR, s, format, GL_RGBA, s->color);
    upload(gl, MAP, s, GL_R32F, GL_RED, s->blur);
    upload(gl, OUTPUT, s, format, GL_RGBA, NULL);
    gl->f.BindTexture(GL_TEXTURE_2D, 0);
    gl->frame = (ddof_gl_frame){.width = s->width,
                                .height = s->height,
                                .color = {gl->texture[COLOR], format},
                                .output = {gl->texture[OUTPUT], format}};
    *(s->depth ? &gl->frame.depth : &gl->frame.coc) = (ddof_gl_texture){gl->texture[MAP], GL_R32F};
    gl->f.Finish();
    return gl->f.GetError() == GL_NO_ERROR;
}

bench_gl *bench_gl_create(const scene *s, ddof_surface surface, char *why, size_t size) {
    bench_gl *gl = calloc(1, sizeof *gl);
    if (!gl) {
        snprintf(why, size, "out of memory");
        return NULL;
    }
    bool good = egl_open(&gl->egl, why, size);
    if (good) good = gl->current = egl_enter(&gl->egl, why, size);
    if (good && !load(gl)) {
        snprintf(why, size, "this EGL does not find the functions of OpenGL ES");
        good = false;
    }
    if (good && !upload_all(gl, s, surface)) {
        snprintf(why, size, "GL cannot hold textures of %dx%d pixels", s->width, s->height);
        good = false;
    }
    if (!good) bench_gl_destroy(&gl);
    return gl;
}

void bench_gl_destroy(bench_gl **made) {
    bench_gl *gl = *made;
    if (!gl) return;
    for (int i = 0; i < BENCH_GL_SLOTS; i++)
        ddof_gl_destroy(&gl->renderer[i]);
    if (gl->current) {
        if (gl->texture[0]) gl->f.DeleteTextures(TEXTURES, gl->texture);
        egl_leave(&gl->egl);
    }
    egl_close(&gl->egl);
    free(gl);
    *made = NULL;
}

static void on_log(void *user, ddof_log_level level, const char *text) {
    bench_gl *gl = user;
    if (level == DDOF_LOG_ERROR) snprintf(gl->said, sizeof gl->said, "%s", text);
}

static int fail_gl(const bench_gl *gl, const ddof_gl *renderer, ddof_status status) {
    const char *text = renderer ? ddof_gl_error(renderer) : gl->said;
    return fail("--backend gl: %s; use --backend cpu", *text ? text : ddof_status_text(status));
}

int bench_gl_solve(bench_gl *gl, int slot, const ddof_settings *settings, double *ms, ddof_gl_stats *stats) {
    ddof_gl **renderer = &gl->renderer[slot];
    const ddof_gl_config config = {.get_proc = egl_get_proc, .get_proc_user = &gl->egl, .log = on_log, .log_user = gl};
    ddof_status done = *renderer ? DDOF_OK : ddof_gl_create(renderer, &config);
    if (done != DDOF_OK) return fail_gl(gl, NULL, done);
    const double begin = now_ms();
    done = ddof_gl_render(*renderer, &gl->frame, settings, stats);
    gl->f.Finish();
    *ms = now_ms() - begin;
    return done == DDOF_OK ? 0 : fail_gl(gl, *renderer, done);
}
