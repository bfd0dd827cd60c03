/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "bench_vulkan_memory.h"

#include <stdio.h>

#include "message.h"

/* ------------------------------------------------------------------------- device */

const char *bench_result(bench_device *d, VkResult result, const char *what) {
    if (result == VK_SUCCESS) return NULL;
    const char *text = result == VK_ERROR_OUT_OF_DEVICE_MEMORY ? "the device has no memory left; make --size smaller"
                       : result == VK_ERROR_OUT_OF_HOST_MEMORY ? "out of memory; make --size smaller"
                       : result == VK_ERROR_DEVICE_LOST        ? "the device was lost"
                                                               : NULL;
    if (text)
        snprintf(d->said, sizeof d->said, "%s: %s", what, text);
    else
        snprintf(d->said, sizeof d->said, "%s: VkResult %d", what, (int)result);
    return d->said;
}

bool bench_device_open(bench_device *d, int index, ddof_status *status, char *why, size_t size) {
    *d = (bench_device){0};
    if (!vulkan_open(&d->session, index, status, why, size)) return false;
    d->open = true;
    *status = DDOF_ERROR_UNSUPPORTED;
#define X(name)                                                                                                        \
    d->name = (PFN_vk##name)vulkan_function(&d->session, "vk" #name);                                                  \
    if (!d->name) {                                                                                                    \
        snprintf(why, size, "this driver has no function vk%s", #name);                                                \
        return false;                                                                                                  \
    }
    BENCH_FUNCTIONS(X)
#undef X
    const VkFenceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    const char *bad = bench_result(d, d->CreateFence(d->session.device, &info, NULL, &d->fence), "vkCreateFence");
    if (!bad) return true;
    *status = DDOF_ERROR_DEVICE;
    snprintf(why, size, "%s", bad);
    return false;
}

void bench_device_close(bench_device *d) {
    if (!d->open) return;
    if (d->fence) d->DestroyFence(d->session.device, d->fence, NULL);
    vulkan_close(&d->session);
    d->open = false;
}

/* ------------------------------------------------------------------------- memory */

static const char *allocate(bench_device *d, const VkMemoryRequirements *need, bool mapped, VkDeviceMemory *memory) {
    const VkMemoryPropertyFlags host = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    const uint32_t type = vulkan_memory_type(&d->session.memory, need->memoryTypeBits, mapped ? host : 0,
                                             mapped ? 0 : VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
    if (type == UINT32_MAX) return bench_result(d, VK_ERROR_FEATURE_NOT_PRESENT, "no memory that fits");
    const VkMemoryAllocateInfo info = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, .allocationSize = need->size, .memoryTypeIndex = type};
    return bench_result(d, d->AllocateMemory(d->session.device, &info, NULL, memory), "vkAllocateMemory");
}

const char *bench_image_create(bench_device *d, bench_image *i) {
    const VkImageCreateInfo info = {.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                                    .imageType = VK_IMAGE_TYPE_2D,
                                    .format = i->format,
                                    .extent = {i->width, i->height, 1},
                                    .mipLevels = 1,
                                    .arrayLayers = 1,
                                    .samples = VK_SAMPLE_COUNT_1_BIT,
                                    .tiling = VK_IMAGE_TILING_OPTIMAL,
                                    .usage = i->usage,
                                    .sharingMode = VK_SHARING_MODE_EXCLUSIVE,
                                    .initialLayout = VK_IMAGE_LAYOUT_UNDEFINED};
    const VkDevice device = d->session.device;
    VkMemoryRequirements need;
    const char *bad = bench_result(d, d->CreateImage(device, &info, NULL, &i->image), "vkCreateImage");
    if (bad) return bad;
    d->GetImageMemoryRequirements(device, i->image, &need);
    bad = allocate(d, &need, false, &i->memory);
    if (!bad) bad = bench_result(d, d->BindImageMemory(device, i->image, i->memory, 0), "vkBindImageMemory");
    if (bad) bench_image_destroy(d, i);
    return bad;
}

void bench_image_destroy(bench_device *d, bench_image *i) {
    if (i->image) d->DestroyImage(d->session.device, i->image, NULL);
    if (i->memory) d->FreeMemory(d->session.device, i->memory, NULL);
    *i = (bench_image){0};
}

const char *bench_buffer_create(bench_device *d, bench_buffer *b, VkDeviceSize size, bool mapped) {
    const VkBufferCreateInfo info = {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                                     .size = size,
                                     .usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                                     .sharingMode = VK_SHARING_MODE_EXCLUSIVE};
    const VkDevice device = d->session.device;
    VkMemoryRequirements need;
    *b = (bench_buffer){.size = size};
    const char *bad = bench_result(d, d->CreateBuffer(device, &info, NULL, &b->buffer), "vkCreateBuffer");
    if (bad) return bad;
    d->GetBufferMemoryRequirements(device, b->buffer, &need);
    bad = allocate(d, &need, mapped, &b->memory);
    if (!bad) bad = bench_result(d, d->BindBufferMemory(device, b->buffer, b->memory, 0), "vkBindBufferMemory");
    if (!bad && mapped)
        bad = bench_result(d, d->MapMemory(device, b->memory, 0, VK_WHOLE_SIZE, 0, &b->mapped), "vkMapMemory");
    if (bad) bench_buffer_destroy(d, b);
    return bad;
}

void bench_buffer_destroy(bench_device *d, bench_buffer *b) {
    if (b->buffer) d->DestroyBuffer(d->session.device, b->buffer, NULL);
    if (b->memory) d->FreeMemory(d->session.device, b->memory, NULL);
    *b = (bench_buffer){0};
}

/* ------------------------------------------------------------------------- commands */

const char *bench_begin(bench_device *d, VkCommandBuffer commands) {
    const VkCommandBufferBeginInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    return bench_result(d, d->BeginCommandBuffer(commands, &info), "vkBeginCommandBuffer");
}

const char *bench_submit(bench_device *d, VkCommandBuffer commands, double *ms) {
    const VkSubmitInfo info = {
        .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 1, .pCommandBuffers = &commands};
    const VkDevice device = d->session.device;
    const double begin = now_ms();
    const char *bad = bench_result(d, d->QueueSubmit(d->session.queue, 1, &info, d->fence), "vkQueueSubmit");
    if (bad) return bad;
    bad = bench_result(d, d->WaitForFences(device, 1, &d->fence, VK_TRUE, UINT64_MAX), "vkWaitForFences");
    *ms = now_ms() - begin;
    return bad ? bad : bench_result(d, d->ResetFences(device, 1, &d->fence), "vkResetFences");
}

void bench_barrier(const bench_device *d, VkCommandBuffer commands, VkPipelineStageFlags from, VkAccessFlags written,
                   VkPipelineStageFlags to, VkAccessFlags used) {
    const VkMemoryBarrier barrier = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER, .srcAccessMask = written, .dstAccessMask = used};
    d->CmdPipelineBarrier(commands, from, to, 0, 1, &barrier, 0, NULL, 0, NULL);
}
