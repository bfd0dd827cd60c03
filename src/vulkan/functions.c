/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "functions.h"

#include <string.h>

/* Functions of an extension have its suffix. */
static PFN_vkVoidFunction of_device(const vulkan_functions *f, VkDevice device, const char *name) {
    PFN_vkVoidFunction found = f->GetDeviceProcAddr(device, name);
    if (!found && strcmp(name, "vkCmdPipelineBarrier2") == 0)
        found = f->GetDeviceProcAddr(device, "vkCmdPipelineBarrier2KHR");
    return found;
}

const char *vulkan_functions_load(vulkan_functions *f, PFN_vkGetInstanceProcAddr get, VkInstance instance,
                                  VkDevice device) {
#define X(name)                                                                                                        \
    f->name = (PFN_vk##name)get(instance, "vk" #name);                                                                 \
    if (!f->name) return "vk" #name;
    VULKAN_INSTANCE_FUNCTIONS(X)
#undef X
#define X(name)                                                                                                        \
    f->name = (PFN_vk##name)of_device(f, device, "vk" #name);                                                          \
    if (!f->name) return "vk" #name;
    VULKAN_DEVICE_FUNCTIONS(X)
#undef X
    return NULL;
}
