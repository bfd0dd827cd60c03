/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* HEIC and AVIF, by libheif: the primary image, and as the channel "depth" the depth image that belongs to it.
 *
 * Colour is decoded as that of PNG is: nclx says the curve, none is sRGB. libheif turns, mirrors and crops both images as
 * the file says of each. The depth of phones is smaller than their colour: it is brought to the colour's size here,
 * between its pixels bilinearly, but across a step by the nearest pixel: a mean of near and far would be a distance at
 * which there is nothing. */
#include "heif.h"

#include <libheif/heif.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "coding.h"

/* Of the range of the depth: neighbours farther apart than this are two surfaces. */
static const float STEP = 1.0f / 32;
static const double FARTHEST = 1e9; /* as the library: at and beyond it is infinitely far */

typedef struct io_source {
    io_options options;
    io_coding coding;
    unsigned char *bytes; /* of the file, for as long as there is the context */
    struct heif_context *context;
    struct heif_image_handle *color, *depth; /* depth: NULL for none */
    int colors;                              /* channels: R G B, R G B A */
} io_source;

static int fail_heif(const io_picture *picture, struct heif_error e, io_error *error) {
    if (e.code == heif_error_Unsupported_feature || e.code == heif_error_Unsupported_filetype)
        return io_fail(error, "%s: holds what libheif cannot decode here (%s); convert the picture", picture->path, e.message);
    return io_fail(error, "%s: is damaged or cut off (%s); get the file again", picture->path, e.message);
}

/* ------------------------------------------------------------------------- what the depth means */

static bool distance(double z) {
    return isfinite(z) && z > 0;
}

/* Two ends that depth can have between them; false when they make no sense. */
static bool set_ends(io_depth *depth, double at_0, double at_1) {
    const bool linear = depth->kind == IO_DEPTH_LINEAR;
    if (at_0 >= FARTHEST && !linear) at_0 = INFINITY;
    if (at_1 >= FARTHEST && !linear) at_1 = INFINITY;
    if (!(at_0 > 0) || !(at_1 > 0) || at_0 == at_1 || (linear && !(isfinite(at_0) && isfinite(at_1)))) return false;
    depth->at_0 = at_0;
    depth->at_1 = at_1;
    return true;
}

/* ITU-T H.265, depth representation information: 0 is the farthest Z or the least disparity, but where the values are Z
 * themselves. A disparity is there a shift between views; phones, which have none to compare with, write 1 / metres. */
static io_depth meaning_of_depth(const struct heif_image_handle *color, heif_item_id id) {
    io_depth depth = {0};
    const struct heif_depth_representation_info *info = NULL;
    if (!heif_image_handle_get_depth_image_representation_info(color, id, &info) || info == NULL) return depth;
    const int type = (int)info->depth_representation_type;
    const bool z = info->has_z_near && info->has_z_far && distance(info->z_near) && distance(info->z_far);
    const bool d = info->has_d_min && info->has_d_max && info->d_min >= 0 && distance(info->d_max);
    if (type == heif_depth_representation_type_uniform_Z) {
        depth.kind = IO_DEPTH_LINEAR;
        if (z) set_ends(&depth, info->z_near, info->z_far);
    } else if (type == heif_depth_representation_type_uniform_inverse_Z ||
               type == heif_depth_representation_type_uniform_disparity) {
        depth.kind = IO_DEPTH_DISPARITY;
        if (z)
            set_ends(&depth, info->z_far, info->z_near);
        else if (d && type == heif_depth_representation_type_uniform_disparity)
            set_ends(&depth, 1 / info->d_min, 1 / info->d_max);
    }
    heif_depth_representation_info_free(info);
    return depth;
}

/* ------------------------------------------------------------------------- opening */

static int find_curve(io_picture *picture, io_source *source, io_error *error) {
    struct heif_color_profile_nclx *nclx = NULL;
    source->coding.curve = IO_CURVE_SRGB;
    source->coding.alpha = source->colors < 4                                              ? IO_ALPHA_NONE
                           : heif_image_handle_is_premultiplied_alpha(source->color) != 0 ? IO_ALPHA_ASSOCIATED
                                                                                          : IO_ALPHA_STRAIGHT;
    const size_t size = heif_image_handle_get_raw_color_profile_size(source->color);
    unsigned char *profile = size > 0 ? malloc(size) : NULL;
    if (profile != NULL && heif_image_handle_get_raw_color_profile(source->color, profile).code == heif_error_Ok)
        io_note_profile(picture, profile, size);
    free(profile);
    if (heif_image_handle_get_nclx_color_profile(source->color, &nclx).code != heif_error_Ok || nclx == NULL) return 0;
    const int status = io_curve_of_transfer(&source->coding, (int)nclx->transfer_characteristics, picture->path, error);
    if (status == 0 && size == 0) io_note_primaries(picture, (int)nclx->color_primaries);
    heif_nclx_color_profile_free(nclx);
    return status;
}

/* The depth shows what the colour shows if it has its shape, but for the rounding of a smaller size. */
static bool same_shape(double width, double height, double depth_width, double depth_height) {
    return fabs(depth_width * height - depth_height * width) <= 0.51 * (width + height) + 0.02 * depth_width * height;
}

static void find_depth(io_picture *picture, io_source *source, io_depth *meaning) {
    heif_item_id id;
    if (heif_image_handle_get_list_of_depth_image_IDs(source->color, &id, 1) < 1 ||
        heif_image_handle_get_depth_image_handle(source->color, id, &source->depth).code != heif_error_Ok)
        return;
    const int width = heif_image_handle_get_width(source->color), height = heif_image_handle_get_height(source->color);
    const int w = heif_image_handle_get_width(source->depth), h = heif_image_handle_get_height(source->depth);
    if (io_check_size(picture->path, w, h, &source->options, NULL) == 0 && same_shape(width, height, w, h)) {
        *meaning = meaning_of_depth(source->color, id);
        return;
    }
    io_note(&picture->note, picture->path, "its depth is left out: of %dx%d, it does not show what its colour of %dx%d shows", w,
            h, width, height);
    heif_image_handle_release(source->depth);
    source->depth = NULL;
}

static int add_part(io_picture *picture, const io_source *source, const io_depth *meaning) {
    static const char *const names[] = {"R", "G", "B", "A"};
    const io_box box = {0, 0, heif_image_handle_get_width(source->color), heif_image_handle_get_height(source->color)};
    io_part *part = io_add_part(picture, "", "", box, box);
    const int bits = heif_image_handle_get_luma_bits_per_pixel(source->color);
    for (int c = 0; part != NULL && c < source->colors + (source->depth != NULL); c++) {
        io_channel *channel = io_add_channel(part, c < source->colors ? names[c] : "depth", IO_FLOAT, 1, 1);
        if (channel == NULL) return -1;
        channel->integer = true;
        if (c == source->colors) channel->depth = *meaning;
    }
    if (part == NULL) return -1;
    part->bits = bits > 0 ? bits : 8;
    part->storage = "coded image";
    part->compression = "HEIF";
    return 0;
}

/* The side of a picture that libheif may decode: its own limit, or less. */
static int longest_side(const io_options *options) {
    enum { LIBHEIF_SIDE = 32768 };
    return options->max_pixels > 0 && options->max_pixels < LIBHEIF_SIDE ? (int)options->max_pixels : LIBHEIF_SIDE;
}

static int parse(io_picture *picture, io_source *source, size_t size, io_meaning meaning, io_error *error) {
    source->context = heif_context_alloc();
    if (source->context == NULL) return io_fail(error, "%s: not enough memory", picture->path);
    const int threads = io_thread_count(source->options.threads);
    heif_context_set_max_decoding_threads(source->context, threads > 1 ? threads : 0); /* 1 would be one beside this one */
    heif_context_set_maximum_image_size_limit(source->context, longest_side(&source->options));
    struct heif_error e = heif_context_read_from_memory_without_copy(source->context, source->bytes, size, NULL);
    if (e.code == heif_error_Ok) e = heif_context_get_primary_image_handle(source->context, &source->color);
    if (e.code != heif_error_Ok) return fail_heif(picture, e, error);
    if (io_check_size(picture->path, heif_image_handle_get_width(source->color), heif_image_handle_get_height(source->color),
                      &source->options, error) != 0)
        return -1;
    source->colors = heif_image_handle_has_alpha_channel(source->color) ? 4 : 3;
    io_depth depth = {0};
    if (meaning == IO_COLOR && find_curve(picture, source, error) != 0) return -1;
    find_depth(picture, source, &depth);
    return add_part(picture, source, &depth) == 0 ? 0 : io_fail(error, "%s: not enough memory", picture->path);
}

int io_heif_open(io_picture *picture, io_meaning meaning, const io_options *options, io_error *error) {
    size_t size;
    io_source *source = picture->source = calloc(1, sizeof *source);
    if (source == NULL) return io_fail(error, "%s: not enough memory", picture->path);
    source->options = *options;
    if (io_read_whole(picture, &source->bytes, &size, error) != 0) return -1;
    return parse(picture, source, size, meaning, error);
}

void io_heif_close(io_picture *picture) {
    io_source *source = picture->source;
    if (source->depth != NULL) heif_image_handle_release(source->depth);
    if (source->color != NULL) heif_image_handle_release(source->color);
    if (source->context != NULL) heif_context_free(source->context);
    free(source->bytes);
    free(source);
    picture->source = NULL;
}

/* ------------------------------------------------------------------------- pixels */

/* A plane of a decoded image: integers of 8 bits, or of more in two bytes, the machine's order. */
typedef struct plane {
    const unsigned char *data;
    int width, height, bits, stride;
} plane;

static uint32_t sample(const plane *p, int x, int y) {
    const unsigned char *row = p->data + (size_t)y * (size_t)p->stride;
    uint16_t wide;
    if (p->bits <= 8) return row[x];
    memcpy(&wide, row + 2 * (size_t)x, sizeof wide);
    return wide;
}

/* False when the image is not what the file's header said. */
static bool get_plane(plane *p, const struct heif_image *image, enum heif_channel channel, int width, int height) {
    *p = (plane){.width = heif_image_get_width(image, channel),
                 .height = heif_image_get_height(image, channel),
                 .bits = heif_image_get_bits_per_pixel_range(image, channel)};
    p->data = heif_image_get_plane_readonly(image, channel, &p->stride);
    return p->data != NULL && p->width == width && p->height == height && p->bits >= 1 && p->bits <= 16 &&
           p->stride >= (int64_t)p->width * (p->bits > 8 ? 2 : 1);
}

static int fail_changed(const io_picture *picture, io_error *error) {
    return io_fail(error, "%s: is damaged (its pixels are not what its header says); get the file again", picture->path);
}

/* `out`: NULL for a channel nobody asked for; its row is needed all the same, alpha's for one. */
static int decode_color(io_picture *picture, const plane *in, float *const *out, io_error *error) {
    const io_source *source = picture->source;
    const int colors = source->colors, width = in[0].width;
    float *table[4] = {NULL}, *scratch = malloc(sizeof(float) * (size_t)width * 4);
    bool good = scratch != NULL;
    for (int c = 0; c < colors; c++)
        good = (table[c] = io_decode_table(&source->coding, in[c].bits, c < 3, false)) != NULL && good;
    for (int y = 0; good && y < in[0].height; y++) {
        float *row[4];
        for (int c = 0; c < colors; c++) {
            const uint32_t maximum = (1u << in[c].bits) - 1;
            row[c] = out[c] != NULL ? out[c] + (size_t)y * (size_t)width : scratch + (size_t)c * (size_t)width;
            for (int x = 0; x < width; x++) {
                const uint32_t v = sample(&in[c], x, y);
                row[c][x] = table[c][v < maximum ? v : maximum];
            }
        }
        io_decode_row(&source->coding, row, 3, colors == 4 ? row[3] : NULL, width);
    }
    for (int c = 0; c < colors; c++)
        free(table[c]);
    free(scratch);
    return good ? 0 : io_fail(error, "%s: not enough memory to read %d x %d pixels", picture->path, width, in[0].height);
}

static int read_color(io_picture *picture, float *const *out, io_error *error) {
    static const enum heif_channel channels[] = {heif_channel_R, heif_channel_G, heif_channel_B, heif_channel_Alpha};
    const io_source *source = picture->source;
    const io_box box = picture->part[0].data;
    struct heif_image *image = NULL;
    plane in[4];
    struct heif_error e = heif_decode_image(source->color, &image, heif_colorspace_RGB, heif_chroma_444, NULL);
    if (e.code != heif_error_Ok) return fail_heif(picture, e, error);
    bool good = true;
    for (int c = 0; good && c < source->colors; c++)
        good = get_plane(&in[c], image, channels[c], box.width, box.height);
    const int status = good ? decode_color(picture, in, out, error) : fail_changed(picture, error);
    heif_image_release(image);
    return status;
}

/* The four pixels around a place; the nearest of them where they lie on two surfaces. */
static float depth_at(const plane *p, float maximum, double x, double y) {
    const int x0 = (int)fmin(fmax(floor(x), 0), p->width - 1), y0 = (int)fmin(fmax(floor(y), 0), p->height - 1);
    const int x1 = x0 + 1 < p->width ? x0 + 1 : x0, y1 = y0 + 1 < p->height ? y0 + 1 : y0;
    const float u = (float)fmin(fmax(x - x0, 0), 1), v = (float)fmin(fmax(y - y0, 0), 1);
    const float a = (float)sample(p, x0, y0), b = (float)sample(p, x1, y0);
    const float c = (float)sample(p, x0, y1), d = (float)sample(p, x1, y1);
    const float low = fminf(fminf(a, b), fminf(c, d)), high = fmaxf(fmaxf(a, b), fmaxf(c, d));
    if (high - low > STEP * maximum) return v < 0.5f ? u < 0.5f ? a : b : u < 0.5f ? c : d;
    const float above = a + (b - a) * u, below = c + (d - c) * u;
    return above + (below - above) * v;
}

static void fit_depth(const plane *p, io_channel *channel) {
    const float maximum = (float)((1u << p->bits) - 1);
    const double across = (double)p->width / channel->width, down = (double)p->height / channel->height;
    float *out = channel->data;
    for (int y = 0; y < channel->height; y++)
        for (int x = 0; x < channel->width; x++) {
            const float value = depth_at(p, maximum, (x + 0.5) * across - 0.5, (y + 0.5) * down - 0.5);
            *out++ = fminf(value / maximum, 1);
        }
}

/* The samples as they are coded, luma for one: a depth has no colour to convert. */
static int read_depth(io_picture *picture, io_channel *channel, io_error *error) {
    const io_source *source = picture->source;
    struct heif_image *image = NULL;
    plane p;
    struct heif_error e =
        heif_decode_image(source->depth, &image, heif_colorspace_undefined, heif_chroma_undefined, NULL);
    if (e.code != heif_error_Ok) return fail_heif(picture, e, error);
    const bool grey = heif_image_has_channel(image, heif_channel_Y);
    const bool good = get_plane(&p, image, grey ? heif_channel_Y : heif_channel_G, heif_image_handle_get_width(source->depth),
                                heif_image_handle_get_height(source->depth));
    if (good) fit_depth(&p, channel);
    heif_image_release(image);
    return good ? 0 : fail_changed(picture, error);
}

int io_heif_read(io_picture *picture, int part_index, const char *const *names, int name_count, io_error *error) {
    enum { BYTES = 24 }; /* a pixel while it is decoded: YCbCr, RGB, alpha, floats */
    io_part *part = &picture->part[part_index];
    const int colors = picture->source->colors;
    float *planes[4] = {NULL};
    bool color = false, depth = false;
    const uint64_t pixels = (uint64_t)part->data.width * (uint64_t)part->data.height;
    if (io_check_memory(picture->path, pixels * BYTES, error) != 0) return -1;
    for (int c = 0; c < part->channel_count; c++) {
        io_channel *channel = &part->channel[c];
        if (channel->data != NULL || !io_name_wanted(channel->name, names, name_count)) continue;
        if (io_channel_allocate(channel, picture->memory, error, picture->path) != 0) return -1;
        if (c < colors) planes[c] = channel->data;
        color |= c < colors;
        depth |= c == colors;
    }
    int status = color ? read_color(picture, planes, error) : 0;
    if (status == 0 && depth) status = read_depth(picture, &part->channel[colors], error);
    return status;
}
