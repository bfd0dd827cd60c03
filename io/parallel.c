/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#if defined(__linux__)
#define _GNU_SOURCE /* sched_getaffinity */
#include <sched.h>
#endif
#include <pthread.h>
#include <stdatomic.h>
#include <unistd.h>

#include "format.h"

enum { MAX_THREADS = 256 };

typedef struct loop {
    void (*task)(void *data, int index);
    void *data;
    int count;
    atomic_int next;
} loop;

int io_thread_count(int threads) {
    if (threads <= 0) {
        threads = (int)sysconf(_SC_NPROCESSORS_ONLN);
#if defined(__linux__)
        /* A farm gives a job some of the machine's processors: more threads than those only wait for each other. */
        cpu_set_t set;
        if (sched_getaffinity(0, sizeof set, &set) == 0) threads = CPU_COUNT(&set);
#endif
    }
    return threads < 1 ? 1 : threads > MAX_THREADS ? MAX_THREADS : threads;
}

static void *work(void *argument) {
    loop *l = argument;
    for (int index; (index = atomic_fetch_add(&l->next, 1)) < l->count;)
        l->task(l->data, index);
    return NULL;
}

void io_parallel(int threads, int count, void (*task)(void *data, int index), void *data) {
    pthread_t thread[MAX_THREADS];
    loop l = {.task = task, .data = data, .count = count};
    int wanted = io_thread_count(threads), started = 0;
    if (wanted > count) wanted = count;
    /* A thread that cannot be had is no error: the others do its share. */
    while (started < wanted - 1 && pthread_create(&thread[started], NULL, work, &l) == 0)
        started++;
    work(&l);
    for (int i = 0; i < started; i++)
        pthread_join(thread[i], NULL);
}
