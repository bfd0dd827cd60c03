/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "backend.h"

#include <stdio.h>
#include <string.h>

#include "../bokeh.h"
#include "sprites.h"

enum {
    PATIENCE_MS = 100, /* of one wait, after which the caller is asked whether to go on */
    WAITS = 6000       /* ten minutes: then the GPU is taken for hung */
};

/* ---- errors */

ddof_status vulkan_check(const vulkan_backend *b, VkResult result, const char *doing) {
    return vulkan_result(b->owner, b->name, result, doing);
}

/* The sentence of a ddof_vulkan that could not be made comes no other way. */
static void keep_text(void *user, ddof_log_level level, const char *text) {
    vulkan_backend *b = user;
    if (level == DDOF_LOG_ERROR)
        snprintf(b->text, sizeof b->text, "%s", text);
    else
        context_log(b->owner, level, "%s", text);
}

/* ---- work for the GPU */

ddof_status vulkan_wait(vulkan_backend *b, slot *s) {
    VkResult result = VK_TIMEOUT;
    if (!s->pending) return DDOF_OK;
    for (int i = 0; i < WAITS && result == VK_TIMEOUT; i++) {
        result = b->f.WaitForFences(b->session.device, 1, &s->fence, VK_TRUE, PATIENCE_MS * UINT64_C(1000000));
        if (result == VK_TIMEOUT) context_progress(b->owner, 0);
    }
    if (result == VK_TIMEOUT) {
        b->hung = true;
        return context_fail(b->owner, DDOF_ERROR_DEVICE, "the Vulkan device (%s) has not answered for ten minutes",
                            b->name);
    }
    s->pending = result != VK_SUCCESS && result != VK_ERROR_DEVICE_LOST;
    return vulkan_check(b, result, "at work");
}

/* Waits for all that is under way, whatever becomes of it. */
static ddof_status settle(vulkan_backend *b) {
    ddof_status status = DDOF_OK;
    for (int i = 0; i < SLOTS && !b->hung; i++) {
        const ddof_status one = vulkan_wait(b, &b->slot[(b->turn + i) % SLOTS]);
        if (status == DDOF_OK) status = one;
    }
    return status;
}

ddof_status vulkan_begin(vulkan_backend *b, slot **out) {
    const VkCommandBufferBeginInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                           .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
    slot *s = *out = &b->slot[b->turn];
    b->turn = (b->turn + 1) % SLOTS;
    ddof_status status = vulkan_wait(b, s);
    if (status == DDOF_OK) status = vulkan_check(b, b->f.BeginCommandBuffer(s->commands, &info), "recording");
    return status;
}

ddof_status vulkan_submit(vulkan_backend *b, slot *s) {
    const VkSubmitInfo info = {
        .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 1, .pCommandBuffers = &s->commands};
    ddof_status status = vulkan_check(b, b->f.EndCommandBuffer(s->commands), "recording");
    if (status == DDOF_OK) status = vulkan_check(b, b->f.ResetFences(b->session.device, 1, &s->fence), "recording");
    if (status == DDOF_OK)
        status = vulkan_check(b, b->f.QueueSubmit(b->session.queue, 1, &info, s->fence), "submitting work");
    s->pending = status == DDOF_OK;
    return status;
}

void vulkan_barrier(const vulkan_backend *b, const slot *s, VkImage image, const transition *t) {
    const VkImageMemoryBarrier info = {.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER,
                                       .srcAccessMask = t->from,
                                       .dstAccessMask = t->to,
                                       .oldLayout = t->before,
                                       .newLayout = t->after,
                                       .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                       .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                       .image = image,
                                       .subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1}};
    b->f.CmdPipelineBarrier(s->commands, t->from_stage, t->to_stage, 0, 0, NULL, 0, NULL, 1, &info);
}

/* ---- the blur */

/* What is not looked at is 0, so that it cannot differ from what a frame object was made with. */
static ddof_settings settings_of(const frame_job *job) {
    ddof_settings s = *job->settings;
    s.lens.focus = DDOF_FOCUS_DISTANCE; /* a pixel has been looked at already */
    s.lens.focus_distance = job->focus_distance;
    if (!job->is_depth) {
        s.lens = (ddof_lens){0};
        s.depth = (ddof_depth){0};
    }
    return s;
}

/* Channels that shine: an alpha does not. */
static int colors_of(const ddof_image *color) {
    if (color->channels == 2 && color->alpha == DDOF_ALPHA_STRAIGHT) return 1;
    return color->channels < 3 ? color->channels : 3;
}

/* The frame object; kept like the pictures. */
static ddof_status make_frame(vulkan_backend *b, const frame_job *job) {
    const vulkan_pictures *p = &b->pictures;
    const ddof_settings s = settings_of(job);
    const frame_kind kind = {.is_depth = job->is_depth,
                             .alpha = job->frame->color.channels == 4,
                             .depth = s.depth.kind,
                             .solver = s.solver,
                             .surface = s.surface,
                             .disc = job->disc,
                             .sprites = vulkan_sprite_kind_of(&s),
                             .colors = colors_of(&job->frame->color)};
    const frame_kind *k = &b->kind;
    if (b->frame && k->is_depth == kind.is_depth && k->alpha == kind.alpha && k->depth == kind.depth &&
        k->solver == kind.solver && k->surface == kind.surface && k->disc == kind.disc && k->colors == kind.colors &&
        !vulkan_sprite_kind_differs(&k->sprites, &kind.sprites))
        return DDOF_OK;
    ddof_vulkan_frame_destroy(&b->frame);
    const uint32_t width = (uint32_t)p->width, height = (uint32_t)p->height;
    const ddof_vulkan_image map = {.image = p->map,
                                   .format = VK_FORMAT_R32_SFLOAT,
                                   .width = width,
                                   .height = height,
                                   .usage = vulkan_map_usage,
                                   .layout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
    ddof_vulkan_images images = {.channels = kind.alpha ? 4 : 3};
    images.color = (ddof_vulkan_image){.image = p->color,
                                       .format = vulkan_color_format(p),
                                       .width = width,
                                       .height = height,
                                       .usage = vulkan_color_usage,
                                       .layout = VK_IMAGE_LAYOUT_GENERAL};
    images.output = images.color;
    *(job->is_depth ? &images.depth : &images.coc) = map;
    ddof_status status = ddof_vulkan_frame_create(b->vk, &b->frame, &images, &s);
    if (status != DDOF_OK) return context_fail(b->owner, status, "%s", ddof_vulkan_error(b->vk));
    b->frame->colors = kind.colors;
    b->kind = kind;
    return DDOF_OK;
}

/* The counters of the sprites, to the beginning of the slot's part of the staging buffer. */
static void copy_counters(const vulkan_backend *b, const slot *s) {
    static const VkMemoryBarrier to_copy = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
                                            .srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT,
                                            .dstAccessMask =
                                                VK_ACCESS_TRANSFER_READ_BIT | VK_ACCESS_TRANSFER_WRITE_BIT},
                                 to_host = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
                                            .srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT,
                                            .dstAccessMask = VK_ACCESS_HOST_READ_BIT};
    const VkBufferCopy region = {.dstOffset = s->offset, .size = sizeof(sprite_state)};
    b->f.CmdPipelineBarrier(s->commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT,
                            VK_PIPELINE_STAGE_TRANSFER_BIT, 0, 1, &to_copy, 0, NULL, 0, NULL);
    b->f.CmdCopyBuffer(s->commands, b->frame->scratch.buffer[BUFFER_SPRITE_STATE], b->pictures.buffer, 1, &region);
    b->f.CmdPipelineBarrier(s->commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &to_host, 0,
                            NULL, 0, NULL);
}

static void read_counters(const vulkan_backend *b, frame_job *job, const slot *s) {
    sprite_state state;
    memcpy(&state, s->memory, sizeof state);
    job->sprites = b->kind.sprites.quads == DDOF_QUADS_GEOMETRY ? state.draw.vertexCount : state.draw.instanceCount;
    job->sprites_dropped = state.dropped;
    job->sprites_large = state.large;
}

static ddof_status blur(vulkan_backend *b, frame_job *job, float gain) {
    static const VkPipelineStageFlags copy = VK_PIPELINE_STAGE_TRANSFER_BIT,
                                      compute = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT;
    static const transition in = {copy,
                                  compute,
                                  VK_ACCESS_TRANSFER_WRITE_BIT,
                                  VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT,
                                  VK_IMAGE_LAYOUT_GENERAL,
                                  VK_IMAGE_LAYOUT_GENERAL},
                            map = {copy,
                                   compute,
                                   VK_ACCESS_TRANSFER_WRITE_BIT,
                                   VK_ACCESS_SHADER_READ_BIT,
                                   VK_IMAGE_LAYOUT_GENERAL,
                                   VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL},
                            out = {compute,
                                   copy,
                                   VK_ACCESS_SHADER_WRITE_BIT,
                                   VK_ACCESS_TRANSFER_READ_BIT,
                                   VK_IMAGE_LAYOUT_GENERAL,
                                   VK_IMAGE_LAYOUT_GENERAL};
    const ddof_frame *f = job->frame;
    const ddof_vulkan_view view = {.picture_width = f->picture_width,
                                   .picture_height = f->picture_height,
                                   .offset_x = f->offset_x,
                                   .offset_y = f->offset_y,
                                   .pixel_aspect = f->pixel_aspect};
    ddof_settings settings = settings_of(job);
    if (job->highlights) settings.sprites.threshold = (double)bokeh_limits_of(job).threshold * (double)gain;
    ddof_vulkan_stats stats;
    slot *s;
    ddof_status status = vulkan_begin(b, &s);
    if (status != DDOF_OK) return status;
    vulkan_barrier(b, s, b->pictures.color, &in);
    vulkan_barrier(b, s, b->pictures.map, &map);
    status = ddof_vulkan_record(b->frame, s->commands, &view, &settings, &stats);
    if (status != DDOF_OK) {
        b->f.EndCommandBuffer(s->commands);
        return context_fail(b->owner, status, "%s", ddof_vulkan_frame_error(b->frame));
    }
    b->surface_bytes = stats.scratch_bytes;
    vulkan_barrier(b, s, b->pictures.color, &out);
    if (b->frame->sprites) copy_counters(b, s);
    status = vulkan_submit(b, s);
    if (status == DDOF_OK) status = vulkan_wait(b, s);
    if (status == DDOF_OK && b->frame->sprites) read_counters(b, job, s);
    return status;
}

static ddof_status diffuse_now(vulkan_backend *b, frame_job *job, staging *st) {
    const ddof_image *color = &job->frame->color;
    const bool half = job->settings->surface != DDOF_SURFACE_RGBA32F;
    ddof_status status = vulkan_pictures_make(b, color->width, color->height, half);
    if (status == DDOF_OK) status = make_frame(b, job);
    if (status != DDOF_OK) return status;
    /* the disc kernel's sources: a hole between sharp pixels is one of 1e-14 of its neighbours' colours */
    if (half || job->disc || job->settings->solver == DDOF_SOLVER_CR4_PACK) staging_find_gain(b->owner, job, st);
    status = vulkan_pictures_upload(b, job, st);
    if (status == DDOF_OK) status = blur(b, job, st->gain);
    if (status == DDOF_OK && b->owner->cancelled) status = DDOF_ERROR_CANCELLED;
    return status == DDOF_OK ? vulkan_pictures_download(b, job, st) : status;
}

/* ---- the device */

/* A GPU that hangs may still write to what it was given: then all of it is left to the process. */
static void shut(vulkan_backend *b) {
    if (b->session.device && !b->hung) {
        if (b->vk) {
            b->f.DeviceWaitIdle(b->session.device);
            vulkan_pictures_delete(b);
        }
        ddof_vulkan_destroy(&b->vk);
        for (int i = 0; i < SLOTS && b->f.DestroyFence; i++)
            b->f.DestroyFence(b->session.device, b->slot[i].fence, NULL);
        if (b->pool) b->f.DestroyCommandPool(b->session.device, b->pool, NULL);
        vulkan_close(&b->session);
    }
    vulkan_backend empty = {.owner = b->owner};
    memcpy(empty.name, b->name, sizeof empty.name); /* the caller's, until ddof_destroy() */
    *b = empty;
}

static ddof_status load_functions(vulkan_backend *b) {
#define X(function)                                                                                                    \
    b->f.function = (PFN_vk##function)vulkan_function(&b->session, "vk" #function);                                    \
    if (!b->f.function)                                                                                                \
        return context_fail(b->owner, DDOF_ERROR_UNSUPPORTED, "the Vulkan driver (%s) has no vk" #function, b->name);
    BACKEND_FUNCTIONS(X)
#undef X
    return DDOF_OK;
}

static ddof_status make_slots(vulkan_backend *b) {
    static const char doing[] = "starting";
    const VkCommandPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                          .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
                                          .queueFamilyIndex = b->session.family};
    const VkFenceCreateInfo fence = {.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    ddof_status status = vulkan_check(b, b->f.CreateCommandPool(b->session.device, &pool, NULL, &b->pool), doing);
    for (int i = 0; i < SLOTS && status == DDOF_OK; i++) {
        const VkCommandBufferAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                                  .commandPool = b->pool,
                                                  .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                                  .commandBufferCount = 1};
        status = vulkan_check(b, b->f.AllocateCommandBuffers(b->session.device, &info, &b->slot[i].commands), doing);
        if (status == DDOF_OK)
            status = vulkan_check(b, b->f.CreateFence(b->session.device, &fence, NULL, &b->slot[i].fence), doing);
    }
    return status;
}

static ddof_status start(vulkan_backend *b) {
    const ddof_config *c = &b->owner->config;
    ddof_status status;
    if (!vulkan_open(&b->session, c->device, &status, b->text, sizeof b->text))
        return context_fail(b->owner, status, "%s", b->text);
    snprintf(b->name, sizeof b->name, "%s", b->session.properties.deviceName);
    status = load_functions(b);
    if (status == DDOF_OK) status = make_slots(b);
    if (status == DDOF_OK) {
        const ddof_vulkan_config config = {.instance = b->session.instance,
                                           .physical_device = b->session.physical_device,
                                           .device = b->session.device,
                                           .queue_family = b->session.family,
                                           .get_instance_proc_addr = b->session.get_instance_proc_addr,
                                           .features = &b->session.features,
                                           .allocate = c->allocate,
                                           .release = c->release,
                                           .memory_user = c->memory_user,
                                           .log = keep_text,
                                           .log_user = b};
        status = ddof_vulkan_create(&b->vk, &config);
        if (status != DDOF_OK) context_fail(b->owner, status, "%s", b->text);
    }
    if (status != DDOF_OK) shut(b);
    return status;
}

/* ---- the stages of the backend */

static ddof_status vulkan_backend_open(ddof_context *ctx) {
    vulkan_backend *b = ctx->config.allocate(ctx->config.memory_user, sizeof *b);
    if (!b) return context_fail(ctx, DDOF_ERROR_MEMORY, "out of memory for the Vulkan backend");
    *b = (vulkan_backend){.owner = ctx};
    ddof_status status = start(b);
    if (status == DDOF_OK)
        ctx->device = b;
    else
        ctx->config.release(ctx->config.memory_user, b);
    return status;
}

static void vulkan_backend_close(ddof_context *ctx) {
    vulkan_backend *b = ctx->device;
    if (!b) return;
    shut(b);
    ctx->config.release(ctx->config.memory_user, b);
    ctx->device = NULL;
}

static void vulkan_backend_trim(ddof_context *ctx) {
    vulkan_backend *b = ctx->device;
    if (b->vk) vulkan_pictures_delete(b);
}

/* Whether work may still be under way, for a wait for it failed. */
static bool unsettled(const vulkan_backend *b) {
    bool pending = false;
    for (int i = 0; i < SLOTS; i++)
        pending = pending || b->slot[i].pending;
    return pending;
}

/* A device that was lost, is out of its memory, or cannot be waited for is closed at once; the next frame opens it
 * anew. */
static ddof_status vulkan_diffuse(ddof_context *ctx, frame_job *job, void *scratch) {
    vulkan_backend *b = ctx->device;
    staging st = staging_lay_out(job, scratch);
    ctx->progress_total = 2.0 * job->frame->color.height;
    ddof_status status = b->vk ? DDOF_OK : start(b);
    if (status != DDOF_OK) return status;
    status = diffuse_now(b, job, &st);
    const ddof_status settled = settle(b);
    if (status == DDOF_OK || settled == DDOF_ERROR_DEVICE) status = settled;
    if (status == DDOF_ERROR_DEVICE || unsettled(b)) shut(b);
    return status;
}

static size_t vulkan_surface_bytes(const ddof_context *ctx) {
    return ((const vulkan_backend *)ctx->device)->surface_bytes;
}

static const char *vulkan_device(const ddof_context *ctx) {
    return ((const vulkan_backend *)ctx->device)->name;
}

const backend backend_vulkan = {
    .id = DDOF_BACKEND_VULKAN,
    .disc = true,
    .scratch_bytes = staging_bytes,
    .coc = staging_coc,
    .diffuse = vulkan_diffuse,
    .sprites = vulkan_diffuse,
    .device = vulkan_device,
    .open = vulkan_backend_open,
    .close = vulkan_backend_close,
    .trim = vulkan_backend_trim,
    .surface_bytes = vulkan_surface_bytes,
    .list = vulkan_list,
};
