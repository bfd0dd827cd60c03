/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Sprites under a caller's conditions: what the bits do not depend on, values and sizes that are hard, memory, progress and
 * cancelling. */
#include <pthread.h>

#include "allocator.h"
#include "layout.h"
#include "parallel.h"
#include "support.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- pictures */

typedef struct picture {
    scene s;
    ddof_settings settings;
    double aspect;
    bool straight;
} picture;

static float lens_image[5 * 8];

static ddof_iris iris_of(int i) {
    const ddof_iris irises[] = {
        {0},
        {.shape = DDOF_IRIS_POLYGON, .blades = 5 + i % 4, .rotation = 11 * i, .curvature = 0.3},
        {.shape = DDOF_IRIS_IMAGE, .rotation = 40, .image = ddof_image_interleaved(lens_image, 5, 8, 1, DDOF_FLOAT, 0)},
        {.cats_eye = 0.8, .edge = 0.5},
        {.fringe = 0.3, .squeeze = 2},
    };
    for (int k = 0; k < COUNT(lens_image); k++) lens_image[k] = (float)(k * 3 % 5);
    return irises[i % COUNT(irises)];
}

/* Blocks near, in focus and far, with lights; i chooses size, iris, levels, kernel, layers, alpha, holes. full: no diffusion.
 * Making an iris takes longer than any of these pictures, so that four have the same. */
static picture picture_of(int i, bool full, rng *r) {
    static const int sizes[][2] = {{67, 41}, {1, 1}, {1, 7}, {7, 1}, {2, 2}, {33, 17}, {130, 40}, {3, 90}};
    static const float blocks[] = {-30, 0, 12, -4, 0, 40, -9, 3, -66, 90};
    const int *size = sizes[i % COUNT(sizes)];
    picture p = {.s = scene_make(size[0], size[1], i % 2), .straight = i % 7 == 3, .aspect = i / 4 == 3 ? 2 : 0};
    for (int k = 0; k < size[0] * size[1]; k++) {
        const bool light = rng_bits(r) % 12 == 0;
        p.s.coc[k] = blocks[(k % size[0] / 11 + k / size[0] / 9 * 3 + i) % COUNT(blocks)] + (float)rng_unit(r);
        for (int c = 0; c < 4; c++) p.s.color[4 * k + c] = (float)rng_unit(r) * (light && c < 3 ? 40 : 1);
        if (i % 5 == 2 && rng_bits(r) % 40 == 0) *(k % 2 ? &p.s.color[4 * k + 1] : &p.s.coc[k]) = NAN;
    }
    p.settings = (ddof_settings){.kernel = i / 2 % 3 == 2 && !full ? DDOF_KERNEL_DISC : DDOF_KERNEL_HEAT,
                                 .layers = i % 9 == 4 && !full ? DDOF_LAYERS_AUTO : DDOF_LAYERS_OFF,
                                 .bokeh = full ? DDOF_BOKEH_FULL : DDOF_BOKEH_HIGHLIGHTS,
                                 .sprites = {.limit = i % 3 ? 1 : 0, .resolution = (ddof_resolution)(i / 3 % 3), .max_sprites = i % 4 == 1 ? 9 : 0},
                                 .iris = iris_of(i / 4)};
    return p;
}

static ddof_frame frame_of(const picture *p) {
    ddof_frame frame = scene_frame(&p->s);
    frame.pixel_aspect = p->aspect;
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

enum { PICTURES = 20 };

/* One context for all: neither do earlier calls with other sizes and irises matter, nor what ddof_trim() frees between them.
 * What is wanted comes from contexts of their own, once for all tests of an instruction set. */
static void same_bits(ddof_context *ctx, unsigned isa, bool full) {
    static float *kept[16][2][PICTURES];
    for (int i = 0; i < PICTURES; i++) {
        rng r = {(uint64_t)(740 + i)};
        picture p = picture_of(i, full, &r);
        float **want = &kept[isa][full][i];
        if (!*want) {
            float *first = plain(isa, &p);
            *want = malloc(values_of(&p) * sizeof **want);
            assert_non_null(*want);
            memcpy(*want, first, values_of(&p) * sizeof **want);
            fenced_free(first);
        }
        ddof_frame frame = frame_of(&p);
        render(ctx, &frame, &p.settings);
        assert_same_bits(p.s.output, *want, values_of(&p), "picture %d, %d x %d", i, p.s.width, p.s.height);
        if (i % 10 == 4) assert_int_equal(ddof_trim(ctx), DDOF_OK);
        scene_free(&p.s);
    }
}

static void threads(void **state) {
    for (int full = 0; full < 2; full++) {
        ddof_context *ctx = context_of(test_parameters(state).isa, test_parameters(state).value);
        same_bits(ctx, test_parameters(state).isa, full);
        DESTROY(ctx);
    }
}

static void parallel_for(void **state) {
    int (*const loops[])(void *, int, ddof_task, void *) = {parallel_serial, parallel_reversed, parallel_threads};
    for (int full = 0; full < 2; full++) {
        ddof_config config = {.threads = PARALLEL_THREADS, .parallel_for = loops[test_parameters(state).value]};
        ddof_context *ctx = NULL;
        assert_int_equal(ddof_create(&ctx, &config), DDOF_OK);
        same_bits(ctx, 0, full);
        DESTROY(ctx);
    }
}

/* Nothing fuses in sprites: without diffusion all instruction sets agree. */
static void instruction_sets(void **state) {
    ddof_context *base = context_of(DDOF_CPU_BASELINE, 1), *other = context_of(test_parameters(state).isa, 1);
    rng r = {741};
    for (int i = 0; i < PICTURES; i++) {
        picture p = picture_of(i, true, &r);
        for (size_t k = 0; k < values_of(&p); k++) { /* holes are filled by other kernels */
            if (isnan(p.s.color[k])) p.s.color[k] = 1;
            if (isnan(p.s.coc[k / 4])) p.s.coc[k / 4] = 1;
        }
        ddof_frame frame = frame_of(&p);
        float *want = fenced(values_of(&p) * sizeof *want, true);
        render(base, &frame, &p.settings);
        memcpy(want, p.s.output, values_of(&p) * sizeof *want);
        render(other, &frame, &p.settings);
        assert_same_bits(p.s.output, want, values_of(&p), "picture %d", i);
        fenced_free(want);
        scene_free(&p.s);
    }
    DESTROY(base);
    DESTROY(other);
}

/* Every arrangement of colour, CoC and output; in place; half floats like the floats they stand for. */
static void memory(void **state) {
    rng r = {742};
    ddof_context *ctx = context_of(0, 2);
    for (int i = 0; i < 2 * LAYOUTS; i++) {
        picture p = picture_of(i % PICTURES, test_parameters(state).value, &r);
        const int half = i % 3 == 1 ? 15 : 0, w = p.s.width, h = p.s.height;
        for (size_t k = 0; k < values_of(&p) && half; k++) {
            p.s.color[k] = (float)half_value(half_nearest((double)p.s.color[k]));
            if (k % 4 == 0) p.s.coc[k / 4] = (float)half_value(half_nearest((double)p.s.coc[k / 4]));
        }
        stored in = stored_make((layout)(i % LAYOUTS), w, h, 4, (unsigned)half),
               map = stored_make((layout)(i % LAYOUT_PLANAR), w, h, 1, (unsigned)half),
               out = stored_make((layout)(i * 5 % LAYOUTS), w, h, 4, i % 2 ? 15 : 0);
        float *want = plain(0, &p), *rounded = fenced(values_of(&p) * sizeof *rounded, true);
        stored_put(&in, p.s.color, 4);
        stored_put(&map, p.s.coc, 1);
        ddof_frame frame = frame_of(&p);
        frame.color = in.image, frame.coc = map.image, frame.output = out.image;
        frame.color.alpha = p.straight ? DDOF_ALPHA_STRAIGHT : DDOF_ALPHA_PREMULTIPLIED;
        render(ctx, &frame, &p.settings);
        stored_get(&out, p.s.output, 4);
        assert_gaps_intact(&out);
        assert_gaps_intact(&in);
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
        scene_free(&p.s);
    }
    DESTROY(ctx);
}

/* The same by a depth map, in a window of a larger picture, as by the CoC that ddof_coc() writes for it. */
static void depth(void **state) {
    rng r = {743};
    ddof_context *ctx = context_of(0, 2);
    (void)state;
    for (int i = 0; i < 16; i++) {
        picture p = picture_of(i * 3, i % 2, &r);
        ddof_settings s = p.settings;
        s.lens = (ddof_lens){.focal_length = 80, .f_number = 1.4, .focus_distance = 3};
        for (size_t k = 0; k < values_of(&p) / 4; k++) p.s.coc[k] = (float)(1.2 + 6 * (double)(k / 11 % 7) / 7);
        ddof_frame frame = frame_of(&p);
        frame.depth = frame.coc;
        frame.coc.channels = 0;
        frame.picture_width = 1000, frame.picture_height = 500, frame.offset_x = 300, frame.offset_y = -20;
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
        scene_free(&p.s);
    }
    DESTROY(ctx);
}

/* ---- hostile values */

static void finite_always(void **state) {
    static const float colors[][4] = {{NAN, INFINITY, -INFINITY, 30}, {1e30f, 0, 5, -1e30f}, {1e-42f, 2, 40, 3}, {NAN, NAN, NAN, NAN}};
    static const float cocs[][4] = {{1e5f, -1e5f, 9, 3}, {NAN, 5, INFINITY, -INFINITY}, {3e38f, -3e38f, 1e-42f, -70}, {NAN, NAN, NAN, NAN}};
    rng r = {744};
    ddof_config config = {.backend = (ddof_backend)test_parameters(state).value, .threads = 2};
    ddof_context *ctx = NULL;
    assert_int_equal(ddof_create(&ctx, &config), DDOF_OK);
    for (int i = 0; i < 80; i++) {
        picture p = picture_of(i % PICTURES, i / 20 % 2, &r);
        int64_t holes = 0;
        p.straight = false;
        for (size_t k = 0; k < values_of(&p) / 4; k++) {
            float *c = p.s.color + 4 * k;
            for (int n = 0; n < 4; n++) c[n] = rng_bits(&r) % 3 ? c[n] : colors[i % 4][rng_bits(&r) % 4];
            p.s.coc[k] = rng_bits(&r) % 2 ? p.s.coc[k] : cocs[i / 4 % 4][rng_bits(&r) % 4];
            holes += !(isfinite(c[0]) && isfinite(c[1]) && isfinite(c[2]) && isfinite(c[3]) && isfinite(p.s.coc[k]));
        }
        ddof_frame frame = frame_of(&p);
        assert_int_equal(render(ctx, &frame, &p.settings).nonfinite_pixels, holes);
        for (size_t k = 0; k < values_of(&p); k++)
            if (!isfinite(p.s.output[k]))
                fail_msg("picture %d, %d x %d: value %zu is %g", i, p.s.width, p.s.height, k, (double)p.s.output[k]);
        scene_free(&p.s);
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
    rng r = {745};
    for (int i = 0; i < 6; i++) {
        watcher w = {0};
        ddof_config config = {.backend = (ddof_backend)test_parameters(state).value, .threads = 1, .progress = watch, .progress_user = &w};
        ddof_context *ctx = NULL;
        assert_int_equal(ddof_create(&ctx, &config), DDOF_OK);
        picture p = picture_of((int[]){0, 13, 22, 8, 6, 14}[i], i % 2, &r);
        ddof_frame frame = frame_of(&p);
        render(ctx, &frame, &p.settings);
        assert_true(!w.wrong && w.calls > 2);
        float *want = fenced(values_of(&p) * sizeof *want, true);
        memcpy(want, p.s.output, values_of(&p) * sizeof *want);
        const int calls = w.calls;
        for (int stop = 1; stop <= calls; stop += calls / 60 + 1) {
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
        assert_same_bits(p.s.output, want, values_of(&p), "after cancelling, picture %d", i);
        DESTROY(ctx);
        fenced_free(want);
        scene_free(&p.s);
    }
}

static void loop_refused(void **state) {
    rng r = {746};
    ddof_config config = {.threads = PARALLEL_THREADS, .parallel_for = parallel_refused};
    (void)state;
    for (int i = 0; i < 4; i++) {
        ddof_context *ctx = NULL;
        picture p = picture_of(i, i % 2, &r);
        ddof_frame frame = frame_of(&p);
        assert_int_equal(ddof_create(&ctx, &config), DDOF_OK);
        assert_int_equal(ddof_render(ctx, &frame, &p.settings, NULL), DDOF_ERROR_MEMORY);
        assert_non_null(strstr(ddof_error(ctx), "parallel_for"));
        DESTROY(ctx);
        scene_free(&p.s);
    }
}

/* ---- memory */

/* ddof_scratch_bytes() tells what is held; a second frame allocates nothing; every allocation may fail; all is given back, by
 * ddof_trim() already. */
static void scratch(void **state) {
    rng r = {747};
    for (int i = 0; i < PICTURES; i++) {
        allocator a = {0};
        ddof_config config = {.backend = (ddof_backend)test_parameters(state).value, .threads = i % 4 + 1, .allocate = allocator_allocate,
                              .release = allocator_release, .memory_user = &a};
        ddof_context *ctx = NULL;
        picture p = picture_of(i, i / 2 % 2, &r);
        ddof_frame frame = frame_of(&p);
        size_t bytes = 0;
        frame.color.channels = frame.output.channels = p.straight ? 2 : i % 4 + 1;
        assert_int_equal(ddof_create(&ctx, &config), DDOF_OK);
        const size_t bare = a.live_bytes;
        assert_int_equal(ddof_scratch_bytes(ctx, &frame, &p.settings, &bytes), DDOF_OK);
        assert_int_equal(a.live_bytes, bare);
        for (int k = 1; k <= 2; k++) { /* the iris, the scratch */
            a.fail_at = a.calls + k;
            assert_int_equal(ddof_render(ctx, &frame, &p.settings, NULL), DDOF_ERROR_MEMORY);
            assert_non_null(strstr(ddof_error(ctx), "memory"));
            assert_int_equal(ddof_trim(ctx), DDOF_OK);
            assert_int_equal(a.live_bytes, bare);
        }
        assert_int_equal(render(ctx, &frame, &p.settings).scratch_bytes, bytes);
        assert_int_equal(a.live_bytes, bare + bytes);
        const int calls = a.calls;
        assert_int_equal(render(ctx, &frame, &p.settings).scratch_bytes, bytes);
        assert_int_equal(a.calls, calls);
        assert_int_equal(ddof_trim(ctx), DDOF_OK);
        assert_int_equal(a.live_bytes, bare);
        DESTROY(ctx);
        assert_true(a.live == 0 && a.live_bytes == 0 && !a.wrong);
        scene_free(&p.s);
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
    for (int i = 0; i < 6; i++)
        if (ddof_render(w->ctx, &w->frame, &w->settings, NULL) != DDOF_OK) w->failed++;
    return NULL;
}

static void at_once(void **state) {
    rng r = {748};
    worker w[3];
    picture p[COUNT(w)];
    float *want[COUNT(w)];
    (void)state;
    for (int i = 0; i < COUNT(w); i++) {
        p[i] = picture_of((int[]){14, 5, 22}[i], i == 1, &r);
        want[i] = plain(0, &p[i]);
        w[i] = (worker){.ctx = context_of(0, 2), .frame = frame_of(&p[i]), .settings = p[i].settings};
    }
    for (int i = 0; i < COUNT(w); i++) assert_int_equal(pthread_create(&w[i].thread, NULL, work, &w[i]), 0);
    for (int i = 0; i < COUNT(w); i++) {
        pthread_join(w[i].thread, NULL);
        assert_int_equal(w[i].failed, 0);
        assert_same_bits(p[i].s.output, want[i], values_of(&p[i]), "context %d", i);
        DESTROY(w[i].ctx);
        fenced_free(want[i]);
        scene_free(&p[i].s);
    }
}

int main(void) {
    static const test tests[] = {
        {"1 thread, one context for all", threads, true, 1, 0},
        {"2 threads", threads, false, 2, 0},
        {"3 threads", threads, true, 3, 0},
        {"7 threads", threads, false, 7, 0},
        {"parallel_for: serial", parallel_for, false, 0, 0},
        {"parallel_for: serial, backwards", parallel_for, false, 1, 0},
        {"parallel_for: threads, backwards", parallel_for, false, 2, 0},
        {"instruction sets", instruction_sets, true, 0, 0},
        {"arrangement of memory, half floats, in place: highlights", memory, false, 0, 0},
        {"arrangement of memory, half floats, in place: every pixel", memory, false, 1, 0},
        {"by depth and by CoC", depth, false, 0, 0},
        {"finite always", finite_always, false, DDOF_BACKEND_CPU, 0},
        {"finite always, reference", finite_always, false, DDOF_BACKEND_REFERENCE, 0},
        {"progress and cancelling", cancelling, false, DDOF_BACKEND_CPU, 0},
        {"progress and cancelling, reference", cancelling, false, DDOF_BACKEND_REFERENCE, 0},
        {"a loop that cannot run", loop_refused, false, 0, 0},
        {"scratch", scratch, false, DDOF_BACKEND_CPU, 0},
        {"scratch, reference", scratch, false, DDOF_BACKEND_REFERENCE, 0},
        {"contexts at once", at_once, false, 0, 0},
    };
    return run_library_tests("bokeh_bits", tests, COUNT(tests));
}
