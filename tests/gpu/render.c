/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "render.h"

#include "../library/layout.h"

#include <math.h>
#include <string.h>

pair pair_make(void) {
    return (pair){gpu_context(promise.backend), reference_context()};
}

void pair_destroy(pair *p) {
    DESTROY(p->gpu);
    DESTROY(p->reference);
}

scene gpu_scene(int width, int height, int pattern, color_pattern color, rng *r) {
    scene s = scene_make(width, height, rng_bits(r) & 1);
    promise.fill_coc(s.coc, width, height, pattern, r);
    fill_color(s.color, width, height, color, r);
    return s;
}

static ddof_solver solver_number(int k) {
    return promise.solvers[k % promise.solver_count];
}

/* The largest difference in `channels` of four. */
static double worst_of(const float *got, const float *want, size_t pixels, int channels) {
    double worst = 0;
    for (size_t i = 0; i < pixels * 4; i++) {
        const double d = fabs((double)got[i] - want[i]);
        if ((int)(i % 4) < channels && !(d <= worst)) worst = d;
    }
    return worst;
}

void gpu_compare(const pair *p, const scene *s, const ddof_frame *frame, const ddof_settings *settings,
                 const float *want, double allowed) {
    const size_t n = (size_t)s->width * (size_t)s->height;
    render(p->gpu, frame, settings);
    const double range = magnitude(s->color, 4 * n),
                 error = worst_of(s->output, want, n, frame->color.channels) / range;
    if (!(error <= allowed))
        fail_msg("%d x %d, %d channels, %s, surface %d, conductance %d, %d substeps, shared %d: the error is %.3g of "
                 "the range, allowed %.3g",
                 s->width, s->height, frame->color.channels, solver_name(settings->solver), settings->surface,
                 settings->conductance, settings->substeps, settings->shared_chain, error, allowed);
}

float *gpu_wanted(const pair *p, const ddof_frame *frame, const ddof_settings *settings) {
    ddof_frame reference = *frame;
    float *want = fenced((size_t)frame->color.width * (size_t)frame->color.height * 4 * sizeof *want, true);
    for (int c = 0; c < 4; c++)
        reference.output.plane[c].data = want + c;
    render(p->reference, &reference, settings);
    return want;
}

/* Every second time with a shared chain, where there is one. */
void gpu_all_solvers(const pair *p, const scene *s, const ddof_frame *frame, ddof_settings settings, rng *r) {
    float *want = gpu_wanted(p, frame, &settings);
    for (int k = 0; k < promise.solver_count; k++)
        for (int surface = DDOF_SURFACE_RGBA16F; surface <= DDOF_SURFACE_RGBA32F; surface++) {
            settings.solver = promise.solvers[k];
            settings.surface = (ddof_surface)surface;
            if (promise.shared_chain) settings.shared_chain = (int)(rng_bits(r) & 1);
            gpu_compare(p, s, frame, &settings, want, promise.tolerance(s, &settings, frame->pixel_aspect));
        }
    fenced_free(want);
}

void gpu_sizes(void **state) {
    (void)state;
    rng r = {100};
    pair p = pair_make();
    for (int n = 1; n <= 67; n += promise.step)
        for (int shape = 0; shape < 3; shape++) {
            const int classic = (n + shape) % 2;
            scene s = gpu_scene(shape == 1 ? 5 : n, shape == 0 ? 5 : n, rng_range(&r, 0, promise.patterns - 1),
                                (color_pattern)rng_range(&r, 0, COLOR_RAMP), &r);
            ddof_frame frame = scene_frame(&s);
            frame.color.channels = frame.output.channels = shape == 2 ? 4 : 3;
            ddof_settings settings = {.conductance = (ddof_conductance)classic, .substeps = n % 8 == 0 ? 2 : 1};
            gpu_all_solvers(&p, &s, &frame, settings, &r);
            scene_free(&s);
        }
    pair_destroy(&p);
}

void gpu_patterns(void **state) {
    (void)state;
    rng r = {101};
    pair p = pair_make();
    int turn = 0;
    for (int pattern = 0; pattern < promise.patterns; pattern++)
        for (int color = 0; color < COLOR_PATTERNS; color++)
            for (int classic = 0; classic < 2; classic++) {
                if (turn++ % promise.step) continue;
                scene s = gpu_scene(211, 130, pattern, (color_pattern)color, &r);
                ddof_frame frame = scene_frame(&s);
                ddof_settings settings = {.conductance = (ddof_conductance)classic};
                frame.pixel_aspect = color == COLOR_RAMP ? 1.25 : 1;
                gpu_all_solvers(&p, &s, &frame, settings, &r);
                scene_free(&s);
            }
    pair_destroy(&p);
}

/* A ramp stays one, to a step of a half float, however far a pixel reaches. */
void gpu_ramp(void **state) {
    (void)state;
    rng r = {103};
    ddof_context *gpu = gpu_context(promise.backend);
    for (int solver = 0; solver < promise.solver_count; solver++)
        for (int k = 0; k < 8; k++) {
            const int width = k % 2 ? 700 : 9, height = k % 2 ? 9 : 700;
            scene s = gpu_scene(width, height, 0, COLOR_RANDOM, &r);
            for (int i = 0; i < width * height; i++) {
                const int at = k % 2 ? i % width : i / width;
                s.coc[i] = k / 4 ? 200.0f : (float)at / 8;
                for (int c = 0; c < 4; c++)
                    s.color[4 * i + c] = (float)(at + c) / 703;
            }
            ddof_frame frame = scene_frame(&s);
            ddof_settings settings = {.solver = promise.solvers[solver], .conductance = (ddof_conductance)(k / 2 % 2)};
            render(gpu, &frame, &settings);
            const ptrdiff_t step = k % 2 ? 4 : 4 * (ptrdiff_t)width;
            for (ptrdiff_t i = step; i < (ptrdiff_t)width * height * 4; i++) {
                if (k % 2 && i / 4 % width == 0) continue;
                const float before = s.output[i - step], now = s.output[i], ulp = now < 0.5f ? 0x1p-12f : 0x1p-11f;
                if (!(now >= before - ulp))
                    fail_msg("%s, ramp %d: value %d falls from %.9g to %.9g", solver_name(settings.solver), k, (int)i,
                             before, now);
            }
            scene_free(&s);
        }
    DESTROY(gpu);
}

/* ---- depth and lens */

/* Depth of which a part is not a distance. */
static void fill_depth(float *depth, int count, bool small, rng *r) {
    for (int k = 0; k < count; k++) {
        depth[k] = (float)(small ? 1.2 * rng_unit(r) : 0.5 + 20 * rng_unit(r));
        if (k % 41 == 0) depth[k] = (float[]){0, INFINITY, -INFINITY, NAN, -1}[k / 41 % 5];
    }
}

/* The CoC that the device makes is the reference's, and blurs as the depth it was made from. */
static void depth_and_coc(const pair *p, const ddof_settings *settings, rng *r, const char *what) {
    enum { W = 93, H = 71, N = W * H };
    float *coc = fenced(N * sizeof *coc, true), *other = fenced(N * sizeof *coc, true);
    float *result = fenced(N * 4 * sizeof *result, true);
    scene s = gpu_scene(W, H, 0, COLOR_RANDOM, r);
    fill_depth(s.coc, N, settings->depth.kind >= DDOF_DEPTH_INVERSE, r);
    ddof_frame frame = scene_frame(&s);
    frame.depth = frame.coc;
    frame.coc = (ddof_image){0};
    frame.picture_width = 200;
    frame.picture_height = 100;
    frame.offset_x = 11;
    frame.offset_y = -7;
    const ddof_stats stats = render(p->gpu, &frame, settings);
    memcpy(result, s.output, N * 4 * sizeof *result);
    float *want = gpu_wanted(p, &frame, settings);
    assert_close(result, want, N * 4, promise.tolerance(&s, settings, 1), "%s: from depth", what);
    fenced_free(want);

    ddof_frame alone = frame;
    alone.output = ddof_image_interleaved(coc, W, H, 1, DDOF_FLOAT, 0);
    const ddof_stats coc_stats = write_coc(p->gpu, &alone, settings);
    alone.output = ddof_image_interleaved(other, W, H, 1, DDOF_FLOAT, 0);
    write_coc(p->reference, &alone, settings);
    for (int k = 0; k < N; k++)
        if (!(isnan(coc[k]) && isnan(other[k])) && !(fabsf(coc[k] - other[k]) <= 1e-4f * fabsf(other[k]) + 1e-3f))
            fail_msg("%s: the CoC of %g is %.9g, not %.9g", what, s.coc[k], coc[k], other[k]);

    frame.coc = ddof_image_interleaved(coc, W, H, 1, DDOF_FLOAT, 0);
    frame.depth = (ddof_image){0};
    const ddof_stats again = render(p->gpu, &frame, settings);
    assert_close(s.output, result, N * 4, promise.coc_difference, "%s: from depth and from CoC", what);
    assert_int_equal(stats.nonfinite_pixels, again.nonfinite_pixels);
    assert_int_equal(stats.nonfinite_pixels, coc_stats.nonfinite_pixels);
    scene_free(&s);
    fenced_free(coc);
    fenced_free(other);
    fenced_free(result);
}

void gpu_depth(void **state) {
    static const ddof_depth depths[] = {
        {.kind = DDOF_DEPTH_PLANAR},
        {.kind = DDOF_DEPTH_RAY},
        {.kind = DDOF_DEPTH_INVERSE},
        {.kind = DDOF_DEPTH_NORMALIZED, .z_at_0 = 0.5, .z_at_1 = 40},
        {.kind = DDOF_DEPTH_DEVICE, .z_at_0 = INFINITY, .z_at_1 = 0.5},
    };
    static const char *const names[] = {"planar", "ray", "inverse", "normalized", "device"};
    (void)state;
    rng r = {104};
    pair p = pair_make();
    for (int i = 0; i < COUNT(depths); i++)
        for (int lens = 0; lens < 4; lens++) {
            ddof_settings settings = {.depth = depths[i], .surface = DDOF_SURFACE_RGBA32F};
            settings.lens = (ddof_lens){.kind = (ddof_lens_kind)(lens % 2),
                                        .focal_length = 85,
                                        .f_number = 1.4,
                                        .focus_distance = 4,
                                        .in_focus_range = lens / 2,
                                        .max_coc_far = 0.5,
                                        .max_coc_near = 0.7,
                                        .limit_far = lens / 2 * 0.3};
            depth_and_coc(&p, &settings, &r, names[i]);
        }
    pair_destroy(&p);
}

/* ---- bad values, types, ranges */

/* Holes of colour and of CoC: 0 scattered, 1 a cross, 2 all but one pixel, 3 all; of CoC: 4 scattered, 5 a cross. */
static void make_holes(scene *s, int kind, rng *r) {
    const int w = s->width, h = s->height, column = rng_range(r, 0, w - 1), row = rng_range(r, 0, h - 1);
    for (int i = 0; i < w * h; i++) {
        const bool line = i % w == column || i / w == row;
        const bool color[6] = {rng_bits(r) % 4 == 0, line, i != row * w + column, true, false, false};
        const bool coc[6] = {false, false, false, false, rng_bits(r) % 3 == 0, line};
        if (color[kind]) s->color[4 * i + (int)(rng_bits(r) % 4)] = (float[]){NAN, INFINITY, -INFINITY}[i % 3];
        if (coc[kind]) s->coc[i] = i % 2 ? NAN : INFINITY;
    }
}

void gpu_holes(void **state) {
    (void)state;
    rng r = {105};
    pair p = pair_make();
    for (int k = 0; k < 60; k++) {
        const int w = rng_range(&r, 1, 90), h = rng_range(&r, 1, 90);
        scene s = gpu_scene(w, h, k % promise.patterns, COLOR_RANDOM, &r);
        for (int i = 0; i < w * h && k >= 42; i++) /* links about as faint as the least there is */
            s.coc[i] = rng_bits(&r) & 1 ? 0 : (float)pow(10, -4 - 2 * rng_unit(&r));
        make_holes(&s, k % 6, &r);
        ddof_frame frame = scene_frame(&s);
        ddof_settings settings = {.conductance = (ddof_conductance)(k % 2),
                                  .substeps = k / 6 % 2 + 1,
                                  .solver = solver_number(k + k / 6),
                                  .surface = k / 7 % 2 ? DDOF_SURFACE_RGBA32F : DDOF_SURFACE_RGBA16F};
        float *want = fenced((size_t)(w * h) * 4 * sizeof *want, true);
        ddof_frame reference = frame;
        reference.output = ddof_image_interleaved(want, w, h, 4, DDOF_FLOAT, 0);
        const ddof_stats a = render(p.reference, &reference, &settings), b = render(p.gpu, &frame, &settings);
        for (int i = 0; i < w * h * 4; i++)
            assert_true(isfinite(s.output[i]));
        assert_close(s.output, want, (size_t)(w * h) * 4, fmax(promise.tolerance(&s, &settings, 1), 2e-5),
                     "%d x %d, holes %d, %s", w, h, k % 6, solver_name(settings.solver));
        assert_int_equal(a.nonfinite_pixels, b.nonfinite_pixels);
        fenced_free(want);
        scene_free(&s);
    }
    pair_destroy(&p);
}

/* Half floats hold neither 1e6 nor 1e-9: a picture is scaled. */
void gpu_brightness(void **state) {
    (void)state;
    rng r = {106};
    pair p = pair_make();
    for (double most = 1e-30; most < 1e31; most *= 1e3) {
        scene s = gpu_scene(61, 47, 1, COLOR_RANDOM, &r);
        for (int i = 0; i < 61 * 47 * 4; i++)
            s.color[i] *= (float)most;
        ddof_frame frame = scene_frame(&s);
        gpu_all_solvers(&p, &s, &frame, (ddof_settings){0}, &r);
        scene_free(&s);
    }
    pair_destroy(&p);
}

/* The first of four floats, where channel 0 is a half. */
static float stored_value(const float *pixel, int c, bool half) {
    uint16_t bits;
    memcpy(&bits, pixel, sizeof bits);
    return half && c == 0 ? (float)half_value(bits) : pixel[c];
}

/* Straight alpha divides what it was multiplied by, and the error with it. */
static void compare_stored(const float *got, const float *want, size_t pixels, const ddof_image *color, double allowed,
                           bool half) {
    for (size_t i = 0; i < pixels; i++)
        for (int c = 0; c < color->channels; c++) {
            const float a = stored_value(got + 4 * i, c, half), b = stored_value(want + 4 * i, c, half);
            const double alpha =
                color->alpha == DDOF_ALPHA_STRAIGHT ? want[4 * i + (size_t)color->channels - 1] / 2 : 1;
            if (!(fabs((double)a - b) <= allowed / alpha + (half && c == 0 ? 0x1p-10 * fabs(b) : 0)))
                fail_msg("pixel %zu, channel %d of %d: %.9g, not %.9g", i, c, color->channels, a, b);
        }
}

void gpu_images(void **state) {
    (void)state;
    rng r = {107};
    pair p = pair_make();
    for (int k = 0; k < 32; k++) {
        const int w = 40 + k, h = 33, channels = k % 4 + 1;
        scene s = gpu_scene(w, h, 1, COLOR_RANDOM, &r);
        const size_t n = (size_t)w * (size_t)h;
        float *want = fenced(n * 4 * sizeof *want, true);
        memset(s.output, 0, n * 4 * sizeof *want);
        memset(want, 0, n * 4 * sizeof *want);
        ddof_frame frame = scene_frame(&s), reference = frame;
        reference.output = ddof_image_interleaved(want, w, h, 4, DDOF_FLOAT, 0);
        for (ddof_frame *f = &frame; f; f = f == &frame ? &reference : NULL) {
            f->color.channels = f->output.channels = channels;
            if (channels % 2 == 0 && k / 4 % 2) f->color.alpha = DDOF_ALPHA_STRAIGHT;
            for (int c = 0; c < channels && k / 8 % 2; c++) {
                f->output.plane[c].row_stride = -(ptrdiff_t)w * 16;
                f->output.plane[c].data = (char *)f->output.plane[c].data + (ptrdiff_t)w * 16 * (h - 1);
            }
            if (k >= 16) f->output.plane[0].type = DDOF_HALF;
        }
        ddof_settings settings = {.solver = solver_number(k + k / 4), .surface = DDOF_SURFACE_RGBA32F};
        render(p.reference, &reference, &settings);
        render(p.gpu, &frame, &settings);
        compare_stored(s.output, want, n, &frame.color, promise.tolerance(&s, &settings, 1), k >= 16);
        if (k < 8) {
            ddof_frame in_place = frame;
            in_place.output = in_place.color;
            memcpy(want, s.output, 4 * n * sizeof *want);
            render(p.gpu, &in_place, &settings);
            for (size_t i = 0; i < 4 * n; i++)
                if ((int)(i % 4) < channels) assert_true(s.color[i] == want[i]);
        }
        fenced_free(want);
        scene_free(&s);
    }
    pair_destroy(&p);
}
