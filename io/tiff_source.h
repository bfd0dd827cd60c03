/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Inside io/tiff*.c only: what is kept of a TIFF between reading and writing, and libtiff without printing. */
#ifndef IO_TIFF_SOURCE_H
#define IO_TIFF_SOURCE_H

#include <tiffio.h>

#include "coding.h"
#include "tiff_ifd.h"

/* ---- a file in libtiff's hands (tiff_file.c) */

typedef struct io_tiff_file {
    TIFF *tiff;
    int descriptor;
    int write_error;  /* errno of the first write that failed: libtiff does not report all of them */
    io_error message; /* libtiff's first complaint, "" for none */
    io_error damage;  /* a decoder's warning that it gave pixels which are not all in the file */
} io_tiff_file;

/* Close it even when it failed. */
int io_tiff_read_file(io_tiff_file *file, const io_picture *picture, io_error *error);
/* The temporary file, which is there; mode as in TIFFOpen. `path` is for messages. */
int io_tiff_write_file(io_tiff_file *file, const char *temporary, const char *mode, const char *path, io_error *error);
/* -1 when something could not be written; file->message then says why. */
int io_tiff_close_file(io_tiff_file *file);

/* ---- the picture */

typedef enum io_tiff_kind { IO_TIFF_UINT, IO_TIFF_HALF, IO_TIFF_FLOAT, IO_TIFF_DOUBLE } io_tiff_kind;

typedef struct io_source {
    io_options options;
    io_coding coding;
    bool created; /* by io_create: there is no file it came from */
    uint32_t width, height;
    io_tiff_kind kind;
    uint16_t bits, samples, photometric, compression, predictor, subsampling[2];
    bool separate, tiled, big_tiff, big_endian;
    uint32_t block_width, block_height; /* of a strip or tile */
    int channels, colours;              /* decoded: 3 colours from the one sample of a palette */
    int alpha;                          /* its channel, -1: none */
    uint16_t extra[64];                 /* meaning of the samples after the colours */
    uint16_t *palette;                  /* 3 * 2^bits entries; NULL: none */
    int pages;                          /* after the first */
    bool all_pages;                     /* false: there are more, but damaged */
    bool sub_images, layers;            /* left out when written */
    uint64_t file_bytes;                /* of the file it came from */
    io_ifd kept;                        /* the tags that are carried over */
} io_source;

enum { IO_TIFF_MOST_SAMPLES = 64 };

const char *io_tiff_compression_name(uint16_t compression);
bool io_tiff_has_predictor(uint16_t compression);
int io_tiff_read(io_picture *picture, int part, const char *const *names, int name_count, io_error *error);
int io_tiff_write(const io_picture *picture, const char *temporary, const char *path, const io_options *options,
                  io_error *note, io_error *error);

#endif
