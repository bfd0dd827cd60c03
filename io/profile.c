/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* What files say of their colour, in the numbers of ITU-T H.273 (cICP of PNG, nclx of HEIF) or as an ICC profile. Curves
 * that are known are decoded; primaries stay what they are. */
#include <string.h>

#include "coding.h"

int io_curve_of_transfer(io_coding *coding, int transfer, const char *path, io_error *error) {
    enum { SYSTEM_M = 4, SYSTEM_BG = 5, LINEAR = 8, PQ = 16, HLG = 18 };
    coding->curve = IO_CURVE_SRGB;
    if (transfer == PQ || transfer == HLG)
        return io_fail(error, "%s: its colour is HDR video (%s), which is not decoded here; convert it to a linear EXR",
                       path, transfer == PQ ? "PQ" : "HLG");
    if (transfer == LINEAR) coding->curve = IO_CURVE_LINEAR;
    if (transfer == SYSTEM_M || transfer == SYSTEM_BG) {
        coding->curve = IO_CURVE_POWER;
        coding->power = transfer == SYSTEM_M ? 1 / 2.2 : 1 / 2.8;
    }
    return 0;
}

void io_note_primaries(io_picture *picture, int primaries) {
    enum { BT_709 = 1, UNSPECIFIED = 2, BT_2020 = 9, DCI_P3 = 11, DISPLAY_P3 = 12 };
    if (primaries == BT_709 || primaries == UNSPECIFIED) return;
    const char *name = primaries == BT_2020      ? "BT.2020"
                       : primaries == DCI_P3     ? "DCI P3"
                       : primaries == DISPLAY_P3 ? "Display P3"
                                                 : "neither sRGB nor a known wider gamut";
    io_note(&picture->note, picture->path, "its primaries (%s) are kept as they are", name);
}

/* The name "sRGB" stands in the profile's description, in ASCII or in UTF-16. */
static bool says_srgb(const unsigned char *profile, size_t size) {
    static const char narrow[] = "sRGB", wide[] = "s\0R\0G\0B";
    for (size_t i = 0; i + 4 <= size; i++)
        if (memcmp(profile + i, narrow, 4) == 0 || (i + 7 <= size && memcmp(profile + i, wide, 7) == 0)) return true;
    return false;
}

void io_note_profile(io_picture *picture, const unsigned char *profile, size_t size) {
    if (!says_srgb(profile, size))
        io_note(&picture->note, picture->path,
                "its ICC profile is not applied: the curve is taken to be sRGB's, primaries are kept as they are");
}
