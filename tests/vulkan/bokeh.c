/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Sprites of ddof_render() on the Vulkan backend against those of the CPU backend. */
#include "support.h"

#include <math.h>
#include <string.h>

static ddof_context *gpu, *cpu;

static void set_up(void) {
    gpu = gpu_context(DDOF_BACKEND_VULKAN);
    cpu = context_of(0, 2);
}

static void tear_down(void) {
    DESTROY(gpu);
    DESTROY(cpu);
}

/* ---- scenes */

/* A dim picture with `lights` pixels of up to `brightest`; CoC in stripes of -widest to widest, with nodes of the
 * iris's tables (exp2(k/64)), so that no driver's logarithm can tell a neighbouring one. */
static scene lights_scene(int width, int height, int lights, float brightest, float widest, uint64_t seed) {
    rng r = {seed};
    scene s = scene_make(width, height, true);
    fill_color(s.color, width, height, COLOR_RANDOM, &r);
    for (int i = 0; i < width * height; i++) {
        const int stripe = 8 * (i % width) / width;
        const float part = exp2f(-(float)(stripe % 4)) * (stripe < 4 ? -1 : 1);
        s.coc[i] = stripe == 3 ? 0 : exp2f(floorf(64 * log2f(widest)) / 64) * part;
        for (int c = 0; c < 4; c++)
            s.color[4 * i + c] *= c < 3 ? 0.5f : 1;
    }
    for (int i = 0; i < lights; i++) {
        const int at = rng_range(&r, 0, width * height - 1);
        float *p = s.color + 4 * (ptrdiff_t)at;
        if (s.coc[at] == 0) continue; /* the brightest of the result would be one that stays sharp */
        for (int c = 0; c < 3; c++)
            p[c] = brightest * (float)(0.3 + 0.7 * rng_unit(&r));
        p[3] = 1;
    }
    return s;
}

typedef struct comparison {
    double error; /* the largest, of the largest value that is wanted */
    ddof_stats got, want;
} comparison;

static comparison compare(const scene *s, const ddof_frame *frame, const ddof_settings *settings) {
    const size_t n = (size_t)s->width * (size_t)s->height * 4;
    float *want = fenced(n * sizeof *want, true);
    comparison c;
    c.want = render(cpu, frame, settings);
    memcpy(want, s->output, n * sizeof *want);
    memset(s->output, 0xff, n * sizeof *want);
    c.got = render(gpu, frame, settings);
    double worst = 0;
    for (size_t i = 0; i < n; i++) {
        if ((int)(i % 4) >= frame->color.channels) continue;
        const double d = fabs((double)s->output[i] - (double)want[i]);
        if (!(d <= worst)) worst = d;
    }
    c.error = worst / magnitude(want, n);
    fenced_free(want);
    return c;
}

/* Drivers' logarithms, cosines and exponentials are good to about 1e-4. */
static const double exact = 1e-3;

static comparison check(const scene *s, const ddof_frame *frame, const ddof_settings *settings, double allowed,
                        const char *what) {
    const comparison c = compare(s, frame, settings);
    if (!(c.error <= allowed))
        fail_msg("%s, %d x %d, bokeh %d, resolution %d: the error is %.3g of the brightest, allowed %.3g", what,
                 s->width, s->height, settings->bokeh, settings->sprites.resolution, c.error, allowed);
    assert_int_equal(c.got.sprites_dropped, c.want.sprites_dropped);
    assert_int_equal(c.got.sprites_large, c.want.sprites_large);
    if (!settings->layers || settings->bokeh == DDOF_BOKEH_HIGHLIGHTS) /* a GPU's layers are as large as the picture */
        assert_int_equal(c.got.sprites, c.want.sprites);
    return c;
}

/* Highlights and all pixels, in whole and in half resolution. */
enum { KINDS = 4 };
static ddof_settings kind(int k) {
    return (ddof_settings){.surface = DDOF_SURFACE_RGBA32F,
                           .bokeh = k / 2 ? DDOF_BOKEH_FULL : DDOF_BOKEH_HIGHLIGHTS,
                           .sprites.resolution = k % 2 ? DDOF_RESOLUTION_HALF : DDOF_RESOLUTION_FULL};
}

static void shapes(void **state) {
    (void)state;
    float image[24 * 20];
    for (int i = 0; i < COUNT(image); i++)
        image[i] = (float)(1 + i % 24) * (i / 24 > 3 && i / 24 < 16 ? 1 : 0.2f);
    const struct {
        const char *name;
        ddof_iris iris;
    } shape[] = {
        {"disc", {0}},
        {"polygon", {.shape = DDOF_IRIS_POLYGON, .blades = 5, .rotation = 20}},
        {"curved polygon", {.shape = DDOF_IRIS_POLYGON, .blades = 3, .rotation = -70, .curvature = 0.4}},
        {"image", {.shape = DDOF_IRIS_IMAGE, .image = ddof_image_interleaved(image, 24, 20, 1, DDOF_FLOAT, 0)}},
        {"cat's eye", {.cats_eye = 0.7}},
        {"edge", {.edge = 0.6}},
        {"squeeze", {.squeeze = 2, .rotation = 30}},
        {"fringe", {.fringe = 0.2}},
        {"all of it",
         {.shape = DDOF_IRIS_POLYGON,
          .blades = 7,
          .rotation = 5,
          .curvature = 0.3,
          .edge = -0.4,
          .cats_eye = 0.5,
          .squeeze = 1.5,
          .fringe = -0.1}},
    };
    for (int k = 0; k < KINDS; k++)
        for (int i = 0; i < COUNT(shape); i += GPU_STEP) {
            scene s = lights_scene(120, 70, 12, 50, 24, 400 + (uint64_t)i);
            const ddof_frame frame = scene_frame(&s);
            ddof_settings settings = kind(k);
            settings.iris = shape[i].iris;
            const comparison c = check(&s, &frame, &settings, exact, shape[i].name);
            if (settings.bokeh == DDOF_BOKEH_HIGHLIGHTS) assert_true(c.want.sprites > 2);
            scene_free(&s);
        }
}

/* Sprites of 25 to 200 pixels, which are drawn at four levels, in the middle of a larger picture, with pixels that are
 * not square. */
static void levels(void **state) {
    (void)state;
    for (int k = 0; k < KINDS; k += 3) {
        scene s = lights_scene(320, 90, 40, 50, 200, 410);
        ddof_frame frame = scene_frame(&s);
        frame.picture_width = 500;
        frame.picture_height = 300;
        frame.offset_x = 70;
        frame.offset_y = 130;
        frame.pixel_aspect = 1.25;
        ddof_settings settings = kind(k);
        settings.sprites.limit = 1;
        settings.iris = (ddof_iris){.cats_eye = 0.6, .fringe = 0.1};
        check(&s, &frame, &settings, exact, "levels");
        scene_free(&s);
    }
}

static void sizes(void **state) {
    static const int size[][2] = {{1, 1}, {7, 5}, {33, 17}, {5, 64}, {1, 20}};
    (void)state;
    for (int k = 0; k < KINDS; k++)
        for (int i = 0; i < COUNT(size); i += GPU_STEP) {
            scene s = lights_scene(size[i][0], size[i][1], 6, 20, 12, 420 + (uint64_t)i);
            const ddof_frame frame = scene_frame(&s);
            ddof_settings settings = kind(k);
            settings.sprites.limit = 1;
            settings.sprites.threshold = 0.3;
            check(&s, &frame, &settings, exact, "size");
            scene_free(&s);
        }
}

/* None, one, and as many as there are pixels, of which a few fit: the threshold is raised as on the CPU. */
static void numbers(void **state) {
    (void)state;
    const int side = GPU_STEP > 1 ? 200 : 1000;
    ddof_settings settings = kind(0);
    scene s = lights_scene(64, 48, 0, 0, 12, 430);
    ddof_frame frame = scene_frame(&s);
    assert_int_equal(check(&s, &frame, &settings, exact, "no light").got.sprites, 0);
    for (int c = 0; c < 3; c++)
        s.color[4 * (20 * 64 + 10) + c] = 30;
    assert_int_equal(check(&s, &frame, &settings, exact, "one light").got.sprites, 1);
    scene_free(&s);

    rng r = {431};
    s = lights_scene(side, side, 0, 0, 12, 432);
    frame = scene_frame(&s);
    for (int i = 0; i < side * side; i++)
        for (int c = 0; c < 3; c++)
            s.color[4 * i + c] = (float)fmin(2 / sqrt(rng_unit(&r)), 1e4); /* a few are far brighter than most */
    settings.sprites.max_sprites = 1500;
    const comparison some = check(&s, &frame, &settings, exact, "too many lights");
    assert_true(some.got.sprites > 1000 && some.got.sprites <= 1500 && some.got.sprites_dropped > side * side / 2);
    settings.sprites.max_sprites = 1;
    const comparison one = check(&s, &frame, &settings, exact, "room for one");
    assert_true(one.got.sprites <= 1);
    for (int i = 0; i < side * side * 4; i++)
        s.color[i] = 3;
    assert_int_equal(check(&s, &frame, &settings, exact, "all alike").got.sprites, 0);
    settings.sprites.max_sprites = 0;
    settings.sprites.max_area = 1;
    check(&s, &frame, &settings, exact, "too much area");
    scene_free(&s);
}

/* However they are listed and made into rectangles, the pictures and counts are the same. */
static void forms(void **state) {
    (void)state;
    for (int k = 0; k < KINDS; k += 3)
        for (int form = 1; form < 4; form++) {
            scene s = lights_scene(90, 60, 12, 50, 16, 440);
            const ddof_frame frame = scene_frame(&s);
            ddof_settings settings = kind(k);
            settings.sprites.append = form % 2 ? DDOF_APPEND_ARGUMENTS : DDOF_APPEND_COUNTER;
            settings.sprites.quads = form / 2 ? DDOF_QUADS_GEOMETRY : DDOF_QUADS_INSTANCED;
            settings.sprites.max_sprites = 7;
            const ddof_status status = ddof_render(gpu, &frame, &settings, NULL);
            if (status == DDOF_ERROR_UNSUPPORTED && form / 2)
                assert_non_null(strstr(ddof_error(gpu), "geometryShader"));
            else
                check(&s, &frame, &settings, exact, "form");
            scene_free(&s);
        }
}

/* With the disc kernel, whose components all begin with what the highlights leave; in half floats. */
static void kernels(void **state) {
    (void)state;
    for (int k = 0; k < 2; k++) {
        scene s = lights_scene(90, 60, 12, 20, 16, 450);
        const ddof_frame frame = scene_frame(&s);
        ddof_settings settings = kind(k);
        check(&s, &frame, &(ddof_settings){.bokeh = settings.bokeh, .sprites = settings.sprites}, 5e-3, "half floats");
        settings.kernel = DDOF_KERNEL_DISC;
        settings.quality = k ? DDOF_QUALITY_GOOD : DDOF_QUALITY_DRAFT;
        if (k == 0 || GPU_STEP == 1) check(&s, &frame, &settings, exact, "disc");
        scene_free(&s);
    }
}

/* Fewer channels, straight alpha, in place, dark: what highlights are does not depend on how colours get to the GPU. */
static void images(void **state) {
    (void)state;
    for (int k = 0; k < KINDS; k += 3)
        for (int channels = 1; channels <= 4; channels++) {
            scene s = lights_scene(90, 60, 12, 50, 16, 460 + (uint64_t)channels);
            ddof_frame frame = scene_frame(&s);
            frame.color.channels = frame.output.channels = channels;
            if (channels % 2 == 0) frame.color.alpha = DDOF_ALPHA_STRAIGHT;
            for (int i = 0; i < 90 * 60; i++)
                s.color[4 * i + (channels == 2)] = (float)(i % 4 + 1) / 4;
            ddof_settings settings = kind(k);
            settings.iris.fringe = 0.2;
            settings.sprites.threshold = 0.6;
            check(&s, &frame, &settings, exact, "channels");
            for (int i = 0; i < 90 * 60 * 4; i++)
                s.color[i] *= 1e-6f;
            settings.sprites.threshold = 0.6e-6;
            if (channels != 2 && channels != 4) check(&s, &frame, &settings, exact, "dark");
            settings.surface = DDOF_SURFACE_RGBA16F;
            if (channels != 2 && channels != 4) check(&s, &frame, &settings, 5e-3, "dark, in half floats");
            scene_free(&s);
        }
}

/* The sum of a light is kept: 1e-4 of it, 1e-3 in half floats. */
static void energy(void **state) {
    (void)state;
    for (int k = 0; k < 2 * KINDS; k++) {
        enum { W = 96, H = 72 };
        scene s = scene_make(W, H, true);
        const ddof_frame frame = scene_frame(&s);
        memset(s.color, 0, sizeof(float) * 4 * W * H);
        for (int i = 0; i < W * H; i++)
            s.coc[i] = k % 3 ? 21 : -21;
        for (int c = 0; c < 3; c++)
            s.color[4 * (36 * W + 47) + c] = 800;
        ddof_settings settings = kind(k % KINDS);
        settings.surface = k / KINDS ? DDOF_SURFACE_RGBA16F : DDOF_SURFACE_RGBA32F;
        settings.iris = (ddof_iris){.shape = DDOF_IRIS_POLYGON, .blades = 6};
        double sum = 0;
        render(gpu, &frame, &settings);
        for (int i = 0; i < W * H; i++)
            sum += (double)s.output[4 * i];
        const double off = fabs(sum / 800 - 1);
        if (settings.bokeh == DDOF_BOKEH_FULL) { /* light is spread by what overlaps: here by one disc each */
            if (!(off <= 1e-2)) fail_msg("FULL: %g of the light is lost or made", off);
        } else if (!(off <= (k / KINDS ? 1e-3 : 1e-4))) {
            fail_msg("kind %d: %g of the light is lost or made", k, off);
        }
        scene_free(&s);
    }
}

/* A hole is no highlight and hides none; of FULL it is filled, so that a constant picture stays constant. */
static void holes(void **state) {
    (void)state;
    for (int k = 0; k < KINDS; k++) {
        rng r = {470};
        scene s = lights_scene(90, 60, 12, 50, 16, 471);
        const ddof_frame frame = scene_frame(&s);
        for (int i = 0; i < 40; i++) {
            const int at = rng_range(&r, 0, 90 * 60 - 1);
            if (i % 2)
                s.color[4 * at + i % 4] = NAN;
            else
                s.coc[at] = NAN;
        }
        const ddof_settings settings = kind(k);
        if (settings.bokeh == DDOF_BOKEH_HIGHLIGHTS) {
            const comparison c = check(&s, &frame, &settings, exact, "holes");
            assert_int_equal(c.got.nonfinite_pixels, c.want.nonfinite_pixels);
        } else {
            for (int i = 0; i < 90 * 60 * 4; i++)
                if (isfinite(s.color[i])) s.color[i] = 0.5f;
            assert_true(render(gpu, &frame, &settings).nonfinite_pixels > 20);
            for (int i = 0; i < 90 * 60 * 4; i++)
                if (!(fabsf(s.output[i] - 0.5f) <= 1e-4f))
                    fail_msg("value %d of a constant picture with holes is %g", i, (double)s.output[i]);
        }
        scene_free(&s);
    }
}

/* Layer by layer: each is a picture of its own for the GPU. */
static void layered(void **state) {
    (void)state;
    for (int k = 0; k < KINDS; k += 3) {
        scene s = lights_scene(120, 70, 12, 50, 16, 480);
        const ddof_frame frame = scene_frame(&s);
        ddof_settings settings = kind(k);
        settings.layers = DDOF_LAYERS_AUTO;
        check(&s, &frame, &settings, exact, "layers");
        scene_free(&s);
    }
}

/* Depth and a lens in the place of CoC. */
static void depth(void **state) {
    static const ddof_depth_kind kinds[] = {DDOF_DEPTH_PLANAR, DDOF_DEPTH_RAY};
    (void)state;
    for (int k = 0; k < KINDS; k += 3)
        for (int i = 0; i < COUNT(kinds); i++) {
            scene s = lights_scene(120, 70, 12, 50, 16, 490);
            ddof_frame frame = scene_frame(&s);
            for (int p = 0; p < 120 * 70; p++)
                s.coc[p] = p % 120 < 40 ? 1 : p % 120 < 80 ? 2 : 8;
            frame.depth = frame.coc;
            frame.coc = (ddof_image){0};
            ddof_settings settings = kind(k);
            settings.depth.kind = kinds[i];
            settings.lens = (ddof_lens){.focal_length = 50, .f_number = 0.35, .focus_distance = 2};
            check(&s, &frame, &settings, 3e-3, "depth"); /* CoC may lie between two nodes: a rim is then 0.5 % off */
            scene_free(&s);
        }
}

static void refused(void **state) {
    (void)state;
    scene s = lights_scene(20, 20, 2, 50, 16, 500);
    const ddof_frame frame = scene_frame(&s);
    for (int m = DDOF_METHOD_GAUSSIAN; m <= DDOF_METHOD_HEXAGON; m++) {
        assert_int_equal(ddof_render(gpu, &frame, &(ddof_settings){.method = (ddof_method)m}, NULL),
                         DDOF_ERROR_UNSUPPORTED);
        assert_non_null(strstr(ddof_error(gpu), "settings.method"));
    }
    float dark[4] = {0};
    ddof_settings settings = kind(0);
    settings.iris =
        (ddof_iris){.shape = DDOF_IRIS_IMAGE, .image = ddof_image_interleaved(dark, 2, 2, 1, DDOF_FLOAT, 0)};
    assert_int_equal(ddof_render(gpu, &frame, &settings, NULL), DDOF_ERROR_INVALID);
    render(gpu, &frame, &(ddof_settings){0});
    scene_free(&s);
}

int main(void) {
    static const struct CMUnitTest tests[] = {
        cmocka_unit_test(shapes), cmocka_unit_test(levels),  cmocka_unit_test(sizes),  cmocka_unit_test(numbers),
        cmocka_unit_test(forms),  cmocka_unit_test(kernels), cmocka_unit_test(images), cmocka_unit_test(energy),
        cmocka_unit_test(holes),  cmocka_unit_test(layered), cmocka_unit_test(depth),  cmocka_unit_test(refused),
    };
    const char *missing = gpu_missing(DDOF_BACKEND_VULKAN);
    if (!missing) set_up();
    const int failed = run_gpu_tests("vulkan bokeh", tests, COUNT(tests), missing);
    if (!missing) tear_down();
    return failed;
}
