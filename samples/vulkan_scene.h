/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* In the place of an engine's renderer: a compute shader that draws pictures with depth, and one that maps the
 * result to the screen. */
#ifndef DDOF_VULKAN_SCENE_H
#define DDOF_VULKAN_SCENE_H

#include "vulkan_sample.h"

#define SCENE_NEAR 0.1f       /* near plane, metres. Depth is SCENE_NEAR / z: reversed-Z, 0 is infinitely far */
#define SCENE_FOCAL_LENGTH 85 /* millimetres, on a sensor 36 mm wide: the scene is seen, and blurred, by one lens */

typedef struct scene {
    VkDescriptorSetLayout set_layout;
    VkDescriptorPool set_pool;
    VkPipelineLayout layout;
    VkPipeline render, tonemap;
} scene;

/* The images a frame goes through. */
typedef struct scene_images {
    sample_image color, depth; /* RGBA16F, scene-linear; R32F: written by scene_render() */
    sample_image blurred;      /* RGBA16F: read by scene_tonemap() */
    sample_image shown;        /* RGBA8 encoded as sRGB: written by it */
    VkDescriptorSet set;
} scene_images;

/* For as many as `frames` scene_images at a time. */
scene scene_create(const sample *s, uint32_t frames);
void scene_destroy(const sample *s, scene *sc);
scene_images scene_images_create(const sample *s, const scene *sc, uint32_t width, uint32_t height);
void scene_images_destroy(const sample *s, const scene *sc, scene_images *images);

/* Expects color and depth as SAMPLE_WRITE. The scene moves in a loop: time 0 to 1 is once around. */
void scene_render(const scene *sc, VkCommandBuffer commands, const scene_images *images, float time);

/* Expects blurred as SAMPLE_READ, shown as SAMPLE_WRITE. */
void scene_tonemap(const scene *sc, VkCommandBuffer commands, const scene_images *images);

#endif
