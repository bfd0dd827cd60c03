/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Where pixels lie in an EXR file: chunks of scanlines or tiles, each behind a leader that names it, found through a
 * table of offsets. Nothing of that is believed before it was compared with what the header implies and with the file's
 * length. */
#include <errno.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "exr.h"

enum { MOST_LEVELS = 32 };

static int ceil_div(int a, int b) {
    return a / b + (a % b != 0);
}

/* ------------------------------------------------------------------------- counting */

static int lines_per_chunk(int compression) {
    static const int lines[IO_EXR_COMPRESSIONS] = {1, 1, 1, 16, 32, 16, 32, 32, 32, 256};
    return lines[compression];
}

/* The limits are those of the codecs: 127 bytes in 2, deflate's 1032:1 (PXR24 drops a byte of four before it), 256
 * samples in 10 bits, a block of 32 bytes in 3; DWA has none worth naming. */
uint64_t io_exr_most_unpacked(int compression) {
    static const uint64_t most[IO_EXR_COMPRESSIONS] = {1, 64, 1040, 1040, 512, 1400, 11, 11, 65536, 65536};
    return most[compression];
}

static int level_count(int size, bool round_up) {
    int count = 1;
    for (int64_t side = 1; round_up ? side < size : side * 2 <= size; side *= 2)
        count++;
    return count;
}

static int level_size(int size, int level, bool round_up) {
    int64_t scale = INT64_C(1) << level;
    int64_t scaled = round_up ? (size + scale - 1) / scale : size / scale;
    return scaled < 1 ? 1 : (int)scaled;
}

static int64_t tiles_of_level(const io_exr_part *layout, int x, int y) {
    int width = level_size(layout->window.width, x, layout->round_up);
    int height = level_size(layout->window.height, y, layout->round_up);
    return (int64_t)ceil_div(width, layout->tile_width) * ceil_div(height, layout->tile_height);
}

int io_exr_count_chunks(const char *path, io_exr_part *layout, io_error *error) {
    int64_t all = 0, flat;
    if (!layout->tiled) {
        layout->lines = lines_per_chunk(layout->compression);
        all = flat = ceil_div(layout->window.height, layout->lines);
    } else {
        int w = layout->window.width, h = layout->window.height;
        int columns = level_count(w, layout->round_up), rows = level_count(h, layout->round_up);
        flat = tiles_of_level(layout, 0, 0);
        if (layout->level_mode == IO_EXR_ONE_LEVEL)
            all = flat;
        else if (layout->level_mode == IO_EXR_MIPMAP)
            for (int level = 0; level < (columns > rows ? columns : rows); level++)
                all += tiles_of_level(layout, level, level);
        else
            for (int y = 0; y < rows; y++)
                for (int x = 0; x < columns; x++)
                    all += tiles_of_level(layout, x, y);
    }
    if (all > INT32_MAX / 8)
        return io_fail(error, "%s: has %lld tiles, which is too many; write it with larger tiles", path,
                       (long long)all);
    layout->chunk_count = (int32_t)all;
    layout->flat_count = (int32_t)flat;
    return 0;
}

int io_exr_channel_rows(const io_channel *channel, int y, int height, int *first) {
    /* The data window begins at a multiple of the sampling: the parser saw to it. */
    int s = channel->y_sampling;
    *first = ceil_div(y, s);
    return ceil_div(y + height, s) - *first;
}

void io_exr_place_chunk(const io_part *part, const io_exr_part *layout, int index, io_exr_chunk *chunk) {
    const io_box *w = &part->data;
    *chunk = (io_exr_chunk){.index = index, .width = w->width};
    if (layout->tiled) {
        int columns = ceil_div(w->width, layout->tile_width);
        chunk->tile_x = index % columns;
        chunk->tile_y = index / columns;
        /* Below 2^31: a second tile exists only where one is smaller than the picture. */
        chunk->x = chunk->tile_x * layout->tile_width;
        chunk->y = chunk->tile_y * layout->tile_height;
        chunk->width = layout->tile_width < w->width - chunk->x ? layout->tile_width : w->width - chunk->x;
        chunk->height = layout->tile_height < w->height - chunk->y ? layout->tile_height : w->height - chunk->y;
    } else {
        chunk->y = index * layout->lines;
        chunk->height = layout->lines < w->height - chunk->y ? layout->lines : w->height - chunk->y;
    }
    for (int i = 0; i < part->channel_count; i++) {
        const io_channel *channel = &part->channel[i];
        int first, rows = io_exr_channel_rows(channel, chunk->y, chunk->height, &first);
        chunk->unpacked +=
            (uint64_t)rows * (uint64_t)(chunk->width / channel->x_sampling) * io_type_size(layout->type[i]);
    }
}

int io_exr_chunk_at(const io_exr_part *layout, int position) {
    if (layout->line_order != IO_EXR_DECREASING_Y) return position;
    if (!layout->tiled) return layout->flat_count - 1 - position;
    int columns = ceil_div(layout->window.width, layout->tile_width), rows = layout->flat_count / columns;
    return (rows - 1 - position / columns) * columns + position % columns;
}

/* ------------------------------------------------------------------------- finding */

bool io_exr_pread(int file, void *data, uint64_t size, uint64_t offset) {
    unsigned char *to = data;
    while (size > 0) {
        size_t step = size < (1u << 30) ? (size_t)size : 1u << 30;
        ssize_t got = offset > INT64_MAX ? 0 : pread(file, to, step, (off_t)offset);
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) return false;
        to += got;
        offset += (uint64_t)got;
        size -= (uint64_t)got;
    }
    return true;
}

int io_exr_read_table(const io_picture *picture, int index, io_error *error) {
    io_exr_source *source = io_exr_source_of(picture);
    io_exr_part *layout = &source->part[index];
    if (layout->offset) return 0;
    size_t count = (size_t)layout->chunk_count;
    uint64_t *offset = malloc(count * sizeof *offset);
    if (!offset) return io_fail(error, "%s: not enough memory", picture->path);
    if (!io_exr_pread(source->file, offset, count * sizeof *offset, layout->table)) {
        free(offset);
        return io_fail(error, "%s: cannot be read any more; was it changed meanwhile?", picture->path);
    }
    for (size_t i = 0; i < count; i++)
        offset[i] = io_get64((const unsigned char *)&offset[i]);
    layout->offset = offset;
    return 0;
}

/* The one line about a chunk that is not there or not what it should be. */
int io_exr_bad_chunk(const io_picture *picture, int index, const io_exr_chunk *chunk, bool missing, io_error *error) {
    const io_part *part = &picture->part[index];
    const io_exr_part *layout = &io_exr_source_of(picture)->part[index];
    bool several = picture->part_count > 1 && part->name[0];
    const char *what = missing ? "missing" : "damaged", *in = several ? " of part " : "",
               *name = several ? part->name : "";
    const char *remedy = missing ? "the file is cut off, copy or write it again" : "copy or write the file again";
    if (chunk->index >= layout->flat_count)
        return io_fail(error, "%s: a smaller level%s%s is %s; %s", picture->path, in, name, what, remedy);
    int top = chunk->y + part->data.y;
    if (layout->tiled)
        return io_fail(error, "%s: rows %d to %d, columns %d to %d%s%s are %s; %s", picture->path, top,
                       top + chunk->height - 1, chunk->x + part->data.x, chunk->x + part->data.x + chunk->width - 1, in,
                       name, what, remedy);
    return io_fail(error, "%s: rows %d to %d%s%s are %s; %s", picture->path, top, top + chunk->height - 1, in, name,
                   what, remedy);
}

/* The leader: [part] y or (tile x, tile y, level x, level y), then the size of the data; of deep data the sizes of the
 * sample table, the data, and the data unpacked. */
int io_exr_locate_chunk(const io_picture *picture, int part, int index, io_exr_chunk *chunk, io_error *error) {
    const io_exr_source *source = io_exr_source_of(picture);
    const io_exr_part *layout = &source->part[part];
    bool multipart = source->version & IO_EXR_FLAG_MULTIPART, flat = index < layout->flat_count;
    if (flat)
        io_exr_place_chunk(&picture->part[part], layout, index, chunk);
    else
        *chunk = (io_exr_chunk){.index = index};

    unsigned char leader[4 + 16 + 24], *at = leader;
    size_t coordinates = layout->tiled ? 16 : 4, size = (multipart ? 4 : 0) + coordinates + (layout->deep ? 24 : 4);
    uint64_t start = layout->offset[index], length = source->length;
    /* Nothing lies before the end of the tables; writers that are interrupted leave zeroes in them. */
    if (start < source->part[source->part_count - 1].table || start > length || size > length - start)
        return io_exr_bad_chunk(picture, part, chunk, true, error);
    if (!io_exr_pread(source->file, leader, size, start)) return io_exr_bad_chunk(picture, part, chunk, true, error);
    bool right = true;
    if (multipart) {
        right = io_get32(at) == (uint32_t)part;
        at += 4;
    }
    if (flat && layout->tiled)
        right = right && io_get32(at) == (uint32_t)chunk->tile_x && io_get32(at + 4) == (uint32_t)chunk->tile_y &&
                io_get32(at + 8) == 0 && io_get32(at + 12) == 0;
    else if (flat)
        right = right && io_get32(at) == (uint32_t)(layout->window.y + chunk->y);
    at += coordinates;
    uint64_t data = layout->deep ? io_get64(at + 8) : io_get32(at), samples = layout->deep ? io_get64(at) : 0;
    if (!right || data > INT64_MAX || samples > INT64_MAX || (!layout->deep && data > INT32_MAX))
        return io_exr_bad_chunk(picture, part, chunk, false, error);
    if (data > length - start - size || samples > length - start - size - data)
        return io_exr_bad_chunk(picture, part, chunk, true, error);
    /* So a part that is copied without being looked into is one that can be opened again. */
    if (flat && !layout->deep && data < chunk->unpacked / io_exr_most_unpacked(layout->compression))
        return io_exr_bad_chunk(picture, part, chunk, false, error);
    chunk->offset = start + size;
    chunk->packed = data;
    chunk->whole_offset = start;
    chunk->whole = size + samples + data;
    return 0;
}

int io_exr_locate_chunks(const io_picture *picture, int part, bool flat_only, io_exr_chunk **chunks, io_error *error) {
    const io_exr_source *source = io_exr_source_of(picture);
    const io_exr_part *layout = &source->part[part];
    int count = flat_only ? layout->flat_count : layout->chunk_count;
    *chunks = NULL;
    if (io_exr_read_table(picture, part, error) != 0) return -1;
    io_exr_chunk *located = malloc((size_t)count * sizeof *located);
    if (!located) return io_fail(error, "%s: not enough memory", picture->path);
    uint64_t sum = 0;
    int result = 0;
    for (int i = 0; result == 0 && i < count; i++) {
        result = io_exr_locate_chunk(picture, part, i, &located[i], error);
        sum += located[i].whole;
        /* Chunks that share bytes would let a small file become a huge one. */
        if (result == 0 && sum > source->length) result = io_exr_bad_chunk(picture, part, &located[i], false, error);
    }
    if (result == 0)
        *chunks = located;
    else
        free(located);
    return result;
}
