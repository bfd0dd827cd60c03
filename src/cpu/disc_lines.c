/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Stages columns and diagonals of the disc kernel: a row at a time, each of its pixels on a line of its own.
 * Coefficients are vectors of LANES pixels, pixels four vectors of GROUP pixels x RGBA, real and imaginary parts apart.
 */
#include "complex.h"
#include "isa.h"

static bool magnitude(const float *coc, float *out, int width, int padded) {
    vint worst = {0};
    int x = 0;
    for (; x + LANES <= width; x += LANES) {
        vfloat d = v_abs(v_load(coc + x));
        worst = v_max_bits(worst, d);
        v_store(out + x, coc_limited(d));
    }
    if (x < width) {
        float part[LANES] = {0};
        memcpy(part, coc + x, (size_t)(width - x) * sizeof(float));
        vfloat d = v_abs(v_load(part));
        worst = v_max_bits(worst, d);
        d = coc_limited(d);
        memcpy(out + x, &d, (size_t)(width - x) * sizeof(float));
    }
    for (x = width; x < padded; x++)
        out[x] = -1;
    int finite = 1;
    for (int i = 0; i < LANES; i++)
        finite &= worst[i] < 0x7f800000;
    return finite;
}

static inline vcomplex load_complex(const float *re, const float *im, ptrdiff_t at) {
    return (vcomplex){v_load(re + at), v_load(im + at)};
}
static inline void store_complex(float *re, float *im, ptrdiff_t at, vcomplex c, bool stream) {
    if (stream) {
        v_stream(re + at, c.re);
        v_stream(im + at, c.im);
    } else {
        v_store(re + at, c.re);
        v_store(im + at, c.im);
    }
}

static inline __attribute__((always_inline)) void
eliminate_row(const disc_link *to, const disc_span *state, const float *near, const float *far, float g,
              const float *re, const float *im, const disc_span *means, int count, bool holes, bool stream) {
    const disc_link link = *to; /* copies, which stores cannot change */
    const disc_span lines = *state, out = *means;
    for (int x = 0; x < count; x += LANES) {
        const vcomplex b = disc_conductance(v_load(near + x), v_load(far + x), &link);
        const disc_elimination e = disc_eliminate(load_complex(lines.keep_re, lines.keep_im, x), v_set(g), b, holes);
        store_complex(lines.keep_re, lines.keep_im, x, e.rest, false);
        store_complex(out.keep_re, out.keep_im, x, e.keep, stream);
#define STEP(k)                                                                                                        \
    do {                                                                                                               \
        const ptrdiff_t at = 4 * (ptrdiff_t)x + (k)*LANES;                                                             \
        const vcomplex mean =                                                                                          \
            complex_lerp(load_complex(lines.re, lines.im, at), load_complex(re, im, at), EXPAND_COMPLEX(e.own, k));    \
        store_complex(lines.re, lines.im, at, mean, false);                                                            \
        store_complex(out.re, out.im, at, mean, stream);                                                               \
    } while (0)
        STEP(0);
        STEP(1);
        STEP(2);
        STEP(3);
#undef STEP
    }
    if (stream) v_stream_fence();
}

static void eliminate_span(const disc_link *link, const disc_span *lines, const float *near, const float *far, float g,
                           const float *re, const float *im, const disc_span *out, int count, bool stream) {
    if (g == 0)
        eliminate_row(link, lines, near, far, g, re, im, out, count, true, false);
    else if (stream)
        eliminate_row(link, lines, near, far, 1, re, im, out, count, false, true);
    else
        eliminate_row(link, lines, near, far, 1, re, im, out, count, false, false);
}

/* The same row of the next tile, on its way from memory while this one is worked on: tiles are too short for the
 * hardware to see where they lead. A macro, for `level` must be a constant: 3 is the first cache, 2 the second. */
#define PREFETCH_TILE(means, x, level)                                                                                 \
    do {                                                                                                               \
        const ptrdiff_t next = (x) + DISC_TILE;                                                                        \
        for (int k = 0; k < 4; k++) {                                                                                  \
            __builtin_prefetch((means).re + 4 * next + k * LANES, 0, level);                                           \
            __builtin_prefetch((means).im + 4 * next + k * LANES, 0, level);                                           \
        }                                                                                                              \
        __builtin_prefetch((means).keep_re + next, 0, level);                                                          \
        __builtin_prefetch((means).keep_im + next, 0, level);                                                          \
    } while (0)

static void substitute(const disc_span *state, const disc_span *from, int count) {
    const disc_span lines = *state, means = *from;
    for (int x = 0; x < count; x += LANES) {
        const vcomplex keep = load_complex(means.keep_re, means.keep_im, x);
        PREFETCH_TILE(means, x, 2); /* of so many rows the first cache would not hold it */
#define STEP(k)                                                                                                        \
    do {                                                                                                               \
        const ptrdiff_t at = 4 * (ptrdiff_t)x + (k)*LANES;                                                             \
        const vcomplex a = complex_lerp(load_complex(lines.re, lines.im, at), load_complex(means.re, means.im, at),    \
                                        EXPAND_COMPLEX(keep, k));                                                      \
        store_complex(lines.re, lines.im, at, a, false);                                                               \
        store_complex(means.re, means.im, at, a, false);                                                               \
    } while (0)
        STEP(0);
        STEP(1);
        STEP(2);
        STEP(3);
#undef STEP
    }
}

static void turn(const disc_link *to, const disc_span *from_lines, const disc_span *to_lines, const float *near,
                 const float *far, const disc_span *state, int count) {
    const disc_link link = *to;
    const disc_span solved = *from_lines, lines = *to_lines, means = *state;
    for (int x = 0; x < count; x += LANES) {
        const vcomplex keep = load_complex(means.keep_re, means.keep_im, x);
        const vcomplex b = disc_conductance(v_load(near + x), v_load(far + x), &link);
        const disc_elimination e = disc_eliminate(load_complex(lines.keep_re, lines.keep_im, x), v_set(1), b, false);
        PREFETCH_TILE(means, x, 3);
        store_complex(lines.keep_re, lines.keep_im, x, e.rest, false);
        store_complex(means.keep_re, means.keep_im, x, e.keep, false);
#define STEP(k)                                                                                                        \
    do {                                                                                                               \
        const ptrdiff_t at = 4 * (ptrdiff_t)x + (k)*LANES;                                                             \
        const vcomplex a = complex_lerp(load_complex(solved.re, solved.im, at), load_complex(means.re, means.im, at),  \
                                        EXPAND_COMPLEX(keep, k));                                                      \
        store_complex(solved.re, solved.im, at, a, false);                                                             \
        const vcomplex mean = complex_lerp(load_complex(lines.re, lines.im, at), a, EXPAND_COMPLEX(e.own, k));         \
        store_complex(lines.re, lines.im, at, mean, false);                                                            \
        store_complex(means.re, means.im, at, mean, false);                                                            \
    } while (0)
        STEP(0);
        STEP(1);
        STEP(2);
        STEP(3);
#undef STEP
    }
}

/* Stores a vector of pixels, the first `left` floats of it. */
static inline __attribute__((always_inline)) void store_pixels(float *out, vfloat v, ptrdiff_t left, bool stream) {
    if (left < LANES)
        memcpy(out, &v, left > 0 ? (size_t)left * sizeof(float) : 0);
    else if (stream)
        v_stream(out, v);
    else
        v_store(out, v);
}

static inline vfloat load_pixels(const float *in, ptrdiff_t left) {
    if (left >= LANES) return v_load(in);
    float part[LANES] = {0};
    if (left > 0) memcpy(part, in, (size_t)left * sizeof(float));
    return v_load(part);
}

static inline __attribute__((always_inline)) void finish_row(const disc_span *state, const disc_span *from,
                                                             float weight_re, float weight_im, const float *add,
                                                             float *out, int count, bool stream) {
    const disc_span lines = *state, means = *from;
    const vcomplex weight = {v_set(weight_re), v_set(weight_im)};
    for (int x = 0; x < count; x += LANES) {
        const vcomplex keep = load_complex(means.keep_re, means.keep_im, x);
        PREFETCH_TILE(means, x, 3);
#define STEP(k)                                                                                                        \
    do {                                                                                                               \
        const ptrdiff_t at = 4 * (ptrdiff_t)x + (k)*LANES, left = 4 * (ptrdiff_t)count - at;                           \
        const vcomplex a = complex_lerp(load_complex(lines.re, lines.im, at), load_complex(means.re, means.im, at),    \
                                        EXPAND_COMPLEX(keep, k));                                                      \
        store_complex(lines.re, lines.im, at, a, false);                                                               \
        vfloat v = v_fma_minus(weight.im, a.im, weight.re * a.re);                                                     \
        if (add) {                                                                                                     \
            v = v + load_pixels(add + at, left);                                                                       \
            __builtin_prefetch(add + at + 4 * DISC_TILE, 1, 3);                                                        \
        }                                                                                                              \
        store_pixels(out + at, v, left, stream);                                                                       \
    } while (0)
        STEP(0);
        STEP(1);
        STEP(2);
        STEP(3);
#undef STEP
    }
    if (stream) v_stream_fence();
}

static void finish(const disc_span *lines, const disc_span *means, float weight_re, float weight_im, const float *add,
                   float *out, int count) {
    if (add)
        finish_row(lines, means, weight_re, weight_im, add, out, count, false);
    else if ((uintptr_t)out % sizeof(vfloat) == 0)
        finish_row(lines, means, weight_re, weight_im, NULL, out, count, true);
    else
        finish_row(lines, means, weight_re, weight_im, NULL, out, count, false);
}

const disc_kernels ISA(disc_kernels) = {
    magnitude, ISA(disc_forward), ISA(disc_backward), eliminate_span, substitute, turn, finish};
