/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Stage iris: what a sprite looks like. One definition for all backends: cpu/sprites.c evaluates it, and so does
 * shaders/include/iris.glsl.
 *
 * Of a sprite of signed CoC d, in pixels, at (dx, dy) from its middle, y downwards, with R = |d|/2 and side = 1 behind the focus,
 * -1 before it: p = side (dx squeeze, -dy / aspect) turned by -rotation, in pixels, y upwards. How much of the pixel it covers:
 *     DISC      s = R - |p|
 *     POLYGON   s = (1 - curvature) (R cos(pi/n) - max_k p.n_k) + curvature (R - |p|), n_k the normals of its sides
 *     cat's eye s = min(s, R - |p0 + c R t|), with p0 = side (dx squeeze, -dy / aspect), t the pixel's place from the middle of the picture,
 *               y upwards, in half diagonals, c = cats_eye
 *     cover = clamp(s + 1/2, 0, 1)
 *   IMAGE       the table, bilinear, at the level whose texels are the largest not above a pixel; 0 outside; times the cover of
 *               the cat's eye
 * Times 1 + side edge (2 min(|p|/R, 1)^2 - 1). `aspect`: pixel rows that a pixel width spans.
 *
 * It is divided by its sum over a lattice of pixels, which a table has by |d| and side, so that a sprite has all of its pixel's light.
 * For that |d| is rounded to a node of the table, of which there are 64 to the octave: that moves a rim by 0.27 % of the
 * diameter. With fringe each of red, green and blue has its own |d| (1 + side fringe {1, 0, -1}), rounded likewise. */
#ifndef DDOF_IRIS_H
#define DDOF_IRIS_H

#include <stdbool.h>

#include <ddof/ddof.h>

enum {
    IRIS_OCTAVE = 64,                   /* nodes */
    IRIS_NODES = 13 * IRIS_OCTAVE + 1,  /* |d| from 1 to 4096, and an octave for fringe */
    IRIS_SIDE = 128,                    /* of the image's table, texels */
    IRIS_LEVELS = 5,                    /* 128, 64, 32, 16, 8 */
    IRIS_TEXELS = (128 * 128 * 4 - 8 * 8) / 3, /* of all levels, the largest first */
    IRIS_SUMS = 10,
    IRIS_CATS = 65,                     /* nodes of |c t| from 0 to 1 */
    IRIS_BLADES = 64,
    IRIS_IMAGE_MOST = 4096              /* pixels a side */
};
#define IRIS_MOST 4096.0f

/* What shaders and kernels are given. */
typedef struct iris_shape {
    int kind;                       /* ddof_iris_shape */
    int blades;
    float cosine, sine;             /* of rotation */
    float apothem;                  /* cos(pi/n) */
    float normal_x[IRIS_BLADES], normal_y[IRIS_BLADES]; /* of the sides; the k-th at (k + 1/2) 2 pi/n */
    float curvature, edge, cats_eye, squeeze, fringe, aspect;
} iris_shape;

/* A context's iris, made when settings first ask for it, and anew when they change. */
typedef struct iris {
    bool made;
    iris_shape shape;
    float reach;                      /* iris_reach() */
    float diameter[IRIS_NODES];       /* of each node */
    float inverse_sum[IRIS_SUMS][IRIS_NODES]; /* of the mask, by iris_sum() and node of the sprite */
    float cats_gain[IRIS_CATS];       /* what the cat's eye makes it brighter by, by |c t| */
    float texel[IRIS_TEXELS];         /* IMAGE: rows from the top */
    float read[IRIS_SIDE * IRIS_SIDE]; /* the first level before it is made 1 where it is brightest */
} iris;

/* A row of a mask to be made, in pixels of the target. */
typedef struct iris_row {
    float diameter, side;
    float cat_x, cat_y; /* c t; both 0 where there is no cat's eye */
    float dx, dy;       /* of the first pixel from the sprite's middle, y downwards */
    int level;          /* IMAGE: iris_level() */
} iris_row;

struct sprite_kernels;

/* What is wrong with it, or NULL. */
const char *iris_check(const ddof_iris *settings);

/* False: its image lets no light through. */
bool iris_make(iris *out, const ddof_iris *settings, double aspect, const struct sprite_kernels *kernels);

/* How many radii it reaches right and left, up and down: 1, but for the corners of an image that is turned. */
float iris_reach(const ddof_iris *settings);

/* The node next to a diameter, and the diameter of a node: exp2(node / 64). */
int iris_node(float diameter);
float iris_diameter(int node);

/* Of inverse_sum. half: in a picture of half the size, where its diameter is half as large and its middle lies a quarter of a pixel off:
 * to the left of a pixel's where u is even, else to the right; above it where v is even, else below. near: before the focus. */
static inline int iris_sum(bool half, int u, int v, bool near) {
    return 5 * near + (half ? 1 + (u & 1) + 2 * (v & 1) : 0);
}

/* The level of the image's table for a sprite of a node, `half` or not; where its texels begin, and how many a side has. */
int iris_level(int node, bool half);
const float *iris_texels(const iris *of, int level);
static inline int iris_level_side(int level) {
    return IRIS_SIDE >> level;
}

#endif
