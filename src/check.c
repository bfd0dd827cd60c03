/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Validation, once, above the backends: what passes here they can work on. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "bokeh.h"
#include "context.h"
#include "image.h"

enum { MAX_SIDE = 1 << 20, MAX_SUBSTEPS = 64, MAX_THREADS = 256, MAX_MORE = 255 };

bool context_all_zero(const uint64_t *reserved, size_t count) {
    for (size_t i = 0; i < count; i++)
        if (reserved[i]) return false;
    return true;
}

ddof_status check_config(const ddof_config *c, const char **wrong) {
    *wrong = NULL;
    if (c->backend < DDOF_BACKEND_AUTO || c->backend > DDOF_BACKEND_VULKAN)
        *wrong = "config.backend is none of ddof_backend";
    else if (c->threads < 0 || c->threads > MAX_THREADS)
        *wrong = "config.threads must be 0 (all) or 1 to 256";
    else if (!c->allocate != !c->release)
        *wrong = "config.allocate and config.release must both be given, or neither";
    else if (c->parallel_for && c->threads < 1)
        *wrong = "config.threads must be given with config.parallel_for: it bounds the worker number";
    else if (c->device < 0)
        *wrong = "config.device is negative: it is an index in the list of ddof_devices()";
    else if (c->device && c->backend != DDOF_BACKEND_VULKAN)
        *wrong = "config.device must be 0, but for DDOF_BACKEND_VULKAN";
    else if (c->reserved_int || !RESERVED_ZERO(c))
        *wrong = "config.reserved_int and config.reserved must be 0";
    return *wrong ? DDOF_ERROR_INVALID : DDOF_OK;
}

/* The bytes a plane spans, as addresses [first, last). Strides resolved, and within 2^40: no product overflows. */
static void plane_extent(const ddof_image *image, int channel, uint64_t *first, uint64_t *last) {
    const ddof_plane *p = &image->plane[channel];
    int64_t x = (int64_t)p->pixel_stride * (image->width - 1), y = (int64_t)p->row_stride * (image->height - 1);
    uint64_t base = (uintptr_t)p->data;
    *first = base + (uint64_t)((x < 0 ? x : 0) + (y < 0 ? y : 0));
    *last = base + (uint64_t)((x > 0 ? x : 0) + (y > 0 ? y : 0)) + (p->type == DDOF_HALF ? 2 : 4);
}

static ddof_status check_plane(ddof_context *ctx, const ddof_image *image, int c, const char *name) {
    const ddof_plane *p = &image->plane[c];
    if (p->type != DDOF_FLOAT && p->type != DDOF_HALF)
        return context_fail(ctx, DDOF_ERROR_INVALID, "frame.%s.plane[%d].type is none of ddof_type", name, c);
    const ptrdiff_t size = p->type == DDOF_HALF ? 2 : 4;
    if (!p->data) return context_fail(ctx, DDOF_ERROR_INVALID, "frame.%s.plane[%d].data is NULL", name, c);
    if ((uintptr_t)p->data % (uintptr_t)size || p->pixel_stride % size || p->row_stride % size)
        return context_fail(ctx, DDOF_ERROR_INVALID, "frame.%s.plane[%d]: data and strides must be multiples of %d bytes",
                            name, c, (int)size);
    const int64_t most = INT64_C(1) << 40, pixel = p->pixel_stride, row = p->row_stride;
    if (pixel > most || pixel < -most || row > most || row < -most)
        return context_fail(ctx, DDOF_ERROR_INVALID, "frame.%s.plane[%d]: a stride is beyond 2^40 bytes", name, c);
    const int64_t reach = (pixel < 0 ? -pixel : pixel) * image->width;
    if (row == 0 && (reach > most || reach > PTRDIFF_MAX))
        return context_fail(ctx, DDOF_ERROR_INVALID, "frame.%s.plane[%d]: a row is longer than 2^40 bytes", name, c);
    return DDOF_OK;
}

static ddof_status check_image(ddof_context *ctx, const ddof_image *image, int channels, const char *name) {
    if (image->channels < 1 || image->channels > 4)
        return context_fail(ctx, DDOF_ERROR_INVALID, "frame.%s has %d channels: give 1 to 4", name, image->channels);
    if (channels && image->channels != channels)
        return context_fail(ctx, DDOF_ERROR_INVALID, "frame.%s has %d channels, it must have %d", name, image->channels,
                            channels);
    if (image->width < 1 || image->height < 1 || image->width > MAX_SIDE || image->height > MAX_SIDE)
        return context_fail(ctx, DDOF_ERROR_INVALID, "frame.%s is %d x %d pixels: each side must be 1 to %d", name,
                            image->width, image->height, MAX_SIDE);
    for (int c = 0; c < image->channels; c++) {
        ddof_status status = check_plane(ctx, image, c, name);
        if (status != DDOF_OK) return status;
    }
    return DDOF_OK;
}

static ddof_status check_size(ddof_context *ctx, const ddof_image *image, const ddof_image *other, const char *name,
                              const char *other_name) {
    if (image->width == other->width && image->height == other->height) return DDOF_OK;
    return context_fail(ctx, DDOF_ERROR_INVALID, "frame.%s is %d x %d but frame.%s is %d x %d: sizes must agree", name,
                        image->width, image->height, other_name, other->width, other->height);
}

static bool overlap(const ddof_image *a, int ca, const ddof_image *b, int cb) {
    uint64_t a0, a1, b0, b1;
    plane_extent(a, ca, &a0, &a1);
    plane_extent(b, cb, &b0, &b1);
    return a0 < b1 && b0 < a1;
}

static bool same_planes(const ddof_image *a, const ddof_image *b) {
    for (int c = 0; c < a->channels; c++) {
        const ddof_plane *p = &a->plane[c], *q = &b->plane[c];
        if (p->data != q->data || p->type != q->type) return false;
        if (a->width > 1 && p->pixel_stride != q->pixel_stride) return false;
        if (a->height > 1 && p->row_stride != q->row_stride) return false;
    }
    return a->channels == b->channels;
}

/* Whether an output lies apart from an image, or, where `same` is allowed, is its very planes. */
static ddof_status check_apart(ddof_context *ctx, const ddof_image *output, const char *name, const ddof_image *image,
                               const char *other_name, bool same) {
    ddof_image out = *output, in = *image;
    image_resolve(&out);
    image_resolve(&in);
    if (same && same_planes(&out, &in)) return DDOF_OK;
    for (int i = 0; i < out.channels; i++)
        for (int j = 0; j < in.channels; j++)
            if (overlap(&out, i, &in, j))
                return context_fail(ctx, DDOF_ERROR_INVALID, "frame.%s overlaps frame.%s in memory%s", name, other_name,
                                    same ? " without being the same planes" : "");
    return DDOF_OK;
}

ddof_status check_geometry(ddof_context *ctx, const ddof_frame *f) {
    if (f->next || f->reserved_int || !RESERVED_ZERO(f))
        return context_fail(ctx, DDOF_ERROR_INVALID, "frame.next must be NULL and frame.reserved 0");
    if (f->picture_width < 0 || f->picture_height < 0 || !f->picture_width != !f->picture_height)
        return context_fail(ctx, DDOF_ERROR_INVALID, "frame.picture_width and picture_height must both be above 0, or 0");
    if (!f->picture_width && (f->offset_x || f->offset_y))
        return context_fail(ctx, DDOF_ERROR_INVALID, "frame.offset_x, offset_y need frame.picture_width, picture_height");
    const int most = MAX_SIDE * 16;
    if (f->offset_x > most || f->offset_y > most || f->offset_x < -most || f->offset_y < -most || f->picture_width > most ||
        f->picture_height > most)
        return context_fail(ctx, DDOF_ERROR_INVALID, "frame.offset or frame.picture size is beyond 2^24 pixels");
    if (f->pixel_aspect != 0 && !(f->pixel_aspect >= 1e-3 && f->pixel_aspect <= 1e3))
        return context_fail(ctx, DDOF_ERROR_INVALID, "frame.pixel_aspect must be 0 (square) or 0.001 to 1000");
    return DDOF_OK;
}

/* Depth or CoC. */
static ddof_status check_map(ddof_context *ctx, const ddof_frame *f, bool work) {
    const bool depth = f->depth.channels != 0;
    const char *name = depth ? "depth" : "coc";
    const ddof_image *map = depth ? &f->depth : &f->coc;
    if (depth == (f->coc.channels != 0))
        return context_fail(ctx, DDOF_ERROR_INVALID, "exactly one of frame.depth and frame.coc must be given");
    ddof_status status = check_image(ctx, map, 1, name);
    if (status != DDOF_OK) return status;
    status = check_size(ctx, map, work ? &f->color : &f->output, name, work ? "color" : "output");
    if (status != DDOF_OK) return status;
    return check_apart(ctx, &f->output, "output", map, name, !work);
}

static ddof_status check_holdout(ddof_context *ctx, const ddof_frame *f) {
    ddof_status status;
    if (!f->holdout) return DDOF_OK;
    if ((status = check_image(ctx, f->holdout, 1, "holdout")) != DDOF_OK) return status;
    if ((status = check_size(ctx, f->holdout, &f->color, "holdout", "color")) != DDOF_OK) return status;
    return check_apart(ctx, &f->output, "output", f->holdout, "holdout", false);
}

static ddof_status check_pair(ddof_context *ctx, const ddof_image *color, const ddof_image *output, const char *color_name,
                              const char *output_name) {
    ddof_status status;
    if ((status = check_image(ctx, color, 0, color_name)) != DDOF_OK) return status;
    if ((status = check_image(ctx, output, color->channels, output_name)) != DDOF_OK) return status;
    if (color->alpha != DDOF_ALPHA_PREMULTIPLIED && color->alpha != DDOF_ALPHA_STRAIGHT)
        return context_fail(ctx, DDOF_ERROR_INVALID, "frame.%s.alpha is none of ddof_alpha", color_name);
    if (color->alpha == DDOF_ALPHA_STRAIGHT && color->channels % 2)
        return context_fail(ctx, DDOF_ERROR_INVALID, "frame.%s: straight alpha needs 2 or 4 channels, not %d", color_name,
                            color->channels);
    if ((status = check_size(ctx, output, color, output_name, color_name)) != DDOF_OK) return status;
    return check_apart(ctx, output, output_name, color, color_name, true);
}

/* ---- more images; the first of all is color and output */

enum { NAME_SIZE = 32 };

static ddof_pair pair_at(const ddof_frame *f, int i, char color[NAME_SIZE], char output[NAME_SIZE]) {
    if (i == 0) {
        strcpy(color, "color");
        strcpy(output, "output");
        return (ddof_pair){f->color, f->output};
    }
    snprintf(color, NAME_SIZE, "more[%d].color", i - 1);
    snprintf(output, NAME_SIZE, "more[%d].output", i - 1);
    return f->more[i - 1];
}

/* The images of two pairs from each other. */
static ddof_status check_two(ddof_context *ctx, const ddof_frame *f, int i, int j) {
    char color_i[NAME_SIZE], output_i[NAME_SIZE], color_j[NAME_SIZE], output_j[NAME_SIZE];
    const ddof_pair a = pair_at(f, i, color_i, output_i), b = pair_at(f, j, color_j, output_j);
    ddof_status status = check_apart(ctx, &a.output, output_i, &b.output, output_j, false);
    if (status == DDOF_OK) status = check_apart(ctx, &a.output, output_i, &b.color, color_j, false);
    return status == DDOF_OK ? check_apart(ctx, &b.output, output_j, &a.color, color_i, false) : status;
}

static ddof_status check_more(ddof_context *ctx, const ddof_frame *f) {
    ddof_status status = DDOF_OK;
    if (f->more_count < 0 || f->more_count > MAX_MORE)
        return context_fail(ctx, DDOF_ERROR_INVALID, "frame.more_count is %d: give 0 to %d", f->more_count, MAX_MORE);
    if (!f->more != !f->more_count)
        return context_fail(ctx, DDOF_ERROR_INVALID, "frame.more and more_count must both be given, or neither");
    for (int i = 1; i <= f->more_count && status == DDOF_OK; i++) {
        char color[NAME_SIZE], output[NAME_SIZE];
        const ddof_pair pair = pair_at(f, i, color, output);
        status = check_pair(ctx, &pair.color, &pair.output, color, output);
        if (status == DDOF_OK) status = check_size(ctx, &pair.color, &f->color, color, "color");
        const ddof_image *const maps[] = {&f->depth, &f->coc, f->holdout};
        static const char *const names[] = {"depth", "coc", "holdout"};
        for (int m = 0; m < 3 && status == DDOF_OK; m++)
            if (maps[m] && maps[m]->channels) status = check_apart(ctx, &pair.output, output, maps[m], names[m], false);
        for (int j = 0; j < i && status == DDOF_OK; j++) status = check_two(ctx, f, i, j);
    }
    return status;
}

ddof_status check_frame(ddof_context *ctx, const ddof_frame *f, bool work) {
    ddof_status status;
    if (!f) return context_fail(ctx, DDOF_ERROR_INVALID, "frame is NULL");
    if ((status = check_geometry(ctx, f)) != DDOF_OK) return status;
    if (!work) {
        status = check_image(ctx, &f->output, 1, "output");
        return status == DDOF_OK ? check_map(ctx, f, work) : status;
    }
    if ((status = check_pair(ctx, &f->color, &f->output, "color", "output")) != DDOF_OK) return status;
    if ((status = check_holdout(ctx, f)) != DDOF_OK) return status;
    if ((status = check_map(ctx, f, work)) != DDOF_OK) return status;
    return check_more(ctx, f);
}

/* What is DIFFUSION's alone. */
static ddof_status check_method(ddof_context *ctx, const ddof_settings *s) {
    if (s->method < DDOF_METHOD_DIFFUSION || s->method > DDOF_METHOD_SCATTER)
        return context_fail(ctx, DDOF_ERROR_INVALID, "settings.method is none of ddof_method");
    if (s->method == DDOF_METHOD_DIFFUSION) return DDOF_OK;
    if (s->kernel != DDOF_KERNEL_HEAT || s->quality != DDOF_QUALITY_DEFAULT || s->substeps || s->conductance != DDOF_CONDUCTANCE_MATCHED)
        return context_fail(ctx, DDOF_ERROR_INVALID,
                            "settings.kernel, quality, substeps and conductance must be 0 with this settings.method: they say how to diffuse");
    if (s->bokeh == DDOF_BOKEH_HIGHLIGHTS)
        return context_fail(ctx, DDOF_ERROR_INVALID, "settings.bokeh: DDOF_BOKEH_HIGHLIGHTS needs DDOF_METHOD_DIFFUSION");
    if (s->bokeh == DDOF_BOKEH_FULL && s->method != DDOF_METHOD_SCATTER)
        return context_fail(ctx, DDOF_ERROR_INVALID,
                            "settings.bokeh: DDOF_BOKEH_FULL is a method of its own: set settings.method, or bokeh, to 0");
    return DDOF_OK;
}

ddof_status check_settings(ddof_context *ctx, const ddof_frame *frame, const ddof_settings *s) {
    if (!s) return context_fail(ctx, DDOF_ERROR_INVALID, "settings is NULL");
    if (!RESERVED_ZERO(s)) return context_fail(ctx, DDOF_ERROR_INVALID, "settings.reserved must be 0");
    if (s->conductance != DDOF_CONDUCTANCE_MATCHED && s->conductance != DDOF_CONDUCTANCE_CLASSIC)
        return context_fail(ctx, DDOF_ERROR_INVALID, "settings.conductance is none of ddof_conductance");
    if (s->substeps < 0 || s->substeps > MAX_SUBSTEPS)
        return context_fail(ctx, DDOF_ERROR_INVALID, "settings.substeps is %d: give 1 to %d, or 0 for 1", s->substeps,
                            MAX_SUBSTEPS);
    if (s->kernel != DDOF_KERNEL_HEAT && s->kernel != DDOF_KERNEL_DISC)
        return context_fail(ctx, DDOF_ERROR_INVALID, "settings.kernel is none of ddof_kernel");
    if (s->quality < DDOF_QUALITY_DEFAULT || s->quality > DDOF_QUALITY_BEST)
        return context_fail(ctx, DDOF_ERROR_INVALID, "settings.quality is none of ddof_quality");
    if (s->kernel == DDOF_KERNEL_HEAT && s->quality != DDOF_QUALITY_DEFAULT)
        return context_fail(ctx, DDOF_ERROR_INVALID, "settings.quality is for DDOF_KERNEL_DISC: set settings.kernel, or quality 0");
    if (s->kernel == DDOF_KERNEL_DISC && (s->substeps || s->conductance != DDOF_CONDUCTANCE_MATCHED))
        return context_fail(ctx, DDOF_ERROR_INVALID,
                            "settings.substeps and conductance must be 0 with DDOF_KERNEL_DISC: settings.quality decides");
    const ddof_status method = check_method(ctx, s);
    if (method != DDOF_OK) return method;
    const char *sprites = bokeh_check(s);
    if (sprites) return context_fail(ctx, DDOF_ERROR_INVALID, "settings.%s", sprites);
    if (s->layers != DDOF_LAYERS_OFF && s->layers != DDOF_LAYERS_AUTO)
        return context_fail(ctx, DDOF_ERROR_INVALID, "settings.layers is none of ddof_layers");
    if (s->solver < DDOF_SOLVER_DEFAULT || s->solver > DDOF_SOLVER_PCR3_SWEEP)
        return context_fail(ctx, DDOF_ERROR_INVALID, "settings.solver is none of ddof_solver");
    if (s->surface < DDOF_SURFACE_DEFAULT || s->surface > DDOF_SURFACE_RGBA32F)
        return context_fail(ctx, DDOF_ERROR_INVALID, "settings.surface is none of ddof_surface");
    if (s->shared_chain != 0 && s->shared_chain != 1)
        return context_fail(ctx, DDOF_ERROR_INVALID, "settings.shared_chain is %d: give 0 or 1", s->shared_chain);
    if (!frame->depth.channels) return DDOF_OK;
    const char *wrong = lens_check(&s->lens, &s->depth);
    return wrong ? context_fail(ctx, DDOF_ERROR_INVALID, "settings: %s", wrong) : DDOF_OK;
}
