/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Stands for bench_gl.c where the headers of GL were not there. */
#include <stdio.h>

#include "bench_gl.h"
#include "message.h"

bench_gl *bench_gl_create(const scene *s, ddof_surface surface, char *why, size_t size) {
    (void)s, (void)surface;
    snprintf(why, size, "this ddof was built without its GL backend: build it with -Dgl=enabled");
    return NULL;
}

void bench_gl_destroy(bench_gl **gl) {
    *gl = NULL;
}

int bench_gl_solve(bench_gl *gl, int slot, const ddof_settings *settings, double *ms, ddof_gl_stats *stats) {
    (void)gl, (void)slot, (void)settings, (void)ms, (void)stats;
    return fail("--backend gl: this ddof was built without it; use --backend cpu");
}
