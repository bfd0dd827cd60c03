/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The shaders as glslc compiled them, numbers separated by commas. */
#include "pipelines.h"

/* clang-format off */
static const uint32_t line_0[] = {
#include "line_0.inc"
};
static const uint32_t line_1[] = {
#include "line_1.inc"
};
static const uint32_t disc_line_0[] = {
#include "disc_line_0.inc"
};
static const uint32_t disc_line_1[] = {
#include "disc_line_1.inc"
};
static const uint32_t pcr_first[] = {
#include "pcr_first.inc"
};
static const uint32_t pcr[] = {
#include "pcr.inc"
};
static const uint32_t pcr_last[] = {
#include "pcr_last.inc"
};
static const uint32_t sweep[] = {
#include "sweep.inc"
};
static const uint32_t initial_reduce4[] = {
#include "initial_reduce4.inc"
};
static const uint32_t reduce[] = {
#include "reduce.inc"
};
static const uint32_t solve[] = {
#include "solve.inc"
};
static const uint32_t substitute[] = {
#include "substitute.inc"
};
static const uint32_t final_solve4[] = {
#include "final_solve4.inc"
};
/* clang-format on */

#define CODE(name) {"compiling the shader " #name, name, sizeof name}

const vulkan_code vulkan_codes[VULKAN_MODULES] = {
    [MODULE_LINE] = CODE(line_0),
    [MODULE_LINE_SUBGROUPS] = CODE(line_1),
    [MODULE_DISC_LINE] = CODE(disc_line_0),
    [MODULE_DISC_LINE_SUBGROUPS] = CODE(disc_line_1),
    [MODULE_PCR_FIRST] = CODE(pcr_first),
    [MODULE_PCR] = CODE(pcr),
    [MODULE_PCR_LAST] = CODE(pcr_last),
    [MODULE_SWEEP] = CODE(sweep),
    [MODULE_INITIAL_REDUCE4] = CODE(initial_reduce4),
    [MODULE_REDUCE] = CODE(reduce),
    [MODULE_SOLVE] = CODE(solve),
    [MODULE_SUBSTITUTE] = CODE(substitute),
    [MODULE_FINAL_SOLVE4] = CODE(final_solve4),
};
