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

#include <string.h>

#include "../image.h"
#include "block.h"
#include "disc_engine.h"

typedef struct worker {
    cpu_block block;
    block_room room; /* its pixels hold two rows of the result, on the way up */
    float *spare;    /* a tile of eliminated rows, on its way to an output that is not RGBA float */
    int64_t holes;
} worker;

typedef struct sweep {
    cpu_frame f;             /* source: of this substep */
    int blocks;
    ddof_image work, result; /* of this substep; strides resolved */
    bool straight_out;       /* alpha of the result */
    bool work_direct, stream;
    bool first; /* substep: holes are looked for and counted */
    float *keep; /* height rows */
    ptrdiff_t keep_stride;
    column_state columns;
    atomic_int *done; /* per block: tiles finished */
    atomic_int next;  /* block to hand out */
    worker *worker;
} sweep;

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
    s->keep = arena_take(a, (size_t)s->keep_stride * height * f);
    s->columns.rest = arena_take(a, wide * f);
    s->columns.mean = arena_take(a, wide * 4 * f);
    s->done = arena_take(a, sizeof(atomic_int) * (size_t)block_count((int)height, (int)lanes));
    s->worker = arena_take(a, sizeof(worker) * (size_t)ctx->threads);
    for (int t = 0; t < ctx->threads; t++) {
        worker w = {.block = {.mean = arena_take(a, wide * lanes * 4 * f), .keep = arena_take(a, wide * lanes * f)}};
        w.block.tile = arena_take(a, lanes * TILE * 4 * f);
        w.spare = arena_take(a, lanes * TILE * 4 * f);
        block_room_take(&w.room, a, job->coc_source.width, (int)lanes);
        if (a->base) s->worker[t] = w;
    }
    if (needs_work_image(job)) {
        const int given = job->frame->output.channels, n = given < 3 ? given : 4; /* RGBA is worked on where it lies */
        void *p = arena_take(a, (wide - PAD) * height * (size_t)n * f);
        s->work = ddof_image_interleaved(p, (int)(wide - PAD), (int)height, n, DDOF_FLOAT, 0);
    }
}

size_t cpu_scratch_bytes(const ddof_context *ctx, const frame_job *job) {
    if (job->method == DDOF_METHOD_GAUSSIAN || job->method == DDOF_METHOD_HEXAGON) return cpu_method_bytes(job);
    if (job->disc) return disc_scratch_bytes(ctx, job);
    sweep s = {0};
    arena a = {0};
    lay_out(ctx, job, &s, &a);
    return a.used;
}

/* ---- down */

static void load_block(const sweep *s, worker *w, int y) {
    cpu_block *b = &w->block;
    const int left = s->f.height - y;
    b->row_scale = (float)s->f.job->row_scale;
    b->column_scale = (float)s->f.job->column_scale;
    memset(b->carry, 0, sizeof b->carry);
    block_load_pixels(&s->f, &b->in, &w->room, y, left < s->f.lanes ? left : s->f.lanes);
    block_load_coc(&s->f, &b->in, &w->room, y);
    b->coc_below = NULL;
    if (y + b->in.count < s->f.height)
        b->coc_below = block_coc_row(&s->f, y + b->in.count, w->room.coc + ((ptrdiff_t)s->f.width + PAD) * s->f.lanes);
}

static void columns_of_tile(const sweep *s, worker *w, int y, int x0, int x1) {
    cpu_block *b = &w->block;
    float *out[MAX_LANES], *keep[MAX_LANES];
    for (int r = 0; r < b->in.count; r++) {
        keep[r] = s->keep + s->keep_stride * (y + r) + x0;
        out[r] = s->work_direct ? image_at(&s->work, 0, x0, y + r) : w->spare + (ptrdiff_t)r * TILE * 4;
    }
    s->f.k->columns->down(b, &s->columns, x0, x1, out, keep, s->stream);
    if (!s->work_direct)
        for (int r = 0; r < b->in.count; r++) span_store(&s->work, x0, y + r, x1 - x0, out[r], false, s->f.k->pixels);
}

static bool down_block(const sweep *s, worker *w, int block) {
    const int y = block * s->f.lanes, tiles = (s->f.width + TILE - 1) / TILE;
    load_block(s, w, y);
    if (!s->f.k->rows->forward(&w->block) && s->first) { /* later substeps find them filled, with or without a CoC */
        w->holes += block_find_holes(&s->f, &w->block.in, &w->room);
        s->f.k->rows->forward(&w->block);
    }
    for (int t = 0; t < tiles; t++) {
        int x0 = (tiles - 1 - t) * TILE, x1 = x0 + TILE < s->f.width ? x0 + TILE : s->f.width;
        s->f.k->rows->backward(&w->block, x0, x1);
        if (block > 0 && !block_wait(s->f.ctx, &s->done[block - 1], t + 1)) return false;
        columns_of_tile(s, w, y, x0, x1);
        atomic_store_explicit(&s->done[block], t + 1, memory_order_release);
    }
    return context_progress(s->f.ctx, w->block.in.count);
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
    for (int y = s->f.height - 2; y >= 0; y--) {
        float *row = image_at(&s->work, 0, x0, y), *below = image_at(&s->work, 0, x0, y + 1);
        s->f.k->columns->up(row, s->keep + s->keep_stride * y + x0, below, x1 - x0);
        if (y % 64 == 0 && !context_progress(s->f.ctx, 0)) return;
    }
}

/* The result is of another type than the work image, or planar: a strip, row by row, through float RGBA; where that lies in scratch,
 * in place there. */
static void up_converting(const sweep *s, worker *w, int x0, int x1) {
    float *row = w->room.pixels, *below = w->room.pixels + ((ptrdiff_t)s->f.width + PAD) * 4;
    const bool in_work = s->work_direct && s->work.plane[0].data != s->result.plane[0].data;
    for (int y = s->f.height - 1; y >= 0; y--) {
        if (in_work)
            row = image_at(&s->work, 0, x0, y);
        else
            span_load(&s->work, x0, y, x1 - x0, row, false, s->f.k->pixels);
        if (y < s->f.height - 1) s->f.k->columns->up(row, s->keep + s->keep_stride * y + x0, below, x1 - x0);
        span_store(&s->result, x0, y, x1 - x0, row, s->straight_out, s->f.k->pixels);
        float *swap = row;
        row = below;
        below = swap;
        if (y % 64 == 0 && !context_progress(s->f.ctx, 0)) return;
    }
}

static int strip_count(const sweep *s) {
    int most = (s->f.width + TILE - 1) / TILE;
    return s->f.ctx->threads < most ? s->f.ctx->threads : most;
}

static void up(void *data, int index, int id) {
    const sweep *s = data;
    const int strips = strip_count(s), lines = (s->f.width + 15) / 16;
    int x0 = (int)((int64_t)lines * index / strips) * 16, x1 = (int)((int64_t)lines * (index + 1) / strips) * 16;
    if (x1 > s->f.width) x1 = s->f.width;
    if (s->work_direct && s->work.plane[0].data == s->result.plane[0].data && !s->straight_out)
        up_direct(s, x0, x1);
    else
        up_converting(s, &s->worker[id], x0, x1);
    context_progress(s->f.ctx, (int64_t)s->f.height * (x1 - x0) / s->f.width);
}

/* ---- the frame */

static bool aligned(const ddof_image *image) {
    return ((uintptr_t)image->plane[0].data | (uintptr_t)image->plane[0].row_stride) % LINE == 0;
}

static ddof_status substep(sweep *s) {
    const ddof_config *config = &s->f.ctx->config;
    s->f.source_direct = image_is_rgba(&s->f.source) && !s->f.straight_in;
    s->work_direct = image_is_rgba(&s->work);
    const bool in_place = s->f.source.plane[0].data == s->work.plane[0].data;
    s->stream = s->work_direct && !in_place && aligned(&s->work) && s->f.width >= TILE;
    s->next = 0;
    for (int i = 0; i < s->blocks; i++) atomic_init(&s->done[i], 0);
    size_t wide = (size_t)s->f.width + PAD;
    memset(s->columns.rest, 0, wide * sizeof(float));
    memset(s->columns.mean, 0, wide * 4 * sizeof(float));
    int tasks = s->f.ctx->threads < s->blocks ? s->f.ctx->threads : s->blocks;
    if (config->parallel_for(config->parallel_user, tasks, down, s)) return DDOF_ERROR_MEMORY;
    if (s->f.ctx->cancelled) return DDOF_ERROR_CANCELLED;
    if (config->parallel_for(config->parallel_user, strip_count(s), up, s)) return DDOF_ERROR_MEMORY;
    return s->f.ctx->cancelled ? DDOF_ERROR_CANCELLED : DDOF_OK;
}

ddof_status cpu_diffuse(ddof_context *ctx, frame_job *job, void *scratch) {
    if (job->disc) return disc_diffuse(ctx, job, scratch);
    const ddof_frame *frame = job->frame;
    sweep s = {.f = {.ctx = ctx, .job = job, .k = ctx->kernels, .width = frame->color.width, .height = frame->color.height}};
    arena a = {.base = scratch};
    ddof_image color = frame->color, output = frame->output;
    const bool straight = color.alpha == DDOF_ALPHA_STRAIGHT;

    s.f.lanes = s.f.k->lanes;
    s.blocks = block_count(s.f.height, s.f.lanes);
    lay_out(ctx, job, &s, &a);
    color.alpha = output.alpha = DDOF_ALPHA_PREMULTIPLIED; /* from here on the straight_* flags say it */
    image_resolve(&color);
    image_resolve(&output);
    image_resolve(&job->coc_source);
    s.f.coc_direct = !job->is_depth && plane_is_tight(&job->coc_source.plane[0]);
    if (!needs_work_image(job)) s.work = output;
    image_resolve(&s.work);

    ctx->progress_total = 2.0 * s.f.height * job->substeps;
    ddof_status status = DDOF_OK;
    for (int i = 0; i < job->substeps && status == DDOF_OK; i++) {
        const bool last = i == job->substeps - 1;
        s.first = i == 0;
        s.f.source = s.first ? color : s.work;
        s.f.rows = s.first ? job->source_rows : NULL;
        s.f.straight_in = s.first && straight;
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
    float *room = w->s->worker[id].room.coc;
    const int y0 = index * w->s->f.lanes, y1 = y0 + w->s->f.lanes < w->s->f.height ? y0 + w->s->f.lanes : w->s->f.height;
    long long bad = 0;
    for (int y = y0; y < y1; y++) {
        const float *row = block_coc_row(&w->s->f, y, room);
        for (int x = 0; x < w->s->f.width; x++) bad += !finite_value(row[x]);
        plane_store(&w->output, 0, 0, y, w->s->f.width, row, w->s->f.k->pixels);
    }
    atomic_fetch_add(&w->bad, bad);
    context_progress(w->s->f.ctx, y1 - y0);
}

ddof_status cpu_coc(ddof_context *ctx, frame_job *job, void *scratch) {
    const ddof_image *in = &job->coc_source;
    sweep s = {.f = {.ctx = ctx, .job = job, .k = ctx->kernels, .width = in->width, .height = in->height}};
    arena a = {.base = scratch};
    coc_work w = {.s = &s, .output = job->frame->output};
    s.f.lanes = s.f.k->lanes;
    lay_out(ctx, job, &s, &a);
    image_resolve(&w.output);
    image_resolve(&job->coc_source);
    ctx->progress_total = s.f.height;
    if (ctx->config.parallel_for(ctx->config.parallel_user, block_count(s.f.height, s.f.lanes), coc_rows, &w))
        return DDOF_ERROR_MEMORY;
    job->nonfinite_pixels = w.bad;
    return ctx->cancelled ? DDOF_ERROR_CANCELLED : DDOF_OK;
}
