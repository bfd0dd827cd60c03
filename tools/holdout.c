/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "holdout.h"

#include <stdlib.h>

#include "job.h"
#include "message.h"
#include "scratch.h"

/* As 'ddof compare' takes a mask: a colour one counts by its first channel. */
static int choose_channel(const io_picture *picture, const char *name, io_selection *selection, io_error *error) {
    if (!name && io_select_color(picture, NULL, selection, error) == 0) return 0;
    return io_select_depth(picture, name, NULL, selection, error);
}

static int convert(holdout *h, const io_channel *channel) {
    const size_t count = (size_t)channel->width * (size_t)channel->height;
    h->image = (ddof_image){.width = channel->width, .height = channel->height, .channels = 1};
    h->image.plane[0] = plane_of_channel(channel);
    if (channel->type != IO_UINT) return 0;
    h->converted = scratch_allocate(count * sizeof(float));
    if (!h->converted) return fail("%s", scratch_error());
    io_channel_to_float(channel, h->converted, 1, (size_t)channel->width);
    h->image.plane[0] = (ddof_plane){.data = h->converted};
    return 0;
}

int holdout_read(holdout *h, const char *text, const char *in, const ddof_image *like, const io_options *reading) {
    io_error error = {0};
    io_selection selection;
    char *file;
    const char *name;
    int status = split_channel("holdout", text, &file, &name);
    if (status) return status;
    const int bad = io_open(&h->picture, *file ? file : in, IO_DATA, reading, &error);
    free(file);
    if (bad || choose_channel(h->picture, name, &selection, &error)) return fail("--holdout: %s", error.text);
    const io_channel *channel = &h->picture->part[selection.part].channel[selection.channel[0]];
    if (channel->width != like->width || channel->height != like->height)
        return fail("--holdout: %s is %dx%d, but the picture is %dx%d; give one of the same size", h->picture->path,
                    channel->width, channel->height, like->width, like->height);
    const char *channel_name = channel->name;
    if (io_read_channels(h->picture, selection.part, &channel_name, 1, &error))
        return fail("--holdout: %s", error.text);
    return convert(h, channel);
}

void holdout_close(holdout *h) {
    io_close(&h->picture);
    scratch_release(h->converted);
    *h = (holdout){0};
}
