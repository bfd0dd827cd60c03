/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The functions of ddof/vulkan.h: what the caller says is checked before anything is made or recorded. */
#include <string.h>

#include "frame.h"
#include "passes.h"
#include "sprites.h"

/* ---- what all frames share */

static const char *wrong_config(const ddof_vulkan_config *c) {
    if (!c->instance || !c->physical_device || !c->device)
        return "config.instance, physical_device and device must be given";
    if (!c->get_instance_proc_addr)
        return "config.get_instance_proc_addr is NULL: how are Vulkan's functions to be found?";
    if (!c->allocate != !c->release) return "config.allocate and config.release must both be given, or neither";
    if (c->pipeline_cache_size && !c->pipeline_cache)
        return "config.pipeline_cache_size is not 0 but there are no data";
    if (!RESERVED_ZERO(c)) return "config.reserved must be 0";
    return NULL;
}

ddof_status ddof_vulkan_create(ddof_vulkan **vk, const ddof_vulkan_config *config) {
    char text[512] = "";
    if (!vk) return DDOF_ERROR_INVALID;
    *vk = NULL;
    if (!config) return DDOF_ERROR_INVALID;
    ddof_vulkan_config c = *config;
    const char *wrong = wrong_config(&c);
    if (wrong) {
        if (c.log) c.log(c.log_user, DDOF_LOG_ERROR, wrong);
        return DDOF_ERROR_INVALID;
    }
    if (!c.allocate) {
        c.allocate = context_allocate;
        c.release = context_release;
    }
    ddof_status status = vulkan_device_create(vk, &c, text, sizeof text);
    if (status != DDOF_OK && c.log && text[0]) c.log(c.log_user, DDOF_LOG_ERROR, text);
    return status;
}

void ddof_vulkan_destroy(ddof_vulkan **vk) {
    if (vk && *vk) vulkan_device_destroy(vk);
}

const char *ddof_vulkan_error(const ddof_vulkan *vk) {
    return vk ? vk->shell.error : "";
}

const char *ddof_vulkan_frame_error(const ddof_vulkan_frame *frame) {
    return frame ? frame->shell.error : "";
}

ddof_status ddof_vulkan_pipeline_cache(ddof_vulkan *vk, void *data, size_t *size) {
    if (!vk) return DDOF_ERROR_INVALID;
    vk->shell.error[0] = 0;
    if (!size) return context_fail(&vk->shell, DDOF_ERROR_INVALID, "size is NULL");
    const VkResult result = vk->f.GetPipelineCacheData(vk->config.device, vk->pipeline_cache, size, data);
    if (result == VK_INCOMPLETE)
        return context_fail(&vk->shell, DDOF_ERROR_INVALID,
                            "there is too little room: ask for the size with data NULL");
    return vulkan_device_check(vk, result, "reading the pipeline cache");
}

/* ---- formats */

static const VkFormat color_formats[] = {VK_FORMAT_R32G32B32A32_SFLOAT,
                                         VK_FORMAT_R16G16B16A16_SFLOAT,
                                         VK_FORMAT_B10G11R11_UFLOAT_PACK32,
                                         VK_FORMAT_E5B9G9R9_UFLOAT_PACK32,
                                         VK_FORMAT_A2B10G10R10_UNORM_PACK32,
                                         VK_FORMAT_R8G8B8A8_UNORM,
                                         VK_FORMAT_R8G8B8A8_SRGB,
                                         VK_FORMAT_B8G8R8A8_UNORM,
                                         VK_FORMAT_B8G8R8A8_SRGB,
                                         0};
static const VkFormat depth_formats[] = {
    VK_FORMAT_D16_UNORM,          VK_FORMAT_X8_D24_UNORM_PACK32, VK_FORMAT_D24_UNORM_S8_UINT, VK_FORMAT_D32_SFLOAT,
    VK_FORMAT_D32_SFLOAT_S8_UINT, VK_FORMAT_R32_SFLOAT,          VK_FORMAT_R16_SFLOAT,        0};
static const VkFormat coc_formats[] = {VK_FORMAT_R32_SFLOAT, VK_FORMAT_R16_SFLOAT, 0};
static const VkFormat output_formats[] = {VK_FORMAT_R32G32B32A32_SFLOAT,
                                          VK_FORMAT_R16G16B16A16_SFLOAT,
                                          VK_FORMAT_B10G11R11_UFLOAT_PACK32,
                                          VK_FORMAT_A2B10G10R10_UNORM_PACK32,
                                          VK_FORMAT_R8G8B8A8_UNORM,
                                          VK_FORMAT_B8G8R8A8_UNORM,
                                          0};

static bool listed(const VkFormat *list, VkFormat format) {
    while (*list && *list != format)
        list++;
    return *list != 0;
}

/* The shaders name no format when they store: from Vulkan 1.3 on, a device says for each whether it can do that. */
static bool has_feature(const ddof_vulkan *vk, VkFormat format, VkFormatFeatureFlags feature) {
    VkFormatProperties3 more = {.sType = VK_STRUCTURE_TYPE_FORMAT_PROPERTIES_3};
    VkFormatProperties2 p = {.sType = VK_STRUCTURE_TYPE_FORMAT_PROPERTIES_2};
    const bool stores = feature & VK_FORMAT_FEATURE_STORAGE_IMAGE_BIT;
    if (stores && vk->version >= VK_API_VERSION_1_3) p.pNext = &more;
    vk->f.GetPhysicalDeviceFormatProperties2(vk->config.physical_device, format, &p);
    if (p.pNext && more.optimalTilingFeatures &&
        !(more.optimalTilingFeatures & VK_FORMAT_FEATURE_2_STORAGE_WRITE_WITHOUT_FORMAT_BIT))
        return false;
    return (p.formatProperties.optimalTilingFeatures & feature) == feature;
}

int ddof_vulkan_can_output(const ddof_vulkan *vk, VkFormat format) {
    return vk && listed(output_formats, format) && has_feature(vk, format, VK_FORMAT_FEATURE_STORAGE_IMAGE_BIT);
}

int ddof_vulkan_can_sample(const ddof_vulkan *vk, VkFormat format) {
    return vk && (listed(color_formats, format) || listed(depth_formats, format)) &&
           has_feature(vk, format, VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT);
}

/* ---- the images of a frame */

static bool layout_allowed(VkFormat format, VkImageLayout layout) {
    const bool depth = vulkan_format_is_depth(format);
    switch (layout) {
    case VK_IMAGE_LAYOUT_GENERAL:
    case VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL:
    case VK_IMAGE_LAYOUT_READ_ONLY_OPTIMAL:
        return true;
    case VK_IMAGE_LAYOUT_DEPTH_STENCIL_READ_ONLY_OPTIMAL:
    case VK_IMAGE_LAYOUT_DEPTH_READ_ONLY_OPTIMAL:
    case VK_IMAGE_LAYOUT_DEPTH_READ_ONLY_STENCIL_ATTACHMENT_OPTIMAL:
        return depth;
    default:
        return false;
    }
}

static ddof_status check_image(ddof_vulkan *vk, ddof_vulkan_image *i, const char *name, const VkFormat *allowed,
                               VkFormatFeatureFlags feature, VkImageUsageFlags usage, bool made) {
    ddof_context *shell = &vk->shell;
    if (!i->format) return context_fail(shell, DDOF_ERROR_INVALID, "images.%s: no image is given", name);
    if (!listed(allowed, i->format))
        return context_fail(shell, DDOF_ERROR_INVALID,
                            "images.%s: VkFormat %d is none of those that ddof/vulkan.h lists for it", name, i->format);
    if (!has_feature(vk, i->format, feature))
        return context_fail(shell, DDOF_ERROR_UNSUPPORTED, "images.%s: this device (%s) cannot %s VkFormat %d", name,
                            vk->name, feature & VK_FORMAT_FEATURE_STORAGE_IMAGE_BIT ? "store to" : "sample", i->format);
    if (made && !i->image) return context_fail(shell, DDOF_ERROR_INVALID, "images.%s.image is VK_NULL_HANDLE", name);
    if (i->width < 1 || i->height < 1)
        return context_fail(shell, DDOF_ERROR_INVALID, "images.%s is %u x %u texels: each side must be above 0", name,
                            i->width, i->height);
    if (i->width > vk->limits.maxImageDimension2D || i->height > vk->limits.maxImageDimension2D)
        return context_fail(shell, DDOF_ERROR_UNSUPPORTED,
                            "images.%s is %u x %u texels, but this device (%s) allows %u", name, i->width, i->height,
                            vk->name, vk->limits.maxImageDimension2D);
    if (i->usage && (i->usage & usage) != usage)
        return context_fail(shell, DDOF_ERROR_INVALID, "images.%s.usage must have%s%s", name,
                            usage & VK_IMAGE_USAGE_STORAGE_BIT ? " VK_IMAGE_USAGE_STORAGE_BIT" : "",
                            usage & VK_IMAGE_USAGE_SAMPLED_BIT ? " VK_IMAGE_USAGE_SAMPLED_BIT" : "");
    if (i->layout && !layout_allowed(i->format, i->layout))
        return context_fail(shell, DDOF_ERROR_INVALID, "images.%s.layout %d is none that ddof/vulkan.h lists for it",
                            name, i->layout);
    if (!i->layout)
        i->layout = vulkan_format_is_depth(i->format) ? VK_IMAGE_LAYOUT_DEPTH_STENCIL_READ_ONLY_OPTIMAL
                                                      : VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
    return DDOF_OK;
}

static bool same_subresource(const ddof_vulkan_image *a, const ddof_vulkan_image *b) {
    return a->image && a->image == b->image && a->mip_level == b->mip_level && a->array_layer == b->array_layer;
}

/* The map has the size of the colour, or half of it. */
static ddof_status check_map(ddof_vulkan *vk, ddof_vulkan_frame *f) {
    const ddof_vulkan_image *color = &f->images.color, *map = f->is_depth ? &f->images.depth : &f->images.coc;
    if (map->width == color->width && map->height == color->height)
        f->map_shift = 0;
    else if (map->width == (color->width + 1) / 2 && map->height == (color->height + 1) / 2)
        f->map_shift = 1;
    else
        return context_fail(
            &vk->shell, DDOF_ERROR_INVALID,
            "images.%s is %u x %u texels: it must have the size of images.color, %u x %u, or half of it",
            f->is_depth ? "depth" : "coc", map->width, map->height, color->width, color->height);
    return DDOF_OK;
}

static ddof_status check_output(ddof_vulkan *vk, ddof_vulkan_frame *f, bool made) {
    ddof_vulkan_images *i = &f->images;
    ddof_vulkan_image *out = &i->output;
    const VkImageUsageFlags usage =
        VK_IMAGE_USAGE_STORAGE_BIT | (vulkan_output_is_read(f) ? (VkImageUsageFlags)VK_IMAGE_USAGE_SAMPLED_BIT : 0);
    ddof_status status =
        check_image(vk, out, "output", output_formats, VK_FORMAT_FEATURE_STORAGE_IMAGE_BIT, usage, made);
    if (status != DDOF_OK) return status;
    if (out->width != i->color.width || out->height != i->color.height)
        return context_fail(&vk->shell, DDOF_ERROR_INVALID,
                            "images.output is %u x %u but images.color is %u x %u texels", out->width, out->height,
                            i->color.width, i->color.height);
    if (f->in_place && out->format != i->color.format)
        return context_fail(&vk->shell, DDOF_ERROR_INVALID,
                            "images.output is images.color, but their formats differ (%d, %d)", out->format,
                            i->color.format);
    if (same_subresource(out, f->is_depth ? &i->depth : &i->coc))
        return context_fail(&vk->shell, DDOF_ERROR_INVALID, "images.output is also the map of depth or CoC");
    out->layout = VK_IMAGE_LAYOUT_GENERAL;
    if (f->in_place) i->color.layout = VK_IMAGE_LAYOUT_GENERAL;
    return DDOF_OK;
}

/* ---- the solver */

static ddof_status choose_solver(ddof_vulkan *vk, ddof_vulkan_frame *f, const ddof_settings *s) {
    f->asked = s->solver == DDOF_SOLVER_DEFAULT ? DDOF_SOLVER_LINE : s->solver;
    f->solver = f->asked;
    if (f->solver != DDOF_SOLVER_LINE && f->solver != DDOF_SOLVER_PCR && f->solver != DDOF_SOLVER_PCR3_SWEEP &&
        f->solver != DDOF_SOLVER_CR4_PACK)
        return context_fail(&vk->shell, DDOF_ERROR_UNSUPPORTED,
                            "settings.solver is one of the GL backend: Vulkan has LINE, PCR, PCR3_SWEEP and CR4_PACK");
    if (f->disc && f->solver != DDOF_SOLVER_LINE)
        return context_fail(&vk->shell, DDOF_ERROR_UNSUPPORTED,
                            "settings.solver: only LINE solves with DDOF_KERNEL_DISC; leave it DEFAULT");
    if (f->sprite_kind.bokeh == DDOF_BOKEH_FULL) return DDOF_OK; /* nothing is solved */
    const int length[2] = {(int)f->images.color.width, (int)f->images.color.height};
    for (int i = 0; i < 2; i++) {
        const bool whole = f->solver == DDOF_SOLVER_LINE;
        if (line_plan_make(&f->line[i], &vk->line, f->disc != NULL, whole ? length[i] : VULKAN_SHORT,
                           i ? VULKAN_STRIP : 1))
            continue;
        if (!whole)
            return context_fail(&vk->shell, DDOF_ERROR_UNSUPPORTED, "this device (%s) has too small workgroups",
                                vk->name);
        if (f->disc)
            return context_fail(&vk->shell, DDOF_ERROR_UNSUPPORTED,
                                "lines of %d pixels are too long for DDOF_KERNEL_DISC on this device (%s): take "
                                "DDOF_KERNEL_HEAT or a smaller picture",
                                length[i], vk->name);
        context_log(&vk->shell, DDOF_LOG_WARNING,
                    "lines of %d pixels are too long for the solver LINE on this device (%s): PCR3_SWEEP does the work",
                    length[i], vk->name);
        f->solver = DDOF_SOLVER_PCR3_SWEEP;
        i = -1; /* both plans anew, for short lines */
    }
    return DDOF_OK;
}

/* Where the pictures lie that passes hand on. A sum does not lie in the output where that is the colour: the next
 * component starts from it. */
static void choose_work(ddof_vulkan_frame *f) {
    const VkFormat out = f->images.output.format;
    const bool exact = f->surface == DDOF_SURFACE_RGBA32F,
               holds = out == VK_FORMAT_R32G32B32A32_SFLOAT || (out == VK_FORMAT_R16G16B16A16_SFLOAT && !exact);
    f->in_place = same_subresource(&f->images.output, &f->images.color);
    f->output_also = PICTURE_OUTPUT;
    f->work_format = exact ? VK_FORMAT_R32G32B32A32_SFLOAT : VK_FORMAT_R16G16B16A16_SFLOAT;
    if (holds && !f->disc) {
        f->output_also = PICTURE_WORK;
        f->work_format = out;
    } else if (holds && f->disc->components > 1 && !f->in_place) {
        f->output_also = PICTURE_SUM;
    }
    f->first = PICTURE_COLOR; /* in place, light is taken out of it */
    if (f->sprite_kind.bokeh == DDOF_BOKEH_HIGHLIGHTS && !f->in_place)
        f->first = f->disc ? PICTURE_REMAINDER : PICTURE_WORK; /* the disc's components all begin with it */
}

static const disc_kernel *disc_of(const ddof_settings *s) {
    if (vulkan_sprite_kind_of(s).bokeh == DDOF_BOKEH_FULL) return NULL;
    return s->kernel == DDOF_KERNEL_DISC ? disc_kernel_pick(s->quality) : NULL;
}

/* The same frame as ddof_render() would have it, without memory. */
static ddof_frame described(const ddof_vulkan_frame *in, const vulkan_region *region, const ddof_vulkan_view *view) {
    ddof_frame f;
    memset(&f, 0, sizeof f);
    f.color.width = f.output.width = region->width;
    f.color.height = f.output.height = region->height;
    f.color.channels = f.output.channels = in->alpha ? 4 : 3;
    ddof_image map = f.color;
    map.channels = 1;
    *(in->is_depth ? &f.depth : &f.coc) = map;
    if (!view) return f;
    f.picture_width = view->picture_width;
    f.picture_height = view->picture_height;
    f.offset_x = view->offset_x;
    f.offset_y = view->offset_y;
    f.pixel_aspect = view->pixel_aspect;
    return f;
}

/* The settings as any backend has them. The lens may still be missing when a frame object is made. */
static ddof_status check_kinds(ddof_vulkan *vk, const ddof_vulkan_frame *f, const ddof_settings *s) {
    const vulkan_region all = {0, 0, (int)f->images.color.width, (int)f->images.color.height};
    ddof_frame same = described(f, &all, NULL);
    same.depth.channels = 0;
    if (f->is_depth && (s->depth.kind < DDOF_DEPTH_PLANAR || s->depth.kind > DDOF_DEPTH_DEVICE))
        return context_fail(&vk->shell, DDOF_ERROR_INVALID, "settings: depth.kind is none of ddof_depth_kind");
    const ddof_status status = check_settings(&vk->shell, &same, s);
    if (status != DDOF_OK || !s->layers) return status;
    return context_fail(&vk->shell, DDOF_ERROR_UNSUPPORTED,
                        "settings.layers: recorded commands diffuse one layer; ddof_render() has layers");
}

static ddof_status describe(ddof_vulkan *vk, ddof_vulkan_frame *f, const ddof_vulkan_images *images,
                            const ddof_settings *settings, bool made) {
    if (!images || !settings)
        return context_fail(&vk->shell, DDOF_ERROR_INVALID, "%s is NULL", images ? "settings" : "images");
    if (images->next || !RESERVED_ZERO(images))
        return context_fail(&vk->shell, DDOF_ERROR_INVALID, "images.next must be NULL and images.reserved 0");
    if (images->channels != 0 && images->channels != 3 && images->channels != 4)
        return context_fail(&vk->shell, DDOF_ERROR_INVALID, "images.channels is %d: give 3 or 4, or 0 for 4",
                            images->channels);
    if (!images->depth.format == !images->coc.format)
        return context_fail(&vk->shell, DDOF_ERROR_INVALID, "exactly one of images.depth and images.coc must be given");
    f->vk = vk;
    f->images = *images;
    f->alpha = images->channels != 3;
    f->is_depth = images->depth.format != 0;
    f->depth_kind = settings->depth.kind;
    f->surface = settings->surface == DDOF_SURFACE_DEFAULT ? DDOF_SURFACE_RGBA16F : settings->surface;
    f->colors = 3;
    const VkFormatFeatureFlags sampled = VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT;
    ddof_status status = check_kinds(vk, f, settings);
    f->disc = status == DDOF_OK ? disc_of(settings) : NULL;
    if (status == DDOF_OK)
        status = check_image(vk, &f->images.color, "color", color_formats, sampled, VK_IMAGE_USAGE_SAMPLED_BIT, made);
    if (status == DDOF_OK)
        status =
            f->is_depth
                ? check_image(vk, &f->images.depth, "depth", depth_formats, sampled, VK_IMAGE_USAGE_SAMPLED_BIT, made)
                : check_image(vk, &f->images.coc, "coc", coc_formats, sampled, VK_IMAGE_USAGE_SAMPLED_BIT, made);
    if (status == DDOF_OK) status = check_map(vk, f);
    if (status == DDOF_OK) status = vulkan_sprites_choose(vk, f, settings);
    if (status != DDOF_OK) return status;
    choose_work(f);
    status = check_output(vk, f, made);
    return status == DDOF_OK ? choose_solver(vk, f, settings) : status;
}

ddof_status ddof_vulkan_scratch(ddof_vulkan *vk, const ddof_vulkan_images *images, const ddof_settings *settings,
                                VkMemoryRequirements *requirements) {
    ddof_vulkan_frame f;
    if (!vk) return DDOF_ERROR_INVALID;
    vk->shell.error[0] = 0;
    if (!requirements) return context_fail(&vk->shell, DDOF_ERROR_INVALID, "requirements is NULL");
    memset(&f, 0, sizeof f);
    *requirements = (VkMemoryRequirements){0, 1, 0};
    ddof_status status = describe(vk, &f, images, settings, false);
    if (status != DDOF_OK) return status;
    status = vulkan_scratch_make(vk, &f);
    if (status == DDOF_OK && f.scratch.total.size) *requirements = f.scratch.total;
    vulkan_scratch_delete(vk, &f.scratch);
    return status;
}

ddof_status ddof_vulkan_frame_create(ddof_vulkan *vk, ddof_vulkan_frame **frame, const ddof_vulkan_images *images,
                                     const ddof_settings *settings) {
    if (frame) *frame = NULL;
    if (!vk) return DDOF_ERROR_INVALID;
    vk->shell.error[0] = 0;
    if (!frame) return context_fail(&vk->shell, DDOF_ERROR_INVALID, "frame is NULL");
    ddof_vulkan_frame *f = vk->config.allocate(vk->config.memory_user, sizeof *f);
    if (!f) return context_fail(&vk->shell, DDOF_ERROR_MEMORY, "out of memory for a frame object");
    memset(f, 0, sizeof *f);
    f->shell.config.log = vk->config.log;
    f->shell.config.log_user = vk->config.log_user;
    ddof_status status = describe(vk, f, images, settings, true);
    if (status == DDOF_OK) status = vulkan_frame_make(f);
    if (status == DDOF_OK)
        *frame = f;
    else
        vk->config.release(vk->config.memory_user, f);
    return status;
}

void ddof_vulkan_frame_destroy(ddof_vulkan_frame **frame) {
    if (!frame || !*frame) return;
    ddof_vulkan_frame *f = *frame;
    *frame = NULL;
    vulkan_frame_delete(f);
    f->vk->config.release(f->vk->config.memory_user, f);
}

/* ---- recording */

static ddof_status check_region(ddof_vulkan_frame *f, const ddof_vulkan_view *v, vulkan_region *region) {
    const int width = (int)f->images.color.width, height = (int)f->images.color.height;
    *region = (vulkan_region){0, 0, width, height};
    if (!v) return DDOF_OK;
    if (v->next || !RESERVED_ZERO(v))
        return context_fail(&f->shell, DDOF_ERROR_INVALID, "view.next must be NULL and view.reserved 0");
    if (!v->width && !v->height && !v->x && !v->y) return DDOF_OK;
    if (v->width < 1 || v->height < 1 || v->x < 0 || v->y < 0 || v->width > width || v->height > height ||
        v->x > width - v->width || v->y > height - v->height)
        return context_fail(&f->shell, DDOF_ERROR_INVALID, "view %d,%d %dx%d is no part of the %d x %d image", v->x,
                            v->y, v->width, v->height, width, height);
    if (f->map_shift && (v->x | v->y) & 1)
        return context_fail(&f->shell, DDOF_ERROR_INVALID,
                            "view.x, y = %d, %d must be even: %s has half the size of the colour", v->x, v->y,
                            f->is_depth ? "depth" : "coc");
    *region = (vulkan_region){v->x, v->y, v->width, v->height};
    return DDOF_OK;
}

static ddof_status check_same(ddof_vulkan_frame *f, const ddof_settings *s) {
    const ddof_solver solver = s->solver == DDOF_SOLVER_DEFAULT ? DDOF_SOLVER_LINE : s->solver;
    const ddof_surface surface = s->surface == DDOF_SURFACE_DEFAULT ? DDOF_SURFACE_RGBA16F : s->surface;
    const disc_kernel *disc = disc_of(s);
    const vulkan_sprite_kind sprites = vulkan_sprite_kind_of(s);
    const char *differs = vulkan_sprite_kind_differs(&sprites, &f->sprite_kind);
    if (s->layers)
        return context_fail(&f->shell, DDOF_ERROR_UNSUPPORTED,
                            "settings.layers: recorded commands diffuse one layer; ddof_render() has layers");
    if (s->method == DDOF_METHOD_GAUSSIAN || s->method == DDOF_METHOD_HEXAGON)
        return context_fail(&f->shell, DDOF_ERROR_UNSUPPORTED, "%s", vulkan_no_such_method);
    if (differs || solver != f->asked || surface != f->surface || disc != f->disc ||
        (f->is_depth && s->depth.kind != f->depth_kind))
        return context_fail(&f->shell, DDOF_ERROR_INVALID,
                            "settings.%s is not what the frame object was made with: make another for it",
                            differs                 ? differs
                            : !disc != !f->disc     ? "kernel"
                            : disc != f->disc       ? "quality"
                            : solver != f->asked    ? "solver"
                            : surface != f->surface ? "surface"
                                                    : "depth.kind");
    if (f->is_depth && s->lens.focus != DDOF_FOCUS_DISTANCE)
        return context_fail(&f->shell, DDOF_ERROR_INVALID,
                            "lens.focus must be DDOF_FOCUS_DISTANCE: reading a pixel back would make the GPU wait");
    return DDOF_OK;
}

static void fill_stats(const ddof_vulkan_frame *f, int dispatches, ddof_vulkan_stats *stats) {
    stats->scratch_bytes = (size_t)f->scratch.total.size;
    stats->dispatches = dispatches;
    stats->solver = f->solver;
    stats->device = f->vk->name;
    if (f->solver != DDOF_SOLVER_LINE) return;
    stats->pixels_per_thread = f->line[0].k;
    stats->workgroup = f->line[0].workgroup;
    stats->strip = f->line[0].strip;
    stats->subgroup = f->line[0].subgroup;
}

ddof_status ddof_vulkan_record(ddof_vulkan_frame *frame, VkCommandBuffer commands, const ddof_vulkan_view *view,
                               const ddof_settings *settings, ddof_vulkan_stats *stats) {
    vulkan_region region;
    frame_job job;
    double distance;
    if (stats) memset(stats, 0, sizeof *stats);
    if (!frame) return DDOF_ERROR_INVALID;
    ddof_context *shell = &frame->shell;
    shell->error[0] = 0;
    if (!commands || !settings)
        return context_fail(shell, DDOF_ERROR_INVALID, "%s is NULL", commands ? "settings" : "commands");
    ddof_status status = check_region(frame, view, &region);
    if (status != DDOF_OK) return status;
    const ddof_frame same = described(frame, &region, view);
    status = check_geometry(shell, &same);
    if (status == DDOF_OK) status = check_settings(shell, &same, settings);
    if (status == DDOF_OK) status = check_same(frame, settings);
    if (status == DDOF_OK) status = pipeline_prepare(shell, &job, &same, settings, true, &distance);
    if (status == DDOF_OK && frame->sprites) status = vulkan_sprites_prepare(frame, &job);
    if (status != DDOF_OK) return status;
    const int dispatches = vulkan_passes_record(frame, commands, &job, &region);
    if (stats) fill_stats(frame, dispatches, stats);
    return DDOF_OK;
}

ddof_status ddof_vulkan_frame_timestamps(ddof_vulkan_frame *frame, VkQueryPool pool, uint32_t first) {
    if (!frame) return DDOF_ERROR_INVALID;
    frame->shell.error[0] = 0;
    if (!frame->sprites)
        return context_fail(&frame->shell, DDOF_ERROR_INVALID,
                            "timestamps are of sprites, and this frame object has none");
    frame->sprites->timestamps = pool;
    frame->sprites->first_timestamp = first;
    return DDOF_OK;
}
