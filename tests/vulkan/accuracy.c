/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Every solver on every surface against the float64 reference, for the CoC of every pattern. */
#include "support.h"

int main(void) {
    static const struct CMUnitTest tests[] = {
        cmocka_unit_test(gpu_sizes),  cmocka_unit_test(gpu_patterns), cmocka_unit_test(gpu_ramp),
        cmocka_unit_test(gpu_depth),  cmocka_unit_test(gpu_holes),    cmocka_unit_test(gpu_brightness),
        cmocka_unit_test(gpu_images),
    };
    return run_gpu_tests("vulkan accuracy", tests, COUNT(tests), gpu_missing(DDOF_BACKEND_VULKAN));
}
