/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Layers and holdout under a caller's conditions: what the bits do not depend on, values and sizes that are hard,
 * memory, progress and cancelling. */
#include <pthread.h>

#include "allocator.h"
#include "layout.h"
#include "parallel.h"
#include "support.h"

#include <math.h>
#include <string.h>

static const int sizes[][2] = {{67, 41}, {1, 1}, {1, 23}, {31, 1}, {2, 2}, {17, 3}, {3, 90}, {128, 48}, {300, 20}};

/* ---- pictures */

enum { SCENES = 9 };

typedef struct picture {
    scene s;
    float *mask_values;
    ddof_image mask;
    ddof_settings settings;
    bool straight;
} picture;

/* Noise, ramps, blocks near, in focus and far, those of support.h, some with holes. */
static float coc_of(int map, int x, int y, rng *r) {
    static const float blocks[] = {-30, 0, 12, -4, 0, 40, -9};
    return map == 0 ? (float)(60 * rng_unit(r) - 30) : blocks[(x / 9 + y / 7 * 3) % COUNT(blocks)];
}

/* i chooses size, map, kernel, alpha, holes and mask. */
static picture picture_of(int i, rng *r) {
    const int *size = sizes[i % COUNT(sizes)], map = i / 2 % 7;
    picture p = {.s = scene_fill(size[0], size[1], (coc_pattern)(map + 1), (color_pattern)(i % 3), r)};
    const size_t n = (size_t)size[0] * (size_t)size[1];
    for (size_t k = 0; k < n; k++) {
        if (map < 2) p.s.coc[k] = coc_of(map, (int)k % size[0], (int)k / size[0], r);
        if (i % 4 == 1) p.s.color[4 * k + 3] = 1;
        if (i % 5 == 2 && rng_bits(r) % 40 == 0) *(k % 2 ? &p.s.color[4 * k + 1] : &p.s.coc[k]) = NAN;
    }
    p.mask_values = fenced(n * sizeof(float), true);
    for (size_t k = 0; k < n; k++)
        p.mask_values[k] = k / 7 % 5 == 0 ? (float)(k % 4) / 3 : 0;
    p.mask = ddof_image_interleaved(i % 3 ? NULL : p.mask_values, size[0], size[1], 1, DDOF_FLOAT, 0);
    p.settings = (ddof_settings){.kernel = i / 2 % 2 ? DDOF_KERNEL_DISC : DDOF_KERNEL_HEAT,
                                 .layers = i % 12 ? DDOF_LAYERS_AUTO : DDOF_LAYERS_OFF};
    p.straight = i % 7 == 3;
    return p;
}

static void picture_free(picture *p) {
    scene_free(&p->s);
    fenced_free(p->mask_values);
}

static ddof_frame frame_of(const picture *p) {
    ddof_frame frame = scene_frame(&p->s);
    if (p->mask.plane[0].data) frame.holdout = &p->mask;
    if (p->straight) frame.color.alpha = DDOF_ALPHA_STRAIGHT;
    return frame;
}

static size_t values_of(const picture *p) {
    return 4 * (size_t)p->s.width * (size_t)p->s.height;
}

/* The result with one thread, tight memory, a fresh context. */
static float *plain(unsigned isa, const picture *p) {
    float *want = fenced(values_of(p) * sizeof *want, true);
    ddof_context *ctx = context_of(isa, 1);
    ddof_frame frame = frame_of(p);
    frame.output = ddof_image_interleaved(want, p->s.width, p->s.height, 4, DDOF_FLOAT, 0);
    render(ctx, &frame, &p->settings);
    DESTROY(ctx);
    return want;
}

/* ---- what the bits do not depend on */

static void same_bits(ddof_context *ctx, unsigned isa, int first, int count) {
    rng r = {600};
    for (int i = first; i < first + count; i++) {
        picture p = picture_of(i, &r);
        float *want = plain(isa, &p);
        ddof_frame frame = frame_of(&p);
        render(ctx, &frame, &p.settings);
        assert_same_bits(p.s.output, want, values_of(&p), "picture %d, %d x %d", i, p.s.width, p.s.height);
        fenced_free(want);
        picture_free(&p);
    }
}

/* One context for all: earlier calls of other sizes do not matter either. */
static void threads(void **state) {
    ddof_context *ctx = context_of(test_parameters(state).isa, test_parameters(state).value);
    same_bits(ctx, test_parameters(state).isa, 0, 72);
    DESTROY(ctx);
}

static void parallel_for(void **state) {
    int (*const loops[])(void *, int, ddof_task, void *) = {parallel_serial, parallel_reversed, parallel_threads};
    ddof_config config = {.threads = PARALLEL_THREADS, .parallel_for = loops[test_parameters(state).value]};
    ddof_context *ctx = NULL;
    assert_int_equal(ddof_create(&ctx, &config), DDOF_OK);
    same_bits(ctx, 0, 30, 45);
    DESTROY(ctx);
}

/* Every arrangement of colour, CoC, mask and output; in place; half floats like the floats they stand for. */
static void memory(void **state) {
    rng r = {601};
    ddof_context *ctx = context_of(0, 2);
    (void)state;
    for (int i = 0; i < 8 * LAYOUTS; i++) {
        picture p = picture_of(i, &r);
        const int half = i % 3 == 1 ? 15 : 0, w = p.s.width, h = p.s.height;
        for (size_t k = 0; k < values_of(&p) && half; k++) {
            p.s.color[k] = (float)half_value(half_nearest((double)p.s.color[k]));
            if (k % 4 == 0)
                p.s.coc[k / 4] = (float)half_value(half_nearest(fmin(fmax((double)p.s.coc[k / 4], -6e4), 6e4)));
        }
        stored in = stored_make((layout)(i % LAYOUTS), w, h, 4, (unsigned)half),
               map = stored_make((layout)(i % LAYOUT_PLANAR), w, h, 1, (unsigned)half),
               out = stored_make((layout)(i * 5 % LAYOUTS), w, h, 4, i % 2 ? 15 : 0);
        float *want = plain(0, &p);
        stored_put(&in, p.s.color, 4);
        stored_put(&map, p.s.coc, 1);
        ddof_frame frame = frame_of(&p);
        frame.color = in.image, frame.coc = map.image, frame.output = out.image;
        frame.color.alpha = p.straight ? DDOF_ALPHA_STRAIGHT : DDOF_ALPHA_PREMULTIPLIED;
        render(ctx, &frame, &p.settings);
        stored_get(&out, p.s.output, 4);
        assert_gaps_intact(&out);
        assert_gaps_intact(&in);
        float *rounded = fenced(values_of(&p) * sizeof *rounded, true);
        for (size_t k = 0; k < values_of(&p); k++)
            rounded[k] = i % 2 ? (float)half_value(half_nearest((double)want[k])) : want[k];
        assert_same_bits(p.s.output, rounded, values_of(&p), "picture %d, %d x %d", i, w, h);
        frame.output = frame.color; /* in place */
        render(ctx, &frame, &p.settings);
        stored_get(&in, p.s.output, 4);
        for (size_t k = 0; k < values_of(&p); k++)
            rounded[k] = half ? (float)half_value(half_nearest((double)want[k])) : want[k];
        assert_same_bits(p.s.output, rounded, values_of(&p), "picture %d in place", i);
        assert_gaps_intact(&in);
        stored_free(&in), stored_free(&map), stored_free(&out);
        fenced_free(want), fenced_free(rounded);
        picture_free(&p);
    }
    DESTROY(ctx);
}

/* By way of a depth map, in a window of a larger picture with wide pixels, and by the CoC that ddof_coc() writes for
 * it. */
static void depth(void **state) {
    rng r = {602};
    ddof_context *ctx = context_of(0, 2);
    (void)state;
    for (int i = 0; i < 20; i++) {
        picture p = picture_of(i % 2 ? i : i + 2, &r);
        ddof_settings s = p.settings;
        s.lens = (ddof_lens){.focal_length = 80, .f_number = 1.4, .focus_distance = 3, .sensor_width = 36};
        s.depth.kind = i % 3 ? DDOF_DEPTH_PLANAR : DDOF_DEPTH_RAY;
        for (size_t k = 0; k < values_of(&p) / 4; k++)
            p.s.coc[k] = rng_bits(&r) % 64 == 0 ? (k % 2 ? NAN : 0) : (float)(1.2 + 6 * (double)((k / 11) % 7) / 7);
        ddof_frame frame = frame_of(&p);
        frame.depth = frame.coc;
        frame.coc.channels = 0;
        frame.picture_width = 1000, frame.picture_height = 500, frame.offset_x = 300, frame.offset_y = -20;
        frame.pixel_aspect = i % 4 ? 0 : 2;
        float *coc = fenced(values_of(&p), true), *want = fenced(4 * values_of(&p), true);
        render(ctx, &frame, &s);
        memcpy(want, p.s.output, 4 * values_of(&p));
        frame.output = ddof_image_interleaved(coc, p.s.width, p.s.height, 1, DDOF_FLOAT, 0);
        write_coc(ctx, &frame, &s);
        frame.coc = frame.output;
        frame.depth.channels = 0;
        frame.output = scene_frame(&p.s).output;
        render(ctx, &frame, &s);
        assert_same_bits(p.s.output, want, values_of(&p), "picture %d", i);
        fenced_free(coc), fenced_free(want);
        picture_free(&p);
    }
    DESTROY(ctx);
}

/* ---- hostile values */

static float hostile(int kind, rng *r) {
    const float choice[][4] = {{NAN, INFINITY, -INFINITY, 1}, {1e6f, 0, 0, 0},      {-5, 3, -1e4f, 0},
                               {1e-42f, -1e-40f, 0, 1},       {NAN, NAN, NAN, NAN}, {1e30f, 0, -1e30f, 1}};
    return choice[kind][rng_bits(r) % 4];
}

static float hostile_coc(int kind, rng *r) {
    const float choice[][4] = {{1e5f, -1e5f, 0, 3},           {-1e5f, -1e5f, -3, 1e-42f},
                               {NAN, 5, INFINITY, -INFINITY}, {3e38f, -3e38f, 3e38f, -3e38f},
                               {-1e-42f, 1e-42f, 0, -2.5f},   {-1, -2, 1, 2},
                               {NAN, NAN, NAN, NAN}};
    return choice[kind][rng_bits(r) % 4];
}

static void finite_always(void **state) {
    rng r = {603};
    ddof_config config = {.backend = (ddof_backend)test_parameters(state).value, .threads = 2};
    ddof_context *ctx = NULL;
    assert_int_equal(ddof_create(&ctx, &config), DDOF_OK);
    for (int i = 0; i < 6 * 7 * 4; i++) {
        picture p = picture_of(i * 5 % 63, &r);
        const size_t n = values_of(&p) / 4;
        size_t holes = 0;
        if (!p.straight)
            for (size_t k = 0; k < 4 * n; k++)
                p.s.color[k] = hostile(i % 6, &r);
        for (size_t k = 0; k < n; k++) {
            p.s.coc[k] = hostile_coc(i / 6 % 7, &r);
            const float *c = p.s.color + 4 * k;
            holes += !(isfinite(c[0]) && isfinite(c[1]) && isfinite(c[2]) && isfinite(c[3]) && isfinite(p.s.coc[k]));
            if (i % 4 == 0) p.mask_values[k] = k % 3 ? hostile(i % 6, &r) : 1;
        }
        ddof_frame frame = frame_of(&p);
        assert_int_equal(render(ctx, &frame, &p.settings).nonfinite_pixels, holes);
        for (size_t k = 0; k < 4 * n; k++)
            if (!isfinite(p.s.output[k]))
                fail_msg("picture %d, colour %d, CoC %d, %d x %d: value %zu is %g", i, i % 6, i / 6 % 7, p.s.width,
                         p.s.height, k, (double)p.s.output[k]);
        picture_free(&p);
    }
    DESTROY(ctx);
}

/* |CoC| beyond 1e5 is 1e5, also where it is spread into what a layer lacks. */
static void beyond(void **state) {
    rng r = {604};
    ddof_context *ctx = context_of(0, 2);
    (void)state;
    for (int i = 0; i < 8; i++) {
        scene s = scene_fill(90, 44, COC_ZERO, COLOR_RANDOM, &r);
        ddof_settings settings = {.kernel = i % 2 ? DDOF_KERNEL_DISC : DDOF_KERNEL_HEAT, .layers = DDOF_LAYERS_AUTO};
        const float far = (i & 2 ? -1.0f : 1.0f) * (i & 4 ? 3e38f : 1e7f);
        ddof_frame frame = scene_frame(&s);
        float *want = fenced(90 * 44 * 4 * sizeof *want, true);
        for (int k = 0; k < 90 * 44; k++)
            s.coc[k] = k % 90 < 30 ? far : k % 90 < 50 ? 0 : -6;
        render(ctx, &frame, &settings);
        memcpy(want, s.output, 90 * 44 * 4 * sizeof *want);
        for (int k = 0; k < 90 * 44; k++)
            s.coc[k] = fminf(fmaxf(s.coc[k], -1e5f), 1e5f);
        render(ctx, &frame, &settings);
        assert_same_bits(s.output, want, 90 * 44 * 4, "CoC %g", (double)far);
        fenced_free(want);
        scene_free(&s);
    }
    DESTROY(ctx);
}

/* ---- progress */

typedef struct watcher {
    int calls, stop_at; /* from 1; 0: never */
    double last;
    bool wrong;
} watcher;

static int watch(void *user, double done) {
    watcher *w = user;
    if (!(done >= w->last && done <= 1)) w->wrong = true;
    w->last = done;
    return ++w->calls == w->stop_at;
}

static void cancelling(void **state) {
    const bool reference = test_parameters(state).value == DDOF_BACKEND_REFERENCE;
    rng r = {605};
    for (int i = 0; i < 6; i++) {
        watcher w = {0};
        ddof_config config = {.backend = (ddof_backend)test_parameters(state).value,
                              .threads = 1,
                              .progress = watch,
                              .progress_user = &w};
        ddof_context *ctx = NULL;
        assert_int_equal(ddof_create(&ctx, &config), DDOF_OK);
        picture p = picture_of((int[]){0, 7, 63, 16, 1, 18}[i], &r);
        float *want = plain(0, &p);
        ddof_frame frame = frame_of(&p);
        render(ctx, &frame, &p.settings);
        assert_true(!w.wrong && w.last <= 1 && w.last > 0.99);
        const int calls = w.calls;
        assert_true(calls > 2);
        for (int stop = 1; stop <= calls; stop += reference ? calls / 10 + 1 : 1) { /* the reference is slow */
            ddof_stats stats;
            const ddof_stats zero = {0};
            w = (watcher){.stop_at = stop};
            assert_int_equal(ddof_render(ctx, &frame, &p.settings, &stats), DDOF_ERROR_CANCELLED);
            assert_non_null(strstr(ddof_error(ctx), "cancelled"));
            assert_memory_equal(&stats, &zero, sizeof zero);
            assert_true(!w.wrong && w.calls == stop);
        }
        w = (watcher){0};
        render(ctx, &frame, &p.settings);
        if (!reference) assert_same_bits(p.s.output, want, values_of(&p), "after cancelling, picture %d", i);
        DESTROY(ctx);
        fenced_free(want);
        picture_free(&p);
    }
}

static void loop_refused(void **state) {
    rng r = {606};
    ddof_config config = {.threads = PARALLEL_THREADS, .parallel_for = parallel_refused};
    ddof_context *ctx = NULL;
    picture p = picture_of(9, &r);
    ddof_frame frame = frame_of(&p);
    (void)state;
    assert_int_equal(ddof_create(&ctx, &config), DDOF_OK);
    assert_int_equal(ddof_render(ctx, &frame, &p.settings, NULL), DDOF_ERROR_MEMORY);
    assert_non_null(strstr(ddof_error(ctx), "parallel_for"));
    DESTROY(ctx);
    picture_free(&p);
}

static int by_last_worker(void *user, int count, ddof_task task, void *data) {
    for (int i = 0; i < count; i++)
        task(data, i, *(const int *)user - 1);
    return 0;
}

/* A loop may use all its workers, also where the backend works with one. */
static void last_worker(void **state) {
    rng r = {609};
    int threads = 200;
    ddof_config config = {.backend = (ddof_backend)test_parameters(state).value,
                          .threads = threads,
                          .parallel_for = by_last_worker,
                          .parallel_user = &threads};
    for (int i = 0; i < 30; i += TEST_STEP) {
        ddof_context *ctx = NULL;
        picture p = picture_of(i, &r);
        ddof_frame frame = frame_of(&p);
        assert_int_equal(ddof_create(&ctx, &config), DDOF_OK);
        render(ctx, &frame, &p.settings);
        DESTROY(ctx);
        picture_free(&p);
    }
}

/* ---- memory */

/* ddof_scratch_bytes() tells what is held; a second frame allocates nothing; every allocation may fail; all is given
 * back. A context for each frame: what it holds is what that frame takes. */
static void scratch(void **state) {
    rng r = {607};
    for (int i = 0; i < 40; i += TEST_STEP) {
        allocator a = {0};
        ddof_config config = {.backend = (ddof_backend)test_parameters(state).value,
                              .threads = i % 4 + 1,
                              .allocate = allocator_allocate,
                              .release = allocator_release,
                              .memory_user = &a};
        ddof_context *ctx = NULL;
        picture p = picture_of(i, &r);
        ddof_frame frame = frame_of(&p);
        size_t bytes = 0;
        frame.color.channels = frame.output.channels = p.straight ? 2 : i % 4 + 1;
        assert_int_equal(ddof_create(&ctx, &config), DDOF_OK);
        const size_t bare = a.live_bytes;
        assert_int_equal(ddof_scratch_bytes(ctx, &frame, &p.settings, &bytes), DDOF_OK);
        assert_int_equal(a.live_bytes, bare);
        a.fail_at = a.calls + 1;
        assert_int_equal(ddof_render(ctx, &frame, &p.settings, NULL), DDOF_ERROR_MEMORY);
        assert_non_null(strstr(ddof_error(ctx), "memory"));
        assert_int_equal(render(ctx, &frame, &p.settings).scratch_bytes, bytes);
        assert_int_equal(a.live_bytes, bare + bytes);
        const int calls = a.calls;
        assert_int_equal(render(ctx, &frame, &p.settings).scratch_bytes, bytes);
        assert_int_equal(a.calls, calls);
        DESTROY(ctx);
        assert_true(a.live == 0 && a.live_bytes == 0 && !a.wrong);
        picture_free(&p);
    }
}

/* ---- two contexts at once */

typedef struct worker {
    pthread_t thread;
    ddof_context *ctx;
    ddof_frame frame;
    ddof_settings settings;
    int failed;
} worker;

static void *work(void *data) {
    worker *w = data;
    for (int i = 0; i < 8; i++)
        if (ddof_render(w->ctx, &w->frame, &w->settings, NULL) != DDOF_OK) w->failed++;
    return NULL;
}

static void at_once(void **state) {
    rng r = {608};
    worker w[2];
    picture p[2];
    float *want[2];
    (void)state;
    for (int i = 0; i < 2; i++) {
        p[i] = picture_of(i ? 63 : 7, &r);
        want[i] = plain(0, &p[i]);
        w[i] = (worker){.ctx = context_of(0, 2), .frame = frame_of(&p[i]), .settings = p[i].settings};
    }
    for (int i = 0; i < 2; i++)
        assert_int_equal(pthread_create(&w[i].thread, NULL, work, &w[i]), 0);
    for (int i = 0; i < 2; i++) {
        pthread_join(w[i].thread, NULL);
        assert_int_equal(w[i].failed, 0);
        assert_same_bits(p[i].s.output, want[i], values_of(&p[i]), "context %d", i);
        DESTROY(w[i].ctx);
        fenced_free(want[i]);
        picture_free(&p[i]);
    }
}

int main(void) {
    static const test tests[] = {
        {"1 thread, one context for all", threads, true, 1, 0},
        {"2 threads", threads, true, 2, 0},
        {"3 threads", threads, true, 3, 0},
        {"7 threads", threads, true, 7, 0},
        {"parallel_for: serial", parallel_for, false, 0, 0},
        {"parallel_for: serial, backwards", parallel_for, false, 1, 0},
        {"parallel_for: threads, backwards", parallel_for, false, 2, 0},
        {"arrangement of memory, half floats, in place", memory, false, 0, 0},
        {"by depth and by CoC", depth, false, 0, 0},
        {"finite always", finite_always, false, DDOF_BACKEND_CPU, 0},
        {"finite always, reference", finite_always, false, DDOF_BACKEND_REFERENCE, 0},
        {"CoC beyond 1e5", beyond, false, 0, 0},
        {"progress and cancelling", cancelling, false, DDOF_BACKEND_CPU, 0},
        {"progress and cancelling, reference", cancelling, false, DDOF_BACKEND_REFERENCE, 0},
        {"a loop that cannot run", loop_refused, false, 0, 0},
        {"the last of 200 workers", last_worker, false, DDOF_BACKEND_CPU, 0},
        {"the last of 200 workers, reference", last_worker, false, DDOF_BACKEND_REFERENCE, 0},
        {"scratch", scratch, false, DDOF_BACKEND_CPU, 0},
        {"scratch, reference", scratch, false, DDOF_BACKEND_REFERENCE, 0},
        {"two contexts at once", at_once, false, 0, 0},
    };
    return run_library_tests("layers_bits", tests, COUNT(tests));
}
