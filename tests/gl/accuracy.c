/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Every solver on every surface against the float64 reference. For CoC up to 200: 1e-4 of the range of the colours with
 * rgba32f where nothing is packed, else 2e-3. */
#include "support.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

typedef struct pair {
    ddof_context *gl, *reference;
} pair;

static pair pair_make(void) {
    return (pair){gl_context(), reference_context()};
}

static void pair_destroy(pair *p) {
    DESTROY(p->gl);
    DESTROY(p->reference);
}

/* What CoC of up to 200 pixels there may be. */
static void fill_coc_200(float *coc, int width, int height, int pattern, rng *r) {
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            float *d = &coc[(ptrdiff_t)y * width + x];
            switch (pattern) {
            case 0:
                *d = 200;
                break;
            case 1:
                *d = (float)(400 * rng_unit(r) - 200);
                break;
            case 2:
                *d = (float)(400.0 * (x + 1) / width - 200);
                break;
            case 3:
                *d = x < width / 2 ? 0.0f : -200.0f;
                break;
            case 4:
                *d = y == height / 2 ? 0.0f : 200.0f;
                break;
            case 5:
                *d = rng_bits(r) % 2 ? 200.0f : (float)(3 * rng_unit(r));
                break;
            default:
                *d = (float)(0.5 + 2 * rng_unit(r));
                break;
            }
        }
}
enum { PATTERNS = 7 };

static scene make(int width, int height, int pattern, color_pattern color, rng *r) {
    scene s = scene_make(width, height, rng_bits(r) & 1);
    fill_coc_200(s.coc, width, height, pattern, r);
    fill_color(s.color, width, height, color, r);
    return s;
}

/* The largest difference in `frame->output.channels` of four channels. */
static double worst_of(const float *got, const float *want, size_t pixels, int channels) {
    double worst = 0;
    for (size_t i = 0; i < pixels * 4; i++) {
        const double d = fabs((double)got[i] - want[i]);
        if ((int)(i % 4) < channels && !(d <= worst)) worst = d;
    }
    return worst;
}

static void compare(const pair *p, const scene *s, const ddof_frame *frame, const ddof_settings *settings,
                    const float *want) {
    const size_t n = (size_t)s->width * (size_t)s->height;
    render(p->gl, frame, settings);
    const double error = worst_of(s->output, want, n, frame->color.channels);
    const double allowed = solver_tolerance(settings) * magnitude(s->color, 4 * n);
    if (!(error <= allowed))
        fail_msg("%d x %d, %d channels, %s, surface %d, conductance %d, %d substeps, shared %d: the error is %.3g, "
                 "allowed %.3g",
                 s->width, s->height, frame->color.channels, solver_name(settings->solver), settings->surface,
                 settings->conductance, settings->substeps, settings->shared_chain, error, allowed);
}

/* All solvers on both surfaces; every second time with a shared chain. */
static void all_solvers(const pair *p, const scene *s, ddof_frame *frame, ddof_settings settings, rng *r) {
    const size_t n = (size_t)s->width * (size_t)s->height;
    float *want = fenced(n * 4 * sizeof *want, true);
    const ddof_frame same = *frame;
    for (int c = 0; c < 4; c++)
        frame->output.plane[c].data = want + c;
    render(p->reference, frame, &settings);
    *frame = same;
    for (int solver = DDOF_SOLVER_CR_VANILLA; solver <= DDOF_SOLVER_CR_PCR; solver++)
        for (int surface = DDOF_SURFACE_RGBA16F; surface <= DDOF_SURFACE_RGBA32F; surface++) {
            settings.solver = (ddof_solver)solver;
            settings.surface = (ddof_surface)surface;
            settings.shared_chain = (int)(rng_bits(r) & 1);
            compare(p, s, frame, &settings, want);
        }
    fenced_free(want);
}

/* 1..67 along rows, along columns, and both. */
static void sizes(void **state) {
    (void)state;
    rng r = {100};
    pair p = pair_make();
    for (int n = 1; n <= 67; n++)
        for (int shape = 0; shape < 3; shape++) {
            const int classic = (n + shape) % 2;
            scene s = make(shape == 1 ? 5 : n, shape == 0 ? 5 : n, rng_range(&r, 0, PATTERNS - 1),
                           (color_pattern)rng_range(&r, 0, COLOR_RAMP), &r);
            ddof_frame frame = scene_frame(&s);
            frame.color.channels = frame.output.channels = shape == 2 ? 4 : 3;
            ddof_settings settings = {.conductance = (ddof_conductance)classic, .substeps = n % 8 == 0 ? 2 : 1};
            all_solvers(&p, &s, &frame, settings, &r);
            scene_free(&s);
        }
    pair_destroy(&p);
}

static void patterns(void **state) {
    (void)state;
    rng r = {101};
    pair p = pair_make();
    for (int pattern = 0; pattern < PATTERNS; pattern++)
        for (int color = 0; color < COLOR_PATTERNS; color++)
            for (int classic = 0; classic < 2; classic++) {
                scene s = make(211, 130, pattern, (color_pattern)color, &r);
                ddof_frame frame = scene_frame(&s);
                ddof_settings settings = {.conductance = (ddof_conductance)classic};
                frame.pixel_aspect = color == COLOR_RAMP ? 1.25 : 1;
                all_solvers(&p, &s, &frame, settings, &r);
                scene_free(&s);
            }
    pair_destroy(&p);
}

static void large(void **state) {
    static const int size[][2] = {{1279, 1023}, {1919, 1201}};
    static const ddof_settings settings[] = {
        {.solver = DDOF_SOLVER_CR4_PACK, .surface = DDOF_SURFACE_RGBA16F, .conductance = DDOF_CONDUCTANCE_CLASSIC},
        {.solver = DDOF_SOLVER_CR4,
         .surface = DDOF_SURFACE_RGBA32F,
         .conductance = DDOF_CONDUCTANCE_CLASSIC,
         .shared_chain = 1},
        {.solver = DDOF_SOLVER_CR, .surface = DDOF_SURFACE_RGBA16F, .conductance = DDOF_CONDUCTANCE_CLASSIC},
        {.solver = DDOF_SOLVER_CR_PCR, .surface = DDOF_SURFACE_RGBA16F, .conductance = DDOF_CONDUCTANCE_CLASSIC},
        {.solver = DDOF_SOLVER_CR_VANILLA, .surface = DDOF_SURFACE_RGBA32F, .conductance = DDOF_CONDUCTANCE_CLASSIC},
        {.solver = DDOF_SOLVER_CR_PACK,
         .surface = DDOF_SURFACE_RGBA16F,
         .conductance = DDOF_CONDUCTANCE_CLASSIC,
         .shared_chain = 1},
    };
    (void)state;
    rng r = {102};
    pair p = pair_make();
    for (int i = 0; i < COUNT(size); i++) {
        scene s = make(size[i][0], size[i][1], i == 0 ? 2 : 1, COLOR_RANDOM, &r);
        const size_t n = (size_t)s.width * (size_t)s.height;
        ddof_frame frame = scene_frame(&s);
        frame.color.channels = frame.output.channels = 3 + i;
        float *want = fenced(n * 4 * sizeof *want, true);
        ddof_frame reference = frame;
        for (int c = 0; c < 4; c++)
            reference.output.plane[c].data = want + c;
        render(p.reference, &reference, &settings[0]);
        for (int k = 0; k < COUNT(settings); k++)
            compare(&p, &s, &frame, &settings[k], want);
        fenced_free(want);
        scene_free(&s);
    }
    pair_destroy(&p);
}

/* No band: a ramp stays one, to a step of a half float, however far a pixel reaches. */
static void ramp(void **state) {
    (void)state;
    rng r = {103};
    ddof_context *gl = gl_context();
    for (int solver = DDOF_SOLVER_CR_VANILLA; solver <= DDOF_SOLVER_CR_PCR; solver++)
        for (int k = 0; k < 8; k++) {
            const int width = k % 2 ? 700 : 9, height = k % 2 ? 9 : 700;
            scene s = make(width, height, 0, COLOR_RANDOM, &r);
            for (int i = 0; i < width * height; i++) {
                const int at = k % 2 ? i % width : i / width;
                s.coc[i] = k / 4 ? 200.0f : (float)at / 8;
                for (int c = 0; c < 4; c++)
                    s.color[4 * i + c] = (float)(at + c) / 703;
            }
            ddof_frame frame = scene_frame(&s);
            ddof_settings settings = {.solver = (ddof_solver)solver, .conductance = (ddof_conductance)(k / 2 % 2)};
            render(gl, &frame, &settings);
            const ptrdiff_t step = k % 2 ? 4 : 4 * (ptrdiff_t)width;
            for (ptrdiff_t i = step; i < (ptrdiff_t)width * height * 4; i++) {
                if (k % 2 && i / 4 % width == 0) continue;
                const float before = s.output[i - step], now = s.output[i], ulp = now < 0.5f ? 0x1p-12f : 0x1p-11f;
                if (now < before - ulp)
                    fail_msg("%s, ramp %d: value %d falls from %.9g to %.9g", solver_name(settings.solver), k, (int)i,
                             before, now);
            }
            scene_free(&s);
        }
    DESTROY(gl);
}

/* ---- depth and lens */

static void depth_is_coc(void **state) {
    static const ddof_depth depths[] = {
        {.kind = DDOF_DEPTH_PLANAR},
        {.kind = DDOF_DEPTH_RAY},
        {.kind = DDOF_DEPTH_INVERSE},
        {.kind = DDOF_DEPTH_NORMALIZED, .z_at_0 = 0.5, .z_at_1 = 40},
        {.kind = DDOF_DEPTH_DEVICE, .z_at_0 = INFINITY, .z_at_1 = 0.5},
    };
    (void)state;
    rng r = {104};
    pair p = pair_make();
    const int w = 93, h = 71;
    float *coc = fenced((size_t)(w * h) * sizeof *coc, true), *other = fenced((size_t)(w * h) * sizeof *coc, true);
    float *result = fenced((size_t)(w * h) * 4 * sizeof *result, true);
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
            scene s = make(w, h, 0, COLOR_RANDOM, &r);
            for (int k = 0; k < w * h; k++) {
                s.coc[k] = (float)(i == 2 || i > 2 ? 1.2 * rng_unit(&r) : 0.5 + 20 * rng_unit(&r));
                if (k % 41 == 0) s.coc[k] = (float[]){0, INFINITY, -INFINITY, NAN, -1}[k / 41 % 5];
            }
            ddof_frame frame = scene_frame(&s);
            frame.depth = frame.coc;
            frame.coc = (ddof_image){0};
            frame.picture_width = 200;
            frame.picture_height = 100;
            frame.offset_x = 11;
            frame.offset_y = -7;
            ddof_stats stats = render(p.gl, &frame, &settings);
            memcpy(result, s.output, (size_t)(w * h) * 4 * sizeof *result);

            ddof_frame alone = frame;
            alone.output = ddof_image_interleaved(coc, w, h, 1, DDOF_FLOAT, 0);
            ddof_stats coc_stats = write_coc(p.gl, &alone, &settings);
            alone.output = ddof_image_interleaved(other, w, h, 1, DDOF_FLOAT, 0);
            write_coc(p.reference, &alone, &settings);
            for (int k = 0; k < w * h; k++)
                if (!(isnan(coc[k]) && isnan(other[k])) &&
                    !(fabsf(coc[k] - other[k]) <= 1e-4f * fabsf(other[k]) + 1e-3f))
                    fail_msg("depth kind %d, lens %d: the CoC of %g is %.9g, not %.9g", i, lens, s.coc[k], coc[k],
                             other[k]);

            frame.coc = ddof_image_interleaved(coc, w, h, 1, DDOF_FLOAT, 0);
            frame.depth = (ddof_image){0};
            ddof_stats again = render(p.gl, &frame, &settings);
            assert_close(s.output, result, (size_t)(w * h) * 4, 1e-6, "depth kind %d, lens %d: from depth and from CoC",
                         i, lens);
            assert_int_equal(stats.nonfinite_pixels, again.nonfinite_pixels);
            assert_int_equal(stats.nonfinite_pixels, coc_stats.nonfinite_pixels);
            scene_free(&s);
        }
    fenced_free(coc);
    fenced_free(other);
    fenced_free(result);
    pair_destroy(&p);
}

/* ---- bad values, types, ranges */

/* Holes of colour and of CoC: single ones, whole rows and columns, all. */
static void holes(void **state) {
    (void)state;
    rng r = {105};
    pair p = pair_make();
    for (int k = 0; k < 42; k++) {
        const int w = rng_range(&r, 1, 90), h = rng_range(&r, 1, 90), column = rng_range(&r, 0, w - 1),
                  row = rng_range(&r, 0, h - 1);
        scene s = make(w, h, k % PATTERNS, COLOR_RANDOM, &r);
        for (int i = 0; i < w * h; i++) {
            const bool line = i % w == column || i / w == row;
            if (k % 6 == 0   ? rng_bits(&r) % 4 == 0
                : k % 6 == 1 ? line
                : k % 6 == 2 ? i != row * w + column
                             : k % 6 == 3)
                s.color[4 * i + (int)(rng_bits(&r) % 4)] = (float[]){NAN, INFINITY, -INFINITY}[i % 3];
            if (k % 6 == 4 ? rng_bits(&r) % 3 == 0 : k % 6 == 5 && line) s.coc[i] = i % 2 ? NAN : INFINITY;
        }
        ddof_frame frame = scene_frame(&s);
        ddof_settings settings = {
            .conductance = (ddof_conductance)(k % 2), .substeps = k / 6 % 2 + 1, .solver = (ddof_solver)(k % 7)};
        settings.surface = k / 7 % 2 ? DDOF_SURFACE_RGBA32F : DDOF_SURFACE_RGBA16F;
        float *want = fenced((size_t)(w * h) * 4 * sizeof *want, true);
        ddof_frame reference = frame;
        reference.output = ddof_image_interleaved(want, w, h, 4, DDOF_FLOAT, 0);
        const ddof_stats a = render(p.reference, &reference, &settings), b = render(p.gl, &frame, &settings);
        assert_close(s.output, want, (size_t)(w * h) * 4, solver_tolerance(&settings), "%d x %d, holes %d, %s", w, h,
                     k % 6, solver_name(settings.solver));
        assert_int_equal(a.nonfinite_pixels, b.nonfinite_pixels);
        fenced_free(want);
        scene_free(&s);
    }
    pair_destroy(&p);
}

/* Half floats hold neither 1e6 nor 1e-9: a picture is scaled. */
static void brightness(void **state) {
    (void)state;
    rng r = {106};
    pair p = pair_make();
    for (double most = 1e-30; most < 1e31; most *= 1e3) {
        scene s = make(61, 47, 1, COLOR_RANDOM, &r);
        for (int i = 0; i < 61 * 47 * 4; i++)
            s.color[i] *= (float)most;
        ddof_frame frame = scene_frame(&s);
        all_solvers(&p, &s, &frame, (ddof_settings){0}, &r);
        scene_free(&s);
    }
    pair_destroy(&p);
}

/* One to four channels, straight alpha, half floats, planes, upside down, in place. */
static void images(void **state) {
    (void)state;
    rng r = {107};
    pair p = pair_make();
    for (int k = 0; k < 32; k++) {
        const int w = 40 + k, h = 33, channels = k % 4 + 1;
        scene s = make(w, h, 1, COLOR_RANDOM, &r);
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
        ddof_settings settings = {.solver = (ddof_solver)(k % 7), .surface = DDOF_SURFACE_RGBA32F};
        render(p.reference, &reference, &settings);
        render(p.gl, &frame, &settings);
        if (k < 16) /* straight alpha divides: by as little as 0.1 here */
            assert_close(s.output, want, 4 * n, 2e-2, "images %d", k);
        float *kept = fenced(4 * n * sizeof *kept, true);
        memcpy(kept, s.output, 4 * n * sizeof *kept);
        if (k < 8) {
            ddof_frame in_place = frame;
            in_place.output = in_place.color;
            render(p.gl, &in_place, &settings);
            for (size_t i = 0; i < 4 * n; i++)
                if ((int)(i % 4) < channels) assert_true(s.color[i] == kept[i]);
        }
        fenced_free(kept);
        fenced_free(want);
        scene_free(&s);
    }
    pair_destroy(&p);
}

int main(void) {
    static const struct CMUnitTest tests[] = {
        cmocka_unit_test(sizes),      cmocka_unit_test(patterns),     cmocka_unit_test(large),
        cmocka_unit_test(ramp),       cmocka_unit_test(depth_is_coc), cmocka_unit_test(holes),
        cmocka_unit_test(brightness), cmocka_unit_test(images),
    };
    return run_gl_tests("gl accuracy", tests, COUNT(tests), gl_missing());
}
