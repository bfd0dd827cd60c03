/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "texels.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

#include "../library/layout.h"

typedef struct known {
    VkFormat format;
    const char *name;
    size_t bytes;
    bool depth;
} known;

static const known formats[] = {
    {VK_FORMAT_R32G32B32A32_SFLOAT, "rgba32f", 16, false},
    {VK_FORMAT_R16G16B16A16_SFLOAT, "rgba16f", 8, false},
    {VK_FORMAT_B10G11R11_UFLOAT_PACK32, "b10g11r11f", 4, false},
    {VK_FORMAT_E5B9G9R9_UFLOAT_PACK32, "e5b9g9r9", 4, false},
    {VK_FORMAT_A2B10G10R10_UNORM_PACK32, "a2b10g10r10", 4, false},
    {VK_FORMAT_R8G8B8A8_UNORM, "rgba8", 4, false},
    {VK_FORMAT_B8G8R8A8_UNORM, "bgra8", 4, false},
    {VK_FORMAT_R8G8B8A8_SRGB, "rgba8 srgb", 4, false},
    {VK_FORMAT_B8G8R8A8_SRGB, "bgra8 srgb", 4, false},
    {VK_FORMAT_D16_UNORM, "d16", 2, true},
    {VK_FORMAT_X8_D24_UNORM_PACK32, "x8 d24", 4, true},
    {VK_FORMAT_D24_UNORM_S8_UINT, "d24 s8", 4, true},
    {VK_FORMAT_D32_SFLOAT, "d32f", 4, true},
    {VK_FORMAT_D32_SFLOAT_S8_UINT, "d32f s8", 4, true},
    {VK_FORMAT_R32_SFLOAT, "r32f", 4, false},
    {VK_FORMAT_R16_SFLOAT, "r16f", 2, false},
    {VK_FORMAT_R8_UNORM, "r8", 1, false},
};

static const known *find(VkFormat format) {
    static const known none = {VK_FORMAT_UNDEFINED, "unknown", 16, false};
    for (size_t i = 0; i < sizeof formats / sizeof *formats; i++)
        if (formats[i].format == format) return &formats[i];
    return &none;
}

const char *format_name(VkFormat format) {
    return find(format)->name;
}

bool format_is_depth(VkFormat format) {
    return find(format)->depth;
}

size_t texel_bytes(VkFormat format) {
    return find(format)->bytes;
}

/* ---- numbers */

static double to_srgb(double v) {
    return v <= 0.0031308 ? 12.92 * v : 1.055 * pow(v, 1 / 2.4) - 0.055;
}

static double from_srgb(double v) {
    return v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
}

static uint32_t unorm(double v, double most) {
    return (uint32_t)llrint(fmin(fmax(v, 0), 1) * most);
}

static bool is_srgb(VkFormat format) {
    return format == VK_FORMAT_R8G8B8A8_SRGB || format == VK_FORMAT_B8G8R8A8_SRGB;
}

/* Where in the texel channel c lies. */
static int place(VkFormat format, int c) {
    const bool swapped = format == VK_FORMAT_B8G8R8A8_UNORM || format == VK_FORMAT_B8G8R8A8_SRGB;
    return swapped && c < 3 ? 2 - c : c;
}

static uint32_t encode_shared(const float rgba[4]) {
    const double most = fmax(fmax(rgba[0], rgba[1]), fmax(rgba[2], 0x1p-20));
    int exponent = (int)fmax(floor(log2(most)), -16) + 16;
    if (llrint(most / exp2(exponent - 24)) == 512) exponent++;
    uint32_t bits = (uint32_t)exponent << 27;
    for (int c = 0; c < 3; c++)
        bits |= (uint32_t)llrint(rgba[c] / exp2(exponent - 24)) << 9 * c;
    return bits;
}

void texel_encode(VkFormat format, const float rgba[4], void *texel) {
    uint16_t half[4];
    uint32_t bits = 0;
    unsigned char bytes[4];
    for (int c = 0; c < 4; c++) {
        half[c] = half_nearest(rgba[c]);
        bytes[place(format, c)] = (unsigned char)unorm(is_srgb(format) && c < 3 ? to_srgb(rgba[c]) : rgba[c], 255);
    }
    const void *from = &bits;
    if (format == VK_FORMAT_R32G32B32A32_SFLOAT || format == VK_FORMAT_D32_SFLOAT ||
        format == VK_FORMAT_D32_SFLOAT_S8_UINT || format == VK_FORMAT_R32_SFLOAT)
        from = rgba;
    else if (format == VK_FORMAT_R16G16B16A16_SFLOAT || format == VK_FORMAT_R16_SFLOAT)
        from = half;
    else if (format == VK_FORMAT_B10G11R11_UFLOAT_PACK32) /* a half without sign and last bits */
        bits = (uint32_t)half[0] >> 4 | (uint32_t)half[1] >> 4 << 11 | (uint32_t)half[2] >> 5 << 22;
    else if (format == VK_FORMAT_E5B9G9R9_UFLOAT_PACK32)
        bits = encode_shared(rgba);
    else if (format == VK_FORMAT_A2B10G10R10_UNORM_PACK32)
        bits = unorm(rgba[0], 1023) | unorm(rgba[1], 1023) << 10 | unorm(rgba[2], 1023) << 20 | unorm(rgba[3], 3) << 30;
    else if (format == VK_FORMAT_D16_UNORM) {
        half[0] = (uint16_t)unorm(rgba[0], 65535);
        from = half;
    } else if (format == VK_FORMAT_X8_D24_UNORM_PACK32 || format == VK_FORMAT_D24_UNORM_S8_UINT)
        bits = unorm(rgba[0], 16777215);
    else
        from = bytes;
    memcpy(texel, from, texel_bytes(format));
}

void texel_decode(VkFormat format, const void *texel, float rgba[4]) {
    unsigned char bytes[16] = {0};
    uint16_t half[4];
    uint32_t bits;
    memcpy(bytes, texel, texel_bytes(format));
    memcpy(half, bytes, sizeof half);
    memcpy(&bits, bytes, sizeof bits);
    for (int c = 0; c < 4; c++) {
        const double v = bytes[place(format, c)] / 255.0;
        rgba[c] = (float)(is_srgb(format) && c < 3 ? from_srgb(v) : v);
        if (format == VK_FORMAT_R16G16B16A16_SFLOAT || format == VK_FORMAT_R16_SFLOAT)
            rgba[c] = (float)half_value(half[c]);
        if (format == VK_FORMAT_A2B10G10R10_UNORM_PACK32)
            rgba[c] = (float)((bits >> 10 * c & (c < 3 ? 1023 : 3)) / (c < 3 ? 1023.0 : 3.0));
        if (format == VK_FORMAT_E5B9G9R9_UFLOAT_PACK32)
            rgba[c] = c < 3 ? (float)((bits >> 9 * c & 511) * exp2((int)(bits >> 27) - 24)) : 1;
    }
    if (format == VK_FORMAT_B10G11R11_UFLOAT_PACK32) {
        rgba[0] = (float)half_value((uint16_t)((bits & 2047) << 4));
        rgba[1] = (float)half_value((uint16_t)((bits >> 11 & 2047) << 4));
        rgba[2] = (float)half_value((uint16_t)(bits >> 22 << 5));
        rgba[3] = 1;
    }
    if (format == VK_FORMAT_D16_UNORM) rgba[0] = (float)(half[0] / 65535.0);
    if (format == VK_FORMAT_X8_D24_UNORM_PACK32 || format == VK_FORMAT_D24_UNORM_S8_UINT)
        rgba[0] = (float)((bits & 0xffffff) / 16777215.0);
    if (format == VK_FORMAT_R32G32B32A32_SFLOAT) memcpy(rgba, bytes, 16);
    if (format == VK_FORMAT_D32_SFLOAT || format == VK_FORMAT_D32_SFLOAT_S8_UINT || format == VK_FORMAT_R32_SFLOAT)
        memcpy(rgba, bytes, 4);
}

double texel_step(VkFormat format, double value, int c) {
    const double octave = exp2(floor(log2(fmax(fabs(value), 0x1p-14))));
    if (format == VK_FORMAT_R32G32B32A32_SFLOAT) return 0;
    if (format == VK_FORMAT_R16G16B16A16_SFLOAT) return octave * 0x1p-10;
    if (format == VK_FORMAT_B10G11R11_UFLOAT_PACK32) return octave * (c == 2 ? 0x1p-5 : 0x1p-6);
    if (format == VK_FORMAT_A2B10G10R10_UNORM_PACK32) return c < 3 ? 1 / 1023.0 : 1 / 3.0;
    return 1 / 255.0;
}
