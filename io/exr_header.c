/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* EXR headers: lists of attributes (name, type, size, value). */
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "exr.h"

enum {
    LONGEST_NAME = 255,
    MOST_CHANNELS = 4096,
    MOST_PARTS = 4096,
    MOST_VIEWS = 64,
    MOST_ATTRIBUTES = 1 << 16,
    LARGEST_COORDINATE = 1 << 29
};

/* ------------------------------------------------------------------------- bytes */

void io_bytes_append(io_bytes *bytes, const void *data, size_t size) {
    if (bytes->failed || size == 0) return;
    if (size > bytes->room - bytes->size) {
        size_t room = 2 * bytes->room + size + 256;
        unsigned char *larger = realloc(bytes->data, room);
        if (!larger) {
            bytes->failed = true;
            return;
        }
        bytes->data = larger;
        bytes->room = room;
    }
    memcpy(bytes->data + bytes->size, data, size);
    bytes->size += size;
}

void io_bytes_append32(io_bytes *bytes, uint32_t value) {
    unsigned char encoded[4];
    io_put32(encoded, value);
    io_bytes_append(bytes, encoded, sizeof encoded);
}

void io_bytes_append_text(io_bytes *bytes, const char *text) {
    io_bytes_append(bytes, text, strlen(text) + 1);
}

uint32_t io_get32(const unsigned char *b) {
    return (uint32_t)b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

uint64_t io_get64(const unsigned char *b) {
    return io_get32(b) | (uint64_t)io_get32(b + 4) << 32;
}

void io_put32(unsigned char *b, uint32_t value) {
    for (int i = 0; i < 4; i++)
        b[i] = (unsigned char)(value >> 8 * i);
}

void io_put64(unsigned char *b, uint64_t value) {
    io_put32(b, (uint32_t)value);
    io_put32(b + 4, (uint32_t)(value >> 32));
}

static float get_float(const unsigned char *b) {
    uint32_t bits = io_get32(b);
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* ------------------------------------------------------------------------- attributes */

const char *io_exr_compression_name(int compression) {
    static const char *const names[IO_EXR_COMPRESSIONS] = {"none",  "RLE", "ZIPS", "ZIP",  "PIZ",
                                                           "PXR24", "B44", "B44A", "DWAA", "DWAB"};
    return compression >= 0 && compression < IO_EXR_COMPRESSIONS ? names[compression] : "unknown";
}

const io_exr_attribute *io_exr_find(const io_exr_part *part, const char *name) {
    for (int i = 0; i < part->attribute_count; i++)
        if (strcmp(part->attribute[i].name, name) == 0) return &part->attribute[i];
    return NULL;
}

void io_exr_append_attribute(io_bytes *bytes, const io_exr_attribute *attribute) {
    io_bytes_append_text(bytes, attribute->name);
    io_bytes_append_text(bytes, attribute->type);
    io_bytes_append32(bytes, attribute->size);
    io_bytes_append(bytes, attribute->value, attribute->size);
}

/* What the parser works on. `short_of` is set when the bytes end too early. */
typedef struct parser {
    const char *path;
    const unsigned char *at, *end;
    bool short_of;
    io_error *error;
    uint64_t least; /* bytes of pixels there must be at least, of the parts so far */
} parser;

static const char *take_name(parser *p) {
    size_t left = (size_t)(p->end - p->at), most = left < LONGEST_NAME + 1 ? left : LONGEST_NAME + 1;
    const unsigned char *nul = most ? memchr(p->at, 0, most) : NULL;
    const char *name = (const char *)p->at;
    if (!nul) {
        p->short_of = left <= LONGEST_NAME;
        if (!p->short_of)
            io_fail(p->error, "%s: a name in the header is longer than %d characters; the file is damaged", p->path,
                    LONGEST_NAME);
        return NULL;
    }
    p->at = nul + 1;
    return name;
}

/* One attribute; *last when it was the empty name that ends a header. */
static int take_attribute(parser *p, io_exr_attribute *attribute, bool *last) {
    *last = false;
    if (!(attribute->name = take_name(p))) return -1;
    if (!attribute->name[0]) {
        *last = true;
        return 0;
    }
    if (!(attribute->type = take_name(p))) return -1;
    if (p->end - p->at < 4) {
        p->short_of = true;
        return -1;
    }
    attribute->size = io_get32(p->at);
    p->at += 4;
    if (attribute->size > INT32_MAX)
        return io_fail(p->error, "%s: the attribute '%s' has a negative size; the file is damaged", p->path,
                       attribute->name);
    if ((size_t)(p->end - p->at) < attribute->size) {
        p->short_of = true;
        return -1;
    }
    attribute->value = p->at;
    p->at += attribute->size;
    return 0;
}

static int take_attributes(parser *p, io_exr_part *part) {
    bool last = false;
    while (!last) {
        io_exr_attribute attribute = {0};
        if (take_attribute(p, &attribute, &last) != 0) return -1;
        if (last) break;
        if (part->attribute_count == MOST_ATTRIBUTES)
            return io_fail(p->error, "%s: has more than %d attributes; the file is damaged", p->path, MOST_ATTRIBUTES);
        if ((part->attribute_count & (part->attribute_count - 1)) == 0) {
            size_t room = part->attribute_count ? 2 * (size_t)part->attribute_count : 1;
            void *larger = realloc(part->attribute, room * sizeof attribute);
            if (!larger) return io_fail(p->error, "%s: not enough memory", p->path);
            part->attribute = larger;
        }
        part->attribute[part->attribute_count++] = attribute;
    }
    return 0;
}

/* The value of an attribute that must be there, once, with this type and size (0: any). */
static const io_exr_attribute *required(parser *p, const io_exr_part *part, const char *name, const char *type,
                                        uint32_t size) {
    const io_exr_attribute *found = io_exr_find(part, name);
    if (!found || strcmp(found->type, type) != 0 || (size && found->size != size)) {
        io_fail(p->error, "%s: the header has no valid '%s'; the file is damaged", p->path, name);
        return NULL;
    }
    for (int i = 0; i < part->attribute_count; i++)
        if (&part->attribute[i] != found && strcmp(part->attribute[i].name, name) == 0) {
            io_fail(p->error, "%s: the header has '%s' twice; the file is damaged", p->path, name);
            return NULL;
        }
    return found;
}

static char *copy_string(const io_exr_part *part, const char *name) {
    const io_exr_attribute *found = io_exr_find(part, name);
    return found && strcmp(found->type, "string") == 0 ? strndup((const char *)found->value, found->size) : strdup("");
}

/* ------------------------------------------------------------------------- one part */

static int parse_window(parser *p, const io_exr_part *part, const char *name, io_box *box) {
    const io_exr_attribute *a = required(p, part, name, "box2i", 16);
    if (!a) return -1;
    int32_t value[4];
    for (int i = 0; i < 4; i++) {
        value[i] = (int32_t)io_get32(a->value + 4 * i);
        if (value[i] > LARGEST_COORDINATE || value[i] < -LARGEST_COORDINATE)
            return io_fail(p->error, "%s: '%s' reaches to coordinate %ld; the file is damaged", p->path, name,
                           (long)value[i]);
    }
    if (value[2] < value[0] || value[3] < value[1])
        return io_fail(p->error, "%s: '%s' is empty; the file is damaged", p->path, name);
    *box = (io_box){value[0], value[1], value[2] - value[0] + 1, value[3] - value[1] + 1};
    return 0;
}

static int parse_storage(parser *p, const io_exr_source *source, io_exr_part *part) {
    const io_exr_attribute *type = io_exr_find(part, "type");
    bool by_type = source->version & (IO_EXR_FLAG_MULTIPART | IO_EXR_FLAG_DEEP);
    part->tiled = source->version & IO_EXR_FLAG_TILED;
    if (by_type) {
        static const char *const names[] = {"scanlineimage", "tiledimage", "deepscanline", "deeptile"};
        int found = -1;
        for (int i = 0; type && i < 4; i++)
            if (strlen(names[i]) == strnlen((const char *)type->value, type->size) &&
                memcmp(names[i], type->value, strlen(names[i])) == 0)
                found = i;
        if (found < 0)
            return io_fail(p->error, "%s: a part is of no known type; convert the file to flat EXR", p->path);
        part->tiled = found & 1;
        part->deep = found & 2;
    }
    if (!part->tiled) return 0;
    const io_exr_attribute *tiles = required(p, part, "tiles", "tiledesc", 9);
    if (!tiles) return -1;
    uint32_t width = io_get32(tiles->value), height = io_get32(tiles->value + 4);
    part->level_mode = tiles->value[8] & 15;
    part->round_up = tiles->value[8] >> 4 == 1;
    if (width < 1 || height < 1 || width > INT_MAX / 4 || height > INT_MAX / 4 || part->level_mode > IO_EXR_RIPMAP ||
        tiles->value[8] >> 4 > 1)
        return io_fail(p->error, "%s: the description of its tiles is damaged", p->path);
    /* Tiles larger than the picture are allowed and hold no more than it. */
    part->tile_width = (int)width;
    part->tile_height = (int)height;
    return 0;
}

static int by_name(const void *a, const void *b) {
    return strcmp((*(io_channel *const *)a)->name, (*(io_channel *const *)b)->name);
}

/* Samples are stored in the order of the channels' names, whatever the order in the header: readers keep them in a map.
 */
int io_exr_sort_channels(const char *path, const io_part *part, io_exr_part *layout, io_error *error) {
    size_t count = (size_t)part->channel_count;
    const io_channel **sorted = malloc((count + 1) * sizeof *sorted);
    layout->order = malloc((count + 1) * sizeof *layout->order);
    if (!sorted || !layout->order) {
        free(sorted);
        return io_fail(error, "%s: not enough memory", path);
    }
    for (size_t i = 0; i < count; i++)
        sorted[i] = &part->channel[i];
    qsort(sorted, count, sizeof *sorted, by_name);
    int result = 0;
    for (size_t i = 0; i < count; i++) {
        layout->order[i] = (int)(sorted[i] - part->channel);
        if (i && strcmp(sorted[i - 1]->name, sorted[i]->name) == 0)
            result = io_fail(error, "%s: has two channels named '%s'; the file is damaged", path, sorted[i]->name);
    }
    free(sorted);
    return result;
}

static int parse_channel(parser *p, const char *name, const unsigned char *entry, io_part *part, io_exr_part *layout) {
    static const io_type types[] = {IO_UINT, IO_HALF, IO_FLOAT};
    uint32_t type = io_get32(entry), x_sampling = io_get32(entry + 8), y_sampling = io_get32(entry + 12);
    const io_box *w = &part->data;
    if (part->channel_count == MOST_CHANNELS)
        return io_fail(p->error, "%s: has more than %d channels in a part", p->path, MOST_CHANNELS);
    if (type > 2)
        return io_fail(p->error, "%s: the channel '%s' is of no known type; the file is damaged", p->path, name);
    if (x_sampling < 1 || y_sampling < 1 || x_sampling > (uint32_t)w->width || y_sampling > (uint32_t)w->height ||
        w->x % (int)x_sampling || w->width % (int)x_sampling || w->y % (int)y_sampling || w->height % (int)y_sampling ||
        ((x_sampling > 1 || y_sampling > 1) && (layout->tiled || layout->deep)))
        return io_fail(p->error, "%s: the channel '%s' has an impossible subsampling; the file is damaged", p->path,
                       name);
    io_channel *channel = io_add_channel(part, name, types[type], (int)x_sampling, (int)y_sampling);
    bool *linear = realloc(layout->linear, (size_t)(part->channel_count + 1) * sizeof *linear);
    layout->linear = linear ? linear : layout->linear;
    io_type *file_type = realloc(layout->type, (size_t)(part->channel_count + 1) * sizeof *file_type);
    layout->type = file_type ? file_type : layout->type;
    if (!channel || !linear || !file_type) return io_fail(p->error, "%s: not enough memory", p->path);
    linear[part->channel_count - 1] = entry[4] != 0;
    file_type[part->channel_count - 1] = types[type];
    int bits = type == 1 ? 16 : 32;
    part->bits = bits > part->bits ? bits : part->bits;
    return 0;
}

static int parse_channels(parser *p, io_part *part, io_exr_part *layout) {
    const io_exr_attribute *a = required(p, layout, "channels", "chlist", 0);
    if (!a) return -1;
    parser list = {p->path, a->value, a->value + a->size, false, p->error, 0};
    for (;;) {
        const char *name = take_name(&list);
        if (!name || (name[0] && list.end - list.at < 16))
            return io_fail(p->error, "%s: the list of channels is damaged", p->path);
        if (!name[0]) break;
        if (parse_channel(p, name, list.at, part, layout) != 0) return -1;
        list.at += 16;
    }
    if (part->channel_count == 0)
        return io_fail(p->error, "%s: has a part without channels; the file is damaged", p->path);
    return io_exr_sort_channels(p->path, part, layout, p->error);
}

static const char *storage_name(const io_exr_part *layout) {
    if (layout->deep) return layout->tiled ? "deep tiled" : "deep scanline";
    if (!layout->tiled) return "scanline";
    return layout->level_mode == IO_EXR_ONE_LEVEL ? "tiled"
           : layout->level_mode == IO_EXR_MIPMAP  ? "mipmap tiled"
                                                  : "ripmap tiled";
}

/* The views of a part that has several: "multiView", of texts with their lengths before them. Its own is the one whose
 * channels have no prefix: the first. False: out of memory. */
static bool take_views(const io_exr_part *layout, io_part *part) {
    const io_exr_attribute *views = io_exr_find(layout, "multiView");
    if (io_exr_find(layout, "view") || !views || strcmp(views->type, "stringvector") != 0) return true;
    part->views = calloc(MOST_VIEWS, sizeof *part->views);
    if (!part->views) return false;
    for (uint32_t at = 0; part->view_count < MOST_VIEWS && views->size - at >= 4;) {
        const uint32_t size = io_get32(views->value + at);
        at += 4;
        if (size > views->size - at) break;
        char *name = strndup((const char *)views->value + at, size);
        if (!name) return false;
        part->views[part->view_count++] = name;
        at += size;
    }
    if (part->view_count == 0) return true;
    free(part->view);
    part->view = strdup(part->views[0]);
    return part->view != NULL;
}

/* A declared size that the file cannot hold even if every codec did its best: a damaged header, or a bomb. */
static int check_plausible(parser *p, const io_exr_source *source, const io_part *part, const io_exr_part *layout) {
    uint64_t bytes = 0;
    for (int i = 0; i < part->channel_count; i++)
        bytes += (uint64_t)part->channel[i].width * (uint64_t)part->channel[i].height * io_type_size(layout->type[i]);
    if (!layout->deep) p->least += bytes / io_exr_most_unpacked(layout->compression);
    if (source->file < 0 || p->least <= source->length) return 0;
    return io_fail(p->error,
                   "%s: declares %d x %d pixels (%llu MiB), which its %llu bytes cannot hold; the file is cut off or "
                   "damaged",
                   p->path, part->data.width, part->data.height, (unsigned long long)(bytes >> 20),
                   (unsigned long long)source->length);
}

static int parse_part(parser *p, io_picture *picture, io_exr_source *source, io_exr_part *layout) {
    io_box data, display;
    const io_exr_attribute *compression, *order, *aspect = io_exr_find(layout, "pixelAspectRatio");
    if (parse_window(p, layout, "dataWindow", &data) != 0 || parse_window(p, layout, "displayWindow", &display) != 0 ||
        io_check_size(p->path, data.width, data.height, &source->options, p->error) != 0 ||
        !(compression = required(p, layout, "compression", "compression", 1)) ||
        !(order = required(p, layout, "lineOrder", "lineOrder", 1)) || parse_storage(p, source, layout) != 0)
        return -1;
    layout->compression = compression->value[0];
    layout->line_order = order->value[0];
    layout->window = data;
    if (layout->compression >= IO_EXR_COMPRESSIONS)
        return io_fail(p->error, "%s: is compressed in a way (%d) this program does not know; write it as ZIP or PIZ",
                       p->path, layout->compression);
    if (layout->line_order > IO_EXR_RANDOM_Y) return io_fail(p->error, "%s: 'lineOrder' is damaged", p->path);

    char *name = copy_string(layout, "name"), *view = copy_string(layout, "view");
    io_part *part = name && view ? io_add_part(picture, name, view, data, display) : NULL;
    free(name);
    free(view);
    if (!part || !take_views(layout, part)) return io_fail(p->error, "%s: not enough memory", p->path);
    if (aspect && aspect->size == 4 && get_float(aspect->value) > 0 && isfinite(get_float(aspect->value)))
        part->pixel_aspect = get_float(aspect->value);
    part->compression = io_exr_compression_name(layout->compression);
    part->storage = storage_name(layout);
    part->deep = layout->deep;
    part->multi_level = layout->tiled && layout->level_mode != IO_EXR_ONE_LEVEL;
    if (parse_channels(p, part, layout) != 0 || io_exr_count_chunks(p->path, layout, p->error) != 0) return -1;

    const io_exr_attribute *count = io_exr_find(layout, "chunkCount");
    if (count && count->size == 4 && (source->version & (IO_EXR_FLAG_MULTIPART | IO_EXR_FLAG_DEEP)) &&
        io_get32(count->value) != (uint32_t)layout->chunk_count)
        return io_fail(p->error, "%s: 'chunkCount' does not fit the size of the picture; the file is damaged", p->path);
    io_exr_chunk largest;
    io_exr_place_chunk(part, layout, 0, &largest);
    if (!layout->deep && largest.unpacked > INT32_MAX)
        return io_fail(p->error, "%s: its tiles or blocks of rows are larger than 2 GiB; the file is damaged", p->path);
    part->chunk_bytes = largest.unpacked;
    return check_plausible(p, source, part, layout);
}

/* ------------------------------------------------------------------------- the whole header */

void io_exr_free_parts(io_exr_source *source) {
    for (int i = 0; i < source->part_count; i++) {
        free(source->part[i].attribute);
        free(source->part[i].offset);
        free(source->part[i].order);
        free(source->part[i].type);
        free(source->part[i].linear);
    }
    free(source->part);
    source->part = NULL;
    source->part_count = 0;
}

static int take_headers(parser *p, io_exr_source *source) {
    bool multipart = source->version & IO_EXR_FLAG_MULTIPART;
    do {
        if (multipart && p->at < p->end && p->at[0] == 0) {
            p->at++;
            if (source->part_count == 0) return io_fail(p->error, "%s: has no parts; the file is damaged", p->path);
            return 0;
        }
        if (source->part_count == MOST_PARTS)
            return io_fail(p->error, "%s: has more than %d parts", p->path, MOST_PARTS);
        io_exr_part *larger = realloc(source->part, (size_t)(source->part_count + 1) * sizeof *larger);
        if (!larger) return io_fail(p->error, "%s: not enough memory", p->path);
        source->part = larger;
        source->part[source->part_count] = (io_exr_part){0};
        if (take_attributes(p, &source->part[source->part_count++]) != 0) return -1;
    } while (multipart);
    return 0;
}

int io_exr_parse(io_picture *picture, io_exr_source *source, bool complete, io_error *error) {
    parser p = {picture->path, source->header, source->header + source->header_size, false, error, 0};
    if (take_headers(&p, source) != 0) {
        io_exr_free_parts(source);
        if (p.short_of && !complete) return 1;
        return p.short_of
                   ? io_fail(error, "%s: ends within its header; it is cut off, copy or write it again", picture->path)
                   : -1;
    }
    uint64_t table = 8 + (uint64_t)(p.at - source->header);
    for (int i = 0; i < source->part_count; i++) {
        if (parse_part(&p, picture, source, &source->part[i]) != 0) return -1;
        source->part[i].table = table;
        table += 8 * (uint64_t)source->part[i].chunk_count;
    }
    if (source->file >= 0 && table > source->length)
        return io_fail(error, "%s: ends after %llu bytes, before its first row; it is cut off, copy or write it again",
                       picture->path, (unsigned long long)source->length);
    return 0;
}

/* ------------------------------------------------------------------------- a header of our own */

static void append_channels(io_bytes *bytes, const io_part *part, const io_exr_part *layout) {
    static const uint32_t types[] = {[IO_UINT] = 0, [IO_HALF] = 1, [IO_FLOAT] = 2};
    io_bytes list = {0};
    for (int i = 0; i < part->channel_count; i++) {
        const io_channel *channel = &part->channel[layout->order[i]];
        unsigned char flags[4] = {layout->linear[layout->order[i]], 0, 0, 0};
        io_bytes_append_text(&list, channel->name);
        io_bytes_append32(&list, types[layout->type[layout->order[i]]]);
        io_bytes_append(&list, flags, 4);
        io_bytes_append32(&list, (uint32_t)channel->x_sampling);
        io_bytes_append32(&list, (uint32_t)channel->y_sampling);
    }
    io_bytes_append_text(&list, "");
    io_exr_append_attribute(bytes, &(io_exr_attribute){"channels", "chlist", list.data, (uint32_t)list.size});
    bytes->failed |= list.failed;
    free(list.data);
}

static void append_window(io_bytes *bytes, const char *name, const io_box *box) {
    unsigned char value[16];
    io_put32(value, (uint32_t)box->x);
    io_put32(value + 4, (uint32_t)box->y);
    io_put32(value + 8, (uint32_t)(box->x + box->width - 1));
    io_put32(value + 12, (uint32_t)(box->y + box->height - 1));
    io_exr_append_attribute(bytes, &(io_exr_attribute){name, "box2i", value, 16});
}

void io_exr_plain_header(io_bytes *bytes, const io_part *part, const io_exr_part *layout, const io_box *display,
                         float pixel_aspect) {
    static const unsigned char one[4] = {0, 0, 0x80, 0x3f}, zero[8];
    unsigned char aspect[4];
    uint32_t bits;
    memcpy(&bits, &pixel_aspect, sizeof bits);
    io_put32(aspect, bits);
    unsigned char compression = (unsigned char)layout->compression, order = (unsigned char)layout->line_order;
    append_channels(bytes, part, layout);
    io_exr_append_attribute(bytes, &(io_exr_attribute){"compression", "compression", &compression, 1});
    append_window(bytes, "dataWindow", &part->data);
    append_window(bytes, "displayWindow", display);
    io_exr_append_attribute(bytes, &(io_exr_attribute){"lineOrder", "lineOrder", &order, 1});
    io_exr_append_attribute(bytes, &(io_exr_attribute){"pixelAspectRatio", "float", aspect, 4});
    io_exr_append_attribute(bytes, &(io_exr_attribute){"screenWindowCenter", "v2f", zero, 8});
    io_exr_append_attribute(bytes, &(io_exr_attribute){"screenWindowWidth", "float", one, 4});
    if (layout->tiled) {
        unsigned char tiles[9] = {0};
        io_put32(tiles, (uint32_t)layout->tile_width);
        io_put32(tiles + 4, (uint32_t)layout->tile_height);
        io_exr_append_attribute(bytes, &(io_exr_attribute){"tiles", "tiledesc", tiles, 9});
    }
    io_bytes_append_text(bytes, "");
}
