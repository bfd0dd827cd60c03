/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* A command line: the first byte says which command, then one argument a line. What is accepted goes on to be checked and
 * to become settings. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "bokeh.h"
#include "fuzz.h"
#include "iris.h"
#include "lens.h"
#include "options.h"
#include "sequence.h"

enum { MOST_WORDS = 64, LARGEST = 4096, PICTURE_WIDTH = 1920 };

static void require_in_range(const options *o) {
    for (int i = 0; i < OPT_COUNT; i++) {
        const option_spec *spec = &option_table[i];
        const option_value *value = &o->value[i];
        if (!value->given || spec->kind < KIND_INTEGER || spec->kind > KIND_SIZE) continue;
        fuzz_require(!isnan(value->number) && value->number >= spec->low && value->number <= spec->high,
                     "a number lies in its option's range", spec->name);
        fuzz_require(spec->kind == KIND_NUMBER_OR_INF || isfinite(value->number), "a number is finite", spec->name);
        fuzz_require(spec->kind != KIND_INTEGER || value->number == floor(value->number), "an integer is whole",
                     spec->name);
    }
}

/* An iris whose image is a file is left to the picture targets. */
static bool wants_file(const char *iris) {
    return iris && strstr(iris, "image");
}

static void make_settings(const options *o) {
    const camera none = {0};
    ddof_settings settings = {0};
    int status = method_check_options(o);
    if (status == 0) status = bokeh_check_options(o);
    if (status == 0 && o->command == COMMAND_RENDER) status = lens_check_options(o);
    if (status == 0) method_settings(&settings, o);
    if (status == 0 && !wants_file(option_text(o, OPT_IRIS))) {
        iris_input iris;
        status = iris_read(&iris, option_text(o, OPT_IRIS), NULL);
        if (status == 0) status = bokeh_settings(&settings, o, &iris, PICTURE_WIDTH);
        iris_close(&iris);
    }
    if (status == 0 && o->command == COMMAND_RENDER && !option_given(o, OPT_COC))
        status = lens_settings(&settings, o, &none, PICTURE_WIDTH);
    fuzz_require_line(status);
}

/* The frames of a pattern, without the folder that it lies in: that is another one on every machine. */
static void expand_frames(const options *o) {
    if (!option_given(o, OPT_FRAMES) || !pattern_has_number(o->file[0])) return;
    sequence frames;
    const int status = sequence_open(&frames, o);
    fuzz_require_line(status);
    if (status) return;
    fuzz_require(frames.count > 0 && frames.frame[0] >= 0, "there are frames", option_text(o, OPT_FRAMES));
    for (int i = 1; i < frames.count; i++)
        fuzz_require(frames.frame[i] > frames.frame[i - 1], "frames go upwards", option_text(o, OPT_FRAMES));
    frame_options one;
    fuzz_require_line(frame_options_make(&one, o, &frames, frames.frame[frames.count - 1]));
    fuzz_require(!option_given(o, OPT_OUTPUT) || strcmp(one.o.value[OPT_OUTPUT].text, option_text(o, OPT_OUTPUT)) != 0,
                 "the output of a frame has its number", option_text(o, OPT_OUTPUT));
    frame_options_free(&one);
    sequence_close(&frames);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    fuzz_listen();
    if (size < 1 || size > LARGEST) return 0;
    char *text = malloc(size), *word[MOST_WORDS];
    fuzz_require(text != NULL, "there is memory for the words", NULL);
    memcpy(text, data + 1, size - 1);
    text[size - 1] = '\0';
    int count = 0;
    for (char *at = text; at && count < MOST_WORDS; count++) {
        word[count] = at;
        at = strchr(at, '\n');
        if (at) *at++ = '\0';
    }
    options parsed;
    const int status = options_parse(&parsed, (command_id)(data[0] % COMMAND_COUNT), count, word);
    fuzz_require_line(status);
    if (status == 0 && !option_given(&parsed, OPT_HELP)) {
        require_in_range(&parsed);
        make_settings(&parsed);
        if (parsed.command == COMMAND_RENDER) expand_frames(&parsed);
    }
    free(text);
    return 0;
}
