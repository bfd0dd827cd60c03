/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The JSON objects the commands print, of which members are never removed or renamed, only added; and reading those that
 * options name. */
#ifndef TOOLS_JSON_H
#define TOOLS_JSON_H

#include <cjson/cJSON.h>
#include <stdbool.h>

/* To be called before anything of cJSON, which leaves out what it has no memory for: from then on that is remembered. */
void json_watch_memory(void);
bool json_out_of_memory(void);

/* Numbers that JSON cannot hold (infinite, NaN) become null. */
void json_number(cJSON *object, const char *key, double number);
void json_integer(cJSON *object, const char *key, double number);
/* Text that is no valid UTF-8 (a file name may be anything) gets '?' for what is wrong. */
void json_text(cJSON *object, const char *key, const char *text);
cJSON *json_text_item(const char *text);

/* Prints and frees the object; returns 0 or an exit code. */
int json_finish(cJSON *object);
/* The same in one line, at once: one of several objects. */
int json_line(cJSON *object);

/* Reads the file of an option: one JSON object, of at most 16 MiB. `begins`: how such a file begins, for the message. Free
 * *root with cJSON_Delete(). Returns 0 or an exit code. */
int json_read(cJSON **root, const char *path, const char *option, const char *begins);

#endif
