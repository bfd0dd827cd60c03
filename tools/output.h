/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Pictures that the commands make anew: results in another format than IN's, previews, false colour. They show the
 * display window; the rest of a data window is left out, what it does not cover is black and transparent. */
#ifndef TOOLS_OUTPUT_H
#define TOOLS_OUTPUT_H

#include <picture.h>

#include "options.h"

/* Before any work: the ending is known and the folder is there and can be written to. Returns 0 or an exit code. */
int output_check(option_id option, const char *path, io_format *format);

/* The selected channels of `part`, blurred or not, as a new picture of `format` for `path`. Says what is left out. */
int output_convert(io_picture **made, const io_picture *input, const io_selection *color, io_format format,
                   const char *path, const io_options *writing);

/* A new sRGB picture of width x height, 8 bits, channels R G B. */
int output_create_rgb(io_picture **made, int width, int height, const char *path, const io_options *writing);

/* Puts colour at (left, 0) of an R G B picture, brightened by `gain` and clipped to 0..1; `shrink` x `shrink` pixels
 * become one. One channel becomes grey. */
int output_place_color(io_picture *made, int left, const io_picture *input, const io_selection *color, int shrink,
                       double gain);

/* Row y of a channel as floats. */
void output_load_row(const io_channel *channel, int y, float *row);

/* Puts width x height values at (x, y) of a channel that may be smaller or larger, and may begin elsewhere. */
void output_place(io_channel *to, const float *from, io_box box);

/* Writes the file and prints the note of what could not be kept. Returns 0 or an exit code. */
int output_write(const io_picture *picture, const char *path, const io_options *writing);

#endif
