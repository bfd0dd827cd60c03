/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The public functions around the solvers: names, costs, steps, bad arguments, memory, invariants. */
#include "support.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static ddof_tridiag batch_of(ddof_tridiag_solver solver, size_t count, size_t n, size_t nrhs) {
    return (ddof_tridiag){.solver = solver, .count = count, .n = n, .nrhs = nrhs};
}

static ddof_tridiag_cost cost_of(ddof_tridiag_solver solver, size_t n, size_t nrhs) {
    const ddof_tridiag batch = batch_of(solver, 1, n, nrhs);
    ddof_tridiag_cost cost;
    assert_int_equal(ddof_tridiag_cost_of(&batch, 4, &cost), DDOF_OK);
    return cost;
}

static void test_names(void **state) {
    (void)state;
    for (int i = 0; i < DDOF_TRIDIAG_SOLVERS; i++) {
        const ddof_tridiag_info *info = ddof_tridiag_about((ddof_tridiag_solver)i);
        assert_true(info && *info->name && *info->title && *info->source);
        assert_int_equal(ddof_tridiag_by_name(info->name), i);
    }
    assert_null(ddof_tridiag_about(DDOF_TRIDIAG_SOLVERS));
    assert_null(ddof_tridiag_about((ddof_tridiag_solver)-1));
    assert_int_equal(ddof_tridiag_by_name("cr8"), DDOF_TRIDIAG_SOLVERS);
    assert_int_equal(ddof_tridiag_by_name(NULL), DDOF_TRIDIAG_SOLVERS);
}

/* Zhang, Cohen and Owens 2010: CR 17n in 2 log2 n - 1 steps, PCR 12 n log2 n in log2 n steps, with b at hand. */
static void test_published_counts(void **state) {
    (void)state;
    uint64_t log2n = 2;
    for (uint64_t n = 4; n <= 65536; n *= 2, log2n++) {
        const ddof_tridiag_cost vanilla = cost_of(DDOF_TRIDIAG_CR_VANILLA, n, 1), cr = cost_of(DDOF_TRIDIAG_CR, n, 1);
        const ddof_tridiag_cost pcr = cost_of(DDOF_TRIDIAG_PCR, n, 1), thomas = cost_of(DDOF_TRIDIAG_THOMAS, n, 1);
        const uint64_t ops = vanilla.adds + vanilla.muls + vanilla.divisions - vanilla.diagonal_adds;
        /* n - 1 reductions of 12 and n - 1 substitutions of 5 operations, one division; all but 16 of 17n */
        assert_int_equal(ops, 17 * (n - 1) + 1);
        assert_int_equal(cr.steps, 2 * log2n - 1);
        assert_int_equal(vanilla.steps, cr.steps + 3); /* constructs first and goes on to one unknown */
        /* they solve pairs at the end, here log2 n steps leave single rows, and their division is a step of its own */
        assert_int_equal(pcr.adds + pcr.muls + pcr.divisions - pcr.diagonal_adds, 12 * n * log2n + n);
        assert_int_equal(pcr.steps, log2n + 1);
        /* 8n for the textbook, which goes up without the sum that keeps the roundings small */
        assert_int_equal(thomas.adds + thomas.muls + thomas.divisions - thomas.diagonal_adds, 9 * n);
        assert_int_equal(thomas.steps, 2 * n);
    }
}

/* What is stored, in units of n: the surfaces of the published table. */
static void test_storage(void **state) {
    (void)state;
    const uint64_t n = 4096;
    assert_int_equal(cost_of(DDOF_TRIDIAG_CR_VANILLA, n, 3).rows, 2 * n - 1);
    const ddof_tridiag_cost cr = cost_of(DDOF_TRIDIAG_CR, n, 3), cr4 = cost_of(DDOF_TRIDIAG_CR4, n, 3);
    assert_int_equal(cr.rows, n - 2);
    assert_true(cr.x_rows == cr.rows && cr.y_rows == cr.rows && cr.records == 0);
    assert_int_equal(cr.bytes, (n - 2) * (12 + 12 + 12));
    assert_int_equal(cr4.rows, n / 2 - 2);
    const ddof_tridiag_cost packed = cost_of(DDOF_TRIDIAG_CR4_PACK, n, 3);
    assert_true(packed.records == n / 2 - 2 && packed.half_rows == n / 2 - 2 && packed.rows == 0);
    assert_int_equal(packed.bytes, (n / 2 - 2) * 24);
    assert_int_equal(cost_of(DDOF_TRIDIAG_CR4_PACK, n, 4).bytes, packed.bytes); /* groups take turns */
    assert_int_equal(cost_of(DDOF_TRIDIAG_THOMAS, n, 3).bytes, n * 4);
}

static void assert_steps(ddof_tridiag_solver solver, size_t n, size_t pcr_size, const size_t *want, size_t count) {
    ddof_tridiag batch = batch_of(solver, 1, n, 1);
    size_t got[64] = {0};
    batch.pcr_size = pcr_size;
    assert_int_equal(ddof_tridiag_steps(&batch, got, COUNT(got)), count);
    for (size_t i = 0; i < count; i++)
        assert_int_equal(got[i], want[i]);
    assert_int_equal(ddof_tridiag_steps(&batch, NULL, 0), count);
}

static void test_steps(void **state) {
    (void)state;
    assert_steps(DDOF_TRIDIAG_CR_VANILLA, 7, 0, (size_t[]){7, 3, 1, 1, 3, 7}, 6);
    assert_steps(DDOF_TRIDIAG_CR, 7, 0, (size_t[]){3, 3, 7}, 3);
    assert_steps(DDOF_TRIDIAG_CR, 16, 0, (size_t[]){8, 4, 2, 2, 4, 8, 16}, 7);
    assert_steps(DDOF_TRIDIAG_CR4, 33, 0, (size_t[]){8, 4, 2, 2, 4, 8, 33}, 7);
    assert_steps(DDOF_TRIDIAG_CR_PCR, 16, 4, (size_t[]){8, 4, 4, 4, 4, 8, 16}, 7);
    assert_steps(DDOF_TRIDIAG_PCR, 5, 0, (size_t[]){5, 5, 5, 5}, 4);
    assert_steps(DDOF_TRIDIAG_PCR3_SWEEP, 19, 0, (size_t[]){19, 19, 19, 8, 8, 3, 3, 8, 8}, 9);
    assert_steps(DDOF_TRIDIAG_THOMAS, 3, 0, (size_t[]){1, 1, 1, 1, 1, 1}, 6);
}

static void test_wrong(void **state) {
    (void)state;
    float a[4] = {0}, b[4] = {1, 1, 1, 1}, c[4] = {0}, x[4] = {1, 2, 3, 4};
    const ddof_tridiag good = batch_of(DDOF_TRIDIAG_CR, 1, 4, 1);
    ddof_tridiag bad[7] = {good, good, good, good, good, good, good};
    const char *member[] = {"solver", "solver", "n ", "n ", "nrhs", "allocate", "reserved"};
    bad[0].solver = DDOF_TRIDIAG_SOLVERS;
    bad[1].solver = (ddof_tridiag_solver)-1;
    bad[2].n = 0;
    bad[3].n = ((size_t)1 << 26) + 1;
    bad[4].nrhs = 65537;
    bad[5].release = (void (*)(void *, void *))(uintptr_t)1;
    bad[6].reserved[3] = 1;
    assert_null(ddof_tridiag_wrong(&good));
    assert_non_null(ddof_tridiag_wrong(NULL));
    for (size_t i = 0; i < COUNT(bad); i++) {
        ddof_tridiag_cost cost = {.steps = 7};
        assert_non_null(strstr(ddof_tridiag_wrong(&bad[i]), member[i]));
        assert_int_equal(ddof_tridiag_solve_f(&bad[i], a, b, c, x, x, &cost), DDOF_ERROR_INVALID);
        assert_int_equal(cost.steps, 0);
        assert_int_equal(ddof_tridiag_diffuse_f(&bad[i], a, b, x, x, NULL), DDOF_ERROR_INVALID);
        assert_int_equal(ddof_tridiag_cost_of(&bad[i], 4, &cost), DDOF_ERROR_INVALID);
        assert_int_equal(ddof_tridiag_steps(&bad[i], NULL, 0), 0);
    }
    assert_int_equal(ddof_tridiag_cost_of(&good, 2, &(ddof_tridiag_cost){0}), DDOF_ERROR_INVALID);
    assert_int_equal(ddof_tridiag_cost_of(&good, 4, NULL), DDOF_ERROR_INVALID);
    assert_int_equal(ddof_tridiag_solve_f(NULL, a, b, c, x, x, NULL), DDOF_ERROR_INVALID);
    assert_int_equal(ddof_tridiag_solve_f(&good, NULL, b, c, x, x, NULL), DDOF_ERROR_INVALID);
    assert_int_equal(ddof_tridiag_solve_f(&good, a, NULL, c, x, x, NULL), DDOF_ERROR_INVALID);
    assert_int_equal(ddof_tridiag_solve_f(&good, a, b, NULL, x, x, NULL), DDOF_ERROR_INVALID);
    assert_int_equal(ddof_tridiag_solve_f(&good, a, b, c, NULL, x, NULL), DDOF_ERROR_INVALID);
    assert_int_equal(ddof_tridiag_solve_f(&good, a, b, c, x, NULL, NULL), DDOF_ERROR_INVALID);
    assert_int_equal(ddof_tridiag_diffuse_f(&good, NULL, b, x, x, NULL), DDOF_ERROR_INVALID);
    assert_true(x[0] == 1 && x[1] == 2 && x[2] == 3 && x[3] == 4);
    const ddof_tridiag none = batch_of(DDOF_TRIDIAG_CR, 0, 4, 1);
    assert_int_equal(ddof_tridiag_solve_f(&none, a, b, c, x, x, NULL), DDOF_OK);
}

typedef struct memory {
    int left, live;
    size_t bytes;
} memory;

static void *allocate(void *user, size_t bytes) {
    memory *m = user;
    if (m->left-- <= 0) return NULL;
    m->live++;
    m->bytes = bytes;
    return malloc(bytes);
}

static void release(void *user, void *block) {
    ((memory *)user)->live--;
    free(block);
}

/* The only allocation fails, or is released again; it holds what the cost says. malloc'ed blocks let the sanitizer see
 * overruns. */
static void test_memory(void **state) {
    (void)state;
    enum { N = 50 };
    float beta[N], x[N];
    for (int i = 0; i < DDOF_TRIDIAG_SOLVERS; i++)
        for (int left = 0; left <= 1; left++) {
            memory m = {left, 0, 0};
            ddof_tridiag batch = batch_of((ddof_tridiag_solver)i, 1, N, 1);
            ddof_tridiag_cost cost = {.steps = 7};
            batch.allocate = allocate;
            batch.release = release;
            batch.memory_user = &m;
            for (int k = 0; k < N; k++)
                beta[k] = 4, x[k] = (float)k;
            const ddof_status status = ddof_tridiag_diffuse_f(&batch, beta, NULL, x, x, &cost);
            assert_int_equal(status, left ? DDOF_OK : DDOF_ERROR_MEMORY);
            assert_int_equal(m.live, 0);
            assert_true(left ? cost.steps > 0 && m.bytes >= cost.bytes : cost.steps == 0 && x[7] == 7);
        }
}

/* Symmetric matrices whose rows sum to g: constants stay, the sum of g y is that of g x, y lies within the range of x.
 */
static void test_invariants(void **state) {
    (void)state;
    rng r = {5};
    for (int i = 0; i < DDOF_TRIDIAG_SOLVERS; i++)
        for (size_t n = 1; n <= 200; n++) {
            const bool packed = i == DDOF_TRIDIAG_CR_PACK || i == DDOF_TRIDIAG_CR4_PACK;
            problem p = problem_make(n % 2 ? SOFT : DIFFUSION_1E4, 1, n, 2, &r);
            for (size_t k = 0; k < n; k++)
                p.x[2 * k + 1] = 0.75; /* a half holds it */
            double *y = solve(&p, (ddof_tridiag_solver)i, 4, TIGHT, NULL), before = 0, after = 0, all = 0;
            for (size_t k = 0; k < n; k++) {
                assert_true(fabs(y[2 * k + 1] - 0.75) <= 1e-6);
                assert_true(y[2 * k] >= -1e-6 && y[2 * k] <= 1 + 1e-6);
                before += p.g[k] * p.x[2 * k];
                after += p.g[k] * y[2 * k];
                all += p.g[k];
            }
            assert_true(fabs(after - before) <= (packed ? 1e-3 : 2e-6) * all);
            free(y);
            problem_free(&p);
        }
}

/* Nothing but holes: zeros. And what is not finite stays in its system, and x of a hole is not used. */
static void test_holes_and_nan(void **state) {
    (void)state;
    enum { N = 37 };
    for (int i = 0; i < DDOF_TRIDIAG_SOLVERS; i++) {
        const ddof_tridiag batch = batch_of((ddof_tridiag_solver)i, 3, N, 1);
        double beta[3 * N], g[3 * N], x[3 * N], y[3 * N];
        for (int k = 0; k < 3 * N; k++) {
            beta[k] = 4;
            g[k] = k >= N && k % 5 != 0; /* the first line: holes */
            x[k] = g[k] != 0 ? 0.5 : NAN;
        }
        x[N + 1] = NAN;
        assert_int_equal(ddof_tridiag_diffuse_d(&batch, beta, g, x, y, NULL), DDOF_OK);
        for (int k = 0; k < N; k++) {
            assert_true(y[k] == 0);
            assert_true(isnan(y[N + k]));
            assert_true(fabs(y[2 * N + k] - 0.5) <= 1e-12);
        }
    }
}

/* Rows times a power of two: the same solution to the bit, from 2^-90 to 2^90. */
static void test_scale(void **state) {
    (void)state;
    enum { N = 45 };
    const float a = -3, b = 5, c = -1.5f;
    for (int i = 0; i < DDOF_TRIDIAG_SOLVERS; i++) {
        const ddof_tridiag batch = batch_of((ddof_tridiag_solver)i, 1, N, 1);
        float first[N];
        for (int e = 0; e <= 180; e += 90) {
            float k[3][N], x[N], y[N];
            for (int j = 0; j < N; j++) {
                const float scale = ldexpf(j % 3 ? 1 : 1.25f, e ? (e - 90 ? 90 : -90) : 0);
                k[0][j] = scale * a;
                k[1][j] = scale * b;
                k[2][j] = scale * c;
                x[j] = scale * (float)(j * 7 % 10);
            }
            assert_int_equal(ddof_tridiag_solve_f(&batch, k[0], k[1], k[2], x, y, NULL), DDOF_OK);
            if (e == 0) memcpy(first, y, sizeof y);
            assert_memory_equal(first, y, sizeof y);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_names),      cmocka_unit_test(test_published_counts),
        cmocka_unit_test(test_storage),    cmocka_unit_test(test_steps),
        cmocka_unit_test(test_wrong),      cmocka_unit_test(test_memory),
        cmocka_unit_test(test_invariants), cmocka_unit_test(test_holes_and_nan),
        cmocka_unit_test(test_scale),
    };
    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests_name("tridiag api", tests, NULL, NULL);
}
