/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "json.h"

#include <math.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "message.h"

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
