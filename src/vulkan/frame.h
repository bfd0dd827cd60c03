/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* A frame object: views of the caller's images, scratch, descriptor sets, pipelines. */
#ifndef DDOF_VULKAN_FRAME_H
#define DDOF_VULKAN_FRAME_H

#include "device.h"

/* The pictures that passes read and write. WORK is what is under way after a direction; of the heat kernel, where the
 * output can hold it, it is the output. ROWS: what a solver that reads neighbours' pixels has made of the rows. The
 * disc kernel has a component under way in WORK and IMAGINARY, and those done in SUM; where the output can hold that,
 * it is the output. Sprites are drawn into LIGHT and, of DDOF_BOKEH_FULL, WEIGHT. REMAINDER: what highlights leave of
 * the colour. */
typedef enum vulkan_picture {
    PICTURE_COLOR,
    PICTURE_ROWS,
    PICTURE_WORK,
    PICTURE_IMAGINARY,
    PICTURE_SUM,
    PICTURE_REMAINDER,
    PICTURE_LIGHT,
    PICTURE_WEIGHT,
    PICTURE_OUTPUT,
    VULKAN_PICTURES
} vulkan_picture;

/* From one picture to another; WORK has IMAGINARY with it. */
typedef struct vulkan_set {
    vulkan_picture from, to;
    VkDescriptorSet handle;
} vulkan_set;

/* Buffers of scratch memory: what solvers keep of lines; of sprites their counters, themselves, and the iris. */
typedef enum vulkan_buffer {
    BUFFER_LEVELS,
    BUFFER_SPRITE_STATE,
    BUFFER_SPRITE_LIST,
    BUFFER_SPRITE_TABLES,
    VULKAN_BUFFERS
} vulkan_buffer;

/* What of the settings for sprites is fixed, defaults filled in. */
typedef struct vulkan_sprite_kind {
    ddof_bokeh bokeh;
    bool half; /* resolution */
    int most;  /* sprites */
    ddof_append append;
    ddof_quads quads;
} vulkan_sprite_kind;

enum { VULKAN_SETS = 4, VULKAN_FRAME_PIPELINES = 32 };

typedef struct vulkan_scratch {
    VkImage image[VULKAN_PICTURES]; /* null: not in scratch */
    VkBuffer buffer[VULKAN_BUFFERS];
    VkDeviceSize image_offset[VULKAN_PICTURES], buffer_offset[VULKAN_BUFFERS], buffer_bytes[VULKAN_BUFFERS];
    VkMemoryRequirements total; /* size 0: none is needed */
    VkDeviceMemory memory;      /* the library's own, or null */
} vulkan_scratch;

struct ddof_vulkan_frame {
    ddof_vulkan *vk;
    ddof_context shell; /* for its error text */
    ddof_vulkan_images images;
    ddof_solver solver; /* that does it */
    ddof_solver asked;  /* as the settings have it, never DEFAULT */
    ddof_surface surface;
    ddof_depth_kind depth_kind;
    bool is_depth, in_place, alpha;
    const disc_kernel *disc; /* NULL: the heat kernel */
    vulkan_sprite_kind sprite_kind;
    struct vulkan_sprites *sprites; /* NULL: none are wanted */
    int colors;                     /* channels that shine; with alpha, the last is not one of them */
    vulkan_picture first;           /* what diffusion begins with: COLOR, or what highlights leave of it */
    vulkan_picture output_also;     /* WORK or SUM, where it lies in the output; else OUTPUT */
    VkFormat work_format;           /* of the pictures in scratch, and of WORK */
    VkFormat light_format;          /* of LIGHT */
    int map_shift;
    line_plan line[2]; /* along rows, along columns */
    vulkan_scratch scratch;
    VkImageView sampled[VULKAN_PICTURES], stored[VULKAN_PICTURES], map;
    VkDescriptorPool pool;
    vulkan_set set[VULKAN_SETS];
    int sets;
    vulkan_pipeline pipeline[VULKAN_FRAME_PIPELINES];
    int pipelines;
};

/* frame.c. What the images say has been checked. On failure nothing is left, and vk's error is set. */
ddof_status vulkan_frame_make(ddof_vulkan_frame *frame);
void vulkan_frame_delete(ddof_vulkan_frame *frame);

/* The size of LIGHT and WEIGHT for a picture of this size; and of the frame's. */
VkExtent2D vulkan_light_size_of(const vulkan_sprite_kind *kind, int width, int height);
VkExtent2D vulkan_light_size(const ddof_vulkan_frame *frame);

/* Whether the output is sampled as well. */
bool vulkan_output_is_read(const ddof_vulkan_frame *frame);

/* Where a picture lies: OUTPUT or itself. */
vulkan_picture vulkan_place(const ddof_vulkan_frame *frame, vulkan_picture picture);

/* scratch.c: the objects of a frame, not bound, and what memory they need. On failure: vulkan_scratch_delete(). */
ddof_status vulkan_scratch_make(ddof_vulkan *vk, ddof_vulkan_frame *frame);
/* Binds them to the caller's memory or to memory of the library's own. */
ddof_status vulkan_scratch_bind(ddof_vulkan *vk, ddof_vulkan_frame *frame);
void vulkan_scratch_delete(ddof_vulkan *vk, vulkan_scratch *s);
VkFormat vulkan_scratch_format(const ddof_vulkan_frame *frame, vulkan_picture picture);

/* Whether it has a depth aspect. */
bool vulkan_format_is_depth(VkFormat format);

#endif
