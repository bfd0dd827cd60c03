/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "scatter.h"

#include <math.h>
#include <string.h>

#include "cpu/kernels.h"

enum { PLACES = 4 /* behind or before the focus; in a target of half the size the left or right of its two pixels */ };

/* Pixels from a sprite's middle to the ends of its masks. */
static int mask_reach(const scatter *s, int node) {
    return (int)(iris_diameter(node) * (s->half ? 0.25f : 0.5f)) + 2;
}

static int mask_width(const scatter *s, int node) {
    return 2 * mask_reach(s, node) + 1;
}

void scatter_plan(scatter *s, const ddof_context *ctx, const frame_job *job, const bokeh_limits *limits) {
    const ddof_frame *f = job->frame;
    const double width = f->picture_width ? f->picture_width : f->color.width;
    const double height = f->picture_width ? f->picture_height : f->color.height;
    *s = (scatter){.ctx = ctx, .iris = job->iris, .width = f->color.width, .height = f->color.height, .half = limits->half};
    s->target_width = s->half ? (s->width + 1) / 2 : s->width;
    s->target_height = s->half ? (s->height + 1) / 2 : s->height;
    s->aspect = (float)job->pixel_aspect;
    s->middle_x = (float)(0.5 * (width - 1) - f->offset_x);
    s->middle_y = (float)(0.5 * (height - 1) - f->offset_y);
    s->per_diagonal = (float)(2 / hypot(width, height / job->pixel_aspect));
    s->fringe = job->settings->iris.fringe != 0 && f->color.channels > 2;
    const double most = (double)limits->largest * (1 + fabs(job->settings->iris.fringe));
    s->nodes = iris_node((float)most) + 1;
    for (int node = 0; node < s->nodes; node++) s->mask[node + 1] = s->mask[node] + PLACES * mask_width(s, node);
}

size_t scatter_take(scatter *s, void *base, int workers) {
    const size_t masks = (size_t)s->nodes * PLACES, line = 64;
    char *at = base;
    s->worker = base;
    at += (sizeof *s->worker * (size_t)workers + line - 1) / line * line;
    const size_t spare = (size_t)s->mask[s->nodes], floats = spare + (size_t)mask_width(s, s->nodes - 1);
    const size_t one = (floats * sizeof(float) + masks * sizeof(int) + line - 1) / line * line;
    for (int i = 0; i < workers && base; i++, at += one) {
        float *mask = (float *)(void *)at;
        s->worker[i] = (scatter_masks){mask, (int *)(void *)(mask + floats), mask + spare, 0};
        memset(s->worker[i].made, 0, masks * sizeof(int));
    }
    return (sizeof *s->worker * (size_t)workers + line - 1) / line * line + one * (size_t)workers;
}

int scatter_reach(const scatter *s, float largest) {
    return (int)(0.5f * largest * (1 + fabsf(s->iris->shape.fringe)) * s->aspect) + 4;
}

/* What of the target's row a sprite covers. */
typedef struct span {
    int x0, x1;
    float dx; /* of x0 */
} span;

static span span_of(const scatter *s, const bokeh_sprite *p, int node) {
    const int middle = s->half ? p->x / 2 : p->x, reach = mask_reach(s, node);
    const float off = !s->half ? 0 : p->x % 2 ? -0.25f : 0.25f;
    return (span){middle - reach, middle + reach + 1, off - (float)reach};
}

/* Of a circle of light, not yet clipped; made once for a row of sprites where it depends on the node alone. */
static const float *mask_of(const scatter *s, scatter_masks *w, const bokeh_sprite *p, int node, const iris_row *row, int count) {
    const sprite_kernels *k = s->ctx->kernels->sprites;
    if (row->cat_x != 0 || row->cat_y != 0) {
        k->mask(s->iris, row, count, w->spare);
        return w->spare;
    }
    const int place = (row->side < 0) * 2 + (s->half && p->x % 2);
    int *made = &w->made[node * PLACES + place];
    float *mask = w->mask + s->mask[node] + place * count;
    if (*made != w->row) k->mask(s->iris, row, count, mask);
    *made = w->row;
    return mask;
}

static float cats_gain(const scatter *s, const iris_row *row) {
    const float at = fminf(hypotf(row->cat_x, row->cat_y), 1) * (IRIS_CATS - 1);
    const int node = at < IRIS_CATS - 2 ? (int)at : IRIS_CATS - 2;
    const float share = at - (float)node;
    return (1 - share) * s->iris->cats_gain[node] + share * s->iris->cats_gain[node + 1];
}

/* Some of a sprite's channels, which have this node, on row y of the target. */
static void draw(const scatter *s, scatter_masks *w, const bokeh_sprite *p, int node, const float color[4], float one, int y) {
    const iris_shape *shape = &s->iris->shape;
    iris_row row = {.diameter = s->iris->diameter[node] * (s->half ? 0.5f : 1), .side = p->coc < 0 ? -1 : 1, .level = iris_level(node, s->half)};
    const int middle = s->half ? p->y / 2 : p->y;
    const float off = !s->half ? 0 : p->y % 2 ? -0.25f : 0.25f;
    row.dy = (float)(y - middle) + off;
    if (fabsf(row.dy) > 0.5f * row.diameter * s->aspect + 1 + s->aspect) return;
    if (shape->cats_eye != 0) {
        row.cat_x = ((float)p->x - s->middle_x) * s->per_diagonal * shape->cats_eye;
        row.cat_y = (s->middle_y - (float)p->y) / s->aspect * s->per_diagonal * shape->cats_eye;
    }
    const span all = span_of(s, p, node);
    row.dx = all.dx;
    const float *mask = mask_of(s, w, p, node, &row, all.x1 - all.x0);
    float gain = s->iris->inverse_sum[s->half][node], light[4];
    if (row.cat_x != 0 || row.cat_y != 0) gain *= cats_gain(s, &row);
    for (int c = 0; c < 4; c++) light[c] = color[c] * gain;
    const int x0 = all.x0 > 0 ? all.x0 : 0, x1 = all.x1 < s->target_width ? all.x1 : s->target_width;
    if (x0 >= x1) return;
    const scatter_target *to = p->coc < 0 ? &s->near : &s->far;
    const int step = s->half ? 2 : 1;
    float *rgba = (float *)(void *)((char *)to->rgba + to->row_stride * y) + 4 * (ptrdiff_t)x0;
    float *weight = to->weight && one > 0 ? to->weight + (ptrdiff_t)s->target_width * y + x0 : NULL;
    s->ctx->kernels->sprites->add(rgba, weight, mask + (x0 - all.x0), s->coc + (ptrdiff_t)s->width * step * y + step * (ptrdiff_t)x0,
                                  step, x1 - x0, p->coc, light, one * gain);
}

static void draw_fringed(const scatter *s, scatter_masks *w, const bokeh_sprite *p, int y) {
    const float fringe = p->coc < 0 ? -s->iris->shape.fringe : s->iris->shape.fringe, d = fabsf(p->coc);
    const float red[4] = {p->color[0], 0, 0, 0}, green[4] = {0, p->color[1], 0, p->color[3]}, blue[4] = {0, 0, p->color[2], 0};
    draw(s, w, p, iris_node(d * (1 + fringe)), red, 0, y);
    draw(s, w, p, p->node, green, p->one, y);
    draw(s, w, p, iris_node(d * (1 - fringe)), blue, 0, y);
}

void scatter_row(const scatter *s, int worker, const bokeh_sprite *sprite, int count, int y0, int y1) {
    scatter_masks *w = &s->worker[worker];
    for (int y = y0; y < y1; y++) {
        w->row++;
        for (int i = 0; i < count; i++) {
            if (s->fringe)
                draw_fringed(s, w, &sprite[i], y);
            else
                draw(s, w, &sprite[i], sprite[i].node, sprite[i].color, sprite[i].one, y);
        }
    }
}
