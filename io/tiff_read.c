/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include <stdlib.h>
#include <string.h>

#include "tiff_source.h"

typedef struct reader {
    io_tiff_file file;
    const io_source *source;
    const char *path;
    io_channel *channel;
    bool wanted[IO_TIFF_MOST_SAMPLES];
    unsigned char *raw;      /* a block of each plane */
    size_t plane_bytes;      /* of such a block */
    size_t row_bytes;        /* of its rows */
    float *table[3], *plain; /* integer samples up to 16 bits: colour (a palette has three), and all others */
    float *scratch;          /* a row of a block for every channel nobody asked for */
} reader;

/* ------------------------------------------------------------------------- samples */

/* Sample number `index` of a row, for sizes that are not whole bytes; the first sample lies in the high bits. */
static uint32_t get_bits(const unsigned char *row, size_t index, int bits) {
    uint32_t value = 0;
    size_t at = index * (size_t)bits;
    for (int i = 0; i < bits; i++, at++)
        value = value << 1 | (row[at / 8] >> (7 - at % 8) & 1u);
    return value;
}

/* `count` samples of channel c, `step` apart in the row from sample number `first` on. */
static void load_integers(const reader *r, const unsigned char *row, size_t first, size_t step, int c, int count,
                          float *out) {
    const int bits = r->source->bits;
    const bool colour = c < r->source->colours;
    const float *table = !colour ? r->plain : r->table[r->source->palette != NULL ? c : 0];
    if (bits == 8) {
        for (int x = 0; x < count; x++)
            out[x] = table[row[first + (size_t)x * step]];
    } else if (bits == 16) {
        const uint16_t *in = (const uint16_t *)row;
        for (int x = 0; x < count; x++)
            out[x] = table[in[first + (size_t)x * step]];
    } else if (bits < 16) {
        for (int x = 0; x < count; x++)
            out[x] = table[get_bits(row, first + (size_t)x * step, bits)];
    } else {
        const uint32_t *in = (const uint32_t *)row;
        const io_coding *coding = &r->source->coding;
        const bool curve = colour && coding->alpha != IO_ALPHA_ASSOCIATED,
                   inverted = r->source->photometric == 0 && colour;
        for (int x = 0; x < count; x++) {
            uint32_t v = in[first + (size_t)x * step];
            float encoded = (float)((double)(inverted ? ~v : v) / 4294967295.0);
            out[x] = curve ? io_decode(coding, encoded) : encoded;
        }
    }
}

static void load(const reader *r, const unsigned char *row, size_t first, size_t step, int c, int count, float *out) {
    switch (r->source->kind) {
    case IO_TIFF_UINT:
        load_integers(r, row, first, step, c, count, out);
        break;
    case IO_TIFF_HALF:
        for (int x = 0; x < count; x++)
            io_half_to_float((const uint16_t *)row + first + (size_t)x * step, out + x, 1, 1);
        break;
    case IO_TIFF_FLOAT:
        for (int x = 0; x < count; x++)
            out[x] = ((const float *)row)[first + (size_t)x * step];
        break;
    case IO_TIFF_DOUBLE:
        for (int x = 0; x < count; x++)
            out[x] = (float)((const double *)row)[first + (size_t)x * step];
        break;
    }
}

/* A row of the block that begins at column x of the picture. */
static void convert_row(const reader *r, int block_row, int x, int y, int count) {
    const io_source *source = r->source;
    float *row[IO_TIFF_MOST_SAMPLES];
    for (int c = 0; c < source->channels; c++) {
        const io_channel *channel = &r->channel[c];
        const int sample = source->palette != NULL ? 0 : c, plane = source->separate ? sample : 0;
        const unsigned char *in = r->raw + (size_t)plane * r->plane_bytes + (size_t)block_row * r->row_bytes;
        row[c] = r->wanted[c] ? (float *)channel->data + (size_t)y * source->width + (size_t)x
                              : r->scratch + (size_t)c * source->block_width;
        load(r, in, source->separate ? 0 : (size_t)sample, source->separate ? 1 : source->samples, c, count, row[c]);
    }
    io_decode_row(&source->coding, row, source->colours, source->alpha >= 0 ? row[source->alpha] : NULL, count);
}

/* ------------------------------------------------------------------------- blocks */

static int read_block(reader *r, uint32_t x, uint32_t y, uint32_t rows, io_error *error) {
    const io_source *source = r->source;
    TIFF *tiff = r->file.tiff;
    const size_t bytes = r->row_bytes * (source->tiled ? source->block_height : rows);
    for (int p = 0; p < (source->separate ? source->samples : 1); p++) {
        unsigned char *out = r->raw + (size_t)p * r->plane_bytes;
        const tmsize_t got =
            source->tiled ? TIFFReadEncodedTile(tiff, TIFFComputeTile(tiff, x, y, 0, (uint16_t)p), out, (tmsize_t)bytes)
                          : TIFFReadEncodedStrip(tiff, TIFFComputeStrip(tiff, y, (uint16_t)p), out, (tmsize_t)bytes);
        if (got == (tmsize_t)bytes && r->file.damage.text[0] == '\0') continue;
        const char *why = r->file.message.text[0] != '\0' ? r->file.message.text : r->file.damage.text;
        return io_fail(error, "%s: rows %u to %u are damaged or cut off (%s); get the file again", r->path, (unsigned)y,
                       (unsigned)(y + rows - 1), why[0] != '\0' ? why : "too few bytes");
    }
    return 0;
}

static int read_blocks(reader *r, io_error *error) {
    const io_source *source = r->source;
    for (uint32_t y = 0; y < source->height; y += source->block_height) {
        const uint32_t rows = source->height - y < source->block_height ? source->height - y : source->block_height;
        for (uint32_t x = 0; x < source->width; x += source->block_width) {
            const uint32_t count = source->width - x < source->block_width ? source->width - x : source->block_width;
            if (read_block(r, x, y, rows, error) < 0) return -1;
            for (uint32_t row = 0; row < rows; row++)
                convert_row(r, (int)row, (int)x, (int)(y + row), (int)count);
        }
    }
    return 0;
}

/* ------------------------------------------------------------------------- preparations */

/* A colour table of a palette: its entries have 16 bits. */
static float *palette_table(const io_source *source, int c) {
    float *values = io_decode_table(&source->coding, 16, true, false);
    const size_t size = (size_t)1 << source->bits;
    float *table = malloc(sizeof *table * size);
    if (values != NULL && table != NULL)
        for (size_t i = 0; i < size; i++)
            table[i] = values[source->palette[(size_t)c * size + i]];
    else {
        free(table);
        table = NULL;
    }
    free(values);
    return table;
}

static int make_tables(reader *r) {
    const io_source *source = r->source;
    if (source->kind != IO_TIFF_UINT || source->bits > 16) return 0;
    if (source->palette != NULL) {
        for (int c = 0; c < 3; c++)
            if ((r->table[c] = palette_table(source, c)) == NULL) return -1;
        return 0;
    }
    r->table[0] = io_decode_table(&source->coding, source->bits, true, source->photometric == PHOTOMETRIC_MINISWHITE);
    r->plain = io_decode_table(&source->coding, source->bits, false, false);
    return r->table[0] == NULL || r->plain == NULL ? -1 : 0;
}

/* The file is opened a second time; it may have been changed between. */
static int check_same(reader *r, io_error *error) {
    const io_source *source = r->source;
    TIFF *tiff = r->file.tiff;
    uint32_t width = 0, height = 0, rows = 0;
    uint16_t bits = 0, samples = 0, planar = PLANARCONFIG_CONTIG;
    TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &width);
    TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &height);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_BITSPERSAMPLE, &bits);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLESPERPIXEL, &samples);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_PLANARCONFIG, &planar);
    TIFFGetFieldDefaulted(tiff, source->tiled ? TIFFTAG_TILELENGTH : TIFFTAG_ROWSPERSTRIP, &rows);
    if (rows > height && !source->tiled) rows = height;
    if (width != source->width || height != source->height || bits != source->bits || samples != source->samples ||
        rows != source->block_height || (planar == PLANARCONFIG_SEPARATE && samples > 1) != source->separate ||
        (TIFFIsTiled(tiff) != 0) != source->tiled)
        return io_fail(error, "%s: it changed since it was opened; try again", r->path);
    if (source->photometric == PHOTOMETRIC_YCBCR) TIFFSetField(tiff, TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB);
    const size_t in_row = source->separate ? 1 : source->samples;
    r->row_bytes = ((size_t)source->block_width * in_row * source->bits + 7) / 8;
    r->plane_bytes = r->row_bytes * source->block_height;
    if ((tmsize_t)r->row_bytes != (source->tiled ? TIFFTileRowSize(tiff) : TIFFScanlineSize(tiff)))
        return io_fail(error, "%s: its rows are laid out in a way that is not supported; save it as plain RGB or grey",
                       r->path);
    return 0;
}

static int prepare(reader *r, io_error *error) {
    const io_source *source = r->source;
    if (check_same(r, error) < 0) return -1;
    r->raw = io_block_allocate(&source->options, r->plane_bytes * (source->separate ? source->samples : 1), error, r->path);
    if (r->raw == NULL) return -1;
    r->scratch = malloc(sizeof(float) * (size_t)source->channels * source->block_width);
    if (make_tables(r) < 0 || r->scratch == NULL)
        return io_fail(error, "%s: not enough memory to read %u x %u pixels", r->path, (unsigned)source->width,
                       (unsigned)source->height);
    return 0;
}

int io_tiff_read(io_picture *picture, int part_index, const char *const *names, int name_count, io_error *error) {
    io_part *part = &picture->part[part_index];
    reader r = {.source = picture->source, .path = picture->path, .channel = part->channel, .file = {.descriptor = -1}};
    int status = 0, wanted = 0;
    for (int c = 0; status == 0 && c < part->channel_count; c++) {
        if (part->channel[c].data != NULL || !io_name_wanted(part->channel[c].name, names, name_count)) continue;
        status = io_channel_allocate(&part->channel[c], picture->memory, error, picture->path);
        r.wanted[c] = true;
        wanted++;
    }
    if (status == 0 && wanted > 0) status = io_tiff_read_file(&r.file, picture, error);
    if (status == 0 && wanted > 0) status = prepare(&r, error);
    if (status == 0 && wanted > 0) status = read_blocks(&r, error);
    io_tiff_close_file(&r.file);
    io_block_release(&r.source->options, r.raw);
    free(r.scratch);
    free(r.plain);
    for (int i = 0; i < 3; i++)
        free(r.table[i]);
    return status;
}
