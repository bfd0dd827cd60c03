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

#include "disc_bounds.h"

/* What docs/disc.md says, and a little more, since a backend may round. */
static void shape(const disc_case *c) {
    for (int i = 0; i < COUNT(bounds); i++) {
        const bound *b = &bounds[i];
        const disc_figures f = disc_measure(c, b->quality, b->d);
        if (!(f.l2 <= b->l2 + 0.001 && f.lobe <= b->lobe + 0.0003 && f.isotropy >= b->isotropy - 0.004))
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
