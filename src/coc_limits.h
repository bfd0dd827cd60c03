/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The numbers on which all CPU backends must agree. */
#ifndef DDOF_COC_LIMITS_H
#define DDOF_COC_LIMITS_H

#define COC_LIMIT 1e5 /* pixels; beyond it a picture is one colour anyway, and float32 still holds every step */

/* Two pixels in focus conduct at least this: a hole between sharp neighbours must still be reached by them, and nothing else
 * can be told from zero (1 + 1e-14 == 1 in float). Not less: along 2^20 holes its square shrinks to 1e-34, still a
 * normal float. */
#define BETA_FLOOR 1e-14

/* So that sums of CoC stay finite; what is no number stays none. */
static inline float coc_within(float coc, float most) {
    if (!(coc - coc == 0)) return coc;
    return coc > most ? most : coc < -most ? -most : coc;
}

#endif
