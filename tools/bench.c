/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench_copy.h"
#include "bench_report.h"
#include "bench_scene.h"
#include "bench_table.h"
#include "bench_vulkan_report.h"
#include "commands.h"
#include "commit.h"
#include "json.h"
#include "lens.h"
#include "message.h"
#include "session.h"

/* ------------------------------------------------------------------------- measuring */

static int solve_once(scene *s, session *work, ddof_stats *stats, double *time) {
    const double begin = now_ms();
    ddof_status done = ddof_render(work->context, &s->frame, &s->settings, stats);
    *time = now_ms() - begin;
    return done == DDOF_OK ? 0 : session_fail(work, done, "bench");
}

/* The heat kernel on the same picture, what the disc kernel is measured by. */
static int heat_once(scene *s, session *work, double *time) {
    const ddof_settings disc = s->settings;
    ddof_stats stats;
    s->settings.kernel = DDOF_KERNEL_HEAT;
    s->settings.quality = DDOF_QUALITY_DEFAULT;
    const int status = solve_once(s, work, &stats, time);
    s->settings = disc;
    return status;
}

/* One copy and one solve in turn, so that both meet the same state of the machine; with the disc kernel a heat solve as
 * well, and the ratios of each pair. */
static int measure(scene *s, session *work, int runs, ddof_stats *stats, spread *solve, spread *copy, spread *ratio) {
    double ignored;
    for (int warm = 0; warm < 2; warm++) {
        int status = solve_once(s, work, stats, &ignored);
        if (status == 0 && ratio) status = heat_once(s, work, &ignored);
        if (status) return status;
    }
    double *times = malloc((size_t)runs * sizeof *times), *copies = malloc((size_t)runs * sizeof *copies);
    double *ratios = malloc((size_t)runs * sizeof *ratios), heat = 1;
    copy_crew *crew = copy_crew_create(stats->threads);
    int status = times && copies && ratios && crew ? 0 : fail("bench: out of memory or threads");
    if (status == 0) copy_crew_run(crew, s->result, s->color, s->bytes);
    for (int i = 0; status == 0 && i < runs; i++) {
        copies[i] = copy_crew_run(crew, s->result, s->color, s->bytes);
        if (ratio) status = heat_once(s, work, &heat);
        if (status == 0) status = solve_once(s, work, stats, &times[i]);
        ratios[i] = times[i] / heat;
    }
    if (status == 0) {
        *solve = spread_of(times, runs);
        *copy = spread_of(copies, runs);
        if (ratio) *ratio = spread_of(ratios, runs);
    }
    copy_crew_destroy(crew);
    free(times);
    free(copies);
    free(ratios);
    return status;
}

/* ------------------------------------------------------------------------- report */

static const char *layout_name(const scene *s) {
    return s->planar ? "planar" : "interleaved";
}

static const char *type_name(const scene *s) {
    return s->type == DDOF_HALF ? "half" : "float";
}

/* "heat", "disc good". */
static const char *method_name(const scene *s, char *text, size_t size) {
    const bool disc = s->settings.kernel == DDOF_KERNEL_DISC;
    snprintf(text, size, "%s%s%s", kernel_name(s->settings.kernel), disc ? " " : "", disc ? quality_name(s->settings.quality) : "");
    return text;
}

static int report_json(const scene *s, const session *work, const ddof_stats *stats, const spread *solve,
                       const spread *copy, const spread *ratio, int runs) {
    char processor[128], method[32];
    processor_name(processor, sizeof processor);
    const double megapixels = (double)s->width * s->height * 1e-6;
    cJSON *object = cJSON_CreateObject();
    json_text(object, "machine", processor);
    json_text(object, "compiler", compiler_name());
    json_text(object, "version", ddof_version());
    json_text(object, "commit", DDOF_COMMIT);
    json_integer(object, "width", s->width);
    json_integer(object, "height", s->height);
    json_integer(object, "channels", s->channels);
    json_text(object, "type", type_name(s));
    json_text(object, "layout", layout_name(s));
    cJSON_AddBoolToObject(object, "in_place", s->in_place);
    json_text(object, "kernel", method_name(s, method, sizeof method));
    json_text(object, "backend", backend_name(work->backend));
    json_text(object, "device", stats->device);
    json_integer(object, "threads", stats->threads);
    json_integer(object, "runs", runs);
    json_number(object, "median_ms", solve->median);
    json_number(object, "min_ms", solve->least);
    json_number(object, "q1_ms", solve->quarter);
    json_number(object, "q3_ms", solve->three_quarters);
    json_number(object, "max_ms", solve->most);
    json_number(object, "memcpy_ms", copy->median);
    json_number(object, "memcpy_min_ms", copy->least);
    json_number(object, "memcpy_ratio", solve->median / copy->median);
    if (ratio) json_number(object, "heat_ratio", ratio->median);
    json_number(object, "megapixels_per_s", megapixels / solve->median * 1e3);
    json_integer(object, "scratch_bytes", (double)stats->scratch_bytes);
    json_integer(object, "peak_rss_bytes", (double)peak_rss_bytes());
    session_add_gpu(work, object, &s->settings, stats, (double)s->width * s->height);
    return json_finish(object);
}

static int report_human(const scene *s, const session *work, const ddof_stats *stats, const spread *solve,
                        const spread *copy, const spread *ratio, int runs) {
    char processor[128];
    processor_name(processor, sizeof processor);
    const double pixels = (double)s->width * s->height;
    printf("%s; %s; ddof %s %s\n", processor, compiler_name(), ddof_version(), DDOF_COMMIT);
    printf("%dx%d, %d channels, %s, %s%s, %s; %s, %d thread%s, %d runs\n", s->width, s->height, s->channels,
           type_name(s), layout_name(s), s->in_place ? ", in place" : "", s->depth ? "depth and lens" : "CoC",
           stats->device, stats->threads, stats->threads == 1 ? "" : "s", runs);
    printf("solve   %9.3f ms median (quartiles %.3f to %.3f, %.3f to %.3f in all)\n", solve->median, solve->quarter,
           solve->three_quarters, solve->least, solve->most);
    printf("memcpy  %9.3f ms median (quartiles %.3f to %.3f) of the same picture\n", copy->median, copy->quarter,
           copy->three_quarters);
    printf("ratio   %9.2f times the memcpy\n", solve->median / copy->median);
    if (ratio)
        printf("%-7s %9.2f times the heat kernel, median (quartiles %.2f to %.2f)\n", quality_name(s->settings.quality), ratio->median,
               ratio->quarter, ratio->three_quarters);
    printf("speed   %9.1f megapixels/s\n", pixels * 1e-3 / solve->median);
    printf("scratch %9.2f bytes per pixel (%zu bytes), peak memory of the process %.1f MB\n",
           (double)stats->scratch_bytes / pixels, stats->scratch_bytes, (double)peak_rss_bytes() * 1e-6);
    if (work->backend == DDOF_BACKEND_GL)
        printf("gl      %9.2f bytes of surfaces per pixel (%zu bytes), %s%s, %s\n",
               (double)stats->surface_bytes / pixels, stats->surface_bytes,
               solver_name(work->backend, s->settings.solver), s->settings.shared_chain ? ", shared chain" : "",
               surface_name(s->settings.surface));
    return finish_output();
}

/* What no backend takes. */
static int bench_check(const options *o) {
    static const option_id not_in_table[] = {OPT_SOLVER,   OPT_SHARED_CHAIN, OPT_TYPE,   OPT_LAYOUT,
                                             OPT_CHANNELS, OPT_IN_PLACE,     OPT_KERNEL, OPT_QUALITY};
    const int status = method_check_options(o);
    if (status) return status;
    if (!option_given(o, OPT_TABLE)) {
        if (option_given(o, OPT_FORMAT)) return fail_usage("--format: is for --table; add --table, or take --json");
        if (option_given(o, OPT_REFERENCE))
            return fail_usage("--reference: is for --table; add --table, or take --backend reference");
        return 0;
    }
    for (size_t i = 0; i < sizeof not_in_table / sizeof *not_in_table; i++)
        if (option_given(o, not_in_table[i]))
            return fail_usage("--%s: is not for --table, which has its own; leave one of them out",
                              option_table[not_in_table[i]].name);
    if (option_given(o, OPT_JSON) && option_given(o, OPT_FORMAT) && strcmp(option_text(o, OPT_FORMAT), "json") != 0)
        return fail_usage("--format: %s contradicts --json; leave one of them out", option_text(o, OPT_FORMAT));
    return 0;
}

static int bench_session(const options *o, session *work) {
    scene s;
    ddof_stats stats = {0};
    spread solve = {0}, copy = {0}, ratio = {0};
    const int runs = (int)option_number(o, OPT_RUNS, 31);
    work->progress = false; /* drawing it would be timed */
    int status = scene_create(&s, o, (int)option_number(o, OPT_SIZE, 1920),
                              option_given(o, OPT_SIZE) ? (int)o->value[OPT_SIZE].number_y : 1080);
    const bool disc = s.settings.kernel == DDOF_KERNEL_DISC;
    if (status == 0) status = measure(&s, work, runs, &stats, &solve, &copy, disc ? &ratio : NULL);
    if (status == 0 && option_given(o, OPT_JSON))
        status = report_json(&s, work, &stats, &solve, &copy, disc ? &ratio : NULL, runs);
    else if (status == 0 && !option_given(o, OPT_QUIET))
        status = report_human(&s, work, &stats, &solve, &copy, disc ? &ratio : NULL, runs);
    scene_destroy(&s);
    return status;
}

int command_bench(const options *o) {
    const char *backend = option_text(o, OPT_BACKEND);
    backend_choice choice;
    session work = {0};
    bool stand_in = false;
    int status = bench_check(o);
    if (status) return status;
    if (option_given(o, OPT_TABLE) && !(backend && strcmp(backend, "vulkan") == 0)) return bench_table(o);
    status = backend_choose(&choice, o);
    if (status) return status;
    if (choice.backend == DDOF_BACKEND_VULKAN) {
        if (option_given(o, OPT_KERNEL)) return fail_usage("--kernel: is not for the bench of the Vulkan backend; leave it out");
        status = bench_vulkan_command(o, &choice, &stand_in);
        if (!stand_in) return status;
    }
    status = stand_in ? session_open_as(&work, o, DDOF_BACKEND_CPU) : session_open(&work, o);
    if (status == 0) status = bench_session(o, &work);
    session_close(&work);
    return status;
}
