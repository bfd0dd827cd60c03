/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#ifndef DDOF_GL_SHADERS_H
#define DDOF_GL_SHADERS_H

#include <stddef.h>

/* The text of a file below shaders/, e.g. "gl/reduce.glsl". */
const char *shader_text(const char *name);

#endif
