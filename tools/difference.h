/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The picture of `ddof compare -o`: how far two pictures are apart, made visible. For each of R, G and B
 *     v = N |A - B|    or, inverted,    1 - N |A - B|
 * of the scene-linear values that compare measures. PNG: v is clipped to 0..1 and stored as round(255 v), with no tone
 * map and no sRGB curve: it is what a screen shows. EXR: v itself, float, not clipped. Pixels that are not finite in A
 * or B are not measured and count as equal here; so does what lies in PNG's display window but not in the data window.
 */
#ifndef TOOLS_DIFFERENCE_H
#define TOOLS_DIFFERENCE_H

#include <picture.h>

#include "options.h"

/* Before any work: the options fit together, and the file can be written. Returns 0 or an exit code. */
int difference_check(const options *o);

/* a, b: interleaved RGB of the size of the data window of `part`, A's. Returns 0 or an exit code. */
int difference_write(const options *o, const io_part *part, const float *a, const float *b, const io_options *writing);

#endif
