/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The file of --animate, applied to some frames: what comes out is what the options allow. */
#include <math.h>

#include "animate.h"
#include "fuzz.h"

static void require_in_range(const options *o, option_id id) {
    const option_spec *spec = &option_table[id];
    const option_value *value = &o->value[id];
    if (!value->given) return;
    fuzz_require(value->number >= spec->low && value->number <= spec->high && !(spec->above && value->number == spec->low),
                 "a number lies in the option's range", spec->name);
    fuzz_require(spec->kind == KIND_NUMBER_OR_INF || isfinite(value->number), "a number is finite", spec->name);
    fuzz_require(value->number_y >= 0 && isfinite(value->number_y), "a place is finite", spec->name);
    fuzz_require(value->text && *value->text, "there is a text", spec->name);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static const int frames[] = {-2000000000, -1, 0, 1, 17, 1000, 1020, 999999999};
    static const option_id ids[] = {OPT_FOCUS, OPT_FOCUS_AT, OPT_FOCUS_RANGE, OPT_FSTOP, OPT_FOCAL_LENGTH};
    animation *read = NULL;
    fuzz_listen();
    if (size > 1 << 16) return 0;
    const int status = animation_read(&read, fuzz_file(data, size));
    fuzz_require_line(status);
    fuzz_require(!read == (status != 0), "there is an animation unless it failed", NULL);
    for (size_t i = 0; read && i < sizeof frames / sizeof *frames; i++) {
        frame_options f = {.count = 0};
        fuzz_require(animation_apply(read, &f, frames[i]) == 0, "it can be applied", NULL);
        for (size_t k = 0; k < sizeof ids / sizeof *ids; k++) {
            require_in_range(&f.o, ids[k]);
            fuzz_require(f.o.value[ids[k]].given == animation_has(read, ids[k]), "what has keys is set", NULL);
        }
        frame_options_free(&f);
    }
    animation_free(read);
    return 0;
}
