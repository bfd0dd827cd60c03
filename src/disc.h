/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The disc kernel: the constants of DDOF_KERNEL_DISC, and the conductance that follows from them (docs/disc.md).
 *
 * A component j is a diffusion like the heat step, with complex conductance; it turns the picture x into complex a_j. The
 * result is the sum of Re(weight_j a_j); the real parts of the weights sum to 1, so constants and energy stay.
 * For a link between pixels of CoC d0, d1, with u = min(|d0|, |d1|)^2 (Kass et al. 2006: the sharper pixel decides):
 *     v    = max(1, u)
 *     B    = u (beta v + offset)/(v + excess)           complex; what a component conducts in all
 *     t    = v/(v + fade)                               the diagonals fade where the disc has no pixels for them
 *     rows B (2 - t)/2, columns likewise, each diagonal B t/4, on the links of its own direction; all / substeps
 * The kernel's variance along each axis is 2 sum Re(weight B). offset gives small discs their shape, and would make them too
 * wide; divided by v + excess they are as wide as a disc at every d, in proportion to d, however small: on ray-traced
 * pictures that decides between 1 and 10 pixels.
 * With only rows and columns (directions 2): rows B, columns B.
 * Pixels that are not square, a = width/height: d pixel widths span d a rows. Diagonals D = min(1, a^2) B t/4, rows B - 2 D,
 * columns a^2 B - 2 D: the widths along rows and columns are exact. */
#ifndef DDOF_DISC_H
#define DDOF_DISC_H

#include <ddof/ddof.h>

typedef struct disc_component {
    double beta_re, beta_im, offset_re, offset_im, weight_re, weight_im;
} disc_component;

typedef struct disc_kernel {
    int components; /* 1 or 2 */
    int directions; /* 2: rows, columns; 4: diagonals too */
    int substeps;   /* each runs all directions, with conductance / substeps */
    double fade;    /* pixels^2 */
    disc_component component[2];
} disc_kernel;

enum { DISC_ROWS, DISC_COLUMNS, DISC_DIAGONAL /* down and right */, DISC_ANTIDIAGONAL /* down and left */ };

/* What a direction conducts, per substep: (level - slope t) B, with B and t of the link. */
typedef struct disc_share {
    double level, slope;
} disc_share;

const disc_kernel *disc_kernel_pick(ddof_quality quality);
/* sum Re(weight offset) / sum Re(weight beta), pixels^2. */
double disc_excess(const disc_kernel *kernel);
disc_share disc_direction(const disc_kernel *kernel, int direction, double pixel_aspect);

#endif
