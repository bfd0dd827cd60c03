/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* A row and three right-hand sides in 128 bits: listing 8.3 of Gruen 2011 with the mask its slides have. Two halves
 * fill w; the third lies in the six lowest mantissa bits of each coefficient, 6 + 6 + 4 of them used. Coefficients are
 * rounded to what is left, not cut: a cut would make all of them a little smaller. What is kept is x/g, which for
 * diffusion is a mean of temperatures (x itself where g = 0). It belongs to the g that is kept, so that a constant
 * stays one whatever the six bits were. */
#ifndef DDOF_TRIDIAG_PACK_H
#define DDOF_TRIDIAG_PACK_H

#include "half.h"
#include "row.h"

typedef struct record {
    uint32_t x, y, z, w;
} record;

static const uint32_t KEPT = 0xffffffc0u, STOLEN = 0x3fu, HALF_STEP = 0x20u;

static inline real per_g(real x, real g) {
    return g != 0 ? x / g : x;
}

static inline real times_g(real x, real g) {
    return g != 0 ? x * g : x;
}

static inline uint32_t kept_bits(real coefficient) {
    const float value = (float)coefficient;
    const uint32_t bits = float_bits(value);
    return ((bits & 0x7fffffffu) > 0x7f800000u ? 0x7fc00000u : bits + HALF_STEP) & KEPT; /* NaN stays one */
}

/* Only the first `count` right-hand sides are looked at, the others are 0. */
static inline record pack(row r, const real *x, size_t count) {
    const uint32_t kept_g = kept_bits(r.g);
    const real g = kept_g << 1 ? r.g : 0; /* too small for a float is 0 for both sides */
    const uint32_t h0 = half_bits((float)per_g(x[0], g));
    const uint32_t h1 = count > 1 ? half_bits((float)per_g(x[1], g)) : 0;
    const uint32_t h2 = count > 2 ? half_bits((float)per_g(x[2], g)) : 0;
    const record d = {kept_bits(r.a) | (h2 & STOLEN), kept_g | (h2 >> 6 & STOLEN), kept_bits(r.c) | h2 >> 12,
                      h0 | h1 << 16};
    return d;
}

static inline row unpack_row(record d) {
    const row r = {(real)bits_float(d.x & KEPT), (real)bits_float(d.y & KEPT), (real)bits_float(d.z & KEPT)};
    return r;
}

/* Right-hand side `index` of a record whose row is r. */
static inline real unpack_x(record d, row r, size_t index) {
    const uint32_t third = (d.x & STOLEN) | (d.y & STOLEN) << 6 | (d.z & STOLEN) << 12;
    const uint32_t half = index == 0 ? d.w & 0xffffu : index == 1 ? d.w >> 16 : third;
    return times_g((real)half_value(half), r.g);
}

#endif
