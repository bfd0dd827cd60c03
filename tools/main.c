/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include <ddof/ddof.h>
#include <stdio.h>
#include <string.h>

#include "commands.h"
#include "json.h"
#include "message.h"
#include "options.h"
#include "session.h"

static int run(const options *o, double start) {
    switch (o->command) {
    case COMMAND_RENDER:
        return command_render(o, start);
    case COMMAND_COC:
        return command_coc(o, start);
    case COMMAND_INFO:
        return command_info(o);
    case COMMAND_COMPARE:
        return command_compare(o);
    case COMMAND_SOLVERS:
        return command_solvers(o);
    case COMMAND_DEVICES:
        return command_devices(o);
    default:
        return command_bench(o);
    }
}

/* "ddof help", "ddof help render", "ddof --help". */
static int help(int count, char *const *word) {
    if (count > 0) {
        command_id command = command_by_name(word[0]);
        if (command == COMMAND_COUNT)
            return fail_usage("%s: no such command; there are render, coc, info, compare, bench, solvers and devices",
                              word[0]);
        help_command(stdout, command);
    } else {
        help_general(stdout);
    }
    return finish_output();
}

int main(int count, char **word) {
    const double start = now_ms();
    if (count < 2) {
        help_general(stderr);
        return EXIT_USAGE;
    }
    if (strcmp(word[1], "--version") == 0 || strcmp(word[1], "-V") == 0) {
        printf("ddof %s\n", ddof_version());
        return finish_output();
    }
    bool asked = strcmp(word[1], "help") == 0 || strcmp(word[1], "--help") == 0 || strcmp(word[1], "-h") == 0;
    if (asked) return help(count - 2, word + 2);
    command_id command = command_by_name(word[1]);
    if (command == COMMAND_COUNT) {
        const char *near_word = command_suggestion(word[1]);
        if (near_word) return fail_usage("%s: no such command; did you mean 'ddof %s'?", word[1], near_word);
        return fail_usage("%s: no such command; there are render, coc, info, compare, bench, solvers and devices",
                          word[1]);
    }
    options o;
    int status = options_parse(&o, command, count - 2, word + 2);
    if (status) return status;
    if (option_given(&o, OPT_HELP)) {
        help_command(stdout, command);
        return finish_output();
    }
    message_quiet(option_given(&o, OPT_QUIET));
    catch_signals();
    json_watch_memory();
    return run(&o, start);
}
