/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Which backend does the work, by --backend and the options that belong to the GPU backends. */
#ifndef TOOLS_BACKEND_H
#define TOOLS_BACKEND_H

#include <ddof/ddof.h>
#include <stddef.h>

#include "options.h"

typedef struct backend_choice {
    ddof_backend backend; /* never AUTO */
    const char *because;  /* the option for which "--backend auto" prefers this GPU backend: where it cannot be had, the
                             CPU engine does the work. NULL: no other backend will do */
} backend_choice;

/* Refuses options that the backend does not have. Returns 0 or an exit code. */
int backend_choose(backend_choice *choice, const options *o);

/* Says that the CPU engine stands in for the choice, and why. */
void backend_note_fallback(const backend_choice *choice, const char *why);

/* As --backend, --solver and --surface call them; of the default solver, what it stands for. */
const char *backend_name(ddof_backend backend);
const char *solver_name(ddof_backend backend, ddof_solver solver);
const char *surface_name(ddof_surface surface);

/* The solvers of a backend, its default first; *count is 0 for those of the CPU. */
const ddof_solver *backend_solvers(ddof_backend backend, size_t *count);

#endif
