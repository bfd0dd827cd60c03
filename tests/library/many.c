/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Many images with one depth or CoC: each has the bits that it has by itself, whatever the others hold, and what is wrong with one
 * of them is refused by its index. */
#include "layout.h"
#include "support.h"

#include <math.h>
#include <string.h>

enum { MOST = 12 };

/* Images in memory of their own, as a caller has them. */
typedef struct images {
    int count;
    stored in[MOST], out[MOST]; /* out without memory: in place */
    ddof_alpha alpha[MOST];
} images;

static void image_values(float *rgba, const scene *s, int index, bool holes, rng *r) {
    fill_color(rgba, s->width, s->height, (color_pattern)(index % COLOR_PATTERNS), r);
    for (int k = 0; k < s->width * s->height; k++) {
        if (index % 2) rgba[4 * k + 3] = (float)(k % 5) / 4;
        if (!holes) continue;
        if (rng_bits(r) % 40 == 0) rgba[4 * k + (int)(rng_bits(r) % 4)] = rng_bits(r) % 2 ? NAN : INFINITY;
        if (k / s->width % 17 == index % 17) rgba[4 * k] = NAN; /* rows of nothing else, others in each image */
    }
}

static images images_make(const scene *s, int count, rng *r) {
    images m = {.count = count};
    for (int i = 0; i < count; i++) {
        const int channels = i == 0 ? 4 : rng_range(r, 1, 4);
        int arrangement = rng_range(r, 0, LAYOUTS - 1);
        if (channels == 1 && arrangement == LAYOUT_LAST_APART) arrangement = LAYOUT_PLANAR;
        const unsigned half = rng_bits(r) % 3 == 0 ? 15 : rng_bits(r) % 3 == 0 ? rng_bits(r) & 15 : 0;
        m.in[i] = stored_make((layout)arrangement, s->width, s->height, channels, half);
        if (rng_bits(r) % 2) m.out[i] = stored_make((layout)rng_range(r, 0, LAYOUT_REVERSED), s->width, s->height, channels, half);
        if (channels % 2 == 0 && rng_bits(r) % 2) m.alpha[i] = DDOF_ALPHA_STRAIGHT;
    }
    return m;
}

/* holes: in every third image. */
static void images_fill(images *m, const scene *s, bool holes, uint64_t seed) {
    for (int i = 0; i < m->count; i++) {
        rng r = {seed + (uint64_t)i};
        image_values(s->color, s, i, holes && i % 3 == 1, &r);
        stored_put(&m->in[i], s->color, 4);
    }
}

static ddof_pair pair_of(const images *m, int i) {
    ddof_pair pair = {m->in[i].image, m->out[i].memory ? m->out[i].image : m->in[i].image};
    pair.color.alpha = m->alpha[i];
    return pair;
}

static void images_free(images *m) {
    for (int i = 0; i < m->count; i++) {
        assert_gaps_intact(&m->in[i]);
        if (m->out[i].memory) {
            assert_gaps_intact(&m->out[i]);
            stored_free(&m->out[i]);
        }
        stored_free(&m->in[i]);
    }
}

static void result(const images *m, int i, const scene *s, float *rgba) {
    memset(rgba, 0, (size_t)s->width * (size_t)s->height * 4 * sizeof *rgba);
    stored_get(m->out[i].memory ? &m->out[i] : &m->in[i], rgba, 4);
}

/* What each becomes alone, by one thread; and the counts of all. */
static ddof_stats alone(unsigned isa, ddof_backend backend, const ddof_frame *base, const ddof_settings *settings, const images *m,
                        const scene *s, float *const *want) {
    ddof_stats all = {0};
    ddof_context *ctx = NULL;
    const ddof_config config = {.backend = backend, .cpu_mask = isa, .threads = 1};
    assert_int_equal(ddof_create(&ctx, &config), DDOF_OK);
    for (int i = 0; i < m->count; i++) {
        ddof_frame frame = *base;
        const ddof_pair pair = pair_of(m, i);
        frame.color = pair.color;
        frame.output = pair.output;
        const ddof_stats stats = render(ctx, &frame, settings);
        if (stats.nonfinite_pixels > all.nonfinite_pixels) all.nonfinite_pixels = stats.nonfinite_pixels;
        all.sprites += stats.sprites;
        result(m, i, s, want[i]);
    }
    DESTROY(ctx);
    return all;
}

/* The same images rendered by `ctx` in one call. */
static void assert_as_alone(ddof_context *ctx, unsigned isa, ddof_backend backend, const ddof_frame *base, const ddof_settings *settings,
                            images *m, const scene *s, bool holes, uint64_t seed) {
    float *want[MOST];
    const size_t values = (size_t)s->width * (size_t)s->height * 4;
    for (int i = 0; i < m->count; i++) want[i] = fenced(values * sizeof(float), true);
    images_fill(m, s, holes, seed);
    const ddof_stats expected = alone(isa, backend, base, settings, m, s, want);
    images_fill(m, s, holes, seed); /* those in place are gone */
    ddof_pair more[MOST];
    for (int i = 1; i < m->count; i++) more[i - 1] = pair_of(m, i);
    ddof_frame frame = *base;
    frame.color = pair_of(m, 0).color;
    frame.output = pair_of(m, 0).output;
    frame.more = m->count > 1 ? more : NULL;
    frame.more_count = m->count - 1;
    const ddof_stats stats = render(ctx, &frame, settings);
    assert_int_equal(stats.nonfinite_pixels, expected.nonfinite_pixels);
    assert_int_equal(stats.sprites, expected.sprites);
    for (int i = 0; i < m->count; i++) {
        result(m, i, s, s->color);
        assert_same_bits(s->color, want[i], values, "%d x %d, image %d of %d, %d channels%s", s->width, s->height, i, m->count,
                         m->in[i].image.channels, m->out[i].memory ? "" : ", in place");
        fenced_free(want[i]);
    }
}

/* ---- the CPU engine */

static const int sizes[][2] = {{1, 1}, {64, 64}, {97, 53}, {130, 33}, {300, 3}, {5, 300}, {192, 31}, {17, 16}, {65, 128}};

static void run_cases(unsigned isa, int threads, int cases, bool holes, ddof_settings (*settings_of)(int)) {
    rng r = {70};
    ddof_context *ctx = context_of(isa, threads);
    for (int i = 0; i < cases; i++) {
        const int *size = sizes[i % COUNT(sizes)];
        scene s = scene_fill(size[0], size[1], (coc_pattern)(i % COC_PATTERNS), COLOR_RANDOM, &r);
        for (int k = 0; k < s.width * s.height && holes && i % 2; k++)
            if (rng_bits(&r) % 60 == 0 || k / s.width == 2) s.coc[k] = NAN;
        images m = images_make(&s, rng_range(&r, 1, MOST), &r);
        ddof_frame base = scene_frame(&s);
        const ddof_settings settings = settings_of(i);
        assert_as_alone(ctx, isa, DDOF_BACKEND_CPU, &base, &settings, &m, &s, holes, rng_bits(&r));
        images_free(&m);
        scene_free(&s);
    }
    DESTROY(ctx);
}

static ddof_settings heat(int i) {
    return (ddof_settings){.conductance = (ddof_conductance)(i % 2), .substeps = i % 3};
}

static ddof_settings disc(int i) {
    return (ddof_settings){.kernel = DDOF_KERNEL_DISC, .quality = (ddof_quality)(i % 3 + 1)};
}

static void bits_of_heat(void **state) {
    run_cases(test_parameters(state).isa, test_parameters(state).value, 27, false, heat);
}

static void holes_of_heat(void **state) {
    run_cases(test_parameters(state).isa, test_parameters(state).value, 36, true, heat);
}

static void bits_of_disc(void **state) {
    run_cases(test_parameters(state).isa, test_parameters(state).value, 18, true, disc);
}

/* Layers, a holdout, sprites and the classical methods, of depth. */
static void everything_else(void **state) {
    static const ddof_settings settings[] = {
        {.layers = DDOF_LAYERS_AUTO},
        {.layers = DDOF_LAYERS_AUTO, .kernel = DDOF_KERNEL_DISC, .bokeh = DDOF_BOKEH_HIGHLIGHTS},
        {.bokeh = DDOF_BOKEH_HIGHLIGHTS},
        {.bokeh = DDOF_BOKEH_FULL},
        {.method = DDOF_METHOD_GAUSSIAN},
        {.method = DDOF_METHOD_HEXAGON},
        {.substeps = 2},
    };
    rng r = {71};
    ddof_context *ctx = context_of(test_parameters(state).isa, 3);
    for (int i = 0; i < 2 * COUNT(settings); i++) {
        scene s = scene_fill(70, 45, COC_SMALL, COLOR_RANDOM, &r);
        for (int k = 0; k < 70 * 45; k++) s.coc[k] = k % 70 < 30 ? 1.5f : 3 + (float)(k % 7);
        images m = images_make(&s, 4, &r);
        float mask[70 * 45];
        for (int k = 0; k < 70 * 45; k++) mask[k] = (float)(k % 70 > 50);
        const ddof_image holdout = ddof_image_interleaved(mask, 70, 45, 1, DDOF_FLOAT, 0);
        ddof_frame base = scene_frame(&s);
        base.depth = base.coc;
        base.coc = (ddof_image){0};
        if (i % 2) base.holdout = &holdout;
        ddof_settings now = settings[i / 2];
        now.lens = (ddof_lens){.kind = DDOF_LENS_ARTIST, .focus_distance = 3, .max_coc_near = 0.1, .max_coc_far = 0.15};
        assert_as_alone(ctx, test_parameters(state).isa, DDOF_BACKEND_CPU, &base, &now, &m, &s, i % 2, rng_bits(&r));
        images_free(&m);
        scene_free(&s);
    }
    DESTROY(ctx);
}

/* ---- any backend */

static void backends(void **state) {
    const ddof_backend backend = (ddof_backend)test_parameters(state).value;
    rng r = {72};
    ddof_context *ctx = NULL;
    const ddof_config config = {.backend = backend};
    assert_int_equal(ddof_create(&ctx, &config), DDOF_OK);
    for (int i = 0; i < 3; i++) {
        scene s = scene_fill(80, 47, COC_SMOOTH, COLOR_RANDOM, &r);
        images m = images_make(&s, 3, &r);
        ddof_frame base = scene_frame(&s);
        const ddof_settings settings = {.layers = i == 2 ? DDOF_LAYERS_AUTO : DDOF_LAYERS_OFF};
        assert_as_alone(ctx, 0, backend, &base, &settings, &m, &s, i == 1, rng_bits(&r));
        images_free(&m);
        scene_free(&s);
    }
    DESTROY(ctx);
}

static void left_out(void **state) {
    (void)state;
}

/* Skipped, and counted so, where the backend cannot be had. */
static test of_backend(ddof_backend backend, const char *name, const char *skipped) {
    ddof_context *ctx = NULL;
    const ddof_config config = {.backend = backend};
    const bool here = ddof_create(&ctx, &config) != DDOF_ERROR_UNSUPPORTED;
    ddof_destroy(&ctx);
    return (test){here ? name : skipped, here ? backends : left_out, false, (int)backend, 0};
}

/* ---- progress */

typedef struct watch {
    double shown;
    int calls;
    bool falls;
} watch;

static int watch_progress(void *user, double done) {
    watch *w = user;
    w->falls |= done < w->shown || done > 1;
    w->shown = done;
    return w->calls-- == 0;
}

/* It rises over all images, and cancels in each of them. */
static void progress(void **state) {
    (void)state;
    rng r = {73};
    for (int layers = 0; layers < 2; layers++) {
        watch w = {.calls = -1};
        ddof_context *ctx = NULL;
        const ddof_config config = {.threads = 2, .progress = watch_progress, .progress_user = &w};
        const ddof_settings settings = {.layers = layers ? DDOF_LAYERS_AUTO : DDOF_LAYERS_OFF};
        scene s = scene_fill(90, 70, COC_SMOOTH, COLOR_RANDOM, &r);
        images m = images_make(&s, 5, &r);
        ddof_pair more[4];
        ddof_frame frame = scene_frame(&s);
        images_fill(&m, &s, false, 1);
        for (int i = 1; i < 5; i++) more[i - 1] = pair_of(&m, i);
        frame.more = more;
        frame.more_count = 4;
        assert_int_equal(ddof_create(&ctx, &config), DDOF_OK);
        render(ctx, &frame, &settings);
        assert_false(w.falls);
        assert_true(w.shown > 0.9);
        const int calls = -1 - w.calls;
        assert_true(calls > 10);
        for (int stop = 0; stop < calls / 2; stop += 3) {
            w = (watch){.calls = stop};
            assert_int_equal(ddof_render(ctx, &frame, &settings, NULL), DDOF_ERROR_CANCELLED);
        }
        DESTROY(ctx);
        images_free(&m);
        scene_free(&s);
    }
}

/* ---- what is refused */

enum { W = 6, H = 5, VALUES = W * H * 4 };

static void assert_refused(ddof_context *ctx, const ddof_frame *frame, const char *word) {
    const ddof_settings settings = {0};
    size_t bytes;
    assert_int_equal(ddof_render(ctx, frame, &settings, NULL), DDOF_ERROR_INVALID);
    if (!strstr(ddof_error(ctx), word)) fail_msg("'%s' does not say '%s'", ddof_error(ctx), word);
    assert_int_equal(ddof_scratch_bytes(ctx, frame, &settings, &bytes), DDOF_ERROR_INVALID);
}

static void refused(void **state) {
    (void)state;
    static float color[3][VALUES], output[3][VALUES], coc[W * H];
    ddof_context *ctx = context_of(0, 1);
    ddof_pair good[2], more[2];
    ddof_frame frame = {.coc = ddof_image_interleaved(coc, W, H, 1, DDOF_FLOAT, 0), .more = more, .more_count = 2};
    const ddof_settings settings = {0};
    for (int i = 0; i < 3; i++) {
        const ddof_pair pair = {ddof_image_interleaved(color[i], W, H, 4, DDOF_FLOAT, 0),
                                ddof_image_interleaved(output[i], W, H, 4, DDOF_FLOAT, 0)};
        if (i)
            good[i - 1] = pair;
        else
            frame.color = pair.color, frame.output = pair.output;
    }
#define REFUSED(change, word)               \
    do {                                    \
        memcpy(more, good, sizeof more);    \
        change;                             \
        assert_refused(ctx, &frame, word);  \
    } while (0)
    memcpy(more, good, sizeof more);
    render(ctx, &frame, &settings);
    REFUSED(more[1].color.channels = 0, "frame.more[1].color has 0 channels");
    REFUSED(more[0].color.channels = 5, "frame.more[0].color has 5 channels");
    REFUSED(more[1].output.channels = 3, "frame.more[1].output has 3 channels, it must have 4");
    REFUSED(more[1].color.plane[2].data = NULL, "frame.more[1].color.plane[2].data is NULL");
    REFUSED(more[0].output.plane[1].type = (ddof_type)7, "frame.more[0].output.plane[1].type");
    REFUSED(more[1].color.width = more[1].output.width = W - 1, "frame.more[1].color is 5 x 5 but frame.color is 6 x 5");
    REFUSED(more[1].output.height = H - 1, "frame.more[1].output is 6 x 4");
    REFUSED(more[0].color.alpha = (ddof_alpha)2, "frame.more[0].color.alpha");
    REFUSED((more[1].color.channels = more[1].output.channels = 3, more[1].color.alpha = DDOF_ALPHA_STRAIGHT),
            "frame.more[1].color: straight alpha");
    REFUSED(more[1].output = more[0].output, "frame.more[1].output overlaps frame.more[0].output in memory");
    REFUSED(more[1].output = frame.output, "frame.more[1].output overlaps frame.output");
    REFUSED(more[0].output = more[1].color, "frame.more[0].output overlaps frame.more[1].color");
    REFUSED(more[0].output = frame.color, "frame.more[0].output overlaps frame.color");
    REFUSED(more[1].output = ddof_image_interleaved(color[2] + 4, W, H - 1, 4, DDOF_FLOAT, 0), "frame.more[1].output is 6 x 4");
    REFUSED(more[1].color = more[1].output = ddof_image_interleaved(coc, W, H, 1, DDOF_FLOAT, 0), "frame.more[1].output overlaps frame.coc");
    memcpy(more, good, sizeof more);
    frame.output = more[1].color;
    assert_refused(ctx, &frame, "frame.output overlaps frame.more[1].color");
    frame.output = ddof_image_interleaved(output[0], W, H, 4, DDOF_FLOAT, 0);
    frame.holdout = &more[1].output;
    more[1].output.channels = more[1].color.channels = 1;
    assert_refused(ctx, &frame, "frame.more[1].output overlaps frame.holdout");
    frame.holdout = NULL;
    memcpy(more, good, sizeof more);
    frame.more_count = -1;
    assert_refused(ctx, &frame, "frame.more_count is -1");
    frame.more_count = 256;
    assert_refused(ctx, &frame, "frame.more_count is 256: give 0 to 255");
    frame.more_count = 0;
    assert_refused(ctx, &frame, "must both be given");
    frame.more_count = 2;
    frame.more = NULL;
    assert_refused(ctx, &frame, "must both be given");
    frame.more = more;
    frame.reserved_int = 1;
    assert_refused(ctx, &frame, "reserved");
    frame.reserved_int = 0;
    render(ctx, &frame, &settings); /* the context goes on working */
    more[0].output = more[0].color;
    more[1].color = good[0].color; /* one input for two is no overlap of an output, unless one of them is in place */
    assert_refused(ctx, &frame, "frame.more[0].output overlaps frame.more[1].color");
    more[0].output = good[0].output;
    render(ctx, &frame, &settings);
    DESTROY(ctx);
}

int main(void) {
    const test tests[] = {
        {"heat, 1 thread", bits_of_heat, true, 1, 0},
        {"heat, 3 threads", bits_of_heat, true, 3, 0},
        {"heat with holes, 1 thread", holes_of_heat, true, 1, 0},
        {"heat with holes, 4 threads", holes_of_heat, true, 4, 0},
        {"disc, 2 threads", bits_of_disc, true, 2, 0},
        {"layers, holdout, sprites, classical methods", everything_else, true, 0, 0},
        {"reference", backends, false, DDOF_BACKEND_REFERENCE, 0},
        of_backend(DDOF_BACKEND_GL, "GL", "GL # SKIP there is none here"),
        of_backend(DDOF_BACKEND_VULKAN, "Vulkan", "Vulkan # SKIP there is none here"),
        {"progress and cancelling", progress, false, 0, 0},
        {"what is refused", refused, false, 0, 0},
    };
    return run_library_tests("many", tests, COUNT(tests));
}
