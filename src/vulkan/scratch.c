/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "../bokeh.h"
#include "frame.h"
#include "passes.h"
#include "sprites.h"

static bool wanted(const ddof_vulkan_frame *frame, vulkan_picture picture) {
    const ddof_bokeh bokeh = frame->sprite_kind.bokeh;
    const bool diffuses = bokeh != DDOF_BOKEH_FULL;
    switch (picture) {
    case PICTURE_ROWS: /* solvers whose last pass reads the pixels beside the one it writes */
        return diffuses && frame->solver == DDOF_SOLVER_CR4_PACK;
    case PICTURE_WORK:
        return diffuses && frame->output_also != PICTURE_WORK;
    case PICTURE_IMAGINARY:
        return diffuses && frame->disc;
    case PICTURE_SUM:
        return diffuses && frame->disc && frame->disc->components > 1 && frame->output_also != PICTURE_SUM;
    case PICTURE_REMAINDER:
        return frame->first == PICTURE_REMAINDER;
    case PICTURE_LIGHT:
        return bokeh != DDOF_BOKEH_OFF;
    case PICTURE_WEIGHT:
        return bokeh == DDOF_BOKEH_FULL;
    default:
        return false;
    }
}

static uint32_t level_side(int side, int level) {
    return (uint32_t)((side + (1 << level) - 1) >> level);
}

VkExtent2D vulkan_light_size_of(const vulkan_sprite_kind *kind, int width, int height) {
    const int first = kind->half;
    const uint32_t tall = level_side(height, first) + level_side(height, first + 1);
    uint32_t wide = 0;
    for (int l = first + 1; l < BOKEH_LEVELS; l++)
        wide += level_side(width, l);
    if (wide < level_side(width, first)) wide = level_side(width, first);
    return (VkExtent2D){wide, kind->bokeh == DDOF_BOKEH_FULL ? 2 * tall : tall};
}

VkExtent2D vulkan_light_size(const ddof_vulkan_frame *frame) {
    return vulkan_light_size_of(&frame->sprite_kind, (int)frame->images.color.width, (int)frame->images.color.height);
}

static ddof_status make_image(ddof_vulkan *vk, const ddof_vulkan_frame *frame, vulkan_picture picture, VkImage *image) {
    const bool drawn = picture == PICTURE_LIGHT || picture == PICTURE_WEIGHT;
    const VkExtent2D light = vulkan_light_size(frame);
    const VkImageCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
        .imageType = VK_IMAGE_TYPE_2D,
        .format = vulkan_scratch_format(frame, picture),
        .extent = {drawn ? light.width : frame->images.color.width, drawn ? light.height : frame->images.color.height,
                   1},
        .mipLevels = 1,
        .arrayLayers = 1,
        .samples = VK_SAMPLE_COUNT_1_BIT,
        .tiling = VK_IMAGE_TILING_OPTIMAL,
        .usage = VK_IMAGE_USAGE_SAMPLED_BIT |
                 (VkImageUsageFlags)(drawn ? VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT : VK_IMAGE_USAGE_STORAGE_BIT),
        .sharingMode = VK_SHARING_MODE_EXCLUSIVE,
        .initialLayout = VK_IMAGE_LAYOUT_UNDEFINED};
    return vulkan_device_check(vk, vk->f.CreateImage(vk->config.device, &info, vk->allocator, image),
                               "making a scratch image");
}

VkFormat vulkan_scratch_format(const ddof_vulkan_frame *frame, vulkan_picture picture) {
    if (picture == PICTURE_LIGHT) return frame->light_format;
    return picture == PICTURE_WEIGHT ? VK_FORMAT_R32_SFLOAT : frame->work_format;
}

static VkBufferUsageFlags buffer_usage(vulkan_buffer buffer) {
    if (buffer == BUFFER_SPRITE_STATE)
        return VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT |
               VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    if (buffer == BUFFER_SPRITE_TABLES) return VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    return VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
}

static ddof_status make_buffer(ddof_vulkan *vk, vulkan_scratch *s, vulkan_buffer buffer) {
    const VkBufferCreateInfo info = {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                                     .size = s->buffer_bytes[buffer],
                                     .usage = buffer_usage(buffer),
                                     .sharingMode = VK_SHARING_MODE_EXCLUSIVE};
    return vulkan_device_check(vk, vk->f.CreateBuffer(vk->config.device, &info, vk->allocator, &s->buffer[buffer]),
                               "making a scratch buffer");
}

static VkDeviceSize round_up(VkDeviceSize n, VkDeviceSize unit) {
    return (n + unit - 1) / unit * unit;
}

/* Room for one more: returns its offset. Images and buffers lie granularity apart. */
static VkDeviceSize place(const ddof_vulkan *vk, vulkan_scratch *s, const VkMemoryRequirements *r) {
    VkDeviceSize align = r->alignment;
    if (align < vk->limits.bufferImageGranularity) align = vk->limits.bufferImageGranularity;
    const VkDeviceSize offset = round_up(s->total.size, align);
    s->total.size = offset + r->size;
    if (s->total.alignment < align) s->total.alignment = align;
    s->total.memoryTypeBits &= r->memoryTypeBits;
    return offset;
}

ddof_status vulkan_scratch_make(ddof_vulkan *vk, ddof_vulkan_frame *frame) {
    vulkan_scratch *s = &frame->scratch;
    const VkDevice device = vk->config.device;
    VkMemoryRequirements r;
    s->total = (VkMemoryRequirements){0, 1, UINT32_MAX};
    for (int i = 0; i < VULKAN_PICTURES; i++) {
        if (!wanted(frame, (vulkan_picture)i)) continue;
        const ddof_status status = make_image(vk, frame, (vulkan_picture)i, &s->image[i]);
        if (status != DDOF_OK) return status;
        vk->f.GetImageMemoryRequirements(device, s->image[i], &r);
        s->image_offset[i] = place(vk, s, &r);
    }
    if (frame->sprite_kind.bokeh != DDOF_BOKEH_FULL)
        s->buffer_bytes[BUFFER_LEVELS] =
            vulkan_levels_bytes(frame->solver, (int)frame->images.color.width, (int)frame->images.color.height);
    vulkan_sprites_bytes(frame, s->buffer_bytes);
    for (int i = 0; i < VULKAN_BUFFERS; i++) {
        if (!s->buffer_bytes[i]) continue;
        const ddof_status status = make_buffer(vk, s, (vulkan_buffer)i);
        if (status != DDOF_OK) return status;
        vk->f.GetBufferMemoryRequirements(device, s->buffer[i], &r);
        s->buffer_offset[i] = place(vk, s, &r);
    }
    if (s->total.memoryTypeBits) return DDOF_OK;
    return context_fail(
        &vk->shell, DDOF_ERROR_UNSUPPORTED,
        "this device (%s) has no memory for images and buffers alike: use the solver LINE, and no sprites", vk->name);
}

static ddof_status allocate(ddof_vulkan *vk, vulkan_scratch *s) {
    const uint32_t type = vulkan_device_memory(vk, s->total.memoryTypeBits);
    if (type == UINT32_MAX)
        return context_fail(&vk->shell, DDOF_ERROR_UNSUPPORTED, "this device (%s) has no memory for scratch", vk->name);
    const VkMemoryAllocateInfo info = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, .allocationSize = s->total.size, .memoryTypeIndex = type};
    return vulkan_device_check(vk, vk->f.AllocateMemory(vk->config.device, &info, vk->allocator, &s->memory),
                               "allocating scratch memory");
}

static ddof_status check_memory(ddof_vulkan *vk, const ddof_vulkan_frame *frame) {
    const ddof_vulkan_images *i = &frame->images;
    const VkMemoryRequirements *r = &frame->scratch.total;
    if (i->scratch_offset % r->alignment)
        return context_fail(&vk->shell, DDOF_ERROR_INVALID, "images.scratch_offset must be a multiple of %llu",
                            (unsigned long long)r->alignment);
    if (i->scratch_size && i->scratch_size < r->size)
        return context_fail(&vk->shell, DDOF_ERROR_INVALID, "images.scratch_size is %llu bytes, %llu are needed",
                            (unsigned long long)i->scratch_size, (unsigned long long)r->size);
    return DDOF_OK;
}

ddof_status vulkan_scratch_bind(ddof_vulkan *vk, ddof_vulkan_frame *frame) {
    vulkan_scratch *s = &frame->scratch;
    const bool own = frame->images.scratch_memory == VK_NULL_HANDLE;
    if (!s->total.size) return DDOF_OK;
    ddof_status status = own ? allocate(vk, s) : check_memory(vk, frame);
    if (status != DDOF_OK) return status;
    const VkDeviceMemory memory = own ? s->memory : frame->images.scratch_memory;
    const VkDeviceSize offset = own ? 0 : frame->images.scratch_offset;
    VkResult result = VK_SUCCESS;
    for (int i = 0; i < VULKAN_PICTURES && result == VK_SUCCESS; i++)
        if (s->image[i])
            result = vk->f.BindImageMemory(vk->config.device, s->image[i], memory, offset + s->image_offset[i]);
    for (int i = 0; i < VULKAN_BUFFERS && result == VK_SUCCESS; i++)
        if (s->buffer[i])
            result = vk->f.BindBufferMemory(vk->config.device, s->buffer[i], memory, offset + s->buffer_offset[i]);
    return vulkan_device_check(vk, result, "binding scratch memory");
}

void vulkan_scratch_delete(ddof_vulkan *vk, vulkan_scratch *s) {
    for (int i = 0; i < VULKAN_PICTURES; i++)
        if (s->image[i]) vk->f.DestroyImage(vk->config.device, s->image[i], vk->allocator);
    for (int i = 0; i < VULKAN_BUFFERS; i++)
        if (s->buffer[i]) vk->f.DestroyBuffer(vk->config.device, s->buffer[i], vk->allocator);
    if (s->memory) vk->f.FreeMemory(vk->config.device, s->memory, vk->allocator);
    *s = (vulkan_scratch){0};
}
