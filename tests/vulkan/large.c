/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* large [8k]: whole pictures with CoC up to 1e4, strictly to 1e-5 of the range with floats and 2e-3 with half floats.
 */
#include "support.h"

#include <string.h>

static void check_picture(const pair *p, int width, int height, coc_pattern coc, ddof_conductance conductance,
                          const ddof_solver *solvers, int count, rng *r) {
    scene s = gpu_scene(width, height, (int)coc, COLOR_RANDOM, r);
    ddof_frame frame = scene_frame(&s);
    ddof_settings settings = {.conductance = conductance};
    float *want = gpu_wanted(p, &frame, &settings);
    for (int k = 0; k < count; k++)
        for (int surface = DDOF_SURFACE_RGBA16F; surface <= DDOF_SURFACE_RGBA32F; surface++) {
            settings.solver = solvers[k];
            settings.surface = (ddof_surface)surface;
            const bool exact = surface == DDOF_SURFACE_RGBA32F && solvers[k] != DDOF_SOLVER_CR4_PACK;
            gpu_compare(p, &s, &frame, &settings, want, exact ? 1e-5 : 2e-3);
        }
    fenced_free(want);
    scene_free(&s);
}

/* The CoC reaches 1e4 in two of three. */
static void pictures(int width, int height, uint64_t seed) {
    static const struct {
        coc_pattern coc;
        ddof_conductance conductance;
    } cases[] = {{COC_SPLIT, DDOF_CONDUCTANCE_CLASSIC},
                 {COC_HUGE, DDOF_CONDUCTANCE_MATCHED},
                 {COC_RANDOM, DDOF_CONDUCTANCE_CLASSIC}};
    rng r = {seed};
    pair p = pair_make();
    for (int i = 0; i < COUNT(cases); i++)
        check_picture(&p, width, height, cases[i].coc, cases[i].conductance, promise.solvers, promise.solver_count, &r);
    pair_destroy(&p);
}

static void odd_1279_1023(void **state) {
    (void)state;
    pictures(1279, 1023, 1);
}

static void full_hd(void **state) {
    (void)state;
    pictures(1920, 1080, 2);
}

static void ultra_hd_8k(void **state) {
    (void)state;
    static const ddof_solver line = DDOF_SOLVER_LINE;
    rng r = {3};
    pair p = pair_make();
    check_picture(&p, 7680, 4320, COC_SPLIT, DDOF_CONDUCTANCE_MATCHED, &line, 1, &r);
    pair_destroy(&p);
}

int main(int argc, char **argv) {
    static const struct CMUnitTest large[] = {cmocka_unit_test(odd_1279_1023), cmocka_unit_test(full_hd)};
    static const struct CMUnitTest largest[] = {cmocka_unit_test(ultra_hd_8k)};
    const char *missing = gpu_missing(DDOF_BACKEND_VULKAN);
    if (argc > 1 && !strcmp(argv[1], "8k")) return run_gpu_tests("vulkan 8k", largest, COUNT(largest), missing);
    return run_gpu_tests("vulkan large", large, COUNT(large), missing);
}
