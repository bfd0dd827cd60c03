/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* What ddof/vulkan.h makes, and what it records: scratch memory, objects, allocations, dispatches, pipelines. */
#include "../library/allocator.h"
#include "pictures.h"

#include <stdlib.h>
#include <string.h>

static VkMemoryRequirements scratch_of(ddof_vulkan *vk, const ddof_vulkan_images *images,
                                       const ddof_settings *settings) {
    VkMemoryRequirements needs;
    memset(&needs, 0xff, sizeof needs);
    if (ddof_vulkan_scratch(vk, images, settings, &needs) != DDOF_OK)
        fail_msg("ddof_vulkan_scratch: %s", ddof_vulkan_error(vk));
    return needs;
}

/* ---- scratch memory */

/* Images that need not exist. */
static ddof_vulkan_images described(uint32_t width, uint32_t height, VkFormat color, VkFormat output) {
    return (ddof_vulkan_images){.color = {.format = color, .width = width, .height = height},
                                .coc = {.format = VK_FORMAT_R32_SFLOAT, .width = width, .height = height},
                                .output = {.format = output, .width = width, .height = height}};
}

/* LINE at 1600 x 1200: none where the output can hold the intermediate, else 8 bytes a pixel of half floats. */
static void line_scratch(void **state) {
    static const VkFormat rounded[] = {VK_FORMAT_B10G11R11_UFLOAT_PACK32, VK_FORMAT_A2B10G10R10_UNORM_PACK32,
                                       VK_FORMAT_R8G8B8A8_UNORM, VK_FORMAT_B8G8R8A8_UNORM};
    const VkFormat half = VK_FORMAT_R16G16B16A16_SFLOAT, wide = VK_FORMAT_R32G32B32A32_SFLOAT;
    const double pixels = 1600 * 1200;
    (void)state;
    ddof_vulkan *vk = create();
    ddof_vulkan_images images = described(1600, 1200, half, half);
    for (int substeps = 0; substeps < 4; substeps++) {
        const ddof_settings settings = {.substeps = substeps};
        assert_int_equal(scratch_of(vk, &images, &settings).size, 0);
    }
    images = described(1600, 1200, wide, wide);
    assert_int_equal(scratch_of(vk, &images, &(ddof_settings){.surface = DDOF_SURFACE_RGBA32F}).size, 0);
    assert_int_equal(scratch_of(vk, &images, &(ddof_settings){0}).size, 0);
    for (int i = 0; i < COUNT(rounded); i++) {
        if (!ddof_vulkan_can_output(vk, rounded[i])) continue;
        images = described(1600, 1200, half, rounded[i]);
        const double bytes = (double)scratch_of(vk, &images, &(ddof_settings){0}).size;
        if (!(bytes > 0 && bytes <= 8 * pixels)) fail_msg("%s: %.0f bytes of scratch", format_name(rounded[i]), bytes);
    }
    images = described(1600, 1200, half, half);
    const double floats = (double)scratch_of(vk, &images, &(ddof_settings){.surface = DDOF_SURFACE_RGBA32F}).size;
    assert_true(floats > 0 && floats <= 16 * pixels);
    assert_int_equal(tap.calls > 0, 1);
    destroy(&vk);
}

/* What is asked for is what is held, and as much as the driver was asked for. */
static void scratch_is_told(void **state) {
    (void)state;
    ddof_vulkan *vk = create();
    for (int k = 0; k < 6 * METHODS; k++) {
        const ddof_settings settings = method(k, (ddof_surface)(k / METHODS % 3));
        frame_set set =
            set_make((frame_kind){.width = 133,
                                  .height = 70,
                                  .color = VK_FORMAT_R16G16B16A16_SFLOAT,
                                  .output = k / METHODS / 3 ? VK_FORMAT_R8G8B8A8_UNORM : VK_FORMAT_R16G16B16A16_SFLOAT,
                                  .coc = COC_SMOOTH},
                     30);
        const VkMemoryRequirements needs = scratch_of(vk, &set.images, &settings);
        const ddof_vulkan_stats stats = set_check(vk, &set, NULL, &settings, "scratch");
        assert_int_equal(stats.scratch_bytes, needs.size);
        set_free(&set);
    }
    destroy(&vk);
}

/* Memory of the caller's, in the middle of more: what lies before and behind it is left alone. */
static void own_scratch(void **state) {
    (void)state;
    ddof_vulkan *vk = create();
    for (int k = 0; k < 2 * METHODS; k++) {
        const ddof_settings settings = method(k, DDOF_SURFACE_RGBA32F);
        frame_set set =
            set_make((frame_kind){.width = 77 + k % 2, /* drivers compile anew for every few pixels */
                                  .height = 60,
                                  .output = k / METHODS ? VK_FORMAT_R8G8B8A8_UNORM : VK_FORMAT_R16G16B16A16_SFLOAT,
                                  .coc = COC_SMOOTH},
                     31);
        const VkMemoryRequirements needs = scratch_of(vk, &set.images, &settings);
        const VkDeviceSize before = (VkDeviceSize)(k + 1) * needs.alignment, whole = before + needs.size + 4096;
        uint32_t visible = 0;
        for (uint32_t i = 0; i < own.memory.memoryTypeCount; i++)
            if (own.memory.memoryTypes[i].propertyFlags & VK_MEMORY_PROPERTY_HOST_COHERENT_BIT) visible |= 1u << i;
        const bool seen = (needs.memoryTypeBits & visible) != 0;
        unsigned char *mapped = NULL;
        const VkDeviceMemory memory =
            own_memory(whole, seen ? needs.memoryTypeBits & visible : needs.memoryTypeBits, 0);
        assert_true(needs.size > 0 && needs.alignment > 0);
        if (seen) {
            CHECK(VK(vkMapMemory)(own.device, memory, 0, VK_WHOLE_SIZE, 0, (void **)&mapped));
            memset(mapped, 0x77, (size_t)whole);
        }
        set.images.scratch_memory = memory;
        set.images.scratch_offset = before;
        set.images.scratch_size = needs.size;
        set_check(vk, &set, NULL, &settings, "own scratch");
        for (VkDeviceSize i = 0; seen && i < whole; i++)
            if ((i < before || i >= before + needs.size) && mapped[i] != 0x77)
                fail_msg("byte %llu of the memory was written", (unsigned long long)i);
        VK(vkFreeMemory)(own.device, memory, NULL);
        set_free(&set);
    }
    destroy(&vk);
}

/* ---- recording */

/* Copies with the barriers that the header asks for and no others, in one command buffer with the blur: synchronization
 * validation sees all of it. */
static void wait_for_copies(VkCommandBuffer commands) {
    const VkMemoryBarrier2 barrier = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
                                      .srcStageMask = VK_PIPELINE_STAGE_2_COPY_BIT,
                                      .srcAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT,
                                      .dstStageMask = VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
                                      .dstAccessMask =
                                          VK_ACCESS_2_SHADER_SAMPLED_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT};
    const VkDependencyInfo info = {
        .sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO, .memoryBarrierCount = 1, .pMemoryBarriers = &barrier};
    VK(vkCmdPipelineBarrier2)(commands, &info);
}

static void wait_for_blur(VkCommandBuffer commands) {
    const VkMemoryBarrier2 barrier = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
                                      .srcStageMask = VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
                                      .srcAccessMask = VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
                                      .dstStageMask = VK_PIPELINE_STAGE_2_COPY_BIT,
                                      .dstAccessMask = VK_ACCESS_2_TRANSFER_READ_BIT | VK_ACCESS_2_TRANSFER_WRITE_BIT};
    const VkDependencyInfo info = {
        .sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO, .memoryBarrierCount = 1, .pMemoryBarriers = &barrier};
    VK(vkCmdPipelineBarrier2)(commands, &info);
}

static void copy_image(VkCommandBuffer commands, const picture *from, const picture *to) {
    const VkImageCopy copy = {.srcSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1},
                              .dstSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1},
                              .extent = {from->d.width, from->d.height, 1}};
    VK(vkCmdCopyImage)
    (commands, from->d.image, VK_IMAGE_LAYOUT_GENERAL, to->d.image, VK_IMAGE_LAYOUT_GENERAL, 1, &copy);
}

static void one_command_buffer(void **state) {
    (void)state;
    ddof_vulkan *vk = create();
    for (int k = 0; k < 4 * METHODS; k++) {
        const VkFormat outputs[] = {VK_FORMAT_R32G32B32A32_SFLOAT, VK_FORMAT_UNDEFINED, VK_FORMAT_R8G8B8A8_UNORM,
                                    VK_FORMAT_R16G16B16A16_SFLOAT};
        const ddof_settings settings =
            heat_method(k, k % 3 ? DDOF_SURFACE_RGBA16F : DDOF_SURFACE_RGBA32F, DDOF_CONDUCTANCE_MATCHED, k % 3);
        const int width = 77 + k % 4;
        frame_set set = set_make((frame_kind){.width = width,
                                              .height = 50,
                                              .output = outputs[k / METHODS],
                                              .layout = VK_IMAGE_LAYOUT_GENERAL,
                                              .coc = COC_SMOOTH},
                                 32);
        picture *output = set.kind.output ? &set.output : &set.color;
        picture color = picture_make(set.kind.color, width, 50, 0, VK_IMAGE_LAYOUT_GENERAL);
        picture map = picture_make(set.kind.map, width, 50, 0, VK_IMAGE_LAYOUT_GENERAL);
        picture result = picture_make(output->d.format, width, 50, 0, VK_IMAGE_LAYOUT_GENERAL);
        float *want = set_want(&set, NULL, &settings);
        ddof_vulkan_frame *frame = frame_of(vk, &set, &settings);
        VkCommandBuffer commands = own_begin();
        copy_image(commands, &set.color, &color);
        copy_image(commands, &set.map, &map);
        for (int twice = 0; twice < 2; twice++) {
            const VkMemoryBarrier copies = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
                                            .srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT,
                                            .dstAccessMask =
                                                VK_ACCESS_TRANSFER_READ_BIT | VK_ACCESS_TRANSFER_WRITE_BIT};
            VK(vkCmdPipelineBarrier)
            (commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT, 0, 1, &copies, 0, NULL, 0, NULL);
            copy_image(commands, &color, &set.color);
            copy_image(commands, &map, &set.map);
            wait_for_copies(commands);
            record(frame, commands, NULL, &settings, NULL);
            wait_for_blur(commands);
            copy_image(commands, output, &result);
        }
        own_finish(commands);
        set_compare(&set, NULL, want, tolerance(&set, &settings, 1), "frame %d", k);
        ddof_vulkan_frame_destroy(&frame);
        picture_free(&color);
        picture_free(&map);
        picture_free(&result);
        fenced_free(want);
        set_free(&set);
    }
    destroy(&vk);
}

/* The output was written, and is written again. */
static void wait_for_output(VkCommandBuffer commands) {
    const VkMemoryBarrier2 barrier = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
                                      .srcStageMask = VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
                                      .srcAccessMask = VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
                                      .dstStageMask = VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
                                      .dstAccessMask = VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT};
    const VkDependencyInfo info = {
        .sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO, .memoryBarrierCount = 1, .pMemoryBarriers = &barrier};
    VK(vkCmdPipelineBarrier2)(commands, &info);
}

/* Two frame objects in a command buffer, which may share their scratch memory; one twice, and in two command buffers
 * that are pending together. */
static void several(void **state) {
    (void)state;
    ddof_vulkan *vk = create();
    for (int k = 0; k < 2 * METHODS; k++) {
        const ddof_settings settings = method(k, DDOF_SURFACE_RGBA32F);
        const frame_kind kind = {.width = 70,
                                 .height = 61,
                                 .output = k / METHODS ? VK_FORMAT_R8G8B8A8_UNORM : VK_FORMAT_R16G16B16A16_SFLOAT,
                                 .coc = COC_SMOOTH};
        frame_set set[2] = {set_make(kind, 33), set_make(kind, 34)};
        const VkMemoryRequirements needs = scratch_of(vk, &set[0].images, &settings);
        const VkDeviceMemory memory = own_memory(needs.size, needs.memoryTypeBits, 0);
        ddof_vulkan_frame *frame[2];
        float *want[2];
        for (int i = 0; i < 2; i++) {
            if (k % 2) set[i].images.scratch_memory = memory;
            frame[i] = frame_of(vk, &set[i], &settings);
            want[i] = set_want(&set[i], NULL, &settings);
        }
        VkCommandBuffer commands[2] = {own_begin(), own_begin()};
        for (int i = 0; i < 6; i++) {
            if (i % 3 == 2) wait_for_output(commands[i / 3]);
            record(frame[i % 2], commands[i / 3], NULL, &settings, NULL); /* 0 1 0, 1 0 1 */
        }
        wait_for_output(commands[0]); /* of the first before the second begins */
        own_end(commands[0]);
        own_end(commands[1]);
        const VkSubmitInfo submit = {
            .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 2, .pCommandBuffers = commands};
        CHECK(VK(vkQueueSubmit)(own.queue, 1, &submit, VK_NULL_HANDLE));
        CHECK(VK(vkQueueWaitIdle)(own.queue));
        for (int i = 0; i < 2; i++) {
            set_compare(&set[i], NULL, want[i], tolerance(&set[i], &settings, 1), "several, %d of %d", i, k);
            own_forget(commands[i]);
            ddof_vulkan_frame_destroy(&frame[i]);
            fenced_free(want[i]);
            set_free(&set[i]);
        }
        VK(vkFreeMemory)(own.device, memory, NULL);
    }
    destroy(&vk);
}

/* No recording allocates or makes anything, and LINE with one substep is two dispatches; of the disc kernel one for
 * each component, direction and substep. */
static void dispatches(void **state) {
    (void)state;
    static const int disc[] = {[DDOF_QUALITY_DEFAULT] = 8, [DDOF_QUALITY_DRAFT] = 2, [DDOF_QUALITY_GOOD] = 8, [DDOF_QUALITY_BEST] = 16};
    for (int k = 0; k < 4 * METHODS; k++) {
        host_memory host = {0};
        allocator memory = {0};
        const VkAllocationCallbacks callbacks = host_callbacks(&host);
        ddof_vulkan_config config = tap_config();
        config.allocator = &callbacks;
        config.allocate = allocator_allocate;
        config.release = allocator_release;
        config.memory_user = &memory;
        ddof_vulkan *vk = NULL;
        tap_forget();
        assert_int_equal(ddof_vulkan_create(&vk, &config), DDOF_OK);
        ddof_settings settings = method(k / 4, (ddof_surface)(k % 3));
        frame_set set = set_make((frame_kind){.width = 121 + k % 4, .height = 90, .output = VK_FORMAT_R8G8B8A8_UNORM}, 35);
        ddof_vulkan_frame *frame = frame_of(vk, &set, &settings);
        const int calls = tap.calls, live = tap.live, allocations = host.allocations, blocks = memory.calls;
        assert_true(calls > 0 && live > 0 && blocks > 0);
        for (int substeps = 1; substeps <= 3; substeps++)
            for (int i = 0; i < 3; i++) {
                ddof_vulkan_stats stats;
                VkCommandBuffer commands = own_begin();
                settings = heat_method(k / 4, settings.surface, (ddof_conductance)(i % 2), substeps);
                tap.dispatches = 0;
                record(frame, commands, &(ddof_vulkan_view){.width = 100 + i, .height = 80 - i}, &settings, &stats);
                own_finish(commands);
                assert_int_equal(tap.calls, calls);
                assert_int_equal(tap.live, live);
                assert_int_equal(host.allocations, allocations);
                assert_int_equal(memory.calls, blocks);
                assert_int_equal(stats.dispatches, tap.dispatches);
                assert_int_equal(stats.solver, settings.kernel ? DDOF_SOLVER_LINE : settings.solver);
                assert_non_null(strstr(stats.device, own.properties.deviceName));
                if (stats.solver != DDOF_SOLVER_LINE) continue;
                assert_int_equal(stats.dispatches, settings.kernel ? disc[settings.quality] : 2 * substeps);
                assert_true(stats.pixels_per_thread > 0 && stats.workgroup > 0 && stats.strip > 0);
                const bool sized = own.size_control.subgroupSizeControl && own.size_control.computeFullSubgroups;
                if (sized && own.properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU)
                    assert_true(stats.subgroup > 1); /* the software drivers have all that it takes */
            }
        ddof_vulkan_frame_destroy(&frame);
        set_free(&set);
        destroy(&vk);
        assert_int_equal(host.live, 0);
        assert_int_equal(memory.live, 0);
        assert_false(memory.wrong);
    }
}

/* ---- pipelines */

static ddof_vulkan *create_with_cache(const void *data, size_t size) {
    ddof_vulkan *vk = NULL;
    ddof_vulkan_config config = tap_config();
    config.pipeline_cache = data;
    config.pipeline_cache_size = size;
    tap_forget();
    assert_int_equal(ddof_vulkan_create(&vk, &config), DDOF_OK);
    return vk;
}

/* Out and in again; and what is no cache, or another's, is as none. */
static void pipeline_cache(void **state) {
    (void)state;
    frame_set set = set_make((frame_kind){.width = 60, .height = 41, .output = VK_FORMAT_R32G32B32A32_SFLOAT}, 36);
    ddof_vulkan *vk = create();
    size_t size = 0, written;
    set_check(vk, &set, NULL, &(ddof_settings){0}, "no cache");
    assert_int_equal(ddof_vulkan_pipeline_cache(vk, NULL, &size), DDOF_OK);
    assert_true(size >= 32);
    unsigned char *data = fenced(size, true);
    written = size;
    assert_int_equal(ddof_vulkan_pipeline_cache(vk, data, &written), DDOF_OK);
    assert_true(written >= 32 && written <= size);
    for (size_t room = 0; room < 32; room += 8) { /* less than the head */
        size_t less = room;
        unsigned char some[32];
        assert_int_equal(ddof_vulkan_pipeline_cache(vk, some, &less), DDOF_ERROR_INVALID);
        assert_true(ddof_vulkan_error(vk)[0] != 0);
    }
    assert_int_equal(ddof_vulkan_pipeline_cache(vk, data, NULL), DDOF_ERROR_INVALID);
    assert_int_equal(ddof_vulkan_pipeline_cache(NULL, data, &written), DDOF_ERROR_INVALID);
    destroy(&vk);
    for (int damage = 0; damage < 8; damage++) {
        unsigned char *bad = fenced(written, true);
        memcpy(bad, data, written);
        rng r = {37 + (uint64_t)damage};
        size_t used = written;
        if (damage == 1) used = 31;       /* no whole head */
        if (damage == 2) bad[4] ^= 2;     /* another version of it */
        if (damage == 3) bad[8] ^= 1;     /* another maker */
        if (damage == 4) bad[16] ^= 0x80; /* another driver */
        if (damage == 5) used = 32;       /* a head alone */
        for (size_t i = 0; damage == 6 && i < used; i++)
            bad[i] = (unsigned char)rng_bits(&r);
        if (damage == 7) bad[0] = 0xff; /* a head of another size */
        vk = create_with_cache(bad, used);
        memset(bad, 0, written);
        fenced_free(bad); /* only read during the call */
        set_check(vk, &set, NULL, &(ddof_settings){.solver = DDOF_SOLVER_LINE}, "some cache");
        destroy(&vk);
    }
    fenced_free(data);
    set_free(&set);
}

/* The features that are needed, no others; and a device of Vulkan 1.1 with extensions. */
static void lesser_devices(void **state) {
    (void)state;
    for (int k = 0; k < 4; k++) {
        own_close();
        const char *missing = own_open(k % 2 ? VK_API_VERSION_1_1 : VK_API_VERSION_1_3, k / 2);
        if (missing) fail_msg("%s", missing);
        ddof_vulkan *vk = create();
        for (int i = 0; i < 2 * METHODS; i++) {
            const ddof_settings settings = method(i, DDOF_SURFACE_RGBA32F);
            frame_set set =
                set_make((frame_kind){.width = 150,
                                      .height = 90,
                                      .output = i / METHODS ? VK_FORMAT_R8G8B8A8_UNORM : VK_FORMAT_R32G32B32A32_SFLOAT,
                                      .coc = COC_SMOOTH},
                         38);
            const ddof_vulkan_stats stats = set_check(vk, &set, NULL, &settings, "lesser");
            if (k / 2 && stats.solver == DDOF_SOLVER_LINE) assert_int_equal(stats.subgroup, 1);
            set_free(&set);
        }
        destroy(&vk);
    }
    own_close();
    assert_null(own_open(VK_API_VERSION_1_3, false));
}

/* NULL stands for the two features that are needed. */
static void features_not_told(void **state) {
    (void)state;
    ddof_vulkan *vk = NULL;
    ddof_vulkan_config config = tap_config();
    config.features = NULL;
    tap_forget();
    assert_int_equal(ddof_vulkan_create(&vk, &config), DDOF_OK);
    frame_set set = set_make((frame_kind){.width = 150, .height = 90, .output = VK_FORMAT_R32G32B32A32_SFLOAT}, 39);
    const ddof_vulkan_stats stats = set_check(vk, &set, NULL, &(ddof_settings){0}, "features not told");
    assert_int_equal(stats.subgroup, 1);
    set_free(&set);
    destroy(&vk);
}

int main(void) {
    static const struct CMUnitTest tests[] = {
        cmocka_unit_test(line_scratch),       cmocka_unit_test(scratch_is_told), cmocka_unit_test(own_scratch),
        cmocka_unit_test(one_command_buffer), cmocka_unit_test(several),         cmocka_unit_test(dispatches),
        cmocka_unit_test(pipeline_cache),     cmocka_unit_test(lesser_devices),  cmocka_unit_test(features_not_told),
    };
    return run_with_own("vulkan objects", tests, COUNT(tests));
}
