/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* An allocator that counts, hands out memory full of garbage, and fails when told to. */
#ifndef TESTS_LIBRARY_ALLOCATOR_H
#define TESTS_LIBRARY_ALLOCATOR_H

#include <stdbool.h>
#include <stddef.h>

typedef struct allocator {
    int calls;   /* of allocate, all together */
    int fail_at; /* the call that returns NULL, from 1; 0: none */
    int live;    /* blocks */
    size_t live_bytes;
    bool wrong; /* a block was released that was not live, or released as NULL */
} allocator;

void *allocator_allocate(void *user, size_t bytes);
void allocator_release(void *user, void *memory);

#endif
