/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* ZIP and ZIPS by libdeflate, two to three times as fast as by OpenEXRCore 3.1, which uses zlib. */
#ifndef IO_EXR_ZIP_H
#define IO_EXR_ZIP_H

#include <stdbool.h>
#include <stddef.h>

typedef struct io_exr_zip io_exr_zip; /* one per thread */

/* Whether this build has libdeflate. */
extern const bool io_exr_has_zip;

/* NULL: this build has no libdeflate, or out of memory. */
io_exr_zip *io_exr_zip_open(int level);
void io_exr_zip_close(io_exr_zip *zip);
/* Memory for chunks of that size: what wants it next cannot fail for lack of it. */
bool io_exr_zip_reserve(io_exr_zip *zip, size_t size);
/* Exactly `size` bytes into `out`; false when the data are damaged, or out of memory. */
bool io_exr_zip_unpack(io_exr_zip *zip, const unsigned char *packed, size_t packed_size, unsigned char *out,
                       size_t size);
/* Compressed bytes, the zip's own until its next call; NULL when they would not be fewer than `size`. */
const unsigned char *io_exr_zip_pack(io_exr_zip *zip, const unsigned char *in, size_t size, size_t *packed_size);

#endif
