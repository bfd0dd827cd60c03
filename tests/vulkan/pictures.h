/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Images of the test's own with known values, and frames made of them. */
#ifndef TESTS_VULKAN_PICTURES_H
#define TESTS_VULKAN_PICTURES_H

#include "tap.h"
#include "texels.h"

/* A level and a layer of an image, as the library is told of it, and with the usage that is said; but that it can be
 * copied, too. After each call here it is in the layout d.layout. */
typedef struct picture {
    ddof_vulkan_image d;
    VkDeviceMemory memory;
    uint32_t levels, layers;
} picture;

/* Whether the device has such images. */
bool picture_possible(VkFormat format, VkImageUsageFlags usage);

/* layout 0: what the library takes 0 for; with STORAGE: GENERAL. */
picture picture_make(VkFormat format, int width, int height, VkImageUsageFlags usage, VkImageLayout layout);
/* Level 1 of 3 and layer 2 of 4, of that size. */
picture picture_part(VkFormat format, int width, int height, VkImageUsageFlags usage);
void picture_free(picture *p);

/* The texels of a level and a layer, without gaps, as texels.h has them. */
void picture_write(const picture *p, uint32_t level, uint32_t layer, const void *texels);
void picture_read(const picture *p, uint32_t level, uint32_t layer, void *texels);
size_t picture_bytes(const picture *p, uint32_t level);

/* Four floats a texel; of one channel: the first. */
void picture_put(const picture *p, const float *rgba);
void picture_get(const picture *p, float *rgba);

/* ---- what a frame is made of */

typedef struct frame_kind {
    int width, height;
    VkFormat color, map, output; /* output UNDEFINED: color itself, in place. 0: RGBA32F, R32F, - */
    bool is_depth;               /* map */
    bool half_map;               /* of half size */
    bool parts;                  /* of images with levels and layers */
    bool sampled;                /* the output, whatever its format */
    int channels;                /* as in ddof_vulkan_images */
    color_pattern pattern;
    coc_pattern coc;
    VkImageLayout layout; /* of the inputs */
} frame_kind;

/* `values`: what is sampled, the map in the size of the picture. */
typedef struct frame_set {
    frame_kind kind;
    scene values;
    picture color, map, output;
    ddof_vulkan_images images;
} frame_set;

frame_set set_make(frame_kind kind, uint64_t seed);
void set_free(frame_set *set);
void set_upload(frame_set *set); /* again, where the input is overwritten or `values` changed: all representable */

/* Where depth is 0..1 as in a depth buffer. */
extern const ddof_settings depth_settings;

/* What the float64 reference makes of the view, RGBA without gaps; fenced_free() it. */
float *set_want(const frame_set *set, const ddof_vulkan_view *view, const ddof_settings *settings);

ddof_vulkan_frame *frame_of(ddof_vulkan *vk, const frame_set *set, const ddof_settings *settings);
/* Must succeed. */
void record(ddof_vulkan_frame *frame, VkCommandBuffer commands, const ddof_vulkan_view *view,
            const ddof_settings *settings, ddof_vulkan_stats *stats);
/* Frame object, command buffer, submission; nothing left over. */
ddof_vulkan_stats set_render(ddof_vulkan *vk, const frame_set *set, const ddof_vulkan_view *view,
                             const ddof_settings *settings);

/* Settings with each of the solvers, then the disc kernel; and copies with a surface and, of the heat
 * kernel, a conductance and substeps. */
enum { SOLVERS = 4, METHODS = SOLVERS + 1 };
ddof_settings method(int k, ddof_surface surface);
ddof_settings heat_method(int k, ddof_surface surface, ddof_conductance conductance, int substeps);

/* What is promised of the error, of the range, by kernel, solver and surface. */
double tolerance(const frame_set *set, const ddof_settings *settings, double aspect);

/* The output, or its part in the view, is `want` but for `allowed` and a step of its format. */
void set_compare(const frame_set *set, const ddof_vulkan_view *view, const float *want, double allowed,
                 const char *format, ...) __attribute__((format(printf, 5, 6)));

/* Renders and compares to what surface, solver and format promise; the statistics. */
ddof_vulkan_stats set_check(ddof_vulkan *vk, const frame_set *set, const ddof_vulkan_view *view,
                            const ddof_settings *settings, const char *what);

#endif
