/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* HEIC, AVIF and JPEG XL: read through libraries that a build may lack. Without them the files are still known for what
 * they are, so that the message can say what to do. They are read only. */
#include <string.h>

#include "heif.h"
#include "jxl.h"

/* ISO/IEC 14496-12: a file begins with its "ftyp" box, whose major brand or a compatible one says what is in it. */
static bool matches_heif(const unsigned char *head, size_t size) {
    static const char *const brands[] = {"heic", "heix", "heim", "heis", "hevc", "hevx", "mif1", "mif2", "msf1", "avif", "avis"};
    if (size < 12 || memcmp(head + 4, "ftyp", 4) != 0) return false;
    for (size_t at = 8; at + 4 <= size; at += at == 8 ? 8 : 4) /* after the major brand its version */
        for (size_t i = 0; i < sizeof brands / sizeof *brands; i++)
            if (memcmp(head + at, brands[i], 4) == 0) return true;
    return false;
}

/* ISO/IEC 18181-2: a bare codestream, or boxes. */
static bool matches_jxl(const unsigned char *head, size_t size) {
    static const unsigned char container[12] = {0, 0, 0, 12, 'J', 'X', 'L', ' ', '\r', '\n', 0x87, '\n'};
    return (size >= 2 && head[0] == 0xff && head[1] == 0x0a) ||
           (size >= sizeof container && memcmp(head, container, sizeof container) == 0);
}

#ifndef IO_HAVE_HEIF
int io_heif_open(io_picture *picture, io_meaning meaning, const io_options *options, io_error *error) {
    (void)meaning;
    (void)options;
    return io_fail(error, "%s: is HEIC or AVIF, and this ddof was built without libheif; convert the picture, or build with libheif",
                   picture->path);
}

int io_heif_read(io_picture *picture, int part, const char *const *names, int name_count, io_error *error) {
    (void)part;
    (void)names;
    (void)name_count;
    return io_heif_open(picture, IO_COLOR, NULL, error);
}

void io_heif_close(io_picture *picture) {
    (void)picture;
}
#endif

#ifndef IO_HAVE_JXL
int io_jxl_open(io_picture *picture, io_meaning meaning, const io_options *options, io_error *error) {
    (void)meaning;
    (void)options;
    return io_fail(error, "%s: is JPEG XL, and this ddof was built without libjxl; convert the picture, or build with libjxl",
                   picture->path);
}

int io_jxl_read(io_picture *picture, int part, const char *const *names, int name_count, io_error *error) {
    (void)part;
    (void)names;
    (void)name_count;
    return io_jxl_open(picture, IO_COLOR, NULL, error);
}

void io_jxl_close(io_picture *picture) {
    (void)picture;
}
#endif

const io_handler io_heif = {
    .format = IO_HEIF, .matches = matches_heif, .open = io_heif_open, .read = io_heif_read, .close = io_heif_close};

const io_handler io_jxl = {
    .format = IO_JXL, .matches = matches_jxl, .open = io_jxl_open, .read = io_jxl_read, .close = io_jxl_close};
