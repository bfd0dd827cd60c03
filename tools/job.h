/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* What `render` and `coc` work on: the picture, its depth or CoC, and the settings, read and checked against each
 * other. Colour, depth and CoC are handed to the library where the file reader put them; nothing is copied unless a
 * type has no place in the library (integers) or --coc-scale changes the values. */
#ifndef TOOLS_JOB_H
#define TOOLS_JOB_H

#include <picture.h>

#include "channels.h"
#include "holdout.h"
#include "iris.h"
#include "lens.h"
#include "options.h"
#include "session.h"

/* Images that one depth or CoC blurs, and so one call of the library. */
typedef struct job_group {
    const char *view; /* "" where IN has none */
    int count;
    const io_selection *color; /* of each image */
    io_selection blur;         /* the depth or CoC channel of `second`, or of `input` */
    float *converted;          /* of scratch.h: depth or CoC of a type the library does not take, or scaled */
    ddof_pair *more;           /* all images but the first, in place */
    ddof_frame frame;          /* everything but `output` */
} job_group;

typedef struct job {
    io_picture *input; /* IN */
    channel_choice choice;
    int group_count;
    job_group *group;
    io_selection color; /* the first image of the first group: what is shown */
    io_picture *second; /* the file of --depth or --coc, NULL when they are in IN */
    holdout holdout;    /* --holdout */
    iris_input iris;    /* --iris */
    camera file;        /* --camera */
    io_options reading;
    ddof_frame frame; /* of the first group */
    ddof_settings settings;
    double decode_ms;
} job;

/* Opens and reads everything the options name. `rewrite`: when IN is of this format, the rest of its colour part is
 * read too, to be written again; NULL: never. On failure everything is closed. Returns 0 or an exit code. */
int job_open(job *j, const options *o, const session *s, const io_format *rewrite);
/* The depth alone, for autofocus: of `frame` the size of the depth and its place in the picture are filled in, then some of its
 * rows (where the file's format lets them be read by themselves, the others are 0). */
int job_open_depth(job *j, const options *o);
int job_read_depth(job *j, const options *o, int row, int rows);
void job_close(job *j);

const io_part *job_part(const job *j); /* IN's part with the colour that is shown */
io_channel *job_color(const job *j, int i);
/* The i-th channel of one of its images; and the depth or CoC of a group. */
io_channel *job_image_channel(const job *j, const io_selection *color, int i);
io_channel *job_blur_channel(const job *j, const job_group *g);

/* Whether some channel of this part of IN is blurred. */
bool job_part_is_blurred(const job *j, int part);
/* Says of all channels that are blurred that they were written to. */
void job_modified(const job *j);

/* What to name when the library refuses: what passed all checks here can only be the depth at the pixel to focus on. */
const char *job_blame(const options *o, ddof_status status);

/* The plane of a channel of the library's types. */
ddof_plane plane_of_channel(const io_channel *channel);

/* "FILE:CHANNEL" -> the file's name (to be freed, "" when the text begins with ':') and the channel, NULL when none is
 * named. File names may hold ':' themselves: the longest that exists is taken. Returns 0 or an exit code. */
int split_channel(const char *option, const char *text, char **file, const char **channel);

/* Smallest and largest finite CoC, by ddof_coc() a few rows at a time. `focus`: what ddof_render() focused on.
 * Returns false when there is none. */
bool job_coc_range(const job *j, session *s, double focus, float *low, float *high);

#endif
