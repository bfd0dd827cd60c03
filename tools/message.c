/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "message.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

enum { PROGRESS_WIDTH = 78 };

static bool quiet_notes;
static bool progress_visible;
static _Thread_local message_log *kept;

void message_keep(message_log *log) {
    kept = log;
}

/* Where this thread keeps such a line; NULL: nowhere, or there is no room. */
static char *kept_place(bool error) {
    if (error) return *kept->error ? NULL : kept->error;
    return kept->notes < MOST_NOTES ? kept->note[kept->notes++] : NULL;
}

/* Names come from files that may be hostile: no control character of theirs reaches the terminal or breaks the line. */
static void print_line(bool error, const char *format, va_list list) {
    char text[2048];
    int length = vsnprintf(text, sizeof text, format, list);
    if (length < 0) text[0] = 0;
    for (char *c = text; *c; c++)
        if ((unsigned char)*c < 0x20 || *c == 0x7f) *c = '?';
    if (kept) {
        char *place = kept_place(error);
        if (place) snprintf(place, MESSAGE_SIZE, "%.*s", MESSAGE_SIZE - 1, text);
        return;
    }
    progress_clear();
    fprintf(stderr, "ddof: %s\n", text);
}

int fail(const char *format, ...) {
    va_list list;
    va_start(list, format);
    print_line(true, format, list);
    va_end(list);
    return EXIT_WORK;
}

int fail_usage(const char *format, ...) {
    va_list list;
    va_start(list, format);
    print_line(true, format, list);
    va_end(list);
    return EXIT_USAGE;
}

void note(const char *format, ...) {
    if (quiet_notes) return;
    va_list list;
    va_start(list, format);
    print_line(false, format, list);
    va_end(list);
}

void message_quiet(bool quiet) {
    quiet_notes = quiet;
}

void progress_text(const char *text) {
    static int terminal = -1;
    if (terminal < 0) terminal = isatty(STDERR_FILENO);
    if (quiet_notes || !terminal) return;
    fprintf(stderr, "\r%-*.*s", PROGRESS_WIDTH, PROGRESS_WIDTH, text);
    fflush(stderr);
    progress_visible = true;
}

void progress_show(double done) {
    char text[32];
    snprintf(text, sizeof text, "ddof: %3d %%", (int)(done * 100));
    progress_text(text);
}

void progress_clear(void) {
    if (kept) return; /* the line belongs to who tells of all frames */
    if (progress_visible) fprintf(stderr, "\r%*s\r", PROGRESS_WIDTH, "");
    progress_visible = false;
}

int finish_output(void) {
    errno = 0;
    if (fflush(stdout) == 0 && !ferror(stdout)) return 0;
    return fail("standard output: %s; the result could not be printed", errno ? strerror(errno) : "write error");
}

double now_ms(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec * 1e3 + (double)now.tv_nsec * 1e-6;
}

size_t peak_rss_bytes(void) {
    struct rusage usage;
    if (getrusage(RUSAGE_SELF, &usage) != 0) return 0;
#ifdef __APPLE__
    return (size_t)usage.ru_maxrss; /* bytes there, kibibytes elsewhere */
#else
    return (size_t)usage.ru_maxrss * 1024;
#endif
}
