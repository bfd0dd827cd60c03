/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Ways to run a parallel loop, for ddof_config.parallel_for; `user` is not looked at. All keep to its contract. */
#ifndef TESTS_LIBRARY_PARALLEL_H
#define TESTS_LIBRARY_PARALLEL_H

#include <ddof/ddof.h>

enum { PARALLEL_THREADS = 4 }; /* what ddof_config.threads must be at least */

int parallel_serial(void *user, int count, ddof_task task, void *task_data); /* one after the other, worker 0 */
int parallel_reversed(void *user, int count, ddof_task task,
                      void *task_data);                                       /* the last one first, changing workers */
int parallel_threads(void *user, int count, ddof_task task, void *task_data); /* 4 new threads, the last index first */
int parallel_refused(void *user, int count, ddof_task task, void *task_data); /* none could be started */

#endif
