/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "coding.h"

float io_decode(const io_coding *coding, float encoded) {
    switch (coding->curve) {
    case IO_CURVE_SRGB:
        return io_srgb_to_linear(encoded);
    case IO_CURVE_POWER:
        return copysignf((float)pow(fabs((double)encoded), 1 / coding->power), encoded);
    case IO_CURVE_LINEAR:
        break;
    }
    return encoded;
}

float io_encode(const io_coding *coding, float linear) {
    switch (coding->curve) {
    case IO_CURVE_SRGB:
        return io_linear_to_srgb(linear);
    case IO_CURVE_POWER:
        return copysignf((float)pow(fabs((double)linear), coding->power), linear);
    case IO_CURVE_LINEAR:
        break;
    }
    return linear;
}

float *io_decode_table(const io_coding *coding, int bits, bool colour, bool inverted) {
    const uint32_t maximum = (1u << bits) - 1;
    float *table = malloc(sizeof *table * ((size_t)maximum + 1));
    if (table == NULL) return NULL;
    /* Associated colour must be divided by alpha before the curve, so the curve cannot be in its table. */
    const bool curve = colour && coding->alpha != IO_ALPHA_ASSOCIATED;
    for (uint32_t v = 0; v <= maximum; v++) {
        float encoded = (float)((double)(inverted ? maximum - v : v) / maximum);
        table[v] = curve ? io_decode(coding, encoded) : encoded;
    }
    return table;
}

void io_decode_row(const io_coding *coding, float *const *colour, int colours, const float *alpha, int width) {
    if (alpha == NULL || coding->alpha == IO_ALPHA_NONE) return;
    for (int c = 0; c < colours; c++) {
        float *v = colour[c];
        if (coding->alpha == IO_ALPHA_STRAIGHT) {
            for (int x = 0; x < width; x++)
                v[x] *= alpha[x];
        } else if (coding->curve != IO_CURVE_LINEAR) {
            /* Light without coverage (alpha 0, a glow) has no straight colour: the curve alone. */
            for (int x = 0; x < width; x++)
                v[x] = alpha[x] > 0 ? io_decode(coding, v[x] / alpha[x]) * alpha[x] : io_decode(coding, v[x]);
        }
    }
}

void io_encode_row(const io_coding *coding, float *const *colour, int colours, const float *alpha, int width) {
    const bool divide = alpha != NULL && coding->alpha != IO_ALPHA_NONE;
    const bool multiply = coding->alpha == IO_ALPHA_ASSOCIATED;
    if (coding->curve == IO_CURVE_LINEAR && (!divide || multiply)) return;
    for (int c = 0; c < colours; c++) {
        float *v = colour[c];
        for (int x = 0; x < width; x++) {
            if (!divide) {
                v[x] = io_encode(coding, v[x]);
            } else if (!(alpha[x] > 0)) {
                v[x] = multiply ? io_encode(coding, v[x]) : 0;
            } else {
                float encoded = io_encode(coding, v[x] / alpha[x]);
                v[x] = multiply ? encoded * alpha[x] : encoded;
            }
        }
    }
}

uint64_t io_quantize(const float *encoded, int width, int bits, bool inverted, void *out, size_t step) {
    const double maximum = bits == 32 ? 4294967295.0 : bits == 16 ? 65535.0 : 255.0;
    uint64_t clamped = 0;
    for (int x = 0; x < width; x++) {
        double v = (double)encoded[x] * maximum + 0.5;
        if (!(v >= 0 && v < maximum + 1)) {
            clamped++;
            v = v > 0 ? maximum : 0; /* NaN compares false: 0 */
        }
        uint32_t q = (uint32_t)v;
        if (inverted) q = (uint32_t)maximum - q;
        if (bits == 8)
            ((uint8_t *)out)[(size_t)x * step] = (uint8_t)q;
        else if (bits == 16)
            ((uint16_t *)out)[(size_t)x * step] = (uint16_t)q;
        else
            ((uint32_t *)out)[(size_t)x * step] = q;
    }
    return clamped;
}

void io_channel_span(const io_channel *channel, int x, int y, int count, float *out) {
    io_channel view = *channel;
    view.width = count;
    view.height = 1;
    view.data = (char *)channel->data + ((size_t)y * (size_t)channel->width + (size_t)x) * io_type_size(channel->type);
    io_channel_to_float(&view, out, 1, (size_t)count);
}

void io_note(io_error *note, const char *path, const char *format, ...) {
    if (note == NULL) return;
    size_t used = strlen(note->text);
    int n = used == 0 ? snprintf(note->text, sizeof note->text, "%s: ", path)
                      : snprintf(note->text + used, sizeof note->text - used, "; ");
    if (n < 0 || (used += (size_t)n) >= sizeof note->text) return;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(note->text + used, sizeof note->text - used, format, arguments);
    va_end(arguments);
}

const io_channel *io_find_channel(const io_part *part, const char *name) {
    for (int i = 0; i < part->channel_count; i++)
        if (strcmp(part->channel[i].name, name) == 0) return &part->channel[i];
    return NULL;
}

int io_plain_channels(const io_part *part, const io_channel *channel[4]) {
    static const char *const grey[] = {"Y", "A"}, *const rgb[] = {"R", "G", "B", "A"};
    const int count = part->channel_count;
    const char *const *names = count <= 2 ? grey : rgb;
    if (count < 1 || count > 4) return 0;
    for (int i = 0; i < count; i++)
        if ((channel[i] = io_find_channel(part, names[i])) == NULL) return 0;
    return count;
}

bool io_name_wanted(const char *name, const char *const *names, int name_count) {
    if (names == NULL) return true;
    for (int i = 0; i < name_count; i++)
        if (strcmp(names[i], name) == 0) return true;
    return false;
}

int io_read_missing(const io_picture *picture, io_error *error) {
    /* Only data that is NULL is touched: what the caller sees of a picture to be written does not change. */
    const io_part *part = &picture->part[0];
    for (int c = 0; c < part->channel_count; c++)
        if (part->channel[c].data == NULL)
            return io_handler_of(picture->format)->read((io_picture *)picture, 0, NULL, 0, error);
    return 0;
}

int64_t io_file_length(FILE *file) {
    struct stat status;
    return fstat(fileno(file), &status) == 0 ? (int64_t)status.st_size : 0;
}
