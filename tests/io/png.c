/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <png.h>

#include "damage.h"

/* ------------------------------------------------------------------------- PNG files to order */

typedef struct chunk {
    const char *name;
    const void *data;
    size_t size;
    bool after_pixels;
} chunk;

typedef struct png_spec {
    int width, height, depth, type;
    bool interlaced;
    const unsigned char *pixels; /* rows as in the file */
    const png_color *palette;
    int colours;
    const unsigned char *opacity; /* tRNS of a palette */
    const png_color_16 *key;      /* tRNS of others */
    const chunk *chunks;
    int chunk_count;
} png_spec;

static size_t row_bytes(const png_spec *spec) {
    static const int samples[] = {[0] = 1, [2] = 3, [3] = 1, [4] = 2, [6] = 4};
    return ((size_t)spec->width * (size_t)(samples[spec->type] * spec->depth) + 7) / 8;
}

static void make_png(const char *path, const png_spec *spec) {
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
    png_infop info = png_create_info_struct(png);
    png_init_io(png, file);
    png_set_IHDR(png, info, (png_uint_32)spec->width, (png_uint_32)spec->height, spec->depth, spec->type,
                 spec->interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE, 0, 0);
    if (spec->palette) png_set_PLTE(png, info, spec->palette, spec->colours);
    if (spec->opacity || spec->key)
        png_set_tRNS(png, info, spec->opacity, spec->opacity ? spec->colours : 0, spec->key);
    png_write_info(png, info);
    for (int i = 0; i < spec->chunk_count; i++)
        if (!spec->chunks[i].after_pixels)
            png_write_chunk(png, (png_const_bytep)spec->chunks[i].name, spec->chunks[i].data, spec->chunks[i].size);
    for (int pass = png_set_interlace_handling(png); pass > 0; pass--)
        for (int y = 0; y < spec->height; y++)
            png_write_row(png, spec->pixels + (size_t)y * row_bytes(spec));
    for (int i = 0; i < spec->chunk_count; i++)
        if (spec->chunks[i].after_pixels)
            png_write_chunk(png, (png_const_bytep)spec->chunks[i].name, spec->chunks[i].data, spec->chunks[i].size);
    png_write_end(png, NULL);
    png_destroy_write_struct(&png, &info);
    assert_int_equal(fclose(file), 0);
}

static void ignore(png_structp png, png_const_charp text) {
    (void)png;
    (void)text;
}

/* The samples of a file, through libpng alone. */
static unsigned char *pixels_of(const char *path, png_spec *spec) {
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, ignore);
    png_infop info = png_create_info_struct(png);
    png_init_io(png, file);
    png_read_info(png, info);
    *spec = (png_spec){.width = (int)png_get_image_width(png, info),
                       .height = (int)png_get_image_height(png, info),
                       .depth = png_get_bit_depth(png, info),
                       .type = png_get_color_type(png, info),
                       .interlaced = png_get_interlace_type(png, info) != PNG_INTERLACE_NONE};
    unsigned char *pixels = calloc((size_t)spec->height, row_bytes(spec));
    assert_non_null(pixels);
    for (int pass = png_set_interlace_handling(png); pass > 0; pass--)
        for (int y = 0; y < spec->height; y++)
            png_read_row(png, pixels + (size_t)y * row_bytes(spec), NULL);
    png_destroy_read_struct(&png, &info, NULL);
    fclose(file);
    return pixels;
}

/* Writes a PNG, sends it through io and compares all samples. */
static const char *assert_round_trip(const png_spec *spec, io_meaning meaning) {
    const char *input = in_folder("in.png"), *output = in_folder("out.png");
    png_spec got;
    make_png(input, spec);
    const char *note = rewrite(input, output, meaning);
    unsigned char *pixels = pixels_of(output, &got);
    assert_int_equal(got.width, spec->width);
    assert_int_equal(got.height, spec->height);
    assert_int_equal(got.depth, spec->depth);
    assert_int_equal(got.type, spec->type);
    assert_int_equal(got.interlaced, spec->interlaced);
    const size_t size = row_bytes(spec) * (size_t)spec->height;
    for (size_t i = 0; i < size; i++)
        if (pixels[i] != spec->pixels[i]) fail_msg("byte %zu of %zu: %d, not %d", i, size, pixels[i], spec->pixels[i]);
    free(pixels);
    return note;
}

static unsigned char *random_pixels(size_t size, uint32_t seed) {
    unsigned char *pixels = malloc(size);
    assert_non_null(pixels);
    for (size_t i = 0; i < size; i++)
        pixels[i] = (unsigned char)next_random(&seed);
    return pixels;
}

/* IEC 61966-2-1, in double. */
static double linear_of(double encoded) {
    return encoded <= 0.04045 ? encoded / 12.92 : pow((encoded + 0.055) / 1.055, 2.4);
}

/* ------------------------------------------------------------------------- values */

static void test_srgb_values(void **state) {
    (void)state;
    unsigned char pixels[256];
    for (int i = 0; i < 256; i++)
        pixels[i] = (unsigned char)i;
    make_png(in_folder("in.png"), &(png_spec){.width = 256, .height = 1, .depth = 8, .pixels = pixels});
    io_picture *picture = read_picture(in_folder("in.png"));
    assert_int_equal(picture->part[0].channel_count, 1);
    assert_int_equal(picture->part[0].bits, 8);
    const float *y = values_of(picture, "Y");
    for (int i = 0; i < 256; i++)
        assert_float_equal(y[i], linear_of(i / 255.0), 2e-7);
    /* Figures everybody knows: middle grey and the end of the straight piece. */
    assert_float_equal(y[188], 0.502886, 1e-6);
    assert_float_equal(y[128], 0.215861, 1e-6);
    assert_float_equal(y[10], 10 / 255.0 / 12.92, 1e-9);
    assert_true(y[0] == 0 && y[255] == 1);
    io_close(&picture);
}

static unsigned char *all_values(void) {
    unsigned char *pixels = malloc(2 * 65536);
    assert_non_null(pixels);
    for (int i = 0; i < 65536; i++) {
        pixels[2 * i] = (unsigned char)(i >> 8);
        pixels[2 * i + 1] = (unsigned char)i;
    }
    return pixels;
}

static void test_all_16_bit_values(void **state) {
    (void)state;
    unsigned char *pixels = all_values();
    const png_spec spec = {.width = 256, .height = 256, .depth = 16, .pixels = pixels};
    assert_string_equal(assert_round_trip(&spec, IO_COLOR), "");
    assert_string_equal(assert_round_trip(&spec, IO_DATA), "");
    io_picture *picture = read_picture(in_folder("in.png"));
    const float *y = values_of(picture, "Y");
    for (int i = 0; i < 65536; i++)
        assert_float_equal(y[i], linear_of(i / 65535.0), 3e-7);
    io_close(&picture);
    free(pixels);
}

static void test_gamma(void **state) {
    (void)state;
    unsigned char *pixels = all_values(), gama[4];
    /* file gamma * 100000, and how value 32768 is to be decoded; 0: by sRGB's curve */
    static const struct {
        unsigned gamma;
        double power;
    } cases[] = {{100000, 1}, {45455, 0}, {55556, 1 / 0.55556}, {25000, 4}, {220000, 1 / 2.2}, {0, 0},
                 {1, 0},      {~0u, 0}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        for (int k = 0; k < 4; k++)
            gama[k] = (unsigned char)(cases[i].gamma >> (24 - 8 * k));
        const chunk chunks[] = {{"gAMA", gama, 4, false}, {"sRGB", "", 1, false}};
        png_spec spec = {
            .width = 256, .height = 256, .depth = 16, .pixels = pixels, .chunks = chunks, .chunk_count = 1};
        assert_round_trip(&spec, IO_COLOR);
        io_picture *picture = read_picture(in_folder("in.png"));
        const double v = 32768 / 65535.0, srgb = linear_of(v);
        assert_float_equal(values_of(picture, "Y")[32768], cases[i].power > 0 ? pow(v, cases[i].power) : srgb, 3e-7);
        io_close(&picture);
        spec.chunk_count = 2; /* sRGB goes before gAMA */
        make_png(in_folder("in.png"), &spec);
        picture = read_picture(in_folder("in.png"));
        assert_float_equal(values_of(picture, "Y")[32768], srgb, 3e-7);
        io_close(&picture);
    }
    free(pixels);
}

static void test_cicp(void **state) {
    (void)state;
    static const unsigned char pixel[] = {128};
    unsigned char cicp[] = {1, 8, 0, 1};
    const chunk chunks[] = {{"cICP", cicp, 4, false}};
    const png_spec spec = {.width = 1, .height = 1, .depth = 8, .pixels = pixel, .chunks = chunks, .chunk_count = 1};
    assert_round_trip(&spec, IO_COLOR);
    io_picture *picture = read_picture(in_folder("in.png"));
    assert_float_equal(values_of(picture, "Y")[0], 128 / 255.0, 1e-7);
    io_close(&picture);
    cicp[1] = 16;
    make_png(in_folder("in.png"), &spec);
    assert_refused(in_folder("in.png"), "PQ");
    io_error error = {""};
    assert_int_equal(io_open(&picture, in_folder("in.png"), IO_DATA, NULL, &error), 0); /* numbers are numbers */
    io_close(&picture);
}

/* ------------------------------------------------------------------------- layouts */

static void test_layouts(void **state) {
    (void)state;
    static const int types[] = {0, 2}; /* types with alpha: test_alpha */
    for (int t = 0; t < 2; t++)
        for (int depth = 8; depth <= 16; depth += 8)
            for (int interlaced = 0; interlaced < 2; interlaced++)
                for (int size = 1; size < 40; size += 6) {
                    png_spec spec = {
                        .width = size + 3, .height = size, .depth = depth, .type = types[t], .interlaced = interlaced};
                    unsigned char *pixels = random_pixels(row_bytes(&spec) * (size_t)spec.height, (uint32_t)size);
                    spec.pixels = pixels;
                    assert_string_equal(assert_round_trip(&spec, IO_COLOR), "");
                    assert_string_equal(assert_round_trip(&spec, IO_DATA), "");
                    free(pixels);
                }
}

static void test_low_bits(void **state) {
    (void)state;
    for (int depth = 1; depth <= 4; depth *= 2) {
        static unsigned char pixels[16 * 7];
        uint32_t seed = 5;
        for (size_t i = 0; i < sizeof pixels; i++)
            pixels[i] = (unsigned char)next_random(&seed);
        const int width = 13, maximum = (1 << depth) - 1;
        const png_spec spec = {.width = width, .height = 7, .depth = depth, .pixels = pixels};
        make_png(in_folder("in.png"), &spec);
        const char *note = rewrite(in_folder("in.png"), in_folder("out.png"), IO_DATA);
        assert_non_null(strstr(note, "-bit samples are written with 8 bits"));
        png_spec got;
        unsigned char *out = pixels_of(in_folder("out.png"), &got);
        assert_int_equal(got.depth, 8);
        for (int y = 0; y < 7; y++)
            for (int x = 0; x < width; x++) {
                int bit = x * depth,
                    v = pixels[(size_t)y * row_bytes(&spec) + (size_t)bit / 8] >> (8 - depth - bit % 8);
                assert_int_equal(out[y * width + x], (v & maximum) * 255 / maximum);
            }
        free(out);
    }
}

static void test_palette(void **state) {
    (void)state;
    static const png_color palette[] = {{0, 0, 0}, {255, 128, 10}, {1, 2, 3}, {200, 100, 50}};
    static const unsigned char indices[] = {0, 1, 2, 3, 3, 2, 1, 0}, opacity[] = {255, 128, 0, 1};
    png_spec spec =
                 {.width = 4, .height = 2, .depth = 8, .type = 3, .pixels = indices, .palette = palette, .colours = 4},
             got;
    make_png(in_folder("in.png"), &spec);
    assert_non_null(
        strstr(rewrite(in_folder("in.png"), in_folder("out.png"), IO_COLOR), "palette is written as 8-bit channels"));
    unsigned char *out = pixels_of(in_folder("out.png"), &got);
    assert_int_equal(got.type, 2);
    for (int i = 0; i < 8; i++)
        assert_memory_equal(out + 3 * i, &palette[indices[i]], 3);
    free(out);
    spec.opacity = opacity;
    make_png(in_folder("in.png"), &spec);
    assert_non_null(strstr(rewrite(in_folder("in.png"), in_folder("out.png"), IO_COLOR), "tRNS"));
    out = pixels_of(in_folder("out.png"), &got);
    assert_int_equal(got.type, 6);
    for (int i = 0; i < 8; i++) {
        const unsigned char a = opacity[indices[i]];
        assert_int_equal(out[4 * i + 3], a);
        assert_memory_equal(out + 4 * i, a ? (const void *)&palette[indices[i]] : "\0\0\0", 3);
    }
    free(out);
}

static void test_colour_key(void **state) {
    (void)state;
    static const unsigned char pixels[] = {1, 2, 3, 250, 251, 252, 1, 2, 4};
    const png_color_16 key = {.red = 1, .green = 2, .blue = 3};
    const png_spec spec = {.width = 3, .height = 1, .depth = 8, .type = 2, .pixels = pixels, .key = &key};
    make_png(in_folder("in.png"), &spec);
    io_picture *picture = read_picture(in_folder("in.png"));
    const float *a = values_of(picture, "A"), *b = values_of(picture, "B");
    assert_true(a[0] == 0 && a[1] == 1 && a[2] == 1 && b[0] == 0 && b[2] > 0);
    io_close(&picture);
}

/* ------------------------------------------------------------------------- alpha */

/* Every 8-bit colour under every 8-bit alpha, and 16-bit ones at random. */
static void test_alpha(void **state) {
    (void)state;
    const png_spec small = {.width = 256, .height = 256, .depth = 8, .type = 4};
    unsigned char *pixels = malloc(2 * 65536);
    assert_non_null(pixels);
    for (int i = 0; i < 65536; i++) {
        pixels[2 * i + 1] = (unsigned char)(i >> 8);
        pixels[2 * i] = i >> 8 ? (unsigned char)i : 0; /* what alpha 0 hides is not kept */
    }
    png_spec spec = small;
    spec.pixels = pixels;
    assert_string_equal(assert_round_trip(&spec, IO_COLOR), "");
    io_picture *picture = read_picture(in_folder("in.png"));
    const float *y = values_of(picture, "Y"), *a = values_of(picture, "A");
    assert_float_equal(a[128 * 256 + 188], 128 / 255.0, 1e-7); /* linear, not through the curve */
    assert_float_equal(y[128 * 256 + 188], linear_of(188 / 255.0) * 128 / 255.0, 1e-7);
    io_close(&picture);
    free(pixels);

    pixels = random_pixels(200 * 200 * 8, 9);
    for (int i = 0; i < 200 * 200; i++) {
        unsigned char *p = pixels + 8 * i;
        if (i % 3 == 0) p[6] = 0, p[7] = (unsigned char)(1 + i % 255); /* tiny alpha */
        if (p[6] == 0 && p[7] == 0) memset(p, 0, 6);
    }
    spec = (png_spec){.width = 200, .height = 200, .depth = 16, .type = 6, .pixels = pixels};
    assert_string_equal(assert_round_trip(&spec, IO_COLOR), "");
    assert_string_equal(assert_round_trip(&spec, IO_DATA), "");
    free(pixels);
}

static void test_hidden_colour(void **state) {
    (void)state;
    static const unsigned char pixels[] = {9, 8, 7, 0, 9, 8, 7, 255};
    const png_spec spec = {.width = 2, .height = 1, .depth = 8, .type = 6, .pixels = pixels};
    png_spec got;
    make_png(in_folder("in.png"), &spec);
    rewrite(in_folder("in.png"), in_folder("out.png"), IO_COLOR);
    unsigned char *out = pixels_of(in_folder("out.png"), &got);
    assert_memory_equal(out, "\0\0\0\0\x9\x8\x7\xff", 8);
    free(out);
    assert_round_trip(&spec, IO_DATA); /* numbers beside a fourth number: nothing is multiplied */
}

/* ------------------------------------------------------------------------- metadata */

static const chunk metadata[] = {
    {"cHRM", "\0\0\x7a\x26\0\0\x80\x84\0\0\xfa\0\0\0\x80\xe8\0\0\x75\x30\0\0\xea\x60\0\0\x3a\x98\0\0\x17\x70", 32,
     false},
    {"gAMA", "\0\0\xb1\x8f", 4, false},
    {"sRGB", "\1", 1, false},
    {"sBIT", "\5\6\5", 3, false},
    {"pHYs", "\0\0\x0b\x13\0\0\x05\x89\1", 9, false},
    {"bKGD", "\0\1\0\2\0\3", 6, false},
    {"tIME", "\x07\xea\1\2\3\4\5", 7, false},
    {"eXIf", "II*\0\x08\0\0\0\1\0\x0e\1\2\0\4\0\0\0abc\0\0\0\0\0", 26, false},
    {"tEXt", "Author\0Some Body", 16, false},
    {"iTXt", "XML:com.adobe.xmp\0\0\0\0\0<x:xmpmeta/>", 34, false},
    {"prVt", "private", 7, false},
    {"tEXt", "Comment\0after the pixels", 24, true},
    {"prVt", "twice", 5, true},
};
enum { METADATA = sizeof metadata / sizeof metadata[0] };

/* Whether the file holds the chunk, byte for byte, on that side of the pixels. */
static bool has_chunk(const char *path, const chunk *wanted) {
    size_t size;
    unsigned char *bytes = read_file(path, &size);
    bool found = false, after = false;
    for (size_t at = 8; at + 12 <= size;) {
        const size_t length =
            (size_t)bytes[at] << 24 | (size_t)bytes[at + 1] << 16 | (size_t)bytes[at + 2] << 8 | bytes[at + 3];
        after |= memcmp(bytes + at + 4, "IDAT", 4) == 0;
        found |= memcmp(bytes + at + 4, wanted->name, 4) == 0 && length == wanted->size &&
                 after == wanted->after_pixels && memcmp(bytes + at + 8, wanted->data, length) == 0;
        at += 12 + length;
    }
    free(bytes);
    return found;
}

static void test_metadata(void **state) {
    (void)state;
    unsigned char *pixels = random_pixels(30 * 3 * 8, 1);
    const png_spec spec = {
        .width = 30, .height = 8, .depth = 8, .type = 2, .pixels = pixels, .chunks = metadata, .chunk_count = METADATA};
    assert_string_equal(assert_round_trip(&spec, IO_COLOR), "");
    for (int i = 0; i < METADATA; i++)
        if (!has_chunk(in_folder("out.png"), &metadata[i])) fail_msg("%s is not kept", metadata[i].name);
    io_picture *picture = open_picture(in_folder("out.png"));
    assert_float_equal(picture->part[0].pixel_aspect, 0.5, 1e-3);
    io_close(&picture);
    rewrite(in_folder("out.png"), in_folder("in.png"), IO_COLOR);
    assert_same_files(in_folder("in.png"), in_folder("out.png")); /* and a second time, to the byte */
    free(pixels);
}

static void test_stale_chunks(void **state) {
    (void)state;
    static const unsigned char pixel[] = {1};
    static const chunk chunks[] = {{"acTL", "\0\0\0\1\0\0\0\0", 8, false},
                                   {"prVT", "depends on pixels", 17, false},
                                   {"prVT", "again", 5, true},
                                   {"fdAT", "\0\0\0\1x", 5, true}};
    const png_spec spec = {.width = 1, .height = 1, .depth = 8, .pixels = pixel, .chunks = chunks, .chunk_count = 4};
    const char *note = assert_round_trip(&spec, IO_COLOR);
    assert_non_null(strstr(note, "animation"));
    assert_non_null(strstr(note, "prVT"));
    assert_null(strstr(strstr(note, "prVT") + 4, "prVT"));
    for (int i = 0; i < 4; i++)
        assert_false(has_chunk(in_folder("out.png"), &chunks[i]));
}

/* ------------------------------------------------------------------------- new pictures, clamping */

static void test_create(void **state) {
    (void)state;
    static const char *const names[] = {"R", "G", "B", "A"};
    static const chunk srgb = {"sRGB", "\0", 1, false};
    io_error error = {""};
    io_picture *picture;
    png_spec got;
    for (int bits = 8; bits <= 16; bits += 8) {
        assert_int_equal(io_create(&picture, IO_PNG, 3, 1, names, 4, IO_HALF, bits, IO_COLOR, &error), 0);
        const float red[] = {0.25f, 2, NAN}, alpha[] = {0.5f, 1, 1};
        io_channel_from_float(channel_of(picture, 0, "R"), red, 1, 3);
        io_channel_from_float(channel_of(picture, 0, "A"), alpha, 1, 3);
        write_picture(picture, in_folder("out.png"), "2 values outside 0..1 were clamped");
        io_close(&picture);
        unsigned char *out = pixels_of(in_folder("out.png"), &got);
        assert_int_equal(got.depth, bits);
        assert_int_equal(got.type, 6);
        assert_true(has_chunk(in_folder("out.png"), &srgb));
        const size_t step = (size_t)bits / 8; /* the upper byte comes first */
        assert_int_equal(out[0], 188);        /* sRGB of 0.25 / 0.5 is 187.5 of 255, or 0xbc3f of 65535 */
        assert_int_equal(out[3 * step], bits == 8 ? 128 : 127 + 1);
        assert_int_equal(out[4 * step], 255);
        assert_int_equal(out[8 * step], 0);
        free(out);
    }
    assert_int_equal(io_create(&picture, IO_PNG, 3, 1, names, 4, IO_FLOAT, 32, IO_COLOR, &error), -1);
    assert_non_null(strstr(error.text, "8 or 16"));
    assert_int_equal(io_create(&picture, IO_PNG, 3, 1, names, 2, IO_FLOAT, 8, IO_COLOR, &error), -1);
    assert_null(picture);
}

static void test_some_channels(void **state) {
    (void)state;
    static const char *const names[] = {"G"};
    static const unsigned char pixels[] = {10, 20, 30, 40, 50, 60, 70, 80};
    const png_spec spec = {.width = 2, .height = 1, .depth = 8, .type = 6, .pixels = pixels};
    io_error error = {""};
    make_png(in_folder("in.png"), &spec);
    io_picture *picture = open_picture(in_folder("in.png"));
    assert_int_equal(io_read_channels(picture, 0, names, 1, &error), 0);
    assert_null(channel_of(picture, 0, "R")->data);
    float *green = channel_of(picture, 0, "G")->data;
    assert_float_equal(green[1], linear_of(60 / 255.0) * 80 / 255.0, 1e-7);
    green[1] = 0;
    io_channel_modified(channel_of(picture, 0, "G"));
    write_picture(picture, in_folder("out.png"), NULL); /* the others are read for it, this one is left alone */
    io_close(&picture);
    png_spec got;
    unsigned char *out = pixels_of(in_folder("out.png"), &got);
    assert_memory_equal(out, ((const unsigned char[]){10, 20, 30, 40, 50, 0, 70, 80}), 8);
    free(out);
}

/* ------------------------------------------------------------------------- damage */

static void test_hostile_headers(void **state) {
    (void)state;
    static const unsigned char pixel[] = {1};
    static const struct {
        unsigned char width[4], height[4];
        const char *words;
    } cases[] = {
        {{0, 1, 0x86, 0xa0}, {0, 1, 0x86, 0xa0}, "100000 x 100000"}, /* a bomb */
        {{0, 0x20, 0, 0}, {0, 0, 0, 1}, "too large"},
        {{0x7f, 0xff, 0xff, 0xff}, {0x7f, 0xff, 0xff, 0xff}, "2147483647"},
        {{0, 0, 0x07, 0xd0}, {0, 0, 0x07, 0xd0}, "more than its"}, /* within all limits, but not of this file */
        {{0, 0, 0, 0}, {0, 0, 0, 1}, "header is damaged"},
        {{0xff, 0xff, 0xff, 0xff}, {0, 0, 0, 1}, "header is damaged"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        size_t size;
        make_png(in_folder("in.png"), &(png_spec){.width = 1, .height = 1, .depth = 8, .pixels = pixel});
        unsigned char *bytes = read_file(in_folder("in.png"), &size);
        memcpy(bytes + 16, cases[i].width, 4);
        memcpy(bytes + 20, cases[i].height, 4);
        uint32_t crc = 0xffffffff; /* a header that is honest about its CRC */
        for (int k = 12; k < 29; k++) {
            crc ^= bytes[k];
            for (int bit = 0; bit < 8; bit++)
                crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
        }
        for (int k = 0; k < 4; k++)
            bytes[29 + k] = (unsigned char)(~crc >> (24 - 8 * k));
        write_file(in_folder("in.png"), bytes, size);
        free(bytes);
        assert_refused(in_folder("in.png"), cases[i].words);
    }
}

static void test_damage(void **state) {
    (void)state;
    for (int interlaced = 0; interlaced < 2; interlaced++) {
        unsigned char *pixels = random_pixels(20 * 6 * 15, 3);
        const png_spec spec = {.width = 20,
                               .height = 15,
                               .depth = 16,
                               .type = 2,
                               .interlaced = interlaced,
                               .pixels = pixels,
                               .chunks = metadata,
                               .chunk_count = METADATA};
        make_png(in_folder("in.png"), &spec);
        check_truncation(in_folder("in.png"), 0);
        check_mutations(in_folder("in.png"), 1000, 77);
        free(pixels);
    }
    static const png_color palette[] = {{0, 0, 0}, {255, 128, 10}};
    static const unsigned char indices[] = {0x55, 0xaa}, opacity[] = {255, 128};
    make_png(in_folder("in.png"), &(png_spec){.width = 8,
                                              .height = 2,
                                              .depth = 1,
                                              .type = 3,
                                              .pixels = indices,
                                              .palette = palette,
                                              .colours = 2,
                                              .opacity = opacity});
    check_truncation(in_folder("in.png"), 0);
    check_mutations(in_folder("in.png"), 1000, 78);
}

static void test_rows_are_named(void **state) {
    (void)state;
    size_t size;
    unsigned char *pixels = random_pixels(300 * 300, 3);
    make_png(in_folder("in.png"), &(png_spec){.width = 300, .height = 300, .depth = 8, .pixels = pixels});
    unsigned char *bytes = read_file(in_folder("in.png"), &size);
    write_file(in_folder("in.png"), bytes, size / 2);
    assert_refused(in_folder("in.png"), "is cut off at row 1");
    free(bytes);
    free(pixels);
}

static void test_full_disk(void **state) {
    (void)state;
    unsigned char *pixels = random_pixels(200 * 200, 3);
    make_png(in_folder("in.png"), &(png_spec){.width = 200, .height = 200, .depth = 8, .pixels = pixels});
    free(pixels);
    check_full_disk(in_folder("in.png"), in_folder("out.png"), 20000);
    check_full_disk(in_folder("in.png"), in_folder("out.png"), 20); /* within the header: stdio has it until the end */
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_srgb_values),     cmocka_unit_test(test_all_16_bit_values),
        cmocka_unit_test(test_gamma),           cmocka_unit_test(test_cicp),
        cmocka_unit_test(test_layouts),         cmocka_unit_test(test_low_bits),
        cmocka_unit_test(test_palette),         cmocka_unit_test(test_colour_key),
        cmocka_unit_test(test_alpha),           cmocka_unit_test(test_hidden_colour),
        cmocka_unit_test(test_metadata),        cmocka_unit_test(test_stale_chunks),
        cmocka_unit_test(test_create),          cmocka_unit_test(test_some_channels),
        cmocka_unit_test(test_hostile_headers), cmocka_unit_test(test_damage),
        cmocka_unit_test(test_rows_are_named),  cmocka_unit_test(test_full_disk),
    };
    return cmocka_run_group_tests_name("png", tests, make_folder, remove_folder);
}
