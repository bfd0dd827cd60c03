/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The classical methods on the CPU: which lines of which picture are gathered to make which. The arithmetic is in gather.c. */
#include "../methods.h"

#include "../image.h"
#include "block.h"
#include "engine.h"

typedef struct work {
    const gather_kernels *k;
    const pixel_kernels *pixels;
    filled_picture source, first, second; /* one CoC; those of the first pass have colours of their own. HEXAGON: V, X */
    gather_line line[HEXAGON_LINES];
    ddof_image output; /* resolved */
    bool straight;
} work;

static void *take_pictures(const frame_job *job, work *w, arena *a) {
    const size_t n = (size_t)job->coc_source.width * (size_t)job->coc_source.height * sizeof(float), fill = filled_bytes(job);
    w->source.rgba = arena_take(a, 4 * n);
    w->source.coc = arena_take(a, n);
    const arena begin = *a;
    w->first.rgba = arena_take(a, 4 * n);
    if (job->method == DDOF_METHOD_HEXAGON) w->second.rgba = arena_take(a, 4 * n);
    if (a->used < begin.used + fill) a->used = begin.used + fill; /* holes are filled before the first pass */
    return begin.base ? begin.base + begin.used : NULL;
}

size_t cpu_method_bytes(const frame_job *job) {
    work w = {0};
    arena a = {0};
    take_pictures(job, &w, &a);
    return a.used;
}

static float *pixel_at(const filled_picture *p, int x, int y) {
    return p->rgba + 4 * ((ptrdiff_t)p->width * y + x);
}

/* Chunk by chunk down a band of rows, for these share most of what they gather. */
static void chunks(const work *w, int y0, int y1, void (*make)(const work *w, int x, int y, int count)) {
    for (int x = 0; x < w->source.width; x += GATHER_CHUNK)
        for (int y = y0; y < y1; y++)
            make(w, x, y, w->source.width - x < GATHER_CHUNK ? w->source.width - x : GATHER_CHUNK);
}

static ddof_status run(ddof_context *ctx, frame_job *job, work *w, void *scratch, void (*first)(void *user, int y0, int y1),
                       void (*second)(void *user, int y0, int y1)) {
    arena a = {.base = scratch};
    w->k = ctx->kernels->gather;
    w->pixels = ctx->kernels->pixels;
    w->output = job->frame->output;
    w->straight = job->frame->color.alpha == DDOF_ALPHA_STRAIGHT;
    image_resolve(&w->output);
    void *fill = take_pictures(job, w, &a);
    ctx->progress_total = 3.0 * job->coc_source.height;
    ddof_status status = filled_load(ctx, job, &w->source, fill);
    if (status != DDOF_OK) return status;
    float *v = w->first.rgba, *x = w->second.rgba;
    w->first = w->second = w->source;
    w->first.rgba = v;
    w->second.rgba = x;
    if (job->method == DDOF_METHOD_HEXAGON)
        hexagon_lines(w->line, job, &w->source);
    else
        gaussian_lines(w->line, job, &w->source);
    status = filled_rows(ctx, w->source.height, first, w);
    return status == DDOF_OK ? filled_rows(ctx, w->source.height, second, w) : status;
}

/* ---- gaussian */

static void gaussian_row(const work *w, int x, int y, int count) {
    w->k->mean(&w->source, &w->line[LINE_ROW], x, y, count, pixel_at(&w->first, x, y));
}

static void gaussian_column(const work *w, int x, int y, int count) {
    float rgba[4 * GATHER_CHUNK];
    w->k->mean(&w->first, &w->line[LINE_COLUMN], x, y, count, rgba);
    span_store(&w->output, x, y, count, rgba, w->straight, w->pixels);
}

static void gaussian_rows(void *user, int y0, int y1) {
    chunks(user, y0, y1, gaussian_row);
}

static void gaussian_columns(void *user, int y0, int y1) {
    chunks(user, y0, y1, gaussian_column);
}

ddof_status cpu_gaussian(ddof_context *ctx, frame_job *job, void *scratch) {
    work w = {0};
    return run(ctx, job, &w, scratch, gaussian_rows, gaussian_columns);
}

/* ---- hexagon */

static void hexagon_sides(const work *w, int x, int y, int count) {
    float *v = pixel_at(&w->first, x, y), *both = pixel_at(&w->second, x, y);
    w->k->mean(&w->source, &w->line[LINE_UP], x, y, count, v);
    w->k->mean(&w->source, &w->line[LINE_LEFT], x, y, count, both);
    for (int i = 0; i < 4 * count; i++) both[i] = 0.5f * (v[i] + both[i]);
}

static void hexagon_rhombi(const work *w, int x, int y, int count) {
    float one[4 * GATHER_CHUNK], two[4 * GATHER_CHUNK];
    w->k->mean(&w->first, &w->line[LINE_LEFT], x, y, count, one);
    w->k->mean(&w->second, &w->line[LINE_RIGHT], x, y, count, two);
    for (int i = 0; i < 4 * count; i++) one[i] = (one[i] + 2 * two[i]) / 3;
    span_store(&w->output, x, y, count, one, w->straight, w->pixels);
}

static void hexagon_first(void *user, int y0, int y1) {
    chunks(user, y0, y1, hexagon_sides);
}

static void hexagon_second(void *user, int y0, int y1) {
    chunks(user, y0, y1, hexagon_rhombi);
}

ddof_status cpu_hexagon(ddof_context *ctx, frame_job *job, void *scratch) {
    work w = {0};
    return run(ctx, job, &w, scratch, hexagon_first, hexagon_second);
}
