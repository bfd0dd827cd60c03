/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* All parts into a new file. The header is that of the source, attribute by attribute, but for the few that must
 * change. A part in which nothing was changed is copied chunk by chunk, whatever it holds: deep samples, levels, lossy
 * pixels stay as they are. Others are compressed on several threads and written in the order of the source. */
#include <errno.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "exr.h"

/* A part on its way out. */
typedef struct outgoing {
    io_part part; /* shallow copy: its channels are the picture's, but for those in `own` */
    io_exr_part layout;
    bool copied;
    bool *own; /* channels that were never read, read here to be written again */
    uint64_t table, *offset;
} outgoing;

typedef struct output {
    const io_picture *picture;
    const io_exr_source *source;
    const char *path; /* for messages */
    FILE *file;
    uint64_t position;
    int code; /* errno of the first failure, 0: none */
    int threads;
    outgoing *part;
    io_error *note, *error;
} output;

static void put(output *o, const void *data, size_t size) {
    if (!o->code && size && fwrite(data, 1, size, o->file) != size) o->code = errno ? errno : EIO;
    o->position += size;
}

static void put_bytes(output *o, io_bytes *bytes) {
    if (bytes->failed && !o->code) o->code = ENOMEM;
    put(o, bytes->data, bytes->size);
    free(bytes->data);
}

static void add_note(output *o, const outgoing *out, const char *text) {
    if (!o->note) return;
    const char *name = o->picture->part_count > 1 ? out->part.name : "";
    io_error before = *o->note;
    io_fail(o->note, "%s%s%s%s%s%s", before.text[0] ? before.text : o->path, before.text[0] ? "; " : ": ",
            name[0] ? "part " : "", name, name[0] ? ": " : "", text);
}

/* ------------------------------------------------------------------------- planning */

/* The part's own list of channels, so that those never read can be read into it; and the types they have by now. */
static int copy_channels(output *o, outgoing *out) {
    size_t count = (size_t)out->part.channel_count;
    io_channel *channels = malloc(count * sizeof *channels);
    bool *own = calloc(count, sizeof *own);
    io_type *types = malloc(count * sizeof *types);
    if (!channels || !own || !types) {
        free(channels);
        free(own);
        free(types);
        return io_fail(o->error, "%s: not enough memory", o->path);
    }
    memcpy(channels, out->part.channel, count * sizeof *channels);
    for (size_t i = 0; i < count; i++)
        types[i] = channels[i].type;
    out->part.channel = channels;
    out->own = own;
    out->layout.type = types;
    return 0;
}

static int plan_encoding(output *o, outgoing *out, int index) {
    io_exr_part *layout = &out->layout;
    bool unread = false, again = false;
    if (copy_channels(o, out) != 0) return -1;
    for (int i = 0; i < out->part.channel_count; i++) {
        const io_channel *channel = &out->part.channel[i];
        unread |= out->own[i] = !channel->data;
        again |= channel->type == IO_HALF && !channel->modified;
    }
    if (unread && io_exr_read_part(o->picture, index, &out->part, out->own, o->error) != 0) {
        memset(out->own, 0, (size_t)out->part.channel_count * sizeof *out->own);
        return -1;
    }
    /* PXR24 does not change what went through it before; B44 nearly never does. */
    if (again && (layout->compression == IO_EXR_B44 || layout->compression == IO_EXR_B44A))
        add_note(o, out, "B44 is lossy, channels that were not changed may differ in their last bits");
    if (layout->compression == IO_EXR_DWAA || layout->compression == IO_EXR_DWAB) {
        layout->compression = IO_EXR_ZIP;
        add_note(o, out, "DWA cannot be written, ZIP was used");
    }
    if (layout->tiled && layout->level_mode != IO_EXR_ONE_LEVEL) {
        layout->level_mode = IO_EXR_ONE_LEVEL;
        add_note(o, out, "smaller levels were dropped, make them anew");
    }
    return io_exr_count_chunks(o->path, layout, o->error);
}

static int plan_part(output *o, int index) {
    outgoing *out = &o->part[index];
    out->part = o->picture->part[index];
    out->layout = o->source->part[index];
    bool made = o->source->file < 0, changed = made;
    if (made)
        out->layout.window = out->part.data;
    else
        out->part.data = out->layout.window; /* as its header says */
    for (int i = 0; i < out->part.channel_count; i++)
        changed |= out->part.channel[i].modified;
    out->copied = out->layout.deep || !changed;
    if (!out->copied && plan_encoding(o, out, index) != 0) /* replaces what it shares with the picture */
        return -1;
    out->offset = calloc((size_t)out->layout.chunk_count, sizeof *out->offset);
    return out->offset ? 0 : io_fail(o->error, "%s: not enough memory", o->path);
}

static void free_plan(outgoing *out) {
    if (out->own) {
        for (int i = 0; i < out->part.channel_count; i++)
            if (out->own[i]) io_channel_release(&out->part.channel[i]);
        free(out->part.channel);
        free(out->layout.type);
        free(out->own);
    }
    free(out->offset);
}

/* ------------------------------------------------------------------------- header */

/* Changes the types in a list of channels: name, type, four bytes, two samplings. */
static void patch_channels(unsigned char *value, const outgoing *out) {
    for (unsigned char *at = value; *at;) {
        const char *name = (const char *)at;
        at += strlen(name) + 1;
        for (int i = 0; i < out->part.channel_count; i++)
            if (strcmp(out->part.channel[i].name, name) == 0)
                io_put32(at, out->layout.type[i] == IO_UINT ? 0 : out->layout.type[i] == IO_HALF ? 1 : 2);
        at += 16;
    }
}

static void append_patched(io_bytes *bytes, const io_exr_attribute *attribute, const outgoing *out) {
    io_exr_append_attribute(bytes, attribute);
    if (bytes->failed || out->copied) return;
    unsigned char *value = bytes->data + (bytes->size - attribute->size);
    if (strcmp(attribute->name, "channels") == 0)
        patch_channels(value, out);
    else if (strcmp(attribute->name, "compression") == 0)
        value[0] = (unsigned char)out->layout.compression;
    else if (strcmp(attribute->name, "tiles") == 0 && out->layout.tiled)
        value[8] = (unsigned char)((value[8] & 0xf0) | out->layout.level_mode);
    else if (strcmp(attribute->name, "chunkCount") == 0 && attribute->size == 4)
        io_put32(value, (uint32_t)out->layout.chunk_count);
}

static void put_header(output *o) {
    io_bytes bytes = {0};
    uint32_t version = o->source->version;
    io_bytes_append32(&bytes, IO_EXR_MAGIC);
    io_bytes_append32(&bytes, version);
    for (int i = 0; i < o->picture->part_count; i++) {
        const outgoing *out = &o->part[i];
        if (o->source->file < 0) {
            io_exr_plain_header(&bytes, &out->part, &out->layout, &out->part.display, (float)out->part.pixel_aspect);
            continue;
        }
        for (int a = 0; a < out->layout.attribute_count; a++)
            append_patched(&bytes, &out->layout.attribute[a], out);
        io_bytes_append_text(&bytes, "");
    }
    if (version & IO_EXR_FLAG_MULTIPART) io_bytes_append_text(&bytes, "");
    put_bytes(o, &bytes);
}

/* First as zeroes, to hold the place; again at the end. */
static void put_tables(output *o) {
    for (int i = 0; i < o->picture->part_count; i++) {
        outgoing *out = &o->part[i];
        io_bytes bytes = {0};
        out->table = o->position;
        for (int c = 0; c < out->layout.chunk_count; c++) {
            unsigned char encoded[8];
            io_put64(encoded, out->offset[c]);
            io_bytes_append(&bytes, encoded, sizeof encoded);
        }
        put_bytes(o, &bytes);
    }
}

/* ------------------------------------------------------------------------- copying */

static int by_offset(const void *a, const void *b) {
    const io_exr_chunk *x = a, *y = b;
    return x->whole_offset < y->whole_offset ? -1 : x->whole_offset > y->whole_offset;
}

static int copy_part(output *o, int index) {
    outgoing *out = &o->part[index];
    enum { STEP = 1 << 20 };
    unsigned char *buffer = malloc(STEP);
    io_exr_chunk *chunks = NULL;
    int result = buffer ? io_exr_locate_chunks(o->picture, index, false, &chunks, o->error)
                        : io_fail(o->error, "%s: not enough memory", o->path);
    if (result == 0) qsort(chunks, (size_t)out->layout.chunk_count, sizeof *chunks, by_offset);
    for (int i = 0; result == 0 && !o->code && i < out->layout.chunk_count; i++) {
        out->offset[chunks[i].index] = o->position;
        for (uint64_t done = 0; result == 0 && done < chunks[i].whole;) {
            uint64_t left = chunks[i].whole - done, step = left < STEP ? left : STEP;
            if (!io_exr_pread(o->source->file, buffer, step, chunks[i].whole_offset + done))
                result = io_exr_bad_chunk(o->picture, index, &chunks[i], true, o->error);
            else
                put(o, buffer, (size_t)step);
            done += step;
        }
    }
    free(chunks);
    free(buffer);
    return result;
}

/* ------------------------------------------------------------------------- compressing */

typedef struct packed_chunk {
    unsigned char *data; /* NULL: not there yet */
    size_t size;
} packed_chunk;

typedef struct encoding {
    output *o;
    int index;
    io_exr_codec *codec;
    packed_chunk *packed; /* by position in the file */
    int written;          /* positions below are in the file */
    int ahead;            /* positions that may be packed before those are written */
    bool writing;         /* one thread is at it */
    bool no_memory;
    atomic_int next;
    pthread_mutex_t mutex;  /* of all the above but `next` */
    pthread_cond_t advance; /* of `written` */
} encoding;

static void put_chunk(encoding *e, const packed_chunk *packed, int position) {
    output *o = e->o;
    outgoing *out = &o->part[e->index];
    unsigned char leader[24], *at = leader;
    io_exr_chunk chunk;
    io_exr_place_chunk(&out->part, &out->layout, io_exr_chunk_at(&out->layout, position), &chunk);
    out->offset[chunk.index] = o->position;
    uint32_t numbers[6] = {(uint32_t)e->index};
    int count = o->source->version & IO_EXR_FLAG_MULTIPART ? 1 : 0;
    if (out->layout.tiled) {
        numbers[count++] = (uint32_t)chunk.tile_x;
        numbers[count++] = (uint32_t)chunk.tile_y;
        numbers[count++] = 0; /* level */
        numbers[count++] = 0;
    } else {
        numbers[count++] = (uint32_t)(out->part.data.y + chunk.y);
    }
    numbers[count++] = (uint32_t)packed->size;
    for (int i = 0; i < count; i++, at += 4)
        io_put32(at, numbers[i]);
    put(o, leader, (size_t)(at - leader));
    put(o, packed->data, packed->size);
}

/* Whoever finishes a chunk writes all that are next in line, unless another thread is doing that already. */
static void hand_in(encoding *e, int position, packed_chunk packed) {
    int count = e->o->part[e->index].layout.chunk_count;
    pthread_mutex_lock(&e->mutex);
    e->packed[position] = packed;
    e->no_memory |= !packed.data;
    if (!e->writing) {
        e->writing = true;
        while (e->written < count && e->packed[e->written].data) {
            int at = e->written;
            pthread_mutex_unlock(&e->mutex);
            put_chunk(e, &e->packed[at], at);
            free(e->packed[at].data);
            pthread_mutex_lock(&e->mutex);
            e->packed[at].data = NULL;
            e->written++;
            pthread_cond_broadcast(&e->advance);
        }
        e->writing = false;
    }
    if (e->no_memory) pthread_cond_broadcast(&e->advance);
    pthread_mutex_unlock(&e->mutex);
}

/* A disk slower than the compression would otherwise leave the picture in memory once more. Whoever has the next position
 * in line never waits. */
static bool await_turn(encoding *e, int position) {
    pthread_mutex_lock(&e->mutex);
    while (position >= e->written + e->ahead && !e->no_memory)
        pthread_cond_wait(&e->advance, &e->mutex);
    const bool go_on = !e->no_memory;
    pthread_mutex_unlock(&e->mutex);
    return go_on;
}

static void encode_chunks(void *data, int unused) {
    (void)unused;
    encoding *e = data;
    const outgoing *out = &e->o->part[e->index];
    io_exr_worker *worker = io_exr_worker_open(e->codec);
    for (int position; (position = atomic_fetch_add(&e->next, 1)) < out->layout.chunk_count;) {
        io_exr_chunk chunk;
        if (!await_turn(e, position)) break;
        io_exr_place_chunk(&out->part, &out->layout, io_exr_chunk_at(&out->layout, position), &chunk);
        const unsigned char *packed = worker ? io_exr_pack(worker, &chunk) : NULL;
        packed_chunk kept = {packed ? malloc((size_t)chunk.packed + 1) : NULL, (size_t)chunk.packed};
        if (kept.data) memcpy(kept.data, packed, kept.size);
        hand_in(e, position, kept);
        if (!kept.data) break;
    }
    io_exr_worker_close(worker);
}

static int encode_part(output *o, int index) {
    outgoing *out = &o->part[index];
    int count = out->layout.chunk_count;
    io_exr_chunk largest;
    io_exr_place_chunk(&out->part, &out->layout, 0, &largest);
    if (largest.unpacked > INT32_MAX)
        return io_fail(o->error,
                       "%s: one block of rows is larger than 2 GiB, which EXR cannot hold; use another "
                       "compression or smaller tiles",
                       o->path);
    encoding e = {.o = o, .index = index, .ahead = 2 * o->threads, .packed = calloc((size_t)count, sizeof *e.packed)};
    if (!e.packed) return io_fail(o->error, "%s: not enough memory", o->path);
    e.codec = io_exr_codec_open(o->path, &out->part, &out->layout, true, o->error);
    int result = e.codec ? 0 : -1;
    if (result == 0) {
        pthread_mutex_init(&e.mutex, NULL);
        pthread_cond_init(&e.advance, NULL);
        io_parallel(o->threads, o->threads < count ? o->threads : count, encode_chunks, &e);
        pthread_cond_destroy(&e.advance);
        pthread_mutex_destroy(&e.mutex);
        if (e.no_memory) result = io_fail(o->error, "%s: not enough memory", o->path);
    }
    for (int i = 0; i < count; i++)
        free(e.packed[i].data);
    free(e.packed);
    io_exr_codec_close(e.codec);
    return result;
}

/* ------------------------------------------------------------------------- the file */

static int write_parts(output *o) {
    int result = 0;
    put_header(o);
    uint64_t tables = o->position;
    put_tables(o);
    for (int i = 0; result == 0 && !o->code && i < o->picture->part_count; i++)
        result = o->part[i].copied ? copy_part(o, i) : encode_part(o, i);
    if (result == 0 && !o->code && fseeko(o->file, (off_t)tables, SEEK_SET) != 0) o->code = errno;
    if (result == 0 && !o->code) put_tables(o);
    return result;
}

int io_exr_write(const io_picture *picture, const char *temporary, const char *path, const io_options *options,
                 io_error *note, io_error *error) {
    output o = {.picture = picture,
                .source = io_exr_source_of(picture),
                .path = path,
                .threads = io_thread_count(options->threads),
                .part = calloc((size_t)picture->part_count, sizeof *o.part),
                .note = note,
                .error = error};
    int result = o.part ? 0 : io_fail(error, "%s: not enough memory", path);
    for (int i = 0; result == 0 && i < picture->part_count; i++)
        result = plan_part(&o, i);
    if (result == 0) {
        o.file = io_open_temporary_stream(temporary);
        if (!o.file) {
            o.code = errno;
        } else {
            setvbuf(o.file, NULL, _IOFBF, 1 << 18);
            result = write_parts(&o);
            if (fclose(o.file) != 0 && !o.code) o.code = errno;
        }
        if (result == 0 && o.code) result = io_fail_write(error, path, o.code);
    }
    for (int i = 0; o.part && i < picture->part_count; i++)
        free_plan(&o.part[i]);
    free(o.part);
    return result;
}
