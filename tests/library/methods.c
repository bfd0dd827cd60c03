/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The Gaussian and the hexagon: against their definition written down in float64, pixel by pixel; what of the result must hold, what its bits do
 * not depend on, and what is refused. */
#include "layout.h"
#include "parallel.h"
#include "support.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

static const ddof_method methods[] = {DDOF_METHOD_GAUSSIAN, DDOF_METHOD_HEXAGON};

static const char *name_of(ddof_method method) {
    return method == DDOF_METHOD_GAUSSIAN ? "gaussian" : "hexagon";
}

static size_t pixels_of(const scene *s) {
    return (size_t)s->width * (size_t)s->height;
}

/* ---- the definition, of docs/methods.md */

typedef struct line {
    bool gaussian;
    double size;
    int dx;
    double dy;
} line;

typedef struct picture {
    int width, height;
    const float *coc;
    double nearest;
} picture;

static double step_of(const picture *p, const line *l, double coc, int *taps) {
    const double longest = l->dx ? p->width : p->height, reach = fmin(l->size * coc * (l->gaussian ? 2.5 : 1), longest);
    double step = 1;
    while (reach > 63 * step) step *= 2;
    *taps = (int)(reach / step + (l->gaussian ? 1 : 0.5));
    return step;
}

static double weight_of(const line *l, double t, double step, double d) {
    if (l->gaussian) {
        const double sigma = l->size * d, cover = fmin(fmax((2.5 * sigma - t) / step + 1, 0), 1);
        if (!(sigma > 0)) return t > 0 ? 0 : step;
        return step * cover * exp(-t * t / (2 * sigma * sigma)) * fmin(1, 1 / (sqrt(2 * acos(-1)) * sigma));
    }
    const double reach = l->size * d, cover = t > 0 ? fmin(fmax((reach - t) / step + 0.5, 0), 1) : 0.5;
    return step * cover / fmax(0.5, reach);
}

typedef struct sums {
    double color[4], weight;
} sums;

static void take(sums *s, const picture *p, const double *rgba, int x, int y, double weight) {
    if (x < 0 || y < 0 || x >= p->width || y >= p->height || !(weight > 0)) return;
    for (int c = 0; c < 4; c++) s->color[c] += weight * rgba[4 * ((ptrdiff_t)p->width * y + x) + c];
    s->weight += weight;
}

static double coc_at(const picture *p, int x, int y) {
    return x < 0 || y < 0 || x >= p->width || y >= p->height ? 0 : (double)p->coc[(ptrdiff_t)p->width * y + x];
}

/* The pixel's mean along a line. */
static void gathered(const picture *p, const line *l, const double *rgba, int x, int y, double out[4]) {
    const double own = fabs(coc_at(p, x, y));
    sums s = {{0}, 0};
    for (int over = 0; over < 2; over++) {
        int taps;
        const double step = step_of(p, l, over ? p->nearest : own, &taps);
        for (int i = l->gaussian ? -taps : 0; i <= taps; i++) {
            const double t = i * step, down = l->dy * t, row = floor(down);
            for (int r = 0; r < 2; r++) {
                const int u = x + l->dx * (int)t, v = y + (int)row + r;
                const double coc = coc_at(p, u, v), d = over ? fabs(coc) : fmin(fabs(coc), own);
                if ((coc < -own) == over) take(&s, p, rgba, u, v, (r ? down - row : 1 - (down - row)) * weight_of(l, fabs(t), step, d));
            }
        }
    }
    for (int c = 0; c < 4; c++) out[c] = s.color[c] / s.weight;
}

static double *along(const picture *p, line l, const double *rgba) {
    double *out = malloc(sizeof *out * 4 * (size_t)p->width * (size_t)p->height);
    assert_non_null(out);
    for (int y = 0; y < p->height; y++)
        for (int x = 0; x < p->width; x++) gathered(p, &l, rgba, x, y, out + 4 * ((ptrdiff_t)p->width * y + x));
    return out;
}

static void define(const scene *s, ddof_method method, double aspect, float *want) {
    const size_t n = 4 * pixels_of(s);
    const double side = cos(acos(-1) / 6) / 2, slope = (float)(tan(acos(-1) / 6) * aspect);
    picture p = {s->width, s->height, s->coc, 0};
    for (size_t i = 0; i < n / 4; i++) p.nearest = fmax(p.nearest, -s->coc[i]);
    double *color = malloc(n * sizeof *color);
    assert_non_null(color);
    for (size_t i = 0; i < n; i++) color[i] = s->color[i];
    if (method == DDOF_METHOD_GAUSSIAN) {
        double *rows = along(&p, (line){true, 0.25, 1, 0}, color), *both = along(&p, (line){true, 0.25 * aspect, 0, 1}, rows);
        for (size_t i = 0; i < n; i++) want[i] = (float)both[i];
        free(rows);
        free(both);
    } else {
        const line left = {false, side, -1, slope};
        double *up = along(&p, (line){false, 0.5 * aspect, 0, -1}, color), *x = along(&p, left, color);
        for (size_t i = 0; i < n; i++) x[i] = (up[i] + x[i]) / 2;
        double *one = along(&p, left, up), *two = along(&p, (line){false, side, 1, slope}, x);
        for (size_t i = 0; i < n; i++) want[i] = (float)((one[i] + 2 * two[i]) / 3);
        free(up);
        free(x);
        free(one);
        free(two);
    }
    free(color);
}

static void check_scene(ddof_context *ctx, const scene *s, double aspect) {
    for (int m = 0; m < COUNT(methods); m++) {
        const ddof_settings settings = {.method = methods[m]};
        const size_t n = 4 * pixels_of(s);
        float *want = fenced(n * sizeof *want, true);
        ddof_frame frame = scene_frame(s);
        frame.pixel_aspect = aspect;
        define(s, methods[m], aspect, want);
        assert_int_equal(render(ctx, &frame, &settings).nonfinite_pixels, 0);
        assert_close(s->output, want, n, 1e-5 * magnitude(s->color, n), "%s, %d x %d, aspect %g", name_of(methods[m]), s->width, s->height,
                     aspect);
        fenced_free(want);
    }
}

/* Every pattern of CoC, sizes that are odd, narrow, and wider than a chunk. */
static void definition(void **state) {
    static const int sizes[][2] = {{1, 1}, {7, 5}, {1, 40}, {40, 1}, {70, 33}, {131, 20}, {20, 131}};
    static const double aspects[] = {1, 0.8, 1.25, 2.5};
    rng r = {120};
    ddof_context *ctx = context_of(test_parameters(state).isa, 2);
    for (int i = 0; i < COUNT(sizes); i++)
        for (int pattern = 0; pattern < COC_BEYOND; pattern++) {
            scene s = scene_fill(sizes[i][0], sizes[i][1], (coc_pattern)pattern, (color_pattern)(pattern % COLOR_PATTERNS), &r);
            check_scene(ctx, &s, aspects[(i + pattern) % COUNT(aspects)]);
            scene_free(&s);
        }
    DESTROY(ctx);
}

/* Blurs of 1 to 500 pixels, of one or the other sign, in pictures that hold them: with steps of 1 to 8. */
static void reaches(void **state) {
    static const float most[] = {3, 12, 60, 150, 500};
    rng r = {121};
    ddof_context *ctx = context_of(test_parameters(state).isa, 2);
    for (int i = 0; i < COUNT(most); i++)
        for (int turned = 0; turned < 2; turned++) {
            scene s = scene_fill(turned ? 9 : 320, turned ? 320 : 9, COC_ZERO, COLOR_LIGHTS, &r);
            for (int y = 0; y < s.height; y++)
                for (int x = 0; x < s.width; x++) {
                    const int block = x / 20 * 7 + y / 20 * 5 + i, of = 1 + block % 3;
                    s.coc[y * s.width + x] = most[i] / (float)of * (block % 2 ? 1.0f : -1.0f) * (block % 5 ? 1 : 0);
                }
            check_scene(ctx, &s, 1);
            scene_free(&s);
        }
    DESTROY(ctx);
}

/* ---- what holds */

static void constants(void **state) {
    rng r = {122};
    ddof_context *ctx = context_of(test_parameters(state).isa, 2);
    for (int i = 0; i < 60; i += TEST_STEP) {
        const ddof_settings settings = {.method = methods[i % 2], .layers = (ddof_layers)(i / 2 % 2)};
        scene s = scene_fill(rng_range(&r, 1, 150), rng_range(&r, 1, 60), (coc_pattern)(i / 4 % COC_PATTERNS), COLOR_RANDOM, &r);
        for (size_t v = 4; v < 4 * pixels_of(&s); v++) s.color[v] = s.color[v - 4];
        ddof_frame frame = scene_frame(&s);
        render(ctx, &frame, &settings);
        assert_close(s.output, s.color, 4 * pixels_of(&s), 1e-6, "%s, layers %d, %d x %d", name_of(settings.method), (int)settings.layers,
                     s.width, s.height);
        scene_free(&s);
    }
    DESTROY(ctx);
}

static void range(void **state) {
    rng r = {123};
    ddof_context *ctx = context_of(test_parameters(state).isa, 2);
    for (int i = 0; i < 40; i += TEST_STEP) {
        const ddof_settings settings = {.method = methods[i % 2]};
        scene s = scene_fill(rng_range(&r, 1, 150), rng_range(&r, 1, 60), (coc_pattern)(i / 2 % COC_PATTERNS), COLOR_SIGNED, &r);
        float low[4] = {INFINITY, INFINITY, INFINITY, INFINITY}, high[4] = {-INFINITY, -INFINITY, -INFINITY, -INFINITY};
        for (size_t v = 0; v < 4 * pixels_of(&s); v++) {
            low[v % 4] = fminf(low[v % 4], s.color[v]);
            high[v % 4] = fmaxf(high[v % 4], s.color[v]);
        }
        ddof_frame frame = scene_frame(&s);
        render(ctx, &frame, &settings);
        for (size_t v = 0; v < 4 * pixels_of(&s); v++)
            assert_true(s.output[v] >= low[v % 4] - 2e-6f && s.output[v] <= high[v % 4] + 2e-6f);
        scene_free(&s);
    }
    DESTROY(ctx);
}

/* A single light, blurred by 60 pixels everywhere: all of it, as wide as promised, and with the hexagon's corners. */
static void shape(void **state) {
    enum { W = 171, H = 161, X = 85, Y = 80 };
    static const float coc = 60;
    ddof_context *ctx = context_of(test_parameters(state).isa, 2);
    for (int m = 0; m < COUNT(methods); m++) {
        const ddof_settings settings = {.method = methods[m]};
        scene s = scene_make(W, H, true);
        double sum = 0, across = 0, down = 0;
        memset(s.color, 0, sizeof *s.color * 4 * pixels_of(&s));
        for (size_t i = 0; i < pixels_of(&s); i++) s.coc[i] = coc;
        s.color[4 * (Y * W + X)] = 1;
        ddof_frame frame = scene_frame(&s);
        render(ctx, &frame, &settings);
        for (int y = 0; y < H; y++)
            for (int x = 0; x < W; x++) {
                const float v = s.output[4 * (y * W + x)];
                sum += v;
                across += v * pow(x - X, 2);
                down += v * pow(y - Y, 2);
                if (methods[m] != DDOF_METHOD_HEXAGON) continue;
                /* how far outside the sides of the hexagon, which are cos 30 radii from its middle */
                const double u = abs(x - X), w = abs(y - Y), radius = 0.5 * (double)coc;
                const double out = fmax(u, 0.5 * u + cos(acos(-1) / 6) * w) - cos(acos(-1) / 6) * radius;
                if (out > 2) assert_true(v == 0);
                if (out < -2) assert_true(v > 0.5 / (1.5 * sqrt(3) * radius * radius) && v < 1.6 / (1.5 * sqrt(3) * radius * radius));
            }
        const double want = methods[m] == DDOF_METHOD_GAUSSIAN ? coc / 4 : coc / 2 * sqrt(5 / 24.0);
        assert_true(fabs(sum - 1) < 1e-4);
        if (!(fabs(sqrt(across / sum) / want - 1) < 0.05 && fabs(sqrt(down / sum) / want - 1) < 0.05))
            fail_msg("%s: standard deviations %g and %g, not %g", name_of(methods[m]), sqrt(across / sum), sqrt(down / sum), want);
        scene_free(&s);
    }
    DESTROY(ctx);
}

/* What is in focus keeps its bits beside what is far, and does not bleed into it; what is near spreads over it. */
static void bleeding(void **state) {
    enum { W = 120, H = 60 };
    rng r = {124};
    ddof_context *ctx = context_of(test_parameters(state).isa, 2);
    for (int m = 0; m < COUNT(methods); m++)
        for (int near = 0; near < 2; near++) {
            const ddof_settings settings = {.method = methods[m]};
            scene s = scene_fill(W, H, COC_ZERO, COLOR_RANDOM, &r);
            for (size_t i = 0; i < pixels_of(&s); i++)
                if (i % W >= W / 2) {
                    s.coc[i] = near ? -24.0f : 24.0f;
                    for (int c = 0; c < 4; c++) s.color[4 * i + (size_t)c] = 10;
                }
            ddof_frame frame = scene_frame(&s);
            render(ctx, &frame, &settings);
            for (int y = 20; y < 40; y++) {
                const float *in = s.color + 4 * (ptrdiff_t)y * W, *out = s.output + 4 * (ptrdiff_t)y * W;
                const int kept = near ? W / 2 - 20 : W / 2;
                assert_close(out, in, (size_t)kept * 4, 1e-6, "%s: in focus", name_of(methods[m]));
                if (!near) assert_close(out + 4 * kept, in + 4 * kept, (size_t)kept * 4, 1e-5, "%s: far", name_of(methods[m]));
                if (near) assert_true(out[4 * (W / 2 - 2)] > 1.5f);
            }
            scene_free(&s);
        }
    DESTROY(ctx);
}

/* Below a pixel of CoC hardly anything changes; at 0 no bit does. */
static void sharp(void **state) {
    rng r = {125};
    ddof_context *ctx = context_of(test_parameters(state).isa, 2);
    for (int i = 0; i < 16; i++) {
        const ddof_settings settings = {.method = methods[i % 2]};
        scene s = scene_fill(rng_range(&r, 1, 90), rng_range(&r, 1, 40), COC_ZERO, COLOR_RANDOM, &r);
        ddof_frame frame = scene_frame(&s);
        render(ctx, &frame, &settings);
        assert_close(s.output, s.color, 4 * pixels_of(&s), 1.2e-7, "%s, CoC 0", name_of(settings.method));
        for (size_t p = 0; p < pixels_of(&s); p++) s.coc[p] = (float)(2 * rng_unit(&r) - 1);
        render(ctx, &frame, &settings);
        assert_close(s.output, s.color, 4 * pixels_of(&s), 1e-3, "%s, CoC below 1", name_of(settings.method));
        scene_free(&s);
    }
    DESTROY(ctx);
}

/* ---- holes */

static void holes(void **state) {
    rng r = {126};
    ddof_context *ctx = context_of(test_parameters(state).isa, 2);
    for (int i = 0; i < 48; i += TEST_STEP) {
        const ddof_settings settings = {.method = methods[i % 2]};
        const double density = (double[]){0.01, 0.3, 0.97, 1}[i / 2 % 4];
        scene s = scene_fill(rng_range(&r, 1, 120), rng_range(&r, 1, 50), (coc_pattern)(i / 8 % COC_PATTERNS), COLOR_RANDOM, &r);
        int64_t count = 0;
        for (size_t p = 0; p < pixels_of(&s); p++) {
            memcpy(s.color + 4 * p, (float[]){0.1f, 0.5f, 0.9f, 1}, 4 * sizeof *s.color);
            if (rng_unit(&r) >= density) continue;
            count++;
            *(rng_bits(&r) & 1 ? &s.coc[p] : &s.color[4 * p + (rng_bits(&r) & 3)]) = rng_bits(&r) & 1 ? NAN : INFINITY;
        }
        ddof_frame frame = scene_frame(&s);
        assert_int_equal(render(ctx, &frame, &settings).nonfinite_pixels, count);
        const bool nothing = (size_t)count == pixels_of(&s);
        for (size_t p = 0; p < pixels_of(&s); p++)
            assert_close(s.output + 4 * p, nothing ? (float[4]){0} : (float[]){0.1f, 0.5f, 0.9f, 1}, 4, 2e-6, "%s, %d x %d, %d holes",
                         name_of(settings.method), s.width, s.height, (int)count);
        scene_free(&s);
    }
    DESTROY(ctx);
}

/* In a sharp picture a hole becomes what lies around it, and nothing else changes. */
static void contained(void **state) {
    rng r = {127};
    ddof_context *ctx = context_of(test_parameters(state).isa, 2);
    for (int m = 0; m < COUNT(methods); m++) {
        const ddof_settings settings = {.method = methods[m]};
        scene s = scene_fill(30, 20, COC_ZERO, COLOR_RANDOM, &r);
        const size_t hole = 10 * 30 + 13;
        s.color[4 * hole + 1] = NAN;
        ddof_frame frame = scene_frame(&s);
        assert_int_equal(render(ctx, &frame, &settings).nonfinite_pixels, 1);
        for (int c = 0; c < 4; c++) assert_true(s.output[4 * hole + (size_t)c] > 0.05f && s.output[4 * hole + (size_t)c] < 0.95f);
        s.color[4 * hole + 1] = s.output[4 * hole + 1];
        for (int c = 0; c < 4; c += 1) s.color[4 * hole + (size_t)c] = s.output[4 * hole + (size_t)c];
        assert_close(s.output, s.color, 4 * pixels_of(&s), 1.2e-7, "%s: beside a hole", name_of(methods[m]));
        scene_free(&s);
    }
    DESTROY(ctx);
}

/* ---- what the bits do not depend on */

static scene scene_of(int i, rng *r) {
    scene s = scene_fill(rng_range(r, 1, 150), rng_range(r, 1, 60), (coc_pattern)(i % COC_PATTERNS), COLOR_RANDOM, r);
    for (size_t p = 0; p < pixels_of(&s) && i % 3 == 0; p++)
        if (rng_bits(r) % 50 == 0) *(p % 2 ? &s.color[4 * p + 1] : &s.coc[p]) = NAN;
    return s;
}

static float *plain(unsigned isa, const scene *s, const ddof_settings *settings) {
    float *want = fenced(4 * pixels_of(s) * sizeof *want, true);
    ddof_context *ctx = context_of(isa, 1);
    ddof_frame frame = scene_frame(s);
    frame.output = ddof_image_interleaved(want, s->width, s->height, 4, DDOF_FLOAT, 0);
    render(ctx, &frame, settings);
    DESTROY(ctx);
    return want;
}

/* Threads, the caller's loops, and instruction sets. */
static void workers(void **state) {
    int (*const loops[])(void *, int, ddof_task, void *) = {NULL, NULL, parallel_reversed, parallel_threads};
    rng r = {128};
    for (int k = 0; k < COUNT(loops); k++) {
        const ddof_config config = {.threads = k < 2 ? k + 2 : PARALLEL_THREADS, .parallel_for = loops[k], .cpu_mask = test_parameters(state).isa};
        ddof_context *ctx = NULL;
        assert_int_equal(ddof_create(&ctx, &config), DDOF_OK);
        for (int i = 0; i < 24; i += TEST_STEP) {
            const ddof_settings settings = {.method = methods[i % 2], .layers = (ddof_layers)(i / 2 % 2)};
            scene s = scene_of(i, &r);
            float *want = plain(settings.layers ? test_parameters(state).isa : 0, &s, &settings);
            ddof_frame frame = scene_frame(&s);
            render(ctx, &frame, &settings);
            assert_same_bits(s.output, want, 4 * pixels_of(&s), "loop %d, %s, %d x %d", k, name_of(settings.method), s.width, s.height);
            fenced_free(want);
            scene_free(&s);
        }
        DESTROY(ctx);
    }
}

/* Arrangements of memory; in place. */
static void memory(void **state) {
    rng r = {129};
    ddof_context *ctx = context_of(test_parameters(state).isa, 2);
    for (int i = 0; i < 2 * LAYOUTS; i++) {
        const ddof_settings settings = {.method = methods[i % 2]};
        scene s = scene_of(i, &r);
        float *want = plain(test_parameters(state).isa, &s, &settings);
        for (int in_place = 0; in_place < 2; in_place++) {
            stored in = stored_make((layout)(i / 2), s.width, s.height, 4, 0);
            stored out = stored_make((layout)((i + 5) % LAYOUTS), s.width, s.height, 4, 0);
            stored_put(&in, s.color, 4);
            ddof_frame frame = scene_frame(&s);
            frame.color = in.image;
            frame.output = in_place ? in.image : out.image;
            render(ctx, &frame, &settings);
            assert_gaps_intact(&in);
            assert_gaps_intact(&out);
            stored_get(in_place ? &in : &out, s.output, 4);
            assert_same_bits(s.output, want, 4 * pixels_of(&s), "%s, %d x %d, layout %d, in place %d", name_of(settings.method), s.width,
                             s.height, i / 2, in_place);
            stored_free(&in);
            stored_free(&out);
        }
        fenced_free(want);
        scene_free(&s);
    }
    DESTROY(ctx);
}

/* Half floats are the rounded result; straight alpha is that of the multiplied picture, divided again; fewer channels are the same ones. */
static void types(void **state) {
    rng r = {130};
    ddof_context *ctx = context_of(test_parameters(state).isa, 2);
    for (int m = 0; m < COUNT(methods); m++)
        for (int channels = 1; channels <= 4; channels++) {
            const ddof_settings settings = {.method = methods[m]};
            const bool straight = channels % 2 == 0;
            scene s = scene_fill(75, 31, COC_SMOOTH, COLOR_RANDOM, &r);
            stored half = stored_make(LAYOUT_TIGHT, s.width, s.height, channels, 15);
            scene multiplied = scene_make(s.width, s.height, true);
            const size_t n = pixels_of(&s);
            memcpy(multiplied.color, s.color, 4 * n * sizeof *s.color);
            memcpy(multiplied.coc, s.coc, n * sizeof *s.coc);
            for (size_t p = 0; p < n && straight; p++)
                for (int c = 0; c < channels - 1; c++) multiplied.color[4 * p + (size_t)c] *= s.color[4 * p + (size_t)channels - 1];
            ddof_frame frame = scene_frame(&multiplied);
            render(ctx, &frame, &settings);
            frame.color = scene_frame(&s).color;
            frame.color.channels = channels;
            frame.color.alpha = straight ? DDOF_ALPHA_STRAIGHT : DDOF_ALPHA_PREMULTIPLIED;
            frame.output = half.image;
            render(ctx, &frame, &settings);
            stored_get(&half, s.output, 4);
            for (size_t p = 0; p < n; p++)
                for (int c = 0; c < channels; c++) {
                    const float *want = multiplied.output + 4 * p;
                    const float value = straight && c < channels - 1 ? want[c] / want[channels - 1] : want[c];
                    assert_true(s.output[4 * p + (size_t)c] == (float)half_value(half_nearest(value)));
                }
            stored_free(&half);
            scene_free(&multiplied);
            scene_free(&s);
        }
    DESTROY(ctx);
}

/* Depth is the CoC that the lens makes of it. */
static void depth(void **state) {
    rng r = {131};
    ddof_context *ctx = context_of(test_parameters(state).isa, 2);
    for (int m = 0; m < COUNT(methods); m++) {
        const ddof_settings settings = {.method = methods[m], .lens = {.focal_length = 85, .f_number = 1.4, .focus_distance = 3}};
        scene s = scene_fill(90, 40, COC_ZERO, COLOR_RANDOM, &r);
        float *z = fenced(pixels_of(&s) * sizeof *z, true), *first = fenced(4 * pixels_of(&s) * sizeof *first, true);
        for (size_t p = 0; p < pixels_of(&s); p++) z[p] = 1 + (float)(p % 90) / 10;
        ddof_frame frame = scene_frame(&s);
        frame.coc = (ddof_image){0};
        frame.depth = ddof_image_interleaved(z, s.width, s.height, 1, DDOF_FLOAT, 0);
        render(ctx, &frame, &settings);
        memcpy(first, s.output, 4 * pixels_of(&s) * sizeof *first);
        frame.output = ddof_image_interleaved(s.coc, s.width, s.height, 1, DDOF_FLOAT, 0);
        write_coc(ctx, &frame, &settings);
        frame = scene_frame(&s);
        render(ctx, &frame, &settings);
        assert_same_bits(s.output, first, 4 * pixels_of(&s), "%s: by depth and by CoC", name_of(methods[m]));
        fenced_free(z);
        fenced_free(first);
        scene_free(&s);
    }
    DESTROY(ctx);
}

/* ---- calls */

typedef struct watcher {
    atomic_int calls;
    int stop_at;
    double last;
} watcher;

static int watch(void *user, double done) {
    watcher *w = user;
    assert_true(done >= w->last && done <= 1);
    w->last = done;
    return atomic_fetch_add(&w->calls, 1) + 1 == w->stop_at;
}

/* Stopped at every call; to the end, all has been said to be done, and there is as much scratch memory as was said. */
static void cancel(void **state) {
    rng r = {132};
    for (int m = 0; m < COUNT(methods) * 2; m++) {
        const ddof_settings settings = {.method = methods[m / 2], .layers = (ddof_layers)(m % 2)};
        watcher w = {0};
        ddof_config config = {.threads = 1, .cpu_mask = test_parameters(state).isa, .progress = watch, .progress_user = &w};
        ddof_context *ctx = NULL;
        scene s = scene_fill(80, 70, COC_SMOOTH, COLOR_RANDOM, &r);
        ddof_frame frame = scene_frame(&s);
        size_t bytes = 0;
        s.color[17] = NAN;
        assert_int_equal(ddof_create(&ctx, &config), DDOF_OK);
        assert_int_equal(ddof_scratch_bytes(ctx, &frame, &settings, &bytes), DDOF_OK);
        assert_int_equal(render(ctx, &frame, &settings).scratch_bytes, bytes);
        assert_true(w.calls > 3 && w.last == 1);
        const int calls = w.calls;
        for (int k = 1; k <= calls; k++) {
            w = (watcher){.stop_at = k};
            assert_int_equal(ddof_render(ctx, &frame, &settings, NULL), DDOF_ERROR_CANCELLED);
            assert_int_equal(w.calls, k);
        }
        w = (watcher){0};
        render(ctx, &frame, &settings);
        scene_free(&s);
        DESTROY(ctx);
    }
}

static void refused(void **state) {
    static const struct {
        ddof_settings settings;
        const char *word;
        ddof_status status;
    } wrong[] = {
        {{.method = (ddof_method)-1}, "settings.method", DDOF_ERROR_INVALID},
        {{.method = (ddof_method)4}, "settings.method", DDOF_ERROR_INVALID},
        {{.method = DDOF_METHOD_GAUSSIAN, .kernel = DDOF_KERNEL_DISC}, "settings.kernel", DDOF_ERROR_INVALID},
        {{.method = DDOF_METHOD_HEXAGON, .kernel = DDOF_KERNEL_DISC, .quality = DDOF_QUALITY_GOOD}, "settings.kernel", DDOF_ERROR_INVALID},
        {{.method = DDOF_METHOD_GAUSSIAN, .substeps = 1}, "substeps", DDOF_ERROR_INVALID},
        {{.method = DDOF_METHOD_SCATTER, .substeps = 2}, "substeps", DDOF_ERROR_INVALID},
        {{.method = DDOF_METHOD_HEXAGON, .conductance = DDOF_CONDUCTANCE_CLASSIC}, "conductance", DDOF_ERROR_INVALID},
        {{.method = DDOF_METHOD_GAUSSIAN, .bokeh = DDOF_BOKEH_HIGHLIGHTS}, "settings.bokeh", DDOF_ERROR_INVALID},
        {{.method = DDOF_METHOD_SCATTER, .bokeh = DDOF_BOKEH_HIGHLIGHTS}, "settings.bokeh", DDOF_ERROR_INVALID},
        {{.method = DDOF_METHOD_GAUSSIAN, .bokeh = DDOF_BOKEH_FULL}, "settings.bokeh", DDOF_ERROR_INVALID},
        {{.method = DDOF_METHOD_HEXAGON, .bokeh = DDOF_BOKEH_FULL}, "settings.bokeh", DDOF_ERROR_INVALID},
        {{.method = DDOF_METHOD_DIFFUSION}, "", DDOF_OK},
        {{.method = DDOF_METHOD_GAUSSIAN, .layers = DDOF_LAYERS_AUTO}, "", DDOF_OK},
        {{.method = DDOF_METHOD_SCATTER, .bokeh = DDOF_BOKEH_FULL}, "", DDOF_OK},
    };
    (void)state;
    rng r = {133};
    ddof_context *ctx = context_of(0, 1), *reference = reference_context();
    scene s = scene_fill(9, 6, COC_SMALL, COLOR_RANDOM, &r);
    ddof_frame frame = scene_frame(&s);
    for (int i = 0; i < COUNT(wrong); i++) {
        assert_int_equal(ddof_render(ctx, &frame, &wrong[i].settings, NULL), wrong[i].status);
        if (!strstr(ddof_error(ctx), wrong[i].word)) fail_msg("%d: '%s' does not say '%s'", i, ddof_error(ctx), wrong[i].word);
    }
    for (int m = 0; m < COUNT(methods); m++) {
        const ddof_settings settings = {.method = methods[m]};
        assert_int_equal(ddof_render(reference, &frame, &settings, NULL), DDOF_ERROR_UNSUPPORTED);
        assert_non_null(strstr(ddof_error(reference), "settings.method"));
    }
    scene_free(&s);
    DESTROY(ctx);
    DESTROY(reference);
}

int main(void) {
    static const test tests[] = {
        {"the definition", definition, true, 0, 0},
        {"reaches", reaches, true, 0, 0},
        {"constants", constants, true, 0, 0},
        {"range", range, true, 0, 0},
        {"shape", shape, true, 0, 0},
        {"bleeding", bleeding, true, 0, 0},
        {"sharp", sharp, true, 0, 0},
        {"holes", holes, true, 0, 0},
        {"beside a hole", contained, true, 0, 0},
        {"workers", workers, true, 0, 0},
        {"memory", memory, true, 0, 0},
        {"types", types, true, 0, 0},
        {"depth", depth, false, 0, 0},
        {"cancel", cancel, false, 0, 0},
        {"refused", refused, false, 0, 0},
    };
    return run_library_tests("methods", tests, COUNT(tests));
}
