/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "device.h"

#include <stdio.h>
#include <string.h>

ddof_status vulkan_result(ddof_context *ctx, const char *device, VkResult result, const char *doing) {
    switch (result) {
    case VK_SUCCESS:
        return DDOF_OK;
    case VK_ERROR_OUT_OF_HOST_MEMORY:
        return context_fail(ctx, DDOF_ERROR_MEMORY, "the Vulkan driver (%s) is out of memory while %s", device, doing);
    case VK_ERROR_OUT_OF_DEVICE_MEMORY:
        return context_fail(ctx, DDOF_ERROR_DEVICE,
                            "the Vulkan device (%s) is out of its memory while %s: give a smaller picture", device,
                            doing);
    case VK_ERROR_DEVICE_LOST:
        return context_fail(ctx, DDOF_ERROR_DEVICE, "the Vulkan device (%s) was lost while %s", device, doing);
    default:
        return context_fail(ctx, DDOF_ERROR_DEVICE, "the Vulkan device (%s) reported VkResult %d while %s", device,
                            (int)result, doing);
    }
}

ddof_status vulkan_device_check(ddof_vulkan *vk, VkResult result, const char *doing) {
    return vulkan_result(&vk->shell, vk->name, result, doing);
}

uint32_t vulkan_device_memory(const ddof_vulkan *vk, uint32_t bits) {
    uint32_t any = UINT32_MAX;
    for (uint32_t i = 0; i < vk->memory.memoryTypeCount; i++) {
        const VkMemoryPropertyFlags flags = vk->memory.memoryTypes[i].propertyFlags;
        if (!(bits & 1u << i) || flags & VK_MEMORY_PROPERTY_PROTECTED_BIT) continue;
        if (flags & VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT) return i;
        if (any == UINT32_MAX) any = i;
    }
    return any;
}

/* ---- what is enabled */

typedef struct enabled {
    bool synchronization2, write_without_format, subgroup_size, geometry;
} enabled;

static void read_feature(const VkBaseInStructure *s, enabled *e) {
    const void *p = s;
    switch (s->sType) {
    case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES: {
        const VkPhysicalDeviceVulkan13Features *f = p;
        e->synchronization2 |= f->synchronization2;
        e->subgroup_size |= f->subgroupSizeControl && f->computeFullSubgroups;
        break;
    }
    case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SYNCHRONIZATION_2_FEATURES:
        e->synchronization2 |= ((const VkPhysicalDeviceSynchronization2Features *)p)->synchronization2;
        break;
    case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_SIZE_CONTROL_FEATURES: {
        const VkPhysicalDeviceSubgroupSizeControlFeatures *f = p;
        e->subgroup_size |= f->subgroupSizeControl && f->computeFullSubgroups;
        break;
    }
    default:
        break;
    }
}

static enabled read_features(const VkPhysicalDeviceFeatures2 *features) {
    enabled e = {features == NULL, features == NULL, false, false};
    if (!features) return e;
    e.write_without_format = features->features.shaderStorageImageWriteWithoutFormat;
    e.geometry = features->features.geometryShader;
    for (const VkBaseInStructure *s = features->pNext; s; s = s->pNext)
        read_feature(s, &e);
    return e;
}

/* ---- what the device has */

static int least(uint32_t a, uint32_t b) {
    const uint32_t n = a < b ? a : b;
    return n < 1 << 20 ? (int)n : 1 << 20;
}

/* The size of subgroups to ask for, 1: none. Of the sizes the device has, the one nearest to 32. */
static void look_at_subgroups(ddof_vulkan *vk) {
    VkPhysicalDeviceSubgroupSizeControlProperties size = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_SIZE_CONTROL_PROPERTIES};
    VkPhysicalDeviceSubgroupProperties subgroup = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES,
                                                   .pNext = &size};
    VkPhysicalDeviceProperties2 all = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, .pNext = &subgroup};
    const VkSubgroupFeatureFlags needed = VK_SUBGROUP_FEATURE_BASIC_BIT | VK_SUBGROUP_FEATURE_SHUFFLE_BIT;
    vk->f.GetPhysicalDeviceProperties2(vk->config.physical_device, &all);
    if (!(subgroup.supportedStages & VK_SHADER_STAGE_COMPUTE_BIT) ||
        !(size.requiredSubgroupSizeStages & VK_SHADER_STAGE_COMPUTE_BIT) ||
        (subgroup.supportedOperations & needed) != needed || size.minSubgroupSize < 1 || size.maxSubgroupSize > 128)
        return;
    uint32_t n = 32;
    if (n < size.minSubgroupSize) n = size.minSubgroupSize;
    if (n > size.maxSubgroupSize) n = size.maxSubgroupSize;
    vk->line.subgroup = (int)n;
    vk->line.subgroups = least(size.maxComputeWorkgroupSubgroups, 1 << 10);
}

static void look_at_device(ddof_vulkan *vk, const enabled *e) {
    VkPhysicalDeviceProperties p;
    vk->f.GetPhysicalDeviceProperties(vk->config.physical_device, &p);
    vk->f.GetPhysicalDeviceMemoryProperties(vk->config.physical_device, &vk->memory);
    vk->limits = p.limits;
    vk->version = p.apiVersion;
    memcpy(vk->name, p.deviceName, sizeof vk->name);
    vk->name[sizeof vk->name - 1] = 0;
    vk->line =
        (line_limits){.workgroup = least(p.limits.maxComputeWorkGroupInvocations, p.limits.maxComputeWorkGroupSize[0]),
                      .shared_bytes = least(p.limits.maxComputeSharedMemorySize, 1 << 20),
                      .subgroup = 1};
    vk->geometry = e->geometry;
    if (vk->line.workgroup > 1024) vk->line.workgroup = 1024; /* more would leave too few registers to a thread */
    if (e->subgroup_size) look_at_subgroups(vk);
}

static bool family_computes(ddof_vulkan *vk) {
    VkQueueFamilyProperties family[32];
    uint32_t count = 32;
    vk->f.GetPhysicalDeviceQueueFamilyProperties(vk->config.physical_device, &count, family);
    if (vk->config.queue_family >= count) return false;
    vk->graphics = family[vk->config.queue_family].queueFlags & VK_QUEUE_GRAPHICS_BIT;
    return family[vk->config.queue_family].queueFlags & VK_QUEUE_COMPUTE_BIT;
}

/* What must be there: NULL, or what is not. */
static const char *missing(ddof_vulkan *vk, const enabled *e) {
    if (vk->version < VK_API_VERSION_1_1) return "config.physical_device: it has Vulkan 1.0 only, 1.1 is needed";
    if (!e->synchronization2)
        return "config.features: synchronization2 is not enabled; enable it when the device is made";
    if (!e->write_without_format)
        return "config.features: shaderStorageImageWriteWithoutFormat is not enabled; enable it when the device is "
               "made";
    if (!family_computes(vk)) return "config.queue_family: there is no such family with compute on this device";
    return NULL;
}

/* ---- objects */

const VkDescriptorType vulkan_binding_types[VULKAN_BINDINGS] = {
    [BIND_COLOR] = VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE,
    [BIND_MAP] = VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE,
    [BIND_TARGET] = VK_DESCRIPTOR_TYPE_STORAGE_IMAGE,
    [BIND_LEVELS_IN] = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
    [BIND_LEVELS_OUT] = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
    [BIND_IMAGINARY] = VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE,
    [BIND_TARGET_IMAGINARY] = VK_DESCRIPTOR_TYPE_STORAGE_IMAGE,
    [BIND_SUM] = VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE,
};

static VkResult make_layouts(ddof_vulkan *vk) {
    VkDescriptorSetLayoutBinding binding[VULKAN_BINDINGS];
    for (uint32_t i = 0; i < VULKAN_BINDINGS; i++)
        binding[i] = (VkDescriptorSetLayoutBinding){.binding = i,
                                                    .descriptorType = vulkan_binding_types[i],
                                                    .descriptorCount = 1,
                                                    .stageFlags = VK_SHADER_STAGE_COMPUTE_BIT};
    const VkDescriptorSetLayoutCreateInfo set = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
                                                 .bindingCount = VULKAN_BINDINGS,
                                                 .pBindings = binding};
    VkResult result = vk->f.CreateDescriptorSetLayout(vk->config.device, &set, vk->allocator, &vk->set_layout);
    if (result != VK_SUCCESS) return result;
    const VkPushConstantRange push = {VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(vulkan_push)};
    const VkPipelineLayoutCreateInfo layout = {.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                               .setLayoutCount = 1,
                                               .pSetLayouts = &vk->set_layout,
                                               .pushConstantRangeCount = 1,
                                               .pPushConstantRanges = &push};
    return vk->f.CreatePipelineLayout(vk->config.device, &layout, vk->allocator, &vk->pipeline_layout);
}

/* The first 32 bytes of a cache say which driver made it: the rest is handed on only where it is this one. */
static bool cache_fits(const ddof_vulkan *vk, const void *data, size_t size) {
    VkPhysicalDeviceProperties p;
    VkPipelineCacheHeaderVersionOne header;
    if (!data || size < sizeof header) return false;
    memcpy(&header, data, sizeof header);
    vk->f.GetPhysicalDeviceProperties(vk->config.physical_device, &p);
    return header.headerSize >= sizeof header && header.headerVersion == VK_PIPELINE_CACHE_HEADER_VERSION_ONE &&
           header.vendorID == p.vendorID && header.deviceID == p.deviceID &&
           !memcmp(header.pipelineCacheUUID, p.pipelineCacheUUID, VK_UUID_SIZE);
}

static VkResult make_cache(ddof_vulkan *vk) {
    const bool fits = cache_fits(vk, vk->config.pipeline_cache, vk->config.pipeline_cache_size);
    if (vk->config.pipeline_cache && !fits)
        context_log(&vk->shell, DDOF_LOG_INFO, "config.pipeline_cache is of another driver and is ignored");
    const VkPipelineCacheCreateInfo info = {.sType = VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO,
                                            .initialDataSize = fits ? vk->config.pipeline_cache_size : 0,
                                            .pInitialData = fits ? vk->config.pipeline_cache : NULL};
    VkResult result = vk->f.CreatePipelineCache(vk->config.device, &info, vk->allocator, &vk->pipeline_cache);
    vk->config.pipeline_cache = NULL; /* the caller's, and only for the time of this call */
    return result;
}

static ddof_status set_up(ddof_vulkan *vk) {
    const ddof_vulkan_config *c = &vk->config;
    const enabled e = read_features(c->features);
    const char *name = vulkan_functions_load(&vk->f, c->get_instance_proc_addr, c->instance, c->device);
    if (name)
        return context_fail(&vk->shell, DDOF_ERROR_UNSUPPORTED,
                            "Vulkan has no %s here: instance and device must be of Vulkan 1.1, with synchronization2",
                            name);
    look_at_device(vk, &e);
    vk->config.features = NULL;
    const char *wrong = missing(vk, &e);
    if (wrong) return context_fail(&vk->shell, DDOF_ERROR_UNSUPPORTED, "%s", wrong);
    ddof_status status = vulkan_device_check(vk, make_layouts(vk), "making the layouts of the passes");
    return status == DDOF_OK ? vulkan_device_check(vk, make_cache(vk), "making a pipeline cache") : status;
}

ddof_status vulkan_device_create(ddof_vulkan **made, const ddof_vulkan_config *config, char *text, size_t size) {
    ddof_vulkan *vk = config->allocate(config->memory_user, sizeof *vk);
    if (!vk) {
        snprintf(text, size, "out of memory for a ddof_vulkan");
        return DDOF_ERROR_MEMORY;
    }
    memset(vk, 0, sizeof *vk);
    vk->config = *config;
    vk->shell.config.log = config->log;
    vk->shell.config.log_user = config->log_user;
    if (config->allocator) {
        vk->allocator_copy = *config->allocator;
        vk->allocator = &vk->allocator_copy;
    }
    ddof_status status = set_up(vk);
    *made = vk;
    if (status == DDOF_OK) return status;
    text[0] = 0; /* has been logged */
    vulkan_device_destroy(made);
    return status;
}

void vulkan_device_destroy(ddof_vulkan **made) {
    ddof_vulkan *vk = *made;
    const VkDevice device = vk->config.device;
    *made = NULL;
    vulkan_pipelines_delete(vk);
    if (vk->pipeline_cache) vk->f.DestroyPipelineCache(device, vk->pipeline_cache, vk->allocator);
    if (vk->pipeline_layout) vk->f.DestroyPipelineLayout(device, vk->pipeline_layout, vk->allocator);
    if (vk->set_layout) vk->f.DestroyDescriptorSetLayout(device, vk->set_layout, vk->allocator);
    vk->config.release(vk->config.memory_user, vk);
}
