/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* What a Vulkan program has long before it wants depth of field, and what the two samples share: a device, images,
 * buffers, barriers. None of it knows ddof. Whatever fails prints one line and ends the program. */
#ifndef DDOF_VULKAN_SAMPLE_H
#define DDOF_VULKAN_SAMPLE_H

#include <stdbool.h>
#include <vulkan/vulkan.h>

typedef struct sample {
    VkInstance instance;
    VkPhysicalDevice gpu;
    VkPhysicalDeviceProperties properties;
    VkPhysicalDeviceMemoryProperties memory;
    VkPhysicalDeviceFeatures2 features; /* what was enabled, chained to the next one */
    VkPhysicalDeviceVulkan13Features features13;
    VkDevice device;
    uint32_t family; /* of queue: graphics and compute */
    VkQueue queue;
    VkCommandPool pool;
} sample;

typedef struct sample_image {
    VkImage image;
    VkDeviceMemory memory;
    VkImageView view;
    VkFormat format;
    VkImageUsageFlags usage;
    uint32_t width, height;
} sample_image;

typedef struct sample_buffer {
    VkBuffer buffer;
    VkDeviceMemory memory;
    void *data; /* mapped and coherent */
} sample_buffer;

/* One way to use an image: half of a barrier. */
typedef struct sample_use {
    VkPipelineStageFlags2 stage;
    VkAccessFlags2 access;
    VkImageLayout layout;
} sample_use;

/* Whatever came before is over, and its contents do not matter. */
static const sample_use SAMPLE_DISCARD = {VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_ACCESS_2_MEMORY_WRITE_BIT,
                                          VK_IMAGE_LAYOUT_UNDEFINED};
static const sample_use SAMPLE_WRITE = {VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
                                        VK_IMAGE_LAYOUT_GENERAL};
static const sample_use SAMPLE_READ = {VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_READ_BIT,
                                       VK_IMAGE_LAYOUT_GENERAL};
static const sample_use SAMPLE_TEXTURE = {VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_SAMPLED_READ_BIT,
                                          VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
static const sample_use SAMPLE_COPY = {VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_READ_BIT,
                                       VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL};

/* The program has it: what it says begins so. */
extern const char sample_program[];

/* Prints that and `what`, as printf() would, and ends the program. */
#if defined(__GNUC__)
__attribute__((noreturn, format(printf, 1, 2)))
#endif
void sample_fail(const char *what, ...);

/* Checks a VkResult, VK_SUBOPTIMAL_KHR included. */
#define SAMPLE_VK(call) sample_check((call), #call)
void sample_check(VkResult result, const char *call);

/* extensions: of the instance, for a window; with any, the device gets VK_KHR_swapchain. */
void sample_open(sample *s, const char *const *extensions, uint32_t count);
void sample_close(sample *s);

VkCommandBuffer sample_commands(const sample *s);
void sample_begin(VkCommandBuffer commands); /* to be submitted once */

/* A 2D image of one level, undefined; its view. */
sample_image sample_image_create(const sample *s, uint32_t width, uint32_t height, VkFormat format,
                                 VkImageUsageFlags usage);
void sample_image_destroy(const sample *s, sample_image *image);

/* To copy into, and to read from on the CPU. */
sample_buffer sample_buffer_create(const sample *s, VkDeviceSize bytes);
void sample_buffer_destroy(const sample *s, sample_buffer *buffer);

void sample_barrier(VkCommandBuffer commands, VkImage image, sample_use from, sample_use to);

/* Copies part of an image, rows tight, visible to the CPU once the commands are done. */
void sample_copy(VkCommandBuffer commands, const sample_image *image, VkImageLayout layout, VkRect2D part,
                 const sample_buffer *to);

#endif
