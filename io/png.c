/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* PNG, by libpng: opening and reading. io/png_write.c writes.
 *
 * Alpha in a PNG is straight; a picture in memory is premultiplied. So colour is decoded to linear, then multiplied by
 * alpha, and on writing divided, then encoded. Colour hidden under alpha 0 is therefore lost (written as 0).
 * The curve: cICP, then sRGB or iCCP (the profile is kept, its curve taken to be sRGB's), then gAMA; none: sRGB.
 * A gAMA within 5 % of 1/2.2 is how sRGB is written in that chunk, and is read as sRGB. */
#include "png_source.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct reader {
    FILE *file;
    png_structp png;
    png_infop info, end;
    io_error message; /* libpng's words, "" for none */
    bool cut;         /* the file ended while libpng wanted more */
    bool no_memory;   /* libpng goes on without a chunk it has no memory for, and only warns */
    uint32_t rows;    /* decoded so far */
    int pass;
    /* What read_rows works on. */
    const io_source *source;
    unsigned char *raw; /* one row, or the whole picture when it is interlaced */
    float *table, *alpha_table;
    float *scratch; /* a row for every channel nobody asked for */
    io_channel *channel;
    bool wanted[4];
} reader;

/* ------------------------------------------------------------------------- libpng without its long jumps */

static void on_error(png_structp png, png_const_charp text) {
    reader *r = png_get_error_ptr(png);
    snprintf(r->message.text, sizeof r->message.text, "%s", text);
    png_longjmp(png, 1);
}

static void on_warning(png_structp png, png_const_charp text) {
    (void)png;
    (void)text;
}

static void *allocate_memory(png_structp png, png_alloc_size_t size) {
    void *memory = malloc(size);
    if (memory == NULL) ((reader *)png_get_mem_ptr(png))->no_memory = true;
    return memory;
}

static void free_memory(png_structp png, void *memory) {
    (void)png;
    free(memory);
}

static void read_bytes(png_structp png, png_bytep out, size_t size) {
    reader *r = png_get_io_ptr(png);
    if (fread(out, 1, size, r->file) == size) return;
    r->cut = !ferror(r->file);
    png_error(png, r->cut ? "the file ends early" : strerror(errno));
}

/* Runs a step that calls libpng. All that a step changes lies in *r, so that nothing is lost by the jump. */
static int guarded(reader *r, void (*step)(reader *)) {
    if (setjmp(png_jmpbuf(r->png))) return -1;
    step(r);
    return 0;
}

static void read_header(reader *r) {
    /* The limits here are wider than io_check_size, whose message is the better one. */
    png_set_user_limits(r->png, PNG_UINT_31_MAX, PNG_UINT_31_MAX);
    png_set_chunk_cache_max(r->png, 4096);
    /* Every ancillary chunk but tRNS comes as raw bytes, its CRC checked, and goes back into the file as it came. */
    png_set_keep_unknown_chunks(r->png, PNG_HANDLE_CHUNK_ALWAYS, NULL, -1);
    png_read_info(r->png, r->info);
}

static int start(reader *r, const io_picture *picture, io_error *error) {
    const char *path = picture->path;
    *r = (reader){.file = io_reopen_stream(picture, error)};
    if (r->file == NULL) return -1;
    int64_t length = io_file_length(r->file);
    r->png = png_create_read_struct_2(PNG_LIBPNG_VER_STRING, r, on_error, on_warning, r, allocate_memory, free_memory);
    if (r->png != NULL) r->info = png_create_info_struct(r->png);
    if (r->info != NULL) r->end = png_create_info_struct(r->png);
    if (r->end == NULL) return io_fail(error, "%s: not enough memory to read it", path);
    png_set_read_fn(r->png, r, read_bytes);
    /* A chunk cannot be longer than the file, so nothing is allocated for a length that lies. */
    png_set_chunk_malloc_max(r->png, length > 0 ? (size_t)length : 1);
    if (guarded(r, read_header) < 0)
        return io_fail(error, "%s: the PNG header is damaged or cut off (%s); export the picture again", path,
                       r->message.text);
    return 0;
}

static void stop(reader *r) {
    if (r->png != NULL) png_destroy_read_struct(&r->png, &r->info, &r->end);
    if (r->file != NULL) fclose(r->file);
    io_block_release(r->source ? &r->source->options : NULL, r->raw);
    free(r->table);
    free(r->alpha_table);
    free(r->scratch);
}

/* ------------------------------------------------------------------------- opening */

static int keep_chunks(io_source *source, reader *r, png_infop info) {
    png_unknown_chunkp chunk;
    int count = png_get_unknown_chunks(r->png, info, &chunk);
    if (count == 0) return 0;
    io_png_chunk *grown = realloc(source->chunk, sizeof *grown * (size_t)(source->chunk_count + count));
    if (grown == NULL) return -1;
    source->chunk = grown;
    for (int i = 0; i < count; i++) {
        io_png_chunk *kept = &source->chunk[source->chunk_count];
        *kept = (io_png_chunk){.size = chunk[i].size, .after_pixels = (chunk[i].location & PNG_AFTER_IDAT) != 0};
        memcpy(kept->name, chunk[i].name, 4);
        kept->data = malloc(kept->size > 0 ? kept->size : 1);
        if (kept->data == NULL) return -1;
        if (kept->size > 0) memcpy(kept->data, chunk[i].data, kept->size);
        source->chunk_count++;
    }
    return 0;
}

const io_png_chunk *io_png_find_chunk(const io_source *source, const char *name) {
    for (int i = 0; i < source->chunk_count; i++)
        if (strcmp(source->chunk[i].name, name) == 0) return &source->chunk[i];
    return NULL;
}

static uint32_t big_endian(const unsigned char *p) {
    return (uint32_t)p[0] << 24 | (uint32_t)p[1] << 16 | (uint32_t)p[2] << 8 | p[3];
}

/* The curve of the file's colour; -1 when it is one this project does not decode. */
static int choose_curve(io_source *source, const char *path, io_error *error) {
    const io_png_chunk *cicp = io_png_find_chunk(source, "cICP");
    source->coding.curve = IO_CURVE_SRGB;
    if (cicp != NULL && cicp->size == 4) return io_curve_of_transfer(&source->coding, cicp->data[1], path, error);
    const io_png_chunk *gama = io_png_find_chunk(source, "gAMA");
    if (gama == NULL || gama->size != 4 || io_png_find_chunk(source, "sRGB") || io_png_find_chunk(source, "iCCP"))
        return 0;
    double power = big_endian(gama->data) / 100000.0;
    /* Beyond these limits neighbouring values of 16 bits would meet, or vanish: such a chunk is nonsense. */
    if (power < 0.2 || power > 10 || fabs(power * 2.2 - 1) < 0.05) return 0;
    source->coding.curve = fabs(power - 1) < 0.0005 ? IO_CURVE_LINEAR : IO_CURVE_POWER;
    source->coding.power = power;
    return 0;
}

static double pixel_aspect(const io_source *source) {
    const io_png_chunk *phys = io_png_find_chunk(source, "pHYs");
    if (phys == NULL || phys->size != 9) return 1;
    double x = big_endian(phys->data), y = big_endian(phys->data + 4); /* pixels a unit of length */
    return x > 0 && y > 0 && y / x > 0.1 && y / x < 10 ? y / x : 1;
}

/* What the header says, against the size of the file: deflate makes at most 1032 bytes of one. */
static int check_header(const io_picture *picture, const io_source *source, reader *r, io_error *error) {
    const char *path = picture->path;
    if (io_check_size(path, source->width, source->height, &source->options, error) < 0) return -1;
    uint64_t row = (uint64_t)png_get_rowbytes(r->png, r->info) + 1, length = (uint64_t)io_file_length(r->file);
    if (row * source->height / 1032 > length)
        return io_fail(error, "%s: says %u x %u pixels, more than its %llu bytes can hold; it is damaged or cut off",
                       path, (unsigned)source->width, (unsigned)source->height, (unsigned long long)length);
    return 0;
}

static int add_part(io_picture *picture, const io_source *source) {
    static const char *const grey[] = {"Y", "A"}, *const rgb[] = {"R", "G", "B", "A"};
    io_box box = {0, 0, (int)source->width, (int)source->height};
    io_part *part = io_add_part(picture, "", "", box, box);
    if (part == NULL) return -1;
    for (int c = 0; c < source->channels; c++) {
        io_channel *channel = io_add_channel(part, source->channels <= 2 ? grey[c] : rgb[c], IO_FLOAT, 1, 1);
        if (channel == NULL) return -1;
        channel->integer = true;
    }
    part->pixel_aspect = pixel_aspect(source);
    part->compression = "deflate";
    part->storage = source->interlaced ? "interlaced" : "scanline";
    part->bits = source->bits;
    part->chunk_bytes = (uint64_t)source->width * (uint64_t)(source->channels * source->bits / 8);
    return 0;
}

static int fill(io_picture *picture, reader *r, io_meaning meaning, io_error *error) {
    io_source *source = picture->source;
    const char *path = picture->path;
    source->width = png_get_image_width(r->png, r->info);
    source->height = png_get_image_height(r->png, r->info);
    if (check_header(picture, source, r, error) < 0) return -1;
    int type = png_get_color_type(r->png, r->info), depth = png_get_bit_depth(r->png, r->info);
    source->palette = type == PNG_COLOR_TYPE_PALETTE;
    source->transparent = png_get_valid(r->png, r->info, PNG_INFO_tRNS) != 0;
    source->file_bits = depth;
    source->bits = depth == 16 ? 16 : 8;
    source->interlaced = png_get_interlace_type(r->png, r->info) != PNG_INTERLACE_NONE;
    source->channels = ((type & PNG_COLOR_MASK_COLOR) != 0 ? 3 : 1) +
                       ((type & PNG_COLOR_MASK_ALPHA) != 0 || source->transparent ? 1 : 0);
    if (keep_chunks(source, r, r->info) < 0) return io_fail(error, "%s: not enough memory for its chunks", path);
    if (meaning == IO_COLOR) {
        source->coding.alpha = source->channels % 2 == 0 ? IO_ALPHA_STRAIGHT : IO_ALPHA_NONE;
        if (choose_curve(source, path, error) < 0) return -1;
    }
    if (add_part(picture, source) < 0) return io_fail(error, "%s: not enough memory", path);
    return 0;
}

static int open_png(io_picture *picture, io_meaning meaning, const io_options *options, io_error *error) {
    reader r;
    int status = start(&r, picture, error);
    if (status == 0 && (picture->source = calloc(1, sizeof *picture->source)) == NULL)
        status = io_fail(error, "%s: not enough memory", picture->path);
    if (status == 0) {
        if (options != NULL) picture->source->options = *options;
        status = fill(picture, &r, meaning, error);
    }
    if (r.no_memory) status = io_fail(error, "%s: not enough memory to read it", picture->path);
    stop(&r);
    return status;
}

/* ------------------------------------------------------------------------- pixels */

static void convert_row(reader *r, const unsigned char *in, uint32_t y) {
    const io_source *source = r->source;
    const int channels = source->channels, width = (int)source->width;
    const int colours = channels <= 2 ? 1 : 3;
    float *row[4];
    for (int c = 0; c < channels; c++) {
        const float *table = c < colours ? r->table : r->alpha_table;
        float *out = row[c] = r->wanted[c] ? (float *)r->channel[c].data + (size_t)y * (size_t)width
                                           : r->scratch + (size_t)c * (size_t)width;
        if (source->bits == 16) {
            const unsigned char *p = in + 2 * c;
            for (int x = 0; x < width; x++, p += 2 * channels)
                out[x] = table[p[0] << 8 | p[1]];
        } else {
            const unsigned char *p = in + c;
            for (int x = 0; x < width; x++, p += channels)
                out[x] = table[*p];
        }
    }
    io_decode_row(&source->coding, row, colours, channels % 2 == 0 ? row[channels - 1] : NULL, width);
}

static void start_rows(reader *r) {
    png_set_expand(r->png);
    if (r->source->interlaced) png_set_interlace_handling(r->png);
    png_read_update_info(r->png, r->info);
    if (png_get_rowbytes(r->png, r->info) !=
        (size_t)r->source->width * (size_t)r->source->channels * (size_t)(r->source->bits / 8))
        png_error(r->png, "it changed since it was opened");
}

static void read_rows(reader *r) {
    const size_t row_bytes = png_get_rowbytes(r->png, r->info);
    const uint32_t height = r->source->height;
    for (r->pass = 0; r->source->interlaced && r->pass < 7; r->pass++)
        for (r->rows = 0; r->rows < height; r->rows++)
            png_read_row(r->png, r->raw + r->rows * row_bytes, NULL);
    for (r->rows = 0; r->rows < height; r->rows++) {
        unsigned char *row = r->source->interlaced ? r->raw + r->rows * row_bytes : r->raw;
        if (!r->source->interlaced) png_read_row(r->png, row, NULL);
        convert_row(r, row, r->rows);
    }
}

static void read_tail(reader *r) {
    png_read_end(r->png, r->end);
}

static int allocate(reader *r, const io_source *source, const char *path, io_error *error) {
    const size_t width = source->width, row = width * (size_t)source->channels * (size_t)(source->bits / 8);
    r->table = io_decode_table(&source->coding, source->bits, true, false);
    r->alpha_table = io_decode_table(&source->coding, source->bits, false, false);
    r->raw = io_block_allocate(&source->options, row * (source->interlaced ? source->height : 1), error, path);
    if (r->raw == NULL) return -1;
    r->scratch = malloc(sizeof(float) * width * (size_t)source->channels);
    if (r->table == NULL || r->alpha_table == NULL || r->scratch == NULL)
        return io_fail(error, "%s: not enough memory to read %u x %u pixels", path, (unsigned)source->width,
                       (unsigned)source->height);
    return 0;
}

static int read_pixels(reader *r, io_source *source, const char *path, io_error *error) {
    if (source->width != png_get_image_width(r->png, r->info) ||
        source->height != png_get_image_height(r->png, r->info) || guarded(r, start_rows) < 0)
        return io_fail(error, "%s: it changed since it was opened; try again", path);
    if (allocate(r, source, path, error) < 0) return -1;
    if (guarded(r, read_rows) < 0) {
        const char *what = r->cut ? "is cut off" : "is damaged";
        if (source->interlaced && r->pass < 7)
            return io_fail(error, "%s: %s at row %u of interlacing pass %d of 7 (%s); get the file again", path, what,
                           (unsigned)r->rows, r->pass + 1, r->message.text);
        return io_fail(error, "%s: %s at row %u of %u (%s); get the file again", path, what, (unsigned)r->rows,
                       (unsigned)source->height, r->message.text);
    }
    if (guarded(r, read_tail) < 0)
        return io_fail(error, "%s: %s after the last row (%s); get the file again", path,
                       r->cut ? "is cut off" : "is damaged", r->message.text);
    if (!source->has_tail && keep_chunks(source, r, r->end) < 0)
        return io_fail(error, "%s: not enough memory for its chunks", path);
    source->has_tail = true;
    return 0;
}

static int read_png(io_picture *picture, int part_index, const char *const *names, int name_count, io_error *error) {
    io_part *part = &picture->part[part_index];
    io_source *source = picture->source;
    reader r;
    int status = start(&r, picture, error), wanted = 0;
    r.source = source;
    r.channel = part->channel;
    for (int c = 0; status == 0 && c < part->channel_count; c++) {
        if (part->channel[c].data != NULL || !io_name_wanted(part->channel[c].name, names, name_count)) continue;
        status = io_channel_allocate(&part->channel[c], picture->memory, error, picture->path);
        r.wanted[c] = status == 0;
        wanted++;
    }
    if (status == 0 && wanted > 0) status = read_pixels(&r, source, picture->path, error);
    if (r.no_memory) status = io_fail(error, "%s: not enough memory to read it", picture->path);
    stop(&r);
    return status;
}

/* ------------------------------------------------------------------------- the rest of the table */

static bool matches_png(const unsigned char *head, size_t size) {
    return size >= 8 && memcmp(head, "\x89PNG\r\n\x1a\n", 8) == 0;
}

static int create_png(io_picture *picture, io_meaning meaning, io_error *error) {
    io_part *part = &picture->part[0];
    const io_channel *channel[4];
    if (part->bits != 8 && part->bits != 16)
        return io_fail(error, "%s: PNG has 8 or 16 bits, not %d", picture->path, part->bits);
    int channels = io_plain_channels(part, channel);
    if (channels == 0)
        return io_fail(error, "%s: PNG holds the channels Y, Y A, R G B or R G B A; write an EXR for others",
                       picture->path);
    io_source *source = picture->source = calloc(1, sizeof *source);
    if (source == NULL) return io_fail(error, "%s: not enough memory", picture->path);
    source->created = true;
    source->bits = source->file_bits = part->bits;
    source->channels = channels;
    if (meaning == IO_COLOR) {
        source->coding.curve = IO_CURVE_SRGB;
        source->coding.alpha = IO_ALPHA_STRAIGHT;
    }
    part->compression = "deflate";
    part->storage = "scanline";
    return 0;
}

static void close_png(io_picture *picture) {
    io_source *source = picture->source;
    if (source == NULL) return;
    for (int i = 0; i < source->chunk_count; i++)
        free(source->chunk[i].data);
    free(source->chunk);
    free(source);
    picture->source = NULL;
}

const io_handler io_png = {
    .format = IO_PNG,
    .matches = matches_png,
    .open = open_png,
    .read = read_png,
    .create = create_png,
    .write = io_png_write,
    .close = close_png,
};
