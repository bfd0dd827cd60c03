/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Depth of field inside a program that has its own Vulkan device: make it once, record it every frame, destroy it when
 * the GPU is done. Draws a scene with the focus pulled from near to far and back; writes OUTDIR/0000.ppm, 0001.ppm ...
 *
 *     vulkan_embed OUTDIR [FRAMES [WIDTHxHEIGHT [F-NUMBER]]]
 *
 * Everything ddof is in this file. vulkan_sample.c and vulkan_scene.c stand for what an engine has anyway. */
#include <ddof/vulkan.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "vulkan_scene.h"

const char sample_program[] = "vulkan_embed";

/* The lens the scene was seen through, in metres and millimetres. Focus and f-number may change every frame; depth.kind
 * is fixed when the frame object is made. */
static ddof_settings lens(double focus, double f_number) {
    return (ddof_settings){
        .lens = {.focal_length = SCENE_FOCAL_LENGTH, .f_number = f_number, .focus_distance = focus},
        .depth = {.kind = DDOF_DEPTH_DEVICE, .z_at_0 = INFINITY, .z_at_1 = SCENE_NEAR},
        .substeps = 3, /* rounder lights, at three times the cost of 1 */
    };
}

/* What ddof has to say, among it why a call failed; ddof_vulkan_error() and ddof_vulkan_frame_error() say it, too. */
static void say(void *user, ddof_log_level level, const char *text) {
    (void)user;
    if (level != DDOF_LOG_INFO) fprintf(stderr, "vulkan_embed: ddof: %s\n", text);
}

static void check(ddof_status status) {
    if (status != DDOF_OK) exit(1); /* and say() has said why */
}

/* Once for a device. */
static ddof_vulkan *create(const sample *s) {
    ddof_vulkan *vk = NULL;
    const ddof_vulkan_config config = {
        .instance = s->instance,
        .physical_device = s->gpu,
        .device = s->device,
        .queue_family = s->family,
        .get_instance_proc_addr = vkGetInstanceProcAddr,
        .features = &s->features,
        .log = say,
    };
    check(ddof_vulkan_create(&vk, &config));
    return vk;
}

static ddof_vulkan_image described(const sample_image *i, VkImageLayout layout) {
    return (ddof_vulkan_image){.image = i->image, .format = i->format, .width = i->width, .height = i->height,
                               .usage = i->usage, .layout = layout};
}

/* Once for a set of images: again after they were made anew, for another size say. */
static ddof_vulkan_frame *create_frame(ddof_vulkan *vk, const scene_images *m) {
    ddof_vulkan_frame *frame = NULL;
    const ddof_settings settings = lens(1, 1);
    const ddof_vulkan_images images = {
        .color = described(&m->color, SAMPLE_TEXTURE.layout),
        .depth = described(&m->depth, SAMPLE_TEXTURE.layout),
        .output = described(&m->blurred, VK_IMAGE_LAYOUT_GENERAL),
        .channels = 3,
    };
    check(ddof_vulkan_frame_create(vk, &frame, &images, &settings));
    return frame;
}

/* Every frame. ddof puts barriers between its own dispatches only: those before and after are the caller's. */
static void record(VkCommandBuffer c, const scene *sc, const scene_images *m, ddof_vulkan_frame *frame,
                   const sample_buffer *readback, float time, double f_number) {
    sample_begin(c);
    sample_barrier(c, m->color.image, SAMPLE_DISCARD, SAMPLE_WRITE);
    sample_barrier(c, m->depth.image, SAMPLE_DISCARD, SAMPLE_WRITE);
    scene_render(sc, c, m, time);

    sample_barrier(c, m->color.image, SAMPLE_WRITE, SAMPLE_TEXTURE);
    sample_barrier(c, m->depth.image, SAMPLE_WRITE, SAMPLE_TEXTURE);
    sample_barrier(c, m->blurred.image, SAMPLE_DISCARD, SAMPLE_WRITE);
    const ddof_settings settings = lens(2.2 * pow(4, 0.5 - 0.5 * cos(6.2831853 * time)), f_number);
    check(ddof_vulkan_record(frame, c, NULL, &settings, NULL));
    sample_barrier(c, m->blurred.image, SAMPLE_WRITE, SAMPLE_READ);

    sample_barrier(c, m->shown.image, SAMPLE_DISCARD, SAMPLE_WRITE);
    scene_tonemap(sc, c, m);
    sample_barrier(c, m->shown.image, SAMPLE_WRITE, SAMPLE_COPY);
    sample_copy(c, &m->shown, SAMPLE_COPY.layout, (VkRect2D){{0, 0}, {m->shown.width, m->shown.height}}, readback);
    SAMPLE_VK(vkEndCommandBuffer(c));
}

static void submit_and_wait(const sample *s, VkCommandBuffer commands) {
    const VkCommandBufferSubmitInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO,
                                            .commandBuffer = commands};
    const VkSubmitInfo2 submit = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2, .commandBufferInfoCount = 1,
                                  .pCommandBufferInfos = &info};
    SAMPLE_VK(vkQueueSubmit2(s->queue, 1, &submit, VK_NULL_HANDLE));
    SAMPLE_VK(vkQueueWaitIdle(s->queue));
}

/* Portable pixmap: 8 bits of R, G, B. */
static void write_ppm(const char *folder, int number, const sample_image *shown, const unsigned char *rgba) {
    char path[4096];
    snprintf(path, sizeof path, "%s/%04d.ppm", folder, number);
    FILE *file = fopen(path, "wb");
    if (!file) sample_fail("cannot write %s", path);
    fprintf(file, "P6\n%u %u\n255\n", shown->width, shown->height);
    for (size_t i = 0; i < (size_t)shown->width * shown->height; i++) fwrite(rgba + 4 * i, 3, 1, file);
    const int failed = ferror(file);
    if (fclose(file) || failed) sample_fail("cannot write %s", path);
}

int main(int argc, char **argv) {
    int frames = 48;
    unsigned width = 640, height = 360;
    double f_number = 1.4;
    char rest;
    if (argc < 2 || argc > 5 || argv[1][0] == '-' ||
        (argc > 2 && (sscanf(argv[2], "%d%c", &frames, &rest) != 1 || frames < 1)) ||
        (argc > 3 && (sscanf(argv[3], "%ux%u%c", &width, &height, &rest) != 2 || !width || !height)) ||
        (argc > 4 && (sscanf(argv[4], "%lf%c", &f_number, &rest) != 1 || !(f_number > 0)))) {
        fprintf(stderr, "usage: vulkan_embed OUTDIR [FRAMES [WIDTHxHEIGHT [F-NUMBER]]]\n");
        return 2;
    }

    sample s;
    sample_open(&s, NULL, 0);
    scene sc = scene_create(&s, 1);
    scene_images images = scene_images_create(&s, &sc, width, height);
    sample_buffer readback = sample_buffer_create(&s, (VkDeviceSize)width * height * 4);
    VkCommandBuffer commands = sample_commands(&s);

    ddof_vulkan *vk = create(&s);
    ddof_vulkan_frame *frame = create_frame(vk, &images);
    for (int i = 0; i < frames; i++) {
        record(commands, &sc, &images, frame, &readback, (float)i / (float)frames, f_number);
        submit_and_wait(&s, commands);
        write_ppm(argv[1], i, &images.shown, readback.data);
    }
    ddof_vulkan_frame_destroy(&frame); /* the GPU is idle: no command buffer with it is pending */
    ddof_vulkan_destroy(&vk);

    sample_buffer_destroy(&s, &readback);
    scene_images_destroy(&s, &sc, &images);
    scene_destroy(&s, &sc);
    sample_close(&s);
    return 0;
}
