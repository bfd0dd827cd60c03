/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include <stddef.h>
#include <string.h>

#include "../bokeh.h"
#include "sprites.h"

enum { HIGHLIGHT_BYTES = 24, FULL_BYTES = 8 /* of a sprite in the list: sprites.glsl */ };

/* ---- what is asked for */

const char vulkan_no_such_method[] = "settings.method: only the CPU and GL backends have this one";

vulkan_sprite_kind vulkan_sprite_kind_of(const ddof_settings *s) {
    vulkan_sprite_kind kind = {.bokeh = s->method == DDOF_METHOD_SCATTER ? DDOF_BOKEH_FULL : s->bokeh};
    if (!kind.bokeh) return kind;
    const bool full = kind.bokeh == DDOF_BOKEH_FULL;
    const ddof_frame any = {.picture_width = 1, .picture_height = 1};
    const frame_job job = {.frame = &any, .settings = s, .method = full ? DDOF_METHOD_SCATTER : DDOF_METHOD_DIFFUSION};
    const bokeh_limits limits = bokeh_limits_of(&job);
    kind.half = limits.half;
    kind.most = full ? 0 : limits.max_sprites;
    kind.append = s->sprites.append ? s->sprites.append : DDOF_APPEND_COUNTER;
    kind.quads = s->sprites.quads ? s->sprites.quads : DDOF_QUADS_INSTANCED;
    return kind;
}

const char *vulkan_sprite_kind_differs(const vulkan_sprite_kind *a, const vulkan_sprite_kind *b) {
    return a->bokeh != b->bokeh     ? "bokeh"
           : a->half != b->half     ? "sprites.resolution"
           : a->most != b->most     ? "sprites.max_sprites"
           : a->append != b->append ? "sprites.append"
           : a->quads != b->quads   ? "sprites.quads"
                                    : NULL;
}

static bool blends(const ddof_vulkan *vk, VkFormat format) {
    VkFormatProperties2 p = {.sType = VK_STRUCTURE_TYPE_FORMAT_PROPERTIES_2};
    vk->f.GetPhysicalDeviceFormatProperties2(vk->config.physical_device, format, &p);
    return p.formatProperties.optimalTilingFeatures & VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BLEND_BIT;
}

static ddof_status check_sizes(ddof_vulkan *vk, const ddof_vulkan_frame *f) {
    const VkPhysicalDeviceLimits *limits = &vk->limits;
    const VkExtent2D size = vulkan_light_size(f);
    VkDeviceSize bytes[VULKAN_BUFFERS] = {0};
    if (size.width > limits->maxFramebufferWidth || size.height > limits->maxFramebufferHeight ||
        size.width > limits->maxImageDimension2D || size.height > limits->maxImageDimension2D)
        return context_fail(
            &vk->shell, DDOF_ERROR_UNSUPPORTED,
            "settings.bokeh: sprites would be drawn into %u x %u pixels, more than this device (%s) has: take "
            "sprites.resolution HALF, or a smaller picture",
            size.width, size.height, vk->name);
    vulkan_sprites_bytes(f, bytes);
    if (bytes[BUFFER_SPRITE_LIST] > limits->maxStorageBufferRange)
        return context_fail(
            &vk->shell, DDOF_ERROR_UNSUPPORTED,
            "settings.bokeh: a list of sprites of %llu bytes is more than this device (%s) has in a buffer: take "
            "fewer, or a smaller picture",
            (unsigned long long)bytes[BUFFER_SPRITE_LIST], vk->name);
    return DDOF_OK;
}

ddof_status vulkan_sprites_choose(ddof_vulkan *vk, ddof_vulkan_frame *f, const ddof_settings *s) {
    if (s->method == DDOF_METHOD_GAUSSIAN || s->method == DDOF_METHOD_HEXAGON)
        return context_fail(&vk->shell, DDOF_ERROR_UNSUPPORTED, "%s", vulkan_no_such_method);
    f->sprite_kind = vulkan_sprite_kind_of(s);
    if (!f->sprite_kind.bokeh) return DDOF_OK;
    if (!vk->graphics)
        return context_fail(
            &vk->shell, DDOF_ERROR_UNSUPPORTED,
            "settings.bokeh: sprites are drawn, and config.queue_family does compute only: give one with graphics");
    if (f->sprite_kind.quads == DDOF_QUADS_GEOMETRY && !vk->geometry)
        return context_fail(
            &vk->shell, DDOF_ERROR_UNSUPPORTED,
            "settings.sprites.quads: the feature geometryShader is not enabled; take DDOF_QUADS_INSTANCED");
    const bool full = f->sprite_kind.bokeh == DDOF_BOKEH_FULL;
    const bool exact = blends(vk, VK_FORMAT_R32G32B32A32_SFLOAT) && blends(vk, VK_FORMAT_R32_SFLOAT);
    if (full && !exact) /* in half floats a sprite of 60 pixels would vanish beside what is there already */
        return context_fail(&vk->shell, DDOF_ERROR_UNSUPPORTED,
                            "settings.bokeh: this device (%s) does not blend floats, which DDOF_BOKEH_FULL needs",
                            vk->name);
    f->light_format = exact ? VK_FORMAT_R32G32B32A32_SFLOAT : VK_FORMAT_R16G16B16A16_SFLOAT;
    return check_sizes(vk, f);
}

void vulkan_sprites_bytes(const ddof_vulkan_frame *f, VkDeviceSize bytes[VULKAN_BUFFERS]) {
    if (!f->sprite_kind.bokeh) return;
    const bool full = f->sprite_kind.bokeh == DDOF_BOKEH_FULL;
    bytes[BUFFER_SPRITE_STATE] = sizeof(sprite_state) + 3 * BOKEH_BINS * sizeof(uint32_t);
    bytes[BUFFER_SPRITE_TABLES] = sizeof(sprite_tables);
    bytes[BUFFER_SPRITE_LIST] = full ? (VkDeviceSize)f->images.color.width * f->images.color.height * FULL_BYTES
                                     : (VkDeviceSize)f->sprite_kind.most * HIGHLIGHT_BYTES;
}

/* ---- descriptors */

static const VkDescriptorType types[SPRITES_BINDINGS] = {
    [SPRITES_COLOR] = VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE,     [SPRITES_MAP] = VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE,
    [SPRITES_REMAINDER] = VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, [SPRITES_OUTPUT] = VK_DESCRIPTOR_TYPE_STORAGE_IMAGE,
    [SPRITES_STATE] = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,    [SPRITES_LIST] = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
    [SPRITES_TABLES] = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,   [SPRITES_BLURRED] = VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE,
    [SPRITES_LIGHT] = VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE,     [SPRITES_WEIGHT] = VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE,
};

static VkShaderStageFlags stages_of(const vulkan_sprites *s, uint32_t binding) {
    switch (binding) {
    case SPRITES_COLOR:
    case SPRITES_MAP:
    case SPRITES_LIST:
    case SPRITES_TABLES:
        return s->stages;
    default:
        return VK_SHADER_STAGE_COMPUTE_BIT;
    }
}

static VkResult make_layouts(ddof_vulkan *vk, vulkan_sprites *s) {
    VkDescriptorSetLayoutBinding binding[SPRITES_BINDINGS];
    for (uint32_t i = 0; i < SPRITES_BINDINGS; i++)
        binding[i] = (VkDescriptorSetLayoutBinding){
            .binding = i, .descriptorType = types[i], .descriptorCount = 1, .stageFlags = stages_of(s, i)};
    const VkDescriptorSetLayoutCreateInfo set = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
                                                 .bindingCount = SPRITES_BINDINGS,
                                                 .pBindings = binding};
    VkResult result = vk->f.CreateDescriptorSetLayout(vk->config.device, &set, vk->allocator, &s->set_layout);
    if (result != VK_SUCCESS) return result;
    const VkPushConstantRange push = {s->stages, 0, sizeof(sprite_push)};
    const VkPipelineLayoutCreateInfo layout = {.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                               .setLayoutCount = 1,
                                               .pSetLayouts = &s->set_layout,
                                               .pushConstantRangeCount = 1,
                                               .pPushConstantRanges = &push};
    return vk->f.CreatePipelineLayout(vk->config.device, &layout, vk->allocator, &s->layout);
}

static VkDescriptorImageInfo image_at(const ddof_vulkan_frame *f, uint32_t binding) {
    const VkImageLayout general = VK_IMAGE_LAYOUT_GENERAL, read = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
    switch (binding) {
    case SPRITES_COLOR:
        return (VkDescriptorImageInfo){VK_NULL_HANDLE, f->sampled[PICTURE_COLOR], f->images.color.layout};
    case SPRITES_MAP:
        return (VkDescriptorImageInfo){VK_NULL_HANDLE, f->map,
                                       f->is_depth ? f->images.depth.layout : f->images.coc.layout};
    case SPRITES_REMAINDER: /* COLOR is the output, where a pass takes light out of it */
        return (VkDescriptorImageInfo){
            VK_NULL_HANDLE, f->stored[f->first == PICTURE_COLOR ? PICTURE_OUTPUT : vulkan_place(f, f->first)], general};
    case SPRITES_OUTPUT:
        return (VkDescriptorImageInfo){VK_NULL_HANDLE, f->stored[PICTURE_OUTPUT], general};
    case SPRITES_BLURRED: /* FULL looks at none */
        if (!f->sampled[PICTURE_OUTPUT]) return image_at(f, SPRITES_COLOR);
        return (VkDescriptorImageInfo){VK_NULL_HANDLE, f->sampled[PICTURE_OUTPUT], general};
    case SPRITES_WEIGHT: /* HIGHLIGHTS looks at none */
        if (!f->sampled[PICTURE_WEIGHT]) return image_at(f, SPRITES_LIGHT);
        return (VkDescriptorImageInfo){VK_NULL_HANDLE, f->sampled[PICTURE_WEIGHT], read};
    default:
        return (VkDescriptorImageInfo){VK_NULL_HANDLE, f->sampled[PICTURE_LIGHT], read};
    }
}

static void write_set(const ddof_vulkan_frame *f) {
    static const vulkan_buffer buffer_of[SPRITES_BINDINGS] = {[SPRITES_STATE] = BUFFER_SPRITE_STATE,
                                                              [SPRITES_LIST] = BUFFER_SPRITE_LIST,
                                                              [SPRITES_TABLES] = BUFFER_SPRITE_TABLES};
    VkDescriptorImageInfo image[SPRITES_BINDINGS];
    VkDescriptorBufferInfo buffer[SPRITES_BINDINGS];
    VkWriteDescriptorSet write[SPRITES_BINDINGS];
    for (uint32_t i = 0; i < SPRITES_BINDINGS; i++) {
        const bool is_buffer = types[i] == VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
        if (is_buffer) buffer[i] = (VkDescriptorBufferInfo){f->scratch.buffer[buffer_of[i]], 0, VK_WHOLE_SIZE};
        if (!is_buffer) image[i] = image_at(f, i);
        write[i] = (VkWriteDescriptorSet){.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                          .dstSet = f->sprites->set,
                                          .dstBinding = i,
                                          .descriptorCount = 1,
                                          .descriptorType = types[i],
                                          .pImageInfo = is_buffer ? NULL : &image[i],
                                          .pBufferInfo = is_buffer ? &buffer[i] : NULL};
    }
    f->vk->f.UpdateDescriptorSets(f->vk->config.device, SPRITES_BINDINGS, write, 0, NULL);
}

static VkResult make_set(ddof_vulkan_frame *f) {
    const ddof_vulkan *vk = f->vk;
    vulkan_sprites *s = f->sprites;
    const VkDescriptorPoolSize size[3] = {{VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE, 5},
                                          {VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, 2},
                                          {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 3}};
    const VkDescriptorPoolCreateInfo pool = {
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO, .maxSets = 1, .poolSizeCount = 3, .pPoolSizes = size};
    VkResult result = vk->f.CreateDescriptorPool(vk->config.device, &pool, vk->allocator, &s->pool);
    if (result != VK_SUCCESS) return result;
    const VkDescriptorSetAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                              .descriptorPool = s->pool,
                                              .descriptorSetCount = 1,
                                              .pSetLayouts = &s->set_layout};
    result = vk->f.AllocateDescriptorSets(vk->config.device, &info, &s->set);
    if (result == VK_SUCCESS) write_set(f);
    return result;
}

/* ---- what is drawn into */

/* The draw waits for the list, and the passes after it for the draw. */
static VkResult make_render_pass(ddof_vulkan_frame *f) {
    const ddof_vulkan *vk = f->vk;
    const uint32_t targets = f->sprite_kind.bokeh == DDOF_BOKEH_FULL ? 2 : 1;
    VkAttachmentDescription attachment[2];
    for (uint32_t i = 0; i < targets; i++)
        attachment[i] =
            (VkAttachmentDescription){.format = vulkan_scratch_format(f, i ? PICTURE_WEIGHT : PICTURE_LIGHT),
                                      .samples = VK_SAMPLE_COUNT_1_BIT,
                                      .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
                                      .storeOp = VK_ATTACHMENT_STORE_OP_STORE,
                                      .stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE,
                                      .stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE,
                                      .initialLayout = VK_IMAGE_LAYOUT_UNDEFINED,
                                      .finalLayout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
    static const VkAttachmentReference reference[2] = {{0, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL},
                                                       {1, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL}};
    const VkSubpassDescription subpass = {.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS,
                                          .colorAttachmentCount = targets,
                                          .pColorAttachments = reference};
    static const VkAccessFlags blended = VK_ACCESS_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT;
    VkPipelineStageFlags stages = VK_PIPELINE_STAGE_DRAW_INDIRECT_BIT | VK_PIPELINE_STAGE_VERTEX_SHADER_BIT |
                                  VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT | VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT;
    if (f->sprites->stages & VK_SHADER_STAGE_GEOMETRY_BIT) stages |= VK_PIPELINE_STAGE_GEOMETRY_SHADER_BIT;
    const VkSubpassDependency dependency[2] = {
        {.srcSubpass = VK_SUBPASS_EXTERNAL,
         .dstSubpass = 0,
         .srcStageMask = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT,
         .dstStageMask = stages,
         .srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_WRITE_BIT,
         .dstAccessMask = VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_INDIRECT_COMMAND_READ_BIT | blended},
        {.srcSubpass = 0,
         .dstSubpass = VK_SUBPASS_EXTERNAL,
         .srcStageMask = stages,
         .dstStageMask = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
         .srcAccessMask = blended,
         .dstAccessMask = VK_ACCESS_SHADER_READ_BIT}};
    const VkRenderPassCreateInfo info = {.sType = VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO,
                                         .attachmentCount = targets,
                                         .pAttachments = attachment,
                                         .subpassCount = 1,
                                         .pSubpasses = &subpass,
                                         .dependencyCount = 2,
                                         .pDependencies = dependency};
    return vk->f.CreateRenderPass(vk->config.device, &info, vk->allocator, &f->sprites->render_pass);
}

static VkResult make_framebuffer(ddof_vulkan_frame *f) {
    const ddof_vulkan *vk = f->vk;
    const VkImageView view[2] = {f->stored[PICTURE_LIGHT], f->stored[PICTURE_WEIGHT]};
    const VkExtent2D size = vulkan_light_size(f);
    const VkFramebufferCreateInfo info = {.sType = VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO,
                                          .renderPass = f->sprites->render_pass,
                                          .attachmentCount = f->sprite_kind.bokeh == DDOF_BOKEH_FULL ? 2 : 1,
                                          .pAttachments = view,
                                          .width = size.width,
                                          .height = size.height,
                                          .layers = 1};
    return vk->f.CreateFramebuffer(vk->config.device, &info, vk->allocator, &f->sprites->framebuffer);
}

/* ---- pipelines */

static sprite_constants constants_of(const ddof_vulkan_frame *f, sprite_pass pass) {
    const VkFormat output = f->images.output.format;
    const bool elsewhere = f->first != PICTURE_COLOR;
    const VkFormat remainder = !elsewhere || vulkan_place(f, f->first) == PICTURE_OUTPUT ? output : f->work_format;
    return (sprite_constants){.full = f->sprite_kind.bokeh == DDOF_BOKEH_FULL,
                              .depth = f->is_depth ? 1 + (int)f->depth_kind : 0,
                              .alpha = f->alpha,
                              .target_half =
                                  (pass == SPRITES_RESOLVE ? output : remainder) == VK_FORMAT_R16G16B16A16_SFLOAT,
                              .half_size = f->sprite_kind.half,
                              .arguments = f->sprite_kind.append == DDOF_APPEND_ARGUMENTS,
                              .points = f->sprite_kind.quads == DDOF_QUADS_GEOMETRY,
                              .remainder = f->sprite_kind.bokeh == DDOF_BOKEH_HIGHLIGHTS && elsewhere};
}

enum { CONSTANTS = sizeof(sprite_constants) / sizeof(int32_t) };

static VkSpecializationInfo specialise(const sprite_constants *c, VkSpecializationMapEntry entry[CONSTANTS]) {
    for (uint32_t i = 0; i < CONSTANTS; i++)
        entry[i] = (VkSpecializationMapEntry){i + 1, i * sizeof(int32_t), sizeof(int32_t)};
    return (VkSpecializationInfo){CONSTANTS, entry, sizeof *c, c};
}

static ddof_status make_compute(ddof_vulkan_frame *f, sprite_pass pass) {
    static const vulkan_module module[] = {[SPRITES_HISTOGRAM] = MODULE_SPRITES_HISTOGRAM,
                                           [SPRITES_RAISE] = MODULE_SPRITES_RAISE,
                                           [SPRITES_APPEND] = MODULE_SPRITES_APPEND,
                                           [SPRITES_TAKE] = MODULE_SPRITES_TAKE,
                                           [SPRITES_RESOLVE] = MODULE_SPRITES_RESOLVE};
    ddof_vulkan *vk = f->vk;
    const sprite_constants c = constants_of(f, pass);
    VkSpecializationMapEntry entry[CONSTANTS];
    const VkSpecializationInfo specialization = specialise(&c, entry);
    ddof_status status;
    const VkShaderModule shader = vulkan_module_make(vk, module[pass], &status);
    if (!shader) return status;
    const VkComputePipelineCreateInfo info = {.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
                                              .stage = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                                                        .stage = VK_SHADER_STAGE_COMPUTE_BIT,
                                                        .module = shader,
                                                        .pName = "main",
                                                        .pSpecializationInfo = &specialization},
                                              .layout = f->sprites->layout};
    const VkResult result = vk->f.CreateComputePipelines(vk->config.device, vk->pipeline_cache, 1, &info, vk->allocator,
                                                         &f->sprites->pipeline[pass]);
    vk->f.DestroyShaderModule(vk->config.device, shader, vk->allocator);
    return vulkan_device_check(vk, result, vulkan_codes[module[pass]].making);
}

static VkResult make_draw(ddof_vulkan_frame *f, const VkPipelineShaderStageCreateInfo *stage, uint32_t stages) {
    const ddof_vulkan *vk = f->vk;
    static const VkPipelineVertexInputStateCreateInfo nothing = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
    const VkPipelineInputAssemblyStateCreateInfo assembly = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO,
        .topology = stages == 3 ? VK_PRIMITIVE_TOPOLOGY_POINT_LIST : VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP};
    static const VkPipelineViewportStateCreateInfo viewport = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO, .viewportCount = 1, .scissorCount = 1};
    static const VkPipelineRasterizationStateCreateInfo raster = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO, .lineWidth = 1};
    static const VkPipelineMultisampleStateCreateInfo samples = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO,
        .rasterizationSamples = VK_SAMPLE_COUNT_1_BIT};
    const VkPipelineColorBlendAttachmentState add = {.blendEnable = VK_TRUE,
                                                     .srcColorBlendFactor = VK_BLEND_FACTOR_ONE,
                                                     .dstColorBlendFactor = VK_BLEND_FACTOR_ONE,
                                                     .srcAlphaBlendFactor = VK_BLEND_FACTOR_ONE,
                                                     .dstAlphaBlendFactor = VK_BLEND_FACTOR_ONE,
                                                     .colorWriteMask =
                                                         VK_COLOR_COMPONENT_R_BIT | VK_COLOR_COMPONENT_G_BIT |
                                                         VK_COLOR_COMPONENT_B_BIT | VK_COLOR_COMPONENT_A_BIT};
    const VkPipelineColorBlendAttachmentState both[2] = {add, add};
    const VkPipelineColorBlendStateCreateInfo blend = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO,
        .attachmentCount = f->sprite_kind.bokeh == DDOF_BOKEH_FULL ? 2 : 1,
        .pAttachments = both};
    static const VkDynamicState dynamic[] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
    static const VkPipelineDynamicStateCreateInfo later = {.sType =
                                                               VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO,
                                                           .dynamicStateCount = 2,
                                                           .pDynamicStates = dynamic};
    const VkGraphicsPipelineCreateInfo info = {.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
                                               .stageCount = stages,
                                               .pStages = stage,
                                               .pVertexInputState = &nothing,
                                               .pInputAssemblyState = &assembly,
                                               .pViewportState = &viewport,
                                               .pRasterizationState = &raster,
                                               .pMultisampleState = &samples,
                                               .pColorBlendState = &blend,
                                               .pDynamicState = &later,
                                               .layout = f->sprites->layout,
                                               .renderPass = f->sprites->render_pass};
    return vk->f.CreateGraphicsPipelines(vk->config.device, vk->pipeline_cache, 1, &info, vk->allocator,
                                         &f->sprites->pipeline[SPRITES_DRAW]);
}

static ddof_status make_graphics(ddof_vulkan_frame *f) {
    const bool points = f->sprite_kind.quads == DDOF_QUADS_GEOMETRY, full = f->sprite_kind.bokeh == DDOF_BOKEH_FULL;
    const struct {
        vulkan_module module;
        VkShaderStageFlagBits stage;
    } part[3] = {{points ? MODULE_SPRITES_POINT : MODULE_SPRITES_VERTEX, VK_SHADER_STAGE_VERTEX_BIT},
                 {full ? MODULE_SPRITES_PIXEL_WEIGHT : MODULE_SPRITES_PIXEL, VK_SHADER_STAGE_FRAGMENT_BIT},
                 {MODULE_SPRITES_GEOMETRY, VK_SHADER_STAGE_GEOMETRY_BIT}};
    const uint32_t parts = points ? 3 : 2;
    ddof_vulkan *vk = f->vk;
    const sprite_constants c = constants_of(f, SPRITES_DRAW);
    VkSpecializationMapEntry entry[CONSTANTS];
    const VkSpecializationInfo specialization = specialise(&c, entry);
    VkPipelineShaderStageCreateInfo stage[3];
    ddof_status status = DDOF_OK;
    uint32_t made = 0;
    while (made < parts && status == DDOF_OK) {
        stage[made] = (VkPipelineShaderStageCreateInfo){.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                                                        .stage = part[made].stage,
                                                        .module = vulkan_module_make(vk, part[made].module, &status),
                                                        .pName = "main",
                                                        .pSpecializationInfo = &specialization};
        if (status == DDOF_OK) made++;
    }
    if (status == DDOF_OK)
        status = vulkan_device_check(vk, make_draw(f, stage, parts), "compiling the shaders of sprites");
    while (made-- > 0)
        vk->f.DestroyShaderModule(vk->config.device, stage[made].module, vk->allocator);
    return status;
}

static ddof_status make_pipelines(ddof_vulkan_frame *f) {
    const bool full = f->sprite_kind.bokeh == DDOF_BOKEH_FULL;
    ddof_status status = make_compute(f, SPRITES_APPEND);
    if (status == DDOF_OK && !full) status = make_compute(f, SPRITES_HISTOGRAM);
    if (status == DDOF_OK && !full) status = make_compute(f, SPRITES_RAISE);
    if (status == DDOF_OK && !full && f->first == PICTURE_COLOR) status = make_compute(f, SPRITES_TAKE);
    if (status == DDOF_OK) status = make_compute(f, SPRITES_RESOLVE);
    return status == DDOF_OK ? make_graphics(f) : status;
}

/* ---- all of it */

ddof_status vulkan_sprites_make(ddof_vulkan_frame *f) {
    ddof_vulkan *vk = f->vk;
    vulkan_sprites *s = f->sprites = vk->config.allocate(vk->config.memory_user, sizeof *s);
    if (!s) return context_fail(&vk->shell, DDOF_ERROR_MEMORY, "out of memory for the sprites of a frame object");
    memset(s, 0, sizeof *s);
    s->stages = VK_SHADER_STAGE_COMPUTE_BIT | VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT;
    if (f->sprite_kind.quads == DDOF_QUADS_GEOMETRY) s->stages |= VK_SHADER_STAGE_GEOMETRY_BIT;
    ddof_status status = vulkan_device_check(vk, make_layouts(vk, s), "making the layouts of the sprites' passes");
    if (status == DDOF_OK) status = vulkan_device_check(vk, make_set(f), "making a descriptor set for sprites");
    if (status == DDOF_OK) status = vulkan_device_check(vk, make_render_pass(f), "making a render pass for sprites");
    if (status == DDOF_OK) status = vulkan_device_check(vk, make_framebuffer(f), "making a framebuffer for sprites");
    return status == DDOF_OK ? make_pipelines(f) : status;
}

void vulkan_sprites_delete(ddof_vulkan_frame *f) {
    const ddof_vulkan *vk = f->vk;
    const VkDevice device = vk->config.device;
    vulkan_sprites *s = f->sprites;
    if (!s) return;
    for (int i = 0; i < SPRITES_PASSES; i++)
        if (s->pipeline[i]) vk->f.DestroyPipeline(device, s->pipeline[i], vk->allocator);
    if (s->framebuffer) vk->f.DestroyFramebuffer(device, s->framebuffer, vk->allocator);
    if (s->render_pass) vk->f.DestroyRenderPass(device, s->render_pass, vk->allocator);
    if (s->pool) vk->f.DestroyDescriptorPool(device, s->pool, vk->allocator);
    if (s->layout) vk->f.DestroyPipelineLayout(device, s->layout, vk->allocator);
    if (s->set_layout) vk->f.DestroyDescriptorSetLayout(device, s->set_layout, vk->allocator);
    vk->config.release(vk->config.memory_user, s);
    f->sprites = NULL;
}
