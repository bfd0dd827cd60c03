/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* What the tests of the GL backend share, beyond those of the library: contexts, and a run that is skipped, and counted
 * as skipped, where there is no GL. */
#ifndef TESTS_GL_SUPPORT_H
#define TESTS_GL_SUPPORT_H

#include "../library/support.h"

#include <ddof/gl.h>

/* Runs them; with `missing` (why there is no GL) all are skipped. */
int run_gl_tests(const char *group, const struct CMUnitTest *tests, int count, const char *missing);

/* NULL, or why ddof_create() makes no GL context here. */
const char *gl_missing(void);

ddof_context *gl_context(void);

const char *solver_name(ddof_solver solver);
bool packs(ddof_solver solver);

/* What a solver promises for CoC up to 200, of the range of the colours. */
double solver_tolerance(const ddof_settings *settings);

#endif
