/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* What the tests of ddof_render() on the Vulkan backend share. */
#ifndef TESTS_VULKAN_SUPPORT_H
#define TESTS_VULKAN_SUPPORT_H

#include "../gpu/render.h"

/* What is promised, of the range of the colours: 2e-3 with half floats and where the solver packs; else that of the CPU
 * backends: 1e-5, and more where the blur reaches farther than 400 pixels. */
double vulkan_tolerance(const scene *s, const ddof_settings *settings, double aspect);

/* The patterns of the library's tests. */
void vulkan_fill_coc(float *coc, int width, int height, int pattern, rng *r);

#endif
