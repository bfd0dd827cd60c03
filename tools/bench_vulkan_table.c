/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* `ddof bench --table --backend vulkan`: every solver of the backend at the sizes of the published table (Gruen 2011,
 * table 8.1) and at those of 4K and 8K video, beside the copy. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench_vulkan_report.h"
#include "message.h"

static const int sizes[][2] = {{1280, 1024}, {1600, 1200}, {1920, 1200}, {2560, 1600}, {3840, 2160}, {7680, 4320}};

enum { SIZES = sizeof sizes / sizeof *sizes };

typedef struct vulkan_row {
    int width, height;
    ddof_solver asked; /* m.plan.solver: that did it */
    vulkan_measure m;
} vulkan_row;

typedef struct vulkan_table {
    vulkan_bench *b;
    ddof_settings settings; /* of the last size */
    vulkan_row row[SIZES * BENCH_VULKAN_SLOTS];
    int rows;
} vulkan_table;

/* The solvers at one size. */
typedef struct turns {
    const ddof_solver *solver;
    size_t solvers;
    bool wanted[BENCH_VULKAN_SLOTS];
    bench_vulkan_plan plan[BENCH_VULKAN_SLOTS];
    double *copies, *times[BENCH_VULKAN_SLOTS];
    double moved;
} turns;

/* ------------------------------------------------------------------------- measuring */

/* The copy and the solvers take turns, the solvers forwards and backwards, so that whatever else the machine does meets
 * them all alike. */
static const char *take_turns(vulkan_bench *b, turns *t) {
    enum { WARM = 2 };
    const char *bad = NULL;
    for (int run = -WARM; !bad && run < b->runs; run++) {
        double ms;
        bad = bench_vulkan_copy(b->vk, &ms);
        if (!bad && run >= 0) t->copies[run] = ms;
        for (size_t turn = 0; !bad && turn < t->solvers; turn++) {
            const size_t i = run & 1 ? t->solvers - 1 - turn : turn;
            if (!t->wanted[i]) continue;
            bad = bench_vulkan_solve(b->vk, (int)i, &ms);
            if (!bad && run >= 0) t->times[i][run] = ms;
        }
    }
    return bad;
}

/* A size or a solver that the device cannot do is left out with a note. */
static void prepare(vulkan_table *table, turns *t, const scene *s) {
    for (size_t i = 0; i < t->solvers; i++) {
        ddof_settings settings = s->settings;
        settings.solver = t->solver[i];
        const char *bad = bench_vulkan_prepare(table->b->vk, (int)i, &settings, &t->plan[i]);
        t->wanted[i] = !bad;
        if (bad)
            note("note: no row of %s at %dx%d: %s", solver_name(DDOF_BACKEND_VULKAN, t->solver[i]), s->width, s->height,
                 bad);
    }
}

static void add_rows(vulkan_table *table, turns *t, const scene *s) {
    const spread copy = spread_of(t->copies, table->b->runs);
    for (size_t i = 0; i < t->solvers; i++)
        if (t->wanted[i])
            table->row[table->rows++] = (vulkan_row){.width = s->width,
                                                     .height = s->height,
                                                     .asked = t->solver[i],
                                                     .m = {.solve = spread_of(t->times[i], table->b->runs),
                                                           .copy = copy,
                                                           .pixels = (double)s->width * s->height,
                                                           .moved = t->moved,
                                                           .plan = t->plan[i]}};
}

static int measure_size(vulkan_table *table, int width, int height) {
    vulkan_bench *b = table->b;
    turns t = {0};
    scene s;
    const size_t bytes = (size_t)b->runs * sizeof(double);
    t.solver = backend_solvers(DDOF_BACKEND_VULKAN, &t.solvers);
    int status = scene_create(&s, b->o, width, height);
    table->settings = s.settings;
    t.copies = malloc(bytes);
    bool room = t.copies != NULL;
    for (size_t i = 0; i < t.solvers; i++)
        room = (t.times[i] = malloc(bytes)) != NULL && room;
    if (status == 0 && !room) status = fail("--runs: out of memory; make it smaller");
    if (status == 0) {
        const char *bad = bench_vulkan_picture(b->vk, &s, s.settings.surface, &t.moved);
        if (!bad) prepare(table, &t, &s);
        if (!bad) bad = take_turns(b, &t);
        if (bad)
            note("note: no rows at %dx%d: %s", width, height, bad);
        else
            add_rows(table, &t, &s);
    }
    for (size_t i = 0; i < t.solvers; i++)
        free(t.times[i]);
    free(t.copies);
    scene_destroy(&s);
    return status;
}

static int measure_all(vulkan_table *table) {
    const option_value *size = &table->b->o->value[OPT_SIZE];
    if (size->given) return measure_size(table, (int)size->number, (int)size->number_y);
    int status = 0;
    for (int i = 0; status == 0 && i < SIZES; i++) {
        if (!option_given(table->b->o, OPT_QUIET)) progress_show((double)i / SIZES);
        status = measure_size(table, sizes[i][0], sizes[i][1]);
    }
    progress_clear();
    return status;
}

/* ------------------------------------------------------------------------- printing */

static const char *asked_name(const vulkan_row *row) {
    return solver_name(DDOF_BACKEND_VULKAN, row->asked);
}

static const char *done_name(const vulkan_row *row) {
    return solver_name(DDOF_BACKEND_VULKAN, row->m.plan.solver);
}

static int print_markdown(const vulkan_table *t) {
    bench_vulkan_print_where(t->b);
    printf("\nmedians of %d run%s, copy and solvers taking turns; %s; copy: as many bytes as a solve must move\n\n",
           t->b->runs, t->b->runs == 1 ? "" : "s", surface_name(t->settings.surface));
    printf("| Size | Solver | ms | quartiles | least | copy ms | of copy | scratch bytes/pixel | how |\n"
           "|---|---|---:|---:|---:|---:|---:|---:|---|\n");
    for (int i = 0; i < t->rows; i++) {
        const vulkan_row *row = &t->row[i];
        const vulkan_measure *m = &row->m;
        char plan[256];
        bench_vulkan_plan_text(&m->plan, plan, sizeof plan);
        printf("| %dx%d | `%s` | %.3f | %.3f to %.3f | %.3f | %.3f | %.2f | %.1f | %s |\n", row->width, row->height,
               asked_name(row), m->solve.median, m->solve.quarter, m->solve.three_quarters, m->solve.least,
               m->copy.median, m->solve.median / m->copy.median, (double)m->plan.scratch_bytes / m->pixels, plan);
    }
    return finish_output();
}

static int print_csv(const vulkan_table *t) {
    char device[sizeof t->b->device.name];
    memcpy(device, t->b->device.name, sizeof device);
    for (char *c = device; *c; c++)
        if (*c == '"') *c = '\'';
    printf("width,height,solver,done_by,device,is_software,surface,runs,median_ms,q1_ms,q3_ms,min_ms,max_ms,copy_ms,"
           "copy_ratio,moved_bytes,scratch_bytes,scratch_bytes_per_pixel,dispatches,pixels_per_thread,workgroup,strip,"
           "subgroup\n");
    for (int i = 0; i < t->rows; i++) {
        const vulkan_row *row = &t->row[i];
        const vulkan_measure *m = &row->m;
        printf("%d,%d,%s,%s,\"%s\",%d,%s,%d", row->width, row->height, asked_name(row), done_name(row), device,
               t->b->device.is_software, surface_name(t->settings.surface), t->b->runs);
        printf(",%.4f,%.4f,%.4f,%.4f,%.4f,%.4f,%.4f", m->solve.median, m->solve.quarter, m->solve.three_quarters,
               m->solve.least, m->solve.most, m->copy.median, m->solve.median / m->copy.median);
        printf(",%.0f,%zu,%.4f", m->moved, m->plan.scratch_bytes, (double)m->plan.scratch_bytes / m->pixels);
        printf(",%d,%d,%d,%d,%d\n", m->plan.dispatches, m->plan.pixels_per_thread, m->plan.workgroup, m->plan.strip,
               m->plan.subgroup);
    }
    return finish_output();
}

static int print_json(const vulkan_table *t) {
    cJSON *object = cJSON_CreateObject(), *rows = cJSON_CreateArray();
    bench_vulkan_add_where(t->b, object);
    json_text(object, "surface", surface_name(t->settings.surface));
    for (int i = 0; i < t->rows; i++) {
        cJSON *row = cJSON_CreateObject();
        json_integer(row, "width", t->row[i].width);
        json_integer(row, "height", t->row[i].height);
        json_text(row, "solver", asked_name(&t->row[i]));
        bench_vulkan_add_measure(&t->row[i].m, row);
        cJSON_AddItemToArray(rows, row);
    }
    cJSON_AddItemToObject(object, "rows", rows);
    return json_finish(object);
}

int bench_vulkan_table(vulkan_bench *b) {
    enum { MARKDOWN, CSV, JSON }; /* the words of --format */
    vulkan_table t = {.b = b};
    int status = measure_all(&t);
    if (status) return status;
    if (t.rows == 0) return fail("--backend vulkan: no solver could do any of the sizes; try --size 640x480");
    if (option_given(b->o, OPT_JSON)) return print_json(&t);
    const int format = (int)option_number(b->o, OPT_FORMAT, MARKDOWN);
    if (option_given(b->o, OPT_QUIET) && !option_given(b->o, OPT_FORMAT)) return 0;
    return format == JSON ? print_json(&t) : format == CSV ? print_csv(&t) : print_markdown(&t);
}
