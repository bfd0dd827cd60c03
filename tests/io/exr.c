/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* EXR in, one channel changed, EXR out: all else is as it was. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support.h"

enum { NONE, RLE, ZIPS, ZIP, PIZ, PXR24, B44, B44A };

static const exr_channel_spec four[] = {{"R", IO_HALF, false, 0, 0},
                                        {"albedo.G", IO_HALF, true, 0, 0},
                                        {"Z", IO_FLOAT, true, 0, 0},
                                        {"id", IO_UINT, true, 0, 0}};

static void assert_as_specified(io_picture *picture, int part, const exr_spec *spec, const char *except) {
    for (int c = 0; c < spec->channel_count; c++) {
        const io_channel *channel = channel_of(picture, part, spec->channels[c].name);
        bool lossy = (spec->compression == B44 || spec->compression == B44A) && channel->type == IO_HALF;
        assert_int_equal(channel->type, spec->channels[c].type);
        if (lossy || (except && strcmp(channel->name, except) == 0)) continue;
        for (int y = 0; y < channel->height; y++)
            for (int x = 0; x < channel->width; x++) {
                size_t i = (size_t)y * (size_t)channel->width + (size_t)x;
                uint32_t bits = channel->type == IO_HALF ? ((const uint16_t *)channel->data)[i]
                                                         : ((const uint32_t *)channel->data)[i];
                if (bits != sample_of(spec, c, x, y))
                    fail_msg("%s at %d %d is %#x, not %#x", channel->name, x, y, (unsigned)bits,
                             (unsigned)sample_of(spec, c, x, y));
            }
    }
}

/* Reads, changes `changed`, writes, and looks at what became of it. */
static void check_round_trip(const exr_spec *spec, const char *changed) {
    const char *in = in_folder("in.exr"), *out = in_folder("out.exr");
    make_exr(in, spec, 1);
    io_picture *before = read_picture(in);
    assert_as_specified(before, 0, spec, NULL);
    change_channel(channel_of(before, 0, changed));
    write_picture(before, out, spec->compression >= B44 ? "B44 is lossy" : NULL);
    io_picture *after = read_picture(out), *original = read_picture(in);
    assert_same_pixels(original, after, changed);
    assert_as_specified(after, 0, spec, changed);
    io_type type = channel_of(before, 0, changed)->type;
    bool lossy = (spec->compression >= B44 && type == IO_HALF) || (spec->compression == PXR24 && type == IO_FLOAT);
    if (!lossy)
        assert_same_channel(channel_of(before, 0, changed), channel_of(after, 0, changed));
    else
        assert_memory_not_equal(channel_of(original, 0, changed)->data, channel_of(after, 0, changed)->data,
                                channel_bytes(channel_of(after, 0, changed)));
    assert_same_attributes(in, out, NULL);
    io_close(&before);
    io_close(&after);
    io_close(&original);
}

static void test_every_compression_type_and_size(void **state) {
    static const io_box boxes[] = {{0, 0, 1, 1}, {-7, -33, 37, 65}, {1000, 3, 16, 257}, {5, 5, 130, 2}};
    (void)state;
    for (int compression = NONE; compression <= B44A; compression++)
        for (int tile = 0; tile <= 24; tile += 24)
            for (size_t b = 0; b < sizeof boxes / sizeof boxes[0]; b++)
                for (int order = 0; order < (tile ? 3 : 2); order++) {
                    exr_spec spec = {.compression = compression,
                                     .tile = tile,
                                     .data = boxes[b],
                                     .display = {0, 0, 64, 48},
                                     .channels = four,
                                     .channel_count = 4};
                    check_round_trip(&spec, order == 0 ? "R" : order == 1 ? "Z" : "id");
                }
}

/* Some rows of Z are those of the whole; the first row, in another chunk when there are several, was left alone. */
static void check_rows(const char *path, const char *name, int row, int rows, bool first_left_out) {
    io_picture *whole = read_picture(path), *part = open_picture(path);
    const io_channel *all = channel_of(whole, 0, name);
    io_error error = {0};
    if (io_read_rows(part, 0, &name, 1, row, rows, &error) != 0) fail_msg("%s", error.text);
    const io_channel *some = channel_of(part, 0, name);
    const size_t line = (size_t)all->width * io_type_size(all->type);
    assert_non_null(some->data);
    assert_memory_equal((char *)some->data + line * (size_t)row, (char *)all->data + line * (size_t)row, line * (size_t)rows);
    if (first_left_out)
        for (size_t i = 0; i < line; i++)
            assert_int_equal(((unsigned char *)some->data)[i], 0);
    io_close(&whole);
    io_close(&part);
}

static void test_some_rows(void **state) {
    (void)state;
    for (int compression = NONE; compression <= B44A; compression++)
        for (int tile = 0; tile <= 24; tile += 24) {
            exr_spec spec = {.compression = compression,
                             .tile = tile,
                             .data = {-7, -33, 37, 165},
                             .display = {0, 0, 64, 48},
                             .channels = four,
                             .channel_count = 4};
            const char *path = in_folder("rows.exr");
            make_exr(path, &spec, 1);
            check_rows(path, "Z", 0, 165, false);
            check_rows(path, "Z", 0, 1, false);
            check_rows(path, "Z", 63, 2, true);
            check_rows(path, "Z", 95, 33, true);
            check_rows(path, "Z", 164, 1, true);
        }
}

static void test_many_channels(void **state) {
    static char names[30][260];
    exr_channel_spec channels[30];
    (void)state;
    for (int i = 0; i < 30; i++) {
        snprintf(
            names[i], sizeof names[i], "layer %d.%.*s", i * 7 % 30, i * 8, /* up to 31, then long */
            "abcdefghijklmnopqrstuvwxyzabcdefghijklmnopqrstuvwxyzabcdefghijklmnopqrstuvwxyzabcdefghijklmnopqrstuvwxyz"
            "abcdefghijklmnopqrstuvwxyzabcdefghijklmnopqrstuvwxyzabcdefghijklmnopqrstuvwxyzabcdefghijklmnopqrstuvwxyz"
            "abcdefghijklmnopqrstuvwxyz");
        channels[i] = (exr_channel_spec){names[i], i % 3 == 0 ? IO_HALF : i % 3 == 1 ? IO_FLOAT : IO_UINT, false, 0, 0};
    }
    exr_spec spec = {.compression = PIZ, .data = {0, 0, 20, 70}, .channels = channels, .channel_count = 30};
    check_round_trip(&spec, names[17]);
}

static void test_subsampled_channels(void **state) {
    /* Sampling that divides a chunk, as OpenEXRCore can write it; others: test_reference_subsampling. */
    static const exr_channel_spec channels[] = {{"Y", IO_HALF, false, 1, 1},
                                                {"RY", IO_HALF, true, 2, 2},
                                                {"BY", IO_HALF, true, 2, 2},
                                                {"far", IO_FLOAT, false, 4, 2}};
    (void)state;
    for (int compression = NONE; compression <= B44A; compression++) {
        exr_spec spec = {.compression = compression,
                         .data = {-8, -16, 36, 70},
                         .display = {0, 0, 64, 48},
                         .channels = channels,
                         .channel_count = 4};
        check_round_trip(&spec, "Y");
        check_round_trip(&spec, "RY");
    }
}

static void test_line_orders(void **state) {
    (void)state;
    /* OpenEXRCore writes increasing order only: the header says otherwise, and the order is ours to make. */
    for (int tile = 0; tile <= 16; tile += 16)
        for (int order = 0; order < 3; order++) {
            exr_spec spec = {
                .compression = ZIP, .tile = tile, .data = {0, 0, 40, 60}, .channels = four, .channel_count = 4};
            make_exr(in_folder("in.exr"), &spec, 1);
            size_t size;
            unsigned char *bytes = read_file(in_folder("in.exr"), &size);
            for (size_t i = 0; i + 24 < size; i++)
                if (memcmp(bytes + i, "lineOrder\0lineOrder\0\1\0\0\0", 24) == 0) bytes[i + 24] = (unsigned char)order;
            write_file(in_folder("in.exr"), bytes, size);
            free(bytes);
            io_picture *picture = read_picture(in_folder("in.exr"));
            change_channel(channel_of(picture, 0, "R"));
            write_picture(picture, in_folder("out.exr"), NULL);
            io_picture *after = read_picture(in_folder("out.exr"));
            assert_same_pixels(picture, after, NULL);
            assert_same_attributes(in_folder("in.exr"), in_folder("out.exr"), NULL);
            io_close(&picture);
            io_close(&after);
        }
}

static void test_all_attributes(void **state) {
    (void)state;
    exr_spec spec = {.compression = ZIP,
                     .data = {-2, 3, 20, 10},
                     .display = {0, 0, 16, 16},
                     .channels = four,
                     .channel_count = 4,
                     .many_attributes = true};
    check_round_trip(&spec, "R");
}

static void test_unchanged_is_copied(void **state) {
    (void)state;
    for (int compression = NONE; compression <= B44A; compression++) {
        exr_spec spec = {.compression = compression,
                         .data = {0, 0, 50, 50},
                         .channels = four,
                         .channel_count = 4,
                         .many_attributes = true};
        make_exr(in_folder("in.exr"), &spec, 1);
        io_picture *picture = compression % 2 ? open_picture(in_folder("in.exr")) : read_picture(in_folder("in.exr"));
        write_picture(picture, in_folder("out.exr"), NULL);
        assert_same_files(in_folder("in.exr"), in_folder("out.exr"));
        io_close(&picture);
    }
}

static void test_channels_never_read_are_kept(void **state) {
    (void)state;
    exr_spec spec = {.compression = PIZ, .tile = 32, .data = {0, 0, 50, 50}, .channels = four, .channel_count = 4};
    make_exr(in_folder("in.exr"), &spec, 1);
    io_picture *picture = open_picture(in_folder("in.exr"));
    io_error error;
    const char *names[] = {"R"};
    assert_int_equal(io_read_channels(picture, 0, names, 1, &error), 0);
    assert_non_null(channel_of(picture, 0, "R")->data);
    assert_null(channel_of(picture, 0, "Z")->data);
    change_channel(channel_of(picture, 0, "R"));
    write_picture(picture, in_folder("out.exr"), NULL);
    assert_null(channel_of(picture, 0, "Z")->data);
    io_picture *after = read_picture(in_folder("out.exr"));
    assert_as_specified(after, 0, &spec, "R");
    assert_same_channel(channel_of(picture, 0, "R"), channel_of(after, 0, "R"));
    names[0] = "nothing";
    assert_int_equal(io_read_channels(picture, 0, names, 1, &error), -1);
    assert_one_line(&error, in_folder("in.exr"));
    io_close(&picture);
    io_close(&after);
}

static void test_new_type(void **state) {
    (void)state;
    exr_spec spec = {.compression = ZIP, .data = {0, 0, 31, 33}, .channels = four, .channel_count = 4};
    make_exr(in_folder("in.exr"), &spec, 1);
    io_picture *picture = read_picture(in_folder("in.exr"));
    io_channel *r = channel_of(picture, 0, "R");
    io_error error;
    assert_int_equal(io_channel_retype(r, IO_FLOAT, &error), 0);
    for (int i = 0; i < 31 * 33; i++)
        ((float *)r->data)[i] = (float)i / 3;
    write_picture(picture, in_folder("out.exr"), NULL);
    io_picture *after = read_picture(in_folder("out.exr"));
    assert_same_pixels(picture, after, NULL);
    assert_same_attributes(in_folder("in.exr"), in_folder("out.exr"), "channels");
    io_close(&picture);
    io_close(&after);
}

static void make_three_parts(const char *path) {
    static const io_box display = {0, 0, 40, 50};
    const exr_spec parts[] = {
        {.name = "beauty",
         .view = "left",
         .compression = ZIP,
         .data = {-3, 2, 33, 40},
         .display = display,
         .channels = four,
         .channel_count = 4},
        {.name = "samples", .compression = NONE, .data = display, .deep = true},
        {.name = "other",
         .view = "right",
         .compression = B44,
         .tile = 16,
         .data = {1, 1, 30, 41},
         .display = display,
         .channels = four,
         .channel_count = 4},
    };
    make_exr(path, parts, 3);
}

static void test_what_is_said_of_parts(void **state) {
    (void)state;
    make_three_parts(in_folder("in.exr"));
    io_picture *picture = read_picture(in_folder("in.exr"));
    assert_int_equal(picture->part_count, 3);
    assert_string_equal(picture->part[0].name, "beauty");
    assert_string_equal(picture->part[2].view, "right");
    assert_string_equal(picture->part[1].storage, "deep scanline");
    assert_true(picture->part[1].deep);
    assert_null(picture->part[1].channel[0].data);
    assert_string_equal(picture->part[2].storage, "tiled");
    assert_string_equal(picture->part[2].compression, "B44");
    assert_int_equal(picture->part[0].data.x, -3);
    assert_int_equal(picture->part[0].display.height, 50);
    assert_true(picture->part[0].pixel_aspect == 1.5);
    io_error error;
    assert_int_equal(io_read_channels(picture, 1, NULL, 0, &error), -1); /* deep */
    assert_one_line(&error, in_folder("in.exr"));
    io_close(&picture);
}

static void test_one_part_changed(void **state) {
    (void)state;
    make_three_parts(in_folder("in.exr"));
    io_picture *picture = read_picture(in_folder("in.exr"));
    write_picture(picture, in_folder("copy.exr"), NULL);
    assert_same_files(in_folder("in.exr"), in_folder("copy.exr"));

    change_channel(channel_of(picture, 0, "R"));
    write_picture(picture, in_folder("out.exr"), NULL);
    io_picture *after = read_picture(in_folder("out.exr"));
    assert_same_pixels(picture, after, NULL);
    assert_same_attributes(in_folder("in.exr"), in_folder("out.exr"), NULL);

    /* The other parts, deep and lossy, are the end of both files: the same in every byte. */
    size_t size, out_size;
    unsigned char *in_bytes = read_file(in_folder("in.exr"), &size);
    unsigned char *out_bytes = read_file(in_folder("out.exr"), &out_size);
    size_t tail = size / 2;
    assert_memory_equal(in_bytes + size - tail, out_bytes + out_size - tail, tail);
    free(in_bytes);
    free(out_bytes);
    io_close(&picture);
    io_close(&after);
}

static void test_threads_do_not_matter(void **state) {
    (void)state;
    exr_spec spec = {.compression = ZIP, .data = {0, 0, 100, 400}, .channels = four, .channel_count = 4};
    make_exr(in_folder("in.exr"), &spec, 1);
    for (int threads = 1; threads <= 8; threads *= 2) {
        io_options options = {.threads = threads};
        io_error error;
        io_picture *picture;
        char name[20];
        assert_int_equal(io_open(&picture, in_folder("in.exr"), IO_COLOR, &options, &error), 0);
        assert_int_equal(io_read(picture, &error), 0);
        assert_as_specified(picture, 0, &spec, NULL);
        change_channel(channel_of(picture, 0, "R"));
        snprintf(name, sizeof name, "%d.exr", threads);
        assert_int_equal(io_write(picture, in_folder(name), &options, NULL, &error), 0);
        assert_same_files(in_folder("1.exr"), in_folder(name));
        io_close(&picture);
    }
}

static void test_new_picture(void **state) {
    (void)state;
    static const char *const names[] = {"R", "G", "B", "A"};
    for (int type = IO_HALF; type <= IO_UINT; type++) {
        io_picture *picture;
        io_error error;
        assert_int_equal(io_create(&picture, IO_EXR, 37, 21, names, 4, (io_type)type, 16, IO_COLOR, &error), 0);
        float *values = malloc(37 * 21 * 4 * sizeof *values);
        assert_non_null(values);
        for (int i = 0; i < 37 * 21 * 4; i++)
            values[i] = (float)(i % 512);
        for (int c = 0; c < 4; c++) {
            assert_string_equal(picture->part[0].channel[c].name, names[c]); /* in the caller's order */
            io_channel_from_float(&picture->part[0].channel[c], values + c, 4, 4 * 37);
        }
        picture->part[0].data.x = -4; /* windows may be set before it is written */
        picture->part[0].display = (io_box){0, 0, 30, 20};
        picture->part[0].pixel_aspect = 2;
        write_picture(picture, in_folder("new.exr"), NULL);
        io_picture *after = read_picture(in_folder("new.exr"));
        assert_string_equal(after->part[0].compression, "ZIP");
        assert_string_equal(after->part[0].storage, "scanline");
        assert_int_equal(after->part[0].data.x, -4);
        assert_int_equal(after->part[0].display.width, 30);
        assert_true(after->part[0].pixel_aspect == 2);
        assert_string_equal(after->part[0].channel[0].name, "A"); /* in the order of the file */
        for (int c = 0; c < 4; c++)
            assert_same_channel(&picture->part[0].channel[c], channel_of(after, 0, names[c]));
        float *back = calloc(37 * 21 * 4, sizeof *back);
        assert_non_null(back);
        for (int c = 0; c < 4; c++)
            io_channel_to_float(channel_of(after, 0, names[c]), back + c, 4, 4 * 37);
        assert_memory_equal(values, back, 37 * 21 * 4 * sizeof *values);
        free(values);
        free(back);
        io_close(&picture);
        io_close(&after);
    }
}

/* ------------------------------------------------------------------------- against the C++ library */

static void check_against_reference(const char *path, io_picture *picture) {
    static const int types[] = {[IO_UINT] = 0, [IO_HALF] = 1, [IO_FLOAT] = 2};
    for (int c = 0; c < picture->part[0].channel_count; c++) {
        const io_channel *channel = &picture->part[0].channel[c];
        unsigned char *data = calloc(1, channel_bytes(channel));
        assert_non_null(data);
        assert_true(read_reference(path, channel->name, types[channel->type], data, channel->width, channel->height));
        if (memcmp(data, channel->data, channel_bytes(channel)) != 0)
            fail_msg("%s: %s is not what the C++ library reads", path, channel->name);
        free(data);
    }
}

static void check_fixture(const char *kind, const char *note, const char *except) {
    const char *in = in_folder("fixture.exr"), *out = in_folder("out.exr");
    int made = make_fixture(kind, in);
    if (made == 0) skip();
    assert_int_equal(made, 1);
    io_picture *picture = read_picture(in);
    check_against_reference(in, picture);
    write_picture(picture, out, NULL);
    assert_same_files(in, out);
    change_channel(channel_of(picture, 0, "R"));
    write_picture(picture, out, note);
    io_picture *after = read_picture(out), *original = read_picture(in);
    assert_same_pixels(original, after, "R");
    if (!strstr(kind, "b44")) assert_same_pixels(picture, after, NULL);
    check_against_reference(out, after);
    assert_same_attributes(in, out, except);
    io_close(&picture);
    io_close(&after);
    io_close(&original);
}

static void test_dwa(void **state) {
    (void)state;
    check_fixture("dwaa scanline", "ZIP was used", "compression,chunkCount");
    check_fixture("dwab scanline", "ZIP was used", "compression,chunkCount");
    check_fixture("dwaa tiled", "ZIP was used", "compression");
    check_fixture("dwab subsampled", "ZIP was used", "compression,chunkCount");
    check_fixture("dwaa mipmap", "ZIP was used", "compression,tiles,chunkCount");
}

static void test_some_rows_of_dwa(void **state) {
    static const char *const kinds[] = {"dwaa scanline", "dwab scanline", "dwaa tiled"};
    (void)state;
    for (int i = 0; i < 3; i++) {
        const char *path = in_folder("rows.exr");
        if (make_fixture(kinds[i], path) == 0) skip();
        io_picture *picture = open_picture(path);
        const int height = channel_of(picture, 0, "R")->height;
        io_close(&picture);
        check_rows(path, "R", 0, 1, false);
        check_rows(path, "R", height / 2, 3, false);
        check_rows(path, "R", height - 1, 1, false);
    }
}

static void test_levels(void **state) {
    (void)state;
    check_fixture("zip mipmap", "smaller levels", "tiles,chunkCount");
    check_fixture("piz ripmap", "smaller levels", "tiles,chunkCount");
    check_fixture("none mipmap", "smaller levels", "tiles,chunkCount");
}

static void test_reference_subsampling(void **state) {
    (void)state;
    static const char *const kinds[] = {"none subsampled", "rle subsampled",   "zips subsampled", "zip subsampled",
                                        "piz subsampled",  "pxr24 subsampled", "b44 subsampled",  "b44a subsampled"};
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; i++)
        check_fixture(kinds[i], strstr(kinds[i], "b44") ? "B44 is lossy" : NULL, NULL);
}

static void test_reference_tiles(void **state) {
    (void)state;
    static const char *const kinds[] = {"none tiled", "rle tiled",   "zip tiled",
                                        "piz tiled",  "pxr24 tiled", "b44 tiled"};
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; i++)
        check_fixture(kinds[i], strstr(kinds[i], "b44") ? "B44 is lossy" : NULL, NULL);
}

static void test_deep_files_are_copied(void **state) {
    (void)state;
    static const char *const kinds[] = {"zips deep scanline", "zips deep tiled"};
    for (int i = 0; i < 2; i++) {
        int made = make_fixture(kinds[i], in_folder("deep.exr"));
        if (made == 0) skip();
        assert_int_equal(made, 1);
        io_picture *picture = read_picture(in_folder("deep.exr"));
        assert_true(picture->part[0].deep);
        assert_null(picture->part[0].channel[0].data);
        write_picture(picture, in_folder("out.exr"), NULL);
        assert_same_files(in_folder("deep.exr"), in_folder("out.exr"));
        io_close(&picture);
    }
}

/* ------------------------------------------------------------------------- pictures from elsewhere */

static void test_sample_pictures(void **state) {
    (void)state;
    static const char *const names[] = {
        "scenes/row/pinhole.exr",
        "scenes/motion/pinhole.exr",
        "openexr-images/Beachball/multipart.0001.exr",
        "openexr-images/Beachball/singlepart.0001.exr",
        "openexr-images/Tiles/GoldenGate.exr",
        "openexr-images/LuminanceChroma/Garden.exr",
        "openexr-images/TestImages/BrightRingsNanInf.exr",
        "openexr-images/DisplayWindow/t12.exr",
        "openexr-images/v2/LowResLeftView/Trunks.exr",
    };
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        const char *path = data_file(names[i]);
        if (!path) skip();
        io_picture *picture = read_picture(path);
        io_channel *first = &picture->part[0].channel[0];
        if (!picture->part[0].deep) change_channel(first);
        write_picture(picture, in_folder("out.exr"), NULL);
        io_picture *after = read_picture(in_folder("out.exr"));
        assert_same_pixels(picture, after, NULL);
        assert_same_attributes(path, in_folder("out.exr"), NULL);
        io_close(&picture);
        io_close(&after);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_compression_type_and_size),
        cmocka_unit_test(test_some_rows),
        cmocka_unit_test(test_many_channels),
        cmocka_unit_test(test_subsampled_channels),
        cmocka_unit_test(test_line_orders),
        cmocka_unit_test(test_all_attributes),
        cmocka_unit_test(test_unchanged_is_copied),
        cmocka_unit_test(test_channels_never_read_are_kept),
        cmocka_unit_test(test_new_type),
        cmocka_unit_test(test_what_is_said_of_parts),
        cmocka_unit_test(test_one_part_changed),
        cmocka_unit_test(test_threads_do_not_matter),
        cmocka_unit_test(test_new_picture),
        cmocka_unit_test(test_dwa),
        cmocka_unit_test(test_some_rows_of_dwa),
        cmocka_unit_test(test_levels),
        cmocka_unit_test(test_reference_subsampling),
        cmocka_unit_test(test_reference_tiles),
        cmocka_unit_test(test_deep_files_are_copied),
        cmocka_unit_test(test_sample_pictures),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
