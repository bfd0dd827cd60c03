/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* What a ddof_vulkan and a ddof_vulkan_frame hold. The parts: functions (of Vulkan), modules and pipelines (the
 * shaders), device (what all frames share), line (how LINE cuts lines), frame (images, scratch, descriptor sets),
 * passes (the method), sprites and sprite_target (what is drawn before or instead), interop (ddof/vulkan.h), and for the backend of ddof_render() loader and backend. */
#ifndef DDOF_VULKAN_DEVICE_H
#define DDOF_VULKAN_DEVICE_H

#include "../context.h"
#include "functions.h"
#include "line.h"
#include "pipelines.h"

struct ddof_vulkan {
    ddof_vulkan_config config; /* all callbacks filled in, but log */
    ddof_context shell;        /* for its error text and log */
    VkAllocationCallbacks allocator_copy;
    const VkAllocationCallbacks *allocator; /* NULL, or the copy */
    vulkan_functions f;
    VkPhysicalDeviceLimits limits;
    uint32_t version; /* of the device */
    VkPhysicalDeviceMemoryProperties memory;
    char name[VK_MAX_PHYSICAL_DEVICE_NAME_SIZE];
    line_limits line;
    bool graphics, geometry; /* the queue family draws; geometry shaders are enabled */
    VkDescriptorSetLayout set_layout;
    VkPipelineLayout pipeline_layout;
    VkPipelineCache pipeline_cache;
    vulkan_pipelines pipelines;
};

/* Bindings of pass.glsl, levels.comp and disc_line.comp. */
enum {
    BIND_COLOR,
    BIND_MAP,
    BIND_TARGET,
    BIND_LEVELS_IN,
    BIND_LEVELS_OUT,
    BIND_IMAGINARY,
    BIND_TARGET_IMAGINARY,
    BIND_SUM,
    VULKAN_BINDINGS
};
extern const VkDescriptorType vulkan_binding_types[VULKAN_BINDINGS];

/* DDOF_OK, or the error that `result` means, set in the context; what was being done goes after "while". */
ddof_status vulkan_result(ddof_context *ctx, const char *device, VkResult result, const char *doing);
ddof_status vulkan_device_check(ddof_vulkan *vk, VkResult result, const char *doing);

/* device.c: on failure *vk is NULL and `text` says why. */
ddof_status vulkan_device_create(ddof_vulkan **vk, const ddof_vulkan_config *config, char *text, size_t size);
void vulkan_device_destroy(ddof_vulkan **vk);
/* A memory type among `bits`, on the device where there is one; UINT32_MAX: none. */
uint32_t vulkan_device_memory(const ddof_vulkan *vk, uint32_t bits);

#endif
