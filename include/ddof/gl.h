/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* ddof inside an OpenGL ES 3.0 program: textures in, texture out, on the caller's own context.
 *
 *     static ddof_gl_function get_proc(void *user, const char *name) { return eglGetProcAddress(name); }
 *
 *     ddof_gl *gl = NULL;
 *     ddof_gl_config config = {.get_proc = get_proc};
 *     if (ddof_gl_create(&gl, &config) != DDOF_OK) return 1;
 *     ddof_gl_frame frame = {.width = w, .height = h, .color = {color, GL_RGBA16F},
 *                            .depth = {depth, GL_DEPTH_COMPONENT24}, .output = {result, GL_RGBA16F}};
 *     if (ddof_gl_render(gl, &frame, &settings, NULL) != DDOF_OK) puts(ddof_gl_error(gl));
 *     ddof_gl_destroy(&gl);
 *
 * Needs OpenGL ES 3.0 or later, or WebGL2, with EXT_color_buffer_float (core in ES 3.2); nothing else. The library is
 * not linked to GL: every function comes through get_proc. Pixel shaders only, the cyclic reduction of Gruen 2011
 * (docs/gl.md).
 *
 * Thread-safety: every function of this header is called on a thread where the context given to ddof_gl_create(), or
 * one that shares all its objects, is current; one call at a time per ddof_gl. Any number of ddof_gl may live on one
 * context.
 *
 * State: a call leaves all GL state as it found it, except that errors which nobody had fetched with glGetError() are
 * discarded (and logged). An occlusion query that is active counts the draws. */
#ifndef DDOF_GL_H
#define DDOF_GL_H

#include <ddof/ddof.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct ddof_gl ddof_gl;

typedef void (*ddof_gl_function)(void);

typedef struct ddof_gl_config {
    ddof_gl_function (*get_proc)(void *user, const char *name); /* e.g. eglGetProcAddress; NULL: no such function */
    void *get_proc_user;

    /* As in ddof_config. */
    void *(*allocate)(void *user, size_t bytes);
    void (*release)(void *user, void *memory);
    void *memory_user;
    void (*log)(void *user, ddof_log_level level, const char *text);
    void *log_user;
    uint64_t reserved[8];
} ddof_gl_config;

/* A 2D texture, level 0. Its filters, wrap modes and compare mode do not matter. */
typedef struct ddof_gl_texture {
    unsigned name;   /* from glGenTextures; 0: none */
    unsigned format; /* its sized internal format, e.g. GL_RGBA16F */
} ddof_gl_texture;

/* One frame. Row 0 is the row of texture coordinate 0. What is diffused is the colour as it is sampled: scene-linear,
 * premultiplied. */
typedef struct ddof_gl_frame {
    int width, height;      /* of all textures, in texels */
    ddof_gl_texture color;  /* RGBA32F, RGBA16F, RGB32F, RGB16F, R11F_G11F_B10F, RGB9_E5, RGB10_A2, RGBA8, SRGB8_ALPHA8,
                               RGB8, SRGB8 */
    ddof_gl_texture depth;  /* R32F, R16F, or DEPTH_COMPONENT16/24/32F, DEPTH24_STENCIL8, DEPTH32F_STENCIL8. Exactly one
                               of  depth and coc has a name */
    ddof_gl_texture coc;    /* R32F or R16F: signed diameter in pixels */
    ddof_gl_texture output; /* RGBA32F or RGBA16F; none of the textures above */
    int channels; /* 0 or 4: alpha is diffused as well; 3: alpha is not looked at, and 1 in the result. The packed
                     solvers keep the coefficients more exactly with 3 */

    int picture_width, picture_height, offset_x, offset_y; /* as in ddof_frame */
    double pixel_aspect;
    const void *next; /* must be NULL */
    uint64_t reserved[8];
} ddof_gl_frame;

typedef struct ddof_gl_stats {
    size_t surface_bytes; /* of the textures held: all but the caller's */
    int64_t objects;      /* GL objects made since ddof_gl_create(); a second frame of the same kind makes none */
    int64_t draws;        /* draw calls of this frame */
    const char *device;   /* GL_RENDERER; lives as long as the ddof_gl */
    uint64_t reserved[8]; /* written as 0 */
} ddof_gl_stats;

/* Makes a renderer for the current context. On failure *gl is NULL and config->log has got the sentence.
 * Errors: INVALID, MEMORY, UNSUPPORTED (no GL in this build, no context, older than ES 3.0, no float render targets).
 */
DDOF_API ddof_status ddof_gl_create(ddof_gl **gl, const ddof_gl_config *config);

/* Deletes its GL objects and nulls *gl. NULL and pointers to NULL are allowed. */
DDOF_API void ddof_gl_destroy(ddof_gl **gl);

/* What was wrong with the last call that failed; "" after one that went well. */
DDOF_API const char *ddof_gl_error(const ddof_gl *gl);

/* Issues the draws that blur frame->color into frame->output, and returns: the GPU may work on. Surfaces and programs
 * are made by the first frame of a size and kind, and kept. settings as for ddof_render(), but lens.focus must be
 * DDOF_FOCUS_DISTANCE. Holes are filled as there but not counted, and no more are sprites. stats may be NULL and is zeroed when the call fails.
 * Errors: INVALID (an argument; a texture of the wrong type), MEMORY, UNSUPPORTED (larger than GL's textures;
 * DDOF_KERNEL_DISC; layers), DEVICE
 * (the context was lost, or out of its memory: what `output` holds is no picture). A context lost while the GPU still
 * works is the caller's to see, by glGetGraphicsResetStatus() or her next frame. */
DDOF_API ddof_status ddof_gl_render(ddof_gl *gl, const ddof_gl_frame *frame, const ddof_settings *settings,
                                    ddof_gl_stats *stats);

/* The bytes of surfaces that a frame of this size, the whole picture, with these settings holds; fewer where GL adds up
 * sprites in half floats (docs/gl.md). Needs no context. Errors: INVALID. */
DDOF_API ddof_status ddof_gl_surface_bytes(int width, int height, const ddof_settings *settings, size_t *bytes);

/* Deletes the surfaces kept between frames. */
DDOF_API ddof_status ddof_gl_trim(ddof_gl *gl);

#ifdef __cplusplus
}
#endif

#endif
