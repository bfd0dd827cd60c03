/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The reference backend: every stage in float64, one line at a time, nothing clever. What every other path is checked
 * against; slow and large (40 bytes a pixel). The rules are those of ddof_render() in ddof.h. */
#include <math.h>
#include <string.h>

#include "context.h"
#include "image.h"
#include "coc_limits.h"

typedef struct planes {
    int width, height, channels;
    double *color; /* channels planes */
    double *coc;   /* NaN: a hole without CoC */
    double *g;     /* heat capacity: 1, or 0 for a hole */
    double *beta, *w, *u; /* one line */
} planes;

static size_t round_line(size_t bytes) {
    return (bytes + 63) / 64 * 64;
}

static size_t lay_out(planes *p, const frame_job *job, char *base) {
    size_t n, line, at = 0;
    p->width = job->coc_source.width;
    p->height = job->coc_source.height;
    p->channels = job->frame->output.channels;
    n = (size_t)p->width * (size_t)p->height;
    line = (size_t)(p->width > p->height ? p->width : p->height);
    struct {
        double **plane;
        size_t count;
    } part[] = {{&p->color, n * (size_t)p->channels}, {&p->coc, n}, {&p->g, n}, {&p->beta, line}, {&p->w, line}, {&p->u, line}};
    for (size_t i = 0; i < sizeof part / sizeof *part; i++) {
        *part[i].plane = base ? (double *)(void *)(base + at) : NULL;
        at += round_line(part[i].count * sizeof(double));
    }
    return at;
}

static size_t reference_scratch_bytes(const ddof_context *ctx, const frame_job *job) {
    planes p;
    (void)ctx;
    return lay_out(&p, job, NULL);
}

static double coc_value(const frame_job *job, int x, int y) {
    double v = image_value(&job->coc_source, 0, x, y);
    if (!job->is_depth) return v;
    const ddof_frame *f = job->frame;
    return lens_coc(&job->curve, lens_inverse_depth(&job->curve, v, x + f->offset_x, y + f->offset_y));
}

static void load(planes *p, frame_job *job) {
    const ddof_image *in = &job->frame->color;
    const size_t n = (size_t)p->width * (size_t)p->height;
    for (int y = 0; y < p->height; y++)
        for (int x = 0; x < p->width; x++) {
            size_t i = (size_t)y * (size_t)p->width + (size_t)x;
            p->coc[i] = coc_value(job, x, y);
            bool good = isfinite(p->coc[i]);
            double alpha = in->alpha == DDOF_ALPHA_STRAIGHT ? image_value(in, in->channels - 1, x, y) : 1;
            for (int c = 0; c < p->channels; c++) {
                double v = image_value(in, c, x, y);
                if (in->alpha == DDOF_ALPHA_STRAIGHT && c < p->channels - 1) v *= alpha;
                p->color[n * (size_t)c + i] = v;
                good = good && isfinite(v);
            }
            for (int c = 0; c < p->channels && !good; c++) p->color[n * (size_t)c + i] = 0;
            p->g[i] = good;
            job->nonfinite_pixels += !good;
        }
}

static double link(double a, double b, double scale) {
    a = isfinite(a) ? fmin(fabs(a), COC_LIMIT) : COC_LIMIT;
    b = isfinite(b) ? fmin(fabs(b), COC_LIMIT) : COC_LIMIT;
    double d = fmin(a, b);
    return fmax(scale * d * d, BETA_FLOOR);
}

/* Solves one line of `count` pixels, `stride` apart, for every channel; the elimination of docs/method.md, section 3. */
static void solve_line(planes *p, size_t first, size_t stride, int count, double scale, const double *g) {
    const size_t n = (size_t)p->width * (size_t)p->height;
    for (int i = 0; i < count; i++) {
        size_t at = first + stride * (size_t)i;
        p->beta[i] = i + 1 < count ? link(p->coc[at], p->coc[at + stride], scale) : 0;
        p->w[i] = g[at];
        if (i > 0 && p->beta[i - 1] > 0) p->w[i] += p->beta[i - 1] * p->w[i - 1] / (p->w[i - 1] + p->beta[i - 1]);
    }
    for (int c = 0; c < p->channels; c++) {
        double *x = p->color + n * (size_t)c + first;
        for (int i = 0; i < count; i++) {
            double den = p->w[i] + p->beta[i], in = g[first + stride * (size_t)i] * x[stride * (size_t)i];
            if (i > 0) in += p->beta[i - 1] * p->u[i - 1];
            p->u[i] = den > 0 ? in / den : 0; /* den is 0 only at the end of a line of holes */
        }
        for (int i = count - 1; i >= 0; i--) {
            double y = p->u[i];
            if (i + 1 < count) y += p->beta[i] / (p->w[i] + p->beta[i]) * x[stride * (size_t)(i + 1)];
            x[stride * (size_t)i] = y;
        }
    }
}

/* After the rows, a hole is filled, unless all of its row was holes. */
static void mark_filled(planes *p) {
    for (int y = 0; y < p->height; y++) {
        double *g = p->g + (size_t)y * (size_t)p->width, any = 0;
        for (int x = 0; x < p->width; x++) any = fmax(any, g[x]);
        for (int x = 0; x < p->width; x++) g[x] = any;
    }
}

static void store(const planes *p, const frame_job *job) {
    const size_t n = (size_t)p->width * (size_t)p->height;
    const bool straight = job->frame->color.alpha == DDOF_ALPHA_STRAIGHT;
    for (int y = 0; y < p->height; y++)
        for (int x = 0; x < p->width; x++)
            for (int c = 0; c < p->channels; c++) {
                size_t i = (size_t)y * (size_t)p->width + (size_t)x;
                double v = p->color[n * (size_t)c + i], alpha = p->color[n * (size_t)(p->channels - 1) + i];
                if (straight && c < p->channels - 1) v = alpha != 0 ? v / alpha : 0;
                image_set_value(&job->frame->output, c, x, y, v);
            }
}

static ddof_status reference_diffuse(ddof_context *ctx, frame_job *job, void *scratch) {
    planes p;
    lay_out(&p, job, scratch);
    ctx->progress_total = (double)job->substeps * (p.width + p.height);
    load(&p, job);
    for (int step = 0; step < job->substeps; step++) {
        for (int y = 0; y < p.height; y++) {
            solve_line(&p, (size_t)y * (size_t)p.width, 1, p.width, job->row_scale, p.g);
            if (!context_progress(ctx, 1)) return DDOF_ERROR_CANCELLED;
        }
        mark_filled(&p);
        for (int x = 0; x < p.width; x++) {
            solve_line(&p, (size_t)x, (size_t)p.width, p.height, job->column_scale, p.g);
            if (!context_progress(ctx, 1)) return DDOF_ERROR_CANCELLED;
        }
        for (size_t i = 0; i < (size_t)p.width * (size_t)p.height; i++) p.g[i] = 1;
    }
    store(&p, job);
    return DDOF_OK;
}

static ddof_status reference_coc(ddof_context *ctx, frame_job *job, void *scratch) {
    (void)scratch;
    ctx->progress_total = job->coc_source.height;
    for (int y = 0; y < job->coc_source.height; y++) {
        for (int x = 0; x < job->coc_source.width; x++) {
            double d = coc_value(job, x, y);
            job->nonfinite_pixels += !isfinite(d);
            image_set_value(&job->frame->output, 0, x, y, d);
        }
        if (!context_progress(ctx, 1)) return DDOF_ERROR_CANCELLED;
    }
    return DDOF_OK;
}

static const char *device(const ddof_context *ctx) {
    (void)ctx;
    return "float64";
}

const backend backend_reference = {.id = DDOF_BACKEND_REFERENCE, .scratch_bytes = reference_scratch_bytes,
                                   .coc = reference_coc, .diffuse = reference_diffuse, .device = device};
