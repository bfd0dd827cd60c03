/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "tap.h"

#include <stdio.h>
#include <string.h>

egl_session session;
gl_tap tap;
char said[600];

static void gen_textures(GLsizei n, GLuint *names) {
    tap.made += n;
    GL(PFNGLGENTEXTURESPROC, glGenTextures)(n, names);
}

static void gen_framebuffers(GLsizei n, GLuint *names) {
    tap.made += n;
    GL(PFNGLGENFRAMEBUFFERSPROC, glGenFramebuffers)(n, names);
}

static void gen_vertex_arrays(GLsizei n, GLuint *names) {
    tap.made += n;
    GL(PFNGLGENVERTEXARRAYSPROC, glGenVertexArrays)(n, names);
}

static void gen_samplers(GLsizei n, GLuint *names) {
    tap.made += n;
    GL(PFNGLGENSAMPLERSPROC, glGenSamplers)(n, names);
}

static GLuint create_program(void) {
    tap.made++;
    return GL(PFNGLCREATEPROGRAMPROC, glCreateProgram)();
}

static GLuint create_shader(GLenum type) {
    tap.made++;
    return GL(PFNGLCREATESHADERPROC, glCreateShader)(type);
}

static bool out_of_memory;

static void tex_storage(GLenum target, GLsizei levels, GLenum format, GLsizei width, GLsizei height) {
    const size_t texel = format == GL_RGBA16F || format == GL_RG32F ? 8
                         : format == GL_R32F                        ? 4
                         : format == GL_R16F                        ? 2
                                                                    : 16;
    tap.bytes += texel * (size_t)width * (size_t)height;
    if (++tap.textures == tap.memory_at) out_of_memory = true;
    GL(PFNGLTEXSTORAGE2DPROC, glTexStorage2D)(target, levels, format, width, height);
}

static void draw_arrays(GLenum mode, GLint first, GLsizei count) {
    tap.calls++;
    GL(PFNGLDRAWARRAYSPROC, glDrawArrays)(mode, first, count);
}

static void draw_arrays_instanced(GLenum mode, GLint first, GLsizei count, GLsizei instances) {
    tap.calls++;
    GL(PFNGLDRAWARRAYSINSTANCEDPROC, glDrawArraysInstanced)(mode, first, count, instances);
}

static bool is_lost(void) {
    return tap.reset_at && tap.calls >= tap.reset_at;
}

static GLenum get_error(void) {
    tap.errors_asked++;
    if (tap.error_at && tap.errors_asked >= tap.error_at) return 0x0507;
    if (out_of_memory) {
        out_of_memory = false;
        return GL_OUT_OF_MEMORY;
    }
    return is_lost() && !tap.silent_reset ? 0x0507 : GL(PFNGLGETERRORPROC, glGetError)();
}

static GLenum reset_status(void) {
    return is_lost() ? 0x8254 /* GL_INNOCENT_CONTEXT_RESET */ : GL_NO_ERROR;
}

static GLenum check_framebuffer(GLenum target) {
    return tap.incomplete ? GL_FRAMEBUFFER_UNSUPPORTED
                          : GL(PFNGLCHECKFRAMEBUFFERSTATUSPROC, glCheckFramebufferStatus)(target);
}

static void get_integerv(GLenum name, GLint *value) {
    GL(PFNGLGETINTEGERVPROC, glGetIntegerv)(name, value);
    if (tap.no_extension && name == GL_NUM_EXTENSIONS) *value = 0;
    if (tap.small && name == GL_MAX_TEXTURE_SIZE) *value = 64;
}

static const GLubyte *get_string(GLenum name) {
    if (tap.no_extension && name == GL_VERSION) return (const GLubyte *)"OpenGL ES 3.0 of the test";
    return GL(PFNGLGETSTRINGPROC, glGetString)(name);
}

static const GLubyte *get_stringi(GLenum name, GLuint index) {
    const GLubyte *text = GL(PFNGLGETSTRINGIPROC, glGetStringi)(name, index);
    return tap.no_float_blend && text && !strcmp((const char *)text, "GL_EXT_float_blend") ? (const GLubyte *)"" : text;
}

ddof_gl_function tap_get_proc(void *user, const char *name) {
    static const struct {
        const char *name;
        ddof_gl_function function;
    } own[] = {
        {"glGenTextures", (ddof_gl_function)gen_textures},
        {"glGenFramebuffers", (ddof_gl_function)gen_framebuffers},
        {"glGenVertexArrays", (ddof_gl_function)gen_vertex_arrays},
        {"glGenSamplers", (ddof_gl_function)gen_samplers},
        {"glCreateProgram", (ddof_gl_function)create_program},
        {"glCreateShader", (ddof_gl_function)create_shader},
        {"glTexStorage2D", (ddof_gl_function)tex_storage},
        {"glDrawArrays", (ddof_gl_function)draw_arrays},
        {"glDrawArraysInstanced", (ddof_gl_function)draw_arrays_instanced},
        {"glGetStringi", (ddof_gl_function)get_stringi},
        {"glGetError", (ddof_gl_function)get_error},
        {"glGetGraphicsResetStatus", (ddof_gl_function)reset_status},
        {"glGetGraphicsResetStatusKHR", (ddof_gl_function)reset_status},
        {"glGetGraphicsResetStatusEXT", (ddof_gl_function)reset_status},
        {"glCheckFramebufferStatus", (ddof_gl_function)check_framebuffer},
        {"glGetIntegerv", (ddof_gl_function)get_integerv},
        {"glGetString", (ddof_gl_function)get_string},
    };
    assert_ptr_equal(user, &session);
    if (tap.hidden && !strcmp(name, tap.hidden)) return NULL;
    for (int i = 0; i < COUNT(own); i++)
        if (!strcmp(name, own[i].name)) return own[i].function;
    return egl_get_proc(&session, name);
}

static void keep(void *user, ddof_log_level level, const char *text) {
    (void)user, (void)level;
    snprintf(said, sizeof said, "%s", text);
}

ddof_status try_create(ddof_gl **gl) {
    const ddof_gl_config config = {.get_proc = tap_get_proc, .get_proc_user = &session, .log = keep};
    said[0] = 0;
    return ddof_gl_create(gl, &config);
}

ddof_gl *create(void) {
    ddof_gl *gl = NULL;
    memset(&tap, 0, sizeof tap);
    if (try_create(&gl) != DDOF_OK) fail_msg("ddof_gl_create: %s", said);
    tap.errors_asked = 0;
    return gl;
}

/* ---- textures */

ddof_gl_texture texture(GLenum format, int width, int height) {
    ddof_gl_texture t = {0, format};
    GL(PFNGLGENTEXTURESPROC, glGenTextures)(1, &t.name);
    GL(PFNGLBINDTEXTUREPROC, glBindTexture)(GL_TEXTURE_2D, t.name);
    GL(PFNGLTEXSTORAGE2DPROC, glTexStorage2D)(GL_TEXTURE_2D, 1, format, width, height);
    return t;
}

void fill(ddof_gl_texture t, int width, int height, GLenum format, GLenum type, const void *values) {
    GL(PFNGLBINDTEXTUREPROC, glBindTexture)(GL_TEXTURE_2D, t.name);
    GL(PFNGLTEXSUBIMAGE2DPROC, glTexSubImage2D)(GL_TEXTURE_2D, 0, 0, 0, width, height, format, type, values);
}

void read_back(ddof_gl_texture t, int width, int height, float *values) {
    GLuint framebuffer;
    GL(PFNGLGENFRAMEBUFFERSPROC, glGenFramebuffers)(1, &framebuffer);
    GL(PFNGLBINDFRAMEBUFFERPROC, glBindFramebuffer)(GL_FRAMEBUFFER, framebuffer);
    GL(PFNGLFRAMEBUFFERTEXTURE2DPROC, glFramebufferTexture2D)
    (GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, t.name, 0);
    GL(PFNGLREADPIXELSPROC, glReadPixels)(0, 0, width, height, GL_RGBA, GL_FLOAT, values);
    GL(PFNGLDELETEFRAMEBUFFERSPROC, glDeleteFramebuffers)(1, &framebuffer);
}

gl_scene gl_scene_make(int width, int height, GLenum format, uint64_t seed) {
    rng r = {seed};
    gl_scene g = {.s = scene_fill(width, height, COC_SMOOTH, COLOR_RANDOM, &r)};
    g.frame = (ddof_gl_frame){.width = width,
                              .height = height,
                              .color = texture(GL_RGBA32F, width, height),
                              .coc = texture(GL_R32F, width, height),
                              .output = texture(format, width, height)};
    fill(g.frame.color, width, height, GL_RGBA, GL_FLOAT, g.s.color);
    fill(g.frame.coc, width, height, GL_RED, GL_FLOAT, g.s.coc);
    return g;
}

void gl_scene_free(gl_scene *g) {
    const GLuint names[4] = {g->frame.color.name, g->frame.coc.name, g->frame.depth.name, g->frame.output.name};
    GL(PFNGLDELETETEXTURESPROC, glDeleteTextures)(4, names);
    scene_free(&g->s);
}

void render_gl(ddof_gl *gl, const gl_scene *g, const ddof_settings *settings, ddof_gl_stats *stats) {
    if (ddof_gl_render(gl, &g->frame, settings, stats) != DDOF_OK) fail_msg("ddof_gl_render: %s", ddof_gl_error(gl));
    assert_string_equal(ddof_gl_error(gl), "");
}

int run_with_session(const char *group, const struct CMUnitTest *tests, int count) {
    char text[300];
    const char *missing = gl_missing();
    if (!missing && (!egl_open(&session, text, sizeof text) || !egl_enter(&session, text, sizeof text))) missing = text;
    const int failed = run_gpu_tests(group, tests, count, missing);
    if (!missing) {
        egl_leave(&session);
        egl_close(&session);
    }
    return failed;
}
