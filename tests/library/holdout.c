/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The holdout mask: held pixels stay as they are and give nothing to others, with and without layers; fractions mix;
 * what is refused. */
#include "layout.h"
#include "support.h"

#include <math.h>
#include <string.h>

/* By the value of a test: kernel and layers. */
static ddof_settings settings_of(int value) {
    return (ddof_settings){.kernel = value & 1 ? DDOF_KERNEL_DISC : DDOF_KERNEL_HEAT,
                           .layers = value & 2 ? DDOF_LAYERS_AUTO : DDOF_LAYERS_OFF};
}

typedef struct request {
    scene s;
    ddof_image mask;
    float *values; /* of the mask */
    ddof_frame frame;
    ddof_settings settings;
} request;

/* Near, sharp and far, noise, masked by blobs; in place of output nothing is written yet. */
static request *make(request *q, int width, int height, int value, rng *r) {
    q->s = scene_fill(width, height, value & 4 ? COC_SMOOTH : COC_SMALL, COLOR_RANDOM, r);
    q->values = fenced((size_t)width * (size_t)height * sizeof(float), true);
    for (int i = 0; i < width * height; i++)
        q->values[i] = (i % width / 6 + i / width / 5) % 3 == 0;
    q->mask = ddof_image_interleaved(q->values, width, height, 1, DDOF_FLOAT, 0);
    q->frame = scene_frame(&q->s);
    q->frame.holdout = &q->mask;
    q->settings = settings_of(value);
    return q;
}

static void unmake(request *q) {
    scene_free(&q->s);
    fenced_free(q->values);
}

static size_t pixels_of(const request *q) {
    return (size_t)q->s.width * (size_t)q->s.height;
}

static void render_now(const request *q) {
    ddof_context *ctx = context_of(0, 2);
    render(ctx, &q->frame, &q->settings);
    DESTROY(ctx);
}

/* The output of q, in memory that is the caller's. */
static float *result_of(const request *q) {
    float *copy = fenced(4 * pixels_of(q) * sizeof *copy, true);
    render_now(q);
    return memcpy(copy, q->s.output, 4 * pixels_of(q) * sizeof *copy);
}

/* ---- held pixels */

/* To the bit, -0 too; for every count of channels, either alpha, whatever depth is there. */
static void stays(void **state) {
    rng r = {500};
    for (int i = 0; i < 24; i++) {
        request q;
        make(&q, 43, 31, test_parameters(state).value, &r);
        const int channels = i % 4 + 1;
        q.frame.color.channels = q.frame.output.channels = channels;
        if (channels % 2 == 0 && i / 4 % 2) q.frame.color.alpha = DDOF_ALPHA_STRAIGHT;
        for (size_t k = 0; k < 4 * pixels_of(&q); k++) {
            if (rng_bits(&r) % 8 == 0) q.s.color[k] = (float[]){0, -0.0f, 1e6f, -3, 1}[rng_bits(&r) % 5];
            if (i / 8 == 1 && k % 4 == 3) q.s.color[k] = 1;
        }
        for (size_t k = 0; k < pixels_of(&q) && i / 8 == 2; k += 7)
            q.s.coc[k] = k % 2 ? NAN : INFINITY;
        render_now(&q);
        for (size_t k = 0; k < pixels_of(&q); k++)
            if (q.values[k] == 1)
                assert_same_bits(q.s.output + 4 * k, q.s.color + 4 * k, (size_t)channels,
                                 "%d channels, alpha %d, pixel %zu", channels, q.frame.color.alpha, k);
        unmake(&q);
    }
}

/* Half floats come back as they went in. */
static void stays_half(void **state) {
    rng r = {501};
    for (int i = 0; i < 2 * LAYOUTS; i++) {
        request q;
        make(&q, 29, 23, test_parameters(state).value, &r);
        for (size_t k = 0; k < 4 * pixels_of(&q); k++)
            q.s.color[k] = (float)half_value(half_nearest((double)q.s.color[k]));
        stored in = stored_make((layout)(i % LAYOUTS), q.s.width, q.s.height, 4, 15);
        stored_put(&in, q.s.color, 4);
        q.frame.color = q.frame.output = in.image;
        if (i >= LAYOUTS) q.frame.color.alpha = DDOF_ALPHA_STRAIGHT;
        render_now(&q);
        stored_get(&in, q.s.output, 4);
        for (size_t k = 0; k < pixels_of(&q); k++)
            if (q.values[k] == 1)
                assert_same_bits(q.s.output + 4 * k, q.s.color + 4 * k, 4, "arrangement %d, %zu", i, k);
        stored_free(&in);
        unmake(&q);
    }
}

static void all_held(void **state) {
    rng r = {502};
    static const int sizes[][2] = {{1, 1}, {1, 9}, {50, 33}};
    for (int i = 0; i < 2 * COUNT(sizes); i++) {
        request q;
        make(&q, sizes[i / 2][0], sizes[i / 2][1], test_parameters(state).value, &r);
        for (size_t k = 0; k < pixels_of(&q); k++)
            q.values[k] = i % 2 ? 1 : INFINITY;
        render_now(&q);
        assert_same_bits(q.s.output, q.s.color, 4 * pixels_of(&q), "%d x %d", q.s.width, q.s.height);
        unmake(&q);
    }
}

/* ---- the others */

static void set_held(request *q, int how, rng *r) {
    for (size_t k = 0; k < pixels_of(q); k++)
        for (int c = 0; c < 4 && q->values[k] == 1; c++)
            q->s.color[4 * k + (size_t)c] = how == 0   ? (float)rng_unit(r)
                                            : how == 1 ? -1e6f
                                            : how == 2 ? (float)(c == 3)
                                            : how == 3 ? NAN
                                                       : INFINITY;
}

/* What is held out may be of any colour, alpha or CoC, or none. */
static void others(void **state) {
    rng r = {503};
    for (int i = 0; i < 24; i++) {
        request q;
        make(&q, 61, 37, test_parameters(state).value, &r);
        const int how = i % 6;
        for (size_t k = 3; k < 4 * pixels_of(&q) && i / 6 % 2; k += 4)
            q.s.color[k] = 1; /* opaque */
        if (i / 12) q.frame.color.alpha = DDOF_ALPHA_STRAIGHT;
        float *want = result_of(&q);
        set_held(&q, how, &r);
        for (size_t k = 0; k < pixels_of(&q) && how == 5; k++)
            if (q.values[k] == 1) q.s.coc[k] = -40;
        render_now(&q);
        for (size_t k = 0; k < pixels_of(&q); k++)
            if (q.values[k] == 0)
                assert_same_bits(q.s.output + 4 * k, want + 4 * k, 4, "held pixels changed, way %d, pixel %zu", how, k);
        for (size_t k = 0; k < 4 * pixels_of(&q); k++)
            assert_true(isfinite(q.s.output[k]));
        fenced_free(want);
        unmake(&q);
    }
}

/* Held light does not leak, and what is held takes no light: a mask over everything bright, one colour elsewhere. */
static void no_bleeding(void **state) {
    rng r = {504};
    request q;
    make(&q, 64, 48, test_parameters(state).value | 4, &r);
    for (size_t k = 0; k < pixels_of(&q); k++)
        for (size_t c = 0; c < 4; c++)
            q.s.color[4 * k + c] = c == 3 ? 1 : q.values[k] == 1 ? 100 : 0.25f;
    render_now(&q);
    assert_close(q.s.output, q.s.color, 4 * pixels_of(&q), 5e-6, "held light");
    unmake(&q);
}

static void nothing_held(void **state) {
    static const float nothing[] = {0, -1, NAN, -INFINITY, -0.0f};
    rng r = {505};
    for (int i = 0; i < 2 * COUNT(nothing); i++) {
        request q;
        make(&q, 45, 34, test_parameters(state).value | (i % 2 ? 4 : 0), &r);
        if (i % 3 == 0) q.s.color[400] = NAN;
        for (size_t k = 0; k < pixels_of(&q); k++)
            q.values[k] = nothing[i / 2];
        float *got = result_of(&q);
        q.frame.holdout = NULL;
        render_now(&q);
        assert_same_bits(got, q.s.output, 4 * pixels_of(&q), "mask of %g", (double)nothing[i / 2]);
        fenced_free(got);
        unmake(&q);
    }
}

/* ---- fractions */

/* In one colour a fraction changes nothing. */
static void fractions(void **state) {
    rng r = {506};
    for (int i = 0; i < 4; i++) {
        request q;
        make(&q, 40, 40, test_parameters(state).value | 4, &r);
        for (size_t k = 0; k < pixels_of(&q); k++) {
            q.values[k] = (float)rng_unit(&r);
            for (size_t c = 0; c < 4; c++)
                q.s.color[4 * k + c] = 0.2f + 0.1f * (float)c;
        }
        render_now(&q);
        assert_close(q.s.output, q.s.color, 4 * pixels_of(&q), 5e-6, "one colour");
        unmake(&q);
    }
}

/* One pixel in the middle of a blurred picture, held more and more: it goes from what it blurs to to the input, evenly
 * as far as its own light does not matter. */
static void one_fraction(void **state) {
    rng r = {507};
    float last = -1;
    for (int i = 0; i <= 10; i++) {
        request q;
        make(&q, 31, 31, test_parameters(state).value, &r);
        const size_t middle = 15 * 31 + 15;
        const float m = 0.1f * (float)i;
        for (size_t k = 0; k < pixels_of(&q); k++) {
            q.values[k] = k == middle ? m : 0;
            q.s.coc[k] = 9;
            for (size_t c = 0; c < 4; c++)
                q.s.color[4 * k + c] = c == 3 || k == middle;
        }
        render_now(&q);
        const float got = q.s.output[4 * middle];
        assert_true(got > last && fabsf(got - m) < 0.15f);
        last = got;
        unmake(&q);
    }
    assert_true(last == 1);
}

/* Masks beyond 0..1 are limited. */
static void limited(void **state) {
    rng r = {508};
    request q;
    make(&q, 50, 30, test_parameters(state).value | 4, &r);
    for (size_t k = 0; k < pixels_of(&q); k++)
        q.values[k] = (float[]){0, 1, 0, 1, 0.25f}[k * k % 5];
    float *want = result_of(&q);
    for (size_t k = 0; k < pixels_of(&q); k++) {
        if (q.values[k] == 0) q.values[k] = k % 3 == 0 ? -7 : k % 3 == 1 ? NAN : -INFINITY;
        if (q.values[k] == 1) q.values[k] = k % 2 ? 1.5f : INFINITY;
    }
    render_now(&q);
    assert_same_bits(q.s.output, want, 4 * pixels_of(&q), "masks beyond 0 to 1");
    fenced_free(want);
    unmake(&q);
}

/* The mask in any arrangement, of floats or of half floats. */
static void arrangements(void **state) {
    rng r = {509};
    for (int i = 0; i < 2 * LAYOUT_LAST_APART; i++) {
        request q;
        make(&q, 300, 7, test_parameters(state).value, &r); /* more than the 256 that are converted at a time */
        for (size_t k = 0; k < pixels_of(&q); k++)
            q.values[k] = (float)rng_range(&r, 0, 4) / 4;
        float *want = result_of(&q);
        stored mask = stored_make((layout)(i / 2), q.s.width, q.s.height, 1, i % 2);
        stored_put(&mask, q.values, 1);
        q.frame.holdout = &mask.image;
        render_now(&q);
        assert_same_bits(q.s.output, want, 4 * pixels_of(&q), "arrangement %d, half %d", i / 2, i % 2);
        assert_gaps_intact(&mask);
        stored_free(&mask);
        fenced_free(want);
        unmake(&q);
    }
}

/* ---- what is refused */

static void refused_as(request *q, const char *word, const char *what) {
    ddof_context *ctx = context_of(0, 1);
    size_t bytes = 0;
    memset(q->s.output, 0x55, 4 * pixels_of(q) * sizeof(float));
    for (int i = 0; i < 2; i++) {
        const ddof_status status = i ? ddof_render(ctx, &q->frame, &q->settings, NULL)
                                     : ddof_scratch_bytes(ctx, &q->frame, &q->settings, &bytes);
        if (status != DDOF_ERROR_INVALID) fail_msg("%s: %s", what, ddof_status_text(status));
        const char *text = ddof_error(ctx);
        if (!strstr(text, "holdout") || !strstr(text, word)) fail_msg("%s: '%s' does not say '%s'", what, text, word);
    }
    for (size_t k = 0; k < 4 * pixels_of(q) * sizeof(float); k++)
        if (((unsigned char *)q->s.output)[k] != 0x55) fail_msg("%s: refused, but the output was written", what);
    DESTROY(ctx);
}

static void refusals(void **state) {
    rng r = {510};
    request q;
    (void)state;
    make(&q, 20, 10, 0, &r);
    const ddof_image good = q.mask;
    q.mask.width = 19, refused_as(&q, "19 x 10", "a narrow mask");
    q.mask = good, q.mask.height = 11, refused_as(&q, "20 x 11", "a high mask");
    q.mask = good, q.mask.width = 0, refused_as(&q, "0 x 10", "no width");
    q.mask = good, q.mask.plane[0].data = NULL, refused_as(&q, "NULL", "no data");
    q.mask = good, q.mask.plane[0].type = (ddof_type)7, refused_as(&q, "type", "no type");
    q.mask = good, q.mask.plane[0].pixel_stride = 6, refused_as(&q, "strides", "a stride of 6 bytes");
    q.mask = ddof_image_interleaved(q.values, 20, 5, 2, DDOF_FLOAT, 0);
    refused_as(&q, "channel", "2 channels");
    q.mask = good, q.mask.channels = 0, refused_as(&q, "channel", "no channels");
    q.mask = good, q.mask.plane[0].data = q.s.output, refused_as(&q, "overlaps", "the output itself");
    q.mask.plane[0].data = q.s.output + 4 * 200 - 1;
    q.mask.plane[0].row_stride = -80, q.mask.plane[0].pixel_stride = -4;
    refused_as(&q, "overlaps", "backwards into the output");
    q.frame.output = q.frame.color;
    q.mask = q.frame.color, q.mask.channels = 1;
    refused_as(&q, "overlaps", "a channel of the colour, in place");
    q.frame.output = scene_frame(&q.s).output;
    render_now(&q); /* which may be the mask when the output lies elsewhere */
    unmake(&q);
}

#define EACH(name, run)                                                                                                \
    {name ", heat", run, false, 0, 0}, {name ", disc", run, false, 1, 0}, {name ", heat, layers", run, false, 2, 0},   \
        {name ", disc, layers", run, false, 3, 0}, {                                                                   \
        name ", layers that blur", run, false, 6, 0                                                                    \
    }

int main(void) {
    static const test tests[] = {
        EACH("held pixels stay", stays),
        EACH("held half floats stay", stays_half),
        EACH("all held", all_held),
        EACH("the others do not see them", others),
        EACH("no light leaks", no_bleeding),
        EACH("nothing held", nothing_held),
        EACH("fractions of one colour", fractions),
        EACH("a fraction of one pixel", one_fraction),
        EACH("limited to 0..1", limited),
        EACH("masks of any arrangement", arrangements),
        {"refused", refusals, false, 0, 0},
    };
    return run_library_tests("holdout", tests, COUNT(tests));
}
