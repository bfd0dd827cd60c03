/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The command line: one table (options_table.c) feeds parsing, --help and the checks that man page, docs and completion
 * are complete. Knows nothing of pictures or of the work. */
#ifndef TOOLS_OPTIONS_H
#define TOOLS_OPTIONS_H

#include <stdbool.h>
#include <stdio.h>

typedef enum command_id {
    COMMAND_RENDER,
    COMMAND_COC,
    COMMAND_INFO,
    COMMAND_COMPARE,
    COMMAND_BENCH,
    COMMAND_SOLVERS,
    COMMAND_DEVICES,
    COMMAND_COUNT
} command_id;

typedef enum option_id {
    OPT_OUTPUT,
    OPT_FRAMES,
    OPT_RESUME,
    OPT_KEEP_GOING,
    OPT_IN_FLIGHT,
    OPT_LAYER,
    OPT_RENDER_CHANNELS,
    OPT_VIEWS,
    OPT_DEPTH,
    OPT_DEPTH_KIND,
    OPT_NEAR,
    OPT_FAR,
    OPT_COC,
    OPT_COC_SCALE,
    OPT_CAMERA,
    OPT_RENDER,
    OPT_FOCAL_LENGTH,
    OPT_SENSOR_WIDTH,
    OPT_FSTOP,
    OPT_UNIT,
    OPT_FOCUS,
    OPT_FOCUS_AT,
    OPT_FOCUS_RANGE,
    OPT_AUTOFOCUS,
    OPT_FOCUS_SMOOTH,
    OPT_ANIMATE,
    OPT_METADATA,
    OPT_MAX_COC,
    OPT_MAX_COC_NEAR,
    OPT_MAX_COC_FAR,
    OPT_MASK,
    OPT_COMPARE_COC,
    OPT_PPD,
    OPT_AMPLIFY,
    OPT_INVERT,
    OPT_SIZE,
    OPT_RUNS,
    OPT_TYPE,
    OPT_LAYOUT,
    OPT_CHANNELS,
    OPT_IN_PLACE,
    OPT_BENCH_COC,
    OPT_BENCH_DEPTH,
    OPT_TABLE,
    OPT_FORMAT,
    OPT_REFERENCE,
    OPT_METHOD,
    OPT_KERNEL,
    OPT_QUALITY,
    OPT_CONDUCTANCE,
    OPT_SUBSTEPS,
    OPT_LAYERS,
    OPT_BOKEH,
    OPT_IRIS,
    OPT_BOKEH_THRESHOLD,
    OPT_BOKEH_LIMIT,
    OPT_MAX_SPRITES,
    OPT_MAX_SPRITE_AREA,
    OPT_BOKEH_RESOLUTION,
    OPT_APPEND,
    OPT_QUADS,
    OPT_HOLDOUT,
    OPT_PREVIEW,
    OPT_EXPOSURE,
    OPT_MAX_MEMORY,
    OPT_SCRATCH,
    OPT_THREADS,
    OPT_BACKEND,
    OPT_DEVICE,
    OPT_SOLVER,
    OPT_SURFACE,
    OPT_SHARED_CHAIN,
    OPT_CPU,
    OPT_QUIET,
    OPT_JSON,
    OPT_HELP,
    OPT_COUNT
} option_id;

typedef enum option_kind {
    KIND_FLAG,
    KIND_TEXT,
    KIND_INTEGER,
    KIND_NUMBER,        /* finite */
    KIND_NUMBER_OR_INF, /* or "inf" */
    KIND_BYTES,         /* whole, or with K, M, G or T, powers of 1024 */
    KIND_EXTENT,        /* pixels, or percent of the picture's width */
    KIND_POINT,         /* X,Y, each in pixels or percent */
    KIND_SIZE,          /* WxH */
    KIND_CHOICE,        /* one word of `choices`; the value is its place there */
    KIND_CPUS           /* words of `choices` separated by commas; the value has one bit for each */
} option_kind;

typedef struct option_spec {
    const char *name; /* without the dashes */
    char letter;      /* 0: none */
    option_kind kind;
    const char *argument; /* how the value is called in --help; NULL for flags */
    const char *example;  /* a value that is right, for error messages */
    const char *help;     /* with the default */
    unsigned commands;    /* bit 1 << command_id */
    double low, high;     /* of numbers, both allowed unless `above` */
    bool above;           /* low itself is not allowed */
    const char *choices;  /* "planar|ray", KIND_CHOICE and KIND_CPUS */
} option_spec;

typedef struct command_spec {
    const char *name;
    int files;             /* how many file names it takes */
    bool writes;           /* --output is required */
    const char *arguments; /* for the usage line */
    const char *summary;
    const char *examples; /* whole lines */
} command_spec;

typedef struct option_value {
    bool given;
    bool percent, percent_y;
    double number, number_y; /* integers, choices and CPU masks as well */
    const char *text;        /* as written */
} option_value;

typedef struct options {
    command_id command;
    const char *file[2];
    int frame; /* of a sequence; -1: the command works on one picture */
    option_value value[OPT_COUNT];
} options;

extern const option_spec option_table[OPT_COUNT];
extern const command_spec command_table[COMMAND_COUNT];

/* Reads argv after the command's name. Returns 0, or an exit code after saying what is wrong. */
int options_parse(options *parsed, command_id command, int count, char *const *argument);

/* By name; COMMAND_COUNT when there is none such. */
command_id command_by_name(const char *name);
/* The nearest command, NULL when none is near. */
const char *command_suggestion(const char *name);

void help_general(FILE *stream);
void help_command(FILE *stream, command_id command);
/* "above 0", "0 to 64", or "" when any number will do. */
void option_range_text(const option_spec *spec, char *text, size_t size);

/* Strict: the whole text, no blanks, no NaN, no hexadecimal. `end` of a part of a text, or NULL for all of it. */
bool read_number(const char *text, const char *end, bool allow_inf, double *number);

/* "12", "12.5" or "3%", as strictly. */
bool read_extent(const char *text, const char *end, double *number, bool *percent);

/* Edit distance between two words, for "did you mean". */
int word_distance(const char *a, const char *b);

static inline bool option_given(const options *o, option_id id) {
    return o->value[id].given;
}
static inline double option_number(const options *o, option_id id, double otherwise) {
    return o->value[id].given ? o->value[id].number : otherwise;
}
static inline const char *option_text(const options *o, option_id id) {
    return o->value[id].text;
}

#endif
