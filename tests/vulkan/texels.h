/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Texels of the formats of ddof/vulkan.h, by arithmetic. */
#ifndef TESTS_VULKAN_TEXELS_H
#define TESTS_VULKAN_TEXELS_H

#include <stdbool.h>
#include <stddef.h>

#include <vulkan/vulkan_core.h>

const char *format_name(VkFormat format);
bool format_is_depth(VkFormat format); /* with a depth aspect */

/* As a copy between a buffer and (the depth of) the image has them. */
size_t texel_bytes(VkFormat format);
void texel_encode(VkFormat format, const float rgba[4], void *texel);
void texel_decode(VkFormat format, const void *texel, float rgba[4]); /* as it is sampled */

/* The distance to the next value of the format, at `value` of channel c. */
double texel_step(VkFormat format, double value, int c);

#endif
