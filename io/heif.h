/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Inside io/ only: what heif.c gives to the table, by way of optional.c. */
#ifndef IO_HEIF_H
#define IO_HEIF_H

#include "format.h"

int io_heif_open(io_picture *picture, io_meaning meaning, const io_options *options, io_error *error);
int io_heif_read(io_picture *picture, int part, const char *const *names, int name_count, io_error *error);
void io_heif_close(io_picture *picture);

#endif
