/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The method, pass by pass: along rows from the colour to the image under way, along columns from there to the output.
 * The disc kernel does so for each of its components, along diagonals, too, and adds them up. */
#ifndef DDOF_VULKAN_PASSES_H
#define DDOF_VULKAN_PASSES_H

#include "frame.h"

enum {
    VULKAN_SHORT = 8, /* lines of fewer pixels are LINE's, whatever the solver */
    VULKAN_STRIP = 4  /* columns side by side: 32 bytes of half floats, the least that memory hands out */
};

/* The part of the images that is the picture, checked. */
typedef struct vulkan_region {
    int x, y, width, height;
} vulkan_region;

/* Bytes of levels that a solver keeps in scratch memory for a picture of this size; 0: none. */
size_t vulkan_levels_bytes(ddof_solver solver, int width, int height);

/* For push constants: the lens, and where the region lies. */
vulkan_picture_push vulkan_picture_push_of(const ddof_vulkan_frame *frame, const frame_job *job, const vulkan_region *region);

/* Makes the pipelines of every pass that the frame object could ever record. */
ddof_status vulkan_passes_prepare(ddof_vulkan_frame *frame);

/* Records them. Nothing can fail. Returns how many dispatches there were. */
int vulkan_passes_record(const ddof_vulkan_frame *frame, VkCommandBuffer commands, const frame_job *job,
                         const vulkan_region *region);

#endif
