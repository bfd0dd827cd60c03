/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "disc_support.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846

const ddof_quality disc_qualities[3] = {DDOF_QUALITY_DRAFT, DDOF_QUALITY_GOOD, DDOF_QUALITY_BEST};
const char *const disc_quality_names[] = {
    [DDOF_QUALITY_DRAFT] = "draft", [DDOF_QUALITY_GOOD] = "good", [DDOF_QUALITY_BEST] = "best"};

/* ---- backends */

static const disc_backend backends[] = {
    {DDOF_BACKEND_REFERENCE, "reference", 2e-7}, /* its output is float */
    {DDOF_BACKEND_CPU, "cpu", 2e-5},
    {DDOF_BACKEND_GL, "gl", 2e-3},
    {DDOF_BACKEND_VULKAN, "vulkan", 2e-4},
};

ddof_settings disc_settings(ddof_quality quality) {
    return (ddof_settings){.kernel = DDOF_KERNEL_DISC, .quality = quality, .surface = DDOF_SURFACE_RGBA32F};
}

static ddof_context *open_backend(const disc_backend *b) {
    ddof_config config = {.backend = b->id, .threads = 2};
    ddof_context *ctx = NULL;
    float color = 1, coc = 1, output;
    ddof_frame frame = {.color = ddof_image_interleaved(&color, 1, 1, 1, DDOF_FLOAT, 0),
                        .coc = ddof_image_interleaved(&coc, 1, 1, 1, DDOF_FLOAT, 0),
                        .output = ddof_image_interleaved(&output, 1, 1, 1, DDOF_FLOAT, 0)};
    const ddof_settings settings = disc_settings(DDOF_QUALITY_GOOD);
    if (ddof_create(&ctx, &config) == DDOF_OK && ddof_render(ctx, &frame, &settings, NULL) == DDOF_ERROR_UNSUPPORTED)
        ddof_destroy(&ctx);
    return ctx;
}

typedef struct entry {
    disc_case about;
    void (*run)(const disc_case *c);
} entry;

static void run_entry(void **state) {
    const entry *e = *state;
    if (e->about.context) e->run(&e->about);
}

int run_disc_tests(const char *group, const disc_test *tests, int count) {
    enum { MOST = 160, NAME = 160 };
    static struct CMUnitTest units[MOST];
    static entry entries[MOST];
    static char names[MOST][NAME];
    ddof_context *context[COUNT(backends)];
    size_t n = 0;
    for (int b = 0; b < COUNT(backends); b++) {
        context[b] = open_backend(&backends[b]);
        for (int i = 0; i < count; i++, n++) {
            if (n == MOST) return 1;
            entries[n] = (entry){{&backends[b], context[b]}, tests[i].run};
            snprintf(names[n], NAME, "%s, %s%s", tests[i].name, backends[b].name,
                     context[b] ? "" : " # SKIP no such backend here, or it has no disc kernel");
            units[n] = (struct CMUnitTest){names[n], run_entry, NULL, NULL, &entries[n]};
        }
    }
    cmocka_set_message_output(CM_OUTPUT_TAP);
    const int failed = _cmocka_run_group_tests(group, units, n, NULL, NULL);
    for (int b = 0; b < COUNT(backends); b++)
        DESTROY(context[b]);
    return failed;
}

/* ---- pictures */

disc_picture disc_picture_make(int width, int height, double coc) {
    const size_t n = (size_t)width * (size_t)height;
    disc_picture p = {width, height, calloc(n, sizeof(float)), calloc(n, sizeof(float)), calloc(n, sizeof(float))};
    for (size_t i = 0; i < n; i++)
        p.coc[i] = (float)coc;
    return p;
}

void disc_picture_free(disc_picture *p) {
    free(p->color);
    free(p->coc);
    free(p->output);
    *p = (disc_picture){0};
}

void disc_picture_render(const disc_case *c, const disc_picture *p, ddof_quality quality, double aspect) {
    const ddof_settings settings = disc_settings(quality);
    const ddof_frame frame = {.color = ddof_image_interleaved(p->color, p->width, p->height, 1, DDOF_FLOAT, 0),
                              .coc = ddof_image_interleaved(p->coc, p->width, p->height, 1, DDOF_FLOAT, 0),
                              .output = ddof_image_interleaved(p->output, p->width, p->height, 1, DDOF_FLOAT, 0),
                              .pixel_aspect = aspect};
    render(c->context, &frame, &settings);
}

float *disc_picture_middle(float *values, const disc_picture *p) {
    return values + (ptrdiff_t)(p->height / 2) * p->width + p->width / 2;
}

/* ---- figures */

/* Square planes of `side` values, odd; the middle is (reach, reach). */
typedef struct plane {
    int reach, side;
    double *value;
} plane;

static plane plane_make(int reach) {
    const int side = 2 * reach + 1;
    return (plane){reach, side, calloc((size_t)side * (size_t)side, sizeof(double))};
}

/* The disc by the area it covers of each pixel, as bench/disc/fit.py has it. */
static plane even_disc(double d, int reach) {
    enum { PARTS = 16 };
    plane p = plane_make(reach);
    double sum = 0;
    for (int i = 0; i < p.side * p.side; i++) {
        const int x = i % p.side - reach, y = i / p.side - reach;
        for (int a = 0; a < PARTS * PARTS && hypot(x, y) < d / 2 + 1; a++) {
            const double u = x + (a % PARTS + 0.5) / PARTS - 0.5, v = y + (a / PARTS + 0.5) / PARTS - 0.5;
            p.value[i] += u * u + v * v <= d * d / 4;
        }
        sum += p.value[i];
    }
    for (int i = 0; i < p.side * p.side; i++)
        p.value[i] /= sum;
    return p;
}

/* Rows, then columns, convolved with a Gaussian, periodic; exact in the spectrum, since sigma may be below a pixel. */
static void soften(plane *p, double sigma) {
    const int n = p->side;
    double *tap = calloc((size_t)n, sizeof *tap), *line = calloc((size_t)n, sizeof *line);
    for (int r = 0; r < n; r++) {
        for (int k = 0; k < n; k++) {
            const int f = k <= p->reach ? k : k - n;
            const double w = 2 * PI * f / n;
            tap[r] += cos(w * r) * exp(-w * w * sigma * sigma / 2) / n;
        }
        if (fabs(tap[r]) < 1e-14) tap[r] = 0;
    }
    for (int pass = 0; pass < 2; pass++)
        for (int l = 0; l < n; l++) {
            const size_t first = (size_t)l * (pass ? 1 : (size_t)n), stride = pass ? (size_t)n : 1;
            memset(line, 0, (size_t)n * sizeof *line);
            for (int r = 0; r < n; r++)
                for (int i = 0; i < n && tap[r] != 0; i++)
                    line[i] += tap[r] * p->value[first + stride * (size_t)(i + r < n ? i + r : i + r - n)];
            for (int i = 0; i < n; i++)
                p->value[first + stride * (size_t)i] = line[i];
        }
    free(tap);
    free(line);
}

/* Keys' cubic. */
static double cubic(double a, double b, double c, double d, double t) {
    return b + t / 2 * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)));
}

static double between(const plane *p, double x, double y) {
    const int i = (int)floor(x), j = (int)floor(y);
    double row[4];
    for (int k = 0; k < 4; k++) {
        const double *v = p->value + (size_t)(j + k - 1 + p->reach) * (size_t)p->side + i - 1 + p->reach;
        row[k] = cubic(v[0], v[1], v[2], v[3], x - i);
    }
    return cubic(row[0], row[1], row[2], row[3], y - j);
}

/* The outermost radius at half of the highest value, in a direction. */
static double radius(const plane *p, double angle, double half) {
    const double step = 0.02;
    double r = p->reach * 0.9;
    while (r > 0 && between(p, r * cos(angle), r * sin(angle)) < half)
        r -= step;
    const double inner = between(p, r * cos(angle), r * sin(angle)),
                 outer = between(p, (r + step) * cos(angle), (r + step) * sin(angle));
    return r + step * (inner - half) / (inner - outer);
}

static void measure_softened(plane *kernel, double d, disc_figures *f) {
    plane disc = even_disc(d, kernel->reach);
    double difference = 0, norm = 0, low = 0, high = 0, least = INFINITY, most = 0;
    soften(kernel, 0.045 * d);
    soften(&disc, 0.045 * d);
    for (int i = 0; i < kernel->side * kernel->side; i++) {
        difference += pow(kernel->value[i] - disc.value[i], 2);
        norm += pow(disc.value[i], 2);
        low = fmin(low, kernel->value[i]);
        high = fmax(high, kernel->value[i]);
    }
    for (int k = 0; k < 16; k++) {
        const double r = radius(kernel, PI / 4 * k / 15, high / 2);
        least = fmin(least, r);
        most = fmax(most, r);
    }
    f->l2 = sqrt(difference / norm);
    f->lobe = -low / high;
    f->isotropy = least / most;
    free(disc.value);
}

disc_figures disc_measure(const disc_case *c, ddof_quality quality, double d) {
    const double even = 4 / (PI * d * d);
    plane kernel = plane_make((int)fmax(2.5 * d, 20));
    disc_picture p = disc_picture_make(kernel.side, kernel.side, d);
    disc_figures f = {.least = INFINITY, .greatest = -INFINITY};
    *disc_picture_middle(p.color, &p) = 1;
    disc_picture_render(c, &p, quality, 0);
    for (int i = 0; i < kernel.side * kernel.side; i++) {
        const double v = p.output[i], x = i % kernel.side - kernel.reach, y = i / kernel.side - kernel.reach;
        kernel.value[i] = v;
        f.sum += v;
        f.variance_x += v * x * x;
        f.variance_y += v * y * y;
        f.least = fmin(f.least, v / even);
        f.greatest = fmax(f.greatest, v / even);
    }
    f.centre = *disc_picture_middle(p.output, &p) / even;
    measure_softened(&kernel, d, &f);
    disc_picture_free(&p);
    free(kernel.value);
    return f;
}
