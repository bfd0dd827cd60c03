/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The commands. Each returns the exit code of the process. */
#ifndef TOOLS_COMMANDS_H
#define TOOLS_COMMANDS_H

#include "options.h"

/* `start`: when the process began, in the time of now_ms(). */
int command_render(const options *o, double start);
int command_coc(const options *o, double start);
int command_info(const options *o);
int command_compare(const options *o);
int command_bench(const options *o);
int command_solvers(const options *o);
int command_devices(const options *o);

#endif
