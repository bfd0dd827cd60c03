/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The GL backend of ddof_render(): the described images go up to textures, through the solver, and back. Its own context
 * is current only while it works, never while the caller's callbacks run. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "../cpu/block.h"
#include "../filled.h"
#include "../image.h"
#include "../staging.h"
#include "device.h"
#include "egl.h"

/* The pictures on the GPU; kept between frames. */
typedef struct gl_images {
    int width, height;
    GLenum format;             /* of color and output */
    GLuint color, map, output; /* map: R32F */
    GLuint coc;                /* R32F, for gl_coc() */
    GLuint framebuffer;        /* to read from */
} gl_images;

typedef struct gl_backend {
    egl_session egl;
    ddof_gl *gl;
    gl_images images;
    bool entered;
} gl_backend;

/* ---- the context */

static bool enter(ddof_context *ctx, gl_backend *b) {
    char text[256];
    b->entered = egl_enter(&b->egl, text, sizeof text);
    if (!b->entered) context_fail(ctx, DDOF_ERROR_DEVICE, "%s", text);
    return b->entered;
}

static void leave(gl_backend *b) {
    if (b->entered) egl_leave(&b->egl);
    b->entered = false;
}

static void delete_images(gl_backend *b) {
    const GLuint textures[4] = {b->images.color, b->images.map, b->images.output, b->images.coc};
    b->gl->f.DeleteTextures(4, textures);
    if (b->images.framebuffer) b->gl->f.DeleteFramebuffers(1, &b->images.framebuffer);
    b->images = (gl_images){0};
}

static void shut(ddof_context *ctx, gl_backend *b) {
    (void)ctx;
    if (b->gl && enter(ctx, b)) {
        delete_images(b);
        gl_device_destroy(&b->gl);
        leave(b);
    } else if (b->gl) { /* the context is gone, and its objects with it */
        b->gl->config.release(b->gl->config.memory_user, b->gl);
        b->gl = NULL;
    }
    egl_close(&b->egl);
    b->images = (gl_images){0};
}

static ddof_status start(ddof_context *ctx, gl_backend *b) {
    char text[512];
    if (!egl_open(&b->egl, text, sizeof text)) return context_fail(ctx, DDOF_ERROR_UNSUPPORTED, "%s", text);
    ddof_status status = DDOF_ERROR_DEVICE;
    if (enter(ctx, b)) {
        const ddof_gl_config config = {.get_proc = egl_get_proc,
                                       .get_proc_user = &b->egl,
                                       .allocate = ctx->config.allocate,
                                       .release = ctx->config.release,
                                       .memory_user = ctx->config.memory_user};
        status = gl_device_create(&b->gl, &config, ctx, text, sizeof text);
        leave(b);
        if (status != DDOF_OK) context_fail(ctx, status, "%s", text);
    }
    if (status != DDOF_OK) egl_close(&b->egl);
    return status;
}

static ddof_status gl_open(ddof_context *ctx) {
    gl_backend *b = ctx->config.allocate(ctx->config.memory_user, sizeof *b);
    if (!b) return context_fail(ctx, DDOF_ERROR_MEMORY, "out of memory for the GL backend");
    memset(b, 0, sizeof *b);
    ddof_status status = start(ctx, b);
    if (status == DDOF_OK)
        ctx->device = b;
    else
        ctx->config.release(ctx->config.memory_user, b);
    return status;
}

static void gl_close(ddof_context *ctx) {
    gl_backend *b = ctx->device;
    if (!b) return;
    shut(ctx, b);
    ctx->config.release(ctx->config.memory_user, b);
    ctx->device = NULL;
}

/* Current, with a context that works: one that was lost is made anew. */
static ddof_status ready(ddof_context *ctx, gl_backend *b) {
    if (!b->gl || b->gl->lost) {
        shut(ctx, b);
        ctx->error[0] = 0;
        ddof_status status = start(ctx, b);
        if (status != DDOF_OK) return status;
    }
    return enter(ctx, b) ? DDOF_OK : DDOF_ERROR_DEVICE;
}

static void gl_trim(ddof_context *ctx) {
    gl_backend *b = ctx->device;
    if (!b->gl || b->gl->lost || !enter(ctx, b)) return;
    delete_images(b);
    gl_surfaces_delete(b->gl);
    gl_methods_delete(b->gl);
    gl_sprites_delete(b->gl);
    leave(b);
}

/* Says how far it is; false: stop. */
static bool progress(ddof_context *ctx, gl_backend *b, int64_t rows) {
    if (!ctx->config.progress) return true;
    leave(b);
    const bool on = context_progress(ctx, rows);
    return enter(ctx, b) && on;
}

/* ---- up */

static ddof_status make_images(ddof_context *ctx, gl_backend *b, int width, int height, GLenum format) {
    gl_images *i = &b->images;
    ddof_gl *gl = b->gl;
    if (width > gl->max_size || height > gl->max_size)
        return context_fail(ctx, DDOF_ERROR_UNSUPPORTED,
                            "the picture is %d x %d, but this GL (%s) has textures up to %d: use the CPU backend",
                            width, height, gl->renderer, gl->max_size);
    if (i->framebuffer && i->width == width && i->height == height && i->format == format) return DDOF_OK;
    delete_images(b);
    *i = (gl_images){.width = width, .height = height, .format = format};
    gl->f.ActiveTexture(GL_TEXTURE0);
    i->map = gl_texture_make(gl, GL_R32F, width, height);
    if (format == GL_R32F) {
        i->coc = gl_texture_make(gl, GL_R32F, width, height);
    } else {
        i->color = gl_texture_make(gl, format, width, height);
        i->output = gl_texture_make(gl, format, width, height);
    }
    gl->f.GenFramebuffers(1, &i->framebuffer);
    gl->objects++;
    ddof_status status = gl_device_check(gl);
    if (status != DDOF_OK) delete_images(b);
    return status;
}

static ddof_status upload(ddof_context *ctx, gl_backend *b, frame_job *job, staging *s) {
    const gl_functions *f = &b->gl->f;
    const int width = b->images.width, height = b->images.height;
    const bool half = b->images.format == GL_RGBA16F;
    const ddof_solver solver =
        job->settings->solver == DDOF_SOLVER_DEFAULT ? DDOF_SOLVER_CR4_PACK : job->settings->solver;
    if (half || solver_packs(solver)) staging_find_gain(ctx, job, s);
    f->ActiveTexture(GL_TEXTURE0);
    for (int y = 0; y < height; y += STAGING_ROWS) {
        const int rows = height - y < STAGING_ROWS ? height - y : STAGING_ROWS;
        staging_load(ctx, job, s, y, rows, half);
        f->BindTexture(GL_TEXTURE_2D, b->images.color);
        f->TexSubImage2D(GL_TEXTURE_2D, 0, 0, y, width, rows, GL_RGBA, half ? GL_HALF_FLOAT : GL_FLOAT,
                         half ? (const void *)s->half : s->pixels);
        f->BindTexture(GL_TEXTURE_2D, b->images.map);
        f->TexSubImage2D(GL_TEXTURE_2D, 0, 0, y, width, rows, GL_RED, GL_FLOAT, s->map);
        if (!progress(ctx, b, rows)) return DDOF_ERROR_CANCELLED;
    }
    return DDOF_OK;
}

/* ---- down */

static void read_from(gl_backend *b, GLuint texture) {
    const gl_functions *f = &b->gl->f;
    f->BindFramebuffer(GL_READ_FRAMEBUFFER, b->images.framebuffer);
    f->FramebufferTexture2D(GL_READ_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture, 0);
}

/* Nothing is stored before GL has said that all went well: a context may be lost at any time. */
static ddof_status read_rows(gl_backend *b, int y, int rows, float *pixels) {
    b->gl->f.ReadPixels(0, y, b->images.width, rows, GL_RGBA, GL_FLOAT, pixels);
    return gl_device_check(b->gl);
}

static ddof_status download(ddof_context *ctx, gl_backend *b, frame_job *job, const staging *s) {
    const int height = b->images.height;
    read_from(b, b->images.output);
    for (int y = 0; y < height; y += STAGING_ROWS) {
        const int rows = height - y < STAGING_ROWS ? height - y : STAGING_ROWS;
        ddof_status status = read_rows(b, y, rows, s->pixels);
        if (status != DDOF_OK) return status;
        staging_store(ctx, job, s, y, rows);
        if (!progress(ctx, b, rows)) return DDOF_ERROR_CANCELLED;
    }
    return DDOF_OK;
}

/* ---- the stages of the backend */

static gl_frame frame_of(const gl_backend *b, frame_job *job) {
    return (gl_frame){.job = job,
                      .settings = job->settings,
                      .width = b->images.width,
                      .height = b->images.height,
                      .color = b->images.color,
                      .map = b->images.map};
}

/* What a stage does with the picture on the GPU. */
typedef ddof_status (*gl_work)(ddof_gl *gl, const gl_frame *frame);

static ddof_status work_now(ddof_context *ctx, gl_backend *b, frame_job *job, staging *s, gl_work work) {
    const ddof_image *color = &job->frame->color;
    const GLenum format = job->settings->surface == DDOF_SURFACE_RGBA32F ? GL_RGBA32F : GL_RGBA16F;
    ddof_status status = make_images(ctx, b, color->width, color->height, format);
    if (status == DDOF_OK) status = upload(ctx, b, job, s);
    if (status != DDOF_OK) return status;
    gl_frame frame = frame_of(b, job);
    frame.output = b->images.output;
    frame.alpha = color->channels == 4;
    frame.half_output = format == GL_RGBA16F;
    frame.colors = color->alpha == DDOF_ALPHA_STRAIGHT ? color->channels - 1 : color->channels < 3 ? color->channels : 3;
    frame.gain = s->gain;
    frame.holes = job->nonfinite_pixels > 0;
    for (GLuint i = 0; i < GL_UNITS; i++)
        b->gl->f.BindSampler(i, b->gl->sampler);
    b->gl->f.BindVertexArray(b->gl->vertex_array);
    b->gl->f.Disable(GL_DITHER);
    status = work(b->gl, &frame);
    return status == DDOF_OK ? download(ctx, b, job, s) : status;
}

static ddof_status run(ddof_context *ctx, frame_job *job, void *scratch, gl_work work) {
    gl_backend *b = ctx->device;
    staging s = staging_lay_out(job, scratch);
    ctx->progress_total = 2.0 * job->frame->color.height;
    ddof_status status = job->method == DDOF_METHOD_DIFFUSION ? gl_check_solver(ctx, job->settings) : DDOF_OK;
    if (status == DDOF_OK) status = ready(ctx, b);
    if (status == DDOF_OK) status = work_now(ctx, b, job, &s, work);
    leave(b);
    if (ctx->cancelled) return DDOF_ERROR_CANCELLED;
    return ctx->error[0] && status == DDOF_ERROR_CANCELLED ? DDOF_ERROR_DEVICE
                                                           : status; /* lost between two callbacks */
}

static ddof_status gl_diffuse(ddof_context *ctx, frame_job *job, void *scratch) {
    return run(ctx, job, scratch, gl_solve);
}

/* ---- gaussian and hexagon: the picture goes up as floats without holes, comes back into the same memory, and is stored */

static filled_picture picture_of(const frame_job *job, arena *a) {
    const size_t n = (size_t)job->coc_source.width * (size_t)job->coc_source.height * sizeof(float);
    filled_picture p = {.width = job->coc_source.width, .height = job->coc_source.height};
    p.rgba = arena_take(a, 4 * n);
    p.coc = arena_take(a, n);
    return p;
}

static size_t gl_scratch_bytes(const ddof_context *ctx, const frame_job *job) {
    arena a = {0};
    if (job->method != DDOF_METHOD_GAUSSIAN && job->method != DDOF_METHOD_HEXAGON) return staging_bytes(ctx, job);
    picture_of(job, &a);
    const size_t fill = filled_bytes(job), stage = staging_bytes(ctx, job);
    return a.used + (fill > stage ? fill : stage);
}

typedef struct stored {
    const filled_picture *picture;
    ddof_image output;
    bool straight;
    const pixel_kernels *k;
} stored;

static void store_rows(void *user, int y0, int y1) {
    const stored *s = user;
    const filled_picture *p = s->picture;
    for (int y = y0; y < y1; y++)
        span_store(&s->output, 0, y, p->width, p->rgba + 4 * (ptrdiff_t)p->width * y, s->straight, s->k);
}

static ddof_status gather(ddof_context *ctx, frame_job *job, void *scratch, gl_work work) {
    arena a = {.base = scratch};
    inner_job inner;
    filled_picture p = picture_of(job, &a);
    void *rest = arena_take(&a, 0);
    const double from = ctx->progress_from, quarter = (ctx->progress_to - from) / 4;
    context_stage(ctx, from, from + quarter);
    ctx->progress_total = p.height;
    ddof_status status = filled_load(ctx, job, &p, rest);
    if (status != DDOF_OK) return status;
    const ddof_image rgba = ddof_image_interleaved(p.rgba, p.width, p.height, 4, DDOF_FLOAT, 0);
    const ddof_image coc = ddof_image_interleaved(p.coc, p.width, p.height, 1, DDOF_FLOAT, 0);
    pipeline_inner(&inner, job, &rgba, &coc, 0, 0);
    inner.job.nearest = p.nearest;
    context_stage(ctx, from + quarter, from + 3 * quarter);
    status = run(ctx, &inner.job, rest, work);
    if (status != DDOF_OK) return status;
    stored s = {&p, job->frame->output, job->frame->color.alpha == DDOF_ALPHA_STRAIGHT, ctx->kernels->pixels};
    image_resolve(&s.output);
    context_stage(ctx, from + 3 * quarter, from + 4 * quarter);
    ctx->progress_total = p.height;
    return filled_rows(ctx, p.height, store_rows, &s);
}

static ddof_status gl_gaussian(ddof_context *ctx, frame_job *job, void *scratch) {
    return gather(ctx, job, scratch, gl_gaussian_render);
}

static ddof_status gl_hexagon(ddof_context *ctx, frame_job *job, void *scratch) {
    return gather(ctx, job, scratch, gl_hexagon_render);
}

/* ---- sprites */

static ddof_status draw_and_count(ddof_gl *gl, const gl_frame *frame) {
    const ddof_status status = gl_sprites_render(gl, frame);
    return status == DDOF_OK ? gl_sprites_count(gl, frame) : status;
}

static ddof_status gl_scatter(ddof_context *ctx, frame_job *job, void *scratch) {
    return run(ctx, job, scratch, draw_and_count);
}

/* ---- the CoC alone */

static ddof_status coc_now(ddof_context *ctx, gl_backend *b, frame_job *job, const staging *s) {
    const int width = job->coc_source.width, height = job->coc_source.height;
    ddof_image output = job->frame->output;
    ddof_status status = make_images(ctx, b, width, height, GL_R32F);
    if (status != DDOF_OK) return status;
    image_resolve(&output);
    b->gl->f.ActiveTexture(GL_TEXTURE0);
    b->gl->f.BindTexture(GL_TEXTURE_2D, b->images.map);
    for (int y = 0; y < height; y++) {
        plane_load(&job->coc_source, 0, 0, y, width, s->map, ctx->kernels->pixels);
        b->gl->f.TexSubImage2D(GL_TEXTURE_2D, 0, 0, y, width, 1, GL_RED, GL_FLOAT, s->map);
    }
    gl_frame frame = frame_of(b, job);
    frame.output = b->images.coc;
    for (GLuint i = 0; i < GL_UNITS; i++)
        b->gl->f.BindSampler(i, b->gl->sampler);
    b->gl->f.BindVertexArray(b->gl->vertex_array);
    status = gl_coc(b->gl, &frame);
    if (status != DDOF_OK) return status;
    read_from(b, b->images.coc);
    for (int y = 0; y < height; y++) {
        if ((status = read_rows(b, y, 1, s->pixels)) != DDOF_OK) return status;
        for (int x = 0; x < width; x++) {
            s->map[x] = s->pixels[(ptrdiff_t)x * 4];
            job->nonfinite_pixels += !isfinite(s->map[x]);
        }
        plane_store(&output, 0, 0, y, width, s->map, ctx->kernels->pixels);
    }
    return progress(ctx, b, height) ? DDOF_OK : DDOF_ERROR_CANCELLED;
}

static ddof_status gl_coc_stage(ddof_context *ctx, frame_job *job, void *scratch) {
    gl_backend *b = ctx->device;
    const staging s = staging_lay_out(job, scratch);
    ctx->progress_total = job->coc_source.height;
    ddof_status status = ready(ctx, b);
    if (status == DDOF_OK) status = coc_now(ctx, b, job, &s);
    leave(b);
    return status;
}

static size_t gl_device_bytes(const ddof_context *ctx) {
    const gl_backend *b = ctx->device;
    return b->gl ? b->gl->surfaces.bytes + b->gl->methods.bytes + b->gl->sprites.bytes : 0;
}

static const char *gl_device(const ddof_context *ctx) {
    const gl_backend *b = ctx->device;
    return b->gl ? b->gl->renderer : "";
}

/* ---- what there is */

static void keep_text(void *user, ddof_log_level level, const char *text) {
    ddof_device *d = user;
    if (level == DDOF_LOG_ERROR) snprintf(d->refused, sizeof d->refused, "%s", text);
}

static void describe(ddof_device *d, const ddof_gl *gl) {
    static const char *const software[] = {"llvmpipe", "softpipe", "swrast", "SwiftShader"};
    const char *version = (const char *)gl->f.GetString(GL_VERSION);
    snprintf(d->name, sizeof d->name, "%s", gl->renderer);
    snprintf(d->driver, sizeof d->driver, "%s", version ? version : "");
    for (size_t i = 0; i < sizeof software / sizeof *software; i++)
        if (strstr(gl->renderer, software[i])) d->is_software = 1;
    d->max_side = gl->max_size;
}

/* EGL picks the device, so there is at most one. */
static int gl_list(ddof_device *devices, int capacity) {
    egl_session egl;
    ddof_gl *gl = NULL;
    ddof_device d;
    memset(&d, 0, sizeof d);
    if (!egl_open(&egl, d.refused, sizeof d.refused)) return 0;
    if (egl_enter(&egl, d.refused, sizeof d.refused)) {
        const ddof_gl_config config = {
            .get_proc = egl_get_proc, .get_proc_user = &egl, .log = keep_text, .log_user = &d};
        if (ddof_gl_create(&gl, &config) == DDOF_OK) describe(&d, gl);
        ddof_gl_destroy(&gl);
        egl_leave(&egl);
    }
    egl_close(&egl);
    if (capacity > 0) devices[0] = d;
    return 1;
}

const backend backend_gl = {
    .id = DDOF_BACKEND_GL,
    .scratch_bytes = gl_scratch_bytes,
    .coc = gl_coc_stage,
    .diffuse = gl_diffuse,
    .gaussian = gl_gaussian,
    .hexagon = gl_hexagon,
    .sprites = gl_scatter,
    .device = gl_device,
    .open = gl_open,
    .close = gl_close,
    .trim = gl_trim,
    .surface_bytes = gl_device_bytes,
    .list = gl_list,
};
