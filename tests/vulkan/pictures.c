/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "pictures.h"

#include <stdlib.h>
#include <string.h>

/* ---- images */

/* Beside what the library needs: copies, and of depth what its layouts are for. */
static VkImageUsageFlags whole_usage(VkFormat format, VkImageUsageFlags usage) {
    usage |= VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
    return usage | (format_is_depth(format) ? (VkImageUsageFlags)VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT : 0);
}

bool picture_possible(VkFormat format, VkImageUsageFlags usage) {
    VkImageFormatProperties properties;
    return VK(vkGetPhysicalDeviceImageFormatProperties)(own.physical, format, VK_IMAGE_TYPE_2D, VK_IMAGE_TILING_OPTIMAL,
                                                        whole_usage(format, usage), 0, &properties) == VK_SUCCESS;
}

static VkImageAspectFlags aspects(VkFormat format) {
    if (!format_is_depth(format)) return VK_IMAGE_ASPECT_COLOR_BIT;
    const bool stencil = format == VK_FORMAT_D24_UNORM_S8_UINT || format == VK_FORMAT_D32_SFLOAT_S8_UINT;
    return VK_IMAGE_ASPECT_DEPTH_BIT | (stencil ? VK_IMAGE_ASPECT_STENCIL_BIT : 0);
}

/* All levels and layers, or one of each; what came before is done, and what comes after sees it. */
static void transition(VkCommandBuffer commands, const picture *p, int level, int layer, VkImageLayout from,
                       VkImageLayout to) {
    const VkAccessFlags all = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT;
    const VkImageMemoryBarrier barrier = {
        .sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER,
        .srcAccessMask = all,
        .dstAccessMask = all,
        .oldLayout = from,
        .newLayout = to,
        .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
        .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
        .image = p->d.image,
        .subresourceRange = {aspects(p->d.format), level < 0 ? 0 : (uint32_t)level, level < 0 ? p->levels : 1,
                             layer < 0 ? 0 : (uint32_t)layer, layer < 0 ? p->layers : 1}};
    VK(vkCmdPipelineBarrier)
    (commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 0, NULL, 0, NULL, 1,
     &barrier);
}

static VkImageLayout layout_of(const picture *p) {
    if (p->d.layout) return p->d.layout;
    return format_is_depth(p->d.format) ? VK_IMAGE_LAYOUT_DEPTH_STENCIL_READ_ONLY_OPTIMAL
                                        : VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
}

static picture make(ddof_vulkan_image d, uint32_t width, uint32_t height, uint32_t levels, uint32_t layers) {
    picture p = {.d = d, .levels = levels, .layers = layers};
    if (d.usage & VK_IMAGE_USAGE_STORAGE_BIT && !d.layout) p.d.layout = VK_IMAGE_LAYOUT_GENERAL;
    const VkImageCreateInfo info = {.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                                    .imageType = VK_IMAGE_TYPE_2D,
                                    .format = d.format,
                                    .extent = {width, height, 1},
                                    .mipLevels = levels,
                                    .arrayLayers = layers,
                                    .samples = VK_SAMPLE_COUNT_1_BIT,
                                    .tiling = VK_IMAGE_TILING_OPTIMAL,
                                    .usage = whole_usage(d.format, d.usage)};
    CHECK(VK(vkCreateImage)(own.device, &info, NULL, &p.d.image));
    VkMemoryRequirements needs;
    VK(vkGetImageMemoryRequirements)(own.device, p.d.image, &needs);
    p.memory = own_memory(needs.size, needs.memoryTypeBits, 0);
    CHECK(VK(vkBindImageMemory)(own.device, p.d.image, p.memory, 0));
    VkCommandBuffer commands = own_begin();
    transition(commands, &p, -1, -1, VK_IMAGE_LAYOUT_UNDEFINED, layout_of(&p));
    own_finish(commands);
    return p;
}

picture picture_make(VkFormat format, int width, int height, VkImageUsageFlags usage, VkImageLayout layout) {
    const uint32_t w = (uint32_t)width, h = (uint32_t)height;
    return make((ddof_vulkan_image){.format = format, .width = w, .height = h, .usage = usage, .layout = layout}, w, h,
                1, 1);
}

picture picture_part(VkFormat format, int width, int height, VkImageUsageFlags usage) {
    const uint32_t w = (uint32_t)width, h = (uint32_t)height;
    const ddof_vulkan_image d = {
        .format = format, .width = w, .height = h, .usage = usage, .mip_level = 1, .array_layer = 2};
    return make(d, 2 * w + 1, 2 * h, 3, 4);
}

void picture_free(picture *p) {
    VK(vkDestroyImage)(own.device, p->d.image, NULL);
    VK(vkFreeMemory)(own.device, p->memory, NULL);
    memset(p, 0, sizeof *p);
}

static VkExtent3D extent(const picture *p, uint32_t level) {
    uint32_t w = p->d.width, h = p->d.height;
    if (p->levels > 1 && level == 0) w = 2 * w + 1, h = 2 * h;
    for (uint32_t i = 1; p->levels > 1 && i < level; i++)
        w = w > 1 ? w / 2 : 1, h = h > 1 ? h / 2 : 1;
    return (VkExtent3D){w, h, 1};
}

size_t picture_bytes(const picture *p, uint32_t level) {
    const VkExtent3D e = extent(p, level);
    return (size_t)e.width * e.height * texel_bytes(p->d.format);
}

typedef struct staging {
    VkBuffer buffer;
    VkDeviceMemory memory;
    void *mapped;
} staging;

static staging staging_make(size_t bytes) {
    staging s;
    VkMemoryRequirements needs;
    const VkBufferCreateInfo info = {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                                     .size = bytes,
                                     .usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT};
    CHECK(VK(vkCreateBuffer)(own.device, &info, NULL, &s.buffer));
    VK(vkGetBufferMemoryRequirements)(own.device, s.buffer, &needs);
    s.memory = own_memory(needs.size, needs.memoryTypeBits,
                          VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
    CHECK(VK(vkBindBufferMemory)(own.device, s.buffer, s.memory, 0));
    CHECK(VK(vkMapMemory)(own.device, s.memory, 0, VK_WHOLE_SIZE, 0, &s.mapped));
    return s;
}

static void staging_free(staging *s) {
    VK(vkDestroyBuffer)(own.device, s->buffer, NULL);
    VK(vkFreeMemory)(own.device, s->memory, NULL);
}

static VkBufferImageCopy copy_of(const picture *p, uint32_t level, uint32_t layer) {
    const VkImageAspectFlags aspect =
        format_is_depth(p->d.format) ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT;
    return (VkBufferImageCopy){.imageSubresource = {aspect, level, layer, 1}, .imageExtent = extent(p, level)};
}

void picture_write(const picture *p, uint32_t level, uint32_t layer, const void *texels) {
    const VkBufferImageCopy copy = copy_of(p, level, layer);
    staging s = staging_make(picture_bytes(p, level));
    memcpy(s.mapped, texels, picture_bytes(p, level));
    VkCommandBuffer commands = own_begin();
    transition(commands, p, (int)level, (int)layer, layout_of(p), VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    VK(vkCmdCopyBufferToImage)(commands, s.buffer, p->d.image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &copy);
    transition(commands, p, (int)level, (int)layer, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, layout_of(p));
    own_finish(commands);
    staging_free(&s);
}

void picture_read(const picture *p, uint32_t level, uint32_t layer, void *texels) {
    const VkBufferImageCopy copy = copy_of(p, level, layer);
    staging s = staging_make(picture_bytes(p, level));
    VkCommandBuffer commands = own_begin();
    transition(commands, p, (int)level, (int)layer, layout_of(p), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    VK(vkCmdCopyImageToBuffer)(commands, p->d.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, s.buffer, 1, &copy);
    transition(commands, p, (int)level, (int)layer, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, layout_of(p));
    const VkMemoryBarrier host = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
                                  .srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT,
                                  .dstAccessMask = VK_ACCESS_HOST_READ_BIT};
    VK(vkCmdPipelineBarrier)
    (commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &host, 0, NULL, 0, NULL);
    own_finish(commands);
    memcpy(texels, s.mapped, picture_bytes(p, level));
    staging_free(&s);
}

void picture_put(const picture *p, const float *rgba) {
    const size_t count = (size_t)p->d.width * p->d.height, step = texel_bytes(p->d.format);
    char *texels = malloc(count * step);
    assert_non_null(texels);
    for (size_t i = 0; i < count; i++)
        texel_encode(p->d.format, rgba + 4 * i, texels + i * step);
    picture_write(p, p->d.mip_level, p->d.array_layer, texels);
    free(texels);
}

void picture_get(const picture *p, float *rgba) {
    const size_t count = (size_t)p->d.width * p->d.height, step = texel_bytes(p->d.format);
    char *texels = malloc(count * step);
    assert_non_null(texels);
    picture_read(p, p->d.mip_level, p->d.array_layer, texels);
    for (size_t i = 0; i < count; i++)
        texel_decode(p->d.format, texels + i * step, rgba + 4 * i);
    free(texels);
}
