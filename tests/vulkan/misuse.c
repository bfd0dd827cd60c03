/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* misuse KIND: a program that does one thing wrong, for validation.sh: the test passes, the validation layers complain.
 */
#include "pictures.h"

#include <string.h>

static const char *kind;

static bool is(const char *name) {
    return !strcmp(kind, name);
}

static void barrier(VkCommandBuffer commands) {
    const VkMemoryBarrier all = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
                                 .srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT,
                                 .dstAccessMask = VK_ACCESS_TRANSFER_READ_BIT | VK_ACCESS_TRANSFER_WRITE_BIT};
    VK(vkCmdPipelineBarrier)
    (commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT, 0, 1, &all, 0, NULL, 0, NULL);
}

static void one_mistake(void **state) {
    (void)state;
    const VkBufferCreateInfo info = {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                                     .size = 256,
                                     .usage = is("usage") ? VK_BUFFER_USAGE_STORAGE_BUFFER_BIT
                                                          : VK_BUFFER_USAGE_TRANSFER_DST_BIT};
    const VkClearColorValue black = {{0}};
    const VkImageSubresourceRange all = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
    VkBuffer buffer;
    VkMemoryRequirements needs;
    CHECK(VK(vkCreateBuffer)(own.device, &info, NULL, &buffer));
    VK(vkGetBufferMemoryRequirements)(own.device, buffer, &needs);
    const VkDeviceMemory memory = own_memory(needs.size, needs.memoryTypeBits, 0);
    CHECK(VK(vkBindBufferMemory)(own.device, buffer, memory, 0));
    picture p = picture_make(VK_FORMAT_R8G8B8A8_UNORM, 8, 8, VK_IMAGE_USAGE_STORAGE_BIT, 0);
    const VkImageLayout layout = is("layout") ? VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL : VK_IMAGE_LAYOUT_GENERAL;
    VkCommandBuffer commands = own_begin();
    VK(vkCmdFillBuffer)(commands, buffer, 0, 256, 1);
    VK(vkCmdClearColorImage)(commands, p.d.image, layout, &black, 1, &all);
    if (!is("hazard") && !is("image_hazard")) barrier(commands);
    if (!is("image_hazard")) VK(vkCmdFillBuffer)(commands, buffer, 0, 256, 2);
    if (!is("hazard")) VK(vkCmdClearColorImage)(commands, p.d.image, layout, &black, 1, &all);
    own_finish(commands);
    picture_free(&p);
    VK(vkFreeMemory)(own.device, memory, NULL);
    if (!is("leak")) VK(vkDestroyBuffer)(own.device, buffer, NULL);
}

int main(int argc, char **argv) {
    static const struct CMUnitTest tests[] = {cmocka_unit_test(one_mistake)};
    kind = argc > 1 ? argv[1] : "right";
    return run_with_own("vulkan misuse", tests, COUNT(tests));
}
