/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* What must hold of the disc kernel for any picture. Every direction is a symmetric matrix whose rows sum to 1, so
 * constants and the sum stay; but it is no average, so the result may leave the range of the input: by how much, is
 * measured here. */
#include "disc_support.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const int sizes[][2] = {{1, 1}, {1, 50}, {50, 1}, {2, 2}, {16, 16}, {67, 33}, {33, 67}, {700, 3}, {3, 700}};

static size_t pixels_of(const disc_picture *p) {
    return (size_t)p->width * (size_t)p->height;
}

static disc_picture random_picture(int width, int height, coc_pattern coc, rng *r) {
    disc_picture p = disc_picture_make(width, height, 0);
    fill_coc(p.coc, width, height, coc, r);
    for (size_t i = 0; i < pixels_of(&p); i++)
        p.color[i] = (float)(2 * rng_unit(r) - 1);
    return p;
}

/* CoC where a kernel rings most: about 1 to 3 px, with much sharper and much blurrier pixels among them. */
static void wild_coc(disc_picture *p, int kind, rng *r) {
    for (size_t i = 0; i < pixels_of(p); i++) {
        const double u = rng_unit(r), v = rng_unit(r);
        const double d[] = {
            0.5 + 2.5 * u, 1 + u, v < 0.5 ? 0 : 1 + 3 * u, pow(10, 3 * u - 1), v < 0.5 ? 1e4 : 1 + 2 * u, 2 + 20 * u};
        p->coc[i] = (float)d[kind % COUNT(d)];
    }
}

typedef void (*picture_check)(const disc_case *c, disc_picture *p, ddof_quality quality, const char *what);

static void for_all(const disc_case *c, uint64_t seed, picture_check check) {
    rng r = {seed};
    for (int i = 0; i < COUNT(sizes); i++)
        for (int coc = 0; coc < COC_PATTERNS; coc++)
            for (int q = 0; q < 3; q++) {
                disc_picture p = random_picture(sizes[i][0], sizes[i][1], (coc_pattern)coc, &r);
                char what[80];
                snprintf(what, sizeof what, "%d x %d, CoC pattern %d, %s", p.width, p.height, coc,
                         disc_quality_names[disc_qualities[q]]);
                check(c, &p, disc_qualities[q], what);
                disc_picture_free(&p);
            }
}

static void check_constant(const disc_case *c, disc_picture *p, ddof_quality quality, const char *what) {
    for (size_t i = 0; i < pixels_of(p); i++)
        p->color[i] = -3.3f;
    disc_picture_render(c, p, quality, 1.25);
    for (size_t i = 0; i < pixels_of(p); i++)
        if (!(fabs(p->output[i] / -3.3f - 1) <= 1e-6 + c->backend->tolerance))
            fail_msg("%s: -3.3 became %.9g", what, p->output[i]);
}

static void constant(const disc_case *c) {
    for_all(c, 70, check_constant);
}

static void check_sum(const disc_case *c, disc_picture *p, ddof_quality quality, const char *what) {
    double before = 0, after = 0, all = 0;
    disc_picture_render(c, p, quality, 1.25);
    for (size_t i = 0; i < pixels_of(p); i++) {
        before += p->color[i];
        after += p->output[i];
        all += fabs(p->color[i]);
    }
    if (!(fabs(after - before) <= (1e-6 + c->backend->tolerance) * all))
        fail_msg("%s: the sum %.9g became %.9g", what, before, after);
}

static void sum(const disc_case *c) {
    for_all(c, 71, check_sum);
}

/* In focus nothing changes. */
static void sharp(const disc_case *c) {
    rng r = {72};
    for (int q = 0; q < 3; q++) {
        disc_picture p = random_picture(61, 43, COC_ZERO, &r);
        disc_picture_render(c, &p, disc_qualities[q], 0);
        assert_close(p.output, p.color, pixels_of(&p), c->backend->tolerance, "CoC 0");
        disc_picture_free(&p);
    }
}

static void linear(const disc_case *c) {
    rng r = {73};
    for (int i = 0; i < 30; i++) {
        disc_picture a = random_picture(rng_range(&r, 1, 90), rng_range(&r, 1, 90), (coc_pattern)(i % COC_BEYOND), &r);
        disc_picture b = random_picture(a.width, a.height, COC_ZERO, &r),
                     both = random_picture(a.width, a.height, COC_ZERO, &r);
        const ddof_quality quality = disc_qualities[i % 3];
        const size_t n = pixels_of(&a);
        memcpy(b.coc, a.coc, n * sizeof(float));
        memcpy(both.coc, a.coc, n * sizeof(float));
        for (size_t k = 0; k < n; k++)
            both.color[k] = (float)(a.color[k] - 1.7 * b.color[k]);
        disc_picture_render(c, &a, quality, 0);
        disc_picture_render(c, &b, quality, 0);
        disc_picture_render(c, &both, quality, 0);
        for (size_t k = 0; k < n; k++)
            a.output[k] = (float)(a.output[k] - 1.7 * b.output[k]);
        assert_close(both.output, a.output, n, 4 * c->backend->tolerance + 1e-6, "%d x %d", a.width, a.height);
        disc_picture_free(&a);
        disc_picture_free(&b);
        disc_picture_free(&both);
    }
}

/* Only the magnitude of the CoC counts, up to its limit. */
static void sign(const disc_case *c) {
    rng r = {74};
    disc_picture p = random_picture(57, 41, COC_BEYOND, &r), q = random_picture(57, 41, COC_ZERO, &r);
    memcpy(q.color, p.color, pixels_of(&p) * sizeof(float));
    for (size_t i = 0; i < pixels_of(&p); i++) {
        if (i % 2) p.coc[i] = (float)(20 * rng_unit(&r));
        q.coc[i] = -fminf(p.coc[i], 1e5f);
    }
    disc_picture_render(c, &p, DDOF_QUALITY_GOOD, 0);
    disc_picture_render(c, &q, DDOF_QUALITY_GOOD, 0);
    assert_close(q.output, p.output, pixels_of(&p), c->backend->tolerance, "negative CoC");
    disc_picture_free(&p);
    disc_picture_free(&q);
}

/* ---- symmetries: directions are run in an order, and do not commute where the CoC varies */

typedef enum change { TURNED /* by 180 degrees */, ACROSS, DOWN, TRANSPOSED } change;

static void apply(float *to, const float *from, int width, int height, change how) {
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            const int u = how == TURNED || how == ACROSS ? width - 1 - x : x,
                      v = how == TURNED || how == DOWN ? height - 1 - y : y;
            to[how == TRANSPOSED ? x * height + y : v * width + u] = from[y * width + x];
        }
}

/* Largest difference between the blur of the changed picture and the changed blur. */
static double asymmetry(const disc_case *c, disc_picture *p, ddof_quality quality, change how) {
    disc_picture m =
        disc_picture_make(how == TRANSPOSED ? p->height : p->width, how == TRANSPOSED ? p->width : p->height, 0);
    apply(m.color, p->color, p->width, p->height, how);
    apply(m.coc, p->coc, p->width, p->height, how);
    disc_picture_render(c, p, quality, 0);
    disc_picture_render(c, &m, quality, 0);
    apply(m.color, p->output, p->width, p->height, how);
    const double worst = worst_difference(m.output, m.color, pixels_of(p));
    disc_picture_free(&m);
    return worst;
}

/* Turned by 180 degrees every direction is itself: the same for any CoC. Of one CoC rows and columns commute, so a
 * picture may be transposed; draft, which has no diagonals, may be mirrored whatever the CoC. */
static void symmetries(const disc_case *c) {
    rng r = {75};
    for (int i = 0; i < 60; i++) {
        const ddof_quality quality = disc_qualities[i % 3];
        disc_picture p = random_picture(rng_range(&r, 1, 80), rng_range(&r, 1, 80), (coc_pattern)(i % COC_BEYOND), &r);
        double worst = asymmetry(c, &p, quality, TURNED);
        if (quality == DDOF_QUALITY_DRAFT)
            worst = fmax(worst, fmax(asymmetry(c, &p, quality, ACROSS), asymmetry(c, &p, quality, DOWN)));
        for (size_t k = 0; k < pixels_of(&p); k++)
            p.coc[k] = (float)(1 + i % 20);
        worst = fmax(worst, asymmetry(c, &p, quality, TRANSPOSED));
        if (!(worst <= 4 * c->backend->tolerance + 1e-6))
            fail_msg("%d x %d, %s: %.3g", p.width, p.height, disc_quality_names[quality], worst);
        disc_picture_free(&p);
    }
}

/* Away from the borders, of one CoC, everything commutes: mirrors too. */
static void mirrors(const disc_case *c) {
    for (int i = 0; i < 12; i++) {
        const ddof_quality quality = disc_qualities[i % 3];
        const double d = 2 + i;
        disc_picture p = disc_picture_make(201, 191, d);
        *disc_picture_middle(p.color, &p) = 1;
        *(disc_picture_middle(p.color, &p) + 5) = 0.5f;
        const double worst = fmax(asymmetry(c, &p, quality, ACROSS), asymmetry(c, &p, quality, DOWN));
        if (!(worst <= c->backend->tolerance + 1e-6)) fail_msg("%s, d %g: %.3g", disc_quality_names[quality], d, worst);
        disc_picture_free(&p);
    }
}

/* Where the CoC varies, mirrored and transposed pictures differ by this much of the range at most (measured: 0.47, of
 * noise between -1 and 1). */
static void order(const disc_case *c) {
    rng r = {76};
    double worst = 0;
    for (int i = 0; i < 48; i++) {
        disc_picture p = random_picture(40, 30, COC_ZERO, &r);
        wild_coc(&p, i / 2, &r);
        worst = fmax(worst, asymmetry(c, &p, disc_qualities[1 + i % 2], i / 12 % 2 ? ACROSS : TRANSPOSED));
        disc_picture_free(&p);
    }
    if (getenv("DISC_FIGURES")) fprintf(stderr, "order of directions: %.3f\n", worst);
    assert_true(worst <= 0.6);
}

static double dot(const float *a, const float *b, size_t count) {
    double total = 0;
    for (size_t i = 0; i < count; i++)
        total += (double)a[i] * b[i];
    return total;
}

/* One line is a symmetric matrix, whatever the CoC: <A x, y> = <x, A y>. */
static void self_adjoint(const disc_case *c) {
    rng r = {77};
    for (int i = 0; i < 60; i++) {
        const int n = rng_range(&r, 1, 900), coc = i % COC_BEYOND;
        disc_picture a = random_picture(i % 2 ? n : 1, i % 2 ? 1 : n, (coc_pattern)coc, &r);
        disc_picture b = random_picture(a.width, a.height, COC_ZERO, &r);
        memcpy(b.coc, a.coc, (size_t)n * sizeof(float));
        disc_picture_render(c, &a, disc_qualities[i / 2 % 3], 0);
        disc_picture_render(c, &b, disc_qualities[i / 2 % 3], 0);
        const double left = dot(a.output, b.color, (size_t)n), right = dot(a.color, b.output, (size_t)n);
        if (!(fabs(left - right) <= (c->backend->tolerance + 1e-6) *
                                        sqrt(dot(a.color, a.color, (size_t)n) * dot(b.color, b.color, (size_t)n))))
            fail_msg("line of %d, CoC pattern %d: <Ax,y> = %.9g, <x,Ay> = %.9g", n, coc, left, right);
        disc_picture_free(&a);
        disc_picture_free(&b);
    }
}

/* ---- leaving the range */

/* The most a pixel of the result can be, when all pixels lie within -1..1: the largest sum of magnitudes in a row of
 * the matrix, whose columns are the blurs of single pixels. Measured over random CoC: 1.12; sought after by hill
 * climbing: 1.19. */
static void gain(const disc_case *c) {
    rng r = {78};
    double most = 0;
    for (int i = 0; i < 36; i++) {
        disc_picture p = disc_picture_make(9, 8, 0);
        double row[72] = {0};
        wild_coc(&p, i / 3, &r);
        for (size_t k = 0; k < pixels_of(&p); k++) {
            p.color[k] = 1;
            disc_picture_render(c, &p, disc_qualities[i % 3], 0);
            p.color[k] = 0;
            for (size_t j = 0; j < pixels_of(&p); j++)
                row[j] += fabs(p.output[j]);
        }
        for (int j = 0; j < COUNT(row); j++)
            most = fmax(most, row[j]);
        disc_picture_free(&p);
    }
    if (getenv("DISC_FIGURES")) fprintf(stderr, "gain: %.3f\n", most);
    if (!(most <= 1.2)) fail_msg("a pixel can grow %.3f times", most);
}

/* The norm: no picture grows. Noise of -1 and 1 stays within its range and a little. */
static void noise(const disc_case *c) {
    rng r = {79};
    double norm = 0, most = 0;
    for (int i = 0; i < 90; i++) {
        disc_picture p = random_picture(50, 40, COC_ZERO, &r);
        wild_coc(&p, i / 3, &r);
        for (size_t k = 0; k < pixels_of(&p); k++)
            p.color[k] = rng_bits(&r) & 1 ? 1 : -1;
        disc_picture_render(c, &p, disc_qualities[i % 3], 0);
        most = fmax(most, magnitude(p.output, pixels_of(&p)));
        norm = fmax(norm, sqrt(dot(p.output, p.output, pixels_of(&p)) / (double)pixels_of(&p)));
        disc_picture_free(&p);
    }
    if (getenv("DISC_FIGURES")) fprintf(stderr, "noise: %.3f, norm %.3f\n", most, norm);
    if (!(norm <= 1 + c->backend->tolerance && most <= 1.09 + c->backend->tolerance))
        fail_msg("norm %.4f, largest %.4f", norm, most);
}

typedef struct ringing {
    ddof_quality quality;
    double edge, light; /* beside an edge, of its height; beside a light, of its disc's plateau: docs/disc.md */
} ringing;

/* How far below black, or above white, an edge between them goes, and how far below black a light in the dark (its own
 * middle apart, where a single pixel shows). */
static void overshoot(const disc_case *c) {
    static const ringing allowed[] = {
        {DDOF_QUALITY_DRAFT, 0.007, 0.012}, {DDOF_QUALITY_GOOD, 0.004, 0.020}, {DDOF_QUALITY_BEST, 0.003, 0.025}};
    for (int q = 0; q < 3; q++)
        for (int k = 0; k < 4; k++) {
            const double d = (double[]){4, 12, 24, 60}[k];
            disc_picture p = disc_picture_make(301, 41, d);
            double low = 0, high = 0;
            for (size_t i = 0; i < pixels_of(&p); i++)
                p.color[i] = i % 301 > 150;
            disc_picture_render(c, &p, allowed[q].quality, 0);
            for (size_t i = 0; i < pixels_of(&p); i++) {
                low = fmin(low, p.output[i]);
                high = fmax(high, p.output[i] - 1.0);
            }
            disc_picture_free(&p);

            p = disc_picture_make(301, 301, d);
            double dark = 0;
            for (int y = -1; y <= 1; y++)
                for (int x = -1; x <= 1; x++)
                    disc_picture_middle(p.color, &p)[y * 301 + x] = 1e6f / 9;
            disc_picture_render(c, &p, allowed[q].quality, 0);
            for (size_t i = 0; i < pixels_of(&p); i++)
                dark = fmin(dark, p.output[i] / 1e6 * d * d * 0.7853981634);
            disc_picture_free(&p);
            if (getenv("DISC_FIGURES"))
                fprintf(stderr, "%s, d %g: edge %.4f %.4f, light %.4f\n", disc_quality_names[allowed[q].quality], d,
                        -low, high, -dark);
            const double edge = allowed[q].edge + c->backend->tolerance;
            if (!(-low <= edge && high <= edge && -dark <= allowed[q].light))
                fail_msg("%s, d %g: edge %.4f below, %.4f above, light %.4f below",
                         disc_quality_names[allowed[q].quality], d, -low, high, -dark);
        }
}

/* ---- values */

/* What is not a number is filled by its neighbours, counted, and passed on to none; pictures of holes are 0. */
static void holes(const disc_case *c) {
    rng r = {80};
    for (int i = 0; i < 60; i++) {
        const ddof_settings settings = disc_settings(disc_qualities[i % 3]);
        disc_picture p = random_picture(rng_range(&r, 1, 60), rng_range(&r, 1, 40), (coc_pattern)(i % COC_BEYOND), &r);
        int64_t lost = 0;
        for (size_t k = 0; k < pixels_of(&p); k++) {
            p.color[k] = 0.7f;
            if (rng_bits(&r) % 5 && i != 59) continue;
            *(k % 2 ? &p.color[k] : &p.coc[k]) = k % 3 ? NAN : INFINITY;
            lost++;
        }
        const ddof_frame frame = {.color = ddof_image_interleaved(p.color, p.width, p.height, 1, DDOF_FLOAT, 0),
                                  .coc = ddof_image_interleaved(p.coc, p.width, p.height, 1, DDOF_FLOAT, 0),
                                  .output = ddof_image_interleaved(p.output, p.width, p.height, 1, DDOF_FLOAT, 0)};
        assert_int_equal(render(c->context, &frame, &settings).nonfinite_pixels, lost);
        const double want = lost == (int64_t)pixels_of(&p) ? 0 : 0.7f;
        for (size_t k = 0; k < pixels_of(&p); k++)
            if (!(fabs(p.output[k] - want) <= 2 * c->backend->tolerance))
                fail_msg("%d x %d, CoC pattern %d: pixel %zu of a constant picture with holes is %.9g", p.width,
                         p.height, i % COC_BEYOND, k, p.output[k]);
        disc_picture_free(&p);
    }
}

/* 1e6 beside 0, values below 0, colour where alpha is 0: finite, and the same as the float64 reference. */
static void extremes(const disc_case *c) {
    rng r = {81};
    ddof_context *reference = reference_context();
    for (int i = 0; i < 60; i++) {
        const ddof_settings settings = disc_settings(disc_qualities[i % 3]);
        scene s =
            scene_fill(rng_range(&r, 1, 90), rng_range(&r, 1, 60), (coc_pattern)(i % COC_BEYOND), COLOR_SIGNED, &r);
        const size_t n = 4 * (size_t)s.width * (size_t)s.height;
        float *want = malloc(n * sizeof *want);
        for (size_t k = 0; k < n; k++)
            s.color[k] = k % 4 == 3 ? (float)(rng_bits(&r) % 3) / 2 : rng_bits(&r) % 50 ? 0 : 1e6f * s.color[k];
        ddof_frame frame = scene_frame(&s);
        frame.pixel_aspect = (double[]){0, 0.5, 2}[i % 3];
        render(c->context, &frame, &settings);
        frame.output = ddof_image_interleaved(want, s.width, s.height, 4, DDOF_FLOAT, 0);
        render(reference, &frame, &settings);
        for (size_t k = 0; k < n; k++)
            assert_true(isfinite(s.output[k]));
        assert_close(s.output, want, n, 1e6 * c->backend->tolerance, "%d x %d, CoC pattern %d", s.width, s.height,
                     i % COC_BEYOND);
        free(want);
        scene_free(&s);
    }
    DESTROY(reference);
}

/* Straight alpha: colour of no weight does not come in. */
static void alpha(const disc_case *c) {
    rng r = {82};
    scene s = scene_fill(70, 50, COC_SMOOTH, COLOR_RANDOM, &r);
    const ddof_settings settings = disc_settings(DDOF_QUALITY_GOOD);
    for (size_t k = 0; k < 70 * 50; k++) {
        const bool there = k % 70 < 35;
        for (int v = 0; v < 3; v++)
            s.color[4 * k + (size_t)v] = there ? 0.25f : 9;
        s.color[4 * k + 3] = there;
    }
    ddof_frame frame = scene_frame(&s);
    frame.color.alpha = DDOF_ALPHA_STRAIGHT;
    render(c->context, &frame, &settings);
    for (size_t k = 0; k < 70 * 50; k++) {
        assert_true(isfinite(s.output[4 * k]));
        if (s.output[4 * k + 3] > 0.05f && !(fabs(s.output[4 * k] - 0.25) <= 100 * c->backend->tolerance))
            fail_msg("pixel %zu: colour %.9g where alpha is %.9g", k, s.output[4 * k], s.output[4 * k + 3]);
    }
    scene_free(&s);
}

/* No more memory for a wider blur. */
static void memory(const disc_case *c) {
    size_t bytes[2];
    for (int i = 0; i < 2; i++) {
        const ddof_settings settings = disc_settings(DDOF_QUALITY_BEST);
        disc_picture p = disc_picture_make(200, 100, i ? 1e4 : 2);
        const ddof_frame frame = {.color = ddof_image_interleaved(p.color, p.width, p.height, 1, DDOF_FLOAT, 0),
                                  .coc = ddof_image_interleaved(p.coc, p.width, p.height, 1, DDOF_FLOAT, 0),
                                  .output = ddof_image_interleaved(p.output, p.width, p.height, 1, DDOF_FLOAT, 0)};
        assert_int_equal(ddof_trim(c->context), DDOF_OK);
        bytes[i] = render(c->context, &frame, &settings).scratch_bytes;
        disc_picture_free(&p);
    }
    assert_int_equal(bytes[0], bytes[1]);
}

int main(void) {
    static const disc_test tests[] = {
        {"constants", constant},
        {"sums", sum},
        {"sharp stays sharp", sharp},
        {"linear", linear},
        {"sign and limit of the CoC", sign},
        {"turned, transposed", symmetries},
        {"mirrored", mirrors},
        {"the order of directions", order},
        {"a line is self-adjoint", self_adjoint},
        {"how far a pixel can grow", gain},
        {"noise as CoC", noise},
        {"overshoot", overshoot},
        {"holes", holes},
        {"extremes", extremes},
        {"straight alpha", alpha},
        {"memory does not grow with the blur", memory},
    };
    return run_disc_tests("disc_invariants", tests, COUNT(tests));
}
