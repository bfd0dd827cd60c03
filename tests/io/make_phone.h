/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* HEIC, AVIF and JPEG XL files with depth, by the encoders of libheif and libjxl. The values are 2^bits - 1 times what
 * phone_value() gives, or, of a JPEG XL of floats, that itself. */
#ifndef TESTS_IO_MAKE_PHONE_H
#define TESTS_IO_MAKE_PHONE_H

#include <stdbool.h>
#include <stddef.h>

typedef struct phone_spec {
    int width, height, depth_width, depth_height; /* depth of width 0: none */
    int bits, depth_bits;                         /* 8 to 16; 0: floats (JPEG XL) */
    bool alpha, lossy;
    /* HEIF */
    bool av1;
    int transfer, primaries; /* H.273; 0: no nclx, where the codec can do without */
    int turn;                /* quarters, anticlockwise: irot of both images */
    bool turn_color_only;
    const unsigned char *sei; /* what the depth means: the NAL unit; NULL: nothing is said */
    size_t sei_size;
    /* JPEG XL */
    bool grey, linear, container;
} phone_spec;

/* Channel 0 to 2 colour, 3 alpha, 4 depth: 0 to 1. */
float phone_value(int channel, int x, int y, int width, int height);

/* 1: written, 0: no encoder here, -1: failed */
int make_heif(const char *path, const phone_spec *spec);
int make_jxl(const char *path, const phone_spec *spec);

/* The NAL unit of a depth representation information message. `type`: 0 inverse Z, 1 disparity, 2 Z. Ends: z_near,
 * z_far, d_min, d_max; 0 for what is not given. Returns its size. */
size_t depth_message(unsigned char out[64], int type, const double ends[4]);

#endif
