/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Sprites against the oracle, which draws them in double, each at every pixel: of highlights, whose rest the library itself blurs
 * without them, and of every pixel. Cases count through every iris, level, resolution, arrangement of channels. */
#include "bokeh_oracle.h"
#include "support.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- irises */

enum { IMAGE_WIDE = 9, IMAGE_TALL = 14 };

typedef struct shape {
    const char *name;
    ddof_iris iris;
    double aspect;
} shape;

static const shape shapes[] = {
    {"disc", {0}, 1},
    {"triangle", {.shape = DDOF_IRIS_POLYGON, .blades = 3}, 1},
    {"triangle, turned, half curved", {.shape = DDOF_IRIS_POLYGON, .blades = 3, .rotation = 100, .curvature = 0.5}, 1},
    {"pentagon, turned", {.shape = DDOF_IRIS_POLYGON, .blades = 5, .rotation = -17}, 1},
    {"hexagon, wide pixels", {.shape = DDOF_IRIS_POLYGON, .blades = 6}, 2},
    {"hexagon, curved", {.shape = DDOF_IRIS_POLYGON, .blades = 6, .curvature = 1}, 1},
    {"64 blades", {.shape = DDOF_IRIS_POLYGON, .blades = 64, .rotation = 3600}, 1},
    {"image", {.shape = DDOF_IRIS_IMAGE}, 1},
    {"image, turned by 45 degrees", {.shape = DDOF_IRIS_IMAGE, .rotation = 45}, 1},
    {"image, cat's eye, tall pixels", {.shape = DDOF_IRIS_IMAGE, .rotation = -120, .cats_eye = 0.7}, 0.5},
    {"bright rim", {.edge = 1}, 1},
    {"bright middle, pentagon", {.shape = DDOF_IRIS_POLYGON, .blades = 5, .edge = -0.6}, 1},
    {"cat's eye", {.cats_eye = 1}, 1},
    {"cat's eye, wide pixels, hexagon", {.shape = DDOF_IRIS_POLYGON, .blades = 6, .cats_eye = 0.5, .rotation = 10}, 2},
    {"squeezed", {.squeeze = 2}, 1},
    {"squeezed, turned triangle, tall pixels", {.shape = DDOF_IRIS_POLYGON, .blades = 3, .squeeze = 1.33, .rotation = 30}, 0.5},
    {"fringe", {.fringe = 0.2}, 1},
    {"fringe the other way, edge, pentagon", {.shape = DDOF_IRIS_POLYGON, .blades = 5, .fringe = -0.5, .edge = 0.4}, 1},
    {"all of it", {.shape = DDOF_IRIS_POLYGON, .blades = 7, .rotation = 33, .curvature = 0.3, .edge = 0.5, .cats_eye = 0.4, .squeeze = 1.5, .fringe = 0.1}, 1.5},
};

/* Dark, bright, and what counts as 0. */
static const float *image_values(void) {
    static float values[IMAGE_WIDE * IMAGE_TALL];
    for (int i = 0; i < COUNT(values); i++) values[i] = i % 11 == 3 ? -1 : i % 17 == 5 ? NAN : 1e4f * (float)(i * 7 % 13);
    return values;
}

static ddof_iris iris_of(const shape *s) {
    ddof_iris iris = s->iris;
    if (s->iris.shape == DDOF_IRIS_IMAGE) iris.image = ddof_image_interleaved((void *)(uintptr_t)image_values(), IMAGE_WIDE, IMAGE_TALL, 1, DDOF_FLOAT, 0);
    return iris;
}

/* ---- scenes */

/* Any CoC of either sign from `least` to `most`, evenly over the magnitudes, that is surely next to its node. */
static float some_coc(rng *r, double least, double most, double fringe) {
    double d;
    do d = least * pow(most / least, rng_unit(r));
    while (bokeh_oracle_between_nodes((double)(float)d, fringe));
    return (float)(rng_bits(r) & 1 ? d : -d);
}

typedef struct sprite_case {
    scene s;
    ddof_frame frame;
    ddof_settings settings;
    bokeh_oracle oracle;
    float *rgba; /* premultiplied, channels there are not 0 */
} sprite_case;

/* Of each shape, kept with the sums that have been needed. */
static bokeh_iris *kept[COUNT(shapes)];

/* What is near, far and in focus lies in blocks; `lights` in 1000 pixels are bright. */
static void fill_scene(scene *s, int lights, double most, double fringe, rng *r) {
    float block[14];
    rng same = {99}; /* so that the sums of their nodes are needed once only */
    for (int i = 0; i < COUNT(block); i++) block[i] = i % 5 == 4 ? 0.5f * (float)(i % 3 - 1) : some_coc(&same, 2.02, most, fringe);
    for (int y = 0; y < s->height; y++)
        for (int x = 0; x < s->width; x++) {
            const int at = y * s->width + x;
            s->coc[at] = block[rng_bits(r) % 8 ? (x / 6 + y / 5 * 3) % COUNT(block) : rng_range(r, 0, COUNT(block) - 1)];
            const bool light = rng_range(r, 1, 1000) <= lights;
            for (int c = 0; c < 4; c++) s->color[4 * at + c] = (float)(rng_unit(r) * (light && c < 3 ? 50 : 0.9));
        }
}

/* The picture as it is blurred. */
static float *loaded(const scene *s, int channels, bool straight) {
    const int n = s->width * s->height;
    float *rgba = fenced(4 * (size_t)n * sizeof *rgba, true);
    for (int i = 0; i < n; i++)
        for (int c = 0; c < 4; c++) {
            rgba[4 * i + c] = c < channels ? s->color[4 * i + c] : 0;
            if (straight && c < channels - 1) rgba[4 * i + c] *= s->color[4 * i + channels - 1];
        }
    return rgba;
}

static sprite_case case_of(int k, bool full, rng *r) {
    static const int sizes[][2] = {{37, 26}, {33, 17}, {21, 40}};
    const shape *look = &shapes[k % COUNT(shapes)];
    const int *size = sizes[k % COUNT(sizes)], channels = full ? 4 : 4 - k / 3 % 4;
    sprite_case c = {.s = scene_make(size[0], size[1], k % 2)};
    const bool straight = k % 4 == 1 && channels % 2 == 0;
    fill_scene(&c.s, 30, k % 3 ? 60 : 230, look->iris.fringe, r);
    c.frame = scene_frame(&c.s);
    c.frame.color.channels = c.frame.output.channels = channels;
    c.frame.pixel_aspect = look->aspect;
    if (straight) c.frame.color.alpha = DDOF_ALPHA_STRAIGHT;
    if (k % 5) c.frame.picture_width = 240, c.frame.picture_height = 130, c.frame.offset_x = 170, c.frame.offset_y = -7;
    c.settings = (ddof_settings){.bokeh = full ? DDOF_BOKEH_FULL : DDOF_BOKEH_HIGHLIGHTS,
                                 .sprites = {.limit = k % 4 ? 1 : 0.3, .threshold = k % 2 ? 0 : 2.5, .resolution = (ddof_resolution)(k / 2 % 3)},
                                 .iris = iris_of(look)};
    c.rgba = loaded(&c.s, channels, straight);
    if (!kept[k % COUNT(shapes)]) kept[k % COUNT(shapes)] = bokeh_iris_make(&c.settings.iris, image_values(), look->aspect);
    c.oracle = (bokeh_oracle){.width = size[0], .height = size[1],
                              .whole_width = c.frame.picture_width ? 240 : size[0], .whole_height = c.frame.picture_width ? 130 : size[1],
                              .left = c.frame.offset_x, .top = c.frame.offset_y,
                              .colors = straight && channels == 2 ? 1 : channels < 3 ? channels : 3, .rgba = c.rgba, .coc = c.s.coc,
                              .sprites = c.settings.sprites, .iris = kept[k % COUNT(shapes)]};
    return c;
}

static void case_free(sprite_case *c) {
    fenced_free(c->rgba);
    scene_free(&c->s);
}

static size_t values_of(const scene *s) {
    return 4 * (size_t)s->width * (size_t)s->height;
}

/* The contexts' result as it would be before it is divided by alpha, channels there are not 0. */
static void assert_result(const sprite_case *c, const double *want, double tolerance, const char *what, int k) {
    const int channels = c->frame.color.channels;
    const bool straight = c->frame.color.alpha == DDOF_ALPHA_STRAIGHT;
    double most = 0, worst = 0;
    size_t at = 0;
    for (size_t i = 0; i < values_of(&c->s); i++) most = fmax(most, fabs(want[i]));
    for (size_t i = 0; i < values_of(&c->s); i++) {
        const int channel = (int)(i % 4);
        if (channel >= channels) continue;
        const float *pixel = c->s.output + (i - (size_t)channel);
        double got = (double)pixel[channel];
        if (straight && channel < channels - 1) got *= (double)pixel[channels - 1];
        if (!(fabs(got - want[i]) <= worst)) worst = fabs(got - want[i]), at = i;
    }
    if (!(worst <= tolerance * most))
        fail_msg("%s, case %d, %s: value %zu is off by %g of %g, allowed %g", what, k, shapes[k % COUNT(shapes)].name, at, worst, most,
                 tolerance * most);
}

/* ---- highlights */

/* Every instruction set of the CPU, and the reference. */
typedef struct contexts {
    ddof_context *each[5];
    int count;
} contexts;

static contexts contexts_make(void) {
    static const unsigned isas[] = {DDOF_CPU_BASELINE, DDOF_CPU_AVX2, DDOF_CPU_AVX512, DDOF_CPU_NEON};
    contexts c = {{reference_context()}, 1};
    for (int i = 0; i < COUNT(isas); i++)
        if (ddof_cpu_available() & isas[i]) c.each[c.count++] = context_of(isas[i], 2);
    return c;
}

static void contexts_free(contexts *c) {
    for (int i = 0; i < c->count; i++) DESTROY(c->each[i]);
}

/* As a part of the brightest pixel (measured: 7e-7). A radius of 32 pixels is exact to 4e-6 pixels in float, and so is what a rim covers,
 * of a sprite whose pixels have a small part of its light each. */
static const double tolerance = 2e-6;

static void assert_counts(const ddof_stats *stats, const bokeh_counts *want, int k) {
    if (stats->sprites != want->drawn || stats->sprites_dropped != want->dropped || stats->sprites_large != want->large)
        fail_msg("case %d, %s: %d sprites, %d dropped, %d large; not %d, %d, %d", k, shapes[k % COUNT(shapes)].name, (int)stats->sprites,
                 (int)stats->sprites_dropped, (int)stats->sprites_large, (int)want->drawn, (int)want->dropped, (int)want->large);
}

static void check_highlights(const contexts *all, sprite_case *c, int k) {
    const size_t n = values_of(&c->s);
    double *want = calloc(n, sizeof *want), *drawn = calloc(n, sizeof *drawn);
    scene rest = scene_make(c->s.width, c->s.height, false);
    ddof_settings off = c->settings;
    ddof_frame frame = scene_frame(&rest);
    const bokeh_counts counts = bokeh_oracle_highlights(&c->oracle, rest.color, drawn);
    memcpy(rest.coc, c->s.coc, n);
    frame.pixel_aspect = c->frame.pixel_aspect;
    off.bokeh = DDOF_BOKEH_OFF;
    for (int i = 0; i < all->count; i++) {
        render(all->each[i], &frame, &off);
        for (size_t v = 0; v < n; v++) want[v] = (double)rest.output[v] + drawn[v];
        const ddof_stats stats = render(all->each[i], &c->frame, &c->settings);
        assert_counts(&stats, &counts, k);
        assert_result(c, want, tolerance, "highlights", k);
    }
    scene_free(&rest);
    free(want), free(drawn);
}

static void highlights(void **state) {
    contexts all = contexts_make();
    rng r = {700};
    (void)state;
    for (int k = 0; k < 2 * COUNT(shapes); k++) {
        sprite_case c = case_of(k, false, &r);
        if (k % 3 == 2) c.settings.kernel = DDOF_KERNEL_DISC;
        check_highlights(&all, &c, k);
        case_free(&c);
    }
    contexts_free(&all);
}

/* More than there is room for: the threshold rises. */
static void budget(void **state) {
    contexts all = contexts_make();
    rng r = {701};
    (void)state;
    for (int k = 0; k < 20; k++) {
        sprite_case c = case_of(k, false, &r);
        for (size_t i = 0; i < values_of(&c.s); i++)
            if (rng_bits(&r) % 3 == 0) c.s.color[i] *= (float)pow(10, 3 * rng_unit(&r));
        fenced_free(c.rgba);
        c.oracle.rgba = c.rgba = loaded(&c.s, c.frame.color.channels, c.frame.color.alpha == DDOF_ALPHA_STRAIGHT);
        c.settings.sprites.max_sprites = k % 3 ? (int[]){1, 2, 17, 100}[k % 4] : 0;
        c.settings.sprites.max_area = k % 2 ? 0 : 1;
        c.oracle.sprites = c.settings.sprites;
        check_highlights(&all, &c, k);
        case_free(&c);
    }
    contexts_free(&all);
}

/* Colours and CoC that are not finite, near lights and as lights. */
static void holes(void **state) {
    static const float bad[] = {NAN, INFINITY, -INFINITY};
    contexts all = contexts_make();
    rng r = {702};
    (void)state;
    for (int k = 0; k < 12; k++) {
        sprite_case c = case_of(k, false, &r);
        for (size_t i = 0; i < values_of(&c.s) && c.frame.color.alpha != DDOF_ALPHA_STRAIGHT; i++) {
            if (rng_bits(&r) % 100 == 0 && (int)(i % 4) < c.frame.color.channels) c.rgba[i] = c.s.color[i] = bad[i % 3];
            if (rng_bits(&r) % 200 == 0) c.s.coc[i / 4] = bad[(i + 1) % 3];
        }
        check_highlights(&all, &c, k);
        case_free(&c);
    }
    contexts_free(&all);
}

/* ---- every pixel */

static void full(void **state) {
    contexts all = contexts_make();
    rng r = {703};
    (void)state;
    for (int k = 0; k < COUNT(shapes); k++) {
        sprite_case c = case_of(k, true, &r);
        double *want = calloc(values_of(&c.s), sizeof *want);
        bokeh_oracle_full(&c.oracle, want);
        for (int i = 0; i < all.count; i++) {
            render(all.each[i], &c.frame, &c.settings);
            assert_result(&c, want, tolerance, "full", k);
        }
        free(want);
        case_free(&c);
    }
    contexts_free(&all);
}

int main(void) {
    static const test tests[] = {
        {"highlights", highlights, false, 0, 0},
        {"more highlights than allowed", budget, false, 0, 0},
        {"holes", holes, false, 0, 0},
        {"every pixel", full, false, 0, 0},
    };
    const int failed = run_library_tests("bokeh", tests, COUNT(tests));
    for (int i = 0; i < COUNT(shapes); i++) bokeh_iris_free(kept[i]);
    return failed;
}
