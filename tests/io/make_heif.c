/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* libheif 1.15 encodes images, but has no way to say that one is another's depth. So each image is encoded by itself, and
 * what came of it, its configuration and its bytes, is put into one file by hand: ISO/IEC 14496-12 and 23008-12. */
#include <libheif/heif.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "make_phone.h"

typedef struct bytes {
    unsigned char *data;
    size_t size;
} bytes;

/* A coded image, and what the file is to say of it. */
typedef struct item {
    bytes boxes, coded; /* the boxes hvcC or av1C, ispe and, of what was padded for the codec, clap; the samples */
    int box_count;
    int width, height, bits, channels, turn;
    const char *auxiliary; /* its type, NULL: the primary image */
    bool depth;
} item;

static void append(bytes *b, const void *data, size_t size) {
    b->data = realloc(b->data, b->size + size);
    if (size > 0) memcpy(b->data + b->size, data, size);
    b->size += size;
}

static void number(bytes *b, uint32_t value, int size) {
    for (int i = size - 1; i >= 0; i--)
        append(b, &(unsigned char){(unsigned char)(value >> 8 * i)}, 1);
}

static uint32_t get_number(const unsigned char *p) {
    return (uint32_t)p[0] << 24 | (uint32_t)p[1] << 16 | (uint32_t)p[2] << 8 | p[3];
}

/* Returns where its size is to be written by end(). */
static size_t begin(bytes *b, const char *type) {
    number(b, 0, 4);
    append(b, type, 4);
    return b->size - 8;
}

static void end(const bytes *b, size_t box) {
    for (int i = 0; i < 4; i++)
        b->data[box + (size_t)i] = (unsigned char)((b->size - box) >> 8 * (3 - i));
}

/* ------------------------------------------------------------------------- images */

/* libx265's encoder loses some kilobytes each time; LeakSanitizer is to look at the rest. */
__attribute__((visibility("default"))) const char *__lsan_default_suppressions(void);
const char *__lsan_default_suppressions(void) {
    return "leak:libx265\n";
}

static struct heif_error collect(struct heif_context *context, const void *data, size_t size, void *to) {
    (void)context;
    append(to, data, size);
    return (struct heif_error){heif_error_Ok, heif_suberror_Unspecified, "ok"};
}

/* The first box of that type, inside `path`: one that holds others, with so many bytes before them. */
static bytes find_box(bytes in, const char *type) {
    static const struct {
        const char *type;
        size_t head;
    } holders[] = {{"meta", 12}, {"iprp", 8}, {"ipco", 8}};
    for (size_t at = 0; at + 8 <= in.size && get_number(in.data + at) >= 8;) {
        const size_t size = get_number(in.data + at);
        if (size > in.size - at) break;
        if (memcmp(in.data + at + 4, type, 4) == 0) return (bytes){in.data + at, size};
        for (size_t i = 0; i < 3; i++) {
            const size_t head = holders[i].head;
            if (memcmp(in.data + at + 4, holders[i].type, 4) != 0) continue;
            bytes found = find_box((bytes){in.data + at + head, size - head}, type);
            if (found.data) return found;
        }
        at += size;
    }
    return (bytes){0};
}

static void fill(struct heif_image *image, enum heif_channel plane, int channel, int width, int height, int bits) {
    int stride;
    heif_image_add_plane(image, plane, width, height, bits);
    unsigned char *data = heif_image_get_plane(image, plane, &stride);
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            const uint16_t v = (uint16_t)lrintf(phone_value(channel, x, y, width, height) * (float)((1 << bits) - 1));
            if (bits > 8)
                memcpy(data + (size_t)y * (size_t)stride + 2 * (size_t)x, &v, 2);
            else
                data[(size_t)y * (size_t)stride + (size_t)x] = (unsigned char)v;
        }
}

/* What is lossless holds G, B, R as they are, which nclx can say: there is no other way for them. */
static struct heif_image *make_image(const item *it, int channel, bool lossy) {
    static const enum heif_channel rgb[] = {heif_channel_R, heif_channel_G, heif_channel_B};
    static const enum heif_channel gbr[] = {heif_channel_Cr, heif_channel_Y, heif_channel_Cb};
    struct heif_image *image = NULL;
    const bool color = it->channels == 3;
    struct heif_error e = heif_image_create(
        it->width, it->height, !color ? heif_colorspace_monochrome : lossy ? heif_colorspace_RGB : heif_colorspace_YCbCr,
        color ? heif_chroma_444 : heif_chroma_monochrome, &image);
    if (e.code != heif_error_Ok) return NULL;
    for (int c = 0; color && c < 3; c++)
        fill(image, (lossy ? rgb : gbr)[c], c, it->width, it->height, it->bits);
    if (!color) fill(image, heif_channel_Y, channel, it->width, it->height, it->bits);
    return image;
}

static int encode(struct heif_encoder *encoder, item *it, int channel, const phone_spec *spec) {
    struct heif_context *context = heif_context_alloc();
    struct heif_encoding_options *options = heif_encoding_options_alloc();
    struct heif_image *image = make_image(it, channel, spec->lossy);
    struct heif_writer writer = {.writer_api_version = 1, .write = collect};
    bytes file = {0};
    options->macOS_compatibility_workaround = 0; /* clap, not a grid of one */
    heif_encoder_set_lossless(encoder, !spec->lossy);
    heif_encoder_set_lossy_quality(encoder, 90);
    heif_encoder_set_parameter_string(encoder, "chroma", spec->lossy ? "420" : "444");
    struct heif_error e = heif_context_encode_image(context, image, encoder, options, NULL);
    if (e.code == heif_error_Ok) e = heif_context_write(context, &writer, &file);
    const char *const types[] = {spec->av1 ? "av1C" : "hvcC", "ispe", "clap"};
    for (int i = 0; i < 3; i++) {
        const bytes box = find_box(file, types[i]);
        if (box.data) append(&it->boxes, box.data, box.size);
        it->box_count += box.data != NULL;
    }
    const bytes coded = find_box(file, "mdat");
    const int status = e.code == heif_error_Ok && it->box_count >= 2 && coded.data ? 1 : -1;
    if (status > 0)
        append(&it->coded, coded.data + 8, coded.size - 8);
    else
        fprintf(stderr, "%d bits, %d channels, %s: %s\n", it->bits, it->channels, spec->av1 ? "AV1" : "HEVC", e.message);
    free(file.data);
    if (image) heif_image_release(image);
    heif_encoding_options_free(options);
    heif_context_free(context);
    return status;
}

/* ------------------------------------------------------------------------- boxes */

static void write_auxiliary(bytes *b, const item *it, const phone_spec *spec) {
    const size_t box = begin(b, "auxC");
    number(b, 0, 4);
    append(b, it->auxiliary, strlen(it->auxiliary) + 1);
    if (it->depth && spec->sei) {
        number(b, (uint32_t)spec->sei_size + 4, 4);
        number(b, (uint32_t)spec->sei_size, 4);
        append(b, spec->sei, spec->sei_size);
    }
    end(b, box);
}

/* The properties of one item; returns how many. */
static int write_properties(bytes *b, const item *it, const phone_spec *spec) {
    int count = it->box_count + 1;
    append(b, it->boxes.data, it->boxes.size);
    size_t box = begin(b, "pixi");
    number(b, 0, 4);
    number(b, (uint32_t)it->channels, 1);
    for (int c = 0; c < it->channels; c++)
        number(b, (uint32_t)it->bits, 1);
    end(b, box);
    if (it->auxiliary) {
        write_auxiliary(b, it, spec);
        count++;
    } else {
        box = begin(b, "colr");
        append(b, "nclx", 4);
        number(b, spec->primaries ? (uint32_t)spec->primaries : 2, 2);
        number(b, spec->transfer ? (uint32_t)spec->transfer : 2, 2);
        number(b, spec->lossy ? 6 : 0, 2);
        number(b, 0x80, 1);
        end(b, box);
        count++;
    }
    if (it->turn) {
        box = begin(b, "irot");
        number(b, (uint32_t)it->turn, 1);
        end(b, box);
        count++;
    }
    return count;
}

static void write_iprp(bytes *b, const item *items, int count, const phone_spec *spec) {
    int properties[3], next = 1;
    const size_t iprp = begin(b, "iprp"), ipco = begin(b, "ipco");
    for (int i = 0; i < count; i++)
        properties[i] = write_properties(b, &items[i], spec);
    end(b, ipco);
    const size_t ipma = begin(b, "ipma");
    number(b, 0, 4);
    number(b, (uint32_t)count, 4);
    for (int i = 0; i < count; i++) {
        number(b, (uint32_t)i + 1, 2);
        number(b, (uint32_t)properties[i], 1);
        for (int p = 0; p < properties[i]; p++, next++)
            number(b, 0x80 | (uint32_t)next, 1);
    }
    end(b, ipma);
    end(b, iprp);
}

static void write_references(bytes *b, int count) {
    const size_t box = begin(b, "iref");
    number(b, 0, 4);
    for (int i = 1; i < count; i++) {
        const size_t one = begin(b, "auxl");
        number(b, (uint32_t)i + 1, 2);
        number(b, 1, 2);
        number(b, 1, 2);
        end(b, one);
    }
    end(b, box);
}

static void write_meta(bytes *b, const item *items, int count, const phone_spec *spec, size_t first_byte) {
    const size_t meta = begin(b, "meta");
    number(b, 0, 4);
    size_t box = begin(b, "hdlr");
    append(b, "\0\0\0\0\0\0\0\0pict\0\0\0\0\0\0\0\0\0\0\0\0\0", 25);
    end(b, box);
    box = begin(b, "pitm");
    number(b, 0, 4);
    number(b, 1, 2);
    end(b, box);
    box = begin(b, "iloc");
    number(b, 0, 4);
    number(b, 0x4400, 2);
    number(b, (uint32_t)count, 2);
    for (int i = 0; i < count; i++) {
        number(b, (uint32_t)i + 1, 2);
        number(b, 0, 2);
        number(b, 1, 2);
        number(b, (uint32_t)first_byte, 4);
        number(b, (uint32_t)items[i].coded.size, 4);
        first_byte += items[i].coded.size;
    }
    end(b, box);
    box = begin(b, "iinf");
    number(b, 0, 4);
    number(b, (uint32_t)count, 2);
    for (int i = 0; i < count; i++) {
        const size_t infe = begin(b, "infe");
        number(b, 0x02000000, 4);
        number(b, (uint32_t)i + 1, 2);
        number(b, 0, 2);
        append(b, spec->av1 ? "av01\0" : "hvc1\0", 5);
        end(b, infe);
    }
    end(b, box);
    if (count > 1) write_references(b, count);
    write_iprp(b, items, count, spec);
    end(b, meta);
}

static int write_all(const char *path, const item *items, int count, const phone_spec *spec) {
    bytes b = {0}, measured = {0};
    const char *brand = spec->av1 ? "avif" : "heic";
    size_t box = begin(&b, "ftyp");
    append(&b, brand, 4);
    number(&b, 0, 4);
    append(&b, "mif1", 4);
    append(&b, brand, 4);
    end(&b, box);
    write_meta(&measured, items, count, spec, 0);
    write_meta(&b, items, count, spec, b.size + measured.size + 8);
    box = begin(&b, "mdat");
    for (int i = 0; i < count; i++)
        append(&b, items[i].coded.data, items[i].coded.size);
    end(&b, box);
    FILE *file = fopen(path, "wb");
    const bool good = file && fwrite(b.data, 1, b.size, file) == b.size;
    const int status = file && fclose(file) == 0 && good ? 1 : -1;
    free(b.data);
    free(measured.data);
    return status;
}

int make_heif(const char *path, const phone_spec *s) {
    struct heif_encoder *encoder = NULL;
    const enum heif_compression_format format = s->av1 ? heif_compression_AV1 : heif_compression_HEVC;
    if (!heif_have_encoder_for_format(format) || !heif_have_decoder_for_format(format)) return 0;
    if (heif_context_get_encoder_for_format(NULL, format, &encoder).code != heif_error_Ok) return -1;
    item items[3] = {{.width = s->width, .height = s->height, .bits = s->bits, .channels = 3, .turn = s->turn}};
    int count = 1;
    if (s->alpha)
        items[count++] = (item){.width = s->width, .height = s->height, .bits = s->bits, .channels = 1, .turn = s->turn,
                                .auxiliary = s->av1 ? "urn:mpeg:mpegB:cicp:systems:auxiliary:alpha"
                                                    : "urn:mpeg:hevc:2015:auxid:1"};
    if (s->depth_width)
        items[count++] = (item){.width = s->depth_width, .height = s->depth_height, .bits = s->depth_bits, .channels = 1,
                                .depth = true, .turn = s->turn_color_only ? 0 : s->turn,
                                .auxiliary = s->av1 ? "urn:mpeg:mpegB:cicp:systems:auxiliary:depth"
                                                    : "urn:mpeg:hevc:2015:auxid:2"};
    int status = 1;
    for (int i = 0; status > 0 && i < count; i++)
        status = encode(encoder, &items[i], i == 0 ? 0 : i == 1 && s->alpha ? 3 : 4, s);
    if (status > 0) status = write_all(path, items, count, s);
    for (int i = 0; i < count; i++) {
        free(items[i].boxes.data);
        free(items[i].coded.data);
    }
    heif_encoder_release(encoder);
    return status;
}
