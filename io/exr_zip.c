/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "exr_zip.h"

#ifdef IO_HAVE_LIBDEFLATE

#include <stdlib.h>
#include <string.h>

#include <libdeflate.h>

const bool io_exr_has_zip = true;

struct io_exr_zip {
    struct libdeflate_compressor *compressor;
    struct libdeflate_decompressor *decompressor;
    unsigned char *a, *b; /* `room` bytes each */
    size_t room;
};

io_exr_zip *io_exr_zip_open(int level) {
    io_exr_zip *zip = calloc(1, sizeof *zip);
    if (!zip) return NULL;
    zip->compressor = libdeflate_alloc_compressor(level);
    zip->decompressor = libdeflate_alloc_decompressor();
    if (zip->compressor && zip->decompressor) return zip;
    io_exr_zip_close(zip);
    return NULL;
}

void io_exr_zip_close(io_exr_zip *zip) {
    if (!zip) return;
    libdeflate_free_compressor(zip->compressor);
    libdeflate_free_decompressor(zip->decompressor);
    free(zip->a);
    free(zip->b);
    free(zip);
}

bool io_exr_zip_reserve(io_exr_zip *zip, size_t size) {
    if (size <= zip->room) return true;
    free(zip->a);
    free(zip->b);
    zip->room = size;
    zip->a = malloc(size);
    zip->b = malloc(size);
    if (!zip->a || !zip->b) zip->room = 0;
    return zip->room != 0;
}

/* What EXR does to the bytes before deflate: those at even places first, then those at odd ones (the high bytes of
 * halves are alike), and each but the first replaced by 128 + its difference to the one before. 16 bytes at a time:
 * these loops would take half as long as libdeflate does. */

typedef unsigned char bytes16 __attribute__((vector_size(16)));

static bytes16 load(const unsigned char *from) {
    bytes16 value;
    memcpy(&value, from, sizeof value);
    return value;
}

static void store(unsigned char *to, bytes16 value) {
    memcpy(to, &value, sizeof value);
}

static void split(const unsigned char *in, unsigned char *even, unsigned char *odd, size_t size) {
    size_t i = 0;
    for (; i + 32 <= size; i += 32) {
        bytes16 a = load(in + i), b = load(in + i + 16);
        store(even + i / 2, __builtin_shufflevector(a, b, 0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30));
        store(odd + i / 2, __builtin_shufflevector(a, b, 1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 21, 23, 25, 27, 29, 31));
    }
    for (; i < size; i++)
        (i % 2 ? odd : even)[i / 2] = in[i];
}

static void join(const unsigned char *even, const unsigned char *odd, unsigned char *out, size_t size) {
    size_t i = 0;
    for (; i + 32 <= size; i += 32) {
        bytes16 a = load(even + i / 2), b = load(odd + i / 2);
        store(out + i, __builtin_shufflevector(a, b, 0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23));
        store(out + i + 16,
              __builtin_shufflevector(a, b, 8, 24, 9, 25, 10, 26, 11, 27, 12, 28, 13, 29, 14, 30, 15, 31));
    }
    for (; i < size; i++)
        out[i] = (i % 2 ? odd : even)[i / 2];
}

static void take_differences(const unsigned char *in, unsigned char *out, size_t size) {
    size_t i = 1;
    out[0] = in[0];
    for (; i + 16 <= size; i += 16)
        store(out + i, load(in + i) - load(in + i - 1) + 128);
    for (; i < size; i++)
        out[i] = (unsigned char)(in[i] - in[i - 1] + 128);
}

static void add_differences(unsigned char *data, size_t size) {
    bytes16 zero = {0}, last = {0};
    size_t i = 0;
    data[0] ^= 128; /* the first is no difference */
    for (; i + 16 <= size; i += 16) {
        bytes16 sum = load(data + i) - 128;
        sum += __builtin_shufflevector(sum, zero, 16, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14);
        sum += __builtin_shufflevector(sum, zero, 16, 17, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13);
        sum += __builtin_shufflevector(sum, zero, 16, 17, 18, 19, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11);
        sum += __builtin_shufflevector(sum, zero, 16, 17, 18, 19, 20, 21, 22, 23, 0, 1, 2, 3, 4, 5, 6, 7);
        sum += last;
        store(data + i, sum);
        last = zero + sum[15];
    }
    for (unsigned char before = last[15]; i < size; i++)
        data[i] = before = (unsigned char)(before + data[i] - 128);
}

bool io_exr_zip_unpack(io_exr_zip *zip, const unsigned char *packed, size_t packed_size, unsigned char *out,
                       size_t size) {
    size_t got = 0;
    if (size == 0 || !io_exr_zip_reserve(zip, size) ||
        libdeflate_zlib_decompress(zip->decompressor, packed, packed_size, zip->a, size, &got) != LIBDEFLATE_SUCCESS ||
        got != size)
        return false;
    add_differences(zip->a, size);
    join(zip->a, zip->a + (size + 1) / 2, out, size);
    return true;
}

const unsigned char *io_exr_zip_pack(io_exr_zip *zip, const unsigned char *in, size_t size, size_t *packed_size) {
    if (size == 0 || !io_exr_zip_reserve(zip, size)) return NULL;
    split(in, zip->a, zip->a + (size + 1) / 2, size);
    take_differences(zip->a, zip->b, size);
    *packed_size = libdeflate_zlib_compress(zip->compressor, zip->b, size, zip->a, size - 1);
    return *packed_size ? zip->a : NULL;
}

#else

const bool io_exr_has_zip = false;

io_exr_zip *io_exr_zip_open(int level) {
    (void)level;
    return NULL;
}

void io_exr_zip_close(io_exr_zip *zip) {
    (void)zip;
}

bool io_exr_zip_reserve(io_exr_zip *zip, size_t size) {
    (void)zip, (void)size;
    return false;
}

bool io_exr_zip_unpack(io_exr_zip *zip, const unsigned char *packed, size_t packed_size, unsigned char *out,
                       size_t size) {
    (void)zip, (void)packed, (void)packed_size, (void)out, (void)size;
    return false;
}

const unsigned char *io_exr_zip_pack(io_exr_zip *zip, const unsigned char *in, size_t size, size_t *packed_size) {
    (void)zip, (void)in, (void)size, (void)packed_size;
    return NULL;
}

#endif
