/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* What the tests of the backends with a device share, beyond those of the library: contexts, names, and a run that is
 * skipped, and counted as skipped, where there is no such device. */
#ifndef TESTS_GPU_SUPPORT_H
#define TESTS_GPU_SUPPORT_H

#include "../library/support.h"

/* Address or thread sanitizer: everything takes many times as long. */
#if defined(__SANITIZE_ADDRESS__)
#define ADDRESS_SANITIZER 1
#endif
#if defined(__SANITIZE_THREAD__)
#define THREAD_SANITIZER 1
#endif
#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#define ADDRESS_SANITIZER 1
#endif
#if __has_feature(thread_sanitizer)
#define THREAD_SANITIZER 1
#endif
#endif

/* Of what is tried at every point: each so manyth one. */
#ifdef ADDRESS_SANITIZER
enum { GPU_STEP = 6 };
#else
enum { GPU_STEP = 1 };
#endif

/* Runs them; with `missing` (why there is no device) all are skipped. */
int run_gpu_tests(const char *group, const struct CMUnitTest *tests, int count, const char *missing);

/* Whether a device that computes on the CPU is as none: DDOF_TEST_GPU is set. */
bool gpu_wanted_only(void);

/* NULL, or why ddof_create() makes no such context here. */
const char *gpu_missing(ddof_backend backend);

ddof_context *gpu_context(ddof_backend backend);

const char *solver_name(ddof_solver solver);

/* What is promised of the disc kernel's error, of the range of the colours. */
double disc_tolerance(ddof_surface surface);

#endif
