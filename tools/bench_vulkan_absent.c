/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Stands for bench_vulkan.c where the headers of Vulkan were not there. */
#include <stdio.h>

#include "bench_vulkan.h"

static const char absent[] = "this ddof was built without its Vulkan backend: build it with -Dvulkan=enabled";

bench_vulkan *bench_vulkan_open(int device, ddof_status *status, char *why, size_t size) {
    (void)device;
    *status = DDOF_ERROR_UNSUPPORTED;
    snprintf(why, size, "%s", absent);
    return NULL;
}

void bench_vulkan_close(bench_vulkan **vk) {
    *vk = NULL;
}

bool bench_vulkan_has_timestamps(const bench_vulkan *vk) {
    (void)vk;
    return false;
}

const char *bench_vulkan_picture(bench_vulkan *vk, const scene *s, ddof_surface surface, double *moved) {
    (void)vk, (void)s, (void)surface, (void)moved;
    return absent;
}

const char *bench_vulkan_prepare(bench_vulkan *vk, int slot, const ddof_settings *settings, bench_vulkan_plan *plan) {
    (void)vk, (void)slot, (void)settings, (void)plan;
    return absent;
}

const char *bench_vulkan_solve(bench_vulkan *vk, int slot, double *ms) {
    (void)vk, (void)slot, (void)ms;
    return absent;
}

const char *bench_vulkan_sprites(bench_vulkan *vk, bench_vulkan_times *times) {
    (void)vk, (void)times;
    return absent;
}

const char *bench_vulkan_copy(bench_vulkan *vk, double *ms) {
    (void)vk, (void)ms;
    return absent;
}
