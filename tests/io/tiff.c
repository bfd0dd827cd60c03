/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "make_tiff.h"

/* Writes a TIFF, sends it through io and compares all samples and how they lie in the file. */
static const char *assert_round_trip(const tiff_spec *s, io_meaning meaning) {
    const char *input = in_folder("in.tif"), *output = in_folder("out.tif");
    tiff_spec got;
    make_tiff(input, s);
    const char *note = rewrite(input, output, meaning);
    TIFF *tiff = TIFFOpen(output, "rc");
    assert_non_null(tiff);
    unsigned char *pixels = tiff_samples(tiff, &got);
    assert_int_equal(TIFFIsBigEndian(tiff), s->mode && strchr(s->mode, 'b') != NULL);
    TIFFClose(tiff);
    assert_int_equal(got.width, s->width);
    assert_int_equal(got.samples, s->samples);
    assert_int_equal(got.bits, s->bits);
    assert_int_equal(got.format, s->format ? s->format : SAMPLEFORMAT_UINT);
    assert_int_equal(got.extra, s->extra);
    assert_int_equal(got.compression, s->compression ? s->compression : COMPRESSION_NONE);
    assert_int_equal(got.predictor, s->predictor ? s->predictor : PREDICTOR_NONE);
    assert_int_equal(got.planar, s->planar ? s->planar : PLANARCONFIG_CONTIG);
    assert_int_equal(got.tile, s->tile);
    assert_int_equal(got.rows, s->rows);
    for (size_t i = 0; i < tiff_bytes(s); i++)
        if (pixels[i] != ((const unsigned char *)s->pixels)[i])
            fail_msg("byte %zu of %zu differs (%d samples of %d bits, format %d)", i, tiff_bytes(s), s->samples,
                     s->bits, s->format);
    free(pixels);
    return note;
}

/* Random samples; floats with their special values. Alpha 0 hides no colour. */ static double
linear_of(double encoded) {
    return encoded <= 0.04045 ? encoded / 12.92 : pow((encoded + 0.055) / 1.055, 2.4);
}

/* ------------------------------------------------------------------------- samples and layouts */

static void test_layouts(void **state) {
    (void)state;
    static const struct {
        int bits, format;
    } kinds[] = {{8, 0}, {16, 0}, {16, SAMPLEFORMAT_IEEEFP}, {32, SAMPLEFORMAT_IEEEFP}};
    static const struct {
        int planar, tile, rows;
        const char *mode;
    } layouts[] = {{1, 0, 0, "w"}, {1, 0, 5, "wb"}, {1, 16, 0, "w8"}, {2, 0, 7, "wl"}, {2, 32, 0, "wb8"}};
    for (size_t k = 0; k < 4; k++)
        for (size_t l = 0; l < 5; l++)
            for (int samples = 1; samples <= 4; samples++) {
                tiff_spec s = {.width = 37,
                               .height = 23,
                               .samples = samples,
                               .bits = kinds[k].bits,
                               .format = kinds[k].format,
                               .photometric = -1,
                               .extra = samples % 2 ? -1 : EXTRASAMPLE_UNSPECIFIED,
                               .planar = samples > 1 ? layouts[l].planar : 1,
                               .tile = layouts[l].tile,
                               .rows = layouts[l].rows,
                               .mode = layouts[l].mode};
                void *pixels = tiff_random(&s, (uint32_t)(k * 100 + l));
                s.pixels = pixels;
                assert_string_equal(assert_round_trip(&s, IO_COLOR), "");
                assert_string_equal(assert_round_trip(&s, IO_DATA), "");
                free(pixels);
            }
}

static void test_compressions(void **state) {
    (void)state;
    static const int codes[] = {COMPRESSION_LZW,  COMPRESSION_PACKBITS, COMPRESSION_ADOBE_DEFLATE, COMPRESSION_DEFLATE,
                                COMPRESSION_LZMA, COMPRESSION_ZSTD,     COMPRESSION_LERC,          COMPRESSION_WEBP};
    int tried = 0;
    for (size_t c = 0; c < sizeof codes / sizeof codes[0]; c++)
        for (int bits = 8; bits <= 32; bits *= 2)
            for (int predictor = 0; predictor <= 3; predictor++) {
                const bool predicts = codes[c] == COMPRESSION_LZW || codes[c] == COMPRESSION_ADOBE_DEFLATE ||
                                      codes[c] == COMPRESSION_ZSTD;
                tiff_spec s = {.width = 37,
                               .height = 23,
                               .samples = 3,
                               .bits = bits,
                               .photometric = -1,
                               .extra = -1,
                               .rows = 9,
                               .format = bits == 32 || predictor == 3 ? SAMPLEFORMAT_IEEEFP : 0,
                               .compression = codes[c],
                               .predictor = predictor};
                if (!TIFFIsCODECConfigured((uint16_t)codes[c]) || predictor == 1 || (predictor && !predicts) ||
                    (predictor == 3 && bits == 8) || (codes[c] == COMPRESSION_WEBP && bits > 8))
                    continue;
                if (codes[c] == COMPRESSION_WEBP) continue; /* lossy by default: test_lossy */
                void *pixels = tiff_random(&s, (uint32_t)c);
                s.pixels = pixels;
                assert_string_equal(assert_round_trip(&s, IO_COLOR), "");
                free(pixels);
                tried++;
            }
    assert_true(tried > 10);
}

static void test_lossy(void **state) {
    (void)state;
    static const int codes[] = {COMPRESSION_JPEG, COMPRESSION_WEBP};
    for (int i = 0; i < 2; i++) {
        static unsigned char pixels[64 * 48 * 3];
        for (int k = 0; k < 64 * 48; k++)
            for (int c = 0; c < 3; c++)
                pixels[3 * k + c] = (unsigned char)(k % 64 * (c + 1) + k / 64);
        const tiff_spec s = {.width = 64,
                             .height = 48,
                             .samples = 3,
                             .bits = 8,
                             .photometric = -1,
                             .extra = -1,
                             .rows = 16,
                             .compression = codes[i],
                             .pixels = pixels};
        if (!TIFFIsCODECConfigured((uint16_t)codes[i])) continue;
        make_tiff(in_folder("in.tif"), &s);
        const char *note = rewrite(in_folder("in.tif"), in_folder("out.tif"), IO_DATA);
        assert_int_equal(strstr(note, "JPEG again") != NULL, codes[i] == COMPRESSION_JPEG);
        io_picture *before = read_picture(in_folder("in.tif")), *after = read_picture(in_folder("out.tif"));
        assert_string_equal(after->part[0].compression, before->part[0].compression);
        const float *a = values_of(before, "G"), *b = values_of(after, "G");
        for (int k = 0; k < 64 * 48; k++)
            assert_float_equal(a[k], b[k], codes[i] == COMPRESSION_JPEG ? 0.05 : 0);
        io_close(&before);
        io_close(&after);
    }
}

static void test_ycbcr(void **state) {
    (void)state;
    static unsigned char pixels[64 * 64 * 3];
    memset(pixels, 100, sizeof pixels);
    TIFF *tiff = TIFFOpen(in_folder("in.tif"), "w");
    const tiff_spec s = {.width = 64,
                         .height = 64,
                         .samples = 3,
                         .bits = 8,
                         .photometric = PHOTOMETRIC_YCBCR,
                         .extra = -1,
                         .rows = 32,
                         .compression = COMPRESSION_JPEG,
                         .pixels = pixels};
    if (!TIFFIsCODECConfigured(COMPRESSION_JPEG)) {
        TIFFClose(tiff);
        skip();
    }
    tiff_set_layout(tiff, &s);
    TIFFSetField(tiff, TIFFTAG_YCBCRSUBSAMPLING, 2, 2);
    TIFFSetField(tiff, TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB);
    tiff_put_samples(tiff, &s);
    TIFFClose(tiff);
    rewrite(in_folder("in.tif"), in_folder("out.tif"), IO_COLOR);
    io_picture *picture = read_picture(in_folder("out.tif"));
    assert_float_equal(values_of(picture, "B")[64 * 63 + 63], linear_of(100 / 255.0), 0.005);
    io_close(&picture);
    uint16_t photometric = 0, x = 0, y = 0;
    tiff = TIFFOpen(in_folder("out.tif"), "rc");
    TIFFGetField(tiff, TIFFTAG_PHOTOMETRIC, &photometric);
    TIFFGetField(tiff, TIFFTAG_YCBCRSUBSAMPLING, &x, &y);
    TIFFClose(tiff);
    assert_true(photometric == PHOTOMETRIC_YCBCR && x == 2 && y == 2);
}

static void test_all_16_bit_values(void **state) {
    (void)state;
    uint16_t *pixels = malloc(65536 * sizeof *pixels);
    assert_non_null(pixels);
    for (int i = 0; i < 65536; i++)
        pixels[i] = (uint16_t)i;
    tiff_spec s = {.width = 256,
                   .height = 256,
                   .samples = 1,
                   .bits = 16,
                   .photometric = PHOTOMETRIC_MINISBLACK,
                   .extra = -1,
                   .pixels = pixels};
    for (int inverted = 0; inverted < 2; inverted++) {
        s.photometric = inverted ? PHOTOMETRIC_MINISWHITE : PHOTOMETRIC_MINISBLACK;
        assert_round_trip(&s, IO_COLOR);
        assert_round_trip(&s, IO_DATA);
        io_picture *picture = read_picture(in_folder("in.tif"));
        const float *y = values_of(picture, "Y");
        for (int i = 0; i < 65536; i++)
            assert_float_equal(y[i], linear_of((inverted ? 65535 - i : i) / 65535.0), 3e-7);
        io_close(&picture);
    }
    free(pixels);
}

static void test_32_bit_integers(void **state) {
    (void)state;
    tiff_spec s = {.width = 50, .height = 20, .samples = 1, .bits = 32, .photometric = -1, .extra = -1}, got;
    uint32_t *pixels = tiff_random(&s, 4);
    pixels[0] = 0;
    pixels[1] = UINT32_MAX;
    pixels[2] = UINT32_MAX / 2;
    s.pixels = pixels;
    make_tiff(in_folder("in.tif"), &s);
    assert_non_null(strstr(rewrite(in_folder("in.tif"), in_folder("out.tif"), IO_DATA), "24 bits"));
    io_picture *picture = read_picture(in_folder("in.tif"));
    assert_float_equal(values_of(picture, "Y")[2], linear_of(0.5), 3e-7);
    io_close(&picture);
    TIFF *tiff = TIFFOpen(in_folder("out.tif"), "rc");
    uint32_t *out = (uint32_t *)(void *)tiff_samples(tiff, &got);
    TIFFClose(tiff);
    assert_true(out[0] == 0 && out[1] == UINT32_MAX);
    for (int i = 0; i < 1000; i++)
        assert_true(fabs((double)out[i] - (double)pixels[i]) <= 256);
    free(out);
    free(pixels);
}

static void test_doubles(void **state) {
    (void)state;
    static const double pixels[] = {1, -2.5, 1e30, 0.1, 1e300, -0.0};
    tiff_spec got;
    make_tiff(in_folder("in.tif"), &(tiff_spec){.width = 3,
                                                .height = 2,
                                                .samples = 1,
                                                .bits = 64,
                                                .photometric = -1,
                                                .extra = -1,
                                                .format = SAMPLEFORMAT_IEEEFP,
                                                .pixels = pixels});
    assert_non_null(
        strstr(rewrite(in_folder("in.tif"), in_folder("out.tif"), IO_COLOR), "64-bit samples are written with 32"));
    TIFF *tiff = TIFFOpen(in_folder("out.tif"), "rc");
    float *out = (float *)(void *)tiff_samples(tiff, &got);
    TIFFClose(tiff);
    assert_true(got.bits == 32 && got.format == SAMPLEFORMAT_IEEEFP && isinf(out[4]));
    for (int i = 0; i < 4; i++)
        assert_true(out[i] == (float)pixels[i]);
    free(out);
}

/* Cameras and microscopes write 10, 12 and 14 bits; the samples are packed. */
static void test_odd_bits(void **state) {
    (void)state;
    static const int sizes[] = {1, 2, 4, 6, 10, 12, 14};
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        enum { WIDTH = 13, HEIGHT = 3 };
        const int bits = sizes[i], maximum = (1 << bits) - 1, row = (WIDTH * bits + 7) / 8;
        unsigned char packed[HEIGHT * 32] = {0};
        for (int k = 0; k < WIDTH * HEIGHT; k++)
            for (int b = 0, value = k * 331 & maximum; b < bits; b++) {
                const int at = k % WIDTH * bits + b;
                packed[k / WIDTH * row + at / 8] |= (unsigned char)((value >> (bits - 1 - b) & 1) << (7 - at % 8));
            }
        const tiff_spec s = {
            .width = WIDTH, .height = HEIGHT, .samples = 1, .bits = bits, .photometric = -1, .extra = -1};
        TIFF *tiff = TIFFOpen(in_folder("in.tif"), "w");
        tiff_set_layout(tiff, &s);
        assert_int_equal(TIFFWriteEncodedStrip(tiff, 0, packed, row * HEIGHT), row * HEIGHT);
        TIFFClose(tiff);
        assert_non_null(strstr(rewrite(in_folder("in.tif"), in_folder("out.tif"), IO_DATA),
                               bits < 8 ? "with 8 bits" : "with 16 bits"));
        io_error error = {""};
        io_picture *picture;
        assert_int_equal(io_open(&picture, in_folder("in.tif"), IO_DATA, NULL, &error), 0);
        assert_int_equal(io_read(picture, &error), 0);
        for (int k = 0; k < WIDTH * HEIGHT; k++)
            assert_float_equal(values_of(picture, "Y")[k], (k * 331 & maximum) / (double)maximum, 1e-7);
        io_close(&picture);
    }
}

static void test_palette(void **state) {
    (void)state;
    static const unsigned char indices[] = {0, 1, 2, 3, 3, 2, 1, 0};
    /* 16-bit entries; 8-bit ones in the upper byte; 8-bit ones in the lower byte */
    for (int style = 0; style < 3; style++) {
        uint16_t map[3][256] = {{0}};
        tiff_spec s = {.width = 4,
                       .height = 2,
                       .samples = 1,
                       .bits = 8,
                       .photometric = PHOTOMETRIC_PALETTE,
                       .extra = -1,
                       .pixels = indices},
                  got;
        for (int c = 0; c < 3; c++)
            for (int i = 0; i < 4; i++)
                map[c][i] = (uint16_t)((50 * i + c) * (style == 0 ? 257 : style == 1 ? 256 : 1));
        TIFF *tiff = TIFFOpen(in_folder("in.tif"), "w");
        tiff_set_layout(tiff, &s);
        TIFFSetField(tiff, TIFFTAG_COLORMAP, map[0], map[1], map[2]);
        tiff_put_samples(tiff, &s);
        TIFFClose(tiff);
        assert_non_null(strstr(rewrite(in_folder("in.tif"), in_folder("out.tif"), IO_COLOR), "palette"));
        tiff = TIFFOpen(in_folder("out.tif"), "rc");
        unsigned char *out = tiff_samples(tiff, &got);
        TIFFClose(tiff);
        assert_true(got.samples == 3 && got.bits == 8 && got.photometric == PHOTOMETRIC_RGB);
        for (int i = 0; i < 24; i++)
            assert_int_equal(out[i], 50 * indices[i / 3] + i % 3);
        free(out);
    }
}

static void test_orientation_is_left_alone(void **state) {
    (void)state;
    static const float pixels[] = {1, 2, 3, 4, 5, 6};
    const tiff_spec s = {.width = 3,
                         .height = 2,
                         .samples = 1,
                         .bits = 32,
                         .format = SAMPLEFORMAT_IEEEFP,
                         .photometric = -1,
                         .extra = -1,
                         .pixels = pixels};
    TIFF *tiff = TIFFOpen(in_folder("in.tif"), "w");
    tiff_set_layout(tiff, &s);
    TIFFSetField(tiff, TIFFTAG_ORIENTATION, ORIENTATION_BOTRIGHT);
    tiff_put_samples(tiff, &s);
    TIFFClose(tiff);
    io_picture *picture = read_picture(in_folder("in.tif"));
    assert_memory_equal(values_of(picture, "Y"), pixels, sizeof pixels);
    io_close(&picture);
    rewrite(in_folder("in.tif"), in_folder("out.tif"), IO_COLOR);
    uint16_t orientation = 0;
    tiff = TIFFOpen(in_folder("out.tif"), "rc");
    TIFFGetField(tiff, TIFFTAG_ORIENTATION, &orientation);
    TIFFClose(tiff);
    assert_int_equal(orientation, ORIENTATION_BOTRIGHT);
}

/* ------------------------------------------------------------------------- alpha */

static void test_alpha(void **state) {
    (void)state;
    static const int extras[] = {EXTRASAMPLE_ASSOCALPHA, EXTRASAMPLE_UNASSALPHA};
    for (int e = 0; e < 2; e++) {
        unsigned char *pixels = malloc(2 * 65536);
        assert_non_null(pixels);
        for (int i = 0; i < 65536; i++) {
            pixels[2 * i + 1] = (unsigned char)(i >> 8);
            pixels[2 * i] = (unsigned char)i; /* for associated alpha also more light than alpha allows */
            if (e == 1 && i >> 8 == 0) pixels[2 * i] = 0;
        }
        const tiff_spec s = {.width = 256,
                             .height = 256,
                             .samples = 2,
                             .bits = 8,
                             .photometric = -1,
                             .extra = extras[e],
                             .pixels = pixels};
        assert_string_equal(assert_round_trip(&s, IO_COLOR), "");
        assert_string_equal(assert_round_trip(&s, IO_DATA), "");
        io_picture *picture = read_picture(in_folder("in.tif"));
        const float *y = values_of(picture, "Y"), *a = values_of(picture, "A");
        const int at = 200 * 256 + 100; /* grey 100, alpha 200 */
        assert_float_equal(a[at], 200 / 255.0, 1e-7);
        assert_float_equal(y[at], linear_of(e ? 100 / 255.0 : 0.5) * 200 / 255.0, 2e-7);
        io_close(&picture);
        free(pixels);
    }
    /* Float: associated numbers are left alone to the bit, others multiplied and divided. */
    static const float numbers[] = {8, 4, 2, 0.5f, -1, 1e-30f, 7, 1, 0.5f, 0.25f, 3, 0};
    tiff_spec s = {.width = 3,
                   .height = 1,
                   .samples = 4,
                   .bits = 32,
                   .format = SAMPLEFORMAT_IEEEFP,
                   .photometric = -1,
                   .extra = EXTRASAMPLE_ASSOCALPHA,
                   .pixels = numbers};
    assert_round_trip(&s, IO_COLOR);
    s.extra = EXTRASAMPLE_UNASSALPHA;
    make_tiff(in_folder("in.tif"), &s);
    io_picture *picture = read_picture(in_folder("in.tif"));
    const float *r = values_of(picture, "R");
    assert_true(r[0] == 4 && r[1] == -1 && r[2] == 0);
    io_close(&picture);
    rewrite(in_folder("in.tif"), in_folder("out.tif"), IO_COLOR);
    picture = read_picture(in_folder("out.tif"));
    assert_true(values_of(picture, "R")[0] == 4);
    io_close(&picture);
}

static void test_further_samples(void **state) {
    (void)state;
    tiff_spec s = {.width = 9, .height = 5, .samples = 6, .bits = 16, .photometric = PHOTOMETRIC_RGB, .extra = -1};
    void *pixels = tiff_random(&s, 11);
    s.pixels = pixels;
    TIFF *tiff = TIFFOpen(in_folder("in.tif"), "w");
    tiff_set_layout(tiff, &s);
    TIFFSetField(tiff, TIFFTAG_EXTRASAMPLES, 3, (const uint16_t[]){0, EXTRASAMPLE_ASSOCALPHA, 0});
    tiff_put_samples(tiff, &s);
    TIFFClose(tiff);
    rewrite(in_folder("in.tif"), in_folder("out.tif"), IO_COLOR);
    io_picture *picture = read_picture(in_folder("out.tif"));
    static const char *const names[] = {"R", "G", "B", "extra1", "A", "extra3"};
    for (int c = 0; c < 6; c++)
        assert_string_equal(picture->part[0].channel[c].name, names[c]);
    assert_float_equal(values_of(picture, "extra1")[7], ((uint16_t *)pixels)[7 * 6 + 3] / 65535.0, 1e-7);
    io_close(&picture);
    tiff_spec got;
    tiff = TIFFOpen(in_folder("out.tif"), "rc");
    unsigned char *out = tiff_samples(tiff, &got);
    TIFFClose(tiff);
    assert_memory_equal(out, pixels, tiff_bytes(&s));
    free(out);
    free(pixels);
}
static void test_created(void **state) {
    (void)state;
    static const char *const names[] = {"R", "G", "B", "A"};
    static const struct {
        io_type type;
        int bits, format, extra, predictor;
    } cases[] = {{IO_FLOAT, 8, 1, EXTRASAMPLE_UNASSALPHA, 2},
                 {IO_FLOAT, 16, 1, EXTRASAMPLE_UNASSALPHA, 2},
                 {IO_HALF, 16, 3, EXTRASAMPLE_ASSOCALPHA, 3},
                 {IO_HALF, 32, 3, EXTRASAMPLE_ASSOCALPHA, 3},
                 {IO_FLOAT, 32, 3, EXTRASAMPLE_ASSOCALPHA, 3}};
    const int width = 700, height = 300;
    float *values = malloc(sizeof *values * (size_t)(width * height));
    assert_non_null(values);
    for (int i = 0; i < width * height; i++)
        values[i] = (float)(i % 1024) / 2048;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        io_error error = {""};
        io_picture *picture;
        tiff_spec got;
        assert_int_equal(
            io_create(&picture, IO_TIFF, width, height, names, 4, cases[i].type, cases[i].bits, IO_COLOR, &error), 0);
        for (int c = 0; c < 4; c++)
            io_channel_from_float(channel_of(picture, 0, names[c]), values, 1, (size_t)width);
        write_picture(picture, in_folder("out.tif"), NULL);
        io_close(&picture);
        TIFF *tiff = TIFFOpen(in_folder("out.tif"), "rc");
        free(tiff_samples(tiff, &got));
        TIFFClose(tiff);
        assert_true(got.bits == cases[i].bits && got.format == cases[i].format && got.extra == cases[i].extra);
        assert_true(got.compression == COMPRESSION_ADOBE_DEFLATE && got.predictor == cases[i].predictor);
        picture = read_picture(in_folder("out.tif"));
        const float *r = values_of(picture, "R");
        for (int k = 0; k < width * height; k++)
            assert_float_equal(r[k], values[k], cases[i].format == 3 ? 0 : cases[i].bits == 16 ? 1e-5 : 3e-3);
        io_close(&picture);
        assert_int_equal(io_create(&picture, IO_TIFF, 3, 3, names, 4, IO_UINT, 32, IO_COLOR, &error), -1);
        assert_int_equal(io_create(&picture, IO_TIFF, 3, 3, names, 4, IO_FLOAT, 12, IO_COLOR, &error), -1);
    }
    free(values);
}
int main(void) {
    TIFFSetWarningHandler(NULL); /* of the files this test reads with libtiff itself */
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_layouts),
        cmocka_unit_test(test_compressions),
        cmocka_unit_test(test_lossy),
        cmocka_unit_test(test_ycbcr),
        cmocka_unit_test(test_all_16_bit_values),
        cmocka_unit_test(test_32_bit_integers),
        cmocka_unit_test(test_doubles),
        cmocka_unit_test(test_odd_bits),
        cmocka_unit_test(test_palette),
        cmocka_unit_test(test_orientation_is_left_alone),
        cmocka_unit_test(test_alpha),
        cmocka_unit_test(test_further_samples),
        cmocka_unit_test(test_created),
    };
    return cmocka_run_group_tests_name("tiff", tests, make_folder, remove_folder);
}
