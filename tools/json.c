/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "json.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "message.h"

enum { LARGEST_FILE = 16 << 20 }; /* bytes; some ten thousand frames */

static atomic_bool out_of_memory;

static void *allocate(size_t size) {
    void *memory = malloc(size);
    if (!memory) atomic_store(&out_of_memory, true);
    return memory;
}

void json_watch_memory(void) {
    cJSON_InitHooks(&(cJSON_Hooks){.malloc_fn = allocate, .free_fn = free});
}

bool json_out_of_memory(void) {
    return atomic_load(&out_of_memory);
}

void json_number(cJSON *object, const char *key, double number) {
    if (!isfinite(number)) {
        cJSON_AddNullToObject(object, key);
        return;
    }
    /* six digits after the point, or six significant ones: what was measured has no more, and logs stay readable */
    char text[64];
    snprintf(text, sizeof text, fabs(number) >= 1 ? "%.6f" : "%.6g", number);
    cJSON_AddNumberToObject(object, key, strtod(text, NULL));
}

void json_integer(cJSON *object, const char *key, double number) {
    cJSON_AddNumberToObject(object, key, number);
}

/* The length of the UTF-8 sequence at s, 0 when it is not one. Overlong forms pass: they harm no reader of JSON. */
static size_t utf8_length(const unsigned char *s) {
    size_t length = s[0] < 0x80 ? 1 : s[0] >> 5 == 6 ? 2 : s[0] >> 4 == 14 ? 3 : s[0] >> 3 == 30 ? 4 : 0;
    for (size_t i = 1; i < length; i++)
        if (s[i] >> 6 != 2) return 0;
    return length;
}

cJSON *json_text_item(const char *text) {
    size_t size = strlen(text);
    char *copy = allocate(size + 1);
    if (!copy) return cJSON_CreateString("");
    memcpy(copy, text, size + 1);
    for (unsigned char *c = (unsigned char *)copy; *c;) {
        size_t length = utf8_length(c);
        if (length == 0) *c = '?';
        c += length ? length : 1;
    }
    cJSON *item = cJSON_CreateString(copy);
    free(copy);
    return item;
}

void json_text(cJSON *object, const char *key, const char *text) {
    cJSON_AddItemToObject(object, key, json_text_item(text));
}

static int print_object(cJSON *object, bool one_line) {
    char *text = !object ? NULL : one_line ? cJSON_PrintUnformatted(object) : cJSON_Print(object);
    cJSON_Delete(object);
    if (!text || json_out_of_memory()) {
        cJSON_free(text);
        return fail("--json: out of memory");
    }
    puts(text);
    cJSON_free(text);
    return finish_output();
}

int json_finish(cJSON *object) {
    return print_object(object, false);
}

int json_line(cJSON *object) {
    return print_object(object, true);
}

/* ------------------------------------------------------------------------- files */

static int read_text(const char *path, const char *option, char **text, size_t *size) {
    FILE *file = fopen(path, "rb");
    if (!file) return fail("%s: %s; give --%s a file that can be read", path, strerror(errno), option);
    size_t room = 4096, used = 0;
    *text = NULL;
    for (;;) {
        char *larger = realloc(*text, room);
        if (!larger) {
            fclose(file);
            return fail("%s: out of memory", path);
        }
        *text = larger;
        used += fread(*text + used, 1, room - used, file);
        if (used < room || room > LARGEST_FILE) break;
        room *= 2;
    }
    bool bad = ferror(file);
    int reason = errno;
    fclose(file);
    if (bad) return fail("%s: %s; give --%s a file that can be read", path, strerror(reason), option);
    if (used > LARGEST_FILE) return fail("%s: larger than %d MiB; give --%s a smaller file", path, LARGEST_FILE >> 20, option);
    *size = used;
    return 0;
}

static int fail_syntax(const char *path, const char *text, const char *at) {
    int line = 1, column = 1;
    for (const char *c = text; c < at; c++) {
        line += *c == '\n';
        column = *c == '\n' ? 1 : column + 1;
    }
    return fail("%s: line %d, column %d: not valid JSON; correct it there", path, line, column);
}

int json_read(cJSON **root, const char *path, const char *option, const char *begins) {
    char *text = NULL;
    size_t size = 0;
    int status = read_text(path, option, &text, &size);
    if (status == 0) {
        const char *end = text;
        *root = cJSON_ParseWithLengthOpts(text, size, &end, false);
        /* only blanks may follow; asking cJSON for that would read a byte past the end */
        while (*root && end < text + size && isspace((unsigned char)*end))
            end++;
        if (!*root || end < text + size) {
            status = json_out_of_memory() ? fail("%s: out of memory", path) : fail_syntax(path, text, end);
            cJSON_Delete(*root);
            *root = NULL;
        } else if (!cJSON_IsObject(*root)) {
            status = fail("%s: not a JSON object; the file of --%s begins with %s", path, option, begins);
            cJSON_Delete(*root);
            *root = NULL;
        }
    }
    free(text);
    return status;
}
