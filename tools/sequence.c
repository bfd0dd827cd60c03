/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "sequence.h"

#include <ctype.h>
#include <dirent.h>
#include <errno.h>
#include <glob.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "message.h"

enum { MOST_FRAMES = 10000000, WIDEST = 9 /* digits of a number */ };

/* ------------------------------------------------------------------------- names */

const char *base_name(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

long frame_of_name(const char *path) {
    const char *name = base_name(path), *dot = strrchr(name, '.');
    const char *end = dot && dot > name ? dot : name + strlen(name);
    const char *start = end;
    while (start > name && isdigit((unsigned char)start[-1]))
        start--;
    return start < end && end - start <= WIDEST ? strtol(start, NULL, 10) : -1;
}

/* The place of a number at `at`: its length in the pattern and the digits it asks for; 0: there is none. */
static size_t number_place(const char *at, int *digits) {
    if (*at == '#') {
        size_t length = strspn(at, "#");
        *digits = length > WIDEST ? WIDEST : (int)length;
        return length;
    }
    if (*at != '%') return 0;
    const char *c = at + 1;
    *digits = 1;
    if (*c == '0' && c[1] >= '1' && c[1] <= '9') {
        *digits = c[1] - '0';
        c += 2;
    }
    return *c == 'd' ? (size_t)(c + 1 - at) : 0;
}

bool pattern_has_number(const char *text) {
    int digits;
    for (; *text; text++)
        if (number_place(text, &digits)) return true;
    return false;
}

char *pattern_fill(const char *pattern, int frame) {
    char number[16], *filled = malloc(strlen(pattern) * sizeof number + 1), *out = filled;
    if (!filled) return NULL;
    while (*pattern) {
        int digits;
        size_t length = number_place(pattern, &digits);
        if (length)
            out += snprintf(out, sizeof number, "%0*d", digits, frame);
        else
            *out++ = *pattern;
        pattern += length ? length : 1;
    }
    *out = 0;
    return filled;
}

bool file_exists(const char *path) {
    struct stat info;
    return stat(path, &info) == 0;
}

static bool is_pattern(const char *text) {
    return pattern_has_number(text) && !file_exists(text);
}

static bool is_glob(const char *text) {
    return strpbrk(text, "*?[") && !pattern_has_number(text) && !file_exists(text);
}

bool sequence_wanted(const options *o) {
    return option_given(o, OPT_FRAMES) || is_pattern(o->file[0]) || is_glob(o->file[0]);
}

/* ------------------------------------------------------------------------- lists of numbers */

static int add_frame(sequence *s, int *room, int frame) {
    if (s->count == MOST_FRAMES)
        return fail_usage("--frames: more than %d frames; render them in several parts", MOST_FRAMES);
    if (s->count == *room) {
        *room = *room ? 2 * *room : 64;
        int *larger = realloc(s->frame, (size_t)*room * sizeof *larger);
        if (!larger) return fail("%s: out of memory for the list of frames", s->text);
        s->frame = larger;
    }
    s->frame[s->count++] = frame;
    return 0;
}

/* A number at *at, which goes past it; -1: there is none, or it is too large. */
static int read_frame(const char **at) {
    const size_t digits = strspn(*at, "0123456789");
    const int value = digits >= 1 && digits <= WIDEST ? (int)strtol(*at, NULL, 10) : -1;
    *at += digits;
    return value;
}

/* "1001-1240x2,1300": numbers and ranges with a step, ascending. */
static int read_list(sequence *s, const char *text) {
    int room = 0, status = 0;
    for (const char *at = text; status == 0;) {
        int first = read_frame(&at), last = first, step = 1;
        if (first >= 0 && *at == '-') {
            at++;
            last = read_frame(&at);
        }
        if (last >= 0 && *at == 'x') {
            at++;
            step = read_frame(&at);
        }
        if (first < 0 || last < 0 || step < 1 || (*at && *at != ','))
            return fail_usage("--frames: '%s' is not a list of frames; write 1001-1240, 1001-1240x2 or 1001,1005-1010",
                              text);
        if (last < first || (s->count && first <= s->frame[s->count - 1]))
            return fail_usage("--frames: '%s' does not go upwards; write each frame once, the lowest first", text);
        for (int frame = first; status == 0 && frame <= last; frame += step)
            status = add_frame(s, &room, frame);
        if (!*at++) break;
    }
    return status;
}

static int by_number(const void *a, const void *b) {
    const int x = *(const int *)a, y = *(const int *)b;
    return x < y ? -1 : x > y;
}

/* All files in the folder that the pattern makes with some number. */
static int list_pattern(sequence *s) {
    const char *name = base_name(s->text);
    char *folder = strndup(s->text, (size_t)(name - s->text));
    if (!folder) return fail("%s: out of memory", s->text);
    int digits, room = 0, status = 0;
    if (pattern_has_number(folder)) {
        status =
            fail_usage("%s: its folder changes with the frame; say which frames there are with --frames A-B", s->text);
        free(folder);
        return status;
    }
    DIR *open = opendir(*folder ? folder : ".");
    if (!open)
        status = fail("%s: folder '%s': %s; give a pattern in a folder that is there", s->text, *folder ? folder : ".",
                      strerror(errno));
    free(folder);
    size_t before = 0;
    while (!number_place(name + before, &digits))
        before++;
    for (struct dirent *entry; open && status == 0 && (entry = readdir(open));) {
        if (strncmp(entry->d_name, name, before) != 0) continue;
        const char *at = entry->d_name + before;
        int frame = read_frame(&at);
        if (frame < 0) continue;
        char *filled = pattern_fill(name, frame);
        if (!filled) status = fail("%s: out of memory", s->text);
        if (filled && strcmp(filled, entry->d_name) == 0) status = add_frame(s, &room, frame);
        free(filled);
    }
    if (open) closedir(open);
    if (s->count > 1) qsort(s->frame, (size_t)s->count, sizeof *s->frame, by_number);
    return status;
}

typedef struct numbered {
    int frame;
    char *file;
} numbered;

/* The files of a glob in the order of their numbers. */
static int sort_files(sequence *s) {
    numbered *all = malloc((size_t)s->glob_count * sizeof *all);
    if (!all) return fail("%s: out of memory", s->text);
    for (int i = 0; i < s->glob_count; i++)
        all[i] = (numbered){s->glob_frame[i], s->glob[i]};
    qsort(all, (size_t)s->glob_count, sizeof *all, by_number); /* the number comes first */
    int status = 0;
    for (int i = 0; i < s->glob_count; i++) {
        s->glob_frame[i] = all[i].frame;
        s->glob[i] = all[i].file;
        if (status == 0 && i > 0 && all[i].frame == all[i - 1].frame)
            status = fail_usage("%s: %s and %s have the same frame number; write a pattern that fits one of them",
                                s->text, all[i - 1].file, all[i].file);
    }
    free(all);
    return status;
}

static int find_glob(sequence *s) {
    glob_t found = {0};
    int code = glob(s->text, 0, NULL, &found), status = 0;
    if (code != 0 || found.gl_pathc == 0 || found.gl_pathc > MOST_FRAMES)
        status = fail("%s: %s; give a pattern of files that are there", s->text,
                      code == GLOB_NOSPACE ? "out of memory" : "there is no such file");
    s->glob = status ? NULL : calloc(found.gl_pathc, sizeof *s->glob);
    s->glob_frame = status ? NULL : malloc(found.gl_pathc * sizeof *s->glob_frame);
    if (status == 0 && (!s->glob || !s->glob_frame)) status = fail("%s: out of memory", s->text);
    for (size_t i = 0; status == 0 && i < found.gl_pathc; i++) {
        const char *file = found.gl_pathv[i];
        const long frame = frame_of_name(file);
        if (frame < 0)
            status = fail_usage("%s: %s has no frame number before its ending; write a pattern that leaves it out",
                                s->text, file);
        s->glob_frame[s->glob_count] = (int)frame;
        s->glob[s->glob_count++] = strdup(file);
        if (status == 0 && !s->glob[s->glob_count - 1]) status = fail("%s: out of memory", s->text);
    }
    globfree(&found);
    return status ? status : sort_files(s);
}

static int list_glob(sequence *s) {
    int room = 0, status = 0;
    for (int i = 0; status == 0 && i < s->glob_count; i++)
        status = add_frame(s, &room, s->glob_frame[i]);
    return status;
}

static int check_place(const options *o, option_id id) {
    const char *path = option_text(o, id);
    if (!path || pattern_has_number(path)) return 0;
    return fail_usage(
        "--%s: %s: every frame would be written to this one file; give a name with #### in it, like out.####.exr",
        option_table[id].name, path);
}

int sequence_open(sequence *s, const options *o) {
    *s = (sequence){.text = o->file[0]};
    int status = check_place(o, OPT_OUTPUT);
    if (status == 0) status = check_place(o, OPT_PREVIEW);
    const bool pattern = is_pattern(s->text), globbed = is_glob(s->text);
    if (status == 0 && !pattern && !globbed)
        status = fail_usage("--frames: %s is one file; give a pattern for the number, like shot.####.exr", s->text);
    if (status == 0 && globbed) status = find_glob(s);
    if (status == 0)
        status = option_given(o, OPT_FRAMES) ? read_list(s, option_text(o, OPT_FRAMES))
                 : globbed                   ? list_glob(s)
                                             : list_pattern(s);
    if (status == 0 && s->count == 0)
        status = fail("%s: there is no file of this pattern; look at the folder and the number of digits", s->text);
    if (status) sequence_close(s);
    return status;
}

void sequence_close(sequence *s) {
    for (int i = 0; i < s->glob_count; i++)
        free(s->glob[i]);
    free(s->glob);
    free(s->glob_frame);
    free(s->frame);
    *s = (sequence){0};
}

char *sequence_file(const sequence *s, int frame) {
    if (!s->glob) return pattern_fill(s->text, frame);
    for (int low = 0, high = s->glob_count; low < high;) {
        const int middle = low + (high - low) / 2;
        if (s->glob_frame[middle] == frame) return strdup(s->glob[middle]);
        *(s->glob_frame[middle] < frame ? &low : &high) = middle + (s->glob_frame[middle] < frame);
    }
    return NULL;
}

/* ------------------------------------------------------------------------- options of a frame */

/* What may be different files of one shot. */
static const option_id patterned[] = {OPT_OUTPUT, OPT_PREVIEW, OPT_DEPTH, OPT_COC, OPT_HOLDOUT, OPT_CAMERA};

static const char *fill_option(frame_options *f, const char *text, int frame) {
    char *filled = pattern_fill(text, frame);
    if (filled) f->filled[f->count++] = filled;
    return filled;
}

int frame_options_make(frame_options *f, const options *o, const sequence *s, int frame) {
    *f = (frame_options){.o = *o};
    f->o.frame = frame;
    f->filled[f->count] = sequence_file(s, frame);
    f->o.file[0] = f->filled[f->count];
    if (!f->o.file[0]) return fail("%s: there is no file of frame %d", s->text, frame);
    f->count++;
    for (size_t i = 0; i < sizeof patterned / sizeof *patterned; i++) {
        option_value *value = &f->o.value[patterned[i]];
        if (value->given && is_pattern(value->text) && !(value->text = fill_option(f, value->text, frame)))
            return fail("%s: out of memory", f->o.file[0]);
    }
    return 0;
}

int frame_options_set(frame_options *f, option_id id, option_value value) {
    char *text = NULL;
    const char *percent = value.percent ? "%" : "", *percent_y = value.percent_y ? "%" : "";
    const bool point = option_table[id].kind == KIND_POINT;
    const int size = point ? asprintf(&text, "%.17g%s,%.17g%s", value.number, percent, value.number_y, percent_y)
                           : asprintf(&text, "%.17g", value.number);
    if (size < 0) return fail("--%s: out of memory", option_table[id].name);
    f->filled[f->count++] = text;
    value.text = text;
    f->o.value[id] = value;
    return 0;
}

void frame_options_free(frame_options *f) {
    while (f->count > 0)
        free(f->filled[--f->count]);
}
