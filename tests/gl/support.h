/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* What the tests of the GL backend share, beyond those of every backend with a device. */
#ifndef TESTS_GL_SUPPORT_H
#define TESTS_GL_SUPPORT_H

#include "../gpu/support.h"

#include <ddof/gl.h>

/* NULL, or why ddof_create() makes no GL context here. */
const char *gl_missing(void);

ddof_context *gl_context(void);

/* What a solver promises for CoC up to 200, of the range of the colours. */
double solver_tolerance(const ddof_settings *settings);

#endif
