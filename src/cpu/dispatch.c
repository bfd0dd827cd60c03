/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Which kernels this machine runs, and the CPU backend's table. */
#include "engine.h"

#if defined(__x86_64__)
#include <cpuid.h>
#endif

#define DECLARE(isa)                                                                                                   \
    extern const row_kernels row_kernels_##isa;                                                                        \
    extern const column_kernels column_kernels_##isa;                                                                  \
    extern const pixel_kernels pixel_kernels_##isa;                                                                    \
    extern const disc_kernels disc_kernels_##isa;                                                                      \
    extern const layer_kernels layer_kernels_##isa;                                                                    \
    extern const fill_kernels fill_kernels_##isa;                                                                      \
    extern const sprite_kernels sprite_kernels_##isa;                                                                  \
    extern const gather_kernels gather_kernels_##isa;
#define TABLE(isa, name, flag, lanes)                                                                                  \
    {name, flag, lanes, &row_kernels_##isa, &column_kernels_##isa, &pixel_kernels_##isa, &disc_kernels_##isa,          \
     &layer_kernels_##isa, &fill_kernels_##isa, &sprite_kernels_##isa, &gather_kernels_##isa}

DECLARE(baseline)
#if defined(__aarch64__)
const cpu_kernels cpu_kernels_baseline = TABLE(baseline, "neon", DDOF_CPU_NEON, 4);
#else
const cpu_kernels cpu_kernels_baseline = TABLE(baseline, "baseline", DDOF_CPU_BASELINE, 4);
#endif
#if defined(__x86_64__)
DECLARE(avx2)
DECLARE(avx512)
static const cpu_kernels kernels_avx2 = TABLE(avx2, "avx2", DDOF_CPU_AVX2, 8);
static const cpu_kernels kernels_avx512 = TABLE(avx512, "avx512", DDOF_CPU_AVX512, 16);
#endif

#if defined(__x86_64__)
/* Clang 14's __builtin_cpu_supports does not know f16c. */
static bool has_f16c(void) {
    unsigned a, b, c, d;
    return __get_cpuid(1, &a, &b, &c, &d) && c & bit_F16C;
}
#endif

unsigned cpu_flags(void) {
    unsigned flags = DDOF_CPU_BASELINE | cpu_kernels_baseline.flag;
#if defined(__x86_64__)
    __builtin_cpu_init();
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && has_f16c())
        flags |= DDOF_CPU_AVX2;
    if (flags & DDOF_CPU_AVX2 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
        __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
        flags |= DDOF_CPU_AVX512;
#endif
    return flags;
}

const cpu_kernels *cpu_kernels_pick(unsigned mask) {
#if defined(__x86_64__)
    unsigned allowed = cpu_flags() & (mask ? mask : ~0u);
    if (allowed & DDOF_CPU_AVX512) return &kernels_avx512;
    if (allowed & DDOF_CPU_AVX2) return &kernels_avx2;
#else
    (void)mask;
#endif
    return &cpu_kernels_baseline;
}

static const char *device(const ddof_context *ctx) {
    return ctx->kernels->name;
}

const backend backend_cpu = {.id = DDOF_BACKEND_CPU, .disc = true, .rows = true, .scratch_bytes = cpu_scratch_bytes, .coc = cpu_coc, .diffuse = cpu_diffuse,
                             .gaussian = cpu_gaussian, .hexagon = cpu_hexagon, .device = device};
