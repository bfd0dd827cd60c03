/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* How near a disc the disc kernel is: what docs/disc.md says of it, as bounds. */
#include "disc_oracle.h"
#include "disc_support.h"

#include <math.h>
#include <stdio.h>

typedef struct bound {
    ddof_quality quality;
    double d;
    double l2, lobe, isotropy; /* at most, at most, at least */
} bound;

static const bound bounds[] = {
    {DDOF_QUALITY_DRAFT, 16, 0.322, 0.009, 0.74},  {DDOF_QUALITY_DRAFT, 48, 0.325, 0.009, 0.75},
    {DDOF_QUALITY_GOOD, 8, 0.153, 0.010, 0.95},    {DDOF_QUALITY_GOOD, 16, 0.130, 0.013, 0.95},
    {DDOF_QUALITY_GOOD, 48, 0.130, 0.015, 0.95},   {DDOF_QUALITY_GOOD, 96, 0.130, 0.015, 0.95},
    {DDOF_QUALITY_BEST, 8, 0.143, 0.006, 0.95},    {DDOF_QUALITY_BEST, 16, 0.099, 0.010, 0.95},
    {DDOF_QUALITY_BEST, 48, 0.090, 0.0135, 0.95},  {DDOF_QUALITY_BEST, 96, 0.090, 0.014, 0.95},
};

static void shape(const disc_case *c) {
    for (int i = 0; i < COUNT(bounds); i++) {
        const bound *b = &bounds[i];
        const disc_figures f = disc_measure(c, b->quality, b->d);
        if (!(f.l2 <= b->l2 && f.lobe <= b->lobe && f.isotropy >= b->isotropy))
            fail_msg("%s, d %g: L2 %.4f, lobe %.4f, isotropy %.3f, not %.3f, %.4f, %.3f", disc_quality_names[b->quality],
                     b->d, f.l2, f.lobe, f.isotropy, b->l2, b->lobe, b->isotropy);
    }
}

int main(void) {
    static const disc_test tests[] = {
        {"shape", shape},
    };
    return run_disc_tests("disc", tests, COUNT(tests));
}
