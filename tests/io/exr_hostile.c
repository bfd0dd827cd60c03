/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* EXR files that are cut off, damaged or made to harm: one line says what is wrong, and nothing else happens. */
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support.h"

enum { NONE, RLE, ZIPS, ZIP, PIZ, PXR24, B44, B44A };

static const exr_channel_spec channels[] = {{"R", IO_HALF, false, 0, 0},
                                            {"G", IO_HALF, true, 0, 0},
                                            {"Z", IO_FLOAT, false, 0, 0},
                                            {"id", IO_UINT, false, 0, 0}};

/* Opens, reads, selects and writes; whatever fails must say so in one line. True when all went well. */
static bool survive(const char *path) {
    io_options options = {.threads = 1, .max_pixels = 1 << 22};
    io_error error = {{0}}, note;
    io_picture *picture;
    io_selection color, depth;
    if (io_open(&picture, path, IO_COLOR, &options, &error) != 0) {
        assert_null(picture);
        assert_one_line(&error, path);
        return false;
    }
    if (io_select_color(picture, NULL, &color, &error) != 0) assert_one_line(&error, path);
    if (io_select_depth(picture, NULL, &color, &depth, &error) != 0) assert_one_line(&error, path);
    bool well = io_read(picture, &error) == 0;
    if (!well) assert_one_line(&error, path);
    if (well && picture->part[0].channel[0].data) io_channel_modified(&picture->part[0].channel[0]);
    if (io_write(picture, in_folder("survived.exr"), &options, &note, &error) != 0) {
        well = false;
        /* A message is about the file that is at fault, and that may be either. */
        assert_int_not_equal(error.text[0], '\0');
        assert_null(strchr(error.text, '\n'));
    }
    io_close(&picture);
    return well;
}

static void make_small(const char *path, int compression, int tile) {
    exr_spec spec = {.compression = compression,
                     .tile = tile,
                     .data = {-3, 5, 19, 70},
                     .display = {0, 0, 16, 80},
                     .channels = channels,
                     .channel_count = 4};
    make_exr(path, &spec, 1);
}

static void test_cut_off_anywhere(void **state) {
    (void)state;
    const char *cut = in_folder("cut.exr");
    for (int compression = NONE; compression <= B44A; compression++)
        for (int tile = 0; tile <= 16; tile += 16) {
            size_t size;
            make_small(in_folder("in.exr"), compression, tile);
            unsigned char *bytes = read_file(in_folder("in.exr"), &size);
            for (size_t length = 0; length < size; length += length < 1500 ? 23 : 331) {
                write_file(cut, bytes, length);
                assert_false(survive(cut));
            }
            free(bytes);
        }
}

static void test_names_the_first_missing_row(void **state) {
    (void)state;
    size_t size;
    io_error error = {{0}};
    make_small(in_folder("in.exr"), ZIP, 0);
    unsigned char *bytes = read_file(in_folder("in.exr"), &size);
    write_file(in_folder("cut.exr"), bytes, size - 10);
    io_picture *picture = open_picture(in_folder("cut.exr"));
    assert_int_equal(io_read(picture, &error), -1);
    assert_non_null(strstr(error.text, "rows 69 to 74 are missing")); /* 70 rows from 5 on, by 16 */
    assert_null(picture->part[0].channel[0].data);
    io_close(&picture);
    free(bytes);
}

static void test_damaged_pixels_name_their_rows(void **state) {
    (void)state;
    size_t size;
    io_error error = {{0}};
    make_small(in_folder("in.exr"), ZIP, 0);
    unsigned char *bytes = read_file(in_folder("in.exr"), &size);
    memset(bytes + size - 200, 0x55, 100);
    write_file(in_folder("bad.exr"), bytes, size);
    for (int threads = 1; threads <= 4; threads++) {
        io_options options = {.threads = threads};
        io_picture *picture;
        assert_int_equal(io_open(&picture, in_folder("bad.exr"), IO_COLOR, &options, &error), 0);
        assert_int_equal(io_read(picture, &error), -1);
        assert_non_null(strstr(error.text, "rows 69 to 74 are damaged"));
        io_close(&picture);
    }
    free(bytes);
}

/* Replaces the window in the header: {x0, y0, x1, y1}. */
static void set_window(unsigned char *bytes, size_t size, const char *name, const int32_t window[4]) {
    for (size_t i = 0; i + 64 < size; i++)
        if (memcmp(bytes + i, name, strlen(name) + 1) == 0) {
            memcpy(bytes + i + strlen(name) + 1 + sizeof "box2i" + 4, window, 16);
            return;
        }
    fail();
}

static void test_declared_sizes(void **state) {
    static const struct {
        int32_t window[4];
        const char *message;
    } cases[] = {
        {{0, 0, 99999, 99999}, "more than the limit"},
        {{0, 0, 1 << 21, 10}, "too large"},
        {{0, 0, 40000, 40000}, "cannot hold"},
        {{-2000000000, 0, 2000000000, 10}, "damaged"},
        {{10, 10, 9, 9}, "empty"},
        {{INT32_MIN, INT32_MIN, INT32_MAX, INT32_MAX}, "damaged"},
    };
    (void)state;
    size_t size;
    make_small(in_folder("in.exr"), ZIP, 0);
    unsigned char *bytes = read_file(in_folder("in.exr"), &size);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        io_picture *picture;
        io_error error = {{0}};
        set_window(bytes, size, "dataWindow", cases[i].window);
        write_file(in_folder("huge.exr"), bytes, size);
        assert_int_equal(io_open(&picture, in_folder("huge.exr"), IO_COLOR, NULL, &error), -1);
        assert_one_line(&error, in_folder("huge.exr"));
        if (!strstr(error.text, cases[i].message)) fail_msg("'%s' is not about '%s'", error.text, cases[i].message);
    }
    free(bytes);
}

static void test_pixel_limit(void **state) {
    (void)state;
    io_options options = {.max_pixels = 1000};
    io_picture *picture;
    io_error error = {{0}};
    make_small(in_folder("in.exr"), ZIP, 0);
    assert_int_equal(io_open(&picture, in_folder("in.exr"), IO_COLOR, &options, &error), -1);
    assert_one_line(&error, in_folder("in.exr"));
}

/* All entries of the chunk table point to the first chunk, which would be copied again and again. */
static void test_chunks_that_share_bytes(void **state) {
    (void)state;
    size_t size;
    exr_spec spec = {
        .compression = NONE, .data = {0, 0, 100, 100}, .channels = channels, .channel_count = 4, .deep = true};
    make_exr(in_folder("in.exr"), &spec, 1);
    unsigned char *bytes = read_file(in_folder("in.exr"), &size);
    size_t table = 0;
    uint64_t first, second;
    for (size_t i = 8; i + 816 < size && !table; i++) {
        memcpy(&first, bytes + i, 8);
        if (first == i + 800) /* a table of 100 entries ends where the first chunk begins */
            table = i;
    }
    assert_int_not_equal(table, 0);
    for (int i = 1; i < 100; i++) {
        /* y is checked too: each chunk gets its own y, in turn, by the longest chunk being claimed by all. */
        memcpy(&second, bytes + table + 8 * i, 8);
        uint64_t huge = size - second - 28 - 400;
        memcpy(bytes + second + 12, &huge, 8);
    }
    write_file(in_folder("shared.exr"), bytes, size);
    io_picture *picture = open_picture(in_folder("shared.exr"));
    io_error error = {{0}};
    assert_int_equal(io_write(picture, in_folder("out.exr"), NULL, NULL, &error), -1);
    assert_one_line(&error, in_folder("shared.exr"));
    io_close(&picture);
    free(bytes);
}

/* Always the same bytes: what fails once fails again. */
static void test_changed_bytes(void **state) {
    (void)state;
    uint64_t random = 88172645463325252u;
    for (int compression = NONE; compression <= B44A; compression++)
        for (int tile = 0; tile <= 16; tile += 16) {
            size_t size;
            make_small(in_folder("in.exr"), compression, tile);
            unsigned char *bytes = read_file(in_folder("in.exr"), &size), *copy = malloc(size);
            assert_non_null(copy);
            for (int run = 0; run < 60; run++) {
                memcpy(copy, bytes, size);
                for (int i = 0; i < 1 + run % 5; i++) {
                    random ^= random << 13, random ^= random >> 7, random ^= random << 17;
                    size_t place = (size_t)(random >> 20) % (run % 2 ? size : 600);
                    copy[place] = run % 3 ? (unsigned char)random : copy[place] ^ (unsigned char)(1 << random % 8);
                }
                write_file(in_folder("changed.exr"), copy, size);
                survive(in_folder("changed.exr"));
            }
            free(bytes);
            free(copy);
        }
}

static void test_damaged_pictures_of_openexr(void **state) {
    (void)state;
    const char *readme = data_file("openexr-images/Damaged/README.rst");
    if (!readme) skip();
    char folder[1024], path[2048];
    snprintf(folder, sizeof folder, "%.*s", (int)(strlen(readme) - strlen("README.rst")), readme);
    DIR *dir = opendir(folder);
    assert_non_null(dir);
    int seen = 0;
    for (struct dirent *entry; (entry = readdir(dir));)
        if (entry->d_name[0] != '.') {
            snprintf(path, sizeof path, "%s%s", folder, entry->d_name);
            assert_false(survive(path));
            seen++;
        }
    closedir(dir);
    assert_true(seen > 10);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_cut_off_anywhere),
        cmocka_unit_test(test_names_the_first_missing_row),
        cmocka_unit_test(test_damaged_pixels_name_their_rows),
        cmocka_unit_test(test_declared_sizes),
        cmocka_unit_test(test_pixel_limit),
        cmocka_unit_test(test_chunks_that_share_bytes),
        cmocka_unit_test(test_changed_bytes),
        cmocka_unit_test(test_damaged_pictures_of_openexr),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
