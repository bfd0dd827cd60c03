/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The default parallel-for: a small pool of pthreads that sleep between loops. */
#ifndef DDOF_THREADS_H
#define DDOF_THREADS_H

#include <ddof/ddof.h>

typedef struct thread_pool thread_pool;

/* As many threads as the process may run on (its affinity mask), 1..256. */
int threads_available(void);

/* `threads` workers, the caller of thread_pool_run among them. NULL when out of memory or threads. */
thread_pool *thread_pool_create(int threads, void *(*allocate)(void *, size_t), void (*release)(void *, void *), void *user);
void thread_pool_destroy(thread_pool *pool);

/* Runs task(data, 0..count-1, worker); returns when all are done. Always 0. */
int thread_pool_run(void *pool, int count, ddof_task task, void *data);

#endif
