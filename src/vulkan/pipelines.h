/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The shaders, and of those that diffuse one pipeline for each module and set of constants, made when a frame object
 * that needs it is. */
#ifndef DDOF_VULKAN_PIPELINES_H
#define DDOF_VULKAN_PIPELINES_H

#include "functions.h"

/* Compiled files of shaders/vulkan. */
typedef enum vulkan_module {
    MODULE_LINE,           /* without subgroups */
    MODULE_LINE_SUBGROUPS, /* with */
    MODULE_DISC_LINE,      /* of the disc kernel, likewise */
    MODULE_DISC_LINE_SUBGROUPS,
    MODULE_PCR_FIRST,
    MODULE_PCR,
    MODULE_PCR_LAST,
    MODULE_SWEEP,
    MODULE_INITIAL_REDUCE4,
    MODULE_REDUCE,
    MODULE_SOLVE,
    MODULE_SUBSTITUTE,
    MODULE_FINAL_SOLVE4,
    MODULE_SPRITES_HISTOGRAM,
    MODULE_SPRITES_RAISE,
    MODULE_SPRITES_APPEND,
    MODULE_SPRITES_TAKE,
    MODULE_SPRITES_RESOLVE,
    MODULE_SPRITES_VERTEX,
    MODULE_SPRITES_POINT,
    MODULE_SPRITES_GEOMETRY,
    MODULE_SPRITES_PIXEL,
    MODULE_SPRITES_PIXEL_WEIGHT,
    VULKAN_MODULES
} vulkan_module;

typedef struct vulkan_code {
    const char *making; /* what to call it in an error */
    const uint32_t *word;
    size_t bytes;
} vulkan_code;

extern const vulkan_code vulkan_codes[VULKAN_MODULES];

/* Specialisation constants, in the order of constant_id in shaders/vulkan/pass.glsl, line.comp and disc_line.comp. */
typedef struct vulkan_constants {
    int32_t workgroup;
    int32_t vertical; /* 0: rows, 1: columns; of the disc kernel: DISC_ROWS and so on */
    int32_t depth;    /* 0: the map holds CoC; else 1 + ddof_depth_kind */
    int32_t alpha;
    int32_t half, target_half;
    int32_t last;
    int32_t k, strip, subgroup; /* of LINE */
    int32_t from_real, add;     /* of the disc kernel */
} vulkan_constants;

/* What the disc kernel's pass solves: a component, along a direction. */
typedef struct vulkan_disc_push {
    float fade, beta[2], offset[2], weight[2], level, slope, excess;
} vulkan_disc_push;

/* How depth becomes CoC, and where the picture lies in its images. */
typedef struct vulkan_picture_push {
    float lens_curve[4], depth_axis[4];
    float depth_linear[2], lens_limit[2];
    int32_t color_place[2], map_place[2];
    int32_t map_shift;
} vulkan_picture_push;

/* Member by member what pass.glsl has. */
typedef struct vulkan_push {
    vulkan_picture_push picture;
    int32_t unknowns;
    int32_t lines, first_line;
    int32_t first_pass;
    union {
        struct {
            float scale;
            int32_t known, to_unknowns, stride;
            uint32_t rows_at, y_at, to_at;
        };
        vulkan_disc_push disc;
    };
} vulkan_push;

typedef struct vulkan_pipeline {
    vulkan_module module;
    vulkan_constants constants;
    VkPipeline handle;
} vulkan_pipeline;

/* Kept in the order of their making; they live as long as the ddof_vulkan. */
typedef struct vulkan_pipelines {
    vulkan_pipeline *pipeline;
    int count, room;
} vulkan_pipelines;

/* A shader; VK_NULL_HANDLE: *status says why, and the error is set. */
VkShaderModule vulkan_module_make(ddof_vulkan *vk, vulkan_module module, ddof_status *status);

/* The pipeline, made if need be; VK_NULL_HANDLE: *status says why, and the error is set. */
VkPipeline vulkan_pipeline_get(ddof_vulkan *vk, vulkan_module module, const vulkan_constants *constants,
                               ddof_status *status);
void vulkan_pipelines_delete(ddof_vulkan *vk);

#endif
