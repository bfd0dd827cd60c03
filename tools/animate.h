/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Keyframes of the lens: the file of --animate. Format: docs/cli.md. Thread-safety: once read it is only looked at. */
#ifndef TOOLS_ANIMATE_H
#define TOOLS_ANIMATE_H

#include "sequence.h"

typedef struct animation animation;

/* Returns 0 or an exit code; *result is NULL on failure. */
int animation_read(animation **result, const char *path);
void animation_free(animation *a); /* NULL is allowed */

/* Whether there are keys for this option. */
bool animation_has(const animation *a, option_id id);

/* Sets the options of the frame that there are keys for. Returns 0 or an exit code. */
int animation_apply(const animation *a, frame_options *f, int frame);

#endif
