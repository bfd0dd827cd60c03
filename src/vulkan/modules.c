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
static const uint32_t sprites_histogram[] = {
#include "sprites_histogram.inc"
};
static const uint32_t sprites_raise[] = {
#include "sprites_raise.inc"
};
static const uint32_t sprites_append[] = {
#include "sprites_append.inc"
};
static const uint32_t sprites_take[] = {
#include "sprites_take.inc"
};
static const uint32_t sprites_resolve[] = {
#include "sprites_resolve.inc"
};
static const uint32_t sprites_vertex[] = {
#include "sprites_vertex.inc"
};
static const uint32_t sprites_point[] = {
#include "sprites_point.inc"
};
static const uint32_t sprites_geometry[] = {
#include "sprites_geometry.inc"
};
static const uint32_t sprites_pixel[] = {
#include "sprites_pixel.inc"
};
static const uint32_t sprites_pixel_weight[] = {
#include "sprites_pixel_weight.inc"
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
    [MODULE_SPRITES_HISTOGRAM] = CODE(sprites_histogram),
    [MODULE_SPRITES_RAISE] = CODE(sprites_raise),
    [MODULE_SPRITES_APPEND] = CODE(sprites_append),
    [MODULE_SPRITES_TAKE] = CODE(sprites_take),
    [MODULE_SPRITES_RESOLVE] = CODE(sprites_resolve),
    [MODULE_SPRITES_VERTEX] = CODE(sprites_vertex),
    [MODULE_SPRITES_POINT] = CODE(sprites_point),
    [MODULE_SPRITES_GEOMETRY] = CODE(sprites_geometry),
    [MODULE_SPRITES_PIXEL] = CODE(sprites_pixel),
    [MODULE_SPRITES_PIXEL_WEIGHT] = CODE(sprites_pixel_weight),
};
