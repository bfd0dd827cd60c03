/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* ddof solvers: the family of ddof/tridiag.h, with what each costs for a picture: its rows, then its columns. */
#include <ddof/tridiag.h>
#include <stdio.h>
#include <stdlib.h>

#include "commands.h"
#include "json.h"
#include "message.h"

enum { CHANNELS = 3 };

/* Bytes of a texel of the surfaces that the published figures are for. */
enum { RGBA32F = 16, RGBA16F = 8, RGBA32UI = 16, R32F = 4 };

typedef struct report {
    const ddof_tridiag_info *info;
    ddof_tridiag batch[2]; /* a row, a column */
    ddof_tridiag_cost cost[2];
    int passes;
    double operations_per_pixel; /* of the whole solve, three channels */
    double bytes_per_pixel;
    double surface_bytes;
} report;

/* Surfaces of all lines of one direction, by what a line stores. The vanilla solver has rgba32f for all of them. */
static double surface_bytes(const report *r, int direction, double lines) {
    const ddof_tridiag_cost *c = &r->cost[direction];
    const int color = r->batch[0].solver == DDOF_TRIDIAG_CR_VANILLA ? RGBA32F : RGBA16F;
    return lines * (RGBA32F * (double)c->rows + color * (double)(c->x_rows + c->y_rows) +
                    RGBA32UI * (double)c->records + RGBA16F * (double)c->half_rows + R32F * (double)c->numbers);
}

/* Where all surfaces have the size of the picture, the columns use those of the rows. */
static bool serve_both(ddof_tridiag_solver solver) {
    return solver == DDOF_TRIDIAG_THOMAS || solver == DDOF_TRIDIAG_PCR || solver == DDOF_TRIDIAG_PCR3_SWEEP;
}

static double operations(const ddof_tridiag_cost *c) {
    return (double)c->adds + (double)c->muls + (double)c->divisions;
}

static report report_of(ddof_tridiag_solver solver, size_t width, size_t height) {
    report r = {.info = ddof_tridiag_about(solver)};
    const size_t n[2] = {width, height};
    const double lines[2] = {(double)height, (double)width}, pixels = (double)width * (double)height;
    const int color = solver == DDOF_TRIDIAG_CR_VANILLA ? RGBA32F : RGBA16F;
    r.surface_bytes = color * pixels; /* the picture between rows and columns */
    for (int d = 0; d < 2; d++) {
        r.batch[d] = (ddof_tridiag){.solver = solver, .count = 1, .n = n[d], .nrhs = CHANNELS};
        ddof_tridiag_cost_of(&r.batch[d], sizeof(float), &r.cost[d]);
        r.passes += r.cost[d].steps;
        r.operations_per_pixel += operations(&r.cost[d]) * lines[d] / pixels;
        if (d == 0 || !serve_both(solver)) r.surface_bytes += surface_bytes(&r, d, lines[d]);
    }
    r.bytes_per_pixel = r.surface_bytes / pixels;
    return r;
}

/* The unknowns of each step of a line, to be freed; NULL when there is no memory. */
static size_t *unknowns_of(const ddof_tridiag *batch, size_t *count) {
    *count = ddof_tridiag_steps(batch, NULL, 0);
    size_t *unknowns = malloc(*count * sizeof *unknowns);
    if (unknowns) ddof_tridiag_steps(batch, unknowns, *count);
    return unknowns;
}

/* How many steps from `i` on have as many unknowns as it. */
static size_t run_length(const size_t *unknowns, size_t count, size_t i) {
    size_t same = 1;
    while (i + same < count && unknowns[i + same] == unknowns[i])
        same++;
    return same;
}

/* ------------------------------------------------------------------------- for people */

/* "1600 x3, 8 x399": what repeats is counted. */
static int print_unknowns(const report *r, int direction) {
    size_t count;
    size_t *unknowns = unknowns_of(&r->batch[direction], &count);
    if (!unknowns) return fail("--size: out of memory; make it smaller");
    printf("  %-11s %-7s", direction == 0 ? r->info->name : "", direction == 0 ? "rows" : "columns");
    for (size_t i = 0, same; i < count; i += same) {
        same = run_length(unknowns, count, i);
        printf("%s %zu", i > 0 ? "," : "", unknowns[i]);
        if (same > 1) printf(" x%zu", same);
    }
    putchar('\n');
    free(unknowns);
    return 0;
}

static int print_human(const report *all, size_t width, size_t height) {
    printf("%zux%zu, rows then columns, three channels\n\n", width, height);
    printf("solver       passes  operations/px  bytes/px     MiB\n");
    for (int i = 0; i < DDOF_TRIDIAG_SOLVERS; i++)
        printf("%-11s %7d %14.1f %9.1f %7.1f\n", all[i].info->name, all[i].passes, all[i].operations_per_pixel,
               all[i].bytes_per_pixel, all[i].surface_bytes / 1048576);
    printf("\nunknowns of each step:\n");
    for (int i = 0; i < DDOF_TRIDIAG_SOLVERS; i++)
        for (int d = 0; d < 2; d++) {
            const int status = print_unknowns(&all[i], d);
            if (status) return status;
        }
    printf("\nwhat they are:\n");
    for (int i = 0; i < DDOF_TRIDIAG_SOLVERS; i++)
        printf("  %-11s %s (%s)\n", all[i].info->name, all[i].info->title, all[i].info->source);
    printf("\nBytes are those of the sources' surfaces: coefficients rgba32f, colour rgba16f (cr-vanilla: rgba32f),\n"
           "packed rgba32ui, a chain for each direction and the picture between them. docs/solvers.md says more.\n");
    return finish_output();
}

/* ------------------------------------------------------------------------- for programs */

static cJSON *direction_object(const report *r, int direction) {
    const ddof_tridiag_cost *c = &r->cost[direction];
    cJSON *object = cJSON_CreateObject(), *list = cJSON_CreateArray();
    json_integer(object, "n", (double)r->batch[direction].n);
    json_integer(object, "steps", c->steps);
    json_integer(object, "adds", (double)c->adds);
    json_integer(object, "muls", (double)c->muls);
    json_integer(object, "divisions", (double)c->divisions);
    json_integer(object, "diagonal_adds", (double)c->diagonal_adds);
    json_integer(object, "rows", (double)c->rows);
    json_integer(object, "x_rows", (double)c->x_rows);
    json_integer(object, "y_rows", (double)c->y_rows);
    json_integer(object, "records", (double)c->records);
    json_integer(object, "half_rows", (double)c->half_rows);
    json_integer(object, "numbers", (double)c->numbers);
    json_integer(object, "bytes", (double)c->bytes);
    size_t count;
    size_t *unknowns = unknowns_of(&r->batch[direction], &count);
    for (size_t i = 0, same; unknowns && i < count; i += same) {
        same = run_length(unknowns, count, i);
        const double pair[2] = {(double)unknowns[i], (double)same};
        cJSON_AddItemToArray(list, cJSON_CreateDoubleArray(pair, 2));
    }
    free(unknowns);
    cJSON_AddItemToObject(object, "unknowns", list);
    return object;
}

static int print_json(const report *all, size_t width, size_t height) {
    cJSON *object = cJSON_CreateObject(), *list = cJSON_CreateArray();
    json_integer(object, "width", (double)width);
    json_integer(object, "height", (double)height);
    json_integer(object, "channels", CHANNELS);
    for (int i = 0; i < DDOF_TRIDIAG_SOLVERS; i++) {
        cJSON *solver = cJSON_CreateObject();
        json_text(solver, "name", all[i].info->name);
        json_text(solver, "title", all[i].info->title);
        json_text(solver, "source", all[i].info->source);
        json_integer(solver, "passes", all[i].passes);
        json_number(solver, "operations_per_pixel", all[i].operations_per_pixel);
        json_number(solver, "bytes_per_pixel", all[i].bytes_per_pixel);
        json_integer(solver, "surface_bytes", all[i].surface_bytes);
        cJSON_AddItemToObject(solver, "row", direction_object(&all[i], 0));
        cJSON_AddItemToObject(solver, "column", direction_object(&all[i], 1));
        cJSON_AddItemToArray(list, solver);
    }
    cJSON_AddItemToObject(object, "solvers", list);
    return json_finish(object);
}

int command_solvers(const options *o) {
    const option_value *size = &o->value[OPT_SIZE];
    const size_t width = size->given ? (size_t)size->number : 1600,
                 height = size->given ? (size_t)size->number_y : 1200;
    report all[DDOF_TRIDIAG_SOLVERS];
    for (int i = 0; i < DDOF_TRIDIAG_SOLVERS; i++)
        all[i] = report_of((ddof_tridiag_solver)i, width, height);
    if (option_given(o, OPT_JSON)) return print_json(all, width, height);
    return option_given(o, OPT_QUIET) ? 0 : print_human(all, width, height);
}
