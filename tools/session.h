/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The library's context as the commands use it: options applied, progress shown, SIGINT and SIGTERM stop the work. */
#ifndef TOOLS_SESSION_H
#define TOOLS_SESSION_H

#include <ddof/ddof.h>
#include <stdbool.h>
#include <stdio.h>

#include "backend.h"
#include "json.h"
#include "options.h"

typedef struct session {
    ddof_context *context;
    bool progress;        /* show it */
    ddof_backend backend; /* that does the work: never AUTO */
    int device;           /* of --device; 0 where there is none */
    char error[512];      /* the library's last: ddof_error() has none when there is no context */
    char warning[512];    /* the library's last, held back until it is clear that the work succeeded */
} session;

/* Returns 0 or an exit code. */
int session_open(session *s, const options *o);
/* The same with a backend of its own instead of --backend. */
int session_open_as(session *s, const options *o, ddof_backend backend);
void session_close(session *s);

/* Says what the library's last call found wrong; `about` is the file or option to name. Returns an exit code. */
int session_fail(const session *s, ddof_status status, const char *about);

/* What the GPU backends add to a report, nothing for the others: solver, surfaces, bytes. As members, as a line. */
void session_add_gpu(const session *s, cJSON *object, const ddof_settings *settings, const ddof_stats *stats,
                     double pixels);
void session_print_gpu(FILE *out, const session *s, const ddof_settings *settings, const ddof_stats *stats, double pixels);

/* Prints the library's warning, if there was one. */
void session_note(session *s, const char *about);

/* SIGINT and SIGTERM. From catch_signals() on they end the process at once, with one line and EXIT_INTERRUPTED: nothing
 * is on disk yet. From signals_hold() on the first one is only remembered, for the solve to be cancelled or a file to
 * be completed; a second one kills. */
void catch_signals(void);
void signals_hold(void);
bool interrupted(void);
/* Says so; returns EXIT_INTERRUPTED. */
int fail_interrupted(void);

/* The words of --cpu in their order, the best of one machine last. */
enum { CPU_SETS = 4 };
typedef struct cpu_set {
    unsigned bit; /* DDOF_CPU_* */
    const char *word;
} cpu_set;
extern const cpu_set cpu_sets[CPU_SETS];

#endif
