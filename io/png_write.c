/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Writing PNG: the bit depth, colour type, interlacing and ancillary chunks of the file the picture came from. What PNG
 * cannot keep is said in the note: palettes and samples below 8 bits become 8-bit channels, colour keys become alpha.
 */
#include "png_source.h"

#include <errno.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

enum {
    BAND = 32, /* rows encoded at a time by one thread */
    LEVEL = 4  /* of deflate: zlib's default of 6 takes twice the time for files 2 % smaller */
};

typedef struct writer {
    FILE *file;
    png_structp png;
    png_infop info;
    io_error message;
    const io_source *source;
    const io_channel *channel[4];
    int channels, width, height;
    unsigned char *pixels; /* the whole picture as PNG samples */
    atomic_bool no_memory;
    atomic_ullong clamped;
} writer;

static void on_error(png_structp png, png_const_charp text) {
    writer *w = png_get_error_ptr(png);
    snprintf(w->message.text, sizeof w->message.text, "%s", text);
    png_longjmp(png, 1);
}

static void on_warning(png_structp png, png_const_charp text) {
    (void)png;
    (void)text;
}

static void write_bytes(png_structp png, png_bytep bytes, size_t size) {
    writer *w = png_get_io_ptr(png);
    if (fwrite(bytes, 1, size, w->file) != size) png_error(png, strerror(errno));
}

static void flush_bytes(png_structp png) {
    (void)png; /* once, at the end: finish() */
}

static int guarded(writer *w, void (*step)(writer *)) {
    if (setjmp(png_jmpbuf(w->png))) return -1;
    step(w);
    return 0;
}

/* ------------------------------------------------------------------------- pixels */

static void encode_row(writer *w, float *const *row, unsigned short *wide, int y) {
    const int channels = w->channels, colours = channels <= 2 ? 1 : 3, width = w->width;
    const size_t count = (size_t)width * (size_t)channels;
    unsigned long long clamped = 0;
    for (int c = 0; c < channels; c++)
        io_channel_span(w->channel[c], 0, y, width, row[c]);
    io_encode_row(&w->source->coding, row, colours, channels % 2 == 0 ? row[channels - 1] : NULL, width);
    if (w->source->bits == 8) {
        unsigned char *out = w->pixels + (size_t)y * count;
        for (int c = 0; c < channels; c++)
            clamped += io_quantize(row[c], width, 8, false, out + c, (size_t)channels);
    } else {
        unsigned char *out = w->pixels + (size_t)y * count * 2;
        for (int c = 0; c < channels; c++)
            clamped += io_quantize(row[c], width, 16, false, wide + c, (size_t)channels);
        for (size_t i = 0; i < count; i++) { /* PNG is big endian */
            out[2 * i] = (unsigned char)(wide[i] >> 8);
            out[2 * i + 1] = (unsigned char)wide[i];
        }
    }
    atomic_fetch_add(&w->clamped, clamped);
}

static void encode_band(void *data, int index) {
    writer *w = data;
    const size_t width = (size_t)w->width, channels = (size_t)w->channels;
    float *scratch = malloc(width * channels * (sizeof(float) + sizeof(unsigned short)));
    if (scratch == NULL) {
        atomic_store(&w->no_memory, true);
        return;
    }
    float *row[4];
    for (size_t c = 0; c < channels; c++)
        row[c] = scratch + c * width;
    unsigned short *wide = (unsigned short *)(scratch + channels * width);
    for (int y = index * BAND; y < w->height && y < (index + 1) * BAND; y++)
        encode_row(w, row, wide, y);
    free(scratch);
}

static int encode(writer *w, const io_options *options, const char *path, io_error *error) {
    const size_t row = (size_t)w->width * (size_t)w->channels * (size_t)(w->source->bits / 8);
    w->pixels = io_block_allocate(options, row * (size_t)w->height, error, path);
    if (w->pixels == NULL) return -1;
    io_parallel(options != NULL ? options->threads : 0, (w->height + BAND - 1) / BAND, encode_band, w);
    if (atomic_load(&w->no_memory))
        return io_fail(error, "%s: not enough memory to write %d x %d pixels", path, w->width, w->height);
    return 0;
}

/* ------------------------------------------------------------------------- chunks */

static bool is_one_of(const char *name, const char *const *list) {
    for (; *list != NULL; list++)
        if (strcmp(name, *list) == 0) return true;
    return false;
}

/* Whether the chunk still holds for the picture that is written. */
static bool keeps(const writer *w, const io_png_chunk *chunk) {
    static const char *const of_layout[] = {"bKGD", "sBIT", NULL}; /* their form follows the colour type */
    static const char *const valid[] = {"cHRM", "cICP", "cLLI", "cLLi", "gAMA", "iCCP", "mDCV", "mDCv",
                                        "pCAL", "sCAL", "sPLT", "sRGB", "sTER", "tIME", NULL};
    const io_source *source = w->source;
    if (is_one_of(chunk->name, of_layout))
        return !source->palette && !source->transparent && w->channels == source->channels &&
               source->bits == source->file_bits;
    if (is_one_of(chunk->name, valid)) return true;
    /* PNG 1.2, 14.2: a lower-case fourth letter says that the chunk does not depend on the pixels. */
    return (chunk->name[3] & 0x20) != 0;
}

static void write_chunks(writer *w, bool after_pixels) {
    for (int i = 0; i < w->source->chunk_count; i++) {
        const io_png_chunk *chunk = &w->source->chunk[i];
        if (chunk->after_pixels == after_pixels && keeps(w, chunk))
            png_write_chunk(w->png, (png_const_bytep)chunk->name, chunk->data, chunk->size);
    }
}

static void note_losses(const writer *w, const char *path, io_error *note) {
    const io_source *source = w->source;
    if (source->palette) {
        io_note(note, path, "its palette is written as 8-bit channels");
    } else if (source->file_bits < 8) {
        io_note(note, path, "its %d-bit samples are written with 8 bits", source->file_bits);
    }
    if (source->transparent) io_note(note, path, "its transparent colour (tRNS) is written as an alpha channel");
    for (int i = 0; i < source->chunk_count; i++) {
        const char *name = source->chunk[i].name;
        bool again = false;
        for (int k = 0; k < i; k++)
            again |= strcmp(name, source->chunk[k].name) == 0;
        if (again || keeps(w, &source->chunk[i]) || strcmp(name, "hIST") == 0) continue;
        if (strcmp(name, "acTL") == 0)
            io_note(note, path, "only the first image of the animation is kept");
        else if (strcmp(name, "fcTL") != 0 && strcmp(name, "fdAT") != 0)
            io_note(note, path, "the chunk %s depends on the old pixels and is left out", name);
    }
    if (w->clamped > 0)
        io_note(note, path, "%llu values outside 0..1 were clamped (EXR keeps them)", (unsigned long long)w->clamped);
}

/* ------------------------------------------------------------------------- the file */

static void write_head(writer *w) {
    static const int type[] = {0, PNG_COLOR_TYPE_GRAY, PNG_COLOR_TYPE_GRAY_ALPHA, PNG_COLOR_TYPE_RGB,
                               PNG_COLOR_TYPE_RGB_ALPHA};
    png_set_user_limits(w->png, PNG_UINT_31_MAX, PNG_UINT_31_MAX);
    png_set_IHDR(w->png, w->info, (png_uint_32)w->width, (png_uint_32)w->height, w->source->bits, type[w->channels],
                 w->source->interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    if (w->source->created && w->source->coding.curve == IO_CURVE_SRGB)
        png_set_sRGB(w->png, w->info, PNG_sRGB_INTENT_PERCEPTUAL);
    png_set_compression_level(w->png, LEVEL);
    png_write_info(w->png, w->info);
    write_chunks(w, false);
}

static void write_rows(writer *w) {
    const size_t row = (size_t)w->width * (size_t)w->channels * (size_t)(w->source->bits / 8);
    for (int pass = png_set_interlace_handling(w->png); pass > 0; pass--)
        for (int y = 0; y < w->height; y++)
            png_write_row(w->png, w->pixels + (size_t)y * row);
    write_chunks(w, true);
    png_write_end(w->png, NULL);
}

static int finish(writer *w, const char *path, io_error *error) {
    FILE *file = w->file;
    w->file = NULL;
    int flushed = fflush(file), number = errno;
    if (fclose(file) != 0 && flushed == 0) {
        flushed = -1;
        number = errno;
    }
    if (flushed != 0) return io_fail(error, "%s: cannot be written: %s", path, strerror(number));
    return 0;
}

static int write_file(writer *w, const char *temporary, const char *path, io_error *error) {
    w->file = io_open_temporary_stream(temporary);
    if (w->file == NULL) return io_fail(error, "%s: cannot be written: %s", path, strerror(errno));
    w->png = png_create_write_struct(PNG_LIBPNG_VER_STRING, w, on_error, on_warning);
    if (w->png != NULL) w->info = png_create_info_struct(w->png);
    if (w->info == NULL) return io_fail(error, "%s: not enough memory to write it", path);
    png_set_write_fn(w->png, w, write_bytes, flush_bytes);
    if (guarded(w, write_head) < 0 || guarded(w, write_rows) < 0)
        return io_fail(error, "%s: cannot be written: %s", path, w->message.text);
    return finish(w, path, error);
}

int io_png_write(const io_picture *picture, const char *temporary, const char *path, const io_options *options,
                 io_error *note, io_error *error) {
    const io_part *part = &picture->part[0];
    writer w = {.source = picture->source};
    if (io_read_missing(picture, error) < 0) return -1;
    w.channels = io_plain_channels(part, w.channel);
    if (w.channels == 0)
        return io_fail(error, "%s: PNG holds the channels Y, Y A, R G B or R G B A; write an EXR for others", path);
    w.width = w.channel[0]->width;
    w.height = w.channel[0]->height;
    int status = encode(&w, options, path, error);
    if (status == 0) status = write_file(&w, temporary, path, error);
    if (status == 0) note_losses(&w, path, note);
    if (w.png != NULL) png_destroy_write_struct(&w.png, &w.info);
    if (w.file != NULL) fclose(w.file);
    io_block_release(options, w.pixels);
    return status;
}
