/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The iris of --iris: a list of key=value by commas, and the picture that it may name. */
#ifndef TOOLS_IRIS_H
#define TOOLS_IRIS_H

#include <ddof/ddof.h>
#include <picture.h>

typedef struct iris_input {
    ddof_iris settings;
    float *values; /* of its picture; NULL: it has none */
} iris_input;

/* Reads the list, NULL for an even disc, and its picture. Returns 0 or an exit code; iris_close() is wanted either way.
 */
int iris_read(iris_input *in, const char *text, const io_options *reading);
/* FILE[:CHANNEL] of the picture that a list names, to be freed; NULL: none, or there is something wrong with the list. */
char *iris_image(const char *text);
void iris_close(iris_input *in);

#endif
