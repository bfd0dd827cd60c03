/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "bench_vulkan_report.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bokeh.h"
#include "commit.h"
#include "message.h"

static const char software_note[] = "this driver computes on the CPU: its times say nothing about GPUs";

/* ------------------------------------------------------------------------- report */

static const char *timing(const vulkan_bench *b) {
    return bench_vulkan_has_timestamps(b->vk) ? "timestamps" : "wall clock";
}

void bench_vulkan_add_where(const vulkan_bench *b, cJSON *object) {
    char processor[128];
    processor_name(processor, sizeof processor);
    json_text(object, "machine", processor);
    json_text(object, "compiler", compiler_name());
    json_text(object, "version", ddof_version());
    json_text(object, "commit", DDOF_COMMIT);
    json_text(object, "backend", backend_name(DDOF_BACKEND_VULKAN));
    json_text(object, "device", b->device.name);
    json_integer(object, "device_index", b->index);
    json_text(object, "driver", b->device.driver);
    cJSON_AddBoolToObject(object, "is_software", b->device.is_software);
    json_text(object, "timing", timing(b));
    json_integer(object, "runs", b->runs);
}

void bench_vulkan_print_where(const vulkan_bench *b) {
    char processor[128];
    processor_name(processor, sizeof processor);
    printf("%s; %s; ddof %s %s\n", processor, compiler_name(), ddof_version(), DDOF_COMMIT);
    printf("%s; %s; times by %s\n", b->device.name, b->device.driver, timing(b));
    if (b->device.is_software) printf("%s\n", software_note);
}

void bench_vulkan_plan_text(const bench_vulkan_plan *plan, char *text, size_t size) {
    int used = snprintf(text, size, "%s in %d dispatch%s", solver_name(DDOF_BACKEND_VULKAN, plan->solver),
                        plan->dispatches, plan->dispatches == 1 ? "" : "es");
    if (plan->pixels_per_thread == 0 || used < 0 || (size_t)used >= size) return;
    used += snprintf(text + used, size - (size_t)used, ", %d pixels a thread, %d thread%s, %d line%s side by side",
                     plan->pixels_per_thread, plan->workgroup, plan->workgroup == 1 ? "" : "s", plan->strip,
                     plan->strip == 1 ? "" : "s");
    if ((size_t)used >= size) return;
    if (plan->subgroup > 1)
        snprintf(text + used, size - (size_t)used, ", subgroups of %d", plan->subgroup);
    else
        snprintf(text + used, size - (size_t)used, ", no subgroups");
}

static void add_plan(const bench_vulkan_plan *plan, cJSON *object) {
    cJSON *members = cJSON_CreateObject();
    json_text(members, "solver", solver_name(DDOF_BACKEND_VULKAN, plan->solver));
    json_integer(members, "dispatches", plan->dispatches);
    json_integer(members, "pixels_per_thread", plan->pixels_per_thread);
    json_integer(members, "workgroup", plan->workgroup);
    json_integer(members, "strip", plan->strip);
    json_integer(members, "subgroup", plan->subgroup);
    cJSON_AddItemToObject(object, "plan", members);
}

void bench_vulkan_add_measure(const vulkan_measure *m, cJSON *object) {
    json_number(object, "median_ms", m->solve.median);
    json_number(object, "min_ms", m->solve.least);
    json_number(object, "q1_ms", m->solve.quarter);
    json_number(object, "q3_ms", m->solve.three_quarters);
    json_number(object, "max_ms", m->solve.most);
    json_number(object, "copy_ms", m->copy.median);
    json_number(object, "copy_min_ms", m->copy.least);
    json_number(object, "copy_q1_ms", m->copy.quarter);
    json_number(object, "copy_q3_ms", m->copy.three_quarters);
    json_number(object, "copy_ratio", m->solve.median / m->copy.median);
    json_integer(object, "moved_bytes", m->moved);
    json_number(object, "moved_bytes_per_pixel", m->moved / m->pixels);
    json_number(object, "gigabytes_per_s", m->moved * 1e-6 / m->solve.median);
    json_number(object, "copy_gigabytes_per_s", m->moved * 1e-6 / m->copy.median);
    json_number(object, "megapixels_per_s", m->pixels * 1e-3 / m->solve.median);
    json_integer(object, "scratch_bytes", (double)m->plan.scratch_bytes);
    json_number(object, "scratch_bytes_per_pixel", (double)m->plan.scratch_bytes / m->pixels);
    add_plan(&m->plan, object);
}

static const char *append_name(const ddof_settings *s) {
    return s->sprites.append == DDOF_APPEND_ARGUMENTS ? "arguments" : "counter";
}

static const char *quads_name(const ddof_settings *s) {
    return s->sprites.quads == DDOF_QUADS_GEOMETRY ? "geometry" : "instanced";
}

static void add_sprites(const scene *s, const vulkan_measure *m, cJSON *object) {
    json_text(object, "bokeh", bokeh_name(s->settings.bokeh));
    if (s->settings.bokeh == DDOF_BOKEH_OFF) return;
    json_text(object, "append", append_name(&s->settings));
    json_text(object, "quads", quads_name(&s->settings));
    if (m->timed) {
        json_number(object, "append_ms", m->append.median);
        json_number(object, "draw_ms", m->draw.median);
        json_number(object, "draw_append_ratio", m->draw_append.median);
    }
    if (m->compared) json_number(object, "highlights_ratio", m->highlights.median);
}

static void print_sprites(const scene *s, const vulkan_measure *m) {
    if (s->settings.bokeh == DDOF_BOKEH_OFF) return;
    printf("sprites %s, appended by %s, quads %s\n", bokeh_name(s->settings.bokeh), append_name(&s->settings),
           quads_name(&s->settings));
    if (m->timed) {
        printf("append  %9.3f ms median (quartiles %.3f to %.3f)\n", m->append.median, m->append.quarter,
               m->append.three_quarters);
        printf("draw    %9.3f ms median (quartiles %.3f to %.3f), %.2f times the append\n", m->draw.median,
               m->draw.quarter, m->draw.three_quarters, m->draw_append.median);
    }
    if (m->compared)
        printf("bokeh   %9.2f times the same without sprites, median (quartiles %.2f to %.2f)\n", m->highlights.median,
               m->highlights.quarter, m->highlights.three_quarters);
}

static int report_json(const vulkan_bench *b, const scene *s, const vulkan_measure *m) {
    cJSON *object = cJSON_CreateObject();
    bench_vulkan_add_where(b, object);
    json_integer(object, "width", s->width);
    json_integer(object, "height", s->height);
    json_integer(object, "channels", s->channels);
    json_text(object, "type", s->type == DDOF_HALF ? "half" : "float");
    cJSON_AddBoolToObject(object, "in_place", s->in_place);
    json_text(object, "solver", solver_name(DDOF_BACKEND_VULKAN, s->settings.solver));
    json_text(object, "surface", surface_name(s->settings.surface));
    bench_vulkan_add_measure(m, object);
    add_sprites(s, m, object);
    return json_finish(object);
}

static int report_human(const vulkan_bench *b, const scene *s, const vulkan_measure *m) {
    char plan[256];
    bench_vulkan_plan_text(&m->plan, plan, sizeof plan);
    bench_vulkan_print_where(b);
    printf("%dx%d, %d channels, %s%s, %s in %s; %d runs\n", s->width, s->height, s->channels,
           surface_name(s->settings.surface), s->in_place ? ", in place" : "", s->depth ? "depth and lens" : "CoC",
           s->type == DDOF_HALF ? "half" : "float", b->runs);
    printf("solver  %s\n", plan);
    printf("solve   %9.3f ms median (quartiles %.3f to %.3f, %.3f to %.3f in all)\n", m->solve.median, m->solve.quarter,
           m->solve.three_quarters, m->solve.least, m->solve.most);
    printf("copy    %9.3f ms median (quartiles %.3f to %.3f) of as many bytes as it must move, %.0f per pixel\n",
           m->copy.median, m->copy.quarter, m->copy.three_quarters, m->moved / m->pixels);
    printf("ratio   %9.2f times the copy\n", m->solve.median / m->copy.median);
    print_sprites(s, m);
    printf("speed   %9.1f megapixels/s, %.1f GB/s; copy %.1f GB/s\n", m->pixels * 1e-3 / m->solve.median,
           m->moved * 1e-6 / m->solve.median, m->moved * 1e-6 / m->copy.median);
    printf("scratch %9.2f bytes per pixel (%zu bytes)\n", (double)m->plan.scratch_bytes / m->pixels,
           m->plan.scratch_bytes);
    return finish_output();
}

/* ------------------------------------------------------------------------- measuring */

static int fail_vulkan(const char *why) {
    return fail("--backend vulkan: %s; use --backend cpu", why);
}

/* What is timed in a turn; of each as many as there are runs. */
enum { COPIES, SOLVES, APPENDS, DRAWS, DRAW_APPENDS, RATIOS, SERIES };
enum { WHOLE, PLAIN /* without sprites */ };

static const char *take_turn(vulkan_bench *b, const vulkan_measure *m, double time[SERIES]) {
    bench_vulkan_times sprites = {1, 1};
    double plain = 1;
    const char *bad = bench_vulkan_copy(b->vk, &time[COPIES]);
    if (!bad && m->compared) bad = bench_vulkan_solve(b->vk, PLAIN, &plain);
    if (!bad) bad = bench_vulkan_solve(b->vk, WHOLE, &time[SOLVES]);
    if (!bad && m->timed) bad = bench_vulkan_sprites(b->vk, &sprites);
    time[APPENDS] = sprites.append;
    time[DRAWS] = sprites.draw;
    time[DRAW_APPENDS] = sprites.draw / sprites.append;
    time[RATIOS] = time[SOLVES] / plain;
    return bad;
}

static const char *prepare(vulkan_bench *b, const scene *s, vulkan_measure *m) {
    const bool sprites = s->settings.bokeh || s->settings.method == DDOF_METHOD_SCATTER;
    bench_vulkan_plan ignored;
    ddof_settings plain = s->settings;
    plain.bokeh = DDOF_BOKEH_OFF;
    m->timed = sprites && bench_vulkan_has_timestamps(b->vk);
    m->compared = s->settings.bokeh == DDOF_BOKEH_HIGHLIGHTS;
    const char *bad = bench_vulkan_picture(b->vk, s, s->settings.surface, &m->moved);
    if (!bad && m->compared) bad = bench_vulkan_prepare(b->vk, PLAIN, &plain, &ignored);
    return bad ? bad : bench_vulkan_prepare(b->vk, WHOLE, &s->settings, &m->plan);
}

/* One of each in turn, so that all meet the same state of the machine. The first turns warm up: drivers compile
 * then. */
static int measure(vulkan_bench *b, const scene *s, vulkan_measure *m) {
    enum { WARM = 2 };
    double *series = malloc((size_t)b->runs * SERIES * sizeof *series), time[SERIES] = {0};
    int status = series ? 0 : fail("--runs: out of memory; make it smaller");
    const char *bad = status == 0 ? prepare(b, s, m) : NULL;
    for (int i = -WARM; status == 0 && !bad && i < b->runs; i++) {
        bad = take_turn(b, m, time);
        for (int k = 0; i >= 0 && k < SERIES; k++)
            series[k * b->runs + i] = time[k];
    }
    if (status == 0 && bad) status = fail_vulkan(bad);
    if (status == 0) {
        spread *of[SERIES] = {&m->copy, &m->solve, &m->append, &m->draw, &m->draw_append, &m->highlights};
        m->pixels = (double)s->width * s->height;
        for (int k = 0; k < SERIES; k++)
            *of[k] = spread_of(series + k * b->runs, b->runs);
    }
    free(series);
    return status;
}

static int bench_one(vulkan_bench *b) {
    scene s;
    vulkan_measure m = {0};
    const options *o = b->o;
    const option_value *size = &o->value[OPT_SIZE];
    int status = scene_create(&s, o, size->given ? (int)size->number : 1920, size->given ? (int)size->number_y : 1080);
    if (status == 0) status = measure(b, &s, &m);
    if (status == 0 && option_given(o, OPT_JSON))
        status = report_json(b, &s, &m);
    else if (status == 0 && !option_given(o, OPT_QUIET))
        status = report_human(b, &s, &m);
    scene_destroy(&s);
    return status;
}

/* ------------------------------------------------------------------------- the command */

static int check_options(const options *o) {
    const double half_most = 65504; /* the largest finite half float */
    if (option_number(o, OPT_LAYOUT, 0) > 0)
        return fail_usage("--layout: the images of the Vulkan backend are interleaved; leave it out");
    if (option_number(o, OPT_CHANNELS, 4) < 3)
        return fail_usage("--channels: the images of the Vulkan backend have 3 or 4; write --channels 3 or 4");
    if (option_number(o, OPT_TYPE, DDOF_FLOAT) > 0 && option_number(o, OPT_BENCH_COC, 0) > half_most)
        return fail_usage("--coc: %g does not fit into half floats; make it at most %g, or leave out --type half",
                          option_number(o, OPT_BENCH_COC, 0), half_most);
    if (option_given(o, OPT_REFERENCE))
        return fail_usage("--reference: makes no row of the table of --backend vulkan; leave one of them out");
    return 0;
}

static int fail_open(const options *o, ddof_status status, const char *why) {
    if (status == DDOF_ERROR_INVALID && option_given(o, OPT_DEVICE))
        return fail_usage("--device: there is no Vulkan device %g; 'ddof devices' lists those there are",
                          option_number(o, OPT_DEVICE, 0));
    return fail_vulkan(why);
}

/* What the device is called; it has been opened, so it is in the list. */
static int look_up_device(vulkan_bench *b) {
    ddof_device *devices = calloc((size_t)b->index + 1, sizeof *devices);
    if (!devices) return fail("--device: out of memory");
    if (ddof_devices(DDOF_BACKEND_VULKAN, devices, b->index + 1) > b->index) b->device = devices[b->index];
    free(devices);
    return 0;
}

int bench_vulkan_command(const options *o, const backend_choice *choice, bool *stand_in) {
    const bool table = option_given(o, OPT_TABLE);
    char why[512] = "";
    ddof_status done;
    vulkan_bench b = {.o = o,
                      .index = (int)option_number(o, OPT_DEVICE, 0),
                      .runs = (int)option_number(o, OPT_RUNS, table ? 11 : 31)};
    *stand_in = false;
    int status = check_options(o);
    if (status) return status;
    b.vk = bench_vulkan_open(b.index, &done, why, sizeof why);
    if (!b.vk && choice->because) {
        *stand_in = true;
        backend_note_fallback(choice, why);
        return 0;
    }
    if (!b.vk) return fail_open(o, done, why);
    status = look_up_device(&b);
    if (status == 0) status = table ? bench_vulkan_table(&b) : bench_one(&b);
    bench_vulkan_close(&b.vk);
    return status;
}
