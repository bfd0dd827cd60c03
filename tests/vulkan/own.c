/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "own.h"

#include <dlfcn.h>
#include <stdio.h>
#include <string.h>

own_device own;

static PFN_vkVoidFunction own_function_if(const char *name) {
    if (own.device)
        return ((PFN_vkGetDeviceProcAddr)own.get_instance_proc_addr(own.instance, "vkGetDeviceProcAddr"))(own.device,
                                                                                                          name);
    return own.get_instance_proc_addr(own.instance, name);
}

PFN_vkVoidFunction own_function(const char *name) {
    PFN_vkVoidFunction f = own_function_if(name);
    if (!f) f = own.get_instance_proc_addr(own.instance, name);
    if (!f) fail_msg("this Vulkan has no %s", name);
    return f;
}

void own_check(VkResult result, const char *what) {
    if (result != VK_SUCCESS) fail_msg("%s: VkResult %d", what, (int)result);
}

/* ---- opening */

static const char *open_instance(uint32_t api) {
    static void *library;
    if (!library) library = dlopen("libvulkan.so.1", RTLD_NOW | RTLD_LOCAL);
    if (!library) return "there is no libvulkan.so.1";
    void *symbol = dlsym(library, "vkGetInstanceProcAddr");
    memcpy(&own.get_instance_proc_addr, &symbol, sizeof symbol);
    const VkApplicationInfo application = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO, .apiVersion = api};
    const VkInstanceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                                       .pApplicationInfo = &application};
    if (VK(vkCreateInstance)(&info, NULL, &own.instance) != VK_SUCCESS) return "there is no Vulkan driver";
    VkPhysicalDevice devices[8];
    uint32_t count = COUNT(devices);
    VK(vkEnumeratePhysicalDevices)(own.instance, &count, devices);
    for (uint32_t i = 0; i < count && !own.physical; i++) {
        VK(vkGetPhysicalDeviceProperties)(devices[i], &own.properties);
        if (!gpu_wanted_only() || own.properties.deviceType != VK_PHYSICAL_DEVICE_TYPE_CPU) own.physical = devices[i];
    }
    if (own.physical) return NULL;
    return count ? "there is no GPU here, only software" : "there is no Vulkan device";
}

static const char *choose_family(void) {
    VkQueueFamilyProperties families[16];
    uint32_t count = COUNT(families);
    VK(vkGetPhysicalDeviceQueueFamilyProperties)(own.physical, &count, families);
    for (int graphics = 1; graphics >= 0; graphics--) /* sprites are drawn */
        for (own.family = 0; own.family < count; own.family++)
            if (families[own.family].queueFlags & VK_QUEUE_COMPUTE_BIT &&
                (!graphics || families[own.family].queueFlags & VK_QUEUE_GRAPHICS_BIT))
                return NULL;
    return "no queue of the Vulkan device computes";
}

/* Of what the device has, what the library needs or may use. */
static const char *choose_features(bool bare) {
    own.size_control.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_SIZE_CONTROL_FEATURES;
    own.synchronization2.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SYNCHRONIZATION_2_FEATURES;
    own.features.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2;
    own.features.pNext = &own.synchronization2;
    own.synchronization2.pNext = bare ? NULL : &own.size_control;
    VK(vkGetPhysicalDeviceFeatures2)(own.physical, &own.features);
    const VkPhysicalDeviceFeatures all = own.features.features;
    own.features.features =
        (VkPhysicalDeviceFeatures){.geometryShader = all.geometryShader && !bare,
                                   .shaderStorageImageWriteWithoutFormat = all.shaderStorageImageWriteWithoutFormat};
    if (!own.synchronization2.synchronization2) return "the Vulkan device has no synchronization2";
    if (!all.shaderStorageImageWriteWithoutFormat)
        return "the Vulkan device has no shaderStorageImageWriteWithoutFormat";
    return NULL;
}

static void open_device(uint32_t api) {
    static const char *const extensions[] = {"VK_KHR_synchronization2", "VK_EXT_subgroup_size_control"};
    const float priority = 1;
    const VkDeviceQueueCreateInfo queue = {.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                           .queueFamilyIndex = own.family,
                                           .queueCount = 1,
                                           .pQueuePriorities = &priority};
    const VkDeviceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                                     .pNext = &own.features,
                                     .queueCreateInfoCount = 1,
                                     .pQueueCreateInfos = &queue,
                                     .enabledExtensionCount = api < VK_API_VERSION_1_3 ? COUNT(extensions) : 0,
                                     .ppEnabledExtensionNames = extensions};
    CHECK(VK(vkCreateDevice)(own.physical, &info, NULL, &own.device));
    VK(vkGetDeviceQueue)(own.device, own.family, 0, &own.queue);
    const VkCommandPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                          .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
                                          .queueFamilyIndex = own.family};
    CHECK(VK(vkCreateCommandPool)(own.device, &pool, NULL, &own.pool));
}

const char *own_open(uint32_t api, bool bare) {
    memset(&own, 0, sizeof own);
    const char *missing = open_instance(api);
    if (!missing) {
        VK(vkGetPhysicalDeviceMemoryProperties)(own.physical, &own.memory);
        missing = own.properties.apiVersion < api ? "the Vulkan device is older than 1.3" : choose_family();
    }
    if (!missing) missing = choose_features(bare);
    if (!missing) open_device(api);
    if (missing) own_close();
    return missing;
}

void own_close(void) {
    if (own.device) {
        VK(vkDestroyCommandPool)(own.device, own.pool, NULL);
        VK(vkDestroyDevice)(own.device, NULL);
        own.device = VK_NULL_HANDLE;
    }
    if (own.instance) VK(vkDestroyInstance)(own.instance, NULL);
    memset(&own, 0, sizeof own);
}

/* ---- memory and commands */

VkDeviceMemory own_memory(VkDeviceSize size, uint32_t bits, VkMemoryPropertyFlags wanted) {
    VkDeviceMemory memory = VK_NULL_HANDLE;
    for (uint32_t i = 0; i < own.memory.memoryTypeCount && !memory; i++) {
        const VkMemoryAllocateInfo info = {
            .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, .allocationSize = size, .memoryTypeIndex = i};
        if (bits >> i & 1 && (own.memory.memoryTypes[i].propertyFlags & wanted) == wanted)
            CHECK(VK(vkAllocateMemory)(own.device, &info, NULL, &memory));
    }
    if (!memory) fail_msg("no type of memory among %x has %x", bits, wanted);
    return memory;
}

VkCommandBuffer own_begin(void) {
    VkCommandBuffer commands;
    const VkCommandBufferAllocateInfo allocate = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                                  .commandPool = own.pool,
                                                  .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                                  .commandBufferCount = 1};
    const VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    CHECK(VK(vkAllocateCommandBuffers)(own.device, &allocate, &commands));
    CHECK(VK(vkBeginCommandBuffer)(commands, &begin));
    return commands;
}

void own_end(VkCommandBuffer commands) {
    CHECK(VK(vkEndCommandBuffer)(commands));
}

void own_submit(VkCommandBuffer commands) {
    const VkSubmitInfo submit = {
        .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 1, .pCommandBuffers = &commands};
    CHECK(VK(vkQueueSubmit)(own.queue, 1, &submit, VK_NULL_HANDLE));
    CHECK(VK(vkQueueWaitIdle)(own.queue));
}

void own_forget(VkCommandBuffer commands) {
    VK(vkFreeCommandBuffers)(own.device, own.pool, 1, &commands);
}

void own_finish(VkCommandBuffer commands) {
    own_end(commands);
    own_submit(commands);
    own_forget(commands);
}

int run_with_own(const char *group, const struct CMUnitTest *tests, int count) {
    const char *missing = NULL;
#ifdef THREAD_SANITIZER
    missing = "the driver's compiler does not run under ThreadSanitizer";
#else
    missing = own_open(VK_API_VERSION_1_3, false);
#endif
    const int failed = run_gpu_tests(group, tests, count, missing);
    if (!missing) own_close();
    return failed;
}
