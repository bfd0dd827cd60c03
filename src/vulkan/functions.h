/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The Vulkan functions that recording needs, each once. */
#ifndef DDOF_VULKAN_FUNCTIONS_H
#define DDOF_VULKAN_FUNCTIONS_H

#include <stdbool.h>

#include <ddof/vulkan.h>

#define VULKAN_INSTANCE_FUNCTIONS(X)                                                                                   \
    X(GetDeviceProcAddr)                                                                                               \
    X(GetPhysicalDeviceFeatures2)                                                                                      \
    X(GetPhysicalDeviceFormatProperties2)                                                                              \
    X(GetPhysicalDeviceMemoryProperties)                                                                               \
    X(GetPhysicalDeviceProperties)                                                                                     \
    X(GetPhysicalDeviceProperties2)                                                                                    \
    X(GetPhysicalDeviceQueueFamilyProperties)

#define VULKAN_DEVICE_FUNCTIONS(X)                                                                                     \
    X(AllocateDescriptorSets)                                                                                          \
    X(AllocateMemory)                                                                                                  \
    X(BindBufferMemory)                                                                                                \
    X(BindImageMemory)                                                                                                 \
    X(CmdBeginRenderPass)                                                                                              \
    X(CmdBindDescriptorSets)                                                                                           \
    X(CmdBindPipeline)                                                                                                 \
    X(CmdCopyBuffer)                                                                                                   \
    X(CmdDispatch)                                                                                                     \
    X(CmdDrawIndirect)                                                                                                 \
    X(CmdEndRenderPass)                                                                                                \
    X(CmdFillBuffer)                                                                                                   \
    X(CmdPipelineBarrier2)                                                                                             \
    X(CmdPushConstants)                                                                                                \
    X(CmdSetScissor)                                                                                                   \
    X(CmdSetViewport)                                                                                                  \
    X(CmdUpdateBuffer)                                                                                                 \
    X(CmdWriteTimestamp)                                                                                               \
    X(CreateBuffer)                                                                                                    \
    X(CreateComputePipelines)                                                                                          \
    X(CreateDescriptorPool)                                                                                            \
    X(CreateDescriptorSetLayout)                                                                                       \
    X(CreateFramebuffer)                                                                                               \
    X(CreateGraphicsPipelines)                                                                                         \
    X(CreateImage)                                                                                                     \
    X(CreateImageView)                                                                                                 \
    X(CreatePipelineCache)                                                                                             \
    X(CreatePipelineLayout)                                                                                            \
    X(CreateRenderPass)                                                                                                \
    X(CreateShaderModule)                                                                                              \
    X(DestroyBuffer)                                                                                                   \
    X(DestroyDescriptorPool)                                                                                           \
    X(DestroyDescriptorSetLayout)                                                                                      \
    X(DestroyFramebuffer)                                                                                              \
    X(DestroyImage)                                                                                                    \
    X(DestroyImageView)                                                                                                \
    X(DestroyPipeline)                                                                                                 \
    X(DestroyPipelineCache)                                                                                            \
    X(DestroyPipelineLayout)                                                                                           \
    X(DestroyRenderPass)                                                                                               \
    X(DestroyShaderModule)                                                                                             \
    X(FreeMemory)                                                                                                      \
    X(GetBufferMemoryRequirements)                                                                                     \
    X(GetImageMemoryRequirements)                                                                                      \
    X(GetPipelineCacheData)                                                                                            \
    X(UpdateDescriptorSets)

typedef struct vulkan_functions {
#define X(name) PFN_vk##name name;
    VULKAN_INSTANCE_FUNCTIONS(X)
    VULKAN_DEVICE_FUNCTIONS(X)
#undef X
} vulkan_functions;

/* NULL, or the name of the first function that is not there. */
const char *vulkan_functions_load(vulkan_functions *f, PFN_vkGetInstanceProcAddr get, VkInstance instance,
                                  VkDevice device);

#endif
