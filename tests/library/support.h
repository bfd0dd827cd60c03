/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* What the tests of the library share: random numbers with a seed, memory with traps around it, scenes that are hard to
 * blur, contexts, and comparisons. Only the public header of the library is used here. */
#ifndef TESTS_LIBRARY_SUPPORT_H
#define TESTS_LIBRARY_SUPPORT_H

/* cmocka.h wants these before it. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <ddof/ddof.h>

/* Of many cases every TEST_STEP-th: all of them, but where each takes ten times as long. */
#ifndef TEST_STEP
#define TEST_STEP 1
#endif

#define COUNT(array) ((int)(sizeof(array) / sizeof *(array)))

/* ---- tests */

/* What a test finds in *state. */
typedef struct test_case {
    unsigned isa; /* DDOF_CPU_*, of a test that is run for each; else 0, which stands for the best */
    int value;
} test_case;

typedef struct test {
    const char *name;
    CMUnitTestFunction run;
    bool per_isa; /* once for each instruction set; those this machine lacks are skipped and counted */
    int value;
    unsigned needs; /* DDOF_CPU_* without which it is skipped */
} test;

static inline test_case test_parameters(void **state) {
    return *(const test_case *)*state;
}

/* Runs them in order, in the Test Anything Protocol; the exit status of main(). */
int run_library_tests(const char *group, const test *tests, int count);

/* ---- random numbers */

typedef struct rng {
    uint64_t state;
} rng;

uint32_t rng_bits(rng *r);
double rng_unit(rng *r);                  /* [0, 1) */
int rng_range(rng *r, int low, int high); /* both included */

/* ---- memory */

/* `bytes` of memory next to a page that may not be touched: behind the last byte (at_end), or before the first one,
 * which is then aligned to 64 bytes. Filled with 0xa5. Freed by fenced_free(). */
void *fenced(size_t bytes, bool at_end);
void fenced_free(void *memory);

/* ---- scenes */

typedef enum coc_pattern {
    COC_ZERO,
    COC_SMALL,       /* random, up to 3 px: what most pixels have */
    COC_RANDOM,      /* either sign, 0.001 to 10000 px, evenly over the magnitudes */
    COC_SMOOTH,      /* a slope through 0 */
    COC_SPLIT,       /* sharp left of the middle, 10000 px right of it */
    COC_ONE_SHARP,   /* 10000 px but for one pixel */
    COC_SHARP_LINES, /* 10000 px but for a row and a column */
    COC_ALTERNATING, /* 0 and 10000 px */
    COC_HUGE,        /* 10000 px */
    COC_BEYOND,      /* 1e5 px and more: the library limits it to 1e5 */
    COC_PATTERNS
} coc_pattern;

typedef enum color_pattern {
    COLOR_RANDOM, /* 0..1 */
    COLOR_SIGNED, /* -1..1 */
    COLOR_RAMP,   /* 0..1 along both directions */
    COLOR_LIGHTS, /* dark, with a few pixels of 1000 */
    COLOR_PATTERNS
} color_pattern;

void fill_coc(float *coc, int width, int height, coc_pattern pattern, rng *r);
void fill_color(float *rgba, int width, int height, color_pattern pattern, rng *r);

/* RGBA float without gaps, a CoC for each pixel, and room for the result. */
typedef struct scene {
    int width, height;
    float *color, *coc, *output;
} scene;

scene scene_make(int width, int height, bool at_end); /* memory only */
scene scene_fill(int width, int height, coc_pattern coc, color_pattern color, rng *r);
void scene_free(scene *s);
ddof_frame scene_frame(const scene *s);

/* ---- contexts and calls */

/* A CPU context with this instruction set, 0: the best. */
ddof_context *context_of(unsigned isa, int threads);
ddof_context *reference_context(void);

/* ddof_render() / ddof_coc() that must succeed. */
ddof_stats render(ddof_context *ctx, const ddof_frame *frame, const ddof_settings *settings);
ddof_stats write_coc(ddof_context *ctx, const ddof_frame *frame, const ddof_settings *settings);

/* Destroys the context and nulls it. */
#define DESTROY(ctx) ddof_destroy(&(ctx))

/* ---- comparisons */

/* What float32 is allowed to be off in a blur of this scene, as a part of the range: 1e-5 while a pixel reaches no
 * farther than 400 pixels (|CoC| up to 2263, or 400 by the classic convention), beyond that in proportion to the reach.
 * Each substep rounds anew. */
double tolerance_of(const scene *s, const ddof_settings *settings, double aspect);

/* The largest difference of two arrays; NaN where exactly one is not finite. */
double worst_difference(const float *a, const float *b, size_t count);
/* The largest magnitude in it. */
double magnitude(const float *values, size_t count);
/* Fails with a sentence made by `format` where two arrays differ by more than `tolerance`. */
void assert_close(const float *got, const float *want, size_t count, double tolerance, const char *format, ...)
    __attribute__((format(printf, 5, 6)));
/* Fails where two arrays differ in a bit. */
void assert_same_bits(const float *got, const float *want, size_t count, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

#endif
