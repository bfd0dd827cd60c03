/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* What pictures look like that are taken apart by depth (docs/layers.md): what is near spreads over what is sharp, what
 * is sharp takes no colour from behind, what is behind goes on there, and constants, also of alpha, stay. */
#include "support.h"

#include <math.h>
#include <string.h>

static const struct {
    const char *name;
    ddof_backend backend;
    ddof_settings settings;
} kinds[] = {
    {"heat", DDOF_BACKEND_CPU, {.layers = DDOF_LAYERS_AUTO}},
    {"heat, 3 substeps", DDOF_BACKEND_CPU, {.substeps = 3, .layers = DDOF_LAYERS_AUTO}},
    {"heat, reference", DDOF_BACKEND_REFERENCE, {.layers = DDOF_LAYERS_AUTO}},
    {"disc, draft",
     DDOF_BACKEND_CPU,
     {.kernel = DDOF_KERNEL_DISC, .quality = DDOF_QUALITY_DRAFT, .layers = DDOF_LAYERS_AUTO}},
    {"disc, good", DDOF_BACKEND_CPU, {.kernel = DDOF_KERNEL_DISC, .layers = DDOF_LAYERS_AUTO}},
    {"disc, best",
     DDOF_BACKEND_CPU,
     {.kernel = DDOF_KERNEL_DISC, .quality = DDOF_QUALITY_BEST, .layers = DDOF_LAYERS_AUTO}},
    {"disc, reference", DDOF_BACKEND_REFERENCE, {.kernel = DDOF_KERNEL_DISC, .layers = DDOF_LAYERS_AUTO}},
};

static void render_kind(const scene *s, int kind, bool layers, int channels, bool straight) {
    ddof_config config = {.backend = kinds[kind].backend, .threads = 2};
    ddof_settings settings = kinds[kind].settings;
    ddof_context *ctx = NULL;
    ddof_frame frame = scene_frame(s);
    if (!layers) settings.layers = DDOF_LAYERS_OFF;
    frame.color.channels = frame.output.channels = channels;
    if (straight) frame.color.alpha = DDOF_ALPHA_STRAIGHT;
    assert_int_equal(ddof_create(&ctx, &config), DDOF_OK);
    render(ctx, &frame, &settings);
    DESTROY(ctx);
}

static float *at(float *rgba, const scene *s, int x, int y) {
    return rgba + 4 * ((ptrdiff_t)y * s->width + x);
}

static size_t values_of(const scene *s) {
    return 4 * (size_t)s->width * (size_t)s->height;
}

static float *copied(const float *values, const scene *s) {
    float *copy = fenced(values_of(s) * sizeof *copy, true);
    return memcpy(copy, values, values_of(s) * sizeof *copy);
}

/* ---- maps of CoC */

enum { MAPS = 7 };

/* Noise; a ramp; blocks near, in focus and far; two near objects; a fence; noise up to 1e5; what only just parts. */
static float coc_of(int map, int x, int y, int width, int height, rng *r) {
    static const float blocks[] = {-30, 0, 12, -4, 0, 40, -9};
    switch (map) {
    case 0:
        return (float)(60 * rng_unit(r) - 30);
    case 1:
        return (float)(40.0 * x / width - 20 + 5.0 * y / height);
    case 2:
        return blocks[(x / 9 + y / 7 * 3) % COUNT(blocks)];
    case 3:
        return x > width / 3 && y > height / 4 ? -25.0f : x < width / 2 ? -3.0f : 0.0f;
    case 4:
        return x % 8 < 2 ? 0.0f : 15.0f;
    case 5:
        return (float)((rng_bits(r) & 1 ? 1 : -1) * pow(10, 8 * rng_unit(r) - 3));
    default:
        return (float)((int)(rng_bits(r) % 9) - 4) * 0.6f;
    }
}

static void put_map(const scene *s, int map, rng *r) {
    for (int y = 0; y < s->height; y++)
        for (int x = 0; x < s->width; x++)
            s->coc[(ptrdiff_t)y * s->width + x] = coc_of(map, x, y, s->width, s->height, r);
}

/* ---- constants */

static void constant(void **state) {
    static const int sizes[][2] = {{67, 41}, {17, 3}, {1, 29}, {40, 64}};
    static const float values[] = {0.7f, -0.25f, 1, 0.5f};
    const int kind = test_parameters(state).value;
    rng r = {400};
    for (int i = 0; i < MAPS * COUNT(sizes) * 4; i++) {
        const int channels = i % 4 + 1;
        scene s = scene_make(sizes[i / 4 % COUNT(sizes)][0], sizes[i / 4 % COUNT(sizes)][1], i % 2);
        put_map(&s, i / 4 / COUNT(sizes), &r);
        for (size_t k = 0; k < values_of(&s); k++)
            s.color[k] = s.output[k] = values[k % 4];
        if (i / 4 % 2) /* opaque */
            for (size_t k = 3; k < values_of(&s); k += 4)
                s.color[k] = s.output[k] = 1;
        render_kind(&s, kind, true, channels, false);
        assert_close(s.output, s.color, values_of(&s), 5e-6, "%s, map %d, %d x %d, %d channels", kinds[kind].name,
                     i / 4 / COUNT(sizes), s.width, s.height, channels);
        scene_free(&s);
    }
}

/* ---- one layer alone */

static void one_layer(void **state) {
    static const float least[] = {-10, -90, 2.5f, -1, -0.01f, 300}, most[] = {-10, -90, 40, 1, 0.01f, 1e5f};
    const int kind = test_parameters(state).value;
    rng r = {401};
    for (int i = 0; i < COUNT(least) * 2; i++) {
        const int k = i / 2;
        scene s = scene_fill(61, 37, COC_ZERO, i % 2 ? COLOR_RANDOM : COLOR_LIGHTS, &r);
        for (size_t n = 0; n < values_of(&s) / 4; n++)
            s.coc[n] = least[k] + (float)rng_unit(&r) * (most[k] - least[k]);
        render_kind(&s, kind, false, 4, false);
        float *want = copied(s.output, &s);
        render_kind(&s, kind, true, 4, false);
        assert_same_bits(s.output, want, values_of(&s), "%s, CoC %g to %g", kinds[kind].name, (double)least[k],
                         (double)most[k]);
        fenced_free(want);
        scene_free(&s);
    }
}

/* ---- a lattice in focus before what is far */

/* Bars `wide` pixels wide, a mesh each 16, of a colour of their own; `textured`: waves behind them, else one colour. */
static bool is_bar(int x, int y, int wide) {
    return (x + 5) % 16 < wide || (y + 9) % 16 < wide;
}

static scene lattice(int wide, bool textured, bool bars, rng *r) {
    scene s = scene_make(96, 80, true);
    for (int y = 0; y < s.height; y++)
        for (int x = 0; x < s.width; x++) {
            const bool bar = bars && is_bar(x, y, wide);
            s.coc[y * s.width + x] = bar ? 0.0f : 10.0f;
            for (int c = 0; c < 4; c++) {
                const double wave = textured ? 0.25 * (sin(0.23 * x + c) + cos(0.19 * y - c)) : 0.1 * c;
                at(s.color, &s, x, y)[c] = c == 3 ? 1 : bar ? (float)(2 + rng_unit(r)) : (float)(0.5 + wave);
            }
        }
    return s;
}

static void before_one_colour(void **state) {
    const int kind = test_parameters(state).value;
    rng r = {402};
    for (int wide = 1; wide <= 4; wide++) {
        scene s = lattice(wide, false, true, &r);
        render_kind(&s, kind, true, 4, false);
        assert_close(s.output, s.color, values_of(&s), 1e-5, "%s, bars of %d", kinds[kind].name, wide);
        scene_free(&s);
    }
}

/* Root of the mean square, over what is not bar and not at the border. */
static double off_between_bars(const scene *s, float *got, float *want, int wide) {
    double sum = 0;
    int n = 0;
    for (int y = 10; y < s->height - 10; y++)
        for (int x = 10; x < s->width - 10; x++)
            for (int c = 0; c < 3 && !is_bar(x, y, wide); c++, n++)
                sum += pow((double)at(got, s, x, y)[c] - (double)at(want, s, x, y)[c], 2);
    return sqrt(sum / n);
}

/* The bars keep their colour, and the background between them is what it would be without them: to 0.004 rms of waves
 * of amplitude 0.5 behind bars of 1 pixel, 0.015 behind bars of 3 (measured 0.0018, 0.0074). One layer, which stops at
 * the bars, is off by three times as much and more (0.026 to 0.039). */
static void before_waves(void **state) {
    const int kind = test_parameters(state).value;
    rng r = {403};
    for (int wide = 1; wide <= 3; wide += 2) {
        scene bare = lattice(wide, true, false, &r), s = lattice(wide, true, true, &r);
        render_kind(&bare, kind, true, 4, false);
        render_kind(&s, kind, true, 4, false);
        for (int y = 0; y < s.height; y++)
            for (int x = 0; x < s.width; x++)
                if (is_bar(x, y, wide))
                    assert_close(at(s.output, &s, x, y), at(s.color, &s, x, y), 4, 1e-4, "%s, bar at %d %d",
                                 kinds[kind].name, x, y);
        const double layered = off_between_bars(&s, s.output, bare.output, wide);
        render_kind(&s, kind, false, 4, false);
        const double single = off_between_bars(&s, s.output, bare.output, wide);
        if (!(layered < (wide == 1 ? 0.004 : 0.015)) || !(single > 3 * layered))
            fail_msg("%s, bars of %d: what is behind is off by %g, by %g with one layer", kinds[kind].name, wide,
                     layered, single);
        scene_free(&bare);
        scene_free(&s);
    }
}

/* ---- something near before what is sharp */

enum { SIDE = 120, FROM = 36, TO = 84, REACH = 32 }; /* of the picture; where the square lies; 2.7 CoC beyond it */
static const float square_coc = -12;

/* Channel 0: coverage by the square. 1: what is behind, noise. 2: both. */
static scene near_square(rng *r) {
    scene s = scene_make(SIDE, SIDE, true);
    for (int y = 0; y < SIDE; y++)
        for (int x = 0; x < SIDE; x++) {
            const bool near = x >= FROM && x < TO && y >= FROM && y < TO;
            const float noise = (float)rng_unit(r), pixel[4] = {near, near ? 0 : noise, near ? 0.6f : noise, 1};
            s.coc[y * SIDE + x] = near ? square_coc : 0;
            memcpy(at(s.color, &s, x, y), pixel, sizeof pixel);
        }
    return s;
}

/* Beside the square: `cover` of it lies over what is there, which stays sharp. */
static void check_beside(const scene *s, const char *name) {
    for (int y = 0; y < SIDE; y++)
        for (int x = 0; x < SIDE; x++) {
            const float *got = at(s->output, s, x, y), *in = at(s->color, s, x, y), cover = got[0];
            const float want[4] = {cover, (1 - cover) * in[1], cover * 0.6f + (1 - cover) * in[2], 1};
            if (x >= FROM && x < TO && y >= FROM && y < TO) continue;
            assert_close(got, want, 4, 1e-5, "%s, %d %d, covered by %g", name, x, y, (double)cover);
            if (x < FROM - REACH || x >= TO + REACH || y < FROM - REACH || y >= TO + REACH)
                assert_close(got, in, 4, 1e-5, "%s, out of reach, %d %d", name, x, y);
        }
}

static void near_before_sharp(void **state) {
    const int kind = test_parameters(state).value, middle = SIDE / 2;
    const char *name = kinds[kind].name;
    rng r = {404};
    scene s = near_square(&r);
    render_kind(&s, kind, true, 4, false);
    check_beside(&s, name);
    assert_close(at(s.output, &s, middle, middle), (const float[]){1, 0, 0.6f, 1}, 4, 1e-3, "%s, in the middle", name);
    const int edges[][2] = {{FROM, middle}, {FROM - 1, middle}, {TO - 1, middle}, {TO, middle},
                            {middle, FROM}, {middle, FROM - 1}, {middle, TO - 1}, {middle, TO}};
    for (int i = 0; i < COUNT(edges); i++)
        assert_close(at(s.output, &s, edges[i][0], edges[i][1]), &(float){0.5f}, 1, 0.15, "%s, at an edge", name);
    render_kind(&s, kind, false, 4, false); /* one layer: nothing leaves the square */
    assert_close(at(s.output, &s, FROM - 1, middle), at(s.color, &s, FROM - 1, middle), 4, 1e-5, "%s, one layer", name);
    assert_true(at(s.output, &s, FROM, middle)[0] > 0.9f);
    scene_free(&s);
}

/* Only a rectangle around what is near is blurred: where it ends less than 1e-5 of the light is left. */
static void end_of_reach(void **state) {
    const int kind = test_parameters(state).value;
    scene s = scene_make(200, 40, true);
    for (int i = 0; i < s.width * s.height; i++) {
        const bool near = i % s.width < 100;
        s.coc[i] = near ? -20.0f : 0;
        for (int c = 0; c < 4; c++)
            s.color[4 * i + c] = near || c == 3;
    }
    render_kind(&s, kind, true, 4, false);
    int end = 199;
    while (at(s.output, &s, end, 20)[0] == 0)
        end--;
    assert_true(end > 110 && end < 198);
    assert_close(at(s.output, &s, end, 20), &(float){0}, 1, 1e-5, "%s, last at %d", kinds[kind].name, end);
    scene_free(&s);
}

/* ---- two near things */

/* A, far out of focus, over B, a little, over what is sharp; each a channel, which together are 1 everywhere. */
static scene overlapping(void) {
    scene s = scene_make(128, 96, true);
    for (int y = 0; y < s.height; y++)
        for (int x = 0; x < s.width; x++) {
            const bool a = x < 64 && y < 60, b = !a && y >= 20 && y < 84 && x < 100;
            const float pixel[4] = {a, b, !a && !b, 1};
            s.coc[y * s.width + x] = a ? -24.0f : b ? -4.0f : 0;
            memcpy(at(s.color, &s, x, y), pixel, sizeof pixel);
        }
    return s;
}

static void two_near(void **state) {
    const int kind = test_parameters(state).value;
    const char *name = kinds[kind].name;
    scene s = overlapping();
    render_kind(&s, kind, true, 4, false);
    for (size_t n = 0; n < values_of(&s); n += 4)
        assert_close(&(float){s.output[n] + s.output[n + 1] + s.output[n + 2]}, &(float){1}, 1, 1e-5, "%s, sum", name);
    assert_close(at(s.output, &s, 30, 30), (const float[]){1, 0, 0}, 3, 0.01, "%s, deep in A", name);
    assert_close(at(s.output, &s, 92, 78), (const float[]){0, 1, 0}, 3, 0.01, "%s, deep in B", name);
    assert_close(at(s.output, &s, 120, 90), (const float[]){0, 0, 1}, 3, 0.01, "%s, beyond both", name);
    for (int x = 63; x <= 64; x++) { /* A's edge: over B, which goes on behind, and over what is sharp */
        assert_close(at(s.output, &s, x, 45), (const float[]){0.5f, 0.5f, 0}, 3, 0.15, "%s, A over B at %d", name, x);
        assert_close(at(s.output, &s, x, 5), (const float[]){0.5f, 0, 0.5f}, 3, 0.15, "%s, A over sharp at %d", name,
                     x);
    }
    assert_true(at(s.output, &s, 72, 45)[0] > 0.05f); /* A reaches 12 pixels, B two */
    assert_true(fabsf(at(s.output, &s, 106, 75)[1]) < 0.03f);
    const float *in = at(s.output, &s, 99, 75), *out = at(s.output, &s, 100, 75);
    assert_close(&(float){in[1] + out[1]}, &(float){1}, 1, 0.1, "%s, B's edge", name);
    scene_free(&s);
}

/* ---- from near through the focus to far */

/* No seam: away from the border and from 2 pixels of CoC, waves of amplitude 0.5 are as without layers, to 0.04
 * (measured: 0.028, where the two near layers part). */
static void slanted(void **state) {
    const int kind = test_parameters(state).value;
    scene s = scene_make(160, 64, true);
    for (int y = 0; y < s.height; y++)
        for (int x = 0; x < s.width; x++) {
            s.coc[y * s.width + x] = (float)(x - 80) / 5;
            for (int c = 0; c < 4; c++)
                at(s.color, &s, x, y)[c] = c == 3 ? 1 : (float)(0.5 + 0.25 * (sin(0.2 * x + c) + cos(0.25 * y - c)));
        }
    render_kind(&s, kind, false, 4, false);
    float *want = copied(s.output, &s);
    render_kind(&s, kind, true, 4, false);
    for (int y = 16; y < s.height - 16; y++)
        assert_close(at(s.output, &s, 20, y), at(want, &s, 20, y), 4 * (160 - 40), 0.04, "%s, row %d", kinds[kind].name,
                     y);
    fenced_free(want);
    scene_free(&s);
}

/* ---- alpha */

/* Alpha of noise with whole blocks of 0 and 1, or 0.5 everywhere. */
static float alpha_of(bool even, int x, int y, rng *r) {
    const int block = (x / 13 + y / 11) % 3;
    return even ? 0.5f : block == 2 ? (float)rng_unit(r) : (float)block;
}

/* Premultiplied: colour stays the same part of alpha, which leaves 0..1 no farther than the kernel does. */
static void ratio(void **state) {
    const int kind = test_parameters(state).value;
    const float over = kinds[kind].settings.kernel == DDOF_KERNEL_DISC ? 0.03f : 1e-5f, color[] = {0.8f, 0.25f, 1.5f};
    rng r = {405};
    for (int i = 0; i < 2 * MAPS; i++) {
        scene s = scene_make(75, 52, true);
        put_map(&s, i / 2, &r);
        for (int y = 0; y < s.height; y++)
            for (int x = 0; x < s.width; x++) {
                float *p = at(s.color, &s, x, y);
                p[3] = alpha_of(i % 2, x, y, &r);
                for (int c = 0; c < 3; c++)
                    p[c] = p[3] * color[c];
            }
        render_kind(&s, kind, true, 4, false);
        for (float *p = s.output; p < s.output + values_of(&s); p += 4) {
            const float want[] = {p[3] * color[0], p[3] * color[1], p[3] * color[2]};
            assert_close(p, want, 3, 1e-4, "%s, map %d, alpha %g", kinds[kind].name, i / 2, (double)p[3]);
            if (!(p[3] >= -over && p[3] <= 1 + over))
                fail_msg("%s, map %d: alpha %g", kinds[kind].name, i / 2, (double)p[3]);
        }
        scene_free(&s);
    }
}

/* Straight alpha, of two channels and of four, is premultiplied alpha multiplied before and divided after; colour where
 * alpha is 0 does not matter. */
static void straight(void **state) {
    const int kind = test_parameters(state).value;
    rng r = {406};
    for (int i = 0; i < 2 * MAPS; i++) {
        const int channels = i % 2 ? 2 : 4, a = channels - 1;
        scene s = scene_fill(47, 39, COC_ZERO, COLOR_RANDOM, &r);
        put_map(&s, i / 2, &r);
        for (int n = 0; n < s.width * s.height; n++)
            s.color[4 * n + a] = alpha_of(false, n % 47, n / 47, &r);
        render_kind(&s, kind, true, channels, true);
        float *got = copied(s.output, &s);
        for (int n = 0; n < s.width * s.height; n++)
            for (int c = 0; c < a; c++)
                s.color[4 * n + c] *= s.color[4 * n + a];
        render_kind(&s, kind, true, channels, false);
        for (int n = 0; n < s.width * s.height; n++) {
            const float alpha = s.output[4 * n + a];
            for (int c = 0; c < a; c++)
                got[4 * n + c] = alpha != 0 ? got[4 * n + c] * alpha : 0;
            assert_close(got + 4 * n, s.output + 4 * n, (size_t)channels, 1e-5, "%s, map %d, %d channels",
                         kinds[kind].name, i / 2, channels);
        }
        fenced_free(got);
        scene_free(&s);
    }
}

/* Light that covers nothing: colour where alpha is 0. Like any colour it stays where it is constant, and alpha stays 0.
 */
static void light_only(void **state) {
    const int kind = test_parameters(state).value;
    rng r = {407};
    for (int i = 0; i < MAPS; i++) {
        scene s = scene_make(50, 33, true);
        put_map(&s, i, &r);
        for (size_t k = 0; k < values_of(&s); k++)
            s.color[k] = k % 4 == 3 ? 0 : 0.9f;
        render_kind(&s, kind, true, 4, false);
        assert_close(s.output, s.color, values_of(&s), 5e-6, "%s, map %d", kinds[kind].name, i);
        for (size_t k = 3; k < values_of(&s); k += 4)
            assert_true(s.output[k] == 0);
        scene_free(&s);
    }
}

#define EACH(name, run)                                                                                                \
    {name ", heat", run, false, 0, 0}, {name ", heat, 3 substeps", run, false, 1, 0},                                  \
        {name ", heat, reference", run, false, 2, 0}, {name ", disc, draft", run, false, 3, 0},                        \
        {name ", disc, good", run, false, 4, 0}, {name ", disc, best", run, false, 5, 0}, {                            \
        name ", disc, reference", run, false, 6, 0                                                                     \
    }

int main(void) {
    static const test tests[] = {
        EACH("a constant stays", constant),
        EACH("one layer alone is the picture", one_layer),
        EACH("a lattice before one colour", before_one_colour),
        EACH("a lattice before waves", before_waves),
        EACH("near before sharp", near_before_sharp),
        EACH("the end of reach", end_of_reach),
        EACH("two near things", two_near),
        EACH("a slanted plane", slanted),
        EACH("colour in proportion to alpha", ratio),
        EACH("straight alpha", straight),
        EACH("colour without alpha", light_only),
    };
    return run_library_tests("layers", tests, COUNT(tests));
}
