/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* binary16 <-> binary32 with integers and one exact float operation, so that compilers can turn the loops into vector
 * code on every machine. NaNs keep the top ten bits of their payload in both directions. */
#include <string.h>

#include "format.h"

static float as_float(uint32_t bits) {
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static uint32_t as_bits(float value) {
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

static float half_to_float(uint16_t half) {
    uint32_t magnitude = half & 0x7fffu;
    uint32_t sign = (uint32_t)(half & 0x8000u) << 16;
    /* Exponent and significand move up by 13 bits; * 2^112 rebiases the exponent and normalises denormals exactly. */
    uint32_t finite = as_bits(as_float(magnitude << 13) * 0x1p112f);
    uint32_t special = 0x7f800000u | magnitude << 13;
    uint32_t mask = magnitude >= 0x7c00u ? 0xffffffffu : 0;
    return as_float(sign | (finite & ~mask) | (special & mask));
}

static uint16_t float_to_half(float value) {
    uint32_t bits = as_bits(value);
    uint32_t sign = bits >> 16 & 0x8000u;
    uint32_t magnitude = bits & 0x7fffffffu;
    /* Normal halves: rebias, then round to nearest even by adding just under half a unit plus the last kept bit. The
     * carry runs into the exponent, up to infinity, as it should. */
    uint32_t normal = (magnitude - (112u << 23) + 0xfffu + (magnitude >> 13 & 1u)) >> 13;
    /* Denormal halves: adding 0.5 puts the unit of the half at the last bit of the sum, and the addition rounds. */
    uint32_t tiny = as_bits(as_float(magnitude < 0x38800000u ? magnitude : 0) + 0.5f) - 0x3f000000u;
    uint32_t payload = magnitude >> 13 & 0x3ffu;
    uint32_t special = magnitude > 0x7f800000u ? 0x7c00u | payload | (payload == 0) : 0x7c00u;
    uint32_t half = magnitude < 0x38800000u ? tiny : normal;
    half = magnitude >= 0x47800000u ? special : half;
    return (uint16_t)(sign | half);
}

void io_half_to_float(const uint16_t *in, float *out, size_t count, size_t out_stride) {
    if (out_stride == 1)
        for (size_t i = 0; i < count; i++)
            out[i] = half_to_float(in[i]);
    else
        for (size_t i = 0; i < count; i++)
            out[i * out_stride] = half_to_float(in[i]);
}

void io_float_to_half(const float *in, uint16_t *out, size_t count, size_t in_stride) {
    if (in_stride == 1)
        for (size_t i = 0; i < count; i++)
            out[i] = float_to_half(in[i]);
    else
        for (size_t i = 0; i < count; i++)
            out[i] = float_to_half(in[i * in_stride]);
}
