/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The method, top to bottom:
 *     lens        where the focus lies; depth and lens become one curve from value to CoC    lens.c
 *     coc         the curve applied, row by row, as the pixels are needed                    cpu/pixels.c
 *     layers      the picture taken apart by depth and, at the end, laid together                layers.c, fill.c
 *     conductance how well a link between two pixels conducts, from their CoC                cpu/conductance.h
 *     diffusion   one implicit step along all rows, then along all columns, `substeps` times cpu/rows.c, cpu/columns.c
 *                 or, of the disc kernel, along diagonals too, with complex numbers                disc.c, cpu/disc_engine.c
 */
#include <math.h>
#include <string.h>

#include "context.h"
#include "image.h"
#include "layers.h"

static ddof_status focus(ddof_context *ctx, frame_job *job, const ddof_lens *lens, bool read, double *distance) {
    *distance = lens->focus_distance;
    if (lens->focus == DDOF_FOCUS_DISTANCE || !read) return DDOF_OK;

    const ddof_frame *frame = job->frame;
    const int x = lens->focus_x, y = lens->focus_y;
    if (x < 0 || y < 0 || x >= frame->depth.width || y >= frame->depth.height)
        return context_fail(ctx, DDOF_ERROR_INVALID, "lens.focus_x, focus_y = %d, %d lie outside the %d x %d depth image", x,
                            y, frame->depth.width, frame->depth.height);
    double value = image_value(&frame->depth, 0, x, y);
    double q = lens_inverse_depth(&job->curve, value, x + frame->offset_x, y + frame->offset_y);
    if (isnan(q))
        return context_fail(ctx, DDOF_ERROR_INVALID, "there is no depth at the pixel %d, %d to focus on (%g)", x, y, value);
    *distance = q > 0 ? 1 / q : INFINITY;
    const char *wrong = lens_check_focus(lens, *distance);
    if (wrong)
        return context_fail(ctx, DDOF_ERROR_INVALID, "focusing on the pixel %d, %d at distance %g: %s", x, y, *distance,
                            wrong);
    return DDOF_OK;
}

ddof_status pipeline_prepare(ddof_context *ctx, frame_job *job, const ddof_frame *frame, const ddof_settings *settings,
                             bool read, double *focus_distance) {
    const double aspect = frame->pixel_aspect > 0 ? frame->pixel_aspect : 1;
    memset(job, 0, sizeof *job);
    job->frame = frame;
    job->settings = settings;
    job->is_depth = frame->depth.channels > 0;
    job->coc_source = job->is_depth ? frame->depth : frame->coc;
    job->substeps = settings->substeps > 0 ? settings->substeps : 1;
    job->row_scale = (settings->conductance == DDOF_CONDUCTANCE_CLASSIC ? 1.0 : 1.0 / 32) / job->substeps;
    job->column_scale = job->row_scale * aspect * aspect; /* d pixel widths span d * aspect rows */
    job->pixel_aspect = aspect;
    job->disc = settings->kernel == DDOF_KERNEL_DISC ? disc_kernel_pick(settings->quality) : NULL;
    *focus_distance = 0;
    if (!job->is_depth) return DDOF_OK;
    lens_curve_depth(&job->curve, frame, settings);
    ddof_status status = focus(ctx, job, &settings->lens, read, focus_distance);
    if (status == DDOF_OK && read) lens_curve_focus(&job->curve, frame, &settings->lens, *focus_distance);
    return status;
}

/* Scratch memory grows to the largest frame seen and stays. */
static ddof_status reserve(ddof_context *ctx, size_t bytes) {
    if (bytes <= ctx->scratch_bytes) return DDOF_OK;
    if (ctx->scratch) ctx->config.release(ctx->config.memory_user, ctx->scratch);
    ctx->scratch_bytes = 0;
    ctx->scratch = ctx->config.allocate(ctx->config.memory_user, bytes);
    if (!ctx->scratch)
        return context_fail(ctx, DDOF_ERROR_MEMORY, "out of memory: %zu bytes of scratch were refused", bytes);
    ctx->scratch_bytes = bytes;
    return DDOF_OK;
}

size_t pipeline_scratch_bytes(const ddof_context *ctx, const frame_job *job, bool coc_only) {
    return !coc_only && layers_wanted(job) ? layers_scratch_bytes(ctx, job) : ctx->backend->scratch_bytes(ctx, job);
}

ddof_status pipeline_run(ddof_context *ctx, frame_job *job, bool coc_only) {
    if (job->disc && !coc_only && !ctx->backend->disc)
        return context_fail(ctx, DDOF_ERROR_UNSUPPORTED, "settings.kernel: this backend has no disc kernel, take another one");
    if (coc_only) job->disc = NULL; /* nothing is diffused */
    ddof_status status = reserve(ctx, pipeline_scratch_bytes(ctx, job, coc_only));
    if (status != DDOF_OK) return status;
    context_stage(ctx, 0, 1);
    ctx->progress_shown = 0;
    ctx->cancelled = false;
    if (!context_progress(ctx, 0)) status = DDOF_ERROR_CANCELLED;
    if (status == DDOF_OK)
        status = coc_only             ? ctx->backend->coc(ctx, job, ctx->scratch)
                 : layers_wanted(job) ? layers_diffuse(ctx, job, ctx->scratch)
                                      : ctx->backend->diffuse(ctx, job, ctx->scratch);
    if (status == DDOF_ERROR_CANCELLED) return context_fail(ctx, status, "cancelled by the progress callback");
    if (status != DDOF_OK && ctx->error[0]) return status;
    if (status != DDOF_OK) return context_fail(ctx, status, "the parallel_for callback could not run its tasks");
    if (job->nonfinite_pixels > 0)
        context_log(ctx, DDOF_LOG_WARNING, "%lld pixels were not finite and were filled by their neighbours",
                    (long long)job->nonfinite_pixels);
    return DDOF_OK;
}
