/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include <math.h>
#include <stdint.h>
#include <string.h>

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

/* ------------------------------------------------------------------------- what the depth means */

typedef struct bit_writer {
    unsigned char *out;
    size_t bits;
} bit_writer;

static void put(bit_writer *w, uint32_t value, int count) {
    for (int i = count - 1; i >= 0; i--, w->bits++)
        if (value >> i & 1) w->out[w->bits / 8] |= (unsigned char)(0x80 >> w->bits % 8);
}

/* ITU-T H.265, depth_rep_info_element: 2^(exponent - 31) (1 + mantissa / 2^24) */
static void put_element(bit_writer *w, double value) {
    int exponent;
    const double fraction = frexp(value, &exponent);
    put(w, 0, 1);
    put(w, (uint32_t)(exponent - 1 + 31), 7);
    put(w, 24 - 1, 5);
    put(w, (uint32_t)((2 * fraction - 1) * (1 << 24)), 24);
}

size_t depth_message(unsigned char out[64], int type, const double ends[4]) {
    bit_writer w = {out, 8 * 4};
    memset(out, 0, 64);
    out[0] = 39 << 1; /* prefix SEI */
    out[1] = 1;
    out[2] = 177;
    for (int i = 0; i < 4; i++)
        put(&w, ends[i] != 0, 1);
    put(&w, type == 0 ? 1 : (uint32_t)type + 1, type == 0 ? 1 : 3); /* ue(v), 0 to 2 */
    if (ends[2] != 0 || ends[3] != 0) put(&w, 1, 1);
    for (int i = 0; i < 4; i++)
        if (ends[i] != 0) put_element(&w, ends[i]);
    put(&w, 1, 1);
    out[3] = (unsigned char)((w.bits + 7) / 8 - 4);
    return (w.bits + 7) / 8;
}
