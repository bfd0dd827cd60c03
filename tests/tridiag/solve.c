/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Every solver against Thomas in long double: all sizes, numbers of right-hand sides, layouts, kinds of systems. */
#include "support.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static const size_t large[] = {127, 128, 129, 1023, 1024, 1919, 4099};

typedef struct subject {
    ddof_tridiag_solver solver;
    kind which;
} subject;

static bool packed(ddof_tridiag_solver solver) {
    return solver == DDOF_TRIDIAG_CR_PACK || solver == DDOF_TRIDIAG_CR4_PACK;
}

/* In units of the range. Where blur is wide it is the oracle that loses digits against double. */
static double tolerance(subject t, size_t number_size) {
    if (packed(t.solver)) return t.which == M_MATRIX || t.which == DOMINANT ? 1e-2 : 2e-3;
    if (number_size == 8) return t.which == DIFFUSION_1E5 || t.which == DIFFUSION_1E4 || t.which == WIDE ? 1e-8 : 1e-13;
    if (t.which == M_MATRIX) return 2e-4; /* row sums of 1e-3 b: their rounding in b */
    return t.solver == DDOF_TRIDIAG_THOMAS || t.solver == DDOF_TRIDIAG_PCR3_SWEEP ? 1e-5 : 1e-6;
}

static double worst_of(subject t, size_t n, size_t number_size, rng *r) {
    double worst = 0;
    for (size_t nrhs = 1; nrhs <= 5; nrhs++) {
        problem p = problem_make(t.which, n < 128 ? 3 : 1, n, nrhs, r);
        double *y = solve(&p, t.solver, number_size, (layout)((n + nrhs) % LAYOUTS), NULL);
        const double e = error_of(&p, y);
        if (!(e <= tolerance(t, number_size)))
            fail_msg("n %zu, nrhs %zu, %zu bytes: error %.3g", n, nrhs, number_size, e);
        worst = fmax(worst, e);
        free(y);
        problem_free(&p);
    }
    return worst;
}

static void test_subject(void **state) {
    const subject t = *(const subject *)*state;
    rng r = {(uint64_t)(t.solver * KINDS + t.which)};
    for (size_t number_size = 4; number_size <= 8; number_size += 4) {
        double worst = 0;
        for (size_t n = 1; n <= 67; n++)
            worst = fmax(worst, worst_of(t, n, number_size, &r));
        for (size_t i = 0; i < COUNT(large); i++)
            worst = fmax(worst, worst_of(t, large[i], number_size, &r));
        print_message("# %s, %s, %s: largest error %.2g of the range\n", ddof_tridiag_about(t.solver)->name,
                      kind_name[t.which], number_size == 4 ? "float" : "double", worst);
    }
}

int main(void) {
    enum { TESTS = DDOF_TRIDIAG_SOLVERS * KINDS };
    static subject subjects[TESTS];
    static char names[TESTS][64];
    static struct CMUnitTest tests[TESTS];
    for (int i = 0; i < TESTS; i++) {
        subjects[i] = (subject){(ddof_tridiag_solver)(i / KINDS), (kind)(i % KINDS)};
        snprintf(names[i], sizeof names[i], "%s, %s", ddof_tridiag_about(subjects[i].solver)->name,
                 kind_name[subjects[i].which]);
        tests[i] = (struct CMUnitTest){names[i], test_subject, NULL, NULL, &subjects[i]};
    }
    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests_name("tridiag", tests, NULL, NULL);
}
