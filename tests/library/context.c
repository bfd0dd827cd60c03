/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* One call at a time, progress and cancelling, logging, loops that fail, threads beyond the work, contexts side by
 * side. */
#include "allocator.h"
#include "parallel.h"
#include "support.h"

#include <math.h>
#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>

static ddof_context *context_with(const ddof_config *config) {
    ddof_context *ctx = NULL;
    assert_int_equal(ddof_create(&ctx, config), DDOF_OK);
    return ctx;
}

static size_t values_of(const scene *s) {
    return (size_t)s->width * (size_t)s->height * 4;
}

/* ---- what there is */

static void names(void **state) {
    (void)state;
    char version[32];
    snprintf(version, sizeof version, "%d.%d.%d", DDOF_VERSION_MAJOR, DDOF_VERSION_MINOR, DDOF_VERSION_PATCH);
    assert_string_equal(version, DDOF_VERSION_STRING);
    assert_string_equal(ddof_version(), DDOF_VERSION_STRING);
    for (int i = DDOF_OK; i <= DDOF_ERROR_DEVICE; i++) {
        assert_true(ddof_status_text((ddof_status)i)[0] != 0);
        for (int k = DDOF_OK; k < i; k++)
            assert_string_not_equal(ddof_status_text((ddof_status)i), ddof_status_text((ddof_status)k));
    }
    assert_non_null(ddof_status_text((ddof_status)99));
    assert_non_null(ddof_status_text((ddof_status)-1));
    assert_true(ddof_cpu_available() & DDOF_CPU_BASELINE);
}

static const char *device_of(const ddof_config *config) {
    static char name[64];
    rng r = {100};
    ddof_context *ctx = context_with(config);
    scene s = scene_fill(3, 3, COC_SMALL, COLOR_RANDOM, &r);
    ddof_frame frame = scene_frame(&s);
    ddof_settings settings = {0};
    ddof_stats stats = render(ctx, &frame, &settings);
    assert_true(stats.threads >= 1);
    if (config && config->threads && config->backend != DDOF_BACKEND_REFERENCE)
        assert_int_equal(stats.threads, config->threads);
    for (int i = 0; i < COUNT(stats.reserved); i++)
        assert_true(stats.reserved[i] == 0);
    strncpy(name, stats.device, sizeof name - 1);
    scene_free(&s);
    DESTROY(ctx);
    return name;
}

/* The mask decides, of what the machine has. */
static void devices(void **state) {
    (void)state;
    const unsigned have = ddof_cpu_available();
    const char *const narrow = have & DDOF_CPU_NEON ? "neon" : "baseline";
    const char *const best = have & DDOF_CPU_AVX512 ? "avx512" : have & DDOF_CPU_AVX2 ? "avx2" : narrow;
    assert_string_equal(device_of(NULL), best);
    assert_string_equal(device_of(&(ddof_config){.threads = 2}), best);
    assert_string_equal(device_of(&(ddof_config){.cpu_mask = ~0u}), best);
    assert_string_equal(device_of(&(ddof_config){.cpu_mask = DDOF_CPU_BASELINE}), narrow);
    assert_string_equal(device_of(&(ddof_config){.cpu_mask = 1u << 31}), narrow);
    if (have & DDOF_CPU_AVX2) assert_string_equal(device_of(&(ddof_config){.cpu_mask = DDOF_CPU_AVX2}), "avx2");
    assert_string_equal(device_of(&(ddof_config){.backend = DDOF_BACKEND_REFERENCE}), "float64");
}

/* ---- one call at a time */

typedef struct intruder {
    ddof_context *ctx;
    const ddof_frame *frame;
    int calls;
    bool wrong;
} intruder;

/* Every call on the busy context is refused and leaves its error text alone. */
static void intrude(intruder *in) {
    static const ddof_settings settings;
    static const ddof_stats zero;
    ddof_stats stats;
    size_t bytes;
    char before[512];
    if (!in->ctx) return;
    snprintf(before, sizeof before, "%s", ddof_error(in->ctx));
    in->calls++;
    memset(&stats, 0xff, sizeof stats);
    in->wrong |= ddof_render(in->ctx, in->frame, &settings, &stats) != DDOF_ERROR_BUSY;
    in->wrong |= memcmp(&stats, &zero, sizeof zero) != 0;
    in->wrong |= ddof_coc(in->ctx, in->frame, &settings, NULL) != DDOF_ERROR_BUSY;
    in->wrong |= ddof_scratch_bytes(in->ctx, in->frame, &settings, &bytes) != DDOF_ERROR_BUSY;
    in->wrong |= ddof_trim(in->ctx) != DDOF_ERROR_BUSY;
    in->wrong |= strcmp(ddof_error(in->ctx), before) != 0;
}

static void *intrude_thread(void *user) {
    intrude(user);
    return NULL;
}

static int progress_intrudes(void *user, double done) {
    pthread_t thread;
    (void)done;
    intrude(user);
    if (pthread_create(&thread, NULL, intrude_thread, user) == 0) pthread_join(thread, NULL);
    return 0;
}

static void log_intrudes(void *user, ddof_log_level level, const char *text) {
    (void)level, (void)text;
    intrude(user);
}

static int loop_intrudes(void *user, int count, ddof_task task, void *task_data) {
    intrude(user);
    return parallel_serial(NULL, count, task, task_data);
}

static allocator plain_allocator;
static intruder *allocating;

static void *allocate_intrudes(void *user, size_t bytes) {
    if (allocating) intrude(allocating);
    return allocator_allocate(user, bytes);
}

static void busy(void **state) {
    (void)state;
    rng r = {101};
    intruder in[4] = {{0}};
    plain_allocator = (allocator){0};
    ddof_context *ctx = context_with(&(ddof_config){.threads = 1,
                                                    .progress = progress_intrudes,
                                                    .progress_user = &in[0],
                                                    .log = log_intrudes,
                                                    .log_user = &in[1],
                                                    .parallel_for = loop_intrudes,
                                                    .parallel_user = &in[2],
                                                    .allocate = allocate_intrudes,
                                                    .release = allocator_release,
                                                    .memory_user = &plain_allocator});
    scene s = scene_fill(100, 100, COC_SMALL, COLOR_RANDOM, &r);
    ddof_frame frame = scene_frame(&s);
    ddof_settings settings = {0};
    for (int i = 0; i < 4; i++)
        in[i].ctx = ctx, in[i].frame = &frame;
    allocating = &in[3];
    s.color[7] = NAN; /* for a warning in the log */
    render(ctx, &frame, &settings);
    assert_int_equal(in[1].calls, 1);
    settings.substeps = -1;
    assert_int_equal(ddof_render(ctx, &frame, &settings, NULL), DDOF_ERROR_INVALID);
    assert_int_equal(in[1].calls, 2);
    assert_non_null(strstr(ddof_error(ctx), "substeps"));
    for (int i = 0; i < 4; i++) {
        assert_true(in[i].calls > 0);
        assert_false(in[i].wrong);
    }
    allocating = NULL;
    scene_free(&s);
    DESTROY(ctx);
    assert_int_equal(plain_allocator.live, 0);
}

/* ---- progress */

typedef struct watcher {
    atomic_int inside, calls;
    int stop_at; /* the call that says stop, from 1; 0: none */
    bool overlapped, fell, outside, after_stop;
    double last;
} watcher;

static int watch(void *user, double done) {
    watcher *w = user;
    if (atomic_fetch_add(&w->inside, 1) != 0) w->overlapped = true;
    const int call = ++w->calls;
    for (int i = 0; i < 4; i++)
        sched_yield(); /* others may try to come in */
    if (done < w->last) w->fell = true;
    if (!(done >= 0 && done <= 1)) w->outside = true;
    if (w->stop_at && call > w->stop_at) w->after_stop = true;
    w->last = done;
    atomic_fetch_sub(&w->inside, 1);
    return w->stop_at == call;
}

static void assert_watched(const watcher *w) {
    assert_false(w->overlapped);
    assert_false(w->fell);
    assert_false(w->outside);
    assert_false(w->after_stop);
}

/* value: threads; 0: the reference */
static ddof_context *watched_context(void **state, watcher *w) {
    const int threads = test_parameters(state).value;
    return context_with(&(ddof_config){.backend = threads ? DDOF_BACKEND_CPU : DDOF_BACKEND_REFERENCE,
                                       .threads = threads,
                                       .progress = watch,
                                       .progress_user = w});
}

static void progress(void **state) {
    rng r = {102};
    watcher w = {0};
    ddof_context *ctx = watched_context(state, &w);
    for (int i = 0; i < 4; i++) {
        const ddof_settings settings = {.substeps = i % 3 + 1};
        scene s = scene_fill(rng_range(&r, 1, 300), rng_range(&r, 1, 300), COC_SMALL, COLOR_RANDOM, &r);
        ddof_frame frame = scene_frame(&s);
        if (i % 4 == 3) frame.color.channels = frame.output.channels = 3;
        w = (watcher){0};
        render(ctx, &frame, &settings);
        assert_watched(&w);
        assert_true(w.calls > 0);
        if (test_parameters(state).value < 2) assert_true(w.last > 0.5);
        frame.output = frame.coc;
        w = (watcher){0};
        write_coc(ctx, &frame, &settings);
        assert_watched(&w);
        scene_free(&s);
    }
    DESTROY(ctx);
}

/* Stopped at the k-th call, for every k: CANCELLED, no more calls, and the next frame is as ever. */
static void cancel(void **state) {
    rng r = {103};
    watcher w = {0};
    ddof_context *ctx = watched_context(state, &w);
    const ddof_settings settings = {.substeps = 2};
    scene s = scene_fill(70, 90, COC_RANDOM, COLOR_RANDOM, &r);
    const size_t n = values_of(&s);
    float *want = fenced(n * sizeof *want, true), *coc = fenced(n / 4 * sizeof *coc, true);
    ddof_frame frame = scene_frame(&s),
               map = {.coc = frame.coc, .output = ddof_image_interleaved(coc, 70, 90, 1, DDOF_FLOAT, 0)};
    render(ctx, &frame, &settings);
    memcpy(want, s.output, n * sizeof *want);
    for (int k = 1, finished = 0; finished < 2; k++) {
        ddof_stats stats, zero = {0};
        finished = 0;
        for (int i = 0; i < 2; i++) {
            w = (watcher){.stop_at = k};
            ddof_status status =
                i ? ddof_coc(ctx, &map, &settings, &stats) : ddof_render(ctx, &frame, &settings, &stats);
            assert_watched(&w);
            if (status == DDOF_OK) {
                assert_true(w.calls < k);
                finished++;
                continue;
            }
            assert_int_equal(status, DDOF_ERROR_CANCELLED);
            assert_int_equal(w.calls, k);
            assert_non_null(strstr(ddof_error(ctx), "cancelled"));
            assert_memory_equal(&stats, &zero, sizeof zero);
        }
        w = (watcher){0};
        render(ctx, &frame, &settings);
        assert_same_bits(s.output, want, n, "after a call that was stopped at %d", k);
        assert_true(k < 2000);
    }
    fenced_free(want);
    fenced_free(coc);
    scene_free(&s);
    DESTROY(ctx);
}

/* ---- loops that fail */

static int refuse_after; /* loops */

static int refuse_later(void *user, int count, ddof_task task, void *task_data) {
    return refuse_after-- > 0 ? parallel_threads(user, count, task, task_data) : 1;
}

static void refused_loops(void **state) {
    (void)state;
    rng r = {104};
    ddof_context *ctx = context_with(&(ddof_config){.threads = PARALLEL_THREADS, .parallel_for = refuse_later});
    ddof_context *never = context_with(&(ddof_config){.threads = 1, .parallel_for = parallel_refused});
    const ddof_settings settings = {.substeps = 2};
    scene s = scene_fill(100, 50, COC_SMALL, COLOR_RANDOM, &r);
    ddof_frame frame = scene_frame(&s);
    assert_int_equal(ddof_render(never, &frame, &settings, NULL), DDOF_ERROR_MEMORY);
    assert_non_null(strstr(ddof_error(never), "parallel_for"));
    bool done = false;
    for (int loops = 0; !done; loops++) {
        refuse_after = loops;
        ddof_status status = ddof_render(ctx, &frame, &settings, NULL);
        done = status == DDOF_OK;
        assert_true(loops < 20);
        if (done) continue;
        assert_int_equal(status, DDOF_ERROR_MEMORY);
        assert_non_null(strstr(ddof_error(ctx), "parallel_for"));
    }
    frame.output = frame.coc;
    refuse_after = 0;
    assert_int_equal(ddof_coc(ctx, &frame, &settings, NULL), DDOF_ERROR_MEMORY);
    refuse_after = 9;
    write_coc(ctx, &frame, &settings);
    scene_free(&s);
    DESTROY(ctx);
    DESTROY(never);
}

/* ---- log */

static int logged[3];
static char last_text[512];

static void note(void *user, ddof_log_level level, const char *text) {
    assert_ptr_equal(user, logged);
    assert_null(strchr(text, '\n'));
    logged[level]++;
    snprintf(last_text, sizeof last_text, "%s", text);
}

static void logging(void **state) {
    (void)state;
    rng r = {105};
    ddof_context *ctx = context_with(&(ddof_config){.threads = 2, .log = note, .log_user = logged});
    ddof_settings settings = {0};
    scene s = scene_fill(40, 30, COC_SMALL, COLOR_RANDOM, &r);
    ddof_frame frame = scene_frame(&s);
    memset(logged, 0, sizeof logged);
    render(ctx, &frame, &settings);
    assert_int_equal(logged[DDOF_LOG_ERROR] + logged[DDOF_LOG_WARNING], 0);
    for (int i = 0; i < 17; i++)
        s.coc[i] = NAN;
    render(ctx, &frame, &settings);
    assert_int_equal(logged[DDOF_LOG_WARNING], 1);
    assert_non_null(strstr(last_text, "17"));
    settings.substeps = 99;
    assert_int_equal(ddof_render(ctx, &frame, &settings, NULL), DDOF_ERROR_INVALID);
    assert_int_equal(logged[DDOF_LOG_ERROR], 1);
    assert_string_equal(last_text, ddof_error(ctx));
    scene_free(&s);
    DESTROY(ctx);
}

/* ---- threads */

/* More threads than rows, columns or pixels. */
static void many_threads(void **state) {
    static const int sizes[][2] = {{1, 1}, {3, 2}, {1, 500}, {500, 1}, {40, 40}};
    rng r = {106};
    ddof_context *many = context_of(test_parameters(state).isa, 64), *one = context_of(test_parameters(state).isa, 1);
    const ddof_settings settings = {.substeps = 2};
    for (int i = 0; i < COUNT(sizes); i++) {
        scene s = scene_fill(sizes[i][0], sizes[i][1], COC_RANDOM, COLOR_RANDOM, &r);
        float *want = fenced(values_of(&s) * sizeof *want, true);
        ddof_frame frame = scene_frame(&s);
        render(one, &frame, &settings);
        memcpy(want, s.output, values_of(&s) * sizeof *want);
        render(many, &frame, &settings);
        assert_same_bits(s.output, want, values_of(&s), "%d x %d", s.width, s.height);
        fenced_free(want);
        scene_free(&s);
    }
    DESTROY(many);
    DESTROY(one);
}

/* Made and destroyed, with and without work in between. */
static void lives(void **state) {
    (void)state;
    for (int i = 0; i < 60; i++) {
        ddof_context *ctx = context_with(&(ddof_config){.threads = i % 9});
        if (i % 2)
            DESTROY(ctx);
        else
            assert_non_null(device_of(&(ddof_config){.threads = 1 + i % 9}));
        DESTROY(ctx);
    }
}

typedef struct side {
    scene s;
    unsigned isa;
    bool failed;
} side;

static void *work_alone(void *user) {
    side *me = user;
    ddof_config config = {.cpu_mask = me->isa, .threads = 3};
    ddof_settings settings = {.substeps = 2};
    ddof_frame frame = scene_frame(&me->s);
    for (int i = 0; i < 10; i++) {
        ddof_context *ctx = NULL;
        me->failed |= ddof_create(&ctx, &config) != DDOF_OK;
        for (int k = 0; k < 3; k++)
            me->failed |= ddof_render(ctx, &frame, &settings, NULL) != DDOF_OK;
        ddof_destroy(&ctx);
    }
    return NULL;
}

/* Contexts share nothing: three at work at once, each on its own thread. */
static void side_by_side(void **state) {
    enum { SIDES = 3 };
    side sides[SIDES];
    pthread_t thread[SIDES];
    rng r = {107};
    for (int i = 0; i < SIDES; i++) {
        sides[i] =
            (side){scene_fill(150, 60 + 20 * i, COC_RANDOM, COLOR_RANDOM, &r), test_parameters(state).isa, false};
        assert_int_equal(pthread_create(&thread[i], NULL, work_alone, &sides[i]), 0);
    }
    for (int i = 0; i < SIDES; i++)
        pthread_join(thread[i], NULL);
    ddof_context *ctx = context_of(test_parameters(state).isa, 1);
    for (int i = 0; i < SIDES; i++) {
        const ddof_settings settings = {.substeps = 2};
        const size_t n = values_of(&sides[i].s);
        float *got = fenced(n * sizeof *got, true);
        assert_false(sides[i].failed);
        memcpy(got, sides[i].s.output, n * sizeof *got);
        ddof_frame frame = scene_frame(&sides[i].s);
        render(ctx, &frame, &settings);
        assert_same_bits(got, sides[i].s.output, n, "context %d", i);
        fenced_free(got);
        scene_free(&sides[i].s);
    }
    DESTROY(ctx);
}

/* The config is copied. */
static void copied_config(void **state) {
    (void)state;
    rng r = {108};
    watcher w = {0};
    ddof_config config = {.threads = 2, .progress = watch, .progress_user = &w};
    ddof_context *ctx = context_with(&config);
    memset(&config, 0xff, sizeof config);
    scene s = scene_fill(40, 40, COC_SMALL, COLOR_RANDOM, &r);
    ddof_frame frame = scene_frame(&s);
    const ddof_settings settings = {0};
    assert_int_equal(render(ctx, &frame, &settings).threads, 2);
    assert_true(w.calls > 0);
    scene_free(&s);
    DESTROY(ctx);
}

int main(void) {
    static const test tests[] = {
        {"version, texts", names, false, 0, 0},
        {"instruction sets by mask", devices, false, 0, 0},
        {"busy", busy, false, 0, 0},
        {"progress, reference", progress, false, 0, 0},
        {"progress, 1 thread", progress, false, 1, 0},
        {"progress, 4 threads", progress, false, 4, 0},
        {"cancel, reference", cancel, false, 0, 0},
        {"cancel, 1 thread", cancel, false, 1, 0},
        {"cancel, 4 threads", cancel, false, 4, 0},
        {"loops that cannot start", refused_loops, false, 0, 0},
        {"log", logging, false, 0, 0},
        {"more threads than work", many_threads, true, 0, 0},
        {"many lives", lives, false, 0, 0},
        {"side by side", side_by_side, true, 0, 0},
        {"config is copied", copied_config, false, 0, 0},
    };
    return run_library_tests("context", tests, COUNT(tests));
}
