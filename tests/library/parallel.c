/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "parallel.h"

#include <pthread.h>

int parallel_serial(void *user, int count, ddof_task task, void *task_data) {
    (void)user;
    for (int i = 0; i < count; i++)
        task(task_data, i, 0);
    return 0;
}

int parallel_reversed(void *user, int count, ddof_task task, void *task_data) {
    (void)user;
    for (int i = count - 1; i >= 0; i--)
        task(task_data, i, PARALLEL_THREADS - 1 - i % PARALLEL_THREADS);
    return 0;
}

typedef struct loop {
    pthread_mutex_t lock;
    int left, workers;
    ddof_task task;
    void *data;
} loop;

static void *run(void *argument) {
    loop *l = argument;
    pthread_mutex_lock(&l->lock);
    const int worker = l->workers++;
    while (l->left > 0) {
        const int index = --l->left;
        pthread_mutex_unlock(&l->lock);
        l->task(l->data, index, worker);
        pthread_mutex_lock(&l->lock);
    }
    pthread_mutex_unlock(&l->lock);
    return NULL;
}

int parallel_threads(void *user, int count, ddof_task task, void *task_data) {
    loop l = {.left = count, .task = task, .data = task_data};
    pthread_t thread[PARALLEL_THREADS];
    int started = 0;
    (void)user;
    pthread_mutex_init(&l.lock, NULL);
    while (started < PARALLEL_THREADS && pthread_create(&thread[started], NULL, run, &l) == 0)
        started++;
    for (int i = 0; i < started; i++)
        pthread_join(thread[i], NULL);
    pthread_mutex_destroy(&l.lock);
    return started == 0;
}

int parallel_refused(void *user, int count, ddof_task task, void *task_data) {
    (void)user, (void)count, (void)task, (void)task_data;
    return 1;
}
