/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "vulkan_scene.h"

static const uint32_t render_code[] = {
#include "vulkan_scene.comp.h"
};
static const uint32_t tonemap_code[] = {
#include "vulkan_tonemap.comp.h"
};

enum { IMAGES = 4, TILE = 8 }; /* bindings, and the side of a workgroup: as in the shaders */

/* As in vulkan_scene.comp. */
typedef struct constants {
    float half_width, near_plane, time;
} constants;

static VkPipeline pipeline(const sample *s, VkPipelineLayout layout, const uint32_t *code, size_t bytes) {
    const VkShaderModuleCreateInfo module = {.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO, .codeSize = bytes,
                                             .pCode = code};
    VkComputePipelineCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
        .stage = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO, .stage = VK_SHADER_STAGE_COMPUTE_BIT,
                  .pName = "main"},
        .layout = layout,
    };
    VkPipeline made;
    SAMPLE_VK(vkCreateShaderModule(s->device, &module, NULL, &info.stage.module));
    SAMPLE_VK(vkCreateComputePipelines(s->device, VK_NULL_HANDLE, 1, &info, NULL, &made));
    vkDestroyShaderModule(s->device, info.stage.module, NULL);
    return made;
}

scene scene_create(const sample *s, uint32_t frames) {
    scene sc;
    VkDescriptorSetLayoutBinding bindings[IMAGES];
    for (uint32_t i = 0; i < IMAGES; i++)
        bindings[i] = (VkDescriptorSetLayoutBinding){.binding = i, .descriptorCount = 1,
                                                     .descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_IMAGE,
                                                     .stageFlags = VK_SHADER_STAGE_COMPUTE_BIT};
    const VkDescriptorSetLayoutCreateInfo set = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
                                                 .bindingCount = IMAGES, .pBindings = bindings};
    SAMPLE_VK(vkCreateDescriptorSetLayout(s->device, &set, NULL, &sc.set_layout));
    const VkDescriptorPoolSize size = {VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, IMAGES * frames};
    const VkDescriptorPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                             .flags = VK_DESCRIPTOR_POOL_CREATE_FREE_DESCRIPTOR_SET_BIT,
                                             .maxSets = frames, .poolSizeCount = 1, .pPoolSizes = &size};
    SAMPLE_VK(vkCreateDescriptorPool(s->device, &pool, NULL, &sc.set_pool));
    const VkPushConstantRange range = {VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(constants)};
    const VkPipelineLayoutCreateInfo layout = {.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                               .setLayoutCount = 1, .pSetLayouts = &sc.set_layout,
                                               .pushConstantRangeCount = 1, .pPushConstantRanges = &range};
    SAMPLE_VK(vkCreatePipelineLayout(s->device, &layout, NULL, &sc.layout));
    sc.render = pipeline(s, sc.layout, render_code, sizeof render_code);
    sc.tonemap = pipeline(s, sc.layout, tonemap_code, sizeof tonemap_code);
    return sc;
}

void scene_destroy(const sample *s, scene *sc) {
    vkDestroyPipeline(s->device, sc->tonemap, NULL);
    vkDestroyPipeline(s->device, sc->render, NULL);
    vkDestroyPipelineLayout(s->device, sc->layout, NULL);
    vkDestroyDescriptorPool(s->device, sc->set_pool, NULL);
    vkDestroyDescriptorSetLayout(s->device, sc->set_layout, NULL);
    *sc = (scene){0};
}

scene_images scene_images_create(const sample *s, const scene *sc, uint32_t width, uint32_t height) {
    const VkImageUsageFlags both = VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_SAMPLED_BIT;
    const VkImageUsageFlags copied = VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
    scene_images m = {
        .color = sample_image_create(s, width, height, VK_FORMAT_R16G16B16A16_SFLOAT, both),
        .depth = sample_image_create(s, width, height, VK_FORMAT_R32_SFLOAT, both | copied),
        .blurred = sample_image_create(s, width, height, VK_FORMAT_R16G16B16A16_SFLOAT, both),
        .shown = sample_image_create(s, width, height, VK_FORMAT_R8G8B8A8_UNORM, VK_IMAGE_USAGE_STORAGE_BIT | copied),
    };
    const VkDescriptorSetAllocateInfo set = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                             .descriptorPool = sc->set_pool, .descriptorSetCount = 1,
                                             .pSetLayouts = &sc->set_layout};
    SAMPLE_VK(vkAllocateDescriptorSets(s->device, &set, &m.set));
    const VkImageView views[IMAGES] = {m.color.view, m.depth.view, m.blurred.view, m.shown.view};
    VkDescriptorImageInfo images[IMAGES];
    for (uint32_t i = 0; i < IMAGES; i++)
        images[i] = (VkDescriptorImageInfo){.imageView = views[i], .imageLayout = VK_IMAGE_LAYOUT_GENERAL};
    /* one write fills the bindings that follow, too */
    const VkWriteDescriptorSet write = {.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET, .dstSet = m.set,
                                        .descriptorCount = IMAGES, .descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_IMAGE,
                                        .pImageInfo = images};
    vkUpdateDescriptorSets(s->device, 1, &write, 0, NULL);
    return m;
}

void scene_images_destroy(const sample *s, const scene *sc, scene_images *m) {
    SAMPLE_VK(vkFreeDescriptorSets(s->device, sc->set_pool, 1, &m->set));
    sample_image_destroy(s, &m->color);
    sample_image_destroy(s, &m->depth);
    sample_image_destroy(s, &m->blurred);
    sample_image_destroy(s, &m->shown);
    *m = (scene_images){0};
}

static void dispatch(const scene *sc, VkCommandBuffer commands, const scene_images *m, VkPipeline shader) {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, shader);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, sc->layout, 0, 1, &m->set, 0, NULL);
    vkCmdDispatch(commands, (m->color.width + TILE - 1) / TILE, (m->color.height + TILE - 1) / TILE, 1);
}

void scene_render(const scene *sc, VkCommandBuffer commands, const scene_images *images, float time) {
    const constants c = {36.0f / 2 / SCENE_FOCAL_LENGTH, SCENE_NEAR, time};
    vkCmdPushConstants(commands, sc->layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof c, &c);
    dispatch(sc, commands, images, sc->render);
}

void scene_tonemap(const scene *sc, VkCommandBuffer commands, const scene_images *images) {
    dispatch(sc, commands, images, sc->tonemap);
}
