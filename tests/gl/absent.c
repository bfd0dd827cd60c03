/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* A machine without libEGL, and one whose libEGL finds no driver: this program's dlopen() and dlsym() are the ones the
 * library gets. */
#include "support.h"

#include <string.h>

typedef unsigned (*query_api)(void);

static bool library_there;

void *dlopen(const char *file, int mode);
void *dlsym(void *handle, const char *name);
static int nothing_at_all(void);

void *dlopen(const char *file, int mode) {
    (void)mode;
    return library_there && strstr(file, "EGL") ? &library_there : NULL;
}

/* Every function there is returns 0. */
static int nothing_at_all(void) {
    return 0;
}

void *dlsym(void *handle, const char *name) {
    int (*function)(void) = nothing_at_all;
    void *symbol;
    assert_ptr_equal(handle, &library_there);
    assert_non_null(strstr(name, "egl"));
    memcpy(&symbol, &function, sizeof symbol);
    return symbol;
}

static char said[300];
static int times;

static void keep(void *user, ddof_log_level level, const char *text) {
    (void)user;
    assert_int_equal(level, DDOF_LOG_ERROR);
    strncpy(said, text, sizeof said - 1);
    times++;
}

static void says(const char *part) {
    const ddof_config config = {.backend = DDOF_BACKEND_GL, .log = keep};
    ddof_context *ctx = (ddof_context *)said;
    times = 0;
    assert_int_equal(ddof_create(&ctx, &config), DDOF_ERROR_UNSUPPORTED);
    assert_null(ctx);
    assert_int_equal(times, 1);
    assert_non_null(strstr(said, part));
}

static void no_library(void **state) {
    (void)state;
    library_there = false;
    says("libEGL.so.1");
}

static void no_driver(void **state) {
    (void)state;
    library_there = true;
    says("driver");
}

/* The other backends do not need it. */
static void others_work(void **state) {
    (void)state;
    ddof_context *ctx = NULL;
    assert_int_equal(ddof_create(&ctx, NULL), DDOF_OK);
    DESTROY(ctx);
}

int main(void) {
    static const struct CMUnitTest tests[] = {cmocka_unit_test(no_library), cmocka_unit_test(no_driver),
                                              cmocka_unit_test(others_work)};
    return run_gpu_tests("gl absent", tests, COUNT(tests), NULL);
}
