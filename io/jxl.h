/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Inside io/ only: what jxl.c gives to the table, by way of optional.c. */
#ifndef IO_JXL_H
#define IO_JXL_H

#include "format.h"

int io_jxl_open(io_picture *picture, io_meaning meaning, const io_options *options, io_error *error);
int io_jxl_read(io_picture *picture, int part, const char *const *names, int name_count, io_error *error);
void io_jxl_close(io_picture *picture);

#endif
