/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Every instruction set against the float64 reference, to the tolerance of support.h: 1e-5 of the range of the colours,
 * and more where a pixel reaches very far. */
#include "support.h"

#include <stdio.h>

typedef struct pair {
    ddof_context *fast, *reference;
} pair;

static pair pair_make(unsigned isa) {
    return (pair){context_of(isa, 1), reference_context()};
}

static void pair_destroy(pair *p) {
    DESTROY(p->fast);
    DESTROY(p->reference);
}

/* Renders the scene both ways and compares. */
static void check(const pair *p, const scene *s, const ddof_settings *settings, double aspect, const char *what) {
    const size_t n = (size_t)s->width * (size_t)s->height * 4;
    float *want = fenced(n * sizeof *want, true);
    ddof_frame frame = scene_frame(s);
    frame.pixel_aspect = aspect;
    render(p->fast, &frame, settings);
    frame.output = ddof_image_interleaved(want, s->width, s->height, 4, DDOF_FLOAT, 0);
    render(p->reference, &frame, settings);
    double tolerance = tolerance_of(s, settings, aspect) * magnitude(s->color, n);
    assert_close(s->output, want, n, tolerance, "%d x %d, %s, conductance %d, %d substeps, aspect %g", s->width,
                 s->height, what, settings->conductance, settings->substeps, aspect);
    fenced_free(want);
}

static const char *pattern_name(coc_pattern pattern) {
    static const char *const names[COC_PATTERNS] = {"sharp",     "small",       "random",      "smooth", "split",
                                                    "one sharp", "sharp lines", "alternating", "huge",   "beyond"};
    return names[pattern];
}

static void scene_check(const pair *p, int width, int height, coc_pattern coc, color_pattern color,
                        const ddof_settings *settings, double aspect, rng *r) {
    scene s = scene_fill(width, height, coc, color, r);
    check(p, &s, settings, aspect, pattern_name(coc));
    scene_free(&s);
}

static ddof_settings some_settings(rng *r) {
    return (ddof_settings){.conductance = rng_bits(r) & 1 ? DDOF_CONDUCTANCE_CLASSIC : DDOF_CONDUCTANCE_MATCHED,
                           .substeps = rng_range(r, 0, 3)};
}

/* Every width with every height. */
static void sizes(void **state) {
    static const double aspects[] = {0, 1, 2, 0.5, 1.4222};
    rng r = {1};
    pair p = pair_make(test_parameters(state).isa);
    for (int height = 1; height <= 67; height++)
        for (int width = 1; width <= 67; width++) {
            ddof_settings settings = some_settings(&r);
            scene_check(&p, width, height, (coc_pattern)rng_range(&r, 0, COC_PATTERNS - 1),
                        (color_pattern)rng_range(&r, 0, COLOR_PATTERNS - 1), &settings, aspects[rng_range(&r, 0, 4)],
                        &r);
        }
    pair_destroy(&p);
}

/* Every pattern of CoC with every pattern of colour and all settings. */
static void patterns(void **state) {
    rng r = {2};
    pair p = pair_make(test_parameters(state).isa);
    for (int coc = 0; coc < COC_PATTERNS; coc++)
        for (int color = 0; color < COLOR_PATTERNS; color++)
            for (int i = 0; i < 6; i++) {
                ddof_settings settings = {.conductance = i % 2 ? DDOF_CONDUCTANCE_CLASSIC : DDOF_CONDUCTANCE_MATCHED,
                                          .substeps = i / 2 + 1};
                scene_check(&p, 131, 37, (coc_pattern)coc, (color_pattern)color, &settings, 0, &r);
            }
    pair_destroy(&p);
}

/* Long lines, where rounding has the longest way to grow. */
static void long_lines(void **state) {
    static const int size[][2] = {{8192, 3}, {8191, 1}, {8185, 2}, {5003, 5},
                                  {3, 8192}, {1, 8191}, {2, 8185}, {5, 5003}};
    static const coc_pattern cocs[] = {COC_HUGE, COC_RANDOM, COC_SPLIT, COC_BEYOND};
    rng r = {3};
    pair p = pair_make(test_parameters(state).isa);
    for (int i = 0; i < COUNT(size); i++)
        for (int k = 0; k < COUNT(cocs); k++)
            for (int classic = 0; classic < 2; classic++) {
                ddof_settings settings = {.conductance = (ddof_conductance)classic, .substeps = rng_range(&r, 0, 3)};
                color_pattern color = (color_pattern)rng_range(&r, 0, COLOR_PATTERNS - 1);
                scene_check(&p, size[i][0], size[i][1], cocs[k], color, &settings, 0, &r);
            }
    pair_destroy(&p);
}

/* One CoC everywhere, of every magnitude: the error grows with the distance that a pixel reaches. */
static void magnitudes(void **state) {
    rng r = {4};
    pair p = pair_make(test_parameters(state).isa);
    for (double d = 0.01; d < 2e5; d *= 10)
        for (int i = 0; i < 2 * COLOR_PATTERNS; i++) {
            ddof_settings settings = {.conductance = (ddof_conductance)(i % 2)};
            scene s = scene_fill(i % 4 < 2 ? 4099 : 1, i % 4 < 2 ? 1 : 4099, COC_ZERO, (color_pattern)(i / 2), &r);
            char what[40];
            snprintf(what, sizeof what, "CoC %g", d);
            for (int k = 0; k < s.width * s.height; k++)
                s.coc[k] = (float)d;
            check(&p, &s, &settings, 0, what);
            scene_free(&s);
        }
    pair_destroy(&p);
}

/* Pictures of an ordinary size, random in everything. */
static void pictures(void **state) {
    rng r = {5};
    pair p = pair_make(test_parameters(state).isa);
    for (int i = 0; i < 12; i++) {
        ddof_settings settings = some_settings(&r);
        scene_check(&p, rng_range(&r, 68, 700), rng_range(&r, 68, 300), (coc_pattern)rng_range(&r, 0, COC_PATTERNS - 1),
                    (color_pattern)rng_range(&r, 0, COLOR_PATTERNS - 1), &settings, 0, &r);
    }
    pair_destroy(&p);
}

/* Full HD with CoC up to 1e4: 1e-5 of the range, whatever the reach. */
static void full_hd(void **state) {
    static const struct {
        coc_pattern coc;
        ddof_conductance conductance;
    } cases[] = {{COC_SMOOTH, DDOF_CONDUCTANCE_MATCHED},
                 {COC_SPLIT, DDOF_CONDUCTANCE_CLASSIC},
                 {COC_HUGE, DDOF_CONDUCTANCE_MATCHED}};
    rng r = {7};
    pair p = pair_make(test_parameters(state).isa);
    for (int i = 0; i < COUNT(cases); i++) {
        const ddof_settings settings = {.conductance = cases[i].conductance};
        scene s = scene_fill(1920, 1080, cases[i].coc, COLOR_RANDOM, &r);
        const size_t n = (size_t)s.width * (size_t)s.height * 4;
        float *want = fenced(n * sizeof *want, true);
        ddof_frame frame = scene_frame(&s);
        render(p.fast, &frame, &settings);
        frame.output = ddof_image_interleaved(want, s.width, s.height, 4, DDOF_FLOAT, 0);
        render(p.reference, &frame, &settings);
        assert_close(s.output, want, n, 1e-5, "%s", pattern_name(cases[i].coc));
        fenced_free(want);
        scene_free(&s);
    }
    pair_destroy(&p);
}

/* Beside lights of 1e6 dark pixels are right too: to 1e-4 of their own value and 1e-7 of the lights. Not to 1e-4 alone,
 * for what a light sends over a link of small conductance beta is rounded to 6e-8/beta of itself (1 - keep, in float).
 */
static void lights(void **state) {
    rng r = {6};
    pair p = pair_make(test_parameters(state).isa);
    for (int i = 0; i < 40; i++) {
        ddof_settings settings = {.conductance = (ddof_conductance)(i % 2)};
        scene s =
            scene_fill(rng_range(&r, 1, 400), rng_range(&r, 1, 200), (coc_pattern)(i % COC_BEYOND), COLOR_LIGHTS, &r);
        const size_t n = (size_t)s.width * (size_t)s.height * 4;
        float *want = fenced(n * sizeof *want, true);
        ddof_frame frame = scene_frame(&s);
        for (size_t v = 0; v < n; v++)
            if (s.color[v] == 1000) s.color[v] = v / 4 % 17 ? 0 : 1e6f;
        render(p.fast, &frame, &settings);
        frame.output = ddof_image_interleaved(want, s.width, s.height, 4, DDOF_FLOAT, 0);
        render(p.reference, &frame, &settings);
        for (size_t v = 0; v < n; v++)
            assert_close(&s.output[v], &want[v], 1, 1e-4 * want[v] + 1e-7 * 1e6, "%d x %d, %s", s.width, s.height,
                         pattern_name((coc_pattern)(i % COC_BEYOND)));
        fenced_free(want);
        scene_free(&s);
    }
    pair_destroy(&p);
}

int main(void) {
    static const test tests[] = {
        {"sizes 1..67 both ways", sizes, true, 0, 0},
        {"patterns of CoC and colour", patterns, true, 0, 0},
        {"lines of 8192", long_lines, true, 0, 0},
        {"magnitudes of CoC", magnitudes, true, 0, 0},
        {"pictures", pictures, true, 0, 0},
        {"dark pixels beside lights", lights, true, 0, 0},
        {"full HD", full_hd, true, 0, 0},
    };
    return run_library_tests("accuracy", tests, COUNT(tests));
}
