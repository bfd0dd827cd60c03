/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The public functions: lifetime, one call at a time, errors. No mathematics. */
#define _DEFAULT_SOURCE /* madvise */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#if defined(__linux__)
#include <sys/mman.h>
#endif

#include "context.h"
#include "cpu/engine.h"
#include "iris.h"

/* Large blocks ask for huge pages: touching the scratch of a 4K frame for the first time otherwise costs as much as solving it. */
void *context_allocate(void *user, size_t bytes) {
    const size_t huge = (size_t)2 << 20, line = 64, align = bytes >= 2 * huge ? huge : line;
    (void)user;
    if (bytes > SIZE_MAX - align) return NULL;
    bytes = (bytes + align - 1) / align * align;
    void *p = aligned_alloc(align, bytes);
#if defined(MADV_HUGEPAGE)
    if (p && align == huge) madvise(p, bytes, MADV_HUGEPAGE);
#endif
    return p;
}

void context_release(void *user, void *memory) {
    (void)user;
    free(memory);
}

const char *ddof_version(void) {
    return DDOF_VERSION_STRING;
}

const char *ddof_status_text(ddof_status status) {
    switch (status) {
    case DDOF_OK: return "no error";
    case DDOF_ERROR_INVALID: return "invalid argument";
    case DDOF_ERROR_MEMORY: return "out of memory";
    case DDOF_ERROR_CANCELLED: return "cancelled";
    case DDOF_ERROR_UNSUPPORTED: return "not supported by this build or machine";
    case DDOF_ERROR_BUSY: return "the context is in use by another call";
    case DDOF_ERROR_DEVICE: return "the device was lost or ran out of memory";
    }
    return "unknown status";
}

unsigned ddof_cpu_available(void) {
    return cpu_flags();
}

ddof_status context_fail(ddof_context *ctx, ddof_status status, const char *format, ...) {
    va_list args;
    va_start(args, format);
    vsnprintf(ctx->error, sizeof ctx->error, format, args);
    va_end(args);
    if (ctx->config.log) ctx->config.log(ctx->config.log_user, DDOF_LOG_ERROR, ctx->error);
    return status;
}

void context_log(ddof_context *ctx, ddof_log_level level, const char *format, ...) {
    char text[512];
    va_list args;
    if (!ctx->config.log) return;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    ctx->config.log(ctx->config.log_user, level, text);
}

bool context_progress(ddof_context *ctx, int64_t units) {
    atomic_fetch_add_explicit(&ctx->progress_done, units, memory_order_relaxed);
    if (ctx->config.progress && pthread_mutex_trylock(&ctx->progress_lock) == 0) {
        double done = ctx->progress_total > 0 ? (double)ctx->progress_done / ctx->progress_total : 0;
        if (done > 1) done = 1;
        done = ctx->progress_from + done * (ctx->progress_to - ctx->progress_from);
        done = ctx->image_from + done * ctx->image_share;
        if (done < ctx->progress_shown) done = ctx->progress_shown;
        ctx->progress_shown = done;
        if (!ctx->cancelled && ctx->config.progress(ctx->config.progress_user, done)) ctx->cancelled = true;
        pthread_mutex_unlock(&ctx->progress_lock);
    }
    return !ctx->cancelled;
}

void context_image(ddof_context *ctx, double from, double share) {
    ctx->image_from = from;
    ctx->image_share = share;
    context_stage(ctx, 0, 1);
}

void context_stage(ddof_context *ctx, double from, double to) {
    ctx->progress_from = from;
    ctx->progress_to = to;
    ctx->progress_done = 0;
    ctx->progress_total = 0;
}

static const backend *pick_backend(ddof_backend id) {
    switch (id) {
    case DDOF_BACKEND_REFERENCE: return &backend_reference;
    case DDOF_BACKEND_GL: return &backend_gl;
    case DDOF_BACKEND_VULKAN: return &backend_vulkan;
    default: return &backend_cpu;
    }
}

/* What can fail while a context is made; on failure the caller cleans up. */
static ddof_status set_up(ddof_context *ctx) {
    ddof_config *c = &ctx->config;
    ctx->threads = c->threads > 0 ? c->threads : threads_available();
    ctx->backend = pick_backend(c->backend);
    if (ctx->backend != &backend_cpu) ctx->threads = 1;
    ctx->kernels = cpu_kernels_pick(c->cpu_mask);
    if (ctx->backend->open) {
        ddof_status status = ctx->backend->open(ctx);
        if (status != DDOF_OK) return status;
    }
    if (c->parallel_for) return DDOF_OK;
    ctx->pool = thread_pool_create(ctx->threads, c->allocate, c->release, c->memory_user);
    c->parallel_for = thread_pool_run;
    c->parallel_user = ctx->pool;
    return ctx->pool ? DDOF_OK : DDOF_ERROR_MEMORY;
}

ddof_status ddof_create(ddof_context **context, const ddof_config *config) {
    static const ddof_config defaults;
    const char *wrong = NULL;
    ddof_config c = config ? *config : defaults;
    if (!context) {
        if (c.log) c.log(c.log_user, DDOF_LOG_ERROR, "context is NULL: give the address of a ddof_context *");
        return DDOF_ERROR_INVALID;
    }
    *context = NULL;
    ddof_status status = check_config(&c, &wrong);
    if (status == DDOF_OK) {
        if (!c.allocate) {
            c.allocate = context_allocate;
            c.release = context_release;
        }
        ddof_context *ctx = c.allocate(c.memory_user, sizeof *ctx);
        status = DDOF_ERROR_MEMORY;
        wrong = "out of memory or threads for a context";
        if (ctx) {
            memset(ctx, 0, sizeof *ctx);
            ctx->config = c;
            pthread_mutex_init(&ctx->progress_lock, NULL);
            atomic_flag_clear(&ctx->busy);
            status = set_up(ctx);
            *context = ctx;
            if (ctx->error[0]) wrong = NULL; /* has been logged */
            if (status != DDOF_OK) ddof_destroy(context);
        }
    }
    if (status != DDOF_OK && wrong && c.log) c.log(c.log_user, DDOF_LOG_ERROR, wrong);
    return status;
}

void ddof_destroy(ddof_context **context) {
    if (!context || !*context) return;
    ddof_context *ctx = *context;
    *context = NULL;
    if (ctx->backend->close) ctx->backend->close(ctx);
    thread_pool_destroy(ctx->pool);
    pthread_mutex_destroy(&ctx->progress_lock);
    if (ctx->scratch) ctx->config.release(ctx->config.memory_user, ctx->scratch);
    if (ctx->iris) ctx->config.release(ctx->config.memory_user, ctx->iris);
    ctx->config.release(ctx->config.memory_user, ctx);
}

int ddof_devices(ddof_backend id, ddof_device *devices, int capacity) {
    const backend *b = pick_backend(id);
    return b->list ? b->list(devices, devices ? capacity : 0) : 0;
}

const char *ddof_error(const ddof_context *context) {
    return context ? context->error : "";
}

/* One call at a time: false when another one is under way. */
static bool enter(ddof_context *ctx) {
    if (!ctx || atomic_flag_test_and_set(&ctx->busy)) return false;
    ctx->error[0] = 0;
    return true;
}

static ddof_status leave(ddof_context *ctx, ddof_status status) {
    atomic_flag_clear(&ctx->busy);
    return status;
}

ddof_status ddof_trim(ddof_context *ctx) {
    if (!ctx) return DDOF_ERROR_INVALID;
    if (!enter(ctx)) return DDOF_ERROR_BUSY;
    if (ctx->scratch) ctx->config.release(ctx->config.memory_user, ctx->scratch);
    if (ctx->iris) ctx->config.release(ctx->config.memory_user, ctx->iris);
    ctx->iris = NULL;
    ctx->scratch = NULL;
    ctx->scratch_bytes = 0;
    if (ctx->backend->trim) ctx->backend->trim(ctx);
    return leave(ctx, DDOF_OK);
}

static ddof_status run(ddof_context *ctx, const ddof_frame *frame, const ddof_settings *settings, bool coc_only,
                       ddof_stats *stats) {
    frame_job job;
    ddof_status status = check_frame(ctx, frame, !coc_only);
    if (status == DDOF_OK) status = check_settings(ctx, frame, settings);
    if (status == DDOF_OK) status = pipeline_prepare(ctx, &job, frame, settings, true, &job.focus_distance);
    if (status == DDOF_OK) status = pipeline_run(ctx, &job, coc_only);
    if (status == DDOF_OK && stats) {
        stats->nonfinite_pixels = job.nonfinite_pixels;
        stats->sprites = job.sprites;
        stats->sprites_dropped = job.sprites_dropped;
        stats->sprites_large = job.sprites_large;
        stats->focus_distance = job.focus_distance;
        stats->scratch_bytes = ctx->scratch_bytes + (ctx->iris ? sizeof *ctx->iris : 0);
        stats->threads = ctx->threads;
        stats->surface_bytes = ctx->backend->surface_bytes ? ctx->backend->surface_bytes(ctx) : 0;
        stats->device = ctx->backend->device(ctx);
    }
    return status;
}

ddof_status ddof_render(ddof_context *ctx, const ddof_frame *frame, const ddof_settings *settings, ddof_stats *stats) {
    if (stats) memset(stats, 0, sizeof *stats);
    if (!ctx) return DDOF_ERROR_INVALID;
    if (!enter(ctx)) return DDOF_ERROR_BUSY;
    return leave(ctx, run(ctx, frame, settings, false, stats));
}

ddof_status ddof_coc(ddof_context *ctx, const ddof_frame *frame, const ddof_settings *settings, ddof_stats *stats) {
    if (stats) memset(stats, 0, sizeof *stats);
    if (!ctx) return DDOF_ERROR_INVALID;
    if (!enter(ctx)) return DDOF_ERROR_BUSY;
    return leave(ctx, run(ctx, frame, settings, true, stats));
}

ddof_status ddof_scratch_bytes(ddof_context *ctx, const ddof_frame *frame, const ddof_settings *settings, size_t *bytes) {
    frame_job job;
    double distance;
    if (!ctx) return DDOF_ERROR_INVALID;
    if (!enter(ctx)) return DDOF_ERROR_BUSY;
    if (!bytes) return leave(ctx, context_fail(ctx, DDOF_ERROR_INVALID, "bytes is NULL"));
    ddof_status status = check_frame(ctx, frame, true);
    if (status == DDOF_OK) status = check_settings(ctx, frame, settings);
    if (status == DDOF_OK) status = pipeline_prepare(ctx, &job, frame, settings, false, &distance);
    if (status == DDOF_OK) *bytes = pipeline_scratch_bytes(ctx, &job, false) + pipeline_iris_bytes(&job);
    return leave(ctx, status);
}
