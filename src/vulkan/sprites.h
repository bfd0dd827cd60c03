/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Sprites (../bokeh.h) of a frame object. All on the device: what becomes a sprite is listed by compute passes, the
 * list's length becomes the argument of one draw, and a compute pass lays what was drawn over the picture.
 *
 *   HIGHLIGHTS  histogram, raise, append, take (in place), draw, the passes of diffusion, resolve
 *   FULL        append, draw, resolve
 *
 * LIGHT has room for all levels of ../bokeh.h: the first, and below it the others side by side. Of FULL it has that
 * twice, and so has WEIGHT: the upper half for what lies behind the focus, the lower for what lies before it. Sprites
 * are cut off where their level ends, by their rectangles: so one viewport and one draw do. */
#ifndef DDOF_VULKAN_SPRITES_H
#define DDOF_VULKAN_SPRITES_H

#include "../iris.h"
#include "frame.h"
#include "passes.h"

/* Bindings of sprites.glsl. */
enum {
    SPRITES_COLOR,
    SPRITES_MAP,
    SPRITES_REMAINDER,
    SPRITES_OUTPUT,
    SPRITES_STATE,
    SPRITES_LIST,
    SPRITES_TABLES,
    SPRITES_BLURRED,
    SPRITES_LIGHT,
    SPRITES_WEIGHT,
    SPRITES_BINDINGS
};

/* Member by member what sprites.glsl has. */
typedef struct sprite_push {
    vulkan_picture_push picture;
    int32_t width, height, target_width, part_height;
    int32_t levels, colors;
    float threshold, largest;
    uint32_t most, most_area_low, most_area_high;
} sprite_push;

typedef struct sprite_tables {
    int32_t kind;
    float blades, curvature, edge, cats_eye, squeeze, fringe, aspect;
    float turn[2], middle[2];
    float per_diagonal, reach, spare[2];
    float diameter[IRIS_NODES], inverse_sum[IRIS_SUMS][IRIS_NODES], cats_gain[IRIS_CATS];
    float texel[IRIS_TEXELS];
} sprite_tables;

/* How buffer STATE begins. */
typedef struct sprite_state {
    VkDrawIndirectCommand draw;
    uint32_t count, dropped, large;
    float raised;
    int32_t raised_bin;
    uint32_t used_levels, unused[6];
} sprite_state;

/* Specialisation constants, in the order of constant_id in sprites.glsl, from 1. */
typedef struct sprite_constants {
    int32_t full, depth, alpha, target_half, half_size, arguments, points, remainder;
} sprite_constants;

typedef enum sprite_pass {
    SPRITES_HISTOGRAM,
    SPRITES_RAISE,
    SPRITES_APPEND,
    SPRITES_TAKE,
    SPRITES_RESOLVE,
    SPRITES_DRAW,
    SPRITES_PASSES
} sprite_pass;

typedef struct vulkan_sprites {
    VkDescriptorSetLayout set_layout;
    VkDescriptorPool pool;
    VkDescriptorSet set;
    VkPipelineLayout layout;
    VkShaderStageFlags stages; /* that see the push constants */
    VkRenderPass render_pass;
    VkFramebuffer framebuffer;
    VkPipeline pipeline[SPRITES_PASSES];
    VkQueryPool timestamps; /* null: none are wanted */
    uint32_t first_timestamp;
    iris iris;
    sprite_tables tables;
} vulkan_sprites;

/* How many bytes each buffer needs; 0: none. */
void vulkan_sprites_bytes(const ddof_vulkan_frame *frame, VkDeviceSize bytes[VULKAN_BUFFERS]);

/* sprite_target.c: what is drawn into, and pipelines. Views of the frame's pictures are there. On failure: _delete().
 */
ddof_status vulkan_sprites_make(ddof_vulkan_frame *frame);
void vulkan_sprites_delete(ddof_vulkan_frame *frame);

extern const char vulkan_no_such_method[];

/* Fills in sprite_kind; says what of it this device cannot do. */
ddof_status vulkan_sprites_choose(ddof_vulkan *vk, ddof_vulkan_frame *frame, const ddof_settings *settings);
vulkan_sprite_kind vulkan_sprite_kind_of(const ddof_settings *settings);
/* The member of settings in which they differ, or NULL. */
const char *vulkan_sprite_kind_differs(const vulkan_sprite_kind *a, const vulkan_sprite_kind *b);

/* sprites.c: the iris, made anew when it has changed. Errors: INVALID. */
ddof_status vulkan_sprites_prepare(ddof_vulkan_frame *frame, const frame_job *job);

/* Record what comes before diffusion, and after it. Nothing can fail. Return how many dispatches there were. */
int vulkan_sprites_draw(const ddof_vulkan_frame *frame, VkCommandBuffer commands, const frame_job *job,
                        const vulkan_region *region);
int vulkan_sprites_resolve(const ddof_vulkan_frame *frame, VkCommandBuffer commands, const frame_job *job,
                           const vulkan_region *region);

#endif
