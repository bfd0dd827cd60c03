/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* How near a disc the disc kernel is: what docs/disc.md says of it, as bounds. */
#include "disc_oracle.h"
#include "disc_support.h"

#include <math.h>

typedef struct bound {
    ddof_quality quality;
    double d;
    double l2, lobe, isotropy; /* at most, at most, at least */
} bound;

static const bound bounds[] = {
    {DDOF_QUALITY_DRAFT, 16, 0.322, 0.009, 0.74},  {DDOF_QUALITY_DRAFT, 48, 0.325, 0.009, 0.75},
    {DDOF_QUALITY_GOOD, 8, 0.147, 0.0113, 0.96},   {DDOF_QUALITY_GOOD, 16, 0.130, 0.0122, 0.99},
    {DDOF_QUALITY_GOOD, 48, 0.130, 0.0134, 0.995}, {DDOF_QUALITY_GOOD, 96, 0.130, 0.0135, 0.995},
    {DDOF_QUALITY_BEST, 8, 0.132, 0.0089, 0.965},  {DDOF_QUALITY_BEST, 16, 0.098, 0.0114, 0.99},
    {DDOF_QUALITY_BEST, 48, 0.090, 0.0146, 0.995}, {DDOF_QUALITY_BEST, 96, 0.090, 0.0150, 0.995},
};

/* What docs/disc.md says, and a little more, since a backend may round. */
static void shape(const disc_case *c) {
    for (int i = 0; i < COUNT(bounds); i++) {
        const bound *b = &bounds[i];
        const disc_figures f = disc_measure(c, b->quality, b->d);
        if (!(f.l2 <= b->l2 + 0.001 && f.lobe <= b->lobe + 0.0005 && f.isotropy >= b->isotropy - 0.004))
            fail_msg("%s, d %g: L2 %.4f, lobe %.4f, isotropy %.3f, not %.3f, %.4f, %.3f",
                     disc_quality_names[b->quality], b->d, f.l2, f.lobe, f.isotropy, b->l2, b->lobe, b->isotropy);
    }
}

/* What is promised of DDOF_QUALITY_GOOD and BEST, whatever the constants are. */
static void promise(const disc_case *c) {
    static const double l2[][3] = {{8, 0.20, 0.20}, {16, 0.13, 0.13}, {48, 0.13, 0.09}, {96, 0.13, 0.09}};
    for (int i = 0; i < COUNT(l2); i++)
        for (int q = 1; q < 3; q++) {
            const disc_figures f = disc_measure(c, disc_qualities[q], l2[i][0]);
            if (!(f.l2 <= l2[i][q] + c->backend->tolerance && f.isotropy >= 0.95 && f.lobe <= 0.0155))
                fail_msg("%s, d %g: L2 %.4f, isotropy %.3f, lobe %.4f", disc_quality_names[disc_qualities[q]], l2[i][0],
                         f.l2, f.isotropy, f.lobe);
        }
}

/* A single pixel's own middle, which the softened figures do not show: at worst, in units of the even disc. */
static void pinhole(const disc_case *c) {
    static const double least[3] = {-0.19, -1.35, -0.77};
    for (int q = 0; q < 3; q++)
        for (double d = 2; d <= 32; d += 1) {
            const disc_figures f = disc_measure(c, disc_qualities[q], d);
            if (!(f.least >= least[q])) fail_msg("%s, d %g: %.3f", disc_quality_names[disc_qualities[q]], d, f.least);
        }
}

/* The variance follows from the conductances exactly, along both axes, for pixels of any shape. It grows with d, and is
 * that of the disc, d^2/16: of draft nearly, of the others to their last digit. */
static void width(const disc_case *c) {
    static const double aspects[] = {1, 0.5, 2};
    for (int q = 0; q < 3; q++)
        for (int i = 0; i < 12; i++) {
            const double d = 1.5 + i / 3 * 3.5, aspect = aspects[i % 3];
            const double want = (double)disc_oracle_variance(disc_qualities[q], (double)(float)d);
            disc_picture p = disc_picture_make(301, 401, d);
            double sum = 0, x2 = 0, y2 = 0;
            *disc_picture_middle(p.color, &p) = 1;
            disc_picture_render(c, &p, disc_qualities[q], aspect);
            for (int k = 0; k < 301 * 401; k++) {
                const double v = p.output[k], x = k % 301 - 150, y = k / 301 - 200;
                sum += v;
                x2 += v * x * x;
                y2 += v * y * y;
            }
            if (!(fabs(sum - 1) <= 1e-6 + c->backend->tolerance &&
                  fabs(x2 / want - 1) <= 1e-5 + 100 * c->backend->tolerance &&
                  fabs(y2 / want / aspect / aspect - 1) <= 1e-5 + 100 * c->backend->tolerance))
                fail_msg("%s, d %g, aspect %g: sum %.8f, variances %.7g, %.7g, not %.7g",
                         disc_quality_names[disc_qualities[q]], d, aspect, sum, x2, y2, want);
            disc_picture_free(&p);
        }
}

static void width_of_a_disc(const disc_case *c) {
    static const long double most[3] = {0.0125L, 5e-6L, 5e-6L};
    (void)c;
    for (int q = 0; q < 3; q++) {
        long double before = 0;
        for (long double d = 0.01L; d < 300; d *= 1.01L) {
            const long double v = disc_oracle_variance(disc_qualities[q], d), off = v / (d * d / 16) - 1;
            if (!(v > before)) fail_msg("%s: the variance falls at d %.3Lf", disc_quality_names[disc_qualities[q]], d);
            if (!(fabsl(off) <= most[q]))
                fail_msg("%s, d %.2Lf: the variance is %.6Lf of a disc's", disc_quality_names[disc_qualities[q]], d,
                         off + 1);
            before = v;
        }
    }
}

int main(void) {
    static const disc_test tests[] = {
        {"shape", shape},
        {"as near a disc as promised", promise},
        {"the middle pixel", pinhole},
        {"variance, from the conductances", width},
        {"variance, that of a disc", width_of_a_disc},
    };
    return run_disc_tests("disc", tests, COUNT(tests));
}
