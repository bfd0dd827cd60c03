/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Writing TIFF: sample format, bits, planes, strips or tiles, compression and predictor of the file the picture came
 * from, by libtiff into a bare file; then its metadata and further pages are appended as they were. */
#include <errno.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "tiff_source.h"

enum { BAND = 16, STRIP_BYTES = 1 << 19, JPEG_QUALITY = 95 };

typedef struct writer {
    io_tiff_file file;
    const io_source *source;
    const char *path;
    const io_channel *channel[IO_TIFF_MOST_SAMPLES];
    int threads, channels, colours, alpha;
    /* How it is written, where the source's way is not possible. */
    io_tiff_kind kind;
    uint16_t bits, photometric, compression, predictor;
    int width, height, block_width, block_height;
    unsigned char *raw;
    size_t row_bytes, plane_bytes;
    int x, y, count, rows; /* the block at work */
    atomic_bool no_memory;
    atomic_ullong clamped;
} writer;

/* ------------------------------------------------------------------------- samples */

static void store(const writer *w, const float *row, int c, unsigned char *out, size_t first, size_t step,
                  unsigned long long *clamped) {
    const bool inverted = w->photometric == PHOTOMETRIC_MINISWHITE && c < w->colours;
    if (w->kind == IO_TIFF_UINT) {
        out += first * (size_t)(w->bits / 8);
        *clamped += io_quantize(row, w->count, w->bits, inverted, out, step);
    } else if (w->kind == IO_TIFF_HALF) {
        for (int x = 0; x < w->count; x++)
            io_float_to_half(row + x, (uint16_t *)out + first + (size_t)x * step, 1, 1);
    } else {
        for (int x = 0; x < w->count; x++)
            ((float *)out)[first + (size_t)x * step] = row[x];
    }
}

static void encode_row(writer *w, float *const *row, int y) {
    const bool separate = w->source->separate;
    unsigned long long clamped = 0;
    for (int c = 0; c < w->channels; c++)
        io_channel_span(w->channel[c], w->x, w->y + y, w->count, row[c]);
    io_encode_row(&w->source->coding, row, w->colours, w->alpha >= 0 ? row[w->alpha] : NULL, w->count);
    for (int c = 0; c < w->channels; c++) {
        unsigned char *out = w->raw + (separate ? (size_t)c * w->plane_bytes : 0) + (size_t)y * w->row_bytes;
        store(w, row[c], c, out, separate ? 0 : (size_t)c, separate ? 1 : (size_t)w->channels, &clamped);
    }
    atomic_fetch_add(&w->clamped, clamped);
}

static void encode_band(void *data, int index) {
    writer *w = data;
    float *scratch = malloc(sizeof *scratch * (size_t)w->channels * (size_t)w->count), *row[IO_TIFF_MOST_SAMPLES];
    if (scratch == NULL) {
        atomic_store(&w->no_memory, true);
        return;
    }
    for (int c = 0; c < w->channels; c++)
        row[c] = scratch + (size_t)c * (size_t)w->count;
    for (int y = index * BAND; y < w->rows && y < (index + 1) * BAND; y++)
        encode_row(w, row, y);
    free(scratch);
}

static int write_failed(const writer *w, io_error *error) {
    const int number = w->file.write_error;
    return io_fail(error, "%s: cannot be written: %s", w->path, number != 0 ? strerror(number) : w->file.message.text);
}

static int write_block(writer *w, io_error *error) {
    TIFF *tiff = w->file.tiff;
    const bool tiled = w->source->tiled;
    const tmsize_t bytes = (tmsize_t)(w->row_bytes * (size_t)(tiled ? w->block_height : w->rows));
    if (tiled) memset(w->raw, 0, w->plane_bytes * (size_t)(w->source->separate ? w->channels : 1));
    io_parallel(w->threads, (w->rows + BAND - 1) / BAND, encode_band, w);
    if (atomic_load(&w->no_memory)) return io_fail(error, "%s: not enough memory to write it", w->path);
    for (int p = 0; p < (w->source->separate ? w->channels : 1); p++) {
        unsigned char *in = w->raw + (size_t)p * w->plane_bytes;
        const uint32_t x = (uint32_t)w->x, y = (uint32_t)w->y;
        const tmsize_t put = tiled ? TIFFWriteEncodedTile(tiff, TIFFComputeTile(tiff, x, y, 0, (uint16_t)p), in, bytes)
                                   : TIFFWriteEncodedStrip(tiff, TIFFComputeStrip(tiff, y, (uint16_t)p), in, bytes);
        if (put != bytes || w->file.write_error != 0) return write_failed(w, error);
    }
    return 0;
}

static int write_blocks(writer *w, io_error *error) {
    for (w->y = 0; w->y < w->height; w->y += w->block_height) {
        w->rows = w->height - w->y < w->block_height ? w->height - w->y : w->block_height;
        for (w->x = 0; w->x < w->width; w->x += w->block_width) {
            w->count = w->width - w->x < w->block_width ? w->width - w->x : w->block_width;
            if (write_block(w, error) < 0) return -1;
        }
    }
    return 0;
}

/* ------------------------------------------------------------------------- how it is written */

/* Whether libtiff can write these samples with this compression without loss, or as the file had it. */
static bool can_compress(const writer *w, uint16_t compression) {
    const bool eight = w->kind == IO_TIFF_UINT && w->bits == 8;
    switch (compression) {
    case COMPRESSION_NONE:
    case COMPRESSION_PACKBITS:
        return true;
    case COMPRESSION_LZW:
    case COMPRESSION_DEFLATE:
    case COMPRESSION_ADOBE_DEFLATE:
    case COMPRESSION_ZSTD:
    case COMPRESSION_LZMA:
        return TIFFIsCODECConfigured(compression) != 0;
    case COMPRESSION_LERC:
        return TIFFIsCODECConfigured(compression) != 0 && w->kind != IO_TIFF_HALF;
    case COMPRESSION_WEBP:
        return TIFFIsCODECConfigured(compression) != 0 && eight && w->channels >= 3 && !w->source->separate;
    case COMPRESSION_JPEG:
        return TIFFIsCODECConfigured(compression) != 0 && eight;
    default:
        return false;
    }
}

/* libtiff (4.5.0) applies the floating point predictor to bytes it has already swapped: nobody can read that. */
static bool swaps_bytes(const io_source *source) {
    const uint16_t one = 1;
    return !source->created && source->big_endian == (*(const unsigned char *)&one == 1);
}

static void choose_compression(writer *w, io_error *note) {
    const io_source *source = w->source;
    w->compression = source->compression;
    w->predictor = source->predictor;
    if (!can_compress(w, w->compression)) {
        w->compression =
            TIFFIsCODECConfigured(COMPRESSION_ADOBE_DEFLATE) ? COMPRESSION_ADOBE_DEFLATE : COMPRESSION_NONE;
        w->predictor = w->kind == IO_TIFF_UINT ? PREDICTOR_HORIZONTAL : PREDICTOR_FLOATINGPOINT;
        io_note(note, w->path, "its %s compression is written as %s", io_tiff_compression_name(source->compression),
                io_tiff_compression_name(w->compression));
    } else if (w->compression == COMPRESSION_JPEG) {
        io_note(note, w->path, "it is compressed with JPEG again (quality %d)", JPEG_QUALITY);
    }
    if (!io_tiff_has_predictor(w->compression)) w->predictor = PREDICTOR_NONE;
    if (w->predictor == PREDICTOR_FLOATINGPOINT && swaps_bytes(source)) {
        w->predictor = PREDICTOR_HORIZONTAL;
        io_note(note, w->path, "its floating point predictor is written as the horizontal one");
    }
    if (w->compression != COMPRESSION_JPEG && w->photometric == PHOTOMETRIC_YCBCR) w->photometric = PHOTOMETRIC_RGB;
}

static void choose_samples(writer *w, io_error *note) {
    const io_source *source = w->source;
    w->kind = source->kind;
    w->bits = source->bits;
    w->photometric = source->photometric;
    if (source->palette != NULL) {
        w->photometric = PHOTOMETRIC_RGB;
        w->bits = 8;
        io_note(note, w->path, "its palette is written as 8-bit channels");
    } else if (w->kind == IO_TIFF_DOUBLE) {
        w->kind = IO_TIFF_FLOAT;
        w->bits = 32;
        io_note(note, w->path, "its 64-bit samples are written with 32 bits");
    } else if (w->kind == IO_TIFF_UINT && w->bits != 8 && w->bits != 16 && w->bits != 32) {
        w->bits = w->bits < 8 ? 8 : 16;
        io_note(note, w->path, "its %d-bit samples are written with %d bits", source->bits, w->bits);
    } else if (w->kind == IO_TIFF_UINT && w->bits == 32) {
        io_note(note, w->path, "its 32-bit integers are kept to 24 bits");
    }
}

/* The source's channels in its order, or the plain ones when the picture's were exchanged. */
static int choose_channels(writer *w, const io_part *part, io_error *error) {
    const io_source *source = w->source;
    w->channels = part->channel_count;
    if (!source->created && w->channels == source->channels) {
        for (int c = 0; c < w->channels; c++)
            w->channel[c] = &part->channel[c];
    } else {
        w->channels = io_plain_channels(part, w->channel);
    }
    if (w->channels != source->channels)
        return io_fail(error, "%s: has %d channels where its source had %d; make a new picture for them", w->path,
                       part->channel_count, source->channels);
    w->colours = source->colours;
    w->alpha = source->alpha;
    w->width = w->channel[0]->width;
    w->height = w->channel[0]->height;
    return 0;
}

static void choose_blocks(writer *w) {
    const io_source *source = w->source;
    const size_t in_row = source->separate ? 1 : (size_t)w->channels;
    w->block_width = source->tiled ? (int)source->block_width : w->width;
    w->block_height = (int)source->block_height;
    if (source->tiled) { /* TIFF 6.0 wants multiples of 16; not every file keeps to that */
        w->block_width = (w->block_width + 15) / 16 * 16;
        w->block_height = (w->block_height + 15) / 16 * 16;
    }
    w->row_bytes = (size_t)w->block_width * in_row * (size_t)(w->bits / 8);
    if (source->created) {
        const size_t rows = STRIP_BYTES / w->row_bytes;
        w->block_height = rows < BAND ? BAND : rows > 4096 ? 4096 : (int)rows;
        if (w->block_height > w->height) w->block_height = w->height;
    }
    if (w->compression == COMPRESSION_JPEG && !source->tiled && w->block_height < w->height) {
        /* JPEG strips hold whole blocks of the coarsest channel; not every file keeps to that. */
        const int unit = 8 * (source->subsampling[1] > 1 ? source->subsampling[1] : 1);
        w->block_height = (w->block_height + unit - 1) / unit * unit;
    }
    w->plane_bytes = w->row_bytes * (size_t)w->block_height;
}

static void set_fields(writer *w) {
    TIFF *tiff = w->file.tiff;
    const io_source *source = w->source;
    const int extras = w->channels - w->colours;
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, (uint32_t)w->width);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, (uint32_t)w->height);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, w->bits);
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, w->channels);
    if (w->kind != IO_TIFF_UINT) TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_IEEEFP);
    TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, source->separate ? PLANARCONFIG_SEPARATE : PLANARCONFIG_CONTIG);
    TIFFSetField(tiff, TIFFTAG_COMPRESSION, w->compression);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, w->photometric);
    if (extras > 0) TIFFSetField(tiff, TIFFTAG_EXTRASAMPLES, extras, source->extra);
    if (source->tiled) {
        TIFFSetField(tiff, TIFFTAG_TILEWIDTH, (uint32_t)w->block_width);
        TIFFSetField(tiff, TIFFTAG_TILELENGTH, (uint32_t)w->block_height);
    } else {
        TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, (uint32_t)w->block_height);
    }
    if (w->predictor != PREDICTOR_NONE) TIFFSetField(tiff, TIFFTAG_PREDICTOR, w->predictor);
    if (w->compression == COMPRESSION_WEBP) TIFFSetField(tiff, TIFFTAG_WEBP_LOSSLESS, 1);
    if (w->compression == COMPRESSION_JPEG) {
        TIFFSetField(tiff, TIFFTAG_JPEGQUALITY, JPEG_QUALITY);
        if (w->photometric == PHOTOMETRIC_YCBCR) {
            TIFFSetField(tiff, TIFFTAG_YCBCRSUBSAMPLING, source->subsampling[0], source->subsampling[1]);
            TIFFSetField(tiff, TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB);
        }
    }
}

/* ------------------------------------------------------------------------- metadata and pages */

/* Tags whose form depends on the bits of a sample. */
static bool depends_on_bits(uint16_t tag) {
    return tag == 280 || tag == 281 || tag == 290 || tag == 291 || tag == 301 || tag == 340 || tag == 341;
}

/* libtiff's directory with the carried-over tags added. Nothing is copied but the list: free only its entries. */
static int merge(const writer *w, const io_ifd *written, io_ifd *merged) {
    const io_ifd *kept = &w->source->kept;
    merged->count = 0;
    merged->entry = malloc(sizeof *merged->entry * (size_t)(written->count + kept->count));
    if (merged->entry == NULL) return -1;
    const bool same = w->bits == w->source->bits;
    for (int i = 0, k = 0; i < written->count || k < kept->count;) {
        const bool take_kept = k < kept->count && (i == written->count || kept->entry[k].tag < written->entry[i].tag);
        if (!take_kept) {
            if (k < kept->count && kept->entry[k].tag == written->entry[i].tag) k++;
            merged->entry[merged->count++] = written->entry[i++];
        } else {
            if (same || !depends_on_bits(kept->entry[k].tag)) merged->entry[merged->count++] = kept->entry[k];
            k++;
        }
    }
    return 0;
}

static bool is_subfile_type(uint16_t tag) {
    return tag == 254;
}

/* A reduced copy of the first page (a thumbnail) would still show the old picture. */
static bool is_thumbnail(io_ifd_file *from, uint64_t page) {
    io_ifd ifd;
    if (io_ifd_read(from, page, is_subfile_type, &ifd) < 0) return false;
    const bool thumbnail =
        ifd.count == 1 && ifd.entry[0].size == 4 && (ifd.entry[0].value[from->big_endian ? 3 : 0] & 1) != 0;
    io_ifd_free(&ifd);
    return thumbnail;
}

static int copy_pages(const writer *w, io_ifd_file *from, io_ifd_file *to, uint64_t next_field, io_error *note,
                      io_error *error) {
    uint64_t page, next, offset, field;
    int lost = 0, thumbnails = 0;
    if (io_ifd_header(from, &page) < 0 || io_ifd_next(from, page, &next) < 0)
        return io_fail(error, "%s: the file its further pages come from has changed; try again", w->path);
    for (int i = 0; i < w->source->pages; i++) {
        page = next;
        if (io_ifd_next(from, page, &next) < 0) next = 0;
        if (is_thumbnail(from, page)) {
            thumbnails++;
            continue;
        }
        const int copied = io_ifd_copy_page(from, page, to, &offset, &field);
        if (copied < 0 || (copied == 0 && io_ifd_link(to, next_field, offset) < 0))
            return io_fail(error, "%s: cannot be written: %s", w->path, strerror(errno));
        if (copied == 0) next_field = field;
        lost += copied == 1;
    }
    if (lost > 0) io_note(note, w->path, "%d of its further pages could not be kept", lost);
    if (thumbnails > 0) io_note(note, w->path, "%d reduced pages (thumbnails) are left out", thumbnails);
    return 0;
}

static int append(const writer *w, const io_picture *picture, io_ifd_file *to, io_error *note, io_error *error) {
    io_ifd written, merged;
    uint64_t first, offset, next_field;
    if (io_ifd_header(to, &first) < 0 || io_ifd_read(to, first, NULL, &written) < 0)
        return io_fail(error, "%s: cannot be read back; is the disk full?", w->path);
    int status = merge(w, &written, &merged);
    if (status == 0) status = io_ifd_append(to, &merged, &offset, &next_field);
    if (status == 0) status = io_ifd_link(to, io_ifd_first_field(to), offset);
    if (status < 0) io_fail(error, "%s: cannot be written: %s", w->path, strerror(errno));
    free(merged.entry);
    io_ifd_free(&written);
    if (to->no_memory) return io_fail(error, "%s: not enough memory to write it", w->path);
    if (status < 0 || w->source->pages == 0) return status;
    io_ifd_file from = {.file = io_reopen_stream(picture, error)};
    if (from.file == NULL) return -1;
    from.length = (uint64_t)io_file_length(from.file);
    status = copy_pages(w, &from, to, next_field, note, error);
    if (from.no_memory || to->no_memory) status = io_fail(error, "%s: not enough memory to write it", w->path);
    fclose(from.file);
    return status;
}

static int add_metadata(const writer *w, const io_picture *picture, const char *temporary, io_error *note,
                        io_error *error) {
    const io_source *source = w->source;
    if (source->kept.count == 0 && source->pages == 0) return 0;
    io_ifd_file to = {.file = io_open_temporary_stream(temporary)};
    if (to.file == NULL) return io_fail(error, "%s: cannot be written: %s", w->path, strerror(errno));
    to.length = (uint64_t)io_file_length(to.file);
    int status = append(w, picture, &to, note, error);
    if (fclose(to.file) != 0 && status == 0)
        status = io_fail(error, "%s: cannot be written: %s", w->path, strerror(errno));
    return status;
}

/* ------------------------------------------------------------------------- the file */

static int write_pixels(writer *w, const char *temporary, const io_options *options, io_error *error) {
    const io_source *source = w->source;
    char mode[8] = "w";
    /* 4 GB is as far as a classic TIFF reaches; further pages and tags cannot be more than their file. */
    const double bytes =
        (double)w->row_bytes * w->height * (source->separate ? w->channels : 1) * ((double)w->width / w->block_width);
    if (!source->created) strcat(mode, source->big_endian ? "b" : "l");
    if (source->big_tiff || bytes * 1.1 + (double)source->file_bytes > 4e9) strcat(mode, "8");
    int status = io_tiff_write_file(&w->file, temporary, mode, w->path, error);
    if (status == 0) {
        set_fields(w);
        if (w->file.message.text[0] != '\0') status = write_failed(w, error);
    }
    if (status == 0) {
        w->raw = io_block_allocate(options, w->plane_bytes * (size_t)(source->separate ? w->channels : 1), error, w->path);
        if (w->raw == NULL) status = -1;
    }
    if (status == 0) status = write_blocks(w, error);
    if (status == 0 && !TIFFFlush(w->file.tiff)) status = write_failed(w, error);
    if (io_tiff_close_file(&w->file) < 0 && status == 0)
        status = io_fail(error, "%s: cannot be written: %s", w->path, w->file.message.text);
    io_block_release(options, w->raw);
    return status;
}

static void note_losses(const writer *w, io_error *note) {
    const io_source *source = w->source;
    if (source->sub_images) io_note(note, w->path, "its sub-images (SubIFD) are left out");
    if (source->layers) io_note(note, w->path, "its Photoshop layers are left out");
    if (!source->created && !source->all_pages)
        io_note(note, w->path, "its list of pages is damaged and ends after %d", source->pages + 1);
    if (source->kept.lost) io_note(note, w->path, "damaged tags are left out");
    if (w->clamped > 0)
        io_note(note, w->path, "%llu values outside 0..1 were clamped (float TIFF and EXR keep them)",
                (unsigned long long)w->clamped);
}

int io_tiff_write(const io_picture *picture, const char *temporary, const char *path, const io_options *options,
                  io_error *note, io_error *error) {
    writer w = {.source = picture->source, .path = path, .threads = options != NULL ? options->threads : 0};
    if (io_read_missing(picture, error) < 0 || choose_channels(&w, &picture->part[0], error) < 0) return -1;
    choose_samples(&w, note);
    choose_compression(&w, note);
    choose_blocks(&w);
    if (write_pixels(&w, temporary, options, error) < 0 || add_metadata(&w, picture, temporary, note, error) < 0) return -1;
    note_losses(&w, note);
    return 0;
}
