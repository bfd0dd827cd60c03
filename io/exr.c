/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The EXR format in the table of formats. The work: exr_header.c, exr_layout.c, exr_codec.c, exr_read.c, exr_write.c.
 */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "exr.h"

static bool exr_matches(const unsigned char *head, size_t size) {
    return size >= 4 && io_get32(head) == IO_EXR_MAGIC;
}

static void exr_close(io_picture *picture) {
    io_exr_source *source = io_exr_source_of(picture);
    if (!source) return;
    io_exr_free_parts(source);
    free(source->header);
    free(source);
    picture->source = NULL;
}

static io_exr_source *new_source(io_picture *picture, const io_options *options, io_error *error) {
    io_exr_source *source = calloc(1, sizeof *source);
    if (!source) {
        io_fail(error, "%s: not enough memory", picture->path);
        return NULL;
    }
    source->file = -1;
    source->version = IO_EXR_VERSION;
    if (options) source->options = *options;
    picture->source = (struct io_source *)source;
    return source;
}

static int read_version(const io_picture *picture, io_exr_source *source, io_error *error) {
    enum { KNOWN = IO_EXR_FLAG_TILED | IO_EXR_FLAG_LONG_NAMES | IO_EXR_FLAG_DEEP | IO_EXR_FLAG_MULTIPART };
    unsigned char head[8];
    source->file = picture->file;
    source->length = (uint64_t)picture->stamp.size;
    if (!io_exr_pread(source->file, head, sizeof head, 0))
        return io_fail(error, "%s: ends within its header; it is cut off, copy or write it again", picture->path);
    source->version = io_get32(head + 4);
    if ((source->version & 0xff) != IO_EXR_VERSION || source->version & ~(0xffu | KNOWN))
        return io_fail(error, "%s: is of an EXR version this program does not know; write it as EXR 2", picture->path);
    if (source->version & IO_EXR_FLAG_TILED && source->version & (IO_EXR_FLAG_DEEP | IO_EXR_FLAG_MULTIPART))
        return io_fail(error, "%s: contradicts itself about tiles; the header is damaged", picture->path);
    return 0;
}

/* The length of a header is known when it was parsed: more and more of the file is read until it is whole. */
static int exr_open(io_picture *picture, io_meaning meaning, const io_options *options, io_error *error) {
    (void)meaning; /* EXR is scene-linear */
    io_exr_source *source = new_source(picture, options, error);
    if (!source || read_version(picture, source, error) != 0) return -1;
    for (uint64_t size = 1 << 16;; size *= 4) {
        bool complete = size >= source->length - 8;
        if (complete) size = source->length - 8;
        unsigned char *header = realloc(source->header, (size_t)size + 1);
        if (!header) return io_fail(error, "%s: not enough memory", picture->path);
        source->header = header;
        source->header_size = (size_t)size;
        if (!io_exr_pread(source->file, header, size, 8))
            return io_fail(error, "%s: cannot be read: %s", picture->path, strerror(errno));
        int result = io_exr_parse(picture, source, complete, error);
        if (result <= 0) return result;
    }
}

static int exr_read(io_picture *picture, int index, const char *const *names, int name_count, io_error *error) {
    io_part *part = &picture->part[index];
    if (part->deep) return io_fail(error, "%s: part %d is deep; flatten it first", picture->path, index);
    bool *wanted = calloc((size_t)part->channel_count, sizeof *wanted), any = false;
    if (!wanted) return io_fail(error, "%s: not enough memory", picture->path);
    int result = 0;
    for (int n = 0; result == 0 && n < (names ? name_count : 1); n++) {
        bool found = false;
        for (int i = 0; i < part->channel_count; i++)
            if (!names || strcmp(part->channel[i].name, names[n]) == 0) {
                found = true;
                any |= wanted[i] = !part->channel[i].data;
            }
        if (!found) result = io_fail(error, "%s: has no channel '%s'", picture->path, names[n]);
    }
    if (result == 0 && any) result = io_exr_read_part(picture, index, part, wanted, error);
    free(wanted);
    return result;
}

static int exr_create(io_picture *picture, io_meaning meaning, io_error *error) {
    (void)meaning;
    io_part *part = &picture->part[0];
    size_t count = (size_t)part->channel_count;
    io_exr_source *source = new_source(picture, NULL, error);
    if (!source) return -1;
    source->part = calloc(1, sizeof *source->part);
    if (!source->part) return io_fail(error, "%s: not enough memory", picture->path);
    source->part_count = 1;
    io_exr_part *layout = source->part;
    layout->compression = IO_EXR_ZIP;
    layout->window = part->data;
    layout->linear = calloc(count, sizeof *layout->linear);
    layout->type = malloc(count * sizeof *layout->type);
    if (!layout->linear || !layout->type) return io_fail(error, "%s: not enough memory", picture->path);
    for (size_t i = 0; i < count; i++) {
        size_t length = strlen(part->channel[i].name);
        if (length < 1 || length > 255)
            return io_fail(error, "%s: '%s' cannot be the name of a channel", picture->path, part->channel[i].name);
        if (length > 31) source->version |= IO_EXR_FLAG_LONG_NAMES;
        layout->type[i] = part->channel[i].type;
        part->bits = 8 * (int)io_type_size(layout->type[i]);
    }
    part->compression = io_exr_compression_name(layout->compression);
    if (io_exr_sort_channels(picture->path, part, layout, error) != 0) return -1;
    return io_exr_count_chunks(picture->path, layout, error);
}

static bool read_text_number(const io_exr_attribute *a, double *number) {
    char text[64], *end;
    if (a->size == 0 || a->size >= sizeof text || !strchr("+-.0123456789", a->value[0])) return false;
    memcpy(text, a->value, a->size);
    text[a->size] = 0;
    *number = strtod(text, &end);
    return end == text + a->size && strpbrk(text, "xXpPnN ") == NULL;
}

static bool exr_number(const io_picture *picture, int part, const char *name, double *number) {
    const io_exr_attribute *a = io_exr_find(&io_exr_source_of(picture)->part[part], name);
    if (!a) return false;
    if (strcmp(a->type, "string") == 0) return read_text_number(a, number);
    if (strcmp(a->type, "float") == 0 && a->size == 4) {
        const uint32_t bits = io_get32(a->value);
        float value;
        memcpy(&value, &bits, sizeof value);
        *number = (double)value;
        return true;
    }
    if (strcmp(a->type, "double") == 0 && a->size == 8) {
        const uint64_t bits = io_get64(a->value);
        memcpy(number, &bits, sizeof bits);
        return true;
    }
    if (strcmp(a->type, "int") == 0 && a->size == 4) {
        *number = (int32_t)io_get32(a->value);
        return true;
    }
    if (strcmp(a->type, "rational") != 0 || a->size != 8) return false;
    const uint32_t denominator = io_get32(a->value + 4);
    *number = (double)(int32_t)io_get32(a->value) / denominator;
    return denominator != 0;
}

static const char *exr_attribute(const io_picture *picture, int part, int index) {
    const io_exr_part *layout = &io_exr_source_of(picture)->part[part];
    return index < layout->attribute_count ? layout->attribute[index].name : NULL;
}

const io_handler io_exr = {
    .format = IO_EXR,
    .matches = exr_matches,
    .open = exr_open,
    .read = exr_read,
    .create = exr_create,
    .write = io_exr_write,
    .number = exr_number,
    .attribute = exr_attribute,
    .close = exr_close,
};
