/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Options of the sprites: --bokeh and what belongs to it. */
#ifndef TOOLS_BOKEH_H
#define TOOLS_BOKEH_H

#include "iris.h"
#include "options.h"

/* What --bokeh says, or its default. */
ddof_bokeh bokeh_of_options(const options *o);

/* Options that exclude each other, or have no meaning. Returns 0 or an exit code. */
int bokeh_check_options(const options *o);

/* Fills settings->bokeh, ->sprites and ->iris, which stays `in`'s. `picture_width`: of the display window, pixels.
 * Returns 0 or an exit code. */
int bokeh_settings(ddof_settings *settings, const options *o, const iris_input *in, int picture_width);

/* What is done: SCATTER also where the bokeh is full. */
ddof_method bokeh_method(const ddof_settings *settings);

/* As --bokeh calls them. */
const char *bokeh_name(ddof_bokeh bokeh);

/* "disc", or what --iris says. */
const char *bokeh_iris_text(const options *o);

/* Says how many highlights were not drawn, and which option would; `about` is the file to name. */
void bokeh_note(const ddof_stats *stats, const char *about);

#endif
