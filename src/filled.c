/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "filled.h"

#include <string.h>

#include "coc_limits.h"
#include "fill.h"
#include "image.h"

enum { BAND = 16 /* rows of a task */ };

typedef struct work {
    ddof_context *ctx;
    frame_job *job;
    filled_picture *picture;
    ddof_image color, map; /* the caller's, resolved */
    atomic_llong holes;
    atomic_int nearest; /* bits of a float >= 0 */
} work;

/* ---- loops */

typedef struct loop {
    ddof_context *ctx;
    void (*rows)(void *user, int y0, int y1);
    void *user;
    int height;
} loop;

static void band(void *data, int index, int worker) {
    const loop *l = data;
    const int y0 = index * BAND, y1 = y0 + BAND < l->height ? y0 + BAND : l->height;
    (void)worker;
    if (l->ctx->cancelled) return;
    l->rows(l->user, y0, y1);
    context_progress(l->ctx, y1 - y0);
}

ddof_status filled_rows(ddof_context *ctx, int height, void (*rows)(void *user, int y0, int y1), void *user) {
    loop l = {ctx, rows, user, height};
    if (ctx->config.parallel_for(ctx->config.parallel_user, (height + BAND - 1) / BAND, band, &l)) return DDOF_ERROR_MEMORY;
    return ctx->cancelled ? DDOF_ERROR_CANCELLED : DDOF_OK;
}

/* ---- the picture */

static float *pixel_at(const filled_picture *p, int x, int y) {
    return p->rgba + 4 * ((ptrdiff_t)p->width * y + x);
}

static float *coc_at(const filled_picture *p, int x, int y) {
    return p->coc + (ptrdiff_t)p->width * y + x;
}

static bool finite_pixel(const filled_picture *p, int x, int y) {
    const float *v = pixel_at(p, x, y);
    return finite_value(v[0]) && finite_value(v[1]) && finite_value(v[2]) && finite_value(v[3]) && finite_value(*coc_at(p, x, y));
}

static void raise(atomic_int *most, float value) {
    int bits, old = atomic_load(most);
    memcpy(&bits, &value, sizeof bits);
    while (bits > old && !atomic_compare_exchange_weak(most, &old, bits)) {}
}

static void load_rows(void *user, int y0, int y1) {
    work *w = user;
    const filled_picture *p = w->picture;
    const frame_job *job = w->job;
    const pixel_kernels *k = w->ctx->kernels->pixels;
    const float most = (float)COC_LIMIT;
    float nearest = 0;
    int64_t holes = 0;
    for (int y = y0; y < y1; y++) {
        float *coc = coc_at(p, 0, y);
        span_load(&w->color, 0, y, p->width, pixel_at(p, 0, y), job->frame->color.alpha == DDOF_ALPHA_STRAIGHT, k);
        plane_load(&w->map, 0, 0, y, p->width, coc, k);
        if (job->is_depth) k->lens(&job->curve, coc, coc, p->width, job->frame->offset_x, y + job->frame->offset_y);
        for (int x = 0; x < p->width; x++) {
            coc[x] = coc_within(coc[x], most);
            if (finite_value(coc[x]) && -coc[x] > nearest) nearest = -coc[x];
            holes += !finite_pixel(p, x, y);
        }
    }
    raise(&w->nearest, nearest);
    atomic_fetch_add(&w->holes, holes);
}

static void known_color(void *user, int x, int y, int count, float *value, float *weight) {
    const filled_picture *p = user;
    for (int i = 0; i < count; i++) {
        weight[i] = finite_pixel(p, x + i, y) ? 1 : 0;
        for (int c = 0; c < 4; c++) value[4 * (ptrdiff_t)i + c] = weight[i] > 0 ? pixel_at(p, x + i, y)[c] : 0;
    }
}

static void known_coc(void *user, int x, int y, int count, float *value, float *weight) {
    const filled_picture *p = user;
    for (int i = 0; i < count; i++) {
        const float coc = *coc_at(p, x + i, y);
        weight[i] = finite_value(coc) ? 1 : 0;
        value[i] = weight[i] > 0 ? coc : 0;
    }
}

/* Colour first, for a pixel whose CoC alone is unknown is a hole, too. */
static ddof_status fill_holes(ddof_context *ctx, filled_picture *p, void *scratch) {
    const ptrdiff_t stride = (ptrdiff_t)sizeof(float) * p->width;
    fill_picture f = {.channels = 4, .width = p->width, .height = p->height, .load = known_color, .user = p};
    ddof_status status = fill_unknown(ctx, &f, p->rgba, 4 * stride, scratch);
    f.channels = 1;
    f.load = known_coc;
    return status == DDOF_OK ? fill_unknown(ctx, &f, p->coc, stride, scratch) : status;
}

size_t filled_bytes(const frame_job *job) {
    return fill_bytes(4, job->coc_source.width, job->coc_source.height);
}

ddof_status filled_load(ddof_context *ctx, frame_job *job, filled_picture *picture, void *scratch) {
    work w = {.ctx = ctx, .job = job, .picture = picture, .color = job->frame->color, .map = job->coc_source};
    picture->width = w.color.width;
    picture->height = w.color.height;
    image_resolve(&w.color);
    image_resolve(&w.map);
    ddof_status status = filled_rows(ctx, picture->height, load_rows, &w);
    const int bits = w.nearest;
    memcpy(&picture->nearest, &bits, sizeof bits);
    job->nonfinite_pixels += w.holes;
    return status == DDOF_OK && w.holes ? fill_holes(ctx, picture, scratch) : status;
}
