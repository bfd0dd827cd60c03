/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* What a frame of a shot was made of, so that --resume can leave it out. Beside the output lies a record,
 * .ddof/NAME.json: the settings, every input with its size and time of change, and the size and checksum of what was
 * written. A frame is complete when all of it is still so. */
#ifndef TOOLS_RESUME_H
#define TOOLS_RESUME_H

#include <stdbool.h>

#include "options.h"

/* Of the options of one frame, before its inputs are opened: settings and inputs in one line of text, to be freed. NULL: an
 * input is not there, or out of memory. */
char *resume_key(const options *o);

/* Whether the outputs are there, whole, and were made of this. */
bool resume_complete(const options *o, const char *key);

/* Writes the record, after the outputs. Failing costs no more than another rendering: a note says it. */
void resume_record(const options *o, const char *key);

#endif
