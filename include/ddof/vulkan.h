/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* ddof inside a Vulkan program: images in, image out, recorded into the caller's own command buffer.
 *
 *     ddof_vulkan *vk = NULL;
 *     ddof_vulkan_config config = {
 *         .instance = instance, .physical_device = gpu, .device = device, .queue_family = family,
 *         .get_instance_proc_addr = vkGetInstanceProcAddr, .features = &enabled_features,
 *     };
 *     if (ddof_vulkan_create(&vk, &config) != DDOF_OK) return 1;
 *
 *     ddof_vulkan_frame *frame = NULL;                      // once per set of images
 *     ddof_vulkan_images images = {
 *         .color = {.image = hdr, .format = VK_FORMAT_R16G16B16A16_SFLOAT, .width = w, .height = h},
 *         .depth = {.image = z, .format = VK_FORMAT_D32_SFLOAT, .width = w, .height = h},
 *         .output = {.image = result, .format = VK_FORMAT_R16G16B16A16_SFLOAT, .width = w, .height = h},
 *         .channels = 3,                                    // alpha holds nothing of use
 *     };
 *     ddof_settings settings = {
 *         .lens = {.focal_length = 50, .f_number = 1.8, .focus_distance = 3},
 *         .depth = {DDOF_DEPTH_DEVICE, INFINITY, z_near},   // reversed-Z, infinite far plane
 *     };
 *     if (ddof_vulkan_frame_create(vk, &frame, &images, &settings) != DDOF_OK) puts(ddof_vulkan_error(vk));
 *
 *     ddof_vulkan_record(frame, commands, NULL, &settings, NULL);   // every frame: dispatches and barriers only
 *
 *     ddof_vulkan_frame_destroy(&frame);                    // once the GPU is done with it
 *     ddof_vulkan_destroy(&vk);
 *
 * Needs instance and device of Vulkan 1.1 or later with the features synchronization2 (core 1.3 or
 * VK_KHR_synchronization2) and shaderStorageImageWriteWithoutFormat enabled, and a queue family with compute. Used
 * where enabled: subgroupSizeControl with computeFullSubgroups (core 1.3 or VK_EXT_subgroup_size_control), for
 * shuffles; geometryShader, for DDOF_QUADS_GEOMETRY. Nothing else, neither float16 nor 16-bit storage. Sprites
 * (settings.bokeh, DDOF_METHOD_SCATTER) are drawn: the queue family must do graphics, too. The library is not linked to Vulkan: every function comes
 * through get_instance_proc_addr. It never submits, waits, or maps memory.
 *
 * Where to record. A primary or secondary command buffer, unprotected, in the recording state, outside render passes,
 * video coding and conditional rendering. Undefined afterwards, as after any dispatch of someone else's: pipeline,
 * descriptor sets, descriptor buffer and push descriptor bindings of the compute bind point, and push constants.
 * Graphics state stays; but with sprites that of the graphics bind point is undefined likewise, and so are viewports,
 * scissors and all other dynamic state: a render pass is recorded, with one draw.
 *
 * Synchronisation. No layout of the caller's images is changed, no ownership transferred: images of exclusive sharing
 * mode belong to the family that executes the work.
 *
 *   before  color, depth or coc: contents and the transition to their `layout` visible to
 *           VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_SAMPLED_READ_BIT.
 *           output: earlier accesses finished, earlier writes and the transition to VK_IMAGE_LAYOUT_GENERAL visible to
 *           COMPUTE_SHADER, SHADER_STORAGE_WRITE; where it is also color, both.
 *   after   output: written by COMPUTE_SHADER, SHADER_STORAGE_WRITE.
 *           color, depth or coc, before they are written again or transitioned: an execution dependency from
 *           COMPUTE_SHADER. That is so with sprites, too: their draw waits for a dispatch, and the last dispatch for it.
 *
 * Scratch memory keeps nothing between recordings: each begins with a barrier from all earlier compute work of the queue
 * and discards what is there. So a frame object may be recorded into any number of pending command buffers of one queue,
 * and frame objects may share their scratch memory there. Between queues, and with other users of that memory, order is
 * the caller's. An output is no scratch: two recordings that write the same one need her barrier between them.
 *
 * Thread-safety: ddof_vulkan_record(), ddof_vulkan_frame_timestamps() and ddof_vulkan_frame_error(): one call at a time per frame object, beside any
 * other call on other objects. All others: one call at a time per ddof_vulkan, whose log callback may then be called
 * from the threads that record, too. Several ddof_vulkan may live on one device. */
#ifndef DDOF_VULKAN_H
#define DDOF_VULKAN_H

#include <ddof/ddof.h>
#include <vulkan/vulkan_core.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct ddof_vulkan ddof_vulkan;
typedef struct ddof_vulkan_frame ddof_vulkan_frame;

typedef struct ddof_vulkan_config {
    VkInstance instance;
    VkPhysicalDevice physical_device;
    VkDevice device;
    uint32_t queue_family; /* of the command buffers to record into; must do compute */
    PFN_vkGetInstanceProcAddr get_instance_proc_addr;
    const VkPhysicalDeviceFeatures2 *features; /* what was enabled, with the pNext chain given to vkCreateDevice(); read
                                                  during the call. NULL: just the two needed; subgroups are not used */
    const VkAllocationCallbacks *allocator;    /* for every vkCreate; the struct is copied; NULL: the driver's */

    /* Compiled pipelines of an earlier run, from ddof_vulkan_pipeline_cache(); data of another driver are ignored. */
    const void *pipeline_cache;
    size_t pipeline_cache_size;

    /* As in ddof_config. */
    void *(*allocate)(void *user, size_t bytes);
    void (*release)(void *user, void *memory);
    void *memory_user;
    void (*log)(void *user, ddof_log_level level, const char *text);
    void *log_user;
    uint64_t reserved[8];
} ddof_vulkan_config;

/* One mip level of one layer of a 2D image of optimal tiling, with one sample per texel (multisampled depth: resolve
 * one sample, never a mean). Vulkan cannot be asked what an image is: what is said here is checked, but believed. */
typedef struct ddof_vulkan_image {
    VkImage image;
    VkFormat format;         /* of the view to be made: the image's, or one it was made compatible with. 0: no image */
    uint32_t width, height;  /* of the mip level, texels */
    VkImageUsageFlags usage; /* as it was created; 0: not checked. Inputs: SAMPLED. Output: STORAGE, and SAMPLED, unless
                                the intermediate lies in scratch memory; with DDOF_BOKEH_HIGHLIGHTS always */
    VkImageLayout layout;    /* while the recorded work runs: GENERAL, SHADER_READ_ONLY_OPTIMAL (meant by 0), or
                                READ_ONLY_OPTIMAL; for depth formats also DEPTH_READ_ONLY_OPTIMAL,
                                DEPTH_READ_ONLY_STENCIL_ATTACHMENT_OPTIMAL and, meant by 0,
                                DEPTH_STENCIL_READ_ONLY_OPTIMAL. `output`, and `color` where it is the same: always
                                GENERAL */
    uint32_t mip_level, array_layer;
} ddof_vulkan_image;

/* The images of a frame. What is diffused is the colour as it is sampled: scene-linear, premultiplied. `depth` or `coc`
 * has the size of `color`, or half of it, rounded up: each of its texels then serves 2 x 2 pixels. A CoC is in pixels
 * of `color` in either case. */
typedef struct ddof_vulkan_images {
    ddof_vulkan_image color;  /* R32G32B32A32_SFLOAT, R16G16B16A16_SFLOAT, B10G11R11_UFLOAT, E5B9G9R9_UFLOAT,
                                 A2B10G10R10_UNORM, R8G8B8A8 and B8G8R8A8 _UNORM and _SRGB */
    ddof_vulkan_image depth;  /* D16_UNORM, X8_D24_UNORM, D24_UNORM_S8_UINT, D32_SFLOAT, D32_SFLOAT_S8_UINT, R32_SFLOAT,
                                 R16_SFLOAT. Exactly one of depth and coc has a format */
    ddof_vulkan_image coc;    /* R32_SFLOAT, R16_SFLOAT: signed diameter in pixels */
    ddof_vulkan_image output; /* the size of `color`: R32G32B32A32_SFLOAT, R16G16B16A16_SFLOAT, or, with an intermediate
                                 in scratch memory, B10G11R11_UFLOAT, A2B10G10R10_UNORM, R8G8B8A8_UNORM, B8G8R8A8_UNORM
                                 (linear values, rounded). It may be `color` itself, format, level and layer included:
                                 the blur is then in place. No other two images may share memory */
    int channels;             /* 0 or 4: alpha is diffused as well; 3: alpha is not looked at, and 1 in the result */

    /* Memory for scratch, as ddof_vulkan_scratch() asks for it, not dedicated to another resource; bound by the library
     * and kept by the caller until after ddof_vulkan_frame_destroy(). VK_NULL_HANDLE: the library allocates it. */
    VkDeviceMemory scratch_memory;
    VkDeviceSize scratch_offset; /* a multiple of the alignment asked for */
    VkDeviceSize scratch_size;   /* room from there on; 0: not checked */
    const void *next;            /* must be NULL */
    uint64_t reserved[8];
} ddof_vulkan_images;

/* What may change from frame to frame. */
typedef struct ddof_vulkan_view {
    int x, y, width, height; /* the part of color and output that is the picture, texels (dynamic resolution); nothing
                                outside is read or written. width and height 0: all. x and y even where depth or
                                coc is of half size */
    int picture_width, picture_height, offset_x, offset_y; /* as in ddof_frame, of that part */
    double pixel_aspect;
    const void *next; /* must be NULL */
    uint64_t reserved[4];
} ddof_vulkan_view;

typedef struct ddof_vulkan_stats {
    size_t scratch_bytes; /* of the frame object: all memory beyond the caller's images */
    int dispatches;       /* recorded; `line` with one substep: 2; DDOF_KERNEL_DISC: 2, 8, 16 */
    ddof_solver solver;   /* that did it: never DEFAULT, and PCR3_SWEEP where a line is too long for LINE */
    int pixels_per_thread, workgroup, strip, subgroup; /* of LINE along rows, else 0: k, threads, lines side by side,
                                                          size of the subgroups (1: not used) */
    const char *device;                                /* its name; lives as long as the ddof_vulkan */
    uint64_t reserved[8];                              /* written as 0 */
} ddof_vulkan_stats;

/* Makes the part that all frames share. On failure *vk is NULL and config->log has got the sentence; every later failure
 * is told both to log and by ddof_vulkan_error() or ddof_vulkan_frame_error().
 * Errors: INVALID, MEMORY, DEVICE (out of its memory, lost), UNSUPPORTED (no Vulkan in this build, a missing feature, a
 * queue family without compute). */
DDOF_API ddof_status ddof_vulkan_create(ddof_vulkan **vk, const ddof_vulkan_config *config);

/* Frees all of it and nulls *vk. Frame objects must be gone. NULL and pointers to NULL are allowed. */
DDOF_API void ddof_vulkan_destroy(ddof_vulkan **vk);

/* What was wrong with the last call on it that failed; "" after one that went well. Calls on frame objects have their
 * own. */
DDOF_API const char *ddof_vulkan_error(const ddof_vulkan *vk);
DDOF_API const char *ddof_vulkan_frame_error(const ddof_vulkan_frame *frame);

/* Whether an image of this format can be the output, or an input (colour, depth, CoC), on this device. */
DDOF_API int ddof_vulkan_can_output(const ddof_vulkan *vk, VkFormat format);
DDOF_API int ddof_vulkan_can_sample(const ddof_vulkan *vk, VkFormat format);

/* The scratch memory such a frame wants; size 0: none. The images need not exist yet: handles are not looked at.
 * Errors: INVALID, UNSUPPORTED, MEMORY, DEVICE. */
DDOF_API ddof_status ddof_vulkan_scratch(ddof_vulkan *vk, const ddof_vulkan_images *images,
                                         const ddof_settings *settings, VkMemoryRequirements *requirements);

/* Makes what recording needs: image views, descriptor sets, scratch, and pipelines, compiled here the first time they
 * are needed, which is slow. It stays valid while the images live, and serves every view, lens, number of substeps and
 * conductance. Of the settings kernel, quality, solver, surface, depth.kind, bokeh and, with sprites, sprites.resolution,
 * max_sprites, append and quads are fixed here; the lens is not looked at yet.
 *
 *   kernel   HEAT, or DISC, which LINE solves and no other solver (UNSUPPORTED); it wants more scratch (docs/vulkan.md)
 *   solver   DEFAULT or LINE, PCR, PCR3_SWEEP, CR4_PACK
 *   surface  RGBA16F: the intermediate lies in the output where that is floating-point, else in scratch as half floats;
 *            RGBA32F: in scratch as floats, unless the output is R32G32B32A32_SFLOAT
 *   bokeh    HIGHLIGHTS, FULL (the same as method SCATTER; the other methods are UNSUPPORTED): docs/vulkan.md says how much
 *            scratch they want. FULL needs a device that blends R32G32B32A32_SFLOAT; and fills holes by what is known in
 *            eight directions, 64 pixels around
 *
 * On failure *frame is NULL. Errors: INVALID, MEMORY, DEVICE, UNSUPPORTED. */
DDOF_API ddof_status ddof_vulkan_frame_create(ddof_vulkan *vk, ddof_vulkan_frame **frame,
                                              const ddof_vulkan_images *images, const ddof_settings *settings);

/* Frees it and nulls *frame; before its ddof_vulkan. Not while a command buffer that it was recorded into is pending;
 * such command buffers are invalid afterwards. */
DDOF_API void ddof_vulkan_frame_destroy(ddof_vulkan_frame **frame);

/* Records the blur into `commands`. Allocates nothing. All is checked before the first command is recorded: after an
 * error the command buffer is as it was. What changes lies in push constants: pending work is not touched. view may be
 * NULL; stats may be NULL and is zeroed when the call fails. lens.focus must be DDOF_FOCUS_DISTANCE. Holes are filled
 * as by ddof_render() but not counted. The iris is made anew when it has changed, which takes some milliseconds, and its
 * image is read in each call. May be recorded any number of times, also into several command buffers. Errors:
 * INVALID (an argument; what was fixed differs from that at creation), UNSUPPORTED. */
DDOF_API ddof_status ddof_vulkan_record(ddof_vulkan_frame *frame, VkCommandBuffer commands,
                                        const ddof_vulkan_view *view, const ddof_settings *settings,
                                        ddof_vulkan_stats *stats);

/* Later recordings of a frame object with sprites write four timestamps into `pool`, from query `first` on: before the
 * sprites are listed, when they are, when they are drawn, and at the end. The caller has reset them; her queue has
 * timestamps. VK_NULL_HANDLE: no more. Errors: INVALID (a frame object without sprites). */
DDOF_API ddof_status ddof_vulkan_frame_timestamps(ddof_vulkan_frame *frame, VkQueryPool pool, uint32_t first);

/* The compiled pipelines, for the next run: with data NULL *size becomes their size; else *size is the room on entry
 * and what was written on return. Errors: INVALID (too little room), MEMORY, DEVICE. */
DDOF_API ddof_status ddof_vulkan_pipeline_cache(ddof_vulkan *vk, void *data, size_t *size);

#ifdef __cplusplus
}
#endif

#endif
