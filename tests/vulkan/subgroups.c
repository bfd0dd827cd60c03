/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* LINE with subgroups of 4 to 64, whatever the device has: its shader, with shuffles through shared memory, on lines that end
 * everywhere in a subgroup. */
#include "pictures.h"

#include <stdio.h>

static void check_size(int width, int height, int size, ddof_settings settings, coc_pattern coc, rng *r) {
    char what[64];
    frame_set set = set_make((frame_kind){.width = width, .height = height, .coc = coc}, rng_bits(r));
    ddof_vulkan *vk = create();
    destroy(&vk); /* what a test that failed has left behind is forgotten */
    tap_forget();
    tap.subgroup = (uint32_t)size;
    tap.invocations = 512; /* shared memory holds the shuffles, too */
    assert_int_equal(try_create(&vk), DDOF_OK);
    snprintf(what, sizeof what, "%d x %d, subgroups of %d", width, height, size);
    settings.surface = DDOF_SURFACE_RGBA32F;
    if (!settings.kernel) settings.conductance = (ddof_conductance)(rng_bits(r) & 1);
    const ddof_vulkan_stats stats = set_check(vk, &set, NULL, &settings, what);
    assert_int_equal(stats.solver, DDOF_SOLVER_LINE);
    assert_int_equal(stats.subgroup, size);
    assert_int_equal(stats.workgroup % size, 0);
    destroy(&vk);
    tap_forget();
    set_free(&set);
}

static void sizes(int subgroup) {
    static const int length[] = {1, 7, 9, 63, 65, 256, 257, 513, 2049};
    static const ddof_settings heat, draft = {.kernel = DDOF_KERNEL_DISC, .quality = DDOF_QUALITY_DRAFT},
                                     good = {.kernel = DDOF_KERNEL_DISC};
    rng r = {(uint64_t)subgroup};
    for (int i = 0; i < COUNT(length); i++)
        for (int disc = 0; disc < 2 - i % 2; disc++) { /* which compiles for long: every second length */
            const ddof_settings *s = disc ? &draft : &heat;
            check_size(length[i], 3, subgroup, *s, (coc_pattern)rng_range(&r, 0, COC_HUGE), &r);
            check_size(5, length[i], subgroup, *s, (coc_pattern)rng_range(&r, 0, COC_HUGE), &r);
        }
    check_size(300, 230, subgroup, heat, COC_RANDOM, &r);
    check_size(300, 230, subgroup, good, COC_RANDOM, &r);
}

static void of_4(void **state) {
    (void)state;
    sizes(4);
}
static void of_8(void **state) {
    (void)state;
    sizes(8);
}
static void of_16(void **state) {
    (void)state;
    sizes(16);
}
static void of_32(void **state) {
    (void)state;
    sizes(32);
}
static void of_64(void **state) {
    (void)state;
    sizes(64);
}

int main(void) {
    static const struct CMUnitTest tests[] = {cmocka_unit_test(of_4), cmocka_unit_test(of_8), cmocka_unit_test(of_16),
                                              cmocka_unit_test(of_32), cmocka_unit_test(of_64)};
    return run_with_own("vulkan subgroups", tests, COUNT(tests));
}
