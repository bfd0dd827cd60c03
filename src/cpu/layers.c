/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Stage layers, a row at a time. Exact IEEE operations, each pixel by itself: all instruction sets agree. */
#include <math.h>

#include "isa.h"
#include "rgba.h"
#include "vec.h"

enum { CHUNK = 64 /* pixels between the steps of a loop in two */, AHEAD = 2 * CHUNK /* pixels fetched early */ };

typedef int32_t pixel_mask __attribute__((vector_size(16)));

static inline int32_t bits_of(float v) {
    int32_t bits;
    memcpy(&bits, &v, sizeof bits);
    return bits;
}

static inline int least(int a, int b) {
    return a < b ? a : b;
}

static int inspect(const float *rgba, const float *coc, int count) {
    pixel_mask good = ~(pixel_mask){0}, opaque = good;
    int32_t finite = -1;
    for (int i = 0; i < count; i++) {
        const pixel p = load(rgba + 4 * (ptrdiff_t)i);
        good &= p - p == 0.0f;
        opaque &= p == 1.0f;
    }
    for (int i = 0; i < count; i++) finite &= coc[i] - coc[i] == 0 ? -1 : 0;
    return (good[0] & good[1] & good[2] & good[3] & finite ? 0 : ROW_NOT_FINITE) | (opaque[3] ? 0 : ROW_TRANSPARENT);
}

/* The class follows from the exponent and the leading bits behind it. */
static void classify(const float *coc, int count, float from, int *classes) {
    int class[CHUNK], counted[2][NEAR_CLASSES + 1] = {{0}}; /* two, so that one increment need not wait for the last */
    for (int x = 0; x < count; x += CHUNK) {
        const int n = least(count - x, CHUNK);
        for (int i = 0; i < n; i++) {
            int c = (bits_of(-coc[x + i]) >> 20) - (127 << 3);
            c = c < 0 ? 0 : c < NEAR_CLASSES ? c : NEAR_CLASSES - 1;
            class[i] = -coc[x + i] > from ? c : NEAR_CLASSES;
        }
        for (int i = 0; i < n; i++) counted[i % 2][class[i]]++;
    }
    for (int c = 0; c < NEAR_CLASSES; c++) classes[c] += counted[0][c] + counted[1][c];
}

/* ---- shares */

static inline float position(layer_share s, float coc) {
    return s.offset - s.gain * coc;
}

static inline float share_of(layer_share s, float coc) {
    float t = position(s, coc);
    t = t > 0 ? t : 0;
    t = t < 1 ? t : 1;
    return t * t * (3 - 2 * t);
}

/* Whether anything of the pixel is the layer's. Shares of two layers are never both between 0 and 1. */
static inline bool own(layer_share here, layer_share nearer, float coc) {
    const float seen = 1 - share_of(nearer, coc), owned = position(here, coc) > 0 ? seen : 0;
    return owned > 0;
}

static bool extent(const float *coc, int count, layer_share here, layer_share nearer, int *first, int *last, float *widest) {
    int32_t most = -1;
    *first = *last = -1;
    for (int x = 0; x < count; x += CHUNK) {
        int32_t wide = -1; /* floats >= 0 compare as their bits do */
        for (int i = x; i < least(count, x + CHUNK); i++) {
            const int32_t bits = own(here, nearer, coc[i]) ? bits_of(fabsf(coc[i])) : -1;
            wide = bits > wide ? bits : wide;
        }
        if (wide < 0) continue;
        if (*first < 0) *first = x;
        *last = least(count, x + CHUNK) - 1;
        most = wide > most ? wide : most;
    }
    if (most < 0) return false;
    while (!own(here, nearer, coc[*first])) ++*first;
    while (!own(here, nearer, coc[*last])) --*last;
    memcpy(widest, &most, sizeof *widest);
    return true;
}

static void cover(const float *coc, int count, layer_share here, layer_share nearer, float *covers, float *weight) {
    for (int i = 0; i < count; i++) {
        const float seen = 1 - share_of(nearer, coc[i]);
        covers[i] = seen > 0 ? share_of(here, coc[i]) : 0; /* of what is seen: all, where some is hidden */
        /* where it shares a pixel, its colour is that of the pixel, not of what lies around */
        weight[i] = 4 * seen < 1 ? 4 * seen : 1;
    }
}

static void split(const float *source, const float *coc, int count, layer_share here, layer_share nearer, float *part,
                  float *weight) {
    float covers[CHUNK];
    for (int x = 0; x < count; x += CHUNK) {
        const int n = least(count - x, CHUNK);
        for (ptrdiff_t i = 0; i < CHUNK; i += 4) __builtin_prefetch(source + 4 * (x + AHEAD + i));
        cover(coc + x, n, here, nearer, covers, weight + x);
        for (ptrdiff_t i = 0; i < n; i++) store(part + 4 * (x + i), covers[i] * load(source + 4 * (x + i)));
    }
}

static void reach(const float *coc, int count, layer_share here, layer_share nearer, float *value, float *weight) {
    for (int i = 0; i < count; i++) {
        weight[i] = own(here, nearer, coc[i]) ? 1 : 0;
        value[i] = weight[i] * fabsf(coc[i]);
    }
}

static void over(const float *part, const float *covers, float *behind, int count) {
    for (ptrdiff_t i = 0; i < count; i++) {
        const pixel p = load(part + 4 * i);
        const float through = 1 - (covers ? covers[i] : p[3]);
        store(behind + 4 * i, p + through * load(behind + 4 * i));
    }
}

static inline float larger(float a, float b) {
    return a > b ? a : b;
}

static void spread(const float *beside, float *restrict row, int count, float slope, float across, bool forward) {
    for (int x = 0; x < count && beside; x++)
        row[x] = larger(larger(row[x], beside[x] - slope), larger(beside[x - 1], beside[x + 1]) - across);
    float before = 0;
    for (int i = 0; i < count; i++) {
        float *at = &row[forward ? i : count - 1 - i];
        *at = before = larger(*at, before - 1);
    }
}

const layer_kernels ISA(layer_kernels) = {inspect, classify, extent, split, cover, reach, spread, over};
