/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The functions of ddof/gl.h: what the caller says is checked, her state is kept. */
#include <stdio.h>
#include <string.h>

#include "device.h"
#include "state.h"

/* Of ES 3.1. */
enum { TEXTURE_WIDTH = 0x1000, TEXTURE_HEIGHT = 0x1001, TEXTURE_INTERNAL_FORMAT = 0x1003 };

ddof_status ddof_gl_create(ddof_gl **gl, const ddof_gl_config *config) {
    char text[512] = "";
    ddof_status status = DDOF_ERROR_INVALID;
    if (!gl) return status;
    *gl = NULL;
    if (!config) return status;
    ddof_gl_config c = *config;
    if (!c.get_proc)
        snprintf(text, sizeof text, "config.get_proc is NULL: how are GL's functions to be found?");
    else if (!c.allocate != !c.release)
        snprintf(text, sizeof text, "config.allocate and config.release must both be given, or neither");
    else if (!RESERVED_ZERO(&c))
        snprintf(text, sizeof text, "config.reserved must be 0");
    else
        status = DDOF_OK;
    if (status == DDOF_OK) {
        if (!c.allocate) {
            c.allocate = context_allocate;
            c.release = context_release;
        }
        status = gl_device_create(gl, &c, NULL, text, sizeof text);
    }
    if (status != DDOF_OK && c.log) c.log(c.log_user, DDOF_LOG_ERROR, text);
    return status;
}

void ddof_gl_destroy(ddof_gl **gl) {
    if (gl && *gl) gl_device_destroy(gl);
}

const char *ddof_gl_error(const ddof_gl *gl) {
    return gl ? gl->shell.error : "";
}

ddof_status ddof_gl_trim(ddof_gl *gl) {
    if (!gl) return DDOF_ERROR_INVALID;
    gl->shell.error[0] = 0;
    gl_surfaces_delete(gl);
    gl_sprites_delete(gl);
    return DDOF_OK;
}

/* ---- what the caller says about her textures */

static const GLenum color_formats[] = {GL_RGBA32F,        GL_RGBA16F, GL_RGB32F,   GL_RGB16F,
                                       GL_R11F_G11F_B10F, GL_RGB9_E5, GL_RGB10_A2, GL_RGBA8,
                                       GL_SRGB8_ALPHA8,   GL_RGB8,    GL_SRGB8,    0};
static const GLenum depth_formats[] = {GL_R32F,
                                       GL_R16F,
                                       GL_DEPTH_COMPONENT16,
                                       GL_DEPTH_COMPONENT24,
                                       GL_DEPTH_COMPONENT32F,
                                       GL_DEPTH24_STENCIL8,
                                       GL_DEPTH32F_STENCIL8,
                                       0};
static const GLenum coc_formats[] = {GL_R32F, GL_R16F, 0};
static const GLenum output_formats[] = {GL_RGBA32F, GL_RGBA16F, 0};

static ddof_status wrong_type(ddof_gl *gl, const char *name, const char *why) {
    return context_fail(gl->owner, DDOF_ERROR_INVALID, "frame.%s: %s", name, why);
}

/* What can be seen in ES 3.0: that it is a 2D texture, and, where it can be drawn to, how its components are kept. */
static ddof_status look_at(ddof_gl *gl, const ddof_gl_texture *t, const char *name) {
    const gl_functions *f = &gl->f;
    const GLenum d = GL_DRAW_FRAMEBUFFER;
    const bool depth =
        t->format == GL_DEPTH_COMPONENT16 || t->format == GL_DEPTH_COMPONENT24 || t->format == GL_DEPTH_COMPONENT32F;
    const bool stencil = t->format == GL_DEPTH24_STENCIL8 || t->format == GL_DEPTH32F_STENCIL8;
    const GLenum at = stencil ? GL_DEPTH_STENCIL_ATTACHMENT : depth ? GL_DEPTH_ATTACHMENT : GL_COLOR_ATTACHMENT0;
    GLint type = 0, red = 0;
    f->BindFramebuffer(d, gl->probe);
    f->FramebufferTexture2D(d, at, GL_TEXTURE_2D, t->name, 0);
    const GLenum error = f->GetError();
    const bool is_2d = error == GL_NO_ERROR;
    if (is_2d && at == GL_COLOR_ATTACHMENT0 && f->CheckFramebufferStatus(d) == GL_FRAMEBUFFER_COMPLETE) {
        f->GetFramebufferAttachmentParameteriv(d, at, GL_FRAMEBUFFER_ATTACHMENT_COMPONENT_TYPE, &type);
        f->GetFramebufferAttachmentParameteriv(d, at, GL_FRAMEBUFFER_ATTACHMENT_RED_SIZE, &red);
    }
    const bool incomplete =
        is_2d && at != GL_COLOR_ATTACHMENT0 && f->CheckFramebufferStatus(d) != GL_FRAMEBUFFER_COMPLETE;
    f->FramebufferTexture2D(d, at, GL_TEXTURE_2D, 0, 0);
    gl_device_clear_errors(gl);
    if (error == GL_CONTEXT_WAS_LOST) gl->lost = true;
    if (gl->lost) return gl_device_lost(gl);
    if (!is_2d) return wrong_type(gl, name, "this is not a 2D texture");
    if (incomplete) return wrong_type(gl, name, "the texture is not of the depth format it is said to have");
    if (type == GL_INT || type == GL_UNSIGNED_INT)
        return wrong_type(gl, name, "the texture holds integers; it must be one that is sampled as float");
    const bool is_float =
        t->format == GL_RGBA32F || t->format == GL_RGBA16F || t->format == GL_R32F || t->format == GL_R16F;
    const int bits = t->format == GL_RGBA32F || t->format == GL_R32F ? 32 : 16;
    if (type && is_float && (type != GL_FLOAT || red != bits))
        return wrong_type(gl, name, "the texture is not of the format it is said to have");
    return DDOF_OK;
}

/* What can be seen from ES 3.1 on. Binds to the unit that is active. */
static ddof_status measure(ddof_gl *gl, const ddof_gl_frame *frame, const ddof_gl_texture *t, const char *name) {
    GLint width = 0, height = 0, format = 0;
    if (!gl->f.GetTexLevelParameteriv) return DDOF_OK;
    gl->f.BindTexture(GL_TEXTURE_2D, t->name);
    gl->f.GetTexLevelParameteriv(GL_TEXTURE_2D, 0, TEXTURE_WIDTH, &width);
    gl->f.GetTexLevelParameteriv(GL_TEXTURE_2D, 0, TEXTURE_HEIGHT, &height);
    gl->f.GetTexLevelParameteriv(GL_TEXTURE_2D, 0, TEXTURE_INTERNAL_FORMAT, &format);
    if (width != frame->width || height != frame->height)
        return context_fail(gl->owner, DDOF_ERROR_INVALID, "frame.%s: the texture is %d x %d, not %d x %d", name, width,
                            height, frame->width, frame->height);
    if ((unsigned)format != t->format)
        return context_fail(gl->owner, DDOF_ERROR_INVALID,
                            "frame.%s: the texture's format is 0x%04x, not 0x%04x as it is said", name,
                            (unsigned)format, t->format);
    return DDOF_OK;
}

static ddof_status check_texture(ddof_gl *gl, const ddof_gl_frame *frame, const ddof_gl_texture *t, const char *name,
                                 const GLenum *allowed) {
    while (*allowed && *allowed != t->format)
        allowed++;
    if (!t->name) return wrong_type(gl, name, "no texture is given");
    if (!*allowed)
        return context_fail(gl->owner, DDOF_ERROR_INVALID,
                            "frame.%s: format 0x%04x is none of those that ddof/gl.h lists for it", name, t->format);
    if (!gl->f.IsTexture(t->name)) return wrong_type(gl, name, "there is no texture of that name");
    ddof_status status = look_at(gl, t, name);
    return status == DDOF_OK ? measure(gl, frame, t, name) : status;
}

static ddof_status check_textures(ddof_gl *gl, const ddof_gl_frame *frame) {
    const bool depth = frame->depth.name != 0;
    const ddof_gl_texture *map = depth ? &frame->depth : &frame->coc;
    if (depth == (frame->coc.name != 0))
        return context_fail(gl->owner, DDOF_ERROR_INVALID, "exactly one of frame.depth and frame.coc must be given");
    if (frame->output.name && (frame->output.name == frame->color.name || frame->output.name == map->name))
        return context_fail(gl->owner, DDOF_ERROR_INVALID,
                            "frame.output is also an input: a texture cannot be read and drawn to at once");
    gl->f.ActiveTexture(GL_TEXTURE0);
    ddof_status status = check_texture(gl, frame, &frame->color, "color", color_formats);
    if (status == DDOF_OK)
        status = check_texture(gl, frame, map, depth ? "depth" : "coc", depth ? depth_formats : coc_formats);
    return status == DDOF_OK ? check_texture(gl, frame, &frame->output, "output", output_formats) : status;
}

/* ---- a frame */

/* The same frame as ddof_render() would have it, without memory. */
static ddof_frame described(const ddof_gl_frame *in) {
    ddof_frame f;
    memset(&f, 0, sizeof f);
    f.color.width = f.output.width = in->width;
    f.color.height = f.output.height = in->height;
    f.color.channels = f.output.channels = in->channels == 3 ? 3 : 4;
    ddof_image map = f.color;
    map.channels = 1;
    *(in->depth.name ? &f.depth : &f.coc) = map;
    f.picture_width = in->picture_width;
    f.picture_height = in->picture_height;
    f.offset_x = in->offset_x;
    f.offset_y = in->offset_y;
    f.pixel_aspect = in->pixel_aspect;
    f.next = in->next;
    memcpy(f.reserved, in->reserved, sizeof f.reserved);
    return f;
}

ddof_status ddof_gl_surface_bytes(int width, int height, const ddof_settings *settings, size_t *bytes) {
    if (width < 1 || height < 1 || width > 1 << 20 || height > 1 << 20 || !settings || !bytes)
        return DDOF_ERROR_INVALID;
    if (settings->solver < DDOF_SOLVER_DEFAULT || settings->solver > DDOF_SOLVER_CR_PCR ||
        settings->surface < DDOF_SURFACE_DEFAULT || settings->surface > DDOF_SURFACE_RGBA32F)
        return DDOF_ERROR_INVALID;
    const ddof_frame frame = described(&(ddof_gl_frame){.width = width, .height = height});
    frame_job job;
    double distance;
    if (bokeh_check(settings)) return DDOF_ERROR_INVALID;
    pipeline_prepare(NULL, &job, &frame, settings, false, &distance);
    const gl_layout layout = gl_layout_make(width, height, 1 << 30, settings);
    gl_surfaces s;
    gl_sprites sprites = {.bytes = 0};
    gl_surfaces_plan(&s, &layout);
    if (job.highlights || job.method == DDOF_METHOD_SCATTER) gl_sprites_plan(&sprites, &job, true, 1 << 30, true);
    *bytes = (job.method == DDOF_METHOD_SCATTER ? 0 : s.bytes) + sprites.bytes;
    return DDOF_OK;
}

static ddof_status check(ddof_gl *gl, const ddof_gl_frame *frame, const ddof_settings *settings) {
    GLboolean active = GL_FALSE, paused = GL_FALSE;
    if (frame->width < 1 || frame->height < 1)
        return context_fail(gl->owner, DDOF_ERROR_INVALID, "frame is %d x %d texels: each side must be above 0",
                            frame->width, frame->height);
    if (frame->width > gl->max_size || frame->height > gl->max_size)
        return context_fail(gl->owner, DDOF_ERROR_UNSUPPORTED, "frame is %d x %d texels, but this GL (%s) allows %d",
                            frame->width, frame->height, gl->renderer, gl->max_size);
    if (frame->channels != 0 && frame->channels != 3 && frame->channels != 4)
        return context_fail(gl->owner, DDOF_ERROR_INVALID, "frame.channels is %d: give 3 or 4, or 0 for 4",
                            frame->channels);
    if (frame->depth.name && settings->lens.focus != DDOF_FOCUS_DISTANCE)
        return context_fail(gl->owner, DDOF_ERROR_INVALID,
                            "lens.focus must be DDOF_FOCUS_DISTANCE: reading a pixel back would make the GPU wait");
    if (settings->kernel == DDOF_KERNEL_DISC || settings->layers == DDOF_LAYERS_AUTO)
        return context_fail(gl->owner, DDOF_ERROR_UNSUPPORTED,
                            "settings.%s: this call diffuses one layer with the heat kernel; ddof_render() has more",
                            settings->kernel ? "kernel" : "layers");
    if (settings->method == DDOF_METHOD_GAUSSIAN || settings->method == DDOF_METHOD_HEXAGON)
        return context_fail(gl->owner, DDOF_ERROR_UNSUPPORTED,
                            "settings.method: this call has neither the Gaussian nor the hexagon; ddof_render() has both");
    gl->f.GetBooleanv(GL_TRANSFORM_FEEDBACK_ACTIVE, &active);
    gl->f.GetBooleanv(GL_TRANSFORM_FEEDBACK_PAUSED, &paused);
    if (active && !paused)
        return context_fail(gl->owner, DDOF_ERROR_INVALID, "transform feedback is active: pause it before the call");
    return DDOF_OK;
}

static ddof_status prepare(ddof_gl *gl, frame_job *job, const ddof_frame *described_frame,
                           const ddof_settings *settings) {
    double distance;
    ddof_status status = check_geometry(gl->owner, described_frame);
    if (status == DDOF_OK) status = check_settings(gl->owner, described_frame, settings);
    if (status == DDOF_OK) status = pipeline_prepare(gl->owner, job, described_frame, settings, true, &distance);
    if (status == DDOF_OK && job->method == DDOF_METHOD_DIFFUSION) status = gl_check_solver(gl->owner, settings);
    if (status == DDOF_OK) status = pipeline_iris(gl->owner, job);
    return status;
}

ddof_status ddof_gl_render(ddof_gl *gl, const ddof_gl_frame *frame, const ddof_settings *settings,
                           ddof_gl_stats *stats) {
    gl_state state;
    frame_job job;
    if (stats) memset(stats, 0, sizeof *stats);
    if (!gl) return DDOF_ERROR_INVALID;
    gl->shell.error[0] = 0;
    if (!frame || !settings)
        return context_fail(gl->owner, DDOF_ERROR_INVALID, "%s is NULL", frame ? "settings" : "frame");
    const ddof_frame same = described(frame);
    ddof_status status = check(gl, frame, settings);
    if (status == DDOF_OK) status = prepare(gl, &job, &same, settings);
    if (status != DDOF_OK) return status;
    const GLenum pending = gl->f.GetError();
    if (pending != GL_NO_ERROR) {
        context_log(gl->owner, DDOF_LOG_WARNING, "GL error 0x%04x was pending and is discarded", pending);
        gl_device_clear_errors(gl);
    }
    if (gl->lost || (status = gl_device_check(gl)) != DDOF_OK)
        return context_fail(gl->owner, DDOF_ERROR_DEVICE, "the GL context (%s) was lost: make another ddof_gl",
                            gl->renderer);
    gl->draws = 0;
    gl_state_save(gl, &state);
    gl_state_set(gl);
    status = check_textures(gl, frame);
    if (status == DDOF_OK) {
        const gl_frame work = {.job = &job,
                               .settings = settings,
                               .width = frame->width,
                               .height = frame->height,
                               .color = frame->color.name,
                               .map = frame->depth.name ? frame->depth.name : frame->coc.name,
                               .output = frame->output.name,
                               .alpha = frame->channels != 3,
                               .half_output = frame->output.format == GL_RGBA16F,
                               .holes = true,
                               .colors = 3,
                               .gain = 1};
        status = job.iris ? gl_sprites_render(gl, &work) : gl_solve(gl, &work);
    }
    gl_state_restore(gl, &state);
    if (status == DDOF_OK && stats) {
        stats->surface_bytes = gl->surfaces.bytes + gl->sprites.bytes;
        stats->objects = gl->objects;
        stats->draws = gl->draws;
        stats->device = gl->renderer;
    }
    return status;
}
