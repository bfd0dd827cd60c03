/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "bench_table.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench_gl.h"
#include "message.h"

static const table_solver solvers[TABLE_SOLVERS] = {
    {"cr", DDOF_BACKEND_GL, DDOF_SOLVER_CR, false, 0},
    {"cr+pack", DDOF_BACKEND_GL, DDOF_SOLVER_CR_PACK, false, 1},
    {"cr4", DDOF_BACKEND_GL, DDOF_SOLVER_CR4, false, 2},
    {"cr4+pack", DDOF_BACKEND_GL, DDOF_SOLVER_CR4_PACK, false, 3},
    {"cr-vanilla", DDOF_BACKEND_GL, DDOF_SOLVER_CR_VANILLA, false, -1},
    {"cr+pcr", DDOF_BACKEND_GL, DDOF_SOLVER_CR_PCR, false, -1},
    {"cr4+pack", DDOF_BACKEND_GL, DDOF_SOLVER_CR4_PACK, true, -1},
    {"cpu", DDOF_BACKEND_CPU, DDOF_SOLVER_DEFAULT, false, -1},
    {"reference", DDOF_BACKEND_REFERENCE, DDOF_SOLVER_DEFAULT, false, -1},
};

enum { CR = 0 }; /* in that list: the row that the others are compared with */

/* Table 8.1 of Gruen 2011 (HD 5870); GTX 480: slides 36 and 41 of Gruen's talk of the same year. */
static const published_size published[TABLE_SIZES] = {
    {1280, 1024, {2.46, 1.97, 1.92, 1.87}, {0}, {90, 70, 50, 40}},
    {1600, 1200, {3.66, 2.93, 2.87, 2.75}, {3.33, 0, 3.32, 3.14}, {132, 102, 73, 58}},
    {1920, 1200, {4.31, 3.43, 3.36, 3.23}, {4.03, 0, 4.02, 3.79}, {158, 122, 88, 70}},
    {2560, 1600, {7.48, 5.97, 5.8, 5.59}, {0}, {281, 219, 156, 125}},
};

/* What is timed at one size. */
typedef struct round_of_solves {
    scene scene;
    bench_gl *gl;
    session *cpu, *reference;
    ddof_settings settings[TABLE_SOLVERS];
    bool wanted[TABLE_SOLVERS];
    double *times[TABLE_SOLVERS];
    size_t bytes[TABLE_SOLVERS];
    char device[TABLE_SOLVERS][128];
} round_of_solves;

/* ------------------------------------------------------------------------- measuring */

static int solve_here(round_of_solves *r, int which, session *s, double *ms) {
    ddof_stats stats;
    const double begin = now_ms();
    const ddof_status done = ddof_render(s->context, &r->scene.frame, &r->settings[which], &stats);
    *ms = now_ms() - begin;
    if (done != DDOF_OK) return session_fail(s, done, "bench");
    r->bytes[which] = stats.scratch_bytes;
    snprintf(r->device[which], sizeof r->device[which], "%s, %d thread%s", stats.device, stats.threads,
             stats.threads == 1 ? "" : "s");
    return 0;
}

static int solve_one(round_of_solves *r, int which, double *ms) {
    if (solvers[which].backend == DDOF_BACKEND_CPU) return solve_here(r, which, r->cpu, ms);
    if (solvers[which].backend == DDOF_BACKEND_REFERENCE) return solve_here(r, which, r->reference, ms);
    ddof_gl_stats stats;
    int status = bench_gl_solve(r->gl, which, &r->settings[which], ms, &stats);
    if (status) return status;
    r->bytes[which] = stats.surface_bytes;
    snprintf(r->device[which], sizeof r->device[which], "%s", stats.device);
    return 0;
}

/* The solvers take turns, forwards and backwards, so that whatever else the machine does meets them all alike. */
static int take_turns(round_of_solves *r, const table *t, double begun, double share) {
    enum { WARM = 2 };
    int status = 0;
    for (int run = -WARM; status == 0 && run < t->runs; run++)
        for (int turn = 0; status == 0 && turn < TABLE_SOLVERS; turn++) {
            const int i = run & 1 ? TABLE_SOLVERS - 1 - turn : turn;
            double ms;
            if (!r->wanted[i]) continue;
            status = solve_one(r, i, &ms);
            if (run >= 0) r->times[i][run] = ms;
            const double part = (double)((run + WARM) * TABLE_SOLVERS + turn) / ((t->runs + WARM) * TABLE_SOLVERS);
            if (!option_given(t->o, OPT_QUIET)) progress_show(begun + share * part);
        }
    progress_clear();
    return status;
}

static const published_size *published_for(int width, int height) {
    for (int i = 0; i < TABLE_SIZES; i++)
        if (published[i].width == width && published[i].height == height) return &published[i];
    return NULL;
}

/* The median of the quotients of each round: what slows the machine for a while slows both. 0: there is no such row. */
static double ratio_to(const round_of_solves *r, int which, int base, int runs, double *quotients) {
    if (!r->wanted[base]) return 0;
    for (int run = 0; run < runs; run++)
        quotients[run] = r->times[which][run] / r->times[base][run];
    return spread_of(quotients, runs).median;
}

static int add_rows(table *t, const round_of_solves *r) {
    double *quotients = malloc((size_t)t->runs * sizeof *quotients), ratio[TABLE_SOLVERS] = {0};
    if (!quotients) return fail("--runs: out of memory; make it smaller");
    for (int i = 0; i < TABLE_SOLVERS; i++) /* before their times are sorted */
        if (r->wanted[i]) ratio[i] = ratio_to(r, i, CR, t->runs, quotients);
    free(quotients);
    for (int i = 0; i < TABLE_SOLVERS; i++) {
        if (!r->wanted[i]) continue;
        table_row *row = &t->row[t->rows++];
        *row = (table_row){.width = r->scene.width,
                           .height = r->scene.height,
                           .solver = &solvers[i],
                           .published = published_for(r->scene.width, r->scene.height),
                           .time = spread_of(r->times[i], t->runs),
                           .ratio = ratio[i],
                           .bytes = r->bytes[i]};
        memcpy(row->device, r->device[i], sizeof row->device);
    }
    return 0;
}

/* ------------------------------------------------------------------------- what is wanted */

static bool backend_is(const options *o, const char *name) {
    const char *given = option_text(o, OPT_BACKEND);
    return strcmp(given ? given : "auto", name) == 0;
}

static int check_options(const options *o) {
    if (backend_is(o, "reference"))
        return fail_usage("--backend: reference alone makes no table; write --table --reference");
    if (backend_is(o, "cpu") && option_given(o, OPT_SURFACE))
        return fail_usage("--surface: belongs to the GPU backends; take --backend gl or --backend vulkan");
    if (option_given(o, OPT_DEVICE)) return fail_usage("--device: belongs to the Vulkan backend; add --backend vulkan");
    return 0;
}

/* Without --backend gl, a machine without GL has a table of the CPU's rows. */
static int open_gl(round_of_solves *r, const table *t) {
    char why[512] = "";
    if (backend_is(t->o, "cpu")) return 0;
    r->gl = bench_gl_create(&r->scene, t->settings.surface, why, sizeof why);
    if (r->gl) return 0;
    if (backend_is(t->o, "gl")) return fail("--backend gl: %s; use --backend cpu", why);
    if (t->rows == 0) note("note: no rows of the GL backend: %s", why);
    return 0;
}

static int prepare(round_of_solves *r, const table *t) {
    int status = open_gl(r, t);
    for (int i = 0; status == 0 && i < TABLE_SOLVERS; i++) {
        const ddof_backend backend = solvers[i].backend;
        r->wanted[i] = backend == DDOF_BACKEND_GL    ? r->gl != NULL
                       : backend == DDOF_BACKEND_CPU ? true
                                                     : r->reference != NULL;
        r->settings[i] = t->settings;
        r->settings[i].lens = r->scene.settings.lens; /* its largest CoC is a fraction of the width */
        r->settings[i].solver = solvers[i].solver;
        r->settings[i].shared_chain = solvers[i].shared_chain;
        r->times[i] = malloc((size_t)t->runs * sizeof(double));
        if (!r->times[i]) status = fail("--runs: out of memory; make it smaller");
    }
    return status;
}

static int measure_size(table *t, session *cpu, session *reference, int width, int height, double begun, double share) {
    round_of_solves r = {.cpu = cpu, .reference = reference};
    int status = scene_create(&r.scene, t->o, width, height);
    t->settings = r.scene.settings;
    if (status == 0) status = prepare(&r, t);
    if (status == 0) status = take_turns(&r, t, begun, share);
    if (status == 0) status = add_rows(t, &r);
    for (int i = 0; i < TABLE_SOLVERS; i++)
        free(r.times[i]);
    bench_gl_destroy(&r.gl);
    scene_destroy(&r.scene);
    return status;
}

static int measure_all(table *t, session *cpu, session *reference) {
    const options *o = t->o;
    if (option_given(o, OPT_SIZE))
        return measure_size(t, cpu, reference, (int)o->value[OPT_SIZE].number, (int)o->value[OPT_SIZE].number_y, 0, 1);
    int status = 0;
    double pixels = 0, done = 0;
    for (int i = 0; i < TABLE_SIZES; i++)
        pixels += (double)published[i].width * published[i].height;
    for (int i = 0; status == 0 && i < TABLE_SIZES; i++) {
        const double share = (double)published[i].width * published[i].height / pixels;
        status = measure_size(t, cpu, reference, published[i].width, published[i].height, done, share);
        done += share;
    }
    return status;
}

int bench_table(const options *o) {
    static table t;
    session cpu = {0}, reference = {0};
    const bool slow = option_given(o, OPT_REFERENCE);
    t = (table){.o = o, .runs = (int)option_number(o, OPT_RUNS, 11)};
    int status = check_options(o);
    if (status == 0) status = session_open_as(&cpu, o, DDOF_BACKEND_CPU);
    if (status == 0 && slow) status = session_open_as(&reference, o, DDOF_BACKEND_REFERENCE);
    cpu.progress = reference.progress = false; /* drawing it would be timed */
    if (status == 0) status = measure_all(&t, &cpu, slow ? &reference : NULL);
    if (status == 0) status = table_print(&t);
    session_close(&cpu);
    session_close(&reference);
    return status;
}
