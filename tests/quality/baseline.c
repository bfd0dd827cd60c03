/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* What the library is compared with: plain depth of field by discs, and pictures for other people's programs.
 *
 * quality_baseline gather|scatter IN COC.exr OUT.exr
 *
 * quality_baseline rgb IN OUT.exr: colour alone
 * quality_baseline map COC.exr OUT.exr|.png: |CoC| over the largest, grey; prints the largest
 * quality_baseline pack IN OUT.png: linear, 16 bits, divided by the brightest value above 1; prints that
 * quality_baseline unpack IN.png OUT.exr SCALE: and back
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "frame.h"

static float largest_of(const float *value, size_t count) {
    float largest = 0;
    for (size_t i = 0; i < count; i++)
        largest = fmaxf(largest, fabsf(value[i]));
    return largest;
}

static void blur(void (*how)(const frame *, float *), char **word) {
    frame in = frame_read(word[0], IO_COLOR);
    frame_read_coc(&in, word[1]);
    frame out = {.width = in.width, .height = in.height};
    out.rgb = allocate((size_t)in.width * (size_t)in.height, 3 * sizeof(float));
    how(&in, out.rgb);
    frame_write(&out, word[2], IO_COLOR);
    frame_free(&in);
    frame_free(&out);
}

static void map(char **word) {
    io_picture *picture = NULL;
    io_error error = {0};
    if (io_open(&picture, word[0], IO_DATA, NULL, &error)) die(error.text, word[0]);
    frame f = {.width = picture->part[0].data.width, .height = picture->part[0].data.height};
    io_close(&picture);
    const size_t count = (size_t)f.width * (size_t)f.height;
    frame_read_coc(&f, word[0]);
    f.rgb = allocate(count, 3 * sizeof(float));
    const float largest = largest_of(f.coc, count);
    for (size_t i = 0; i < 3 * count; i++)
        f.rgb[i] = largest > 0 ? fabsf(f.coc[i / 3]) / largest : 0;
    frame_write(&f, word[1], IO_DATA);
    printf("%.6f\n", (double)largest);
    frame_free(&f);
}

static void scaled(const char *from, io_meaning read_as, const char *to, io_meaning write_as, double scale) {
    frame f = frame_read(from, read_as);
    const size_t count = 3 * (size_t)f.width * (size_t)f.height;
    if (scale <= 0) {
        const double largest = fmax(1, (double)largest_of(f.rgb, count));
        printf("%.9g\n", largest);
        scale = 1 / largest;
    }
    for (size_t i = 0; i < count; i++)
        f.rgb[i] = (float)(scale * (double)f.rgb[i]);
    frame_write(&f, to, write_as);
    frame_free(&f);
}

int main(int count, char **word) {
    const char *what = count > 1 ? word[1] : "";
    if (strcmp(what, "gather") == 0 && count == 5)
        blur(gather, word + 2);
    else if (strcmp(what, "scatter") == 0 && count == 5)
        blur(scatter, word + 2);
    else if (strcmp(what, "rgb") == 0 && count == 4)
        scaled(word[2], IO_COLOR, word[3], IO_COLOR, 1);
    else if (strcmp(what, "map") == 0 && count == 4)
        map(word + 2);
    else if (strcmp(what, "pack") == 0 && count == 4)
        scaled(word[2], IO_COLOR, word[3], IO_DATA, 0);
    else if (strcmp(what, "unpack") == 0 && count == 5)
        scaled(word[2], IO_DATA, word[3], IO_COLOR, strtod(word[4], NULL));
    else
        die("usage: gather|scatter IN COC OUT, rgb IN OUT, map COC OUT, pack IN OUT, unpack IN OUT SCALE", word[0]);
    return 0;
}
