/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* A GL context of the test's own, and a tap between it and the library: it counts what is made, and can make calls
 * fail. */
#ifndef TESTS_GL_TAP_H
#define TESTS_GL_TAP_H

#include "support.h"

#include "gl/egl.h"
#include <GLES3/gl3.h>

extern egl_session session;

#define GL(type, name) ((type)egl_get_proc(&session, #name))

typedef struct gl_tap {
    size_t bytes;               /* of textures made */
    int made;                   /* objects of any kind */
    int calls;                  /* that draw */
    int reset_at;               /* draw from which on the context counts as lost; 0: never */
    int memory_at;              /* texture whose storage is refused; 0: none */
    int errors_asked, error_at; /* question for errors from which on the context is lost; 0: never */
    int textures;
    bool no_extension, no_float_blend, incomplete, small, silent_reset;
    const char *hidden; /* a function that is not there */
} gl_tap;
extern gl_tap tap;

/* What ddof_gl_create() said when it failed. */
extern char said[600];

ddof_gl_function tap_get_proc(void *user, const char *name);

ddof_status try_create(ddof_gl **gl); /* with the tap as it is */
ddof_gl *create(void);                /* with the tap cleared; must succeed */

/* A scene in textures: CoC; colour RGBA32F; output of the format given. */
typedef struct gl_scene {
    scene s;
    ddof_gl_frame frame;
} gl_scene;

ddof_gl_texture texture(GLenum format, int width, int height);
void fill(ddof_gl_texture t, int width, int height, GLenum format, GLenum type, const void *values);
void read_back(ddof_gl_texture t, int width, int height, float *values);
gl_scene gl_scene_make(int width, int height, GLenum format, uint64_t seed);
void gl_scene_free(gl_scene *g);

/* Must succeed. */
void render_gl(ddof_gl *gl, const gl_scene *g, const ddof_settings *settings, ddof_gl_stats *stats);

/* Runs the tests with the session current; skips them where there is no GL. */
int run_with_session(const char *group, const struct CMUnitTest *tests, int count);

#endif
