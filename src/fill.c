/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* A pyramid of weighted means (push), each level half as large; then, from the coarsest level down (pull), what a pixel lacks
 * is interpolated in the level above: from the means there as far as their weights say that they are known, the rest
 * from what that level has got from its own next (Gortler et al. 1996, with the pull weighted too: a pixel takes what
 * lies beside it before what is only near it). Constant time per pixel, however large the holes. The arithmetic is in
 * cpu/fill.c. */
#include "fill.h"

#include <string.h>

#include "cpu/kernels.h"

enum { LEVELS = 24, BAND = 16 /* rows of a task */, SMALL = 1 << 14 /* pixels of a level not worth waking threads for */ };

typedef struct level {
    int width, height;
    float *value;  /* weighted sums, divided so that no weight exceeds 1 */
    float *weight;
    float *filled;
} level;

typedef struct pyramid {
    ddof_context *ctx;
    const fill_picture *picture;
    char *out;
    ptrdiff_t stride;
    level level[LEVELS]; /* 0: the picture, of which nothing is kept */
    int levels, channels;
    int at; /* the level that is being made */
} pyramid;

/* Pixels under work. */
typedef struct tile {
    float value[4 * (FILL_TILE + PAD)], weight[FILL_TILE + PAD];
} tile;

static size_t align(size_t bytes) {
    return (bytes + 63) / 64 * 64;
}

/* Levels from 1 on; with a NULL base only sizes are counted. */
static size_t lay_out(pyramid *p, char *base) {
    size_t used = 0;
    for (p->levels = 1; p->levels < LEVELS; p->levels++) {
        const level *below = &p->level[p->levels - 1];
        level *l = &p->level[p->levels];
        if (below->width == 1 && below->height == 1) break;
        *l = (level){.width = (below->width + 1) / 2, .height = (below->height + 1) / 2};
        const size_t plane = align((size_t)l->width * (size_t)l->height * sizeof(float)), c = (size_t)p->channels;
        if (base) {
            l->weight = (float *)(void *)(base + used);
            l->value = (float *)(void *)(base + used + plane);
            l->filled = (float *)(void *)(base + used + plane + plane * c);
        }
        used += plane * (1 + 2 * c);
    }
    return used;
}

size_t fill_bytes(int channels, int width, int height) {
    pyramid p = {.channels = channels, .level = {{.width = width, .height = height}}};
    return lay_out(&p, NULL);
}

static float *value_at(const pyramid *p, const level *l, int x, int y) {
    return l->value + p->channels * ((ptrdiff_t)l->width * y + x);
}

static float *filled_at(const pyramid *p, const level *l, int x, int y) {
    return l->filled + p->channels * ((ptrdiff_t)l->width * y + x);
}

static float *weight_at(const level *l, int x, int y) {
    return l->weight + (ptrdiff_t)l->width * y + x;
}

/* ---- push */

static void push_tile(const pyramid *p, int x, int y, int count) {
    const level *from = &p->level[p->at - 1], *to = from + 1;
    const float *value[2] = {NULL, NULL}, *weight[2] = {NULL, NULL};
    tile made[2];
    for (int i = 0; i < 2 && 2 * y + i < from->height; i++) {
        if (p->at == 1) {
            p->picture->load(p->picture->user, x, 2 * y + i, count, made[i].value, made[i].weight);
            value[i] = made[i].value;
            weight[i] = made[i].weight;
        } else {
            value[i] = value_at(p, from, x, 2 * y + i);
            weight[i] = weight_at(from, x, 2 * y + i);
        }
    }
    p->ctx->kernels->fill->push(p->channels, count, p->at == 1, value, weight, value_at(p, to, x / 2, y),
                                weight_at(to, x / 2, y));
}

/* ---- pull */

static void pull_tile(const pyramid *p, int x, int y, int count) {
    const level *here = &p->level[p->at], *above = here + 1;
    const int before = (y - 1) >> 1; /* centres: y + 1/2 of this level is y/2 + 1/4 of the one above */
    const int y0 = before < 0 ? 0 : before, y1 = before + 1 < above->height ? before + 1 : above->height - 1;
    const size_t pixel = (size_t)p->channels * sizeof(float), bytes = pixel * (size_t)count;
    tile t;
    if (p->at == 0) {
        p->picture->load(p->picture->user, x, y, count, t.value, t.weight);
    } else {
        memcpy(t.value, value_at(p, here, x, y), bytes);
        memcpy(t.weight, weight_at(here, x, y), (size_t)count * sizeof(float));
    }
    if (!p->picture->whole) {
        const fill_tile f = {p->channels, x, count, p->at == 0, above->width, y % 2 ? 0.25f : 0.75f,
                             {value_at(p, above, 0, y0), value_at(p, above, 0, y1)},
                             {filled_at(p, above, 0, y0), filled_at(p, above, 0, y1)},
                             {weight_at(above, 0, y0), weight_at(above, 0, y1)}};
        p->ctx->kernels->fill->pull(&f, t.value, t.weight);
    }
    memcpy(p->at ? (char *)filled_at(p, here, x, y) : p->out + p->stride * y + pixel * (size_t)x, t.value, bytes);
}

/* ---- bands of rows */

static void band(const pyramid *p, int index, int width, void (*work)(const pyramid *p, int x, int y, int count)) {
    for (int y = index * BAND; y < (index + 1) * BAND && y < p->level[p->at].height; y++)
        for (int x = 0; x < width; x += FILL_TILE) work(p, x, y, width - x < FILL_TILE ? width - x : FILL_TILE);
    if (p->at < 2) context_progress(p->ctx, 0);
}

static void push(void *data, int index, int worker) {
    const pyramid *p = data;
    (void)worker;
    band(p, index, p->level[p->at - 1].width, push_tile);
}

static void pull(void *data, int index, int worker) {
    const pyramid *p = data;
    (void)worker;
    band(p, index, p->level[p->at].width, pull_tile);
}

/* Of the single pixel of the coarsest level. */
static void finish_top(const pyramid *p) {
    const level *top = &p->level[p->levels - 1];
    const float w = top->weight[0];
    for (int c = 0; c < p->channels; c++) top->filled[c] = w > 0 ? top->value[c] / w : 0;
}

static ddof_status run(pyramid *p, ddof_task task) {
    const ddof_config *config = &p->ctx->config;
    const level *l = &p->level[p->at];
    const int bands = (l->height + BAND - 1) / BAND;
    if ((int64_t)l->width * l->height < SMALL)
        for (int i = 0; i < bands; i++) task(p, i, 0);
    else if (config->parallel_for(config->parallel_user, bands, task, p))
        return DDOF_ERROR_MEMORY;
    return p->ctx->cancelled ? DDOF_ERROR_CANCELLED : DDOF_OK;
}

/* Of a single pixel. */
static void fill_pixel(const pyramid *p) {
    float value[4], weight;
    p->picture->load(p->picture->user, 0, 0, 1, value, &weight);
    for (int c = 0; c < p->channels && !(weight > 0); c++) value[c] = 0;
    memcpy(p->out, value, (size_t)p->channels * sizeof(float));
}

ddof_status fill_unknown(ddof_context *ctx, const fill_picture *picture, float *out, ptrdiff_t stride, void *scratch) {
    pyramid p = {.ctx = ctx, .picture = picture, .out = (char *)out, .stride = stride, .channels = picture->channels};
    p.level[0] = (level){.width = picture->width, .height = picture->height};
    lay_out(&p, scratch);
    ddof_status status = DDOF_OK;
    if (picture->whole) return run(&p, pull);
    if (p.levels == 1) {
        fill_pixel(&p);
        return status;
    }
    for (p.at = 1; p.at < p.levels && status == DDOF_OK; p.at++) status = run(&p, push);
    if (status != DDOF_OK) return status;
    finish_top(&p);
    for (p.at = p.levels - 2; p.at >= 0 && status == DDOF_OK; p.at--) status = run(&p, pull);
    return status;
}
