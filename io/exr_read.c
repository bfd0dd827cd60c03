/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* All chunks of a part into its channels, on several threads. */
#include <limits.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "exr.h"
#include "exr_dwa.h"

/* ------------------------------------------------------------------------- chunk by chunk */

typedef struct reading {
    const io_picture *picture;
    const io_exr_chunk *chunks;
    const bool *wanted;
    io_exr_codec *codec;
    int file, count;
    atomic_int next;
    atomic_int first_bad; /* index, `count`: none */
    atomic_bool no_memory;
} reading;

static void report_bad(reading *r, int index) {
    int known = atomic_load(&r->first_bad);
    while (index < known && !atomic_compare_exchange_weak(&r->first_bad, &known, index))
        ;
}

/* Whether any of these rows, counted from the first of the data, is to be read. */
static bool rows_wanted(const io_picture *picture, int row, int rows) {
    return picture->rows == 0 || (row < (int64_t)picture->row + picture->rows && (int64_t)row + rows > picture->row);
}

/* Takes chunks until there are none, or one was bad. Chunks are taken in order, so every one before a bad one is tried.
 */
static void read_chunks(void *data, int unused) {
    (void)unused;
    reading *r = data;
    io_exr_worker *worker = io_exr_worker_open(r->codec);
    if (!worker) atomic_store(&r->no_memory, true);
    for (int i; worker && (i = atomic_fetch_add(&r->next, 1)) < atomic_load(&r->first_bad);) {
        const io_exr_chunk *chunk = &r->chunks[i];
        if (!rows_wanted(r->picture, chunk->y, chunk->height)) continue;
        unsigned char *packed = io_exr_packed_buffer(worker, chunk);
        if (!packed) {
            atomic_store(&r->no_memory, true);
            break;
        }
        if (!io_exr_pread(r->file, packed, chunk->packed, chunk->offset) ||
            io_exr_unpack(worker, chunk, r->wanted) != 0)
            report_bad(r, i);
    }
    io_exr_worker_close(worker);
}

static int read_flat(const io_picture *picture, int index, const io_part *part, const bool *wanted,
                     const io_exr_chunk *chunks, io_error *error) {
    const io_exr_source *source = io_exr_source_of(picture);
    const io_exr_part *layout = &source->part[index];
    reading r = {
        .picture = picture, .chunks = chunks, .wanted = wanted, .file = source->file, .count = layout->flat_count};
    atomic_init(&r.first_bad, r.count);
    if (!(r.codec = io_exr_codec_open(picture->path, part, layout, false, error))) return -1;
    int threads = io_thread_count(source->options.threads);
    io_parallel(threads, threads < r.count ? threads : r.count, read_chunks, &r);
    io_exr_codec_close(r.codec);
    int bad = atomic_load(&r.first_bad);
    if (atomic_load(&r.no_memory)) return io_fail(error, "%s: not enough memory", picture->path);
    if (bad < r.count) return io_exr_bad_chunk(picture, index, &chunks[bad], false, error);
    return 0;
}

/* ------------------------------------------------------------------------- DWA */

#ifdef IO_HAVE_DWA

/* Level 0 of the part as a file of its own, in memory: its header is ours, its chunks are checked. */
static int make_plain_file(const io_picture *picture, int index, const io_exr_chunk *chunks, io_bytes *file,
                           io_error *error) {
    const io_exr_source *source = io_exr_source_of(picture);
    const io_exr_part *layout = &source->part[index];
    io_bytes header = {0};
    io_bytes_append32(&header, IO_EXR_MAGIC);
    io_bytes_append32(&header, IO_EXR_VERSION | IO_EXR_FLAG_LONG_NAMES | (layout->tiled ? IO_EXR_FLAG_TILED : 0));
    io_exr_plain_header(&header, &picture->part[index], layout, &picture->part[index].data, 1);
    uint64_t at = header.size + 8 * (uint64_t)layout->flat_count, end = at;
    size_t leader = layout->tiled ? 20 : 8;
    for (int i = 0; i < layout->flat_count; i++)
        end += leader + chunks[i].packed;
    if (header.failed) io_fail(error, "%s: not enough memory", picture->path);
    unsigned char *data =
        header.failed ? NULL : io_block_allocate(&source->options, (size_t)end, error, picture->path);
    if (data) memcpy(data, header.data, header.size);
    free(header.data);
    if (!data) return -1;
    file->data = data;
    file->size = header.size;
    for (int i = 0; i < layout->flat_count; i++) {
        io_put64(data + file->size + 8 * (size_t)i, at);
        if (layout->tiled) {
            io_put32(data + at, (uint32_t)chunks[i].tile_x);
            io_put32(data + at + 4, (uint32_t)chunks[i].tile_y);
            memset(data + at + 8, 0, 8);
        } else {
            io_put32(data + at, (uint32_t)(layout->window.y + chunks[i].y));
        }
        io_put32(data + at + leader - 4, (uint32_t)chunks[i].packed);
        if (!io_exr_pread(source->file, data + at + leader, chunks[i].packed, chunks[i].offset))
            return io_exr_bad_chunk(picture, index, &chunks[i], true, error);
        at += leader + chunks[i].packed;
    }
    file->size = (size_t)end;
    return 0;
}

typedef struct dwa_reading {
    const io_picture *picture;
    const io_bytes *file;
    const io_part *part;
    const io_exr_slice *slices;
    int slice_count;
    int band; /* lines a task decodes: a row of chunks */
    pthread_mutex_t mutex;
    int bad;          /* the first band that failed, INT_MAX: none */
    char reason[200]; /* why */
} dwa_reading;

static void read_band(void *data, int index) {
    dwa_reading *r = data;
    const io_box *w = &r->part->data;
    int top = w->y + index * r->band, left = w->height - index * r->band;
    int bottom = top + (r->band < left ? r->band : left) - 1;
    if (!rows_wanted(r->picture, index * r->band, r->band)) return;
    char reason[sizeof r->reason];
    if (io_exr_dwa_decode(r->file->data, r->file->size, w->x, w->y, top, bottom, r->slices, r->slice_count, reason,
                          sizeof reason) == 0)
        return;
    pthread_mutex_lock(&r->mutex);
    if (index < r->bad) {
        r->bad = index;
        memcpy(r->reason, reason, sizeof reason);
    }
    pthread_mutex_unlock(&r->mutex);
}

static int read_bands(dwa_reading *r, const io_picture *picture, const io_exr_part *layout, io_error *error) {
    int height = r->part->data.height, lines = layout->tiled ? layout->tile_height : layout->lines;
    r->band = lines < height ? lines : height;
    pthread_mutex_init(&r->mutex, NULL);
    io_parallel(io_exr_source_of(picture)->options.threads, (height - 1) / r->band + 1, read_band, r);
    pthread_mutex_destroy(&r->mutex);
    if (r->bad == INT_MAX) return 0;
    int top = r->part->data.y + r->bad * r->band, left = height - r->bad * r->band;
    return io_fail(error, "%s: rows %d to %d are damaged (%s); copy or write the file again", picture->path, top,
                   top + (r->band < left ? r->band : left) - 1, r->reason);
}

static int read_dwa(const io_picture *picture, int index, const io_part *part, const bool *wanted,
                    const io_exr_chunk *chunks, io_error *error) {
    static const int types[] = {[IO_UINT] = 0, [IO_HALF] = 1, [IO_FLOAT] = 2};
    const io_exr_part *layout = &io_exr_source_of(picture)->part[index];
    io_exr_slice *slices = calloc((size_t)part->channel_count, sizeof *slices);
    io_bytes file = {0};
    dwa_reading r = {.picture = picture, .file = &file, .part = part, .slices = slices, .bad = INT_MAX};
    int result = slices ? 0 : io_fail(error, "%s: not enough memory", picture->path);
    for (int i = 0; slices && i < part->channel_count; i++) {
        const io_channel *c = &part->channel[i];
        if (wanted[i])
            slices[r.slice_count++] =
                (io_exr_slice){c->name, types[layout->type[i]], c->x_sampling, c->y_sampling, c->width, c->data};
    }
    if (result == 0) result = make_plain_file(picture, index, chunks, &file, error);
    if (result == 0) result = read_bands(&r, picture, layout, error);
    io_block_release(&io_exr_source_of(picture)->options, file.data);
    free(slices);
    return result;
}

#else

static int read_dwa(const io_picture *picture, int index, const io_part *part, const bool *wanted,
                    const io_exr_chunk *chunks, io_error *error) {
    (void)index, (void)wanted, (void)chunks;
    return io_fail(error, "%s: is compressed as %s, which this build cannot read; write it as ZIP or PIZ",
                   picture->path, part->compression);
}

#endif

/* ------------------------------------------------------------------------- a part */

int io_exr_read_part(const io_picture *picture, int index, io_part *part, const bool *wanted, io_error *error) {
    const io_exr_part *layout = &io_exr_source_of(picture)->part[index];
    bool dwa = layout->compression == IO_EXR_DWAA || layout->compression == IO_EXR_DWAB;
    io_exr_chunk *chunks;
    /* Before any memory is taken: a file that is cut off is told from its chunk table. */
    if (io_exr_locate_chunks(picture, index, true, &chunks, error) != 0) return -1;
    uint64_t bytes = 0;
    for (int i = 0; i < part->channel_count; i++)
        if (wanted[i]) bytes += io_channel_bytes(&part->channel[i]);
    const io_memory *memory = picture->memory;
    int result = memory ? 0 : io_check_memory(picture->path, bytes, error);
    for (int i = 0; result == 0 && i < part->channel_count; i++)
        if (wanted[i]) result = io_channel_allocate(&part->channel[i], memory, error, picture->path);
    if (result == 0) result = (dwa ? read_dwa : read_flat)(picture, index, part, wanted, chunks, error);
    for (int i = 0; result != 0 && i < part->channel_count; i++)
        if (wanted[i]) io_channel_release(&part->channel[i]);
    free(chunks);
    return result;
}
