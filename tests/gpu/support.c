/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#define _GNU_SOURCE /* RTLD_NODELETE */
#include "support.h"

#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void not_here(void **state) {
    (void)state;
}

/* What a driver leaks can be told from what the library does while the driver is loaded. */
static void keep_driver(void) {
#ifdef ADDRESS_SANITIZER
    (void)dlopen("libvulkan_lvp.so", RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
#endif
}

int run_gpu_tests(const char *group, const struct CMUnitTest *tests, int count, const char *missing) {
    enum { MOST = 64, NAME = 400 };
    static struct CMUnitTest units[MOST];
    static char names[MOST][NAME];
    if (count > MOST) return 1;
    keep_driver();
    for (int i = 0; i < count; i++) {
        units[i] = tests[i];
        if (!missing) continue;
        snprintf(names[i], NAME, "%s # SKIP %s", tests[i].name, missing);
        units[i] = (struct CMUnitTest){names[i], not_here, NULL, NULL, NULL};
    }
    cmocka_set_message_output(CM_OUTPUT_TAP);
    return _cmocka_run_group_tests(group, units, (size_t)count, NULL, NULL);
}

static char why[300];

static void keep(void *user, ddof_log_level level, const char *text) {
    (void)user;
    if (level == DDOF_LOG_ERROR) snprintf(why, sizeof why, "%s", text);
}

bool gpu_wanted_only(void) {
    return getenv("DDOF_TEST_GPU") != NULL;
}

const char *gpu_missing(ddof_backend backend) {
#ifdef THREAD_SANITIZER
    (void)keep, (void)backend;
    return "the driver's compiler does not run under ThreadSanitizer"; /* and the backend has one thread */
#else
    ddof_config config = {.backend = backend, .log = keep};
    ddof_context *ctx = NULL;
    ddof_device best;
    keep_driver();
    if (gpu_wanted_only() && ddof_devices(backend, &best, 1) > 0 && best.is_software)
        return "there is no GPU here, only software";
    ddof_status status = ddof_create(&ctx, &config);
    DESTROY(ctx);
    if (status == DDOF_OK) return NULL;
    return status == DDOF_ERROR_UNSUPPORTED ? why : NULL; /* another status is a failure for the tests to find */
#endif
}

ddof_context *gpu_context(ddof_backend backend) {
    ddof_config config = {.backend = backend, .log = keep};
    ddof_context *ctx = NULL;
    if (ddof_create(&ctx, &config) != DDOF_OK) fail_msg("ddof_create: %s", why);
    return ctx;
}

double disc_tolerance(ddof_surface surface) {
    return surface == DDOF_SURFACE_RGBA32F ? 1e-5 : 5e-3;
}

const char *solver_name(ddof_solver solver) {
    static const char *const names[] = {"default",  "cr-vanilla", "cr",   "cr+pack", "cr4",
                                        "cr4+pack", "cr+pcr",     "line", "pcr",     "pcr3+sweep"};
    return names[solver];
}
