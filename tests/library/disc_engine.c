/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The disc kernel of the CPU engine: against school algebra, and that its bits depend on nothing but the picture. */
#include "allocator.h"
#include "disc_school.h"
#include "layout.h"
#include "parallel.h"
#include "support.h"

#include <math.h>
#include <string.h>

static size_t pixels_of(const scene *s) {
    return (size_t)s->width * (size_t)s->height;
}

static ddof_settings settings_of(int i) {
    return (ddof_settings){.kernel = DDOF_KERNEL_DISC, .quality = (ddof_quality)(1 + i % 3)};
}

/* ---- what it computes */

static bool *holes_of(const scene *s) {
    bool *hole = fenced(pixels_of(s) * sizeof *hole, true);
    for (size_t p = 0; p < pixels_of(s); p++) {
        const float *c = s->color + 4 * p;
        hole[p] = !(isfinite(c[0]) && isfinite(c[1]) && isfinite(c[2]) && isfinite(c[3]) && isfinite(s->coc[p]));
    }
    return hole;
}

/* The result against the oracle's, every channel, to `tolerance` of the range. Returns how many holes there were. */
static int64_t check(ddof_context *ctx, const scene *s, const ddof_settings *settings, double aspect,
                     double tolerance) {
    const size_t n = pixels_of(s);
    bool *hole = holes_of(s);
    double *values = fenced(n * sizeof *values, true), most = 0;
    int64_t holes = 0;
    ddof_frame frame = scene_frame(s);
    frame.pixel_aspect = aspect;
    for (size_t p = 0; p < n; p++)
        holes += hole[p];
    for (size_t v = 0; v < 4 * n; v++)
        if (isfinite(s->color[v])) most = fmax(most, fabs(s->color[v]));
    assert_int_equal(render(ctx, &frame, settings).nonfinite_pixels, holes);
    for (size_t c = 0; c < 4; c++) {
        const disc_school o = {s->width, s->height, settings->quality, aspect > 0 ? aspect : 1, s->coc, hole};
        for (size_t p = 0; p < n; p++)
            values[p] = s->color[4 * p + c];
        disc_school_blur(&o, values);
        for (size_t p = 0; p < n; p++)
            if (!(fabs(s->output[4 * p + c] - values[p]) <= tolerance * most))
                fail_msg("%d x %d, quality %d, aspect %g, pixel %zu, %zu, channel %zu: %.9g, not %.9g", s->width,
                         s->height, settings->quality, aspect, p % (size_t)s->width, p / (size_t)s->width, c,
                         s->output[4 * p + c], values[p]);
    }
    fenced_free(values);
    fenced_free(hole);
    return holes;
}

/* Diagonals of every length, all patterns of CoC. */
static void accuracy(void **state) {
    static const int sizes[][2] = {{1, 1},  {1, 67},  {67, 1},  {2, 2},   {17, 3},
                                   {3, 17}, {16, 16}, {65, 31}, {33, 65}, {64, 64}};
    rng r = {70};
    ddof_context *ctx = context_of(test_parameters(state).isa, 2);
    for (int i = 0; i < 90; i += TEST_STEP) {
        const int *size = sizes[i % COUNT(sizes)], width = i < 30 ? size[0] : rng_range(&r, 1, 67);
        const ddof_settings settings = settings_of(i);
        scene s = scene_fill(width, i < 30 ? size[1] : rng_range(&r, 1, 67), (coc_pattern)(i % COC_PATTERNS),
                             (color_pattern)(i % COLOR_PATTERNS), &r);
        const double aspect = (double[]){0, 0.5, 2, 1.4587}[i / 3 % 4];
        check(ctx, &s, &settings, aspect, 1e-5);
        scene_free(&s);
    }
    DESTROY(ctx);
}

static void make_hole(scene *s, size_t p, rng *r) {
    static const float bad[] = {NAN, INFINITY, -INFINITY, -NAN};
    const unsigned which = 1 + rng_bits(r) % 31;
    for (int c = 0; c < 4; c++)
        if (which >> c & 1) s->color[4 * p + (size_t)c] = bad[rng_range(r, 0, 3)];
    if (which >> 4 & 1) s->coc[p] = bad[rng_range(r, 0, 3)];
}

/* Few holes, many, whole rows of them, nothing else. */
static void holes(void **state) {
    rng r = {71};
    ddof_context *ctx = context_of(test_parameters(state).isa, 2);
    for (int i = 0; i < 72; i += TEST_STEP) {
        const ddof_settings settings = settings_of(i);
        scene s = scene_fill(rng_range(&r, 1, 60), rng_range(&r, 1, 50), (coc_pattern)(i / 3 % COC_PATTERNS),
                             COLOR_SIGNED, &r);
        const double density = (double[]){0.002, 0.05, 0.5, 0.97, 1.1}[i / 3 % 5];
        const int dead = rng_range(&r, 0, s.height - 1), dead_rows = i % 4 * 3;
        for (size_t p = 0; p < pixels_of(&s); p++) {
            const int y = (int)(p / (size_t)s.width);
            if (rng_unit(&r) < density || (y >= dead && y < dead + dead_rows)) make_hole(&s, p, &r);
        }
        check(ctx, &s, &settings, 1, 2e-5);
        scene_free(&s);
    }
    DESTROY(ctx);
}

/* Constants stay, the sum stays, and what is in focus is not touched. */
static void invariants(void **state) {
    rng r = {72};
    ddof_context *ctx = context_of(test_parameters(state).isa, 2);
    for (int i = 0; i < 60; i += TEST_STEP) {
        const ddof_settings settings = settings_of(i);
        scene s =
            scene_fill(rng_range(&r, 1, 400), rng_range(&r, 1, 200), (coc_pattern)(i % COC_PATTERNS), COLOR_RANDOM, &r);
        double before = 0, after = 0;
        ddof_frame frame = scene_frame(&s);
        for (size_t p = 0; p < pixels_of(&s); p++)
            s.color[4 * p] = 0.7f;
        render(ctx, &frame, &settings);
        for (size_t p = 0; p < pixels_of(&s); p++) {
            const float *in = s.color + 4 * p, *out = s.output + 4 * p;
            before += in[1], after += out[1];
            assert_true(fabsf(out[0] - 0.7f) < 3e-6f);
            for (int c = 0; c < 4 && s.coc[p] == 0; c++)
                assert_true(fabsf(out[c] - in[c]) <= 5e-7f * in[c]);
        }
        if (fabs(after - before) > 1e-5 * before)
            fail_msg("%d x %d: the sum %g became %g", s.width, s.height, before, after);
        scene_free(&s);
    }
    DESTROY(ctx);
}

/* ---- what its bits do not depend on */

/* With some holes in every third one, among them a whole row. */
static scene scene_of(int i, rng *r) {
    static const int sizes[][2] = {{1, 1},   {64, 64},  {97, 53}, {130, 33}, {300, 3},
                                   {5, 300}, {192, 31}, {17, 16}, {65, 128}};
    const int *size = sizes[i % COUNT(sizes)];
    scene s = scene_fill(size[0], size[1], (coc_pattern)(i % COC_PATTERNS), COLOR_RANDOM, r);
    for (int k = 1; k < s.width * s.height && i % 3 == 2; k++)
        if (rng_bits(r) % 50 == 0 || k / s.width == 2) *(k % 2 ? &s.color[4 * k + 1] : &s.coc[k]) = NAN;
    return s;
}

/* The result with one thread, tight memory, a fresh context. */
static float *plain(unsigned isa, const scene *s, const ddof_settings *settings) {
    float *want = fenced(pixels_of(s) * 4 * sizeof *want, true);
    ddof_context *ctx = context_of(isa, 1);
    ddof_frame frame = scene_frame(s);
    frame.output = ddof_image_interleaved(want, s->width, s->height, 4, DDOF_FLOAT, 0);
    render(ctx, &frame, settings);
    DESTROY(ctx);
    return want;
}

static void same_as_plain(ddof_context *ctx, unsigned isa, int i, rng *r) {
    const ddof_settings settings = settings_of(i / 2);
    scene s = scene_of(i, r);
    float *want = plain(isa, &s, &settings);
    ddof_frame frame = scene_frame(&s);
    render(ctx, &frame, &settings);
    assert_same_bits(s.output, want, 4 * pixels_of(&s), "%d x %d, quality %d", s.width, s.height, settings.quality);
    fenced_free(want);
    scene_free(&s);
}

static void threads(void **state) {
    rng r = {73};
    ddof_context *ctx = context_of(test_parameters(state).isa, test_parameters(state).value);
    for (int i = 0; i < 54; i += TEST_STEP)
        same_as_plain(ctx, test_parameters(state).isa, i, &r);
    DESTROY(ctx);
}

static void parallel_for(void **state) {
    int (*const loops[])(void *, int, ddof_task, void *) = {parallel_serial, parallel_reversed, parallel_threads};
    rng r = {74};
    ddof_config config = {.cpu_mask = test_parameters(state).isa,
                          .threads = PARALLEL_THREADS,
                          .parallel_for = loops[test_parameters(state).value]};
    ddof_context *ctx = NULL;
    assert_int_equal(ddof_create(&ctx, &config), DDOF_OK);
    for (int i = 0; i < 36; i += TEST_STEP)
        same_as_plain(ctx, test_parameters(state).isa, i, &r);
    DESTROY(ctx);
}

static void fused(void **state) {
    rng r = {75};
    ddof_context *ctx = context_of(test_parameters(state).isa, 3);
    for (int i = 0; i < 108; i += TEST_STEP)
        same_as_plain(ctx, DDOF_CPU_AVX2, i, &r);
    DESTROY(ctx);
}

/* Every arrangement of the colour with every one of the output; -1: in place. */
static void memory(void **state) {
    rng r = {76};
    ddof_context *ctx = context_of(test_parameters(state).isa, 2);
    for (int i = 0; i < 6; i += TEST_STEP) {
        const ddof_settings settings = settings_of(i);
        scene s = scene_of(i + i / 3, &r);
        float *want = plain(test_parameters(state).isa, &s, &settings);
        for (int color = 0; color < LAYOUTS; color++)
            for (int output = -1; output < LAYOUTS; output++) {
                stored in = stored_make((layout)color, s.width, s.height, 4, 0);
                stored map = stored_make((layout)((color + output + 1) % LAYOUT_PLANAR), s.width, s.height, 1, 0);
                stored out = stored_make((layout)(output < 0 ? 0 : output), s.width, s.height, 4, 0);
                stored_put(&in, s.color, 4);
                stored_put(&map, s.coc, 1);
                ddof_frame frame = {.color = in.image, .coc = map.image, .output = output < 0 ? in.image : out.image};
                render(ctx, &frame, &settings);
                stored_get(output < 0 ? &in : &out, s.output, 4);
                assert_same_bits(s.output, want, 4 * pixels_of(&s), "%d x %d, colour %d, output %d", s.width, s.height,
                                 color, output);
                assert_gaps_intact(&in);
                assert_gaps_intact(&out);
                stored_free(&in);
                stored_free(&map);
                stored_free(&out);
            }
        fenced_free(want);
        scene_free(&s);
    }
    DESTROY(ctx);
}

/* One to four channels of either type, alpha of either kind: the float RGBA result, cut, divided, rounded; in place
 * too. */
static void types(void **state) {
    rng r = {77};
    ddof_context *ctx = context_of(test_parameters(state).isa, 2);
    for (int i = 0; i < 72; i += TEST_STEP) {
        const int channels = i % 4 + 1, arrangement = rng_range(&r, 0, channels == 1 ? LAYOUT_REVERSED : LAYOUTS - 1);
        const bool straight = channels % 2 == 0 && i / 4 % 2;
        const unsigned half = i / 8 % 2 ? 15 : rng_bits(&r) & 15;
        const ddof_settings settings = settings_of(i / 3);
        scene s =
            scene_fill(rng_range(&r, 1, 90), rng_range(&r, 1, 60), (coc_pattern)(i % COC_PATTERNS), COLOR_RANDOM, &r);
        stored in = stored_make((layout)arrangement, s.width, s.height, channels, half);
        stored out = stored_make((layout)rng_range(&r, 0, LAYOUT_REVERSED), s.width, s.height, channels, half);
        stored_put(&in, s.color, 4);
        memset(s.color, 0, 4 * pixels_of(&s) * sizeof(float));
        stored_get(&in, s.color, 4); /* rounded to half where it is that */
        ddof_frame frame = scene_frame(&s);
        frame.color = in.image;
        frame.output = out.image;
        if (straight) {
            frame.color.alpha = DDOF_ALPHA_STRAIGHT;
            for (size_t p = 0; p < pixels_of(&s); p++)
                for (int c = 0; c < channels - 1; c++)
                    s.color[4 * p + (size_t)c] *= s.color[4 * p + (size_t)channels - 1];
        }
        float *want = plain(test_parameters(state).isa, &s, &settings);
        for (size_t v = 0; v < 4 * pixels_of(&s); v++) {
            const size_t c = v % 4, alpha = v - c + (size_t)channels - 1;
            if (straight && c + 1 < (size_t)channels) want[v] = want[alpha] != 0 ? want[v] / want[alpha] : 0;
            if (c >= (size_t)channels) want[v] = 0;
        }
        for (size_t v = 0; v < 4 * pixels_of(&s); v++)
            if (half >> v % 4 & 1) want[v] = (float)half_value(half_nearest(want[v]));
        for (int place = 0; place < 2; place++) {
            if (place) frame.output = frame.color;
            render(ctx, &frame, &settings);
            memset(s.output, 0, 4 * pixels_of(&s) * sizeof(float));
            stored_get(place ? &in : &out, s.output, 4);
            assert_same_bits(s.output, want, 4 * pixels_of(&s), "%d x %d, %d channels, half %x, in place %d", s.width,
                             s.height, channels, half, place);
        }
        assert_gaps_intact(&in);
        assert_gaps_intact(&out);
        fenced_free(want);
        stored_free(&in);
        stored_free(&out);
        scene_free(&s);
    }
    DESTROY(ctx);
}

/* Depth and lens give what the CoC made of them gives. */
static void depth(void **state) {
    rng r = {78};
    ddof_context *ctx = context_of(test_parameters(state).isa, 2);
    for (int i = 0; i < 12; i++) {
        ddof_settings settings = settings_of(i);
        scene s = scene_fill(rng_range(&r, 1, 90), rng_range(&r, 1, 60), COC_ZERO, COLOR_RANDOM, &r);
        float *got = fenced(4 * pixels_of(&s) * sizeof *got, true), *z = fenced(pixels_of(&s) * sizeof *z, true);
        settings.lens = (ddof_lens){.focal_length = 85, .f_number = 1.4, .focus_distance = 3};
        for (size_t p = 0; p < pixels_of(&s); p++)
            z[p] = p % 97 == 96 ? NAN : (float)(0.5 + 20 * rng_unit(&r));
        ddof_frame frame = {.color = ddof_image_interleaved(s.color, s.width, s.height, 4, DDOF_FLOAT, 0),
                            .depth = ddof_image_interleaved(z, s.width, s.height, 1, DDOF_FLOAT, 0),
                            .output = ddof_image_interleaved(s.coc, s.width, s.height, 1, DDOF_FLOAT, 0)};
        write_coc(ctx, &frame, &settings);
        frame.output = ddof_image_interleaved(got, s.width, s.height, 4, DDOF_FLOAT, 0);
        render(ctx, &frame, &settings);
        frame = scene_frame(&s);
        render(ctx, &frame, &settings);
        assert_same_bits(got, s.output, 4 * pixels_of(&s), "%d x %d", s.width, s.height);
        fenced_free(got);
        fenced_free(z);
        scene_free(&s);
    }
    DESTROY(ctx);
}

/* ---- memory, cancelling */

/* Announced to the byte, nothing allocated for a second frame, and no trace of the frames before. */
static void scratch(void **state) {
    rng r = {79};
    allocator a = {0};
    ddof_config config = {.threads = 3,
                          .cpu_mask = test_parameters(state).isa,
                          .allocate = allocator_allocate,
                          .release = allocator_release,
                          .memory_user = &a};
    ddof_context *ctx = NULL;
    assert_int_equal(ddof_create(&ctx, &config), DDOF_OK);
    for (int i = 0; i < 40; i += TEST_STEP) {
        const ddof_settings settings = settings_of(i);
        size_t bytes = 0;
        scene s = scene_of(rng_range(&r, 0, 1000), &r);
        float *want = plain(test_parameters(state).isa, &s, &settings);
        ddof_frame frame = scene_frame(&s);
        if (i % 2) {
            memcpy(s.output, s.color, 4 * pixels_of(&s) * sizeof(float));
            frame.color = frame.output;
        }
        if (i % 5 < 3) ddof_trim(ctx);
        assert_int_equal(ddof_scratch_bytes(ctx, &frame, &settings, &bytes), DDOF_OK);
        const ddof_stats stats = render(ctx, &frame, &settings);
        if (i % 5 < 3) assert_int_equal(stats.scratch_bytes, bytes);
        assert_same_bits(s.output, want, 4 * pixels_of(&s), "call %d, %d x %d", i, s.width, s.height);
        const int calls = a.calls;
        frame = scene_frame(&s);
        if (i % 2 == 0) render(ctx, &frame, &settings);
        if (i % 2 == 0) assert_same_bits(s.output, want, 4 * pixels_of(&s), "again, %d x %d", s.width, s.height);
        assert_int_equal(a.calls, calls);
        fenced_free(want);
        scene_free(&s);
    }
    DESTROY(ctx);
    assert_int_equal(a.live, 0);
}

typedef struct stopper {
    int calls, stop_at;
    double last;
} stopper;

static int stop(void *user, double done) {
    stopper *s = user;
    assert_true(done >= s->last && done <= 1);
    s->last = done;
    return ++s->calls == s->stop_at;
}

static void cancel(void **state) {
    rng r = {80};
    stopper w = {0};
    ddof_config config = {.threads = test_parameters(state).value, .progress = stop, .progress_user = &w};
    ddof_context *ctx = NULL;
    assert_int_equal(ddof_create(&ctx, &config), DDOF_OK);
    scene s = scene_fill(70, 90, COC_RANDOM, COLOR_RANDOM, &r);
    const ddof_settings settings = settings_of(2);
    float *want = plain(0, &s, &settings);
    ddof_frame frame = scene_frame(&s);
    bool finished = false;
    for (int k = 1; !finished; k++) {
        w = (stopper){.stop_at = k};
        const ddof_status status = ddof_render(ctx, &frame, &settings, NULL);
        finished = status == DDOF_OK;
        if (!finished) {
            assert_int_equal(status, DDOF_ERROR_CANCELLED);
            assert_int_equal(w.calls, k);
        }
        w = (stopper){0};
        render(ctx, &frame, &settings);
        assert_true(w.last > 0.9);
        assert_same_bits(s.output, want, 4 * pixels_of(&s), "after a call that was stopped at %d", k);
        assert_true(k < 2000);
    }
    fenced_free(want);
    scene_free(&s);
    DESTROY(ctx);
}

int main(void) {
    static const test tests[] = {
        {"accuracy", accuracy, true, 0, 0},
        {"holes", holes, true, 0, 0},
        {"invariants", invariants, true, 0, 0},
        {"2 threads", threads, true, 2, 0},
        {"7 threads", threads, true, 7, 0},
        {"parallel_for: serial", parallel_for, true, 0, 0},
        {"parallel_for: serial, backwards", parallel_for, true, 1, 0},
        {"parallel_for: threads, backwards", parallel_for, true, 2, 0},
        {"avx2 and avx512 agree", fused, false, 0, DDOF_CPU_AVX512},
        {"arrangement of memory", memory, true, 0, 0},
        {"types", types, true, 0, 0},
        {"depth", depth, true, 0, 0},
        {"scratch", scratch, true, 0, 0},
        {"cancel, 1 thread", cancel, false, 1, 0},
        {"cancel, 4 threads", cancel, false, 4, 0},
    };
    return run_library_tests("disc_engine", tests, COUNT(tests));
}
