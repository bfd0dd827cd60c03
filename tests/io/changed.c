/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* A file that is written to, or replaced, between the moment it is opened and the last byte that is wanted of it. */
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "damage.h"

static const struct {
    const char *name;
    io_format format;
    io_type type;
    int bits;
} formats[] = {{"in.exr", IO_EXR, IO_HALF, 16},
               {"in.png", IO_PNG, IO_FLOAT, 16},
               {"in.tif", IO_TIFF, IO_FLOAT, 32},
               {"in.pfm", IO_PFM, IO_FLOAT, 32}};
enum { FORMATS = sizeof formats / sizeof formats[0] };

static void make(int f, const char *path, float value) {
    static const char *const names[] = {"R", "G", "B"};
    float values[16 * 9];
    io_picture *picture;
    io_error error;
    assert_int_equal(io_create(&picture, formats[f].format, 16, 9, names, 3, formats[f].type, formats[f].bits, IO_COLOR,
                               &error),
                     0);
    for (int i = 0; i < 16 * 9; i++)
        values[i] = value;
    for (int c = 0; c < 3; c++)
        io_channel_from_float(&picture->part[0].channel[c], values, 1, 16);
    write_picture(picture, path, NULL);
    io_close(&picture);
    /* A write within the same tick of the clock would leave the time as it is. */
    const struct timespec long_ago[2] = {{1000000000, 0}, {1000000000, 0}};
    assert_int_equal(utimensat(AT_FDCWD, path, long_ago, 0), 0);
}

static void append_byte(const char *path) {
    FILE *file = fopen(path, "ab");
    assert_non_null(file);
    fputc(0, file);
    fclose(file);
}

/* The last byte, the same as before: only the time tells. */
static void touch_byte(const char *path) {
    FILE *file = fopen(path, "r+b");
    assert_non_null(file);
    fseek(file, -1, SEEK_END);
    const int byte = fgetc(file);
    fseek(file, -1, SEEK_END);
    fputc(byte, file);
    fclose(file);
}

static void cut(const char *path) {
    struct stat status;
    assert_int_equal(stat(path, &status), 0);
    assert_int_equal(truncate(path, status.st_size / 2), 0);
}

static void empty(const char *path) {
    assert_int_equal(truncate(path, 0), 0);
}

static void (*const changes[])(const char *) = {append_byte, touch_byte, cut, empty};
enum { CHANGES = sizeof changes / sizeof changes[0] };

static void assert_changed(const io_error *error, const char *path) {
    assert_one_line(error, path);
    if (!strstr(error->text, "changed while it was read")) fail_msg("\"%s\"", error->text);
}

static void test_before_reading(void **state) {
    (void)state;
    for (int f = 0; f < FORMATS; f++)
        for (int i = 0; i < CHANGES; i++) {
            const char *path = in_folder(formats[f].name);
            io_error error = {""};
            make(f, path, 0.5f);
            io_picture *picture = open_picture(path);
            changes[i](path);
            assert_int_equal(io_read(picture, &error), -1);
            assert_changed(&error, path);
            io_close(&picture);
            unlink(path);
        }
}

/* After some channels were read: the others are wanted when it is written. */
static void test_before_writing(void **state) {
    (void)state;
    for (int f = 0; f < FORMATS; f++)
        for (int i = 0; i < CHANGES; i++) {
            static const char *const red[] = {"R"};
            const char *path = in_folder(formats[f].name);
            char output[600];
            snprintf(output, sizeof output, "%s", in_folder("out"));
            strcat(output, strrchr(path, '.'));
            io_error error = {""};
            make(f, path, 0.5f);
            io_picture *picture = open_picture(path);
            assert_int_equal(io_read_channels(picture, 0, red, 1, &error), 0);
            changes[i](path);
            assert_int_equal(io_write(picture, output, NULL, NULL, &error), -1);
            assert_changed(&error, path);
            io_close(&picture);
            unlink(path);
            assert_int_equal(count_files(), 0);
        }
}

/* As renderers and this program do it: the new file is another one, and the old one is read to its end. */
static void test_replaced(void **state) {
    (void)state;
    for (int f = 0; f < FORMATS; f++) {
        const char *path = in_folder(formats[f].name);
        char other[600];
        snprintf(other, sizeof other, "%s", in_folder("other"));
        strcat(other, strrchr(path, '.'));
        io_error error = {""};
        make(f, path, 0.5f);
        make(f, other, 0.25f);
        io_picture *picture = open_picture(path);
        assert_int_equal(rename(other, path), 0);
        if (io_read(picture, &error) != 0) fail_msg("%s", error.text);
        float values[16 * 9];
        io_channel_to_float(channel_of(picture, 0, "G"), values, 1, 16);
        assert_true(values[17] > 0.49f && values[17] < 0.51f);
        io_close(&picture);
        unlink(path);
    }
    assert_int_equal(count_files(), 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_before_reading),
        cmocka_unit_test(test_before_writing),
        cmocka_unit_test(test_replaced),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
