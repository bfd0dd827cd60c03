/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* A pyramid of weighted means (push), each level half as large; then, from the coarsest level down (pull), what a pixel lacks
 * is interpolated in the level above: from the means there as far as their weights say that they are known, the rest
 * from what that level has got from its own next (Gortler et al. 1996, with the pull weighted too: a pixel takes what
 * lies beside it before what is only near it). Constant time per pixel, however large the holes. */
#include "fill.h"

enum { LEVELS = 24, BAND = 16 /* rows of a task */ };

/* Full trust in interpolated means whose weights sum to 1/TRUST or more. */
#define TRUST 4.0f

typedef struct level {
    int width, height;
    ptrdiff_t stride;
    float *value;  /* weighted sums, divided so that no weight exceeds 1; level 0: the values themselves */
    const float *weight;
    float *made;   /* the weights where this level's own; level 0: NULL, they are the caller's */
    float *filled; /* level 0: value */
} level;

typedef struct pyramid {
    ddof_context *ctx;
    level level[LEVELS];
    int levels, channels;
    int at; /* the level that is being made */
} pyramid;

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
        l->stride = l->width;
        const size_t plane = align((size_t)l->width * (size_t)l->height * sizeof(float)), c = (size_t)p->channels;
        if (base) {
            l->made = (float *)(void *)(base + used);
            l->weight = l->made;
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

/* ---- push */

static inline __attribute__((always_inline)) void push_row(const level *from, level *to, int y, int channels, bool first) {
    const int rows = 2 * y + 1 < from->height ? 2 : 1;
    for (int x = 0; x < to->width; x++) {
        float sum[4] = {0}, weight = 0;
        const int columns = 2 * x + 1 < from->width ? 2 : 1;
        for (int v = 0; v < rows; v++)
            for (int u = 0; u < columns; u++) {
                const ptrdiff_t i = from->stride * (2 * y + v) + 2 * x + u;
                const float w = from->weight[i], scale = first ? w : 1;
                weight += w;
                for (int c = 0; c < channels; c++) sum[c] += scale * from->value[channels * i + c];
            }
        const ptrdiff_t o = to->stride * y + x;
        const float scale = weight > 1 ? 1 / weight : 1;
        to->made[o] = weight * scale;
        for (int c = 0; c < channels; c++) to->value[channels * o + c] = sum[c] * scale;
    }
}

static void push(void *data, int index, int worker) {
    pyramid *p = data;
    const level *from = &p->level[p->at - 1];
    level *to = &p->level[p->at];
    (void)worker;
    for (int y = index * BAND; y < (index + 1) * BAND && y < to->height; y++)
        if (p->channels == 4)
            push_row(from, to, y, 4, p->at == 1);
        else
            push_row(from, to, y, 1, p->at == 1);
}

/* ---- pull */

/* The four pixels of the level above around a pixel, and their shares. */
typedef struct corners {
    ptrdiff_t at[4];
    float share[4];
} corners;

static inline void along(int x, int count, int *first, int *second, float *share) {
    const int left = (x - 1) >> 1; /* centres: x + 1/2 of this level is x/2 + 1/4 of the one above */
    *share = x % 2 ? 0.25f : 0.75f;
    *first = left < 0 ? 0 : left;
    *second = left + 1 < count ? left + 1 : count - 1;
}

static inline corners around(const level *above, int x, int y) {
    int x0, x1, y0, y1;
    float s, t;
    along(x, above->width, &x0, &x1, &s);
    along(y, above->height, &y0, &y1, &t);
    return (corners){{above->stride * y0 + x0, above->stride * y0 + x1, above->stride * y1 + x0, above->stride * y1 + x1},
                     {(1 - s) * (1 - t), s * (1 - t), (1 - s) * t, s * t}};
}

static inline __attribute__((always_inline)) void pull_row(const level *here, const level *above, int y, int channels,
                                                           bool first) {
    for (int x = 0; x < here->width; x++) {
        const ptrdiff_t i = here->stride * y + x;
        const float lack = 1 - here->weight[i], own = first ? here->weight[i] : 1;
        const float *value = here->value + channels * i;
        float *filled = here->filled + channels * i;
        if (!(lack > 0)) {
            for (int c = 0; c < channels; c++) filled[c] = value[c];
            continue;
        }
        const corners k = around(above, x, y);
        float weight = 0, known[4] = {0}, rest[4] = {0};
        for (int j = 0; j < 4; j++) {
            weight += k.share[j] * above->weight[k.at[j]];
            for (int c = 0; c < channels; c++) {
                known[c] += k.share[j] * above->value[channels * k.at[j] + c];
                rest[c] += k.share[j] * above->filled[channels * k.at[j] + c];
            }
        }
        const float trust = weight * TRUST < 1 ? weight * TRUST : 1, scale = weight > 1e-30f ? trust / weight : 0;
        for (int c = 0; c < channels; c++) filled[c] = own * value[c] + lack * (scale * known[c] + (1 - trust) * rest[c]);
    }
}

static void pull(void *data, int index, int worker) {
    pyramid *p = data;
    const level *here = &p->level[p->at], *above = here + 1;
    (void)worker;
    for (int y = index * BAND; y < (index + 1) * BAND && y < here->height; y++)
        if (p->channels == 4)
            pull_row(here, above, y, 4, p->at == 0);
        else
            pull_row(here, above, y, 1, p->at == 0);
}

/* Of the single pixel of the coarsest level. */
static void finish_top(pyramid *p) {
    const level *top = &p->level[p->levels - 1];
    const float w = top->weight[0], scale = p->levels == 1 ? (w > 0) : w > 0 ? 1 / w : 0;
    for (int c = 0; c < p->channels; c++) top->filled[c] = scale * top->value[c];
}

static ddof_status run(pyramid *p, ddof_task task) {
    const ddof_config *config = &p->ctx->config;
    const int bands = (p->level[p->at].height + BAND - 1) / BAND;
    if (bands == 1)
        task(p, 0, 0);
    else if (config->parallel_for(config->parallel_user, bands, task, p))
        return DDOF_ERROR_MEMORY;
    return p->ctx->cancelled ? DDOF_ERROR_CANCELLED : DDOF_OK;
}

ddof_status fill_unknown(ddof_context *ctx, const fill_picture *picture, void *scratch) {
    pyramid p = {.ctx = ctx, .channels = picture->channels};
    level *base = &p.level[0];
    *base = (level){picture->width, picture->height, picture->stride, picture->value, picture->weight, NULL, picture->value};
    lay_out(&p, scratch);
    ddof_status status = DDOF_OK;
    for (p.at = 1; p.at < p.levels && status == DDOF_OK; p.at++) status = run(&p, push);
    if (status != DDOF_OK) return status;
    finish_top(&p);
    for (p.at = p.levels - 2; p.at >= 0 && status == DDOF_OK; p.at--) status = run(&p, pull);
    return status;
}
