/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "make_tiff.h"

static size_t pixel_bytes(const tiff_spec *s) {
    return (size_t)s->samples * (size_t)s->bits / 8;
}
size_t tiff_bytes(const tiff_spec *s) {
    return pixel_bytes(s) * (size_t)s->width * (size_t)s->height;
}

void tiff_set_layout(TIFF *tiff, const tiff_spec *s) {
    uint16_t extra = (uint16_t)s->extra;
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, (uint32_t)s->width);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, (uint32_t)s->height);
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, s->samples);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, s->bits);
    TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, s->format ? s->format : SAMPLEFORMAT_UINT);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, s->photometric >= 0 ? s->photometric : s->samples >= 3 ? 2 : 1);
    TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, s->planar ? s->planar : PLANARCONFIG_CONTIG);
    TIFFSetField(tiff, TIFFTAG_COMPRESSION, s->compression ? s->compression : COMPRESSION_NONE);
    if (s->extra >= 0) TIFFSetField(tiff, TIFFTAG_EXTRASAMPLES, 1, &extra);
    if (s->predictor) TIFFSetField(tiff, TIFFTAG_PREDICTOR, s->predictor);
    if (s->tile) {
        TIFFSetField(tiff, TIFFTAG_TILEWIDTH, (uint32_t)s->tile);
        TIFFSetField(tiff, TIFFTAG_TILELENGTH, (uint32_t)s->tile);
    } else {
        TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, (uint32_t)(s->rows ? s->rows : s->height));
    }
}

/* Copies a rectangle of samples between the interleaved picture and a block of the file. */
static void move(const tiff_spec *s, unsigned char *block, int x0, int y0, int block_width, int rows, int plane,
                 bool out) {
    const size_t sample = (size_t)s->bits / 8, count = s->planar == PLANARCONFIG_SEPARATE ? 1 : (size_t)s->samples;
    for (int y = 0; y < rows && y0 + y < s->height; y++)
        for (int x = 0; x < block_width && x0 + x < s->width; x++) {
            unsigned char *picture = (unsigned char *)(uintptr_t)s->pixels +
                                     ((size_t)(y0 + y) * (size_t)s->width + (size_t)(x0 + x)) * pixel_bytes(s) +
                                     (count == 1 ? (size_t)plane * sample : 0);
            unsigned char *in_block = block + ((size_t)y * (size_t)block_width + (size_t)x) * count * sample;
            memcpy(out ? picture : in_block, out ? in_block : picture, count * sample);
        }
}

static void move_all(TIFF *tiff, const tiff_spec *s, bool out) {
    const int width = s->tile ? s->tile : s->width, rows = s->tile ? s->tile : s->rows ? s->rows : s->height;
    unsigned char *block = calloc((size_t)rows, (size_t)width * pixel_bytes(s));
    assert_non_null(block);
    for (int plane = 0; plane < (s->planar == PLANARCONFIG_SEPARATE ? s->samples : 1); plane++)
        for (int y = 0; y < s->height; y += rows)
            for (int x = 0; x < s->width; x += width) {
                const uint32_t index = s->tile ? TIFFComputeTile(tiff, (uint32_t)x, (uint32_t)y, 0, (uint16_t)plane)
                                               : TIFFComputeStrip(tiff, (uint32_t)y, (uint16_t)plane);
                const tmsize_t size =
                    s->tile ? TIFFTileSize(tiff)
                            : TIFFVStripSize(tiff, (uint32_t)(s->height - y < rows ? s->height - y : rows));
                if (out) {
                    assert_int_equal((s->tile ? TIFFReadEncodedTile : TIFFReadEncodedStrip)(tiff, index, block, size),
                                     size);
                    move(s, block, x, y, width, rows, plane, true);
                } else {
                    move(s, block, x, y, width, rows, plane, false);
                    assert_int_equal((s->tile ? TIFFWriteEncodedTile : TIFFWriteEncodedStrip)(tiff, index, block, size),
                                     size);
                }
            }
    free(block);
}

void tiff_put_samples(TIFF *tiff, const tiff_spec *s) {
    move_all(tiff, s, false);
}

void make_tiff(const char *path, const tiff_spec *s) {
    TIFF *tiff = TIFFOpen(path, s->mode ? s->mode : "w");
    assert_non_null(tiff);
    tiff_set_layout(tiff, s);
    tiff_put_samples(tiff, s);
    TIFFClose(tiff);
}

unsigned char *tiff_samples(TIFF *tiff, tiff_spec *got) {
    uint32_t width = 0, height = 0, rows = 0, tile = 0;
    uint16_t samples = 1, bits = 1, format = 1, photometric = 0, compression = 1, predictor = 1, planar = 1, extras = 0,
             *types = NULL;
    TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &width);
    TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &height);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLESPERPIXEL, &samples);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_BITSPERSAMPLE, &bits);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLEFORMAT, &format);
    TIFFGetField(tiff, TIFFTAG_PHOTOMETRIC, &photometric);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_COMPRESSION, &compression);
    if (compression == COMPRESSION_LZW || compression == COMPRESSION_ADOBE_DEFLATE || compression == COMPRESSION_ZSTD)
        TIFFGetFieldDefaulted(tiff, TIFFTAG_PREDICTOR, &predictor);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_PLANARCONFIG, &planar);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_ROWSPERSTRIP, &rows);
    TIFFGetField(tiff, TIFFTAG_TILEWIDTH, &tile);
    TIFFGetField(tiff, TIFFTAG_EXTRASAMPLES, &extras, &types);
    *got = (tiff_spec){.width = (int)width,
                       .height = (int)height,
                       .samples = samples,
                       .bits = bits,
                       .format = format,
                       .photometric = photometric,
                       .extra = extras ? types[0] : -1,
                       .compression = compression,
                       .predictor = predictor,
                       .planar = planar,
                       .tile = (int)tile,
                       .rows = rows < height ? (int)rows : 0};
    unsigned char *pixels = malloc(tiff_bytes(got));
    assert_non_null(pixels);
    got->pixels = pixels;
    move_all(tiff, got, true);
    return pixels;
}

/* Writes a TIFF, sends it through io and compares all samples and how they lie in the file. */ void *
tiff_random(const tiff_spec *s, uint32_t seed) {
    const size_t count = tiff_bytes(s) / ((size_t)s->bits / 8);
    unsigned char *pixels = malloc(tiff_bytes(s));
    assert_non_null(pixels);
    for (size_t i = 0; i < tiff_bytes(s); i++)
        pixels[i] = (unsigned char)next_random(&seed);
    if (s->format != SAMPLEFORMAT_IEEEFP) return pixels;
    for (size_t i = 0; i < count; i++) {
        static const float special[] = {0, -0.0f, 1e-40f, INFINITY, -INFINITY, 3e38f, -1};
        const float value =
            i < 7 ? special[i]
                  : ldexpf((float)(int)(next_random(&seed) % 65536 - 32768), (int)(next_random(&seed) % 40) - 30);
        if (s->bits == 32) {
            ((float *)pixels)[i] = value;
        } else { /* every half but signalling NaNs */
            uint16_t *half = (uint16_t *)pixels + i;
            *half = (*half & 0x7c00) == 0x7c00 ? (uint16_t)(*half & 0xfc00) : *half;
        }
    }
    return pixels;
}

/* ------------------------------------------------------------------------- metadata */

static const TIFFFieldInfo private_fields[] = {
    {65000, TIFF_VARIABLE2, TIFF_VARIABLE2, TIFF_LONG, FIELD_CUSTOM, 1, 1, (char[]){"PrivateLong"}},
    {65001, TIFF_VARIABLE2, TIFF_VARIABLE2, TIFF_UNDEFINED, FIELD_CUSTOM, 1, 1, (char[]){"PrivateBytes"}}};

static void set_metadata(TIFF *tiff) {
    static unsigned char profile[3001], xmp[] = "<x:xmpmeta/>";
    for (size_t i = 0; i < sizeof profile; i++)
        profile[i] = (unsigned char)(i * 7);
    TIFFMergeFieldInfo(tiff, private_fields, 2);
    TIFFSetField(tiff, TIFFTAG_IMAGEDESCRIPTION, "a picture");
    TIFFSetField(tiff, TIFFTAG_SOFTWARE, "some renderer");
    TIFFSetField(tiff, TIFFTAG_ARTIST, "somebody");
    TIFFSetField(tiff, TIFFTAG_COPYRIGHT, "nobody");
    TIFFSetField(tiff, TIFFTAG_DATETIME, "2026:01:02 03:04:05");
    TIFFSetField(tiff, TIFFTAG_XRESOLUTION, 300.0);
    TIFFSetField(tiff, TIFFTAG_YRESOLUTION, 150.25);
    TIFFSetField(tiff, TIFFTAG_RESOLUTIONUNIT, RESUNIT_CENTIMETER);
    TIFFSetField(tiff, TIFFTAG_ICCPROFILE, (uint32_t)sizeof profile, profile);
    TIFFSetField(tiff, TIFFTAG_XMLPACKET, (uint32_t)sizeof xmp, xmp);
    TIFFSetField(tiff, 65000, 3u, (const uint32_t[]){1, 2, 0x12345678});
    TIFFSetField(tiff, 65001, 5u, "bytes");
}

void check_metadata(TIFF *tiff) {
    const char *text = NULL;
    const unsigned char *bytes = NULL;
    const uint32_t *numbers = NULL;
    float x = 0, y = 0;
    uint16_t unit = 0;
    uint32_t count = 0;
    static const struct {
        uint32_t tag;
        const char *text;
    } texts[] = {{TIFFTAG_IMAGEDESCRIPTION, "a picture"},
                 {TIFFTAG_SOFTWARE, "some renderer"},
                 {TIFFTAG_ARTIST, "somebody"},
                 {TIFFTAG_COPYRIGHT, "nobody"},
                 {TIFFTAG_DATETIME, "2026:01:02 03:04:05"}};
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++) {
        assert_int_equal(TIFFGetField(tiff, texts[i].tag, &text), 1);
        assert_string_equal(text, texts[i].text);
    }
    TIFFGetField(tiff, TIFFTAG_XRESOLUTION, &x);
    TIFFGetField(tiff, TIFFTAG_YRESOLUTION, &y);
    TIFFGetField(tiff, TIFFTAG_RESOLUTIONUNIT, &unit);
    assert_true(x == 300 && y == 150.25f && unit == RESUNIT_CENTIMETER);
    assert_int_equal(TIFFGetField(tiff, TIFFTAG_ICCPROFILE, &count, &bytes), 1);
    assert_int_equal(count, 3001);
    for (uint32_t i = 0; i < count; i++)
        assert_int_equal(bytes[i], (unsigned char)(i * 7));
    assert_int_equal(TIFFGetField(tiff, TIFFTAG_XMLPACKET, &count, &bytes), 1);
    assert_memory_equal(bytes, "<x:xmpmeta/>", 12);
    assert_int_equal(TIFFGetField(tiff, 65000, &count, &numbers), 1);
    assert_true(count == 3 && numbers[2] == 0x12345678);
    assert_int_equal(TIFFGetField(tiff, 65001, &count, &bytes), 1);
    assert_true(count == 5 && memcmp(bytes, "bytes", 5) == 0);
}

void write_rich_page(TIFF *tiff, const tiff_spec *s) {
    uint64_t exif = 0;
    TIFFCreateEXIFDirectory(tiff);
    TIFFSetField(tiff, EXIFTAG_EXPOSURETIME, 1 / 250.0);
    TIFFSetField(tiff, EXIFTAG_DATETIMEORIGINAL, "2025:12:31 23:59:59");
    assert_int_equal(TIFFWriteCustomDirectory(tiff, &exif), 1);
    TIFFFreeDirectory(tiff);
    TIFFCreateDirectory(tiff);
    tiff_set_layout(tiff, s);
    set_metadata(tiff);
    TIFFSetField(tiff, TIFFTAG_EXIFIFD, exif);
    tiff_put_samples(tiff, s);
}

void check_exif(TIFF *tiff) {
    uint64_t exif = 0;
    const char *text = NULL;
    assert_int_equal(TIFFGetField(tiff, TIFFTAG_EXIFIFD, &exif), 1);
    assert_int_equal(TIFFReadEXIFDirectory(tiff, exif), 1);
    assert_int_equal(TIFFGetField(tiff, EXIFTAG_DATETIMEORIGINAL, &text), 1);
    assert_string_equal(text, "2025:12:31 23:59:59");
    const bool wide = TIFFFieldSetGetSize(TIFFFieldWithTag(tiff, EXIFTAG_EXPOSURETIME)) == sizeof(double);
    double seconds = 0;
    float short_seconds = 0;
    assert_int_equal(TIFFGetField(tiff, EXIFTAG_EXPOSURETIME, wide ? (void *)&seconds : (void *)&short_seconds), 1);
    assert_float_equal(wide ? seconds : (double)short_seconds, 1 / 250.0, 1e-9);
}
