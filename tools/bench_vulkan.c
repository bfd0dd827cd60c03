/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "bench_vulkan.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench_vulkan_memory.h"
#include "format.h"

enum { COLOR, MAP, OUTPUT, IMAGES };

/* Command buffers: one for uploads, one for the copy, then those of the solvers. */
enum { UPLOAD, COPY, SOLVE, COMMANDS = SOLVE + BENCH_VULKAN_SLOTS };

/* Timestamps: at both ends, and those of ddof_vulkan_frame_timestamps(). */
enum { FROM, TO, SPRITES, QUERIES = SPRITES + 4 };

enum {
    STAGING_BYTES = 32 << 20,
    COPY_BYTES = 256 << 20 /* of each of the two buffers of the copy: far beyond any cache, within any device */
};

struct bench_vulkan {
    bench_device device;
    ddof_vulkan *renderer;
    ddof_vulkan_frame *frame[BENCH_VULKAN_SLOTS];
    VkCommandPool pool;
    VkCommandBuffer commands[COMMANDS];
    VkQueryPool queries;       /* timestamps; VK_NULL_HANDLE: the queue has none */
    uint64_t timestamp_mask;   /* the bits that count */
    bench_image image[IMAGES]; /* OUTPUT: none when the blur is in place */
    bench_buffer staging, from, to;
    const scene *scene;
    bool in_place;
    char said[512];
};

/* ------------------------------------------------------------------------- life */

static void on_log(void *user, ddof_log_level level, const char *text) {
    bench_vulkan *vk = user;
    if (level == DDOF_LOG_ERROR) snprintf(vk->said, sizeof vk->said, "%s", text);
}

static const char *said_by_library(bench_vulkan *vk, ddof_status status) {
    if (status == DDOF_OK) return NULL;
    const char *text = vk->renderer ? ddof_vulkan_error(vk->renderer) : vk->said;
    if (text != vk->said || !*text) snprintf(vk->said, sizeof vk->said, "%s", *text ? text : ddof_status_text(status));
    return vk->said;
}

static const char *create_queries(bench_vulkan *vk) {
    bench_device *d = &vk->device;
    enum { FAMILIES = 64 };
    VkQueueFamilyProperties family[FAMILIES];
    uint32_t count = FAMILIES;
    d->GetPhysicalDeviceQueueFamilyProperties(d->session.physical_device, &count, family);
    const uint32_t bits = d->session.family < count ? family[d->session.family].timestampValidBits : 0;
    if (bits == 0) return NULL;
    vk->timestamp_mask = bits >= 64 ? UINT64_MAX : (UINT64_C(1) << bits) - 1;
    const VkQueryPoolCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO, .queryType = VK_QUERY_TYPE_TIMESTAMP, .queryCount = QUERIES};
    return bench_result(d, d->CreateQueryPool(d->session.device, &info, NULL, &vk->queries), "vkCreateQueryPool");
}

static const char *create_commands(bench_vulkan *vk) {
    bench_device *d = &vk->device;
    const VkCommandPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                          .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
                                          .queueFamilyIndex = d->session.family};
    const char *bad =
        bench_result(d, d->CreateCommandPool(d->session.device, &pool, NULL, &vk->pool), "vkCreateCommandPool");
    if (bad) return bad;
    const VkCommandBufferAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                              .commandPool = vk->pool,
                                              .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                              .commandBufferCount = COMMANDS};
    return bench_result(d, d->AllocateCommandBuffers(d->session.device, &info, vk->commands),
                        "vkAllocateCommandBuffers");
}

bench_vulkan *bench_vulkan_open(int device, ddof_status *status, char *why, size_t size) {
    bench_vulkan *vk = calloc(1, sizeof *vk);
    *status = DDOF_ERROR_MEMORY;
    if (!vk) {
        snprintf(why, size, "out of memory");
        return NULL;
    }
    bench_device *d = &vk->device;
    if (bench_device_open(d, device, status, why, size)) {
        const ddof_vulkan_config config = {.instance = d->session.instance,
                                           .physical_device = d->session.physical_device,
                                           .device = d->session.device,
                                           .queue_family = d->session.family,
                                           .get_instance_proc_addr = d->session.get_instance_proc_addr,
                                           .features = &d->session.features,
                                           .log = on_log,
                                           .log_user = vk};
        *status = ddof_vulkan_create(&vk->renderer, &config);
        const char *bad = said_by_library(vk, *status);
        if (!bad) *status = DDOF_ERROR_DEVICE;
        if (!bad) bad = create_commands(vk);
        if (!bad) bad = create_queries(vk);
        if (!bad) {
            *status = DDOF_OK;
            return vk;
        }
        snprintf(why, size, "%s", bad);
    }
    bench_vulkan_close(&vk);
    return NULL;
}

static void destroy_picture(bench_vulkan *vk) {
    bench_device *d = &vk->device;
    for (int i = 0; i < BENCH_VULKAN_SLOTS; i++)
        ddof_vulkan_frame_destroy(&vk->frame[i]);
    for (int i = 0; i < IMAGES; i++)
        bench_image_destroy(d, &vk->image[i]);
    bench_buffer_destroy(d, &vk->staging);
    bench_buffer_destroy(d, &vk->from);
    bench_buffer_destroy(d, &vk->to);
}

void bench_vulkan_close(bench_vulkan **made) {
    bench_vulkan *vk = *made;
    if (!vk) return;
    bench_device *d = &vk->device;
    if (d->open && d->fence) {
        destroy_picture(vk);
        ddof_vulkan_destroy(&vk->renderer);
        if (vk->queries) d->DestroyQueryPool(d->session.device, vk->queries, NULL);
        if (vk->pool) d->DestroyCommandPool(d->session.device, vk->pool, NULL);
    }
    bench_device_close(d);
    free(vk);
    *made = NULL;
}

bool bench_vulkan_has_timestamps(const bench_vulkan *vk) {
    return vk->queries != VK_NULL_HANDLE;
}

/* ------------------------------------------------------------------------- upload */

/* Row y of the scene as the texels of an image; `row` has room for 8 floats per pixel. */
static void convert_row(const scene *s, int which, const bench_image *image, int y, float *row, void *texels) {
    const size_t width = (size_t)s->width, channels = which == MAP ? 1 : (size_t)s->channels;
    const size_t first = (size_t)y * width * channels, count = width * channels;
    const bool half = image->format == VK_FORMAT_R16G16B16A16_SFLOAT || image->format == VK_FORMAT_R16_SFLOAT;
    float *values = row, *padded = row + 4 * width;
    if (which == MAP)
        memcpy(values, s->blur + first, count * sizeof *values);
    else if (s->type == DDOF_HALF)
        io_half_to_float((const uint16_t *)s->color + first, values, count, 1);
    else
        memcpy(values, (const float *)s->color + first, count * sizeof *values);
    if (channels == 3) {
        for (size_t x = 0; x < width; x++) {
            memcpy(padded + 4 * x, values + 3 * x, 3 * sizeof *values);
            padded[4 * x + 3] = 1;
        }
        values = padded;
    }
    const size_t numbers = width * (which == MAP ? 1 : 4);
    if (half)
        io_float_to_half(values, texels, numbers, 1);
    else
        memcpy(texels, values, numbers * sizeof *values);
}

static void change_layout(const bench_vulkan *vk, const bench_image *image, VkImageLayout from, VkImageLayout to) {
    const VkImageMemoryBarrier barrier = {.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER,
                                          .srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT,
                                          .dstAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT | VK_ACCESS_SHADER_READ_BIT |
                                                           VK_ACCESS_SHADER_WRITE_BIT,
                                          .oldLayout = from,
                                          .newLayout = to,
                                          .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                          .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                          .image = image->image,
                                          .subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1}};
    const VkPipelineStageFlags both = VK_PIPELINE_STAGE_TRANSFER_BIT | VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT;
    vk->device.CmdPipelineBarrier(vk->commands[UPLOAD], VK_PIPELINE_STAGE_TRANSFER_BIT, both, 0, 0, NULL, 0, NULL, 1,
                                  &barrier);
}

/* Rows first to first + count - 1, which lie in the staging buffer. */
static const char *upload_rows(bench_vulkan *vk, const bench_image *image, int first, int count, VkImageLayout after) {
    bench_device *d = &vk->device;
    const VkCommandBuffer commands = vk->commands[UPLOAD];
    const VkImageLayout during = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;
    const VkBufferImageCopy region = {.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1},
                                      .imageOffset = {0, first, 0},
                                      .imageExtent = {image->width, (uint32_t)count, 1}};
    double ignored;
    const char *bad = bench_begin(d, commands);
    if (bad) return bad;
    change_layout(vk, image, first == 0 ? VK_IMAGE_LAYOUT_UNDEFINED : during, during);
    d->CmdCopyBufferToImage(commands, vk->staging.buffer, image->image, during, 1, &region);
    if (first + count == (int)image->height) change_layout(vk, image, during, after);
    bad = bench_result(d, d->EndCommandBuffer(commands), "vkEndCommandBuffer");
    return bad ? bad : bench_submit(d, commands, &ignored);
}

static const char *upload(bench_vulkan *vk, int which, const scene *s, VkImageLayout after) {
    const bench_image *image = &vk->image[which];
    const size_t row_bytes = image->texel * image->width;
    const int most = (int)(vk->staging.size / row_bytes);
    float *row = malloc((size_t)s->width * 8 * sizeof *row);
    if (!row) return bench_result(&vk->device, VK_ERROR_OUT_OF_HOST_MEMORY, "upload");
    const char *bad = NULL;
    for (int y = 0; !bad && y < s->height; y += most) {
        const int count = s->height - y < most ? s->height - y : most;
        for (int i = 0; i < count; i++)
            convert_row(s, which, image, y + i, row, (char *)vk->staging.mapped + row_bytes * (size_t)i);
        bad = upload_rows(vk, image, y, count, after);
    }
    free(row);
    return bad;
}

/* ------------------------------------------------------------------------- picture */

static const char *create_images(bench_vulkan *vk, const scene *s, ddof_surface surface) {
    const bool full = surface == DDOF_SURFACE_RGBA32F, half_map = s->type == DDOF_HALF;
    const VkFormat color = full ? VK_FORMAT_R32G32B32A32_SFLOAT : VK_FORMAT_R16G16B16A16_SFLOAT;
    const VkImageUsageFlags input = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT,
                            output = input | VK_IMAGE_USAGE_STORAGE_BIT;
    const uint32_t width = (uint32_t)s->width, height = (uint32_t)s->height;
    const size_t texel = full ? 16 : 8;
    vk->image[COLOR] = (bench_image){.format = color, .texel = texel, .usage = s->in_place ? output : input};
    vk->image[MAP] = (bench_image){
        .format = half_map ? VK_FORMAT_R16_SFLOAT : VK_FORMAT_R32_SFLOAT, .texel = half_map ? 2 : 4, .usage = input};
    vk->image[OUTPUT] = (bench_image){.format = color, .texel = texel, .usage = output};
    const char *bad = NULL;
    for (int i = 0; !bad && i < (s->in_place ? OUTPUT : IMAGES); i++) {
        vk->image[i].width = width;
        vk->image[i].height = height;
        bad = bench_image_create(&vk->device, &vk->image[i]);
    }
    return bad;
}

static const char *upload_all(bench_vulkan *vk, const scene *s) {
    const size_t row = vk->image[COLOR].texel * (size_t)s->width, all = row * (size_t)s->height;
    const size_t room = all < STAGING_BYTES ? all : row > STAGING_BYTES ? row : STAGING_BYTES;
    const VkImageLayout sampled = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, general = VK_IMAGE_LAYOUT_GENERAL;
    const char *bad = bench_buffer_create(&vk->device, &vk->staging, room, true);
    if (!bad) bad = upload(vk, COLOR, s, s->in_place ? general : sampled);
    if (!bad) bad = upload(vk, MAP, s, sampled);
    /* the result too: the first use of memory must not be timed; what is in it does not matter */
    if (!bad && !s->in_place) bad = upload(vk, OUTPUT, s, general);
    bench_buffer_destroy(&vk->device, &vk->staging);
    return bad;
}

/* ------------------------------------------------------------------------- commands that are timed */

static const char *begin_timed(bench_vulkan *vk, VkCommandBuffer commands, VkPipelineStageFlags stage,
                               VkAccessFlags access) {
    bench_device *d = &vk->device;
    const char *bad = bench_begin(d, commands);
    if (bad) return bad;
    if (vk->queries) d->CmdResetQueryPool(commands, vk->queries, 0, QUERIES);
    bench_barrier(d, commands, stage | VK_PIPELINE_STAGE_TRANSFER_BIT,
                  VK_ACCESS_TRANSFER_WRITE_BIT | (access & VK_ACCESS_SHADER_WRITE_BIT), stage, access);
    if (vk->queries) d->CmdWriteTimestamp(commands, VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT, vk->queries, FROM);
    return NULL;
}

static const char *end_timed(bench_vulkan *vk, VkCommandBuffer commands) {
    bench_device *d = &vk->device;
    if (vk->queries) d->CmdWriteTimestamp(commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, vk->queries, TO);
    return bench_result(d, d->EndCommandBuffer(commands), "vkEndCommandBuffer");
}

/* ms: between `count` timestamps, from `first` on. */
static const char *read_times(bench_vulkan *vk, uint32_t first, uint32_t count, double *ms) {
    bench_device *d = &vk->device;
    uint64_t ticks[QUERIES];
    const char *bad =
        bench_result(d,
                     d->GetQueryPoolResults(d->session.device, vk->queries, first, count, sizeof ticks, ticks,
                                            sizeof *ticks, VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT),
                     "vkGetQueryPoolResults");
    for (uint32_t i = 0; !bad && i + 1 < count; i++)
        ms[i] = (double)((ticks[i + 1] - ticks[i]) & vk->timestamp_mask) *
                (double)d->session.properties.limits.timestampPeriod * 1e-6;
    return bad;
}

static const char *run_timed(bench_vulkan *vk, VkCommandBuffer commands, double *ms) {
    const char *bad = bench_submit(&vk->device, commands, ms);
    return bad || !vk->queries ? bad : read_times(vk, FROM, TO - FROM + 1, ms);
}

/* The buffers are filled once, so that their memory is there; then `bytes` of one go to the other, in several pieces
 * where they are smaller than that. */
static const char *record_copy(bench_vulkan *vk, VkDeviceSize bytes) {
    bench_device *d = &vk->device;
    const VkCommandBuffer commands = vk->commands[COPY];
    const VkPipelineStageFlags transfer = VK_PIPELINE_STAGE_TRANSFER_BIT;
    const VkAccessFlags access = VK_ACCESS_TRANSFER_READ_BIT | VK_ACCESS_TRANSFER_WRITE_BIT;
    const VkDeviceSize room = bytes < COPY_BYTES ? (bytes + 3) / 4 * 4 : COPY_BYTES;
    double ignored;
    const char *bad = bench_buffer_create(d, &vk->from, room, false);
    if (!bad) bad = bench_buffer_create(d, &vk->to, room, false);
    if (!bad) bad = bench_begin(d, commands);
    if (bad) return bad;
    d->CmdFillBuffer(commands, vk->from.buffer, 0, VK_WHOLE_SIZE, 0x3c003c00);
    d->CmdFillBuffer(commands, vk->to.buffer, 0, VK_WHOLE_SIZE, 0);
    bad = bench_result(d, d->EndCommandBuffer(commands), "vkEndCommandBuffer");
    if (!bad) bad = bench_submit(d, commands, &ignored);
    if (!bad) bad = begin_timed(vk, commands, transfer, access);
    if (bad) return bad;
    for (VkDeviceSize done = 0; done < bytes; done += room) {
        const VkBufferCopy region = {.size = bytes - done < room ? bytes - done : room};
        if (done > 0) bench_barrier(d, commands, transfer, access, transfer, access);
        d->CmdCopyBuffer(commands, vk->from.buffer, vk->to.buffer, 1, &region);
    }
    return end_timed(vk, commands);
}

/* ------------------------------------------------------------------------- for the bench */

const char *bench_vulkan_picture(bench_vulkan *vk, const scene *s, ddof_surface surface, double *moved) {
    const uint32_t most = vk->device.session.properties.limits.maxImageDimension2D;
    destroy_picture(vk);
    vk->scene = s;
    vk->in_place = s->in_place;
    if ((uint32_t)s->width > most || (uint32_t)s->height > most) {
        snprintf(vk->said, sizeof vk->said, "images of this device have at most %u pixels a side; make --size smaller",
                 (unsigned)most);
        return vk->said;
    }
    const char *bad = create_images(vk, s, surface);
    if (!bad) bad = upload_all(vk, s);
    if (bad) return bad;
    /* both directions of a substep read colour and CoC and write colour */
    const size_t per_pixel = 2 * (2 * vk->image[COLOR].texel + vk->image[MAP].texel);
    const double pixels = (double)s->width * s->height;
    *moved = pixels * (double)per_pixel * s->settings.substeps;
    return record_copy(vk, (VkDeviceSize)(*moved / 2));
}

static ddof_vulkan_image describe(const bench_image *image) {
    return (ddof_vulkan_image){.image = image->image,
                               .format = image->format,
                               .width = image->width,
                               .height = image->height,
                               .usage = image->usage};
}

static const char *record_solve(bench_vulkan *vk, int slot, const ddof_settings *settings, ddof_vulkan_stats *stats) {
    const VkCommandBuffer commands = vk->commands[SOLVE + slot];
    const VkAccessFlags access = VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT;
    const char *bad = begin_timed(vk, commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, access);
    if (!bad) bad = said_by_library(vk, ddof_vulkan_record(vk->frame[slot], commands, NULL, settings, stats));
    return bad ? bad : end_timed(vk, commands);
}

const char *bench_vulkan_prepare(bench_vulkan *vk, int slot, const ddof_settings *settings, bench_vulkan_plan *plan) {
    ddof_vulkan_images images = {.color = describe(&vk->image[COLOR]),
                                 .output = describe(&vk->image[vk->in_place ? COLOR : OUTPUT]),
                                 .channels = vk->scene->channels};
    *(vk->scene->depth ? &images.depth : &images.coc) = describe(&vk->image[MAP]);
    ddof_vulkan_stats stats;
    ddof_vulkan_frame_destroy(&vk->frame[slot]);
    const char *bad = said_by_library(vk, ddof_vulkan_frame_create(vk->renderer, &vk->frame[slot], &images, settings));
    if (!bad && vk->queries && (settings->bokeh || settings->method == DDOF_METHOD_SCATTER))
        bad = said_by_library(vk, ddof_vulkan_frame_timestamps(vk->frame[slot], vk->queries, SPRITES));
    if (!bad) bad = record_solve(vk, slot, settings, &stats);
    if (bad) return bad;
    *plan = (bench_vulkan_plan){.solver = stats.solver,
                                .scratch_bytes = stats.scratch_bytes,
                                .dispatches = stats.dispatches,
                                .pixels_per_thread = stats.pixels_per_thread,
                                .workgroup = stats.workgroup,
                                .strip = stats.strip,
                                .subgroup = stats.subgroup};
    return NULL;
}

const char *bench_vulkan_solve(bench_vulkan *vk, int slot, double *ms) {
    return run_timed(vk, vk->commands[SOLVE + slot], ms);
}

const char *bench_vulkan_sprites(bench_vulkan *vk, bench_vulkan_times *times) {
    double ms[QUERIES - SPRITES - 1];
    const char *bad = read_times(vk, SPRITES, QUERIES - SPRITES, ms);
    if (!bad) *times = (bench_vulkan_times){ms[0], ms[1]};
    return bad;
}

const char *bench_vulkan_copy(bench_vulkan *vk, double *ms) {
    return run_timed(vk, vk->commands[COPY], ms);
}
