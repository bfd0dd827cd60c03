/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* A GL context of the library's own, without a window: libEGL is looked for when it is needed, never linked to. */
#ifndef DDOF_GL_EGL_H
#define DDOF_GL_EGL_H

#include <stdbool.h>
#include <stddef.h>

#include <EGL/egl.h>

#include <ddof/gl.h>

typedef struct egl_functions {
    PFNEGLBINDAPIPROC BindAPI;
    PFNEGLCHOOSECONFIGPROC ChooseConfig;
    PFNEGLCREATECONTEXTPROC CreateContext;
    PFNEGLCREATEPBUFFERSURFACEPROC CreatePbufferSurface;
    PFNEGLDESTROYCONTEXTPROC DestroyContext;
    PFNEGLDESTROYSURFACEPROC DestroySurface;
    PFNEGLGETCURRENTCONTEXTPROC GetCurrentContext;
    PFNEGLGETCURRENTDISPLAYPROC GetCurrentDisplay;
    PFNEGLGETCURRENTSURFACEPROC GetCurrentSurface;
    PFNEGLGETDISPLAYPROC GetDisplay;
    PFNEGLGETERRORPROC GetError;
    PFNEGLGETPROCADDRESSPROC GetProcAddress;
    PFNEGLINITIALIZEPROC Initialize;
    PFNEGLMAKECURRENTPROC MakeCurrent;
    PFNEGLQUERYAPIPROC QueryAPI;
    PFNEGLQUERYSTRINGPROC QueryString;
} egl_functions;

typedef struct egl_session {
    egl_functions f;
    void *library;
    EGLDisplay display;
    EGLContext context;
    EGLSurface surface; /* EGL_NO_SURFACE where none is needed */
    /* What was current before egl_enter(). */
    EGLDisplay before_display;
    EGLContext before;
    EGLSurface before_draw, before_read;
    EGLenum before_api;
} egl_session;

/* False: `text` says why. */
bool egl_open(egl_session *s, char *text, size_t size);
void egl_close(egl_session *s);

/* Makes the session's context current, and what was current before that current again. */
bool egl_enter(egl_session *s, char *text, size_t size);
void egl_leave(egl_session *s);

/* For ddof_gl_config; user is the session. */
ddof_gl_function egl_get_proc(void *user, const char *name);

#endif
