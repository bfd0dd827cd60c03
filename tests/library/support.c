/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#define _GNU_SOURCE /* MAP_ANONYMOUS */
#include "support.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#if defined(__unix__) || defined(__APPLE__)
#include <sys/mman.h>
#include <unistd.h>
#endif

/* ---- tests */

typedef struct instruction_set {
    const char *name;
    unsigned flag;
} instruction_set;

static const instruction_set isas[] = {
#if defined(__aarch64__)
    {"neon", DDOF_CPU_NEON},
#else
    {"baseline", DDOF_CPU_BASELINE},
#endif
#if defined(__x86_64__)
    {"avx2", DDOF_CPU_AVX2},
    {"avx512", DDOF_CPU_AVX512},
#endif
};

static void not_here(void **state) {
    (void)state;
}

int run_library_tests(const char *group, const test *tests, int count) {
    enum { MOST = 128, NAME = 160 };
    static struct CMUnitTest units[MOST];
    static test_case cases[MOST];
    static char names[MOST][NAME];
    size_t n = 0;
    for (int i = 0; i < count; i++)
        for (int k = 0; k < (tests[i].per_isa ? COUNT(isas) : 1); k++, n++) {
            const unsigned flag = tests[i].per_isa ? isas[k].flag : tests[i].needs;
            const bool here = (ddof_cpu_available() & flag) == flag;
            if (n == MOST) return 1;
            cases[n] = (test_case){flag, tests[i].value};
            snprintf(names[n], NAME, "%s%s%s%s", tests[i].name, tests[i].per_isa ? ", " : "",
                     tests[i].per_isa ? isas[k].name : "", here ? "" : " # SKIP this machine has no such instructions");
            units[n] = (struct CMUnitTest){names[n], here ? tests[i].run : not_here, NULL, NULL, &cases[n]};
        }
    cmocka_set_message_output(CM_OUTPUT_TAP);
    return _cmocka_run_group_tests(group, units, n, NULL, NULL);
}

/* ---- random numbers: splitmix64 */

uint32_t rng_bits(rng *r) {
    uint64_t z = r->state += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return (uint32_t)(z >> 32);
}

double rng_unit(rng *r) {
    return rng_bits(r) / 4294967296.0;
}

int rng_range(rng *r, int low, int high) {
    return low + (int)(rng_bits(r) % (uint32_t)(high - low + 1));
}

/* ---- memory */

#if defined(__unix__) || defined(__APPLE__)
enum { MOST_FENCED = 64 };
static struct {
    void *memory, *map;
    size_t bytes;
} fences[MOST_FENCED];

void *fenced(size_t bytes, bool at_end) {
    const size_t page = (size_t)sysconf(_SC_PAGESIZE), used = (bytes + page - 1) / page * page;
    int slot = 0;
    while (slot < MOST_FENCED && fences[slot].memory)
        slot++;
    assert_true(slot < MOST_FENCED);
    char *map = mmap(NULL, used + 2 * page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    assert_true(map != MAP_FAILED);
    assert_int_equal(mprotect(map, page, PROT_NONE), 0);
    assert_int_equal(mprotect(map + page + used, page, PROT_NONE), 0);
    fences[slot].map = map;
    fences[slot].bytes = used + 2 * page;
    fences[slot].memory = at_end ? map + page + used - bytes : map + page;
    return memset(fences[slot].memory, 0xa5, bytes);
}

void fenced_free(void *memory) {
    for (int i = 0; memory && i < MOST_FENCED; i++)
        if (fences[i].memory == memory) {
            munmap(fences[i].map, fences[i].bytes);
            fences[i].memory = NULL;
        }
}
#else
void *fenced(size_t bytes, bool at_end) {
    char *whole = malloc(bytes + 128);
    assert_non_null(whole);
    (void)at_end;
    char *memory = whole + 64 + (64 - (uintptr_t)whole % 64);
    memory[-1] = (char)(memory - whole);
    return memset(memory, 0xa5, bytes);
}

void fenced_free(void *memory) {
    if (memory) free((char *)memory - ((unsigned char *)memory)[-1]);
}
#endif

/* ---- scenes */

static float coc_at(coc_pattern pattern, int x, int y, int width, int height, const int sharp[2], rng *r) {
    const bool column = x == sharp[0], row = y == sharp[1];
    switch (pattern) {
    case COC_SMALL:
        return (float)(6 * rng_unit(r) - 3);
    case COC_RANDOM:
        return (float)((rng_bits(r) & 1 ? 1 : -1) * pow(10, 7 * rng_unit(r) - 3));
    case COC_SMOOTH:
        return (float)(60.0 * (x + 0.5) / width - 30 + 20.0 * y / height);
    case COC_SPLIT:
        return x < width / 2 ? 0.0f : 1e4f;
    case COC_ONE_SHARP:
        return row && column ? 0.0f : -1e4f;
    case COC_SHARP_LINES:
        return row || column ? 0.0f : 1e4f;
    case COC_ALTERNATING:
        return (x + y) % 2 ? 1e4f : 0.0f;
    case COC_HUGE:
        return 1e4f;
    case COC_BEYOND:
        return (float)pow(10, 5 + (rng_bits(r) % 16 == 0 ? 30 : 1) * rng_unit(r));
    default:
        return 0;
    }
}

void fill_coc(float *coc, int width, int height, coc_pattern pattern, rng *r) {
    const int sharp[2] = {rng_range(r, 0, width - 1), rng_range(r, 0, height - 1)};
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++)
            coc[(ptrdiff_t)y * width + x] = coc_at(pattern, x, y, width, height, sharp, r);
}

void fill_color(float *rgba, int width, int height, color_pattern pattern, rng *r) {
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++)
            for (int c = 0; c < 4; c++) {
                double v = rng_unit(r);
                if (pattern == COLOR_SIGNED) v = 2 * v - 1;
                if (pattern == COLOR_RAMP) v = (x + 1.0) / width / (c + 1) + (y + 1.0) / height * c / (c + 1);
                if (pattern == COLOR_LIGHTS) v = v < 0.02 ? 1000 : v * 0.1;
                rgba[((ptrdiff_t)y * width + x) * 4 + c] = (float)v;
            }
}

scene scene_make(int width, int height, bool at_end) {
    const size_t n = (size_t)width * (size_t)height * sizeof(float);
    return (scene){width, height, fenced(4 * n, at_end), fenced(n, at_end), fenced(4 * n, at_end)};
}

scene scene_fill(int width, int height, coc_pattern coc, color_pattern color, rng *r) {
    scene s = scene_make(width, height, rng_bits(r) & 1);
    fill_coc(s.coc, width, height, coc, r);
    fill_color(s.color, width, height, color, r);
    return s;
}

void scene_free(scene *s) {
    fenced_free(s->color);
    fenced_free(s->coc);
    fenced_free(s->output);
    *s = (scene){0};
}

ddof_frame scene_frame(const scene *s) {
    return (ddof_frame){.color = ddof_image_interleaved(s->color, s->width, s->height, 4, DDOF_FLOAT, 0),
                        .coc = ddof_image_interleaved(s->coc, s->width, s->height, 1, DDOF_FLOAT, 0),
                        .output = ddof_image_interleaved(s->output, s->width, s->height, 4, DDOF_FLOAT, 0)};
}

/* ---- contexts and calls */

ddof_context *context_of(unsigned isa, int threads) {
    ddof_config config = {.backend = DDOF_BACKEND_CPU, .cpu_mask = isa, .threads = threads};
    ddof_context *ctx = NULL;
    assert_int_equal(ddof_create(&ctx, &config), DDOF_OK);
    assert_non_null(ctx);
    return ctx;
}

ddof_context *reference_context(void) {
    ddof_config config = {.backend = DDOF_BACKEND_REFERENCE};
    ddof_context *ctx = NULL;
    assert_int_equal(ddof_create(&ctx, &config), DDOF_OK);
    return ctx;
}

ddof_stats render(ddof_context *ctx, const ddof_frame *frame, const ddof_settings *settings) {
    ddof_stats stats;
    memset(&stats, 0xff, sizeof stats);
    ddof_status status = ddof_render(ctx, frame, settings, &stats);
    if (status != DDOF_OK) fail_msg("ddof_render: %s: %s", ddof_status_text(status), ddof_error(ctx));
    assert_string_equal(ddof_error(ctx), "");
    return stats;
}

ddof_stats write_coc(ddof_context *ctx, const ddof_frame *frame, const ddof_settings *settings) {
    ddof_stats stats;
    memset(&stats, 0xff, sizeof stats);
    ddof_status status = ddof_coc(ctx, frame, settings, &stats);
    if (status != DDOF_OK) fail_msg("ddof_coc: %s: %s", ddof_status_text(status), ddof_error(ctx));
    return stats;
}

/* ---- comparisons */

double tolerance_of(const scene *s, const ddof_settings *settings, double aspect) {
    const int substeps = settings->substeps > 0 ? settings->substeps : 1;
    const double scale = settings->conductance == DDOF_CONDUCTANCE_CLASSIC ? 1 : 1.0 / 32;
    double largest = 0;
    for (size_t i = 0; i < (size_t)s->width * (size_t)s->height; i++)
        if (isfinite(s->coc[i])) largest = fmax(largest, fabs(s->coc[i]));
    double along = sqrt(scale / substeps) * fmin(largest, 1e5), down = along * (aspect > 0 ? aspect : 1);
    return fmax(1e-5, 2.5e-8 * substeps * fmax(fmin(s->width, along), fmin(s->height, down)));
}

double worst_difference(const float *a, const float *b, size_t count) {
    double worst = 0;
    for (size_t i = 0; i < count; i++) {
        if (!isfinite(a[i]) && !isfinite(b[i])) continue;
        double d = fabs((double)a[i] - b[i]);
        if (!(d <= worst)) worst = d;
        if (isnan(worst)) return NAN;
    }
    return worst;
}

double magnitude(const float *values, size_t count) {
    double most = 0;
    for (size_t i = 0; i < count; i++)
        if (fabsf(values[i]) > most) most = fabsf(values[i]);
    return most;
}

void assert_close(const float *got, const float *want, size_t count, double tolerance, const char *format, ...) {
    char what[512];
    va_list args;
    va_start(args, format);
    vsnprintf(what, sizeof what, format, args);
    va_end(args);
    for (size_t i = 0; i < count; i++)
        if (!(fabs((double)got[i] - want[i]) <= tolerance))
            fail_msg("%s: value %zu is %.9g, not %.9g; the largest difference is %.3g, allowed %.3g", what, i, got[i],
                     want[i], worst_difference(got, want, count), tolerance);
}

void assert_same_bits(const float *got, const float *want, size_t count, const char *format, ...) {
    char what[512];
    va_list args;
    va_start(args, format);
    vsnprintf(what, sizeof what, format, args);
    va_end(args);
    for (size_t i = 0; i < count; i++)
        if (memcmp(&got[i], &want[i], sizeof *got))
            fail_msg("%s: value %zu is %.9g, not %.9g", what, i, got[i], want[i]);
}
