/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* A file of one format (FUZZ_FORMAT) through all that the command does with pictures: opened, copied as it is, colour and
 * depth chosen, read, every channel written anew; and what was written is read again. */
#include <picture.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "fuzz.h"

enum { LARGEST = 1 << 16, MOST_PIXELS = 1 << 15, MOST_VALUES = 1 << 18 };

static const io_options options = {.threads = 1, .max_pixels = MOST_PIXELS};

static void require_line(int result, io_error *error) {
    fuzz_require(result == 0 || (error->text[0] && !strchr(error->text, '\n')), "who refuses says why in one line",
                 error->text);
    error->text[0] = '\0';
}

static const char *output_name(void) {
    static char name[64];
    static const char *const endings[] = {[IO_EXR] = "exr", [IO_PNG] = "png", [IO_TIFF] = "tif", [IO_PFM] = "pfm"};
    if (!name[0])
        snprintf(name, sizeof name, "%s/ddof-fuzz-%ld.%s", access("/dev/shm", W_OK) == 0 ? "/dev/shm" : "/tmp",
                 (long)getpid(), endings[FUZZ_FORMAT]);
    return name;
}

/* Whatever was opened can be copied, or is refused. */
static void copy(const io_picture *picture) {
    io_error error = {""}, note = {""};
    const int result = io_write(picture, output_name(), &options, &note, &error);
    require_line(result, &error);
    if (result == 0) {
        io_picture *copied;
        fuzz_require(io_open(&copied, output_name(), IO_COLOR, &options, &error) == 0, "a copy can be opened",
                     error.text);
        io_close(&copied);
    }
    unlink(output_name());
}

static void select_all(const io_picture *picture) {
    io_error error = {""};
    io_selection color, depth;
    const int found = io_select_color(picture, NULL, &color, &error);
    require_line(found, &error);
    require_line(io_select_depth(picture, NULL, found == 0 ? &color : NULL, &depth, &error), &error);
    const io_part *part = &picture->part[picture->part_count - 1];
    if (part->channel_count == 0) return;
    const char *name = part->channel[part->channel_count - 1].name;
    require_line(io_select_color(picture, name, &color, &error), &error);
    require_line(io_select_depth(picture, name, NULL, &depth, &error), &error);
}

static void pass_values(io_channel *channel) {
    const size_t width = (size_t)channel->width, height = (size_t)channel->height;
    float *values = malloc(width * height * sizeof *values + 1);
    fuzz_require(values != NULL, "there is memory for a channel", channel->name);
    io_channel_to_float(channel, values, 1, width);
    io_channel_from_float(channel, values, 1, width);
    free(values);
}

static uint64_t count_values(const io_picture *picture) {
    uint64_t values = 0;
    for (int p = 0; p < picture->part_count; p++)
        for (int c = 0; c < picture->part[p].channel_count; c++)
            values += (uint64_t)picture->part[p].channel[c].width * (uint64_t)picture->part[p].channel[c].height;
    return values;
}

/* What io_write calls a success is a picture again. */
static void write_anew(io_picture *picture) {
    io_error error = {""}, note = {""};
    for (int p = 0; p < picture->part_count; p++)
        for (int c = 0; c < picture->part[p].channel_count; c++)
            if (picture->part[p].channel[c].data) pass_values(&picture->part[p].channel[c]);
    const int result = io_write(picture, output_name(), &options, &note, &error);
    require_line(result, &error);
    if (result == 0) {
        io_picture *again;
        fuzz_require(io_open(&again, output_name(), IO_COLOR, &options, &error) == 0 && io_read(again, &error) == 0,
                     "what was written can be read", error.text);
        bool same = again->part_count == picture->part_count;
        for (int p = 0; same && p < again->part_count; p++)
            same = again->part[p].channel_count == picture->part[p].channel_count &&
                   again->part[p].data.width == picture->part[p].data.width &&
                   again->part[p].data.height == picture->part[p].data.height;
        fuzz_require(same, "what was written has the same parts", picture->path);
        io_close(&again);
    }
    unlink(output_name());
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    io_picture *picture;
    io_error error = {""};
    if (size > LARGEST) return 0;
    const int result =
        io_open(&picture, fuzz_file(data, size), size & 1 ? IO_DATA : IO_COLOR, &options, &error);
    fuzz_require((result == 0) == (picture != NULL), "what fails gives no picture", error.text);
    require_line(result, &error);
    if (!picture) return 0;
    if (picture->format == FUZZ_FORMAT && count_values(picture) <= MOST_VALUES) {
        copy(picture);
        select_all(picture);
        const int read = io_read(picture, &error);
        require_line(read, &error);
        if (read == 0) write_anew(picture);
    }
    io_close(&picture);
    return 0;
}
