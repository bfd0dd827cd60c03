/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* What the tests of io/ share: a folder of their own, pictures to look at, EXR files made to order. */
#ifndef TESTS_IO_SUPPORT_H
#define TESTS_IO_SUPPORT_H

/* cmocka.h wants these before it. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "picture.h"

/* ---- files */

/* Group set-up and tear-down: a folder by mkdtemp(), removed with all that is in it. */
int make_folder(void **state);
int remove_folder(void **state);
/* "<folder>/<name>", good for the next 16 calls. */
const char *in_folder(const char *name);
/* How many files there are in the folder. */
int count_files(void);
/* "<data>/<name>", NULL when there is no such file: call skip() then. */
const char *data_file(const char *name);
unsigned char *read_file(const char *path, size_t *size);
void write_file(const char *path, const void *data, size_t size);
void assert_same_files(const char *a, const char *b);

/* ---- pictures */

io_picture *open_picture(const char *path); /* asserts success */
io_picture *read_picture(const char *path);
void write_picture(const io_picture *picture, const char *path, const char *note);
io_channel *channel_of(io_picture *picture, int part, const char *name); /* asserts that it is there */
size_t channel_bytes(const io_channel *channel);
void assert_same_channel(const io_channel *a, const io_channel *b);
/* All channels of all flat parts but those named `except` (may be NULL). */
void assert_same_pixels(const io_picture *a, const io_picture *b, const char *except);
/* Adds 0.25 to every value of the channel. */
void change_channel(io_channel *channel);
void assert_one_line(const io_error *error, const char *path);

/* ---- EXR files, by OpenEXRCore */

typedef struct exr_channel_spec {
    const char *name;
    io_type type;
    bool linear;
    int x_sampling, y_sampling; /* 0: 1 */
} exr_channel_spec;

typedef struct exr_spec {
    const char *name, *view;
    int compression;
    int tile; /* 0: scanlines */
    int line_order;
    io_box data, display; /* display of width 0: data */
    const exr_channel_spec *channels;
    int channel_count;
    bool deep; /* scanlines; its channels are ignored: one float Z, 0 to 2 samples a pixel, not compressed */
    bool many_attributes;
} exr_spec;

/* Pixels follow a formula of channel, x, y: smooth, with noise, with infinities and NaNs in half channels. */
void make_exr(const char *path, const exr_spec *parts, int count);
uint32_t sample_of(const exr_spec *spec, int channel, int column, int row); /* its bits */
/* All attributes of all parts but those in the list `except` ("compression,tiles", may be NULL), through the library.
 */
void assert_same_attributes(const char *a, const char *b, const char *except);

/* ---- EXR files OpenEXRCore cannot write (fixture.cpp) */

int make_fixture(const char *kind, const char *path); /* 1: made, 0: not built, -1: failed */
/* Reads a channel of part 0 with the C++ library. */
bool read_reference(const char *path, const char *channel, int type, void *data, int width, int height);

#endif
