/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The display is never terminated and the library never unloaded: both are the process's, and another user of EGL in it
 * would lose her objects. */
#include "egl.h"

#include <dlfcn.h>
#include <stdio.h>
#include <string.h>

#include <EGL/eglext.h>

/* ISO C has no conversion from void * to a function; POSIX says that they look alike. */
#define LOOK_UP(s, name) look_up((s)->library, "egl" #name, &(s)->f.name, sizeof(s)->f.name)

static bool look_up(void *library, const char *name, void *function, size_t size) {
    void *symbol = dlsym(library, name);
    memcpy(function, &symbol, size);
    return symbol != NULL;
}

static bool load(egl_session *s, char *text, size_t size) {
    s->library = dlopen("libEGL.so.1", RTLD_NOW | RTLD_LOCAL);
    if (!s->library) {
        snprintf(text, size,
                 "the GL backend needs libEGL.so.1, which is not installed (Debian: libegl1 libgl1-mesa-dri)");
        return false;
    }
    const bool all = LOOK_UP(s, BindAPI) && LOOK_UP(s, ChooseConfig) && LOOK_UP(s, CreateContext) &&
                     LOOK_UP(s, CreatePbufferSurface) && LOOK_UP(s, DestroyContext) && LOOK_UP(s, DestroySurface) &&
                     LOOK_UP(s, GetCurrentContext) && LOOK_UP(s, GetCurrentDisplay) && LOOK_UP(s, GetCurrentSurface) &&
                     LOOK_UP(s, GetDisplay) && LOOK_UP(s, GetError) && LOOK_UP(s, GetProcAddress) &&
                     LOOK_UP(s, Initialize) && LOOK_UP(s, MakeCurrent) && LOOK_UP(s, QueryAPI) &&
                     LOOK_UP(s, QueryString);
    if (!all) snprintf(text, size, "this libEGL.so.1 is too old for the GL backend: EGL 1.4 is needed");
    return all;
}

static bool listed(const char *extensions, const char *name) {
    const size_t length = strlen(name);
    for (const char *p = extensions; p && (p = strstr(p, name)); p += length)
        if ((p == extensions || p[-1] == ' ') && (p[length] == ' ' || p[length] == 0)) return true;
    return false;
}

static EGLDisplay platform_display(egl_session *s, EGLenum platform, void *native) {
    PFNEGLGETPLATFORMDISPLAYEXTPROC get =
        (PFNEGLGETPLATFORMDISPLAYEXTPROC)s->f.GetProcAddress("eglGetPlatformDisplayEXT");
    return get ? get(platform, native, NULL) : EGL_NO_DISPLAY;
}

static EGLContext create(egl_session *s, EGLConfig config, bool robust) {
    const EGLint attributes[] = {EGL_CONTEXT_CLIENT_VERSION, 3,
                                 robust ? EGL_CONTEXT_OPENGL_RESET_NOTIFICATION_STRATEGY_EXT : EGL_NONE,
                                 EGL_LOSE_CONTEXT_ON_RESET_EXT, EGL_NONE};
    return s->f.CreateContext(s->display, config, EGL_NO_CONTEXT, attributes);
}

/* A context on this display, or false. */
static bool try_display(egl_session *s, EGLDisplay display) {
    static const EGLint wanted[] = {EGL_RENDERABLE_TYPE, EGL_OPENGL_ES3_BIT_KHR, EGL_SURFACE_TYPE, EGL_PBUFFER_BIT,
                                    EGL_NONE};
    static const EGLint small[] = {EGL_WIDTH, 1, EGL_HEIGHT, 1, EGL_NONE};
    EGLConfig config = EGL_NO_CONFIG_KHR;
    EGLint count = 0;
    if (display == EGL_NO_DISPLAY || !s->f.Initialize(display, NULL, NULL)) return false;
    s->display = display;
    const char *have = s->f.QueryString(display, EGL_EXTENSIONS);
    const bool surfaceless = listed(have, "EGL_KHR_surfaceless_context");
    if (!surfaceless || !listed(have, "EGL_KHR_no_config_context"))
        if (!s->f.ChooseConfig(display, wanted, &config, 1, &count) || count < 1) return false;
    if (listed(have, "EGL_EXT_create_context_robustness")) s->context = create(s, config, true);
    if (s->context == EGL_NO_CONTEXT) s->context = create(s, config, false);
    if (s->context == EGL_NO_CONTEXT) return false;
    s->surface = surfaceless ? EGL_NO_SURFACE : s->f.CreatePbufferSurface(display, config, small);
    if (surfaceless || s->surface != EGL_NO_SURFACE) return true;
    s->f.DestroyContext(display, s->context);
    s->context = EGL_NO_CONTEXT;
    return false;
}

/* A device that is not a software rasteriser. */
static bool try_devices(egl_session *s) {
    EGLDeviceEXT device[8];
    EGLint count = 0;
    PFNEGLQUERYDEVICESEXTPROC query = (PFNEGLQUERYDEVICESEXTPROC)s->f.GetProcAddress("eglQueryDevicesEXT");
    PFNEGLQUERYDEVICESTRINGEXTPROC string =
        (PFNEGLQUERYDEVICESTRINGEXTPROC)s->f.GetProcAddress("eglQueryDeviceStringEXT");
    if (!query || !string || !query(8, device, &count)) return false;
    for (EGLint i = 0; i < count; i++) {
        if (listed(string(device[i], EGL_EXTENSIONS), "EGL_MESA_device_software")) continue;
        if (try_display(s, platform_display(s, EGL_PLATFORM_DEVICE_EXT, device[i]))) return true;
    }
    return false;
}

bool egl_open(egl_session *s, char *text, size_t size) {
    memset(s, 0, sizeof *s);
    if (!load(s, text, size)) return false;
    const EGLenum api = s->f.QueryAPI();
    const char *client = s->f.QueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
    bool good = s->f.BindAPI(EGL_OPENGL_ES_API);
    if (good)
        good = (listed(client, "EGL_EXT_platform_device") && try_devices(s)) ||
               (listed(client, "EGL_MESA_platform_surfaceless") &&
                try_display(s, platform_display(s, EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY))) ||
               try_display(s, s->f.GetDisplay(EGL_DEFAULT_DISPLAY));
    if (!good)
        snprintf(text, size,
                 "EGL finds no driver for OpenGL ES 3.0 on this machine (a software one, on Debian: libgl1-mesa-dri)");
    if (api != EGL_NONE) s->f.BindAPI(api);
    return good;
}

void egl_close(egl_session *s) {
    if (s->surface != EGL_NO_SURFACE) s->f.DestroySurface(s->display, s->surface);
    if (s->context != EGL_NO_CONTEXT) s->f.DestroyContext(s->display, s->context);
    s->surface = EGL_NO_SURFACE;
    s->context = EGL_NO_CONTEXT;
}

bool egl_enter(egl_session *s, char *text, size_t size) {
    s->before = s->f.GetCurrentContext();
    s->before_display = s->f.GetCurrentDisplay();
    s->before_draw = s->f.GetCurrentSurface(EGL_DRAW);
    s->before_read = s->f.GetCurrentSurface(EGL_READ);
    s->before_api = s->f.QueryAPI();
    s->f.BindAPI(EGL_OPENGL_ES_API);
    if (s->f.MakeCurrent(s->display, s->surface, s->surface, s->context)) return true;
    snprintf(text, size, "the GL context cannot be made current (EGL error 0x%04x)", (unsigned)s->f.GetError());
    egl_leave(s);
    return false;
}

void egl_leave(egl_session *s) {
    if (s->before != EGL_NO_CONTEXT)
        s->f.MakeCurrent(s->before_display, s->before_draw, s->before_read, s->before);
    else
        s->f.MakeCurrent(s->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    if (s->before_api != EGL_NONE) s->f.BindAPI(s->before_api);
}

ddof_gl_function egl_get_proc(void *user, const char *name) {
    return (ddof_gl_function)((egl_session *)user)->f.GetProcAddress(name);
}
