/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "pipelines.h"

#include <string.h>

#include "device.h"

VkShaderModule vulkan_module_make(ddof_vulkan *vk, vulkan_module module, ddof_status *status) {
    const vulkan_code *code = &vulkan_codes[module];
    const VkShaderModuleCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO, .codeSize = code->bytes, .pCode = code->word};
    VkShaderModule made = VK_NULL_HANDLE;
    *status =
        vulkan_device_check(vk, vk->f.CreateShaderModule(vk->config.device, &info, vk->allocator, &made), code->making);
    return *status == DDOF_OK ? made : VK_NULL_HANDLE;
}

static VkPipeline make(ddof_vulkan *vk, vulkan_module module, const vulkan_constants *c, ddof_status *status) {
    enum { CONSTANTS = sizeof *c / sizeof(int32_t) };
    VkSpecializationMapEntry entry[CONSTANTS];
    for (uint32_t i = 0; i < CONSTANTS; i++)
        entry[i] = (VkSpecializationMapEntry){i, i * sizeof(int32_t), sizeof(int32_t)};
    const VkSpecializationInfo specialization = {CONSTANTS, entry, sizeof *c, c};
    const VkPipelineShaderStageRequiredSubgroupSizeCreateInfo size = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_REQUIRED_SUBGROUP_SIZE_CREATE_INFO,
        .requiredSubgroupSize = (uint32_t)c->subgroup};
    const bool subgroups = module == MODULE_LINE_SUBGROUPS || module == MODULE_DISC_LINE_SUBGROUPS;
    VkPipeline made = VK_NULL_HANDLE;
    VkShaderModule shader = vulkan_module_make(vk, module, status);
    if (!shader) return VK_NULL_HANDLE;
    const VkComputePipelineCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
        .stage = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                  .pNext = subgroups ? &size : NULL,
                  .flags = subgroups ? VK_PIPELINE_SHADER_STAGE_CREATE_REQUIRE_FULL_SUBGROUPS_BIT : 0,
                  .stage = VK_SHADER_STAGE_COMPUTE_BIT,
                  .module = shader,
                  .pName = "main",
                  .pSpecializationInfo = &specialization},
        .layout = vk->pipeline_layout};
    *status = vulkan_device_check(
        vk, vk->f.CreateComputePipelines(vk->config.device, vk->pipeline_cache, 1, &info, vk->allocator, &made),
        vulkan_codes[module].making);
    vk->f.DestroyShaderModule(vk->config.device, shader, vk->allocator);
    return *status == DDOF_OK ? made : VK_NULL_HANDLE;
}

static VkPipeline find(const ddof_vulkan *vk, vulkan_module module, const vulkan_constants *constants) {
    const vulkan_pipelines *p = &vk->pipelines;
    for (int i = 0; i < p->count; i++)
        if (p->pipeline[i].module == module && !memcmp(&p->pipeline[i].constants, constants, sizeof *constants))
            return p->pipeline[i].handle;
    return VK_NULL_HANDLE;
}

static bool make_room(ddof_vulkan *vk, ddof_status *status) {
    vulkan_pipelines *p = &vk->pipelines;
    if (p->count < p->room) return true;
    const int room = p->room ? 2 * p->room : 16;
    vulkan_pipeline *more = vk->config.allocate(vk->config.memory_user, sizeof *more * (size_t)room);
    if (!more) {
        *status = context_fail(&vk->shell, DDOF_ERROR_MEMORY, "out of memory for a list of pipelines");
        return false;
    }
    if (p->pipeline) {
        memcpy(more, p->pipeline, sizeof *more * (size_t)p->count);
        vk->config.release(vk->config.memory_user, p->pipeline);
    }
    p->pipeline = more;
    p->room = room;
    return true;
}

VkPipeline vulkan_pipeline_get(ddof_vulkan *vk, vulkan_module module, const vulkan_constants *constants,
                               ddof_status *status) {
    VkPipeline found = find(vk, module, constants);
    if (found || !make_room(vk, status)) return found;
    found = make(vk, module, constants, status);
    if (found) vk->pipelines.pipeline[vk->pipelines.count++] = (vulkan_pipeline){module, *constants, found};
    return found;
}

void vulkan_pipelines_delete(ddof_vulkan *vk) {
    vulkan_pipelines *p = &vk->pipelines;
    for (int i = 0; i < p->count; i++)
        vk->f.DestroyPipeline(vk->config.device, p->pipeline[i].handle, vk->allocator);
    if (p->pipeline) vk->config.release(vk->config.memory_user, p->pipeline);
    *p = (vulkan_pipelines){NULL, 0, 0};
}
