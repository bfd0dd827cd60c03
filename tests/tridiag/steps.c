/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The inside of the solvers, in double: one 4:1 step is two 2:1 steps, one 1:4 step two 1:2 steps; packing; halves. */
#include "support.h"

#include <math.h>
#include <stdlib.h>

#include "tridiag/steps.h"

static const double TO_ROUNDING = 1e-13;

/* A diffusion problem as the solvers see it, with a scratch memory that is large enough for all of a test. */
typedef struct fixture {
    problem p;
    system_of s;
    char *scratch;
    double *y, v[4];
} fixture;

static void fixture_make(fixture *f, kind which, size_t n, size_t nrhs) {
    rng r = {n};
    f->p = problem_make(which, 1, n, nrhs, &r);
    f->scratch = malloc(1 << 20);
    f->y = calloc(n * nrhs, sizeof *f->y);
    assert_true(f->scratch && f->y);
    f->s = (system_of){.n = n,
                       .nrhs = nrhs,
                       .diffusion = true,
                       .beta = f->p.beta,
                       .g = f->p.g,
                       .x = f->p.x,
                       .y = f->y,
                       .row_stride = 1,
                       .x_row_stride = (ptrdiff_t)nrhs,
                       .x_rhs_stride = 1,
                       .scratch = f->scratch,
                       .v = f->v};
}

static void fixture_free(fixture *f) {
    problem_free(&f->p);
    free(f->scratch);
    free(f->y);
}

static void assert_near(double got, double want, const char *what, size_t n, size_t i) {
    if (!(fabs(got - want) <= TO_ROUNDING * fmax(1, fabs(want))))
        fail_msg("n %zu, row %zu: %s is %.17g, not %.17g", n, i, what, got, want);
}

static void test_reduce4(void **state) {
    (void)state;
    for (size_t n = 4; n <= 400; n++) {
        fixture f;
        fixture_make(&f, n % 2 ? SOFT : DIFFUSION_200, n, 3);
        const level full = REAL(level_input)(&f.s);
        level half = REAL(level_table)(&f.s, n / 2), quarter = REAL(level_table)(&f.s, n / 4);
        level direct = REAL(level_table)(&f.s, n / 4);
        REAL(reduce_step)(&f.s, &full, &half);
        REAL(reduce_step)(&f.s, &half, &quarter);
        REAL(initial_reduce4)(&f.s, &full, &direct);
        for (size_t i = 0; i < n / 4; i++) {
            assert_near(direct.abc[i].a, quarter.abc[i].a, "a", n, i);
            assert_near(direct.abc[i].g, quarter.abc[i].g, "g", n, i);
            assert_near(direct.abc[i].c, quarter.abc[i].c, "c", n, i);
            for (size_t k = 0; k < 3; k++)
                assert_near(direct.x[3 * i + k], quarter.x[3 * i + k], "x", n, i);
        }
        fixture_free(&f);
    }
}

static void test_solve4(void **state) {
    (void)state;
    for (size_t n = 4; n <= 400; n++) {
        fixture f;
        fixture_make(&f, n % 2 ? SOFT : DIFFUSION_200, n, 2);
        level full = REAL(level_input)(&f.s);
        level half = REAL(level_table)(&f.s, n / 2), quarter = REAL(level_table)(&f.s, n / 4);
        REAL(reduce_step)(&f.s, &full, &half);
        for (size_t i = 0; i < n / 4 * 2; i++)
            quarter.y[i] = f.p.y[(i / 2 * 4 + 3) * 2 + i % 2]; /* known */
        REAL(final_solve4)(&f.s, &quarter, &full);
        double *direct = malloc(n * 2 * sizeof *direct);
        assert_non_null(direct);
        for (size_t i = 0; i < n * 2; i++)
            direct[i] = f.y[i];
        REAL(substitute_step)(&f.s, &quarter, &half);
        REAL(substitute_step)(&f.s, &half, &full);
        for (size_t i = 0; i < n * 2; i++)
            assert_near(direct[i], f.y[i], "y", n, i / 2);
        free(direct);
        fixture_free(&f);
    }
}

/* Any three halves come back as they were put in, whatever the coefficients; those keep 17 bits. */
static void test_pack(void **state) {
    (void)state;
    for (uint32_t h = 0; h < 65536; h++) {
        const uint32_t halves[3] = {h, 65535 - h, h * 40503 & 65535};
        const row r = {-1e4 / (1 + h % 97), 1 + h % 13, -3e-7 * (1 + h % 89)};
        double x[3];
        for (int k = 0; k < 3; k++)
            x[k] = (double)half_value(halves[k]) * r.g;
        const record d = pack(r, x, 3);
        const row back = unpack_row(d);
        assert_true(fabs(back.a / r.a - 1) < 0x1p-17 && fabs(back.g / r.g - 1) < 0x1p-17 &&
                    fabs(back.c / r.c - 1) < 0x1p-17);
        for (size_t k = 0; k < 3; k++) {
            const double want = (double)half_value(halves[k]), got = unpack_x(d, back, k) / back.g;
            assert_true(isnan(want) ? isnan(got) : got == want);
        }
    }
}

/* g = 0, or too small for a float: x itself is kept. */
static void test_pack_without_g(void **state) {
    (void)state;
    const row hole = {-2, 0, -3}, tiny = {-2, 1e-60, -3};
    const double x[3] = {0.5, -0.25, 8};
    for (size_t k = 0; k < 3; k++) {
        assert_true(unpack_x(pack(hole, x, 3), unpack_row(pack(hole, x, 3)), k) == x[k]);
        assert_true(unpack_x(pack(tiny, x, 3), unpack_row(pack(tiny, x, 3)), k) == x[k]);
        assert_true(unpack_x(pack(hole, x, 1), unpack_row(pack(hole, x, 1)), k) == (k == 0 ? x[k] : 0));
    }
    const row nan = {NAN, 1, 1};
    assert_true(isnan(unpack_row(pack(nan, x, 3)).a));
}

/* Each half to a float and back; what lies between two halves goes to the nearer one, the middle to the even one. */
static void test_half(void **state) {
    (void)state;
    for (uint32_t h = 0; h < 0x7c00; h++) {
        const float here = half_value(h), next = h == 0x7bff ? 65536.0f : half_value(h + 1), middle = (here + next) / 2;
        assert_int_equal(half_bits(here), h);
        assert_int_equal(half_bits(-here), h | 0x8000);
        assert_int_equal(half_bits(nextafterf(middle, 0)), h);
        assert_int_equal(half_bits(nextafterf(middle, INFINITY)), h + 1);
        assert_int_equal(half_bits(middle), h + (h & 1));
    }
    assert_int_equal(half_bits(INFINITY), 0x7c00);
    assert_int_equal(half_bits(1e30f), 0x7c00);
    assert_true(isinf(half_value(0xfc00)) && isnan(half_value(half_bits(NAN))));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_reduce4),        cmocka_unit_test(test_solve4), cmocka_unit_test(test_pack),
        cmocka_unit_test(test_pack_without_g), cmocka_unit_test(test_half),
    };
    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests_name("tridiag steps", tests, NULL, NULL);
}
