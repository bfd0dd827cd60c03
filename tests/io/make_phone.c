/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include <math.h>

#include "make_phone.h"

#ifndef IO_HAVE_HEIF
int make_heif(const char *path, const phone_spec *spec) {
    (void)path;
    (void)spec;
    return 0;
}
#endif

#ifndef IO_HAVE_JXL
int make_jxl(const char *path, const phone_spec *spec) {
    (void)path;
    (void)spec;
    return 0;
}
#endif

float phone_value(int channel, int x, int y, int width, int height) {
    const float u = ((float)x + 0.5f) / (float)width, v = ((float)y + 0.5f) / (float)height;
    switch (channel) {
    case 0: return u;
    case 1: return v;
    case 2: return 0.5f + 0.4f * sinf(9 * u) * cosf(7 * v);
    case 3: return 0.25f + 0.5f * u;
    default: return u < 0.5f ? 0.2f + 0.1f * v : 0.75f; /* a slope before a wall, and the step between them */
    }
}
