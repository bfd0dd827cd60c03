/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* What the command says, and how it ends. Functions of tools/ that can fail return 0, or one of these codes after
 * having said why on standard error: one line, "ddof: FILE or OPTION: what is wrong; what to do". */
#ifndef TOOLS_MESSAGE_H
#define TOOLS_MESSAGE_H

#include <stdbool.h>
#include <stddef.h>

enum {
    EXIT_WORK = 1,         /* a file could not be read or written, or the work failed */
    EXIT_USAGE = 2,        /* an option is wrong or missing */
    EXIT_INTERRUPTED = 130 /* SIGINT or SIGTERM */
};

int fail(const char *format, ...) __attribute__((format(printf, 1, 2)));       /* returns EXIT_WORK */
int fail_usage(const char *format, ...) __attribute__((format(printf, 1, 2))); /* returns EXIT_USAGE */

/* A line on standard error that is no error; silent after message_quiet(true). */
void note(const char *format, ...) __attribute__((format(printf, 1, 2)));
void message_quiet(bool quiet);

/* What a thread has said, kept instead of printed: for frames that are worked on side by side. */
enum { MOST_NOTES = 8, MESSAGE_SIZE = 1024 };
typedef struct message_log {
    char error[MESSAGE_SIZE]; /* the first; "" when there was none */
    char note[MOST_NOTES][MESSAGE_SIZE];
    int notes;
} message_log;
/* From now on this thread's lines go there; NULL: to standard error again. */
void message_keep(message_log *log);

/* Progress in one line that is overwritten; silent unless standard error is a terminal. */
void progress_show(double done);
void progress_text(const char *text);
void progress_clear(void);

/* Flushes standard output and says so when it could not be written: a result that is lost must not look like success.
 */
int finish_output(void);

/* Milliseconds of a clock that only goes forward. */
double now_ms(void);
/* Largest memory the process has held so far. */
size_t peak_rss_bytes(void);

#endif
