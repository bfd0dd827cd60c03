/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Stage fill, a row at a time. Exact IEEE operations, each pixel by itself: all instruction sets agree. */
#include "isa.h"
#include "rgba.h"
#include "vec.h"

/* Full trust in interpolated means whose weights sum to 1/TRUST or more. */
#define TRUST 4.0f

enum { CHUNK = 16 /* pixels that are passed over when none lacks anything; a multiple of 2 GROUP */ };

#define INLINE static inline __attribute__((always_inline))

/* ---- push: sums over 2 x 2 pixels, divided where the weights sum to more than 1 */

INLINE void push_rows(int channels, int width, bool picture, int rows, const float *const value[2],
                      const float *const weight[2], float *value_above, float *weight_above) {
    const int pairs = width / 2;
    const float *w0 = weight[0], *w1 = weight[rows - 1], *v0 = value[0], *v1 = value[rows - 1];
    for (ptrdiff_t x = 0; x < pairs; x++) {
        float sum = w0[2 * x] + w0[2 * x + 1];
        if (rows == 2) sum += w1[2 * x] + w1[2 * x + 1];
        weight_above[x] = sum;
    }
    if (channels == 1) {
        for (ptrdiff_t x = 0; x < pairs; x++) {
            const float scale = weight_above[x] > 1 ? 1 / weight_above[x] : 1;
            const float a = picture ? w0[2 * x] : 1, b = picture ? w0[2 * x + 1] : 1;
            const float c = picture ? w1[2 * x] : 1, d = picture ? w1[2 * x + 1] : 1;
            float sum = a * v0[2 * x] + b * v0[2 * x + 1];
            if (rows == 2) sum += c * v1[2 * x] + d * v1[2 * x + 1];
            value_above[x] = scale * sum;
        }
    } else {
        for (ptrdiff_t x = 0; x < pairs; x++) {
            const float scale = weight_above[x] > 1 ? 1 / weight_above[x] : 1;
            const float a = picture ? w0[2 * x] : 1, b = picture ? w0[2 * x + 1] : 1;
            const float c = picture ? w1[2 * x] : 1, d = picture ? w1[2 * x + 1] : 1;
            pixel sum = a * load(v0 + 8 * x) + b * load(v0 + 8 * x + 4);
            if (rows == 2) sum += c * load(v1 + 8 * x) + d * load(v1 + 8 * x + 4);
            sum *= scale;
            memcpy(value_above + 4 * x, &sum, sizeof sum);
        }
    }
    for (ptrdiff_t x = 0; x < pairs; x++) weight_above[x] = weight_above[x] < 1 ? weight_above[x] : 1;
}

/* The last column of an odd width has no partner. */
static void push_last(int channels, int width, bool picture, int rows, const float *const value[2],
                      const float *const weight[2], float *value_above, float *weight_above) {
    float w[2][2] = {{0}}, v[2][8] = {{0}};
    for (int r = 0; r < rows; r++) {
        w[r][0] = weight[r][width - 1];
        memcpy(v[r], value[r] + (ptrdiff_t)channels * (width - 1), (size_t)channels * sizeof(float));
    }
    const float *const values[2] = {v[0], v[1]}, *const weights[2] = {w[0], w[1]};
    push_rows(channels, 2, picture, 2, values, weights, value_above + (ptrdiff_t)channels * (width / 2),
              weight_above + width / 2);
}

static void push(int channels, int width, bool picture, const float *const value[2], const float *const weight[2],
                 float *value_above, float *weight_above) {
    const int rows = value[1] ? 2 : 1;
#define PUSH(c, p, r)                                                                                                  \
    if (channels == c && picture == p && rows == r) push_rows(c, width, p, r, value, weight, value_above, weight_above)
    PUSH(1, true, 1);
    PUSH(1, true, 2);
    PUSH(1, false, 1);
    PUSH(1, false, 2);
    PUSH(4, true, 1);
    PUSH(4, true, 2);
    PUSH(4, false, 1);
    PUSH(4, false, 2);
#undef PUSH
    if (width % 2) push_last(channels, width, picture, rows, value, weight, value_above, weight_above);
}

/* ---- pull: interpolates in the level above, whose pixels are twice as wide: an even pixel has 3/4 of the pixel it is part
 * of and 1/4 of the one before, an odd pixel 1/4 of the one after */

enum { ABOVE = FILL_TILE / 2 + 2 + PAD };

/* Between two rows, pixels [x - 1, x + count + 1) of them; the first and the last stand for what is beyond. */
INLINE void blend(const float *const rows[2], float share, int channels, int x, int count, int width, float *restrict out) {
    const int first = x > 0 ? x - 1 : 0, end = x + count + 1 < width ? x + count + 1 : width;
    const float *a = rows[0] + (ptrdiff_t)channels * first, *b = rows[1] + (ptrdiff_t)channels * first;
    const ptrdiff_t n = (ptrdiff_t)channels * (end - first);
    float *restrict row = out + (ptrdiff_t)channels * (first - (x - 1));
    for (ptrdiff_t i = 0; i < n; i++) row[i] = (1 - share) * a[i] + share * b[i];
    for (int c = 0; c < channels; c++) {
        const ptrdiff_t last = n - channels + c;
        if (first == x) out[c] = (1 - share) * a[c] + share * b[c];
        row[n + c] = (1 - share) * a[last] + share * b[last];
    }
}

/* What a pixel takes of the means that are known above, and of what these got themselves. */
typedef struct takes {
    float known, rest;
} takes;

INLINE takes take(float weight_above, float weight) {
    const float lack = 1 - weight, w = weight_above, trust = w * TRUST < 1 ? w * TRUST : 1;
    const float scale = w > 1e-30f ? trust / w : 0;
    return (takes){lack * scale, lack * (1 - trust)};
}

static void take_row(const float *restrict above, const float *restrict weight, int count, float *restrict known,
                     float *restrict rest) {
    for (ptrdiff_t i = 0; i < (count + 1) / 2; i++) {
        const takes even = take(0.25f * above[i] + 0.75f * above[i + 1], weight[2 * i]);
        const takes odd = take(0.75f * above[i + 1] + 0.25f * above[i + 2], weight[2 * i + 1]);
        known[2 * i] = even.known, known[2 * i + 1] = odd.known;
        rest[2 * i] = even.rest, rest[2 * i + 1] = odd.rest;
    }
}

typedef struct pull_rows {
    const float *known, *rest;   /* how much of what is above */
    const float *value, *filled; /* above, from the pixel before the first */
    const float *weight;         /* NULL: 1 */
} pull_rows;

INLINE void pull_one(const pull_rows *r, bool picture, int count, float *restrict row) {
    const float *restrict v = r->value, *restrict f = r->filled;
    for (ptrdiff_t i = 0; i < (count + 1) / 2; i++) {
        const ptrdiff_t x = 2 * i, y = x + 1;
        const float v0 = 0.25f * v[i] + 0.75f * v[i + 1], v1 = 0.75f * v[i + 1] + 0.25f * v[i + 2];
        const float f0 = 0.25f * f[i] + 0.75f * f[i + 1], f1 = 0.75f * f[i + 1] + 0.25f * f[i + 2];
        const float own0 = picture ? r->weight[x] * row[x] : row[x], own1 = picture ? r->weight[y] * row[y] : row[y];
        row[x] = own0 + (r->known[x] * v0 + r->rest[x] * f0);
        row[y] = own1 + (r->known[y] * v1 + r->rest[y] * f1);
    }
}

/* GROUP even pixels and GROUP odd ones, in order. */
INLINE void interleave(vfloat a, vfloat b, vfloat out[2]) {
#if LANES == 16
    out[0] = __builtin_shufflevector(a, b, 0, 1, 2, 3, 16, 17, 18, 19, 4, 5, 6, 7, 20, 21, 22, 23);
    out[1] = __builtin_shufflevector(a, b, 8, 9, 10, 11, 24, 25, 26, 27, 12, 13, 14, 15, 28, 29, 30, 31);
#elif LANES == 8
    out[0] = __builtin_shufflevector(a, b, 0, 1, 2, 3, 8, 9, 10, 11);
    out[1] = __builtin_shufflevector(a, b, 4, 5, 6, 7, 12, 13, 14, 15);
#else
    out[0] = a, out[1] = b;
#endif
}

/* 2 GROUP pixels from the GROUP above, which p points before. */
INLINE void upsample(const float *p, vfloat out[2]) {
    const vfloat here = 0.75f * v_load(p + 4);
    interleave(0.25f * v_load(p) + here, here + 0.25f * v_load(p + 8), out);
}

INLINE void pull_group(const pull_rows *r, bool picture, ptrdiff_t x, float *row) {
    vfloat value[2], filled[2];
    upsample(r->value + 2 * x, value);
    upsample(r->filled + 2 * x, filled);
    const vfloat known = v_load(r->known + x), rest = v_load(r->rest + x), weight = picture ? v_load(r->weight + x) : v_set(1);
#define PULL(k)                                                                                                        \
    do {                                                                                                               \
        float *p = row + 4 * x + LANES * (k);                                                                          \
        const vfloat taken = V_EXPAND(known, k) * value[k] + V_EXPAND(rest, k) * filled[k];                            \
        v_store(p, (picture ? V_EXPAND(weight, k) * v_load(p) : v_load(p)) + taken);                                   \
    } while (0)
    PULL(0);
    PULL(1);
#undef PULL
}

static inline bool lacks(const float *weight, int count) {
    int32_t any = 0;
    for (int i = 0; i < count; i++) any |= weight[i] < 1 ? -1 : 0;
    return any;
}

INLINE void pull_four(const pull_rows *r, const float *weight, bool picture, int count, float *row) {
    for (ptrdiff_t x = 0; x < count; x += CHUNK)
        if (lacks(weight + x, CHUNK))
            for (ptrdiff_t i = x; i < x + CHUNK; i += 2 * GROUP) pull_group(r, picture, i, row);
}

INLINE void pull_tile(const fill_tile *t, int channels, bool picture, float *value, const float *weight) {
    float known[FILL_TILE + 2 * PAD], rest[FILL_TILE + 2 * PAD], above[ABOVE], values[4 * ABOVE], filled[4 * ABOVE];
    const int x = t->x / 2, count = (t->count + 1) / 2;
    blend(t->weight, t->share, 1, x, count, t->width_above, above);
    blend(t->value, t->share, channels, x, count, t->width_above, values);
    blend(t->filled, t->share, channels, x, count, t->width_above, filled);
    take_row(above, weight, t->count, known, rest);
    const pull_rows r = {known, rest, values, filled, weight};
    if (channels == 1)
        pull_one(&r, picture, t->count, value);
    else
        pull_four(&r, weight, picture, t->count, value);
}

static void pull(const fill_tile *tile, float *value, float *weight) {
    if (!lacks(weight, tile->count)) return;
    for (int i = 0; i < PAD; i++) weight[tile->count + i] = 1;
    if (tile->channels == 1 && tile->picture)
        pull_tile(tile, 1, true, value, weight);
    else if (tile->channels == 1)
        pull_tile(tile, 1, false, value, weight);
    else if (tile->picture)
        pull_tile(tile, 4, true, value, weight);
    else
        pull_tile(tile, 4, false, value, weight);
}

const fill_kernels ISA(fill_kernels) = {push, pull};
