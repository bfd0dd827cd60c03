/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Which pixels are sprites and what they look like, by brute force in double: every sprite is evaluated at every pixel. Written from
 * the text of src/bokeh.h and src/iris.h; shares nothing with the library. */
#ifndef TESTS_LIBRARY_BOKEH_ORACLE_H
#define TESTS_LIBRARY_BOKEH_ORACLE_H

#include <stdbool.h>
#include <stdint.h>

#include <ddof/ddof.h>

enum { ORACLE_NODES = 900, ORACLE_TEXELS = 128 * 128 + 64 * 64 + 32 * 32 + 16 * 16 + 8 * 8 };

/* What the iris looks like, and its sums as far as they have been needed. */
typedef struct bokeh_iris {
    ddof_iris s;
    double aspect, turn[2], normal[64][2];
    double sum[5][2][ORACLE_NODES]; /* by place within a pixel, side, node */
    double cats_gain[65];
    double texel[ORACLE_TEXELS];
} bokeh_iris;

/* image: values of s.image, tight; NULL where there is none. */
bokeh_iris *bokeh_iris_make(const ddof_iris *s, const float *image, double aspect);
void bokeh_iris_free(bokeh_iris *iris);

typedef struct bokeh_oracle {
    int width, height;                               /* of the part that is given */
    int whole_width, whole_height, left, top;        /* the picture it is of */
    int colors;                                      /* that count as R, G, B */
    const float *rgba, *coc;                         /* premultiplied; channels there are not are 0. Signed, pixels */
    ddof_sprites sprites;
    bokeh_iris *iris;
} bokeh_oracle;

typedef struct bokeh_counts {
    int64_t drawn, dropped, large;
    double threshold; /* raised */
} bokeh_counts;

/* HIGHLIGHTS: `rest` is the picture less what is taken, `drawn` what is added to it after the blur. RGBA. */
bokeh_counts bokeh_oracle_highlights(const bokeh_oracle *o, float *rest, double *drawn);

/* FULL, of a picture without holes. */
void bokeh_oracle_full(const bokeh_oracle *o, double *out);

/* Whether a CoC, or that of one of its colours, lies so close between two nodes of the iris's tables that float may take the other one. */
bool bokeh_oracle_between_nodes(double coc, double fringe);

#endif
