/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "iris.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "job.h"
#include "message.h"

#define EXAMPLE "--iris blades=6,rotation=10"

enum { SIDE_MOST = 4096 }; /* pixels of a picture, as the library has it */

enum {
    KEY_DISC,
    KEY_BLADES,
    KEY_IMAGE,
    KEY_ROTATION,
    KEY_CURVATURE,
    KEY_EDGE,
    KEY_CATS_EYE,
    KEY_SQUEEZE,
    KEY_FRINGE,
    KEYS
};

static const struct iris_key {
    const char *name;
    double low, high;
    size_t member; /* of ddof_iris, a double */
} keys[KEYS] = {
    [KEY_DISC] = {.name = "disc"},
    [KEY_BLADES] = {"blades", 3, 64, 0},
    [KEY_IMAGE] = {.name = "image"},
    [KEY_ROTATION] = {"rotation", -3600, 3600, offsetof(ddof_iris, rotation)},
    [KEY_CURVATURE] = {"curvature", 0, 1, offsetof(ddof_iris, curvature)},
    [KEY_EDGE] = {"edge", -1, 1, offsetof(ddof_iris, edge)},
    [KEY_CATS_EYE] = {"cats-eye", 0, 1, offsetof(ddof_iris, cats_eye)},
    [KEY_SQUEEZE] = {"squeeze", 1, 4, offsetof(ddof_iris, squeeze)},
    [KEY_FRINGE] = {"fringe", -0.5, 0.5, offsetof(ddof_iris, fringe)},
};

typedef struct parser {
    ddof_iris *iris;
    unsigned given; /* a bit for each key */
    char *image;    /* FILE[:CHANNEL]; to be freed */
} parser;

/* ------------------------------------------------------------------------- the list */

static int find_key(const char *name, size_t length) {
    int key = 0;
    while (key < KEYS && !(strlen(keys[key].name) == length && strncmp(keys[key].name, name, length) == 0))
        key++;
    return key;
}

static int read_key_number(parser *p, int key, const char *value, size_t length) {
    const struct iris_key *spec = &keys[key];
    const bool whole = key == KEY_BLADES;
    double number;
    if (!read_number(value, value + length, false, &number) || (whole && number != floor(number)))
        return fail_usage("--iris: %s: '%.*s' is not a %snumber; write it like " EXAMPLE, spec->name, (int)length,
                          value, whole ? "whole " : "");
    if (!(number >= spec->low && number <= spec->high))
        return fail_usage("--iris: %s: %.*s is out of range; it must be %g to %g", spec->name, (int)length, value,
                          spec->low, spec->high);
    if (whole)
        p->iris->blades = (int)number;
    else
        memcpy((char *)p->iris + spec->member, &number, sizeof number);
    return 0;
}

/* "blades=6" or "disc". */
static int read_item(parser *p, const char *item, size_t length) {
    const char *equals = memchr(item, '=', length), *value = equals ? equals + 1 : item + length;
    const size_t value_length = (size_t)(item + length - value);
    const int key = find_key(item, equals ? (size_t)(equals - item) : length);
    if (key == KEYS)
        return fail_usage(
            "--iris: '%.*s' is none of disc, blades, image, rotation, curvature, edge, cats-eye, squeeze, fringe; "
            "write it like " EXAMPLE,
            (int)length, item);
    if (p->given & 1u << key) return fail_usage("--iris: %s is there twice; leave one of them out", keys[key].name);
    p->given |= 1u << key;
    if (key == KEY_DISC) return equals ? fail_usage("--iris: disc takes no value; write just --iris disc") : 0;
    if (value_length == 0)
        return fail_usage("--iris: %s needs a value; write it like %s", keys[key].name,
                          key == KEY_IMAGE ? "--iris image=heart.png" : EXAMPLE);
    if (key != KEY_IMAGE) return read_key_number(p, key, value, value_length);
    p->image = strndup(value, value_length);
    return p->image ? 0 : fail("--iris: out of memory");
}

/* There is one shape. */
static int choose_shape(parser *p) {
    static const int shapes[] = {KEY_DISC, KEY_BLADES, KEY_IMAGE};
    int chosen = KEY_DISC;
    for (size_t i = 0, found = 0; i < sizeof shapes / sizeof *shapes; i++) {
        if (!(p->given & 1u << shapes[i])) continue;
        if (found++)
            return fail_usage("--iris: %s and %s cannot be used together; give one of them", keys[chosen].name,
                              keys[shapes[i]].name);
        chosen = shapes[i];
    }
    if (p->given & 1u << KEY_CURVATURE && chosen != KEY_BLADES)
        return fail_usage("--iris: curvature needs blades too; write it like --iris blades=6,curvature=0.4");
    p->iris->shape = chosen == KEY_BLADES ? DDOF_IRIS_POLYGON : chosen == KEY_IMAGE ? DDOF_IRIS_IMAGE : DDOF_IRIS_DISC;
    return 0;
}

static int read_list(parser *p, const char *text) {
    for (const char *item = text;; item++) {
        const size_t length = strcspn(item, ",");
        const int status = read_item(p, item, length);
        if (status) return status;
        item += length;
        if (*item == 0) return choose_shape(p);
    }
}

/* ------------------------------------------------------------------------- the picture */

static int choose_channels(const io_picture *picture, const char *name, io_selection *selection, io_error *error) {
    if (!name && io_select_color(picture, NULL, selection, error) == 0) return 0;
    return io_select_depth(picture, name, NULL, selection, error);
}

/* The mean of the colours, times alpha: what is transparent is no part of the iris. */
static void mix(const io_part *part, const io_selection *selection, float *channel, float *out, size_t count) {
    const int colors = selection->count - selection->alpha;
    for (int c = 0; c < selection->count; c++) {
        const io_channel *from = &part->channel[selection->channel[c]];
        io_channel_to_float(from, channel, 1, (size_t)from->width);
        for (size_t i = 0; i < count; i++)
            out[i] = c == colors ? out[i] * channel[i] : out[i] + channel[i] / (float)colors;
    }
}

static int convert(iris_input *in, const io_picture *picture, const io_selection *selection) {
    const io_part *part = &picture->part[selection->part];
    const io_channel *first = &part->channel[selection->channel[0]];
    const size_t count = (size_t)first->width * (size_t)first->height;
    float *channel = malloc(count * sizeof *channel);
    in->values = calloc(count, sizeof *in->values);
    if (channel && in->values) mix(part, selection, channel, in->values, count);
    free(channel);
    if (!channel || !in->values) return fail("--iris: %s: out of memory for %zu pixels", picture->path, count);
    size_t open = 0;
    for (size_t i = 0; i < count; i++)
        open += isfinite(in->values[i]) && in->values[i] > 0;
    if (open == 0)
        return fail("--iris: %s lets no light through, all of it is black; make white what is open, black what is not",
                    picture->path);
    in->settings.image = ddof_image_interleaved(in->values, first->width, first->height, 1, DDOF_FLOAT, 0);
    return 0;
}

static int read_channels(iris_input *in, io_picture *picture, const char *name) {
    io_error error = {0};
    io_selection selection;
    if (choose_channels(picture, name, &selection, &error)) return fail("--iris: %s", error.text);
    const io_channel *channel = picture->part[selection.part].channel, *first = &channel[selection.channel[0]];
    const char *names[4];
    if (first->width > SIDE_MOST || first->height > SIDE_MOST)
        return fail("--iris: %s is %dx%d, but an iris has at most %d pixels a side; make it smaller", picture->path,
                    first->width, first->height, SIDE_MOST);
    for (int i = 0; i < selection.count; i++)
        names[i] = channel[selection.channel[i]].name;
    if (io_read_channels(picture, selection.part, names, selection.count, &error))
        return fail("--iris: %s", error.text);
    return convert(in, picture, &selection);
}

static int read_image(iris_input *in, const char *text, const io_options *reading) {
    io_error error = {0};
    io_picture *picture = NULL;
    char *file;
    const char *name;
    int status = split_channel("iris", text, &file, &name);
    if (status) return status;
    if (!*file)
        status = fail_usage("--iris: image=%s names no file; write it like --iris image=heart.png", text);
    else if (io_open(&picture, file, IO_DATA, reading, &error))
        status = fail("--iris: %s", error.text);
    else
        status = read_channels(in, picture, name);
    free(file);
    io_close(&picture);
    return status;
}

/* ------------------------------------------------------------------------- all of it */

int iris_read(iris_input *in, const char *text, const io_options *reading) {
    *in = (iris_input){0};
    parser p = {.iris = &in->settings};
    int status = text ? read_list(&p, text) : 0;
    if (status == 0 && p.image) status = read_image(in, p.image, reading);
    free(p.image);
    return status;
}

char *iris_image(const char *text) {
    ddof_iris unused = {0};
    parser p = {.iris = &unused};
    if (text && read_list(&p, text)) {
        free(p.image);
        p.image = NULL;
    }
    return p.image;
}

void iris_close(iris_input *in) {
    free(in->values);
    *in = (iris_input){0};
}
