/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* ddof_coc() against the formulas of ddof.h, written down once more in double: every kind of depth, both lenses,
 * limits, focus; and what follows from them: crops, proxies, a CoC image handed back. */
#include "support.h"

#include <math.h>
#include <string.h>

static double or_default(double value, double otherwise) {
    return value > 0 ? value : otherwise;
}

/* ---- the model: 1/z of a pixel, and its CoC */

typedef struct inverse_depth {
    double q;       /* 1/z; 0: infinitely far; NaN: a hole */
    double rounded; /* what float may be off in it */
} inverse_depth;

static inverse_depth model_depth(const ddof_frame *frame, const ddof_settings *s, double v, int x, int y) {
    const double width = or_default(frame->picture_width, frame->depth.width);
    const double height = or_default(frame->picture_height, frame->depth.height);
    const double pitch = or_default(s->lens.sensor_width, 36) / width, f = s->lens.focal_length;
    const double a = s->depth.z_at_0, b = s->depth.z_at_1;
    double z = v, terms = fabs(v);
    if (isnan(v)) return (inverse_depth){NAN, 0};
    if (s->depth.kind == DDOF_DEPTH_RAY) {
        const double px = (frame->offset_x + x + 0.5 - width / 2) * pitch;
        const double py = (frame->offset_y + y + 0.5 - height / 2) * pitch / or_default(frame->pixel_aspect, 1);
        z = v * f / sqrt(f * f + px * px + py * py);
    } else if (s->depth.kind == DDOF_DEPTH_NORMALIZED) {
        z = a + (b - a) * v;
        terms = a + fabs((b - a) * v);
    } else if (s->depth.kind == DDOF_DEPTH_INVERSE || s->depth.kind == DDOF_DEPTH_DEVICE) {
        const double at_0 = s->depth.kind == DDOF_DEPTH_INVERSE ? 0 : 1 / a;
        const double slope = s->depth.kind == DDOF_DEPTH_INVERSE ? 1 : 1 / b - 1 / a;
        const double q = at_0 + slope * v;
        if (s->depth.kind == DDOF_DEPTH_INVERSE && v == INFINITY) return (inverse_depth){NAN, 0};
        return (inverse_depth){q > 0 && isfinite(v) ? q : 0, 4e-7 * (at_0 + fabs(slope * v))};
    }
    if (!(z > 0) || isinf(z)) return (inverse_depth){0, 0};
    return (inverse_depth){1 / z, 4e-7 * fmax(terms, z) / z / z};
}

/* CoC of the distance 1/q, focus at s; by the letter of ddof.h. */
static double model_coc(const ddof_frame *frame, const ddof_lens *lens, double s, double q) {
    const double width = or_default(frame->picture_width, frame->depth.width);
    const double s0 = s - lens->in_focus_range / 2, s1 = s + lens->in_focus_range / 2, z = q > 0 ? 1 / q : INFINITY;
    const double f = lens->focal_length / or_default(lens->unit, 1000);
    double part = 0, coc;
    if (z > s1) part = isinf(z) ? 1 : (z - s1) / z;
    if (z < s0) part = isinf(s) ? -1 / z : (z - s0) / z; /* focus at infinity: times s, which f/(s - f) divides out */
    if (lens->kind == DDOF_LENS_ARTIST)
        coc = part > 0 ? lens->max_coc_far * width * part : lens->max_coc_near * width * fmax(part, -1);
    else
        coc = lens->focal_length / lens->f_number * part * (isinf(s) ? f : f / (s - f)) * width /
              or_default(lens->sensor_width, 36);
    if (lens->limit_far > 0) coc = fmin(coc, lens->limit_far * width);
    if (lens->limit_near > 0) coc = fmax(coc, -lens->limit_near * width);
    return fmax(fmin(coc, 1e5), -1e5);
}

static void assert_coc(const ddof_frame *frame, const ddof_settings *s, double focus, double v, int x, int y,
                       float got) {
    const inverse_depth d = model_depth(frame, s, v, x, y);
    if (isnan(d.q)) {
        if (!isnan(got)) fail_msg("pixel %d, %d: depth %g has CoC %g, it must be a hole", x, y, v, got);
        return;
    }
    const double want = model_coc(frame, &s->lens, focus, d.q), far = model_coc(frame, &s->lens, focus, 0);
    const double low = model_coc(frame, &s->lens, focus, fmax(d.q - d.rounded, 0));
    const double high = model_coc(frame, &s->lens, focus, d.q + d.rounded);
    const double slack = 2e-6 * (fabs(want) + fabs(far)) + fabs(low - want) + fabs(high - want) + 1e-9;
    if (!(fabs(got - want) <= slack))
        fail_msg("pixel %d, %d, depth kind %d, lens kind %d, focus %g: value %g (1/z = %g) has CoC %.9g, not %.9g "
                 "within %.2g",
                 x, y, s->depth.kind, s->lens.kind, focus, v, d.q, got, want, slack);
}

/* ---- random cameras */

static double between(rng *r, double low, double high) {
    return low * pow(high / low, rng_unit(r));
}

static ddof_settings some_camera(ddof_lens_kind lens, ddof_depth_kind depth, rng *r) {
    const double unit = (double[]){0, 1, 10, 25.4, 1000}[rng_range(r, 0, 4)], metre = 1000 / or_default(unit, 1000);
    ddof_settings s = {.lens = {.kind = lens,
                                .focal_length = between(r, 8, 400),
                                .f_number = between(r, 0.7, 32),
                                .unit = unit,
                                .focus_distance = metre * between(r, 0.6, 200)},
                       .depth = {.kind = depth}};
    if (rng_bits(r) & 1) s.lens.sensor_width = between(r, 4, 60);
    if (rng_bits(r) & 1) s.lens.in_focus_range = s.lens.focus_distance * between(r, 0.01, 3);
    if (rng_bits(r) & 1) s.lens.limit_near = between(r, 0.001, 0.2);
    if (rng_bits(r) & 1) s.lens.limit_far = between(r, 0.001, 0.2);
    if (lens == DDOF_LENS_ARTIST) {
        s.lens.max_coc_near = rng_bits(r) % 4 ? between(r, 0.001, 0.5) : 0;
        s.lens.max_coc_far = rng_bits(r) % 4 ? between(r, 0.001, 0.5) : 0;
    } else if (rng_bits(r) % 8 == 0) {
        s.lens.focus_distance = INFINITY;
    }
    const double near = metre * between(r, 0.1, 1), far = metre * between(r, 2, 500);
    const bool white_is_near = rng_bits(r) & 1;
    s.depth.z_at_0 = white_is_near ? far : near;
    s.depth.z_at_1 = white_is_near ? near : far;
    if (depth == DDOF_DEPTH_DEVICE && rng_bits(r) % 3 == 0)
        *(white_is_near ? &s.depth.z_at_0 : &s.depth.z_at_1) = INFINITY;
    return s;
}

/* Values of the depth image that make sense for it, and some that do not. */
static void fill_depth(float *depth, size_t n, const ddof_settings *s, rng *r) {
    static const float odd[] = {0, -0.0f, 1, -1, INFINITY, -INFINITY, NAN, 1e10f, 1e-6f};
    const double metre = 1000 / or_default(s->lens.unit, 1000);
    for (size_t i = 0; i < n; i++) {
        double v = metre * between(r, 0.05, 1000);
        if (s->depth.kind == DDOF_DEPTH_INVERSE) v = 1 / v;
        if (s->depth.kind == DDOF_DEPTH_NORMALIZED || s->depth.kind == DDOF_DEPTH_DEVICE) v = 1.5 * rng_unit(r) - 0.25;
        depth[i] = rng_bits(r) % 32 ? (float)v : odd[rng_range(r, 0, COUNT(odd) - 1)];
    }
}

static ddof_frame map_frame(float *depth, float *coc, int width, int height) {
    return (ddof_frame){.depth = ddof_image_interleaved(depth, width, height, 1, DDOF_FLOAT, 0),
                        .output = ddof_image_interleaved(coc, width, height, 1, DDOF_FLOAT, 0)};
}

/* A place in a larger picture, pixels that are not square. */
static void some_geometry(ddof_frame *frame, rng *r) {
    if (rng_bits(r) & 1) frame->pixel_aspect = between(r, 0.5, 2);
    if (rng_bits(r) & 1) return;
    frame->picture_width = rng_range(r, 1, 4000);
    frame->picture_height = rng_range(r, 1, 3000);
    frame->offset_x = rng_range(r, -300, 2000);
    frame->offset_y = rng_range(r, -300, 2000);
}

enum { WIDTH = 67, HEIGHT = 41, PIXELS = WIDTH * HEIGHT, CAMERAS = 60 };

static void check_cameras(ddof_context *ctx, ddof_lens_kind lens, ddof_depth_kind kind) {
    rng r = {(uint64_t)(60 + lens * 8 + kind)};
    float *depth = fenced(PIXELS * sizeof *depth, true), *coc = fenced(PIXELS * sizeof *coc, true);
    for (int i = 0; i < CAMERAS; i++) {
        const ddof_settings s = some_camera(lens, kind, &r);
        int64_t holes = 0;
        ddof_frame frame = map_frame(depth, coc, WIDTH, HEIGHT);
        fill_depth(depth, PIXELS, &s, &r);
        some_geometry(&frame, &r);
        ddof_stats stats = write_coc(ctx, &frame, &s);
        assert_true(stats.focus_distance == s.lens.focus_distance);
        for (int p = 0; p < PIXELS; p++) {
            holes += isnan(coc[p]);
            assert_coc(&frame, &s, s.lens.focus_distance, depth[p], p % WIDTH, p / WIDTH, coc[p]);
        }
        assert_int_equal(stats.nonfinite_pixels, holes);
    }
    fenced_free(depth);
    fenced_free(coc);
}

/* value: kind of depth, plus 16 for the artist's lens. */
static void cameras(void **state) {
    const int value = test_parameters(state).value;
    ddof_context *ctx = context_of(test_parameters(state).isa, 2);
    check_cameras(ctx, (ddof_lens_kind)(value / 16), (ddof_depth_kind)(value % 16));
    DESTROY(ctx);
}

static void reference_cameras(void **state) {
    (void)state;
    ddof_context *ctx = reference_context();
    for (int value = 0; value < 10; value++)
        check_cameras(ctx, (ddof_lens_kind)(value / 5), (ddof_depth_kind)(value % 5));
    DESTROY(ctx);
}

/* ---- numbers anyone can check: 50 mm, f/2, focus at 2 m, on 36 mm and 3600 pixels */

static void by_hand(void **state) {
    ddof_context *ctx = context_of(test_parameters(state).isa, 1);
    enum { N = 3600 };
    static float depth[N], coc[N];
    ddof_settings s = {.lens = {.focal_length = 50, .f_number = 2, .focus_distance = 2}};
    ddof_frame frame = map_frame(depth, coc, N, 1);
    for (int i = 0; i < N; i++)
        depth[i] = 2;
    depth[1] = 4;
    depth[2] = 1;
    depth[3] = INFINITY;
    depth[4] = 0;
    write_coc(ctx, &frame, &s);
    const double whole = 25.0 * 50 / 1950 * 100; /* aperture 25 mm, magnification f/(s - f), 100 pixels a mm */
    assert_true(coc[0] == 0);
    assert_true(fabs(coc[1] - whole / 2) < 1e-4);
    assert_true(fabs(coc[2] + whole) < 1e-4);
    assert_true(fabs(coc[3] - whole) < 1e-4);
    assert_true(coc[4] == coc[3]);
    s.lens = (ddof_lens){.kind = DDOF_LENS_ARTIST, .focus_distance = 2, .max_coc_near = 0.01, .max_coc_far = 0.02};
    write_coc(ctx, &frame, &s);
    assert_true(coc[0] == 0);
    assert_true(fabs(coc[1] - 36) < 1e-4); /* half of 0.02 W at twice the distance */
    assert_true(fabs(coc[2] + 36) < 1e-4); /* all of 0.01 W at half the distance, */
    depth[2] = 0.1f;
    write_coc(ctx, &frame, &s);
    assert_true(fabs(coc[2] + 36) < 1e-4); /* and no more nearer still */
    assert_true(fabs(coc[3] - 72) < 1e-4);
    DESTROY(ctx);
}

/* ---- focus */

/* Focus on a pixel is focus at its distance. */
static void focus_pixel(void **state) {
    rng r = {80};
    ddof_context *ctx = context_of(test_parameters(state).isa, 2);
    float *depth = fenced(PIXELS * sizeof *depth, true), *coc = fenced(PIXELS * sizeof *coc, true);
    for (int i = 0; i < 200; i++) {
        ddof_settings s = some_camera(DDOF_LENS_THIN, (ddof_depth_kind)(i % 5), &r);
        ddof_frame frame = map_frame(depth, coc, WIDTH, HEIGHT);
        fill_depth(depth, PIXELS, &s, &r);
        some_geometry(&frame, &r);
        const int p = rng_range(&r, 0, PIXELS - 1);
        s.lens.focus = DDOF_FOCUS_PIXEL;
        s.lens.focus_x = p % WIDTH;
        s.lens.focus_y = p / WIDTH;
        s.lens.focus_distance = -3; /* not looked at */
        const inverse_depth d = model_depth(&frame, &s, depth[p], p % WIDTH, p / WIDTH);
        const double want = d.q > 0 ? 1 / d.q : INFINITY;
        if (isnan(d.q) || want <= s.lens.focal_length / or_default(s.lens.unit, 1000)) {
            assert_int_equal(ddof_coc(ctx, &frame, &s, NULL), DDOF_ERROR_INVALID);
            assert_true(ddof_error(ctx)[0] != 0);
            continue;
        }
        const double focus = write_coc(ctx, &frame, &s).focus_distance;
        assert_true(isinf(want) ? isinf(focus) : fabs(focus / want - 1) <= 1e-6 + 2 * d.rounded * want);
        for (int k = 0; k < PIXELS; k++)
            assert_coc(&frame, &s, focus, depth[k], k % WIDTH, k / WIDTH, coc[k]);
    }
    fenced_free(depth);
    fenced_free(coc);
    DESTROY(ctx);
}

static void assert_refused(ddof_context *ctx, const ddof_frame *frame, const ddof_settings *s, const char *word) {
    assert_int_equal(ddof_coc(ctx, frame, s, NULL), DDOF_ERROR_INVALID);
    if (!strstr(ddof_error(ctx), word)) fail_msg("'%s' does not say '%s'", ddof_error(ctx), word);
}

static void focus_pixel_refused(void **state) {
    ddof_context *ctx = context_of(test_parameters(state).isa, 1);
    float depth[6] = {2, NAN, INFINITY, 0.01f, 0, 3}, coc[6];
    ddof_settings s = {.lens = {.focal_length = 50, .f_number = 2, .focus = DDOF_FOCUS_PIXEL}};
    ddof_frame frame = map_frame(depth, coc, 3, 2);
    static const int outside[][2] = {{-1, 0}, {3, 0}, {0, -1}, {0, 2}, {INT32_MAX, 0}, {0, INT32_MIN}};
    for (int i = 0; i < COUNT(outside); i++) {
        s.lens.focus_x = outside[i][0];
        s.lens.focus_y = outside[i][1];
        assert_refused(ctx, &frame, &s, "outside");
    }
    s.lens.focus_y = 0;
    s.lens.focus_x = 1; /* NaN */
    assert_refused(ctx, &frame, &s, "no depth");
    s.lens.focus_x = 2; /* infinitely far: a real lens can */
    assert_true(isinf(write_coc(ctx, &frame, &s).focus_distance));
    s.lens.kind = DDOF_LENS_ARTIST; /* the artist's has no gain there */
    assert_refused(ctx, &frame, &s, "finite");
    s.lens.kind = DDOF_LENS_THIN;
    s.lens.focus_y = 1;
    s.lens.focus_x = 0; /* 1 cm, inside the focal length */
    assert_refused(ctx, &frame, &s, "focal length");
    DESTROY(ctx);
}

/* ---- crops, proxies */

/* A part of the picture has the CoC of that part of the whole. */
static void crop(void **state) {
    rng r = {81};
    ddof_context *ctx = context_of(test_parameters(state).isa, 2);
    float *depth = fenced(PIXELS * sizeof *depth, true), *whole = fenced(PIXELS * sizeof *whole, true);
    for (int i = 0; i < 60; i++) {
        ddof_settings s = some_camera((ddof_lens_kind)(i / 5 % 2), (ddof_depth_kind)(i % 5), &r);
        ddof_frame frame = map_frame(depth, whole, WIDTH, HEIGHT);
        fill_depth(depth, PIXELS, &s, &r);
        write_coc(ctx, &frame, &s);
        const int x0 = rng_range(&r, 0, WIDTH - 1), y0 = rng_range(&r, 0, HEIGHT - 1);
        const int w = rng_range(&r, 1, WIDTH - x0), h = rng_range(&r, 1, HEIGHT - y0);
        float *part = fenced((size_t)(w * h) * sizeof *part, true);
        ddof_frame cut = {.depth = ddof_image_interleaved(depth + y0 * WIDTH + x0, w, h, 1, DDOF_FLOAT, WIDTH * 4),
                          .output = ddof_image_interleaved(part, w, h, 1, DDOF_FLOAT, 0),
                          .picture_width = WIDTH,
                          .picture_height = HEIGHT,
                          .offset_x = x0,
                          .offset_y = y0};
        write_coc(ctx, &cut, &s);
        for (int y = 0; y < h; y++)
            for (int x = 0; x < w; x++)
                if (!isnan(whole[(y0 + y) * WIDTH + x0 + x]) || !isnan(part[y * w + x]))
                    assert_same_bits(&part[y * w + x], &whole[(y0 + y) * WIDTH + x0 + x], 1, "depth kind %d at %d, %d",
                                     i % 5, x, y);
        fenced_free(part);
    }
    fenced_free(depth);
    fenced_free(whole);
    DESTROY(ctx);
}

/* A proxy of half the size has half the CoC, and its blur is the blur of the picture, made smaller. */
static void proxy(void **state) {
    enum { W = 256, H = 128, N = W * H };
    ddof_context *ctx = context_of(test_parameters(state).isa, 2);
    scene big = scene_make(W, H, true), small = scene_make(W / 2, H / 2, true);
    float *coc_big = fenced(N * sizeof(float), true), *coc_small = fenced(N / 4 * sizeof(float), true);
    const ddof_settings s = {.lens = {.focal_length = 85, .f_number = 1.4, .focus_distance = 3}, .substeps = 2};
    for (int p = 0; p < N / 4; p++) {
        const int x = p % (W / 2), y = p / (W / 2);
        small.coc[p] = (float)(2 + 4.0 * x / W);
        for (int c = 0; c < 4; c++) {
            small.color[4 * p + c] = (x / 16 + y / 16 + c) % 2 ? 1.0f : 0.1f;
            for (int k = 0; k < 4; k++)
                big.color[4 * ((2 * y + k / 2) * W + 2 * x + k % 2) + c] = small.color[4 * p + c];
        }
        for (int k = 0; k < 4; k++)
            big.coc[(2 * y + k / 2) * W + 2 * x + k % 2] = small.coc[p];
    }
    ddof_frame frame = scene_frame(&big), half = scene_frame(&small);
    frame.depth = frame.coc, half.depth = half.coc;
    frame.coc.channels = half.coc.channels = 0;
    render(ctx, &frame, &s);
    render(ctx, &half, &s);
    double off = 0;
    for (int p = 0; p < N / 4; p++)
        for (int c = 0; c < 4; c++) {
            const float *q = big.output + 4 * (2 * (p / (W / 2)) * W + 2 * (p % (W / 2))) + c;
            off += pow((q[0] + q[4] + q[4 * W] + q[4 * W + 4]) / 4 - small.output[4 * p + c], 2);
        }
    if (!(sqrt(off / N) < 0.02)) fail_msg("the proxy is off by %.3g", sqrt(off / N));
    frame.output = ddof_image_interleaved(coc_big, W, H, 1, DDOF_FLOAT, 0);
    half.output = ddof_image_interleaved(coc_small, W / 2, H / 2, 1, DDOF_FLOAT, 0);
    write_coc(ctx, &frame, &s);
    write_coc(ctx, &half, &s);
    for (int p = 0; p < N / 4; p++) {
        const float twice = coc_big[2 * (p / (W / 2)) * W + 2 * (p % (W / 2))];
        assert_close(&coc_small[p], &(float){twice / 2}, 1, 1e-5, "pixel %d", p);
    }
    scene_free(&big);
    scene_free(&small);
    fenced_free(coc_big);
    fenced_free(coc_small);
    DESTROY(ctx);
}

/* ---- handed back */

/* The CoC image in place of the depth renders the same bits; written over the depth it is the same too. */
static void handed_back(void **state) {
    rng r = {82};
    ddof_context *ctx = context_of(test_parameters(state).isa, 2);
    for (int i = 0; i < 60; i++) {
        const ddof_settings s = some_camera((ddof_lens_kind)(i / 5 % 2), (ddof_depth_kind)(i % 5), &r);
        scene a = scene_fill(rng_range(&r, 1, 130), rng_range(&r, 1, 60), COC_ZERO, COLOR_RANDOM, &r);
        const size_t n = (size_t)a.width * (size_t)a.height;
        float *want = fenced(4 * n * sizeof *want, true), *coc = fenced(n * sizeof *coc, true);
        fill_depth(a.coc, n, &s, &r);
        ddof_frame frame = scene_frame(&a), map = map_frame(a.coc, coc, a.width, a.height);
        some_geometry(&frame, &r);
        map.pixel_aspect = frame.pixel_aspect;
        map.picture_width = frame.picture_width, map.picture_height = frame.picture_height;
        map.offset_x = frame.offset_x, map.offset_y = frame.offset_y;
        frame.depth = frame.coc;
        frame.coc.channels = 0;
        const int64_t holes = render(ctx, &frame, &s).nonfinite_pixels;
        memcpy(want, a.output, 4 * n * sizeof *want);
        assert_int_equal(write_coc(ctx, &map, &s).nonfinite_pixels, holes);
        frame.coc = map.output;
        frame.depth.channels = 0;
        assert_int_equal(render(ctx, &frame, &s).nonfinite_pixels, holes);
        assert_same_bits(a.output, want, 4 * n, "depth kind %d, lens kind %d", i % 5, i / 5 % 2);
        map.output = map.depth;
        write_coc(ctx, &map, &s);
        for (size_t p = 0; p < n; p++)
            if (!isnan(coc[p]) || !isnan(a.coc[p])) assert_same_bits(&a.coc[p], &coc[p], 1, "in place, pixel %zu", p);
        fenced_free(want);
        fenced_free(coc);
        scene_free(&a);
    }
    DESTROY(ctx);
}

int main(void) {
    static const test tests[] = {
        {"by hand", by_hand, true, 0, 0},
        {"thin lens, planar depth", cameras, true, DDOF_DEPTH_PLANAR, 0},
        {"thin lens, ray depth", cameras, true, DDOF_DEPTH_RAY, 0},
        {"thin lens, inverse depth", cameras, true, DDOF_DEPTH_INVERSE, 0},
        {"thin lens, normalised depth", cameras, true, DDOF_DEPTH_NORMALIZED, 0},
        {"thin lens, device depth", cameras, true, DDOF_DEPTH_DEVICE, 0},
        {"artist's lens, planar depth", cameras, true, 16 + DDOF_DEPTH_PLANAR, 0},
        {"artist's lens, ray depth", cameras, true, 16 + DDOF_DEPTH_RAY, 0},
        {"artist's lens, inverse depth", cameras, true, 16 + DDOF_DEPTH_INVERSE, 0},
        {"artist's lens, normalised depth", cameras, true, 16 + DDOF_DEPTH_NORMALIZED, 0},
        {"artist's lens, device depth", cameras, true, 16 + DDOF_DEPTH_DEVICE, 0},
        {"the reference's lenses", reference_cameras, false, 0, 0},
        {"focus on a pixel", focus_pixel, true, 0, 0},
        {"focus on a pixel, refused", focus_pixel_refused, true, 0, 0},
        {"crops", crop, true, 0, 0},
        {"proxies", proxy, true, 0, 0},
        {"CoC handed back", handed_back, true, 0, 0},
    };
    return run_library_tests("lens", tests, COUNT(tests));
}
