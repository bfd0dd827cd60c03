/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The CPU engine's stages as one instruction set implements them. What src/meson.build lists as
 * kernel_sources is compiled once per instruction set; engine.c, disc_engine.c, methods.c, ../layers.c, ../fill.c and ../bokeh.c drive it.
 *
 * The engine works on a BLOCK of as many rows as the vectors have lanes: every row is solved, one row per lane, and the
 * column elimination of these rows follows at once, while they are in the cache. */
#ifndef DDOF_CPU_KERNELS_H
#define DDOF_CPU_KERNELS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <ddof/ddof.h>

#include "../lens.h"

enum {
    MAX_LANES = 16, /* rows of a block, at most */
    TILE = 64,      /* pixels; rows are handed from the row stage to the column stage in tiles of this width */
    PAD = 16        /* every scratch row is this many pixels longer, so that vectors may run over the end */
};

/* The rows of a block as they come in, RGBA float; those beyond `count` repeat the last one and are not written. */
typedef struct cpu_rows {
    int width, count;
    const float *pixel[MAX_LANES]; /* rows of the source */
    const float *coc[MAX_LANES];   /* their CoC, pixels */
    const float *capacity;         /* heat capacity g, [x][lane]; NULL: 1 everywhere */
    float row_alive[MAX_LANES];    /* g of a row in the column stage: 0 when all of it was holes */
} cpu_rows;

/* A block under work. */
typedef struct cpu_block {
    cpu_rows in;
    const float *coc_below;        /* CoC of the row below the block; NULL where there is none */
    float row_scale, column_scale; /* conductance of d = 1 along rows and columns */
    float *mean;                   /* scratch: (width + PAD) * lanes * 4, [x][4][lane] */
    float *keep;                   /* scratch: (width + PAD) * lanes, [x][lane] */
    float *tile;                   /* scratch: lanes rows of TILE pixels */
    float carry[4][MAX_LANES];     /* row stage: the solution right of the tile */
} cpu_block;

/* The column elimination between blocks: what the rows above leave behind, for each column. */
typedef struct column_state {
    float *rest; /* the weight they reach the next row with */
    float *mean; /* their mean, RGBA */
} column_state;

/* Stage rows (rows.c). */
typedef struct row_kernels {
    /* Down: eliminates all rows of the block from left to right. False when a value was not finite: then the caller says
     * by `capacity` where the holes are, and calls again. */
    bool (*forward)(const cpu_block *block);
    /* Back: substitutes pixels [x0, x1) from right to left into block->tile. x0 is a multiple of TILE; the last tile comes
     * first, with a carry of zeros. */
    void (*backward)(cpu_block *block, int x0, int x1);
} row_kernels;

/* Stage columns (columns.c). */
typedef struct column_kernels {
    /* Down: takes block->tile through the elimination of the columns; writes the mean to out[row] and keep to keep[row], both
     * pointing at pixel x0. stream: past the caches; out and keep are then aligned to 64 bytes. */
    void (*down)(const cpu_block *block, const column_state *state, int x0, int x1, float *const *out, float *const *keep,
                 bool stream);
    /* Up, in place: row = lerp(below, row, keep), `count` pixels. */
    void (*up)(float *row, const float *keep, const float *below, int count);
} column_kernels;

/* ---- the disc kernel (disc.h): complex pixels are two RGBA pixels, one of real and one of imaginary parts */

enum {
    DISC_TILE = 64,
    DISC_ROWS_AT_ONCE = 2, /* of a sweep without a row stage */
    DISC_SKEW = 16         /* pixels by which a tile lies farther left in each row: diagonals then find their neighbours done */
};

/* What a link conducts: with d the lesser magnitude of CoC and v = max(1, d^2),
 *     B = d^2 (linear v + constant) / ((v + excess) (v + fade)) (beta v + offset)
 * which is disc.h's with one division. */
typedef struct disc_link {
    float linear, constant, fade, excess;
    float beta_re, beta_im, offset_re, offset_im;
} disc_link;

/* Complex pixels side by side and, where there is one, their coefficient `keep`; in the state of lines rest instead. */
typedef struct disc_span {
    float *re, *im;           /* RGBA */
    float *keep_re, *keep_im; /* one a pixel */
} disc_span;

/* A block in the row stage, a row per lane. */
typedef struct disc_block {
    cpu_rows in;                        /* real parts; coc is the magnitude, limited, with borders of -1 */
    const float *imaginary[MAX_LANES];  /* [0] NULL: there is none */
    float *mean;                        /* scratch: (width + PAD) * lanes * 8, [x][8][lane] */
    float *keep;                        /* scratch: (width + PAD) * lanes * 2, [x][2][lane] */
    float *tile_re, *tile_im;           /* scratch: lanes rows of TILE pixels */
    float carry[8][MAX_LANES];          /* the solution right of the tile */
} disc_block;

typedef struct disc_kernels {
    /* A row of CoC to its magnitude, limited, and -1 beyond `width` up to `padded`. False when a value was not finite. */
    bool (*magnitude)(const float *coc, float *out, int width, int padded);
    /* Stage rows (disc_rows.c), as in row_kernels. */
    bool (*forward)(const disc_block *block, const disc_link *link);
    void (*backward)(disc_block *block, int x0, int x1);
    /* Stages columns and diagonals (disc_lines.c): the pixels of a row, each on a line of its own. `lines` is the state of
     * these lines; count is rounded up to whole vectors, so everything but the output has room for that.
     * One row of an elimination: near, far: magnitudes of the CoC of these pixels and the next ones on their lines;
     * writes means and keep to `out`. */
    void (*eliminate)(const disc_link *link, const disc_span *lines, const float *near, const float *far, float g,
                      const float *re, const float *im, const disc_span *out, int count, bool stream);
    /* One row of a substitution; the solution is left in `lines` and, in place, in `state`. */
    void (*substitute)(const disc_span *lines, const disc_span *state, int count);
    /* Both in one: the substitution of the lines `solved`, then the elimination of `lines`, in place in `state`. */
    void (*turn)(const disc_link *link, const disc_span *solved, const disc_span *lines, const float *near, const float *far,
                 const disc_span *state, int count);
    /* A substitution whose solution a becomes the result: out = add + Re(weight a); add NULL: 0. Exactly `count` pixels are
     * written. */
    void (*finish)(const disc_span *lines, const disc_span *state, float weight_re, float weight_im, const float *add,
                   float *out, int count);
} disc_kernels;

/* ---- layers */

/* What of a pixel belongs to a layer and all nearer ones: smoothstep(offset - gain CoC), 0 to 1. */
typedef struct layer_share {
    float gain, offset;
} layer_share;

enum { NEAR_OCTAVE = 8, NEAR_CLASSES = 20 * NEAR_OCTAVE }; /* of |CoC|, logarithmic, from 1 pixel */

enum { ROW_NOT_FINITE = 1, ROW_TRANSPARENT = 2 };

/* Stage layers (layers.c), a row of `count` pixels at a time. */
typedef struct layer_kernels {
    /* ROW_*: whether some value is not finite, some alpha not 1. */
    int (*inspect)(const float *rgba, const float *coc, int count);
    /* Counts what is nearer than `least` pixels of CoC by class. */
    void (*classify)(const float *coc, int count, float least, int *classes);
    /* The layer's first and last pixel, and its largest |CoC|; false: it has none. */
    bool (*extent)(const float *coc, int count, layer_share here, layer_share nearer, int *first, int *last, float *widest);
    /* Takes the layer's part of the source. weight: 0 where something nearer hides it. */
    void (*split)(const float *source, const float *coc, int count, layer_share here, layer_share nearer, float *part,
                  float *weight);
    /* How much of a pixel it covers; the same weight. */
    void (*cover)(const float *coc, int count, layer_share here, layer_share nearer, float *cover, float *weight);
    /* Its |CoC|, and 1, where it has pixels; else both 0. */
    void (*reach)(const float *coc, int count, layer_share here, layer_share nearer, float *reach, float *weight);
    /* Raises a row to what the row beside it leaves of its values, less `slope` straight and less `across` diagonally; then,
     * pixel by pixel, forward or backward, to its neighbour's less 1. Both rows have a 0 at either end beyond `count`. */
    void (*spread)(const float *beside, float *row, int count, float slope, float across, bool forward);
    /* Lays it over what is behind, in place there. cover: NULL: its alpha. */
    void (*over)(const float *part, const float *cover, float *behind, int count);
} layer_kernels;

enum { FILL_TILE = 256 /* pixels of a row that are filled at a time, in the nearest cache */ };

/* A tile of a row of a pyramid's level, and the two rows of the level above around it. */
typedef struct fill_tile {
    int channels, x, count; /* channels: 1 or 4; x: even */
    bool picture;           /* the row is one of the picture, not yet multiplied by its weights */
    int width_above;
    float share; /* of the second row above */
    const float *value[2], *filled[2], *weight[2];
} fill_tile;

/* Stage fill (fill.c). */
typedef struct fill_kernels {
    /* Pixels of the level above from those of one or two rows (else NULL), `count` of them in each. */
    void (*push)(int channels, int count, bool picture, const float *const value[2], const float *const weight[2],
                 float *value_above, float *weight_above);
    /* Fills a tile, in place. It and its weights have room for PAD pixels more. */
    void (*pull)(const fill_tile *tile, float *value, float *weight);
} fill_kernels;

struct iris;
struct iris_row;

/* Stage bokeh (sprites.c). */
typedef struct sprite_kernels {
    /* The largest R, G or B, whichever of the first `colors` channels there are, that is a number; -infinity when none is. */
    float (*brightest)(const float *rgba, int count, int colors);
    /* A row of a sprite's mask, not divided by its sum (iris.h). */
    void (*mask)(const struct iris *iris, const struct iris_row *row, int count, float *mask);
    /* rgba += mask * visible(coc, sprite_coc) * color, pixel by pixel, `coc_step` values of coc to a pixel; weight, where not
     * NULL: the same of 1. */
    void (*add)(float *rgba, float *weight, const float *mask, const float *coc, int coc_step, int count, float sprite_coc,
                const float color[4], float one);
} sprite_kernels;

struct filled_picture;
struct gather_line;

enum { GATHER_CHUNK = 64 };

/* Stage gather (gather.c). */
typedef struct gather_kernels {
    /* RGBA of `count` <= GATHER_CHUNK pixels from (x, y), each the mean along a line through it (methods.h). */
    void (*mean)(const struct filled_picture *picture, const struct gather_line *line, int x, int y, int count, float *rgba);
} gather_kernels;

/* Stages lens and input/output (pixels.c). */
typedef struct pixel_kernels {
    /* A row of depth values to signed CoC. x, y: position of its first pixel in the whole picture. */
    void (*lens)(const lens_curve *curve, const float *depth, float *coc, int count, int x, int y);
    void (*half_to_float)(const uint16_t *in, float *out, int count);
    void (*float_to_half)(const float *in, uint16_t *out, int count);
} pixel_kernels;

typedef struct cpu_kernels {
    const char *name;
    unsigned flag; /* DDOF_CPU_* */
    int lanes;
    const row_kernels *rows;
    const column_kernels *columns;
    const pixel_kernels *pixels;
    const disc_kernels *disc;
    const layer_kernels *layers;
    const fill_kernels *fill;
    const sprite_kernels *sprites;
    const gather_kernels *gather;
} cpu_kernels;

extern const cpu_kernels cpu_kernels_baseline; /* always there; the others are picked in dispatch.c */

#endif
