/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "image.h"

#include <string.h>

#include "cpu/kernels.h"

enum { CHUNK = 256 }; /* pixels converted at a time, on the stack */

static ptrdiff_t type_size(ddof_type type) {
    return type == DDOF_HALF ? 2 : 4;
}

void image_resolve(ddof_image *image) {
    for (int c = 0; c < image->channels; c++) {
        ddof_plane *p = &image->plane[c];
        if (p->pixel_stride == 0) p->pixel_stride = type_size(p->type);
        if (p->row_stride == 0) p->row_stride = image->width * (p->pixel_stride < 0 ? -p->pixel_stride : p->pixel_stride);
    }
}

bool image_is_rgba(const ddof_image *image) {
    if (image->channels != 4 || image->alpha != DDOF_ALPHA_PREMULTIPLIED) return false;
    const ddof_plane *p = image->plane;
    for (int c = 0; c < 4; c++) {
        if (p[c].type != DDOF_FLOAT || p[c].pixel_stride != 16 || p[c].row_stride != p[0].row_stride) return false;
        /* As numbers: where only sizes are asked for there may be no data. */
        if ((uintptr_t)p[c].data != (uintptr_t)p[0].data + 4 * (size_t)c) return false;
    }
    return true;
}

bool plane_is_tight(const ddof_plane *plane) {
    return plane->type == DDOF_FLOAT && plane->pixel_stride == 4;
}

double image_value(const ddof_image *image, int channel, int x, int y) {
    ddof_image one = *image;
    uint16_t half;
    float value;
    image_resolve(&one);
    const void *p = image_at(&one, channel, x, y);
    if (one.plane[channel].type == DDOF_FLOAT) {
        memcpy(&value, p, 4);
    } else {
        memcpy(&half, p, 2);
        cpu_kernels_baseline.pixels->half_to_float(&half, &value, 1);
    }
    return value;
}

void image_set_value(const ddof_image *image, int channel, int x, int y, double value) {
    ddof_image one = *image;
    float single = (float)value;
    image_resolve(&one);
    plane_store(&one, channel, x, y, 1, &single, cpu_kernels_baseline.pixels);
}

void plane_load(const ddof_image *image, int channel, int x, int y, int count, float *out, const pixel_kernels *k) {
    const ddof_plane *p = &image->plane[channel];
    const char *in = image_at(image, channel, x, y);
    if (p->type == DDOF_FLOAT) {
        if (p->pixel_stride == 4)
            memcpy(out, in, (size_t)count * 4);
        else
            for (int i = 0; i < count; i++) memcpy(out + i, in + p->pixel_stride * i, 4);
    } else if (p->pixel_stride == 2) {
        k->half_to_float((const uint16_t *)(const void *)in, out, count);
    } else {
        uint16_t half[CHUNK];
        for (int at = 0; at < count; at += CHUNK) {
            int n = count - at < CHUNK ? count - at : CHUNK;
            for (int i = 0; i < n; i++) memcpy(half + i, in + p->pixel_stride * (at + i), 2);
            k->half_to_float(half, out + at, n);
        }
    }
}

void plane_store(const ddof_image *image, int channel, int x, int y, int count, const float *in, const pixel_kernels *k) {
    const ddof_plane *p = &image->plane[channel];
    char *out = image_at(image, channel, x, y);
    if (p->type == DDOF_FLOAT) {
        if (p->pixel_stride == 4)
            memcpy(out, in, (size_t)count * 4);
        else
            for (int i = 0; i < count; i++) memcpy(out + p->pixel_stride * i, in + i, 4);
    } else if (p->pixel_stride == 2) {
        k->float_to_half(in, (uint16_t *)(void *)out, count);
    } else {
        uint16_t half[CHUNK];
        for (int at = 0; at < count; at += CHUNK) {
            int n = count - at < CHUNK ? count - at : CHUNK;
            k->float_to_half(in + at, half, n);
            for (int i = 0; i < n; i++) memcpy(out + p->pixel_stride * (at + i), half + i, 2);
        }
    }
}

static void multiply(float *rgba, int alpha, int count) {
    for (int i = 0; i < count; i++) {
        float a = rgba[4 * i + alpha];
        for (int c = 0; c < alpha; c++) rgba[4 * i + c] *= a;
    }
}

static void divide(float plane[4][CHUNK], int alpha, int count) {
    for (int c = 0; c < alpha; c++)
        for (int i = 0; i < count; i++) plane[c][i] = plane[alpha][i] != 0 ? plane[c][i] / plane[alpha][i] : 0;
}

void span_load(const ddof_image *image, int x, int y, int count, float *rgba, bool straight, const pixel_kernels *k) {
    float plane[4][CHUNK] = {{0}};
    for (int at = 0; at < count; at += CHUNK) {
        int n = count - at < CHUNK ? count - at : CHUNK;
        float *out = rgba + 4 * (ptrdiff_t)at;
        for (int c = 0; c < image->channels; c++) plane_load(image, c, x + at, y, n, plane[c], k);
        for (int i = 0; i < n; i++)
            for (int c = 0; c < 4; c++) out[4 * i + c] = plane[c][i];
        if (straight) multiply(out, image->channels - 1, n);
    }
}

void span_store(const ddof_image *image, int x, int y, int count, const float *rgba, bool straight,
                const pixel_kernels *k) {
    float plane[4][CHUNK];
    for (int at = 0; at < count; at += CHUNK) {
        int n = count - at < CHUNK ? count - at : CHUNK;
        const float *in = rgba + 4 * (ptrdiff_t)at;
        for (int i = 0; i < n; i++)
            for (int c = 0; c < 4; c++) plane[c][i] = in[4 * i + c];
        if (straight) divide(plane, image->channels - 1, n);
        for (int c = 0; c < image->channels; c++) plane_store(image, c, x + at, y, n, plane[c], k);
    }
}
