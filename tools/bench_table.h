/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* `ddof bench --table`: every solver at the sizes of the published table (Gruen 2011, table 8.1), time and memory,
 * beside the published figures. */
#ifndef TOOLS_BENCH_TABLE_H
#define TOOLS_BENCH_TABLE_H

#include "bench_report.h"
#include "bench_scene.h"
#include "session.h"

enum { TABLE_SIZES = 4, TABLE_SOLVERS = 9, TABLE_PUBLISHED = 4 };

/* What a row times. */
typedef struct table_solver {
    const char *name;
    ddof_backend backend;
    ddof_solver solver;
    bool shared_chain;
    int published; /* its column in published_size; -1: none */
} table_solver;

/* 0: not published. Of cr, cr+pack, cr4, cr4+pack. */
typedef struct published_size {
    int width, height;
    double hd5870_ms[TABLE_PUBLISHED], gtx480_ms[TABLE_PUBLISHED], mb[TABLE_PUBLISHED];
} published_size;

typedef struct table_row {
    int width, height;
    const table_solver *solver;
    const published_size *published; /* NULL: none for this size */
    spread time;
    size_t bytes; /* of the surfaces on the GPU; of the scratch memory of the CPU's engines */
    double ratio; /* to the time of cr: the median over the rounds; 0: there is no cr */
    char device[128];
} table_row;

typedef struct table {
    const options *o;
    int runs;
    ddof_settings settings; /* of all solvers; .solver and .shared_chain are the rows' */
    table_row row[TABLE_SIZES * TABLE_SOLVERS];
    int rows;
} table;

/* Returns the exit code. */
int bench_table(const options *o);

/* bench_print.c: in the format asked for. Returns 0 or an exit code. */
int table_print(const table *t);

#endif
