/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Damage done to a good file of any format, and what must come of it: a refusal in one line that names the file, and
 * nothing printed, leaked or left behind. */
#ifndef TESTS_IO_DAMAGE_H
#define TESTS_IO_DAMAGE_H

#include "support.h"

/* Set it where a library prints of damaged files by itself, as Debian's libjxl does, and the decoders of libheif; else nothing may be printed. */
extern bool library_prints;

uint32_t next_random(uint32_t *state);

/* Opens and reads whatever is at `path`; a failure is checked to be one line. */
bool reads(const char *path, io_error *error);
/* A refusal whose line holds `words`. */
void assert_refused(const char *path, const char *words);

/* Every beginning of the file is refused; `spare`: bytes at the end that may be missing. */
void check_truncation(const char *path, size_t spare);
/* A few bytes changed at random, `rounds` times: read or refused, but nothing else. Some of what is read is written. */
void check_mutations(const char *path, int rounds, uint32_t seed);
/* A disk that fills up at `limit` bytes while `output` is written: reported, nothing left behind, the old file stays.
 */
void check_full_disk(const char *input, const char *output, size_t limit);

/* Reads `input`, says that all of it was changed, writes it as `output`; gives the note. */
const char *rewrite(const char *input, const char *output, io_meaning meaning);
const float *values_of(io_picture *picture, const char *channel);

#endif
