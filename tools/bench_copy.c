/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "bench_copy.h"

#include <pthread.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "message.h"

typedef struct copier {
    copy_crew *crew;
    pthread_t thread;
    int index;
    double begin, end;
} copier;

struct copy_crew {
    int threads, started; /* the caller is the first; `started` counts the others */
    copier *copiers;
    pthread_mutex_t lock;
    pthread_cond_t wake, done;
    int round, working;
    bool stop;
    char *to;
    const char *from;
    size_t bytes;
};

static void copy_share(copier *c) {
    copy_crew *crew = c->crew;
    /* whole cache lines, so that no two threads write to one */
    size_t lines = (crew->bytes + 63) / 64, threads = (size_t)crew->threads, index = (size_t)c->index;
    size_t first = lines * index / threads * 64, last = lines * (index + 1) / threads * 64;
    if (last > crew->bytes) last = crew->bytes;
    c->begin = now_ms();
    if (last > first) memcpy(crew->to + first, crew->from + first, last - first);
    c->end = now_ms();
}

static void *copier_main(void *data) {
    copier *c = data;
    copy_crew *crew = c->crew;
    int round = 0;
    pthread_mutex_lock(&crew->lock);
    for (;;) {
        while (crew->round == round && !crew->stop)
            pthread_cond_wait(&crew->wake, &crew->lock);
        if (crew->stop) break;
        round = crew->round;
        pthread_mutex_unlock(&crew->lock);
        copy_share(c);
        pthread_mutex_lock(&crew->lock);
        if (--crew->working == 0) pthread_cond_signal(&crew->done);
    }
    pthread_mutex_unlock(&crew->lock);
    return NULL;
}

copy_crew *copy_crew_create(int threads) {
    copy_crew *crew = calloc(1, sizeof *crew);
    if (!crew) return NULL;
    crew->threads = threads < 1 ? 1 : threads;
    crew->copiers = calloc((size_t)crew->threads, sizeof *crew->copiers);
    pthread_mutex_init(&crew->lock, NULL);
    pthread_cond_init(&crew->wake, NULL);
    pthread_cond_init(&crew->done, NULL);
    bool good = crew->copiers != NULL;
    for (int i = 0; good && i < crew->threads; i++) {
        crew->copiers[i].crew = crew;
        crew->copiers[i].index = i;
        if (i == 0) continue;
        good = pthread_create(&crew->copiers[i].thread, NULL, copier_main, &crew->copiers[i]) == 0;
        crew->started += good;
    }
    if (!good) {
        copy_crew_destroy(crew);
        return NULL;
    }
    return crew;
}

void copy_crew_destroy(copy_crew *crew) {
    if (!crew) return;
    pthread_mutex_lock(&crew->lock);
    crew->stop = true;
    pthread_cond_broadcast(&crew->wake);
    pthread_mutex_unlock(&crew->lock);
    for (int i = 1; i <= crew->started; i++)
        pthread_join(crew->copiers[i].thread, NULL);
    pthread_mutex_destroy(&crew->lock);
    pthread_cond_destroy(&crew->wake);
    pthread_cond_destroy(&crew->done);
    free(crew->copiers);
    free(crew);
}

double copy_crew_run(copy_crew *crew, void *to, const void *from, size_t bytes) {
    pthread_mutex_lock(&crew->lock);
    crew->to = to;
    crew->from = from;
    crew->bytes = bytes;
    crew->working = crew->threads - 1;
    crew->round++;
    pthread_cond_broadcast(&crew->wake);
    pthread_mutex_unlock(&crew->lock);
    copy_share(&crew->copiers[0]);
    pthread_mutex_lock(&crew->lock);
    while (crew->working > 0)
        pthread_cond_wait(&crew->done, &crew->lock);
    pthread_mutex_unlock(&crew->lock);
    double begin = crew->copiers[0].begin, end = crew->copiers[0].end;
    for (int i = 1; i < crew->threads; i++) {
        if (crew->copiers[i].begin < begin) begin = crew->copiers[i].begin;
        if (crew->copiers[i].end > end) end = crew->copiers[i].end;
    }
    return end - begin;
}
