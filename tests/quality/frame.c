/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "frame.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

void die(const char *what, const char *which) {
    fprintf(stderr, "%s: %s\n", which, what);
    exit(1);
}

void *allocate(size_t count, size_t size) {
    void *p = calloc(count, size);
    if (!p) die("out of memory", "quality");
    return p;
}

static const io_channel *read_channels(io_picture **picture, const char *path, const io_selection *selection) {
    const char *names[4];
    io_error error = {0};
    const io_part *part = &(*picture)->part[selection->part];
    for (int i = 0; i < selection->count; i++)
        names[i] = part->channel[selection->channel[i]].name;
    if (io_read_channels(*picture, selection->part, names, selection->count, &error)) die(error.text, path);
    return part->channel;
}

frame frame_read(const char *path, io_meaning meaning) {
    io_picture *picture = NULL;
    io_selection s;
    io_error error = {0};
    if (io_open(&picture, path, meaning, NULL, &error) || io_select_color(picture, NULL, &s, &error))
        die(error.text, path);
    const io_channel *channel = read_channels(&picture, path, &s), *first = &channel[s.channel[0]];
    frame f = {.width = first->width, .height = first->height};
    const size_t count = 3 * (size_t)f.width * (size_t)f.height;
    f.rgb = allocate(count, sizeof(float));
    for (int i = 0; i < 3; i++)
        io_channel_to_float(&channel[s.channel[s.count > 2 ? i : 0]], f.rgb + i, 3, 3 * (size_t)f.width);
    for (size_t i = 0; i < count; i++)
        if (!isfinite(f.rgb[i])) f.rgb[i] = 0;
    io_close(&picture);
    return f;
}

void frame_read_coc(frame *f, const char *path) {
    io_picture *picture = NULL;
    io_selection s;
    io_error error = {0};
    if (io_open(&picture, path, IO_DATA, NULL, &error) || io_select_depth(picture, "CoC", NULL, &s, &error))
        die(error.text, path);
    const io_channel *channel = &read_channels(&picture, path, &s)[s.channel[0]];
    if (channel->width != f->width || channel->height != f->height) die("its CoC has another size", path);
    f->coc = allocate((size_t)f->width * (size_t)f->height, sizeof(float));
    io_channel_to_float(channel, f->coc, 1, (size_t)f->width);
    for (size_t i = 0; i < (size_t)f->width * (size_t)f->height; i++)
        if (!isfinite(f->coc[i])) f->coc[i] = 0;
    io_close(&picture);
}

void frame_write(const frame *f, const char *path, io_meaning meaning) {
    static const char *const names[] = {"R", "G", "B"};
    io_picture *picture = NULL;
    io_format format = IO_EXR;
    io_error error = {0};
    if (!io_format_of_name(path, &format)) die("unknown ending", path);
    if (io_create(&picture, format, f->width, f->height, names, 3, IO_FLOAT, format == IO_PNG ? 16 : 32, meaning,
                  &error))
        die(error.text, path);
    for (int i = 0; i < 3; i++)
        io_channel_from_float(&picture->part[0].channel[i], f->rgb + i, 3, 3 * (size_t)f->width);
    if (io_write(picture, path, NULL, NULL, &error)) die(error.text, path);
    io_close(&picture);
}

void frame_free(frame *f) {
    free(f->rgb);
    free(f->coc);
    *f = (frame){0};
}

float *disc_areas(float largest_radius) {
    const int count = (int)(largest_radius * 16) + 3;
    float *areas = allocate((size_t)count, sizeof *areas);
    for (int k = 0; k < count; k++) {
        const float radius = (float)k / 16;
        const int reach = (int)radius + 1;
        double sum = 0;
        for (int j = -reach; j <= reach; j++)
            for (int i = -reach; i <= reach; i++)
                sum += (double)disc_cover(sqrtf((float)(i * i + j * j)), radius);
        areas[k] = (float)sum;
    }
    return areas;
}
