/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Where in a picture a depth of field is easy or hard to get right, by its signed CoC (diameter in pixels).
 *   A depth edge lies between two of four neighbours whose CoC differs by more than 1 pixel and by more than a quarter
 * of the larger: |c - d| > max(1, 0.25 max(|c|, |d|)). Sharp and blurred, near and far meet there; a floor that recedes
 *     is none.
 *   silhouette: within one CoC of a depth edge: at most max(|c|, |d|) from the centre of one of its two pixels. What is
 *     blurred across an edge, or is hidden behind it, is mixed there.
 *   in focus: |CoC| < 1 of the others.   defocused: the rest.
 * A pixel whose CoC is no finite number is in none of them and makes no edge. */
#ifndef TOOLS_REGIONS_H
#define TOOLS_REGIONS_H

typedef enum region_kind {
    REGION_NONE,
    REGION_IN_FOCUS,
    REGION_DEFOCUSED,
    REGION_SILHOUETTE,
    REGION_COUNT
} region_kind;

/* coc, region (region_kind): width x height. Nonzero: out of memory. Thread-safety: any thread. */
int regions_divide(unsigned char *region, const float *coc, int width, int height);

#endif
