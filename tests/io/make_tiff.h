/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* TIFF files made by libtiff, which is thereby also the judge of what io/ writes. */
#ifndef TESTS_IO_MAKE_TIFF_H
#define TESTS_IO_MAKE_TIFF_H

#include <tiffio.h>

#include "damage.h"

typedef struct tiff_spec {
    int width, height, samples, bits, format;       /* format 0: unsigned */
    int photometric;                                /* -1: by samples */
    int extra;                                      /* of the last sample, -1: no such tag */
    int compression, predictor, planar, tile, rows; /* 0: none, none, contiguous, strips, all rows */
    const char *mode;                               /* NULL: "w" */
    const void *pixels;                             /* interleaved */
} tiff_spec;

size_t tiff_bytes(const tiff_spec *spec);
/* All tags that say how the samples lie in the file. */
void tiff_set_layout(TIFF *tiff, const tiff_spec *spec);
/* Writes spec->pixels as the samples of the current page. */
void tiff_put_samples(TIFF *tiff, const tiff_spec *spec);
/* A file of one page. */
void make_tiff(const char *path, const tiff_spec *spec);
/* The samples of the current page, to be freed, and how they lie in the file. */
unsigned char *tiff_samples(TIFF *tiff, tiff_spec *got);
/* Samples at random, to be freed; floats with their special values. */
void *tiff_random(const tiff_spec *spec, uint32_t seed);

/* A page with texts, a profile, private tags and an EXIF directory; and whether the current page has them. check_exif
 * leaves the EXIF directory as the current one. */
void write_rich_page(TIFF *tiff, const tiff_spec *spec);
void check_metadata(TIFF *tiff);
void check_exif(TIFF *tiff);

#endif
