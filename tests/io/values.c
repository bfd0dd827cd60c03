/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Half floats, the sRGB curve, channels as floats, names, threads. */
#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "format.h"
#include "support.h"

/* By the definition of binary16. */
static double half_value(unsigned half) {
    int exponent = half >> 10 & 31, significand = half & 1023;
    double magnitude = exponent == 31  ? significand ? NAN : INFINITY
                       : exponent == 0 ? ldexp(significand, -24)
                                       : ldexp(1024 + significand, exponent - 25);
    return half & 0x8000 ? -magnitude : magnitude;
}

static void test_every_half(void **state) {
    (void)state;
    for (unsigned h = 0; h < 65536; h++) {
        uint16_t half = (uint16_t)h, back;
        float value;
        io_half_to_float(&half, &value, 1, 1);
        double expected = half_value(h);
        if (isnan(expected) ? !isnan(value) : value != expected || !signbit(value) != !signbit(expected))
            fail_msg("half %#x is %g, not %g", h, (double)value, expected);
        io_float_to_half(&value, &back, 1, 1);
        if (back != half) fail_msg("half %#x comes back as %#x", h, back);
    }
}

static void test_rounding_to_half(void **state) {
    (void)state;
    for (unsigned h = 0; h < 0x7c00; h++) {
        /* Halfway between neighbours: to the even one. A little more or less: to the nearer. */
        double low = half_value(h), high = h == 0x7bff ? 65536 : half_value(h + 1), middle = (low + high) / 2;
        float values[3] = {nextafterf((float)middle, 0), (float)middle, nextafterf((float)middle, INFINITY)};
        unsigned expected[3] = {h, h & 1 ? h + 1 : h, h + 1};
        uint16_t got[3];
        io_float_to_half(values, got, 3, 1);
        for (int i = 0; i < 3; i++)
            if (got[i] != expected[i]) fail_msg("%a is half %#x, not %#x", (double)values[i], got[i], expected[i]);
    }
    const float large[] = {65520, 1e10f, INFINITY, -INFINITY, -1e30f};
    const uint16_t expected[] = {0x7c00, 0x7c00, 0x7c00, 0xfc00, 0xfc00};
    uint16_t got[5];
    io_float_to_half(large, got, 5, 1);
    assert_memory_equal(got, expected, sizeof got);
}

static void test_channels_as_floats(void **state) {
    (void)state;
    static const float in[] = {0, -1, 0.5f, 1.5f, 2.5f, 4294967040.f, 1e20f, NAN};
    static const uint32_t uints[] = {0, 0, 0, 2, 2, 4294967040u, UINT32_MAX, 0};
    for (int type = IO_HALF; type <= IO_UINT; type++) {
        io_channel channel = {.name = (char *)"c", .type = (io_type)type, .width = 4, .height = 2};
        float spread[3 * 4 * 2 + 6], back[3 * 4 * 2 + 6];
        io_error error;
        assert_int_equal(io_channel_allocate(&channel, NULL, &error, "file"), 0);
        assert_int_equal((uintptr_t)channel.data % 64, 0);
        for (size_t i = 0; i < sizeof spread / sizeof spread[0]; i++)
            spread[i] = back[i] = -77;
        for (int y = 0; y < 2; y++)
            for (int x = 0; x < 4; x++)
                spread[y * 15 + x * 3] = in[y * 4 + x];
        io_channel_from_float(&channel, spread, 3, 15);
        assert_true(channel.modified);
        io_channel_to_float(&channel, back, 3, 15);
        for (int i = 0; i < 8; i++) {
            float got = back[i / 4 * 15 + i % 4 * 3];
            if (type == IO_UINT)
                assert_int_equal(((uint32_t *)channel.data)[i], uints[i]);
            else if (type == IO_FLOAT)
                assert_memory_equal(&got, &in[i], sizeof got);
            else
                assert_true(isnan(in[i]) ? isnan(got) : fabsf(in[i]) < 65504 ? got == in[i] : isinf(got));
        }
        assert_true(back[1] == -77 && back[14] == -77); /* what lies between is not touched */
        io_channel_release(&channel);
        assert_null(channel.data);
    }
}

static void test_srgb(void **state) {
    (void)state;
    assert_true(io_srgb_to_linear(0) == 0 && io_linear_to_srgb(0) == 0);
    assert_true(fabsf(io_srgb_to_linear(1) - 1) < 1e-6f && fabsf(io_linear_to_srgb(1) - 1) < 1e-6f);
    assert_true(fabsf(io_srgb_to_linear(0.5f) - 0.21404114f) < 1e-6f);
    for (int i = -2000; i <= 2000; i++) {
        float value = (float)i / 1000, linear = io_srgb_to_linear(value);
        assert_true(fabsf(io_linear_to_srgb(linear) - value) < 4e-6f);
        assert_true(io_srgb_to_linear(-value) == -linear);
    }
}

static void test_names(void **state) {
    (void)state;
    io_format format;
    assert_true(io_format_of_name("a.b/c.EXR", &format) && format == IO_EXR);
    assert_true(io_format_of_name("x.png", &format) && format == IO_PNG);
    assert_true(io_format_of_name("x.tif", &format) && format == IO_TIFF);
    assert_true(io_format_of_name("x.Tiff", &format) && format == IO_TIFF);
    assert_true(io_format_of_name("x.0001.pfm", &format) && format == IO_PFM);
    assert_false(io_format_of_name("exr", &format));
    assert_false(io_format_of_name("x.exr.bak", &format));
    assert_string_equal(io_format_name(IO_TIFF), "TIFF");
}

static atomic_int done[1000];
static void task(void *data, int index) {
    atomic_fetch_add(&done[index], 1);
    atomic_fetch_add((atomic_int *)data, index);
}

static void test_parallel(void **state) {
    (void)state;
    for (int threads = 0; threads <= 300; threads = threads * 3 + 1)
        for (int count = 0; count <= 1000; count = count * 10 + 1) {
            atomic_int sum = 0;
            memset(done, 0, sizeof done);
            io_parallel(threads, count, task, &sum);
            for (int i = 0; i < 1000; i++)
                assert_int_equal(done[i], i < count);
            assert_int_equal(sum, count * (count - 1) / 2);
        }
    assert_true(io_thread_count(0) >= 1);
    assert_int_equal(io_thread_count(7), 7);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_half),
        cmocka_unit_test(test_rounding_to_half),
        cmocka_unit_test(test_channels_as_floats),
        cmocka_unit_test(test_srgb),
        cmocka_unit_test(test_names),
        cmocka_unit_test(test_parallel),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
