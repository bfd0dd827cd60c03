/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "block.h"

#include <sched.h>
#include <string.h>

#include "../image.h"

#if defined(__x86_64__)
#define spin_pause() __builtin_ia32_pause()
#elif defined(__aarch64__)
#define spin_pause() __asm__ volatile("yield")
#else
#define spin_pause() ((void)0)
#endif

enum { SPINS = 2000 };

void *arena_take(arena *a, size_t bytes) {
    void *p = a->base ? a->base + a->used : NULL;
    a->used += (bytes + LINE - 1) / LINE * LINE;
    return p;
}

int block_count(int height, int rows) {
    return (height + rows - 1) / rows;
}

void block_room_take(block_room *room, arena *a, int width, int lanes) {
    const size_t wide = (size_t)width + PAD, n = (size_t)lanes, f = sizeof(float);
    room->pixels = arena_take(a, wide * n * 4 * f);
    room->coc = arena_take(a, wide * (n + 1) * f);
    room->capacity = arena_take(a, (wide + 1) * n * f);
}

const float *block_coc_row(const cpu_frame *f, int y, float *room) {
    const frame_job *job = f->job;
    if (f->coc_direct) return image_at(&job->coc_source, 0, 0, y);
    plane_load(&job->coc_source, 0, 0, y, f->width, room, f->k->pixels);
    if (job->is_depth)
        f->k->pixels->lens(&job->curve, room, room, f->width, job->frame->offset_x, y + job->frame->offset_y);
    return room;
}

void block_load_pixels(const cpu_frame *f, cpu_rows *in, const block_room *room, int y, int count) {
    in->width = f->width;
    in->count = count;
    in->capacity = NULL;
    for (int r = 0; r < f->lanes; r++) {
        in->row_alive[r] = 1;
        if (r >= count) {
            in->pixel[r] = in->pixel[count - 1];
            continue;
        }
        float *copy = room->pixels + ((ptrdiff_t)f->width + PAD) * 4 * r;
        in->pixel[r] = copy;
        if (f->rows && f->rows[y + r])
            in->pixel[r] = f->rows[y + r];
        else if (f->source_direct)
            in->pixel[r] = image_at(&f->source, 0, 0, y + r);
        else
            span_load(&f->source, 0, y + r, f->width, copy, f->straight_in, f->k->pixels);
    }
}

void block_load_coc(const cpu_frame *f, cpu_rows *in, const block_room *room, int y) {
    for (int r = 0; r < f->lanes; r++)
        in->coc[r] = r < in->count ? block_coc_row(f, y + r, room->coc + ((ptrdiff_t)f->width + PAD) * r)
                                   : in->coc[in->count - 1];
}

int64_t block_find_holes(const cpu_frame *f, cpu_rows *in, const block_room *room) {
    const ptrdiff_t wide = f->width + PAD, lanes = f->lanes;
    int64_t all = 0;
    for (ptrdiff_t i = 0; i < (wide + 1) * lanes; i++)
        room->capacity[i] = 1;
    for (int r = 0; r < in->count; r++) {
        float *row = room->pixels + wide * 4 * r;
        int64_t holes = 0;
        if (in->pixel[r] != row) memcpy(row, in->pixel[r], (size_t)f->width * 4 * sizeof(float));
        for (ptrdiff_t x = 0; x < f->width; x++) {
            float *p = row + 4 * x;
            if (finite_value(p[0]) && finite_value(p[1]) && finite_value(p[2]) && finite_value(p[3]) &&
                finite_value(in->coc[r][x]))
                continue;
            memset(p, 0, 4 * sizeof *p);
            room->capacity[x * lanes + r] = 0;
            holes++;
        }
        in->pixel[r] = row;
        in->row_alive[r] = holes < f->width;
        all += holes;
    }
    for (ptrdiff_t r = in->count; r < lanes; r++) { /* the padding rows follow the last one */
        in->pixel[r] = in->pixel[in->count - 1];
        for (ptrdiff_t x = 0; x < f->width; x++)
            room->capacity[x * lanes + r] = room->capacity[x * lanes + in->count - 1];
    }
    in->capacity = room->capacity;
    return all;
}

bool block_wait(const ddof_context *ctx, const atomic_int *done, int wanted) {
    for (int i = 0; atomic_load_explicit(done, memory_order_acquire) < wanted; i++) {
        if (atomic_load_explicit(&ctx->cancelled, memory_order_relaxed)) return false;
        if (i < SPINS)
            spin_pause();
        else
            sched_yield();
    }
    return true;
}
