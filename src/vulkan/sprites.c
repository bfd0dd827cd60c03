/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "sprites.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#include "../bokeh.h"
#include "../cpu/kernels.h"

enum {
    SIDE = 8,       /* pixels of a workgroup of the passes over the picture */
    HISTOGRAM = 32, /* likewise, of the histogram */
    THREADS = 64,   /* of a workgroup of the pass over the sprites */
    UPDATE = 65536  /* bytes that a command writes at most */
};

/* ---- the iris */

static void fill_tables(vulkan_sprites *s) {
    const iris_shape *shape = &s->iris.shape;
    sprite_tables *t = &s->tables;
    *t = (sprite_tables){.kind = shape->kind,
                         .blades = (float)shape->blades,
                         .curvature = shape->curvature,
                         .edge = shape->edge,
                         .squeeze = shape->squeeze,
                         .aspect = shape->aspect,
                         .reach = s->iris.reach,
                         .turn = {shape->cosine, shape->sine}};
    memcpy(t->diameter, s->iris.diameter, sizeof t->diameter);
    memcpy(t->inverse_sum, s->iris.inverse_sum, sizeof t->inverse_sum);
    memcpy(t->cats_gain, s->iris.cats_gain, sizeof t->cats_gain);
    if (shape->kind == DDOF_IRIS_IMAGE) memcpy(t->texel, s->iris.texel, sizeof t->texel);
}

/* What does not depend on the iris alone. */
static void fill_places(const ddof_vulkan_frame *f, const frame_job *job) {
    const ddof_frame *frame = job->frame;
    const iris_shape *shape = &f->sprites->iris.shape;
    const double width = frame->picture_width ? frame->picture_width : frame->color.width;
    const double height = frame->picture_width ? frame->picture_height : frame->color.height;
    sprite_tables *t = &f->sprites->tables;
    t->cats_eye = shape->cats_eye;
    t->fringe = f->colors > 2 ? shape->fringe : 0;
    t->middle[0] = (float)(0.5 * (width - 1) - frame->offset_x);
    t->middle[1] = (float)(0.5 * (height - 1) - frame->offset_y);
    t->per_diagonal = (float)(2 / hypot(width, height / job->pixel_aspect));
}

ddof_status vulkan_sprites_prepare(ddof_vulkan_frame *f, const frame_job *job) {
    vulkan_sprites *s = f->sprites;
    if (!iris_make(&s->iris, &job->settings->iris, job->pixel_aspect, cpu_kernels_baseline.sprites))
        return context_fail(&f->shell, DDOF_ERROR_INVALID,
                            "settings.iris.image lets no light through: all of it is 0, below, or not a number");
    fill_tables(s);
    fill_places(f, job);
    return DDOF_OK;
}

/* ---- commands */

typedef struct recording {
    const ddof_vulkan_frame *frame;
    VkCommandBuffer commands;
    sprite_push push;
    int dispatches;
} recording;

static recording begin(const ddof_vulkan_frame *f, VkCommandBuffer commands, const frame_job *job,
                       const vulkan_region *region) {
    const bokeh_limits limits = bokeh_limits_of(job);
    const bool full = f->sprite_kind.bokeh == DDOF_BOKEH_FULL;
    const VkExtent2D target = vulkan_light_size_of(&f->sprite_kind, region->width, region->height);
    const double area = fmin(floor(limits.max_area * 16), 0x1p62);
    const uint64_t most_area = (uint64_t)area;
    return (recording){
        .frame = f,
        .commands = commands,
        .push = {.picture = vulkan_picture_push_of(f, job, region),
                 .width = region->width,
                 .height = region->height,
                 .target_width = (int32_t)target.width,
                 .part_height = (int32_t)(full ? target.height / 2 : target.height),
                 .levels = bokeh_level(iris_node(limits.largest), limits.half) + 1,
                 .colors = f->colors,
                 .threshold = limits.threshold,
                 .largest = limits.largest,
                 .most = full ? (uint32_t)region->width * (uint32_t)region->height : (uint32_t)limits.max_sprites,
                 .most_area_low = (uint32_t)most_area,
                 .most_area_high = (uint32_t)(most_area >> 32)}};
}

static void order(const recording *r, VkPipelineStageFlags2 from_stage, VkAccessFlags2 from,
                  VkPipelineStageFlags2 to_stage, VkAccessFlags2 to) {
    const VkMemoryBarrier2 memory = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
                                     .srcStageMask = from_stage,
                                     .srcAccessMask = from,
                                     .dstStageMask = to_stage,
                                     .dstAccessMask = to};
    const VkDependencyInfo info = {
        .sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO, .memoryBarrierCount = 1, .pMemoryBarriers = &memory};
    r->frame->vk->f.CmdPipelineBarrier2(r->commands, &info);
}

static const VkPipelineStageFlags2 COMPUTE = VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
                                   COPY = VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT;
static const VkAccessFlags2 READ = VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_SAMPLED_READ_BIT,
                            WRITE = VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT;

static void bind(const recording *r, VkPipelineBindPoint point, sprite_pass pass) {
    const vulkan_functions *v = &r->frame->vk->f;
    const vulkan_sprites *s = r->frame->sprites;
    v->CmdBindPipeline(r->commands, point, s->pipeline[pass]);
    v->CmdBindDescriptorSets(r->commands, point, s->layout, 0, 1, &s->set, 0, NULL);
    v->CmdPushConstants(r->commands, s->layout, s->stages, 0, sizeof r->push, &r->push);
}

/* Every pass but the first waits for the one before. */
static void dispatch(recording *r, sprite_pass pass, int x, int y) {
    if (r->dispatches++ > 0) order(r, COMPUTE, WRITE, COMPUTE, READ | WRITE);
    bind(r, VK_PIPELINE_BIND_POINT_COMPUTE, pass);
    r->frame->vk->f.CmdDispatch(r->commands, (uint32_t)x, (uint32_t)y, 1);
}

static void over_picture(recording *r, sprite_pass pass) {
    const int side = pass == SPRITES_HISTOGRAM ? HISTOGRAM : SIDE;
    dispatch(r, pass, (r->push.width + side - 1) / side, (r->push.height + side - 1) / side);
}

static void mark(const recording *r, uint32_t which) {
    const vulkan_sprites *s = r->frame->sprites;
    if (s->timestamps)
        r->frame->vk->f.CmdWriteTimestamp(r->commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, s->timestamps,
                                          s->first_timestamp + which);
}

static void update(const recording *r, VkBuffer buffer, VkDeviceSize from, VkDeviceSize to, const void *data) {
    for (VkDeviceSize at = from; at < to; at += UPDATE)
        r->frame->vk->f.CmdUpdateBuffer(r->commands, buffer, at, to - at < UPDATE ? to - at : UPDATE,
                                        (const char *)data + at);
}

/* Counters to 0, and the iris to where shaders read it. What used them before has been waited for by compute alone. */
static void write_buffers(const recording *r) {
    const ddof_vulkan_frame *f = r->frame;
    const VkBuffer state = f->scratch.buffer[BUFFER_SPRITE_STATE];
    const bool points = f->sprite_kind.quads == DDOF_QUADS_GEOMETRY, image = f->sprites->tables.kind == DDOF_IRIS_IMAGE;
    const sprite_state fresh = {.draw = {.vertexCount = points ? 0 : 4, .instanceCount = points ? 1 : 0}};
    order(r, COMPUTE, 0, COPY, VK_ACCESS_2_TRANSFER_WRITE_BIT);
    update(r, state, 0, sizeof fresh, &fresh);
    f->vk->f.CmdFillBuffer(r->commands, state, sizeof fresh, VK_WHOLE_SIZE, 0);
    update(r, f->scratch.buffer[BUFFER_SPRITE_TABLES], 0,
           image ? sizeof(sprite_tables) : offsetof(sprite_tables, texel), &f->sprites->tables);
    order(r, COPY, VK_ACCESS_2_TRANSFER_WRITE_BIT, COMPUTE, READ | WRITE);
}

/* The counter of the sprites to the arguments of their draw. */
static void copy_count(const recording *r) {
    const ddof_vulkan_frame *f = r->frame;
    const VkBuffer state = f->scratch.buffer[BUFFER_SPRITE_STATE];
    const bool points = f->sprite_kind.quads == DDOF_QUADS_GEOMETRY;
    const VkBufferCopy region = {offsetof(sprite_state, count),
                                 points ? offsetof(sprite_state, draw.vertexCount)
                                        : offsetof(sprite_state, draw.instanceCount),
                                 sizeof(uint32_t)};
    order(r, COMPUTE, WRITE, COPY, VK_ACCESS_2_TRANSFER_READ_BIT | VK_ACCESS_2_TRANSFER_WRITE_BIT);
    f->vk->f.CmdCopyBuffer(r->commands, state, state, 1, &region);
}

static void draw(const recording *r) {
    const ddof_vulkan_frame *f = r->frame;
    const vulkan_functions *v = &f->vk->f;
    static const VkClearValue black[2];
    const VkExtent2D size = vulkan_light_size_of(&f->sprite_kind, r->push.width, r->push.height);
    const VkRenderPassBeginInfo info = {.sType = VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO,
                                        .renderPass = f->sprites->render_pass,
                                        .framebuffer = f->sprites->framebuffer,
                                        .renderArea.extent = size,
                                        .clearValueCount = 2,
                                        .pClearValues = black};
    const VkViewport viewport = {.width = (float)size.width, .height = (float)size.height, .maxDepth = 1};
    v->CmdBeginRenderPass(r->commands, &info, VK_SUBPASS_CONTENTS_INLINE);
    bind(r, VK_PIPELINE_BIND_POINT_GRAPHICS, SPRITES_DRAW);
    v->CmdSetViewport(r->commands, 0, 1, &viewport);
    v->CmdSetScissor(r->commands, 0, 1, &info.renderArea);
    v->CmdDrawIndirect(r->commands, f->scratch.buffer[BUFFER_SPRITE_STATE], 0, 1, sizeof(VkDrawIndirectCommand));
    v->CmdEndRenderPass(r->commands);
}

int vulkan_sprites_draw(const ddof_vulkan_frame *f, VkCommandBuffer commands, const frame_job *job,
                        const vulkan_region *region) {
    recording r = begin(f, commands, job, region);
    const bool full = f->sprite_kind.bokeh == DDOF_BOKEH_FULL;
    write_buffers(&r);
    mark(&r, 0);
    if (!full) {
        over_picture(&r, SPRITES_HISTOGRAM);
        dispatch(&r, SPRITES_RAISE, 1, 1);
    }
    over_picture(&r, SPRITES_APPEND);
    if (f->sprites->pipeline[SPRITES_TAKE])
        dispatch(&r, SPRITES_TAKE, (f->sprite_kind.most + THREADS - 1) / THREADS, 1);
    if (f->sprite_kind.append == DDOF_APPEND_COUNTER) copy_count(&r);
    mark(&r, 1);
    draw(&r);
    mark(&r, 2);
    return r.dispatches;
}

int vulkan_sprites_resolve(const ddof_vulkan_frame *f, VkCommandBuffer commands, const frame_job *job,
                           const vulkan_region *region) {
    recording r = begin(f, commands, job, region);
    order(&r, COMPUTE | COPY, WRITE, COMPUTE, READ | WRITE); /* after it, compute alone has to be waited for */
    over_picture(&r, SPRITES_RESOLVE);
    mark(&r, 3);
    return r.dispatches;
}
