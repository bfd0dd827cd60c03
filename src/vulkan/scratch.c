/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "frame.h"
#include "passes.h"

static bool wanted(const ddof_vulkan_frame *frame, vulkan_picture picture) {
    switch (picture) {
    case PICTURE_ROWS: /* solvers whose last pass reads the pixels beside the one it writes */
        return frame->solver == DDOF_SOLVER_CR4_PACK;
    case PICTURE_WORK:
        return frame->output_also != PICTURE_WORK;
    case PICTURE_IMAGINARY:
        return frame->disc != NULL;
    case PICTURE_SUM:
        return frame->disc && frame->disc->components > 1 && frame->output_also != PICTURE_SUM;
    default:
        return false;
    }
}

static ddof_status make_image(ddof_vulkan *vk, const ddof_vulkan_frame *frame, VkImage *image) {
    const VkImageCreateInfo info = {.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                                    .imageType = VK_IMAGE_TYPE_2D,
                                    .format = frame->work_format,
                                    .extent = {frame->images.color.width, frame->images.color.height, 1},
                                    .mipLevels = 1,
                                    .arrayLayers = 1,
                                    .samples = VK_SAMPLE_COUNT_1_BIT,
                                    .tiling = VK_IMAGE_TILING_OPTIMAL,
                                    .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_STORAGE_BIT,
                                    .sharingMode = VK_SHARING_MODE_EXCLUSIVE,
                                    .initialLayout = VK_IMAGE_LAYOUT_UNDEFINED};
    return vulkan_device_check(vk, vk->f.CreateImage(vk->config.device, &info, vk->allocator, image),
                               "making a scratch image");
}

static ddof_status make_levels(ddof_vulkan *vk, vulkan_scratch *s) {
    const VkBufferCreateInfo info = {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                                     .size = s->levels_bytes,
                                     .usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
                                     .sharingMode = VK_SHARING_MODE_EXCLUSIVE};
    return vulkan_device_check(vk, vk->f.CreateBuffer(vk->config.device, &info, vk->allocator, &s->levels),
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
        const ddof_status status = make_image(vk, frame, &s->image[i]);
        if (status != DDOF_OK) return status;
        vk->f.GetImageMemoryRequirements(device, s->image[i], &r);
        s->image_offset[i] = place(vk, s, &r);
    }
    s->levels_bytes =
        vulkan_levels_bytes(frame->solver, (int)frame->images.color.width, (int)frame->images.color.height);
    if (s->levels_bytes) {
        const ddof_status status = make_levels(vk, s);
        if (status != DDOF_OK) return status;
        vk->f.GetBufferMemoryRequirements(device, s->levels, &r);
        s->levels_offset = place(vk, s, &r);
    }
    if (s->total.memoryTypeBits) return DDOF_OK;
    return context_fail(&vk->shell, DDOF_ERROR_UNSUPPORTED,
                        "this device (%s) has no memory for images and buffers alike: use the solver LINE", vk->name);
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
    if (result == VK_SUCCESS && s->levels)
        result = vk->f.BindBufferMemory(vk->config.device, s->levels, memory, offset + s->levels_offset);
    return vulkan_device_check(vk, result, "binding scratch memory");
}

void vulkan_scratch_delete(ddof_vulkan *vk, vulkan_scratch *s) {
    for (int i = 0; i < VULKAN_PICTURES; i++)
        if (s->image[i]) vk->f.DestroyImage(vk->config.device, s->image[i], vk->allocator);
    if (s->levels) vk->f.DestroyBuffer(vk->config.device, s->levels, vk->allocator);
    if (s->memory) vk->f.FreeMemory(vk->config.device, s->memory, vk->allocator);
    *s = (vulkan_scratch){0};
}
