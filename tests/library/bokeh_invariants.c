/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* What sprites keep: the light of a pixel, alpha, what is nearer, the number that is allowed, and a picture without any. */
#include "support.h"

#include <math.h>
#include <string.h>

static size_t values_of(const scene *s) {
    return 4 * (size_t)s->width * (size_t)s->height;
}

static scene flat(int width, int height, float coc, float color) {
    scene s = scene_make(width, height, true);
    for (size_t i = 0; i < values_of(&s); i++) {
        s.color[i] = i % 4 == 3 ? 1 : color;
        s.coc[i / 4] = coc;
    }
    return s;
}

static void put(const scene *s, int x, int y, float value) {
    for (int c = 0; c < 3; c++) s->color[4 * (y * s->width + x) + c] = value * (float)(c + 2) / 4;
}

static double sum_of(const scene *s, const float *values, int channel) {
    double sum = 0;
    for (size_t i = (size_t)channel; i < values_of(s); i += 4) sum += (double)values[i];
    return sum;
}

static float *copied(const float *values, size_t count) {
    return memcpy(fenced(count * sizeof *values, true), values, count * sizeof *values);
}

/* ---- light */

typedef struct kept {
    const char *name;
    ddof_iris iris;
    double aspect;
} kept;

static float spots[6 * 6];

static const kept shapes[] = {
    {"disc", {0}, 0},
    {"disc, wide pixels", {0}, 2},
    {"hexagon", {.shape = DDOF_IRIS_POLYGON, .blades = 6, .rotation = 12}, 0},
    {"64 blades", {.shape = DDOF_IRIS_POLYGON, .blades = 64}, 0},
    {"squeezed", {.squeeze = 2}, 0},
    {"bright rim", {.edge = 0.8}, 0},
    {"hexagon with a bright middle", {.shape = DDOF_IRIS_POLYGON, .blades = 6, .edge = -0.8}, 0},
    {"fringe", {.fringe = 0.2}, 0},
    {"triangle", {.shape = DDOF_IRIS_POLYGON, .blades = 3, .rotation = 5}, 0},
    {"pentagon with a bright rim", {.shape = DDOF_IRIS_POLYGON, .blades = 5, .edge = 0.5, .curvature = 0.3}, 0},
    {"image, turned", {.shape = DDOF_IRIS_IMAGE, .rotation = 30}, 0},
};

static ddof_iris iris_of(int i) {
    ddof_iris iris = shapes[i].iris;
    for (int k = 0; k < COUNT(spots); k++) spots[k] = (float)(k * 5 % 7);
    if (iris.shape == DDOF_IRIS_IMAGE) iris.image = ddof_image_interleaved(spots, 6, 6, 1, DDOF_FLOAT, 0);
    return iris;
}

/* To 1e-5, at every level and resolution, of either side. Alpha has the bits that it has without sprites. */
static void light(void **state) {
    static const float cocs[] = {4, 9.3f, 33, 63, 70, 110};
    ddof_context *ctx = context_of(0, 2);
    (void)state;
    for (int k = 0; k < COUNT(shapes) * COUNT(cocs) * 4; k++) {
        const int shape = k / 4 / COUNT(cocs);
        const float coc = cocs[k / 4 % COUNT(cocs)] / (shapes[shape].aspect > 1 && k / 4 % COUNT(cocs) ? 2 : 1);
        const bool half = k % 2;
        scene s = flat(160, 157, k & 2 ? -coc : coc, 0.25f);
        ddof_frame frame = scene_frame(&s);
        ddof_settings settings = {0};
        frame.pixel_aspect = shapes[shape].aspect;
        put(&s, 80 - half, 78, 1000);
        render(ctx, &frame, &settings);
        float *off = copied(s.output, values_of(&s));
        settings = (ddof_settings){.bokeh = DDOF_BOKEH_HIGHLIGHTS, .iris = iris_of(shape), .sprites = {.limit = 1, .resolution = half ? DDOF_RESOLUTION_HALF : DDOF_RESOLUTION_FULL}};
        assert_int_equal(render(ctx, &frame, &settings).sprites, 1);
        for (int c = 0; c < 3; c++) {
            const double given = 250 * (c + 2), lost = sum_of(&s, s.output, c) - sum_of(&s, s.color, c);
            if (!(fabs(lost) <= 1e-5 * given))
                fail_msg("%s, CoC %g, %s, channel %d: off by %g of the light", shapes[shape].name, (double)s.coc[0], half ? "half" : "full", c,
                         lost / given);
        }
        for (size_t i = 3; i < values_of(&s); i += 4) assert_same_bits(&s.output[i], &off[i], 1, "alpha, %s", shapes[shape].name);
        fenced_free(off);
        scene_free(&s);
    }
    DESTROY(ctx);
}

/* With a cat's eye what is left of a disc has all the light to 1 % wherever it is (measured: 0.5 %): how much brighter it gets is a
 * table made for circles of 64 pixels, exact in the middle. */
static void cats_eye(void **state) {
    static const int places[][2] = {{40, 40}, {120, 60}, {60, 110}, {118, 112}};
    ddof_context *ctx = context_of(0, 2);
    (void)state;
    for (int k = 0; k < COUNT(places) * 8; k++) {
        scene s = flat(160, 150, (k & 1 ? -1.0f : 1.0f) * (k & 2 ? 12.0f : 50.0f), 0.25f);
        ddof_frame frame = scene_frame(&s);
        const ddof_settings settings = {.bokeh = DDOF_BOKEH_HIGHLIGHTS, .iris = {.cats_eye = k & 4 ? 1 : 0.4}, .sprites = {.limit = 1}};
        put(&s, places[k / 8][0], places[k / 8][1], 1000);
        assert_int_equal(render(ctx, &frame, &settings).sprites, 1);
        const double lost = sum_of(&s, s.output, 0) - sum_of(&s, s.color, 0);
        if (!(fabs(lost) <= 0.01 * 500)) fail_msg("case %d: off by %g of the light", k, lost / 500);
        scene_free(&s);
    }
    DESTROY(ctx);
}

/* At the border what would fall out is diffused: to 2 % (its part is reckoned of an even disc, not of pixels). */
static void at_borders(void **state) {
    ddof_context *ctx = context_of(0, 2);
    rng r = {720};
    (void)state;
    for (int k = 0; k < 24; k++) {
        scene s = flat(90, 70, (k % 2 ? -1.0f : 1.0f) * (k % 3 ? 14.0f : 41.0f), 0.25f);
        ddof_frame frame = scene_frame(&s);
        const ddof_settings settings = {.bokeh = DDOF_BOKEH_HIGHLIGHTS, .sprites = {.limit = 1}};
        put(&s, k % 4 ? rng_range(&r, 0, 89) : 0, k % 4 < 2 ? rng_range(&r, 0, 69) : 69, 1000);
        assert_int_equal(render(ctx, &frame, &settings).sprites, 1);
        const double lost = sum_of(&s, s.output, 0) - sum_of(&s, s.color, 0);
        if (!(fabs(lost) <= 0.02 * 500)) fail_msg("case %d: off by %g of the light", k, lost / 500);
        scene_free(&s);
    }
    DESTROY(ctx);
}

/* ---- what lies before what */

/* Far lights, left; to the right columns of other CoC. Two shapes of iris take the same light and leave the same rest: where no sprite
 * is seen, the bits are the same. */
static scene columns(const float *coc, int count, float light) {
    scene s = flat(20 * (count + 1), 60, light, 0.5f);
    for (int y = 0; y < s.height; y++)
        for (int x = 20; x < s.width; x++) s.coc[y * s.width + x] = coc[x / 20 - 1];
    for (int y = 9; y < 60; y += 14) put(&s, 14, y, 400);
    return s;
}

static void order(void **state) {
    static const float nearer[] = {0, -8, 6, 1, -30, 7.4f}, farther[] = {-20, 0, 40, 3, -14.9f, 1e5f};
    ddof_context *ctx = context_of(0, 2);
    (void)state;
    for (int k = 0; k < 8; k++) {
        const float *coc = k % 2 ? farther : nearer;
        scene s = columns(coc, 6, k % 2 ? -90 : 90);
        ddof_frame frame = scene_frame(&s);
        ddof_settings settings = {.bokeh = DDOF_BOKEH_HIGHLIGHTS, .sprites = {.limit = 1, .resolution = k & 2 ? DDOF_RESOLUTION_HALF : DDOF_RESOLUTION_FULL},
                                  .kernel = k & 4 ? DDOF_KERNEL_DISC : DDOF_KERNEL_HEAT};
        int same = 0, other = 0;
        if (!(k % 2)) /* smaller, so that all of its level's pixels lie in a column */
            for (int y = 0; y < s.height; y++)
                for (int x = 0; x < 20; x++) s.coc[y * s.width + x] = 30;
        assert_int_equal(render(ctx, &frame, &settings).sprites, 4);
        float *disc = copied(s.output, values_of(&s));
        settings.iris = (ddof_iris){.shape = DDOF_IRIS_POLYGON, .blades = 4, .rotation = 45};
        render(ctx, &frame, &settings);
        for (int y = 0; y < s.height; y++)
            for (int x = 0; x < s.width; x++) {
                const bool changed = memcmp(disc + 4 * (y * s.width + x), s.output + 4 * (y * s.width + x), 16) != 0;
                /* in pictures of half the size one pixel is seen by all that lie around it */
                if (!(k % 2) && x >= (k & 2 ? 22 : 20) && changed) fail_msg("case %d: a far light is seen at %d %d, over %g", k, x, y, (double)s.coc[y * s.width + x]);
                if (x >= 20) *(changed ? &other : &same) += 1;
            }
        if (k % 2 && !(other > same / 4)) fail_msg("case %d: near light covers %d of %d pixels", k, other, other + same);
        fenced_free(disc);
        scene_free(&s);
    }
    DESTROY(ctx);
}

/* A near light loses nothing over what is farther. */
static void near_over_sharp(void **state) {
    ddof_context *ctx = context_of(0, 2);
    (void)state;
    for (int k = 0; k < 4; k++) {
        scene s = flat(120, 110, k & 1 ? 0 : 25, 0.25f);
        ddof_frame frame = scene_frame(&s);
        const ddof_settings settings = {.bokeh = DDOF_BOKEH_HIGHLIGHTS, .sprites = {.limit = 1, .resolution = k & 2 ? DDOF_RESOLUTION_HALF : DDOF_RESOLUTION_FULL}};
        put(&s, 60, 50, 1000);
        s.coc[50 * 120 + 60] = -40;
        assert_int_equal(render(ctx, &frame, &settings).sprites, 1);
        for (int c = 0; c < 3; c++)
            assert_true(fabs(sum_of(&s, s.output, c) - sum_of(&s, s.color, c)) <= 1e-5 * 250 * (c + 2));
        assert_true(s.output[4 * (50 * 120 + 78)] > 0.5f && s.output[4 * (50 * 120 + 83)] < 0.26f);
        scene_free(&s);
    }
    DESTROY(ctx);
}

/* ---- none, one, very many */

static void none(void **state) {
    rng r = {721};
    ddof_context *ctx = context_of(0, 2);
    (void)state;
    for (int k = 0; k < 48; k++) {
        scene s = scene_fill(k % 5 ? 61 : 1, k % 7 ? 37 : 1, (coc_pattern)(k % COC_PATTERNS), k % 3 ? COLOR_RANDOM : COLOR_SIGNED, &r);
        ddof_frame frame = scene_frame(&s);
        ddof_settings settings = {.kernel = k & 1 ? DDOF_KERNEL_DISC : DDOF_KERNEL_HEAT, .layers = k % 4 == 3 ? DDOF_LAYERS_AUTO : DDOF_LAYERS_OFF};
        frame.color.channels = frame.output.channels = k / 2 % 4 + 1;
        if (k / 2 % 2 && k % 3) frame.color.alpha = DDOF_ALPHA_STRAIGHT;
        frame.pixel_aspect = k % 6 ? 0 : 2;
        for (size_t i = 0; i < values_of(&s) && k % 8 == 1; i += 57) *(i % 2 ? &s.color[i] : &s.coc[i / 4]) = NAN;
        memset(s.output, 0, values_of(&s) * sizeof(float));
        render(ctx, &frame, &settings);
        float *off = copied(s.output, values_of(&s));
        settings.bokeh = DDOF_BOKEH_HIGHLIGHTS;
        settings.iris = (ddof_iris){.fringe = 0.1, .cats_eye = 1};
        const ddof_stats stats = render(ctx, &frame, &settings);
        assert_true(stats.sprites == 0 && stats.sprites_dropped == 0 && stats.sprites_large == 0);
        assert_same_bits(s.output, off, values_of(&s), "case %d", k);
        fenced_free(off);
        scene_free(&s);
    }
    DESTROY(ctx);
}

/* Beyond the limit, and all of them equally bright: diffused. */
static void left_to_diffusion(void **state) {
    ddof_context *ctx = context_of(0, 2);
    (void)state;
    for (int k = 0; k < 4; k++) {
        scene s = flat(40, 30, k & 1 ? 1e5f : -11, 7);
        ddof_frame frame = scene_frame(&s);
        ddof_settings settings = {0};
        render(ctx, &frame, &settings);
        float *off = copied(s.output, values_of(&s));
        settings.bokeh = DDOF_BOKEH_HIGHLIGHTS;
        settings.sprites = (ddof_sprites){.max_sprites = k & 2 ? 1199 : 1200, .limit = k & 2 ? 1 : 0.25, .max_area = 1024};
        const ddof_stats stats = render(ctx, &frame, &settings);
        const bool large = s.coc[0] > 40 || !(k & 2);
        assert_true(stats.sprites == 0 && stats.sprites_large == (large ? 1200 : 0) && stats.sprites_dropped == (large ? 0 : 1200));
        assert_same_bits(s.output, off, values_of(&s), "case %d", k);
        fenced_free(off);
        scene_free(&s);
    }
    DESTROY(ctx);
}

/* Pixels just at an edge of a bin, and far above the last one: never more than allowed. */
static void edges_of_bins(void **state) {
    ddof_context *ctx = context_of(0, 1);
    (void)state;
    for (int k = 0; k < 512 * 7; k++) {
        const double threshold = k % 2 ? 1 : 0.7331;
        float v = (float)(threshold * exp2(k / 7 / 16.0));
        for (int i = k % 7 - 3; i != 0; i += i < 0 ? 1 : -1) v = nextafterf(v, i < 0 ? 0 : INFINITY);
        scene s = flat(8, 8, 5, v);
        ddof_frame frame = scene_frame(&s);
        const ddof_settings settings = {.bokeh = DDOF_BOKEH_HIGHLIGHTS, .sprites = {.threshold = threshold, .limit = 1, .max_sprites = 2}};
        put(&s, 3, 3, 2.5f * v);
        const ddof_stats stats = render(ctx, &frame, &settings);
        const int all = v > (float)threshold ? 64 : 1;
        if (stats.sprites > 2 || stats.sprites + stats.sprites_dropped != all)
            fail_msg("bin %d, brightness %.9g: %d drawn, %d dropped of %d", k / 7, (double)v, (int)stats.sprites, (int)stats.sprites_dropped, all);
        scene_free(&s);
    }
    DESTROY(ctx);
}

static void beyond_the_bins(void **state) {
    ddof_context *ctx = context_of(0, 1);
    (void)state;
    for (int k = 1; k < 4; k++) {
        scene s = flat(40, 30, 6, 5);
        ddof_frame frame = scene_frame(&s);
        ddof_settings settings = {0};
        render(ctx, &frame, &settings);
        float *off = copied(s.output, values_of(&s));
        settings.bokeh = DDOF_BOKEH_HIGHLIGHTS;
        settings.sprites = (ddof_sprites){.threshold = 1e-30, .limit = 1, .max_sprites = k == 1 ? 1 : k == 2 ? 1199 : 0, .max_area = k == 3 ? 1 : 0};
        const ddof_stats stats = render(ctx, &frame, &settings);
        assert_true(stats.sprites == 0 && stats.sprites_dropped == 1200);
        assert_same_bits(s.output, off, values_of(&s), "case %d", k);
        fenced_free(off);
        scene_free(&s);
    }
    DESTROY(ctx);
}

static void more_is_more(void **state) {
    ddof_context *ctx = context_of(0, 2);
    scene s = flat(64, 64, 9, 0.1f);
    ddof_frame frame = scene_frame(&s);
    rng r = {722};
    (void)state;
    for (int i = 0; i < 64 * 64; i++) put(&s, i % 64, i / 64, (float)exp2(6 * rng_unit(&r) - 1));
    for (int by_area = 0; by_area < 2; by_area++) {
        int64_t last = 0, all = 0;
        for (int most = 1; most <= 1024; most *= 2) {
            const ddof_settings settings = {.bokeh = DDOF_BOKEH_HIGHLIGHTS,
                                            .sprites = {.limit = 1, .max_sprites = by_area ? 1 << 20 : most * 4, .max_area = by_area ? most : 1024}};
            const ddof_stats stats = render(ctx, &frame, &settings);
            if (!all) all = stats.sprites + stats.sprites_dropped;
            assert_true(stats.sprites >= last && stats.sprites + stats.sprites_dropped == all);
            assert_true(by_area ? (double)stats.sprites * 80 <= most * 64.0 * 64 : stats.sprites <= most * 4);
            last = stats.sprites;
        }
        assert_int_equal(last, all);
    }
    scene_free(&s);
    DESTROY(ctx);
}

/* A million of different brightness: as many as allowed, the brightest; memory is that of a black picture. */
static void million(void **state) {
    enum { SIDE = 1000, EDGE = 10, LIT = (SIDE - 2 * EDGE) * (SIDE - 2 * EDGE) };
    ddof_context *ctx = context_of(0, 2);
    scene s = flat(SIDE, SIDE, 6, 0.1f);
    ddof_frame frame = scene_frame(&s);
    const ddof_settings settings = {.bokeh = DDOF_BOKEH_HIGHLIGHTS};
    size_t bytes, again;
    (void)state;
    assert_int_equal(ddof_scratch_bytes(ctx, &frame, &settings, &bytes), DDOF_OK);
    assert_int_equal(render(ctx, &frame, &settings).scratch_bytes, bytes);
    for (int i = 0; i < LIT; i++) put(&s, EDGE + i % (SIDE - 2 * EDGE), EDGE + i / (SIDE - 2 * EDGE), 2 + 40 * (float)(i * 7919LL % LIT) / LIT);
    assert_int_equal(ddof_scratch_bytes(ctx, &frame, &settings, &again), DDOF_OK);
    const ddof_stats stats = render(ctx, &frame, &settings);
    assert_true(stats.scratch_bytes == bytes && again == bytes);
    assert_int_equal(stats.sprites + stats.sprites_dropped, LIT);
    assert_true(stats.sprites <= 65536 && stats.sprites > 50000); /* a bin more would be too many: 4 % of brightness */
    for (int c = 0; c < 3; c++) {
        const double given = sum_of(&s, s.color, c), lost = sum_of(&s, s.output, c) - given;
        if (!(fabs(lost) <= 1e-5 * given)) fail_msg("channel %d: off by %g of the light", c, lost / given);
    }
    scene_free(&s);
    DESTROY(ctx);
}

int main(void) {
    static const test tests[] = {
        {"light is kept", light, false, 0, 0},
        {"light is kept, cat's eye", cats_eye, false, 0, 0},
        {"light is kept at the border", at_borders, false, 0, 0},
        {"what lies before what", order, false, 0, 0},
        {"near over what is farther", near_over_sharp, false, 0, 0},
        {"no highlights", none, false, 0, 0},
        {"left to diffusion", left_to_diffusion, false, 0, 0},
        {"edges of bins", edges_of_bins, false, 0, 0},
        {"beyond the last bin", beyond_the_bins, false, 0, 0},
        {"more allowed, more drawn", more_is_more, false, 0, 0},
        {"a million", million, false, 0, 0},
    };
    return run_library_tests("bokeh_invariants", tests, COUNT(tests));
}
