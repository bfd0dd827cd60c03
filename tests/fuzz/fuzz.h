/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Fuzz targets: functions that are given any bytes at all and abort when what must hold does not. One file, one target,
 * and one line in meson.build. Built with clang and -Dfuzz=true they are libFuzzer programs; in any other build replay.c
 * runs each of them once over the files of its corpus. */
#ifndef TESTS_FUZZ_H
#define TESTS_FUZZ_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* The entry that libFuzzer calls. */
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* Says which rule was broken, and aborts: libFuzzer keeps the input then. */
void fuzz_require(bool held, const char *rule, const char *detail);

/* The bytes as a file: a name good until the next call, the same every time. */
const char *fuzz_file(const uint8_t *data, size_t size);

/* From here on, what tools/ says on standard error is kept instead of printed. */
void fuzz_listen(void);
/* What was said since, to be forgotten at the next call; *lines: how many lines it has. */
const char *fuzz_heard(int *lines);

/* `status` of a function of tools/: 0 and nothing said, or else one line that begins with "ddof: ". */
void fuzz_require_line(int status);

/* Bytes taken one after another; zeroes when there are no more. */
typedef struct fuzz_bytes {
    const uint8_t *data;
    size_t size;
} fuzz_bytes;

unsigned fuzz_byte(fuzz_bytes *in);
/* low..high */
int fuzz_range(fuzz_bytes *in, int low, int high);

#endif
