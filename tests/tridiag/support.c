/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "support.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

const char *const kind_name[KINDS] = {
    [DOMINANT] = "dominant",
    [M_MATRIX] = "M-matrix",
    [DIFFUSION_200] = "diffusion, CoC 200",
    [DIFFUSION_1E4] = "diffusion, CoC 1e4",
    [DIFFUSION_1E5] = "diffusion, CoC 1e5",
    [WIDE] = "diffusion, CoC 1000 everywhere",
    [HOLES] = "holes",
    [SOFT] = "soft capacities",
    [CUT] = "cut off",
    [RAMP] = "ramp",
};

/* splitmix64 */
double rng_unit(rng *r) {
    uint64_t z = r->state += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return (double)((z ^ z >> 31) >> 40) * 0x1p-24;
}

/* ---- problems */

static double *numbers(size_t count) {
    double *p = calloc(count ? count : 1, sizeof *p);
    assert_non_null(p);
    return p;
}

static double coc(kind which, rng *r) {
    const double u = rng_unit(r);
    switch (which) {
    case DIFFUSION_200:
        return 200 * u;
    case DIFFUSION_1E4:
        return u < 0.02 ? 0 : u < 0.5 ? 1e4 : pow(10, 8 * u - 4);
    case DIFFUSION_1E5:
        return pow(10, 3 + 2 * u);
    case WIDE:
        return 1000;
    case HOLES:
        return 1 + 20 * u;
    case CUT:
        return u < 0.5 ? 0 : 30 * u;
    case RAMP:
        return 48;
    default:
        return 60 * u;
    }
}

static double capacity(kind which, rng *r) {
    const double u = rng_unit(r);
    if (which == HOLES || which == CUT) return u < 0.5;
    return which == SOFT ? u : 1;
}

static void fill_diffusion(problem *p, kind which, rng *r) {
    for (size_t i = 0; i < p->count * p->n; i++) {
        const double d = fmin(coc(which, r), which == RAMP ? 48 : coc(which, r));
        p->beta[i] = (float)(d * d);
        p->g[i] = (float)capacity(which, r);
        const bool first = i % p->n == 0, last = i % p->n == p->n - 1;
        p->a[i] = first ? 0 : -p->beta[i - 1];
        p->c[i] = last ? 0 : -p->beta[i];
        p->b[i] = p->g[i] - (p->a[i] + p->c[i]);
    }
}

static void fill_general(problem *p, kind which, rng *r) {
    for (size_t i = 0; i < p->count * p->n; i++) {
        const bool m = which == M_MATRIX;
        p->a[i] = m ? -100 * rng_unit(r) : 2 * rng_unit(r) - 1;
        p->c[i] = m ? -100 * rng_unit(r) : 2 * rng_unit(r) - 1;
        p->a[i] = (float)p->a[i];
        p->c[i] = (float)p->c[i];
        const double sum = fabs(p->a[i]) + fabs(p->c[i]), sign = !m && rng_unit(r) < 0.5 ? -1 : 1;
        p->b[i] = (float)(sign * (sum * (m ? 1.001 : 1.1) + 0.1));
    }
}

/* Textbook Thomas; where a pivot is 0, so is the unknown. */
static void oracle(problem *p) {
    long double *c = malloc(p->n * sizeof *c), *d = malloc(p->n * sizeof *d);
    assert_true(c && d);
    for (size_t k = 0; k < p->count * p->nrhs; k++) {
        const size_t base = k / p->nrhs * p->n, rhs = k % p->nrhs;
        for (size_t i = 0; i < p->n; i++) {
            const size_t at = base + i;
            const long double a = i > 0 ? p->a[at] : 0, above = i + 1 < p->n ? p->c[at] : 0;
            const long double x = (long double)p->x[at * p->nrhs + rhs] * (p->diffusion ? p->g[at] : 1);
            const long double b = p->diffusion ? p->g[at] - a - above : p->b[at]; /* b would be rounded in a double */
            const long double pivot = b - (i > 0 ? a * c[i - 1] : 0);
            c[i] = pivot != 0 ? above / pivot : 0;
            d[i] = pivot != 0 ? (x - (i > 0 ? a * d[i - 1] : 0)) / pivot : 0;
        }
        for (size_t i = p->n; i-- > 0;) {
            if (i + 1 < p->n) d[i] -= c[i] * d[i + 1];
            p->y[(base + i) * p->nrhs + rhs] = (double)d[i];
        }
    }
    free(c);
    free(d);
}

problem problem_make(kind which, size_t count, size_t n, size_t nrhs, rng *r) {
    const size_t rows = count * n;
    problem p = {count, n, nrhs, which > M_MATRIX, NULL, NULL, NULL, NULL, NULL, NULL, NULL, 1};
    p.a = numbers(rows);
    p.b = numbers(rows);
    p.c = numbers(rows);
    p.beta = numbers(rows);
    p.g = numbers(rows);
    p.x = numbers(rows * nrhs);
    p.y = numbers(rows * nrhs);
    if (p.diffusion)
        fill_diffusion(&p, which, r);
    else
        fill_general(&p, which, r);
    for (size_t i = 0; i < rows * nrhs; i++)
        p.x[i] = which == RAMP ? (float)((double)(i / nrhs % n + 1) / (double)n) : rng_unit(r);
    oracle(&p);
    for (size_t i = 0; i < rows * nrhs && !p.diffusion; i++)
        p.range = fmax(p.range, fabs(p.y[i]));
    return p;
}

void problem_free(problem *p) {
    double *all[] = {p->a, p->b, p->c, p->beta, p->g, p->x, p->y};
    for (size_t i = 0; i < COUNT(all); i++)
        free(all[i]);
}

/* ---- layouts */

/* A batch, and where its element (0, 0, 0) lies in arrays of `coefficients` and `values` numbers. */
typedef struct place {
    ddof_tridiag batch;
    size_t coefficient_first, coefficients, value_first, values;
} place;

static place place_of(const problem *p, ddof_tridiag_solver solver, layout how) {
    const ptrdiff_t n = (ptrdiff_t)p->n, nrhs = (ptrdiff_t)p->nrhs, count = (ptrdiff_t)p->count;
    const size_t rows = p->n * p->count, values = rows * p->nrhs;
    place l = {{.solver = solver, .count = p->count, .n = p->n, .nrhs = p->nrhs, .pcr_size = p->n % 3 * 8},
               0,
               rows,
               0,
               values};
    ddof_tridiag *b = &l.batch;
    switch (how) {
    case RGBA:
        b->row_stride = 2;
        b->x_row_stride = nrhs + 1;
        l.coefficients = 2 * rows;
        l.values = values + rows;
        break;
    case PLANAR:
        b->x_rhs_stride = n * count;
        b->x_row_stride = 1;
        b->x_system_stride = n;
        break;
    case COLUMNS:
        b->row_stride = count;
        b->system_stride = 1;
        b->x_row_stride = count * nrhs;
        b->x_system_stride = nrhs;
        break;
    case BACKWARD:
        b->row_stride = -1;
        b->system_stride = -n;
        b->x_rhs_stride = -1;
        b->x_row_stride = -nrhs;
        b->x_system_stride = -n * nrhs;
        l.coefficient_first = rows - 1;
        l.value_first = values - 1;
        break;
    default:
        break;
    }
    return l;
}

static size_t coefficient_at(const place *l, size_t s, size_t i) {
    const ddof_tridiag *b = &l->batch;
    const ptrdiff_t row = b->row_stride ? b->row_stride : 1;
    const ptrdiff_t system = b->system_stride ? b->system_stride : (ptrdiff_t)b->n * row;
    return (size_t)((ptrdiff_t)l->coefficient_first + (ptrdiff_t)s * system + (ptrdiff_t)i * row);
}

static size_t value_at(const place *l, size_t s, size_t i, size_t r) {
    const ddof_tridiag *b = &l->batch;
    const ptrdiff_t rhs = b->x_rhs_stride ? b->x_rhs_stride : 1;
    const ptrdiff_t row = b->x_row_stride ? b->x_row_stride : (ptrdiff_t)b->nrhs * rhs;
    const ptrdiff_t system = b->x_system_stride ? b->x_system_stride : (ptrdiff_t)b->n * row;
    return (size_t)((ptrdiff_t)l->value_first + (ptrdiff_t)s * system + (ptrdiff_t)i * row + (ptrdiff_t)r * rhs);
}

/* ---- one call in either number type */

typedef struct array {
    void *data;
    size_t number_size, count;
} array;

static const double UNTOUCHED = 12345; /* a float holds it exactly */

static void put(array *a, size_t i, double v) {
    assert_true(i < a->count);
    if (a->number_size == 4)
        ((float *)a->data)[i] = (float)v;
    else
        ((double *)a->data)[i] = v;
}

static double get(const array *a, size_t i) {
    return a->number_size == 4 ? (double)((const float *)a->data)[i] : ((const double *)a->data)[i];
}

static array array_make(size_t count, size_t number_size) {
    array a = {malloc(count * number_size), number_size, count};
    assert_non_null(a.data);
    for (size_t i = 0; i < count; i++)
        put(&a, i, UNTOUCHED);
    return a;
}

static array coefficients(const place *l, const double *from, size_t number_size) {
    array a = array_make(l->coefficients, number_size);
    for (size_t s = 0; s < l->batch.count; s++)
        for (size_t i = 0; i < l->batch.n; i++)
            put(&a, coefficient_at(l, s, i), from[s * l->batch.n + i]);
    return a;
}

static ddof_status call(const place *l, bool diffusion, const array k[3], const array *x, array *y,
                        ddof_tridiag_cost *cost) {
    const size_t c = l->coefficient_first, v = l->value_first;
    if (x->number_size == 4) {
        const float *a = (float *)k[0].data + c, *b = (float *)k[1].data + c;
        float *out = (float *)y->data + v;
        const float *in = (float *)x->data + v;
        return diffusion ? ddof_tridiag_diffuse_f(&l->batch, a, b, in, out, cost)
                         : ddof_tridiag_solve_f(&l->batch, a, b, (float *)k[2].data + c, in, out, cost);
    }
    const double *a = (double *)k[0].data + c, *b = (double *)k[1].data + c;
    double *out = (double *)y->data + v;
    const double *in = (double *)x->data + v;
    return diffusion ? ddof_tridiag_diffuse_d(&l->batch, a, b, in, out, cost)
                     : ddof_tridiag_solve_d(&l->batch, a, b, (double *)k[2].data + c, in, out, cost);
}

double *solve(const problem *p, ddof_tridiag_solver solver, size_t number_size, layout how, ddof_tridiag_cost *cost) {
    const place l = place_of(p, solver, how);
    const bool in_place = how == IN_PLACE || how == COLUMNS;
    array k[3] = {coefficients(&l, p->diffusion ? p->beta : p->a, number_size),
                  coefficients(&l, p->diffusion ? p->g : p->b, number_size), coefficients(&l, p->c, number_size)};
    array x = array_make(l.values, number_size), y = in_place ? x : array_make(l.values, number_size);
    double *result = numbers(p->count * p->n * p->nrhs);
    for (size_t e = 0; e < p->count * p->n * p->nrhs; e++)
        put(&x, value_at(&l, e / p->nrhs / p->n, e / p->nrhs % p->n, e % p->nrhs), p->x[e]);
    assert_int_equal(call(&l, p->diffusion, k, &x, &y, cost), DDOF_OK);
    for (size_t e = 0; e < p->count * p->n * p->nrhs; e++) {
        const size_t at = value_at(&l, e / p->nrhs / p->n, e / p->nrhs % p->n, e % p->nrhs);
        result[e] = get(&y, at);
        put(&y, at, UNTOUCHED);
    }
    for (size_t i = 0; i < l.values; i++)
        assert_true(get(&y, i) == UNTOUCHED);
    for (size_t i = 0; i < COUNT(k); i++)
        free(k[i].data);
    free(x.data);
    if (!in_place) free(y.data);
    return result;
}

double error_of(const problem *p, const double *y) {
    double worst = 0;
    for (size_t i = 0; i < p->count * p->n * p->nrhs; i++) {
        const double e = fabs(y[i] - p->y[i]);
        if (!(e <= worst)) worst = e;
        if (isnan(worst)) return NAN;
    }
    return worst / p->range;
}
