/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* A Vulkan device of the library's own, for ddof_render(), the bench and the list of devices: the loader is found at run time.
 * Thread-safety: one call at a time per session. */
#ifndef DDOF_VULKAN_LOADER_H
#define DDOF_VULKAN_LOADER_H

#include <stdbool.h>

#include <ddof/vulkan.h>

/* Made by vulkan_open(), with all features enabled that ddof/vulkan.h names and the device has. Not to be copied: `features`
 * points into it. */
typedef struct vulkan_session {
    void *library; /* of dlopen(), never closed: drivers do not all survive it */
    PFN_vkGetInstanceProcAddr get_instance_proc_addr;
    PFN_vkGetDeviceProcAddr get_device_proc_addr;
    VkInstance instance;
    VkPhysicalDevice physical_device;
    VkDevice device;
    uint32_t family; /* of `queue`: compute and transfer; with graphics, and with timestamps, where there is one */
    VkQueue queue;
    VkPhysicalDeviceMemoryProperties memory;
    VkPhysicalDeviceProperties properties;
    VkPhysicalDeviceFeatures2 features; /* what was enabled, for ddof_vulkan_config; its chain: */
    VkPhysicalDeviceSynchronization2Features synchronization2;
    VkPhysicalDeviceSubgroupSizeControlFeatures subgroup_size;
} vulkan_session;

/* The `index`-th device of vulkan_list(). False: `text` says why, and nothing is left open; *status is UNSUPPORTED, INVALID (no
 * such index), MEMORY or DEVICE. */
bool vulkan_open(vulkan_session *s, int index, ddof_status *status, char *text, size_t size);
void vulkan_close(vulkan_session *s);

/* As ddof_devices(). */
int vulkan_list(ddof_device *devices, int capacity);

/* A function of the device (or of the instance), or NULL. */
PFN_vkVoidFunction vulkan_function(const vulkan_session *s, const char *name);

/* A memory type among `bits` that has all of `wanted` and, where there is a choice, of `liked`; UINT32_MAX: none. */
uint32_t vulkan_memory_type(const VkPhysicalDeviceMemoryProperties *memory, uint32_t bits, VkMemoryPropertyFlags wanted,
                            VkMemoryPropertyFlags liked);

#endif
