/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Options and camera file -> the library's settings. Options win over the camera file. */
#ifndef TOOLS_LENS_H
#define TOOLS_LENS_H

#include <ddof/ddof.h>

#include "camera.h"
#include "options.h"

/* What can be said without looking at a picture: options that exclude each other. Returns 0 or an exit code. */
int lens_check_options(const options *o);

/* Fills settings->lens and ->depth, but for focus_x and focus_y. `picture_width`: of the display window, pixels.
 * Returns 0 or an exit code. */
int lens_settings(ddof_settings *settings, const options *o, const camera *file, int picture_width);

/* Millimetres in one unit of the depth. */
double lens_unit(const options *o, const camera *file);

/* Options of the method that exclude each other. Returns 0 or an exit code. */
int method_check_options(const options *o);

/* "--method none": pictures are read and written again, and nothing is blurred. */
bool method_none(const options *o);

/* What --method says; what "none" would have been. */
ddof_method method_of_options(const options *o);

/* Method, kernel, quality, conductance, substeps, layers, and how the GPU backends solve. */
void method_settings(ddof_settings *settings, const options *o);

/* Pixels or percent -> the library's fraction of the picture's width. */
double extent_fraction(const option_value *extent, int picture_width);

/* As --method, --kernel and --quality call them. */
const char *method_name(ddof_method method);
const char *kernel_name(ddof_kernel kernel);
const char *quality_name(ddof_quality quality);

/* One line for people: "85 mm f/2, focus 4", into text. `focus`: what the library focused on. */
void lens_describe(char *text, size_t size, const ddof_settings *settings, double focus, int picture_width);

#endif
