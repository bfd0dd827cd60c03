/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include <string.h>

#include "options.h"

enum { HELP_COLUMN = 28, HELP_WIDTH = 100 };

void help_general(FILE *stream) {
    fputs("ddof: depth of field for finished pictures\n\nusage:\n", stream);
    for (int i = 0; i < COMMAND_COUNT; i++) {
        const command_spec *spec = &command_table[i];
        int used = fprintf(stream, "  ddof %s %s", spec->name, spec->arguments);
        fprintf(stream, "%*s%s\n", used < HELP_COLUMN ? HELP_COLUMN - used : 1, "", spec->summary);
    }
    fputs("  ddof --version            which version this is\n"
          "\nEvery command has --help with its options and examples.\n"
          "\nexample:\n"
          "  ddof render shot.exr -o out.exr --fstop 2.8 --focal-length 85 --focus 3.2\n"
          "\nexit codes: 0 done, 1 a file or the work failed, 2 wrong usage, 130 interrupted\n",
          stream);
}

/* Breaks a text at blanks so that it stays right of HELP_COLUMN. */
static void print_wrapped(FILE *stream, const char *text) {
    size_t room = HELP_WIDTH - HELP_COLUMN;
    while (strlen(text) > room) {
        size_t cut = room;
        while (cut > 0 && text[cut] != ' ')
            cut--;
        if (cut == 0) break;
        fprintf(stream, "%.*s\n%*s", (int)cut, text, HELP_COLUMN, "");
        text += cut + 1;
    }
    fprintf(stream, "%s\n", text);
}

static void print_option(FILE *stream, const option_spec *spec) {
    int used = 0;
    if (spec->letter)
        used += fprintf(stream, "  -%c, --%s", spec->letter, spec->name);
    else
        used += fprintf(stream, "  --%s", spec->name);
    if (spec->argument) used += fprintf(stream, " %s", spec->argument);
    if (used > HELP_COLUMN - 2) {
        fputc('\n', stream);
        used = 0;
    }
    fprintf(stream, "%*s", HELP_COLUMN - used, "");
    print_wrapped(stream, spec->help);
}

void help_command(FILE *stream, command_id command) {
    const command_spec *spec = &command_table[command];
    fprintf(stream, "ddof %s: %s\n\nusage: ddof %s %s%s[options]\n\noptions:\n", spec->name, spec->summary, spec->name,
            spec->arguments, *spec->arguments ? " " : "");
    for (int i = 0; i < OPT_COUNT; i++)
        if (option_table[i].commands & 1u << command) print_option(stream, &option_table[i]);
    fprintf(stream, "\nexamples:\n%s", spec->examples);
    fputs("\nexit codes: 0 done, 1 a file or the work failed, 2 wrong usage, 130 interrupted\n", stream);
}
