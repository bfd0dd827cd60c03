/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* What the bits of a result do not depend on: threads, parallel_for, the arrangement of memory, in place or not,
 * earlier calls on the context, and which of two instruction sets with fused multiply-add computed them. */
#include "layout.h"
#include "parallel.h"
#include "support.h"

#include <math.h>
#include <string.h>

static const int sizes[][2] = {{1, 1},   {64, 64},  {97, 53}, {130, 33}, {300, 3},
                               {5, 300}, {192, 31}, {17, 16}, {65, 128}};

static ddof_settings settings_of(int i) {
    return (ddof_settings){.conductance = (ddof_conductance)(i % 2), .substeps = i % 3};
}

/* A scene with some holes in every third one, among them a whole row. */
static scene scene_of(int i, rng *r) {
    const int *size = sizes[i % COUNT(sizes)];
    scene s = scene_fill(size[0], size[1], (coc_pattern)(i % COC_PATTERNS), COLOR_RANDOM, r);
    for (int k = 1; k < s.width * s.height && i % 3 == 2; k++)
        if (rng_bits(r) % 50 == 0 || k / s.width == 2) *(k % 2 ? &s.color[4 * k + 1] : &s.coc[k]) = NAN;
    return s;
}

static size_t values_of(const scene *s) {
    return (size_t)s->width * (size_t)s->height * 4;
}

/* The result with one thread, tight memory, a fresh context. */
static float *plain(unsigned isa, const scene *s, const ddof_settings *settings) {
    float *want = fenced(values_of(s) * sizeof *want, true);
    ddof_context *ctx = context_of(isa, 1);
    ddof_frame frame = scene_frame(s);
    frame.output = ddof_image_interleaved(want, s->width, s->height, 4, DDOF_FLOAT, 0);
    render(ctx, &frame, settings);
    DESTROY(ctx);
    return want;
}

static void threads(void **state) {
    const int count = test_parameters(state).value;
    rng r = {30};
    ddof_context *ctx = context_of(test_parameters(state).isa, count);
    for (int i = 0; i < 36; i += TEST_STEP) {
        const ddof_settings settings = settings_of(i);
        scene s = scene_of(i, &r);
        float *want = plain(test_parameters(state).isa, &s, &settings);
        ddof_frame frame = scene_frame(&s);
        assert_int_equal(render(ctx, &frame, &settings).threads, count);
        assert_same_bits(s.output, want, values_of(&s), "%d threads, %d x %d", count, s.width, s.height);
        fenced_free(want);
        scene_free(&s);
    }
    DESTROY(ctx);
}

static void parallel_for(void **state) {
    int (*const loops[])(void *, int, ddof_task, void *) = {parallel_serial, parallel_reversed, parallel_threads};
    rng r = {31};
    ddof_config config = {.cpu_mask = test_parameters(state).isa,
                          .threads = PARALLEL_THREADS,
                          .parallel_for = loops[test_parameters(state).value]};
    ddof_context *ctx = NULL;
    assert_int_equal(ddof_create(&ctx, &config), DDOF_OK);
    for (int i = 0; i < 36; i += TEST_STEP) {
        const ddof_settings settings = settings_of(i);
        scene s = scene_of(i, &r);
        float *want = plain(test_parameters(state).isa, &s, &settings);
        ddof_frame frame = scene_frame(&s);
        render(ctx, &frame, &settings);
        assert_same_bits(s.output, want, values_of(&s), "%d x %d", s.width, s.height);
        fenced_free(want);
        scene_free(&s);
    }
    DESTROY(ctx);
}

/* ---- memory */

/* Renders with the three images arranged as told; in place where output < 0. */
static void render_arranged(ddof_context *ctx, const scene *s, const ddof_settings *settings, int color, int coc,
                            int output) {
    stored in = stored_make((layout)color, s->width, s->height, 4, 0);
    stored map = stored_make((layout)coc, s->width, s->height, 1, 0);
    stored out = {0};
    if (output >= 0) out = stored_make((layout)output, s->width, s->height, 4, 0);
    stored_put(&in, s->color, 4);
    stored_put(&map, s->coc, 1);
    ddof_frame frame = {.color = in.image, .coc = map.image, .output = output >= 0 ? out.image : in.image};
    render(ctx, &frame, settings);
    if (output >= 0) assert_gaps_intact(&out);
    assert_gaps_intact(&in);
    assert_gaps_intact(&map);
    stored_get(output >= 0 ? &out : &in, s->output, 4);
    stored_free(&in);
    stored_free(&map);
    if (output >= 0) stored_free(&out);
}

/* Every arrangement of the colour with every one of the output; -1: in place. */
static void memory(void **state) {
    rng r = {32};
    ddof_context *ctx = context_of(test_parameters(state).isa, 2);
    for (int i = 0; i < 9; i += TEST_STEP) {
        const ddof_settings settings = settings_of(i);
        scene s = scene_of(i, &r);
        float *want = plain(test_parameters(state).isa, &s, &settings);
        for (int color = 0; color < LAYOUTS; color++)
            for (int output = -1; output < LAYOUTS; output++) {
                int coc = (color + output + 1) % LAYOUT_PLANAR;
                render_arranged(ctx, &s, &settings, color, coc, output);
                assert_same_bits(s.output, want, values_of(&s), "%d x %d, colour %d, CoC %d, output %d", s.width,
                                 s.height, color, coc, output);
            }
        fenced_free(want);
        scene_free(&s);
    }
    DESTROY(ctx);
}

/* One to four channels of either type, alpha of either kind, any arrangement: the same in place and not. */
static void in_place(void **state) {
    rng r = {33};
    ddof_context *ctx = context_of(test_parameters(state).isa, 2);
    for (int i = 0; i < 96; i += TEST_STEP) {
        const int channels = i % 4 + 1, arrangement = rng_range(&r, 0, LAYOUTS - 1);
        const ddof_settings settings = settings_of(i);
        scene s = scene_of(i, &r);
        const unsigned half = i / 4 % 2 ? 15 : i / 8 % 3 == 0 ? rng_bits(&r) & 15 : 0;
        if (channels == 1 && arrangement == LAYOUT_LAST_APART) continue;
        stored in = stored_make((layout)arrangement, s.width, s.height, channels, half);
        stored out = stored_make((layout)rng_range(&r, 0, LAYOUT_REVERSED), s.width, s.height, channels, half);
        stored_put(&in, s.color, 4);
        ddof_frame frame = scene_frame(&s);
        frame.color = in.image;
        frame.output = out.image;
        if (channels % 2 == 0 && i / 48) frame.color.alpha = DDOF_ALPHA_STRAIGHT;
        render(ctx, &frame, &settings);
        memset(s.output, 0, values_of(&s) * sizeof(float));
        stored_get(&out, s.output, 4);
        frame.output = frame.color;
        render(ctx, &frame, &settings);
        memset(s.color, 0, values_of(&s) * sizeof(float));
        stored_get(&in, s.color, 4);
        assert_same_bits(s.color, s.output, values_of(&s), "%d x %d, %d channels, half %x, arrangement %d", s.width,
                         s.height, channels, half, arrangement);
        assert_gaps_intact(&in);
        stored_free(&in);
        stored_free(&out);
        scene_free(&s);
    }
    DESTROY(ctx);
}

/* ---- history, instruction sets */

static void history(void **state) {
    rng r = {34};
    ddof_context *ctx = context_of(test_parameters(state).isa, 3);
    for (int i = 0; i < 60; i += TEST_STEP) {
        const int k = rng_range(&r, 0, 1000);
        const ddof_settings settings = settings_of(k);
        scene s = scene_of(k, &r);
        float *want = plain(test_parameters(state).isa, &s, &settings);
        ddof_frame frame = scene_frame(&s);
        if (i % 7 == 6) assert_int_equal(ddof_trim(ctx), DDOF_OK);
        render(ctx, &frame, &settings);
        assert_same_bits(s.output, want, values_of(&s), "call %d, %d x %d", i, s.width, s.height);
        fenced_free(want);
        scene_free(&s);
    }
    DESTROY(ctx);
}

/* AVX2 against AVX-512: both fuse. */
static void fused(void **state) {
    rng r = {35};
    ddof_context *wide = context_of(test_parameters(state).isa, 2);
    for (int i = 0; i < 200; i += TEST_STEP) {
        const ddof_settings settings = settings_of(i);
        scene s = i < 30 ? scene_of(i, &r)
                         : scene_fill(rng_range(&r, 1, 200), rng_range(&r, 1, 100), (coc_pattern)(i % COC_PATTERNS),
                                      (color_pattern)(i / 2 % COLOR_PATTERNS), &r);
        float *want = plain(DDOF_CPU_AVX2, &s, &settings);
        ddof_frame frame = scene_frame(&s);
        ddof_stats stats = render(wide, &frame, &settings);
        assert_string_equal(stats.device, "avx512");
        assert_same_bits(s.output, want, values_of(&s), "%d x %d", s.width, s.height);
        fenced_free(want);
        scene_free(&s);
    }
    DESTROY(wide);
}

int main(void) {
    static const test tests[] = {
        {"2 threads", threads, true, 2, 0},
        {"3 threads", threads, true, 3, 0},
        {"7 threads", threads, true, 7, 0},
        {"parallel_for: serial", parallel_for, true, 0, 0},
        {"parallel_for: serial, backwards", parallel_for, true, 1, 0},
        {"parallel_for: threads, backwards", parallel_for, true, 2, 0},
        {"arrangement of memory", memory, true, 0, 0},
        {"in place", in_place, true, 0, 0},
        {"earlier calls", history, true, 0, 0},
        {"avx2 and avx512 agree", fused, false, 0, DDOF_CPU_AVX512},
    };
    return run_library_tests("bits", tests, COUNT(tests));
}
