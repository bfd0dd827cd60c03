/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* One vector of LANES floats, by the compilers' vector extensions: 4 lanes (SSE2, NEON, plain C), 8 (AVX2) or 16 (AVX-512)
 * from the same source. What the extensions cannot say portably (fused multiply-add, streaming stores) is here, once.
 *
 * Every operation below is one correctly rounded IEEE operation per lane, the build forbids the compiler to contract,
 * and no kernel has a scalar tail: so a pixel's bits depend neither on its lane nor on the block it falls into, and all
 * instruction sets that fuse (AVX2, AVX-512, NEON) agree to the last bit. */
#ifndef DDOF_CPU_VEC_H
#define DDOF_CPU_VEC_H

#include <stdint.h>
#include <string.h>

#if defined(__AVX512F__) || defined(__AVX2__) || defined(__SSE2__)
#include <immintrin.h>
#elif defined(__ARM_NEON)
#include <arm_neon.h>
#endif

#if defined(__AVX512F__)
#define LANES 16
#elif defined(__AVX2__)
#define LANES 8
#else
#define LANES 4
#endif
#define GROUP (LANES / 4) /* RGBA pixels in a vector */

typedef float vfloat __attribute__((vector_size(4 * LANES)));
typedef int32_t vint __attribute__((vector_size(4 * LANES)));

static inline vfloat v_load(const float *p) {
    vfloat v;
    memcpy(&v, p, sizeof v);
    return v;
}
static inline void v_store(float *p, vfloat v) { memcpy(p, &v, sizeof v); }
static inline vfloat v_set(float s) { return s - (vfloat){0}; }
static inline vfloat v_select(vint mask, vfloat yes, vfloat no) {
    return (vfloat)((mask & (vint)yes) | (~mask & (vint)no));
}
static inline vfloat v_abs(vfloat v) { return (vfloat)((vint)v & 0x7fffffff); }

/* Of two numbers; where one is NaN, b. */
static inline vfloat v_min(vfloat a, vfloat b) {
#if defined(__AVX512F__)
    return (vfloat)_mm512_min_ps((__m512)a, (__m512)b);
#elif defined(__AVX2__)
    return (vfloat)_mm256_min_ps((__m256)a, (__m256)b);
#elif defined(__SSE2__)
    return (vfloat)_mm_min_ps((__m128)a, (__m128)b);
#else
    return v_select((vint)(a < b), a, b);
#endif
}
static inline vfloat v_max(vfloat a, vfloat b) {
#if defined(__AVX512F__)
    return (vfloat)_mm512_max_ps((__m512)a, (__m512)b);
#elif defined(__AVX2__)
    return (vfloat)_mm256_max_ps((__m256)a, (__m256)b);
#elif defined(__SSE2__)
    return (vfloat)_mm_max_ps((__m128)a, (__m128)b);
#else
    return v_select((vint)(a > b), a, b);
#endif
}

/* Of non-negative floats, infinity and NaN among them, the largest by their bits: NaN > infinity > all else. */
static inline vint v_max_bits(vint a, vfloat b) {
#if defined(__AVX512F__)
    return (vint)_mm512_max_epi32((__m512i)a, (__m512i)b);
#elif defined(__AVX2__)
    return (vint)_mm256_max_epi32((__m256i)a, (__m256i)b);
#else
    vint mask = a > (vint)b;
    return (mask & a) | (~mask & (vint)b);
#endif
}

/* a * b + c, fused where the instruction set can. */
static inline vfloat v_fma(vfloat a, vfloat b, vfloat c) {
#if defined(__AVX512F__)
    return (vfloat)_mm512_fmadd_ps((__m512)a, (__m512)b, (__m512)c);
#elif defined(__AVX2__)
    return (vfloat)_mm256_fmadd_ps((__m256)a, (__m256)b, (__m256)c);
#elif defined(__ARM_NEON)
    return (vfloat)vfmaq_f32((float32x4_t)c, (float32x4_t)a, (float32x4_t)b);
#else
    return a * b + c;
#endif
}

/* c - a * b, likewise; the compilers do not see it in a v_fma of -a. */
static inline vfloat v_fma_minus(vfloat a, vfloat b, vfloat c) {
#if defined(__AVX512F__)
    return (vfloat)_mm512_fnmadd_ps((__m512)a, (__m512)b, (__m512)c);
#elif defined(__AVX2__)
    return (vfloat)_mm256_fnmadd_ps((__m256)a, (__m256)b, (__m256)c);
#elif defined(__ARM_NEON)
    return (vfloat)vfmsq_f32((float32x4_t)c, (float32x4_t)a, (float32x4_t)b);
#else
    return c - a * b;
#endif
}

/* a (1 - t) for t in 0..1, as good as if rounded once. */
static inline vfloat v_remaining(vfloat a, vfloat t) {
#if defined(__AVX2__) || defined(__ARM_NEON)
    return v_fma_minus(t, a, a);
#else /* a - t a cancels where t is near 1, but there 1 - t is exact */
    return v_select((vint)(t < 0.5f), a - t * a, (1.0f - t) * a);
#endif
}

/* Past the caches, for memory that is next read when it has long been evicted. p is aligned to the vector. */
static inline void v_stream(float *p, vfloat v) {
#if defined(__AVX512F__)
    _mm512_stream_ps(p, (__m512)v);
#elif defined(__AVX2__)
    _mm256_stream_ps(p, (__m256)v);
#elif defined(__SSE2__)
    _mm_stream_ps(p, (__m128)v);
#else
    v_store(p, v);
#endif
}
/* Orders streaming stores before what other threads are told next. */
static inline void v_stream_fence(void) {
#if defined(__SSE2__)
    _mm_sfence();
#endif
}

/* Lane GROUP*k + i four times over, i = 0..GROUP-1: a coefficient per pixel becomes one per channel. */
#if LANES == 16
#define V_EXPAND(v, k)                                                                                                 \
    __builtin_shufflevector(v, v, 4 * (k), 4 * (k), 4 * (k), 4 * (k), 4 * (k) + 1, 4 * (k) + 1, 4 * (k) + 1,           \
                            4 * (k) + 1, 4 * (k) + 2, 4 * (k) + 2, 4 * (k) + 2, 4 * (k) + 2, 4 * (k) + 3, 4 * (k) + 3, \
                            4 * (k) + 3, 4 * (k) + 3)
#elif LANES == 8
#define V_EXPAND(v, k)                                                                                                 \
    __builtin_shufflevector(v, v, 2 * (k), 2 * (k), 2 * (k), 2 * (k), 2 * (k) + 1, 2 * (k) + 1, 2 * (k) + 1,           \
                            2 * (k) + 1)
#else
#define V_EXPAND(v, k) __builtin_shufflevector(v, v, k, k, k, k)
#endif

/* Transposes GROUP x GROUP pixels of four floats: v[i] holds GROUP pixels of row i, then of column i. */
static inline void v_transpose_pixels(vfloat *v) {
#if LANES == 16
#define LO(a, b) __builtin_shufflevector(a, b, 0, 1, 2, 3, 4, 5, 6, 7, 16, 17, 18, 19, 20, 21, 22, 23)
#define HI(a, b) __builtin_shufflevector(a, b, 8, 9, 10, 11, 12, 13, 14, 15, 24, 25, 26, 27, 28, 29, 30, 31)
#define EVEN(a, b) __builtin_shufflevector(a, b, 0, 1, 2, 3, 8, 9, 10, 11, 16, 17, 18, 19, 24, 25, 26, 27)
#define ODD(a, b) __builtin_shufflevector(a, b, 4, 5, 6, 7, 12, 13, 14, 15, 20, 21, 22, 23, 28, 29, 30, 31)
    vfloat a = LO(v[0], v[1]), b = LO(v[2], v[3]), c = HI(v[0], v[1]), d = HI(v[2], v[3]);
    v[0] = EVEN(a, b), v[1] = ODD(a, b), v[2] = EVEN(c, d), v[3] = ODD(c, d);
#undef LO
#undef HI
#undef EVEN
#undef ODD
#elif LANES == 8
    vfloat a = v[0], b = v[1];
    v[0] = __builtin_shufflevector(a, b, 0, 1, 2, 3, 8, 9, 10, 11);
    v[1] = __builtin_shufflevector(a, b, 4, 5, 6, 7, 12, 13, 14, 15);
#else
    (void)v;
#endif
}

/* Transposes LANES x LANES floats. */
static inline void v_transpose(vfloat *v) {
#if LANES == 16
    vfloat t[16];
    for (int i = 0; i < 16; i += 4) { /* 4 x 4 within each 128-bit block */
        vfloat a = __builtin_shufflevector(v[i], v[i + 1], 0, 16, 1, 17, 4, 20, 5, 21, 8, 24, 9, 25, 12, 28, 13, 29);
        vfloat b = __builtin_shufflevector(v[i], v[i + 1], 2, 18, 3, 19, 6, 22, 7, 23, 10, 26, 11, 27, 14, 30, 15, 31);
        vfloat c = __builtin_shufflevector(v[i + 2], v[i + 3], 0, 16, 1, 17, 4, 20, 5, 21, 8, 24, 9, 25, 12, 28, 13, 29);
        vfloat d =
            __builtin_shufflevector(v[i + 2], v[i + 3], 2, 18, 3, 19, 6, 22, 7, 23, 10, 26, 11, 27, 14, 30, 15, 31);
        t[i] = __builtin_shufflevector(a, c, 0, 1, 16, 17, 4, 5, 20, 21, 8, 9, 24, 25, 12, 13, 28, 29);
        t[i + 1] = __builtin_shufflevector(a, c, 2, 3, 18, 19, 6, 7, 22, 23, 10, 11, 26, 27, 14, 15, 30, 31);
        t[i + 2] = __builtin_shufflevector(b, d, 0, 1, 16, 17, 4, 5, 20, 21, 8, 9, 24, 25, 12, 13, 28, 29);
        t[i + 3] = __builtin_shufflevector(b, d, 2, 3, 18, 19, 6, 7, 22, 23, 10, 11, 26, 27, 14, 15, 30, 31);
    }
    for (int i = 0; i < 4; i++) { /* then the blocks */
        vfloat q[4] = {t[i], t[i + 4], t[i + 8], t[i + 12]};
        v_transpose_pixels(q);
        for (int j = 0; j < 4; j++) v[4 * j + i] = q[j];
    }
#elif LANES == 8
    vfloat t[8];
    for (int i = 0; i < 8; i += 4) {
        vfloat a = __builtin_shufflevector(v[i], v[i + 1], 0, 8, 1, 9, 4, 12, 5, 13);
        vfloat b = __builtin_shufflevector(v[i], v[i + 1], 2, 10, 3, 11, 6, 14, 7, 15);
        vfloat c = __builtin_shufflevector(v[i + 2], v[i + 3], 0, 8, 1, 9, 4, 12, 5, 13);
        vfloat d = __builtin_shufflevector(v[i + 2], v[i + 3], 2, 10, 3, 11, 6, 14, 7, 15);
        t[i] = __builtin_shufflevector(a, c, 0, 1, 8, 9, 4, 5, 12, 13);
        t[i + 1] = __builtin_shufflevector(a, c, 2, 3, 10, 11, 6, 7, 14, 15);
        t[i + 2] = __builtin_shufflevector(b, d, 0, 1, 8, 9, 4, 5, 12, 13);
        t[i + 3] = __builtin_shufflevector(b, d, 2, 3, 10, 11, 6, 7, 14, 15);
    }
    for (int i = 0; i < 4; i++) {
        vfloat q[2] = {t[i], t[i + 4]};
        v_transpose_pixels(q);
        v[i] = q[0], v[4 + i] = q[1];
    }
#else
    vfloat a = __builtin_shufflevector(v[0], v[1], 0, 4, 1, 5), b = __builtin_shufflevector(v[0], v[1], 2, 6, 3, 7);
    vfloat c = __builtin_shufflevector(v[2], v[3], 0, 4, 1, 5), d = __builtin_shufflevector(v[2], v[3], 2, 6, 3, 7);
    v[0] = __builtin_shufflevector(a, c, 0, 1, 4, 5), v[1] = __builtin_shufflevector(a, c, 2, 3, 6, 7);
    v[2] = __builtin_shufflevector(b, d, 0, 1, 4, 5), v[3] = __builtin_shufflevector(b, d, 2, 3, 6, 7);
#endif
}

#endif
