/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Stands for the Vulkan backend in a library that was built without it. Vulkan's headers may not be there, and with
 * them ddof/vulkan.h: its functions are declared here once more, with the same binary interface. */
#include <string.h>

#include "../context.h"

static const char absent[] =
    "this library was built without its Vulkan backend: build it with -Dvulkan=enabled (Debian: libvulkan-dev glslc)";

static ddof_status vulkan_open(ddof_context *ctx) {
    return context_fail(ctx, DDOF_ERROR_UNSUPPORTED, "%s", absent);
}

const backend backend_vulkan = {.id = DDOF_BACKEND_VULKAN, .open = vulkan_open};

typedef struct ddof_vulkan ddof_vulkan;
typedef struct ddof_vulkan_frame ddof_vulkan_frame;

/* ddof_vulkan_config up to its reserved members. VkInstance and the like are pointers. */
typedef struct stub_config {
    void *instance, *physical_device, *device;
    uint32_t queue_family;
    void (*get_instance_proc_addr)(void);
    const void *features, *allocator, *pipeline_cache;
    size_t pipeline_cache_size;
    void *(*allocate)(void *user, size_t bytes);
    void (*release)(void *user, void *memory);
    void *memory_user;
    void (*log)(void *user, ddof_log_level level, const char *text);
    void *log_user;
} stub_config;

/* ddof_vulkan_stats. */
typedef struct stub_stats {
    size_t scratch_bytes;
    int dispatches;
    ddof_solver solver;
    int pixels_per_thread, workgroup, strip, subgroup;
    const char *device;
    uint64_t reserved[8];
} stub_stats;

DDOF_API ddof_status ddof_vulkan_create(ddof_vulkan **vk, const stub_config *config);
DDOF_API void ddof_vulkan_destroy(ddof_vulkan **vk);
DDOF_API const char *ddof_vulkan_error(const ddof_vulkan *vk);
DDOF_API const char *ddof_vulkan_frame_error(const ddof_vulkan_frame *frame);
DDOF_API int ddof_vulkan_can_output(const ddof_vulkan *vk, int format);
DDOF_API int ddof_vulkan_can_sample(const ddof_vulkan *vk, int format);
DDOF_API ddof_status ddof_vulkan_scratch(ddof_vulkan *vk, const void *images, const ddof_settings *settings,
                                         void *requirements);
DDOF_API ddof_status ddof_vulkan_frame_create(ddof_vulkan *vk, ddof_vulkan_frame **frame, const void *images,
                                              const ddof_settings *settings);
DDOF_API void ddof_vulkan_frame_destroy(ddof_vulkan_frame **frame);
DDOF_API ddof_status ddof_vulkan_record(ddof_vulkan_frame *frame, void *commands, const void *view,
                                        const ddof_settings *settings, stub_stats *stats);
DDOF_API ddof_status ddof_vulkan_frame_timestamps(ddof_vulkan_frame *frame, uint64_t pool, uint32_t first);
DDOF_API ddof_status ddof_vulkan_pipeline_cache(ddof_vulkan *vk, void *data, size_t *size);

ddof_status ddof_vulkan_create(ddof_vulkan **vk, const stub_config *config) {
    if (!vk) return DDOF_ERROR_INVALID;
    *vk = NULL;
    if (!config) return DDOF_ERROR_INVALID;
    if (config->log) config->log(config->log_user, DDOF_LOG_ERROR, absent);
    return DDOF_ERROR_UNSUPPORTED;
}

void ddof_vulkan_destroy(ddof_vulkan **vk) {
    if (vk) *vk = NULL;
}

const char *ddof_vulkan_error(const ddof_vulkan *vk) {
    (void)vk;
    return "";
}

const char *ddof_vulkan_frame_error(const ddof_vulkan_frame *frame) {
    (void)frame;
    return "";
}

int ddof_vulkan_can_output(const ddof_vulkan *vk, int format) {
    (void)vk, (void)format;
    return 0;
}

int ddof_vulkan_can_sample(const ddof_vulkan *vk, int format) {
    (void)vk, (void)format;
    return 0;
}

ddof_status ddof_vulkan_scratch(ddof_vulkan *vk, const void *images, const ddof_settings *settings,
                                void *requirements) {
    (void)vk, (void)images, (void)settings, (void)requirements;
    return DDOF_ERROR_UNSUPPORTED;
}

ddof_status ddof_vulkan_frame_create(ddof_vulkan *vk, ddof_vulkan_frame **frame, const void *images,
                                     const ddof_settings *settings) {
    (void)vk, (void)images, (void)settings;
    if (frame) *frame = NULL;
    return DDOF_ERROR_UNSUPPORTED;
}

void ddof_vulkan_frame_destroy(ddof_vulkan_frame **frame) {
    if (frame) *frame = NULL;
}

ddof_status ddof_vulkan_record(ddof_vulkan_frame *frame, void *commands, const void *view,
                               const ddof_settings *settings, stub_stats *stats) {
    (void)frame, (void)commands, (void)view, (void)settings;
    if (stats) memset(stats, 0, sizeof *stats);
    return DDOF_ERROR_UNSUPPORTED;
}

ddof_status ddof_vulkan_frame_timestamps(ddof_vulkan_frame *frame, uint64_t pool, uint32_t first) {
    (void)frame, (void)pool, (void)first;
    return DDOF_ERROR_UNSUPPORTED;
}

ddof_status ddof_vulkan_pipeline_cache(ddof_vulkan *vk, void *data, size_t *size) {
    (void)vk, (void)data, (void)size;
    return DDOF_ERROR_UNSUPPORTED;
}
