/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* On the CPU: the picture comes as RGBA into memory that it can be blurred in, the caller's output where that is fit for it.
 *     HIGHLIGHTS  candidates are counted by brightness, those that fit are listed, row by row; their light is taken out, the rest blurred by
 *                 the backend, and they are drawn.
 *     FULL        two pictures, far and near, are drawn of all pixels, and laid together. */
#include "bokeh.h"

#include <math.h>
#include <string.h>

#include "coc_limits.h"
#include "fill.h"
#include "image.h"
#include "scatter.h"

enum {
    BAND = 16,  /* rows of a task */
    CHUNK = 64, /* pixels whose brightest is remembered */
    AREA_UNIT = 16 /* areas are summed in sixteenths of a square pixel: the sum does not depend on its order */
};

/* ---- what is asked for */

static bool within(double v, double least, double most) {
    return v >= least && v <= most;
}

static const char *check_sprites(const ddof_sprites *s) {
    for (size_t i = 0; i < sizeof s->reserved / sizeof *s->reserved; i++)
        if (s->reserved[i]) return "sprites.reserved must be 0";
    if (s->reserved_int) return "sprites.reserved_int must be 0";
    if (s->threshold != 0 && !within(s->threshold, 1e-30, 1e30)) return "sprites.threshold must be above 0, or 0 for 1";
    if (!within(s->limit, 0, 1)) return "sprites.limit must be 0 to 1, a fraction of the picture's width";
    if (s->max_sprites < 0 || s->max_sprites > 1 << 20) return "sprites.max_sprites must be 1 to 1048576, or 0 for 65536";
    if (s->max_area < 0 || s->max_area > 1024) return "sprites.max_area must be 1 to 1024, or 0 for 64";
    if (s->resolution < DDOF_RESOLUTION_DEFAULT || s->resolution > DDOF_RESOLUTION_HALF)
        return "sprites.resolution is none of ddof_resolution";
    if (s->append < DDOF_APPEND_DEFAULT || s->append > DDOF_APPEND_ARGUMENTS) return "sprites.append is none of ddof_append";
    if (s->quads < DDOF_QUADS_DEFAULT || s->quads > DDOF_QUADS_GEOMETRY) return "sprites.quads is none of ddof_quads";
    return NULL;
}

const char *bokeh_check(const ddof_settings *s) {
    if (s->bokeh < DDOF_BOKEH_OFF || s->bokeh > DDOF_BOKEH_FULL) return "bokeh is none of ddof_bokeh";
    if (s->bokeh == DDOF_BOKEH_OFF && s->method != DDOF_METHOD_SCATTER) return NULL;
    const char *wrong = check_sprites(&s->sprites);
    return wrong ? wrong : iris_check(&s->iris);
}

bokeh_limits bokeh_limits_of(const frame_job *job) {
    const ddof_sprites *s = &job->settings->sprites;
    const ddof_frame *f = job->frame;
    const double width = f->picture_width ? f->picture_width : f->color.width;
    const double height = f->picture_width ? f->picture_height : f->color.height;
    const double largest = (s->limit > 0 ? s->limit : 0.25) * width;
    const bool full = job->method == DDOF_METHOD_SCATTER;
    return (bokeh_limits){.threshold = s->threshold > 0 ? (float)s->threshold : 1,
                          .largest = (float)fmin(fmax(largest, 1), (double)IRIS_MOST),
                          .max_sprites = s->max_sprites ? s->max_sprites : 65536,
                          .max_area = (s->max_area ? s->max_area : 64) * width * height,
                          .half = s->resolution == DDOF_RESOLUTION_DEFAULT ? full : s->resolution == DDOF_RESOLUTION_HALF};
}

/* Of a disc, what lies on the near side of a line at a distance of `at` radii. */
static float segment(float at) {
    const float h = at < 1 ? at > -1 ? at : -1 : 1;
    return 0.5f + (h * sqrtf(1 - h * h) + asinf(h)) * 0.318309886f;
}

float bokeh_inside(int x, int y, int width, int height, float diameter, float aspect) {
    const float per_x = 2 / diameter, per_y = per_x / aspect, u = (float)x + 0.5f, v = (float)y + 0.5f;
    const float across = segment(u * per_x) + segment(((float)width - u) * per_x) - 1;
    return across * (segment(v * per_y) + segment(((float)height - v) * per_y) - 1);
}

/* ---- the budget */

float bokeh_edge(int bin, float threshold) {
    return threshold * exp2f((float)bin / BOKEH_BIN_OCTAVE);
}

/* By the edges themselves, so that what lies above one is counted above it: a logarithm is off by a bit where they meet. */
int bokeh_bin(float v, float threshold) {
    const float at = log2f(v / threshold) * BOKEH_BIN_OCTAVE;
    int bin = at > 0 ? at < BOKEH_BINS - 1 ? (int)at : BOKEH_BINS - 1 : 0;
    while (bin > 0 && v <= bokeh_edge(bin, threshold)) bin--;
    while (bin < BOKEH_BINS - 1 && v > bokeh_edge(bin + 1, threshold)) bin++;
    return bin;
}

float bokeh_raise(const bokeh_limits *limits, const int64_t count[BOKEH_BINS], const double area[BOKEH_BINS], int64_t *dropped) {
    int64_t sprites = 0;
    double sum = 0;
    int bin = BOKEH_BINS;
    *dropped = 0;
    while (bin > 0 && sprites + count[bin - 1] <= limits->max_sprites && sum + area[bin - 1] <= limits->max_area) {
        bin--;
        sprites += count[bin];
        sum += area[bin];
    }
    for (int b = 0; b < bin; b++) *dropped += count[b];
    if (bin == BOKEH_BINS) return INFINITY; /* the last one has no upper edge */
    return *dropped ? bokeh_edge(bin, limits->threshold) : limits->threshold;
}

/* ---- memory */

/* RGBA float, rows `stride` bytes apart. */
typedef struct pixels {
    char *base;
    ptrdiff_t stride;
} pixels;

typedef struct work {
    ddof_context *ctx;
    frame_job *job;
    const cpu_kernels *k;
    bokeh_limits limits;
    int width, height, colors, chunks;
    bool straight, direct; /* direct: the result is the caller's output */
    ddof_image color, output; /* the caller's, resolved, alpha as it comes */
    pixels source;            /* where the picture is read: the caller's memory where it is fit for that */
    pixels picture, result;   /* what light is taken from; what it is drawn on, after the blur. May be the same */
    const float **rows;       /* NULL, or of the picture those that light was taken from: the others are only read */
    float *coc;
    bool coc_direct;          /* that is the caller's */
    float *peak;              /* the brightest of each chunk */
    int *first;               /* sprite of a row; height + 1 */
    bokeh_sprite *sprite;
    bokeh_sprite *listed;     /* FULL: per worker, of a row */
    scatter scatter;
    void *rest;               /* the backend's, or the targets and the workers' masks */
    float raised;             /* the threshold */
    int level;                /* under work */
    int64_t drawn[BOKEH_LEVELS]; /* HIGHLIGHTS: sprites of each */
    float *sums;              /* FULL: per worker, of a row: far and near, RGBA and weight */
    atomic_llong large, holes, every; /* every: FULL: sprites */
    atomic_llong count[BOKEH_BINS], area[BOKEH_BINS];
} work;

static void *take(char *base, size_t *used, size_t bytes) {
    void *p = base ? base + *used : NULL;
    *used += (bytes + 63) / 64 * 64;
    return p;
}

static int workers(const ddof_context *ctx) {
    return ctx->pool ? ctx->threads : ctx->config.threads;
}

static void take_target(work *w, char *base, size_t *used, int level, scatter_target *t) {
    const scatter_level *l = &w->scatter.level[level];
    const size_t n = (size_t)l->width * (size_t)l->height;
    const bool full = w->job->method == DDOF_METHOD_SCATTER;
    *t = (scatter_target){.rgba = (float *)(void *)w->result.base, .row_stride = w->result.stride};
    if (!full && level == 0) return;
    t->row_stride = (ptrdiff_t)sizeof(float) * 4 * l->width;
    t->rgba = take(base, used, n * 4 * sizeof(float));
    if (full) t->weight = take(base, used, n * sizeof(float));
    if (base) memset(t->rgba, 0, n * 4 * sizeof(float));
    if (base && full) memset(t->weight, 0, n * sizeof(float));
}

/* Pictures of the levels that have sprites; HIGHLIGHTS draws level 0 into the picture itself. */
static size_t take_targets(work *w, char *base) {
    scatter *s = &w->scatter;
    const bool full = w->job->method == DDOF_METHOD_SCATTER;
    size_t used = 0;
    for (int i = s->first; i < s->levels; i++) {
        scatter_level *l = &s->level[i];
        if (base && !full && !w->drawn[i]) continue;
        l->begin = take(base, &used, (size_t)l->height * sizeof(int));
        l->end = take(base, &used, (size_t)l->height * sizeof(int));
        take_target(w, base, &used, i, &l->far);
        l->near = l->far;
        if (full) take_target(w, base, &used, i, &l->near);
        for (int y = 0; y < l->height && base; y++) l->begin[y] = l->width, l->end[y] = 0;
    }
    const size_t masks = scatter_take(s, base ? base + used : NULL, workers(w->ctx));
    return used + masks;
}

/* The blur of what is left. */
static void inner_of(const work *w, inner_job *inner) {
    const ddof_image part = ddof_image_interleaved(w->source.base, w->width, w->height, 4, DDOF_FLOAT, w->source.stride);
    const ddof_image map = ddof_image_interleaved(w->coc, w->width, w->height, 1, DDOF_FLOAT, 0);
    pipeline_inner(inner, w->job, &part, &map, 0, 0);
    inner->frame.output = ddof_image_interleaved(w->result.base, w->width, w->height, 4, DDOF_FLOAT, w->result.stride);
    inner->job.source_rows = w->rows;
    inner->job.highlights = false;
    inner->settings.bokeh = DDOF_BOKEH_OFF;
}

static size_t lay_out(work *w, ddof_context *ctx, frame_job *job, char *base) {
    const ddof_image *color = &job->frame->color;
    size_t used = 0;
    *w = (work){.ctx = ctx, .job = job, .k = ctx->kernels, .limits = bokeh_limits_of(job), .width = color->width, .height = color->height};
    w->color = *color;
    w->output = job->frame->output;
    w->straight = color->alpha == DDOF_ALPHA_STRAIGHT;
    w->color.alpha = w->output.alpha = DDOF_ALPHA_PREMULTIPLIED;
    image_resolve(&w->color);
    image_resolve(&w->output);
    w->colors = w->straight && color->channels == 2 ? 1 : color->channels < 3 ? color->channels : 3;
    w->direct = image_is_rgba(&w->output) && !w->straight;
    w->chunks = (w->width + CHUNK - 1) / CHUNK;
    const size_t n = (size_t)w->width * (size_t)w->height, tall = (size_t)w->height;
    const bool full = job->method == DDOF_METHOD_SCATTER;
    w->result = (pixels){w->output.plane[0].data, w->output.plane[0].row_stride};
    w->picture = w->result;
    /* a disc of several components wants its source until the end: in place it would keep a sum of its own */
    if (!w->direct || (job->disc && !full))
        w->picture = (pixels){take(base, &used, n * 4 * sizeof(float)), (ptrdiff_t)sizeof(float) * 4 * w->width};
    if (!w->direct) w->result = w->picture;
    w->source = w->picture;
    if (ctx->backend->rows && !full && w->direct && image_is_rgba(&w->color) && w->color.plane[0].data != w->output.plane[0].data) {
        if (w->picture.base == w->result.base)
            w->picture = (pixels){take(base, &used, n * 4 * sizeof(float)), (ptrdiff_t)sizeof(float) * 4 * w->width};
        w->source = (pixels){w->color.plane[0].data, w->color.plane[0].row_stride};
        w->rows = take(base, &used, tall * sizeof *w->rows);
        if (base) memset(w->rows, 0, tall * sizeof *w->rows);
    }
    ddof_image map = job->coc_source;
    image_resolve(&map);
    w->coc_direct = !full && !job->is_depth && plane_is_tight(&map.plane[0]) &&
                    map.plane[0].row_stride == (ptrdiff_t)sizeof(float) * w->width;
    w->coc = w->coc_direct ? map.plane[0].data : take(base, &used, n * sizeof(float));
    w->peak = take(base, &used, (size_t)w->chunks * tall * sizeof(float));
    w->first = take(base, &used, (tall + 1) * sizeof(int));
    const size_t most = (size_t)w->limits.max_sprites < n ? (size_t)w->limits.max_sprites : n;
    if (!full) w->sprite = take(base, &used, most * sizeof(bokeh_sprite));
    if (full) w->listed = take(base, &used, (size_t)w->width * (size_t)workers(ctx) * sizeof(bokeh_sprite));
    if (full) w->sums = take(base, &used, 10 * (size_t)w->width * (size_t)workers(ctx) * sizeof(float));
    w->rest = take(base, &used, 0);
    scatter_plan(&w->scatter, ctx, job, &w->limits);
    w->scatter.coc = w->coc;
    const size_t drawing = take_targets(w, NULL);
    if (full) { /* holes are filled before anything is drawn */
        const size_t fill = fill_bytes(4, w->width, w->height);
        return used + (fill > drawing ? fill : drawing);
    }
    inner_job inner;
    inner_of(w, &inner);
    const size_t blur = ctx->backend->scratch_bytes(ctx, &inner.job);
    return used + (blur > drawing ? blur : drawing);
}

size_t bokeh_scratch_bytes(const ddof_context *ctx, const frame_job *job) {
    work w;
    frame_job sized = *job;
    return lay_out(&w, (ddof_context *)ctx, &sized, NULL);
}

/* ---- loops over rows */

typedef struct loop {
    work *w;
    void (*rows)(work *w, int worker, int y0, int y1);
    int height;
} loop;

static void loop_band(void *data, int index, int worker) {
    const loop *l = data;
    const int y0 = index * BAND, y1 = y0 + BAND < l->height ? y0 + BAND : l->height;
    if (!l->w->ctx->cancelled) l->rows(l->w, worker, y0, y1);
    context_progress(l->w->ctx, 0);
}

static ddof_status rows(work *w, int height, void (*do_rows)(work *w, int worker, int y0, int y1)) {
    const ddof_config *config = &w->ctx->config;
    loop l = {w, do_rows, height};
    if (config->parallel_for(config->parallel_user, (height + BAND - 1) / BAND, loop_band, &l)) return DDOF_ERROR_MEMORY;
    return w->ctx->cancelled ? DDOF_ERROR_CANCELLED : DDOF_OK;
}

static inline float *at(pixels p, int x, int y) {
    return (float *)(void *)(p.base + p.stride * y) + 4 * (ptrdiff_t)x;
}

static float *pixel_at(const work *w, int x, int y) {
    return at(w->source, x, y);
}

static float *coc_at(const work *w, int x, int y) {
    return w->coc + (ptrdiff_t)w->width * y + x;
}

/* ---- the picture */

/* Limited; what is no number stays none. */
static void load_coc(const work *w, int y, float *coc) {
    const frame_job *job = w->job;
    const float most = job->method == DDOF_METHOD_SCATTER ? w->limits.largest : (float)COC_LIMIT;
    ddof_image map = job->coc_source;
    image_resolve(&map);
    plane_load(&map, 0, 0, y, w->width, coc, w->k->pixels);
    if (job->is_depth) w->k->pixels->lens(&job->curve, coc, coc, w->width, job->frame->offset_x, y + job->frame->offset_y);
    for (int x = 0; x < w->width; x++) coc[x] = coc_within(coc[x], most);
}

static void load_rows(work *w, int worker, int y0, int y1) {
    (void)worker;
    for (int y = y0; y < y1; y++) {
        float *rgba = pixel_at(w, 0, y), *coc = coc_at(w, 0, y);
        if (image_is_rgba(&w->color) && !w->straight && (void *)rgba != image_at(&w->color, 0, 0, y))
            memcpy(rgba, image_at(&w->color, 0, 0, y), 4 * (size_t)w->width * sizeof *rgba);
        else if (!image_is_rgba(&w->color) || w->straight)
            span_load(&w->color, 0, y, w->width, rgba, w->straight, w->k->pixels);
        if (!w->coc_direct) load_coc(w, y, coc);
        for (int c = 0; c < w->chunks; c++) {
            const int x = c * CHUNK, n = w->width - x < CHUNK ? w->width - x : CHUNK;
            w->peak[(ptrdiff_t)w->chunks * y + c] = w->k->sprites->brightest(rgba + 4 * (ptrdiff_t)x, n, w->colors);
        }
    }
}

static bool finite_pixel(const work *w, int x, int y) {
    const float *p = pixel_at(w, x, y);
    return finite_value(p[0]) && finite_value(p[1]) && finite_value(p[2]) && finite_value(p[3]) && finite_value(*coc_at(w, x, y));
}

static float brightness(const work *w, const float *rgba) {
    float v = rgba[0];
    for (int c = 1; c < w->colors; c++) v = rgba[c] > v ? rgba[c] : v;
    return v;
}

static float smooth(float from, float to, float v) {
    float t = (v - from) / (to - from);
    t = t > 0 ? t < 1 ? t : 1 : 0;
    return t * t * (3 - 2 * t);
}

/* ---- which pixels */

typedef struct candidate {
    float v, coc, share;
    bool large;
} candidate;

/* The CoC of the brightest pixel around: Z is not antialiased, so a light's rim may have that of what is behind it. */
static float brightest_coc(const work *w, int x, int y) {
    const int x0 = x > BOKEH_REACH ? x - BOKEH_REACH : 0, y0 = y > BOKEH_REACH ? y - BOKEH_REACH : 0;
    const int x1 = x + BOKEH_REACH < w->width - 1 ? x + BOKEH_REACH : w->width - 1;
    const int y1 = y + BOKEH_REACH < w->height - 1 ? y + BOKEH_REACH : w->height - 1;
    float most = -INFINITY, coc = 0;
    for (int i = y0; i <= y1; i++)
        for (int j = x0; j <= x1; j++) {
            const float v = brightness(w, pixel_at(w, j, i));
            if (!(v > most) || !finite_pixel(w, j, i)) continue;
            most = v;
            coc = *coc_at(w, j, i);
        }
    return coc;
}

/* Whether there is anything to be taken from a pixel brighter than `threshold`. */
static bool look_at(const work *w, int x, int y, float threshold, candidate *c) {
    *c = (candidate){.v = brightness(w, pixel_at(w, x, y))};
    if (!(c->v > threshold) || !finite_pixel(w, x, y)) return false;
    c->coc = brightest_coc(w, x, y);
    c->share = smooth(BOKEH_LEAST, BOKEH_WHOLE, fabsf(c->coc));
    c->large = fabsf(c->coc) > w->limits.largest;
    return c->share > 0;
}

/* Calls `each` for the candidates of rows y0 to y1 - 1, in reading order. */
static void candidates(work *w, int y0, int y1, float threshold, void (*each)(work *w, int x, int y, const candidate *c, void *user),
                       void *user) {
    candidate c;
    for (int y = y0; y < y1; y++)
        for (int chunk = 0; chunk < w->chunks; chunk++) {
            if (!(w->peak[(ptrdiff_t)w->chunks * y + chunk] > threshold)) continue;
            const int end = (chunk + 1) * CHUNK < w->width ? (chunk + 1) * CHUNK : w->width;
            for (int x = chunk * CHUNK; x < end; x++)
                if (look_at(w, x, y, threshold, &c)) each(w, x, y, &c, user);
        }
}

static void count_one(work *w, int x, int y, const candidate *c, void *user) {
    (void)x, (void)y, (void)user;
    if (c->large) {
        atomic_fetch_add(&w->large, 1);
        return;
    }
    const int bin = bokeh_bin(c->v, w->limits.threshold);
    atomic_fetch_add(&w->count[bin], 1);
    const int node = iris_node(fabsf(c->coc)), level = bokeh_level(node, w->limits.half);
    const float across = w->job->iris->diameter[node] / (float)(1 << level);
    atomic_fetch_add(&w->area[bin], (long long)(across * across * AREA_UNIT));
}

static void count_rows(work *w, int worker, int y0, int y1) {
    (void)worker;
    candidates(w, y0, y1, w->limits.threshold, count_one, NULL);
}

static void count_kept(work *w, int x, int y, const candidate *c, void *user) {
    (void)x, (void)user;
    w->first[y + 1] += !c->large;
}

static void count_kept_rows(work *w, int worker, int y0, int y1) {
    (void)worker;
    for (int y = y0; y < y1; y++) w->first[y + 1] = 0;
    candidates(w, y0, y1, w->raised, count_kept, NULL);
}

static void list_one(work *w, int x, int y, const candidate *c, void *user) {
    int *next = user;
    if (c->large) return;
    const float *rgba = pixel_at(w, x, y), left = w->raised / c->v, part = c->share * (1 - left * left);
    bokeh_sprite *s = &w->sprite[w->first[y] + next[y % BAND]++];
    *s = (bokeh_sprite){.x = x, .y = y, .coc = c->coc, .node = iris_node(fabsf(c->coc))};
    for (int i = 0; i < w->colors; i++) s->color[i] = rgba[i] * part;
    s->one = bokeh_inside(x, y, w->width, w->height, w->job->iris->diameter[s->node], (float)w->job->pixel_aspect);
}

static void list_rows(work *w, int worker, int y0, int y1) {
    int next[BAND] = {0};
    (void)worker;
    candidates(w, y0, y1, w->raised, list_one, next);
}

static void take_rows(work *w, int worker, int y0, int y1) {
    (void)worker;
    for (int y = y0; y < y1 && w->rows; y++) {
        if (w->first[y] == w->first[y + 1]) continue;
        w->rows[y] = memcpy(at(w->picture, 0, y), pixel_at(w, 0, y), 4 * (size_t)w->width * sizeof(float));
    }
    for (int i = w->first[y0]; i < w->first[y1]; i++) {
        float *rgba = at(w->picture, w->sprite[i].x, w->sprite[i].y);
        for (int c = 0; c < w->colors; c++) rgba[c] -= w->sprite[i].one * w->sprite[i].color[c];
    }
}

/* Lists the sprites and takes their light. */
static ddof_status select_highlights(work *w) {
    int64_t count[BOKEH_BINS];
    double area[BOKEH_BINS];
    ddof_status status = rows(w, w->height, count_rows);
    for (int b = 0; b < BOKEH_BINS; b++) {
        count[b] = atomic_load(&w->count[b]);
        area[b] = (double)atomic_load(&w->area[b]) / AREA_UNIT;
    }
    w->raised = bokeh_raise(&w->limits, count, area, &w->job->sprites_dropped);
    w->job->sprites_large = atomic_load(&w->large);
    if (status == DDOF_OK) status = rows(w, w->height, count_kept_rows);
    if (status != DDOF_OK) return status;
    w->first[0] = 0;
    for (int y = 0; y < w->height; y++) w->first[y + 1] += w->first[y];
    w->job->sprites = w->first[w->height];
    status = rows(w, w->height, list_rows);
    return status == DDOF_OK ? rows(w, w->height, take_rows) : status;
}

/* ---- highlights */

static ddof_status blur_rest(work *w) {
    inner_job inner;
    inner_of(w, &inner);
    const ddof_status status = w->ctx->backend->diffuse(w->ctx, &inner.job, w->rest);
    w->job->nonfinite_pixels += inner.job.nonfinite_pixels;
    return status;
}

/* The rows of the picture whose sprites may reach rows y0 to y1 - 1 of a level. */
static void reached(const work *w, int level, int y0, int y1, int *from, int *to) {
    const int reach = scatter_reach(&w->scatter, level);
    const int64_t first = ((int64_t)y0 << level) - reach, last = ((int64_t)y1 << level) + reach;
    *from = first > 0 ? (int)first : 0;
    *to = last < w->height ? (int)last : w->height;
}

static void highlight_rows(work *w, int worker, int y0, int y1) {
    int from, to;
    reached(w, w->level, y0, y1, &from, &to);
    for (int y = from; y < to; y++)
        if (w->first[y + 1] > w->first[y])
            scatter_row(&w->scatter, worker, w->level, w->sprite + w->first[y], w->first[y + 1] - w->first[y], y0, y1);
}

/* Calls `do_rows` for the rows of each level. */
static ddof_status all_levels(work *w, void (*do_rows)(work *w, int worker, int y0, int y1)) {
    ddof_status status = DDOF_OK;
    for (w->level = w->scatter.first; w->level < w->scatter.levels && status == DDOF_OK; w->level++)
        if (w->scatter.level[w->level].begin) status = rows(w, w->scatter.level[w->level].height, do_rows);
    return status;
}

static void add_rows(work *w, int worker, int y0, int y1) {
    (void)worker;
    for (int y = y0; y < y1; y++) scatter_sum_row(&w->scatter, 1, false, y, at(w->result, 0, y), NULL);
}

static ddof_status draw_highlights(work *w) {
    for (int i = 0; i < w->first[w->height]; i++) w->drawn[bokeh_level(w->sprite[i].node, w->limits.half)]++;
    take_targets(w, w->rest);
    const ddof_status status = all_levels(w, highlight_rows);
    return status == DDOF_OK && w->scatter.levels > 1 ? rows(w, w->height, add_rows) : status;
}

/* ---- every pixel */

static void count_holes(work *w, int worker, int y0, int y1) {
    int64_t holes = 0;
    (void)worker;
    for (int y = y0; y < y1; y++)
        for (int x = 0; x < w->width; x++) holes += !finite_pixel(w, x, y);
    atomic_fetch_add(&w->holes, holes);
}

static void known_color(void *user, int x, int y, int count, float *value, float *weight) {
    const work *w = user;
    for (int i = 0; i < count; i++) {
        weight[i] = finite_pixel(w, x + i, y) ? 1 : 0;
        for (int c = 0; c < 4; c++) value[4 * (ptrdiff_t)i + c] = weight[i] > 0 ? pixel_at(w, x + i, y)[c] : 0;
    }
}

static void known_coc(void *user, int x, int y, int count, float *value, float *weight) {
    const work *w = user;
    for (int i = 0; i < count; i++) {
        value[i] = *coc_at(w, x + i, y);
        weight[i] = finite_value(value[i]) ? 1 : 0;
        if (!(weight[i] > 0)) value[i] = 0;
    }
}

/* Colour first, for a pixel whose CoC alone is unknown is a hole, too. */
static ddof_status fill_holes(work *w) {
    ddof_status status = rows(w, w->height, count_holes);
    w->job->nonfinite_pixels = w->holes;
    if (status != DDOF_OK || !w->holes) return status;
    fill_picture p = {.channels = 4, .width = w->width, .height = w->height, .load = known_color, .user = w};
    status = fill_unknown(w->ctx, &p, pixel_at(w, 0, 0), w->picture.stride, w->rest);
    p.channels = 1;
    p.load = known_coc;
    return status == DDOF_OK ? fill_unknown(w->ctx, &p, w->coc, (ptrdiff_t)sizeof(float) * w->width, w->rest) : status;
}

static int list_row(const work *w, int y, bokeh_sprite *list) {
    int count = 0;
    for (int x = 0; x < w->width; x++) {
        const float coc = *coc_at(w, x, y), *rgba = pixel_at(w, x, y), share = smooth(BOKEH_LEAST, BOKEH_WHOLE, fabsf(coc));
        if (!(share > 0)) continue;
        bokeh_sprite *s = &list[count++];
        *s = (bokeh_sprite){.x = x, .y = y, .coc = coc, .node = iris_node(fabsf(coc)), .one = share};
        for (int c = 0; c < 4; c++) s->color[c] = rgba[c] * share;
    }
    return count;
}

static void full_rows(work *w, int worker, int y0, int y1) {
    bokeh_sprite *list = w->listed + (size_t)worker * (size_t)w->width;
    int from, to;
    reached(w, w->level, y0, y1, &from, &to);
    for (int y = from; y < to && !w->ctx->cancelled; y++) {
        const int count = list_row(w, y, list);
        if (count) scatter_row(&w->scatter, worker, w->level, list, count, y0, y1);
    }
}

/* rgba towards the mean of sprites with these sums. */
static void mix(float *rgba, const float *sum, float weight, float share) {
    for (int c = 0; c < 4; c++) rgba[c] += share * (sum[c] / weight - rgba[c]);
}

static void compose_rows(work *w, int worker, int y0, int y1) {
    const ptrdiff_t wide = w->width;
    float *far = w->sums + 10 * wide * worker, *f = far + 4 * wide, *near = f + wide, *n = near + 4 * wide;
    int64_t drawn = 0;
    for (int y = y0; y < y1; y++) {
        memset(far, 0, 10 * (size_t)wide * sizeof(float));
        scatter_sum_row(&w->scatter, w->scatter.first, false, y, far, f);
        scatter_sum_row(&w->scatter, w->scatter.first, true, y, near, n);
        for (ptrdiff_t x = 0; x < wide; x++) {
            float *rgba = pixel_at(w, (int)x, y);
            const float coc = *coc_at(w, (int)x, y), own = smooth(BOKEH_LEAST, BOKEH_WHOLE, fabsf(coc));
            drawn += own > 0;
            if (coc > 0 && f[x] > BOKEH_EMPTY) mix(rgba, far + 4 * x, f[x], own);
            if (coc < 0 && n[x] > BOKEH_EMPTY) mix(rgba, near + 4 * x, n[x], own);
            if (n[x] > BOKEH_EMPTY) mix(rgba, near + 4 * x, n[x], n[x] < 1 ? n[x] : 1);
        }
    }
    atomic_fetch_add(&w->every, drawn);
}

static ddof_status draw_all(work *w) {
    take_targets(w, w->rest);
    ddof_status status = all_levels(w, full_rows);
    if (status == DDOF_OK) status = rows(w, w->height, compose_rows);
    w->job->sprites = w->every;
    return status;
}

/* ---- the frame */

static void store_rows(work *w, int worker, int y0, int y1) {
    (void)worker;
    for (int y = y0; y < y1; y++) span_store(&w->output, 0, y, w->width, at(w->result, 0, y), w->straight, w->k->pixels);
}

ddof_status bokeh_blur(ddof_context *ctx, frame_job *job, void *scratch) {
    work w;
    lay_out(&w, ctx, job, scratch);
    ddof_status status = rows(&w, w.height, load_rows);
    if (job->method == DDOF_METHOD_SCATTER) {
        if (status == DDOF_OK) status = fill_holes(&w);
        if (status == DDOF_OK) status = draw_all(&w);
    } else {
        if (status == DDOF_OK) status = select_highlights(&w);
        if (status == DDOF_OK) status = blur_rest(&w);
        if (status == DDOF_OK && job->sprites) status = draw_highlights(&w);
    }
    return status == DDOF_OK && !w.direct ? rows(&w, w.height, store_rows) : status;
}
