/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "options.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "message.h"

/* ------------------------------------------------------------------------- words */

int word_distance(const char *a, const char *b) {
    enum { LONGEST = 40 };
    size_t m = strlen(a), n = strlen(b);
    if (m > LONGEST || n > LONGEST) return LONGEST;
    int row[LONGEST + 1];
    for (size_t j = 0; j <= n; j++)
        row[j] = (int)j;
    for (size_t i = 1; i <= m; i++) {
        int corner = row[0];
        row[0] = (int)i;
        for (size_t j = 1; j <= n; j++) {
            int change = corner + (a[i - 1] != b[j - 1]);
            corner = row[j];
            int best = row[j] < row[j - 1] ? row[j] + 1 : row[j - 1] + 1;
            row[j] = best < change ? best : change;
        }
    }
    return row[n];
}

/* A word that starts like the right one, or differs in a third of its letters, is worth suggesting. */
static int suggestion_score(const char *typed, const char *right) {
    size_t length = strlen(typed);
    if (length >= 2 && strncmp(typed, right, length) == 0) return 0;
    int distance = word_distance(typed, right);
    return distance <= 1 + (int)length / 3 ? distance : -1;
}

command_id command_by_name(const char *name) {
    int i = 0;
    while (i < COMMAND_COUNT && strcmp(command_table[i].name, name) != 0)
        i++;
    return (command_id)i;
}

const char *command_suggestion(const char *name) {
    const char *best = NULL;
    int best_score = 100;
    for (int i = 0; i < COMMAND_COUNT; i++) {
        int score = suggestion_score(name, command_table[i].name);
        if (score >= 0 && score < best_score) {
            best_score = score;
            best = command_table[i].name;
        }
    }
    return best;
}

/* ------------------------------------------------------------------------- which option */

static int fail_unknown(const char *typed, size_t length, command_id command) {
    char name[64];
    snprintf(name, sizeof name, "%.*s", (int)length, typed);
    const char *best = NULL;
    int best_score = 100;
    for (int i = 0; i < OPT_COUNT; i++) {
        const option_spec *spec = &option_table[i];
        if (!(spec->commands & 1u << command)) {
            if (strcmp(spec->name, name) == 0) {
                int owner = 0;
                while (!(spec->commands & 1u << owner))
                    owner++;
                return fail_usage("--%s: not an option of 'ddof %s' but of 'ddof %s'; see 'ddof %s --help'", name,
                                  command_table[command].name, command_table[owner].name, command_table[command].name);
            }
            continue;
        }
        int score = suggestion_score(name, spec->name);
        if (score >= 0 && score < best_score) {
            best_score = score;
            best = spec->name;
        }
    }
    if (best) return fail_usage("--%s: unknown option; did you mean --%s?", name, best);
    return fail_usage("--%s: unknown option; see 'ddof %s --help'", name, command_table[command].name);
}

static int find_long(const char *name, size_t length, command_id command) {
    for (int i = 0; i < OPT_COUNT; i++) {
        const option_spec *spec = &option_table[i];
        bool allowed = spec->commands & 1u << command;
        if (allowed && strlen(spec->name) == length && strncmp(spec->name, name, length) == 0) return i;
    }
    return -1;
}

static int find_letter(char letter, command_id command) {
    for (int i = 0; i < OPT_COUNT; i++)
        if (option_table[i].letter == letter && option_table[i].commands & 1u << command) return i;
    return -1;
}

/* ------------------------------------------------------------------------- values */

void option_range_text(const option_spec *spec, char *text, size_t size) {
    bool top = isfinite(spec->high) && spec->high < 1e5;
    if (spec->above && !top)
        snprintf(text, size, "above %g", spec->low);
    else if (!top)
        snprintf(text, size, spec->low < -1e5 ? "a number" : "at least %g", spec->low);
    else
        snprintf(text, size, spec->above ? "above %g to %g" : "%g to %g", spec->low, spec->high);
}

bool read_number(const char *text, const char *end, bool allow_inf, double *number) {
    if (!end) end = text + strlen(text);
    char copy[64];
    size_t length = (size_t)(end - text);
    if (length == 0 || length >= sizeof copy || isspace((unsigned char)*text)) return false;
    memcpy(copy, text, length);
    copy[length] = 0;
    if (strpbrk(copy, "xXpP")) return false;
    char *stop;
    *number = strtod(copy, &stop);
    bool word = strpbrk(copy, "nN") != NULL; /* inf, nan */
    return *stop == 0 && !isnan(*number) && (isfinite(*number) || (allow_inf && word));
}

static int fail_value(const option_spec *spec, const char *text, const char *what) {
    return fail_usage("--%s: '%s' is not %s; write it like --%s %s", spec->name, text, what, spec->name, spec->example);
}

static int check_range(const option_spec *spec, double number, const char *text) {
    if (number >= spec->low && number <= spec->high && !(spec->above && number == spec->low)) return 0;
    char range[64];
    option_range_text(spec, range, sizeof range);
    if (number > spec->high) snprintf(range, sizeof range, "at most %.7g", spec->high);
    return fail_usage("--%s: %s is out of range; it must be %s, like --%s %s", spec->name, text, range, spec->name,
                      spec->example);
}

static int read_scalar(const option_spec *spec, const char *text, option_value *value) {
    bool allow_inf = spec->kind == KIND_NUMBER_OR_INF;
    if (!read_number(text, NULL, allow_inf, &value->number))
        return fail_value(spec, text, spec->kind == KIND_INTEGER ? "a whole number" : "a number");
    if (spec->kind == KIND_INTEGER && value->number != floor(value->number))
        return fail_value(spec, text, "a whole number");
    return check_range(spec, value->number, text);
}

/* "512M": digits and at most one letter. */
static int read_bytes(const option_spec *spec, const char *text, option_value *value) {
    static const char letters[] = "KMGT";
    const size_t digits = strspn(text, "0123456789");
    const char *letter = text[digits] ? strchr(letters, toupper((unsigned char)text[digits])) : NULL;
    if (digits == 0 || (text[digits] && (!letter || text[digits + 1])) || !read_number(text, text + digits, false, &value->number))
        return fail_value(spec, text, "a number of bytes, with K, M, G or T after it or nothing");
    if (letter) value->number *= exp2(10 * (double)(letter - letters + 1));
    return check_range(spec, value->number, text);
}

bool read_extent(const char *text, const char *end, double *number, bool *percent) {
    if (!end) end = text + strlen(text);
    *percent = end > text && end[-1] == '%';
    return read_number(text, *percent ? end - 1 : end, false, number);
}

static int read_pair(const option_spec *spec, const char *text, option_value *value) {
    bool size = spec->kind == KIND_SIZE;
    const char *what = size ? "WIDTHxHEIGHT" : "X,Y";
    const char *middle = strchr(text, size ? 'x' : ',');
    if (!middle) return fail_value(spec, text, what);
    if (!read_extent(text, middle, &value->number, &value->percent)) return fail_value(spec, text, what);
    if (!read_extent(middle + 1, NULL, &value->number_y, &value->percent_y)) return fail_value(spec, text, what);
    if (size && (value->percent || value->percent_y || value->number != floor(value->number) ||
                 value->number_y != floor(value->number_y)))
        return fail_value(spec, text, what);
    if ((value->percent && value->number > 100) || (value->percent_y && value->number_y > 100))
        return fail_usage("--%s: %s is out of range; the picture ends at 100%%,100%%", spec->name, text);
    int status = check_range(spec, value->number, text);
    return status ? status : check_range(spec, value->number_y, text);
}

/* The place of a word of given length in "a|b|c", -1 when it is not there. */
static int find_choice(const char *choices, const char *word, size_t length) {
    int index = 0;
    for (const char *c = choices; c; index++) {
        const char *bar = strchr(c, '|');
        size_t n = bar ? (size_t)(bar - c) : strlen(c);
        if (n == length && strncmp(c, word, n) == 0) return index;
        c = bar ? bar + 1 : NULL;
    }
    return -1;
}

static int read_choices(const option_spec *spec, const char *text, option_value *value) {
    bool list = spec->kind == KIND_CPUS;
    unsigned mask = 0;
    const char *word = text;
    for (;;) {
        size_t length = list ? strcspn(word, ",") : strlen(word);
        int index = find_choice(spec->choices, word, length);
        if (index < 0)
            return fail_usage("--%s: '%.*s' is none of %s; write it like --%s %s", spec->name, (int)length, word,
                              spec->choices, spec->name, spec->example);
        mask |= 1u << index;
        value->number = list ? (double)mask : index;
        if (word[length] == 0) return 0;
        word += length + 1;
    }
}

static int read_value(const option_spec *spec, const char *text, option_value *value) {
    value->given = true;
    value->text = text;
    switch (spec->kind) {
    case KIND_FLAG:
        return 0;
    case KIND_TEXT:
        if (*text) return 0;
        return fail_usage("--%s: empty; write it like --%s %s", spec->name, spec->name, spec->example);
    case KIND_EXTENT:
        if (!read_extent(text, NULL, &value->number, &value->percent))
            return fail_value(spec, text, "a number of pixels or percent");
        return check_range(spec, value->number, text);
    case KIND_BYTES:
        return read_bytes(spec, text, value);
    case KIND_POINT:
    case KIND_SIZE:
        return read_pair(spec, text, value);
    case KIND_CHOICE:
    case KIND_CPUS:
        return read_choices(spec, text, value);
    default:
        return read_scalar(spec, text, value);
    }
}

/* ------------------------------------------------------------------------- the whole line */

typedef struct reader {
    options *parsed;
    int count, next;
    char *const *argument;
    int files;
} reader;

/* `attached`: the value written in the same word, NULL when there is none. */
static int read_option(reader *in, int id, const char *attached) {
    const option_spec *spec = &option_table[id];
    option_value value = {0};
    if (spec->kind == KIND_FLAG) {
        if (attached) return fail_usage("--%s: takes no value; write just --%s", spec->name, spec->name);
        value.given = true;
        in->parsed->value[id] = value;
        return 0;
    }
    const char *text = attached;
    if (!text && in->next < in->count) {
        text = in->argument[in->next];
        /* "--focus --quiet" is a value forgotten, not a value called --quiet; --focus=VALUE can still say that */
        if (strncmp(text, "--", 2) == 0) text = NULL;
        in->next += text != NULL;
    }
    if (!text) return fail_usage("--%s: needs a value, like --%s %s", spec->name, spec->name, spec->example);
    int status = read_value(spec, text, &value);
    in->parsed->value[id] = value; /* a later one replaces an earlier one */
    return status;
}

static int read_file_name(reader *in, const char *name) {
    const command_spec *command = &command_table[in->parsed->command];
    if (in->files == command->files)
        return fail_usage("%s: one argument too many%s; usage: ddof %s %s", name,
                          command->writes && command->files == 1 ? " (several frames: one pattern, like shot.####.exr)" : "",
                          command->name, command->arguments);
    if (!*name) return fail_usage("'': an empty file name; usage: ddof %s %s", command->name, command->arguments);
    in->parsed->file[in->files++] = name;
    return 0;
}

static int read_word(reader *in, bool *options_end) {
    command_id command = in->parsed->command;
    const char *word = in->argument[in->next++];
    if (*options_end || word[0] != '-' || word[1] == 0) return read_file_name(in, word);
    if (strcmp(word, "--") == 0) {
        *options_end = true;
        return 0;
    }
    if (word[1] != '-') {
        int id = find_letter(word[1], command);
        if (id < 0)
            return fail_usage("-%c: unknown option; see 'ddof %s --help'", word[1], command_table[command].name);
        return read_option(in, id, word[2] == 0 ? NULL : word + 2 + (word[2] == '='));
    }
    const char *name = word + 2, *equals = strchr(name, '=');
    size_t length = equals ? (size_t)(equals - name) : strlen(name);
    int id = find_long(name, length, command);
    if (id < 0) return fail_unknown(name, length, command);
    return read_option(in, id, equals ? equals + 1 : NULL);
}

int options_parse(options *parsed, command_id command, int count, char *const *argument) {
    *parsed = (options){.command = command, .frame = -1};
    reader in = {parsed, count, 0, argument, 0};
    bool options_end = false;
    while (in.next < count) {
        int status = read_word(&in, &options_end);
        if (status) return status;
        if (option_given(parsed, OPT_HELP)) return 0; /* whatever else is missing */
    }
    const command_spec *spec = &command_table[command];
    if (in.files < spec->files) {
        const char *missing = spec->files == 1 ? "IN" : in.files == 0 ? "A" : "B";
        return fail_usage("%s: the picture's file name is missing; usage: ddof %s %s", missing, spec->name,
                          spec->arguments);
    }
    if (spec->writes && !option_given(parsed, OPT_OUTPUT))
        return fail_usage("--output: missing; say where the result goes, like -o %s", option_table[OPT_OUTPUT].example);
    return 0;
}
