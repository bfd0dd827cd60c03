/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* ddof_render() whose context is lost in mid-frame: never a wrong picture that is said to be right, and a new context
 * for the next frame. The linker (--wrap) puts this program between the backend and EGL's functions. */
#include "support.h"

#include <string.h>

ddof_gl_function __real_egl_get_proc(void *user, const char *name);
ddof_gl_function __wrap_egl_get_proc(void *user, const char *name);

static struct {
    int looks, lost_at; /* how often it was asked for errors; from which time on it is lost; 0: never */
    unsigned (*get_error)(void);
    void (*read_pixels)(int, int, int, int, unsigned, unsigned, void *);
} tap;

static unsigned get_error(void) {
    tap.looks++;
    if (tap.lost_at && tap.looks >= tap.lost_at) return 0x0507; /* GL_CONTEXT_LOST */
    return tap.get_error();
}

/* After the loss, whatever happens to lie there. */
static void read_pixels(int x, int y, int width, int height, unsigned format, unsigned type, void *pixels) {
    if (tap.lost_at && tap.looks >= tap.lost_at - 1)
        memset(pixels, 0x40, (size_t)width * (size_t)height * 16);
    else
        tap.read_pixels(x, y, width, height, format, type, pixels);
}

ddof_gl_function __wrap_egl_get_proc(void *user, const char *name) {
    ddof_gl_function real = __real_egl_get_proc(user, name);
    if (!strcmp(name, "glGetError")) {
        tap.get_error = (unsigned (*)(void))real;
        return (ddof_gl_function)get_error;
    }
    if (!strcmp(name, "glReadPixels")) {
        tap.read_pixels = (void (*)(int, int, int, int, unsigned, unsigned, void *))real;
        return (ddof_gl_function)read_pixels;
    }
    return real;
}

static void lose(const ddof_settings *settings) {
    enum { W = 70, H = 50, N = W * H * 4 };
    rng r = {1};
    scene s = scene_fill(W, H, COC_SMOOTH, COLOR_RANDOM, &r);
    float *right = fenced(N * sizeof *right, true);
    ddof_frame frame = scene_frame(&s);
    ddof_context *ctx = gl_context();
    render(ctx, &frame, settings);
    memcpy(right, s.output, N * sizeof *right);
    tap.looks = 0;
    render(ctx, &frame, settings);
    const int looks = tap.looks;
    assert_true(looks > 4);
    for (int at = 1; at <= looks; at++) {
        ddof_stats stats;
        tap.looks = 0;
        tap.lost_at = at;
        assert_int_equal(ddof_render(ctx, &frame, settings, &stats), DDOF_ERROR_DEVICE);
        assert_non_null(strstr(ddof_error(ctx), "lost"));
        assert_null(stats.device);
        tap.lost_at = 0;
        memset(s.output, 0, N * sizeof *s.output);
        render(ctx, &frame, settings);
        assert_same_bits(s.output, right, N, "after a context lost at %d", at);
    }
    DESTROY(ctx);
    fenced_free(right);
    scene_free(&s);
}

static void lost(void **state) {
    (void)state;
    lose(&(ddof_settings){0});
}

static void lost_with_sprites(void **state) {
    (void)state;
    lose(&(ddof_settings){.bokeh = DDOF_BOKEH_HIGHLIGHTS, .sprites = {.threshold = 0.9}});
    lose(&(ddof_settings){.bokeh = DDOF_BOKEH_FULL});
}

int main(void) {
    static const struct CMUnitTest tests[] = {cmocka_unit_test(lost), cmocka_unit_test(lost_with_sprites)};
    return run_gpu_tests("gl lost", tests, COUNT(tests), gl_missing());
}
