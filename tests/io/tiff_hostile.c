/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Damaged and malicious TIFF files, and disks that are full. */
#include <stdlib.h>
#include <string.h>

#include "make_tiff.h"

static void make_damaged(int compression, int tile, const char *mode) {
    tiff_spec s = {.width = 33,
                   .height = 21,
                   .samples = 3,
                   .bits = 8,
                   .photometric = -1,
                   .extra = -1,
                   .rows = tile ? 0 : 8,
                   .tile = tile,
                   .compression = compression};
    unsigned char *pixels = tiff_random(&s, 1);
    memset(pixels, 50, tiff_bytes(&s) / 2);
    s.pixels = pixels;
    TIFF *tiff = TIFFOpen(in_folder("in.tif"), mode);
    write_rich_page(tiff, &s);
    TIFFWriteDirectory(tiff);
    tiff_set_layout(tiff, &s);
    tiff_put_samples(tiff, &s);
    TIFFClose(tiff);
    free(pixels);
}

static void test_damage(void **state) {
    (void)state;
    static const int codes[] = {COMPRESSION_NONE, COMPRESSION_LZW,  COMPRESSION_PACKBITS, COMPRESSION_ADOBE_DEFLATE,
                                COMPRESSION_ZSTD, COMPRESSION_JPEG, COMPRESSION_LZMA};
    static const char *const modes[] = {"wl", "wb", "wl8"};
    for (size_t i = 0; i < sizeof codes / sizeof codes[0]; i++) {
        if (!TIFFIsCODECConfigured((uint16_t)codes[i])) continue;
        make_damaged(codes[i], i % 2 ? 16 : 0, modes[i % 3]);
        check_mutations(in_folder("in.tif"), 400, (uint32_t)i);
    }
}

/* libtiff puts the directory of a first page behind its pixels, so that a file that ends early has none; the pixels
 * come last where another page follows. */
static void test_truncation(void **state) {
    (void)state;
    tiff_spec s = {.width = 21,
                   .height = 17,
                   .samples = 3,
                   .bits = 16,
                   .photometric = -1,
                   .extra = -1,
                   .rows = 4,
                   .compression = COMPRESSION_ADOBE_DEFLATE};
    void *pixels = tiff_random(&s, 1);
    s.pixels = pixels;
    make_tiff(in_folder("in.tif"), &s);
    check_truncation(in_folder("in.tif"), 0);
    free(pixels);
    /* The directory first: nothing but the pixels can be cut off. */
    static const unsigned char head[] = "II*\0\x08\0\0\0\x08\0"
                                        "\0\1\3\0\1\0\0\0\x10\0\0\0"   /* 16 x 16 pixels */
                                        "\1\1\3\0\1\0\0\0\x10\0\0\0"   /* */
                                        "\2\1\3\0\1\0\0\0\x08\0\0\0"   /* of 8 bits */
                                        "\6\1\3\0\1\0\0\0\1\0\0\0"     /* 0 is black */
                                        "\x11\1\4\0\1\0\0\0\x70\0\0\0" /* strip at 112 */
                                        "\x15\1\3\0\1\0\0\0\1\0\0\0"   /* of 1 sample */
                                        "\x16\1\3\0\1\0\0\0\x10\0\0\0" /* 16 rows */
                                        "\x17\1\4\0\1\0\0\0\0\1\0\0"   /* 256 bytes */
                                        "\0\0\0\0\0\0";
    unsigned char file[112 + 256] = {0};
    memcpy(file, head, sizeof head - 1);
    write_file(in_folder("in.tif"), file, sizeof file);
    check_truncation(in_folder("in.tif"), 0);
    write_file(in_folder("in.tif"), file, sizeof file - 1);
    assert_refused(in_folder("in.tif"), "rows 0 to 15 are damaged or cut off");
}

static void put16(unsigned char *p, unsigned v) {
    p[0] = (unsigned char)v;
    p[1] = (unsigned char)(v >> 8);
}

/* A bare little-endian TIFF: entries of SHORT or LONG with one value, then 64 bytes of pixels at 200. */
static void make_bare(const char *path, const uint32_t (*tags)[2], int count) {
    unsigned char file[264] = "II*\0\x08\0\0\0";
    put16(file + 8, (unsigned)count);
    for (int i = 0; i < count; i++) {
        unsigned char *p = file + 10 + 12 * i;
        put16(p, tags[i][0]);
        put16(p + 2, 4);
        put16(p + 4, 1);
        put16(p + 8, tags[i][1] & 0xffff);
        put16(p + 10, tags[i][1] >> 16);
    }
    write_file(path, file, sizeof file);
}

static void test_hostile_headers(void **state) {
    (void)state;
    static const struct {
        uint32_t tag, value;
        const char *words;
    } cases[] = {
        {256, 100000, "more than"},
        {256, 2000000, "too large"},
        {256, 0xffffffff, "too large"},
        {256, 0, "TIFF"},
        {257, 0xffffffff, "header"},
        {258, 7, NULL},
        {258, 24, "24-bit"},
        {258, 0, NULL},
        {259, 99, "unknown compression"},
        {259, 6, "JPEG"},
        {262, 5, "CMYK"},
        {262, 8, "L*a*b*"},
        {262, 6, NULL},
        {262, 3, NULL},
        {262, 32803, "special"},
        {273, 0xffffff00, "rows 0 to 7"},
        {277, 0, NULL},
        {277, 65535, NULL},
        {278, 0, NULL},
        {279, 3, NULL},
        {339, 2, "signed"},
        {339, 3, "8-bit float"},
        {339, 5, "complex"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        uint32_t tags[][2] = {{256, 8},   {257, 8}, {258, 8}, {259, 1},  {262, 1},
                              {273, 200}, {277, 1}, {278, 8}, {279, 64}, {339, 1}};
        io_error error;
        make_bare(in_folder("in.tif"), (const uint32_t(*)[2])tags, 10);
        if (!reads(in_folder("in.tif"), &error)) fail_msg("%s", error.text);
        for (int t = 0; t < 10; t++)
            if (tags[t][0] == cases[i].tag) tags[t][1] = cases[i].value;
        make_bare(in_folder("in.tif"), (const uint32_t(*)[2])tags, 10);
        if (cases[i].words)
            assert_refused(in_folder("in.tif"), cases[i].words);
        else
            reads(in_folder("in.tif"), &error);
    }
}

static void test_rings(void **state) {
    (void)state;
    const uint32_t tags[][2] = {{256, 8},   {257, 8}, {258, 8}, {259, 1},  {262, 1},
                                {273, 200}, {277, 1}, {278, 8}, {279, 64}, {34665, 8}};
    size_t size;
    make_bare(in_folder("in.tif"), tags, 10); /* its EXIF directory is the picture itself */
    unsigned char *bytes = read_file(in_folder("in.tif"), &size);
    bytes[10 + 12 * 10] = 8; /* and so is its next page */
    write_file(in_folder("in.tif"), bytes, size);
    free(bytes);
    const char *note = rewrite(in_folder("in.tif"), in_folder("out.tif"), IO_COLOR);
    assert_non_null(strstr(note, "damaged tags are left out"));
    assert_non_null(strstr(note, "ends after 1"));
}

static void test_full_disk(void **state) {
    (void)state;
    static const int codes[] = {COMPRESSION_NONE, COMPRESSION_ADOBE_DEFLATE};
    for (int i = 0; i < 2; i++) {
        tiff_spec s = {.width = 200,
                       .height = 200,
                       .samples = 1,
                       .bits = 8,
                       .photometric = -1,
                       .extra = -1,
                       .rows = 50,
                       .compression = codes[i]};
        void *pixels = tiff_random(&s, 1);
        s.pixels = pixels;
        TIFF *tiff = TIFFOpen(in_folder("in.tif"), "w");
        write_rich_page(tiff, &s);
        TIFFClose(tiff);
        static const size_t limits[] = {4,     20000, 39000,
                                        40100, 41000, 43500}; /* header, pixels, libtiff's tags, ours */
        for (size_t k = 0; k < sizeof limits / sizeof limits[0]; k++)
            check_full_disk(in_folder("in.tif"), in_folder("out.tif"), limits[k]);
        free(pixels);
    }
}
int main(void) {
    TIFFSetWarningHandler(NULL); /* of the files this test reads with libtiff itself */
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_damage), cmocka_unit_test(test_truncation), cmocka_unit_test(test_hostile_headers),
        cmocka_unit_test(test_rings),  cmocka_unit_test(test_full_disk),
    };
    return cmocka_run_group_tests_name("tiff hostile", tests, make_folder, remove_folder);
}
