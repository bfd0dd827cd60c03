/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* TIFF, by libtiff: opening. tiff_read.c and tiff_write.c do the pixels, tiff_ifd.c carries over the metadata.
 *
 * The first page is the picture; the others are copied as they are. Pixels stay in the order of the file, whatever the
 * Orientation tag says about showing them, and the tag is kept. Float samples are scene-linear numbers; integers hold
 * sRGB (a profile is kept, its curve taken to be sRGB's). Alpha follows ExtraSamples: unassociated alpha is multiplied
 * in after decoding; integer colour with associated alpha was multiplied after encoding, so it is divided, decoded and
 * multiplied again. An extra sample of no stated meaning is called A when it is the only one, and left alone. */
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tiff_source.h"

/* How many bytes one byte of the file can become at most, generously; 0: no limit that is of any use. */
typedef struct compression {
    uint16_t code, ratio;
    const char *name;
} compression;

static const compression compressions[] = {
    {COMPRESSION_NONE, 1, "none"},
    {COMPRESSION_CCITTRLE, 0, "CCITT RLE"},
    {COMPRESSION_CCITTFAX3, 0, "CCITT fax 3"},
    {COMPRESSION_CCITTFAX4, 0, "CCITT fax 4"},
    {COMPRESSION_LZW, 4096, "LZW"},
    {COMPRESSION_OJPEG, 0, "old-style JPEG"},
    {COMPRESSION_JPEG, 0, "JPEG"},
    {COMPRESSION_NEXT, 0, "NeXT"},
    {COMPRESSION_CCITTRLEW, 0, "CCITT RLE"},
    {COMPRESSION_PACKBITS, 64, "PackBits"},
    {COMPRESSION_THUNDERSCAN, 0, "ThunderScan"},
    {COMPRESSION_PIXARLOG, 2064, "PixarLog"},
    {COMPRESSION_DEFLATE, 1032, "deflate"},
    {COMPRESSION_ADOBE_DEFLATE, 1032, "deflate"},
    {COMPRESSION_JBIG, 0, "JBIG"},
    {COMPRESSION_SGILOG, 0, "SGI LogLuv"},
    {COMPRESSION_SGILOG24, 0, "SGI LogLuv 24"},
    {COMPRESSION_JP2000, 0, "JPEG 2000"},
    {COMPRESSION_LERC, 0, "LERC"},
    {COMPRESSION_LZMA, 0, "LZMA"},
    {COMPRESSION_ZSTD, 0, "Zstandard"},
    {COMPRESSION_WEBP, 0, "WebP"},
};

static const compression *find_compression(uint16_t code) {
    static const compression unknown = {0, 0, "unknown"};
    for (size_t i = 0; i < sizeof compressions / sizeof compressions[0]; i++)
        if (compressions[i].code == code) return &compressions[i];
    return &unknown;
}

const char *io_tiff_compression_name(uint16_t code) {
    return find_compression(code)->name;
}

bool io_tiff_has_predictor(uint16_t code) {
    return code == COMPRESSION_LZW || code == COMPRESSION_DEFLATE || code == COMPRESSION_ADOBE_DEFLATE ||
           code == COMPRESSION_ZSTD || code == COMPRESSION_LZMA;
}

/* ------------------------------------------------------------------------- what the samples are */

static int check_samples(const char *path, io_source *source, uint16_t format, io_error *error) {
    static const char *const refused[] = {[5] = "CMYK", [8] = "CIE L*a*b*", [9] = "ICC L*a*b*", [10] = "ITU L*a*b*"};
    const uint16_t photometric = source->photometric, bits = source->bits;
    if (photometric == PHOTOMETRIC_YCBCR) {
        if (source->compression != COMPRESSION_JPEG)
            return io_fail(error, "%s: is a YCbCr TIFF, which is only read with JPEG compression; convert it to RGB",
                           path);
    } else if (photometric > PHOTOMETRIC_PALETTE) {
        return io_fail(error, "%s: is a %s TIFF (photometric interpretation %d); convert it to RGB", path,
                       photometric <= 10 && refused[photometric] != NULL ? refused[photometric] : "special",
                       photometric);
    }
    if (source->compression == COMPRESSION_OJPEG)
        return io_fail(error, "%s: has old-style JPEG compression; convert it, e.g. with tiffcp -c lzw", path);
    if (!TIFFIsCODECConfigured(source->compression))
        return io_fail(error, "%s: has %s compression (%d), which the installed libtiff cannot decode; convert it",
                       path, io_tiff_compression_name(source->compression), source->compression);
    if (format == SAMPLEFORMAT_IEEEFP && (bits == 16 || bits == 32 || bits == 64)) {
        source->kind = bits == 16 ? IO_TIFF_HALF : bits == 32 ? IO_TIFF_FLOAT : IO_TIFF_DOUBLE;
        if (photometric == PHOTOMETRIC_MINISWHITE || photometric == PHOTOMETRIC_PALETTE)
            return io_fail(error, "%s: has float samples that are %s; convert it to plain grey or RGB", path,
                           photometric == PHOTOMETRIC_PALETTE ? "a palette's" : "white at 0");
        return 0;
    }
    if ((format == SAMPLEFORMAT_UINT || format == SAMPLEFORMAT_VOID) && (bits <= 16 || bits == 32) &&
        !(photometric == PHOTOMETRIC_PALETTE && bits > 16)) {
        source->kind = IO_TIFF_UINT;
        return 0;
    }
    return io_fail(error, "%s: has %d-bit %s samples; convert it to 8, 16 or 32 bits unsigned, or to float", path, bits,
                   format == SAMPLEFORMAT_UINT     ? "unsigned"
                   : format == SAMPLEFORMAT_INT    ? "signed"
                   : format == SAMPLEFORMAT_IEEEFP ? "float"
                                                   : "complex");
}

/* Which samples are colour, which alpha. */
static int choose_channels(const char *path, io_source *source, TIFF *tiff, io_error *error) {
    uint16_t count = 0, *types = NULL;
    const bool said = TIFFGetField(tiff, TIFFTAG_EXTRASAMPLES, &count, &types) != 0 && count > 0;
    const int samples = source->samples;
    const bool palette = source->photometric == PHOTOMETRIC_PALETTE;
    const bool rgb = source->photometric == PHOTOMETRIC_RGB || source->photometric == PHOTOMETRIC_YCBCR ||
                     (source->photometric <= PHOTOMETRIC_MINISBLACK && !said && samples >= 3);
    source->colours = rgb ? 3 : 1;
    source->alpha = -1;
    if (samples > IO_TIFF_MOST_SAMPLES || samples < source->colours || (palette && samples != 1))
        return io_fail(error, "%s: has %d samples a pixel, which is not possible for %s; export it again", path,
                       samples,
                       palette ? "a palette"
                       : rgb   ? "RGB"
                               : "grey");
    const int extras = samples - source->colours;
    for (int i = 0; i < extras; i++) {
        source->extra[i] = said && count == extras ? types[i] : EXTRASAMPLE_UNSPECIFIED;
        if (source->alpha < 0 && source->extra[i] != EXTRASAMPLE_UNSPECIFIED) source->alpha = source->colours + i;
    }
    if (source->alpha < 0 && extras == 1) source->alpha = source->colours;
    source->channels = palette ? 3 : samples;
    if (palette) source->colours = 3;
    return 0;
}

static void choose_coding(io_source *source, io_meaning meaning) {
    if (meaning == IO_DATA) return;
    if (source->kind == IO_TIFF_UINT) source->coding.curve = IO_CURVE_SRGB;
    uint16_t type = source->alpha < 0 ? EXTRASAMPLE_UNSPECIFIED : source->extra[source->alpha - source->colours];
    source->coding.alpha = type == EXTRASAMPLE_UNASSALPHA   ? IO_ALPHA_STRAIGHT
                           : type == EXTRASAMPLE_ASSOCALPHA ? IO_ALPHA_ASSOCIATED
                                                            : IO_ALPHA_NONE;
}

/* Palettes of 16-bit entries, of 8-bit ones in the upper byte, or (wrongly, but common) in the lower one: all as 16. */
static int keep_palette(const char *path, io_source *source, TIFF *tiff, io_error *error) {
    uint16_t *map[3], every_low = 0, every_high = 0;
    const size_t size = (size_t)1 << source->bits;
    if (!TIFFGetField(tiff, TIFFTAG_COLORMAP, &map[0], &map[1], &map[2]))
        return io_fail(error, "%s: is a palette TIFF without a palette; export it again", path);
    source->palette = malloc(sizeof *source->palette * 3 * size);
    if (source->palette == NULL) return io_fail(error, "%s: not enough memory", path);
    for (size_t i = 0; i < 3 * size; i++) {
        const uint16_t value = source->palette[i] = map[i / size][i % size];
        every_low |= value & 0xff;
        every_high |= value >> 8;
    }
    for (size_t i = 0; i < 3 * size; i++) {
        if (every_high == 0)
            source->palette[i] = (uint16_t)(source->palette[i] * 257);
        else if (every_low == 0)
            source->palette[i] = (uint16_t)((source->palette[i] >> 8) * 257);
    }
    return 0;
}

/* ------------------------------------------------------------------------- how they lie in the file */

static int check_layout(const char *path, io_source *source, uint64_t length, io_error *error) {
    const uint64_t bits = (uint64_t)source->bits * source->samples,
                   ratio = find_compression(source->compression)->ratio;
    if (io_check_size(path, source->width, source->height, &source->options, error) < 0) return -1;
    const uint64_t bytes = (source->width * bits + 7) / 8 * source->height;
    if (ratio > 0 && bytes / ratio > length)
        return io_fail(error, "%s: says %u x %u pixels, more than its %llu bytes can hold; it is damaged or cut off",
                       path, (unsigned)source->width, (unsigned)source->height, (unsigned long long)length);
    const uint64_t width = source->block_width, height = source->block_height;
    if (width == 0 || height == 0 || width > 1u << 24 || height > 1u << 24)
        return io_fail(error, "%s: the size of its %s is damaged; export it again", path,
                       source->tiled ? "tiles" : "strips");
    /* A tile may be larger than a small picture, but not to any extent. */
    const uint64_t block = (width * bits + 7) / 8 * height, most = (64u << 20) + 4 * bytes;
    if (source->tiled && block > most)
        return io_fail(error, "%s: its tiles of %u x %u are far larger than the picture; export it again", path,
                       (unsigned)width, (unsigned)height);
    return 0;
}

static int get_layout(const char *path, io_source *source, io_tiff_file *file, io_error *error) {
    TIFF *tiff = file->tiff;
    uint32_t depth = 1;
    uint16_t planar = PLANARCONFIG_CONTIG;
    TIFFGetFieldDefaulted(tiff, TIFFTAG_PLANARCONFIG, &planar);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_IMAGEDEPTH, &depth);
    if (depth > 1) return io_fail(error, "%s: is a volume of %u slices; export a picture", path, (unsigned)depth);
    source->separate = planar == PLANARCONFIG_SEPARATE && source->samples > 1;
    source->tiled = TIFFIsTiled(tiff) != 0;
    source->block_width = source->width;
    if (source->tiled) {
        TIFFGetField(tiff, TIFFTAG_TILEWIDTH, &source->block_width);
        TIFFGetField(tiff, TIFFTAG_TILELENGTH, &source->block_height);
    } else {
        TIFFGetFieldDefaulted(tiff, TIFFTAG_ROWSPERSTRIP, &source->block_height);
        if (source->block_height > source->height) source->block_height = source->height;
    }
    source->predictor = PREDICTOR_NONE;
    if (io_tiff_has_predictor(source->compression)) TIFFGetFieldDefaulted(tiff, TIFFTAG_PREDICTOR, &source->predictor);
    if (source->photometric == PHOTOMETRIC_YCBCR)
        TIFFGetFieldDefaulted(tiff, TIFFTAG_YCBCRSUBSAMPLING, &source->subsampling[0], &source->subsampling[1]);
    return 0;
}

static int get_header(const char *path, io_source *source, io_tiff_file *file, io_meaning meaning, io_error *error) {
    TIFF *tiff = file->tiff;
    uint16_t format = SAMPLEFORMAT_UINT;
    const void *version = NULL;
    if (TIFFGetField(tiff, TIFFTAG_DNGVERSION, &version))
        return io_fail(error, "%s: is a camera raw file (DNG); develop it to a TIFF or EXR first", path);
    if (!TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &source->width) ||
        !TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &source->height) ||
        !TIFFGetField(tiff, TIFFTAG_PHOTOMETRIC, &source->photometric))
        return io_fail(error, "%s: its first page is no picture (size or colour tags are missing); export it again",
                       path);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_BITSPERSAMPLE, &source->bits);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLESPERPIXEL, &source->samples);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_COMPRESSION, &source->compression);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLEFORMAT, &format);
    if (source->bits == 0) return io_fail(error, "%s: has samples of 0 bits; export it again", path);
    if (check_samples(path, source, format, error) < 0 || choose_channels(path, source, tiff, error) < 0 ||
        get_layout(path, source, file, error) < 0)
        return -1;
    choose_coding(source, meaning);
    return source->photometric == PHOTOMETRIC_PALETTE ? keep_palette(path, source, tiff, error) : 0;
}

/* ------------------------------------------------------------------------- metadata */

/* Tags of how pixels lie in the file, which libtiff writes anew, and those that would be wrong afterwards. */
static bool is_carried_over(uint16_t tag) {
    static const uint16_t ours[] = {256, 257, 258, 259,   262,   266,   273,   277,   278,  279, 284, 288,
                                    289, 292, 293, 317,   320,   322,   323,   324,   325,  330, 338, 339,
                                    347, 512, 513, 514,   515,   517,   518,   519,   520,  521, 529, 530,
                                    531, 532, 559, 32995, 32996, 32997, 32998, 37724, 50674};
    for (size_t i = 0; i < sizeof ours / sizeof ours[0]; i++)
        if (tag == ours[i]) return false;
    return true;
}

static double pixel_aspect(TIFF *tiff) {
    float x = 0, y = 0; /* pixels a unit of length */
    if (!TIFFGetField(tiff, TIFFTAG_XRESOLUTION, &x) || !TIFFGetField(tiff, TIFFTAG_YRESOLUTION, &y)) return 1;
    return x > 0 && y > 0 && y / x > 0.1f && y / x < 10 ? (double)y / (double)x : 1;
}

static int get_metadata(const io_picture *picture, io_source *source, io_tiff_file *file, io_error *error) {
    const char *path = picture->path;
    const uint64_t offset = TIFFCurrentDirOffset(file->tiff);
    const void *unused;
    uint16_t count = 0;
    uint32_t bytes = 0;
    source->sub_images = TIFFGetField(file->tiff, TIFFTAG_SUBIFD, &count, &unused) != 0 && count > 0;
    source->layers = TIFFGetField(file->tiff, TIFFTAG_IMAGESOURCEDATA, &bytes, &unused) != 0;
    io_ifd_file raw = {.file = io_reopen_stream(picture, error)};
    if (raw.file == NULL) return -1;
    uint64_t first;
    raw.length = source->file_bytes = (uint64_t)io_file_length(raw.file);
    int status =
        io_ifd_header(&raw, &first) < 0 || io_ifd_read(&raw, offset, is_carried_over, &source->kept) < 0 ? -1 : 0;
    source->big_endian = raw.big_endian;
    source->big_tiff = raw.big_tiff;
    if (status == 0) source->pages = io_ifd_count_next(&raw, offset, &source->all_pages);
    if (raw.no_memory)
        status = io_fail(error, "%s: not enough memory", path);
    else if (status == 0)
        status = check_layout(path, source, raw.length, error);
    else
        io_fail(error, "%s: the TIFF directory is damaged; export the picture again", path);
    fclose(raw.file);
    return status;
}

/* ------------------------------------------------------------------------- the table */

static int add_part(io_picture *picture, const io_source *source, TIFF *tiff) {
    static const char *const rgb[] = {"R", "G", "B"};
    const io_box box = {0, 0, (int)source->width, (int)source->height};
    io_part *part = io_add_part(picture, "", "", box, box);
    for (int c = 0; part != NULL && c < source->channels; c++) {
        char extra[24];
        snprintf(extra, sizeof extra, "extra%d", c - source->colours + 1);
        const char *name = c == source->alpha     ? "A"
                           : c >= source->colours ? extra
                           : source->colours == 3 ? rgb[c]
                                                  : "Y";
        io_channel *channel = io_add_channel(part, name, IO_FLOAT, 1, 1);
        if (channel == NULL)
            part = NULL;
        else
            channel->integer = source->kind == IO_TIFF_UINT;
    }
    if (part == NULL) return -1;
    part->pixel_aspect = pixel_aspect(tiff);
    part->compression = io_tiff_compression_name(source->compression);
    part->storage = source->tiled ? "tiled" : "scanline";
    part->bits = source->bits;
    /* what is compressed libtiff holds a whole block of */
    const bool packed = source->compression != COMPRESSION_NONE;
    part->chunk_bytes = (uint64_t)source->block_width * (packed ? source->block_height : 1) *
                        (((uint64_t)source->samples * source->bits + 7) / 8);
    return 0;
}

static int open_tiff(io_picture *picture, io_meaning meaning, const io_options *options, io_error *error) {
    io_tiff_file file;
    int status = io_tiff_read_file(&file, picture, error);
    io_source *source = picture->source = calloc(1, sizeof *source);
    if (status == 0 && source == NULL) status = io_fail(error, "%s: not enough memory", picture->path);
    if (status == 0) {
        if (options != NULL) source->options = *options;
        status = get_header(picture->path, source, &file, meaning, error);
    }
    if (status == 0) status = get_metadata(picture, source, &file, error);
    if (status == 0 && add_part(picture, source, file.tiff) < 0)
        status = io_fail(error, "%s: not enough memory", picture->path);
    io_tiff_close_file(&file);
    return status;
}

static bool matches_tiff(const unsigned char *head, size_t size) {
    return size >= 4 && (memcmp(head, "II*\0", 4) == 0 || memcmp(head, "MM\0*", 4) == 0 ||
                         memcmp(head, "II+\0", 4) == 0 || memcmp(head, "MM\0+", 4) == 0);
}

static int create_tiff(io_picture *picture, io_meaning meaning, io_error *error) {
    io_part *part = &picture->part[0];
    const io_channel *channel[4];
    const int channels = io_plain_channels(part, channel), bits = part->bits;
    if (bits != 8 && bits != 16 && bits != 32)
        return io_fail(error, "%s: TIFF has 8, 16 or 32 bits, not %d", picture->path, bits);
    if (channels == 0 || channel[0]->type == IO_UINT)
        return io_fail(error,
                       "%s: TIFF holds the channels Y, Y A, R G B or R G B A as numbers with fractions; write an EXR "
                       "for others",
                       picture->path);
    io_source *source = picture->source = calloc(1, sizeof *source);
    if (source == NULL) return io_fail(error, "%s: not enough memory", picture->path);
    source->created = true;
    source->kind = bits == 32 ? IO_TIFF_FLOAT : bits == 16 && channel[0]->type == IO_HALF ? IO_TIFF_HALF : IO_TIFF_UINT;
    source->bits = (uint16_t)bits;
    source->samples = (uint16_t)channels;
    source->channels = channels;
    source->colours = channels <= 2 ? 1 : 3;
    source->alpha = channels % 2 == 0 ? channels - 1 : -1;
    /* Float colour stays premultiplied; integers would lose precision where alpha is small. */
    source->extra[0] = source->kind == IO_TIFF_UINT ? EXTRASAMPLE_UNASSALPHA : EXTRASAMPLE_ASSOCALPHA;
    source->photometric = source->colours == 3 ? PHOTOMETRIC_RGB : PHOTOMETRIC_MINISBLACK;
    source->compression = COMPRESSION_ADOBE_DEFLATE;
    source->predictor = source->kind == IO_TIFF_UINT ? PREDICTOR_HORIZONTAL : PREDICTOR_FLOATINGPOINT;
    choose_coding(source, meaning);
    part->compression = "deflate";
    part->storage = "scanline";
    return 0;
}

static void close_tiff(io_picture *picture) {
    io_source *source = picture->source;
    if (source == NULL) return;
    io_ifd_free(&source->kept);
    free(source->palette);
    free(source);
    picture->source = NULL;
}

const io_handler io_tiff = {
    .format = IO_TIFF,
    .matches = matches_tiff,
    .open = open_tiff,
    .read = io_tiff_read,
    .create = create_tiff,
    .write = io_tiff_write,
    .close = close_tiff,
};
