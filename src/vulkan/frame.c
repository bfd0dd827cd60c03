/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "frame.h"

#include <string.h>

#include "passes.h"
#include "sprites.h"

bool vulkan_format_is_depth(VkFormat format) {
    return format >= VK_FORMAT_D16_UNORM && format <= VK_FORMAT_D32_SFLOAT_S8_UINT;
}

vulkan_picture vulkan_place(const ddof_vulkan_frame *f, vulkan_picture picture) {
    return picture == f->output_also ? PICTURE_OUTPUT : picture;
}

bool vulkan_output_is_read(const ddof_vulkan_frame *f) {
    return f->output_also != PICTURE_OUTPUT || f->sprite_kind.bokeh == DDOF_BOKEH_HIGHLIGHTS;
}

/* ---- views */

/* A view restricted to one usage: the format may allow no other. */
static ddof_status view(ddof_vulkan *vk, VkImage image, VkFormat format, uint32_t level, uint32_t layer,
                        VkImageUsageFlags usage, VkImageView *made, const char *what) {
    const VkImageViewUsageCreateInfo only = {.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_USAGE_CREATE_INFO, .usage = usage};
    const VkImageViewCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
        .pNext = &only,
        .image = image,
        .viewType = VK_IMAGE_VIEW_TYPE_2D,
        .format = format,
        .subresourceRange = {vulkan_format_is_depth(format) ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT,
                             level, 1, layer, 1}};
    return vulkan_device_check(vk, vk->f.CreateImageView(vk->config.device, &info, vk->allocator, made), what);
}

static ddof_status view_of_caller(ddof_vulkan *vk, const ddof_vulkan_image *i, VkImageUsageFlags usage,
                                  VkImageView *made, const char *what) {
    return view(vk, i->image, i->format, i->mip_level, i->array_layer, usage, made, what);
}

static ddof_status view_scratch(ddof_vulkan_frame *f, vulkan_picture picture) {
    static const char doing[] = "viewing a scratch image";
    ddof_vulkan *vk = f->vk;
    const VkFormat format = vulkan_scratch_format(f, picture);
    const bool drawn = picture == PICTURE_LIGHT || picture == PICTURE_WEIGHT;
    ddof_status status =
        view(vk, f->scratch.image[picture], format, 0, 0, VK_IMAGE_USAGE_SAMPLED_BIT, &f->sampled[picture], doing);
    if (status != DDOF_OK) return status;
    return view(vk, f->scratch.image[picture], format, 0, 0,
                drawn ? VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT : VK_IMAGE_USAGE_STORAGE_BIT, &f->stored[picture], doing);
}

static ddof_status make_views(ddof_vulkan_frame *f) {
    const ddof_vulkan_images *i = &f->images;
    ddof_vulkan *vk = f->vk;
    ddof_status status =
        view_of_caller(vk, &i->color, VK_IMAGE_USAGE_SAMPLED_BIT, &f->sampled[PICTURE_COLOR], "viewing images.color");
    if (status == DDOF_OK)
        status = view_of_caller(vk, f->is_depth ? &i->depth : &i->coc, VK_IMAGE_USAGE_SAMPLED_BIT, &f->map,
                                f->is_depth ? "viewing images.depth" : "viewing images.coc");
    if (status == DDOF_OK)
        status = view_of_caller(vk, &i->output, VK_IMAGE_USAGE_STORAGE_BIT, &f->stored[PICTURE_OUTPUT],
                                "viewing images.output");
    if (status == DDOF_OK && vulkan_output_is_read(f))
        status = view_of_caller(vk, &i->output, VK_IMAGE_USAGE_SAMPLED_BIT, &f->sampled[PICTURE_OUTPUT],
                                "viewing images.output");
    for (int p = 0; p < VULKAN_PICTURES && status == DDOF_OK; p++)
        if (f->scratch.image[p]) status = view_scratch(f, (vulkan_picture)p);
    return status;
}

/* ---- descriptor sets */

static void list_sets(ddof_vulkan_frame *f) {
    static const vulkan_set heat[] = {{PICTURE_COLOR, PICTURE_WORK, VK_NULL_HANDLE},
                                      {PICTURE_WORK, PICTURE_WORK, VK_NULL_HANDLE},
                                      {PICTURE_WORK, PICTURE_OUTPUT, VK_NULL_HANDLE}},
                            heat_by_rows[] = {{PICTURE_COLOR, PICTURE_ROWS, VK_NULL_HANDLE},
                                              {PICTURE_WORK, PICTURE_ROWS, VK_NULL_HANDLE},
                                              {PICTURE_ROWS, PICTURE_WORK, VK_NULL_HANDLE},
                                              {PICTURE_ROWS, PICTURE_OUTPUT, VK_NULL_HANDLE}},
                            sum = {PICTURE_WORK, PICTURE_SUM, VK_NULL_HANDLE};
    const bool by_rows = f->scratch.image[PICTURE_ROWS];
    f->sets = by_rows ? 4 : 3;
    memcpy(f->set, by_rows ? heat_by_rows : heat, sizeof *f->set * (size_t)f->sets);
    for (int i = 0; i < f->sets; i++)
        if (f->set[i].from == PICTURE_COLOR && f->first == PICTURE_REMAINDER) f->set[i].from = f->first;
    if (f->disc && f->disc->components > 1) f->set[f->sets++] = sum;
}

/* What a descriptor set has at a binding; false: nothing. */
static bool binding_of(const ddof_vulkan_frame *f, const vulkan_set *set, uint32_t binding,
                       VkDescriptorImageInfo *image) {
    const VkImageLayout map = f->is_depth ? f->images.depth.layout : f->images.coc.layout,
                        from = set->from == PICTURE_COLOR ? f->images.color.layout : VK_IMAGE_LAYOUT_GENERAL;
    VkImageView view = VK_NULL_HANDLE;
    if (binding == BIND_COLOR) view = f->sampled[vulkan_place(f, set->from)];
    if (binding == BIND_MAP) view = f->map;
    if (binding == BIND_TARGET) view = f->stored[vulkan_place(f, set->to)];
    if (binding == BIND_IMAGINARY) view = f->sampled[PICTURE_IMAGINARY];
    if (binding == BIND_TARGET_IMAGINARY) view = f->stored[PICTURE_IMAGINARY];
    if (binding == BIND_SUM && f->disc) { /* of one component nothing is added up, but the shader could */
        view = f->sampled[vulkan_place(f, PICTURE_SUM)];
        if (!view) view = f->sampled[PICTURE_IMAGINARY];
    }
    *image = (VkDescriptorImageInfo){.imageView = view,
                                     .imageLayout = binding == BIND_COLOR ? from
                                                    : binding == BIND_MAP ? map
                                                                          : VK_IMAGE_LAYOUT_GENERAL};
    return view != VK_NULL_HANDLE;
}

static void write_set(ddof_vulkan_frame *f, const vulkan_set *set) {
    const VkDescriptorBufferInfo levels = {f->scratch.buffer[BUFFER_LEVELS], 0, VK_WHOLE_SIZE};
    VkDescriptorImageInfo image[VULKAN_BINDINGS];
    VkWriteDescriptorSet write[VULKAN_BINDINGS];
    uint32_t count = 0;
    for (uint32_t i = 0; i < VULKAN_BINDINGS; i++) {
        const bool is_buffer = vulkan_binding_types[i] == VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
        if (is_buffer ? !levels.buffer : !binding_of(f, set, i, &image[i])) continue;
        write[count++] = (VkWriteDescriptorSet){.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                                .dstSet = set->handle,
                                                .dstBinding = i,
                                                .descriptorCount = 1,
                                                .descriptorType = vulkan_binding_types[i],
                                                .pImageInfo = is_buffer ? NULL : &image[i],
                                                .pBufferInfo = is_buffer ? &levels : NULL};
    }
    f->vk->f.UpdateDescriptorSets(f->vk->config.device, count, write, 0, NULL);
}

static ddof_status make_sets(ddof_vulkan_frame *f) {
    ddof_vulkan *vk = f->vk;
    const uint32_t n = VULKAN_SETS;
    const VkDescriptorPoolSize size[3] = {{VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE, 4 * n},
                                          {VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, 2 * n},
                                          {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 2 * n}};
    const VkDescriptorPoolCreateInfo pool = {
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO, .maxSets = n, .poolSizeCount = 3, .pPoolSizes = size};
    list_sets(f);
    ddof_status status = vulkan_device_check(
        vk, vk->f.CreateDescriptorPool(vk->config.device, &pool, vk->allocator, &f->pool), "making a descriptor pool");
    for (int i = 0; i < f->sets && status == DDOF_OK; i++) {
        const VkDescriptorSetAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                                  .descriptorPool = f->pool,
                                                  .descriptorSetCount = 1,
                                                  .pSetLayouts = &vk->set_layout};
        status = vulkan_device_check(vk, vk->f.AllocateDescriptorSets(vk->config.device, &info, &f->set[i].handle),
                                     "making a descriptor set");
        if (status == DDOF_OK) write_set(f, &f->set[i]);
    }
    return status;
}

/* ---- all of it */

ddof_status vulkan_frame_make(ddof_vulkan_frame *f) {
    ddof_status status = vulkan_scratch_make(f->vk, f);
    if (status == DDOF_OK) status = vulkan_scratch_bind(f->vk, f);
    if (status == DDOF_OK) status = make_views(f);
    if (status == DDOF_OK && f->sprite_kind.bokeh) status = vulkan_sprites_make(f);
    if (status == DDOF_OK && f->sprite_kind.bokeh != DDOF_BOKEH_FULL) status = make_sets(f);
    if (status == DDOF_OK && f->sprite_kind.bokeh != DDOF_BOKEH_FULL) status = vulkan_passes_prepare(f);
    if (status != DDOF_OK) vulkan_frame_delete(f);
    return status;
}

void vulkan_frame_delete(ddof_vulkan_frame *f) {
    ddof_vulkan *vk = f->vk;
    const VkDevice device = vk->config.device;
    vulkan_sprites_delete(f);
    if (f->pool) vk->f.DestroyDescriptorPool(device, f->pool, vk->allocator);
    for (int i = 0; i < VULKAN_PICTURES; i++) {
        if (f->sampled[i]) vk->f.DestroyImageView(device, f->sampled[i], vk->allocator);
        if (f->stored[i]) vk->f.DestroyImageView(device, f->stored[i], vk->allocator);
    }
    if (f->map) vk->f.DestroyImageView(device, f->map, vk->allocator);
    vulkan_scratch_delete(vk, &f->scratch);
}
