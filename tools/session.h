/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The library's context as the commands use it: options applied, progress shown, SIGINT and SIGTERM stop the work. */
#ifndef TOOLS_SESSION_H
#define TOOLS_SESSION_H

#include <ddof/ddof.h>
#include <stdbool.h>

#include "options.h"

typedef struct session {
    ddof_context *context;
    bool progress;       /* show it */
    const char *backend; /* the name asked for */
    char error[512];     /* the library's last: ddof_error() has none when there is no context */
    char warning[512];   /* the library's last, held back until it is clear that the work succeeded */
} session;

/* Returns 0 or an exit code. */
int session_open(session *s, const options *o);
void session_close(session *s);

/* Says what the library's last call found wrong; `about` is the file or option to name. Returns an exit code. */
int session_fail(const session *s, ddof_status status, const char *about);

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

/* The mask of --cpu, checked against this machine; 0: all. Returns 0 or an exit code. */
int cpu_mask_of_options(const options *o, unsigned *mask);

#endif
