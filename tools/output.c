/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "output.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "message.h"

int output_check(option_id option, const char *path, io_format *format) {
    const char *name = option_table[option].name;
    if (!io_format_of_name(path, format))
        return fail_usage("--%s: %s: unknown ending; use .exr, .png, .tif, .tiff or .pfm", name, path);
    if (!io_format_writes(*format))
        return fail_usage("--%s: %s: %s is read, but not written; use .exr, .png, .tif, .tiff or .pfm", name, path,
                          io_format_name(*format));
    struct stat info;
    if (stat(path, &info) == 0 && S_ISDIR(info.st_mode))
        return fail("%s: is a folder; give --%s the name of a file", path, name);
    io_error error = {0};
    if (io_check_output(path, &error)) return fail("%s", error.text);
    const char *slash = strrchr(path, '/');
    char *folder = slash ? strndup(path, (size_t)(slash - path) + (slash == path)) : strdup(".");
    if (!folder) return fail("--%s: out of memory", name);
    int status = 0;
    if (stat(folder, &info) != 0 || (S_ISDIR(info.st_mode) && access(folder, W_OK | X_OK) != 0))
        status =
            fail("%s: folder '%s': %s; give --%s a place that can be written to", path, folder, strerror(errno), name);
    else if (!S_ISDIR(info.st_mode))
        status = fail("%s: '%s' is no folder; give --%s a place that can be written to", path, folder, name);
    free(folder);
    return status;
}

/* ------------------------------------------------------------------------- placing */

/* Row y of a channel as a channel. */
static io_channel row_of(const io_channel *channel, int y) {
    io_channel view = *channel;
    view.height = 1;
    view.data = (char *)channel->data + (size_t)y * (size_t)channel->width * io_type_size(channel->type);
    return view;
}

void output_place(io_channel *to, const float *from, io_box box) {
    int first = box.x < 0 ? -box.x : 0, last = box.width;
    if (box.x + (int64_t)box.width > to->width) last = to->width - box.x;
    if (last <= first) return;
    float *data = to->data;
    for (int y = 0; y < box.height; y++) {
        int64_t row = box.y + (int64_t)y;
        if (row < 0 || row >= to->height) continue;
        memcpy(data + row * to->width + box.x + first, from + (size_t)y * (size_t)box.width + first,
               (size_t)(last - first) * sizeof(float));
    }
}

static io_box place_in_display(const io_part *part, const io_channel *channel) {
    return (io_box){part->data.x - part->display.x, part->data.y - part->display.y, channel->width, channel->height};
}

void output_load_row(const io_channel *channel, int y, float *row) {
    const io_channel view = row_of(channel, y);
    io_channel_to_float(&view, row, 1, (size_t)channel->width);
}

/* ------------------------------------------------------------------------- another format */

static void note_losses(const io_picture *input, const io_selection *color, io_format format, const char *path,
                        int kept) {
    int channels = 0;
    for (int i = 0; i < input->part_count; i++)
        channels += input->part[i].channel_count;
    const bool linear = !input->part[color->part].channel[color->channel[0]].integer || input->format == IO_TIFF;
    const char *curve = format == IO_PNG && linear ? "sRGB-encoded, " : "";
    const char *alpha = kept < color->count ? "without alpha, " : "";
    const int others = channels - color->count;
    if (others > 0)
        note("note: %s: %s%s%d other channel%s and the metadata of %s left out", path, curve, alpha, others,
             others == 1 ? "" : "s", input->path);
    else
        note("note: %s: %s%sthe metadata of %s left out", path, curve, alpha, input->path);
}

typedef struct target {
    io_type type;
    int bits;
} target;

/* As precise as the source: 8 bits stay 8 where there are such, half stays half. */
static target target_of(const io_picture *input, const io_selection *color, io_format format) {
    const io_part *part = &input->part[color->part];
    const io_type source = part->channel[color->channel[0]].type;
    const bool integer = part->channel[color->channel[0]].integer;
    const bool eight = integer && part->bits == 8;
    if (format == IO_PFM) return (target){IO_FLOAT, 32};
    if (format == IO_PNG || (format == IO_TIFF && integer)) return (target){IO_FLOAT, eight ? 8 : 16};
    return eight || source == IO_HALF ? (target){IO_HALF, 16} : (target){IO_FLOAT, 32};
}

/* Row by row, so that nothing is as large as the picture but the picture. */
static int convert_channel(io_channel *to, const io_channel *from, const io_part *part, const char *path) {
    const io_box box = place_in_display(part, from);
    float *row = malloc(((size_t)from->width + (size_t)to->width) * sizeof(float)), *placed = row + from->width;
    if (!row) return fail("%s: out of memory for a row of %d pixels", path, to->width);
    for (int y = 0; y < to->height; y++) {
        const int64_t in = (int64_t)y - box.y;
        io_channel out = row_of(to, y), whole = out; /* placed as floats, then given its type */
        whole.data = placed;
        memset(placed, 0, (size_t)to->width * sizeof(float));
        if (in >= 0 && in < from->height) {
            output_load_row(from, (int)in, row);
            output_place(&whole, row, (io_box){box.x, 0, from->width, 1});
        }
        io_channel_from_float(&out, placed, 1, (size_t)to->width);
    }
    to->modified = true;
    free(row);
    return 0;
}

int output_convert(io_picture **made, const io_picture *input, const io_selection *color, io_format format,
                   const char *path, const io_options *writing) {
    static const char *const rgba[] = {"R", "G", "B", "A"}, *const ya[] = {"Y", "A"};
    const io_part *part = &input->part[color->part];
    const int kept = format == IO_PFM && color->alpha ? color->count - 1 : color->count;
    const target as = target_of(input, color, format);
    io_error error = {0};
    if (io_create_in(made, format, part->display.width, part->display.height, color->count > 2 ? rgba : ya, kept, as.type,
                     as.bits, IO_COLOR, writing->memory, &error))
        return fail("%s: %s", path, error.text);
    int status = 0;
    for (int i = 0; status == 0 && i < kept; i++)
        status = convert_channel(&(*made)->part[0].channel[i], &part->channel[color->channel[i]], part, path);
    if (status)
        io_close(made);
    else
        note_losses(input, color, format, path, kept);
    return status;
}

/* ------------------------------------------------------------------------- for the eye */

int output_create_rgb(io_picture **made, int width, int height, const char *path, const io_options *writing) {
    static const char *const names[] = {"R", "G", "B"};
    io_error error = {0};
    if (io_create_in(made, IO_PNG, width, height, names, 3, IO_FLOAT, 8, IO_COLOR, writing->memory, &error))
        return fail("%s: %s", path, error.text);
    for (int i = 0; i < 3; i++)
        io_channel_modified(&(*made)->part[0].channel[i]);
    return 0;
}

/* The mean of the pixels of one square of the display window; outside of the data window it is black. `values`: the rows
 * of the data window from `data.y` on. */
static float mean_of_square(const float *values, io_box data, int x, int y, int side) {
    float sum = 0;
    for (int j = 0; j < side; j++)
        for (int i = 0; i < side; i++) {
            const int64_t column = (int64_t)x + i - data.x, row = (int64_t)y + j - data.y;
            if (column < 0 || row < 0 || column >= data.width || row >= data.height) continue;
            const float value = values[row * data.width + column];
            if (isfinite(value)) sum += value;
        }
    return sum / (float)(side * side);
}

/* The rows of a channel among `count` of the display window, into `room`; where those are. */
static io_box load_rows(const io_channel *from, io_box data, int y, int count, float *room) {
    const int64_t first = y > data.y ? (int64_t)y - data.y : 0;
    int64_t end = (int64_t)y + count - data.y;
    if (end > data.height) end = data.height;
    for (int64_t row = first; row < end; row++)
        output_load_row(from, (int)row, room + (row - first) * data.width);
    return (io_box){data.x, (int)(data.y + first), data.width, end > first ? (int)(end - first) : 0};
}

int output_place_color(io_picture *made, int left, const io_picture *input, const io_selection *color, int shrink,
                       double gain) {
    const io_part *part = &input->part[color->part];
    const int width = (part->display.width + shrink - 1) / shrink;
    float *values = malloc((size_t)part->data.width * (size_t)shrink * sizeof(float));
    if (!values) return fail("%s: out of memory for %d rows", input->path, shrink);
    for (int i = 0; i < 3; i++) {
        const io_channel *from = &part->channel[color->channel[color->count > 2 ? i : 0]];
        const io_channel *to = &made->part[0].channel[i];
        for (int y = 0; y < to->height; y++) {
            const io_box data = load_rows(from, place_in_display(part, from), y * shrink, shrink, values);
            float *row = (float *)to->data + (size_t)y * (size_t)to->width + left;
            for (int x = 0; x < width; x++)
                row[x] = fminf(fmaxf((float)gain * mean_of_square(values, data, x * shrink, y * shrink, shrink), 0), 1);
        }
    }
    free(values);
    return 0;
}

int output_write(const io_picture *picture, const char *path, const io_options *writing) {
    io_error error = {0}, losses = {0};
    if (io_write(picture, path, writing, &losses, &error)) return fail("%s", error.text);
    if (*losses.text) note("note: %s", losses.text);
    return 0;
}
