/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "allocator.h"

#include <stdlib.h>
#include <string.h>

enum { HEAD = 64, MAGIC = 0x600d };

/* Lies before the memory. */
typedef struct head {
    size_t bytes;
    int magic;
} head;

void *allocator_allocate(void *user, size_t bytes) {
    allocator *a = user;
    if (++a->calls == a->fail_at) return NULL;
    char *p = aligned_alloc(64, (bytes + HEAD + 63) / 64 * 64);
    if (!p) return NULL;
    memcpy(p, &(head){bytes, MAGIC}, sizeof(head));
    memset(p + HEAD, 0xff, bytes); /* NaN, if it is ever read */
    a->live++;
    a->live_bytes += bytes;
    return p + HEAD;
}

void allocator_release(void *user, void *memory) {
    allocator *a = user;
    head h = {0};
    if (memory) memcpy(&h, (char *)memory - HEAD, sizeof h);
    if (h.magic != MAGIC) {
        a->wrong = true;
        return;
    }
    a->live--;
    a->live_bytes -= h.bytes;
    memset((char *)memory - HEAD, 0, HEAD);
    free((char *)memory - HEAD);
}
