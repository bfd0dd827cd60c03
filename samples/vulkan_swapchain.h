/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The images of a window, and the frames in flight to it. */
#ifndef DDOF_VULKAN_SWAPCHAIN_H
#define DDOF_VULKAN_SWAPCHAIN_H

#include "vulkan_sample.h"

enum { SWAPCHAIN_MOST = 16, IN_FLIGHT = 2 /* frames: one is drawn while the CPU records the other */ };

typedef struct swapchain {
    VkSwapchainKHR chain;
    uint32_t width, height, count;
    VkImage images[SWAPCHAIN_MOST];
    VkSemaphore drawn[SWAPCHAIN_MOST];
    VkSemaphore acquired[IN_FLIGHT];
    VkFence done[IN_FLIGHT];
    int turn; /* of the frame in flight that is recorded now */
} swapchain;

/* width, height: for surfaces that leave their size to the program. */
swapchain swapchain_create(const sample *s, VkSurfaceKHR surface, uint32_t width, uint32_t height);

/* Once the device is idle. */
void swapchain_destroy(const sample *s, swapchain *w);

/* Takes the next turn, once the GPU is done with the frame that had it before. False: the window has changed, and a new
 * swapchain is needed. */
bool swapchain_acquire(const sample *s, swapchain *w, uint32_t *image);

/* Records the copy of a picture of the same size, in SAMPLE_COPY, to that image of the window. */
void swapchain_blit(const swapchain *w, uint32_t image, VkCommandBuffer commands, VkImage picture);

/* Submits commands with that copy in them, and shows the image. False as above, but the commands were submitted. */
bool swapchain_present(const sample *s, const swapchain *w, uint32_t image, VkCommandBuffer commands);

#endif
