/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The method, top to bottom:
 *     lens        where the focus lies; depth and lens become one curve from value to CoC    lens.c
 *     coc         the curve applied, row by row, as the pixels are needed                    cpu/pixels.c
 *     layers      the picture taken apart by depth and, at the end, laid together                layers.c, fill.c
 *     conductance how well a link between two pixels conducts, from their CoC                cpu/conductance.h
 *     diffusion   one implicit step along all rows, then along all columns, `substeps` times cpu/rows.c, cpu/columns.c
 *                 or, of the disc kernel, along diagonals too, with complex numbers                disc.c, cpu/disc_engine.c
 *                 or, in its place, the classical methods                                          methods.c, cpu/methods.c
 *     bokeh       what is too bright for that, taken out before and drawn after, as the iris's picture   bokeh.c, iris.c
 */
#include <math.h>
#include <string.h>

#include "bokeh.h"
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
    job->method = settings->bokeh == DDOF_BOKEH_FULL ? DDOF_METHOD_SCATTER : settings->method;
    job->highlights = settings->bokeh == DDOF_BOKEH_HIGHLIGHTS;
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

void pipeline_inner(inner_job *i, const frame_job *job, const ddof_image *part, const ddof_image *coc, int x, int y) {
    i->job = *job;
    i->frame = *job->frame;
    i->frame.holdout = NULL;
    i->frame.depth = (ddof_image){0};
    i->frame.color = i->frame.output = *part;
    i->frame.coc = *coc;
    if (!i->frame.picture_width) {
        i->frame.picture_width = job->frame->color.width;
        i->frame.picture_height = job->frame->color.height;
    }
    i->frame.offset_x += x;
    i->frame.offset_y += y;
    i->settings = *job->settings;
    i->settings.layers = DDOF_LAYERS_OFF;
    i->job.frame = &i->frame;
    i->job.settings = &i->settings;
    i->job.coc_source = i->frame.coc;
    i->job.is_depth = false;
    i->job.nonfinite_pixels = i->job.sprites = i->job.sprites_dropped = i->job.sprites_large = 0;
}

static bool wants_sprites(const frame_job *job) {
    return job->highlights || job->method == DDOF_METHOD_SCATTER;
}

size_t pipeline_blur_bytes(const ddof_context *ctx, const frame_job *job) {
    return wants_sprites(job) && !ctx->backend->sprites ? bokeh_scratch_bytes(ctx, job) : ctx->backend->scratch_bytes(ctx, job);
}

ddof_status pipeline_blur(ddof_context *ctx, frame_job *job, void *scratch) {
    const backend *b = ctx->backend;
    if (wants_sprites(job)) return (b->sprites ? b->sprites : bokeh_blur)(ctx, job, scratch);
    if (job->method == DDOF_METHOD_GAUSSIAN) return b->gaussian(ctx, job, scratch);
    if (job->method == DDOF_METHOD_HEXAGON) return b->hexagon(ctx, job, scratch);
    return b->diffuse(ctx, job, scratch);
}

/* The image of an iris is read anew each time. */
ddof_status pipeline_iris(ddof_context *ctx, frame_job *job) {
    if (!wants_sprites(job)) return DDOF_OK;
    if (!ctx->iris) {
        ctx->iris = ctx->config.allocate(ctx->config.memory_user, sizeof *ctx->iris);
        if (!ctx->iris) return context_fail(ctx, DDOF_ERROR_MEMORY, "out of memory: %zu bytes for the iris", sizeof *ctx->iris);
        ctx->iris->made = false;
    }
    if (!iris_make(ctx->iris, &job->settings->iris, job->pixel_aspect, ctx->kernels->sprites))
        return context_fail(ctx, DDOF_ERROR_INVALID, "settings.iris.image lets no light through: all of it is 0, below, or not a number");
    job->iris = ctx->iris;
    return DDOF_OK;
}

/* Whether the backend does what the job asks for. */
static ddof_status check_method(ddof_context *ctx, const frame_job *job) {
    const backend *b = ctx->backend;
    if (job->disc && !b->disc)
        return context_fail(ctx, DDOF_ERROR_UNSUPPORTED, "settings.kernel: this backend has no disc kernel, take another one");
    if ((job->method == DDOF_METHOD_GAUSSIAN && !b->gaussian) || (job->method == DDOF_METHOD_HEXAGON && !b->hexagon))
        return context_fail(ctx, DDOF_ERROR_UNSUPPORTED, "settings.method: only the CPU and GL backends have this one");
    return DDOF_OK;
}

/* ---- the images of a frame, which share its CoC: 0 is frame.color, the others are frame.more */

typedef struct one_image {
    frame_job job;
    ddof_frame frame;
} one_image;

static void take_image(one_image *image, const frame_job *job, int i) {
    image->job = *job;
    image->job.frame = &image->frame;
    image->job.nonfinite_pixels = image->job.sprites = image->job.sprites_dropped = image->job.sprites_large = 0;
    image->frame = *job->frame;
    image->frame.more = NULL;
    image->frame.more_count = 0;
    if (i == 0) return;
    image->frame.color = job->frame->more[i - 1].color;
    image->frame.output = job->frame->more[i - 1].output;
}

static void add_counts(frame_job *job, const frame_job *image) {
    if (image->nonfinite_pixels > job->nonfinite_pixels) job->nonfinite_pixels = image->nonfinite_pixels;
    job->sprites += image->sprites;
    job->sprites_dropped += image->sprites_dropped;
    job->sprites_large += image->sprites_large;
}

size_t pipeline_iris_bytes(const frame_job *job) {
    return wants_sprites(job) ? sizeof(iris) : 0;
}

size_t pipeline_scratch_bytes(const ddof_context *ctx, const frame_job *job, bool coc_only) {
    size_t most = 0;
    if (coc_only) return ctx->backend->scratch_bytes(ctx, job);
    for (int i = 0; i <= job->frame->more_count; i++) {
        one_image image;
        take_image(&image, job, i);
        const size_t bytes = layers_wanted(&image.job) ? layers_scratch_bytes(ctx, &image.job) : pipeline_blur_bytes(ctx, &image.job);
        if (bytes > most) most = bytes;
    }
    return most;
}

/* The images one after the other. */
static ddof_status run_images(ddof_context *ctx, frame_job *job) {
    const int count = 1 + job->frame->more_count;
    ddof_status status = DDOF_OK;
    for (int i = 0; i < count && status == DDOF_OK; i++) {
        one_image image;
        take_image(&image, job, i);
        context_image(ctx, (double)i / count, 1.0 / count);
        status = layers_wanted(&image.job) ? layers_diffuse(ctx, &image.job, ctx->scratch)
                                           : pipeline_blur(ctx, &image.job, ctx->scratch);
        add_counts(job, &image.job);
    }
    return status;
}

ddof_status pipeline_run(ddof_context *ctx, frame_job *job, bool coc_only) {
    ddof_status status = coc_only ? DDOF_OK : check_method(ctx, job);
    if (coc_only) { /* nothing is blurred */
        job->disc = NULL;
        job->method = DDOF_METHOD_DIFFUSION;
        job->highlights = false;
    }
    if (status == DDOF_OK) status = pipeline_iris(ctx, job);
    if (status == DDOF_OK) status = reserve(ctx, pipeline_scratch_bytes(ctx, job, coc_only));
    if (status != DDOF_OK) return status;
    context_image(ctx, 0, 1);
    ctx->progress_shown = 0;
    ctx->cancelled = false;
    if (!context_progress(ctx, 0)) status = DDOF_ERROR_CANCELLED;
    if (status == DDOF_OK) status = coc_only ? ctx->backend->coc(ctx, job, ctx->scratch) : run_images(ctx, job);
    if (status == DDOF_ERROR_CANCELLED) return context_fail(ctx, status, "cancelled by the progress callback");
    if (status != DDOF_OK && ctx->error[0]) return status;
    if (status != DDOF_OK) return context_fail(ctx, status, "the parallel_for callback could not run its tasks");
    if (job->sprites_dropped > 0)
        context_log(ctx, DDOF_LOG_WARNING,
                    "%lld highlights were left to diffusion: sprites.max_sprites or max_area does not suffice for them",
                    (long long)job->sprites_dropped);
    if (job->nonfinite_pixels > 0)
        context_log(ctx, DDOF_LOG_WARNING, "%lld pixels were not finite and were filled by their neighbours",
                    (long long)job->nonfinite_pixels);
    return DDOF_OK;
}
