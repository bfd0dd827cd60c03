/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Which channels of a picture are blurred: --channels, --views, --layer. Images that may share one depth stand in a group. */
#ifndef TOOLS_CHANNELS_H
#define TOOLS_CHANNELS_H

#include <picture.h>

#include "options.h"

/* Images of one view in one window. */
typedef struct channel_group {
    const char *view; /* the picture's; "" where it has none */
    int count;
    io_selection *color;
} channel_group;

typedef struct channel_choice {
    int count; /* of groups, at least 1 */
    channel_group *group;
    int sharp_count; /* channels that hold data and that only a wildcard names: left sharp */
    io_selection *sharp; /* one channel each */
} channel_choice;

/* Returns 0 or an exit code. On failure there is nothing to free. */
int channels_choose(channel_choice *choice, const io_picture *picture, const options *o);
/* Says what stays sharp, in a note each: channels that a wildcard names, and views. */
void channels_note(const channel_choice *choice, const io_picture *picture, const options *o);
void channels_free(channel_choice *choice);

/* Images in all groups. */
int channels_count(const channel_choice *choice);

/* What an image is called: "diffuse", "RGBA", "Z"; with "part:" before it where parts share channels' names. */
void channels_image_name(const io_picture *picture, const io_selection *color, char *name, size_t size);

/* Why a channel is data, which a blur would spoil: "depth", "ids", ...; NULL: it is light. `part` may have no name. */
const char *channels_data(const io_part *part, int channel);

#endif
