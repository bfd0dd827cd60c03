/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The same systems solved by LAPACK: bench/lapack [WIDTH HEIGHT [DIAMETER [RUNS]]], one thread.
 *
 * One repetition is a picture: HEIGHT systems of length WIDTH and WIDTH systems of length HEIGHT, four right-hand sides each, the
 * matrix 1 + diffusion with beta = min(d_i, d_i+1)^2/32. LAPACK gets the layout that suits it best, every right-hand side
 * contiguous and the column systems already transposed, and its transposes are not timed; ddof gets the interleaved
 * picture as it is. A memcpy of that picture is timed in between, and everything is printed as a ratio to it. */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <ddof/ddof.h>

/* LAPACK, Fortran interface: symmetric positive definite, and general tridiagonal systems. */
extern void sptsv_(const int *n, const int *nrhs, float *d, float *e, float *b, const int *ldb, int *info);
extern void sgtsv_(const int *n, const int *nrhs, float *dl, float *d, float *du, float *b, const int *ldb, int *info);

enum { CHANNELS = 4 };

typedef struct picture {
    int width, height, runs;
    float *coc, *coc_columns;    /* rows, and columns as rows */
    float *rows, *columns;       /* right-hand sides, [system][channel][pixel] */
    float *pixels, *result;      /* interleaved */
    float *d, *lower, *upper;    /* one matrix */
    ddof_context *context;
} picture;

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec * 1e3 + (double)t.tv_nsec * 1e-6;
}

static float *floats(size_t count) {
    float *p = aligned_alloc(64, (count * sizeof *p + 63) / 64 * 64);
    if (!p) {
        fputs("lapack: out of memory\n", stderr);
        exit(1);
    }
    return memset(p, 0, count * sizeof *p);
}

static void matrix(const picture *p, const float *coc, int n) {
    float before = 0;
    for (int i = 0; i < n; i++) {
        float m = i + 1 < n ? fminf(fabsf(coc[i]), fabsf(coc[i + 1])) : 0, beta = m * m / 32;
        p->lower[i] = p->upper[i] = -beta;
        p->d[i] = 1 + before + beta;
        before = beta;
    }
}

static void solve(const picture *p, bool general, const float *coc, float *b, int n, int systems) {
    const int nrhs = CHANNELS;
    for (int s = 0; s < systems; s++) {
        int info;
        float *x = b + (size_t)s * CHANNELS * (size_t)n;
        matrix(p, coc + (size_t)s * (size_t)n, n);
        if (general)
            sgtsv_(&n, &nrhs, p->lower, p->d, p->upper, x, &n, &info);
        else
            sptsv_(&n, &nrhs, p->d, p->upper, x, &n, &info);
        if (info) fprintf(stderr, "lapack: info %d\n", info);
    }
}

static void run_lapack(picture *p, bool general) {
    solve(p, general, p->coc, p->rows, p->width, p->height);
    solve(p, general, p->coc_columns, p->columns, p->height, p->width);
}
static void run_sptsv(picture *p) {
    run_lapack(p, false);
}
static void run_sgtsv(picture *p) {
    run_lapack(p, true);
}
static void run_ddof(picture *p) {
    const ddof_frame frame = {
        .color = ddof_image_interleaved(p->pixels, p->width, p->height, CHANNELS, DDOF_FLOAT, 0),
        .coc = ddof_image_interleaved(p->coc, p->width, p->height, 1, DDOF_FLOAT, 0),
        .output = ddof_image_interleaved(p->result, p->width, p->height, CHANNELS, DDOF_FLOAT, 0),
    };
    const ddof_settings settings = {0};
    if (ddof_render(p->context, &frame, &settings, NULL) != DDOF_OK) puts(ddof_error(p->context));
}
static void run_memcpy(picture *p) {
    memcpy(p->result, p->pixels, (size_t)p->width * (size_t)p->height * CHANNELS * sizeof(float));
    __asm__ volatile("" ::"r"(p->result) : "memory");
}

static int compare(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

static double median(picture *p, void (*run)(picture *)) {
    double t[99];
    run(p);
    for (int i = 0; i < p->runs; i++) {
        double start = now();
        run(p);
        t[i] = now() - start;
    }
    qsort(t, (size_t)p->runs, sizeof *t, compare);
    return t[p->runs / 2];
}

static void fill(picture *p, float diameter) {
    unsigned seed = 1;
    const size_t n = (size_t)p->width * (size_t)p->height;
    for (int y = 0; y < p->height; y++)
        for (int x = 0; x < p->width; x++) {
            float u = (float)x / (float)p->width, v = (float)y / (float)p->height;
            float d = diameter * (0.55f + 0.45f * sinf(6.2832f * (u + 0.5f * v)));
            p->coc[(size_t)y * (size_t)p->width + (size_t)x] = d;
            p->coc_columns[(size_t)x * (size_t)p->height + (size_t)y] = d;
        }
    for (size_t i = 0; i < n * CHANNELS; i++) {
        seed = seed * 1664525u + 1013904223u;
        p->pixels[i] = p->rows[i] = p->columns[i] = (float)(seed >> 8) / 16777216.0f;
    }
}

int main(int argc, char **argv) {
    picture p = {.width = argc > 2 ? atoi(argv[1]) : 1920, .height = argc > 2 ? atoi(argv[2]) : 1080};
    p.runs = argc > 4 ? atoi(argv[4]) : 9;
    if (p.width < 1 || p.height < 1 || p.runs < 1 || p.runs > 99) {
        fputs("usage: lapack [WIDTH HEIGHT [DIAMETER [RUNS]]]\n", stderr);
        return 2;
    }
    const size_t n = (size_t)p.width * (size_t)p.height, line = (size_t)(p.width > p.height ? p.width : p.height);
    p.coc = floats(n), p.coc_columns = floats(n);
    p.rows = floats(n * CHANNELS), p.columns = floats(n * CHANNELS);
    p.pixels = floats(n * CHANNELS), p.result = floats(n * CHANNELS);
    p.d = floats(line), p.lower = floats(line), p.upper = floats(line);
    const ddof_config config = {.threads = 1};
    if (ddof_create(&p.context, &config) != DDOF_OK) return 1;
    fill(&p, argc > 3 ? (float)atof(argv[3]) : 48);

    double copy = median(&p, run_memcpy), ours = median(&p, run_ddof);
    double general = median(&p, run_sgtsv), symmetric = median(&p, run_sptsv);
    printf("%d x %d RGBA float, one thread, medians of %d\n", p.width, p.height, p.runs);
    printf("%-28s %9.2f ms %7.2f x memcpy\n", "memcpy of the picture", copy, 1.0);
    printf("%-28s %9.2f ms %7.2f x memcpy\n", "ddof", ours, ours / copy);
    printf("%-28s %9.2f ms %7.2f x memcpy\n", "LAPACK sptsv", symmetric, symmetric / copy);
    printf("%-28s %9.2f ms %7.2f x memcpy\n", "LAPACK sgtsv", general, general / copy);
    ddof_destroy(&p.context);
    float *all[] = {p.coc, p.coc_columns, p.rows, p.columns, p.pixels, p.result, p.d, p.lower, p.upper};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) free(all[i]);
    return 0;
}
