/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* One layer cannot show what lies behind (docs/layers.md). Here a picture becomes up to four, by CoC:
 *     nearest, near   nearer than the focus; parted where their blur falls into two groups
 *     focus           |CoC| below 1 to 2 pixels
 *     far             the rest
 * Neighbouring layers share a pixel smoothly, so that a surface that runs through both shows no seam. A layer is premultiplied
 * colour and coverage. Where something nearer hides it, both are filled from around, and where it has no pixels, its CoC is:
 * so it continues behind what is near, and its edge spreads as wide as its CoC says. Each is diffused by itself, and from the
 * last to the nearest laid over those behind it. A holdout is a hole in all of them, and its pixels are put back at the end.
 *
 * A picture that has only one of the layers is diffused as it is. The arithmetic of a row is in cpu/layers.c. */
#include "layers.h"

#include <math.h>
#include <string.h>

#include "coc_limits.h"
#include "cpu/kernels.h"
#include "fill.h"
#include "image.h"

enum {
    LAYERS = 4,
    BAND = 16, /* rows of a task */
    GRID = 64  /* rectangles begin at multiples of it: the pyramids of a fill do not shift from frame to frame */
};

/* CoC between which a pixel goes over from the focus to what is out of it, pixels. Below, blur is hardly seen. */
#define FOCUS_LEAST 1.0f
#define FOCUS_MOST 2.0f
/* Half the width of the passage between the two near layers, and the least CoC to part them at. */
#define PART_SOFT 0.05f
#define PART_LEAST 2.2f

typedef struct layer {
    layer_share share;
    bool last;           /* behind everything: opaque */
    bool focus, near;
    int x0, y0, x1, y1;  /* the pixels it can reach */
    float widest;        /* |CoC| */
} layer;

/* Of the last layer, and of what is nearer than the first. */
static const layer_share everything = {0, 1}, nothing = {0, 0};

/* Premultiplied RGBA float, rows `stride` bytes apart. */
typedef struct pixels {
    char *base;
    ptrdiff_t stride;
} pixels;

typedef struct work {
    ddof_context *ctx;
    frame_job *job;
    const pixel_kernels *k;
    const layer_kernels *layers;
    int width, height, channels, bands;
    bool straight, opaque; /* the picture's alpha; opaque: 1 everywhere, or none */
    ddof_image color, output; /* the caller's, resolved */
    pixels source;         /* the picture, holes and holdouts filled: the caller's where it is fit for that */
    float *copy;           /* room for the source where it is not */
    float *coc;            /* signed; until they are filled, holes are NaN */
    pixels layer;          /* the layer under work */
    float *reach;          /* its CoC */
    float *coverage;       /* of it, where its pixels have no channel to spare; else NULL */
    pixels result;         /* the layers so far: the caller's output where it is fit for that */
    float *row;            /* per worker: RGBA, mask */
    void *rest;            /* fill, or backend */
    atomic_llong holes, held; /* pixels that were not finite; that a mask holds out */
    atomic_int transparent;
    atomic_llong near_class[NEAR_CLASSES];
    atomic_int box[LAYERS][4];
    atomic_int widest[LAYERS]; /* bits of a float >= 0 */
    layer parts[LAYERS];
    int count;
    const layer *now;
    layer_share nearer; /* than now */
} work;

bool layers_wanted(const frame_job *job) {
    return job->settings->layers == DDOF_LAYERS_AUTO || job->frame->holdout;
}

/* ---- memory */

static float *take(char *base, size_t *used, size_t count) {
    float *p = base ? (float *)(void *)(base + *used) : NULL;
    *used += (count * sizeof(float) + 63) / 64 * 64;
    return p;
}

static pixels take_pixels(const work *w, char *base, size_t *used) {
    float *p = take(base, used, 4 * (size_t)w->width * (size_t)w->height);
    return (pixels){(char *)p, (ptrdiff_t)sizeof(float) * 4 * w->width};
}

static inline float *at(pixels p, int x, int y) {
    return p.base ? (float *)(void *)(p.base + p.stride * y) + 4 * (ptrdiff_t)x : NULL;
}

/* A job that blurs the layer's part of a picture in place. */
static void inner(const work *w, const frame_job *job, inner_job *i, float *first, ptrdiff_t stride, int channels,
                  const layer *l) {
    const int width = l->x1 - l->x0, height = l->y1 - l->y0;
    const ddof_image part = ddof_image_interleaved(first, width, height, channels, DDOF_FLOAT, stride);
    const ddof_image coc = ddof_image_interleaved(w->reach ? w->reach + (ptrdiff_t)w->width * l->y0 + l->x0 : NULL, width, height,
                                                  1, DDOF_FLOAT, (ptrdiff_t)sizeof(float) * w->width);
    pipeline_inner(i, job, &part, &coc, l->x0, l->y0);
    if (l->focus) { /* at 2 pixels a disc, or a sprite, cannot be told from a bell */
        i->job.disc = NULL;
        i->job.highlights = false;
        if (i->job.method == DDOF_METHOD_SCATTER) i->job.method = DDOF_METHOD_DIFFUSION;
        i->settings.kernel = DDOF_KERNEL_HEAT;
        i->settings.quality = DDOF_QUALITY_DEFAULT;
        i->settings.method = i->job.method;
        i->settings.bokeh = DDOF_BOKEH_OFF;
    }
    if (channels == 1 && i->job.highlights) { /* coverage shines nowhere */
        i->job.highlights = false;
        i->settings.bokeh = DDOF_BOKEH_OFF;
    }
}

static size_t largest(size_t a, size_t b) {
    return a > b ? a : b;
}

static size_t lay_out(work *w, const ddof_context *ctx, const frame_job *job, char *base) {
    const ddof_image *color = &job->frame->color;
    size_t used = 0;
    w->width = color->width;
    w->height = color->height;
    w->channels = color->channels;
    w->bands = (w->height + BAND - 1) / BAND;
    const size_t n = (size_t)w->width * (size_t)w->height, wide = (size_t)w->width;
    w->copy = take(base, &used, 4 * n);
    w->coc = take(base, &used, n);
    w->layer = take_pixels(w, base, &used);
    w->reach = take(base, &used, n);
    w->result = take_pixels(w, base, &used);
    w->coverage = w->channels == 4 ? take(base, &used, n) : NULL;
    /* the caller's loop may use all its workers, also where the backend has one thread */
    w->row = take(base, &used, 5 * wide * (size_t)(ctx->pool ? ctx->threads : ctx->config.threads));
    w->rest = take(base, &used, 0);
    size_t rest = largest(fill_bytes(4, w->width, w->height), pipeline_blur_bytes(ctx, job));
    rest = largest(rest, (wide + 2) * (size_t)w->height * sizeof(float)); /* of spread_near() */
    layer whole = {.x1 = w->width, .y1 = w->height};
    for (int kind = 0; kind < 4; kind++) {
        inner_job i;
        const int channels = kind % 2 ? 1 : 4;
        whole.focus = kind / 2;
        inner(w, job, &i, NULL, (ptrdiff_t)sizeof(float) * channels * w->width, channels, &whole);
        rest = largest(rest, pipeline_blur_bytes(ctx, &i.job));
    }
    return used + rest;
}

size_t layers_scratch_bytes(const ddof_context *ctx, const frame_job *job) {
    work w = {0};
    return lay_out(&w, ctx, job, NULL);
}

/* ---- loops over rows */

typedef struct loop {
    work *w;
    void (*row)(work *w, int y, float *room);
    int y0, y1;
} loop;

static void loop_band(void *data, int index, int worker) {
    const loop *l = data;
    float *room = l->w->row + 5 * (size_t)l->w->width * (size_t)worker;
    for (int i = 0, y = l->y0 + index * BAND; i < BAND && y < l->y1; i++, y++) l->row(l->w, y, room);
    context_progress(l->w->ctx, 0);
}

static ddof_status rows(work *w, int y0, int y1, void (*row)(work *w, int y, float *room)) {
    const ddof_config *config = &w->ctx->config;
    loop l = {w, row, y0, y1};
    if (config->parallel_for(config->parallel_user, (y1 - y0 + BAND - 1) / BAND, loop_band, &l)) return DDOF_ERROR_MEMORY;
    return w->ctx->cancelled ? DDOF_ERROR_CANCELLED : DDOF_OK;
}

/* ---- the picture */

static float clamped(float v) {
    return v > 0 ? v < 1 ? v : 1 : 0; /* what is not a number is 0 */
}

static void mask_row(const work *w, int x, int y, int count, float *mask) {
    memset(mask, 0, (size_t)count * sizeof *mask);
    if (!w->job->frame->holdout) return;
    ddof_image image = *w->job->frame->holdout;
    image_resolve(&image);
    plane_load(&image, 0, x, y, count, mask, w->k);
    for (int i = 0; i < count; i++) mask[i] = clamped(mask[i]);
}

/* Channels that are missing are 0, alpha is 1. */
static void color_row(const work *w, int x, int y, int count, float *rgba, bool multiply) {
    if (image_is_rgba(&w->color) && !multiply) {
        memcpy(rgba, image_at(&w->color, 0, x, y), 4 * (size_t)count * sizeof *rgba);
        return;
    }
    span_load(&w->color, x, y, count, rgba, multiply, w->k);
    for (int i = 0; i < count && w->channels < 4; i++) rgba[4 * (size_t)i + 3] = 1;
}

static bool finite_rgba(const float *p) {
    return finite_value(p[0]) && finite_value(p[1]) && finite_value(p[2]) && finite_value(p[3]);
}

/* Marks in a row of CoC the holes and what `mask`, where there is one, holds out entirely. */
static void find_holes(work *w, const float *rgba, float *coc, const float *mask) {
    int64_t holes = 0;
    int transparent = 0;
    for (int x = 0; x < w->width; x++) {
        const float *p = rgba + 4 * (size_t)x;
        const bool hole = !finite_rgba(p) || !finite_value(coc[x]);
        holes += hole;
        if (hole || (mask && mask[x] == 1))
            coc[x] = NAN;
        else
            transparent |= p[3] != 1;
    }
    atomic_fetch_add(&w->holes, holes);
    if (transparent) atomic_store(&w->transparent, 1);
}

static void load_row(work *w, int y, float *room) {
    float *coc = w->coc + (size_t)w->width * (size_t)y, *rgba = at(w->source, 0, y);
    frame_job *job = w->job;
    int classes[NEAR_CLASSES] = {0};
    if (w->source.base == (char *)w->copy) color_row(w, 0, y, w->width, rgba, w->straight);
    ddof_image map = job->coc_source;
    image_resolve(&map);
    plane_load(&map, 0, 0, y, w->width, coc, w->k);
    if (job->is_depth) w->k->lens(&job->curve, coc, coc, w->width, job->frame->offset_x, y + job->frame->offset_y);
    for (int x = 0; x < w->width; x++) coc[x] = coc_within(coc[x], (float)COC_LIMIT);
    const int found = w->layers->inspect(rgba, coc, w->width);
    if (job->frame->holdout) {
        int64_t held = 0;
        mask_row(w, 0, y, w->width, room);
        for (int x = 0; x < w->width; x++) held += room[x] > 0;
        atomic_fetch_add(&w->held, held);
        find_holes(w, rgba, coc, room);
    } else if (found & ROW_NOT_FINITE) {
        find_holes(w, rgba, coc, NULL);
    } else if (found & ROW_TRANSPARENT) {
        atomic_store(&w->transparent, 1);
    }
    w->layers->classify(coc, w->width, FOCUS_MOST, classes);
    for (int c = 0; c < NEAR_CLASSES; c++)
        if (classes[c]) atomic_fetch_add(&w->near_class[c], classes[c]);
}

/* What is neither a hole nor held out. */
static void known_weight(const work *w, int x, int y, int count, float *weight) {
    const float *coc = w->coc + (ptrdiff_t)w->width * y + x;
    mask_row(w, x, y, count, weight);
    for (int i = 0; i < count; i++) weight[i] = finite_value(coc[i]) ? 1 - weight[i] : 0;
}

static void known_color(void *user, int x, int y, int count, float *value, float *weight) {
    const work *w = user;
    color_row(w, x, y, count, value, w->straight);
    known_weight(w, x, y, count, weight);
    for (int i = 0; i < count; i++)
        if (weight[i] == 0) memset(value + 4 * (size_t)i, 0, 4 * sizeof *value);
}

static void known_coc(void *user, int x, int y, int count, float *value, float *weight) {
    const work *w = user;
    const float *coc = w->coc + (ptrdiff_t)w->width * y + x;
    known_weight(w, x, y, count, weight);
    for (int i = 0; i < count; i++) value[i] = finite_value(coc[i]) ? coc[i] : 0;
}

/* Where the picture is read and the result made: the caller's memory, where the one is not needed after the other. */
static void choose_memory(work *w) {
    const bool in_place = w->color.plane[0].data == w->output.plane[0].data;
    w->source = (pixels){(char *)w->copy, (ptrdiff_t)sizeof(float) * 4 * w->width};
    if (image_is_rgba(&w->color) && !w->straight && !in_place)
        w->source = (pixels){w->color.plane[0].data, w->color.plane[0].row_stride};
    if (image_is_rgba(&w->output) && !w->straight && !(in_place && w->job->frame->holdout))
        w->result = (pixels){w->output.plane[0].data, w->output.plane[0].row_stride};
}

static ddof_status load(work *w) {
    choose_memory(w);
    ddof_status status = rows(w, 0, w->height, load_row);
    w->opaque = w->channels < 4 || !w->transparent;
    if (status != DDOF_OK || (!w->holes && !w->held)) return status;
    const ptrdiff_t stride = (ptrdiff_t)sizeof(float) * w->width;
    w->source = (pixels){(char *)w->copy, 4 * stride};
    fill_picture p = {.channels = 4, .width = w->width, .height = w->height, .load = known_color, .user = w};
    status = fill_unknown(w->ctx, &p, w->copy, w->source.stride, w->rest);
    p.channels = 1;
    p.load = known_coc;
    return status == DDOF_OK ? fill_unknown(w->ctx, &p, w->coc, stride, w->rest) : status;
}

/* ---- which layers there are */

/* The CoC at which a class of the histogram begins: octaves, linear within. Between classes of fractions. */
static double class_border(double class) {
    const double octave = floor(class / NEAR_OCTAVE);
    return exp2(octave) * (1 + class / NEAR_OCTAVE - octave);
}

/* The CoC that parts what is near into two groups, by Otsu's criterion: the one that makes their means most different. A
 * mean over all CoC, so weighted that nearly only the best count: in a gap it falls in the middle, and it moves smoothly
 * from frame to frame. 0: nothing to part. */
static float parting(const work *w) {
    double count[NEAR_CLASSES], sum[NEAR_CLASSES], between[NEAR_CLASSES] = {0}, n = 0, s = 0, n0 = 0, s0 = 0, most = 0, weight = 0, mean = 0;
    for (int b = 0; b < NEAR_CLASSES; b++) {
        const double d = class_border(b + 0.5);
        count[b] = (double)atomic_load(&w->near_class[b]);
        sum[b] = count[b] * (d < w->width ? d : w->width);
        n += count[b];
        s += sum[b];
    }
    for (int b = 1; b < NEAR_CLASSES; b++) {
        n0 += count[b - 1];
        s0 += sum[b - 1];
        if (!(n0 > 0 && n0 < n)) continue;
        const double apart = s0 / n0 - (s - s0) / (n - n0);
        between[b] = n0 * (n - n0) * apart * apart;
        most = fmax(most, between[b]);
    }
    if (!(most > 0)) return 0;
    for (int b = 1; b < NEAR_CLASSES; b++) {
        const double share = pow(between[b] / most, 32);
        weight += share;
        mean += share * b;
    }
    return (float)class_border(mean / weight);
}

/* Between -CoC of `least`, where what is nearer begins to rise, and `most`, where it is all. */
static layer_share rising(float least, float most) {
    return (layer_share){1 / (most - least), -least / (most - least)};
}

static void raise(atomic_int *most, int value) {
    int old = atomic_load(most);
    while (value > old && !atomic_compare_exchange_weak(most, &old, value)) {}
}

static void extent_row(work *w, int y, float *room) {
    const float *coc = w->coc + (size_t)w->width * (size_t)y;
    (void)room;
    for (int l = 0; l < w->count; l++) {
        int first, last, bits;
        float widest;
        if (!w->layers->extent(coc, w->width, w->parts[l].share, l ? w->parts[l - 1].share : nothing, &first, &last, &widest))
            continue;
        const int box[4] = {-first, -y, last, y};
        for (int i = 0; i < 4; i++) raise(&w->box[l][i], box[i]);
        memcpy(&bits, &widest, sizeof bits);
        raise(&w->widest[l], bits);
    }
}

static int clip(double v, int least, int most) {
    return v < least ? least : v > most ? most : (int)v;
}

/* Drops layers without pixels, and says how far the others reach. */
static void keep_used(work *w) {
    const frame_job *job = w->job;
    const double scale = job->disc ? 1 : sqrt(32 * job->row_scale * job->substeps); /* of the width of the kernel */
    /* widths to where less than 1e-5 is left, so that no light is bright enough to show the rectangle's edge */
    const bool long_tail = job->disc ? job->settings->quality == DDOF_QUALITY_DRAFT : job->substeps < 3;
    const double tall = job->pixel_aspect, tail = long_tail ? 2.5 : 1.5;
    const bool whole = w->ctx->backend->open != NULL; /* a device keeps surfaces of one size */
    int count = 0, box[4] = {-INT32_MAX, -INT32_MAX, -1, -1};
    for (int l = 0; l < w->count; l++) {
        layer part = w->parts[l];
        int bits = atomic_load(&w->widest[l]);
        if (atomic_load(&w->box[l][2]) < 0) continue;
        for (int i = 0; i < 4; i++) { /* and what nearer ones hide, where it is filled */
            const int own = atomic_load(&w->box[l][i]);
            box[i] = own > box[i] ? own : box[i];
        }
        memcpy(&part.widest, &bits, sizeof part.widest);
        const double reach = tail * scale * (double)part.widest + 4;
        part.x0 = whole ? 0 : clip(-box[0] - reach, 0, w->width) & -GRID;
        part.y0 = whole ? 0 : clip(-box[1] - reach * tall - 4, 0, w->height) & -GRID;
        part.x1 = whole ? w->width : clip(box[2] + 1 + reach, 0, w->width);
        part.y1 = whole ? w->height : clip(box[3] + 1 + reach * tall + 4, 0, w->height);
        w->parts[count++] = part;
    }
    w->count = count;
    layer *last = &w->parts[count - 1];
    last->last = true;
    last->share = everything;
    last->x0 = last->y0 = 0;
    last->x1 = w->width;
    last->y1 = w->height;
}

static ddof_status find_layers(work *w) {
    const float parted = parting(w);
    w->count = 0;
    if (w->job->settings->layers == DDOF_LAYERS_AUTO) {
        if (parted >= PART_LEAST)
            w->parts[w->count++] = (layer){.share = rising(parted * (1 - PART_SOFT), parted * (1 + PART_SOFT)), .near = true};
        w->parts[w->count++] = (layer){.share = rising(FOCUS_LEAST, FOCUS_MOST), .near = true};
        w->parts[w->count++] = (layer){.share = rising(-FOCUS_MOST, -FOCUS_LEAST), .focus = true};
    }
    w->parts[w->count++] = (layer){.share = everything, .last = true};
    for (int l = 0; l < LAYERS; l++)
        for (int i = 0; i < 4; i++) atomic_store(&w->box[l][i], -INT32_MAX);
    ddof_status status = rows(w, 0, w->height, extent_row);
    if (status == DDOF_OK) keep_used(w);
    return status;
}

/* ---- one layer; its pixels are counted from x0, y0 */

static const float *coc_at(const work *w, int x, int y) {
    return w->coc + (ptrdiff_t)w->width * (w->now->y0 + y) + w->now->x0 + x;
}

static void split(void *user, int x, int y, int count, float *value, float *weight) {
    const work *w = user;
    const layer *l = w->now;
    w->layers->split(at(w->source, l->x0 + x, l->y0 + y), coc_at(w, x, y), count, l->share, w->nearer, value, weight);
}

static void cover(void *user, int x, int y, int count, float *value, float *weight) {
    const work *w = user;
    w->layers->cover(coc_at(w, x, y), count, w->now->share, w->nearer, value, weight);
}

static void reach(void *user, int x, int y, int count, float *value, float *weight) {
    const work *w = user;
    w->layers->reach(coc_at(w, x, y), count, w->now->share, w->nearer, value, weight);
}

/* A link takes the smaller CoC of its ends, so what is near would spread over something less near of its own layer only as
 * wide as that one does. So around each pixel CoC falls no faster than by 1 a pixel, which a disc's does from its middle
 * to nothing at twice its rim; surfaces slope less and stay. Two passes over the rectangle, the distance 1 along and
 * sqrt 2 across (of pixels that are not square: as long as they are). */
static ddof_status spread_near(work *w) {
    const layer *l = w->now;
    const int width = l->x1 - l->x0, height = l->y1 - l->y0;
    const ptrdiff_t stride = width + 2;
    const double tall = 1 / w->job->pixel_aspect;
    const float slope = (float)tall, across = (float)sqrt(1 + tall * tall);
    float *first = (float *)w->rest + 1;
    for (int y = 0; y < height; y++) {
        float *row = first + stride * y;
        w->layers->reach(coc_at(w, 0, y), width, l->share, w->nearer, row, w->row);
        row[-1] = row[width] = 0;
        w->layers->spread(y ? row - stride : NULL, row, width, slope, across, true);
    }
    for (int y = height - 1; y >= 0; y--) {
        float *row = first + stride * y, *out = w->reach + (ptrdiff_t)w->width * (l->y0 + y) + l->x0;
        w->layers->spread(y < height - 1 ? row + stride : NULL, row, width, slope, across, false);
        for (int x = 0; x < width; x++) out[x] = -(out[x] > row[x] ? out[x] : row[x]); /* the sign is that of what is near */
    }
    context_progress(w->ctx, 0);
    return w->ctx->cancelled ? DDOF_ERROR_CANCELLED : DDOF_OK;
}

static ddof_status fill_layer(work *w, int channels,
                              void (*make)(void *user, int x, int y, int count, float *value, float *weight), bool whole,
                              float *out, ptrdiff_t stride) {
    const layer *l = w->now;
    const fill_picture p = {channels, l->x1 - l->x0, l->y1 - l->y0, make, w, whole};
    return fill_unknown(w->ctx, &p, out, stride, w->rest);
}

static ddof_status diffuse_layer(work *w, float *first, ptrdiff_t stride, int channels, double from, double to) {
    inner_job i;
    inner(w, w->job, &i, first, stride, channels, w->now);
    context_stage(w->ctx, from, to);
    const ddof_status status = pipeline_blur(w->ctx, &i.job, w->rest);
    w->job->sprites += i.job.sprites;
    w->job->sprites_dropped += i.job.sprites_dropped;
    w->job->sprites_large += i.job.sprites_large;
    return status;
}

/* Lays the layer under work over those behind it, which are the result. */
static void over_row(work *w, int y, float *room) {
    const layer *l = w->now;
    (void)room;
    if (l->last || y < l->y0 || y >= l->y1) return;
    const float *cover = w->coverage ? w->coverage + (ptrdiff_t)w->width * y + l->x0 : NULL;
    w->layers->over(at(w->layer, l->x0, y), cover, at(w->result, l->x0, y), l->x1 - l->x0);
}

static ddof_status one_layer(work *w, double from, double to) {
    const layer *l = w->now;
    const bool first = l == w->parts, separate = w->coverage && !l->last;
    const pixels out = l->last ? w->result : w->layer;
    const ptrdiff_t stride = (ptrdiff_t)sizeof(float) * w->width, begin = (ptrdiff_t)w->width * l->y0 + l->x0;
    float *rgba = at(out, l->x0, l->y0), *coverage = separate ? w->coverage + begin : NULL;
    ddof_status status = fill_layer(w, 4, split, first, rgba, out.stride);
    if (status == DDOF_OK && separate) status = fill_layer(w, 1, cover, first, coverage, stride);
    if (status == DDOF_OK) status = fill_layer(w, 1, reach, false, w->reach + begin, stride);
    if (status == DDOF_OK && l->near) status = spread_near(w);
    if (status == DDOF_OK) status = diffuse_layer(w, rgba, out.stride, 4, from, separate ? (from + to) / 2 : to);
    if (status == DDOF_OK && separate) status = diffuse_layer(w, coverage, stride, 1, (from + to) / 2, to);
    return status == DDOF_OK && !first ? rows(w, l->y0, l->y1, over_row) : status;
}

/* ---- the frame */

/* `color`: as the caller gave it. The colour of a hole is not used. */
static void mix_held(const work *w, float mask, const float *color, float *rgba) {
    const int alpha = w->straight ? w->channels - 1 : -1;
    if (!(mask > 0) || !finite_rgba(color)) return;
    for (int c = 0; c < 4; c++)
        rgba[c] = mask * (c < alpha ? color[c] * color[alpha] : color[c]) + (1 - mask) * rgba[c];
}

/* Those held out entirely: the very bits, not multiplied and divided. */
static void put_back_held(const work *w, int y, const float *mask, const float *color) {
    for (int x = 0, end; x < w->width; x = end) {
        for (end = x; end < w->width && mask[end] == 1 && finite_rgba(color + 4 * (size_t)end);) end++;
        if (end > x)
            span_store(&w->output, x, y, end - x, color + 4 * (size_t)x, false, w->k);
        else
            end++;
    }
}

static void store_row(work *w, int y, float *room) {
    float *rgba = at(w->result, 0, y);
    over_row(w, y, room);
    for (ptrdiff_t x = 0; x < w->width && w->opaque && w->channels == 4; x++) rgba[4 * x + 3] = 1;
    float *mask = room, *color = room + w->width;
    if (w->held) {
        mask_row(w, 0, y, w->width, mask);
        color_row(w, 0, y, w->width, color, false);
        for (ptrdiff_t x = 0; x < w->width; x++) mix_held(w, mask[x], color + 4 * x, rgba + 4 * x);
    }
    if (w->result.base != w->output.plane[0].data) span_store(&w->output, 0, y, w->width, rgba, w->straight, w->k);
    if (w->held) put_back_held(w, y, mask, color);
}

/* One layer that nothing was taken out of is the picture itself. */
static ddof_status as_it_is(work *w) {
    ddof_settings plain = *w->job->settings;
    plain.layers = DDOF_LAYERS_OFF;
    const ddof_settings *given = w->job->settings;
    w->job->settings = &plain;
    const double shown = (w->ctx->progress_shown - w->ctx->image_from) / w->ctx->image_share;
    context_stage(w->ctx, shown > 0 ? shown : 0, 1);
    const ddof_status status = pipeline_blur(w->ctx, w->job, w->rest);
    w->job->settings = given;
    return status;
}

ddof_status layers_diffuse(ddof_context *ctx, frame_job *job, void *scratch) {
    work w = {.ctx = ctx, .job = job, .k = ctx->kernels->pixels, .layers = ctx->kernels->layers};
    w.color = job->frame->color;
    w.output = job->frame->output;
    w.straight = w.color.alpha == DDOF_ALPHA_STRAIGHT;
    w.color.alpha = w.output.alpha = DDOF_ALPHA_PREMULTIPLIED; /* from here on `straight` says it */
    image_resolve(&w.color);
    image_resolve(&w.output);
    lay_out(&w, ctx, job, scratch);
    ddof_status status = load(&w);
    if (status == DDOF_OK) status = find_layers(&w);
    if (status != DDOF_OK) return status;
    if (w.count == 1 && !w.held) return as_it_is(&w);
    job->nonfinite_pixels += w.holes;
    if (w.opaque) w.coverage = NULL;
    for (int l = w.count - 1, done = 0; l >= 0 && status == DDOF_OK; l--, done++) {
        w.now = &w.parts[l];
        w.nearer = l ? w.parts[l - 1].share : nothing;
        status = one_layer(&w, (double)done / w.count, (done + 1.0) / w.count);
    }
    return status == DDOF_OK ? rows(&w, 0, w.height, store_row) : status;
}
