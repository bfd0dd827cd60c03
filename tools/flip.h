/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* FLIP: how different two pictures look to a person who flips between them, 0 (the same) to 1, for each pixel.
 *   LDR-FLIP: P. Andersson, J. Nilsson, T. Akenine-Moller, M. Oskarsson, K. Astrom, M. D. Fairchild, "FLIP: A
 * Difference Evaluator for Alternating Images", HPG 2020. Both pictures in the opponent space Y Cx Cz are seen through
 * the eye's contrast sensitivity (a Gaussian a channel, two for blue-yellow), clamped to what a display can show,
 * compared in Hunt-adjusted CIE Lab by HyAB distance: the colour difference. Edges and points of luminance, by first
 * and second derivatives of a Gaussian, give the feature difference, which raises it: colour^(1 - feature). HDR-FLIP:
 * P. Andersson, J. Nilsson, P. Shirley, T. Akenine-Moller, "Visualizing Errors in Rendered High Dynamic Range Images",
 * Eurographics 2021. The largest LDR-FLIP over several exposures through the ACES curve's fit. Filters are as wide as
 * `ppd`, the pixels in a degree of sight, asks; the outermost pixels are repeated beyond the border. Where a picture is
 * not finite both are black, and the map is NAN. */
#ifndef TOOLS_FLIP_H
#define TOOLS_FLIP_H

typedef enum flip_tone {
    FLIP_DISPLAY, /* linear light of a display, clamped to 0..1 */
    FLIP_COMPACT, /* x/(1 + x), as metrics.h; its sRGB curve is undone by the display */
    FLIP_ACES     /* the fit of the paper's section 3.2 */
} flip_tone;

typedef struct flip_view {
    double ppd; /* 1 to FLIP_PPD_MAX */
    flip_tone tone;
    double exposure; /* stops before FLIP_ACES */
    int threads;     /* 1 or more; the map does not depend on it */
} flip_view;

enum { FLIP_PPD_MAX = 1000 };
#define FLIP_PPD 67.0 /* a 4K display 0.7 m wide, seen from 0.7 m */

/* Stops of the first and the last exposure, and how many there are at even steps: 2 or more. */
typedef struct flip_exposures {
    double start, stop;
    int count;
} flip_exposures;

/* a, b: width x height x RGB, interleaved, scene-linear; map: width x height. It does not matter which of the two is
 * the reference. Nonzero: out of memory. Thread-safety: any thread. */
int flip_ldr(float *map, const float *a, const float *b, int width, int height, const flip_view *view);

/* The same over all exposures of `reference`; view->tone and ->exposure are not used. `used` may be NULL. */
int flip_hdr(float *map, const float *test, const float *reference, int width, int height, const flip_view *view,
             flip_exposures *used);

/* The first exposure brings the brightest luminance to 0.85 of the display's white, the last one the median. Pixels
 * that are not finite do not count; where the median is black, that of the others is taken. Nonzero: out of memory. */
int flip_choose_exposures(flip_exposures *exposures, const float *reference, int width, int height);

/* Mean over the pixels that are in the mask (NULL: all) and not NAN; NAN when there is none. */
double flip_mean(const float *map, const unsigned char *mask, int width, int height);

#endif
