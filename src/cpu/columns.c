/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Stage columns: one implicit step of heat diffusion along every column. Down, a tile of solved rows at a time, the
 * elimination; up, a row at a time, the substitution. Coefficients are vectors of LANES pixels, pixels four vectors of
 * GROUP pixels x RGBA. */
#include "conductance.h"
#include "isa.h"

static inline vfloat load_part(const float *p, int count) {
    if (count >= LANES) return v_load(p);
    float part[LANES] = {0};
    memcpy(part, p, (size_t)count * sizeof(float));
    return v_load(part);
}

static inline void store_part(float *p, vfloat v, int count, bool stream) {
    if (count < LANES)
        memcpy(p, &v, (size_t)count * sizeof(float));
    else if (stream)
        v_stream(p, v);
    else
        v_store(p, v);
}

/* LANES columns on their way down. */
typedef struct column_group {
    vfloat rest;    /* weight that reaches the next row */
    vfloat mean[4]; /* of the rows so far */
    vfloat coc;     /* magnitude, of this row */
} column_group;

static inline column_group group_load(const cpu_block *b, const column_state *s, int x, int count) {
    column_group g = {.rest = v_load(s->rest + x)};
    for (int k = 0; k < 4; k++) g.mean[k] = v_load(s->mean + 4 * (ptrdiff_t)x + k * LANES);
    g.coc = coc_magnitude(load_part(b->in.coc[0] + x, count));
    return g;
}

static inline void group_store(const column_group *g, const column_state *s, int x) {
    v_store(s->rest + x, g->rest);
    for (int k = 0; k < 4; k++) v_store(s->mean + 4 * (ptrdiff_t)x + k * LANES, g->mean[k]);
}

/* One row of the group: `pixel` solved along its row; coc_below NULL at the border. */
static inline __attribute__((always_inline)) void group_step(column_group *g, vfloat capacity, vfloat scale,
                                                             const float *coc_below, const float *pixel, float *out,
                                                             float *keep, int count, bool stream) {
    vfloat beta = v_set(BETA_BORDER);
    if (coc_below) {
        vfloat below = coc_magnitude(load_part(coc_below, count));
        beta = conductance(g->coc, below, scale);
        g->coc = below;
    }
    elimination e = eliminate(g->rest, capacity, beta);
    g->rest = e.rest;
    store_part(keep, e.keep, count, stream);
    g->mean[0] = lerp(g->mean[0], v_load(pixel), V_EXPAND(e.own, 0));
    g->mean[1] = lerp(g->mean[1], v_load(pixel + LANES), V_EXPAND(e.own, 1));
    g->mean[2] = lerp(g->mean[2], v_load(pixel + 2 * LANES), V_EXPAND(e.own, 2));
    g->mean[3] = lerp(g->mean[3], v_load(pixel + 3 * LANES), V_EXPAND(e.own, 3));
    for (int k = 0; k < 4; k++) {
        int left = count * 4 - k * LANES;
        if (left > 0) store_part(out + k * LANES, g->mean[k], left < LANES ? left : LANES, stream);
    }
}

/* `groups` groups side by side, so that one's division hides behind the other's. */
static inline __attribute__((always_inline)) void columns_of_groups(const cpu_block *b, const column_state *s, int x0, int x,
                                                                    int count, int groups, float *const *out,
                                                                    float *const *keep, bool stream) {
    column_group g[2];
    const vfloat scale = v_set(b->column_scale);
    for (int i = 0; i < groups; i++) g[i] = group_load(b, s, x + i * LANES, count);
    for (int r = 0; r < b->in.count; r++) {
        const float *below = r + 1 < b->in.count ? b->in.coc[r + 1] : b->coc_below;
        const float *pixel = b->tile + (ptrdiff_t)r * TILE * 4;
        for (int i = 0; i < groups; i++) {
            const ptrdiff_t at = x - x0 + i * LANES;
            group_step(&g[i], v_set(b->in.row_alive[r]), scale, below ? below + x0 + at : NULL, pixel + 4 * at,
                       out[r] + 4 * at, keep[r] + at, count, stream);
        }
    }
    for (int i = 0; i < groups; i++) group_store(&g[i], s, x + i * LANES);
}

static void columns_down(const cpu_block *b, const column_state *s, int x0, int x1, float *const *out, float *const *keep,
                         bool stream) {
    int x = x0;
    if (stream)
        for (; x + 2 * LANES <= x1; x += 2 * LANES) columns_of_groups(b, s, x0, x, LANES, 2, out, keep, true);
    else
        for (; x + 2 * LANES <= x1; x += 2 * LANES) columns_of_groups(b, s, x0, x, LANES, 2, out, keep, false);
    for (; x < x1; x += LANES) columns_of_groups(b, s, x0, x, x1 - x < LANES ? x1 - x : LANES, 1, out, keep, false);
    if (stream) v_stream_fence();
}

static inline void up_step(float *row, const float *keep, const float *below) {
    vfloat k = v_load(keep);
    v_store(row, lerp(v_load(below), v_load(row), V_EXPAND(k, 0)));
    v_store(row + LANES, lerp(v_load(below + LANES), v_load(row + LANES), V_EXPAND(k, 1)));
    v_store(row + 2 * LANES, lerp(v_load(below + 2 * LANES), v_load(row + 2 * LANES), V_EXPAND(k, 2)));
    v_store(row + 3 * LANES, lerp(v_load(below + 3 * LANES), v_load(row + 3 * LANES), V_EXPAND(k, 3)));
}

static void columns_up(float *row, const float *keep, const float *below, int count) {
    int x = 0;
    for (; x + LANES <= count; x += LANES) up_step(row + 4 * (ptrdiff_t)x, keep + x, below + 4 * (ptrdiff_t)x);
    if (x < count) {
        float row_part[4 * LANES] = {0}, keep_part[LANES] = {0}, below_part[4 * LANES] = {0};
        size_t left = (size_t)(count - x);
        memcpy(row_part, row + 4 * (ptrdiff_t)x, left * 4 * sizeof(float));
        memcpy(keep_part, keep + x, left * sizeof(float));
        memcpy(below_part, below + 4 * (ptrdiff_t)x, left * 4 * sizeof(float));
        up_step(row_part, keep_part, below_part);
        memcpy(row + 4 * (ptrdiff_t)x, row_part, left * 4 * sizeof(float));
    }
}

const column_kernels ISA(column_kernels) = {columns_down, columns_up};
