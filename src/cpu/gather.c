/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Stage gather, a chunk of a row at a time, tap by tap: the formulas of methods.h. Exact IEEE operations, each pixel by itself, and a tap of
 * weight 0 changes nothing: all instruction sets agree, and chunks may begin anywhere. */
#include <math.h>

#include "../methods.h"
#include "isa.h"
#include "rgba.h"
#include "vec.h"

/* The pixels under work; rows of values have room for a vector more. */
typedef struct chunk {
    int count;
    const float *rgba;             /* their colours */
    float own[GATHER_CHUNK + PAD]; /* |CoC| */
    float step[GATHER_CHUNK + PAD];
    int taps[GATHER_CHUNK];
    float sum[4 * GATHER_CHUNK];   /* of colours less the pixel's own: a constant keeps its bits */
    float weight[GATHER_CHUNK + PAD];
} chunk;

/* A tap, the same for all pixels of a chunk. */
typedef struct tap {
    float t, step;
    float share; /* of its row */
    bool over;
} tap;

static inline vfloat clamped(vfloat v) {
    return v_max(v_min(v, v_set(1)), v_set(0));
}

/* 2^-x for 0 <= x < 126, to 1.2e-7. */
static inline vfloat power(vfloat x) {
    const vint whole = __builtin_convertvector(x, vint);
    const vfloat f = x - __builtin_convertvector(whole, vfloat);
    const vfloat p = 1 + f * (-0.6931444406509399f + f * (0.24018670618534088f + f * (-0.05531669408082962f +
                         f * (0.009228378534317017f + f * -0.0009540336322970688f))));
    return p * (vfloat)((127 - whole) << 23);
}

/* Without `step` and `share`; d: the CoC that counts. */
static inline vfloat gaussian(float size, float t, float per_step, vfloat d) {
    const vfloat sigma = size * d, inverse = 1 / v_max(sigma, v_set(1e-3f)), x = t * inverse;
    const vfloat cover = clamped((GAUSSIAN_REACH * sigma - t) * per_step + 1);
    return cover * v_min(inverse * 0.3989422804f, v_set(1)) * power(v_min(x * x * 0.7213475204f, v_set(100)));
}

static inline vfloat box(float size, float t, float per_step, vfloat d) {
    const vfloat reach = size * d, cover = clamped((reach - t) * per_step + 0.5f);
    return (t > 0 ? cover : v_set(0.5f)) / v_max(reach, v_set(0.5f));
}

/* Weights of the taps of CoC `coc`, one for each pixel of `own`, in whole vectors; whether any is not 0. */
static inline __attribute__((always_inline)) bool weigh(bool is_gaussian, float size, const tap *at, const float *own, const float *step,
                                                        const float *coc, int count, float *restrict weight) {
    const float t = at->t, per_step = 1 / at->step, share = at->share * at->step;
    vint any = {0};
    for (int i = 0; i < count; i += LANES) {
        const vfloat c = v_load(coc + i), p = v_load(own + i), distance = v_abs(c);
        const vint over = (vint)(c < -p);
        const vint counts = at->over ? over : ~over & (vint)(v_load(step + i) == at->step);
        const vfloat d = at->over ? distance : v_min(distance, p);
        const vfloat w = share * (is_gaussian ? gaussian(size, t, per_step, d) : box(size, t, per_step, d));
        const vfloat kept = (vfloat)(counts & (vint)w);
        v_store(weight + i, kept);
        any |= (vint)(kept > 0);
    }
    int found = 0;
    for (int i = 0; i < LANES; i++) found |= any[i];
    return found;
}

/* The pixels of a chunk from x that have a neighbour dx columns away inside the picture. */
static void inside(const filled_picture *p, int x, int dx, int count, int *first, int *last) {
    *first = x + dx < 0 ? -x - dx : 0;
    *last = x + dx + count > p->width ? p->width - x - dx : count;
}

/* sum += weight * (rgba - own) */
static void add(float *sum, const float *weight, const float *rgba, const float *own, ptrdiff_t count) {
    ptrdiff_t i = 0;
    for (; i + LANES <= count; i += LANES) {
        const vfloat w = v_load(weight + i);
#define ADD(k)                                                                                                         \
    do {                                                                                                               \
        const ptrdiff_t at = 4 * i + LANES * (k);                                                                      \
        v_store(sum + at, v_load(sum + at) + V_EXPAND(w, k) * (v_load(rgba + at) - v_load(own + at)));                  \
    } while (0)
        ADD(0);
        ADD(1);
        ADD(2);
        ADD(3);
#undef ADD
    }
    for (; i < count; i++) store(sum + 4 * i, load(sum + 4 * i) + weight[i] * (load(rgba + 4 * i) - load(own + 4 * i)));
}

static void add_row(chunk *c, const filled_picture *p, const gather_line *l, const tap *t, int x, int y, int dx) {
    float coc[GATHER_CHUNK + PAD] = {0}, weight[GATHER_CHUNK + PAD];
    int first, last;
    inside(p, x, dx, c->count, &first, &last);
    if (y < 0 || y >= p->height || first >= last || !(t->share > 0)) return;
    const int count = last - first;
    const ptrdiff_t at = (ptrdiff_t)p->width * y + x + dx + first;
    memcpy(coc, p->coc + at, (size_t)count * sizeof *coc);
    const bool any = l->gaussian ? weigh(true, l->size, t, c->own + first, c->step + first, coc, count, weight)
                                 : weigh(false, l->size, t, c->own + first, c->step + first, coc, count, weight);
    if (!any) return;
    const ptrdiff_t begin = 4 * (ptrdiff_t)first;
    add(c->sum + begin, weight, p->rgba + 4 * at, c->rgba + begin, count);
    for (int i = 0; i < count; i++) c->weight[first + i] += weight[i];
}

/* The i-th tap of all pixels that have this step, or that it lies over. */
static void add_tap(chunk *c, const filled_picture *p, const gather_line *l, int x, int y, int i, float step, bool over) {
    const float steps = (float)i * step, down = l->dy * steps, row = floorf(down);
    const int dx = l->dx * i * (int)step;
    tap t = {fabsf(steps), step, 1 - (down - row), over};
    if (row < (float)-p->height || row > (float)p->height) return;
    add_row(c, p, l, &t, x, y + (int)row, dx);
    t.share = down - row;
    add_row(c, p, l, &t, x, y + (int)row + 1, dx);
}

static void add_taps(chunk *c, const filled_picture *p, const gather_line *l, int x, int y, int taps, float step, bool over) {
    for (int i = l->gaussian ? -taps : 0; i <= taps; i++) add_tap(c, p, l, x, y, i, step, over);
}

static void mean(const filled_picture *p, const gather_line *l, int x, int y, int count, float *rgba) {
    const float *coc = p->coc + (ptrdiff_t)p->width * y + x;
    chunk c = {.count = count, .rgba = p->rgba + 4 * ((ptrdiff_t)p->width * y + x)};
    float widest = 1, sharpest = p->nearest;
    for (int i = 0; i < count; i++) {
        c.own[i] = fabsf(coc[i]);
        c.step[i] = gather_step(l, c.own[i], &c.taps[i]);
        widest = c.step[i] > widest ? c.step[i] : widest;
        sharpest = c.own[i] < sharpest ? c.own[i] : sharpest;
    }
    for (float step = 1; step <= widest; step *= 2) {
        int taps = -1;
        for (int i = 0; i < count; i++) taps = c.step[i] == step && c.taps[i] > taps ? c.taps[i] : taps;
        if (taps >= 0) add_taps(&c, p, l, x, y, taps, step, false);
    }
    if (sharpest < p->nearest) add_taps(&c, p, l, x, y, l->over_taps, l->over_step, true);
    for (ptrdiff_t i = 0; i < count; i++) store(rgba + 4 * i, load(c.rgba + 4 * i) + load(c.sum + 4 * i) / c.weight[i]);
}

const gather_kernels ISA(gather_kernels) = {mean};
