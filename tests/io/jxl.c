/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "damage.h"
#include "format.h"
#include "make_phone.h"

enum { WIDTH = 61, HEIGHT = 37 };
static const phone_spec plain = {
    .width = WIDTH, .height = HEIGHT, .depth_width = WIDTH, .depth_height = HEIGHT, .linear = true};

static const char *make(const phone_spec *spec) {
    const char *path = in_folder("in.jxl");
    const int made = make_jxl(path, spec);
    if (made == 0) skip();
    assert_int_equal(made, 1);
    return path;
}

/* What the samples of `bits` are as floats; bits 0: floats. */
static float stored(int channel, int i, int bits) {
    const float value = phone_value(channel, i % WIDTH, i / WIDTH, WIDTH, HEIGHT);
    return bits ? (float)((double)rintf(value * (float)((1 << bits) - 1)) / ((1 << bits) - 1)) : value;
}

static const float *values(io_picture *picture, const char *name) {
    return channel_of(picture, 0, name)->data;
}

static void check_exact(const phone_spec *s) {
    static const char *const rgb[] = {"R", "G", "B", "A"}, *const grey[] = {"Y", "A"};
    io_picture *picture = read_picture(make(s));
    const int colors = s->grey ? 1 : 3;
    assert_int_equal(picture->format, IO_JXL);
    assert_int_equal(picture->part[0].bits, s->bits ? s->bits : 32);
    assert_int_equal(picture->part[0].channel_count, colors + s->alpha + 1);
    assert_string_equal(picture->note.text, "");
    for (int c = 0; c < colors + s->alpha; c++) {
        const io_channel *channel = channel_of(picture, 0, (s->grey ? grey : rgb)[c]);
        const float *got = channel->data;
        assert_int_equal(channel->integer, s->bits > 0);
        for (int i = 0; i < WIDTH * HEIGHT; i++) {
            const float v = stored(c < colors ? c : 3, i, s->bits), a = stored(3, i, s->bits);
            const float linear = c < colors && !s->linear ? io_srgb_to_linear(v) : v;
            const float wanted = c < colors && s->alpha ? linear * a : linear;
            if (got[i] != wanted) fail_msg("%s of pixel %d is %.9g, not %.9g", channel->name, i, (double)got[i], (double)wanted);
        }
    }
    const io_channel *depth = channel_of(picture, 0, "depth");
    assert_int_equal(depth->integer, s->depth_bits > 0);
    for (int i = 0; i < WIDTH * HEIGHT; i++)
        if (((const float *)depth->data)[i] != stored(4, i, s->depth_bits)) fail_msg("depth of pixel %d differs", i);
    io_close(&picture);
}

static void test_exact(void **state) {
    (void)state;
    static const int bits[] = {0, 8, 10, 16};
    for (int b = 0; b < 4; b++)
        for (int d = 0; d < 4; d += 1 + (b % 2))
            for (int flags = 0; flags < 8; flags++) {
                phone_spec s = plain;
                s.bits = bits[b];
                s.depth_bits = bits[d];
                s.linear = bits[b] == 0 || flags == 7;
                s.alpha = flags & 1;
                s.grey = flags & 2;
                s.container = flags & 4;
                check_exact(&s);
            }
}

static void test_depth_is_found(void **state) {
    (void)state;
    io_selection color, depth;
    io_picture *picture = open_picture(make(&plain));
    assert_int_equal(io_select_color(picture, NULL, &color, NULL), 0);
    assert_int_equal(io_select_depth(picture, NULL, &color, &depth, NULL), 0);
    assert_string_equal(picture->part[0].channel[depth.channel[0]].name, "depth");
    io_close(&picture);
    phone_spec s = plain;
    s.depth_width = 0;
    picture = read_picture(make(&s));
    assert_int_equal(picture->part[0].channel_count, 3);
    assert_int_equal(io_select_depth(picture, NULL, &color, &depth, NULL), -1);
    io_close(&picture);
}

static void test_some_channels(void **state) {
    (void)state;
    static const char *const depth[] = {"depth"}, *const green[] = {"G"};
    phone_spec s = plain;
    s.alpha = true;
    io_picture *picture = open_picture(make(&s)), *whole = read_picture(in_folder("in.jxl"));
    assert_int_equal(io_read_channels(picture, 0, depth, 1, NULL), 0);
    assert_null(channel_of(picture, 0, "G")->data);
    assert_int_equal(io_read_channels(picture, 0, green, 1, NULL), 0);
    assert_null(channel_of(picture, 0, "A")->data);
    assert_same_channel(channel_of(picture, 0, "G"), channel_of(whole, 0, "G"));
    assert_same_channel(channel_of(picture, 0, "depth"), channel_of(whole, 0, "depth"));
    io_close(&picture);
    io_close(&whole);
}

/* Coded by eye: close, and scene-linear. */
static void test_lossy(void **state) {
    (void)state;
    for (int bits = 0; bits <= 8; bits += 8) {
        phone_spec s = plain;
        s.lossy = true;
        s.bits = bits;
        s.linear = bits == 0;
        io_picture *picture = read_picture(make(&s));
        const float *green = values(picture, "G");
        double error = 0;
        for (int i = 0; i < WIDTH * HEIGHT; i++) {
            const float wanted = bits ? io_srgb_to_linear(stored(1, i, 8)) : stored(1, i, 0);
            error += fabs((double)green[i] - (double)wanted);
        }
        if (error / (WIDTH * HEIGHT) >= 0.02) fail_msg("mean error %g with %d bits", error / (WIDTH * HEIGHT), bits);
        io_close(&picture);
    }
}

static void test_profiles(void **state) {
    (void)state;
    phone_spec s = plain;
    s.primaries = 9;
    io_picture *picture = read_picture(make(&s));
    assert_non_null(strstr(picture->note.text, "BT.2020"));
    assert_true(values(picture, "R")[5] == stored(0, 5, 0));
    io_close(&picture);
    s.transfer = 16;
    assert_refused(make(&s), "PQ");
    s.transfer = 18;
    assert_refused(make(&s), "HLG");
}

static void test_limits(void **state) {
    (void)state;
    const io_options options = {.max_pixels = WIDTH * HEIGHT - 1};
    io_picture *picture;
    io_error error;
    assert_int_equal(io_open(&picture, make(&plain), IO_COLOR, &options, &error), -1);
    assert_one_line(&error, in_folder("in.jxl"));
    assert_int_equal(io_create(&picture, IO_JXL, 2, 2, (const char *const[]){"Y"}, 1, IO_FLOAT, 8, IO_COLOR, &error), -1);
    assert_non_null(strstr(error.text, "not written"));
}

static void test_hostile(void **state) {
    (void)state;
    phone_spec s = plain;
    s.alpha = true;
    s.bits = 8;
    s.linear = false;
    library_prints = true;
    for (int container = 0; container < 2; container++) {
        s.container = container;
        const char *path = make(&s);
        check_truncation(path, 0);
        check_mutations(path, 1500, 11);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_exact),         cmocka_unit_test(test_depth_is_found),
        cmocka_unit_test(test_some_channels), cmocka_unit_test(test_lossy),         cmocka_unit_test(test_profiles),
        cmocka_unit_test(test_limits),        cmocka_unit_test(test_hostile),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
