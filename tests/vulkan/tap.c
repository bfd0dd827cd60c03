/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "tap.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "vulkan/pipelines.h"

vulkan_tap tap;
const char *tap_names[TAP_NAMES];
int tap_name_count;
char said[600];

static bool fails(void) {
    return ++tap.calls == tap.fail_at;
}

static bool wait_fails(void) {
    return ++tap.waits == tap.wait_at;
}

/* Where the name was asked for last. */
static PFN_vkVoidFunction real_function(const char *name);
#define REAL(name) ((PFN_##name)real_function(#name))

/* ---- objects */

/* These have one shape each, but for the types of the handles. */
#define TAP_CREATE(what, create_info)                                                                                  \
    static VKAPI_ATTR VkResult VKAPI_CALL create_##what(VkDevice device, const create_info *info,                      \
                                                        const VkAllocationCallbacks *allocator, Vk##what *made) {      \
        *made = VK_NULL_HANDLE;                                                                                        \
        const VkResult result = fails() ? tap.fail_with : REAL(vkCreate##what)(device, info, allocator, made);         \
        tap.live += result == VK_SUCCESS;                                                                              \
        return result;                                                                                                 \
    }                                                                                                                  \
    static VKAPI_ATTR void VKAPI_CALL destroy_##what(VkDevice device, Vk##what made,                                   \
                                                     const VkAllocationCallbacks *allocator) {                         \
        tap.live -= made != VK_NULL_HANDLE;                                                                            \
        REAL(vkDestroy##what)(device, made, allocator);                                                                \
    }
TAP_CREATE(Buffer, VkBufferCreateInfo)
TAP_CREATE(BufferView, VkBufferViewCreateInfo)
TAP_CREATE(CommandPool, VkCommandPoolCreateInfo)
TAP_CREATE(DescriptorPool, VkDescriptorPoolCreateInfo)
TAP_CREATE(DescriptorSetLayout, VkDescriptorSetLayoutCreateInfo)
TAP_CREATE(Fence, VkFenceCreateInfo)
TAP_CREATE(Framebuffer, VkFramebufferCreateInfo)
TAP_CREATE(Image, VkImageCreateInfo)
TAP_CREATE(ImageView, VkImageViewCreateInfo)
TAP_CREATE(PipelineCache, VkPipelineCacheCreateInfo)
TAP_CREATE(PipelineLayout, VkPipelineLayoutCreateInfo)
TAP_CREATE(QueryPool, VkQueryPoolCreateInfo)
TAP_CREATE(RenderPass, VkRenderPassCreateInfo)
TAP_CREATE(Sampler, VkSamplerCreateInfo)
TAP_CREATE(Semaphore, VkSemaphoreCreateInfo)
TAP_CREATE(ShaderModule, VkShaderModuleCreateInfo)

/* The shaders of LINE with subgroups, without: shuffles go through shared memory. */
static const uint32_t line_shared[] = {
#include "line_shared.inc"
};
static const uint32_t disc_line_shared[] = {
#include "disc_line_shared.inc"
};

static VKAPI_ATTR VkResult VKAPI_CALL create_module(VkDevice device, const VkShaderModuleCreateInfo *info,
                                                    const VkAllocationCallbacks *allocator, VkShaderModule *made) {
    VkShaderModuleCreateInfo other = *info;
    if (tap.subgroup && info->pCode == vulkan_codes[MODULE_LINE_SUBGROUPS].word) {
        other.codeSize = sizeof line_shared;
        other.pCode = line_shared;
    }
    if (tap.subgroup && info->pCode == vulkan_codes[MODULE_DISC_LINE_SUBGROUPS].word) {
        other.codeSize = sizeof disc_line_shared;
        other.pCode = disc_line_shared;
    }
    return create_ShaderModule(device, &other, allocator, made);
}

static VKAPI_ATTR VkResult VKAPI_CALL create_pipelines(VkDevice device, VkPipelineCache cache, uint32_t count,
                                                       const VkComputePipelineCreateInfo *info,
                                                       const VkAllocationCallbacks *allocator, VkPipeline *made) {
    memset(made, 0, count * sizeof *made);
    VkComputePipelineCreateInfo one = *info;
    if (tap.subgroup) { /* what the device has not is not asked of it */
        assert_int_equal(count, 1);
        one.stage.pNext = NULL;
        one.stage.flags = 0;
    }
    const VkResult result =
        fails() ? tap.fail_with
                : REAL(vkCreateComputePipelines)(device, cache, count, tap.subgroup ? &one : info, allocator, made);
    for (uint32_t i = 0; i < count; i++)
        tap.live += made[i] != VK_NULL_HANDLE;
    return result;
}

static VKAPI_ATTR VkResult VKAPI_CALL create_graphics(VkDevice device, VkPipelineCache cache, uint32_t count,
                                                      const VkGraphicsPipelineCreateInfo *info,
                                                      const VkAllocationCallbacks *allocator, VkPipeline *made) {
    memset(made, 0, count * sizeof *made);
    const VkResult result =
        fails() ? tap.fail_with : REAL(vkCreateGraphicsPipelines)(device, cache, count, info, allocator, made);
    for (uint32_t i = 0; i < count; i++)
        tap.live += made[i] != VK_NULL_HANDLE;
    return result;
}

static VKAPI_ATTR void VKAPI_CALL destroy_Pipeline(VkDevice device, VkPipeline made,
                                                   const VkAllocationCallbacks *allocator) {
    tap.live -= made != VK_NULL_HANDLE;
    REAL(vkDestroyPipeline)(device, made, allocator);
}

static VKAPI_ATTR VkResult VKAPI_CALL create_device(VkPhysicalDevice physical, const VkDeviceCreateInfo *info,
                                                    const VkAllocationCallbacks *allocator, VkDevice *made) {
    *made = VK_NULL_HANDLE;
    const VkResult result = fails() ? tap.fail_with : REAL(vkCreateDevice)(physical, info, allocator, made);
    tap.live += result == VK_SUCCESS;
    return result;
}

static VKAPI_ATTR void VKAPI_CALL destroy_device(VkDevice made, const VkAllocationCallbacks *allocator) {
    tap.live -= made != VK_NULL_HANDLE;
    REAL(vkDestroyDevice)(made, allocator);
}

static VKAPI_ATTR VkResult VKAPI_CALL allocate_memory(VkDevice device, const VkMemoryAllocateInfo *info,
                                                      const VkAllocationCallbacks *allocator, VkDeviceMemory *made) {
    *made = VK_NULL_HANDLE;
    const VkResult result = fails() ? tap.fail_with : REAL(vkAllocateMemory)(device, info, allocator, made);
    tap.live += result == VK_SUCCESS;
    return result;
}

static VKAPI_ATTR void VKAPI_CALL free_memory(VkDevice device, VkDeviceMemory made,
                                              const VkAllocationCallbacks *allocator) {
    tap.live -= made != VK_NULL_HANDLE;
    REAL(vkFreeMemory)(device, made, allocator);
}

/* ---- other calls that may fail: what they make goes with its pool */

static VKAPI_ATTR VkResult VKAPI_CALL allocate_sets(VkDevice device, const VkDescriptorSetAllocateInfo *info,
                                                    VkDescriptorSet *made) {
    memset(made, 0, info->descriptorSetCount * sizeof *made);
    return fails() ? tap.fail_with : REAL(vkAllocateDescriptorSets)(device, info, made);
}

static VKAPI_ATTR VkResult VKAPI_CALL allocate_commands(VkDevice device, const VkCommandBufferAllocateInfo *info,
                                                        VkCommandBuffer *made) {
    memset(made, 0, info->commandBufferCount * sizeof *made);
    return fails() ? tap.fail_with : REAL(vkAllocateCommandBuffers)(device, info, made);
}

static VKAPI_ATTR VkResult VKAPI_CALL bind_buffer(VkDevice device, VkBuffer buffer, VkDeviceMemory memory,
                                                  VkDeviceSize offset) {
    return fails() ? tap.fail_with : REAL(vkBindBufferMemory)(device, buffer, memory, offset);
}

static VKAPI_ATTR VkResult VKAPI_CALL bind_image(VkDevice device, VkImage image, VkDeviceMemory memory,
                                                 VkDeviceSize offset) {
    return fails() ? tap.fail_with : REAL(vkBindImageMemory)(device, image, memory, offset);
}

static VKAPI_ATTR VkResult VKAPI_CALL map_memory(VkDevice device, VkDeviceMemory memory, VkDeviceSize offset,
                                                 VkDeviceSize size, VkMemoryMapFlags flags, void **data) {
    return fails() ? tap.fail_with : REAL(vkMapMemory)(device, memory, offset, size, flags, data);
}

static VKAPI_ATTR VkResult VKAPI_CALL cache_data(VkDevice device, VkPipelineCache cache, size_t *size, void *data) {
    return fails() ? tap.fail_with : REAL(vkGetPipelineCacheData)(device, cache, size, data);
}

static VKAPI_ATTR VkResult VKAPI_CALL submit(VkQueue queue, uint32_t count, const VkSubmitInfo *info, VkFence fence) {
    return wait_fails() ? tap.fail_with : REAL(vkQueueSubmit)(queue, count, info, fence);
}

static VKAPI_ATTR VkResult VKAPI_CALL wait_for_fences(VkDevice device, uint32_t count, const VkFence *fences,
                                                      VkBool32 all, uint64_t timeout) {
    const VkResult result = REAL(vkWaitForFences)(device, count, fences, all, timeout);
    return wait_fails() ? tap.fail_with : result;
}

static VKAPI_ATTR VkResult VKAPI_CALL wait_idle(VkQueue queue) {
    const VkResult result = REAL(vkQueueWaitIdle)(queue);
    return wait_fails() ? tap.fail_with : result;
}

static VKAPI_ATTR void VKAPI_CALL dispatch(VkCommandBuffer commands, uint32_t x, uint32_t y, uint32_t z) {
    tap.dispatches++;
    REAL(vkCmdDispatch)(commands, x, y, z);
}

/* ---- lies */

static void lie_about_limits(VkPhysicalDeviceProperties *p) {
    VkPhysicalDeviceLimits *l = &p->limits;
    if (tap.api_version) p->apiVersion = tap.api_version;
    if (tap.invocations) {
        l->maxComputeWorkGroupInvocations = tap.invocations;
        for (int i = 0; i < 3; i++)
            l->maxComputeWorkGroupSize[i] = tap.invocations;
    }
    if (tap.shared_bytes) l->maxComputeSharedMemorySize = tap.shared_bytes;
    if (tap.max_side) l->maxImageDimension2D = tap.max_side;
    if (tap.buffer_range) l->maxStorageBufferRange = tap.buffer_range;
}

static void lie_about_subgroups(VkShaderStageFlags *stages, VkSubgroupFeatureFlags *operations) {
    if (tap.no_shuffle)
        *operations &= ~(VkFlags)(VK_SUBGROUP_FEATURE_SHUFFLE_BIT | VK_SUBGROUP_FEATURE_SHUFFLE_RELATIVE_BIT);
    if (tap.no_compute_subgroup) *stages &= ~(VkFlags)VK_SHADER_STAGE_COMPUTE_BIT;
}

static VKAPI_ATTR void VKAPI_CALL properties(VkPhysicalDevice physical, VkPhysicalDeviceProperties *p) {
    REAL(vkGetPhysicalDeviceProperties)(physical, p);
    lie_about_limits(p);
}

static VKAPI_ATTR void VKAPI_CALL properties2(VkPhysicalDevice physical, VkPhysicalDeviceProperties2 *p) {
    REAL(vkGetPhysicalDeviceProperties2)(physical, p);
    lie_about_limits(&p->properties);
    for (VkBaseOutStructure *s = p->pNext; s; s = s->pNext) {
        void *any = s;
        if (s->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES) {
            VkPhysicalDeviceSubgroupProperties *subgroup = any;
            lie_about_subgroups(&subgroup->supportedStages, &subgroup->supportedOperations);
        }
        if (s->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_PROPERTIES) {
            VkPhysicalDeviceVulkan11Properties *all = any;
            lie_about_subgroups(&all->subgroupSupportedStages, &all->subgroupSupportedOperations);
        }
        if (s->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_SIZE_CONTROL_PROPERTIES && tap.subgroup) {
            VkPhysicalDeviceSubgroupSizeControlProperties *size = any;
            size->minSubgroupSize = size->maxSubgroupSize = tap.subgroup;
            size->maxComputeWorkgroupSubgroups = 1024 / tap.subgroup;
        }
        if (s->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_SIZE_CONTROL_PROPERTIES && tap.no_required_size)
            ((VkPhysicalDeviceSubgroupSizeControlProperties *)any)->requiredSubgroupSizeStages = 0;
        if (s->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_PROPERTIES && tap.no_required_size)
            ((VkPhysicalDeviceVulkan13Properties *)any)->requiredSubgroupSizeStages = 0;
    }
}

static VKAPI_ATTR void VKAPI_CALL families(VkPhysicalDevice physical, uint32_t *count, VkQueueFamilyProperties *p) {
    REAL(vkGetPhysicalDeviceQueueFamilyProperties)(physical, count, p);
    for (uint32_t i = 0; p && tap.no_compute && i < *count; i++)
        p[i].queueFlags &= ~(VkFlags)VK_QUEUE_COMPUTE_BIT;
    for (uint32_t i = 0; p && tap.no_graphics && i < *count; i++)
        p[i].queueFlags &= ~(VkFlags)VK_QUEUE_GRAPHICS_BIT;
}

static void lie_about_format(VkFormat format, VkFormatFeatureFlags *optimal) {
    if (format == tap.no_storage) *optimal &= ~(VkFlags)VK_FORMAT_FEATURE_STORAGE_IMAGE_BIT;
    if (format == tap.no_blending) *optimal &= ~(VkFlags)VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BLEND_BIT;
    if (format == tap.no_sampling) *optimal &= ~(VkFlags)VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT;
}

static VKAPI_ATTR void VKAPI_CALL format_properties(VkPhysicalDevice physical, VkFormat format, VkFormatProperties *p) {
    REAL(vkGetPhysicalDeviceFormatProperties)(physical, format, p);
    lie_about_format(format, &p->optimalTilingFeatures);
}

static VKAPI_ATTR void VKAPI_CALL format_properties2(VkPhysicalDevice physical, VkFormat format,
                                                     VkFormatProperties2 *p) {
    REAL(vkGetPhysicalDeviceFormatProperties2)(physical, format, p);
    lie_about_format(format, &p->formatProperties.optimalTilingFeatures);
}

/* ---- finding functions */

static PFN_vkVoidFunction remember(const char *name, PFN_vkVoidFunction found) {
    for (int i = 0; i < tap_name_count; i++)
        if (!strcmp(tap_names[i], name)) return found;
    if (tap_name_count < TAP_NAMES) tap_names[tap_name_count++] = name; /* a literal of the library */
    return found;
}

static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL device_function(VkDevice device, const char *name) {
    return remember(name, tap_function(name, REAL(vkGetDeviceProcAddr)(device, name)));
}

#define TAPPED(name, function)                                                                                         \
    { name, (PFN_vkVoidFunction)function, NULL }
#define TAPPED_PAIR(what) TAPPED("vkCreate" #what, create_##what), TAPPED("vkDestroy" #what, destroy_##what)
static struct {
    const char *name;
    PFN_vkVoidFunction tapped, real;
} functions[] = {
    TAPPED_PAIR(Buffer),
    TAPPED_PAIR(BufferView),
    TAPPED_PAIR(CommandPool),
    TAPPED_PAIR(DescriptorPool),
    TAPPED_PAIR(DescriptorSetLayout),
    TAPPED_PAIR(Fence),
    TAPPED_PAIR(Framebuffer),
    TAPPED_PAIR(Image),
    TAPPED_PAIR(ImageView),
    TAPPED_PAIR(PipelineCache),
    TAPPED_PAIR(PipelineLayout),
    TAPPED_PAIR(QueryPool),
    TAPPED_PAIR(RenderPass),
    TAPPED_PAIR(Sampler),
    TAPPED_PAIR(Semaphore),
    TAPPED("vkCreateShaderModule", create_module),
    TAPPED("vkDestroyShaderModule", destroy_ShaderModule),
    TAPPED("vkCreateComputePipelines", create_pipelines),
    TAPPED("vkCreateGraphicsPipelines", create_graphics),
    TAPPED("vkDestroyPipeline", destroy_Pipeline),
    TAPPED("vkCreateDevice", create_device),
    TAPPED("vkDestroyDevice", destroy_device),
    TAPPED("vkAllocateMemory", allocate_memory),
    TAPPED("vkFreeMemory", free_memory),
    TAPPED("vkAllocateDescriptorSets", allocate_sets),
    TAPPED("vkAllocateCommandBuffers", allocate_commands),
    TAPPED("vkBindBufferMemory", bind_buffer),
    TAPPED("vkBindImageMemory", bind_image),
    TAPPED("vkMapMemory", map_memory),
    TAPPED("vkGetPipelineCacheData", cache_data),
    TAPPED("vkQueueSubmit", submit),
    TAPPED("vkWaitForFences", wait_for_fences),
    TAPPED("vkQueueWaitIdle", wait_idle),
    TAPPED("vkCmdDispatch", dispatch),
    TAPPED("vkGetPhysicalDeviceProperties", properties),
    TAPPED("vkGetPhysicalDeviceProperties2", properties2),
    TAPPED("vkGetPhysicalDeviceQueueFamilyProperties", families),
    TAPPED("vkGetPhysicalDeviceFormatProperties", format_properties),
    TAPPED("vkGetPhysicalDeviceFormatProperties2", format_properties2),
    TAPPED("vkGetDeviceProcAddr", device_function),
};

static PFN_vkVoidFunction real_function(const char *name) {
    for (int i = 0; i < COUNT(functions); i++)
        if (!strcmp(functions[i].name, name)) return functions[i].real;
    return NULL;
}

/* Of the kinds that are counted, or that would be a way around: a library that begins to use another must be tapped
 * there. */
static bool should_be_tapped(const char *name) {
    static const char *const kinds[] = {"vkCreate", "vkDestroy",          "vkAllocate", "vkFree",
                                        "vkBind",   "vkCmdDispatch",      "vkQueue",    "vkMap",
                                        "vkWait",   "vkGetPipelineCache", "vkMerge"};
    static const char *const harmless[] = {"vkFreeCommandBuffers", "vkFreeDescriptorSets", "vkCreateInstance",
                                           "vkDestroyInstance"};
    for (int i = 0; i < COUNT(harmless); i++)
        if (!strcmp(name, harmless[i])) return false;
    for (int i = 0; i < COUNT(kinds); i++)
        if (!strncmp(name, kinds[i], strlen(kinds[i]))) return true;
    return false;
}

PFN_vkVoidFunction tap_function(const char *name, PFN_vkVoidFunction real) {
    if (tap.hidden && !strcmp(name, tap.hidden)) return NULL;
    if (!real) return NULL;
    for (int i = 0; i < COUNT(functions); i++)
        if (!strcmp(name, functions[i].name)) {
            functions[i].real = real;
            return functions[i].tapped;
        }
    if (should_be_tapped(name)) snprintf(tap.untapped, sizeof tap.untapped, "%s", name);
    return real;
}

PFN_vkVoidFunction VKAPI_PTR tap_get_instance_proc_addr(VkInstance instance, const char *name) {
    assert_ptr_equal(instance, own.instance);
    return remember(name, tap_function(name, own.get_instance_proc_addr(instance, name)));
}

void tap_forget(void) {
    const int live = tap.live;
    memset(&tap, 0, sizeof tap);
    tap.live = live;
    tap_name_count = 0;
}

/* ---- memory of Vulkan */

enum { HEAD = 64 };

static void *VKAPI_PTR host_allocate(void *user, size_t size, size_t alignment, VkSystemAllocationScope scope) {
    host_memory *m = user;
    (void)scope;
    if (size == 0 || alignment > HEAD) return NULL;
    char *memory = aligned_alloc(HEAD, (size + 2 * HEAD - 1) / HEAD * HEAD);
    if (!memory) return NULL;
    memcpy(memory, &size, sizeof size);
    m->allocations++;
    m->live++;
    return memory + HEAD;
}

static void VKAPI_PTR host_release(void *user, void *memory) {
    host_memory *m = user;
    if (!memory) return;
    m->live--;
    free((char *)memory - HEAD);
}

static void *VKAPI_PTR host_reallocate(void *user, void *original, size_t size, size_t alignment,
                                       VkSystemAllocationScope scope) {
    void *memory = host_allocate(user, size, alignment, scope);
    size_t old = 0;
    if (original) memcpy(&old, (char *)original - HEAD, sizeof old);
    if (memory && original) memcpy(memory, original, old < size ? old : size);
    if (memory || size == 0) host_release(user, original);
    return memory;
}

VkAllocationCallbacks host_callbacks(host_memory *memory) {
    return (VkAllocationCallbacks){.pUserData = memory,
                                   .pfnAllocation = host_allocate,
                                   .pfnReallocation = host_reallocate,
                                   .pfnFree = host_release};
}

/* ---- the library */

static void keep(void *user, ddof_log_level level, const char *text) {
    (void)user;
    if (level == DDOF_LOG_ERROR) snprintf(said, sizeof said, "%s", text);
}

ddof_vulkan_config tap_config(void) {
    return (ddof_vulkan_config){.instance = own.instance,
                                .physical_device = own.physical,
                                .device = own.device,
                                .queue_family = own.family,
                                .get_instance_proc_addr = tap_get_instance_proc_addr,
                                .features = &own.features,
                                .log = keep};
}

ddof_status try_create(ddof_vulkan **vk) {
    const ddof_vulkan_config config = tap_config();
    said[0] = 0;
    return ddof_vulkan_create(vk, &config);
}

ddof_vulkan *create(void) {
    ddof_vulkan *vk = NULL;
    memset(&tap, 0, sizeof tap); /* also what a test that failed has left behind */
    tap_forget();
    if (try_create(&vk) != DDOF_OK) fail_msg("ddof_vulkan_create: %s", said);
    assert_non_null(vk);
    return vk;
}

void destroy(ddof_vulkan **vk) {
    ddof_vulkan_destroy(vk);
    assert_null(*vk);
    assert_int_equal(tap.live, 0);
    if (tap.untapped[0]) fail_msg("the library calls %s, which these tests do not count", tap.untapped);
}
