/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#define _GNU_SOURCE /* sched_getaffinity */
#include "threads.h"

#include <pthread.h>
#include <signal.h>
#include <stdbool.h>
#include <string.h>
#if defined(__linux__)
#include <sched.h>
#endif
#include <unistd.h>

enum { MAX_THREADS = 256 };

struct thread_pool {
    pthread_mutex_t lock;
    pthread_cond_t begin, end;
    ddof_task task;
    void *data;
    int count, next; /* jobs of the loop, and the next one to hand out */
    int running;     /* workers inside the loop */
    unsigned loop;   /* counts loops, so that a worker sees a new one */
    bool quit;
    int helpers;
    void (*release)(void *, void *);
    void *user;
    pthread_t thread[MAX_THREADS];
};

int threads_available(void) {
    long n = sysconf(_SC_NPROCESSORS_ONLN);
#if defined(__linux__)
    cpu_set_t set;
    if (sched_getaffinity(0, sizeof set, &set) == 0) n = CPU_COUNT(&set);
#endif
    return n < 1 ? 1 : n > MAX_THREADS ? MAX_THREADS : (int)n;
}

/* Called and left with the lock held. */
static void work(thread_pool *pool, int worker) {
    while (pool->next < pool->count) {
        int index = pool->next++;
        pthread_mutex_unlock(&pool->lock);
        pool->task(pool->data, index, worker);
        pthread_mutex_lock(&pool->lock);
    }
}

static void *helper(void *argument) {
    thread_pool *pool = argument;
    unsigned seen = 0;
    pthread_mutex_lock(&pool->lock);
    int worker = ++pool->helpers;
    pthread_cond_signal(&pool->end);
    for (;;) {
        while (pool->loop == seen && !pool->quit) pthread_cond_wait(&pool->begin, &pool->lock);
        if (pool->quit) break;
        seen = pool->loop;
        pool->running++;
        work(pool, worker);
        if (--pool->running == 0) pthread_cond_signal(&pool->end);
    }
    pthread_mutex_unlock(&pool->lock);
    return NULL;
}

thread_pool *thread_pool_create(int threads, void *(*allocate)(void *, size_t), void (*release)(void *, void *), void *user) {
    thread_pool *pool = allocate(user, sizeof *pool);
    sigset_t all, old;
    if (!pool) return NULL;
    memset(pool, 0, sizeof *pool);
    pool->release = release;
    pool->user = user;
    pthread_mutex_init(&pool->lock, NULL);
    pthread_cond_init(&pool->begin, NULL);
    pthread_cond_init(&pool->end, NULL);
    sigfillset(&all); /* signals are the caller's business, on the caller's threads */
    pthread_sigmask(SIG_SETMASK, &all, &old);
    int started = 0;
    while (started < threads - 1 && pthread_create(&pool->thread[started], NULL, helper, pool) == 0) started++;
    pthread_sigmask(SIG_SETMASK, &old, NULL);
    pthread_mutex_lock(&pool->lock); /* every helper has its number before the first loop */
    while (pool->helpers < started) pthread_cond_wait(&pool->end, &pool->lock);
    pthread_mutex_unlock(&pool->lock);
    if (started < threads - 1) {
        thread_pool_destroy(pool);
        return NULL;
    }
    return pool;
}

void thread_pool_destroy(thread_pool *pool) {
    if (!pool) return;
    pthread_mutex_lock(&pool->lock);
    pool->quit = true;
    pthread_cond_broadcast(&pool->begin);
    int helpers = pool->helpers;
    pthread_mutex_unlock(&pool->lock);
    for (int i = 0; i < helpers; i++) pthread_join(pool->thread[i], NULL);
    pthread_cond_destroy(&pool->begin);
    pthread_cond_destroy(&pool->end);
    pthread_mutex_destroy(&pool->lock);
    pool->release(pool->user, pool);
}

int thread_pool_run(void *opaque, int count, ddof_task task, void *data) {
    thread_pool *pool = opaque;
    pthread_mutex_lock(&pool->lock);
    pool->task = task;
    pool->data = data;
    pool->count = count;
    pool->next = 0;
    pool->loop++;
    if (count > 1) pthread_cond_broadcast(&pool->begin);
    work(pool, 0);
    while (pool->running > 0) pthread_cond_wait(&pool->end, &pool->lock);
    pthread_mutex_unlock(&pool->lock);
    return 0;
}
