/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The CPU engine for the disc kernel: which rows are worked on when, by whom, in what memory. The arithmetic is in
 * disc_rows.c and disc_lines.c.
 *
 * One component after the other. Its solves follow each other in sweeps over the picture, down and up in turn, each of
 * which ends one solve and begins the next, so that a pixel passes through memory once for each direction: source,
 * rows, elimination of the columns                  down substitution of the columns, elimination of the diagonals up
 *     substitution of the diagonals, of the antidiagonals elimination   down
 *     substitution of the antidiagonals, and either the result  up
 *     or the next substep: rows, elimination of the columns
 * Between sweeps a pixel is a complex mean and its `keep`, 40 bytes in scratch.
 *
 * Columns and diagonals are LINES with an index: x of a column, x - y and x + y of the diagonals but for a constant.
 * What a sweep carries from row to row is kept by line, so a diagonal finds its own wherever it passes. Lines begin and
 * end where a link leads out of the picture: it conducts nothing, and what was carried there before has no weight.
 *
 * Workers take blocks of rows in order. Within a block tiles go from left to right, and each row of a tile lies
 * DISC_SKEW pixels farther left than the one before, so that the neighbours of its pixels, on whichever side, are done;
 * of the block before only a few more tiles must be. */
#include "disc_engine.h"

#include <string.h>

#include "../image.h"

enum { SOURCE = -1, RESULT = -1 };

typedef struct disc_worker {
    disc_block block;
    block_room room;
    float *row; /* of the result, on its way to an output that is not RGBA float */
    int64_t holes;
} disc_worker;

typedef struct disc_run {
    cpu_frame f;
    const disc_kernels *k;
    const disc_kernel *kernel;
    int padded; /* width, in whole vectors */
    ptrdiff_t stride, coc_stride;
    float *coc;      /* magnitudes: of pixel (0, 0); -1 all around the picture */
    bool *coc_holes; /* rows with a CoC that is not finite */
    float *state;    /* rows of complex means and keep */
    size_t line_count;
    disc_span solved, eliminated;                /* by line: the solution; mean and rest */
    atomic_int *solved_tiles, *eliminated_tiles; /* per block */
    float *sum;                                  /* of the components so far; NULL: in the output */
    ddof_image output;
    bool straight_out, output_direct;
    disc_worker *worker;

    /* the sweep under way */
    int component;
    int from, to; /* directions of disc.h; SOURCE, RESULT */
    bool up;
    int rows; /* of a block */
    disc_link link, row_link;
    atomic_int next; /* block to hand out */
} disc_run;

static bool output_is_direct(const frame_job *job) {
    ddof_image output = job->frame->output;
    output.alpha = job->frame->color.alpha;
    image_resolve(&output);
    return image_is_rgba(&output);
}

/* The sum may grow in the output where that is RGBA float and the source does not lie there. */
static bool needs_sum(const frame_job *job) {
    const bool in_place = job->frame->color.plane[0].data == job->frame->output.plane[0].data;
    return job->disc->components > 1 && (in_place || !output_is_direct(job));
}

static disc_span take_lines(arena *a, size_t count) {
    const size_t pixels = count * 4 * sizeof(float), values = count * sizeof(float);
    disc_span lines;
    lines.re = arena_take(a, pixels);
    lines.im = arena_take(a, pixels);
    lines.keep_re = arena_take(a, values);
    lines.keep_im = arena_take(a, values);
    return lines;
}

static void take_worker(disc_worker *w, arena *a, int width, int lanes) {
    const size_t wide = (size_t)width + PAD, n = (size_t)lanes, f = sizeof(float);
    w->block.mean = arena_take(a, wide * n * 8 * f);
    w->block.keep = arena_take(a, wide * n * 2 * f);
    w->block.tile_re = arena_take(a, n * TILE * 4 * f);
    w->block.tile_im = arena_take(a, n * TILE * 4 * f);
    w->row = arena_take(a, wide * 4 * f);
    block_room_take(&w->room, a, width, lanes);
}

static void lay_out(const ddof_context *ctx, const frame_job *job, disc_run *run, arena *a) {
    const int width = job->coc_source.width, lanes = ctx->kernels->lanes;
    const size_t height = (size_t)job->coc_source.height, f = sizeof(float);
    const size_t blocks = (size_t)block_count((int)height, DISC_ROWS_AT_ONCE); /* no vector has fewer lanes */

    run->stride = (width + PAD - 1) / PAD * PAD;
    run->coc_stride = run->stride + 2 * PAD;
    run->state = arena_take(a, (size_t)run->stride * 10 * height * f);
    run->coc = arena_take(a, (size_t)run->coc_stride * (height + 2) * f);
    if (a->base) run->coc += run->coc_stride + PAD;
    run->coc_holes = arena_take(a, height * sizeof(bool));
    run->line_count = (size_t)run->stride + height + PAD;
    run->solved = take_lines(a, run->line_count);
    run->eliminated = take_lines(a, run->line_count);
    run->solved_tiles = arena_take(a, sizeof(atomic_int) * blocks);
    run->eliminated_tiles = arena_take(a, sizeof(atomic_int) * blocks);
    if (needs_sum(job)) run->sum = arena_take(a, (size_t)width * height * 4 * f);
    run->worker = arena_take(a, sizeof(disc_worker) * (size_t)ctx->threads);
    for (int t = 0; t < ctx->threads; t++) {
        disc_worker w = {0};
        take_worker(&w, a, width, lanes);
        if (a->base) run->worker[t] = w;
    }
}

size_t disc_scratch_bytes(const ddof_context *ctx, const frame_job *job) {
    disc_run run = {0};
    arena a = {0};
    lay_out(ctx, job, &run, &a);
    return a.used;
}

/* ---- the rows of a sweep */

/* Pixel (x, y) of the state. */
static disc_span state_at(const disc_run *run, int x, int y) {
    float *row = run->state + run->stride * 10 * y;
    return (disc_span){row + 4 * x, row + 4 * (run->stride + x), row + 8 * run->stride + x, row + 9 * run->stride + x};
}

static const float *coc_at(const disc_run *run, int x, int y) {
    return run->coc + run->coc_stride * y + x;
}

/* How far a line of this direction moves to the right from a row to the one below. */
static int lean(int direction) {
    return direction == DISC_DIAGONAL ? 1 : direction == DISC_ANTIDIAGONAL ? -1 : 0;
}

/* The line through pixel (x, y). */
static disc_span lines_at(const disc_run *run, const disc_span *lines, int direction, int x, int y) {
    const ptrdiff_t l = direction == DISC_DIAGONAL       ? x - y + run->f.height - 1
                        : direction == DISC_ANTIDIAGONAL ? x + y
                                                         : x;
    return (disc_span){lines->re + 4 * l, lines->im + 4 * l, lines->keep_re + l, lines->keep_im + l};
}

static void eliminate_span(disc_run *run, int x, int y, int count, float g, const float *re, const float *im) {
    const int down = run->up ? -1 : 1;
    const disc_span lines = lines_at(run, &run->eliminated, run->to, x, y), out = state_at(run, x, y);
    run->k->eliminate(&run->link, &lines, coc_at(run, x, y), coc_at(run, x + down * lean(run->to), y + down), g, re, im,
                      &out, count, run->from == SOURCE);
}

/* Ends the last solve of a span and adds the component's part to the result, which the last component completes. */
static void finish_span(disc_run *run, disc_worker *w, int x, int y, int count, const disc_span *lines) {
    const disc_component *c = &run->kernel->component[run->component];
    const bool first = run->component == 0, last = run->component == run->kernel->components - 1;
    const disc_span state = state_at(run, x, y);
    if (x + count > run->f.width) count = run->f.width - x;
    float *sum = run->sum             ? run->sum + ((ptrdiff_t)run->f.width * y + x) * 4
                 : run->output_direct ? image_at(&run->output, 0, x, y)
                                      : NULL;
    float *out = !last ? sum : run->output_direct ? image_at(&run->output, 0, x, y) : w->row;
    run->k->finish(lines, &state, (float)c->weight_re, (float)c->weight_im, first ? NULL : sum, out, count);
    if (last && !run->output_direct) span_store(&run->output, x, y, count, out, run->straight_out, run->f.k->pixels);
}

/* ---- a block without rows: tiles of skewed rows */

/* Row y of the block's tile: ends the solve before; begins the next, or hands on the solution. */
static void tile_row(disc_run *run, disc_worker *w, int x, int y, int count) {
    const disc_span solved = lines_at(run, &run->solved, run->from, x, y), state = state_at(run, x, y);
    if (run->to == RESULT) {
        finish_span(run, w, x, y, count, &solved);
    } else if (run->to == DISC_COLUMNS) { /* after rows, which go on with the solution */
        run->k->substitute(&solved, &state, count);
    } else {
        const int down = run->up ? -1 : 1;
        const disc_span lines = lines_at(run, &run->eliminated, run->to, x, y);
        run->k->turn(&run->link, &solved, &lines, coc_at(run, x, y), coc_at(run, x + down * lean(run->to), y + down),
                     &state, count);
    }
}

static int block_row(const disc_run *run, int block, int r) {
    const int at = block * run->rows + r;
    return run->up ? run->f.height - 1 - at : at;
}

static int rows_in_block(const disc_run *run, int block) {
    const int left = run->f.height - block * run->rows;
    return left < run->rows ? left : run->rows;
}

static bool solve_block(disc_run *run, disc_worker *w, int block) {
    const int slant = DISC_SKEW * (run->rows - 1), tiles = (run->padded + slant + DISC_TILE - 1) / DISC_TILE;
    const int ahead = (slant + 1 + DISC_TILE - 1) / DISC_TILE, count = rows_in_block(run, block);
    for (int t = 0; t < tiles; t++) {
        const int wanted = t + 1 + ahead < tiles ? t + 1 + ahead : tiles;
        if (block > 0 && !block_wait(run->f.ctx, &run->solved_tiles[block - 1], wanted)) return false;
        for (int r = 0; r < count; r++) {
            int x0 = t * DISC_TILE - r * DISC_SKEW, x1 = x0 + DISC_TILE;
            if (x0 < 0) x0 = 0;
            if (x1 > run->padded) x1 = run->padded;
            if (x0 < x1) tile_row(run, w, x0, block_row(run, block, r), x1 - x0);
        }
        atomic_store_explicit(&run->solved_tiles[block], t + 1, memory_order_release);
    }
    return true;
}

/* ---- a block with rows */

static void set_magnitudes(const disc_run *run, cpu_rows *in, int y) {
    for (int r = 0; r < run->f.lanes; r++)
        in->coc[r] = coc_at(run, 0, y + (r < in->count ? r : in->count - 1));
}

/* Rows of the source, eliminated; in its first look at a block a component finds the holes, too. */
static void forward_source(disc_run *run, disc_worker *w, int y, int count) {
    cpu_rows *in = &w->block.in;
    bool holes = false;
    block_load_pixels(&run->f, in, &w->room, y, count);
    set_magnitudes(run, in, y);
    w->block.imaginary[0] = NULL;
    for (int r = 0; r < count; r++)
        holes |= run->coc_holes[y + r];
    if (!holes && run->k->forward(&w->block, &run->row_link)) return;
    block_load_coc(&run->f, in, &w->room, y);
    const int64_t found = block_find_holes(&run->f, in, &w->room);
    if (run->component == 0) w->holes += found;
    set_magnitudes(run, in, y);
    run->k->forward(&w->block, &run->row_link);
}

static void forward_state(disc_run *run, disc_worker *w, int y, int count) {
    cpu_rows *in = &w->block.in;
    in->width = run->f.width;
    in->count = count;
    in->capacity = NULL;
    for (int r = 0; r < run->f.lanes; r++) {
        const disc_span row = state_at(run, 0, y + (r < count ? r : count - 1));
        in->pixel[r] = row.re;
        w->block.imaginary[r] = row.im;
        in->row_alive[r] = 1;
    }
    set_magnitudes(run, in, y);
    run->k->forward(&w->block, &run->row_link);
}

static bool rows_block(disc_run *run, disc_worker *w, int block) {
    const int tiles = block_count(run->f.width, TILE), count = rows_in_block(run, block);
    const int top = block_row(run, block, run->up ? count - 1 : 0);
    if (run->from == SOURCE)
        forward_source(run, w, top, count);
    else
        forward_state(run, w, top, count);
    memset(w->block.carry, 0, sizeof w->block.carry);
    for (int t = 0; t < tiles; t++) {
        const int x0 = (tiles - 1 - t) * TILE, x1 = x0 + TILE < run->padded ? x0 + TILE : run->padded;
        run->k->backward(&w->block, x0, x1);
        if (block > 0 && !block_wait(run->f.ctx, &run->eliminated_tiles[block - 1], t + 1)) return false;
        for (int r = 0; r < count; r++) {
            const int lane = run->up ? count - 1 - r : r;
            const ptrdiff_t at = (ptrdiff_t)lane * TILE * 4;
            eliminate_span(run, x0, top + lane, x1 - x0, w->block.in.row_alive[lane], w->block.tile_re + at,
                           w->block.tile_im + at);
        }
        atomic_store_explicit(&run->eliminated_tiles[block], t + 1, memory_order_release);
    }
    return true;
}

/* ---- the sweeps of a component */

static void sweep_task(void *data, int index, int id) {
    disc_run *run = data;
    const int blocks = block_count(run->f.height, run->rows);
    (void)index; /* blocks are handed out in order, whatever the order of the tasks */
    for (;;) {
        const int block = atomic_fetch_add(&run->next, 1);
        if (block >= blocks) return;
        if (run->from != SOURCE && !solve_block(run, &run->worker[id], block)) return;
        if (run->to == DISC_COLUMNS && !rows_block(run, &run->worker[id], block)) return;
        if (!context_progress(run->f.ctx, rows_in_block(run, block))) return;
    }
}

static disc_link link_of(const disc_run *run, int direction) {
    const disc_component *c = &run->kernel->component[run->component];
    const disc_share share = disc_direction(run->kernel, direction, run->f.job->pixel_aspect);
    return (disc_link){(float)(share.level - share.slope),
                       (float)(share.level * run->kernel->fade),
                       (float)run->kernel->fade,
                       (float)disc_excess(run->kernel),
                       (float)c->beta_re,
                       (float)c->beta_im,
                       (float)c->offset_re,
                       (float)c->offset_im};
}

static void clear_lines(const disc_span *lines, size_t count) {
    memset(lines->re, 0, count * 4 * sizeof(float));
    memset(lines->im, 0, count * 4 * sizeof(float));
    memset(lines->keep_re, 0, count * sizeof(float));
    memset(lines->keep_im, 0, count * sizeof(float));
}

static ddof_status parallel(disc_run *run, int count, ddof_task task) {
    const ddof_config *config = &run->f.ctx->config;
    if (config->parallel_for(config->parallel_user, count, task, run)) return DDOF_ERROR_MEMORY;
    return run->f.ctx->cancelled ? DDOF_ERROR_CANCELLED : DDOF_OK;
}

static ddof_status sweep(disc_run *run, int from, int to) {
    run->from = from;
    run->to = to;
    run->rows = to == DISC_COLUMNS ? run->f.lanes : DISC_ROWS_AT_ONCE;
    if (to != RESULT) run->link = link_of(run, to);
    run->row_link = link_of(run, DISC_ROWS);
    clear_lines(&run->solved, run->line_count);
    clear_lines(&run->eliminated, run->line_count);
    const int blocks = block_count(run->f.height, run->rows);
    for (int i = 0; i < blocks; i++) {
        atomic_init(&run->solved_tiles[i], 0);
        atomic_init(&run->eliminated_tiles[i], 0);
    }
    run->next = 0;
    const ddof_status status = parallel(run, run->f.ctx->threads < blocks ? run->f.ctx->threads : blocks, sweep_task);
    run->up = !run->up;
    return status;
}

static int sweep_count(const disc_kernel *kernel) {
    return kernel->substeps * (kernel->directions - 1) + 1;
}

static ddof_status component(disc_run *run) {
    int from = SOURCE;
    ddof_status status = DDOF_OK;
    run->up = false;
    for (int i = 0; i < run->kernel->substeps && status == DDOF_OK; i++) {
        status = sweep(run, from, DISC_COLUMNS);
        from = DISC_COLUMNS;
        if (run->kernel->directions == 2) continue;
        if (status == DDOF_OK) status = sweep(run, DISC_COLUMNS, DISC_DIAGONAL);
        if (status == DDOF_OK) status = sweep(run, DISC_DIAGONAL, DISC_ANTIDIAGONAL);
        from = DISC_ANTIDIAGONAL;
    }
    return status == DDOF_OK ? sweep(run, from, RESULT) : status;
}

/* ---- the frame */

/* Magnitudes of the CoC, which all sweeps read. */
static void magnitude_task(void *data, int index, int id) {
    disc_run *run = data;
    const int y0 = index * MAX_LANES, y1 = y0 + MAX_LANES < run->f.height ? y0 + MAX_LANES : run->f.height;
    for (int y = y0; y < y1; y++) {
        const float *row = block_coc_row(&run->f, y, run->worker[id].room.coc);
        float *out = run->coc + run->coc_stride * y;
        run->coc_holes[y] = !run->k->magnitude(row, out, run->f.width, (int)run->stride + PAD);
        for (int x = 1; x <= PAD; x++)
            out[-x] = -1;
    }
}

static ddof_status magnitudes(disc_run *run) {
    float *above = run->coc - run->coc_stride - PAD, *below = run->coc + run->coc_stride * run->f.height - PAD;
    for (ptrdiff_t x = 0; x < run->coc_stride; x++)
        above[x] = below[x] = -1;
    return parallel(run, block_count(run->f.height, MAX_LANES), magnitude_task);
}

ddof_status disc_diffuse(ddof_context *ctx, frame_job *job, void *scratch) {
    const ddof_frame *frame = job->frame;
    const int lanes = ctx->kernels->lanes;
    disc_run run = {.f = {.ctx = ctx,
                          .job = job,
                          .k = ctx->kernels,
                          .width = frame->color.width,
                          .height = frame->color.height,
                          .lanes = lanes,
                          .source = frame->color,
                          .rows = job->source_rows},
                    .k = ctx->kernels->disc,
                    .kernel = job->disc,
                    .output = frame->output};
    arena a = {.base = scratch};

    lay_out(ctx, job, &run, &a);
    run.padded = (run.f.width + lanes - 1) / lanes * lanes;
    run.f.straight_in = run.straight_out = frame->color.alpha == DDOF_ALPHA_STRAIGHT;
    run.output_direct = output_is_direct(job);
    run.f.source.alpha = run.output.alpha = DDOF_ALPHA_PREMULTIPLIED;
    image_resolve(&run.f.source);
    image_resolve(&run.output);
    image_resolve(&job->coc_source);
    run.f.source_direct = image_is_rgba(&run.f.source) && !run.f.straight_in;
    run.f.coc_direct = !job->is_depth && plane_is_tight(&job->coc_source.plane[0]);

    ctx->progress_total = (double)run.kernel->components * sweep_count(run.kernel) * run.f.height;
    ddof_status status = magnitudes(&run);
    for (run.component = 0; run.component < run.kernel->components && status == DDOF_OK; run.component++)
        status = component(&run);
    for (int t = 0; t < ctx->threads; t++)
        job->nonfinite_pixels += run.worker[t].holes;
    return status;
}
