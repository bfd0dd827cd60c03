/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* ddof/gl.h and the GL backend where something is wrong: arguments, textures, contexts, memory; and several at once. */
#include "tap.h"

#include <stdlib.h>
#include <string.h>

static void refused(ddof_gl *gl, const ddof_gl_frame *frame, const ddof_settings *settings, ddof_status status,
                    const char *part) {
    ddof_gl_stats stats;
    assert_int_equal(ddof_gl_render(gl, frame, settings, &stats), status);
    if (!strstr(ddof_gl_error(gl), part)) fail_msg("\"%s\" says nothing of \"%s\"", ddof_gl_error(gl), part);
    assert_int_equal(stats.draws, 0);
}

static void invalid_frames(void **state) {
    (void)state;
    ddof_gl *gl = create();
    gl_scene g = gl_scene_make(40, 30, GL_RGBA16F, 6);
    const ddof_settings s = {0};
    const ddof_gl_frame good = g.frame;
    const ddof_gl_texture integer = texture(GL_RGBA32UI, 40, 30), half = texture(GL_RGBA16F, 40, 30),
                          depth = texture(GL_DEPTH_COMPONENT24, 40, 30);
    ddof_gl_texture cube = {0, GL_RGBA16F};
    GL(PFNGLGENTEXTURESPROC, glGenTextures)(1, &cube.name);
    GL(PFNGLBINDTEXTUREPROC, glBindTexture)(GL_TEXTURE_CUBE_MAP, cube.name);
    GL(PFNGLBINDTEXTUREPROC, glBindTexture)(GL_TEXTURE_CUBE_MAP, 0);
    ddof_gl_frame f;

    assert_int_equal(ddof_gl_render(NULL, &good, &s, NULL), DDOF_ERROR_INVALID);
    refused(gl, NULL, &s, DDOF_ERROR_INVALID, "frame is NULL");
    refused(gl, &good, NULL, DDOF_ERROR_INVALID, "settings is NULL");
    f = good, f.width = 0, refused(gl, &f, &s, DDOF_ERROR_INVALID, "0 x 30");
    f = good, f.width = 1 << 19, refused(gl, &f, &s, DDOF_ERROR_UNSUPPORTED, "allows");
    f = good, f.channels = 2, refused(gl, &f, &s, DDOF_ERROR_INVALID, "channels");
    f = good, f.reserved[1] = 1, refused(gl, &f, &s, DDOF_ERROR_INVALID, "reserved");
    f = good, f.coc.name = 0, refused(gl, &f, &s, DDOF_ERROR_INVALID, "exactly one");
    f = good, f.depth = depth,
    refused(gl, &f, &(ddof_settings){.lens = {.focal_length = 50, .f_number = 2, .focus_distance = 3}},
            DDOF_ERROR_INVALID, "");
    f = good, f.output = good.color, refused(gl, &f, &s, DDOF_ERROR_INVALID, "output");
    f = good, f.color.name = 0, refused(gl, &f, &s, DDOF_ERROR_INVALID, "color");
    f = good, f.color.name = 12345, refused(gl, &f, &s, DDOF_ERROR_INVALID, "color");
    f = good, f.color.format = GL_RGBA32UI, refused(gl, &f, &s, DDOF_ERROR_INVALID, "format");
    f = good, f.color = integer, f.color.format = GL_RGBA16F, refused(gl, &f, &s, DDOF_ERROR_INVALID, "color");
    f = good, f.color = cube, refused(gl, &f, &s, DDOF_ERROR_INVALID, "color");
    f = good, f.color.format = GL_RGBA16F, refused(gl, &f, &s, DDOF_ERROR_INVALID, "color");
    f = good, f.output = half, f.output.format = GL_RGBA8, refused(gl, &f, &s, DDOF_ERROR_INVALID, "output");
    f = good, f.output = depth, f.output.format = GL_RGBA16F, refused(gl, &f, &s, DDOF_ERROR_INVALID, "output");
    f = good, f.coc = half, f.coc.format = GL_R32F, refused(gl, &f, &s, DDOF_ERROR_INVALID, "coc");
    f = good, f.coc.name = 0, f.depth = half, f.depth.format = GL_DEPTH_COMPONENT24,
    refused(gl, &f, &(ddof_settings){.lens = {.focal_length = 50, .f_number = 2, .focus_distance = 3}},
            DDOF_ERROR_INVALID, "depth");
    f = good, f.coc.name = 0, f.depth = depth,
    refused(gl, &f, &(ddof_settings){.lens = {.focal_length = 50, .f_number = 2, .focus = DDOF_FOCUS_PIXEL}},
            DDOF_ERROR_INVALID, "focus");
    refused(gl, &good, &(ddof_settings){.solver = (ddof_solver)10}, DDOF_ERROR_INVALID, "solver");
    refused(gl, &good, &(ddof_settings){.solver = DDOF_SOLVER_LINE}, DDOF_ERROR_UNSUPPORTED, "solver");
    refused(gl, &good, &(ddof_settings){.kernel = DDOF_KERNEL_DISC}, DDOF_ERROR_UNSUPPORTED, "kernel");
    refused(gl, &good, &(ddof_settings){.layers = DDOF_LAYERS_AUTO}, DDOF_ERROR_UNSUPPORTED, "layers");
    refused(gl, &good, &(ddof_settings){.method = DDOF_METHOD_GAUSSIAN}, DDOF_ERROR_UNSUPPORTED, "method");
    refused(gl, &good, &(ddof_settings){.method = DDOF_METHOD_HEXAGON}, DDOF_ERROR_UNSUPPORTED, "method");
    refused(gl, &good, &(ddof_settings){.surface = (ddof_surface)3}, DDOF_ERROR_INVALID, "surface");
    refused(gl, &good, &(ddof_settings){.shared_chain = 2}, DDOF_ERROR_INVALID, "shared_chain");
    refused(gl, &good, &(ddof_settings){.substeps = 65}, DDOF_ERROR_INVALID, "substeps");
    if (strstr((const char *)GL(PFNGLGETSTRINGPROC, glGetString)(GL_VERSION), "ES 3.2")) /* ES 3.0 cannot be asked */
        f = good, f.width = 39, refused(gl, &f, &s, DDOF_ERROR_INVALID, "40 x 30");
    assert_int_equal(GL(PFNGLGETERRORPROC, glGetError)(), GL_NO_ERROR);
    render_gl(gl, &g, &s, NULL);
    ddof_gl_destroy(&gl);
    const GLuint names[4] = {integer.name, half.name, depth.name, cube.name};
    GL(PFNGLDELETETEXTURESPROC, glDeleteTextures)(4, names);
    gl_scene_free(&g);
}

static void not_created(ddof_status status, const char *part) {
    ddof_gl *gl = (ddof_gl *)&tap;
    assert_int_equal(try_create(&gl), status);
    assert_null(gl);
    if (!strstr(said, part)) fail_msg("\"%s\" says nothing of \"%s\"", said, part);
    memset(&tap, 0, sizeof tap);
}

static void unfit_contexts(void **state) {
    (void)state;
    char text[200];
    memset(&tap, 0, sizeof tap);
    ddof_gl *gl = NULL;
    assert_int_equal(ddof_gl_create(NULL, NULL), DDOF_ERROR_INVALID);
    assert_int_equal(ddof_gl_create(&gl, NULL), DDOF_ERROR_INVALID);
    assert_int_equal(ddof_gl_create(&gl, &(ddof_gl_config){0}), DDOF_ERROR_INVALID);
    tap.hidden = "glTexStorage2D", not_created(DDOF_ERROR_UNSUPPORTED, "glTexStorage2D");
    tap.no_extension = true, not_created(DDOF_ERROR_UNSUPPORTED, "EXT_color_buffer_float");
    tap.incomplete = true, not_created(DDOF_ERROR_UNSUPPORTED, "float");
    egl_leave(&session);
    not_created(DDOF_ERROR_UNSUPPORTED, "current");
    assert_true(egl_enter(&session, text, sizeof text));

    gl_scene g = gl_scene_make(65, 20, GL_RGBA16F, 8);
    tap.small = true;
    assert_int_equal(try_create(&gl), DDOF_OK);
    refused(gl, &g.frame, &(ddof_settings){0}, DDOF_ERROR_UNSUPPORTED, "65 x 20");
    ddof_gl_destroy(&gl);
    gl_scene_free(&g);
    memset(&tap, 0, sizeof tap);
}

/* Lost while the caller's textures are looked at: not her textures' fault. */
static void lost_early(void **state) {
    (void)state;
    gl_scene g = gl_scene_make(50, 40, GL_RGBA16F, 15);
    for (int at = 1; at <= 5; at++) {
        ddof_gl *gl = create();
        tap.error_at = at;
        refused(gl, &g.frame, &(ddof_settings){0}, DDOF_ERROR_DEVICE, "lost");
        ddof_gl_destroy(&gl);
    }
    gl_scene_free(&g);
}

/* Wherever in a frame the context is lost, the frame fails, and so do all after it. */
static void lost_context(void **state) {
    (void)state;
    gl_scene g = gl_scene_make(50, 40, GL_RGBA16F, 10);
    for (int silent = 0; silent < 2; silent++)
        for (int at = 1; at <= 24; at++) {
            ddof_gl *gl = create();
            ddof_gl_stats stats;
            render_gl(gl, &g, &(ddof_settings){.solver = DDOF_SOLVER_CR}, &stats);
            if (at > stats.draws) at = 100;
            tap.silent_reset = silent;
            tap.calls = 0;
            tap.reset_at = at > 24 ? (int)stats.draws : at;
            if (silent && strstr((const char *)GL(PFNGLGETSTRINGPROC, glGetString)(GL_VERSION), "ES 3.0") &&
                !GL(ddof_gl_function, glGetGraphicsResetStatusKHR))
                tap.silent_reset = false; /* nobody to ask */
            refused(gl, &g.frame, &(ddof_settings){.solver = DDOF_SOLVER_CR}, DDOF_ERROR_DEVICE, "lost");
            refused(gl, &g.frame, &(ddof_settings){0}, DDOF_ERROR_DEVICE, "lost");
            ddof_gl_destroy(&gl);
        }
    gl_scene_free(&g);
}

static void out_of_texture_memory(void **state) {
    (void)state;
    gl_scene g = gl_scene_make(50, 40, GL_RGBA16F, 11);
    for (int bokeh = DDOF_BOKEH_OFF; bokeh <= DDOF_BOKEH_FULL; bokeh++)
        for (int at = 1; at < 12; at++) {
            const ddof_settings settings = {.bokeh = (ddof_bokeh)bokeh};
            ddof_gl *gl = create();
            tap.textures = 0;
            tap.memory_at = at;
            refused(gl, &g.frame, &settings, DDOF_ERROR_DEVICE, "memory");
            render_gl(gl, &g, &settings, NULL); /* it may go better next time */
            ddof_gl_destroy(&gl);
        }
    gl_scene_free(&g);
}

static void *no_memory(void *user, size_t bytes) {
    (void)bytes;
    return --*(int *)user < 0 ? NULL : malloc(bytes);
}

static void give_back(void *user, void *memory) {
    (void)user;
    free(memory);
}

static void out_of_memory_here(void **state) {
    (void)state;
    gl_scene g = gl_scene_make(50, 40, GL_RGBA16F, 12);
    int left = 0;
    ddof_gl *gl = NULL;
    ddof_gl_config config = {.get_proc = tap_get_proc,
                             .get_proc_user = &session,
                             .allocate = no_memory,
                             .release = give_back,
                             .memory_user = &left};
    assert_int_equal(ddof_gl_create(&gl, &config), DDOF_ERROR_MEMORY);
    left = 1;
    assert_int_equal(ddof_gl_create(&gl, &config), DDOF_OK);
    refused(gl, &g.frame, &(ddof_settings){0}, DDOF_ERROR_MEMORY, "memory");
    left = 1;
    render_gl(gl, &g, &(ddof_settings){0}, NULL);
    ddof_gl_destroy(&gl);
    gl_scene_free(&g);
}

/* ---- contexts beside each other */

/* ddof_render() with the GL backend leaves the caller's context current, and two of them do not disturb each other. */
static void beside_each_other(void **state) {
    (void)state;
    rng r = {13};
    scene s = scene_fill(64, 48, COC_SMOOTH, COLOR_RANDOM, &r), t = scene_fill(100, 30, COC_SMOOTH, COLOR_RANDOM, &r);
    float *first[2] = {fenced(64 * 48 * 16, true), fenced(100 * 30 * 16, true)};
    ddof_context *a = gl_context(), *b = gl_context();
    const EGLContext mine = session.f.GetCurrentContext();
    for (int k = 0; k < 4; k++) {
        ddof_frame f = scene_frame(&s), h = scene_frame(&t);
        render(a, &f, &(ddof_settings){0});
        render(b, &h, &(ddof_settings){.solver = DDOF_SOLVER_CR});
        assert_ptr_equal(session.f.GetCurrentContext(), mine);
        assert_int_equal(GL(PFNGLGETERRORPROC, glGetError)(), GL_NO_ERROR);
        if (k == 0) memcpy(first[0], s.output, 64 * 48 * 16), memcpy(first[1], t.output, 100 * 30 * 16);
        assert_same_bits(s.output, first[0], 64 * 48 * 4, "frame %d", k);
        assert_same_bits(t.output, first[1], 100 * 30 * 4, "frame %d", k);
        if (k == 1) assert_int_equal(ddof_trim(a), DDOF_OK);
    }
    DESTROY(a);
    DESTROY(b);
    assert_ptr_equal(session.f.GetCurrentContext(), mine);
    fenced_free(first[0]);
    fenced_free(first[1]);
    scene_free(&s);
    scene_free(&t);
}

static int stop_at_half(void *user, double done) {
    assert_ptr_equal(session.f.GetCurrentContext(),
                     *(EGLContext *)user); /* no context but the caller's is hers to see */
    return done >= 0.5;
}

static void cancelled(void **state) {
    (void)state;
    rng r = {14};
    scene s = scene_fill(64, 48, COC_SMOOTH, COLOR_RANDOM, &r);
    EGLContext mine = session.f.GetCurrentContext();
    ddof_config config = {.backend = DDOF_BACKEND_GL, .progress = stop_at_half, .progress_user = &mine};
    ddof_context *ctx = NULL;
    ddof_frame f = scene_frame(&s);
    assert_int_equal(ddof_create(&ctx, &config), DDOF_OK);
    assert_int_equal(ddof_render(ctx, &f, &(ddof_settings){0}, NULL), DDOF_ERROR_CANCELLED);
    assert_ptr_equal(session.f.GetCurrentContext(), mine);
    DESTROY(ctx);
    scene_free(&s);
}

static void too_large(void **state) {
    (void)state;
    const int w = 1 << 18;
    float *color = calloc((size_t)w, 4), *coc = calloc((size_t)w, 4), *output = calloc((size_t)w, 4);
    ddof_context *ctx = gl_context();
    const ddof_frame f = {.color = ddof_image_interleaved(color, w, 1, 1, DDOF_FLOAT, 0),
                          .coc = ddof_image_interleaved(coc, w, 1, 1, DDOF_FLOAT, 0),
                          .output = ddof_image_interleaved(output, w, 1, 1, DDOF_FLOAT, 0)};
    assert_int_equal(ddof_render(ctx, &f, &(ddof_settings){0}, NULL), DDOF_ERROR_UNSUPPORTED);
    assert_non_null(strstr(ddof_error(ctx), "262144 x 1"));
    DESTROY(ctx);
    free(color);
    free(coc);
    free(output);
}

int main(void) {
    static const struct CMUnitTest tests[] = {
        cmocka_unit_test(invalid_frames),
        cmocka_unit_test(unfit_contexts),
        cmocka_unit_test(lost_early),
        cmocka_unit_test(lost_context),
        cmocka_unit_test(out_of_texture_memory),
        cmocka_unit_test(out_of_memory_here),
        cmocka_unit_test(beside_each_other),
        cmocka_unit_test(cancelled),
        cmocka_unit_test(too_large),
    };
    return run_with_session("gl refused", tests, COUNT(tests));
}
