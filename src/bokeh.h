/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Stage bokeh: what is too bright for diffusion is taken out of the picture before, and drawn as sprites after it; or every
 * pixel is drawn (docs/bokeh.md). What is below is one definition for all backends, in GLSL in shaders/include/bokeh.glsl; bokeh.c
 * does it on the CPU, for the backends that have no sprites of their own.
 *
 * HIGHLIGHTS
 *   candidate  v = max(R, G, B) > threshold, of a pixel that is no hole. d = the CoC of the pixel with the largest v at most 2 rows and columns away, the
 *              first in reading order of equals, among those whose colour and CoC are finite. a = smoothstep(2, 4, |d|); none where a = 0, or where
 *              |d| > limit (counted as large).
 *   budget     the threshold is the lowest edge >= threshold of a bin, 16 to the octave of v/threshold, 512 bins, above which there are at
 *              most max_sprites candidates with a sum of (d/2^l)^2, see LEVELS, of at most max_area times the picture's pixels.
 *   taken      colour * a * (1 - (raised threshold/v)^2), from R, G and B: nothing at the threshold, nearly all of what is much brighter, so that
 *              little of it is left to show the disc of the diffusion around another shape.
 *              What of a sprite would lie outside of the picture is not taken, but diffused, which keeps it inside: all of it times
 *              bokeh_inside() is.
 *   drawn      added, each pixel times visible(d of the pixel, d of the sprite).
 * FULL
 *   holes are filled from around, the CoC of the picture is limited to `limit`, then every pixel with |d| >= 2 is a sprite of its R, G, B, A, and of 1, times
 *   smoothstep(2, 4, |d|); near ones (d < 0) and far ones are summed by themselves, times visible(). With F, N the two sums of colour, f, n of 1,
 *   and t = smoothstep(2, 4, |d|) of the pixel's own CoC d:
 *       base = mix(colour, F/f, t) where d > 0 and f > 1e-6;  mix(colour, N/n, t) where d < 0 and n > 1e-6
 *       out  = mix(base, N/n, min(n, 1)) where n > 1e-6
 * LEVELS  however large a sprite is, it is drawn with a diameter of less than 64 pixels (below 8192): in a picture of 1/2^l of the
 *   size, rounded up, l = bokeh_level() of its node, for HALF resolution at least 1. Then a pixel's sprite costs the same whatever the blur, and
 *   its rim is as soft in proportion. In the target of level l >= 1 the middle of the sprite of pixel (x, y) lies at (u/2 - 1/4, v/2 - 1/4), in
 *   pixels of the target counted from their middles, u = x >> (l - 1), v = y >> (l - 1); its diameter is |d|/2^l, its sum that of
 *   iris.inverse_sum[iris_sum(true, u, v, d < 0)] at its node less 64 (l - 1). With fringe l is that of |d|. visible() takes the CoC of the pixel (X << l, Y << l) of the
 *   picture. A target's sums are divided by 4^l and interpolated bilinearly, at the borders from inside, pixel x at (x + 1/2)/2^l - 1/2; those of
 *   all levels are added up. */
#ifndef DDOF_BOKEH_H
#define DDOF_BOKEH_H

#include "context.h"
#include "iris.h"

enum {
    BOKEH_BIN_OCTAVE = 16,
    BOKEH_BINS = 512,
    BOKEH_REACH = 2, /* rows and columns to look for the brightest pixel */
    BOKEH_LEVELS = 8 /* at most */
};
#define BOKEH_LEAST 2.0f /* |CoC| where sprites begin, and where they are all there */
#define BOKEH_WHOLE 4.0f
#define BOKEH_EMPTY 1e-6f

/* What the settings ask for, defaults filled in. */
typedef struct bokeh_limits {
    float threshold; /* scene-linear */
    float largest;   /* |CoC|, pixels */
    int max_sprites;
    double max_area; /* sum of (d/2^l)^2, pixels of the targets */
    bool half;       /* resolution */
} bokeh_limits;

typedef struct bokeh_sprite {
    int x, y;
    float coc;      /* signed */
    int node;       /* of iris.h, of |coc| */
    float color[4]; /* alpha: of FULL */
    float one;      /* FULL: what it weighs; HIGHLIGHTS: how much of it is taken from the picture */
} bokeh_sprite;

/* What is wrong with settings.bokeh and, where they are looked at, sprites and iris, or NULL. */
const char *bokeh_check(const ddof_settings *settings);

bokeh_limits bokeh_limits_of(const frame_job *job);

/* The level that a sprite of a node is drawn at: its diameter there is 32 to 64 pixels, or less at level 0. */
static inline int bokeh_level(int node, bool half) {
    const int level = node / IRIS_OCTAVE - 5;
    return level < half ? half : level < BOKEH_LEVELS - 1 ? level : BOKEH_LEVELS - 1;
}

/* The bin of v > threshold, and a bin's lower edge. */
int bokeh_bin(float v, float threshold);
float bokeh_edge(int bin, float threshold);

/* The threshold that keeps within the limits. count, area: of the candidates in each bin. dropped: how many it leaves out. */
float bokeh_raise(const bokeh_limits *limits, const int64_t count[BOKEH_BINS], const double area[BOKEH_BINS], int64_t *dropped);

/* How much of a sprite of CoC s is seen over something of CoC p: all, unless that is nearer; then it counts how alike they are blurred.
 * All of it where p is not a number. */
static inline float bokeh_visible(float p, float s) {
    float ratio = s > 0 ? p / s : p >= s ? 1.0f : s / p;
    float t = (ratio - 0.25f) * 2;
    t = t < 1 ? t : 1;
    t = t > 0 ? t : 0;
    return t * t * (3 - 2 * t);
}

/* How much of a disc of this diameter around pixel (x, y) lies in a picture of these sizes; of an ellipse that is `aspect` times as tall. */
float bokeh_inside(int x, int y, int width, int height, float diameter, float aspect);

/* In the place of backend.diffuse, where the job asks for sprites and the backend has none of its own. */
ddof_status bokeh_blur(ddof_context *ctx, frame_job *job, void *scratch);
size_t bokeh_scratch_bytes(const ddof_context *ctx, const frame_job *job);

#endif
