/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "support.h"

#include <stdio.h>
#include <string.h>

static void not_here(void **state) {
    (void)state;
}

int run_gl_tests(const char *group, const struct CMUnitTest *tests, int count, const char *missing) {
    enum { MOST = 64, NAME = 400 };
    static struct CMUnitTest units[MOST];
    static char names[MOST][NAME];
    if (count > MOST) return 1;
    for (int i = 0; i < count; i++) {
        units[i] = tests[i];
        if (!missing) continue;
        snprintf(names[i], NAME, "%s # SKIP %s", tests[i].name, missing);
        units[i] = (struct CMUnitTest){names[i], not_here, NULL, NULL, NULL};
    }
    cmocka_set_message_output(CM_OUTPUT_TAP);
    return _cmocka_run_group_tests(group, units, (size_t)count, NULL, NULL);
}

#if defined(__SANITIZE_THREAD__)
#define THREAD_SANITIZER 1
#elif defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define THREAD_SANITIZER 1
#endif
#endif

static char why[300];

static void keep(void *user, ddof_log_level level, const char *text) {
    (void)user;
    if (level == DDOF_LOG_ERROR) snprintf(why, sizeof why, "%s", text);
}

const char *gl_missing(void) {
#ifdef THREAD_SANITIZER
    return "the driver's compiler does not run under ThreadSanitizer"; /* and the backend has one thread */
#endif
    ddof_config config = {.backend = DDOF_BACKEND_GL, .log = keep};
    ddof_context *ctx = NULL;
    ddof_status status = ddof_create(&ctx, &config);
    DESTROY(ctx);
    if (status == DDOF_OK) return NULL;
    return status == DDOF_ERROR_UNSUPPORTED ? why : NULL; /* another status is a failure for the tests to find */
}

ddof_context *gl_context(void) {
    ddof_config config = {.backend = DDOF_BACKEND_GL};
    ddof_context *ctx = NULL;
    assert_int_equal(ddof_create(&ctx, &config), DDOF_OK);
    return ctx;
}

const char *solver_name(ddof_solver solver) {
    static const char *const names[] = {"default", "cr-vanilla", "cr", "cr+pack", "cr4", "cr4+pack", "cr+pcr"};
    return names[solver];
}

bool packs(ddof_solver solver) {
    return solver == DDOF_SOLVER_DEFAULT || solver == DDOF_SOLVER_CR_PACK || solver == DDOF_SOLVER_CR4_PACK;
}

double solver_tolerance(const ddof_settings *settings) {
    return settings->surface == DDOF_SURFACE_RGBA32F && !packs(settings->solver) ? 1e-4 : 2e-3;
}
