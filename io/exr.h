/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Inside io/exr*.c only.
 *
 * The container (header, chunk tables, chunk leaders) is read and written here, byte by byte, so that whatever a file
 * says about itself is checked before it is believed, and is copied as it was, also what this program does not know.
 * OpenEXRCore is the codec: it sees a header of our own making (exr_codec.c) and one chunk at a time.
 *
 *   exr_header.c   bytes <-> attributes <-> io_exr_part
 *   exr_layout.c   which chunk holds which pixels, where it lies in the file, whether it is there
 *   exr_codec.c    packed chunk <-> pixels of planar channels
 *   exr_read.c     all chunks of a part, on several threads
 *   exr_write.c    all parts into a new file: copied, or compressed on several threads and written in order
 *   exr_dwa.cpp    DWA, which the C library cannot
 *
 * The format: https://openexr.com/en/latest/OpenEXRFileLayout.html */
#ifndef IO_EXR_H
#define IO_EXR_H

#include "format.h"

enum {
    IO_EXR_MAGIC = 20000630,
    IO_EXR_VERSION = 2,
    /* Flags in the version field. */
    IO_EXR_FLAG_TILED = 0x200, /* one part, flat, tiled */
    IO_EXR_FLAG_LONG_NAMES = 0x400,
    IO_EXR_FLAG_DEEP = 0x800,
    IO_EXR_FLAG_MULTIPART = 0x1000
};

/* Values of the attribute "compression". */
enum {
    IO_EXR_NONE,
    IO_EXR_RLE,
    IO_EXR_ZIPS,
    IO_EXR_ZIP,
    IO_EXR_PIZ,
    IO_EXR_PXR24,
    IO_EXR_B44,
    IO_EXR_B44A,
    IO_EXR_DWAA,
    IO_EXR_DWAB,
    IO_EXR_COMPRESSIONS
};

enum { IO_EXR_INCREASING_Y, IO_EXR_DECREASING_Y, IO_EXR_RANDOM_Y };
enum { IO_EXR_ONE_LEVEL, IO_EXR_MIPMAP, IO_EXR_RIPMAP };

typedef struct io_exr_attribute {
    const char *name, *type; /* in the header's bytes */
    const unsigned char *value;
    uint32_t size;
} io_exr_attribute;

/* What a header says about the layout of its part. */
typedef struct io_exr_part {
    io_exr_attribute *attribute; /* in the order of the file */
    int attribute_count;
    bool tiled, deep;
    int compression, line_order;
    io_box window;               /* data window */
    int lines;                   /* of a scanline chunk */
    int tile_width, tile_height; /* tiled only, as are the next two */
    int level_mode;
    bool round_up;
    int32_t chunk_count; /* of all levels */
    int32_t flat_count;  /* of level 0, which comes first */
    uint64_t table;      /* where the chunk table lies in the file */
    uint64_t *offset;    /* the chunk table; NULL until io_exr_read_table() */
    int channel_count;
    int *order;    /* channels by name: the order of the samples in a chunk */
    io_type *type; /* in the file, by channel of the io_part; the one in memory may be another by now */
    bool *linear;  /* perceptually linear (pLinear), by channel of the io_part */
} io_exr_part;

/* picture->source of an EXR picture. */
typedef struct io_exr_source {
    int file; /* the picture's */
    uint64_t length;
    uint32_t version; /* with flags */
    unsigned char *header;
    size_t header_size;
    int part_count;
    io_exr_part *part;
    io_options options;
} io_exr_source;

static inline io_exr_source *io_exr_source_of(const io_picture *picture) {
    return (io_exr_source *)picture->source;
}

/* ---- bytes, little-endian in the file on every machine */

typedef struct io_bytes {
    unsigned char *data;
    size_t size, room;
    bool failed; /* out of memory: everything appended since is lost */
} io_bytes;

void io_bytes_append(io_bytes *bytes, const void *data, size_t size);
void io_bytes_append32(io_bytes *bytes, uint32_t value);
void io_bytes_append_text(io_bytes *bytes, const char *text); /* with its NUL */
uint32_t io_get32(const unsigned char *bytes);
uint64_t io_get64(const unsigned char *bytes);
void io_put32(unsigned char *bytes, uint32_t value);
void io_put64(unsigned char *bytes, uint64_t value);

/* ---- exr_header.c */

/* Parses source->header and ->version into source->part and picture->part. With `complete` false the bytes are the
 * beginning of a longer header; then 1 means that more of them are needed. */
int io_exr_parse(io_picture *picture, io_exr_source *source, bool complete, io_error *error);
void io_exr_append_attribute(io_bytes *bytes, const io_exr_attribute *attribute);
const io_exr_attribute *io_exr_find(const io_exr_part *part, const char *name);
void io_exr_free_parts(io_exr_source *source);
const char *io_exr_compression_name(int compression);
/* The header of a file with this one part and nothing in it but what codecs need: what OpenEXR is shown instead of the
 * file. */
void io_exr_plain_header(io_bytes *bytes, const io_part *part, const io_exr_part *layout, const io_box *display,
                         float pixel_aspect);
/* Fills layout->order. */
int io_exr_sort_channels(const char *path, const io_part *part, io_exr_part *layout, io_error *error);

/* ---- exr_layout.c */

typedef struct io_exr_chunk {
    int index;
    int x, y, width, height; /* pixels, from the top-left corner of the data window */
    int tile_x, tile_y;
    uint64_t unpacked;            /* bytes of its samples */
    uint64_t offset, packed;      /* of its compressed bytes in the file */
    uint64_t whole, whole_offset; /* with its leader */
} io_exr_chunk;

/* How many bytes one packed byte can become at most. */
uint64_t io_exr_most_unpacked(int compression);
/* Fills chunk_count, flat_count, lines. */
int io_exr_count_chunks(const char *path, io_exr_part *layout, io_error *error);
/* The part of the picture that chunk `index` of level 0 covers. */
void io_exr_place_chunk(const io_part *part, const io_exr_part *layout, int index, io_exr_chunk *chunk);
/* Rows of a channel within `height` lines from line y on (from the top of the data window), and the first of them. */
int io_exr_channel_rows(const io_channel *channel, int y, int height, int *first);
/* The index of the chunk that is written as number `position` into a file with the line order of the part. */
int io_exr_chunk_at(const io_exr_part *layout, int position);
/* Reads the chunk table. */
int io_exr_read_table(const io_picture *picture, int part, io_error *error);
/* Reads the leader of chunk `index` (of any level) and checks it against the file. */
int io_exr_locate_chunk(const io_picture *picture, int part, int index, io_exr_chunk *chunk, io_error *error);
/* Locates all chunks; `flat_only`: those of level 0. Free *chunks. */
int io_exr_locate_chunks(const io_picture *picture, int part, bool flat_only, io_exr_chunk **chunks, io_error *error);
/* The line about a chunk that is not there, or not what it should be. Returns -1. */
int io_exr_bad_chunk(const io_picture *picture, int part, const io_exr_chunk *chunk, bool missing, io_error *error);
/* pread() of all of it; false when the file ends before. */
bool io_exr_pread(int file, void *data, uint64_t size, uint64_t offset);

/* ---- exr_codec.c: one per part, shared by threads; one io_exr_worker per thread */

typedef struct io_exr_codec io_exr_codec;
typedef struct io_exr_worker io_exr_worker;

io_exr_codec *io_exr_codec_open(const char *path, const io_part *part, const io_exr_part *layout, bool encode,
                                io_error *error);
void io_exr_codec_close(io_exr_codec *codec);
io_exr_worker *io_exr_worker_open(const io_exr_codec *codec);
void io_exr_worker_close(io_exr_worker *worker);
/* Where to put chunk->packed bytes before unpacking; NULL: out of memory. */
unsigned char *io_exr_packed_buffer(io_exr_worker *worker, const io_exr_chunk *chunk);
/* Writes the samples of the chunk into the wanted channels of the part. -1: the data are damaged, or out of memory. */
int io_exr_unpack(io_exr_worker *worker, const io_exr_chunk *chunk, const bool *wanted);
/* Compresses the chunk and sets chunk->packed. The result belongs to the worker until its next call. NULL: out of
 * memory. */
const unsigned char *io_exr_pack(io_exr_worker *worker, io_exr_chunk *chunk);

/* ---- exr_read.c, exr_write.c */

/* Reads the channels that `wanted` says, by index, into part->channel[].data, which it allocates. `part` may be a copy.
 */
int io_exr_read_part(const io_picture *picture, int index, io_part *part, const bool *wanted, io_error *error);
int io_exr_write(const io_picture *picture, const char *temporary, const char *path, const io_options *options,
                 io_error *note, io_error *error);

#endif
