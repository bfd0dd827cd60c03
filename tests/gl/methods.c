/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The Gaussian and the hexagon on the GL backend against the CPU engine, which has the same definition: 2e-5 of the range of the colours with
 * rgba32f, 2e-3 with rgba16f. */
#include "../library/layout.h"
#include "support.h"

#include <math.h>
#include <string.h>

enum { CASES = 4 }; /* method and surface */

static ddof_settings settings_of(int i) {
    return (ddof_settings){.method = i % 2 ? DDOF_METHOD_HEXAGON : DDOF_METHOD_GAUSSIAN,
                           .surface = i / 2 % 2 ? DDOF_SURFACE_RGBA16F : DDOF_SURFACE_RGBA32F};
}

static double tolerance_for(const ddof_settings *s) {
    return s->surface == DDOF_SURFACE_RGBA32F ? 2e-5 : 2e-3;
}

static size_t values_of(const scene *s) {
    return 4 * (size_t)s->width * (size_t)s->height;
}

static double range_of(const scene *s) {
    double most = 0;
    for (size_t v = 0; v < values_of(s); v++)
        if (isfinite(s->color[v])) most = fmax(most, fabs(s->color[v]));
    return most;
}

/* The same of both, and what they count. */
static void compare(ddof_context *gl, ddof_context *cpu, const scene *s, ddof_frame frame, const ddof_settings *settings, const char *what) {
    float *want = fenced(values_of(s) * sizeof *want, true);
    const double allowed = tolerance_for(settings) * range_of(s);
    const int64_t holes = render(gl, &frame, settings).nonfinite_pixels;
    for (int c = 0; c < 4; c++) frame.output.plane[c].data = want + c;
    assert_int_equal(render(cpu, &frame, settings).nonfinite_pixels, holes);
    for (size_t p = 0; p < values_of(s) / 4; p++)
        assert_close(s->output + 4 * p, want + 4 * p, (size_t)frame.color.channels, allowed, "%s, %d x %d, method %d, surface %d, pixel %d", what,
                     s->width, s->height, settings->method, settings->surface, (int)p);
    fenced_free(want);
}

/* Blocks of a few CoC of either sign: what lies over what, with steps of 1 to 4. */
static void fill_blocks(scene *s, float most, int turn) {
    for (int y = 0; y < s->height; y++)
        for (int x = 0; x < s->width; x++) {
            const int block = x / 20 * 7 + y / 20 * 5 + turn;
            s->coc[y * s->width + x] = most / (float)(1 + block % 3) * (block % 2 ? 1.0f : -1.0f) * (block % 5 ? 1 : 0);
        }
}

static void pictures(void **state) {
    static const int sizes[][2] = {{1, 1}, {7, 5}, {1, 70}, {70, 1}, {131, 67}, {300, 40}};
    (void)state;
    rng r = {140};
    ddof_context *gl = gl_context(), *cpu = context_of(0, 2);
    for (int i = 0; i < COUNT(sizes); i++)
        for (int k = 0; k < 2 * CASES; k++) {
            const ddof_settings settings = settings_of(k);
            scene s = scene_fill(sizes[i][0], sizes[i][1], COC_SMOOTH, (color_pattern)(k % 3), &r);
            if (k >= CASES) fill_blocks(&s, (float[]){3, 12, 60, 300}[k % 4], i);
            ddof_frame frame = scene_frame(&s);
            frame.pixel_aspect = k % 3 == 2 ? 1.25 : 1;
            frame.color.channels = frame.output.channels = 1 + (k + i) % 4;
            compare(gl, cpu, &s, frame, &settings, "picture");
            scene_free(&s);
        }
    DESTROY(gl);
    DESTROY(cpu);
}

static void layers(void **state) {
    (void)state;
    rng r = {141};
    ddof_context *gl = gl_context(), *cpu = context_of(0, 2);
    for (int k = 0; k < CASES; k++) {
        ddof_settings settings = settings_of(k);
        settings.layers = DDOF_LAYERS_AUTO;
        scene s = scene_fill(120, 80, COC_ZERO, COLOR_RAMP, &r);
        fill_blocks(&s, 24, k);
        compare(gl, cpu, &s, scene_frame(&s), &settings, "layers");
        scene_free(&s);
    }
    DESTROY(gl);
    DESTROY(cpu);
}

static void holes(void **state) {
    (void)state;
    rng r = {142};
    ddof_context *gl = gl_context(), *cpu = context_of(0, 2);
    for (int k = 0; k < 3 * CASES; k++) {
        const ddof_settings settings = settings_of(k);
        scene s = scene_fill(90, 50, COC_SMOOTH, COLOR_RANDOM, &r);
        for (size_t v = 0; v < values_of(&s); v += 4)
            if (rng_unit(&r) < (double[]){0.01, 0.6, 1}[k / CASES]) *(v % 8 ? &s.color[v + 1] : &s.coc[v / 4]) = k % 2 ? NAN : -INFINITY;
        compare(gl, cpu, &s, scene_frame(&s), &settings, "holes");
        scene_free(&s);
    }
    DESTROY(gl);
    DESTROY(cpu);
}

/* A constant keeps its bits where they are floats; what is bright or dark is scaled for half floats. */
static void brightness(void **state) {
    static const float brights[] = {0.1f, 3e5f, 1e-7f};
    (void)state;
    rng r = {143};
    ddof_context *gl = gl_context();
    for (int k = 0; k < CASES; k++)
        for (int i = 0; i < COUNT(brights); i++) {
            const ddof_settings settings = settings_of(k);
            scene s = scene_fill(60, 40, COC_SMOOTH, COLOR_RANDOM, &r);
            for (size_t v = 0; v < values_of(&s); v++) s.color[v] = brights[i] * (float)(1 + v % 4);
            ddof_frame frame = scene_frame(&s);
            render(gl, &frame, &settings);
            assert_close(s.output, s.color, values_of(&s), (settings.surface == DDOF_SURFACE_RGBA32F ? 1e-6 : 1e-3) * 4 * (double)brights[i],
                         "%g, method %d, surface %d", (double)brights[i], settings.method, settings.surface);
            scene_free(&s);
        }
    DESTROY(gl);
}

/* Straight alpha in half floats, in place. */
static void arrangements(void **state) {
    (void)state;
    rng r = {144};
    ddof_context *gl = gl_context(), *cpu = context_of(0, 2);
    for (int k = 0; k < CASES; k++) {
        const ddof_settings settings = settings_of(k);
        scene s = scene_fill(80, 33, COC_SMOOTH, COLOR_RANDOM, &r);
        float *got[2];
        for (size_t p = 3; p < values_of(&s); p += 4) s.color[p] = 0.5f + 0.5f * s.color[p];
        for (int i = 0; i < 2; i++) {
            stored both = stored_make(LAYOUT_PLANAR, s.width, s.height, 4, 15);
            stored_put(&both, s.color, 4);
            ddof_frame frame = scene_frame(&s);
            frame.color = frame.output = both.image;
            frame.color.alpha = DDOF_ALPHA_STRAIGHT;
            render(i ? gl : cpu, &frame, &settings);
            got[i] = fenced(values_of(&s) * sizeof *got[i], true);
            stored_get(&both, got[i], 4);
            assert_gaps_intact(&both);
            stored_free(&both);
        }
        assert_close(got[1], got[0], values_of(&s), 1e-3 + 2 * tolerance_for(&settings), "straight, method %d, surface %d", settings.method,
                     settings.surface);
        fenced_free(got[0]);
        fenced_free(got[1]);
        scene_free(&s);
    }
    DESTROY(gl);
    DESTROY(cpu);
}

typedef struct watcher {
    int calls, stop_at;
    double last;
} watcher;

static int watch(void *user, double done) {
    watcher *w = user;
    assert_true(done >= w->last && done <= 1);
    w->last = done;
    return ++w->calls == w->stop_at;
}

/* Stopped at every call; the bytes are those that were said, and those of the textures. */
static void calls(void **state) {
    (void)state;
    rng r = {145};
    watcher w = {0, 0, 0};
    const ddof_config config = {.backend = DDOF_BACKEND_GL, .progress = watch, .progress_user = &w};
    ddof_context *ctx = NULL;
    assert_int_equal(ddof_create(&ctx, &config), DDOF_OK);
    for (int k = 0; k < CASES; k++) {
        const ddof_settings settings = settings_of(k);
        scene s = scene_fill(64, 50, COC_SMOOTH, COLOR_RANDOM, &r);
        const ddof_frame frame = scene_frame(&s);
        size_t bytes = 0;
        assert_int_equal(ddof_trim(ctx), DDOF_OK);
        assert_int_equal(ddof_scratch_bytes(ctx, &frame, &settings, &bytes), DDOF_OK);
        w = (watcher){0, 0, 0};
        const ddof_stats stats = render(ctx, &frame, &settings);
        assert_int_equal(stats.scratch_bytes, bytes);
        assert_int_equal(stats.surface_bytes, 64 * 50 * (k % 2 ? 2 : 1) * (k / 2 ? 8 : 16));
        assert_true(w.last == 1);
        for (int stop = 1, most = w.calls; stop <= most; stop++) {
            w = (watcher){0, stop, 0};
            assert_int_equal(ddof_render(ctx, &frame, &settings, NULL), DDOF_ERROR_CANCELLED);
            assert_int_equal(w.calls, stop);
        }
        scene_free(&s);
    }
    DESTROY(ctx);
}

int main(void) {
    static const struct CMUnitTest tests[] = {
        cmocka_unit_test(pictures),     cmocka_unit_test(layers), cmocka_unit_test(holes), cmocka_unit_test(brightness),
        cmocka_unit_test(arrangements), cmocka_unit_test(calls),
    };
    return run_gpu_tests("gl methods", tests, COUNT(tests), gl_missing());
}
