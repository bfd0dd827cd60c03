/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include <math.h>
#include <picture.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "commands.h"
#include "job.h"
#include "json.h"
#include "message.h"
#include "metadata.h"

static const double FARTHEST = 1e9; /* as the library: at and beyond it is infinitely far */

typedef struct depth_range {
    bool read;
    double low, high;             /* of the values that are distances */
    size_t distances, far, holes; /* pixels: finite and above 0; infinite, 1e9 or more, 0 or less; NaN */
} depth_range;

typedef struct contents {
    io_picture *input, *second; /* second: the file of --depth */
    io_selection color, depth;
    bool has_color, has_depth;
    io_error no_color, no_depth;
    depth_range range;
    metadata lens;
} contents;

static io_picture *depth_picture(const contents *c) {
    return c->second ? c->second : c->input;
}

static io_channel *depth_channel(const contents *c) {
    return &depth_picture(c)->part[c->depth.part].channel[c->depth.channel[0]];
}

static const char *type_name(io_type type) {
    return type == IO_HALF ? "half" : type == IO_FLOAT ? "float" : "uint";
}

/* ------------------------------------------------------------------------- looking */

static void find_range(const float *value, size_t count, depth_range *range) {
    *range = (depth_range){.read = true, .low = INFINITY, .high = -INFINITY};
    for (size_t i = 0; i < count; i++) {
        const double z = (double)value[i];
        if (isnan(z)) {
            range->holes++;
        } else if (z <= 0 || z >= FARTHEST) {
            range->far++;
        } else {
            range->distances++;
            range->low = fmin(range->low, z);
            range->high = fmax(range->high, z);
        }
    }
}

static int read_range(contents *c) {
    io_error error = {0};
    const char *name = depth_channel(c)->name;
    if (io_read_channels(depth_picture(c), c->depth.part, &name, 1, &error)) return fail("%s", error.text);
    const io_channel *channel = depth_channel(c);
    const size_t count = (size_t)channel->width * (size_t)channel->height;
    float *value = malloc(count * sizeof(float));
    if (!value) return fail("%s: out of memory for %zu pixels", depth_picture(c)->path, count);
    io_channel_to_float(channel, value, 1, (size_t)channel->width);
    find_range(value, count, &c->range);
    free(value);
    return 0;
}

static int look(contents *c, const options *o, const io_options *reading) {
    io_error error = {0};
    const char *name = NULL, *text = option_text(o, OPT_DEPTH);
    if (io_open(&c->input, o->file[0], IO_COLOR, reading, &error)) return fail("%s", error.text);
    c->has_color = io_select_color(c->input, option_text(o, OPT_LAYER), &c->color, &c->no_color) == 0;
    if (!c->has_color && option_given(o, OPT_LAYER)) return fail("--layer: %s", c->no_color.text);
    if (text) {
        char *file;
        int status = split_channel("depth", text, &file, &name);
        if (status) return status;
        int bad = *file ? io_open(&c->second, file, IO_DATA, reading, &error) : 0;
        free(file);
        if (bad) return fail("--depth: %s", error.text);
    }
    const io_selection *near_color = c->has_color && !c->second ? &c->color : NULL;
    c->has_depth = io_select_depth(depth_picture(c), name, near_color, &c->depth, &c->no_depth) == 0;
    if (!c->has_depth && text) return fail("--depth: %s", c->no_depth.text);
    const bool asked = option_given(o, OPT_METADATA);
    return metadata_find(&c->lens, c->input, c->has_color ? c->color.part : 0, o, option_text(o, OPT_METADATA), asked);
}

/* ------------------------------------------------------------------------- for people */

static void print_name(const char *name) {
    for (; *name; name++)
        putchar((unsigned char)*name < 0x20 || *name == 0x7f ? '?' : *name);
}

static void print_part(const io_part *part, int index) {
    printf("part %d", index);
    if (*part->name) {
        printf(" \"");
        print_name(part->name);
        printf("\"");
    }
    if (*part->view) {
        printf(", view ");
        print_name(part->view);
    }
    printf(": %dx%d, %s, %s", part->data.width, part->data.height, part->storage, part->compression);
    if (part->pixel_aspect != 1) printf(", pixel aspect %g", part->pixel_aspect);
    printf("\n");
    const io_box a = part->data, b = part->display;
    if (a.x != b.x || a.y != b.y || a.width != b.width || a.height != b.height)
        printf("  data window %dx%d at %d,%d; display window %dx%d at %d,%d\n", a.width, a.height, a.x, a.y, b.width,
               b.height, b.x, b.y);
    printf("  channels:");
    for (int i = 0; i < part->channel_count; i++) {
        const io_channel *channel = &part->channel[i];
        printf(i ? ", " : " ");
        print_name(channel->name);
        printf(" %s", type_name(channel->type));
        if (channel->x_sampling != 1 || channel->y_sampling != 1)
            printf(" (every %d x %d pixels)", channel->x_sampling, channel->y_sampling);
    }
    printf("\n");
}

static void print_selection(const io_picture *picture, const io_selection *selection) {
    const io_part *part = &picture->part[selection->part];
    for (int i = 0; i < selection->count; i++) {
        printf(" ");
        print_name(part->channel[selection->channel[i]].name);
    }
    if (picture->part_count > 1) printf(" of part %d", selection->part);
}

static void print_lens(const metadata *lens) {
    bool any = false;
    for (int i = 0; i < METADATA_ITEMS; i++) {
        const metadata_item *item = &lens->item[i];
        if (!*item->name) continue;
        printf("%s %s %g (", any ? "," : "lens, with --metadata:", option_table[item->id].name, item->number);
        print_name(item->name);
        printf("%s)", item->metres ? ", metres" : "");
        any = true;
    }
    if (any) printf("\n");
}

/* "device" and "normalized" are words of --depth-kind, NULL: the file does not say. */
static const char *depth_kind_word(const io_depth *depth) {
    return depth->kind == IO_DEPTH_LINEAR ? "normalized" : depth->kind == IO_DEPTH_DISPARITY ? "device" : NULL;
}

static void print_meaning(const io_channel *channel) {
    const io_depth *depth = &channel->depth;
    if (!depth_kind_word(depth)) {
        if (channel->integer) printf("  its values, 0 to 1, are not said to mean anything: give --depth-kind, --near and --far\n");
        return;
    }
    printf("  the file says: --depth-kind %s", depth_kind_word(depth));
    if (depth->at_0 > 0)
        printf(" --near %g --far %g\n", depth->at_0, depth->at_1);
    else
        printf(", but not --near and --far\n");
}

static void print_human(const contents *c) {
    print_name(c->input->path);
    printf(": %s, %d part%s\n", io_format_name(c->input->format), c->input->part_count,
           c->input->part_count == 1 ? "" : "s");
    for (int i = 0; i < c->input->part_count; i++)
        print_part(&c->input->part[i], i);
    if (*c->input->note.text) printf("note: %s\n", c->input->note.text);
    print_lens(&c->lens);
    printf("colour:");
    if (c->has_color)
        print_selection(c->input, &c->color);
    else
        printf(" none");
    printf("\ndepth:");
    if (!c->has_depth) {
        printf(" none; give one with --depth FILE\n");
        return;
    }
    print_selection(depth_picture(c), &c->depth);
    if (c->second) {
        printf(" of ");
        print_name(c->second->path);
    }
    const depth_range *range = &c->range;
    if (range->read && range->distances) printf(", %g to %g", range->low, range->high);
    if (range->far) printf(", %zu pixels infinitely far", range->far);
    if (range->holes) printf(", %zu pixels NaN", range->holes);
    printf("\n");
    print_meaning(depth_channel(c));
}

/* ------------------------------------------------------------------------- for programs */

static void add_box(cJSON *object, const char *key, io_box box) {
    const int numbers[4] = {box.x, box.y, box.width, box.height};
    cJSON_AddItemToObject(object, key, cJSON_CreateIntArray(numbers, 4));
}

static cJSON *part_object(const io_part *part) {
    cJSON *object = cJSON_CreateObject(), *channels = cJSON_CreateArray();
    json_text(object, "name", part->name);
    json_text(object, "view", part->view);
    json_text(object, "storage", part->storage);
    json_text(object, "compression", part->compression);
    json_integer(object, "bits", part->bits);
    cJSON_AddBoolToObject(object, "deep", part->deep);
    add_box(object, "data_window", part->data);
    add_box(object, "display_window", part->display);
    json_number(object, "pixel_aspect", part->pixel_aspect);
    for (int i = 0; i < part->channel_count; i++) {
        cJSON *channel = cJSON_CreateObject();
        json_text(channel, "name", part->channel[i].name);
        json_text(channel, "type", type_name(part->channel[i].type));
        json_integer(channel, "x_sampling", part->channel[i].x_sampling);
        json_integer(channel, "y_sampling", part->channel[i].y_sampling);
        cJSON_AddItemToArray(channels, channel);
    }
    cJSON_AddItemToObject(object, "channels", channels);
    return object;
}

static cJSON *selection_object(const io_picture *picture, const io_selection *selection) {
    cJSON *object = cJSON_CreateObject(), *channels = cJSON_CreateArray();
    json_integer(object, "part", selection->part);
    for (int i = 0; i < selection->count; i++)
        cJSON_AddItemToArray(channels,
                             json_text_item(picture->part[selection->part].channel[selection->channel[i]].name));
    cJSON_AddItemToObject(object, "channels", channels);
    return object;
}

static cJSON *lens_object(const metadata *lens) {
    cJSON *object = cJSON_CreateObject();
    for (int i = 0; i < METADATA_ITEMS; i++) {
        const metadata_item *item = &lens->item[i];
        if (!*item->name) continue;
        cJSON *found = cJSON_AddObjectToObject(object, option_table[item->id].name);
        json_text(found, "attribute", item->name);
        json_number(found, "value", item->number);
    }
    return object;
}

/* near and far are null for what JSON has no number for: infinity, and what the file does not say. */
static void add_meaning(cJSON *object, const io_channel *channel) {
    const io_depth *depth = &channel->depth;
    if (depth_kind_word(depth))
        json_text(object, "kind", depth_kind_word(depth));
    else
        cJSON_AddNullToObject(object, "kind");
    json_number(object, "near", depth->at_0 > 0 ? depth->at_0 : NAN);
    json_number(object, "far", depth->at_1 > 0 ? depth->at_1 : NAN);
}

static int print_json(const contents *c) {
    cJSON *object = cJSON_CreateObject(), *parts = cJSON_CreateArray(), *color = cJSON_CreateNull();
    cJSON *depth = cJSON_CreateNull();
    json_text(object, "file", c->input->path);
    json_text(object, "format", io_format_name(c->input->format));
    for (int i = 0; i < c->input->part_count; i++)
        cJSON_AddItemToArray(parts, part_object(&c->input->part[i]));
    cJSON_AddItemToObject(object, "parts", parts);
    if (c->has_color) {
        cJSON_Delete(color);
        color = selection_object(c->input, &c->color);
        cJSON_AddBoolToObject(color, "alpha", c->color.alpha);
        json_text(color, "prefix", c->color.prefix);
    }
    cJSON_AddItemToObject(object, "color", color);
    if (c->has_depth) {
        cJSON_Delete(depth);
        depth = selection_object(depth_picture(c), &c->depth);
        json_text(depth, "file", depth_picture(c)->path);
        json_number(depth, "min", c->range.distances ? c->range.low : NAN);
        json_number(depth, "max", c->range.distances ? c->range.high : NAN);
        json_integer(depth, "distances", (double)c->range.distances);
        json_integer(depth, "infinitely_far", (double)c->range.far);
        json_integer(depth, "nan", (double)c->range.holes);
        add_meaning(depth, depth_channel(c));
    }
    cJSON_AddItemToObject(object, "depth", depth);
    cJSON_AddItemToObject(object, "lens", lens_object(&c->lens));
    return json_finish(object);
}

/* ------------------------------------------------------------------------- all of it */

int command_info(const options *o) {
    const io_options reading = {.threads = (int)option_number(o, OPT_THREADS, 0)};
    contents c = {0};
    int status = look(&c, o, &reading);
    if (status == 0) {
        /* a damaged file still has a header worth showing */
        int damaged = c.has_depth ? read_range(&c) : 0;
        status = option_given(o, OPT_JSON) ? print_json(&c) : 0;
        if (!option_given(o, OPT_JSON) && !option_given(o, OPT_QUIET)) {
            print_human(&c);
            status = finish_output();
        }
        if (damaged) status = damaged;
    }
    io_close(&c.input);
    io_close(&c.second);
    return status;
}
