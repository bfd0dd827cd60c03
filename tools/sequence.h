/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Which frames a command works on, and the names of their files.
 *
 * A pattern is a name with #### (as many digits at least, filled with zeros) or %d, %04d. It may stand for IN (then a glob
 * like 'shot.*.exr' will do as well, whose frame numbers are the last numbers of the names) and for every other file of
 * the command. A name that exists as it is written is no pattern. */
#ifndef TOOLS_SEQUENCE_H
#define TOOLS_SEQUENCE_H

#include "options.h"

typedef struct sequence {
    const char *text; /* IN as given; the caller's */
    int *frame;       /* ascending */
    int count;
    char **glob; /* of a glob: the files found, in the order of glob_frame; else NULL */
    int *glob_frame;
    int glob_count;
} sequence;

/* Whether the command is to work on several frames: IN is a pattern, or --frames is given. */
bool sequence_wanted(const options *o);

/* The frames of --frames, or all there are; and that the output has a place for their number. Returns 0 or an exit code. */
int sequence_open(sequence *s, const options *o);
void sequence_close(sequence *s);

/* The name of IN's file at any frame number, which need not be one of the sequence nor exist; to be freed. NULL: a glob has
 * none of this number, or out of memory. */
char *sequence_file(const sequence *s, int frame);

/* The options of one frame: every pattern filled in. `o` must outlive them. */
typedef struct frame_options {
    options o;
    char *filled[16]; /* texts of its own */
    int count;
} frame_options;
int frame_options_make(frame_options *f, const options *o, const sequence *s, int frame);
/* Sets an option that is a number or a point, with a text as one would write it. Returns 0 or an exit code. */
int frame_options_set(frame_options *f, option_id id, option_value value);
void frame_options_free(frame_options *f);

/* The last number of a file's name before its ending, "pinhole.0007.exr" -> 7; -1: none. */
long frame_of_name(const char *path);
bool file_exists(const char *path);
/* The part of a path after the last slash. */
const char *base_name(const char *path);

/* Whether a name has a place for the frame's number; and that filled in, to be freed, NULL: out of memory. */
bool pattern_has_number(const char *text);
char *pattern_fill(const char *pattern, int frame);

#endif
