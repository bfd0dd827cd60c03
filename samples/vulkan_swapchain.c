/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "vulkan_swapchain.h"

/* Not _SRGB: the tone map has encoded already, and a blit would encode again. */
static const VkFormat format = VK_FORMAT_B8G8R8A8_UNORM;

static bool has_format(const sample *s, VkSurfaceKHR surface) {
    VkSurfaceFormatKHR formats[64];
    uint32_t count = 64;
    const VkResult result = vkGetPhysicalDeviceSurfaceFormatsKHR(s->gpu, surface, &count, formats);
    if (result != VK_INCOMPLETE) sample_check(result, "vkGetPhysicalDeviceSurfaceFormatsKHR");
    for (uint32_t i = 0; i < count; i++)
        if (formats[i].format == format && formats[i].colorSpace == VK_COLOR_SPACE_SRGB_NONLINEAR_KHR) return true;
    return false;
}

static VkSemaphore semaphore(const sample *s) {
    VkSemaphore made;
    const VkSemaphoreCreateInfo info = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO};
    SAMPLE_VK(vkCreateSemaphore(s->device, &info, NULL, &made));
    return made;
}

swapchain swapchain_create(const sample *s, VkSurfaceKHR surface, uint32_t width, uint32_t height) {
    swapchain w = {.width = width, .height = height, .count = SWAPCHAIN_MOST};
    VkBool32 shown;
    SAMPLE_VK(vkGetPhysicalDeviceSurfaceSupportKHR(s->gpu, s->family, surface, &shown));
    if (!shown || !has_format(s, surface)) sample_fail("%s cannot show B8G8R8A8 here", s->properties.deviceName);
    VkSurfaceCapabilitiesKHR can;
    SAMPLE_VK(vkGetPhysicalDeviceSurfaceCapabilitiesKHR(s->gpu, surface, &can));
    if (can.currentExtent.width != UINT32_MAX) {
        w.width = can.currentExtent.width;
        w.height = can.currentExtent.height;
    }
    const VkSwapchainCreateInfoKHR chain = {
        .sType = VK_STRUCTURE_TYPE_SWAPCHAIN_CREATE_INFO_KHR,
        .surface = surface,
        /* one to draw into while the others are shown */
        .minImageCount = can.minImageCount + (can.minImageCount != can.maxImageCount),
        .imageFormat = format,
        .imageColorSpace = VK_COLOR_SPACE_SRGB_NONLINEAR_KHR,
        .imageExtent = {w.width, w.height},
        .imageArrayLayers = 1,
        .imageUsage = VK_IMAGE_USAGE_TRANSFER_DST_BIT,
        .preTransform = can.currentTransform,
        .compositeAlpha = VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR,
        .presentMode = VK_PRESENT_MODE_FIFO_KHR,
        .clipped = VK_TRUE,
    };
    SAMPLE_VK(vkCreateSwapchainKHR(s->device, &chain, NULL, &w.chain));
    SAMPLE_VK(vkGetSwapchainImagesKHR(s->device, w.chain, &w.count, w.images));
    for (uint32_t i = 0; i < w.count; i++) w.drawn[i] = semaphore(s);
    for (int i = 0; i < IN_FLIGHT; i++) {
        const VkFenceCreateInfo info = {VK_STRUCTURE_TYPE_FENCE_CREATE_INFO, NULL, VK_FENCE_CREATE_SIGNALED_BIT};
        SAMPLE_VK(vkCreateFence(s->device, &info, NULL, &w.done[i]));
        w.acquired[i] = semaphore(s);
    }
    return w;
}

void swapchain_destroy(const sample *s, swapchain *w) {
    for (uint32_t i = 0; i < w->count; i++) vkDestroySemaphore(s->device, w->drawn[i], NULL);
    for (int i = 0; i < IN_FLIGHT; i++) {
        vkDestroySemaphore(s->device, w->acquired[i], NULL);
        vkDestroyFence(s->device, w->done[i], NULL);
    }
    vkDestroySwapchainKHR(s->device, w->chain, NULL);
    *w = (swapchain){0};
}

bool swapchain_acquire(const sample *s, swapchain *w, uint32_t *image) {
    w->turn = (w->turn + 1) % IN_FLIGHT;
    SAMPLE_VK(vkWaitForFences(s->device, 1, &w->done[w->turn], VK_TRUE, UINT64_MAX));
    const VkResult result =
        vkAcquireNextImageKHR(s->device, w->chain, UINT64_MAX, w->acquired[w->turn], VK_NULL_HANDLE, image);
    if (result == VK_ERROR_OUT_OF_DATE_KHR) return false;
    if (result != VK_SUBOPTIMAL_KHR) sample_check(result, "vkAcquireNextImageKHR");
    return true;
}

void swapchain_blit(const swapchain *w, uint32_t image, VkCommandBuffer commands, VkImage picture) {
    const sample_use fill = {VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
                             VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL};
    const sample_use present = {VK_PIPELINE_STAGE_2_NONE, 0, VK_IMAGE_LAYOUT_PRESENT_SRC_KHR};
    const VkImageSubresourceLayers level = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    const VkOffset3D end = {(int32_t)w->width, (int32_t)w->height, 1};
    const VkImageBlit all = {level, {{0, 0, 0}, end}, level, {{0, 0, 0}, end}};
    sample_barrier(commands, w->images[image], SAMPLE_DISCARD, fill);
    /* a blit, because it puts R G B A into the window's order */
    vkCmdBlitImage(commands, picture, SAMPLE_COPY.layout, w->images[image], fill.layout, 1, &all, VK_FILTER_NEAREST);
    sample_barrier(commands, w->images[image], fill, present);
}

bool swapchain_present(const sample *s, const swapchain *w, uint32_t image, VkCommandBuffer commands) {
    const VkSemaphoreSubmitInfo wait = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO,
                                        .semaphore = w->acquired[w->turn],
                                        .stageMask = VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT};
    const VkSemaphoreSubmitInfo signal = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO,
                                          .semaphore = w->drawn[image],
                                          .stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT};
    const VkCommandBufferSubmitInfo work = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO,
                                            .commandBuffer = commands};
    const VkSubmitInfo2 submit = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2,
                                  .waitSemaphoreInfoCount = 1, .pWaitSemaphoreInfos = &wait,
                                  .commandBufferInfoCount = 1, .pCommandBufferInfos = &work,
                                  .signalSemaphoreInfoCount = 1, .pSignalSemaphoreInfos = &signal};
    SAMPLE_VK(vkResetFences(s->device, 1, &w->done[w->turn]));
    SAMPLE_VK(vkQueueSubmit2(s->queue, 1, &submit, w->done[w->turn]));
    const VkPresentInfoKHR present = {.sType = VK_STRUCTURE_TYPE_PRESENT_INFO_KHR,
                                      .waitSemaphoreCount = 1, .pWaitSemaphores = &w->drawn[image],
                                      .swapchainCount = 1, .pSwapchains = &w->chain, .pImageIndices = &image};
    const VkResult result = vkQueuePresentKHR(s->queue, &present);
    if (result == VK_ERROR_OUT_OF_DATE_KHR || result == VK_SUBOPTIMAL_KHR) return false;
    sample_check(result, "vkQueuePresentKHR");
    return true;
}
