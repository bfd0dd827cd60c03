/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Small pictures for docs/quality, tone-mapped as `ddof compare` does.
 *
 * quality_sheet A OUT.jpg: the picture
 * quality_sheet A B OUT.jpg: 4 |A - B| of the tone-mapped pictures, at half size
 */
#include <stdio.h>
#include <stdlib.h>

#include <jpeglib.h>

#include "frame.h"
#include "metrics.h"

enum { QUALITY = 78, AMPLIFY = 4 };

static void write_jpeg(const char *path, unsigned char *pixel, int width, int height) {
    struct jpeg_compress_struct jpeg;
    struct jpeg_error_mgr error; /* the default one ends the program with a message */
    FILE *file = fopen(path, "wb");
    if (!file) die("cannot be written", path);
    jpeg.err = jpeg_std_error(&error);
    jpeg_create_compress(&jpeg);
    jpeg_stdio_dest(&jpeg, file);
    jpeg.image_width = (JDIMENSION)width;
    jpeg.image_height = (JDIMENSION)height;
    jpeg.input_components = 3;
    jpeg.in_color_space = JCS_RGB;
    jpeg_set_defaults(&jpeg);
    jpeg_set_quality(&jpeg, QUALITY, TRUE);
    jpeg.optimize_coding = TRUE;
    jpeg_start_compress(&jpeg, TRUE);
    while (jpeg.next_scanline < jpeg.image_height) {
        JSAMPROW row = pixel + 3 * (size_t)jpeg.next_scanline * (size_t)width;
        jpeg_write_scanlines(&jpeg, &row, 1);
    }
    jpeg_finish_compress(&jpeg);
    jpeg_destroy_compress(&jpeg);
    if (fclose(file)) die("cannot be written", path);
}

static unsigned char byte_of(float value) {
    return (unsigned char)(255 * (value < 0 ? 0 : value > 1 ? 1 : value) + 0.5f);
}

static void write_picture(const frame *f, const char *path) {
    const size_t count = 3 * (size_t)f->width * (size_t)f->height;
    unsigned char *pixel = allocate(count, 1);
    for (size_t i = 0; i < count; i++)
        pixel[i] = byte_of(metrics_tone_map(f->rgb[i]));
    write_jpeg(path, pixel, f->width, f->height);
    free(pixel);
}

static void write_difference(const frame *a, const frame *b, const char *path) {
    if (a->width != b->width || a->height != b->height) die("the two pictures differ in size", path);
    const int width = a->width / 2, height = a->height / 2;
    unsigned char *pixel = allocate((size_t)width * (size_t)height, 3);
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++)
            for (int c = 0; c < 3; c++) {
                float sum = 0;
                for (int k = 0; k < 4; k++) {
                    const size_t at =
                        3 * ((size_t)(2 * y + k / 2) * (size_t)a->width + (size_t)(2 * x + k % 2)) + (size_t)c;
                    const float d = metrics_tone_map(a->rgb[at]) - metrics_tone_map(b->rgb[at]);
                    sum += d < 0 ? -d : d;
                }
                pixel[3 * (y * width + x) + c] = byte_of(AMPLIFY * sum / 4);
            }
    write_jpeg(path, pixel, width, height);
    free(pixel);
}

int main(int count, char **word) {
    if (count < 3 || count > 4) die("usage: quality_sheet A [B] OUT.jpg", word[0]);
    frame a = frame_read(word[1], IO_COLOR), b = {0};
    if (count == 4) b = frame_read(word[2], IO_COLOR);
    if (count == 4)
        write_difference(&a, &b, word[3]);
    else
        write_picture(&a, word[2]);
    frame_free(&a);
    frame_free(&b);
    return 0;
}
