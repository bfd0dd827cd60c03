/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "vulkan_sample.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

void sample_fail(const char *what, ...) {
    va_list arguments;
    va_start(arguments, what);
    fprintf(stderr, "%s: ", sample_program);
    vfprintf(stderr, what, arguments);
    fputc('\n', stderr);
    va_end(arguments);
    exit(1);
}

void sample_check(VkResult result, const char *call) {
    if (result != VK_SUCCESS) sample_fail("%s gave VkResult %d", call, (int)result);
}

/* Whether the device has what ddof needs, and in which family of queues. What ddof likes to have is enabled, too. */
static bool usable(sample *s, VkPhysicalDevice gpu) {
    VkQueueFamilyProperties families[16];
    uint32_t count = 16;
    const VkQueueFlags both = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
    vkGetPhysicalDeviceProperties(gpu, &s->properties);
    if (s->properties.apiVersion < VK_API_VERSION_1_3) return false;
    vkGetPhysicalDeviceQueueFamilyProperties(gpu, &count, families);
    for (s->family = 0; s->family < count && (families[s->family].queueFlags & both) != both;) s->family++;

    VkPhysicalDeviceVulkan13Features has13 = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES};
    VkPhysicalDeviceFeatures2 has = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, .pNext = &has13};
    vkGetPhysicalDeviceFeatures2(gpu, &has);
    s->features13 = (VkPhysicalDeviceVulkan13Features){
        .sType = has13.sType,
        .synchronization2 = VK_TRUE,
        .subgroupSizeControl = has13.subgroupSizeControl,
        .computeFullSubgroups = has13.computeFullSubgroups,
    };
    s->features = (VkPhysicalDeviceFeatures2){.sType = has.sType, .pNext = &s->features13};
    s->features.features.shaderStorageImageWriteWithoutFormat = VK_TRUE;
    return s->family < count && has13.synchronization2 && has.features.shaderStorageImageWriteWithoutFormat;
}

static void open_device(sample *s, bool swapchain) {
    VkPhysicalDevice gpus[16];
    uint32_t count = 16;
    VkResult result = vkEnumeratePhysicalDevices(s->instance, &count, gpus);
    if (result != VK_INCOMPLETE) sample_check(result, "vkEnumeratePhysicalDevices");
    for (int software = 0; software < 2 && !s->gpu; software++)
        for (uint32_t i = 0; i < count && !s->gpu; i++)
            if (usable(s, gpus[i]) && (s->properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU) == software)
                s->gpu = gpus[i];
    if (!s->gpu) sample_fail("no Vulkan 1.3 device with what ddof needs");
    vkGetPhysicalDeviceMemoryProperties(s->gpu, &s->memory);

    const float priority = 1;
    const VkDeviceQueueCreateInfo queue = {.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                           .queueFamilyIndex = s->family,
                                           .queueCount = 1, .pQueuePriorities = &priority};
    const char *const extension = VK_KHR_SWAPCHAIN_EXTENSION_NAME;
    const VkDeviceCreateInfo device = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, .pNext = &s->features,
                                       .queueCreateInfoCount = 1, .pQueueCreateInfos = &queue,
                                       .enabledExtensionCount = swapchain, .ppEnabledExtensionNames = &extension};
    SAMPLE_VK(vkCreateDevice(s->gpu, &device, NULL, &s->device));
    vkGetDeviceQueue(s->device, s->family, 0, &s->queue);
    const VkCommandPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                          .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
                                          .queueFamilyIndex = s->family};
    SAMPLE_VK(vkCreateCommandPool(s->device, &pool, NULL, &s->pool));
}

void sample_open(sample *s, const char *const *extensions, uint32_t count) {
    *s = (sample){0};
    const VkApplicationInfo about = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO, .pApplicationName = sample_program,
                                     .apiVersion = VK_API_VERSION_1_3};
    const VkInstanceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO, .pApplicationInfo = &about,
                                       .enabledExtensionCount = count, .ppEnabledExtensionNames = extensions};
    const VkResult result = vkCreateInstance(&info, NULL, &s->instance);
    if (result == VK_ERROR_INCOMPATIBLE_DRIVER) sample_fail("no Vulkan driver");
    sample_check(result, "vkCreateInstance");
    open_device(s, count > 0);
}

void sample_close(sample *s) {
    vkDestroyCommandPool(s->device, s->pool, NULL);
    vkDestroyDevice(s->device, NULL);
    vkDestroyInstance(s->instance, NULL);
    *s = (sample){0};
}

VkCommandBuffer sample_commands(const sample *s) {
    VkCommandBuffer commands;
    const VkCommandBufferAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                              .commandPool = s->pool, .commandBufferCount = 1};
    SAMPLE_VK(vkAllocateCommandBuffers(s->device, &info, &commands));
    return commands;
}

void sample_begin(VkCommandBuffer commands) {
    const VkCommandBufferBeginInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                           .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
    SAMPLE_VK(vkBeginCommandBuffer(commands, &info));
}

/* An allocation for each resource: an engine would share them out. */
static VkDeviceMemory allocate(const sample *s, VkMemoryRequirements needs, VkMemoryPropertyFlags wanted) {
    VkMemoryAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, .allocationSize = needs.size};
    while (info.memoryTypeIndex < s->memory.memoryTypeCount &&
           (!(needs.memoryTypeBits >> info.memoryTypeIndex & 1) ||
            (s->memory.memoryTypes[info.memoryTypeIndex].propertyFlags & wanted) != wanted))
        info.memoryTypeIndex++;
    if (info.memoryTypeIndex == s->memory.memoryTypeCount) sample_fail("no memory with properties 0x%x", wanted);
    VkDeviceMemory memory;
    SAMPLE_VK(vkAllocateMemory(s->device, &info, NULL, &memory));
    return memory;
}

sample_image sample_image_create(const sample *s, uint32_t width, uint32_t height, VkFormat format,
                                 VkImageUsageFlags usage) {
    sample_image made = {.format = format, .usage = usage, .width = width, .height = height};
    const VkImageCreateInfo image = {.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO, .imageType = VK_IMAGE_TYPE_2D,
                                     .format = format, .extent = {width, height, 1}, .mipLevels = 1, .arrayLayers = 1,
                                     .samples = VK_SAMPLE_COUNT_1_BIT, .usage = usage};
    SAMPLE_VK(vkCreateImage(s->device, &image, NULL, &made.image));
    VkMemoryRequirements needs;
    vkGetImageMemoryRequirements(s->device, made.image, &needs);
    made.memory = allocate(s, needs, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
    SAMPLE_VK(vkBindImageMemory(s->device, made.image, made.memory, 0));
    const VkImageViewCreateInfo view = {.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO, .image = made.image,
                                        .viewType = VK_IMAGE_VIEW_TYPE_2D, .format = format,
                                        .subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1}};
    SAMPLE_VK(vkCreateImageView(s->device, &view, NULL, &made.view));
    return made;
}

void sample_image_destroy(const sample *s, sample_image *image) {
    vkDestroyImageView(s->device, image->view, NULL);
    vkDestroyImage(s->device, image->image, NULL);
    vkFreeMemory(s->device, image->memory, NULL);
    *image = (sample_image){0};
}

sample_buffer sample_buffer_create(const sample *s, VkDeviceSize bytes) {
    sample_buffer made;
    const VkBufferCreateInfo info = {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .size = bytes,
                                     .usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT};
    SAMPLE_VK(vkCreateBuffer(s->device, &info, NULL, &made.buffer));
    VkMemoryRequirements needs;
    vkGetBufferMemoryRequirements(s->device, made.buffer, &needs);
    made.memory = allocate(s, needs, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
    SAMPLE_VK(vkBindBufferMemory(s->device, made.buffer, made.memory, 0));
    SAMPLE_VK(vkMapMemory(s->device, made.memory, 0, VK_WHOLE_SIZE, 0, &made.data));
    return made;
}

void sample_buffer_destroy(const sample *s, sample_buffer *buffer) {
    vkDestroyBuffer(s->device, buffer->buffer, NULL);
    vkFreeMemory(s->device, buffer->memory, NULL);
    *buffer = (sample_buffer){0};
}

void sample_barrier(VkCommandBuffer commands, VkImage image, sample_use from, sample_use to) {
    const VkImageMemoryBarrier2 barrier = {
        .sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2,
        .srcStageMask = from.stage, .srcAccessMask = from.access, .oldLayout = from.layout,
        .dstStageMask = to.stage, .dstAccessMask = to.access, .newLayout = to.layout,
        .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED, .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
        .image = image, .subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1},
    };
    const VkDependencyInfo dependency = {.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO, .imageMemoryBarrierCount = 1,
                                         .pImageMemoryBarriers = &barrier};
    vkCmdPipelineBarrier2(commands, &dependency);
}

void sample_copy(VkCommandBuffer commands, const sample_image *image, VkImageLayout layout, VkRect2D part,
                 const sample_buffer *to) {
    const VkBufferImageCopy region = {.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1},
                                      .imageOffset = {part.offset.x, part.offset.y, 0},
                                      .imageExtent = {part.extent.width, part.extent.height, 1}};
    vkCmdCopyImageToBuffer(commands, image->image, layout, to->buffer, 1, &region);
    const VkMemoryBarrier2 barrier = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
                                      .srcStageMask = VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
                                      .srcAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT,
                                      .dstStageMask = VK_PIPELINE_STAGE_2_HOST_BIT,
                                      .dstAccessMask = VK_ACCESS_2_HOST_READ_BIT};
    const VkDependencyInfo dependency = {.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO, .memoryBarrierCount = 1,
                                         .pMemoryBarriers = &barrier};
    vkCmdPipelineBarrier2(commands, &dependency);
}
