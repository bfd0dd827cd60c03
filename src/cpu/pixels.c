/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Stage lens, a row at a time, and the half <-> float conversions. Plain loops that the compiler turns into vectors: every
 * operation is exact IEEE, so all instruction sets agree. */
#include <math.h>

#include "isa.h"
#include "vec.h"

/* q = 1/z; what is not a distance (zero, behind the camera, infinite) lies at q = 0, a NaN stays one. */
static inline float usable(float q, float v) {
    float kept = q > 0 && q <= 3.4e38f ? q : 0.0f;
    return v == v ? kept : v;
}

static inline float to_coc(const lens_curve *c, float q) {
    float away = c->gain_far * (c->q_far - q), toward = c->gain_near * (q - c->q_near);
    away = away < c->limit_far ? away : c->limit_far;
    toward = toward < c->limit_near ? toward : c->limit_near;
    float coc = q < c->q_far ? away : q > c->q_near ? -toward : 0.0f;
    return q == q ? coc : q;
}

static void inverse_depth(const lens_curve *c, const float *v, float *q, int count, int x, int y) {
    float t = ((float)y + 0.5f - c->y_center) * c->y_tangent;
    switch (c->kind) {
    case DDOF_DEPTH_RAY:
        for (int i = 0; i < count; i++) {
            float p = ((float)(x + i) + 0.5f - c->x_center) * c->x_tangent;
            q[i] = usable(sqrtf(1.0f + p * p + t * t) / v[i], v[i]);
        }
        break;
    case DDOF_DEPTH_INVERSE:
        for (int i = 0; i < count; i++) q[i] = usable(v[i], v[i] < INFINITY ? v[i] : NAN);
        break;
    case DDOF_DEPTH_NORMALIZED:
        for (int i = 0; i < count; i++) q[i] = usable(1.0f / (c->offset + c->slope * v[i]), v[i]);
        break;
    case DDOF_DEPTH_DEVICE:
        for (int i = 0; i < count; i++) q[i] = usable(c->offset + c->slope * v[i], v[i]);
        break;
    default:
        for (int i = 0; i < count; i++) q[i] = usable(1.0f / v[i], v[i]);
    }
}

static void lens_row(const lens_curve *curve, const float *depth, float *coc, int count, int x, int y) {
    const lens_curve c = *curve;
    inverse_depth(&c, depth, coc, count, x, y);
    for (int i = 0; i < count; i++) coc[i] = to_coc(&c, coc[i]);
}

static inline float half_value(uint16_t h) {
    uint32_t sign = (uint32_t)(h & 0x8000) << 16, rest = (uint32_t)(h & 0x7fff) << 13, bits;
    float f;
    bits = rest + (rest >= 0x0f800000 ? 0x70000000 : 0x38000000); /* infinity and NaN keep their exponent of ones */
    memcpy(&f, &bits, 4);
    if (rest < 0x00800000) f = (float)(h & 0x7fff) * 0x1p-24f; /* subnormal */
    memcpy(&bits, &f, 4);
    bits |= sign;
    memcpy(&f, &bits, 4);
    return f;
}

static inline uint16_t half_bits(float f) {
    uint32_t bits, sign;
    memcpy(&bits, &f, 4);
    sign = bits >> 16 & 0x8000;
    bits &= 0x7fffffff;
    uint32_t normal = (bits - 0x38000000 + 0xfff + (bits >> 13 & 1)) >> 13; /* to nearest, ties to even */
    float magnitude;
    memcpy(&magnitude, &bits, 4);
    float shifted = magnitude + 0.5f; /* the adder rounds a subnormal to multiples of 2^-24 */
    uint32_t subnormal;
    memcpy(&subnormal, &shifted, 4);
    subnormal -= 0x3f000000;
    uint32_t out = bits < 0x38800000 ? subnormal : normal;
    out = out > 0x7c00 || bits >= 0x47800000 ? 0x7c00 : out;
    out = bits > 0x7f800000 ? 0x7e00 : out;
    return (uint16_t)(out | sign);
}

static void half_to_float(const uint16_t *in, float *out, int count) {
    int i = 0;
#if defined(__F16C__)
    for (; i + 8 <= count; i += 8) _mm256_storeu_ps(out + i, _mm256_cvtph_ps(_mm_loadu_si128((const __m128i *)(in + i))));
#endif
    for (; i < count; i++) out[i] = half_value(in[i]);
}

static void float_to_half(const float *in, uint16_t *out, int count) {
    int i = 0;
#if defined(__F16C__)
    for (; i + 8 <= count; i += 8)
        _mm_storeu_si128((__m128i *)(out + i), _mm256_cvtps_ph(_mm256_loadu_ps(in + i), _MM_FROUND_TO_NEAREST_INT));
#endif
    for (; i < count; i++) out[i] = half_bits(in[i]);
}

const pixel_kernels ISA(pixel_kernels) = {lens_row, half_to_float, float_to_half};
