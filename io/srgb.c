/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include <math.h>

#include "format.h"

float io_srgb_to_linear(float encoded) {
    float value = fabsf(encoded);
    float linear = value <= 0.04045f ? value / 12.92f : powf((value + 0.055f) / 1.055f, 2.4f);
    return copysignf(linear, encoded);
}

float io_linear_to_srgb(float linear) {
    float value = fabsf(linear);
    float encoded = value <= 0.0031308f ? value * 12.92f : 1.055f * powf(value, 1 / 2.4f) - 0.055f;
    return copysignf(encoded, linear);
}
