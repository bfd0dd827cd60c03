/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "damage.h"

/* 2 x 3 pixels, the bottom row first; values chosen so that bytes show their order. */
static const float upwards[] = {5, 6, 3, 4, 1, -2.5f};

static size_t put(unsigned char *out, const float *values, size_t count, bool big_endian) {
    for (size_t i = 0; i < count; i++) {
        uint32_t bits;
        memcpy(&bits, &values[i], 4);
        for (int k = 0; k < 4; k++)
            out[4 * i + (size_t)k] = (unsigned char)(bits >> (big_endian ? 24 - 8 * k : 8 * k));
    }
    return 4 * count;
}

static void make_pfm(const char *path, const char *header, const float *values, size_t count, bool big_endian) {
    unsigned char *bytes = malloc(strlen(header) + 4 * count + 1);
    assert_non_null(bytes);
    const size_t size = strlen(header);
    memcpy(bytes, header, size);
    write_file(path, bytes, size + put(bytes + size, values, count, big_endian));
    free(bytes);
}

static void test_headers(void **state) {
    (void)state;
    static const struct {
        const char *header;
        bool big_endian;
        float scale;
    } cases[] = {
        {"Pf\n2 3\n-1.0\n", false, 1},       {"Pf\n2 3\n1.0\n", true, 1},
        {"Pf\n2\n3\n-1\n", false, 1},        {"Pf 2 3 -1.000000 ", false, 1},
        {"Pf\r\n2 3\r\n-1.0\r\n", false, 1}, {"Pf\n# a comment\n2 3\n# and\n# more\n-1.0\n", false, 1},
        {"Pf\n2 3\n-.5\n", false, 0.5f},     {"Pf\n2 3\n+2e1\n", true, 20},
        {"Pf\n2 3\n-25E-2\n", false, 0.25f},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        make_pfm(in_folder("in.pfm"), cases[i].header, upwards, 6, cases[i].big_endian);
        io_picture *picture = read_picture(in_folder("in.pfm"));
        assert_true(picture->part[0].data.width == 2 && picture->part[0].data.height == 3);
        assert_int_equal(picture->part[0].channel_count, 1);
        const float *y = values_of(picture, "Y");
        for (int row = 0; row < 3; row++)
            for (int x = 0; x < 2; x++)
                assert_true(y[2 * row + x] == upwards[2 * (2 - row) + x] * cases[i].scale);
        io_close(&picture);
    }
}

/* A canonical file comes back to the byte, whatever bits its floats have. */
static void test_round_trip(void **state) {
    (void)state;
    static const struct {
        const char *header;
        size_t channels;
        bool big_endian;
    } cases[] = {{"Pf\n37 21\n-1.0\n", 1, false},
                 {"PF\n37 21\n-1.0\n", 3, false},
                 {"PF\n37 21\n1.0\n", 3, true},
                 {"PF4\n37 21\n-1.0\n", 4, false}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const size_t count = 37 * 21 * cases[i].channels;
        float *values = malloc(sizeof *values * count);
        assert_non_null(values);
        uint32_t seed = 3;
        for (size_t k = 0; k < count; k++) {
            const uint32_t bits = next_random(&seed) << 16 ^ next_random(&seed);
            memcpy(&values[k], &bits, 4);
            if (isnan(values[k])) values[k] = k % 2 ? INFINITY : NAN;
        }
        make_pfm(in_folder("in.pfm"), cases[i].header, values, count, cases[i].big_endian);
        assert_string_equal(rewrite(in_folder("in.pfm"), in_folder("out.pfm"), i % 2 ? IO_DATA : IO_COLOR), "");
        assert_same_files(in_folder("in.pfm"), in_folder("out.pfm"));
        free(values);
    }
}

static void test_some_channels(void **state) {
    (void)state;
    static const float values[] = {1, 2, 3, 4, 5, 6};
    static const char *const green[] = {"G"};
    io_error error = {""};
    make_pfm(in_folder("in.pfm"), "PF\n2 1\n-1.0\n", values, 6, false);
    io_picture *picture = open_picture(in_folder("in.pfm"));
    assert_int_equal(io_read_channels(picture, 0, green, 1, &error), 0);
    assert_null(channel_of(picture, 0, "R")->data);
    assert_true(values_of(picture, "G")[1] == 5);
    ((float *)channel_of(picture, 0, "G")->data)[1] = 50;
    io_channel_modified(channel_of(picture, 0, "G"));
    write_picture(picture, in_folder("out.pfm"), NULL);
    io_close(&picture);
    picture = read_picture(in_folder("out.pfm"));
    assert_true(values_of(picture, "G")[1] == 50 && values_of(picture, "B")[1] == 6 && values_of(picture, "R")[0] == 1);
    io_close(&picture);
}

static void test_created(void **state) {
    (void)state;
    static const char *const names[] = {"B", "G", "R"}; /* the order is the file's, not the caller's */
    const float one[] = {1, 2};
    io_error error = {""};
    io_picture *picture;
    assert_int_equal(io_create(&picture, IO_PFM, 2, 1, names, 3, IO_HALF, 32, IO_COLOR, &error), 0);
    io_channel_from_float(channel_of(picture, 0, "R"), one, 1, 2);
    write_picture(picture, in_folder("out.pfm"), NULL);
    io_close(&picture);
    make_pfm(in_folder("in.pfm"), "PF\n2 1\n-1.0\n", (const float[]){1, 0, 0, 2, 0, 0}, 6, false);
    assert_same_files(in_folder("in.pfm"), in_folder("out.pfm"));
    static const char *const two[] = {"Y", "A"};
    assert_int_equal(io_create(&picture, IO_PFM, 2, 1, two, 2, IO_FLOAT, 32, IO_COLOR, &error), -1);
    assert_int_equal(io_create(&picture, IO_PFM, 2, 1, two, 1, IO_FLOAT, 16, IO_COLOR, &error), -1);
    assert_non_null(strstr(error.text, "32 bits"));
}

static void test_bad_headers(void **state) {
    (void)state;
    static const struct {
        const char *header, *words;
    } cases[] = {
        {"Pf\n", "header"},
        {"Pf\n2\n", "header"},
        {"Pf\nx 3\n-1.0\n", "header"},
        {"Pf\n-2 3\n-1.0\n", "header"},
        {"Pf\n2 3\nlittle\n", "header"},
        {"Pf\n2 3\n-1e\n", "header"},
        {"Pf\n2 3\n-1e999\n", "header"},
        {"Pf\n2 3\n0.0\n", "scale"},
        {"Pf\n2 3\n1e-90\n", "scale"},
        {"Pf\n0 3\n-1.0\n", "0 x 3"},
        {"Pf\n2000000 3\n-1.0\n", "too large"},
        {"Pf\n99999999999999999999999 3\n-1.0\n", "too large"},
        {"Pf\n100000 100000\n-1.0\n", "100000 x 100000"},
        {"Pf\n3 3\n-1.0\n", "is cut off"},
        {"PF\n2 3\n-1.0\n", "is cut off"},
        {"PFx\n2 3\n-1.0\n", "PFM"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        make_pfm(in_folder("in.pfm"), cases[i].header, upwards, 6, false);
        assert_refused(in_folder("in.pfm"), cases[i].words);
    }
}

static void test_damage(void **state) {
    (void)state;
    float values[300];
    for (int i = 0; i < 300; i++)
        values[i] = (float)i;
    make_pfm(in_folder("in.pfm"), "PF\n10 10\n-1.0\n", values, 300, false);
    check_truncation(in_folder("in.pfm"), 0);
    make_pfm(in_folder("in.pfm"), "Pf\n2 3\n-1.0\n", values, 6, false); /* most changes hit the header */
    check_mutations(in_folder("in.pfm"), 3000, 5);
}

static void test_full_disk(void **state) {
    (void)state;
    float *values = calloc(100 * 100, sizeof *values);
    make_pfm(in_folder("in.pfm"), "Pf\n100 100\n-1.0\n", values, 100 * 100, false);
    free(values);
    check_full_disk(in_folder("in.pfm"), in_folder("out.pfm"), 20);
    check_full_disk(in_folder("in.pfm"), in_folder("out.pfm"), 39999);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_headers),   cmocka_unit_test(test_round_trip),  cmocka_unit_test(test_some_channels),
        cmocka_unit_test(test_created),   cmocka_unit_test(test_bad_headers), cmocka_unit_test(test_damage),
        cmocka_unit_test(test_full_disk),
    };
    return cmocka_run_group_tests_name("pfm", tests, make_folder, remove_folder);
}
