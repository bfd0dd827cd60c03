/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* A Vulkan instance and device of the test's own, found without the library's loader. */
#ifndef TESTS_VULKAN_OWN_H
#define TESTS_VULKAN_OWN_H

#include "../gpu/support.h"

#include <ddof/vulkan.h>

typedef struct own_device {
    PFN_vkGetInstanceProcAddr get_instance_proc_addr;
    VkInstance instance;
    VkPhysicalDevice physical;
    VkDevice device;
    uint32_t family;
    VkQueue queue;
    VkCommandPool pool;
    VkPhysicalDeviceProperties properties;
    VkPhysicalDeviceMemoryProperties memory;
    /* What was enabled, for ddof_vulkan_config.features. */
    VkPhysicalDeviceFeatures2 features;
    VkPhysicalDeviceSynchronization2Features synchronization2;
    VkPhysicalDeviceSubgroupSizeControlFeatures size_control;
} own_device;
extern own_device own;

/* A function of the device, or of the instance. VK() must find it. */
PFN_vkVoidFunction own_function(const char *name);
#define VK(name) ((PFN_##name)own_function(#name))

/* `api`: of the instance. `bare`: with no feature but those that the library needs. NULL, or why there is none. */
const char *own_open(uint32_t api, bool bare);
void own_close(void);

/* Fails where the result is not VK_SUCCESS. */
void own_check(VkResult result, const char *what);
#define CHECK(call) own_check(call, #call)

/* Memory of a type among `bits` with all of `wanted`. */
VkDeviceMemory own_memory(VkDeviceSize size, uint32_t bits, VkMemoryPropertyFlags wanted);

VkCommandBuffer own_begin(void);
void own_end(VkCommandBuffer commands);
void own_submit(VkCommandBuffer commands); /* and waits */
void own_forget(VkCommandBuffer commands);
void own_finish(VkCommandBuffer commands); /* the last three in a row */

/* Runs the tests with a device of Vulkan 1.3; skips them where there is none. */
int run_with_own(const char *group, const struct CMUnitTest *tests, int count);

#endif
