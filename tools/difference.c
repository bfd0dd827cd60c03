/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "difference.h"

#include <math.h>
#include <stdlib.h>
#include <sys/stat.h>

#include "message.h"
#include "output.h"

static bool same_file(const char *a, const char *b) {
    struct stat p, q;
    return stat(a, &p) == 0 && stat(b, &q) == 0 && p.st_dev == q.st_dev && p.st_ino == q.st_ino;
}

int difference_check(const options *o) {
    const char *path = option_text(o, OPT_OUTPUT);
    if (!path) {
        const option_id lone = option_given(o, OPT_AMPLIFY) ? OPT_AMPLIFY : OPT_INVERT;
        if (!option_given(o, lone)) return 0;
        return fail_usage("--%s: describes a picture of the difference; say where it goes, like -o difference.png",
                          option_table[lone].name);
    }
    io_format format;
    int status = output_check(OPT_OUTPUT, path, &format);
    if (status) return status;
    if (format != IO_PNG && format != IO_EXR)
        return fail_usage("--output: %s: differences are written as PNG or EXR; use .png or .exr", path);
    for (int i = 0; i < 2; i++)
        if (same_file(path, o->file[i]))
            return fail_usage("--output: %s is one of the two pictures; give the difference another name", path);
    return 0;
}

/* 0 everywhere when the pixel is not finite in one of the pictures. */
static float amplified(const float *a, const float *b, int channel, double gain) {
    bool finite = true;
    for (int c = 0; c < 3; c++)
        finite = finite && isfinite(a[c]) && isfinite(b[c]);
    return finite ? (float)(gain * fabs((double)a[channel] - (double)b[channel])) : 0;
}

static void shade(const options *o, io_format format, float *value, size_t count) {
    for (size_t i = 0; i < count; i++) {
        if (option_given(o, OPT_INVERT)) value[i] = 1 - value[i];
        if (format == IO_PNG) value[i] = fminf(fmaxf(value[i], 0), 1);
    }
}

/* `place`: of the data window in the picture made. */
static void fill(const options *o, io_picture *made, io_box place, const float *a, const float *b, float *value) {
    const size_t count = (size_t)place.width * (size_t)place.height;
    const double gain = option_number(o, OPT_AMPLIFY, 255);
    for (int c = 0; c < 3; c++) {
        io_channel *channel = &made->part[0].channel[c];
        for (size_t i = 0; i < count; i++)
            value[i] = amplified(a + 3 * i, b + 3 * i, c, gain);
        output_place(channel, value, place);
        shade(o, made->format, channel->data, (size_t)channel->width * (size_t)channel->height);
        io_channel_modified(channel);
    }
}

/* PNG has no windows: it shows the display window. */
int difference_write(const options *o, const io_part *part, const float *a, const float *b, const io_options *writing) {
    static const char *const names[] = {"R", "G", "B"};
    const char *path = option_text(o, OPT_OUTPUT);
    io_format format = IO_PNG;
    io_picture *made = NULL;
    io_error error = {0};
    io_format_of_name(path, &format);
    const bool png = format == IO_PNG;
    const io_box window = png ? part->display : part->data;
    if (io_create(&made, format, window.width, window.height, names, 3, IO_FLOAT, png ? 8 : 32, IO_DATA, &error))
        return fail("%s: %s", path, error.text);
    if (!png) {
        made->part[0].data = part->data;
        made->part[0].display = part->display;
        made->part[0].pixel_aspect = part->pixel_aspect;
    }
    const io_box place = {part->data.x - window.x, part->data.y - window.y, part->data.width, part->data.height};
    float *value = malloc((size_t)place.width * (size_t)place.height * sizeof *value);
    int status = value ? 0 : fail("%s: out of memory for %dx%d pixels", path, window.width, window.height);
    if (status == 0) fill(o, made, place, a, b, value);
    if (status == 0) status = output_write(made, path, writing);
    free(value);
    io_close(&made);
    return status;
}
