/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "damage.h"
#include "format.h"
#include "make_phone.h"

enum { WIDTH = 64, HEIGHT = 48 };
static const phone_spec plain = {
    .width = WIDTH, .height = HEIGHT, .depth_width = WIDTH, .depth_height = HEIGHT, .bits = 8, .depth_bits = 8};

static const char *make(const phone_spec *spec) {
    const char *path = in_folder(spec->av1 ? "in.avif" : "in.heic");
    const int made = make_heif(path, spec);
    if (made == 0) skip();
    assert_int_equal(made, 1);
    return path;
}

/* libheif 1.15 and libaom 3.6 cannot encode 4:4:4 or grey of 10 bits together. */
static int most_bits(bool av1) {
    return av1 ? 8 : 10;
}

static float stored(int channel, int x, int y, int width, int height, int bits) {
    const float maximum = (float)((1 << bits) - 1);
    return rintf(phone_value(channel, x, y, width, height) * maximum) / maximum;
}

static const float *values(io_picture *picture, const char *name) {
    return channel_of(picture, 0, name)->data;
}

static void check_colors(const phone_spec *s) {
    static const char *const names[] = {"R", "G", "B", "A"};
    io_picture *picture = read_picture(make(s));
    assert_int_equal(picture->format, IO_HEIF);
    assert_int_equal(picture->part[0].bits, s->bits);
    for (int c = 0; c < 3 + s->alpha; c++) {
        const float *got = values(picture, names[c]);
        for (int y = 0; y < HEIGHT; y++)
            for (int x = 0; x < WIDTH; x++) {
                const float v = stored(c, x, y, WIDTH, HEIGHT, s->bits), a = stored(3, x, y, WIDTH, HEIGHT, s->bits);
                assert_float_equal(got[y * WIDTH + x], c == 3 ? v : io_srgb_to_linear(v) * (s->alpha ? a : 1), 1e-6);
            }
    }
    io_close(&picture);
}

static void test_color(void **state) {
    (void)state;
    for (int av1 = 0; av1 < 2; av1++)
        for (int bits = 8; bits <= most_bits(av1); bits += 2)
            for (int alpha = 0; alpha < 2; alpha++) {
                phone_spec s = plain;
                s.av1 = av1;
                s.bits = bits;
                s.alpha = alpha;
                check_colors(&s);
            }
}

/* Colour that eyes find close: the mean error of a lossy file. */
static void test_lossy(void **state) {
    (void)state;
    phone_spec s = plain;
    s.lossy = true;
    for (int av1 = 0; av1 < 2; av1++) {
        s.av1 = av1;
        io_picture *picture = read_picture(make(&s));
        const float *green = values(picture, "G"), *depth = values(picture, "depth");
        double error = 0, depth_error = 0;
        for (int i = 0; i < WIDTH * HEIGHT; i++) {
            const int x = i % WIDTH, y = i / WIDTH;
            error += fabs((double)io_linear_to_srgb(green[i]) - (double)stored(1, x, y, WIDTH, HEIGHT, 8));
            depth_error += fabs((double)depth[i] - (double)stored(4, x, y, WIDTH, HEIGHT, 8));
        }
        assert_true(error / (WIDTH * HEIGHT) < 0.02);
        assert_true(depth_error / (WIDTH * HEIGHT) < 0.02);
        io_close(&picture);
    }
}

static void test_depth(void **state) {
    (void)state;
    for (int av1 = 0; av1 < 2; av1++)
        for (int bits = 8; bits <= most_bits(av1); bits += 2) {
            phone_spec s = plain;
            s.av1 = av1;
            s.depth_bits = bits;
            io_selection color, depth;
            io_picture *picture = read_picture(make(&s));
            assert_int_equal(io_select_color(picture, NULL, &color, NULL), 0);
            assert_int_equal(io_select_depth(picture, NULL, &color, &depth, NULL), 0);
            const io_channel *channel = &picture->part[depth.part].channel[depth.channel[0]];
            assert_string_equal(channel->name, "depth");
            assert_true(channel->integer);
            assert_int_equal(channel->depth.kind, IO_DEPTH_UNSAID);
            const float *got = channel->data;
            for (int i = 0; i < WIDTH * HEIGHT; i++)
                assert_float_equal(got[i], stored(4, i % WIDTH, i / WIDTH, WIDTH, HEIGHT, bits), 1e-6);
            io_close(&picture);
        }
}

/* Only what is asked for is decoded, and the rest can be asked for later. */
static void test_some_channels(void **state) {
    (void)state;
    static const char *const depth[] = {"depth"}, *const green[] = {"G"};
    io_picture *picture = open_picture(make(&plain)), *whole = read_picture(in_folder("in.heic"));
    assert_int_equal(io_read_channels(picture, 0, depth, 1, NULL), 0);
    assert_null(channel_of(picture, 0, "G")->data);
    assert_int_equal(io_read_channels(picture, 0, green, 1, NULL), 0);
    assert_null(channel_of(picture, 0, "R")->data);
    assert_same_channel(channel_of(picture, 0, "G"), channel_of(whole, 0, "G"));
    assert_same_channel(channel_of(picture, 0, "depth"), channel_of(whole, 0, "depth"));
    io_close(&picture);
    io_close(&whole);
}

/* Half the size: between its own pixels on the slope, and nothing in between near and far at the step. */
static void test_small_depth(void **state) {
    (void)state;
    phone_spec s = plain;
    s.depth_width = WIDTH / 2;
    s.depth_height = HEIGHT / 2;
    io_picture *picture = read_picture(make(&s));
    const io_channel *channel = channel_of(picture, 0, "depth");
    assert_true(channel->width == WIDTH && channel->height == HEIGHT);
    const float *got = channel->data;
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            const float v = got[y * WIDTH + x];
            /* the slope goes on by half a pixel at most beyond the outermost samples */
            if (x < WIDTH / 2) assert_float_equal(v, phone_value(4, x, y, WIDTH, HEIGHT), 0.5 / 255 + 0.1 * 0.5 / HEIGHT + 1e-5);
            if (x >= WIDTH / 2) assert_float_equal(v, stored(4, x, y, WIDTH, HEIGHT, 8), 1e-6);
        }
    io_close(&picture);
}

static void test_other_shape(void **state) {
    (void)state;
    phone_spec s = plain;
    s.depth_width = 32;
    s.depth_height = 40;
    io_picture *picture = open_picture(make(&s));
    assert_int_equal(picture->part[0].channel_count, 3);
    assert_non_null(strstr(picture->note.text, "32x40"));
    io_close(&picture);
}

/* irot turns both images. */
static void test_turned(void **state) {
    (void)state;
    phone_spec s = plain;
    s.turn = 1;
    s.depth_width = WIDTH / 2;
    s.depth_height = HEIGHT / 2;
    io_picture *picture = read_picture(make(&s));
    assert_true(picture->part[0].data.width == HEIGHT && picture->part[0].data.height == WIDTH);
    const float *red = values(picture, "R"), *depth = values(picture, "depth");
    for (int y = 0; y < WIDTH; y++)
        for (int x = 0; x < HEIGHT; x++) {
            /* a quarter anticlockwise: what was on the right is on top */
            const int before_x = WIDTH - 1 - y, before_y = x;
            assert_float_equal(red[y * HEIGHT + x],
                               io_srgb_to_linear(stored(0, before_x, before_y, WIDTH, HEIGHT, 8)), 1e-6);
            assert_float_equal(depth[y * HEIGHT + x], phone_value(4, before_x, before_y, WIDTH, HEIGHT), 0.005);
        }
    io_close(&picture);
    s.turn_color_only = true;
    picture = open_picture(make(&s));
    assert_int_equal(picture->part[0].channel_count, 3);
    assert_non_null(strstr(picture->note.text, "depth is left out"));
    io_close(&picture);
}

static void test_meaning(void **state) {
    (void)state;
    static const struct {
        int type;
        double ends[4]; /* z_near, z_far, d_min, d_max */
        io_depth_kind kind;
        double at_0, at_1;
    } cases[] = {
        {0, {0.5, 8, 0, 0}, IO_DEPTH_DISPARITY, 8, 0.5},      {1, {0, 0, 0.25, 4}, IO_DEPTH_DISPARITY, 4, 0.25},
        {1, {2, 10, 0.25, 4}, IO_DEPTH_DISPARITY, 10, 2},     {2, {0.75, 12, 0, 0}, IO_DEPTH_LINEAR, 0.75, 12},
        {0, {0.5, 4e9, 0, 0}, IO_DEPTH_DISPARITY, INFINITY, 0.5}, {0, {0.5, 0, 0, 0}, IO_DEPTH_DISPARITY, 0, 0},
        {2, {3, 3, 0, 0}, IO_DEPTH_LINEAR, 0, 0},             {2, {1, 4e9, 0, 0}, IO_DEPTH_LINEAR, 1, 4e9},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        for (int av1 = 0; av1 < 2; av1++) {
            unsigned char message[64];
            phone_spec s = plain;
            s.av1 = av1;
            s.sei = message;
            s.sei_size = depth_message(message, cases[i].type, cases[i].ends);
            io_picture *picture = open_picture(make(&s));
            const io_depth *depth = &channel_of(picture, 0, "depth")->depth;
            assert_int_equal(depth->kind, cases[i].kind);
            if (isinf(cases[i].at_0))
                assert_true(isinf(depth->at_0));
            else
                assert_float_equal(depth->at_0, cases[i].at_0, 1e-6 * cases[i].at_0);
            assert_float_equal(depth->at_1, cases[i].at_1, 1e-6 * cases[i].at_1);
            io_close(&picture);
        }
}

static void test_profiles(void **state) {
    (void)state;
    phone_spec s = plain;
    s.transfer = 8;
    s.primaries = 12;
    io_picture *picture = read_picture(make(&s));
    assert_non_null(strstr(picture->note.text, "Display P3"));
    assert_float_equal(values(picture, "R")[10], stored(0, 10, 0, WIDTH, HEIGHT, 8), 1e-6);
    io_close(&picture);
    s.primaries = 1;
    s.transfer = 13;
    picture = open_picture(make(&s));
    assert_string_equal(picture->note.text, "");
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
    assert_one_line(&error, in_folder("in.heic"));
    assert_int_equal(io_create(&picture, IO_HEIF, 2, 2, (const char *const[]){"Y"}, 1, IO_FLOAT, 8, IO_COLOR, &error), -1);
    assert_non_null(strstr(error.text, "not written"));
    picture = read_picture(in_folder("in.heic"));
    assert_int_equal(io_write(picture, in_folder("out.heic"), NULL, NULL, &error), -1);
    assert_non_null(strstr(error.text, "not written"));
    io_close(&picture);
}

/* There under LeakSanitizer. libheif 1.15 loses an nclx whose numbers it does not know. */
extern void __lsan_disable(void) __attribute__((weak, visibility("default")));
extern void __lsan_enable(void) __attribute__((weak, visibility("default")));

static void test_hostile(void **state) {
    (void)state;
    unsigned char message[64];
    phone_spec s = plain;
    s.width = 32;
    s.height = 24;
    s.depth_width = 16;
    s.depth_height = 12;
    s.sei = message;
    s.sei_size = depth_message(message, 1, (const double[]){0.5, 8, 0.1, 2});
    library_prints = true;
    for (int av1 = 0; av1 < 2; av1++) {
        s.av1 = av1;
        const char *path = make(&s);
        check_truncation(path, 0);
        if (__lsan_disable) __lsan_disable();
        check_mutations(path, 400, 7);
        if (__lsan_enable) __lsan_enable();
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_color),       cmocka_unit_test(test_lossy),         cmocka_unit_test(test_depth),
        cmocka_unit_test(test_some_channels), cmocka_unit_test(test_small_depth), cmocka_unit_test(test_other_shape),
        cmocka_unit_test(test_turned),      cmocka_unit_test(test_meaning),       cmocka_unit_test(test_profiles),
        cmocka_unit_test(test_limits),      cmocka_unit_test(test_hostile),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
