/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* vulkan_window [--frames N]: the scene in a window, two frames in flight, focused on what is under the mouse pointer.
 * The wheel sets the aperture. The GPU measures the focus: each frame copies the depth under the pointer to a
 * buffer, which is looked at when the GPU is known to be done with it, two frames later. */
#include <ddof/vulkan.h>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "vulkan_scene.h"
#include "vulkan_swapchain.h"

const char sample_program[] = "vulkan_window";

/* What a frame in flight needs for itself: images, and so a frame object of ddof. */
typedef struct slot {
    scene_images images;
    ddof_vulkan_frame *dof;
    sample_buffer measured; /* one float: the depth under the pointer */
    VkCommandBuffer commands;
} slot;

typedef struct viewer {
    GLFWwindow *window;
    int width, height; /* of its picture when the swapchain was made */
    VkSurfaceKHR surface;
    sample s;
    scene sc;
    ddof_vulkan *vk;
    swapchain screen;
    slot slots[IN_FLIGHT];
    double f_number, focus; /* the latter as the depth image has it: SCENE_NEAR / metres */
} viewer;

static ddof_settings lens(const viewer *v) {
    return (ddof_settings){
        .lens = {.focal_length = SCENE_FOCAL_LENGTH, .f_number = v->f_number, .focus_distance = SCENE_NEAR / v->focus},
        .depth = {.kind = DDOF_DEPTH_DEVICE, .z_at_0 = INFINITY, .z_at_1 = SCENE_NEAR},
    };
}

static void say(void *user, ddof_log_level level, const char *text) {
    (void)user;
    if (level != DDOF_LOG_INFO) fprintf(stderr, "vulkan_window: ddof: %s\n", text);
}

static void check(ddof_status status) {
    if (status != DDOF_OK) exit(1); /* and say() has said why */
}

static ddof_vulkan_image described(const sample_image *i, VkImageLayout layout) {
    return (ddof_vulkan_image){.image = i->image, .format = i->format, .width = i->width, .height = i->height,
                               .usage = i->usage, .layout = layout};
}

/* What has the size of the window. */
static void create_sized(viewer *v) {
    while (glfwGetFramebufferSize(v->window, &v->width, &v->height), !v->width || !v->height)
        glfwWaitEvents(); /* minimised */
    v->screen = swapchain_create(&v->s, v->surface, (uint32_t)v->width, (uint32_t)v->height);
    const ddof_settings settings = lens(v);
    for (slot *f = v->slots; f < v->slots + IN_FLIGHT; f++) {
        f->images = scene_images_create(&v->s, &v->sc, v->screen.width, v->screen.height);
        const ddof_vulkan_images images = {
            .color = described(&f->images.color, SAMPLE_TEXTURE.layout),
            .depth = described(&f->images.depth, VK_IMAGE_LAYOUT_GENERAL),
            .output = described(&f->images.blurred, VK_IMAGE_LAYOUT_GENERAL),
            .channels = 3,
        };
        check(ddof_vulkan_frame_create(v->vk, &f->dof, &images, &settings));
    }
}

static void destroy_sized(viewer *v) {
    SAMPLE_VK(vkDeviceWaitIdle(v->s.device));
    for (slot *f = v->slots; f < v->slots + IN_FLIGHT; f++) {
        ddof_vulkan_frame_destroy(&f->dof);
        scene_images_destroy(&v->s, &v->sc, &f->images);
    }
    swapchain_destroy(&v->s, &v->screen);
}

static VkRect2D pixel_under_pointer(const viewer *v) {
    double x, y;
    int width, height; /* of the window in the pointer's unit, which need not be pixels */
    glfwGetCursorPos(v->window, &x, &y);
    glfwGetWindowSize(v->window, &width, &height);
    x = fmin(fmax(x / width, 0) * v->screen.width, v->screen.width - 1.0);
    y = fmin(fmax(y / height, 0) * v->screen.height, v->screen.height - 1.0);
    return (VkRect2D){{(int32_t)x, (int32_t)y}, {1, 1}};
}

static void record(const viewer *v, const slot *f, uint32_t screen) {
    /* ddof and the copy of a pixel both read the depth, in the one layout that serves them */
    const sample_use measure = {SAMPLE_TEXTURE.stage | SAMPLE_COPY.stage, SAMPLE_TEXTURE.access | SAMPLE_COPY.access,
                                VK_IMAGE_LAYOUT_GENERAL};
    const VkCommandBuffer c = f->commands;
    const scene_images *m = &f->images;
    sample_begin(c);
    sample_barrier(c, m->color.image, SAMPLE_DISCARD, SAMPLE_WRITE);
    sample_barrier(c, m->depth.image, SAMPLE_DISCARD, SAMPLE_WRITE);
    scene_render(&v->sc, c, m, (float)fmod(glfwGetTime() / 12, 1));

    sample_barrier(c, m->color.image, SAMPLE_WRITE, SAMPLE_TEXTURE);
    sample_barrier(c, m->depth.image, SAMPLE_WRITE, measure);
    sample_copy(c, &m->depth, measure.layout, pixel_under_pointer(v), &f->measured);
    sample_barrier(c, m->blurred.image, SAMPLE_DISCARD, SAMPLE_WRITE);
    const ddof_settings settings = lens(v);
    check(ddof_vulkan_record(f->dof, c, NULL, &settings, NULL));
    sample_barrier(c, m->blurred.image, SAMPLE_WRITE, SAMPLE_READ);

    sample_barrier(c, m->shown.image, SAMPLE_DISCARD, SAMPLE_WRITE);
    scene_tonemap(&v->sc, c, m);
    sample_barrier(c, m->shown.image, SAMPLE_WRITE, SAMPLE_COPY);
    swapchain_blit(&v->screen, screen, c, m->shown.image);
    SAMPLE_VK(vkEndCommandBuffer(c));
}

/* False: the window has another size now. */
static bool draw(viewer *v) {
    uint32_t image;
    if (!swapchain_acquire(&v->s, &v->screen, &image)) return false;
    const slot *f = &v->slots[v->screen.turn];
    /* a pull of focus is even in 1/z, as the CoC is; the sky is taken for a kilometre */
    v->focus += 0.2 * (fmax(*(const float *)f->measured.data, SCENE_NEAR / 1000) - v->focus);
    record(v, f, image);
    return swapchain_present(&v->s, &v->screen, image, f->commands);
}

static void wheel(GLFWwindow *window, double x, double y) {
    viewer *v = glfwGetWindowUserPointer(window);
    (void)x;
    v->f_number = fmin(fmax(v->f_number * exp2(-y / 6), 0.7), 32); /* a third of a stop */
}

static void create(viewer *v) {
    uint32_t count = 0;
    if (!glfwInit() || !glfwVulkanSupported()) sample_fail("no display, or no Vulkan driver that can show a window");
    const char **extensions = glfwGetRequiredInstanceExtensions(&count);
    sample_open(&v->s, extensions, count);
    glfwWindowHint(GLFW_CLIENT_API, GLFW_NO_API);
    v->window = glfwCreateWindow(960, 540, "ddof", NULL, NULL);
    if (!v->window) sample_fail("no window");
    glfwSetWindowUserPointer(v->window, v);
    glfwSetScrollCallback(v->window, wheel);
    SAMPLE_VK(glfwCreateWindowSurface(v->s.instance, v->window, NULL, &v->surface));
    v->sc = scene_create(&v->s, IN_FLIGHT);
    const ddof_vulkan_config config = {.instance = v->s.instance, .physical_device = v->s.gpu, .device = v->s.device,
                                       .queue_family = v->s.family, .get_instance_proc_addr = vkGetInstanceProcAddr,
                                       .features = &v->s.features, .log = say};
    check(ddof_vulkan_create(&v->vk, &config));
    for (slot *f = v->slots; f < v->slots + IN_FLIGHT; f++) {
        f->commands = sample_commands(&v->s);
        f->measured = sample_buffer_create(&v->s, sizeof(float));
        *(float *)f->measured.data = (float)v->focus;
    }
    create_sized(v);
}

static void destroy(viewer *v) {
    destroy_sized(v);
    for (slot *f = v->slots; f < v->slots + IN_FLIGHT; f++) sample_buffer_destroy(&v->s, &f->measured);
    ddof_vulkan_destroy(&v->vk);
    scene_destroy(&v->s, &v->sc);
    vkDestroySurfaceKHR(v->s.instance, v->surface, NULL);
    sample_close(&v->s);
    glfwTerminate();
}

int main(int argc, char **argv) {
    int frames = 0, width, height;
    char rest, title[80];
    if (argc != 1 && (argc != 3 || strcmp(argv[1], "--frames") != 0 || sscanf(argv[2], "%d%c", &frames, &rest) != 1 ||
                      frames < 1)) {
        fprintf(stderr, "usage: vulkan_window [--frames N]\n");
        return 2;
    }
    viewer v = {.f_number = 1.4, .focus = SCENE_NEAR / 4};
    create(&v);
    for (int i = 0; !glfwWindowShouldClose(v.window) && (!frames || i < frames); i++) {
        glfwPollEvents();
        glfwGetFramebufferSize(v.window, &width, &height); /* not every driver reports a change */
        if (width != v.width || height != v.height || !draw(&v)) {
            destroy_sized(&v);
            create_sized(&v);
        }
        snprintf(title, sizeof title, "f/%.1f, focus at %.2f m", v.f_number, SCENE_NEAR / v.focus);
        glfwSetWindowTitle(v.window, title);
    }
    destroy(&v);
    return 0;
}
