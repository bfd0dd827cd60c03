/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#define _GNU_SOURCE /* memfd_create */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "fuzz.h"

void fuzz_require(bool held, const char *rule, const char *detail) {
    if (held) return;
    dprintf(STDERR_FILENO, "broken rule: %s: %s\n", rule, detail ? detail : "");
    abort();
}

const char *fuzz_file(const uint8_t *data, size_t size) {
    static int file = -1;
    static char name[40];
    if (file < 0) {
        file = memfd_create("input", MFD_CLOEXEC);
        fuzz_require(file >= 0, "memfd_create", NULL);
        snprintf(name, sizeof name, "/proc/self/fd/%d", file);
    }
    bool written = ftruncate(file, 0) == 0 && (size == 0 || pwrite(file, data, size, 0) == (ssize_t)size);
    fuzz_require(written, "the input can be written", name);
    return name;
}

/* ------------------------------------------------------------------------- what is said */

static char *said;
static size_t said_size;

/* glibc's stderr is a variable; what sanitizers say goes to the descriptor and is still seen. */
void fuzz_listen(void) {
    static FILE *kept;
    if (kept) return;
    kept = open_memstream(&said, &said_size);
    fuzz_require(kept != NULL, "open_memstream", NULL);
    stderr = kept;
}

const char *fuzz_heard(int *lines) {
    fflush(stderr);
    *lines = 0;
    for (size_t i = 0; i < said_size; i++)
        *lines += said[i] == '\n';
    rewind(stderr);
    return said_size > 0 ? said : "";
}

void fuzz_require_line(int status) {
    int lines;
    const char *text = fuzz_heard(&lines);
    fuzz_require(status == 0 || lines == 1, "who refuses says why in one line", text);
    fuzz_require(status != 0 || lines == 0, "who succeeds says nothing", text);
    fuzz_require(lines == 0 || strncmp(text, "ddof: ", 6) == 0, "a line begins with the program's name", text);
}

/* ------------------------------------------------------------------------- bytes */

unsigned fuzz_byte(fuzz_bytes *in) {
    if (in->size == 0) return 0;
    in->size--;
    return *in->data++;
}

int fuzz_range(fuzz_bytes *in, int low, int high) {
    const unsigned span = (unsigned)(high - low) + 1, byte = fuzz_byte(in);
    return low + (int)((span > 256 ? byte << 8 | fuzz_byte(in) : byte) % span);
}
