/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The reference backend: every stage in float64, one line at a time, nothing clever. What every other path is checked
 * against; slow and large (48 bytes a pixel of RGBA, 152 with the disc kernel). The rules are those of ddof_render() in
 * ddof.h, the disc kernel that of disc.h. */
#include <complex.h>
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
    /* the disc kernel's: */
    double complex *a;   /* one component, channels planes */
    double *sum;         /* of the components, channels planes */
    double *good;        /* g before any component */
    double complex *b, *r, *v; /* one line */
} planes;

static size_t round_line(size_t bytes) {
    return (bytes + 63) / 64 * 64;
}

static size_t lay_out(planes *p, const frame_job *job, char *base) {
    size_t n, line, at = 0, disc = job->disc != NULL;
    p->width = job->coc_source.width;
    p->height = job->coc_source.height;
    p->channels = job->frame->output.channels;
    n = (size_t)p->width * (size_t)p->height;
    line = (size_t)(p->width > p->height ? p->width : p->height);
    struct {
        double **plane;
        size_t count;
    } real[] = {{&p->color, n * (size_t)p->channels}, {&p->coc, n}, {&p->g, n}, {&p->beta, line}, {&p->w, line}, {&p->u, line},
                {&p->sum, disc * n * (size_t)p->channels}, {&p->good, disc * n}};
    struct {
        double complex **plane;
        size_t count;
    } imaginary[] = {{&p->a, disc * n * (size_t)p->channels}, {&p->b, disc * line}, {&p->r, disc * line}, {&p->v, disc * line}};
    for (size_t i = 0; i < sizeof real / sizeof *real; i++) {
        *real[i].plane = base ? (double *)(void *)(base + at) : NULL;
        at += round_line(real[i].count * sizeof(double));
    }
    for (size_t i = 0; i < sizeof imaginary / sizeof *imaginary; i++) {
        *imaginary[i].plane = base ? (double complex *)(void *)(base + at) : NULL;
        at += round_line(imaginary[i].count * sizeof(double complex));
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

/* The CoC of a link: that of its sharper pixel. */
static double link(double a, double b) {
    a = isfinite(a) ? fmin(fabs(a), COC_LIMIT) : COC_LIMIT;
    b = isfinite(b) ? fmin(fabs(b), COC_LIMIT) : COC_LIMIT;
    return fmin(a, b);
}

/* ---- the heat kernel */

static double heat_conductance(double d, double scale) {
    return fmax(scale * d * d, BETA_FLOOR);
}

/* Solves one line of `count` pixels, `stride` apart, for every channel; the elimination of docs/method.md, section 3. */
static void solve_line(planes *p, size_t first, size_t stride, int count, double scale, const double *g) {
    const size_t n = (size_t)p->width * (size_t)p->height;
    for (int i = 0; i < count; i++) {
        size_t at = first + stride * (size_t)i;
        p->beta[i] = i + 1 < count ? heat_conductance(link(p->coc[at], p->coc[at + stride]), scale) : 0;
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

static ddof_status diffuse_heat(ddof_context *ctx, planes *p, const frame_job *job) {
    ctx->progress_total = (double)job->substeps * (p->width + p->height);
    for (int step = 0; step < job->substeps; step++) {
        for (int y = 0; y < p->height; y++) {
            solve_line(p, (size_t)y * (size_t)p->width, 1, p->width, job->row_scale, p->g);
            if (!context_progress(ctx, 1)) return DDOF_ERROR_CANCELLED;
        }
        mark_filled(p);
        for (int x = 0; x < p->width; x++) {
            solve_line(p, (size_t)x, (size_t)p->width, p->height, job->column_scale, p->g);
            if (!context_progress(ctx, 1)) return DDOF_ERROR_CANCELLED;
        }
        for (size_t i = 0; i < (size_t)p->width * (size_t)p->height; i++) p->g[i] = 1;
    }
    return DDOF_OK;
}

/* ---- the disc kernel */

typedef struct disc_line {
    size_t first, stride;
    int count;
} disc_line;

static int disc_lines(const planes *p, int direction) {
    if (direction >= DISC_DIAGONAL) return p->width + p->height - 1;
    return direction == DISC_ROWS ? p->height : p->width;
}

/* Line `k` of a direction. Diagonals start along the top, then down the side they run away from. */
static disc_line disc_line_at(const planes *p, int direction, int k) {
    const size_t width = (size_t)p->width;
    if (direction == DISC_ROWS) return (disc_line){(size_t)k * width, 1, p->width};
    if (direction == DISC_COLUMNS) return (disc_line){(size_t)k, width, p->height};
    const int down = k < p->width ? 0 : k - p->width + 1, rows = p->height - down;
    if (direction == DISC_DIAGONAL) {
        const int x = down ? 0 : k, columns = p->width - x;
        return (disc_line){(size_t)down * width + (size_t)x, width + 1, columns < rows ? columns : rows};
    }
    const int x = down ? p->width - 1 : k, columns = x + 1;
    return (disc_line){(size_t)down * width + (size_t)x, width - 1, columns < rows ? columns : rows};
}

static double complex disc_conductance(double d, const disc_component *c, const disc_kernel *k, disc_share share) {
    const double u = d * d, v = fmax(u, 1);
    const double part = u / (v + disc_excess(k)) * (share.level - share.slope * v / (v + k->fade));
    return part * (c->beta_re * v + c->offset_re) + BETA_FLOOR + part * (c->beta_im * v + c->offset_im) * I;
}

/* As solve_line(), with complex conductance. */
static void solve_disc_line(planes *p, disc_line l, const disc_component *component, const disc_kernel *kernel,
                            disc_share share) {
    const size_t n = (size_t)p->width * (size_t)p->height;
    double complex w = 0;
    for (int i = 0; i < l.count; i++) {
        const size_t at = l.first + l.stride * (size_t)i;
        w = p->g[at] + (i > 0 ? p->b[i - 1] * w * p->r[i - 1] : 0);
        p->b[i] = i + 1 < l.count ? disc_conductance(link(p->coc[at], p->coc[at + l.stride]), component, kernel, share) : 0;
        p->r[i] = w + p->b[i] != 0 ? 1 / (w + p->b[i]) : 0; /* 0 only at the end of a line of holes */
    }
    for (int c = 0; c < p->channels; c++) {
        double complex *a = p->a + n * (size_t)c + l.first;
        for (int i = 0; i < l.count; i++) {
            const size_t at = l.stride * (size_t)i;
            p->v[i] = (p->g[l.first + at] * a[at] + (i > 0 ? p->b[i - 1] * p->v[i - 1] : 0)) * p->r[i];
        }
        for (int i = l.count - 1; i >= 0; i--) {
            const size_t at = l.stride * (size_t)i;
            a[at] = p->v[i] + (i + 1 < l.count ? p->b[i] * p->r[i] * a[at + l.stride] : 0);
        }
    }
}

static ddof_status diffuse_component(ddof_context *ctx, planes *p, const frame_job *job, const disc_component *component) {
    const size_t n = (size_t)p->width * (size_t)p->height, values = n * (size_t)p->channels;
    for (size_t i = 0; i < values; i++) p->a[i] = p->color[i];
    for (int step = 0; step < job->disc->substeps; step++)
        for (int direction = 0; direction < job->disc->directions; direction++) {
            const disc_share share = disc_direction(job->disc, direction, job->pixel_aspect);
            for (int k = 0; k < disc_lines(p, direction); k++) {
                solve_disc_line(p, disc_line_at(p, direction, k), component, job->disc, share);
                if (!context_progress(ctx, 1)) return DDOF_ERROR_CANCELLED;
            }
            if (direction == DISC_ROWS) mark_filled(p);
            for (size_t i = 0; i < n && direction == DISC_COLUMNS; i++) p->g[i] = 1;
        }
    for (size_t i = 0; i < values; i++)
        p->sum[i] += component->weight_re * creal(p->a[i]) - component->weight_im * cimag(p->a[i]);
    return DDOF_OK;
}

static ddof_status diffuse_disc(ddof_context *ctx, planes *p, const frame_job *job) {
    const size_t n = (size_t)p->width * (size_t)p->height, values = n * (size_t)p->channels;
    double lines = 0;
    for (int direction = 0; direction < job->disc->directions; direction++) lines += disc_lines(p, direction);
    ctx->progress_total = lines * job->disc->substeps * job->disc->components;
    memset(p->sum, 0, values * sizeof *p->sum);
    memcpy(p->good, p->g, n * sizeof *p->g);
    for (int j = 0; j < job->disc->components; j++) {
        memcpy(p->g, p->good, n * sizeof *p->g);
        ddof_status status = diffuse_component(ctx, p, job, &job->disc->component[j]);
        if (status != DDOF_OK) return status;
    }
    memcpy(p->color, p->sum, values * sizeof *p->sum);
    return DDOF_OK;
}

static ddof_status reference_diffuse(ddof_context *ctx, frame_job *job, void *scratch) {
    planes p;
    lay_out(&p, job, scratch);
    load(&p, job);
    ddof_status status = job->disc ? diffuse_disc(ctx, &p, job) : diffuse_heat(ctx, &p, job);
    if (status == DDOF_OK) store(&p, job);
    return status;
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

const backend backend_reference = {.id = DDOF_BACKEND_REFERENCE, .disc = true, .scratch_bytes = reference_scratch_bytes,
                                   .coc = reference_coc, .diffuse = reference_diffuse, .device = device};
