/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "bokeh_oracle.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double TURN = 6.28318530717958647692;

static double clamp(double v, double least, double most) {
    return v < least ? least : v > most ? most : v;
}

static double length(double x, double y) {
    return sqrt(x * x + y * y);
}

static double smooth(double from, double to, double v) {
    const double t = clamp((v - from) / (to - from), 0, 1);
    return t * t * (3 - 2 * t);
}

/* ---- nodes and levels */

static int node_of(double diameter) {
    return (int)clamp(floor(64 * log2(diameter) + 0.5), 0, 13 * 64);
}

static double diameter_of(int node) {
    return exp2(node / 64.0);
}

static int level_of(int node, bool half) {
    const int level = node / 64 - 5;
    return level < half ? half : level > 7 ? 7 : level;
}

static bool close_to_next(double diameter) {
    const double at = 64 * log2(diameter) + 0.5;
    return fabs(at - nearbyint(at)) < 1e-3;
}

bool bokeh_oracle_between_nodes(double coc, double fringe) {
    const double d = fabs(coc);
    return close_to_next(d) || close_to_next(d * (1 + fringe)) || close_to_next(d * (1 - fringe));
}

/* ---- the mask */

/* The texel that covers [x0, x1] x [y0, y1] of the image. */
static double box_mean(const bokeh_iris *i, const float *image, double x0, double x1, double y0, double y1) {
    double sum = 0;
    for (int y = 0; y < i->s.image.height; y++)
        for (int x = 0; x < i->s.image.width; x++) {
            const double wide = fmin(x + 1, x1) - fmax(x, x0), tall = fmin(y + 1, y1) - fmax(y, y0);
            const float v = image[y * i->s.image.width + x];
            if (wide > 0 && tall > 0 && v > 0 && isfinite(v)) sum += wide * tall * v;
        }
    return sum / ((x1 - x0) * (y1 - y0));
}

static void make_texels(bokeh_iris *i, const float *image) {
    const double side = fmax(i->s.image.width, i->s.image.height), step = side / 128;
    const double left = (side - i->s.image.width) / 2, top = (side - i->s.image.height) / 2;
    double *t = i->texel, most = 0;
    for (int y = 0; y < 128; y++)
        for (int x = 0; x < 128; x++) {
            t[128 * y + x] = box_mean(i, image, x * step - left, (x + 1) * step - left, y * step - top, (y + 1) * step - top);
            most = fmax(most, t[128 * y + x]);
        }
    for (int k = 0; k < 128 * 128; k++) t[k] /= most;
    for (int n = 64; n >= 8; n /= 2) {
        double *next = t + 4 * n * n;
        for (int y = 0; y < n; y++)
            for (int x = 0; x < n; x++) {
                const double *p = t + 4 * n * y + 2 * x;
                next[n * y + x] = (p[0] + p[1] + p[2 * n] + p[2 * n + 1]) / 4;
            }
        t = next;
    }
}

/* At (u, v) of -1 to 1, v upwards, of the level whose texels are the largest not above a pixel: 128 texels span the diameter. */
static double image_at(const bokeh_iris *i, double diameter, double u, double v) {
    const double *t = i->texel;
    int n = 128;
    while (n > 8 && diameter <= n / 2 * (1 + 1e-9)) {
        t += n * n;
        n /= 2;
    }
    const double x = (u + 1) / 2 * n - 0.5, y = (1 - v) / 2 * n - 0.5;
    double sum = 0;
    for (int dy = 0; dy < 2; dy++)
        for (int dx = 0; dx < 2; dx++) {
            const double at_x = floor(x) + dx, at_y = floor(y) + dy;
            if (at_x < 0 || at_y < 0 || at_x >= n || at_y >= n) continue;
            sum += (1 - fabs(x - at_x)) * (1 - fabs(y - at_y)) * t[n * (int)at_y + (int)at_x];
        }
    return sum;
}

static double polygon(const bokeh_iris *i, double radius, double x, double y) {
    const ddof_iris *s = &i->s;
    double most = -INFINITY;
    for (int k = 0; k < s->blades; k++) most = fmax(most, x * i->normal[k][0] + y * i->normal[k][1]);
    return (1 - s->curvature) * (radius * cos(TURN / 2 / s->blades) - most) + s->curvature * (radius - length(x, y));
}

/* Not divided by its sum. (dx, dy): from the middle, y downwards; (cat_x, cat_y): c t. */
static double mask(const bokeh_iris *i, double diameter, double side, double cat_x, double cat_y, double dx, double dy) {
    const double radius = diameter / 2, squeeze = i->s.squeeze > 0 ? i->s.squeeze : 1;
    const double x0 = side * dx * squeeze, y0 = -side * dy / i->aspect;
    const double x = x0 * i->turn[0] + y0 * i->turn[1], y = y0 * i->turn[0] - x0 * i->turn[1];
    const double cut = radius - length(x0 + radius * cat_x, y0 + radius * cat_y);
    double cover;
    if (x * x + y * y > 2.25 * (radius + 2) * (radius + 2)) return 0; /* no shape reaches so far */
    if (i->s.shape == DDOF_IRIS_IMAGE) {
        cover = image_at(i, diameter, x / radius, y / radius);
        if (cat_x != 0 || cat_y != 0) cover *= clamp(cut + 0.5, 0, 1);
    } else {
        const double inside = i->s.shape == DDOF_IRIS_POLYGON ? polygon(i, radius, x, y) : radius - length(x, y);
        cover = clamp(fmin(inside, cat_x != 0 || cat_y != 0 ? cut : inside) + 0.5, 0, 1);
    }
    const double r = fmin(length(x, y) / radius, 1);
    return cover * (1 + side * i->s.edge * (2 * r * r - 1));
}

static double lattice_sum(const bokeh_iris *i, double diameter, double side, double off_x, double off_y, double cat_x) {
    const int wide = (int)(0.75 * diameter) + 3, tall = (int)(0.75 * diameter * i->aspect + 2 * i->aspect) + 3;
    double sum = 0;
    for (int y = -tall; y <= tall; y++)
        for (int x = -wide; x <= wide; x++) sum += mask(i, diameter, side, cat_x, 0, x + off_x, y + off_y);
    return sum;
}

/* Of a sprite of a node in its target of level l, whose pixels' middles lie (off_x, off_y) from its own. */
static double sum_of(bokeh_iris *i, int node, int level, double side, double off_x, double off_y) {
    const int table = node - 64 * level, place = level ? 1 + (off_x > 0) + 2 * (off_y > 0) : 0;
    double *sum = &i->sum[place][side < 0][table + 64];
    if (*sum == 0) *sum = lattice_sum(i, diameter_of(table), side, off_x, off_y, 0);
    return *sum;
}

bokeh_iris *bokeh_iris_make(const ddof_iris *s, const float *image, double aspect) {
    bokeh_iris *i = calloc(1, sizeof *i);
    if (!i) abort();
    i->s = *s;
    i->aspect = aspect;
    i->turn[0] = cos(s->rotation / 360 * TURN);
    i->turn[1] = sin(s->rotation / 360 * TURN);
    for (int k = 0; k < s->blades; k++) {
        i->normal[k][0] = cos((k + 0.5) * TURN / s->blades);
        i->normal[k][1] = sin((k + 0.5) * TURN / s->blades);
    }
    if (s->shape == DDOF_IRIS_IMAGE) make_texels(i, image);
    for (int k = 0; k <= 64 && s->cats_eye > 0; k++)
        i->cats_gain[k] = fmin(lattice_sum(i, 64, 1, 0, 0, 0) / lattice_sum(i, 64, 1, 0, 0, k / 64.0), 1e3);
    return i;
}

void bokeh_iris_free(bokeh_iris *iris) {
    free(iris);
}

/* ---- sprites */

typedef struct sprite {
    int x, y;
    double coc, color[4], one;
} sprite;

/* Sums of a level. */
typedef struct target {
    int width, height;
    double *sum[2]; /* far, near: RGBA and 1, interleaved */
} target;

static double visible(double p, double s) {
    const double ratio = s > 0 ? p / s : p >= s ? 1 : s / p;
    return isnan(ratio) ? 1 : smooth(0.25, 0.75, ratio);
}

static bool is_half(const bokeh_oracle *o, bool full) {
    return o->sprites.resolution == DDOF_RESOLUTION_HALF || (full && o->sprites.resolution == DDOF_RESOLUTION_DEFAULT);
}

static double limit_of(const bokeh_oracle *o) {
    return clamp((o->sprites.limit > 0 ? o->sprites.limit : 0.25) * o->whole_width, 1, 4096);
}

/* Channels first to last of a sprite, at its CoC for them. */
static void draw(const bokeh_oracle *o, const target *t, int level, const sprite *s, double diameter, int first, int last) {
    const double aspect = o->iris->aspect, size = 1 << level, side = s->coc < 0 ? -1 : 1;
    const int node = node_of(diameter), u = level ? s->x >> (level - 1) : 0, v = level ? s->y >> (level - 1) : 0;
    const double x = level ? u / 2.0 - 0.25 : s->x, y = level ? v / 2.0 - 0.25 : s->y;
    const double diagonal = length(o->whole_width, o->whole_height / aspect) / 2;
    const double cat_x = o->iris->s.cats_eye * (s->x + o->left - (o->whole_width - 1) / 2.0) / diagonal;
    const double cat_y = o->iris->s.cats_eye * ((o->whole_height - 1) / 2.0 - (s->y + o->top)) / aspect / diagonal;
    const double at = fmin(length(cat_x, cat_y), 1) * 64;
    const int below = at < 63 ? (int)at : 63;
    const double *gain = o->iris->cats_gain;
    const double brighter = o->iris->s.cats_eye > 0 ? gain[below] + (at - below) * (gain[below + 1] - gain[below]) : 1;
    const double part = brighter / sum_of(o->iris, node, level, side, floor(x + 0.5) - x, floor(y + 0.5) - y);
    for (int Y = 0; Y < t->height; Y++)
        for (int X = 0; X < t->width; X++) {
            const double m = mask(o->iris, diameter_of(node) / size, side, cat_x, cat_y, X - x, Y - y);
            const double seen = m > 0 ? part * m * visible((double)o->coc[(Y << level) * o->width + (X << level)], s->coc) : 0;
            double *to = t->sum[s->coc < 0] + 5 * (Y * t->width + X);
            for (int c = first; c <= last && seen > 0; c++) to[c] += seen * (c < 4 ? s->color[c] : s->one);
        }
}

static void draw_sprite(const bokeh_oracle *o, target *t, bool full, const sprite *s) {
    const double d = fabs(s->coc), fringe = (s->coc < 0 ? -1 : 1) * (o->colors == 3 ? o->iris->s.fringe : 0);
    const int level = level_of(node_of(d), is_half(o, full));
    if (!t[level].sum[0])
        for (int i = 0; i < 2; i++) t[level].sum[i] = calloc(5 * (size_t)t[level].width * (size_t)t[level].height, sizeof(double));
    if (!t[level].sum[0] || !t[level].sum[1]) abort();
    if (fringe == 0) {
        draw(o, &t[level], level, s, d, 0, 4);
        return;
    }
    draw(o, &t[level], level, s, d * (1 + fringe), 0, 0);
    draw(o, &t[level], level, s, d, 1, 1);
    draw(o, &t[level], level, s, d * (1 - fringe), 2, 2);
    draw(o, &t[level], level, s, d, 3, 4);
}

static void make_targets(const bokeh_oracle *o, target t[8]) {
    for (int l = 0; l < 8; l++) t[l] = (target){(o->width + (1 << l) - 1) >> l, (o->height + (1 << l) - 1) >> l, {NULL, NULL}};
}

static void free_targets(target t[8]) {
    for (int l = 0; l < 8; l++) free(t[l].sum[0]), free(t[l].sum[1]);
}

/* Sums of all levels at a pixel of the picture. */
static void gather(const target t[8], int near, int x, int y, double sum[5]) {
    memset(sum, 0, 5 * sizeof *sum);
    for (int l = 0; l < 8; l++) {
        const double size = 1 << l, u = clamp((x + 0.5) / size - 0.5, 0, t[l].width - 1), v = clamp((y + 0.5) / size - 0.5, 0, t[l].height - 1);
        const int u0 = (int)u, v0 = (int)v, u1 = u0 + 1 < t[l].width ? u0 + 1 : u0, v1 = v0 + 1 < t[l].height ? v0 + 1 : v0;
        for (int c = 0; c < 5 && t[l].sum[near]; c++) {
            const double *s = t[l].sum[near] + c;
            const int w = 5 * t[l].width;
            const double above = s[v0 * w + 5 * u0] + (u - u0) * (s[v0 * w + 5 * u1] - s[v0 * w + 5 * u0]);
            const double under = s[v1 * w + 5 * u0] + (u - u0) * (s[v1 * w + 5 * u1] - s[v1 * w + 5 * u0]);
            sum[c] += (above + (v - v0) * (under - above)) / (size * size);
        }
    }
}

/* ---- highlights */

static bool known(const bokeh_oracle *o, int x, int y) {
    const float *p = o->rgba + 4 * (y * o->width + x);
    return isfinite(p[0]) && isfinite(p[1]) && isfinite(p[2]) && isfinite(p[3]) && isfinite(o->coc[y * o->width + x]);
}

static double bright(const bokeh_oracle *o, int x, int y) {
    double v = -INFINITY;
    for (int c = 0; c < o->colors; c++) v = fmax(v, (double)o->rgba[4 * (y * o->width + x) + c]);
    return v;
}

static double coc_around(const bokeh_oracle *o, int x, int y) {
    double most = -INFINITY, coc = 0;
    for (int j = y - 2; j <= y + 2; j++)
        for (int i = x - 2; i <= x + 2; i++) {
            if (i < 0 || j < 0 || i >= o->width || j >= o->height || !known(o, i, j) || bright(o, i, j) <= most) continue;
            most = bright(o, i, j);
            coc = clamp((double)o->coc[j * o->width + i], -1e5, 1e5);
        }
    return coc;
}

/* Those of `found` have their brightness in `one`; what is too large is counted only. */
static int list(const bokeh_oracle *o, double threshold, sprite *found, int64_t *large) {
    int count = 0;
    *large = 0;
    for (int y = 0; y < o->height; y++)
        for (int x = 0; x < o->width; x++) {
            if (!known(o, x, y) || !(bright(o, x, y) > threshold)) continue;
            const double coc = coc_around(o, x, y);
            if (!(fabs(coc) > 2)) continue;
            if (fabs(coc) > limit_of(o))
                ++*large;
            else
                found[count++] = (sprite){.x = x, .y = y, .coc = coc, .one = bright(o, x, y)};
        }
    return count;
}

/* The lowest edge of a bin that keeps within the limits; more than any value where none does. */
static double raise_threshold(const bokeh_oracle *o, double threshold, const sprite *all, int count) {
    const int most = o->sprites.max_sprites ? o->sprites.max_sprites : 65536;
    const double area = (o->sprites.max_area ? o->sprites.max_area : 64) * (double)o->whole_width * o->whole_height;
    for (int bin = 0; bin < 512; bin++) {
        const double edge = threshold * exp2(bin / 16.0);
        double sum = 0;
        int above = 0;
        for (int i = 0; i < count; i++) {
            if (!(all[i].one > edge)) continue;
            const int node = node_of(fabs(all[i].coc));
            sum += pow(diameter_of(node) / (1 << level_of(node, is_half(o, false))), 2);
            above++;
        }
        if (above <= most && sum <= area) return edge;
    }
    return INFINITY;
}

/* Of a circle around 0, what lies on one side of a line at a distance of `at` radii. */
static double segment(double at) {
    const double h = clamp(at, -1, 1);
    return 0.5 + (h * sqrt(1 - h * h) + asin(h)) * 2 / TURN;
}

/* How much of a sprite lies in the picture, columns and rows by themselves. */
static double inside(const bokeh_oracle *o, int x, int y, double diameter) {
    const double radius = diameter / 2, tall = radius * o->iris->aspect;
    const double across = segment((x + 0.5) / radius) - segment((x + 0.5 - o->width) / radius);
    return across * (segment((y + 0.5) / tall) - segment((y + 0.5 - o->height) / tall));
}

bokeh_counts bokeh_oracle_highlights(const bokeh_oracle *o, float *rest, double *drawn) {
    const int n = o->width * o->height;
    sprite *all = calloc((size_t)n, sizeof *all);
    target t[8];
    bokeh_counts counts = {.threshold = o->sprites.threshold > 0 ? (double)(float)o->sprites.threshold : 1};
    if (!all) abort();
    const int candidates = list(o, counts.threshold, all, &counts.large);
    counts.threshold = raise_threshold(o, counts.threshold, all, candidates);
    make_targets(o, t);
    memcpy(rest, o->rgba, 4 * (size_t)n * sizeof *rest);
    for (int i = 0; i < candidates; i++) {
        sprite *s = &all[i];
        const int at = 4 * (s->y * o->width + s->x);
        if (!(s->one > counts.threshold)) continue;
        const double here = inside(o, s->x, s->y, diameter_of(node_of(fabs(s->coc))));
        for (int c = 0; c < o->colors; c++) {
            s->color[c] = (double)o->rgba[at + c] * smooth(2, 4, fabs(s->coc)) * (1 - pow(counts.threshold / s->one, 2));
            rest[at + c] = (float)((double)o->rgba[at + c] - here * s->color[c]);
        }
        draw_sprite(o, t, false, s);
        counts.drawn++;
    }
    counts.dropped = candidates - counts.drawn;
    for (int i = 0; i < n; i++) {
        double far[5], near[5];
        gather(t, 0, i % o->width, i / o->width, far);
        gather(t, 1, i % o->width, i / o->width, near);
        for (int c = 0; c < 4; c++) drawn[4 * i + c] = far[c] + near[c];
    }
    free_targets(t);
    free(all);
    return counts;
}

/* ---- every pixel */

static void mix(double *out, const double *sum, double share) {
    for (int c = 0; c < 4; c++) out[c] += share * (sum[c] / sum[4] - out[c]);
}

void bokeh_oracle_full(const bokeh_oracle *o, double *out) {
    const int n = o->width * o->height;
    float *limited = calloc((size_t)n, sizeof *limited);
    bokeh_oracle l = *o;
    target t[8];
    if (!limited) abort();
    make_targets(o, t);
    l.coc = limited;
    for (int i = 0; i < n; i++) limited[i] = (float)clamp((double)o->coc[i], -limit_of(o), limit_of(o));
    for (int i = 0; i < n; i++) {
        const double coc = (double)limited[i], share = smooth(2, 4, fabs(coc));
        sprite s = {.x = i % o->width, .y = i / o->width, .coc = coc, .one = share};
        for (int c = 0; c < 4; c++) s.color[c] = share * (double)o->rgba[4 * i + c];
        if (share > 0) draw_sprite(&l, t, true, &s);
    }
    for (int i = 0; i < n; i++) {
        double far[5], near[5];
        const double coc = (double)limited[i], share = smooth(2, 4, fabs(coc));
        for (int c = 0; c < 4; c++) out[4 * i + c] = (double)o->rgba[4 * i + c];
        gather(t, 0, i % o->width, i / o->width, far);
        gather(t, 1, i % o->width, i / o->width, near);
        if (coc > 0 && far[4] > 1e-6) mix(out + 4 * i, far, share);
        if (coc < 0 && near[4] > 1e-6) mix(out + 4 * i, near, share);
        if (near[4] > 1e-6) mix(out + 4 * i, near, fmin(near[4], 1));
    }
    free_targets(t);
    free(limited);
}
