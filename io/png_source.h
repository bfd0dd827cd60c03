/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Inside io/png*.c only: what is kept of a PNG between reading and writing. */
#ifndef IO_PNG_SOURCE_H
#define IO_PNG_SOURCE_H

#include <png.h>

#include "coding.h"

typedef struct io_png_chunk {
    char name[5];
    unsigned char *data;
    size_t size;
    bool after_pixels;
} io_png_chunk;

typedef struct io_source {
    io_options options;
    io_coding coding;
    bool created; /* by io_create: there is no file it came from */
    uint32_t width, height;
    int bits;      /* 8 or 16: what is decoded and written */
    int file_bits; /* 1, 2, 4, 8, 16 */
    int channels;  /* decoded: Y, Y A, R G B, R G B A */
    bool palette, transparent /* tRNS */, interlaced, has_tail;
    int chunk_count; /* ancillary chunks but tRNS, raw, in the order of the file */
    io_png_chunk *chunk;
} io_source;

const io_png_chunk *io_png_find_chunk(const io_source *source, const char *name);

int io_png_write(const io_picture *picture, const char *temporary, const char *path, const io_options *options,
                 io_error *note, io_error *error);

#endif
