/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Inside io/ only: what a file format implements, and what they share. picture.c holds the table. */
#ifndef IO_FORMAT_H
#define IO_FORMAT_H

#include <stdarg.h>
#include <stdio.h>

#include "picture.h"

typedef struct io_handler {
    io_format format;
    /* Whether a file that begins with these bytes is of this format. */
    bool (*matches)(const unsigned char *head, size_t size);
    /* picture->path, ->format are set. Fills the parts (channel data NULL) and picture->source. */
    int (*open)(io_picture *picture, io_meaning meaning, const io_options *options, io_error *error);
    /* Reads channels of `part` (names NULL: all of them); channels already read are left alone. */
    int (*read)(io_picture *picture, int part, const char *const *names, int name_count, io_error *error);
    /* Gives a picture made by io_create its source. bits is checked here. NULL, and write too: read only. */
    int (*create)(io_picture *picture, io_meaning meaning, io_error *error);
    /* Writes the file `temporary` from scratch. Messages name `path`, the final name. */
    int (*write)(const io_picture *picture, const char *temporary, const char *path, const io_options *options,
                 io_error *note, io_error *error);
    /* As io_attribute_number and _name; NULL: the format has none. */
    bool (*number)(const io_picture *picture, int part, const char *name, double *number);
    const char *(*attribute)(const io_picture *picture, int part, int index);
    /* Frees picture->source. */
    void (*close)(io_picture *picture);
} io_handler;

extern const io_handler io_exr, io_png, io_tiff, io_pfm, io_heif, io_jxl;
const io_handler *io_handler_of(io_format format);

/* Sets error->text and returns -1. The text names the file first: "shot.exr: ...". Control characters (from names in
 * hostile files) become '?', so that it is one line. error may be NULL. */
int io_fail(io_error *error, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* The picture's file from its beginning, a descriptor or stream to be closed; they share one place in the file, so one is
 * used at a time. -1 or NULL after saying why. */
int io_reopen(const io_picture *picture, io_error *error);
FILE *io_reopen_stream(const io_picture *picture, io_error *error);
/* All bytes of the picture's file, to be freed. */
int io_read_whole(const io_picture *picture, unsigned char **bytes, size_t *size, io_error *error);
/* `result` of what was read from the picture's file; -1 and the line about it when the file was written to since it was
 * opened, whatever else seemed to be wrong. */
int io_check_unchanged(const io_picture *picture, int result, io_error *error);

/* The line about a failure (errno) to write `path`: full disk, permissions, missing folder... Returns -1. */
int io_fail_write(io_error *error, const char *path, int code);

/* The temporary file that a handler is to write, empty at first, for reading and writing; -1: see errno. It is there: one
 * that was put in its place, or a link, is not followed. The stream is closed by the caller. */
int io_open_temporary(const char *name);
FILE *io_open_temporary_stream(const char *name);

/* A part with channels, appended to the picture; NULL when out of memory. Names are copied. */
io_part *io_add_part(io_picture *picture, const char *name, const char *view, io_box data, io_box display);
io_channel *io_add_channel(io_part *part, const char *name, io_type type, int x_sampling, int y_sampling);
/* Allocates a channel's data (64-byte aligned, zeroed). memory NULL: the process's own. */
int io_channel_allocate(io_channel *channel, const io_memory *memory, io_error *error, const char *path);
/* Frees a channel's data, which was made by io_channel_allocate (free() will not do). */
void io_channel_release(io_channel *channel);
/* A zeroed block for what is as large as a picture or a strip of one; NULL with the line in `error`. `options` may be
 * NULL. */
void *io_block_allocate(const io_options *options, size_t bytes, io_error *error, const char *path);
void io_block_release(const io_options *options, void *block);
/* Refuses width x height beyond options->max_pixels or outside 1..2^20 a side. */
int io_check_size(const char *path, int64_t width, int64_t height, const io_options *options, io_error *error);

/* Refuses pixels that would not fit into the machine's memory, before any of it is taken: allocation itself does not
 * fail on most systems, but the process is killed later. */
int io_check_memory(const char *path, uint64_t bytes, io_error *error);

/* sRGB transfer curve (IEC 61966-2-1), on 0..1; values outside go through the same curve, odd around 0. */
float io_srgb_to_linear(float encoded);
float io_linear_to_srgb(float linear);

/* IEEE binary16 <-> binary32, bit patterns in, round to nearest even, beyond the range: infinity. */
void io_half_to_float(const uint16_t *in, float *out, size_t count, size_t out_stride);
void io_float_to_half(const float *in, uint16_t *out, size_t count, size_t in_stride);

/* Runs task(data, 0..count-1) on `threads` pthreads (0: as many as the process may use), the caller's among them. */
void io_parallel(int threads, int count, void (*task)(void *data, int index), void *data);

#endif
