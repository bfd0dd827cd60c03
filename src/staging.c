/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "staging.h"

#include <math.h>

#include "image.h"

static size_t line(size_t bytes) {
    return (bytes + 63) / 64 * 64;
}

size_t staging_bytes(const ddof_context *ctx, const frame_job *job) {
    const size_t n = (size_t)job->coc_source.width * STAGING_ROWS;
    (void)ctx;
    return line(n * 16) + line(n * 4) + line(n * 8);
}

staging staging_lay_out(frame_job *job, void *scratch) {
    const size_t n = (size_t)job->coc_source.width * STAGING_ROWS;
    char *p = scratch;
    image_resolve(&job->coc_source);
    return (staging){(float *)(void *)p, (float *)(void *)(p + line(n * 16)),
                     (uint16_t *)(void *)(p + line(n * 16) + line(n * 4)), 1};
}

/* Rows y .. y + rows - 1 as they are, but premultiplied. */
static void load_rows(const ddof_context *ctx, const frame_job *job, const staging *s, int y, int rows) {
    ddof_image in = job->frame->color;
    const int width = in.width;
    image_resolve(&in);
    for (int r = 0; r < rows; r++) {
        span_load(&in, 0, y + r, width, s->pixels + (ptrdiff_t)r * width * 4, in.alpha == DDOF_ALPHA_STRAIGHT,
                  ctx->kernels->pixels);
        plane_load(&job->coc_source, 0, 0, y + r, width, s->map + (ptrdiff_t)r * width, ctx->kernels->pixels);
    }
}

/* Half floats reach from 6e-8 to 65504: a picture that is brighter, or very dark, is scaled by a power of two. */
void staging_find_gain(const ddof_context *ctx, const frame_job *job, staging *s) {
    const int width = job->frame->color.width, height = job->frame->color.height;
    float most = 0;
    for (int y = 0; y < height; y++) {
        load_rows(ctx, job, s, y, 1);
        for (ptrdiff_t i = 0; i < (ptrdiff_t)width * 4; i++) {
            const float v = fabsf(s->pixels[i]);
            if (v > most && finite_value(v)) most = v;
        }
    }
    s->gain = 1;
    if (most == 0 || (most <= 32768 && most >= 1.0f / 64)) return;
    int exponent;
    frexpf(most, &exponent);
    s->gain = ldexpf(1, most > 32768 ? 15 - exponent : exponent < -120 ? 120 : -exponent);
}

/* Whether a value of depth or CoC leaves its pixel without a CoC. */
static bool unknown(const frame_job *job, float v) {
    if (!job->is_depth) return !finite_value(v);
    return isnan(v) || (job->curve.kind == DDOF_DEPTH_INVERSE && v == INFINITY);
}

static int64_t mark_holes(const frame_job *job, const staging *s, ptrdiff_t count) {
    int64_t holes = 0;
    for (ptrdiff_t i = 0; i < count; i++) {
        float *p = s->pixels + 4 * i;
        const bool colored = finite_value(p[0]) && finite_value(p[1]) && finite_value(p[2]) && finite_value(p[3]);
        for (int c = 0; c < 4; c++)
            p[c] = colored ? p[c] * s->gain : INFINITY;
        holes += !colored || unknown(job, s->map[i]);
    }
    return holes;
}

void staging_load(const ddof_context *ctx, frame_job *job, const staging *s, int y, int rows, bool half) {
    const int width = job->frame->color.width;
    load_rows(ctx, job, s, y, rows);
    job->nonfinite_pixels += mark_holes(job, s, (ptrdiff_t)rows * width);
    if (half) ctx->kernels->pixels->float_to_half(s->pixels, s->half, rows * width * 4);
}

void staging_store(const ddof_context *ctx, const frame_job *job, const staging *s, int y, int rows) {
    const bool straight = job->frame->color.alpha == DDOF_ALPHA_STRAIGHT;
    ddof_image output = job->frame->output;
    const int width = output.width;
    image_resolve(&output);
    for (ptrdiff_t i = 0; s->gain != 1 && i < (ptrdiff_t)rows * width * 4; i++)
        s->pixels[i] /= s->gain;
    for (int r = 0; r < rows; r++)
        span_store(&output, 0, y + r, width, s->pixels + (ptrdiff_t)r * width * 4, straight, ctx->kernels->pixels);
}

ddof_status staging_coc(ddof_context *ctx, frame_job *job, void *scratch) {
    const staging s = staging_lay_out(job, scratch);
    const ddof_frame *frame = job->frame;
    const int width = job->coc_source.width, height = job->coc_source.height;
    const pixel_kernels *k = ctx->kernels->pixels;
    ddof_image output = frame->output;
    image_resolve(&output);
    ctx->progress_total = height;
    for (int y = 0; y < height; y++) {
        plane_load(&job->coc_source, 0, 0, y, width, s.map, k);
        if (job->is_depth) k->lens(&job->curve, s.map, s.pixels, width, frame->offset_x, y + frame->offset_y);
        const float *coc = job->is_depth ? s.pixels : s.map;
        for (int x = 0; x < width; x++)
            job->nonfinite_pixels += !finite_value(coc[x]);
        plane_store(&output, 0, 0, y, width, coc, k);
        if (!context_progress(ctx, 1)) return DDOF_ERROR_CANCELLED;
    }
    return DDOF_OK;
}
