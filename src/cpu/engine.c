/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The CPU engine: which block of rows is worked on when, by whom, in what memory. The arithmetic is in rows.c and columns.c.
 *
 * A substep is two sweeps. DOWN: workers take blocks of rows in order. A block's rows are eliminated from left to right, all
 * by itself; then, tile by tile from right to left, substituted, and each tile goes at once through the column elimination,
 * as soon as the block above is done with that tile: a wavefront, in which a worker waits only for a block that
 * another one has already begun. UP: each worker substitutes a strip of columns from the last row to the first.
 *
 * Between the sweeps the means lie in the output itself (or, when that is half float, in scratch) and `keep`, 4 bytes a
 * pixel, in scratch. */
#include "engine.h"

#include <sched.h>
#include <string.h>

#include "../image.h"

#if defined(__x86_64__)
#define spin_pause() __builtin_ia32_pause()
#elif defined(__aarch64__)
#define spin_pause() __asm__ volatile("yield")
#else
#define spin_pause() ((void)0)
#endif

enum { LINE = 64, SPINS = 2000 };

/* Scratch memory is handed out in order; with a NULL base only sizes are counted. */
typedef struct arena {
    char *base;
    size_t used;
} arena;

static void *take(arena *a, size_t bytes) {
    void *p = a->base ? a->base + a->used : NULL;
    a->used += (bytes + LINE - 1) / LINE * LINE;
    return p;
}

typedef struct worker {
    cpu_block block;
    float *pixels;   /* rows of the source, converted; or two rows of the result */
    float *spare;    /* a tile of eliminated rows, on its way to an output that is not RGBA float */
    float *coc;      /* rows of CoC, computed */
    float *capacity; /* where the holes are */
    int64_t holes;
} worker;

typedef struct sweep {
    ddof_context *ctx;
    frame_job *job;
    const cpu_kernels *k;
    int width, height, lanes, blocks;
    ddof_image source, work, result; /* of this substep; strides resolved */
    bool straight_in, straight_out;  /* alpha of source and result */
    bool source_direct, work_direct, coc_direct, stream;
    bool first; /* substep: holes are looked for and counted */
    float *keep; /* height rows */
    ptrdiff_t keep_stride;
    column_state columns;
    atomic_int *done; /* per block: tiles finished */
    atomic_int next;  /* block to hand out */
    worker *worker;
} sweep;

static int block_count(int height, int lanes) {
    return (height + lanes - 1) / lanes;
}

/* Rows of keep begin on a cache line where there are enough of them to matter. */
static ptrdiff_t keep_stride(int width) {
    return width < TILE ? width : (width + 15) / 16 * 16;
}

static bool needs_work_image(const frame_job *job) {
    for (int c = 0; c < job->frame->output.channels; c++)
        if (job->frame->output.plane[c].type != DDOF_FLOAT) return true;
    return false;
}

static void lay_out(const ddof_context *ctx, const frame_job *job, sweep *s, arena *a) {
    const size_t wide = (size_t)job->coc_source.width + PAD, lanes = (size_t)ctx->kernels->lanes;
    const size_t height = (size_t)job->coc_source.height, f = sizeof(float);

    s->keep_stride = keep_stride(job->coc_source.width);
    s->keep = take(a, (size_t)s->keep_stride * height * f);
    s->columns.rest = take(a, wide * f);
    s->columns.mean = take(a, wide * 4 * f);
    s->done = take(a, sizeof(atomic_int) * (size_t)block_count((int)height, (int)lanes));
    s->worker = take(a, sizeof(worker) * (size_t)ctx->threads);
    for (int t = 0; t < ctx->threads; t++) {
        worker w = {.block = {.mean = take(a, wide * lanes * 4 * f), .keep = take(a, wide * lanes * f)}};
        w.block.tile = take(a, lanes * TILE * 4 * f);
        w.spare = take(a, lanes * TILE * 4 * f);
        w.pixels = take(a, wide * lanes * 4 * f);
        w.coc = take(a, wide * (lanes + 1) * f);
        w.capacity = take(a, (wide + 1) * lanes * f);
        if (a->base) s->worker[t] = w;
    }
    if (needs_work_image(job)) {
        int n = job->frame->output.channels;
        void *p = take(a, (wide - PAD) * height * (size_t)n * f);
        s->work = ddof_image_interleaved(p, (int)(wide - PAD), (int)height, n, DDOF_FLOAT, 0);
    }
}

size_t cpu_scratch_bytes(const ddof_context *ctx, const frame_job *job) {
    sweep s = {0};
    arena a = {0};
    lay_out(ctx, job, &s, &a);
    return a.used;
}

/* ---- down */

/* CoC of row y, in the caller's memory where it is fit for that, else in `room`. */
static const float *coc_row(const sweep *s, int y, float *room) {
    const frame_job *job = s->job;
    if (s->coc_direct) return image_at(&job->coc_source, 0, 0, y);
    plane_load(&job->coc_source, 0, 0, y, s->width, room, s->k->pixels);
    if (job->is_depth)
        s->k->pixels->lens(&job->curve, room, room, s->width, job->frame->offset_x, y + job->frame->offset_y);
    return room;
}

static void load_block(const sweep *s, worker *w, int y) {
    cpu_block *b = &w->block;
    const ptrdiff_t wide = s->width + PAD;
    b->width = s->width;
    b->count = s->height - y < s->lanes ? s->height - y : s->lanes;
    b->row_scale = (float)s->job->row_scale;
    b->column_scale = (float)s->job->column_scale;
    b->capacity = NULL;
    memset(b->carry, 0, sizeof b->carry);
    for (int r = 0; r < s->lanes; r++) {
        b->row_alive[r] = 1;
        if (r >= b->count) {
            b->pixel[r] = b->pixel[b->count - 1];
            b->coc[r] = b->coc[b->count - 1];
            continue;
        }
        b->coc[r] = coc_row(s, y + r, w->coc + wide * r);
        float *room = w->pixels + wide * 4 * r;
        b->pixel[r] = room;
        if (s->source_direct)
            b->pixel[r] = image_at(&s->source, 0, 0, y + r);
        else
            span_load(&s->source, 0, y + r, s->width, room, s->straight_in, s->k->pixels);
    }
    b->coc_below = NULL;
    if (y + b->count < s->height) b->coc_below = coc_row(s, y + b->count, w->coc + wide * s->lanes);
}

static inline bool finite(float v) {
    return v - v == 0;
}

/* Something in this block was not finite: copies its rows with zeros in the holes and says where they are. */
static void find_holes(const sweep *s, worker *w) {
    cpu_block *b = &w->block;
    const ptrdiff_t wide = s->width + PAD, lanes = s->lanes;
    for (ptrdiff_t i = 0; i < (wide + 1) * lanes; i++) w->capacity[i] = 1;
    for (int r = 0; r < b->count; r++) {
        float *row = w->pixels + wide * 4 * r;
        int64_t holes = 0;
        if (b->pixel[r] != row) memcpy(row, b->pixel[r], (size_t)s->width * 4 * sizeof(float));
        for (ptrdiff_t x = 0; x < s->width; x++) {
            float *p = row + 4 * x;
            if (finite(p[0]) && finite(p[1]) && finite(p[2]) && finite(p[3]) && finite(b->coc[r][x])) continue;
            memset(p, 0, 4 * sizeof *p);
            w->capacity[x * lanes + r] = 0;
            holes++;
        }
        b->pixel[r] = row;
        b->row_alive[r] = holes < s->width;
        w->holes += holes;
    }
    for (ptrdiff_t r = b->count; r < lanes; r++) { /* the padding rows follow the last one */
        b->pixel[r] = b->pixel[b->count - 1];
        for (ptrdiff_t x = 0; x < s->width; x++) w->capacity[x * lanes + r] = w->capacity[x * lanes + b->count - 1];
    }
    b->capacity = w->capacity;
}

/* False when the frame was cancelled. */
static bool wait_for_tile(const sweep *s, int block, int tile) {
    if (block == 0) return true;
    for (int i = 0; atomic_load_explicit(&s->done[block - 1], memory_order_acquire) <= tile; i++) {
        if (atomic_load_explicit(&s->ctx->cancelled, memory_order_relaxed)) return false;
        if (i < SPINS)
            spin_pause();
        else
            sched_yield();
    }
    return true;
}

static void columns_of_tile(const sweep *s, worker *w, int y, int x0, int x1) {
    cpu_block *b = &w->block;
    float *out[MAX_LANES], *keep[MAX_LANES];
    for (int r = 0; r < b->count; r++) {
        keep[r] = s->keep + s->keep_stride * (y + r) + x0;
        out[r] = s->work_direct ? image_at(&s->work, 0, x0, y + r) : w->spare + (ptrdiff_t)r * TILE * 4;
    }
    s->k->columns->down(b, &s->columns, x0, x1, out, keep, s->stream);
    if (!s->work_direct)
        for (int r = 0; r < b->count; r++) span_store(&s->work, x0, y + r, x1 - x0, out[r], false, s->k->pixels);
}

static bool down_block(const sweep *s, worker *w, int block) {
    const int y = block * s->lanes, tiles = (s->width + TILE - 1) / TILE;
    load_block(s, w, y);
    if (!s->k->rows->forward(&w->block) && s->first) { /* later substeps find them filled, with or without a CoC */
        find_holes(s, w);
        s->k->rows->forward(&w->block);
    }
    for (int t = 0; t < tiles; t++) {
        int x0 = (tiles - 1 - t) * TILE, x1 = x0 + TILE < s->width ? x0 + TILE : s->width;
        s->k->rows->backward(&w->block, x0, x1);
        if (!wait_for_tile(s, block, t)) return false;
        columns_of_tile(s, w, y, x0, x1);
        atomic_store_explicit(&s->done[block], t + 1, memory_order_release);
    }
    return context_progress(s->ctx, w->block.count);
}

static void down(void *data, int index, int id) {
    sweep *s = data;
    (void)index; /* blocks are handed out in order, whatever the order of the tasks */
    for (;;) {
        int block = atomic_fetch_add(&s->next, 1);
        if (block >= s->blocks || !down_block(s, &s->worker[id], block)) return;
    }
}

/* ---- up */

static void up_direct(const sweep *s, int x0, int x1) {
    for (int y = s->height - 2; y >= 0; y--) {
        float *row = image_at(&s->work, 0, x0, y), *below = image_at(&s->work, 0, x0, y + 1);
        s->k->columns->up(row, s->keep + s->keep_stride * y + x0, below, x1 - x0);
        if (y % 64 == 0 && !context_progress(s->ctx, 0)) return;
    }
}

/* The result is of another type than the work image, or planar: a strip, row by row, through float RGBA. */
static void up_converting(const sweep *s, worker *w, int x0, int x1) {
    float *row = w->pixels, *below = w->pixels + ((ptrdiff_t)s->width + PAD) * 4;
    for (int y = s->height - 1; y >= 0; y--) {
        span_load(&s->work, x0, y, x1 - x0, row, false, s->k->pixels);
        if (y < s->height - 1) s->k->columns->up(row, s->keep + s->keep_stride * y + x0, below, x1 - x0);
        span_store(&s->result, x0, y, x1 - x0, row, s->straight_out, s->k->pixels);
        float *swap = row;
        row = below;
        below = swap;
        if (y % 64 == 0 && !context_progress(s->ctx, 0)) return;
    }
}

static int strip_count(const sweep *s) {
    int most = (s->width + TILE - 1) / TILE;
    return s->ctx->threads < most ? s->ctx->threads : most;
}

static void up(void *data, int index, int id) {
    const sweep *s = data;
    const int strips = strip_count(s), lines = (s->width + 15) / 16;
    int x0 = (int)((int64_t)lines * index / strips) * 16, x1 = (int)((int64_t)lines * (index + 1) / strips) * 16;
    if (x1 > s->width) x1 = s->width;
    if (s->work_direct && s->work.plane[0].data == s->result.plane[0].data && !s->straight_out)
        up_direct(s, x0, x1);
    else
        up_converting(s, &s->worker[id], x0, x1);
    context_progress(s->ctx, (int64_t)s->height * (x1 - x0) / s->width);
}

/* ---- the frame */

static bool aligned(const ddof_image *image) {
    return ((uintptr_t)image->plane[0].data | (uintptr_t)image->plane[0].row_stride) % LINE == 0;
}

static ddof_status substep(sweep *s) {
    const ddof_config *config = &s->ctx->config;
    s->source_direct = image_is_rgba(&s->source) && !s->straight_in;
    s->work_direct = image_is_rgba(&s->work);
    const bool in_place = s->source.plane[0].data == s->work.plane[0].data;
    s->stream = s->work_direct && !in_place && aligned(&s->work) && s->width >= TILE;
    s->next = 0;
    for (int i = 0; i < s->blocks; i++) atomic_init(&s->done[i], 0);
    size_t wide = (size_t)s->width + PAD;
    memset(s->columns.rest, 0, wide * sizeof(float));
    memset(s->columns.mean, 0, wide * 4 * sizeof(float));
    int tasks = s->ctx->threads < s->blocks ? s->ctx->threads : s->blocks;
    if (config->parallel_for(config->parallel_user, tasks, down, s)) return DDOF_ERROR_MEMORY;
    if (s->ctx->cancelled) return DDOF_ERROR_CANCELLED;
    if (config->parallel_for(config->parallel_user, strip_count(s), up, s)) return DDOF_ERROR_MEMORY;
    return s->ctx->cancelled ? DDOF_ERROR_CANCELLED : DDOF_OK;
}

ddof_status cpu_diffuse(ddof_context *ctx, frame_job *job, void *scratch) {
    const ddof_frame *frame = job->frame;
    sweep s = {.ctx = ctx, .job = job, .k = ctx->kernels, .width = frame->color.width, .height = frame->color.height};
    arena a = {.base = scratch};
    ddof_image color = frame->color, output = frame->output;
    const bool straight = color.alpha == DDOF_ALPHA_STRAIGHT;

    s.lanes = s.k->lanes;
    s.blocks = block_count(s.height, s.lanes);
    lay_out(ctx, job, &s, &a);
    color.alpha = output.alpha = DDOF_ALPHA_PREMULTIPLIED; /* from here on the straight_* flags say it */
    image_resolve(&color);
    image_resolve(&output);
    image_resolve(&job->coc_source);
    s.coc_direct = !job->is_depth && plane_is_tight(&job->coc_source.plane[0]);
    if (!needs_work_image(job)) s.work = output;
    image_resolve(&s.work);

    ctx->progress_total = 2.0 * s.height * job->substeps;
    ddof_status status = DDOF_OK;
    for (int i = 0; i < job->substeps && status == DDOF_OK; i++) {
        const bool last = i == job->substeps - 1;
        s.first = i == 0;
        s.source = s.first ? color : s.work;
        s.straight_in = s.first && straight;
        s.result = last ? output : s.work;
        s.straight_out = last && straight;
        status = substep(&s);
    }
    for (int t = 0; t < ctx->threads; t++) job->nonfinite_pixels += s.worker[t].holes;
    return status;
}

/* ---- the CoC alone */

typedef struct coc_work {
    sweep *s;
    ddof_image output;
    atomic_llong bad;
} coc_work;

static void coc_rows(void *data, int index, int id) {
    coc_work *w = data;
    float *room = w->s->worker[id].coc;
    const int y0 = index * w->s->lanes, y1 = y0 + w->s->lanes < w->s->height ? y0 + w->s->lanes : w->s->height;
    long long bad = 0;
    for (int y = y0; y < y1; y++) {
        const float *row = coc_row(w->s, y, room);
        for (int x = 0; x < w->s->width; x++) bad += !finite(row[x]);
        plane_store(&w->output, 0, 0, y, w->s->width, row, w->s->k->pixels);
    }
    atomic_fetch_add(&w->bad, bad);
    context_progress(w->s->ctx, y1 - y0);
}

ddof_status cpu_coc(ddof_context *ctx, frame_job *job, void *scratch) {
    const ddof_image *in = &job->coc_source;
    sweep s = {.ctx = ctx, .job = job, .k = ctx->kernels, .width = in->width, .height = in->height};
    arena a = {.base = scratch};
    coc_work w = {.s = &s, .output = job->frame->output};
    s.lanes = s.k->lanes;
    lay_out(ctx, job, &s, &a);
    image_resolve(&w.output);
    image_resolve(&job->coc_source);
    ctx->progress_total = s.height;
    if (ctx->config.parallel_for(ctx->config.parallel_user, block_count(s.height, s.lanes), coc_rows, &w))
        return DDOF_ERROR_MEMORY;
    job->nonfinite_pixels = w.bad;
    return ctx->cancelled ? DDOF_ERROR_CANCELLED : DDOF_OK;
}
