/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Chunks <-> planar channels. A chunk holds, line after line, the samples of each channel, little-endian, channels
 * sorted by name; compressed as a whole by OpenEXRCore.
 *
 * The library is given a context made from a header written here, never the file: its parser and its chunk tables do
 * not meet foreign bytes, only its decompressors do. Its own copying between chunks and channels is not used either: of
 * subsampled channels it counts the lines wrongly where the sampling does not divide the chunk (3.1.5: coding.c). */
#include <stdlib.h>
#include <string.h>

#include <openexr.h>

#include "exr.h"
#include "exr_zip.h"

/* Deflate levels above this one cost time and gain next to nothing on picture data; it is OpenEXR's own default too. */
enum { DEFLATE_LEVEL = 4 };

struct io_exr_codec {
    exr_context_t context; /* NULL: nothing is compressed */
    const io_part *part;
    const io_exr_part *layout;
    bool encode;
    io_bytes header; /* what the library reads */
};

struct io_exr_worker {
    const io_exr_codec *codec;
    bool started; /* the pipeline is initialised */
    exr_decode_pipeline_t decode;
    exr_encode_pipeline_t encode;
    exr_result_t (*compress)(exr_encode_pipeline_t *); /* the library's */
    io_exr_zip *zip;                                   /* instead of the library, where there is one */
    unsigned char *packed, *unpacked;                  /* a chunk, where the library has no say */
    size_t packed_room, unpacked_room;
    const io_exr_chunk *chunk; /* at work */
    const bool *wanted;
};

/* ------------------------------------------------------------------------- samples */

static void copy_samples(void *to, const void *from, size_t bytes, size_t sample) {
#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
    const unsigned char *in = from;
    unsigned char *out = to;
    for (size_t i = 0; i < bytes; i += sample)
        for (size_t b = 0; b < sample; b++)
            out[i + b] = in[i + sample - 1 - b];
#else
    (void)sample;
    memcpy(to, from, bytes);
#endif
}

/* Calls for each run of samples in the order of the chunk; `packed` walks along. Unpacks into the channels or packs
 * them. */
static void walk_samples(const io_exr_worker *worker, unsigned char *packed) {
    const io_part *part = worker->codec->part;
    const io_exr_part *layout = worker->codec->layout;
    const io_exr_chunk *chunk = worker->chunk;
    for (int y = chunk->y; y < chunk->y + chunk->height; y++)
        for (int i = 0; i < part->channel_count; i++) {
            int c = layout->order[i];
            const io_channel *channel = &part->channel[c];
            if (y % channel->y_sampling) continue;
            size_t sample = io_type_size(layout->type[c]);
            size_t bytes = (size_t)(chunk->width / channel->x_sampling) * sample;
            size_t row = (size_t)(y / channel->y_sampling), column = (size_t)(chunk->x / channel->x_sampling);
            unsigned char *data = channel->data;
            if (worker->codec->encode)
                copy_samples(packed, data + (row * (size_t)channel->width + column) * sample, bytes, sample);
            else if (worker->wanted[c])
                copy_samples(data + (row * (size_t)channel->width + column) * sample, packed, bytes, sample);
            packed += bytes;
        }
}

/* ------------------------------------------------------------------------- contexts */

static void silent(exr_const_context_t context, exr_result_t code, const char *message) {
    (void)context, (void)code, (void)message;
}

static int64_t read_header(exr_const_context_t context, void *user, void *buffer, uint64_t size, uint64_t offset,
                           exr_stream_error_func_ptr_t fail) {
    const io_bytes *header = user;
    (void)context, (void)fail;
    if (offset >= header->size) return 0;
    uint64_t left = header->size - offset;
    memcpy(buffer, header->data + offset, (size_t)(size < left ? size : left));
    return (int64_t)(size < left ? size : left);
}

static int64_t write_nowhere(exr_const_context_t context, void *user, const void *buffer, uint64_t size,
                             uint64_t offset, exr_stream_error_func_ptr_t fail) {
    (void)context, (void)user, (void)buffer, (void)offset, (void)fail;
    return (int64_t)size;
}

static exr_result_t start_decoding(io_exr_codec *codec) {
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = silent;
    init.user_data = &codec->header;
    init.read_fn = read_header;
    uint32_t flags = IO_EXR_FLAG_LONG_NAMES | (codec->layout->tiled ? IO_EXR_FLAG_TILED : 0);
    io_bytes_append32(&codec->header, IO_EXR_MAGIC);
    io_bytes_append32(&codec->header, IO_EXR_VERSION | flags);
    io_exr_plain_header(&codec->header, codec->part, codec->layout, &codec->part->data, 1);
    return codec->header.failed ? EXR_ERR_OUT_OF_MEMORY : exr_start_read(&codec->context, "chunks", &init);
}

static exr_result_t start_encoding(io_exr_codec *codec) {
    static const exr_pixel_type_t types[] = {
        [IO_UINT] = EXR_PIXEL_UINT, [IO_HALF] = EXR_PIXEL_HALF, [IO_FLOAT] = EXR_PIXEL_FLOAT};
    const io_exr_part *layout = codec->layout;
    const io_box *w = &codec->part->data;
    exr_attr_box2i_t window = {.min = {.x = w->x, .y = w->y},
                               .max = {.x = w->x + w->width - 1, .y = w->y + w->height - 1}};
    exr_attr_v2f_t center = {.x = 0, .y = 0};
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = silent;
    init.write_fn = write_nowhere;
    init.zip_level = DEFLATE_LEVEL;
    int index;
    exr_result_t r = exr_start_write(&codec->context, "chunks", EXR_WRITE_FILE_DIRECTLY, &init);
    if (r == EXR_ERR_SUCCESS) r = exr_set_longname_support(codec->context, 1);
    if (r == EXR_ERR_SUCCESS)
        r = exr_add_part(codec->context, "chunks", layout->tiled ? EXR_STORAGE_TILED : EXR_STORAGE_SCANLINE, &index);
    if (r == EXR_ERR_SUCCESS)
        r = exr_initialize_required_attr(codec->context, 0, &window, &window, 1, &center, 1, EXR_LINEORDER_INCREASING_Y,
                                         (exr_compression_t)layout->compression);
    if (r == EXR_ERR_SUCCESS && layout->tiled)
        r = exr_set_tile_descriptor(codec->context, 0, (uint32_t)layout->tile_width, (uint32_t)layout->tile_height,
                                    EXR_TILE_ONE_LEVEL, EXR_TILE_ROUND_DOWN);
    for (int i = 0; r == EXR_ERR_SUCCESS && i < codec->part->channel_count; i++) {
        int c = layout->order[i];
        const io_channel *channel = &codec->part->channel[c];
        r = exr_add_channel(codec->context, 0, channel->name, types[layout->type[c]],
                            layout->linear[c] ? EXR_PERCEPTUALLY_LINEAR : EXR_PERCEPTUALLY_LOGARITHMIC,
                            channel->x_sampling, channel->y_sampling);
    }
    return r == EXR_ERR_SUCCESS ? exr_write_header(codec->context) : r;
}

io_exr_codec *io_exr_codec_open(const char *path, const io_part *part, const io_exr_part *layout, bool encode,
                                io_error *error) {
    io_exr_codec *codec = calloc(1, sizeof *codec);
    if (!codec) {
        io_fail(error, "%s: not enough memory", path);
        return NULL;
    }
    codec->part = part;
    codec->layout = layout;
    codec->encode = encode;
    if (layout->compression == IO_EXR_NONE) return codec;
    exr_result_t r = encode ? start_encoding(codec) : start_decoding(codec);
    if (r == EXR_ERR_SUCCESS) return codec;
    io_fail(error, "%s: OpenEXR refuses this layout of channels (%s); write the picture in another way", path,
            exr_get_default_error_message(r));
    io_exr_codec_close(codec);
    return NULL;
}

void io_exr_codec_close(io_exr_codec *codec) {
    if (!codec) return;
    if (codec->context) exr_finish(&codec->context);
    free(codec->header.data);
    free(codec);
}

/* ------------------------------------------------------------------------- workers */

io_exr_worker *io_exr_worker_open(const io_exr_codec *codec) {
    io_exr_worker *worker = calloc(1, sizeof *worker);
    if (!worker) return NULL;
    const bool zip = codec->layout->compression == IO_EXR_ZIP || codec->layout->compression == IO_EXR_ZIPS;
    worker->codec = codec;
    if (!io_exr_has_zip || !zip || (worker->zip = io_exr_zip_open(DEFLATE_LEVEL))) return worker;
    free(worker);
    return NULL;
}

void io_exr_worker_close(io_exr_worker *worker) {
    if (!worker) return;
    if (worker->started && worker->codec->encode)
        exr_encoding_destroy(worker->codec->context, &worker->encode);
    else if (worker->started)
        exr_decoding_destroy(worker->codec->context, &worker->decode);
    io_exr_zip_close(worker->zip);
    free(worker->packed);
    free(worker->unpacked);
    free(worker);
}

static unsigned char *reserve(unsigned char **buffer, size_t *room, uint64_t size) {
    if (size > *room || !*buffer) {
        free(*buffer);
        *room = (size_t)(size + size / 4 + 64);
        *buffer = malloc(*room);
        if (!*buffer) *room = 0;
    }
    return *buffer;
}

unsigned char *io_exr_packed_buffer(io_exr_worker *worker, const io_exr_chunk *chunk) {
    return reserve(&worker->packed, &worker->packed_room, chunk->packed);
}

static exr_chunk_info_t chunk_info(const io_exr_worker *worker, const io_exr_chunk *chunk) {
    const io_exr_part *layout = worker->codec->layout;
    return (exr_chunk_info_t){.idx = chunk->index,
                              .start_x = layout->tiled ? chunk->tile_x : layout->window.x,
                              .start_y = layout->tiled ? chunk->tile_y : layout->window.y + chunk->y,
                              .width = chunk->width,
                              .height = chunk->height,
                              .type = layout->tiled ? EXR_STORAGE_TILED : EXR_STORAGE_SCANLINE,
                              .compression = (uint8_t)layout->compression,
                              .packed_size = chunk->packed,
                              .unpacked_size = chunk->unpacked};
}

/* The library's decompressors walk the lines by these numbers. */
static void set_channel_sizes(const io_exr_worker *worker, const io_exr_chunk *chunk, exr_coding_channel_info_t *info) {
    static uint8_t unused[4];
    const io_part *part = worker->codec->part;
    for (int i = 0; i < part->channel_count; i++) {
        const io_channel *channel = &part->channel[worker->codec->layout->order[i]];
        int first;
        info[i].height = io_exr_channel_rows(channel, chunk->y, chunk->height, &first);
        info[i].width = chunk->width / channel->x_sampling;
        /* Never followed, but without it the library declines. */
        info[i].decode_to_ptr = unused;
        info[i].user_pixel_stride = info[i].bytes_per_element;
        info[i].user_line_stride = info[i].width * info[i].bytes_per_element;
    }
}

/* ------------------------------------------------------------------------- decoding */

static exr_result_t already_read(exr_decode_pipeline_t *pipeline) {
    (void)pipeline;
    return EXR_ERR_SUCCESS;
}

static exr_result_t unpack_samples(exr_decode_pipeline_t *pipeline) {
    walk_samples(pipeline->decoding_user_data, pipeline->unpacked_buffer);
    return EXR_ERR_SUCCESS;
}

static exr_result_t decompress(io_exr_worker *worker, const io_exr_chunk *chunk) {
    exr_const_context_t context = worker->codec->context;
    exr_chunk_info_t info = chunk_info(worker, chunk);
    exr_decode_pipeline_t *p = &worker->decode;
    exr_result_t r =
        worker->started ? exr_decoding_update(context, 0, &info, p) : exr_decoding_initialize(context, 0, &info, p);
    if (r != EXR_ERR_SUCCESS) return r;
    set_channel_sizes(worker, chunk, p->channels);
    if (!worker->started) {
        worker->started = true;
        r = exr_decoding_choose_default_routines(context, 0, p);
        p->decoding_user_data = worker;
        p->read_fn = already_read;
        p->unpack_and_convert_fn = unpack_samples;
    }
    p->packed_buffer = worker->packed; /* with packed_alloc_size 0: not the library's to free */
    return r == EXR_ERR_SUCCESS ? exr_decoding_run(context, 0, p) : r;
}

int io_exr_unpack(io_exr_worker *worker, const io_exr_chunk *chunk, const bool *wanted) {
    int compression = worker->codec->layout->compression;
    bool b44 = compression == IO_EXR_B44 || compression == IO_EXR_B44A;
    worker->chunk = chunk;
    worker->wanted = wanted;
    /* Chunks that compression would not make smaller are stored as they are. Some writers of B44 do not know that rule.
     */
    if (chunk->packed == chunk->unpacked) {
        walk_samples(worker, worker->packed);
        return 0;
    }
    if (compression == IO_EXR_NONE || chunk->packed == 0 || (chunk->packed > chunk->unpacked && !b44)) return -1;
    if (worker->zip) {
        unsigned char *unpacked = reserve(&worker->unpacked, &worker->unpacked_room, chunk->unpacked);
        if (!unpacked || !io_exr_zip_unpack(worker->zip, worker->packed, chunk->packed, unpacked, chunk->unpacked))
            return -1;
        walk_samples(worker, unpacked);
        return 0;
    }
    return decompress(worker, chunk) == EXR_ERR_SUCCESS ? 0 : -1;
}

/* ------------------------------------------------------------------------- encoding */

/* The samples are gathered in the next step, which runs outside of the library's lock. */
static exr_result_t announce_samples(exr_encode_pipeline_t *pipeline) {
    const io_exr_worker *worker = pipeline->encoding_user_data;
    pipeline->packed_bytes = worker->chunk->unpacked;
    return EXR_ERR_SUCCESS;
}

static exr_result_t pack_and_compress(exr_encode_pipeline_t *pipeline) {
    io_exr_worker *worker = pipeline->encoding_user_data;
    walk_samples(worker, pipeline->packed_buffer);
    return worker->compress(pipeline);
}

static exr_result_t compress(io_exr_worker *worker, const io_exr_chunk *chunk) {
    exr_const_context_t context = worker->codec->context;
    exr_chunk_info_t info = chunk_info(worker, chunk);
    exr_encode_pipeline_t *p = &worker->encode;
    exr_result_t r =
        worker->started ? exr_encoding_update(context, 0, &info, p) : exr_encoding_initialize(context, 0, &info, p);
    if (r != EXR_ERR_SUCCESS) return r;
    set_channel_sizes(worker, chunk, p->channels);
    if (!worker->started) {
        worker->started = true;
        r = exr_encoding_choose_default_routines(context, 0, p);
        p->encoding_user_data = worker;
        worker->compress = p->compress_fn;
        p->convert_and_pack_fn = announce_samples;
        p->compress_fn = pack_and_compress;
        p->yield_until_ready_fn = NULL;
        p->write_fn = NULL;
    }
    return r == EXR_ERR_SUCCESS ? exr_encoding_run(context, 0, p) : r;
}

static const unsigned char *pack_by_library(io_exr_worker *worker, io_exr_chunk *chunk) {
    if (compress(worker, chunk) != EXR_ERR_SUCCESS) return NULL;
    if (worker->encode.compressed_bytes >= chunk->unpacked) return worker->encode.packed_buffer;
    chunk->packed = worker->encode.compressed_bytes;
    return worker->encode.compressed_buffer;
}

const unsigned char *io_exr_pack(io_exr_worker *worker, io_exr_chunk *chunk) {
    worker->chunk = chunk;
    chunk->packed = chunk->unpacked; /* what compression does not make smaller is stored as it is */
    if (worker->codec->context && !worker->zip && chunk->unpacked > 0) return pack_by_library(worker, chunk);
    unsigned char *unpacked = reserve(&worker->unpacked, &worker->unpacked_room, chunk->unpacked);
    if (!unpacked || (worker->zip && !io_exr_zip_reserve(worker->zip, (size_t)chunk->unpacked))) return NULL;
    walk_samples(worker, unpacked);
    size_t size;
    const unsigned char *packed =
        worker->zip ? io_exr_zip_pack(worker->zip, unpacked, (size_t)chunk->unpacked, &size) : NULL;
    if (!packed) return unpacked;
    chunk->packed = size;
    return packed;
}
