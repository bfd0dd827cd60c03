/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* PFM: "PF" (R G B), "Pf" (Y) or "PF4" (R G B A), width, height, scale; then binary32 rows, the bottom one first. A
 * negative scale means little endian. Values are scene-linear; they are delivered multiplied by |scale|, and written
 * with a scale of 1 in the byte order of the file they came from. */
#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "coding.h"

enum { LONGEST_HEADER = 4096 };

typedef struct io_source {
    io_options options;
    bool big_endian;
    float scale;      /* > 0 */
    long data_offset; /* of the first pixel */
} io_source;

static bool matches_pfm(const unsigned char *head, size_t size) {
    return size >= 3 && head[0] == 'P' && (head[1] == 'F' || head[1] == 'f') &&
           (isspace(head[2]) || (head[1] == 'F' && head[2] == '4'));
}

/* ------------------------------------------------------------------------- header */

/* The next word of the header, after white space and comments. The character after it is read too. */
static bool next_word(FILE *file, char *word, size_t size) {
    int c = getc(file);
    while (ftell(file) < LONGEST_HEADER && (isspace(c) || c == '#')) {
        if (c == '#')
            while (c != '\n' && c != EOF && ftell(file) < LONGEST_HEADER)
                c = getc(file);
        else
            c = getc(file);
    }
    size_t length = 0;
    for (; c != EOF && !isspace(c) && length + 1 < size; c = getc(file))
        word[length++] = (char)c;
    word[length] = '\0';
    return length > 0 && isspace(c);
}

static bool next_size(FILE *file, int64_t *value) {
    char word[24], *end;
    if (!next_word(file, word, sizeof word) || !isdigit((unsigned char)word[0])) return false;
    *value = strtoll(word, &end, 10); /* too many digits: the largest value, refused by io_check_size */
    return *end == '\0';
}

/* A plain decimal number, whatever the locale says a decimal point is. */
static bool parse_scale(const char *word, double *value) {
    double sign = *word == '-' ? -1 : 1, number = 0, place = 1;
    bool digits = false;
    if (*word == '-' || *word == '+') word++;
    for (; isdigit((unsigned char)*word); word++, digits = true)
        number = number * 10 + (*word - '0');
    if (*word == '.')
        for (word++; isdigit((unsigned char)*word); word++, digits = true)
            number += (*word - '0') * (place /= 10);
    if (digits && (*word == 'e' || *word == 'E')) {
        char *end;
        long exponent = strtol(word + 1, &end, 10);
        if (end == word + 1 || exponent < -99 || exponent > 99) return false;
        number *= pow(10, (double)exponent);
        word = end;
    }
    *value = sign * number;
    return digits && *word == '\0';
}

/* "\r\n" after the scale: the line feed is the header's if the file is then as long as it should be. */
static void skip_line_feed(FILE *file, io_source *source, int64_t length, int64_t bytes) {
    if (fseek(file, source->data_offset - 1, SEEK_SET) == 0 && getc(file) == '\r' && getc(file) == '\n' &&
        length - source->data_offset > bytes)
        source->data_offset++;
}

static int read_header(io_picture *picture, FILE *file, io_error *error) {
    io_source *source = picture->source;
    const char *path = picture->path;
    char magic[8], word[64];
    int64_t width, height;
    double scale;
    if (!next_word(file, magic, sizeof magic) || !next_size(file, &width) || !next_size(file, &height) ||
        !next_word(file, word, sizeof word) || !parse_scale(word, &scale))
        return io_fail(error, "%s: the PFM header is not \"PF width height scale\"; export the picture again", path);
    if (scale == 0 || !isfinite((float)scale) || (float)scale == 0)
        return io_fail(error, "%s: the PFM scale is %s, it must be a number other than 0; export the picture again",
                       path, word);
    if (io_check_size(path, width, height, &source->options, error) < 0) return -1;
    const int channels = strcmp(magic, "PF4") == 0  ? 4
                         : strcmp(magic, "PF") == 0 ? 3
                         : strcmp(magic, "Pf") == 0 ? 1
                                                    : 0;
    if (channels == 0) return io_fail(error, "%s: is no PFM file", path);
    source->big_endian = scale > 0;
    source->scale = (float)fabs(scale);
    source->data_offset = ftell(file);
    const int64_t length = io_file_length(file), bytes = width * height * channels * 4;
    skip_line_feed(file, source, length, bytes);
    if (length - source->data_offset < bytes)
        return io_fail(
            error, "%s: is cut off: %lld x %lld pixels need %lld bytes, the file has %lld; get the file again", path,
            (long long)width, (long long)height, (long long)bytes, (long long)(length - source->data_offset));
    io_box box = {0, 0, (int)width, (int)height};
    io_part *part = io_add_part(picture, "", "", box, box);
    static const char *const rgb[] = {"R", "G", "B", "A"};
    for (int c = 0; part != NULL && c < channels; c++)
        if (io_add_channel(part, channels == 1 ? "Y" : rgb[c], IO_FLOAT, 1, 1) == NULL) part = NULL;
    if (part == NULL) return io_fail(error, "%s: not enough memory", path);
    part->bits = 32;
    part->chunk_bytes = (uint64_t)width * (uint64_t)channels * 4;
    return 0;
}

static int open_pfm(io_picture *picture, io_meaning meaning, const io_options *options, io_error *error) {
    (void)meaning; /* float files hold plain numbers either way */
    FILE *file = io_reopen_stream(picture, error);
    if (file == NULL) return -1;
    picture->source = calloc(1, sizeof *picture->source);
    int status = picture->source == NULL ? io_fail(error, "%s: not enough memory", picture->path) : 0;
    if (status == 0) {
        if (options != NULL) picture->source->options = *options;
        status = read_header(picture, file, error);
    }
    fclose(file);
    return status;
}

/* ------------------------------------------------------------------------- pixels */

static float load(const unsigned char *p, bool big_endian) {
    uint32_t bits = big_endian ? (uint32_t)p[0] << 24 | (uint32_t)p[1] << 16 | (uint32_t)p[2] << 8 | p[3]
                               : (uint32_t)p[3] << 24 | (uint32_t)p[2] << 16 | (uint32_t)p[1] << 8 | p[0];
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static void store(unsigned char *p, float value, bool big_endian) {
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    for (int i = 0; i < 4; i++)
        p[big_endian ? 3 - i : i] = (unsigned char)(bits >> (8 * i));
}

static int read_rows(io_picture *picture, FILE *file, unsigned char *row, const bool *wanted, io_error *error) {
    const io_source *source = picture->source;
    const io_part *part = &picture->part[0];
    const int channels = part->channel_count, width = part->data.width, height = part->data.height;
    const size_t size = (size_t)width * (size_t)channels * 4;
    if (fseek(file, source->data_offset, SEEK_SET) != 0)
        return io_fail(error, "%s: cannot be read: %s", picture->path, strerror(errno));
    for (int y = height - 1; y >= 0; y--) {
        if (fread(row, 1, size, file) != size)
            return io_fail(error, "%s: cannot be read at row %d of %d: %s", picture->path, y, height,
                           ferror(file) ? strerror(errno) : "the file ends early");
        for (int c = 0; c < channels; c++) {
            if (!wanted[c]) continue;
            float *out = (float *)part->channel[c].data + (size_t)y * (size_t)width;
            for (int x = 0; x < width; x++)
                out[x] = load(row + 4 * ((size_t)x * (size_t)channels + (size_t)c), source->big_endian) * source->scale;
        }
    }
    return 0;
}

static int read_pfm(io_picture *picture, int part_index, const char *const *names, int name_count, io_error *error) {
    io_part *part = &picture->part[part_index];
    bool wanted[4] = {false}, any = false;
    for (int c = 0; c < part->channel_count; c++) {
        if (part->channel[c].data != NULL || !io_name_wanted(part->channel[c].name, names, name_count)) continue;
        if (io_channel_allocate(&part->channel[c], picture->memory, error, picture->path) < 0) return -1;
        wanted[c] = any = true;
    }
    if (!any) return 0;
    FILE *file = io_reopen_stream(picture, error);
    if (file == NULL) return -1;
    unsigned char *row = malloc((size_t)part->data.width * (size_t)part->channel_count * 4);
    int status = row == NULL ? io_fail(error, "%s: not enough memory", picture->path)
                             : read_rows(picture, file, row, wanted, error);
    free(row);
    fclose(file);
    return status;
}

/* ------------------------------------------------------------------------- writing */

static int create_pfm(io_picture *picture, io_meaning meaning, io_error *error) {
    (void)meaning;
    const io_channel *channel[4];
    int channels = io_plain_channels(&picture->part[0], channel);
    if (picture->part[0].bits != 32)
        return io_fail(error, "%s: PFM has 32 bits, not %d", picture->path, picture->part[0].bits);
    if (channels == 0 || channels == 2)
        return io_fail(error, "%s: PFM holds the channels Y, R G B or R G B A; write an EXR for others", picture->path);
    picture->source = calloc(1, sizeof *picture->source);
    if (picture->source == NULL) return io_fail(error, "%s: not enough memory", picture->path);
    picture->source->scale = 1;
    return 0;
}

static int write_rows(FILE *file, const io_channel *const *channel, int channels, bool big_endian) {
    const int width = channel[0]->width;
    const size_t size = (size_t)width * (size_t)channels * 4;
    unsigned char *row = malloc(size);
    float *values = malloc(sizeof *values * (size_t)width);
    int status = row == NULL || values == NULL ? -1 : 0;
    if (status < 0) errno = ENOMEM;
    for (int y = channel[0]->height - 1; y >= 0 && status == 0; y--) {
        for (int c = 0; c < channels; c++) {
            io_channel_span(channel[c], 0, y, width, values);
            for (int x = 0; x < width; x++)
                store(row + 4 * ((size_t)x * (size_t)channels + (size_t)c), values[x], big_endian);
        }
        if (fwrite(row, 1, size, file) != size) status = -1;
    }
    int number = errno;
    free(row);
    free(values);
    errno = number;
    return status;
}

static int write_pfm(const io_picture *picture, const char *temporary, const char *path, const io_options *options,
                     io_error *note, io_error *error) {
    (void)options;
    (void)note;
    const io_channel *channel[4];
    if (io_read_missing(picture, error) < 0) return -1;
    const int channels = io_plain_channels(&picture->part[0], channel);
    if (channels == 0 || channels == 2)
        return io_fail(error, "%s: PFM holds the channels Y, R G B or R G B A; write an EXR for others", path);
    FILE *file = io_open_temporary_stream(temporary);
    if (file == NULL) return io_fail(error, "%s: cannot be written: %s", path, strerror(errno));
    const bool big_endian = picture->source->big_endian;
    int status = fprintf(file, "%s\n%d %d\n%s\n",
                         channels == 1   ? "Pf"
                         : channels == 3 ? "PF"
                                         : "PF4",
                         channel[0]->width, channel[0]->height, big_endian ? "1.0" : "-1.0") < 0
                     ? -1
                     : write_rows(file, channel, channels, big_endian);
    int number = errno;
    if (fclose(file) != 0 && status == 0) {
        status = -1;
        number = errno;
    }
    if (status < 0) return io_fail(error, "%s: cannot be written: %s", path, strerror(number));
    return 0;
}

static void close_pfm(io_picture *picture) {
    free(picture->source);
    picture->source = NULL;
}

const io_handler io_pfm = {
    .format = IO_PFM,
    .matches = matches_pfm,
    .open = open_pfm,
    .read = read_pfm,
    .create = create_pfm,
    .write = write_pfm,
    .close = close_pfm,
};
