/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* What the tests of the disc kernel share: every test is run by every backend that has it, and how a point's picture is
 * measured. */
#ifndef TESTS_LIBRARY_DISC_SUPPORT_H
#define TESTS_LIBRARY_DISC_SUPPORT_H

#include "support.h"

/* A backend, and what it is allowed to be off, as a part of the input's range. */
typedef struct disc_backend {
    ddof_backend id;
    const char *name;
    double tolerance;
} disc_backend;

/* What a test finds in *state. */
typedef struct disc_case {
    const disc_backend *backend;
    ddof_context *context;
} disc_case;

typedef struct disc_test {
    const char *name;
    void (*run)(const disc_case *c);
} disc_test;

/* Every test with every backend; those without the disc kernel, or that are not here, are skipped and counted. */
int run_disc_tests(const char *group, const disc_test *tests, int count);

extern const ddof_quality disc_qualities[3];
extern const char *const disc_quality_names[];

ddof_settings disc_settings(ddof_quality quality);

/* A picture of one channel, doubles, with its CoC and room for the result. */
typedef struct disc_picture {
    int width, height;
    float *color, *coc, *output;
} disc_picture;

disc_picture disc_picture_make(int width, int height, double coc); /* black, of one CoC */
void disc_picture_free(disc_picture *p);
void disc_picture_render(const disc_case *c, const disc_picture *p, ddof_quality quality, double aspect);
float *disc_picture_middle(float *values, const disc_picture *p);

/* What a point in a plane of CoC d becomes. */
typedef struct disc_figures {
    double sum, variance_x, variance_y; /* of the kernel; pixels^2 */
    double centre, least, greatest;     /* of the kernel, in units of the even disc, 4/(pi d^2) */
    /* Kernel and disc softened by a Gaussian of 4.5 % of d (docs/disc.md): */
    double l2;       /* norm of the difference / norm of the disc */
    double lobe;     /* deepest value below 0 / highest value */
    double isotropy; /* least / greatest radius at half of the highest value */
} disc_figures;

disc_figures disc_measure(const disc_case *c, ddof_quality quality, double d);

#endif
