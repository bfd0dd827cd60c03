/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* phone_fixture KIND FILE [said|float]: a picture of 96 x 64 with depth. KIND: heic, avif (depth of half the size; "said":
 * disparity, 8 m to 0.5 m), jxl (8 bits, "float": of floats). Exit code 77: no such encoder here. */
#include <stdio.h>
#include <string.h>

#include "make_phone.h"

int main(int argc, char **argv) {
    unsigned char message[64];
    phone_spec spec = {.width = 96, .height = 64, .depth_width = 96, .depth_height = 64, .bits = 8, .depth_bits = 8};
    if (argc < 3) return 2;
    const char *more = argc > 3 ? argv[3] : "";
    if (strcmp(more, "said") == 0) {
        spec.sei = message;
        spec.sei_size = depth_message(message, 0, (const double[]){0.5, 8, 0, 0});
    }
    if (strcmp(more, "float") == 0) {
        spec.bits = spec.depth_bits = 0;
        spec.linear = true;
    }
    spec.av1 = strcmp(argv[1], "avif") == 0;
    int made;
    if (strcmp(argv[1], "jxl") == 0) {
        made = make_jxl(argv[2], &spec);
    } else {
        spec.depth_width /= 2;
        spec.depth_height /= 2;
        made = make_heif(argv[2], &spec);
    }
    return made > 0 ? 0 : made == 0 ? 77 : 1;
}
