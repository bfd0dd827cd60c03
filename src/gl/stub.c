/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Stands for the GL backend in a library that was built without it. */
#include <string.h>

#include <ddof/gl.h>

#include "../context.h"

static const char absent[] =
    "this library was built without its GL backend: build it with -Dgl=enabled (Debian: libegl-dev "
    "libgles-dev)";

static ddof_status gl_open(ddof_context *ctx) {
    return context_fail(ctx, DDOF_ERROR_UNSUPPORTED, "%s", absent);
}

const backend backend_gl = {.id = DDOF_BACKEND_GL, .open = gl_open};

ddof_status ddof_gl_create(ddof_gl **gl, const ddof_gl_config *config) {
    if (!gl || !config) return DDOF_ERROR_INVALID;
    *gl = NULL;
    if (config->log) config->log(config->log_user, DDOF_LOG_ERROR, absent);
    return DDOF_ERROR_UNSUPPORTED;
}

void ddof_gl_destroy(ddof_gl **gl) {
    if (gl) *gl = NULL;
}

const char *ddof_gl_error(const ddof_gl *gl) {
    (void)gl;
    return "";
}

ddof_status ddof_gl_render(ddof_gl *gl, const ddof_gl_frame *frame, const ddof_settings *settings,
                           ddof_gl_stats *stats) {
    (void)gl, (void)frame, (void)settings;
    if (stats) memset(stats, 0, sizeof *stats);
    return DDOF_ERROR_UNSUPPORTED;
}

ddof_status ddof_gl_surface_bytes(int width, int height, const ddof_settings *settings, size_t *bytes) {
    (void)width, (void)height, (void)settings, (void)bytes;
    return DDOF_ERROR_UNSUPPORTED;
}

ddof_status ddof_gl_trim(ddof_gl *gl) {
    (void)gl;
    return DDOF_ERROR_UNSUPPORTED;
}
