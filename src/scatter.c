/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "scatter.h"

#include <math.h>
#include <string.h>

#include "cpu/kernels.h"
#include "cpu/rgba.h"

enum { PLACES = 4 /* behind or before the focus; from level 1 on, in the left or the right of two pixels */ };

/* Where the tables of a node that is drawn at a level lie: from level 1 on as if the picture were 1/2^(level - 1) of its size. */
static int table_node(int node, int level) {
    return level > 1 ? node - (level - 1) * IRIS_OCTAVE : node;
}

void scatter_plan(scatter *s, const ddof_context *ctx, const frame_job *job, const bokeh_limits *limits) {
    const ddof_frame *f = job->frame;
    const double width = f->picture_width ? f->picture_width : f->color.width;
    const double height = f->picture_width ? f->picture_height : f->color.height;
    *s = (scatter){.ctx = ctx, .iris = job->iris, .width = f->color.width, .height = f->color.height, .half = limits->half};
    s->aspect = (float)job->pixel_aspect;
    s->middle_x = (float)(0.5 * (width - 1) - f->offset_x);
    s->middle_y = (float)(0.5 * (height - 1) - f->offset_y);
    s->per_diagonal = (float)(2 / hypot(width, height / job->pixel_aspect));
    s->fringe = job->settings->iris.fringe != 0 && f->color.channels > 2;
    s->radii = iris_reach(&job->settings->iris);
    s->largest = limits->largest * (1 + fabsf((float)job->settings->iris.fringe));
    s->first = limits->half;
    s->levels = bokeh_level(iris_node(limits->largest), limits->half) + 1;
    for (int l = 0; l < s->levels; l++) {
        s->level[l].width = (s->width + (1 << l) - 1) >> l;
        s->level[l].height = (s->height + (1 << l) - 1) >> l;
    }
    s->nodes = iris_node(s->largest) + 1;
    for (int node = 0; node < s->nodes; node++) {
        for (int half = 0; half < 2; half++) s->reach[half][node] = (short)(s->radii * iris_diameter(node) * (half ? 0.25f : 0.5f) + 2);
        s->mask[node + 1] = s->mask[node] + PLACES * (2 * s->reach[s->half][node] + 1);
    }
}

static size_t line(size_t bytes) {
    return (bytes + 63) / 64 * 64;
}

size_t scatter_take(scatter *s, void *base, int workers) {
    const size_t masks = (size_t)s->nodes * PLACES, cached = (size_t)s->mask[s->nodes];
    const size_t floats = cached + 2 * (size_t)s->reach[0][s->nodes - 1] + 1;
    const size_t head = line(sizeof *s->worker * (size_t)workers), one = line(floats * sizeof(float) + masks * sizeof(int));
    s->worker = base;
    for (int i = 0; i < workers && base; i++) {
        float *mask = (float *)(void *)((char *)base + head + one * (size_t)i);
        s->worker[i] = (scatter_masks){mask, (int *)(void *)(mask + floats), mask + cached, 0};
        memset(s->worker[i].made, 0, masks * sizeof(int));
    }
    return head + one * (size_t)workers;
}

int scatter_reach(const scatter *s, int level) {
    const bool last = level == s->levels - 1;
    const float there = last ? s->largest : fminf(s->largest, 64.0f * (float)(1 << level) * 1.5f); /* fringe: half as much again */
    return (int)(0.5f * there * s->radii * s->aspect + (2 + s->aspect) * (float)(1 << level)) + 1;
}

/* Of a circle of light, not yet clipped; made once for a row of sprites where it depends on the node alone. */
static const float *mask_of(const scatter *s, scatter_masks *w, int node, int place, const iris_row *row, int count) {
    const sprite_kernels *k = s->ctx->kernels->sprites;
    if (row->cat_x != 0 || row->cat_y != 0) {
        k->mask(s->iris, row, count, w->spare);
        return w->spare;
    }
    int *made = &w->made[node * PLACES + place];
    float *mask = w->mask + s->mask[node] + place * count;
    if (*made != w->row) k->mask(s->iris, row, count, mask);
    *made = w->row;
    return mask;
}

/* Pixels to either side of the middle that a row of a mask may cover: shapes lie in their circle, images in a square. */
static int reach_on(const scatter *s, const iris_row *row, int most) {
    if (s->iris->shape.kind == DDOF_IRIS_IMAGE) return most;
    const float radius = 0.5f * row->diameter + 0.5f, up = row->dy / s->aspect, across = radius * radius - up * up;
    const int reach = across > 0 ? (int)sqrtf(across) + 1 : 1;
    return reach < most ? reach : most;
}

static float cats_gain(const scatter *s, const iris_row *row) {
    const float at = fminf(hypotf(row->cat_x, row->cat_y), 1) * (IRIS_CATS - 1);
    const int node = at < IRIS_CATS - 2 ? (int)at : IRIS_CATS - 2;
    const float share = at - (float)node;
    return (1 - share) * s->iris->cats_gain[node] + share * s->iris->cats_gain[node + 1];
}

/* Some of a sprite's channels, which have this node, on row y of a level. */
static void draw(const scatter *s, scatter_masks *w, int level, const bokeh_sprite *p, int node, const float color[4], float one, int y) {
    const bool half = level > 0;
    const int u = half ? p->x >> (level - 1) : p->x, v = half ? p->y >> (level - 1) : p->y, table = table_node(node, level);
    iris_row row = {.diameter = s->iris->diameter[table] * (half ? 0.5f : 1), .side = p->coc < 0 ? -1 : 1, .level = iris_level(table, half)};
    row.dy = half ? (float)(y - v / 2) + (v % 2 ? -0.25f : 0.25f) : (float)(y - v);
    if (fabsf(row.dy) > 0.5f * row.diameter * s->radii * s->aspect + 1 + s->aspect) return;
    if (s->iris->shape.cats_eye != 0) {
        row.cat_x = ((float)p->x - s->middle_x) * s->per_diagonal * s->iris->shape.cats_eye;
        row.cat_y = (s->middle_y - (float)p->y) / s->aspect * s->per_diagonal * s->iris->shape.cats_eye;
    }
    const int reach = reach_on(s, &row, s->reach[half][table]), count = 2 * reach + 1, begin = (half ? u / 2 : u) - reach;
    row.dx = (half ? u % 2 ? -0.25f : 0.25f : 0) - (float)reach;
    const float *mask = mask_of(s, w, table, (p->coc < 0) * 2 + (half && u % 2), &row, count);
    float gain = s->iris->inverse_sum[iris_sum(half, u, v, p->coc < 0)][table], light[4];
    if (row.cat_x != 0 || row.cat_y != 0) gain *= cats_gain(s, &row);
    for (int c = 0; c < 4; c++) light[c] = color[c] * gain;
    const scatter_level *l = &s->level[level];
    const int x0 = begin > 0 ? begin : 0, x1 = begin + count < l->width ? begin + count : l->width;
    if (x0 >= x1) return;
    const scatter_target *to = p->coc < 0 ? &l->near : &l->far;
    if (x0 < l->begin[y]) l->begin[y] = x0;
    if (x1 > l->end[y]) l->end[y] = x1;
    float *rgba = (float *)(void *)((char *)to->rgba + to->row_stride * y) + 4 * (ptrdiff_t)x0;
    float *weight = to->weight && one > 0 ? to->weight + (ptrdiff_t)l->width * y + x0 : NULL;
    const float *coc = s->coc + (ptrdiff_t)s->width * ((ptrdiff_t)y << level) + ((ptrdiff_t)x0 << level);
    s->ctx->kernels->sprites->add(rgba, weight, mask + (x0 - begin), coc, 1 << level, x1 - x0, p->coc, light, one * gain);
}

static void draw_fringed(const scatter *s, scatter_masks *w, int level, const bokeh_sprite *p, int y) {
    const float fringe = p->coc < 0 ? -s->iris->shape.fringe : s->iris->shape.fringe, d = fabsf(p->coc);
    const float red[4] = {p->color[0], 0, 0, 0}, green[4] = {0, p->color[1], 0, p->color[3]}, blue[4] = {0, 0, p->color[2], 0};
    draw(s, w, level, p, iris_node(d * (1 + fringe)), red, 0, y);
    draw(s, w, level, p, p->node, green, p->one, y);
    draw(s, w, level, p, iris_node(d * (1 - fringe)), blue, 0, y);
}

void scatter_row(const scatter *s, int worker, int level, const bokeh_sprite *sprite, int count, int y0, int y1) {
    scatter_masks *w = &s->worker[worker];
    for (int y = y0; y < y1; y++) {
        w->row++;
        for (int i = 0; i < count; i++) {
            if (bokeh_level(sprite[i].node, s->half) != level) continue;
            if (s->fringe)
                draw_fringed(s, w, level, &sprite[i], y);
            else
                draw(s, w, level, &sprite[i], sprite[i].node, sprite[i].color, sprite[i].one, y);
        }
    }
}

/* ---- the sums */

/* The two pixels of a level of `width` that pixel x of the picture lies between, and the share of the second. */
static inline void between(int x, int level, int width, int *first, int *second, float *share) {
    const int at = 2 * x + 1 - (1 << level), below = at >> (level + 1);
    *share = (float)(at - below * (2 << level)) / (float)(2 << level);
    *first = below > 0 ? below : 0;
    *second = below + 1 < width ? below + 1 : width - 1;
}

static void sum_level(const scatter_level *l, int level, const scatter_target *t, int y, int width, float *rgba, float *weight) {
    int y0, y1;
    float down;
    between(y, level, l->height, &y0, &y1, &down);
    int begin = l->begin[y0] < l->begin[y1] ? l->begin[y0] : l->begin[y1], end = l->end[y0] > l->end[y1] ? l->end[y0] : l->end[y1];
    begin = begin > 0 ? (begin - 1) << level : 0; /* interpolation reaches one pixel farther */
    end = end + 1 < l->width ? (end + 1) << level : width;
    end = end < width ? end : width;
    const float *top = (const float *)(const void *)((const char *)t->rgba + t->row_stride * y0), part = 1 / (float)(1 << 2 * level);
    const float *bottom = (const float *)(const void *)((const char *)t->rgba + t->row_stride * y1);
    const float upper = part * (1 - down), lower = part * down;
    for (int x = begin; x < end; x++) {
        int x0, x1;
        float right;
        between(x, level, l->width, &x0, &x1, &right);
        const pixel left = upper * load(top + 4 * (ptrdiff_t)x0) + lower * load(bottom + 4 * (ptrdiff_t)x0);
        const pixel next = upper * load(top + 4 * (ptrdiff_t)x1) + lower * load(bottom + 4 * (ptrdiff_t)x1);
        const pixel sum = load(rgba + 4 * (ptrdiff_t)x) + ((1 - right) * left + right * next);
        store(rgba + 4 * (ptrdiff_t)x, sum);
    }
    const float *above = t->weight + (ptrdiff_t)l->width * y0, *under = t->weight + (ptrdiff_t)l->width * y1;
    for (int x = begin; x < end && weight; x++) {
        int x0, x1;
        float right;
        between(x, level, l->width, &x0, &x1, &right);
        weight[x] += (1 - right) * (upper * above[x0] + lower * under[x0]) + right * (upper * above[x1] + lower * under[x1]);
    }
}

void scatter_sum_row(const scatter *s, int first, bool near, int y, float *rgba, float *weight) {
    for (int i = first; i < s->levels; i++)
        if (s->level[i].begin) sum_level(&s->level[i], i, near ? &s->level[i].near : &s->level[i].far, y, s->width, rgba, weight);
}
