/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* `ddof bench --backend vulkan`, and its --table. */
#ifndef TOOLS_BENCH_VULKAN_REPORT_H
#define TOOLS_BENCH_VULKAN_REPORT_H

#include "backend.h"
#include "bench_report.h"
#include "bench_vulkan.h"
#include "json.h"

/* The device, opened by --device. */
typedef struct vulkan_bench {
    const options *o;
    bench_vulkan *vk;
    int index;
    ddof_device device; /* as of ddof_devices() */
    int runs;
} vulkan_bench;

/* Returns the exit code. *stand_in: nothing was done but a note printed, since the CPU engine is to do the work. */
int bench_vulkan_command(const options *o, const backend_choice *choice, bool *stand_in);

/* bench_vulkan_table.c: every solver at the published sizes and at those of 4K and 8K. Returns the exit code. */
int bench_vulkan_table(vulkan_bench *b);

/* Machine, device, and how time is taken: members, or lines. */
void bench_vulkan_add_where(const vulkan_bench *b, cJSON *object);
void bench_vulkan_print_where(const vulkan_bench *b);
/* Members of a solve: times beside those of the copy, memory, plan. */
typedef struct vulkan_measure {
    spread solve, copy;   /* milliseconds */
    double pixels, moved; /* moved: bytes */
    bench_vulkan_plan plan;
    bool timed, compared; /* whether there are the next three, and the last */
    spread append, draw, draw_append;
    spread highlights; /* the whole to diffusion alone, of each pair */
} vulkan_measure;
void bench_vulkan_add_measure(const vulkan_measure *m, cJSON *object);
/* "line, 8 pixels a thread, ..." */
void bench_vulkan_plan_text(const bench_vulkan_plan *plan, char *text, size_t size);

#endif
