/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* JPEG XL, by libjxl: the first frame, its colour and alpha, and as the channel "depth" the first extra channel of that
 * type. Other extra channels are left out.
 *
 * libjxl gives floats. Where the file keeps its own samples, those of integers are brought to the very v / maximum and
 * go through the same tables as those of PNG, and floats stay as they are. What it coded by eye (XYB) has no samples of
 * its own; it comes as linear sRGB. */
#include "jxl.h"

#include <jxl/decode.h>
#include <jxl/encode.h> /* JxlColorEncodingSetToLinearSRGB */
#include <jxl/thread_parallel_runner.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "coding.h"

enum { MOST_EXTRA = 64 };

typedef struct io_source {
    io_options options;
    io_coding coding;
    unsigned char *bytes; /* of the file */
    size_t size;
    JxlBasicInfo info;
    int colors; /* channels: Y or R G B, and A */
    int depth;  /* the extra channel's index, -1: none */
    JxlExtraChannelInfo depth_info;
} io_source;

typedef struct reader {
    const io_source *source;
    JxlDecoder *decoder;
    void *runner;
    float *plane[4]; /* of the whole picture; NULL: not wanted */
    float *depth;
    size_t width;
} reader;

/* ------------------------------------------------------------------------- libjxl */

static JxlPixelFormat pixel_format(int channels) {
    return (JxlPixelFormat){.num_channels = (uint32_t)channels, .data_type = JXL_TYPE_FLOAT, .endianness = JXL_NATIVE_ENDIAN};
}

/* libjxl 0.9 dropped an argument that had no use. */
static bool get_encoding(const JxlDecoder *decoder, JxlColorEncoding *encoding) {
#if JPEGXL_NUMERIC_VERSION >= JPEGXL_COMPUTE_NUMERIC_VERSION(0, 9, 0)
    return JxlDecoderGetColorAsEncodedProfile(decoder, JXL_COLOR_PROFILE_TARGET_DATA, encoding) == JXL_DEC_SUCCESS;
#else
    return JxlDecoderGetColorAsEncodedProfile(decoder, NULL, JXL_COLOR_PROFILE_TARGET_DATA, encoding) == JXL_DEC_SUCCESS;
#endif
}

static void stop(reader *r) {
    if (r->decoder != NULL) JxlDecoderDestroy(r->decoder);
    if (r->runner != NULL) JxlThreadParallelRunnerDestroy(r->runner);
}

static int start(reader *r, const io_picture *picture, int events, io_error *error) {
    const io_source *source = picture->source;
    *r = (reader){.source = source, .decoder = JxlDecoderCreate(NULL)};
    if (r->decoder != NULL && (events & JXL_DEC_FULL_IMAGE))
        r->runner = JxlThreadParallelRunnerCreate(NULL, (size_t)io_thread_count(source->options.threads));
    bool good = r->decoder != NULL && JxlDecoderSubscribeEvents(r->decoder, events) == JXL_DEC_SUCCESS;
    if (good && r->runner != NULL)
        good = JxlDecoderSetParallelRunner(r->decoder, JxlThreadParallelRunner, r->runner) == JXL_DEC_SUCCESS;
    good = good && JxlDecoderSetInput(r->decoder, source->bytes, source->size) == JXL_DEC_SUCCESS;
    if (!good) return io_fail(error, "%s: not enough memory to read it", picture->path);
    JxlDecoderCloseInput(r->decoder);
    return 0;
}

static int fail_status(const io_picture *picture, JxlDecoderStatus status, io_error *error) {
    return io_fail(error, "%s: is %s; get the file again", picture->path,
                   status == JXL_DEC_NEED_MORE_INPUT ? "cut off" : "damaged, or JPEG XL that this libjxl cannot decode");
}

/* XYB has primaries of its own; what it is decoded to can be chosen. */
static void choose_profile(const io_source *source, JxlDecoder *decoder) {
    JxlColorEncoding linear = {0};
    if (source->info.uses_original_profile) return;
    JxlColorEncodingSetToLinearSRGB(&linear, source->info.num_color_channels == 1);
    JxlDecoderSetPreferredColorProfile(decoder, &linear);
}

/* ------------------------------------------------------------------------- opening */

static void note_icc(io_picture *picture, const JxlDecoder *decoder) {
    size_t size = 0;
    unsigned char *profile = NULL;
#if JPEGXL_NUMERIC_VERSION >= JPEGXL_COMPUTE_NUMERIC_VERSION(0, 9, 0)
    bool good = JxlDecoderGetICCProfileSize(decoder, JXL_COLOR_PROFILE_TARGET_DATA, &size) == JXL_DEC_SUCCESS &&
                (profile = malloc(size > 0 ? size : 1)) != NULL &&
                JxlDecoderGetColorAsICCProfile(decoder, JXL_COLOR_PROFILE_TARGET_DATA, profile, size) == JXL_DEC_SUCCESS;
#else
    bool good = JxlDecoderGetICCProfileSize(decoder, NULL, JXL_COLOR_PROFILE_TARGET_DATA, &size) == JXL_DEC_SUCCESS &&
                (profile = malloc(size > 0 ? size : 1)) != NULL &&
                JxlDecoderGetColorAsICCProfile(decoder, NULL, JXL_COLOR_PROFILE_TARGET_DATA, profile, size) == JXL_DEC_SUCCESS;
#endif
    io_note_profile(picture, profile, good ? size : 0);
    free(profile);
}

static int find_curve(io_picture *picture, io_source *source, JxlDecoder *decoder, io_error *error) {
    JxlColorEncoding encoding;
    source->coding.curve = IO_CURVE_SRGB;
    if (!get_encoding(decoder, &encoding)) {
        note_icc(picture, decoder);
        return 0;
    }
    if (encoding.color_space == JXL_COLOR_SPACE_RGB)
        io_note_primaries(picture, encoding.primaries == JXL_PRIMARIES_P3 && encoding.white_point == JXL_WHITE_POINT_D65
                                       ? 12
                                       : (int)encoding.primaries + (encoding.primaries == JXL_PRIMARIES_CUSTOM ? 1000 : 0));
    if (encoding.transfer_function != JXL_TRANSFER_FUNCTION_GAMMA)
        return io_curve_of_transfer(&source->coding, (int)encoding.transfer_function, picture->path, error);
    if (encoding.gamma > 0.1 && encoding.gamma <= 1) {
        source->coding.curve = IO_CURVE_POWER;
        source->coding.power = encoding.gamma;
    }
    return 0;
}

static int find_extra(const io_picture *picture, io_source *source, const JxlDecoder *decoder, io_error *error) {
    source->depth = -1;
    if (source->info.num_extra_channels > MOST_EXTRA)
        return io_fail(error, "%s: has %u extra channels, more than %d; leave some out", picture->path,
                       (unsigned)source->info.num_extra_channels, MOST_EXTRA);
    for (uint32_t i = 0; source->depth < 0 && i < source->info.num_extra_channels; i++) {
        JxlExtraChannelInfo info;
        if (JxlDecoderGetExtraChannelInfo(decoder, i, &info) != JXL_DEC_SUCCESS || info.type != JXL_CHANNEL_DEPTH) continue;
        source->depth = (int)i;
        source->depth_info = info;
    }
    return 0;
}

static int add_part(io_picture *picture, const io_source *source) {
    static const char *const grey[] = {"Y", "A"}, *const rgb[] = {"R", "G", "B", "A"};
    const JxlBasicInfo *info = &source->info;
    const int colors = (int)info->num_color_channels, all = source->colors + (source->depth >= 0);
    const io_box box = {0, 0, (int)info->xsize, (int)info->ysize};
    io_part *part = io_add_part(picture, "", "", box, box);
    for (int c = 0; part != NULL && c < all; c++) {
        const char *name = c == source->colors ? "depth" : (colors == 1 ? grey : rgb)[c];
        io_channel *channel = io_add_channel(part, name, IO_FLOAT, 1, 1);
        if (channel == NULL) return -1;
        channel->integer = (c == source->colors ? source->depth_info.exponent_bits_per_sample
                            : c == colors       ? info->alpha_exponent_bits
                                                : info->exponent_bits_per_sample) == 0;
    }
    if (part == NULL) return -1;
    part->bits = (int)info->bits_per_sample;
    part->compression = info->uses_original_profile ? "JPEG XL" : "JPEG XL (XYB)";
    part->storage = "codestream";
    return 0;
}

static int read_header(io_picture *picture, io_source *source, JxlDecoder *decoder, io_meaning meaning, io_error *error) {
    JxlDecoderStatus status = JxlDecoderProcessInput(decoder);
    JxlBasicInfo *info = &source->info;
    if (status != JXL_DEC_BASIC_INFO || JxlDecoderGetBasicInfo(decoder, info) != JXL_DEC_SUCCESS)
        return fail_status(picture, status, error);
    if (io_check_size(picture->path, info->xsize, info->ysize, &source->options, error) != 0) return -1;
    if (info->num_color_channels != 1 && info->num_color_channels != 3)
        return io_fail(error, "%s: has %u colours, not 1 or 3; convert it to R G B", picture->path,
                       (unsigned)info->num_color_channels);
    source->colors = (int)info->num_color_channels + (info->alpha_bits > 0);
    if (find_extra(picture, source, decoder, error) != 0) return -1;
    status = JxlDecoderProcessInput(decoder);
    if (status != JXL_DEC_COLOR_ENCODING) return fail_status(picture, status, error);
    choose_profile(source, decoder);
    if (meaning == IO_COLOR) {
        source->coding.alpha = info->alpha_bits == 0       ? IO_ALPHA_NONE
                               : info->alpha_premultiplied ? IO_ALPHA_ASSOCIATED
                                                           : IO_ALPHA_STRAIGHT;
        if (find_curve(picture, source, decoder, error) != 0) return -1;
    }
    return add_part(picture, source) == 0 ? 0 : io_fail(error, "%s: not enough memory", picture->path);
}

int io_jxl_open(io_picture *picture, io_meaning meaning, const io_options *options, io_error *error) {
    reader r = {0};
    io_source *source = picture->source = calloc(1, sizeof *source);
    if (source == NULL) return io_fail(error, "%s: not enough memory", picture->path);
    source->options = *options;
    int status = io_read_whole(picture, &source->bytes, &source->size, error);
    if (status == 0) status = start(&r, picture, JXL_DEC_BASIC_INFO | JXL_DEC_COLOR_ENCODING, error);
    if (status == 0) status = read_header(picture, source, r.decoder, meaning, error);
    stop(&r);
    return status;
}

void io_jxl_close(io_picture *picture) {
    free(picture->source->bytes);
    free(picture->source);
    picture->source = NULL;
}

/* ------------------------------------------------------------------------- pixels */

/* Pixels of one row, on any of the threads. */
static void take_pixels(void *opaque, size_t x, size_t y, size_t count, const void *pixels) {
    const reader *r = opaque;
    const size_t colors = (size_t)r->source->colors;
    const float *in = pixels;
    for (size_t c = 0; c < colors; c++) {
        float *out = r->plane[c] != NULL ? r->plane[c] + y * r->width + x : NULL;
        for (size_t i = 0; out != NULL && i < count; i++)
            out[i] = in[i * colors + c];
    }
}

static bool set_buffers(reader *r) {
    const JxlPixelFormat colors = pixel_format(r->source->colors), one = pixel_format(1);
    const size_t size = r->width * r->source->info.ysize * sizeof(float);
    if (JxlDecoderSetImageOutCallback(r->decoder, &colors, take_pixels, r) != JXL_DEC_SUCCESS) return false;
    return r->depth == NULL || JxlDecoderSetExtraChannelBuffer(r->decoder, &one, r->depth, size,
                                                               (uint32_t)r->source->depth) == JXL_DEC_SUCCESS;
}

/* To the end of the file: what is cut off behind the first frame is cut off too. Of an animation the rest is left. */
static int decode(reader *r, const io_picture *picture, io_error *error) {
    bool complete = false;
    for (;;) {
        const JxlDecoderStatus status = JxlDecoderProcessInput(r->decoder);
        if (status == JXL_DEC_COLOR_ENCODING) {
            choose_profile(r->source, r->decoder);
        } else if (status == JXL_DEC_NEED_IMAGE_OUT_BUFFER) {
            if (!set_buffers(r)) return fail_status(picture, JXL_DEC_ERROR, error);
        } else if (status == JXL_DEC_FULL_IMAGE) {
            complete = true;
            if (r->source->info.have_animation) return 0;
        } else if (status == JXL_DEC_SUCCESS && complete) {
            return 0;
        } else {
            return fail_status(picture, status, error);
        }
    }
}

/* libjxl's v / maximum is off by the last bit: back to v, and through the table. What is no v (a lossy file's) stays. */
static void from_table(float *values, size_t count, const float *table, int bits) {
    const float maximum = (float)((1u << bits) - 1);
    for (size_t i = 0; i < count; i++) {
        const float scaled = values[i] * maximum, whole = rintf(scaled);
        if (whole >= 0 && whole <= maximum && fabsf(scaled - whole) < 0.01f) values[i] = table[(uint32_t)whole];
    }
}

/* Samples as they were coded -> what they stand for. `color`: with the curve, unless alpha comes before it. */
static int restore(const io_source *source, float *values, size_t count, int bits, int exponent_bits, bool color) {
    const bool integer = source->info.uses_original_profile && exponent_bits == 0 && bits <= 16;
    if (!integer) {
        for (size_t i = 0; color && source->coding.alpha != IO_ALPHA_ASSOCIATED && i < count; i++)
            values[i] = io_decode(&source->coding, values[i]);
        return 0;
    }
    float *table = io_decode_table(&source->coding, bits, color, false);
    if (table == NULL) return -1;
    from_table(values, count, table, bits);
    free(table);
    return 0;
}

static int restore_all(const reader *r) {
    const io_source *source = r->source;
    const JxlBasicInfo *info = &source->info;
    const int colors = (int)info->num_color_channels;
    const size_t count = r->width * info->ysize;
    int status = 0;
    for (int c = 0; status == 0 && c < source->colors; c++)
        if (r->plane[c] != NULL)
            status = restore(source, r->plane[c], count, (int)(c < colors ? info->bits_per_sample : info->alpha_bits),
                             (int)(c < colors ? info->exponent_bits_per_sample : info->alpha_exponent_bits), c < colors);
    if (status == 0 && r->depth != NULL)
        status = restore(source, r->depth, count, (int)source->depth_info.bits_per_sample,
                         (int)source->depth_info.exponent_bits_per_sample, false);
    for (uint32_t y = 0; status == 0 && r->plane[0] != NULL && y < info->ysize; y++) {
        float *row[4];
        for (int c = 0; c < source->colors; c++)
            row[c] = r->plane[c] + y * r->width;
        io_decode_row(&source->coding, row, colors, source->colors > colors ? row[colors] : NULL, (int)r->width);
    }
    return status;
}

static int read_planes(reader *r, const io_picture *picture, io_error *error) {
    int status = decode(r, picture, error);
    if (status == 0 && restore_all(r) != 0)
        status = io_fail(error, "%s: not enough memory to read %zu x %u pixels", picture->path, r->width,
                         (unsigned)r->source->info.ysize);
    return status;
}

int io_jxl_read(io_picture *picture, int part_index, const char *const *names, int name_count, io_error *error) {
    io_part *part = &picture->part[part_index];
    const io_source *source = picture->source;
    io_channel spare[4] = {{0}}; /* colour is decoded whole: alpha belongs to each of its channels */
    bool color = false, any = false;
    reader r;
    /* libjxl holds the floats of all channels, and about as much again */
    const uint64_t pixels = (uint64_t)part->data.width * (uint64_t)part->data.height;
    if (io_check_memory(picture->path, pixels * 12 * (3 + source->info.num_extra_channels), error) != 0) return -1;
    int status = start(&r, picture, JXL_DEC_COLOR_ENCODING | JXL_DEC_FULL_IMAGE, error);
    r.width = (size_t)part->data.width;
    for (int c = 0; status == 0 && c < part->channel_count; c++) {
        io_channel *channel = &part->channel[c];
        if (channel->data != NULL || !io_name_wanted(channel->name, names, name_count)) continue;
        status = io_channel_allocate(channel, picture->memory, error, picture->path);
        any = true;
        color |= c < source->colors;
        *(c < source->colors ? &r.plane[c] : &r.depth) = channel->data;
    }
    for (int c = 0; status == 0 && color && c < source->colors; c++) {
        if (r.plane[c] != NULL) continue;
        spare[c] = part->channel[c];
        spare[c].data = NULL;
        status = io_channel_allocate(&spare[c], picture->memory, error, picture->path);
        r.plane[c] = spare[c].data;
    }
    if (status == 0 && any) status = read_planes(&r, picture, error);
    stop(&r);
    for (int c = 0; c < 4; c++)
        io_channel_release(&spare[c]);
    return status;
}
