/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include <jxl/encode.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include "make_phone.h"

enum { ALPHA = 3, DEPTH = 4 };

/* Floats: integers are v / maximum, which libjxl makes v again. */
static float *values_of(const phone_spec *s, int first, int channels, int bits) {
    const size_t count = (size_t)s->width * (size_t)s->height * (size_t)channels;
    float *values = malloc(count * sizeof *values), *out = values;
    const float maximum = (float)((1 << bits) - 1);
    for (int y = 0; values && y < s->height; y++)
        for (int x = 0; x < s->width; x++)
            for (int c = 0; c < channels; c++) {
                const float value = phone_value(first + c, x, y, s->width, s->height);
                *out++ = bits ? rintf(value * maximum) / maximum : value;
            }
    return values;
}

static bool describe_extra(JxlEncoder *encoder, size_t index, JxlExtraChannelType type, int bits) {
    JxlExtraChannelInfo info;
    JxlEncoderInitExtraChannelInfo(type, &info);
    info.bits_per_sample = bits ? (uint32_t)bits : 32;
    info.exponent_bits_per_sample = bits ? 0 : 8;
    return JxlEncoderSetExtraChannelInfo(encoder, index, &info) == JXL_ENC_SUCCESS;
}

static bool describe(JxlEncoder *encoder, const phone_spec *s) {
    JxlBasicInfo info;
    JxlColorEncoding color;
    JxlEncoderInitBasicInfo(&info);
    info.xsize = (uint32_t)s->width;
    info.ysize = (uint32_t)s->height;
    info.bits_per_sample = s->bits ? (uint32_t)s->bits : 32;
    info.exponent_bits_per_sample = s->bits ? 0 : 8;
    info.num_color_channels = s->grey ? 1 : 3;
    info.num_extra_channels = (uint32_t)s->alpha + (s->depth_width > 0);
    info.alpha_bits = s->alpha ? info.bits_per_sample : 0;
    info.alpha_exponent_bits = s->alpha ? info.exponent_bits_per_sample : 0;
    info.uses_original_profile = !s->lossy;
    (s->linear ? JxlColorEncodingSetToLinearSRGB : JxlColorEncodingSetToSRGB)(&color, s->grey);
    if (s->primaries == 9) color.primaries = JXL_PRIMARIES_2100;
    if (s->transfer) color.transfer_function = (JxlTransferFunction)s->transfer;
    JxlEncoderUseContainer(encoder, s->container);
    return JxlEncoderSetBasicInfo(encoder, &info) == JXL_ENC_SUCCESS &&
           (!s->alpha || describe_extra(encoder, 0, JXL_CHANNEL_ALPHA, s->bits)) &&
           (!s->depth_width || describe_extra(encoder, s->alpha, JXL_CHANNEL_DEPTH, s->depth_bits)) &&
           JxlEncoderSetColorEncoding(encoder, &color) == JXL_ENC_SUCCESS &&
           JxlEncoderSetCodestreamLevel(encoder, JxlEncoderGetRequiredCodestreamLevel(encoder)) == JXL_ENC_SUCCESS;
}

static bool add_frame(JxlEncoder *encoder, const phone_spec *s) {
    JxlEncoderFrameSettings *settings = JxlEncoderFrameSettingsCreate(encoder, NULL);
    const int channels = s->grey ? 1 : 3;
    JxlPixelFormat format = {(uint32_t)channels, JXL_TYPE_FLOAT, JXL_NATIVE_ENDIAN, 0}, one = {1, JXL_TYPE_FLOAT, JXL_NATIVE_ENDIAN, 0};
    const size_t bytes = (size_t)s->width * (size_t)s->height * sizeof(float);
    float *color = values_of(s, 0, channels, s->bits), *depth = values_of(s, DEPTH, 1, s->depth_bits);
    float *alpha = values_of(s, ALPHA, 1, s->bits);
    bool good = color && depth && alpha;
    if (!s->lossy) good = good && JxlEncoderSetFrameLossless(settings, true) == JXL_ENC_SUCCESS;
    good = good && JxlEncoderAddImageFrame(settings, &format, color, bytes * (size_t)channels) == JXL_ENC_SUCCESS;
    if (s->alpha) good = good && JxlEncoderSetExtraChannelBuffer(settings, &one, alpha, bytes, 0) == JXL_ENC_SUCCESS;
    if (s->depth_width)
        good = good && JxlEncoderSetExtraChannelBuffer(settings, &one, depth, bytes, s->alpha) == JXL_ENC_SUCCESS;
    free(color);
    free(depth);
    free(alpha);
    JxlEncoderCloseInput(encoder);
    return good;
}

static bool write_output(JxlEncoder *encoder, const char *path) {
    unsigned char buffer[4096];
    FILE *file = fopen(path, "wb");
    bool good = file != NULL;
    JxlEncoderStatus status = JXL_ENC_NEED_MORE_OUTPUT;
    while (good && status == JXL_ENC_NEED_MORE_OUTPUT) {
        unsigned char *next = buffer;
        size_t left = sizeof buffer;
        status = JxlEncoderProcessOutput(encoder, &next, &left);
        good = fwrite(buffer, 1, sizeof buffer - left, file) == sizeof buffer - left;
    }
    if (file && fclose(file) != 0) good = false;
    return good && status == JXL_ENC_SUCCESS;
}

int make_jxl(const char *path, const phone_spec *spec) {
    JxlEncoder *encoder = JxlEncoderCreate(NULL);
    const bool good = encoder && describe(encoder, spec) && add_frame(encoder, spec) && write_output(encoder, path);
    if (encoder) JxlEncoderDestroy(encoder);
    return good ? 1 : -1;
}
