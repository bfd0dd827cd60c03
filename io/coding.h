/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Inside io/ only: how the numbers of an integer file become scene-linear premultiplied floats and back. PNG and TIFF
 * share it, so that the two formats cannot disagree.
 *
 * Everything is done on rows of one float array per channel. "Encoded" means v / maximum, 0..1, as in the file. */
#ifndef IO_CODING_H
#define IO_CODING_H

#include "format.h"

typedef enum io_curve {
    IO_CURVE_LINEAR, /* none: data, or a file that says its gamma is 1 */
    IO_CURVE_SRGB,
    IO_CURVE_POWER /* encoded = linear^power */
} io_curve;

typedef enum io_alpha {
    IO_ALPHA_NONE,      /* no alpha, or one that has nothing to do with the colour */
    IO_ALPHA_STRAIGHT,  /* colour in the file is not multiplied by alpha */
    IO_ALPHA_ASSOCIATED /* encoded colour was multiplied by alpha after it was encoded (TIFF 6.0, as its writers do it)
                         */
} io_alpha;

typedef struct io_coding {
    io_curve curve;
    double power; /* IO_CURVE_POWER only */
    io_alpha alpha;
} io_coding;

/* One value through the curve. Odd around 0, so that what lies outside 0..1 survives a round trip. */
float io_decode(const io_coding *coding, float encoded);
float io_encode(const io_coding *coding, float linear);

/* The curve for a number of ITU-T H.273 (cICP, nclx). Those of cameras (BT.709, BT.601, BT.2020) and what is unspecified
 * are read as sRGB, as viewers show them. -1 and a line for HDR video. */
int io_curve_of_transfer(io_coding *coding, int transfer, const char *path, io_error *error);
/* Into picture->note: what is not sRGB's, H.273 primaries or an ICC profile. */
void io_note_primaries(io_picture *picture, int primaries);
void io_note_profile(io_picture *picture, const unsigned char *profile, size_t size);

/* The 2^bits values (bits 1..16) that samples stand for, or NULL; to be freed. `colour`: what io_decode_row wants for a
 * colour sample, else v / maximum for alpha and extra samples. `inverted`: 0 stands for white. */
float *io_decode_table(const io_coding *coding, int bits, bool colour, bool inverted);

/* A row of samples from io_decode_table -> linear and premultiplied, in place. alpha: NULL when there is none. */
void io_decode_row(const io_coding *coding, float *const *colour, int colours, const float *alpha, int width);

/* Back: linear and premultiplied -> encoded, in place. Where alpha is 0 straight colour has no value and becomes 0. */
void io_encode_row(const io_coding *coding, float *const *colour, int colours, const float *alpha, int width);

/* Encoded -> 8, 16 or 32 bit integers in the machine's byte order, `step` samples apart. Clamped to 0..maximum, NaN is
 * 0. Returns how many values had to be clamped by more than rounding. */
uint64_t io_quantize(const float *encoded, int width, int bits, bool inverted, void *out, size_t step);

/* `count` pixels of a channel from (x, y) on as floats, whatever its type. */
void io_channel_span(const io_channel *channel, int x, int y, int count, float *out);

/* Adds to the line in `note` (may be NULL): "PATH: first thing; second thing". */
void io_note(io_error *note, const char *path, const char *format, ...) __attribute__((format(printf, 3, 4)));

/* The channel of that name, or NULL. */
const io_channel *io_find_channel(const io_part *part, const char *name);
/* The channels of a picture in the order of its file when they are Y, Y A, R G B or R G B A, whatever their order in
 * the part; else 0. Returns how many. */
int io_plain_channels(const io_part *part, const io_channel *channel[4]);
/* Reads the channels that nobody asked for yet, so that all of them can be written. */
int io_read_missing(const io_picture *picture, io_error *error);
/* In bytes; 0 when it cannot be known. */
int64_t io_file_length(FILE *file);
/* Whether the name is among `names` (NULL: every name is). */
bool io_name_wanted(const char *name, const char *const *names, int name_count);

#endif
