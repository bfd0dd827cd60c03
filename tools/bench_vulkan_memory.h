/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The device of bench_vulkan.c: its functions, images and buffers, and how work is submitted. */
#ifndef TOOLS_BENCH_VULKAN_MEMORY_H
#define TOOLS_BENCH_VULKAN_MEMORY_H

#include "vulkan/loader.h"

/* clang-format off */
#define BENCH_FUNCTIONS(X) \
    X(AllocateCommandBuffers) X(AllocateMemory) X(BeginCommandBuffer) X(BindBufferMemory) \
    X(BindImageMemory) X(CmdCopyBuffer) X(CmdCopyBufferToImage) X(CmdFillBuffer) X(CmdPipelineBarrier) \
    X(CmdResetQueryPool) X(CmdWriteTimestamp) X(CreateBuffer) X(CreateCommandPool) X(CreateFence) \
    X(CreateImage) X(CreateQueryPool) X(DestroyBuffer) X(DestroyCommandPool) X(DestroyFence) \
    X(DestroyImage) X(DestroyQueryPool) X(EndCommandBuffer) X(FreeMemory) \
    X(GetBufferMemoryRequirements) X(GetImageMemoryRequirements) \
    X(GetPhysicalDeviceQueueFamilyProperties) X(GetQueryPoolResults) X(MapMemory) X(QueueSubmit) \
    X(ResetFences) X(WaitForFences)
/* clang-format on */

typedef struct bench_device {
    vulkan_session session;
    bool open;
#define X(name) PFN_vk##name name;
    BENCH_FUNCTIONS(X)
#undef X
    VkFence fence;
    char said[512]; /* what went wrong last */
} bench_device;

typedef struct bench_image {
    VkImage image;
    VkDeviceMemory memory;
    VkFormat format;
    VkImageUsageFlags usage;
    uint32_t width, height;
    size_t texel; /* bytes */
} bench_image;

typedef struct bench_buffer {
    VkBuffer buffer;
    VkDeviceMemory memory;
    VkDeviceSize size;
    void *mapped; /* NULL: in the device's memory */
} bench_buffer;

/* False: `why` says why, *status as of ddof_create(). To be closed either way. */
bool bench_device_open(bench_device *d, int index, ddof_status *status, char *why, size_t size);
void bench_device_close(bench_device *d);

/* What follows returns NULL or d->said. */

/* "`what`: " and the result in words; NULL for VK_SUCCESS. */
const char *bench_result(bench_device *d, VkResult result, const char *what);

/* image: format, usage and size are filled in. */
const char *bench_image_create(bench_device *d, bench_image *image);
void bench_image_destroy(bench_device *d, bench_image *image);

const char *bench_buffer_create(bench_device *d, bench_buffer *buffer, VkDeviceSize size, bool mapped);
void bench_buffer_destroy(bench_device *d, bench_buffer *buffer);

const char *bench_begin(bench_device *d, VkCommandBuffer commands);
/* Submits and waits; *ms: how long that took. */
const char *bench_submit(bench_device *d, VkCommandBuffer commands, double *ms);

/* A barrier for all memory. */
void bench_barrier(const bench_device *d, VkCommandBuffer commands, VkPipelineStageFlags from, VkAccessFlags written,
                   VkPipelineStageFlags to, VkAccessFlags used);

#endif
