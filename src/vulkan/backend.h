/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The Vulkan backend of ddof_render(): a caller of ddof/vulkan.h with a device of its own. The parts: backend (the
 * device, the blur, the stages), pictures (the images on the GPU, and the way up to them and down). */
#ifndef DDOF_VULKAN_BACKEND_H
#define DDOF_VULKAN_BACKEND_H

#include "../context.h"
#include "../staging.h"
#include "frame.h"
#include "loader.h"

enum { SLOTS = 2 };

#define BACKEND_FUNCTIONS(X)                                                                                           \
    X(AllocateCommandBuffers)                                                                                          \
    X(AllocateMemory)                                                                                                  \
    X(BeginCommandBuffer)                                                                                              \
    X(BindBufferMemory)                                                                                                \
    X(BindImageMemory)                                                                                                 \
    X(CmdCopyBuffer)                                                                                                   \
    X(CmdCopyBufferToImage)                                                                                            \
    X(CmdCopyImageToBuffer)                                                                                            \
    X(CmdPipelineBarrier)                                                                                              \
    X(CreateBuffer)                                                                                                    \
    X(CreateCommandPool)                                                                                               \
    X(CreateFence)                                                                                                     \
    X(CreateImage)                                                                                                     \
    X(DestroyBuffer)                                                                                                   \
    X(DestroyCommandPool)                                                                                              \
    X(DestroyFence)                                                                                                    \
    X(DestroyImage)                                                                                                    \
    X(DeviceWaitIdle)                                                                                                  \
    X(EndCommandBuffer)                                                                                                \
    X(FreeMemory)                                                                                                      \
    X(GetBufferMemoryRequirements)                                                                                     \
    X(GetImageMemoryRequirements)                                                                                      \
    X(GetPhysicalDeviceImageFormatProperties)                                                                          \
    X(MapMemory)                                                                                                       \
    X(QueueSubmit)                                                                                                     \
    X(ResetFences)                                                                                                     \
    X(WaitForFences)

typedef struct backend_functions {
#define X(name) PFN_vk##name name;
    BACKEND_FUNCTIONS(X)
#undef X
} backend_functions;

/* A command buffer, and a part of the staging buffer for its band. */
typedef struct slot {
    VkCommandBuffer commands;
    VkFence fence;
    bool pending; /* submitted, and not waited for */
    char *memory;
    VkDeviceSize offset; /* of the part in the buffer */
    int y, rows;         /* the band */
} slot;

/* The pictures on the GPU; kept between frames. */
typedef struct vulkan_pictures {
    int width, height;
    bool half;                /* color: RGBA16F, else RGBA32F */
    VkImage color, map;       /* map: R32F */
    VkDeviceMemory memory[3]; /* of color, map, buffer */
    VkBuffer buffer;          /* the parts of the slots, one after the other: rows of colour, then rows of map */
    int band;                 /* rows of a part */
} vulkan_pictures;

/* What a frame object was made for, beside the pictures. */
typedef struct frame_kind {
    bool is_depth, alpha;
    ddof_depth_kind depth;
    ddof_solver solver;
    ddof_surface surface;
    const disc_kernel *disc;
    vulkan_sprite_kind sprites;
    int colors; /* channels that shine */
} frame_kind;

typedef struct vulkan_backend {
    ddof_context *owner;
    vulkan_session session;
    backend_functions f;
    ddof_vulkan *vk; /* NULL: there is no session, the device was lost */
    ddof_vulkan_frame *frame;
    frame_kind kind;
    VkCommandPool pool;
    slot slot[SLOTS];
    int turn;
    vulkan_pictures pictures;
    size_t surface_bytes;
    bool hung;
    char name[VK_MAX_PHYSICAL_DEVICE_NAME_SIZE], text[512];
} vulkan_backend;

typedef struct transition {
    VkPipelineStageFlags from_stage, to_stage;
    VkAccessFlags from, to;
    VkImageLayout before, after;
} transition;

/* backend.c. DDOF_OK, or says what went wrong while `doing`. */
ddof_status vulkan_check(const vulkan_backend *b, VkResult result, const char *doing);
/* The next slot; its command buffer is recording. */
ddof_status vulkan_begin(vulkan_backend *b, slot **out);
ddof_status vulkan_submit(vulkan_backend *b, slot *s);
ddof_status vulkan_wait(vulkan_backend *b, slot *s);
void vulkan_barrier(const vulkan_backend *b, const slot *s, VkImage image, const transition *t);

/* pictures.c. */
extern const VkImageUsageFlags vulkan_color_usage, vulkan_map_usage;
VkFormat vulkan_color_format(const vulkan_pictures *p);
/* Makes them, unless they are there already; with the old ones goes the frame object. */
ddof_status vulkan_pictures_make(vulkan_backend *b, int width, int height, bool half);
void vulkan_pictures_delete(vulkan_backend *b);
/* From the described images to `color` and `map`, which are left in the layout GENERAL, written by TRANSFER. */
ddof_status vulkan_pictures_upload(vulkan_backend *b, frame_job *job, const staging *st);
/* From `color`, in the layout GENERAL and visible to TRANSFER, to the described output. */
ddof_status vulkan_pictures_download(vulkan_backend *b, const frame_job *job, const staging *st);

#endif
