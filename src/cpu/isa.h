/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Names of what is compiled once per instruction set: ISA(row_kernels) is row_kernels_avx2 where the build says
 * -DDDOF_ISA=avx2. */
#ifndef DDOF_CPU_ISA_H
#define DDOF_CPU_ISA_H

#include "kernels.h"

#define ISA_JOIN(name, isa) name##_##isa
#define ISA_NAME(name, isa) ISA_JOIN(name, isa)
#define ISA(name) ISA_NAME(name, DDOF_ISA)

extern const row_kernels ISA(row_kernels);
extern const column_kernels ISA(column_kernels);
extern const pixel_kernels ISA(pixel_kernels);
extern const disc_kernels ISA(disc_kernels);
extern const layer_kernels ISA(layer_kernels);
extern const fill_kernels ISA(fill_kernels);
extern const sprite_kernels ISA(sprite_kernels);
extern const gather_kernels ISA(gather_kernels);

/* Of disc_rows.c, for the table in disc_lines.c. */
bool ISA(disc_forward)(const disc_block *block, const disc_link *link);
void ISA(disc_backward)(disc_block *block, int x0, int x1);

#endif
