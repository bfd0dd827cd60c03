/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* What a TIFF holds beside the first page's pixels. */
#include <stdlib.h>
#include <string.h>

#include "make_tiff.h"

static void test_metadata(void **state) {
    (void)state;
    static const char *const modes[] = {"wl", "wb", "wl8", "wb8"};
    for (int i = 0; i < 4; i++) {
        tiff_spec s = {.width = 20, .height = 10, .samples = 3, .bits = 8, .photometric = -1, .extra = -1, .rows = 3};
        void *pixels = tiff_random(&s, 1);
        s.pixels = pixels;
        TIFF *tiff = TIFFOpen(in_folder("in.tif"), modes[i]);
        write_rich_page(tiff, &s);
        TIFFClose(tiff);
        const char *note = rewrite(in_folder("in.tif"), in_folder("out.tif"), IO_COLOR);
        assert_string_equal(note, "");
        rewrite(in_folder("out.tif"), in_folder("out2.tif"), IO_COLOR);
        tiff = TIFFOpen(in_folder("out2.tif"), "r");
        assert_int_equal(TIFFIsBigTIFF(tiff), i >= 2);
        check_metadata(tiff);
        check_exif(tiff);
        TIFFClose(tiff);
        io_picture *picture = open_picture(in_folder("out.tif"));
        assert_float_equal(picture->part[0].pixel_aspect, 150.25 / 300, 1e-6);
        io_close(&picture);
        free(pixels);
    }
}

static void test_pages(void **state) {
    (void)state;
    static const char *const modes[] = {"wl", "wb", "wl8"};
    for (int i = 0; i < 3; i++) {
        tiff_spec first = {.width = 20, .height = 10, .samples = 3, .bits = 8, .photometric = -1, .extra = -1}, got;
        tiff_spec second = {.width = 40,
                            .height = 30,
                            .samples = 1,
                            .bits = 32,
                            .format = SAMPLEFORMAT_IEEEFP,
                            .photometric = -1,
                            .extra = -1,
                            .tile = 16,
                            .compression = COMPRESSION_ADOBE_DEFLATE,
                            .predictor = i == 1 ? 2 : 3};
        tiff_spec third = {
            .width = 11, .height = 12, .samples = 4, .bits = 16, .photometric = -1, .extra = 1, .planar = 2, .rows = 5};
        void *pixels[] = {tiff_random(&first, 1), tiff_random(&second, 2), tiff_random(&third, 3)};
        first.pixels = pixels[0];
        second.pixels = pixels[1];
        third.pixels = pixels[2];
        TIFF *tiff = TIFFOpen(in_folder("in.tif"), modes[i]);
        tiff_set_layout(tiff, &first);
        tiff_put_samples(tiff, &first);
        TIFFWriteDirectory(tiff);
        tiff_set_layout(tiff, &first); /* a thumbnail */
        TIFFSetField(tiff, TIFFTAG_SUBFILETYPE, FILETYPE_REDUCEDIMAGE);
        tiff_put_samples(tiff, &first);
        TIFFWriteDirectory(tiff);
        tiff_set_layout(tiff, &second);
        tiff_put_samples(tiff, &second);
        TIFFWriteDirectory(tiff);
        write_rich_page(tiff, &third);
        TIFFClose(tiff);
        const char *note = rewrite(in_folder("in.tif"), in_folder("out.tif"), IO_COLOR);
        assert_non_null(strstr(note, "1 reduced pages"));
        tiff = TIFFOpen(in_folder("out.tif"), "rc");
        assert_int_equal(TIFFNumberOfDirectories(tiff), 3);
        const tiff_spec *const specs[] = {&first, &second, &third};
        for (int page = 0; page < 3; page++) {
            assert_int_equal(TIFFSetDirectory(tiff, (tdir_t)page), 1);
            unsigned char *out = tiff_samples(tiff, &got);
            assert_memory_equal(out, pixels[page], tiff_bytes(specs[page]));
            assert_int_equal(got.tile, specs[page]->tile);
            free(out);
        }
        check_metadata(tiff);
        check_exif(tiff);
        TIFFClose(tiff);
        for (int page = 0; page < 3; page++)
            free(pixels[page]);
    }
}
int main(void) {
    TIFFSetWarningHandler(NULL); /* of the files this test reads with libtiff itself */
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_metadata),
        cmocka_unit_test(test_pages),
    };
    return cmocka_run_group_tests_name("tiff metadata", tests, make_folder, remove_folder);
}
