/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* A ddof_gl comes and goes, and GL's complaints become sentences. */
#include "device.h"

#include "../cpu/engine.h"

#include <stdio.h>
#include <string.h>

enum { OLDEST = 30 };

static bool has_extension(const gl_functions *f, const char *name) {
    GLint count = 0;
    f->GetIntegerv(GL_NUM_EXTENSIONS, &count);
    for (GLuint i = 0; i < (GLuint)count; i++) {
        const char *have = (const char *)f->GetStringi(GL_EXTENSIONS, i);
        if (have && !strcmp(have, name)) return true;
    }
    return false;
}

/* 10 * major + minor of an OpenGL ES context (or WebGL2, which its hosts call ES 3.0); 0: something else. */
static int es_version(const gl_functions *f) {
    const char *text = (const char *)f->GetString(GL_VERSION);
    int major = 0, minor = 0;
    if (!text || sscanf(text, "OpenGL ES %d.%d", &major, &minor) != 2) return 0;
    return 10 * major + minor;
}

static void load_reset_status(ddof_gl *gl, int version) {
    static const char *const names[3] = {"glGetGraphicsResetStatus", "glGetGraphicsResetStatusKHR",
                                         "glGetGraphicsResetStatusEXT"};
    const bool there[3] = {version >= 32, has_extension(&gl->f, "GL_KHR_robustness"),
                           has_extension(&gl->f, "GL_EXT_robustness")};
    for (int i = 0; i < 3 && !gl->f.GetGraphicsResetStatus; i++)
        if (there[i])
            gl->f.GetGraphicsResetStatus =
                (GLenum(GL_APIENTRY *)(void))gl->config.get_proc(gl->config.get_proc_user, names[i]);
}

/* Whether a float texture can be drawn to: what EXT_color_buffer_float promises, seen with our own eyes. */
static bool renders_float(ddof_gl *gl) {
    static const GLenum formats[] = {GL_RGBA32F, GL_RGBA16F, GL_R32F, GL_RGBA32UI};
    const gl_functions *f = &gl->f;
    GLint binding = 0, framebuffer = 0;
    bool good = true;
    f->GetIntegerv(GL_TEXTURE_BINDING_2D, &binding);
    f->GetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &framebuffer);
    f->BindFramebuffer(GL_DRAW_FRAMEBUFFER, gl->probe);
    for (size_t i = 0; i < sizeof formats / sizeof *formats && good; i++) {
        GLuint texture = 0;
        f->GenTextures(1, &texture);
        f->BindTexture(GL_TEXTURE_2D, texture);
        f->TexStorage2D(GL_TEXTURE_2D, 1, formats[i], 4, 4);
        f->FramebufferTexture2D(GL_DRAW_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture, 0);
        good = f->CheckFramebufferStatus(GL_DRAW_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
        f->FramebufferTexture2D(GL_DRAW_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, 0, 0);
        f->BindTexture(GL_TEXTURE_2D, 0);
        f->DeleteTextures(1, &texture);
    }
    f->BindTexture(GL_TEXTURE_2D, (GLuint)binding);
    f->BindFramebuffer(GL_DRAW_FRAMEBUFFER, (GLuint)framebuffer);
    return good;
}

static void make_objects(ddof_gl *gl) {
    const gl_functions *f = &gl->f;
    static const GLenum parameters[][2] = {
        {GL_TEXTURE_MIN_FILTER, GL_NEAREST},   {GL_TEXTURE_MAG_FILTER, GL_NEAREST},
        {GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE}, {GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE},
        {GL_TEXTURE_COMPARE_MODE, GL_NONE},
    };
    f->GenVertexArrays(1, &gl->vertex_array);
    f->GenSamplers(1, &gl->sampler);
    f->GenFramebuffers(1, &gl->output);
    f->GenFramebuffers(1, &gl->probe);
    gl->objects += 4;
    for (size_t i = 0; i < sizeof parameters / sizeof *parameters; i++)
        f->SamplerParameteri(gl->sampler, parameters[i][0], (GLint)parameters[i][1]);
}

static ddof_status set_up(ddof_gl *gl, char *text, size_t size) {
    const gl_functions *f = &gl->f;
    const char *missing = gl_functions_load(&gl->f, &gl->config);
    if (missing) {
        snprintf(text, size, "no OpenGL ES 3.0: there is no function %s", missing);
        return DDOF_ERROR_UNSUPPORTED;
    }
    const char *version_text = (const char *)f->GetString(GL_VERSION);
    const char *renderer = (const char *)f->GetString(GL_RENDERER);
    if (!version_text) {
        snprintf(text, size, "no GL context is current on this thread");
        return DDOF_ERROR_UNSUPPORTED;
    }
    snprintf(gl->renderer, sizeof gl->renderer, "%s", renderer ? renderer : "an unnamed GL");
    const int version = es_version(f);
    if (version < OLDEST) {
        snprintf(text, size, "OpenGL ES 3.0 is needed, but the current context (%s) is %s", gl->renderer, version_text);
        return DDOF_ERROR_UNSUPPORTED;
    }
    gl_functions_load_later(&gl->f, &gl->config, version);
    load_reset_status(gl, version);
    gl_device_clear_errors(gl);
    f->GetIntegerv(GL_MAX_TEXTURE_SIZE, &gl->max_size);
    gl->blends = has_extension(f, "GL_EXT_float_blend");
    make_objects(gl);
    if ((version < 32 && !has_extension(f, "GL_EXT_color_buffer_float")) || !renders_float(gl)) {
        snprintf(text, size, "this GL (%s) does not render to float textures: EXT_color_buffer_float is needed",
                 gl->renderer);
        return DDOF_ERROR_UNSUPPORTED;
    }
    gl_device_clear_errors(gl); /* what looking at formats may have left */
    return DDOF_OK;
}

ddof_status gl_device_create(ddof_gl **out, const ddof_gl_config *config, ddof_context *owner, char *text,
                             size_t size) {
    ddof_gl *gl = config->allocate(config->memory_user, sizeof *gl);
    *out = NULL;
    if (!gl) {
        snprintf(text, size, "out of memory for a GL renderer");
        return DDOF_ERROR_MEMORY;
    }
    memset(gl, 0, sizeof *gl);
    gl->config = *config;
    gl->owner = owner ? owner : &gl->shell;
    gl->shell.config.log = config->log;
    gl->shell.config.log_user = config->log_user;
    gl->shell.config.allocate = config->allocate;
    gl->shell.config.memory_user = config->memory_user;
    gl->shell.kernels = cpu_kernels_pick(0);
    *out = gl;
    ddof_status status = set_up(gl, text, size);
    if (status != DDOF_OK) gl_device_destroy(out);
    return status;
}

void gl_device_destroy(ddof_gl **out) {
    ddof_gl *gl = *out;
    *out = NULL;
    if (gl->vertex_array) {
        gl_programs_delete(gl, &gl->programs);
        gl_programs_delete(gl, &gl->methods.programs);
        gl_programs_delete(gl, &gl->sprites.programs);
        gl_surfaces_delete(gl);
        gl_methods_delete(gl);
        gl_sprites_delete(gl);
        gl->f.DeleteFramebuffers(1, &gl->output);
        gl->f.DeleteFramebuffers(1, &gl->probe);
        gl->f.DeleteSamplers(1, &gl->sampler);
        gl->f.DeleteVertexArrays(1, &gl->vertex_array);
    }
    if (gl->shell.iris) gl->config.release(gl->config.memory_user, gl->shell.iris);
    gl->config.release(gl->config.memory_user, gl);
}

ddof_status gl_device_lost(ddof_gl *gl) {
    gl->lost = true;
    return context_fail(gl->owner, DDOF_ERROR_DEVICE, "the GL context (%s) was lost", gl->renderer);
}

ddof_status gl_device_check(ddof_gl *gl) {
    const GLenum error = gl->f.GetError();
    if (error == GL_CONTEXT_WAS_LOST || (gl->f.GetGraphicsResetStatus && gl->f.GetGraphicsResetStatus() != GL_NO_ERROR))
        return gl_device_lost(gl);
    if (error == GL_NO_ERROR) return DDOF_OK;
    gl_device_clear_errors(gl);
    if (error == GL_OUT_OF_MEMORY)
        return context_fail(gl->owner, DDOF_ERROR_DEVICE, "the GL (%s) is out of its memory", gl->renderer);
    return context_fail(gl->owner, DDOF_ERROR_DEVICE, "the GL (%s) reported error 0x%04x", gl->renderer, error);
}

void gl_device_clear_errors(ddof_gl *gl) {
    for (int i = 0; i < 16; i++) { /* a lost context may never run out of them */
        const GLenum error = gl->f.GetError();
        if (error == GL_NO_ERROR) return;
        if (error == GL_CONTEXT_WAS_LOST) gl->lost = true;
    }
}
