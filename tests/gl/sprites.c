/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Sprites of ddof_render() on GL against those of the CPU: the same pixels, the same shapes, the same light. What is
 * allowed is stated as a part of 1 + |value|: the pictures are 0 to 1 but for the highlights. */
#include <math.h>
#include <string.h>

#include "support.h"

/* With rgba32f and a solver that does not pack: float rounding, here and there. Half floats: two of their steps, and
 * what the solver promises. */
static double allowed_of(const ddof_settings *settings) {
    return settings->surface == DDOF_SURFACE_RGBA32F ? 2e-5 : 3e-3;
}

static const ddof_settings exact = {.surface = DDOF_SURFACE_RGBA32F, .solver = DDOF_SOLVER_CR4};

typedef struct contexts {
    ddof_context *gl, *cpu;
} contexts;

static contexts contexts_make(void) {
    return (contexts){gl_context(), context_of(0, 1)};
}

static void contexts_free(contexts *c) {
    DESTROY(c->gl);
    DESTROY(c->cpu);
}

/* Renders on both; `value` divides what is compared. */
static ddof_stats compare_by(const contexts *c, const ddof_frame *frame, const ddof_settings *settings, double value,
                             double allowed, const char *what) {
    const int width = frame->color.width, height = frame->color.height, channels = frame->color.channels;
    const size_t n = (size_t)width * (size_t)height;
    float *want = fenced(n * 16, true);
    ddof_frame other = *frame;
    other.output = ddof_image_interleaved(want, width, height, channels, DDOF_FLOAT, 0);
    const ddof_stats a = render(c->cpu, &other, settings), b = render(c->gl, frame, settings);
    const float *got = frame->output.plane[0].data;
    for (size_t i = 0; i < n * (size_t)channels; i++) {
        const double x = got[i] / value, y = want[i] / value;
        if (!(fabs(x - y) <= allowed * (1 + fabs(y))))
            fail_msg("%s, bokeh %d, resolution %d, surface %d: pixel %d, %d, channel %d of %d x %d: %.9g, not %.9g",
                     what, settings->bokeh, settings->sprites.resolution, settings->surface,
                     (int)(i / (size_t)channels) % width, (int)(i / (size_t)channels) / width,
                     (int)(i % (size_t)channels), width, height, x, y);
    }
    assert_int_equal(b.sprites, a.sprites);
    assert_int_equal(b.sprites_dropped, a.sprites_dropped);
    assert_int_equal(b.sprites_large, a.sprites_large);
    assert_int_equal(b.nonfinite_pixels, a.nonfinite_pixels);
    fenced_free(want);
    return b;
}

static ddof_stats compare(const contexts *c, const ddof_frame *frame, const ddof_settings *settings, const char *what) {
    return compare_by(c, frame, settings, 1, allowed_of(settings), what);
}

/* ---- scenes */

enum { CLEAR = 5 /* |CoC| of what shines, at least: all of it is taken */ };

/* 0 far, 1 near, 2 from near to far, 3 near over far with an edge, 4 up to 150 pixels either way. */
enum { MAPS = 5 };

static float coc_of(int map, int x, int y, int width, int height) {
    switch (map) {
    case 0:
        return 17.3f;
    case 1:
        return -11.6f;
    case 2:
        return -18.0f + 50.0f * (float)x / (float)width + 3.0f * (float)y / (float)height;
    case 3:
        return x > width / 2 ? 21.5f : -9.1f;
    default:
        return (float)(300 * (x + 0.5) / width - 150);
    }
}

static void add_light(scene *s, int x, int y, float v) {
    for (int c = 0; c < 3; c++)
        s->color[4 * ((ptrdiff_t)y * s->width + x) + c] = v * (1 - 0.2f * (float)c);
}

/* A dim picture with lights: points, and blocks of 3 x 3 whose middle is the brightest. */
static scene lights(int width, int height, int map, int count, rng *r) {
    scene s = scene_make(width, height, rng_bits(r) & 1);
    fill_color(s.color, width, height, COLOR_RANDOM, r);
    for (int i = 0; i < width * height * 4; i++)
        s.color[i] *= 0.9f;
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++)
            s.coc[(ptrdiff_t)y * width + x] = coc_of(map, x, y, width, height);
    for (int i = 0; i < count; i++) {
        const int x = rng_range(r, 0, width - 1), y = rng_range(r, 0, height - 1), wide = i % 3 == 0;
        const float v = (float)(5 + 200 * rng_unit(r));
        for (int dy = -wide; dy <= wide; dy++)
            for (int dx = -wide; dx <= wide; dx++) {
                const int u = x + dx, w = y + dy;
                if (u < 0 || w < 0 || u >= width || w >= height || fabsf(s.coc[(ptrdiff_t)w * width + u]) < CLEAR)
                    continue;
                add_light(&s, u, w, dx || dy ? v * 0.7f : v);
            }
    }
    return s;
}

/* ---- the iris */

typedef struct named_iris {
    const char *name;
    ddof_iris iris;
} named_iris;

enum { IRISES = 9 };

/* `image`: 24 x 17. */
static void irises(named_iris out[IRISES], float *image) {
    for (int i = 0; i < 24 * 17; i++)
        image[i] = (float)(i % 24 + i / 24 * 2) * (i / 24 > 7 ? 1.0f : 0.2f);
    const ddof_image described = ddof_image_interleaved(image, 24, 17, 1, DDOF_FLOAT, 0);
    const named_iris all[IRISES] = {
        {"disc", {.shape = DDOF_IRIS_DISC}},
        {"polygon", {.shape = DDOF_IRIS_POLYGON, .blades = 5, .rotation = 20, .curvature = 0.3}},
        {"image", {.shape = DDOF_IRIS_IMAGE, .image = described}},
        {"turned image", {.shape = DDOF_IRIS_IMAGE, .image = described, .rotation = 30}},
        {"cat's eye", {.cats_eye = 0.8}},
        {"edge", {.edge = 0.7}},
        {"squeeze", {.squeeze = 1.7}},
        {"fringe", {.fringe = 0.3}},
        {"all",
         {.shape = DDOF_IRIS_POLYGON,
          .blades = 6,
          .rotation = 11,
          .curvature = 0.2,
          .edge = -0.4,
          .cats_eye = 0.5,
          .squeeze = 1.3,
          .fringe = -0.2}},
    };
    memcpy(out, all, sizeof all);
}

static void shapes(void **state) {
    (void)state;
    rng r = {301};
    float image[24 * 17];
    named_iris all[IRISES];
    irises(all, image);
    contexts c = contexts_make();
    for (int i = 0; i < IRISES; i++)
        for (int k = 0; k < 4; k++) {
            scene s = lights(96, 70, k < 2 ? 2 : 3, 25, &r);
            ddof_frame frame = scene_frame(&s);
            ddof_settings settings = exact;
            settings.bokeh = k % 2 ? DDOF_BOKEH_FULL : DDOF_BOKEH_HIGHLIGHTS;
            settings.sprites.resolution = (i + k / 2) % 2 ? DDOF_RESOLUTION_HALF : DDOF_RESOLUTION_FULL;
            settings.iris = all[i].iris;
            if (i == IRISES - 1) frame.pixel_aspect = 1.3;
            const ddof_stats stats = compare(&c, &frame, &settings, all[i].name);
            assert_true(stats.sprites > 0);
            scene_free(&s);
        }
    contexts_free(&c);
}

/* Every kind of CoC, on both surfaces. */
static void maps(void **state) {
    (void)state;
    rng r = {302};
    contexts c = contexts_make();
    for (int map = 0; map < MAPS; map++)
        for (int k = 0; k < 8; k++) {
            scene s = lights(80, 61, map, 20, &r);
            ddof_frame frame = scene_frame(&s);
            ddof_settings settings = {.bokeh = k % 2 ? DDOF_BOKEH_FULL : DDOF_BOKEH_HIGHLIGHTS,
                                      .surface = k / 2 % 2 ? DDOF_SURFACE_RGBA32F : DDOF_SURFACE_RGBA16F,
                                      .solver = DDOF_SOLVER_CR4};
            settings.sprites.resolution = k / 4 ? DDOF_RESOLUTION_HALF : DDOF_RESOLUTION_FULL;
            settings.sprites.limit = map == 4 ? 1 : 0.25;
            compare(&c, &frame, &settings, "maps");
            scene_free(&s);
        }
    contexts_free(&c);
}

/* Also CoC between 2 and 4, of which a part is taken, and pictures smaller than a sprite. */
static void sizes(void **state) {
    static const int size[][2] = {{1, 1}, {7, 5}, {33, 17}, {1, 40}, {65, 1}, {2, 2}, {16, 16}, {17, 257}};
    (void)state;
    rng r = {303};
    contexts c = contexts_make();
    for (int i = 0; i < COUNT(size); i++)
        for (int k = 0; k < 4; k++) {
            const int w = size[i][0], h = size[i][1];
            scene s = lights(w, h, 0, 0, &r);
            for (int p = 0; p < w * h; p++) {
                s.coc[p] = (float)(12 * rng_unit(&r) - 6);
                if (rng_bits(&r) % 4 == 0) add_light(&s, p % w, p / w, 3);
            }
            ddof_frame frame = scene_frame(&s);
            ddof_settings settings = exact;
            settings.bokeh = k % 2 ? DDOF_BOKEH_FULL : DDOF_BOKEH_HIGHLIGHTS;
            settings.sprites.resolution = k / 2 ? DDOF_RESOLUTION_HALF : DDOF_RESOLUTION_FULL;
            settings.sprites.limit = 1;
            compare(&c, &frame, &settings, "sizes");
            scene_free(&s);
        }
    contexts_free(&c);
}

/* ---- how many */

static void none_and_one(void **state) {
    (void)state;
    rng r = {304};
    contexts c = contexts_make();
    scene s = lights(70, 50, 0, 0, &r);
    ddof_frame frame = scene_frame(&s);
    ddof_settings settings = exact, off = exact;
    const size_t n = 70 * 50 * 4;
    float *plain = fenced(n * sizeof *plain, true);
    settings.bokeh = DDOF_BOKEH_HIGHLIGHTS;
    assert_int_equal(compare(&c, &frame, &settings, "none").sprites, 0);
    memcpy(plain, s.output, n * sizeof *plain);
    render(c.gl, &frame, &off);
    assert_same_bits(s.output, plain, n, "without highlights"); /* it is the diffusion alone */
    add_light(&s, 31, 22, 40);
    assert_int_equal(compare(&c, &frame, &settings, "one").sprites, 1);
    settings.sprites.threshold = 50;
    assert_int_equal(compare(&c, &frame, &settings, "none above the threshold").sprites, 0);
    fenced_free(plain);
    scene_free(&s);
    contexts_free(&c);
}

/* Far more than there may be: by number, by area, and both; the threshold rises as on the CPU. */
static void many(void **state) {
    static const ddof_sprites limits[] = {
        {.max_sprites = 1000}, {.max_area = 1}, {.max_sprites = 2000, .max_area = 2}, {.max_sprites = 1}};
    (void)state;
    rng r = {305};
    contexts c = contexts_make();
    enum { W = 500, H = 400 };
    scene s = lights(W, H, 2, 0, &r);
    for (int i = 0; i < W * H; i++) {
        s.coc[i] *= 0.4f;
        add_light(&s, i % W, i / W, (float)(1.5 * pow(2, 9 * rng_unit(&r))));
    }
    ddof_frame frame = scene_frame(&s);
    for (int i = 0; i < COUNT(limits); i++) {
        ddof_settings settings = exact;
        settings.bokeh = DDOF_BOKEH_HIGHLIGHTS;
        settings.sprites = limits[i];
        const int most = limits[i].max_sprites ? limits[i].max_sprites : 65536;
        const ddof_stats stats = compare_by(&c, &frame, &settings, 100, 2e-5, "many");
        assert_true(stats.sprites_dropped > 0 && stats.sprites <= most);
        assert_true(i == 3 || stats.sprites > 100);
    }
    scene_free(&s);
    contexts_free(&c);
}

/* All of one brightness: none is brighter than others, so none fits. */
static void equals(void **state) {
    (void)state;
    rng r = {306};
    contexts c = contexts_make();
    scene s = lights(90, 60, 0, 0, &r);
    for (int i = 0; i < 90 * 60; i++)
        add_light(&s, i % 90, i / 90, 8);
    ddof_frame frame = scene_frame(&s);
    ddof_settings settings = exact;
    settings.bokeh = DDOF_BOKEH_HIGHLIGHTS;
    settings.sprites.max_sprites = 1000;
    const ddof_stats stats = compare(&c, &frame, &settings, "equals");
    assert_int_equal(stats.sprites, 0);
    assert_int_equal(stats.sprites_dropped, 90 * 60);
    scene_free(&s);
    contexts_free(&c);
}

/* A CoC beyond the limit is left to diffusion, and counted; with FULL it is limited. */
static void large(void **state) {
    (void)state;
    rng r = {307};
    contexts c = contexts_make();
    for (int k = 0; k < 4; k++) {
        scene s = lights(120, 80, 4, 60, &r);
        ddof_frame frame = scene_frame(&s);
        ddof_settings settings = exact;
        settings.bokeh = k % 2 ? DDOF_BOKEH_FULL : DDOF_BOKEH_HIGHLIGHTS;
        settings.sprites.resolution = k / 2 ? DDOF_RESOLUTION_HALF : DDOF_RESOLUTION_FULL;
        const ddof_stats stats = compare(&c, &frame, &settings, "large");
        if (k % 2 == 0) assert_true(stats.sprites_large > 0 && stats.sprites > 0);
        scene_free(&s);
    }
    contexts_free(&c);
}

/* ---- what comes in */

/* Half floats hold neither 1e7 nor 1e-7: the picture is scaled, and the threshold with it. */
static void brightness(void **state) {
    (void)state;
    contexts c = contexts_make();
    for (double most = 1e-12; most < 1e13; most *= 1e4) {
        rng r = {308};
        scene s = lights(64, 48, 2, 20, &r);
        for (int i = 0; i < 64 * 48 * 4; i++)
            s.color[i] *= (float)most;
        ddof_frame frame = scene_frame(&s);
        ddof_settings settings = {.bokeh = DDOF_BOKEH_HIGHLIGHTS, .sprites = {.threshold = most}};
        const ddof_stats stats = compare_by(&c, &frame, &settings, most, 3e-3, "brightness");
        assert_true(stats.sprites > 10);
        scene_free(&s);
    }
    contexts_free(&c);
}

/* One to four channels, straight alpha, from depth, in a part of a picture. */
static void images(void **state) {
    (void)state;
    rng r = {309};
    contexts c = contexts_make();
    for (int k = 0; k < 16; k++) {
        const int w = 60, h = 44, channels = k % 4 + 1;
        scene s = lights(w, h, 2, 20, &r);
        ddof_frame frame = scene_frame(&s);
        ddof_settings settings = exact;
        frame.color.channels = channels;
        frame.output = ddof_image_interleaved(s.output, w, h, channels, DDOF_FLOAT, 0);
        if (k / 4 % 2 && channels % 2 == 0) {
            frame.color.alpha = DDOF_ALPHA_STRAIGHT;
            for (int i = 0; i < w * h; i++)
                s.color[4 * i + channels - 1] = 0.5f + 0.5f * (float)rng_unit(&r);
        }
        settings.bokeh = k / 8 ? DDOF_BOKEH_FULL : DDOF_BOKEH_HIGHLIGHTS;
        settings.iris = (ddof_iris){.cats_eye = 0.6, .fringe = 0.2};
        if (k % 2) {
            frame.picture_width = 150;
            frame.picture_height = 90;
            frame.offset_x = 70;
            frame.offset_y = -10;
        }
        if (k / 4 % 2 == 0) { /* 1 to 9 m, focused at 2.5 */
            for (int i = 0; i < w * h; i++)
                s.coc[i] = 1.0f + 8.0f * (float)(i % w) / w;
            frame.depth = frame.coc;
            frame.coc = (ddof_image){0};
            settings.lens = (ddof_lens){.focal_length = 85, .f_number = 1.4, .focus_distance = 2.5};
            settings.sprites.limit = 1;
        }
        compare(&c, &frame, &settings, "images");
        scene_free(&s);
    }
    contexts_free(&c);
}

static void holes(void **state) {
    (void)state;
    rng r = {310};
    contexts c = contexts_make();
    for (int k = 0; k < 8; k++) {
        const int w = 61, h = 45;
        scene s = lights(w, h, 3, 20, &r);
        for (int i = 0; i < w * h; i++) {
            const bool block = i % w / 9 == 3 && i / w / 7 == 2, some = rng_bits(&r) % 20 == 0;
            if (k / 2 % 2 ? block : some) s.color[4 * i + i % 4] = i % 2 ? NAN : INFINITY;
            if (k / 2 % 2 ? block && i % 3 : rng_bits(&r) % 20 == 0) s.coc[i] = NAN;
        }
        ddof_frame frame = scene_frame(&s);
        ddof_settings settings = exact;
        settings.bokeh = k % 2 ? DDOF_BOKEH_FULL : DDOF_BOKEH_HIGHLIGHTS;
        settings.sprites.resolution = k / 4 ? DDOF_RESOLUTION_HALF : DDOF_RESOLUTION_FULL;
        compare(&c, &frame, &settings, "holes");
        scene_free(&s);
    }
    contexts_free(&c);
}

int main(void) {
    static const struct CMUnitTest tests[] = {
        cmocka_unit_test(shapes), cmocka_unit_test(maps),   cmocka_unit_test(sizes), cmocka_unit_test(none_and_one),
        cmocka_unit_test(many),   cmocka_unit_test(equals), cmocka_unit_test(large), cmocka_unit_test(brightness),
        cmocka_unit_test(images), cmocka_unit_test(holes),
    };
    return run_gpu_tests("gl sprites", tests, COUNT(tests), gl_missing());
}
