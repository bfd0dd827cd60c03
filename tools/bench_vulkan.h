/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The Vulkan solvers of `ddof bench`, timed alone: images go in, an image comes out, nothing is uploaded or read back
 * in between. One picture, one recorded command buffer for each solver, and one for the copy that is their yardstick.
 * Needs no header of Vulkan. */
#ifndef TOOLS_BENCH_VULKAN_H
#define TOOLS_BENCH_VULKAN_H

#include <ddof/ddof.h>
#include <stdbool.h>

#include "bench_scene.h"

typedef struct bench_vulkan bench_vulkan;

/* How a solver does it, as ddof_vulkan_stats. */
typedef struct bench_vulkan_plan {
    ddof_solver solver;
    size_t scratch_bytes;
    int dispatches, pixels_per_thread, workgroup, strip, subgroup;
} bench_vulkan_plan;

/* Milliseconds of a solve's sprites. */
typedef struct bench_vulkan_times {
    double append; /* until they are listed, and their light is taken out of the picture */
    double draw;
} bench_vulkan_times;

/* Opens a device of ddof_devices(). NULL: `why` says so; *status as of ddof_create(). */
bench_vulkan *bench_vulkan_open(int device, ddof_status *status, char *why, size_t size);
void bench_vulkan_close(bench_vulkan **vk);

/* Whether times are the device's timestamps, and not wall time from submission to fence. */
bool bench_vulkan_has_timestamps(const bench_vulkan *vk);

/* What follows returns NULL, or what went wrong: a text that lives until the next call. */

/* Takes the scene's picture (interleaved, 3 or 4 channels) in place of any earlier one: colour and result as `surface`,
 * CoC or depth in floats, or halves if the scene's type is that. *moved: the bytes that the copy moves, see below. */
const char *bench_vulkan_picture(bench_vulkan *vk, const scene *s, ddof_surface surface, double *moved);

/* Records a solve into `slot`, 0 to BENCH_VULKAN_SLOTS - 1, in place of what was there. */
enum { BENCH_VULKAN_SLOTS = 4 };
const char *bench_vulkan_prepare(bench_vulkan *vk, int slot, const ddof_settings *settings, bench_vulkan_plan *plan);

/* Runs it, waits and tells the milliseconds it took. */
const char *bench_vulkan_solve(bench_vulkan *vk, int slot, double *ms);

/* Of the last solve, which was of sprites, on a device with timestamps. */
const char *bench_vulkan_sprites(bench_vulkan *vk, bench_vulkan_times *times);

/* The yardstick: a copy in the device's memory of as many bytes, half of them read and half written, as no solver of
 * this method can do without: for each substep and direction, colour and CoC read and colour written. */
const char *bench_vulkan_copy(bench_vulkan *vk, double *ms);

#endif
