/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* ddof/gl.h on a context of the test's own: pictures, bytes, objects, state. */
#include "tap.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static void against_reference(void **state) {
    (void)state;
    ddof_gl *gl = create();
    ddof_context *reference = reference_context();
    for (int k = 0; k < 28; k++) {
        gl_scene g = gl_scene_make(70 + k, 40 + 3 * k, k % 2 ? GL_RGBA32F : GL_RGBA16F, (uint64_t)k);
        const size_t n = (size_t)g.s.width * (size_t)g.s.height * 4;
        ddof_settings settings = {.solver = (ddof_solver)(k % 7),
                                  .surface = (ddof_surface)(k / 7 % 3),
                                  .shared_chain = k / 2 % 2,
                                  .substeps = k / 9,
                                  .conductance = (ddof_conductance)(k / 3 % 2)};
        float *got = fenced(n * sizeof *got, true);
        ddof_frame frame = scene_frame(&g.s);
        render(reference, &frame, &settings);
        render_gl(gl, &g, &settings, NULL);
        read_back(g.frame.output, g.s.width, g.s.height, got);
        assert_close(got, g.s.output, n, k % 2 ? solver_tolerance(&settings) : 2e-3, "frame %d", k);
        fenced_free(got);
        gl_scene_free(&g);
    }
    DESTROY(reference);
    ddof_gl_destroy(&gl);
    assert_null(gl);
}

/* What a frame of a solver or, from SOLVERS on, of sprites asks for. */
enum { SOLVERS = 7, KINDS = SOLVERS + 4 };

static ddof_settings kind_of(int k) {
    if (k < SOLVERS) return (ddof_settings){.solver = (ddof_solver)k};
    return (ddof_settings){
        .bokeh = k % 2 ? DDOF_BOKEH_HIGHLIGHTS : DDOF_BOKEH_FULL,
        .sprites = {.threshold = 0.9, .resolution = k % 4 < 2 ? DDOF_RESOLUTION_FULL : DDOF_RESOLUTION_HALF},
        .surface = DDOF_SURFACE_RGBA32F,
        .solver = DDOF_SOLVER_CR4};
}

/* Sprites in textures as in memory; where floats of 32 bits cannot be blended, sums are of half floats. */
static void sprites(void **state) {
    (void)state;
    ddof_context *cpu = context_of(0, 1);
    for (int halves = 0; halves < 2; halves++) {
        ddof_gl *gl = create();
        if (halves) {
            ddof_gl_destroy(&gl);
            tap.no_float_blend = true;
            assert_int_equal(try_create(&gl), DDOF_OK);
        }
        for (int k = 0; k < 8; k++) {
            gl_scene g = gl_scene_make(61 + k, 47, k % 3 ? GL_RGBA32F : GL_RGBA16F, (uint64_t)k);
            const int w = g.s.width, h = g.s.height, n = w * h * 4;
            ddof_settings settings = kind_of(SOLVERS + k % 4);
            settings.iris = k < 4 ? (ddof_iris){.cats_eye = 0.4} : (ddof_iris){.shape = DDOF_IRIS_POLYGON, .blades = 6};
            for (int i = 0; i < w * h; i += 41) /* also where holes are filled from around */
                for (int c = 0; c < 4; c++)
                    g.s.color[4 * i + c] = i % 2 ? 12 : NAN;
            fill(g.frame.color, w, h, GL_RGBA, GL_FLOAT, g.s.color);
            ddof_frame frame = scene_frame(&g.s);
            if (k / 2 % 2) {
                g.frame.channels = 3;
                for (int i = 3; i < n; i += 4)
                    g.s.color[i] = 1;
            }
            float *got = fenced((size_t)n * sizeof *got, true);
            ddof_gl_stats stats;
            render(cpu, &frame, &settings);
            render_gl(gl, &g, &settings, &stats);
            read_back(g.frame.output, w, h, got);
            const double allowed = halves ? 1e-2 : k % 3 ? 2e-5 : 2e-3;
            for (int i = 0; i < n; i++)
                if (!(fabs((double)got[i] - g.s.output[i]) <= allowed * (1 + fabs((double)g.s.output[i]))))
                    fail_msg("half floats %d, frame %d: value %d is %g, not %g", halves, k, i, got[i], g.s.output[i]);
            assert_true(stats.surface_bytes > 0);
            fenced_free(got);
            gl_scene_free(&g);
        }
        ddof_gl_destroy(&gl);
    }
    DESTROY(cpu);
}

/* Every kind of depth texture gives what its values give as CoC or float depth. */
static void depth_textures(void **state) {
    static const GLenum formats[] = {GL_R16F,
                                     GL_DEPTH_COMPONENT16,
                                     GL_DEPTH_COMPONENT24,
                                     GL_DEPTH_COMPONENT32F,
                                     GL_DEPTH24_STENCIL8,
                                     GL_DEPTH32F_STENCIL8};
    const int w = 60, h = 34;
    const size_t n = (size_t)w * (size_t)h;
    (void)state;
    ddof_gl *gl = create();
    const ddof_settings settings = {.lens = {.focal_length = 85, .f_number = 1.4, .focus_distance = 2},
                                    .depth = {.kind = DDOF_DEPTH_DEVICE, .z_at_0 = 0.5, .z_at_1 = 50},
                                    .surface = DDOF_SURFACE_RGBA32F,
                                    .solver = DDOF_SOLVER_CR4};
    gl_scene g = gl_scene_make(w, h, GL_RGBA32F, 5);
    float *want = fenced(n * 16, true), *got = fenced(n * 16, true), *depth = fenced(n * 4, true);
    uint16_t *small = fenced(n * 2, true);
    uint32_t *pair = fenced(n * 8, true);
    rng r = {77};
    for (size_t i = 0; i < n; i++)
        depth[i] = (float)(rng_bits(&r) % 257) / 256; /* exact in all formats but the unorms */
    const ddof_gl_texture coc = g.frame.coc;
    g.frame.coc = (ddof_gl_texture){0, 0};
    g.frame.depth = texture(GL_R32F, w, h);
    fill(g.frame.depth, w, h, GL_RED, GL_FLOAT, depth);
    render_gl(gl, &g, &settings, NULL);
    read_back(g.frame.output, w, h, want);
    for (int k = 0; k < COUNT(formats); k++) {
        GL(PFNGLDELETETEXTURESPROC, glDeleteTextures)(1, &g.frame.depth.name);
        g.frame.depth = texture(formats[k], w, h);
        for (size_t i = 0; i < n; i++) {
            small[i] = (uint16_t)lrint(depth[i] * 65535.0);
            const uint32_t unorm = (uint32_t)llrint(depth[i] * 16777215.0);
            memcpy(&pair[k == 5 ? 2 * i : i], k == 5 ? (const void *)&depth[i] : &(uint32_t){unorm << 8}, 4);
        }
        if (k == 0)
            fill(g.frame.depth, w, h, GL_RED, GL_FLOAT, depth);
        else if (k == 1)
            fill(g.frame.depth, w, h, GL_DEPTH_COMPONENT, GL_UNSIGNED_SHORT, small);
        else if (k == 3)
            fill(g.frame.depth, w, h, GL_DEPTH_COMPONENT, GL_FLOAT, depth);
        else if (k == 2) {
            for (size_t i = 0; i < n; i++)
                pair[i] = (uint32_t)llrint(depth[i] * 4294967295.0);
            fill(g.frame.depth, w, h, GL_DEPTH_COMPONENT, GL_UNSIGNED_INT, pair);
        } else
            fill(g.frame.depth, w, h, GL_DEPTH_STENCIL,
                 k == 4 ? GL_UNSIGNED_INT_24_8 : GL_FLOAT_32_UNSIGNED_INT_24_8_REV, pair);
        render_gl(gl, &g, &settings, NULL);
        read_back(g.frame.output, w, h, got);
        assert_close(got, want, n * 4, k == 1 ? 1e-3 : 1e-5, "depth format 0x%04x", formats[k]);
    }
    g.frame.coc = coc;
    fenced_free(want);
    fenced_free(got);
    fenced_free(depth);
    fenced_free(small);
    fenced_free(pair);
    gl_scene_free(&g);
    ddof_gl_destroy(&gl);
}

/* GL makes nothing for a second frame, and what it makes for the first is what ddof_gl_surface_bytes() says. */
static void second_frame(void **state) {
    (void)state;
    for (int k = 0; k < 32; k++) {
        ddof_gl *gl = create();
        gl_scene g = gl_scene_make(133, 101, GL_RGBA16F, 9);
        ddof_settings settings = {
            .solver = (ddof_solver)(k % 6 + 1), .shared_chain = k / 6 % 2, .surface = (ddof_surface)(k / 12 + 1)};
        if (k >= 24) settings = kind_of(SOLVERS + k % 4);
        if (k >= 28) settings.surface = DDOF_SURFACE_RGBA16F;
        ddof_gl_stats first, second;
        size_t said_bytes = 0;
        tap.bytes = 0;
        render_gl(gl, &g, &settings, &first);
        assert_int_equal(tap.bytes, first.surface_bytes);
        assert_int_equal(ddof_gl_surface_bytes(133, 101, &settings, &said_bytes), DDOF_OK);
        assert_int_equal(said_bytes, first.surface_bytes);
        tap.made = 0;
        render_gl(gl, &g, &settings, &second);
        assert_int_equal(tap.made, 0);
        assert_int_equal(first.objects, second.objects);
        assert_int_equal(first.draws, tap.calls / 2);
        assert_non_null(second.device);
        assert_int_equal(ddof_gl_trim(gl), DDOF_OK);
        render_gl(gl, &g, &settings, &second);
        assert_true(tap.made > 0);
        gl_scene_free(&g);
        ddof_gl_destroy(&gl);
    }
}

/* At most what table 8.1 of Gruen 2011 says, and per pixel what its numbers amount to. */
static void published_bytes(void **state) {
    static const int size[4][2] = {{1280, 1024}, {1600, 1200}, {1920, 1200}, {2560, 1600}};
    static const struct {
        ddof_solver solver;
        double per_pixel, megabytes[4];
    } published[] = {
        {DDOF_SOLVER_CR, 69, {90, 132, 158, 281}},
        {DDOF_SOLVER_CR_PACK, 53, {70, 102, 122, 219}},
        {DDOF_SOLVER_CR4, 38, {50, 73, 88, 156}},
        {DDOF_SOLVER_CR4_PACK, 30, {40, 58, 70, 125}},
    };
    (void)state;
    for (int i = 0; i < COUNT(published); i++)
        for (int k = 0; k < 4; k++) {
            size_t twice = 0, shared = 0;
            const double pixels = (double)size[k][0] * size[k][1];
            ddof_settings settings = {.solver = published[i].solver};
            assert_int_equal(ddof_gl_surface_bytes(size[k][0], size[k][1], &settings, &twice), DDOF_OK);
            settings.shared_chain = 1;
            assert_int_equal(ddof_gl_surface_bytes(size[k][0], size[k][1], &settings, &shared), DDOF_OK);
            assert_true((double)twice / pixels <= published[i].per_pixel);
            assert_true((double)twice <= published[i].megabytes[k] * 1e6);
            assert_true(shared < twice);
        }
    for (int w = 1; w < 70; w++) /* odd sizes are rounded down, never up */
        for (int h = 1; h < 70; h++) {
            size_t bytes = 0;
            assert_int_equal(ddof_gl_surface_bytes(w, h, &(ddof_settings){0}, &bytes), DDOF_OK);
            assert_true((double)bytes <= 30.0 * w * h);
        }
}

/* ---- state */

enum { UNITS = 16, DUMP = 400 };

/* All that a context can be asked in ES 3.0 that a draw could change. */
static int dump(GLint *out) {
    static const GLenum single[] = {
        GL_CURRENT_PROGRAM,
        GL_VERTEX_ARRAY_BINDING,
        GL_DRAW_FRAMEBUFFER_BINDING,
        GL_READ_FRAMEBUFFER_BINDING,
        GL_ACTIVE_TEXTURE,
        GL_ARRAY_BUFFER_BINDING,
        GL_ELEMENT_ARRAY_BUFFER_BINDING,
        GL_PIXEL_PACK_BUFFER_BINDING,
        GL_PIXEL_UNPACK_BUFFER_BINDING,
        GL_UNIFORM_BUFFER_BINDING,
        GL_RENDERBUFFER_BINDING,
        GL_TRANSFORM_FEEDBACK_BINDING,
        GL_BLEND,
        GL_CULL_FACE,
        GL_DEPTH_TEST,
        GL_DITHER,
        GL_POLYGON_OFFSET_FILL,
        GL_PRIMITIVE_RESTART_FIXED_INDEX,
        GL_RASTERIZER_DISCARD,
        GL_SAMPLE_ALPHA_TO_COVERAGE,
        GL_SAMPLE_COVERAGE,
        GL_SCISSOR_TEST,
        GL_STENCIL_TEST,
        GL_DEPTH_WRITEMASK,
        GL_DEPTH_FUNC,
        GL_STENCIL_WRITEMASK,
        GL_BLEND_SRC_RGB,
        GL_BLEND_DST_RGB,
        GL_BLEND_SRC_ALPHA,
        GL_BLEND_DST_ALPHA,
        GL_BLEND_EQUATION_RGB,
        GL_BLEND_EQUATION_ALPHA,
        GL_CULL_FACE_MODE,
        GL_FRONT_FACE,
        GL_STENCIL_FUNC,
        GL_STENCIL_REF,
        GL_PACK_ALIGNMENT,
        GL_PACK_ROW_LENGTH,
        GL_UNPACK_ALIGNMENT,
        GL_UNPACK_ROW_LENGTH,
        GL_UNPACK_SKIP_ROWS,
        GL_UNPACK_SKIP_PIXELS,
        GL_READ_BUFFER,
        GL_DRAW_BUFFER0,
        GL_DRAW_BUFFER1,
    };
    static const GLenum four[] = {GL_VIEWPORT, GL_SCISSOR_BOX, GL_COLOR_WRITEMASK};
    static const GLenum per_unit[] = {GL_TEXTURE_BINDING_2D, GL_TEXTURE_BINDING_3D, GL_TEXTURE_BINDING_2D_ARRAY,
                                      GL_TEXTURE_BINDING_CUBE_MAP, GL_SAMPLER_BINDING};
    PFNGLGETINTEGERVPROC get = GL(PFNGLGETINTEGERVPROC, glGetIntegerv);
    PFNGLACTIVETEXTUREPROC activate = GL(PFNGLACTIVETEXTUREPROC, glActiveTexture);
    GLint active;
    int n = 0;
    memset(out, 0, DUMP * sizeof *out);
    for (int i = 0; i < COUNT(single); i++)
        get(single[i], &out[n++]);
    for (int i = 0; i < COUNT(four); i++, n += 4)
        get(four[i], &out[n]);
    get(GL_ACTIVE_TEXTURE, &active);
    for (GLuint u = 0; u < UNITS; u++)
        for (int i = 0; i < COUNT(per_unit); i++) {
            activate(GL_TEXTURE0 + u);
            get(per_unit[i], &out[n++]);
        }
    activate((GLenum)active);
    assert_true(n <= DUMP);
    return n;
}

/* A state as unlike the one a frame needs as can be. */
static void disturb(const gl_scene *g) {
    static const GLenum caps[] = {GL_BLEND,
                                  GL_CULL_FACE,
                                  GL_DEPTH_TEST,
                                  GL_DITHER,
                                  GL_POLYGON_OFFSET_FILL,
                                  GL_RASTERIZER_DISCARD,
                                  GL_SAMPLE_ALPHA_TO_COVERAGE,
                                  GL_SAMPLE_COVERAGE,
                                  GL_SCISSOR_TEST,
                                  GL_STENCIL_TEST};
    GLuint name[3], vertex_array, framebuffer[2], sampler;
    for (int i = 0; i < COUNT(caps); i++)
        GL(PFNGLENABLEPROC, glEnable)(caps[i]);
    GL(PFNGLGENTEXTURESPROC, glGenTextures)(3, name);
    GL(PFNGLGENSAMPLERSPROC, glGenSamplers)(1, &sampler);
    GL(PFNGLGENVERTEXARRAYSPROC, glGenVertexArrays)(1, &vertex_array);
    GL(PFNGLGENFRAMEBUFFERSPROC, glGenFramebuffers)(2, framebuffer);
    for (GLuint u = 0; u < UNITS; u++) {
        GL(PFNGLACTIVETEXTUREPROC, glActiveTexture)(GL_TEXTURE0 + u);
        GL(PFNGLBINDTEXTUREPROC, glBindTexture)(GL_TEXTURE_2D, u % 3 ? name[0] : g->frame.color.name);
        GL(PFNGLBINDTEXTUREPROC, glBindTexture)(GL_TEXTURE_3D, name[1]);
        GL(PFNGLBINDTEXTUREPROC, glBindTexture)(GL_TEXTURE_CUBE_MAP, name[2]);
        GL(PFNGLBINDSAMPLERPROC, glBindSampler)(u, u % 2 ? sampler : 0);
    }
    GL(PFNGLACTIVETEXTUREPROC, glActiveTexture)(GL_TEXTURE0 + 7);
    GL(PFNGLBINDVERTEXARRAYPROC, glBindVertexArray)(vertex_array);
    GL(PFNGLBINDFRAMEBUFFERPROC, glBindFramebuffer)(GL_DRAW_FRAMEBUFFER, framebuffer[0]);
    GL(PFNGLBINDFRAMEBUFFERPROC, glBindFramebuffer)(GL_READ_FRAMEBUFFER, framebuffer[1]);
    GL(PFNGLVIEWPORTPROC, glViewport)(3, 4, 5, 6);
    GL(PFNGLSCISSORPROC, glScissor)(1, 2, 3, 4);
    GL(PFNGLCOLORMASKPROC, glColorMask)(GL_TRUE, GL_FALSE, GL_TRUE, GL_FALSE);
    GL(PFNGLBLENDFUNCPROC, glBlendFunc)(GL_DST_COLOR, GL_ONE_MINUS_SRC_ALPHA);
    GL(PFNGLBLENDEQUATIONSEPARATEPROC, glBlendEquationSeparate)(GL_FUNC_SUBTRACT, GL_MAX);
    GL(PFNGLPIXELSTOREIPROC, glPixelStorei)(GL_UNPACK_ROW_LENGTH, 77);
    GL(PFNGLPIXELSTOREIPROC, glPixelStorei)(GL_UNPACK_SKIP_ROWS, 3);
    GL(PFNGLPIXELSTOREIPROC, glPixelStorei)(GL_UNPACK_ALIGNMENT, 1);
    GLuint buffer;
    GL(PFNGLGENBUFFERSPROC, glGenBuffers)(1, &buffer);
    GL(PFNGLBINDBUFFERPROC, glBindBuffer)(GL_PIXEL_UNPACK_BUFFER, buffer);
}

static void calm(void) {
    static const GLenum caps[] = {GL_BLEND,
                                  GL_CULL_FACE,
                                  GL_DEPTH_TEST,
                                  GL_POLYGON_OFFSET_FILL,
                                  GL_RASTERIZER_DISCARD,
                                  GL_SAMPLE_ALPHA_TO_COVERAGE,
                                  GL_SAMPLE_COVERAGE,
                                  GL_SCISSOR_TEST,
                                  GL_STENCIL_TEST};
    for (int i = 0; i < COUNT(caps); i++)
        GL(PFNGLDISABLEPROC, glDisable)(caps[i]);
    GL(PFNGLCOLORMASKPROC, glColorMask)(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    GL(PFNGLPIXELSTOREIPROC, glPixelStorei)(GL_UNPACK_ROW_LENGTH, 0);
    GL(PFNGLPIXELSTOREIPROC, glPixelStorei)(GL_UNPACK_SKIP_ROWS, 0);
    GL(PFNGLPIXELSTOREIPROC, glPixelStorei)(GL_UNPACK_ALIGNMENT, 4);
    GL(PFNGLBINDBUFFERPROC, glBindBuffer)(GL_PIXEL_UNPACK_BUFFER, 0);
    for (GLuint u = 0; u < UNITS; u++)
        GL(PFNGLBINDSAMPLERPROC, glBindSampler)(u, 0);
    GL(PFNGLACTIVETEXTUREPROC, glActiveTexture)(GL_TEXTURE0);
}

static void state_is_kept(void **state) {
    (void)state;
    GLint before[DUMP], after[DUMP];
    gl_scene g = gl_scene_make(90, 50, GL_RGBA32F, 3);
    float *plain = fenced(90 * 50 * 16, true), *disturbed = fenced(90 * 50 * 16, true);
    ddof_gl *gl = create();
    render_gl(gl, &g, &(ddof_settings){0}, NULL);
    read_back(g.frame.output, 90, 50, plain);
    ddof_gl_destroy(&gl);

    disturb(&g);
    const int n = dump(before);
    gl = create();
    assert_int_equal(dump(after), n);
    assert_memory_equal(before, after, sizeof before);
    for (int k = 0; k < 2 * KINDS; k++) { /* the first frame of a kind makes surfaces, the second does not */
        ddof_settings settings = kind_of(k / 2);
        settings.shared_chain = k % 3 == 0;
        render_gl(gl, &g, &settings, NULL);
        dump(after);
        for (int i = 0; i < n; i++)
            if (before[i] != after[i]) fail_msg("state %d was %d and is %d", i, before[i], after[i]);
    }
    ddof_gl_frame bad = g.frame; /* nor does a frame that fails change any */
    bad.output.format = GL_RGBA16F;
    assert_int_equal(ddof_gl_render(gl, &bad, &(ddof_settings){0}, NULL), DDOF_ERROR_INVALID);
    dump(after);
    assert_memory_equal(before, after, sizeof before);
    render_gl(gl, &g, &(ddof_settings){0}, NULL);
    ddof_gl_destroy(&gl);
    dump(after);
    assert_memory_equal(before, after, sizeof before);
    calm();
    read_back(g.frame.output, 90, 50, disturbed);
    assert_same_bits(disturbed, plain, 90 * 50 * 4, "rendered in a disturbed state");
    fenced_free(plain);
    fenced_free(disturbed);
    gl_scene_free(&g);
}

/* ---- KHR_debug */

static int messages;

static void GL_APIENTRY message(GLenum source, GLenum type, GLuint id, GLenum severity, GLsizei length,
                                const GLchar *text, const void *user) {
    (void)source, (void)type, (void)id, (void)length, (void)user;
    if (severity == 0x826B) return; /* GL_DEBUG_SEVERITY_NOTIFICATION */
    messages++;
    printf("# GL says: %s\n", text);
}

static void debug_is_silent(void **state) {
    typedef void(GL_APIENTRY * callback)(GLenum, GLenum, GLuint, GLenum, GLsizei, const GLchar *, const void *);
    typedef void(GL_APIENTRY * set_callback)(callback, const void *);
    (void)state;
    set_callback set = GL(set_callback, glDebugMessageCallbackKHR);
    if (!set) skip();
    gl_scene g = gl_scene_make(120, 90, GL_RGBA16F, 4);
    GL(PFNGLENABLEPROC, glEnable)(0x92E0); /* GL_DEBUG_OUTPUT */
    GL(PFNGLENABLEPROC, glEnable)(0x8242); /* GL_DEBUG_OUTPUT_SYNCHRONOUS */
    set(message, NULL);
    messages = 0;
    ddof_gl *gl = create();
    for (int k = 0; k < 28; k++) {
        const ddof_settings settings = {
            .solver = (ddof_solver)(k % 7), .shared_chain = k / 7 % 2, .surface = (ddof_surface)(k / 14 + 1)};
        render_gl(gl, &g, &settings, NULL);
    }
    for (int k = SOLVERS; k < KINDS; k++) {
        const ddof_settings settings = kind_of(k);
        render_gl(gl, &g, &settings, NULL);
    }
    ddof_gl_destroy(&gl);
    assert_int_equal(messages, 0);
    GL(PFNGLDISABLEPROC, glDisable)(0xFFFF); /* the callback does hear of errors */
    assert_int_equal(messages, 1);
    GL(PFNGLGETERRORPROC, glGetError)();
    set(NULL, NULL);
    GL(PFNGLDISABLEPROC, glDisable)(0x92E0);
    gl_scene_free(&g);
}

int main(void) {
    static const struct CMUnitTest tests[] = {
        cmocka_unit_test(against_reference), cmocka_unit_test(sprites),         cmocka_unit_test(depth_textures),
        cmocka_unit_test(second_frame),      cmocka_unit_test(published_bytes), cmocka_unit_test(state_is_kept),
        cmocka_unit_test(debug_is_silent),
    };
    return run_with_session("gl interop", tests, COUNT(tests));
}
