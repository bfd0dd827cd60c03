/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The table of `ddof bench --table` as Markdown, CSV or JSON. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "bench_table.h"
#include "commit.h"
#include "json.h"
#include "message.h"

static const char gl_timing[] =
    "from ddof_gl_render() to the end of glFinish(), textures to a texture: no upload, no readback";
static const char cpu_timing[] = "ddof_render(), memory to memory";

static double per_pixel(const table_row *row) {
    return (double)row->bytes / ((double)row->width * row->height);
}

static double mebibytes(const table_row *row) {
    return (double)row->bytes / 1048576;
}

/* NaN: not published. */
static double published_value(const table_row *row, const double values[TABLE_PUBLISHED]) {
    const int column = row->solver->published;
    return column < 0 || !(values[column] > 0) ? (double)NAN : values[column];
}

static double published_hd5870(const table_row *row) {
    return row->published ? published_value(row, row->published->hd5870_ms) : (double)NAN;
}

static double published_gtx480(const table_row *row) {
    return row->published ? published_value(row, row->published->gtx480_ms) : (double)NAN;
}

static double published_mb(const table_row *row) {
    return row->published ? published_value(row, row->published->mb) : (double)NAN;
}

static const char *backend_word(const table_row *row) {
    const ddof_backend backend = row->solver->backend;
    return backend == DDOF_BACKEND_GL ? "gl" : backend == DDOF_BACKEND_CPU ? "cpu" : "reference";
}

static bool is_cr4_pack(const table_row *row) {
    return row->solver->solver == DDOF_SOLVER_CR4_PACK && !row->solver->shared_chain;
}

/* ------------------------------------------------------------------------- Markdown */

/* The device of the rows of one backend. */
static const char *device_of(const table *t, ddof_backend backend) {
    for (int i = 0; i < t->rows; i++)
        if (t->row[i].solver->backend == backend) return t->row[i].device;
    return NULL;
}

static void print_where(const table *t) {
    char processor[128];
    const char *gl = device_of(t, DDOF_BACKEND_GL), *cpu = device_of(t, DDOF_BACKEND_CPU);
    processor_name(processor, sizeof processor);
    printf("%s; %s; ddof %s %s\n\n", processor, compiler_name(), ddof_version(), DDOF_COMMIT);
    if (gl) printf("- GL: %s; surfaces %s; time %s\n", gl, surface_name(t->settings.surface), gl_timing);
    printf("- CPU: %s; time of %s\n", cpu, cpu_timing);
    printf("- medians of %d runs, the solvers taking turns; \"of cr\": median of each round's quotient; %s "
           "conductance, %d substep%s, CoC up to %g px\n",
           t->runs, t->settings.conductance == DDOF_CONDUCTANCE_CLASSIC ? "classic" : "matched", t->settings.substeps,
           t->settings.substeps == 1 ? "" : "s", option_number(t->o, OPT_BENCH_COC, 48));
    printf("- memory: surfaces beyond picture, depth and result; cpu, reference: scratch memory\n");
    printf("- published: Gruen 2011, table 8.1 (HD 5870) and slides (GTX 480); its MB are MiB\n\n");
}

static void print_optional(double value, const char *format) {
    if (isnan(value))
        printf(" |");
    else
        printf(format, value);
}

static int print_markdown(const table *t) {
    print_where(t);
    printf("| Size | Solver | ms | quartiles | least | of cr | MiB | bytes/pixel | published MB | HD 5870 ms | GTX 480 "
           "ms |\n"
           "|---|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|\n");
    for (int i = 0; i < t->rows; i++) {
        const table_row *row = &t->row[i];
        printf("| %dx%d | `%s`%s | %.1f | %.1f to %.1f | %.1f |", row->width, row->height, row->solver->name,
               row->solver->shared_chain ? ", shared chain" : "", row->time.median, row->time.quarter,
               row->time.three_quarters, row->time.least);
        print_optional(row->ratio > 0 ? row->ratio : (double)NAN, " %.2f |");
        printf(" %.1f | %.1f |", mebibytes(row), per_pixel(row));
        print_optional(published_mb(row), " %.0f |");
        print_optional(published_hd5870(row), " %.2f |");
        print_optional(published_gtx480(row), " %.2f |");
        printf("\n");
    }
    bool first = true;
    for (int i = 0; i < t->rows; i++)
        if (is_cr4_pack(&t->row[i])) {
            printf("%s%dx%d %.2f", first ? "\ntime of cr4+pack / time of cr: " : ", ", t->row[i].width,
                   t->row[i].height, t->row[i].ratio);
            first = false;
        }
    if (!first) printf("\n");
    return finish_output();
}

/* ------------------------------------------------------------------------- CSV */

static void csv_number(double value, const char *format) {
    printf(",");
    if (!isnan(value)) printf(format, value);
}

static int print_csv(const table *t) {
    printf("width,height,solver,shared_chain,backend,device,surface,runs,median_ms,q1_ms,q3_ms,min_ms,max_ms,"
           "ratio_to_cr,surface_bytes,surface_bytes_per_pixel,published_mb,published_hd5870_ms,published_gtx480_ms\n");
    for (int i = 0; i < t->rows; i++) {
        const table_row *row = &t->row[i];
        const bool gl = row->solver->backend == DDOF_BACKEND_GL;
        char device[sizeof row->device];
        memcpy(device, row->device, sizeof device);
        for (char *c = device; *c; c++)
            if (*c == '"') *c = '\'';
        printf("%d,%d,%s,%d,%s,\"%s\",%s,%d", row->width, row->height, row->solver->name, row->solver->shared_chain,
               backend_word(row), device, gl ? surface_name(t->settings.surface) : "", t->runs);
        printf(",%.4f,%.4f,%.4f,%.4f,%.4f", row->time.median, row->time.quarter, row->time.three_quarters,
               row->time.least, row->time.most);
        csv_number(row->ratio > 0 ? row->ratio : (double)NAN, "%.4f");
        printf(",%zu,%.4f", row->bytes, per_pixel(row));
        csv_number(published_mb(row), "%.0f");
        csv_number(published_hd5870(row), "%.2f");
        csv_number(published_gtx480(row), "%.2f");
        printf("\n");
    }
    return finish_output();
}

/* ------------------------------------------------------------------------- JSON */

static cJSON *row_object(const table *t, const table_row *row) {
    cJSON *object = cJSON_CreateObject();
    json_integer(object, "width", row->width);
    json_integer(object, "height", row->height);
    json_text(object, "solver", row->solver->name);
    cJSON_AddBoolToObject(object, "shared_chain", row->solver->shared_chain);
    json_text(object, "backend", backend_word(row));
    json_text(object, "device", row->device);
    if (row->solver->backend == DDOF_BACKEND_GL) json_text(object, "surface", surface_name(t->settings.surface));
    json_number(object, "median_ms", row->time.median);
    json_number(object, "q1_ms", row->time.quarter);
    json_number(object, "q3_ms", row->time.three_quarters);
    json_number(object, "min_ms", row->time.least);
    json_number(object, "max_ms", row->time.most);
    json_number(object, "ratio_to_cr", row->ratio > 0 ? row->ratio : (double)NAN);
    json_integer(object, "surface_bytes", (double)row->bytes);
    json_number(object, "surface_bytes_per_pixel", per_pixel(row));
    json_number(object, "published_mb", published_mb(row));
    json_number(object, "published_hd5870_ms", published_hd5870(row));
    json_number(object, "published_gtx480_ms", published_gtx480(row));
    return object;
}

static int print_json(const table *t) {
    char processor[128];
    processor_name(processor, sizeof processor);
    cJSON *object = cJSON_CreateObject(), *rows = cJSON_CreateArray();
    json_text(object, "machine", processor);
    json_text(object, "compiler", compiler_name());
    json_text(object, "version", ddof_version());
    json_text(object, "commit", DDOF_COMMIT);
    json_integer(object, "runs", t->runs);
    json_text(object, "gl_timing", gl_timing);
    json_text(object, "cpu_timing", cpu_timing);
    for (int i = 0; i < t->rows; i++)
        cJSON_AddItemToArray(rows, row_object(t, &t->row[i]));
    cJSON_AddItemToObject(object, "rows", rows);
    return json_finish(object);
}

int table_print(const table *t) {
    enum { MARKDOWN, CSV, JSON }; /* the words of --format */
    if (option_given(t->o, OPT_JSON)) return print_json(t);
    const int format = (int)option_number(t->o, OPT_FORMAT, MARKDOWN);
    if (option_given(t->o, OPT_QUIET) && !option_given(t->o, OPT_FORMAT)) return 0;
    return format == JSON ? print_json(t) : format == CSV ? print_csv(t) : print_markdown(t);
}
