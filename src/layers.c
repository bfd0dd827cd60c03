/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* One layer cannot show what lies behind (docs/method.md, section 8). Here a picture becomes up to four, by CoC:
 *     nearest, near   nearer than the focus; parted where their blur falls into two groups
 *     focus           |CoC| below 1 to 2 pixels
 *     far             the rest
 * Neighbouring layers share a pixel smoothly, so that a surface that runs through both shows no seam. A layer is premultiplied
 * colour and coverage. Where something nearer hides it, both are filled from around, and where it has no pixels, its CoC is:
 * so it continues behind what is near, and its edge spreads as wide as its CoC says. Each is diffused by itself; laid
 * over each other they are the picture. A holdout is a hole in all of them, and its pixels are put back at the end.
 *
 * A picture that has only one of the layers is diffused as it is. */
#include "layers.h"

#include <math.h>
#include <string.h>

#include "cpu/kernels.h"
#include "fill.h"
#include "image.h"

enum { LAYERS = 4, BAND = 16 /* rows of a task */, OCTAVE = 8, BINS = 20 * OCTAVE };

/* CoC between which a pixel goes over from the focus to what is out of it, pixels. Below, blur is hardly seen. */
#define FOCUS_LEAST 1.0f
#define FOCUS_MOST 2.0f
/* Half the width of the passage between the two near layers, and the least CoC to part them at. */
#define PART_SOFT 0.05f
#define PART_LEAST 2.2f

typedef struct layer {
    float least, most;   /* -CoC at which its and all nearer layers' common share begins to rise, and is 1; the last: none */
    bool last;           /* behind everything: opaque */
    bool focus;
    int x0, y0, x1, y1;  /* the pixels it can reach */
    float widest;        /* |CoC| */
} layer;

typedef struct work {
    ddof_context *ctx;
    frame_job *job;
    const pixel_kernels *k;
    int width, height, channels, bands;
    bool straight, opaque; /* the picture's alpha; opaque: 1 everywhere, or none */
    float *source;         /* premultiplied RGBA, holes and holdouts filled */
    float *coc;            /* signed */
    float *known;          /* weight for a fill */
    float *layer, *reach;  /* the layer under work: premultiplied RGBA and its CoC */
    float *coverage;       /* of it, where its pixels have no channel to spare; else NULL */
    float *result, *through; /* layers so far, and what shines through them */
    float *row;            /* per worker: RGBA, CoC, mask */
    void *rest;            /* fill, or backend */
    atomic_llong holes, held; /* pixels that were not finite; that a mask holds out */
    atomic_int transparent;
    atomic_llong near_bin[BINS];
    atomic_int box[LAYERS][4];
    atomic_int widest[LAYERS]; /* bits of a float >= 0 */
    layer parts[LAYERS];
    int count;
    const layer *now, *nearer; /* NULL: there is none */
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

/* A job that diffuses `width` x `height` pixels of the layer from (x, y) in place. */
typedef struct inner_job {
    frame_job job;
    ddof_frame frame;
    ddof_settings settings;
} inner_job;

static void inner(const work *w, const frame_job *job, inner_job *i, float *pixels, int channels, int x, int y, int width,
                  int height) {
    const size_t at = (size_t)w->width * (size_t)y + (size_t)x;
    i->job = *job;
    i->frame = *job->frame;
    i->frame.holdout = NULL;
    i->frame.depth = (ddof_image){0};
    i->frame.color = i->frame.output = ddof_image_interleaved(pixels ? pixels + (size_t)channels * at : NULL, width, height, channels,
                                                              DDOF_FLOAT, (ptrdiff_t)sizeof(float) * channels * w->width);
    i->frame.coc = ddof_image_interleaved(w->reach ? w->reach + at : NULL, width, height, 1, DDOF_FLOAT,
                                          (ptrdiff_t)sizeof(float) * w->width);
    i->settings = *job->settings;
    i->settings.layers = DDOF_LAYERS_OFF;
    i->job.settings = &i->settings;
    i->job.frame = &i->frame;
    i->job.coc_source = i->frame.coc;
    i->job.is_depth = false;
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
    w->source = take(base, &used, 4 * n);
    w->coc = take(base, &used, n);
    w->known = take(base, &used, n);
    w->layer = take(base, &used, 4 * n);
    w->reach = take(base, &used, n);
    w->result = take(base, &used, 4 * n);
    w->through = take(base, &used, n);
    w->coverage = w->channels == 4 ? take(base, &used, n) : NULL;
    w->row = take(base, &used, 6 * wide * (size_t)ctx->threads);
    w->rest = take(base, &used, 0);
    size_t rest = largest(fill_bytes(4, w->width, w->height), ctx->backend->scratch_bytes(ctx, job));
    for (int channels = 4; channels > 0; channels -= 3) {
        inner_job i;
        inner(w, job, &i, w->layer, channels, 0, 0, w->width, w->height);
        rest = largest(rest, ctx->backend->scratch_bytes(ctx, &i.job));
        i.job.disc = NULL;
        rest = largest(rest, ctx->backend->scratch_bytes(ctx, &i.job));
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
    float *room = l->w->row + 6 * (size_t)l->w->width * (size_t)worker;
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

static bool finite(float v) {
    return v - v == 0;
}

static float clamped(float v) {
    return v > 0 ? v < 1 ? v : 1 : 0; /* what is not a number is 0 */
}

static void mask_row(const work *w, int y, float *mask) {
    memset(mask, 0, (size_t)w->width * sizeof *mask);
    if (!w->job->frame->holdout) return;
    ddof_image image = *w->job->frame->holdout;
    image_resolve(&image);
    plane_load(&image, 0, 0, y, w->width, mask, w->k);
    for (int x = 0; x < w->width; x++) mask[x] = clamped(mask[x]);
}

static void color_row(const work *w, int y, float *rgba) {
    ddof_image image = w->job->frame->color;
    image_resolve(&image);
    image.alpha = DDOF_ALPHA_PREMULTIPLIED;
    span_load(&image, 0, y, w->width, rgba, w->straight, w->k);
}

/* Which of BINS logarithmic classes a positive CoC belongs to, from its exponent and the leading bits behind it. */
static int bin_of(float d) {
    int32_t bits;
    memcpy(&bits, &d, sizeof bits);
    const int bin = (bits >> 20) - (127 << 3); /* OCTAVE = 8 to an octave, from 1 pixel */
    return bin < 0 ? 0 : bin < BINS ? bin : BINS - 1;
}

static void load_row(work *w, int y, float *room) {
    const size_t at = (size_t)w->width * (size_t)y;
    float *rgba = w->source + 4 * at, *coc = w->coc + at, *known = w->known + at, *mask = room;
    const frame_job *job = w->job;
    int64_t holes = 0, held = 0;
    int bins[BINS] = {0}, transparent = 0;
    color_row(w, y, rgba);
    mask_row(w, y, mask);
    ddof_image map = job->coc_source;
    image_resolve(&map);
    plane_load(&map, 0, 0, y, w->width, coc, w->k);
    if (job->is_depth) w->k->lens(&job->curve, coc, coc, w->width, job->frame->offset_x, y + job->frame->offset_y);
    for (int x = 0; x < w->width; x++) {
        float *p = rgba + 4 * (size_t)x;
        known[x] = 1 - mask[x];
        held += mask[x] > 0;
        if (finite(p[0]) && finite(p[1]) && finite(p[2]) && finite(p[3]) && finite(coc[x])) {
            if (-coc[x] > FOCUS_MOST) bins[bin_of(-coc[x])]++;
            transparent |= p[3] != 1;
            continue;
        }
        memset(p, 0, 4 * sizeof *p);
        coc[x] = known[x] = 0;
        holes++;
    }
    atomic_fetch_add(&w->holes, holes);
    atomic_fetch_add(&w->held, held);
    if (transparent) atomic_store(&w->transparent, 1);
    for (int b = 0; b < BINS; b++)
        if (bins[b]) atomic_fetch_add(&w->near_bin[b], bins[b]);
}

static ddof_status fill_rect(work *w, float *value, int channels, int x0, int y0, int x1, int y1) {
    const size_t at = (size_t)w->width * (size_t)y0 + (size_t)x0;
    const fill_picture p = {value + (size_t)channels * at, w->known + at, channels, x1 - x0, y1 - y0, w->width};
    return fill_unknown(w->ctx, &p, w->rest);
}

static ddof_status load(work *w) {
    ddof_status status = rows(w, 0, w->height, load_row);
    w->opaque = w->channels < 4 || !w->transparent;
    if (status != DDOF_OK || (!w->holes && !w->held)) return status;
    status = fill_rect(w, w->source, 4, 0, 0, w->width, w->height);
    return status == DDOF_OK ? fill_rect(w, w->coc, 1, 0, 0, w->width, w->height) : status;
}

/* ---- which layers there are */

/* The CoC that parts what is near into two groups, by Otsu's criterion: the one that makes their means most different. A
 * mean over all CoC, so weighted that nearly only the best count: in a gap it falls in the middle, and it moves smoothly
 * from frame to frame. 0: nothing to part. */
static float parting(const work *w) {
    double count[BINS], sum[BINS], between[BINS] = {0}, n = 0, s = 0, n0 = 0, s0 = 0, most = 0, weight = 0, mean = 0;
    for (int b = 0; b < BINS; b++) {
        const double d = exp2((b + 0.5) / OCTAVE);
        count[b] = (double)atomic_load(&w->near_bin[b]);
        sum[b] = count[b] * (d < w->width ? d : w->width);
        n += count[b];
        s += sum[b];
    }
    for (int b = 1; b < BINS; b++) {
        n0 += count[b - 1];
        s0 += sum[b - 1];
        if (!(n0 > 0 && n0 < n)) continue;
        const double apart = s0 / n0 - (s - s0) / (n - n0);
        between[b] = n0 * (n - n0) * apart * apart;
        most = fmax(most, between[b]);
    }
    if (!(most > 0)) return 0;
    for (int b = 1; b < BINS; b++) {
        const double share = pow(between[b] / most, 32);
        weight += share;
        mean += share * b;
    }
    return (float)exp2(mean / weight / OCTAVE);
}

static float smooth(float least, float most, float x) {
    float t = (x - least) / (most - least);
    t = t > 0 ? t < 1 ? t : 1 : 0;
    return t * t * (3 - 2 * t);
}

/* Of a pixel: what belongs to this layer and all nearer ones. */
static inline float share_up_to(const layer *l, float coc) {
    return !l ? 0 : l->last ? 1 : smooth(l->least, l->most, -coc);
}

static void extent_row(work *w, int y, float *room) {
    const float *coc = w->coc + (size_t)w->width * (size_t)y;
    (void)room;
    for (int l = 0; l < w->count; l++) {
        const layer *here = &w->parts[l], *nearer = l ? here - 1 : NULL;
        int first = -1, last = -1;
        float widest = 0;
        for (int x = 0; x < w->width; x++) {
            if (!(share_up_to(here, coc[x]) > share_up_to(nearer, coc[x]))) continue;
            if (first < 0) first = x;
            last = x;
            widest = fmaxf(widest, fabsf(coc[x]));
        }
        if (first < 0) continue;
        const int now[4] = {-first, -y, last, y};
        for (int i = 0; i < 4; i++) {
            int old = atomic_load(&w->box[l][i]);
            while (now[i] > old && !atomic_compare_exchange_weak(&w->box[l][i], &old, now[i])) {}
        }
        int bits, old = atomic_load(&w->widest[l]);
        memcpy(&bits, &widest, sizeof bits);
        while (bits > old && !atomic_compare_exchange_weak(&w->widest[l], &old, bits)) {}
    }
}

static int clip(double v, int least, int most) {
    return v < least ? least : v > most ? most : (int)v;
}

/* Drops layers without pixels, and says how far the others reach. */
static void keep_used(work *w) {
    const frame_job *job = w->job;
    const double scale = job->disc ? 1 : sqrt(32 * job->row_scale * job->substeps); /* of the width of the kernel */
    const double tall = job->pixel_aspect;
    const bool whole = w->ctx->backend->open != NULL; /* a device keeps surfaces of one size */
    int count = 0;
    for (int l = 0; l < w->count; l++) {
        layer part = w->parts[l];
        int box[4], bits = atomic_load(&w->widest[l]);
        for (int i = 0; i < 4; i++) box[i] = atomic_load(&w->box[l][i]);
        if (box[2] < 0) continue;
        memcpy(&part.widest, &bits, sizeof part.widest);
        const double reach = 1.5 * scale * (double)part.widest + 4;
        part.x0 = whole ? 0 : clip(-box[0] - reach, 0, w->width);
        part.y0 = whole ? 0 : clip(-box[1] - reach * tall - 4, 0, w->height);
        part.x1 = whole ? w->width : clip(box[2] + 1 + reach, 0, w->width);
        part.y1 = whole ? w->height : clip(box[3] + 1 + reach * tall + 4, 0, w->height);
        w->parts[count++] = part;
    }
    w->count = count;
    layer *last = &w->parts[count - 1];
    last->last = true;
    last->x0 = last->y0 = 0;
    last->x1 = w->width;
    last->y1 = w->height;
}

static ddof_status find_layers(work *w) {
    const float at = parting(w);
    w->count = 0;
    if (w->job->settings->layers == DDOF_LAYERS_AUTO) {
        if (at >= PART_LEAST)
            w->parts[w->count++] = (layer){.least = at * (1 - PART_SOFT), .most = at * (1 + PART_SOFT)};
        w->parts[w->count++] = (layer){.least = FOCUS_LEAST, .most = FOCUS_MOST};
        w->parts[w->count++] = (layer){.least = -FOCUS_MOST, .most = -FOCUS_LEAST, .focus = true};
    }
    w->parts[w->count++] = (layer){.last = true};
    for (int l = 0; l < LAYERS; l++)
        for (int i = 0; i < 4; i++) atomic_store(&w->box[l][i], -INT32_MAX);
    ddof_status status = rows(w, 0, w->height, extent_row);
    if (status == DDOF_OK) keep_used(w);
    return status;
}

/* ---- one layer */

/* Takes the layer's part of the picture; known: 0 where something nearer hides it. */
static void split_row(work *w, int y, float *room) {
    const layer *l = w->now;
    (void)room;
    for (int x = l->x0; x < l->x1; x++) {
        const size_t i = (size_t)w->width * (size_t)y + (size_t)x;
        const float hidden = share_up_to(w->nearer, w->coc[i]), seen = 1 - hidden;
        const float cover = l->last ? 1 : seen > 0 ? (share_up_to(l, w->coc[i]) - hidden) / seen : 0;
        float *out = w->layer + 4 * i;
        for (int c = 0; c < 4; c++) out[c] = cover * w->source[4 * i + (size_t)c];
        if (w->coverage)
            w->coverage[i] = cover;
        else
            out[3] = cover;
        /* where it shares a pixel, its colour is that of the pixel, not of what lies around */
        w->known[i] = 4 * seen < 1 ? 4 * seen : 1;
    }
}

/* The layer's CoC where it has pixels. */
static void reach_row(work *w, int y, float *room) {
    const layer *l = w->now;
    (void)room;
    for (int x = l->x0; x < l->x1; x++) {
        const size_t i = (size_t)w->width * (size_t)y + (size_t)x;
        const bool own = share_up_to(l, w->coc[i]) > share_up_to(w->nearer, w->coc[i]);
        w->known[i] = own;
        w->reach[i] = own ? fabsf(w->coc[i]) : 0;
    }
}

/* Lays the layer behind those before it. */
static void compose_row(work *w, int y, float *room) {
    const layer *l = w->now;
    (void)room;
    for (int x = l->x0; x < l->x1; x++) {
        const size_t i = (size_t)w->width * (size_t)y + (size_t)x;
        const float *in = w->layer + 4 * i;
        const float through = w->through[i], cover = l->last ? 1 : w->coverage ? w->coverage[i] : in[3];
        for (size_t c = 0; c < 4; c++) w->result[4 * i + c] += through * in[c];
        w->through[i] = through * (1 - cover);
    }
}

static ddof_status diffuse_layer(work *w, float *pixels, int channels, double from, double to) {
    const layer *l = w->now;
    inner_job i;
    inner(w, w->job, &i, pixels, channels, l->x0, l->y0, l->x1 - l->x0, l->y1 - l->y0);
    if (l->focus && i.job.disc) { /* at 2 pixels a disc cannot be told from a bell */
        i.job.disc = NULL;
        i.settings.kernel = DDOF_KERNEL_HEAT;
        i.settings.quality = DDOF_QUALITY_DEFAULT;
    }
    context_stage(w->ctx, from, to);
    return w->ctx->backend->diffuse(w->ctx, &i.job, w->rest);
}

static ddof_status one_layer(work *w, double from, double to) {
    const layer *l = w->now;
    ddof_status status = rows(w, l->y0, l->y1, split_row);
    if (status == DDOF_OK && w->nearer) {
        status = fill_rect(w, w->layer, 4, l->x0, l->y0, l->x1, l->y1);
        if (status == DDOF_OK && w->coverage) status = fill_rect(w, w->coverage, 1, l->x0, l->y0, l->x1, l->y1);
    }
    if (status == DDOF_OK) status = rows(w, l->y0, l->y1, reach_row);
    if (status == DDOF_OK) status = fill_rect(w, w->reach, 1, l->x0, l->y0, l->x1, l->y1);
    const bool separate = w->coverage && !l->last;
    if (status == DDOF_OK) status = diffuse_layer(w, w->layer, 4, from, separate ? (from + to) / 2 : to);
    if (status == DDOF_OK && separate) status = diffuse_layer(w, w->coverage, 1, (from + to) / 2, to);
    return status == DDOF_OK ? rows(w, l->y0, l->y1, compose_row) : status;
}

/* ---- the frame */

static void clear_row(work *w, int y, float *room) {
    const size_t at = (size_t)w->width * (size_t)y;
    (void)room;
    memset(w->result + 4 * at, 0, 4 * (size_t)w->width * sizeof(float));
    for (int x = 0; x < w->width; x++) w->through[at + (size_t)x] = 1;
}

static void store_row(work *w, int y, float *room) {
    const size_t n = (size_t)w->width;
    float *rgba = w->result + 4 * n * (size_t)y, *mask = room, *color = room + n;
    ddof_image output = w->job->frame->output;
    image_resolve(&output);
    output.alpha = DDOF_ALPHA_PREMULTIPLIED;
    if (w->opaque && w->channels == 4)
        for (size_t x = 0; x < n; x++) rgba[4 * x + 3] = 1;
    if (w->held) {
        mask_row(w, y, mask);
        color_row(w, y, color);
        for (size_t x = 0; x < n; x++)
            for (size_t c = 0; c < 4 && mask[x] > 0; c++) {
                const float held = finite(color[4 * x + c]) ? color[4 * x + c] : rgba[4 * x + c];
                rgba[4 * x + c] = mask[x] * held + (1 - mask[x]) * rgba[4 * x + c];
            }
    }
    span_store(&output, 0, y, w->width, rgba, w->straight, w->k);
}

/* One layer that nothing was taken out of is the picture itself. */
static ddof_status as_it_is(work *w) {
    ddof_settings plain = *w->job->settings;
    plain.layers = DDOF_LAYERS_OFF;
    const ddof_settings *given = w->job->settings;
    w->job->settings = &plain;
    context_stage(w->ctx, w->ctx->progress_shown, 1);
    const ddof_status status = w->ctx->backend->diffuse(w->ctx, w->job, w->rest);
    w->job->settings = given;
    return status;
}

ddof_status layers_diffuse(ddof_context *ctx, frame_job *job, void *scratch) {
    work w = {.ctx = ctx, .job = job, .k = ctx->kernels->pixels, .straight = job->frame->color.alpha == DDOF_ALPHA_STRAIGHT};
    lay_out(&w, ctx, job, scratch);
    ddof_status status = load(&w);
    if (status == DDOF_OK) status = find_layers(&w);
    if (status != DDOF_OK) return status;
    if (w.count == 1 && !w.held) return as_it_is(&w);
    job->nonfinite_pixels += w.holes;
    if (w.opaque) w.coverage = NULL;
    status = rows(&w, 0, w.height, clear_row);
    for (int l = 0; l < w.count && status == DDOF_OK; l++) {
        w.now = &w.parts[l];
        w.nearer = l ? w.now - 1 : NULL;
        status = one_layer(&w, (double)l / w.count, (l + 1.0) / w.count);
    }
    return status == DDOF_OK ? rows(&w, 0, w.height, store_row) : status;
}
