/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The caller's allocator: balanced, failing at every call, not needed for a second frame; how much scratch there is. */
#include "allocator.h"
#include "layout.h"
#include "parallel.h"
#include "support.h"

#include <string.h>

/* value of a test: the backend */
static ddof_status make(ddof_context **ctx, allocator *a, void **state, int threads) {
    const ddof_config config = {.backend = (ddof_backend)test_parameters(state).value,
                                .threads = threads,
                                .allocate = allocator_allocate,
                                .release = allocator_release,
                                .memory_user = a};
    return ddof_create(ctx, &config);
}

static void assert_balanced(const allocator *a) {
    assert_int_equal(a->live, 0);
    assert_int_equal(a->live_bytes, 0);
    assert_false(a->wrong);
}

/* A series of frames, each of which may want more memory; half is one of them. */
static ddof_status frame_of(ddof_context *ctx, int i, ddof_stats *stats) {
    static const int sizes[][2] = {{20, 10}, {40, 30}, {64, 64}, {40, 30}, {200, 20}, {20, 200}};
    const ddof_settings settings = {.substeps = i % 2 + 1};
    rng r = {(uint64_t)(90 + i)};
    scene s = scene_fill(sizes[i][0], sizes[i][1], COC_SMOOTH, COLOR_RANDOM, &r);
    ddof_frame frame = scene_frame(&s);
    stored half = stored_make(LAYOUT_TIGHT, s.width, s.height, 4, i == 3 ? 15 : 0);
    frame.output = half.image;
    ddof_status status = ddof_render(ctx, &frame, &settings, stats);
    if (status == DDOF_OK) {
        stored_get(&half, s.output, 4);
        for (int v = 0; v < s.width * s.height * 4; v++)
            assert_true(s.output[v] >= 0 && s.output[v] <= 1);
    }
    stored_free(&half);
    scene_free(&s);
    return status;
}
enum { FRAMES = 6 };

static void balance(void **state) {
    for (int threads = 1; threads < 5; threads++) {
        allocator a = {0};
        ddof_context *ctx = NULL;
        assert_int_equal(make(&ctx, &a, state, threads), DDOF_OK);
        for (int i = 0; i < FRAMES; i++)
            assert_int_equal(frame_of(ctx, i, NULL), DDOF_OK);
        assert_true(a.live > 0 && a.calls > 0);
        DESTROY(ctx);
        assert_balanced(&a);
    }
}

/* The k-th allocation fails, for every k: MEMORY, nothing lost, and after it the same call works. */
static void failing(void **state) {
    bool went_through = false;
    for (int k = 1; !went_through; k++) {
        allocator a = {.fail_at = k};
        ddof_context *ctx = NULL;
        ddof_status status = make(&ctx, &a, state, 3);
        if (status != DDOF_OK) {
            assert_int_equal(status, DDOF_ERROR_MEMORY);
            assert_null(ctx);
            assert_balanced(&a);
            continue;
        }
        went_through = true;
        for (int i = 0; i < FRAMES; i++) {
            ddof_stats stats, zero = {0};
            status = frame_of(ctx, i, &stats);
            if (status == DDOF_OK) continue;
            went_through = false;
            assert_int_equal(status, DDOF_ERROR_MEMORY);
            assert_non_null(strstr(ddof_error(ctx), "memory"));
            assert_memory_equal(&stats, &zero, sizeof zero);
            assert_int_equal(frame_of(ctx, i, NULL), DDOF_OK);
        }
        DESTROY(ctx);
        assert_balanced(&a);
        assert_true(k < 100);
    }
}

/* The second frame of a size allocates nothing, nor does a smaller one; a larger one lets the old memory go. */
static void second_frame(void **state) {
    allocator a = {0};
    ddof_context *ctx = NULL;
    assert_int_equal(make(&ctx, &a, state, 2), DDOF_OK);
    assert_int_equal(frame_of(ctx, 2, NULL), DDOF_OK);
    const int calls = a.calls, live = a.live;
    assert_int_equal(frame_of(ctx, 2, NULL), DDOF_OK);
    assert_int_equal(frame_of(ctx, 0, NULL), DDOF_OK);
    assert_int_equal(frame_of(ctx, 1, NULL), DDOF_OK);
    assert_int_equal(a.calls, calls);
    assert_int_equal(frame_of(ctx, 4, NULL), DDOF_OK);
    assert_int_equal(frame_of(ctx, 5, NULL), DDOF_OK);
    assert_int_equal(a.live, live);
    DESTROY(ctx);
    assert_balanced(&a);
}

static void trim(void **state) {
    allocator a = {0};
    ddof_context *ctx = NULL;
    ddof_stats stats;
    assert_int_equal(make(&ctx, &a, state, 2), DDOF_OK);
    const size_t bare = a.live_bytes;
    assert_int_equal(ddof_trim(ctx), DDOF_OK);
    assert_int_equal(frame_of(ctx, 2, &stats), DDOF_OK);
    assert_true(a.live_bytes >= bare + stats.scratch_bytes);
    assert_int_equal(ddof_trim(ctx), DDOF_OK);
    assert_int_equal(a.live_bytes, bare);
    assert_int_equal(ddof_trim(ctx), DDOF_OK);
    assert_int_equal(frame_of(ctx, 0, NULL), DDOF_OK);
    DESTROY(ctx);
    assert_balanced(&a);
}

/* ---- how much */

/* ddof_scratch_bytes() tells what a fresh context will hold, for any frame; the result does not read the pictures. */
static void announced(void **state) {
    rng r = {95};
    for (int i = 0; i < 60; i++) {
        const int channels = rng_range(&r, 1, 4),
                  arrangement = rng_range(&r, 0, channels == 1 ? LAYOUT_REVERSED : LAYOUTS - 1);
        ddof_settings settings = {.substeps = i % 3, .lens = {.focal_length = 50, .f_number = 2, .focus_distance = 3}};
        scene s = scene_fill(rng_range(&r, 1, 300), rng_range(&r, 1, 100), COC_SMALL, COLOR_RANDOM, &r);
        stored in = stored_make((layout)arrangement, s.width, s.height, channels, rng_bits(&r) & 15);
        stored out = stored_make((layout)arrangement, s.width, s.height, channels, i % 2 ? rng_bits(&r) & 15 : 0);
        stored_put(&in, s.color, 4);
        allocator a = {0};
        ddof_context *ctx = NULL;
        size_t bytes = 0;
        assert_int_equal(make(&ctx, &a, state, 1 + i % 4), DDOF_OK);
        const size_t bare = a.live_bytes;
        ddof_frame frame = scene_frame(&s);
        frame.color = in.image;
        frame.output = out.image;
        if (i % 4 == 3) {
            frame.depth = frame.coc;
            frame.coc.channels = 0;
            settings.lens.focus = i % 8 == 3 ? DDOF_FOCUS_PIXEL : DDOF_FOCUS_DISTANCE;
            s.coc[0] = 3;
        }
        assert_int_equal(ddof_scratch_bytes(ctx, &frame, &settings, &bytes), DDOF_OK);
        assert_int_equal(a.live_bytes, bare);
        assert_int_equal(render(ctx, &frame, &settings).scratch_bytes, bytes);
        assert_int_equal(a.live_bytes, bare + bytes);
        DESTROY(ctx);
        stored_free(&in);
        stored_free(&out);
        scene_free(&s);
    }
}

/* Large pictures of RGBA float: 4 bytes a pixel and, for each thread, a block of rows: as many as a vector has lanes
 * (16 at most) at 12 floats a pixel, 768 bytes a column. */
static void modest(void **state) {
    static const int sizes[][2] = {{1920, 1080}, {3840, 2160},  {4099, 2999},
                                   {8192, 8192}, {16384, 1000}, {100, 100000}};
    for (int i = 0; i < COUNT(sizes) * 4; i++) {
        const int threads = (int[]){1, 2, 8, 32}[i % 4];
        const size_t width = (size_t)sizes[i / 4][0], height = (size_t)sizes[i / 4][1];
        ddof_context *ctx = context_of(test_parameters(state).isa, threads);
        ddof_settings settings = {0};
        size_t bytes;
        void *nowhere[] = {(void *)(uintptr_t)0x10000000, (void *)(uintptr_t)0x1000000}; /* not read */
        ddof_frame frame = {.color = ddof_image_interleaved(nowhere[0], (int)width, (int)height, 4, DDOF_FLOAT, 0),
                            .coc = ddof_image_interleaved(nowhere[1], (int)width, (int)height, 1, DDOF_FLOAT, 4)};
        frame.output = frame.color;
        assert_int_equal(ddof_scratch_bytes(ctx, &frame, &settings, &bytes), DDOF_OK);
        const size_t pixels = (width + 15) * height * 4, rows = (width + 64) * (64 + 768 * (size_t)threads);
        if (bytes > pixels + rows + height + 65536 * (size_t)threads)
            fail_msg("%zu x %zu, %d threads: %zu bytes, %.2f a pixel", width, height, threads, bytes,
                     (double)bytes / (double)(width * height));
        DESTROY(ctx);
    }
}

int main(void) {
    static const test tests[] = {
        {"balanced, CPU", balance, false, DDOF_BACKEND_CPU, 0},
        {"balanced, reference", balance, false, DDOF_BACKEND_REFERENCE, 0},
        {"every allocation fails once, CPU", failing, false, DDOF_BACKEND_CPU, 0},
        {"every allocation fails once, reference", failing, false, DDOF_BACKEND_REFERENCE, 0},
        {"a second frame, CPU", second_frame, false, DDOF_BACKEND_CPU, 0},
        {"a second frame, reference", second_frame, false, DDOF_BACKEND_REFERENCE, 0},
        {"ddof_trim, CPU", trim, false, DDOF_BACKEND_CPU, 0},
        {"ddof_trim, reference", trim, false, DDOF_BACKEND_REFERENCE, 0},
        {"announced scratch, CPU", announced, false, DDOF_BACKEND_CPU, 0},
        {"announced scratch, reference", announced, false, DDOF_BACKEND_REFERENCE, 0},
        {"4 bytes a pixel", modest, true, 0, 0},
    };
    return run_library_tests("memory", tests, COUNT(tests));
}
