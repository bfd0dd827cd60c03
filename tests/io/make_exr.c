/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* EXR files made by OpenEXRCore, which is thereby also the judge of what io/ writes. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <openexr.h>

#include "support.h"

static void check(exr_result_t result) {
    if (result != EXR_ERR_SUCCESS) fail_msg("OpenEXRCore: %s", exr_get_default_error_message(result));
}

static void silent(exr_const_context_t context, exr_result_t code, const char *message) {
    (void)context, (void)code, (void)message;
}

static exr_context_initializer_t initializer(void) {
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = silent;
    return init;
}

/* ------------------------------------------------------------------------- pixels */

static uint32_t hash(uint32_t a) {
    a = (a ^ a >> 16) * 0x7feb352du;
    a = (a ^ a >> 15) * 0x846ca68bu;
    return a ^ a >> 16;
}

uint32_t sample_of(const exr_spec *spec, int channel, int column, int row) {
    uint32_t noise = hash((uint32_t)(row * 65536 + column) * 31u + (uint32_t)channel);
    io_type type = spec->channels[channel].type;
    if (type == IO_UINT) return noise % 7 ? (uint32_t)(row * 100 + column) : noise;
    if (type == IO_HALF) {
        static const uint16_t special[] = {0x7c00, 0xfc00, 0x7e01, 0x0001, 0x8000, 0x7bff};
        /* B44 has no NaN and no infinity. */
        bool lossy = spec->compression == EXR_COMPRESSION_B44 || spec->compression == EXR_COMPRESSION_B44A;
        if (noise % 97 == 0 && !lossy) return special[noise / 97 % 6];
        return 0x3000u + (uint32_t)(column * 16 + row * 5) % 0x1000u + noise % 16;
    }
    float value = 1 + (float)column * 0.25f + (float)row + (float)(noise % 1024) / 4096;
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    /* PXR24 keeps 24 bits of a float. */
    return spec->compression == EXR_COMPRESSION_PXR24 ? bits & 0xffffff00u : bits;
}

static int sampling(int value) {
    return value ? value : 1;
}

/* A whole channel, tightly packed. */
static unsigned char *make_channel(const exr_spec *spec, int channel) {
    const exr_channel_spec *c = &spec->channels[channel];
    int width = spec->data.width / sampling(c->x_sampling), height = spec->data.height / sampling(c->y_sampling);
    size_t size = io_type_size(c->type);
    unsigned char *data = malloc((size_t)width * (size_t)height * size), *at = data;
    assert_non_null(data);
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++, at += size) {
            uint32_t bits = sample_of(spec, channel, x, y);
            uint16_t half = (uint16_t)bits;
            memcpy(at, c->type == IO_HALF ? (void *)&half : (void *)&bits, size);
        }
    return data;
}

/* ------------------------------------------------------------------------- headers */

static void add_many_attributes(exr_context_t c, int part) {
    static const unsigned char pixels[4 * 3 * 2] = {1, 2, 3, 4, 5, 6, 7, 8, 9};
    static const char *texts[] = {"one", "", "drei"};
    static const float floats[] = {1.5f, -2, 3e30f};
    check(exr_attr_set_box2f(c, part, "aBox2f", &(exr_attr_box2f_t){{.x = 1, .y = 2}, {.x = 3, .y = 4}}));
    check(exr_attr_set_box2i(c, part, "aBox2i", &(exr_attr_box2i_t){{.x = -1, .y = 2}, {.x = 3, .y = 4}}));
    check(exr_attr_set_chromaticities(c, part, "chromaticities",
                                      &(exr_attr_chromaticities_t){.64f, .33f, .3f, .6f, .15f, .06f, .3127f, .329f}));
    check(exr_attr_set_double(c, part, "aDouble", 1e300));
    check(exr_attr_set_envmap(c, part, "envmap", EXR_ENVMAP_CUBE));
    check(exr_attr_set_float(c, part, "aFloat", 0.1f));
    check(exr_attr_set_float_vector(c, part, "aFloatVector", 3, floats));
    check(exr_attr_set_int(c, part, "anInt", -77));
    check(exr_attr_set_keycode(c, part, "keyCode", &(exr_attr_keycode_t){1, 2, 3, 4, 5, 6, 7}));
    check(exr_attr_set_m33f(c, part, "aM33f", &(exr_attr_m33f_t){{1, 2, 3, 4, 5, 6, 7, 8, 9}}));
    check(exr_attr_set_m33d(c, part, "aM33d", &(exr_attr_m33d_t){{1, 2, 3, 4, 5, 6, 7, 8, 9}}));
    check(exr_attr_set_m44f(c, part, "worldToCamera", &(exr_attr_m44f_t){{1, 2, 3, 4, 5, 6, 7, 8, 9}}));
    check(exr_attr_set_m44d(c, part, "aM44d", &(exr_attr_m44d_t){{1, 2, 3, 4, 5, 6, 7, 8, 9}}));
    check(exr_attr_set_preview(c, part, "preview", &(exr_attr_preview_t){3, 2, 0, pixels}));
    check(exr_attr_set_rational(c, part, "framesPerSecond", &(exr_attr_rational_t){24000, 1001}));
    check(exr_attr_set_string(c, part, "owner", "somebody"));
    check(exr_attr_set_string_vector(c, part, "aStringVector", 3, texts));
    check(exr_attr_set_timecode(c, part, "timeCode", &(exr_attr_timecode_t){0x01020304, 99}));
    check(exr_attr_set_v2i(c, part, "aV2i", &(exr_attr_v2i_t){.x = 1, .y = -2}));
    check(exr_attr_set_v2f(c, part, "aV2f", &(exr_attr_v2f_t){.x = 1, .y = -2}));
    check(exr_attr_set_v2d(c, part, "aV2d", &(exr_attr_v2d_t){.x = 1, .y = -2}));
    check(exr_attr_set_v3i(c, part, "aV3i", &(exr_attr_v3i_t){.x = 1, .y = -2, .z = 3}));
    check(exr_attr_set_v3f(c, part, "aV3f", &(exr_attr_v3f_t){.x = 1, .y = -2, .z = 3}));
    check(exr_attr_set_v3d(c, part, "aV3d", &(exr_attr_v3d_t){.x = 1, .y = -2, .z = 3}));
    check(exr_attr_set_float(c, part, "dwaCompressionLevel", 60));
    check(exr_attr_set_user(c, part, "studioData", "studioType", 5, "\1\2\0\3\4"));
    /* Longer than what is read of a header at first. */
    static unsigned char manifest[300000];
    for (size_t i = 0; i < sizeof manifest; i++)
        manifest[i] = (unsigned char)hash((uint32_t)i);
    check(exr_attr_set_user(c, part, "manifest", "studioType", sizeof manifest, manifest));
    check(exr_attr_set_string(c, part, "an attribute whose name has more than 31 characters", "long"));
}

static exr_attr_box2i_t box_of(io_box box) {
    return (exr_attr_box2i_t){{.x = box.x, .y = box.y}, {.x = box.x + box.width - 1, .y = box.y + box.height - 1}};
}

static void add_part(exr_context_t c, const exr_spec *spec, bool any_deep) {
    static const exr_pixel_type_t types[] = {
        [IO_UINT] = EXR_PIXEL_UINT, [IO_HALF] = EXR_PIXEL_HALF, [IO_FLOAT] = EXR_PIXEL_FLOAT};
    exr_attr_box2i_t data = box_of(spec->data), display = box_of(spec->display.width ? spec->display : spec->data);
    exr_storage_t storage = spec->deep   ? EXR_STORAGE_DEEP_SCANLINE
                            : spec->tile ? EXR_STORAGE_TILED
                                         : EXR_STORAGE_SCANLINE;
    int part;
    check(exr_add_part(c, spec->name ? spec->name : "a", storage, &part));
    check(exr_initialize_required_attr(c, part, &display, &data, 1.5f, &(exr_attr_v2f_t){.x = 0.5f, .y = 0}, 2,
                                       (exr_lineorder_t)spec->line_order, (exr_compression_t)spec->compression));
    if (spec->deep) check(exr_add_channel(c, part, "Z", EXR_PIXEL_FLOAT, EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1));
    if (any_deep) check(exr_set_version(c, part, 1));
    for (int i = 0; i < spec->channel_count && !spec->deep; i++) {
        const exr_channel_spec *channel = &spec->channels[i];
        check(exr_add_channel(c, part, channel->name, types[channel->type],
                              channel->linear ? EXR_PERCEPTUALLY_LINEAR : EXR_PERCEPTUALLY_LOGARITHMIC,
                              sampling(channel->x_sampling), sampling(channel->y_sampling)));
    }
    if (spec->tile)
        check(exr_set_tile_descriptor(c, part, (uint32_t)spec->tile, (uint32_t)spec->tile, EXR_TILE_ONE_LEVEL,
                                      EXR_TILE_ROUND_DOWN));
    if (spec->view) check(exr_attr_set_string(c, part, "view", spec->view));
    if (spec->many_attributes) add_many_attributes(c, part);
}

/* ------------------------------------------------------------------------- chunks */

static void write_chunk(exr_context_t c, int part, const exr_spec *spec, const exr_chunk_info_t *info,
                        unsigned char *const *pixels, int x, int y) {
    exr_encode_pipeline_t pipeline;
    check(exr_encoding_initialize(c, part, info, &pipeline));
    for (int i = 0; i < pipeline.channel_count; i++) {
        exr_coding_channel_info_t *channel = &pipeline.channels[i];
        int index = 0;
        while (strcmp(spec->channels[index].name, channel->channel_name) != 0)
            index++;
        int size = channel->bytes_per_element, width = spec->data.width / channel->x_samples;
        channel->user_pixel_stride = size;
        channel->user_line_stride = width * size;
        channel->encode_from_ptr =
            pixels[index] + ((y + channel->y_samples - 1) / channel->y_samples * width + x) * size;
    }
    check(exr_encoding_choose_default_routines(c, part, &pipeline));
    check(exr_encoding_run(c, part, &pipeline));
    check(exr_encoding_destroy(c, &pipeline));
}

static void write_deep(exr_context_t c, int part, const exr_spec *spec) {
    for (int y = 0; y < spec->data.height; y++) {
        int32_t counts[256];
        float values[512];
        int total = 0;
        for (int x = 0; x < spec->data.width; x++) {
            for (uint32_t n = hash((uint32_t)(x + 1000 * y)) % 3; n > 0; n--)
                values[total++] = (float)(x + y);
            counts[x] = total;
        }
        uint64_t bytes = (uint64_t)total * sizeof values[0];
        check(exr_write_deep_scanline_chunk(c, part, spec->data.y + y, values, bytes ? bytes : 4, bytes ? bytes : 4,
                                            counts, (uint64_t)spec->data.width * sizeof counts[0]));
    }
}

static void write_part(exr_context_t c, int part, const exr_spec *spec) {
    unsigned char *pixels[32];
    exr_chunk_info_t info;
    if (spec->deep) {
        write_deep(c, part, spec);
        return;
    }
    for (int i = 0; i < spec->channel_count; i++)
        pixels[i] = make_channel(spec, i);
    if (spec->tile) {
        for (int ty = 0; ty * spec->tile < spec->data.height; ty++)
            for (int tx = 0; tx * spec->tile < spec->data.width; tx++) {
                check(exr_write_tile_chunk_info(c, part, tx, ty, 0, 0, &info));
                write_chunk(c, part, spec, &info, pixels, tx * spec->tile, ty * spec->tile);
            }
    } else {
        int lines;
        check(exr_get_scanlines_per_chunk(c, part, &lines));
        for (int y = 0; y < spec->data.height; y += lines) {
            check(exr_write_scanline_chunk_info(c, part, spec->data.y + y, &info));
            write_chunk(c, part, spec, &info, pixels, 0, y);
        }
    }
    for (int i = 0; i < spec->channel_count; i++)
        free(pixels[i]);
}

void make_exr(const char *path, const exr_spec *parts, int count) {
    exr_context_initializer_t init = initializer();
    exr_context_t context;
    check(exr_start_write(&context, path, EXR_WRITE_FILE_DIRECTLY, &init));
    check(exr_set_longname_support(context, 1));
    bool any_deep = false;
    for (int i = 0; i < count; i++)
        any_deep |= parts[i].deep;
    for (int i = 0; i < count; i++)
        add_part(context, &parts[i], any_deep);
    check(exr_write_header(context));
    for (int i = 0; i < count; i++)
        write_part(context, i, &parts[i]);
    check(exr_finish(&context));
}

/* ------------------------------------------------------------------------- comparison */

static bool same_channels(const exr_attr_chlist_t *a, const exr_attr_chlist_t *b) {
    bool same = a->num_channels == b->num_channels;
    for (int i = 0; same && i < a->num_channels; i++) {
        const exr_attr_chlist_entry_t *x = &a->entries[i], *y = &b->entries[i];
        same = strcmp(x->name.str, y->name.str) == 0 && x->pixel_type == y->pixel_type && x->p_linear == y->p_linear &&
               x->x_sampling == y->x_sampling && x->y_sampling == y->y_sampling;
    }
    return same;
}

static bool same_value(const exr_attribute_t *a, const exr_attribute_t *b) {
    static const size_t sizes[EXR_ATTR_LAST_KNOWN_TYPE] = {[EXR_ATTR_BOX2I] = sizeof(exr_attr_box2i_t),
                                                           [EXR_ATTR_BOX2F] = sizeof(exr_attr_box2f_t),
                                                           [EXR_ATTR_CHROMATICITIES] =
                                                               sizeof(exr_attr_chromaticities_t),
                                                           [EXR_ATTR_KEYCODE] = sizeof(exr_attr_keycode_t),
                                                           [EXR_ATTR_M33F] = sizeof(exr_attr_m33f_t),
                                                           [EXR_ATTR_M33D] = sizeof(exr_attr_m33d_t),
                                                           [EXR_ATTR_M44F] = sizeof(exr_attr_m44f_t),
                                                           [EXR_ATTR_M44D] = sizeof(exr_attr_m44d_t),
                                                           [EXR_ATTR_RATIONAL] = sizeof(exr_attr_rational_t),
                                                           [EXR_ATTR_TILEDESC] = sizeof(exr_attr_tiledesc_t),
                                                           [EXR_ATTR_TIMECODE] = sizeof(exr_attr_timecode_t),
                                                           [EXR_ATTR_V2I] = sizeof(exr_attr_v2i_t),
                                                           [EXR_ATTR_V2F] = sizeof(exr_attr_v2f_t),
                                                           [EXR_ATTR_V2D] = sizeof(exr_attr_v2d_t),
                                                           [EXR_ATTR_V3I] = sizeof(exr_attr_v3i_t),
                                                           [EXR_ATTR_V3F] = sizeof(exr_attr_v3f_t),
                                                           [EXR_ATTR_V3D] = sizeof(exr_attr_v3d_t)};
    if (strcmp(a->type_name, b->type_name) != 0 || a->type != b->type) return false;
    switch (a->type) {
    case EXR_ATTR_CHLIST:
        return same_channels(a->chlist, b->chlist);
    case EXR_ATTR_COMPRESSION:
    case EXR_ATTR_ENVMAP:
    case EXR_ATTR_LINEORDER:
        return a->uc == b->uc;
    case EXR_ATTR_INT:
        return a->i == b->i;
    case EXR_ATTR_FLOAT:
        return memcmp(&a->f, &b->f, sizeof a->f) == 0;
    case EXR_ATTR_DOUBLE:
        return memcmp(&a->d, &b->d, sizeof a->d) == 0;
    case EXR_ATTR_STRING:
        return a->string->length == b->string->length &&
               memcmp(a->string->str, b->string->str, (size_t)a->string->length) == 0;
    case EXR_ATTR_STRING_VECTOR: {
        bool same = a->stringvector->n_strings == b->stringvector->n_strings;
        for (int i = 0; same && i < a->stringvector->n_strings; i++)
            same = strcmp(a->stringvector->strings[i].str, b->stringvector->strings[i].str) == 0;
        return same;
    }
    case EXR_ATTR_FLOAT_VECTOR:
        return a->floatvector->length == b->floatvector->length &&
               memcmp(a->floatvector->arr, b->floatvector->arr, (size_t)a->floatvector->length * sizeof(float)) == 0;
    case EXR_ATTR_PREVIEW:
        return a->preview->width == b->preview->width && a->preview->height == b->preview->height &&
               memcmp(a->preview->rgba, b->preview->rgba, 4u * a->preview->width * a->preview->height) == 0;
    case EXR_ATTR_OPAQUE:
        return a->opaque->size == b->opaque->size &&
               memcmp(a->opaque->packed_data, b->opaque->packed_data, (size_t)a->opaque->size) == 0;
    default:
        assert_true(sizes[a->type] > 0);
        return memcmp(a->rawptr, b->rawptr, sizes[a->type]) == 0;
    }
}

static bool listed(const char *name, const char *list) {
    const char *found = list ? strstr(list, name) : NULL;
    return found && (found == list || found[-1] == ',') && (!found[strlen(name)] || found[strlen(name)] == ',');
}

void assert_same_attributes(const char *a, const char *b, const char *except) {
    exr_context_initializer_t init = initializer();
    exr_context_t ca, cb;
    int parts, parts_b;
    check(exr_start_read(&ca, a, &init));
    check(exr_start_read(&cb, b, &init));
    check(exr_get_count(ca, &parts));
    check(exr_get_count(cb, &parts_b));
    assert_int_equal(parts, parts_b);
    for (int p = 0; p < parts; p++) {
        int count, count_b;
        check(exr_get_attribute_count(ca, p, &count));
        check(exr_get_attribute_count(cb, p, &count_b));
        assert_int_equal(count, count_b);
        for (int i = 0; i < count; i++) {
            const exr_attribute_t *x, *y;
            check(exr_get_attribute_by_index(ca, p, EXR_ATTR_LIST_FILE_ORDER, i, &x));
            if (exr_get_attribute_by_name(cb, p, x->name, &y) != EXR_ERR_SUCCESS)
                fail_msg("part %d lost the attribute %s", p, x->name);
            if (!listed(x->name, except) && !same_value(x, y))
                fail_msg("part %d: the attribute %s differs", p, x->name);
        }
    }
    check(exr_finish(&ca));
    check(exr_finish(&cb));
}
