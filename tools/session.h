/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The library's context as the commands use it: options applied, progress shown, SIGINT and SIGTERM stop the work. */
#ifndef TOOLS_SESSION_H
#define TOOLS_SESSION_H

#include <ddof/ddof.h>
#include <stdbool.h>

#include "json.h"
#include "options.h"

typedef struct session {
    ddof_context *context;
    bool progress;        /* show it */
    ddof_backend backend; /* that does the work: never AUTO */
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

/* As --backend calls it. */
const char *session_backend_name(const session *s);
/* Members for the GL backend: solver, surfaces, bytes; nothing for the others. */
void session_add_gl(const session *s, cJSON *object, const ddof_settings *settings, const ddof_stats *stats,
                    double pixels);

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

/* Of --backend. */
ddof_backend backend_of_options(const options *o);
/* As --solver and --surface call them; of the default, what it stands for. */
const char *solver_name(ddof_solver solver);
const char *surface_name(ddof_surface surface);

#endif
