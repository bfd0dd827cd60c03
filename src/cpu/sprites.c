/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Stage bokeh, a row at a time: the formulas of iris.h and bokeh.h. Exact IEEE operations, each pixel by itself: all instruction
 * sets agree. */
#include <math.h>

#include "../iris.h"
#include "isa.h"
#include "rgba.h"
#include "vec.h"

enum { CHUNK = 64 /* pixels between the steps of a loop in two */ };

static inline float least(float a, float b) {
    return a < b ? a : b;
}

static inline float most(float a, float b) {
    return a > b ? a : b;
}

static float brightest(const float *rgba, int count, int colors) {
    pixel v = {-INFINITY, -INFINITY, -INFINITY, -INFINITY};
    for (ptrdiff_t i = 0; i < count; i++) {
        const pixel p = load(rgba + 4 * i);
        for (int c = 0; c < 4; c++) v[c] = p[c] > v[c] ? p[c] : v[c];
    }
    float found = v[0];
    for (int c = 1; c < colors; c++) found = most(found, v[c]);
    return found;
}

/* ---- the mask */

/* A chunk of a row: p and p0 of iris.h. */
typedef struct chunk {
    float x[CHUNK], y[CHUNK], x0[CHUNK], y0;
} chunk;

static void positions(chunk *c, const iris_shape *s, const iris_row *row, int first) {
    c->y0 = -row->side * row->dy / s->aspect;
    for (int i = 0; i < CHUNK; i++) {
        c->x0[i] = row->side * (row->dx + (float)(first + i)) * s->squeeze;
        c->x[i] = c->x0[i] * s->cosine + c->y0 * s->sine;
        c->y[i] = c->y0 * s->cosine - c->x0[i] * s->sine;
    }
}

static inline float cover_of(float inside) {
    return most(least(inside + 0.5f, 1), 0);
}

static void disc_distance(const chunk *c, float radius, float *inside) {
    for (int i = 0; i < CHUNK; i++) inside[i] = radius - sqrtf(c->x[i] * c->x[i] + c->y[i] * c->y[i]);
}

static void polygon_distance(const chunk *c, const iris_shape *s, float radius, float *inside) {
    float beyond[CHUNK];
    for (int i = 0; i < CHUNK; i++) beyond[i] = -INFINITY;
    for (int k = 0; k < s->blades; k++)
        for (int i = 0; i < CHUNK; i++) beyond[i] = most(beyond[i], c->x[i] * s->normal_x[k] + c->y[i] * s->normal_y[k]);
    disc_distance(c, radius, inside);
    for (int i = 0; i < CHUNK; i++)
        inside[i] = (1 - s->curvature) * (radius * s->apothem - beyond[i]) + s->curvature * inside[i];
}

static inline float texel_at(const float *texel, int side, int x, int y) {
    return x >= 0 && y >= 0 && x < side && y < side ? texel[y * side + x] : 0;
}

static void image_cover(const chunk *c, const float *texel, int side, float radius, float *cover) {
    const float scale = 0.5f * (float)side / radius, middle = 0.5f * (float)side - 0.5f;
    for (int i = 0; i < CHUNK; i++) {
        const float u = c->x[i] * scale + middle, v = middle - c->y[i] * scale;
        cover[i] = 0;
        if (!(u > -1 && v > -1 && u < (float)side && v < (float)side)) continue;
        const int x = (int)(u + 1) - 1, y = (int)(v + 1) - 1;
        const float right = u - (float)x, below = v - (float)y;
        cover[i] = (1 - below) * ((1 - right) * texel_at(texel, side, x, y) + right * texel_at(texel, side, x + 1, y)) +
                   below * ((1 - right) * texel_at(texel, side, x, y + 1) + right * texel_at(texel, side, x + 1, y + 1));
    }
}

static void cats_eye(const chunk *c, const iris_row *row, float radius, float *inside) {
    for (int i = 0; i < CHUNK; i++) {
        const float x = c->x0[i] + radius * row->cat_x, y = c->y0 + radius * row->cat_y;
        inside[i] = radius - sqrtf(x * x + y * y);
    }
}

static void mask(const iris *of, const iris_row *row, int count, float *out) {
    const iris_shape *s = &of->shape;
    const float radius = 0.5f * row->diameter, edge = row->side * s->edge, within = 1 / radius;
    const bool cat = row->cat_x != 0 || row->cat_y != 0;
    chunk c;
    float inside[CHUNK], cut[CHUNK];
    for (int first = 0; first < count; first += CHUNK) {
        positions(&c, s, row, first);
        if (cat) cats_eye(&c, row, radius, cut);
        if (s->kind == DDOF_IRIS_IMAGE) {
            image_cover(&c, iris_texels(of, row->level), iris_level_side(row->level), radius, inside);
            for (int i = 0; i < CHUNK && cat; i++) inside[i] *= cover_of(cut[i]);
        } else {
            if (s->kind == DDOF_IRIS_POLYGON)
                polygon_distance(&c, s, radius, inside);
            else
                disc_distance(&c, radius, inside);
            for (int i = 0; i < CHUNK && cat; i++) inside[i] = least(inside[i], cut[i]);
            for (int i = 0; i < CHUNK; i++) inside[i] = cover_of(inside[i]);
        }
        for (int i = 0; i < CHUNK && edge != 0; i++) {
            const float r = least(sqrtf(c.x[i] * c.x[i] + c.y[i] * c.y[i]) * within, 1);
            inside[i] *= 1 + edge * (2 * r * r - 1);
        }
        const int n = count - first < CHUNK ? count - first : CHUNK;
        memcpy(out + first, inside, (size_t)n * sizeof *out);
    }
}

/* ---- drawing */

/* bokeh_visible() of bokeh.h, without its branches. */
static void visible(const float *coc, int step, int count, float sprite, float *out) {
    const float inverse = 1 / sprite;
    float gathered[CHUNK];
    for (int i = 0; i < count && step > 1; i++) gathered[i] = coc[i * (ptrdiff_t)step];
    const float *p = step > 1 ? gathered : coc;
    if (sprite > 0)
        for (int i = 0; i < count; i++) out[i] = p[i] * inverse;
    else
        for (int i = 0; i < count; i++) out[i] = p[i] >= sprite ? 1 : sprite / p[i];
    for (int i = 0; i < count; i++) {
        const float t = most(least((out[i] - 0.25f) * 2, 1), 0);
        out[i] = t * t * (3 - 2 * t);
    }
}

static void add(float *rgba, float *weight, const float *masks, const float *coc, int step, int count, float sprite,
                const float color[4], float one) {
    const pixel light = load(color);
    float part[CHUNK];
    for (int first = 0; first < count; first += CHUNK) {
        const int n = count - first < CHUNK ? count - first : CHUNK;
        visible(coc + first * (ptrdiff_t)step, step, n, sprite, part);
        for (int i = 0; i < n; i++) part[i] *= masks[first + i];
        float *to = rgba + 4 * (ptrdiff_t)first;
        for (ptrdiff_t i = 0; i < n; i++) store(to + 4 * i, load(to + 4 * i) + part[i] * light);
        for (int i = 0; i < n && weight; i++) weight[first + i] += part[i] * one;
    }
}

const sprite_kernels ISA(sprite_kernels) = {brightest, mask, add};
