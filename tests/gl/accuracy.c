/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Every solver on every surface against the float64 reference. For CoC up to 200: 1e-4 of the range of the colours with
 * rgba32f where nothing is packed, else 2e-3. */
#include "../gpu/render.h"
#include "support.h"

/* What CoC of up to 200 pixels there may be. */
static void fill_coc_200(float *coc, int width, int height, int pattern, rng *r) {
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            float *d = &coc[(ptrdiff_t)y * width + x];
            switch (pattern) {
            case 0:
                *d = 200;
                break;
            case 1:
                *d = (float)(400 * rng_unit(r) - 200);
                break;
            case 2:
                *d = (float)(400.0 * (x + 1) / width - 200);
                break;
            case 3:
                *d = x < width / 2 ? 0.0f : -200.0f;
                break;
            case 4:
                *d = y == height / 2 ? 0.0f : 200.0f;
                break;
            case 5:
                *d = rng_bits(r) % 2 ? 200.0f : (float)(3 * rng_unit(r));
                break;
            default:
                *d = (float)(0.5 + 2 * rng_unit(r));
                break;
            }
        }
}

static double tolerance(const scene *s, const ddof_settings *settings, double aspect) {
    (void)s, (void)aspect;
    return solver_tolerance(settings);
}

const gpu_promise promise = {
    .backend = DDOF_BACKEND_GL,
    .solvers = {DDOF_SOLVER_CR_VANILLA, DDOF_SOLVER_CR, DDOF_SOLVER_CR_PACK, DDOF_SOLVER_CR4, DDOF_SOLVER_CR4_PACK,
                DDOF_SOLVER_CR_PCR},
    .solver_count = 6,
    .patterns = 7,
    .fill_coc = fill_coc_200,
    .tolerance = tolerance,
    .coc_difference = 1e-6,
    .shared_chain = true,
    .step = 1,
};

static void large(void **state) {
    static const int size[][2] = {{1279, 1023}, {1919, 1201}};
    static const ddof_settings settings[] = {
        {.solver = DDOF_SOLVER_CR4_PACK, .surface = DDOF_SURFACE_RGBA16F, .conductance = DDOF_CONDUCTANCE_CLASSIC},
        {.solver = DDOF_SOLVER_CR4,
         .surface = DDOF_SURFACE_RGBA32F,
         .conductance = DDOF_CONDUCTANCE_CLASSIC,
         .shared_chain = 1},
        {.solver = DDOF_SOLVER_CR, .surface = DDOF_SURFACE_RGBA16F, .conductance = DDOF_CONDUCTANCE_CLASSIC},
        {.solver = DDOF_SOLVER_CR_PCR, .surface = DDOF_SURFACE_RGBA16F, .conductance = DDOF_CONDUCTANCE_CLASSIC},
        {.solver = DDOF_SOLVER_CR_VANILLA, .surface = DDOF_SURFACE_RGBA32F, .conductance = DDOF_CONDUCTANCE_CLASSIC},
        {.solver = DDOF_SOLVER_CR_PACK,
         .surface = DDOF_SURFACE_RGBA16F,
         .conductance = DDOF_CONDUCTANCE_CLASSIC,
         .shared_chain = 1},
    };
    (void)state;
    rng r = {102};
    pair p = pair_make();
    for (int i = 0; i < COUNT(size); i++) {
        scene s = gpu_scene(size[i][0], size[i][1], i == 0 ? 2 : 1, COLOR_RANDOM, &r);
        ddof_frame frame = scene_frame(&s);
        frame.color.channels = frame.output.channels = 3 + i;
        float *want = gpu_wanted(&p, &frame, &settings[0]);
        for (int k = 0; k < COUNT(settings); k++)
            gpu_compare(&p, &s, &frame, &settings[k], want, solver_tolerance(&settings[k]));
        fenced_free(want);
        scene_free(&s);
    }
    pair_destroy(&p);
}

int main(void) {
    static const struct CMUnitTest tests[] = {
        cmocka_unit_test(gpu_sizes),      cmocka_unit_test(gpu_patterns), cmocka_unit_test(large),
        cmocka_unit_test(gpu_ramp),       cmocka_unit_test(gpu_depth),    cmocka_unit_test(gpu_holes),
        cmocka_unit_test(gpu_brightness), cmocka_unit_test(gpu_images),
    };
    return run_gpu_tests("gl accuracy", tests, COUNT(tests), gl_missing());
}
