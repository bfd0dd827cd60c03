/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* A camera file. The first byte says how its entry is chosen. */
#include <math.h>
#include <string.h>

#include "camera.h"
#include "fuzz.h"

static void require_number(double number, const char *name) {
    fuzz_require(isfinite(number) && number >= 0, "a length is 0 or above", name);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static const char *const entries[] = {NULL, "thin_lens.0007.exr", "a", "\n"};
    static const char *const inputs[] = {"pinhole.0007.exr", "a", "shots/x.99999999999.exr", "."};
    fuzz_listen();
    if (size < 1 || size > 1 << 16) return 0;
    camera read;
    const char *path = fuzz_file(data + 1, size - 1);
    const int status = camera_read(&read, path, entries[data[0] % 4], inputs[data[0] / 4 % 4]);
    fuzz_require_line(status);
    if (status) return 0;
    require_number(read.focal_length, "focal_length");
    require_number(read.sensor_width, "sensor_width");
    require_number(read.f_number, "f_number");
    require_number(read.focus_distance, "focus_distance");
    require_number(read.unit, "unit");
    fuzz_require(memchr(read.entry, 0, sizeof read.entry) && memchr(read.depth_channel, 0, sizeof read.depth_channel),
                 "names end", NULL);
    return 0;
}
