/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Two bands of rows are under way at a time, so that the CPU converts one while the GPU copies the other. */
#include <string.h>

#include "../cpu/kernels.h"
#include "backend.h"

enum { BAND_BYTES = 4 << 20 };

/* ---- the pictures */

void vulkan_pictures_delete(vulkan_backend *b) {
    vulkan_pictures *p = &b->pictures;
    ddof_vulkan_frame_destroy(&b->frame);
    b->surface_bytes = 0;
    b->f.DestroyImage(b->session.device, p->color, NULL);
    b->f.DestroyImage(b->session.device, p->map, NULL);
    b->f.DestroyBuffer(b->session.device, p->buffer, NULL);
    for (int i = 0; i < 3; i++)
        b->f.FreeMemory(b->session.device, p->memory[i], NULL);
    *p = (vulkan_pictures){0};
}

/* Memory for an image or a buffer. */
static ddof_status allocate(vulkan_backend *b, const VkMemoryRequirements *needs, VkMemoryPropertyFlags wanted,
                            VkMemoryPropertyFlags liked, VkDeviceMemory *memory) {
    static const char doing[] = "making room for the picture";
    const VkPhysicalDeviceMemoryProperties *m = &b->session.memory;
    const uint32_t type = vulkan_memory_type(m, needs->memoryTypeBits, wanted, liked);
    if (type == UINT32_MAX || needs->size > m->memoryHeaps[m->memoryTypes[type].heapIndex].size)
        return vulkan_check(b, VK_ERROR_OUT_OF_DEVICE_MEMORY, doing);
    const VkMemoryAllocateInfo info = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, .allocationSize = needs->size, .memoryTypeIndex = type};
    return vulkan_check(b, b->f.AllocateMemory(b->session.device, &info, NULL, memory), doing);
}

static VkImageCreateInfo image_info(int width, int height, VkFormat format, VkImageUsageFlags usage) {
    return (VkImageCreateInfo){.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                               .imageType = VK_IMAGE_TYPE_2D,
                               .format = format,
                               .extent = {(uint32_t)width, (uint32_t)height, 1},
                               .mipLevels = 1,
                               .arrayLayers = 1,
                               .samples = VK_SAMPLE_COUNT_1_BIT,
                               .tiling = VK_IMAGE_TILING_OPTIMAL,
                               .usage = usage,
                               .sharingMode = VK_SHARING_MODE_EXCLUSIVE,
                               .initialLayout = VK_IMAGE_LAYOUT_UNDEFINED};
}

static ddof_status make_image(vulkan_backend *b, const VkImageCreateInfo *info, VkImage *image,
                              VkDeviceMemory *memory) {
    static const char doing[] = "making an image";
    VkMemoryRequirements needs;
    ddof_status status = vulkan_check(b, b->f.CreateImage(b->session.device, info, NULL, image), doing);
    if (status != DDOF_OK) return status;
    b->f.GetImageMemoryRequirements(b->session.device, *image, &needs);
    status = allocate(b, &needs, 0, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, memory);
    if (status != DDOF_OK) return status;
    return vulkan_check(b, b->f.BindImageMemory(b->session.device, *image, *memory, 0), doing);
}

static VkDeviceSize texel_bytes(const vulkan_pictures *p) {
    return p->half ? 8 : 16;
}

static ddof_status make_buffer(vulkan_backend *b) {
    static const char doing[] = "making a buffer";
    vulkan_pictures *p = &b->pictures;
    const VkDeviceSize row = (VkDeviceSize)p->width * (texel_bytes(p) + 4), most = BAND_BYTES / row;
    p->band = most >= (VkDeviceSize)p->height ? p->height : most > 1 ? (int)most : 1;
    const VkDeviceSize part = ((VkDeviceSize)p->band * row + 255) / 256 * 256;
    const VkBufferCreateInfo info = {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                                     .size = part * SLOTS,
                                     .usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                                     .sharingMode = VK_SHARING_MODE_EXCLUSIVE};
    VkMemoryRequirements needs;
    void *mapped = NULL;
    ddof_status status = vulkan_check(b, b->f.CreateBuffer(b->session.device, &info, NULL, &p->buffer), doing);
    if (status != DDOF_OK) return status;
    b->f.GetBufferMemoryRequirements(b->session.device, p->buffer, &needs);
    status = allocate(b, &needs, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT,
                      VK_MEMORY_PROPERTY_HOST_CACHED_BIT, &p->memory[2]); /* it is read as well */
    if (status == DDOF_OK)
        status = vulkan_check(b, b->f.BindBufferMemory(b->session.device, p->buffer, p->memory[2], 0), doing);
    if (status == DDOF_OK)
        status = vulkan_check(b, b->f.MapMemory(b->session.device, p->memory[2], 0, VK_WHOLE_SIZE, 0, &mapped), doing);
    for (int i = 0; i < SLOTS && status == DDOF_OK; i++) {
        b->slot[i].offset = part * (VkDeviceSize)i;
        b->slot[i].memory = (char *)mapped + b->slot[i].offset;
    }
    return status;
}

/* Whether the device has images so large. */
static ddof_status check_size(vulkan_backend *b, const VkImageCreateInfo *info, VkDeviceSize texel) {
    VkImageFormatProperties have;
    const uint32_t width = info->extent.width, height = info->extent.height;
    const uint32_t most = b->session.properties.limits.maxImageDimension2D;
    if (width > most || height > most)
        return context_fail(
            b->owner, DDOF_ERROR_UNSUPPORTED,
            "the picture is %u x %u, but this Vulkan device (%s) has images up to %u: use the CPU backend", width,
            height, b->name, most);
    const VkResult result = b->f.GetPhysicalDeviceImageFormatProperties(
        b->session.physical_device, info->format, info->imageType, info->tiling, info->usage, info->flags, &have);
    if (result != VK_SUCCESS && result != VK_ERROR_FORMAT_NOT_SUPPORTED)
        return vulkan_check(b, result, "looking for formats");
    if (result == VK_SUCCESS && width <= have.maxExtent.width && height <= have.maxExtent.height &&
        width * texel * height <= have.maxResourceSize)
        return DDOF_OK;
    return context_fail(b->owner, DDOF_ERROR_UNSUPPORTED,
                        "the picture is %u x %u, but this Vulkan device (%s) has no images of that size in %zu bytes a "
                        "pixel: use the CPU backend",
                        width, height, b->name, (size_t)texel);
}

const VkImageUsageFlags vulkan_color_usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_STORAGE_BIT |
                                             VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT,
                        vulkan_map_usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;

VkFormat vulkan_color_format(const vulkan_pictures *p) {
    return p->half ? VK_FORMAT_R16G16B16A16_SFLOAT : VK_FORMAT_R32G32B32A32_SFLOAT;
}

ddof_status vulkan_pictures_make(vulkan_backend *b, int width, int height, bool half) {
    vulkan_pictures *p = &b->pictures;
    if (p->buffer && p->width == width && p->height == height && p->half == half) return DDOF_OK;
    vulkan_pictures_delete(b);
    *p = (vulkan_pictures){.width = width, .height = height, .half = half};
    const VkImageCreateInfo color = image_info(width, height, vulkan_color_format(p), vulkan_color_usage);
    const VkImageCreateInfo map = image_info(width, height, VK_FORMAT_R32_SFLOAT, vulkan_map_usage);
    ddof_status status = check_size(b, &color, texel_bytes(p));
    if (status == DDOF_OK) status = check_size(b, &map, 4);
    if (status == DDOF_OK) status = make_image(b, &color, &p->color, &p->memory[0]);
    if (status == DDOF_OK) status = make_image(b, &map, &p->map, &p->memory[1]);
    if (status == DDOF_OK) status = make_buffer(b);
    if (status != DDOF_OK) vulkan_pictures_delete(b);
    return status;
}

/* ---- up, and down */

static void copy_band(const vulkan_backend *b, const slot *s, VkImage image, VkDeviceSize offset, VkImageLayout layout,
                      bool up) {
    const VkBufferImageCopy region = {.bufferOffset = s->offset + offset,
                                      .imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1},
                                      .imageOffset = {0, s->y, 0},
                                      .imageExtent = {(uint32_t)b->pictures.width, (uint32_t)s->rows, 1}};
    if (up)
        b->f.CmdCopyBufferToImage(s->commands, b->pictures.buffer, image, layout, 1, &region);
    else
        b->f.CmdCopyImageToBuffer(s->commands, image, layout, b->pictures.buffer, 1, &region);
}

/* Rows of colour lie at the beginning of a part, those of the map behind them. */
static void fill(vulkan_backend *b, frame_job *job, const staging *st, slot *s) {
    const vulkan_pictures *p = &b->pictures;
    const size_t row = (size_t)p->width, texel = (size_t)texel_bytes(p);
    for (int r = 0; r < s->rows; r += STAGING_ROWS) {
        const int rows = s->rows - r < STAGING_ROWS ? s->rows - r : STAGING_ROWS;
        staging_load(b->owner, job, st, s->y + r, rows, p->half);
        memcpy(s->memory + (size_t)r * row * texel, p->half ? (const void *)st->half : st->pixels,
               (size_t)rows * row * texel);
        memcpy(s->memory + row * ((size_t)s->rows * texel + (size_t)r * 4), st->map, (size_t)rows * row * 4);
    }
}

static ddof_status upload_band(vulkan_backend *b, frame_job *job, const staging *st, int y) {
    static const transition fresh = {VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                                     VK_PIPELINE_STAGE_TRANSFER_BIT,
                                     VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT,
                                     VK_ACCESS_TRANSFER_WRITE_BIT,
                                     VK_IMAGE_LAYOUT_UNDEFINED,
                                     VK_IMAGE_LAYOUT_GENERAL};
    const vulkan_pictures *p = &b->pictures;
    slot *s;
    ddof_status status = vulkan_begin(b, &s);
    if (status != DDOF_OK) return status;
    s->y = y;
    s->rows = p->height - y < p->band ? p->height - y : p->band;
    fill(b, job, st, s);
    if (y == 0) {
        vulkan_barrier(b, s, p->color, &fresh);
        vulkan_barrier(b, s, p->map, &fresh);
    }
    copy_band(b, s, p->color, 0, VK_IMAGE_LAYOUT_GENERAL, true);
    copy_band(b, s, p->map, (VkDeviceSize)p->width * (VkDeviceSize)s->rows * texel_bytes(p), VK_IMAGE_LAYOUT_GENERAL,
              true);
    status = vulkan_submit(b, s);
    if (status == DDOF_OK && !context_progress(b->owner, s->rows)) status = DDOF_ERROR_CANCELLED;
    return status;
}

ddof_status vulkan_pictures_upload(vulkan_backend *b, frame_job *job, const staging *st) {
    ddof_status status = DDOF_OK;
    for (int y = 0; y < b->pictures.height && status == DDOF_OK; y += b->pictures.band)
        status = upload_band(b, job, st, y);
    return status;
}

/* Nothing is stored before the GPU has said that all went well. */
static ddof_status store_band(vulkan_backend *b, const frame_job *job, const staging *st, slot *s) {
    const vulkan_pictures *p = &b->pictures;
    const size_t row = (size_t)p->width * 4;
    ddof_status status = vulkan_wait(b, s);
    if (status != DDOF_OK) return status;
    for (int r = 0; r < s->rows; r += STAGING_ROWS) {
        const int rows = s->rows - r < STAGING_ROWS ? s->rows - r : STAGING_ROWS;
        const char *from = s->memory + (size_t)r * (size_t)p->width * (size_t)texel_bytes(p);
        if (p->half)
            b->owner->kernels->pixels->half_to_float((const uint16_t *)(const void *)from, st->pixels,
                                                     rows * p->width * 4);
        else
            memcpy(st->pixels, from, (size_t)rows * row * sizeof(float));
        staging_store(b->owner, job, st, s->y + r, rows);
    }
    return context_progress(b->owner, s->rows) ? DDOF_OK : DDOF_ERROR_CANCELLED;
}

static ddof_status read_band(vulkan_backend *b, int y, slot **out) {
    static const VkMemoryBarrier for_the_host = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
                                                 .srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT,
                                                 .dstAccessMask = VK_ACCESS_HOST_READ_BIT};
    const vulkan_pictures *p = &b->pictures;
    ddof_status status = vulkan_begin(b, out);
    slot *s = *out;
    if (status != DDOF_OK) return status;
    s->y = y;
    s->rows = p->height - y < p->band ? p->height - y : p->band;
    copy_band(b, s, p->color, 0, VK_IMAGE_LAYOUT_GENERAL, false);
    b->f.CmdPipelineBarrier(s->commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 1,
                            &for_the_host, 0, NULL, 0, NULL);
    return vulkan_submit(b, s);
}

/* The next band is on its way while one is stored. */
ddof_status vulkan_pictures_download(vulkan_backend *b, const frame_job *job, const staging *st) {
    slot *ready = NULL, *next = NULL;
    ddof_status status = DDOF_OK;
    for (int y = 0; y < b->pictures.height && status == DDOF_OK; y += b->pictures.band) {
        status = read_band(b, y, &next);
        if (status == DDOF_OK && ready) status = store_band(b, job, st, ready);
        ready = next;
    }
    return status == DDOF_OK ? store_band(b, job, st, ready) : status;
}
