/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "layout.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "support.h"

enum { FILL = 0xa5 }; /* as fenced() leaves it */

static unsigned char *value_at(const stored *s, int c, int x, int y) {
    const ddof_plane *p = &s->image.plane[c];
    const int size = p->type == DDOF_HALF ? 2 : 4;
    const ptrdiff_t pixel = p->pixel_stride ? p->pixel_stride : size;
    const ptrdiff_t row = p->row_stride ? p->row_stride : s->image.width * (pixel < 0 ? -pixel : pixel);
    return (unsigned char *)p->data + row * y + pixel * x;
}

/* Interleaved with `slots` values of `size` bytes a pixel, the first at `first`. */
static void interleave(stored *s, size_t size, size_t slots, size_t first, size_t row) {
    for (int c = 0; c < s->image.channels; c++) {
        ddof_plane *p = &s->image.plane[c];
        p->data = s->memory + first + (size_t)c * size;
        p->pixel_stride = (ptrdiff_t)(slots * size);
        p->row_stride = (ptrdiff_t)row;
    }
}

static size_t row_bytes(layout arrangement, size_t tight, size_t size) {
    switch (arrangement) {
    case LAYOUT_ALIGNED:
        return (tight + 63) / 64 * 64;
    case LAYOUT_PADDED:
        return tight + 7 * size;
    case LAYOUT_OFFSET_16:
        return (tight + 63) / 64 * 64 + 16;
    default:
        return tight;
    }
}

static void turn_rows(stored *s) {
    for (int c = 0; c < s->image.channels; c++) {
        ddof_plane *p = &s->image.plane[c];
        p->data = (char *)p->data + p->row_stride * (s->image.height - 1);
        p->row_stride = -p->row_stride;
    }
}

static void turn_pixels(stored *s) {
    for (int c = 0; c < s->image.channels; c++) {
        ddof_plane *p = &s->image.plane[c];
        p->data = (char *)p->data + p->pixel_stride * (s->image.width - 1);
        p->pixel_stride = -p->pixel_stride;
    }
}

static void turn_channels(stored *s) {
    for (int c = 0; c < s->image.channels / 2; c++) {
        void *swap = s->image.plane[c].data;
        s->image.plane[c].data = s->image.plane[s->image.channels - 1 - c].data;
        s->image.plane[s->image.channels - 1 - c].data = swap;
    }
}

/* Channels from `from` on, in planes of their own at `memory`; strides left to their defaults. */
static void planes(stored *s, int from, unsigned char *memory, size_t plane_bytes) {
    for (int c = from; c < s->image.channels; c++) {
        ddof_plane *p = &s->image.plane[c];
        p->data = memory + plane_bytes * (size_t)(c - from);
        p->pixel_stride = p->row_stride = 0;
    }
}

static void rows_apart(stored *s, size_t size) {
    for (int c = 0; c < s->image.channels; c++) {
        ddof_plane *p = &s->image.plane[c];
        p->data = s->memory + (size_t)c * (size_t)s->image.width * size;
        p->pixel_stride = (ptrdiff_t)size;
        p->row_stride = (ptrdiff_t)((size_t)s->image.channels * (size_t)s->image.width * size);
    }
}

stored stored_make(layout arrangement, int width, int height, int channels, unsigned half) {
    const unsigned all = (1u << channels) - 1;
    const size_t size = (half & all) == all ? 2 : 4, n = (size_t)channels;
    const size_t slots = arrangement == LAYOUT_SPACED ? n + 3 : arrangement == LAYOUT_LAST_APART ? n - 1 : n;
    const size_t row = row_bytes(arrangement, (size_t)width * slots * size, size),
                 plane = (size_t)width * (size_t)height * size;
    const size_t first = arrangement == LAYOUT_OFFSET || arrangement == LAYOUT_SPACED ? size : 0;
    stored s = {.arrangement = arrangement, .image = {.width = width, .height = height, .channels = channels}};
    s.bytes = arrangement == LAYOUT_PLANAR ? plane * n : row * (size_t)height + first;
    if (arrangement == LAYOUT_LAST_APART) s.bytes = row * (size_t)height + plane;
    s.memory = fenced(s.bytes, arrangement == LAYOUT_TIGHT || arrangement >= LAYOUT_REVERSED);
    interleave(&s, size, slots, first, row);
    if (arrangement == LAYOUT_BOTTOM_UP) turn_rows(&s);
    if (arrangement == LAYOUT_MIRRORED) turn_pixels(&s);
    if (arrangement == LAYOUT_REVERSED) turn_channels(&s);
    if (arrangement == LAYOUT_ROWS_APART) rows_apart(&s, size);
    for (int c = 0; c < channels; c++)
        s.image.plane[c].type = half >> c & 1 ? DDOF_HALF : DDOF_FLOAT;
    if (arrangement == LAYOUT_PLANAR && size == 2) planes(&s, 0, s.memory, plane);
    if (arrangement == LAYOUT_PLANAR && size == 4)
        for (int c = 0; c < channels; c++)
            s.image.plane[c] =
                (ddof_plane){s.memory + plane * (size_t)c, s.image.plane[c].type, 4, 4 * (ptrdiff_t)width};
    if (arrangement == LAYOUT_LAST_APART) {
        planes(&s, channels - 1, s.memory + row * (size_t)height, plane);
        s.image.plane[channels - 1].pixel_stride = (ptrdiff_t)size;
    }
    return s;
}

void stored_free(stored *s) {
    fenced_free(s->memory);
    *s = (stored){0};
}

void stored_put(const stored *s, const float *values, int step) {
    for (int y = 0; y < s->image.height; y++)
        for (int x = 0; x < s->image.width; x++)
            for (int c = 0; c < s->image.channels; c++) {
                float v = values[((ptrdiff_t)y * s->image.width + x) * step + c];
                uint16_t h = half_nearest(v);
                if (s->image.plane[c].type == DDOF_HALF)
                    memcpy(value_at(s, c, x, y), &h, 2);
                else
                    memcpy(value_at(s, c, x, y), &v, 4);
            }
}

void stored_get(const stored *s, float *values, int step) {
    for (int y = 0; y < s->image.height; y++)
        for (int x = 0; x < s->image.width; x++)
            for (int c = 0; c < s->image.channels; c++) {
                float *v = &values[((ptrdiff_t)y * s->image.width + x) * step + c];
                uint16_t h;
                if (s->image.plane[c].type == DDOF_HALF) {
                    memcpy(&h, value_at(s, c, x, y), 2);
                    *v = (float)half_value(h);
                } else {
                    memcpy(v, value_at(s, c, x, y), 4);
                }
            }
}

void assert_gaps_intact(const stored *s) {
    unsigned char *used = calloc(s->bytes, 1);
    assert_non_null(used);
    for (int y = 0; y < s->image.height; y++)
        for (int x = 0; x < s->image.width; x++)
            for (int c = 0; c < s->image.channels; c++)
                memset(used + (value_at(s, c, x, y) - s->memory), 1, s->image.plane[c].type == DDOF_HALF ? 2 : 4);
    for (size_t i = 0; i < s->bytes; i++)
        if (!used[i] && s->memory[i] != FILL)
            fail_msg("arrangement %d, %d x %d: byte %zu of %zu is no pixel's but was written", s->arrangement,
                     s->image.width, s->image.height, i, s->bytes);
    free(used);
}

double half_value(uint16_t half) {
    const int exponent = half >> 10 & 31, mantissa = half & 1023;
    const double sign = half & 0x8000 ? -1 : 1;
    if (exponent == 31) return mantissa ? NAN : sign * INFINITY;
    return sign * (exponent ? ldexp(1024 + mantissa, exponent - 25) : ldexp(mantissa, -24));
}

uint16_t half_nearest(double value) {
    const uint16_t sign = signbit(value) ? 0x8000 : 0;
    const double a = fabs(value);
    if (isnan(value)) return (uint16_t)(sign | 0x7e00);
    if (a >= 65520) return (uint16_t)(sign | 0x7c00);
    const int exponent = a < 0x1p-14 ? -14 : ilogb(a);
    const int rounded = (int)nearbyint(ldexp(a, 10 - exponent)); /* 1024..2048, less where subnormal */
    return (uint16_t)(sign | (((exponent + 15) << 10) + rounded - 1024));
}
