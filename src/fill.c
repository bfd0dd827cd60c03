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
    char *room;
    size_t room_bytes; /* per worker */
} pyramid;

/* Rows under work: two with their weights, and what a pull needs. */
typedef struct row_room {
    float *value[2], *weight[2], *pull;
} row_room;

static size_t align(size_t bytes) {
    return (bytes + 63) / 64 * 64;
}

static row_room room_of(const pyramid *p, int worker) {
    const size_t n = (size_t)p->level[0].width + PAD, c = (size_t)p->channels;
    float *room = (float *)(void *)(p->room + p->room_bytes * (size_t)worker);
    return (row_room){{room, room + c * n}, {room + 2 * c * n, room + (2 * c + 1) * n}, room + (2 * c + 2) * n};
}

/* Levels from 1 on, and the workers' rows; with a NULL base only sizes are counted. */
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
    const size_t c = (size_t)p->channels, width = (size_t)p->level[0].width;
    p->room = base + used;
    p->room_bytes = align((2 * (c + 1) * (width + PAD) + fill_pull_floats(p->channels, p->level[0].width)) * sizeof(float));
    return used + p->room_bytes * (size_t)p->ctx->threads;
}

size_t fill_bytes(const ddof_context *ctx, int channels, int width, int height) {
    pyramid p = {.ctx = (ddof_context *)(uintptr_t)ctx, .channels = channels, .level = {{.width = width, .height = height}}};
    return lay_out(&p, NULL);
}

static float *value_row(const pyramid *p, const level *l, int y) {
    return l->value + (ptrdiff_t)p->channels * l->width * y;
}

static float *filled_row(const pyramid *p, const level *l, int y) {
    return l->filled + (ptrdiff_t)p->channels * l->width * y;
}

static float *weight_row(const level *l, int y) {
    return l->weight + (ptrdiff_t)l->width * y;
}

/* ---- push */

static void push_row(const pyramid *p, const row_room *room, int y) {
    const level *from = &p->level[p->at - 1], *to = from + 1;
    const float *value[2] = {NULL, NULL}, *weight[2] = {NULL, NULL};
    for (int i = 0; i < 2 && 2 * y + i < from->height; i++) {
        value[i] = room->value[i];
        weight[i] = room->weight[i];
        if (p->at == 1) {
            p->picture->row(p->picture->user, 2 * y + i, room->value[i], room->weight[i]);
        } else {
            value[i] = value_row(p, from, 2 * y + i);
            weight[i] = weight_row(from, 2 * y + i);
        }
    }
    p->ctx->kernels->fill->push(p->channels, from->width, p->at == 1, value, weight, value_row(p, to, y), weight_row(to, y));
}

static void push(void *data, int index, int worker) {
    const pyramid *p = data;
    const row_room room = room_of(p, worker);
    for (int y = index * BAND; y < (index + 1) * BAND && y < p->level[p->at].height; y++) push_row(p, &room, y);
    if (p->at == 1) context_progress(p->ctx, 0);
}

/* ---- pull */

static void pull_row(const pyramid *p, const row_room *room, int y) {
    const level *here = &p->level[p->at], *above = here + 1;
    const int before = (y - 1) >> 1; /* centres: y + 1/2 of this level is y/2 + 1/4 of the one above */
    const int y0 = before < 0 ? 0 : before, y1 = before + 1 < above->height ? before + 1 : above->height - 1;
    const size_t bytes = (size_t)p->channels * (size_t)here->width * sizeof(float);
    if (p->at == 0) {
        p->picture->row(p->picture->user, y, room->value[0], room->weight[0]);
    } else {
        memcpy(room->value[0], value_row(p, here, y), bytes);
        memcpy(room->weight[0], weight_row(here, y), (size_t)here->width * sizeof(float));
    }
    if (!p->picture->whole) {
        const fill_rows rows = {p->channels, here->width, above->width, p->at == 0, y % 2 ? 0.25f : 0.75f,
                                {value_row(p, above, y0), value_row(p, above, y1)},
                                {filled_row(p, above, y0), filled_row(p, above, y1)},
                                {weight_row(above, y0), weight_row(above, y1)}};
        p->ctx->kernels->fill->pull(&rows, room->value[0], room->weight[0], room->pull);
    }
    memcpy(p->at ? (void *)filled_row(p, here, y) : p->out + p->stride * y, room->value[0], bytes);
}

static void pull(void *data, int index, int worker) {
    const pyramid *p = data;
    const row_room room = room_of(p, worker);
    for (int y = index * BAND; y < (index + 1) * BAND && y < p->level[p->at].height; y++) pull_row(p, &room, y);
    if (p->at == 0) context_progress(p->ctx, 0);
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
    const row_room room = room_of(p, 0);
    p->picture->row(p->picture->user, 0, room.value[0], room.weight[0]);
    for (int c = 0; c < p->channels && !(room.weight[0][0] > 0); c++) room.value[0][c] = 0;
    memcpy(p->out, room.value[0], (size_t)p->channels * sizeof(float));
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
