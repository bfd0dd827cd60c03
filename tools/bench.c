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
#include "bokeh.h"
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

/* What a solve is measured by besides the copy, where it is something else: the heat kernel on the same picture, and
 * the same settings without sprites. */
enum { BY_HEAT, BY_PLAIN, BASELINES };

typedef struct measured {
    spread solve, copy;
    bool compared[BASELINES];
    spread ratio[BASELINES]; /* of each pair */
} measured;

static void choose_baselines(measured *m, const ddof_settings *settings) {
    const bool heat = bokeh_method(settings) == DDOF_METHOD_DIFFUSION && settings->kernel == DDOF_KERNEL_HEAT;
    m->compared[BY_HEAT] = !heat;
    m->compared[BY_PLAIN] = settings->bokeh == DDOF_BOKEH_HIGHLIGHTS;
}

static int baseline_once(scene *s, session *work, int which, double *time) {
    const ddof_settings own = s->settings;
    ddof_stats stats;
    s->settings.bokeh = DDOF_BOKEH_OFF;
    if (which == BY_HEAT) {
        s->settings.method = DDOF_METHOD_DIFFUSION;
        s->settings.kernel = DDOF_KERNEL_HEAT;
        s->settings.quality = DDOF_QUALITY_DEFAULT;
    }
    const int status = solve_once(s, work, &stats, time);
    s->settings = own;
    return status;
}

/* The baselines that are wanted, then the solve. */
static int take_turn(scene *s, session *work, const measured *m, ddof_stats *stats, double base[BASELINES],
                     double *time) {
    int status = 0;
    for (int b = 0; status == 0 && b < BASELINES; b++)
        if (m->compared[b]) status = baseline_once(s, work, b, &base[b]);
    return status == 0 ? solve_once(s, work, stats, time) : status;
}

/* One copy and one turn after the other, so that all meet the same state of the machine. */
static int measure(scene *s, session *work, int runs, ddof_stats *stats, measured *m) {
    double base[BASELINES] = {1, 1}, ignored;
    choose_baselines(m, &s->settings);
    for (int warm = 0; warm < 2; warm++) {
        const int status = take_turn(s, work, m, stats, base, &ignored);
        if (status) return status;
    }
    double *times = malloc((size_t)runs * sizeof *times), *copies = malloc((size_t)runs * sizeof *copies);
    double *ratios = malloc((size_t)runs * BASELINES * sizeof *ratios);
    copy_crew *crew = copy_crew_create(stats->threads);
    int status = times && copies && ratios && crew ? 0 : fail("bench: out of memory or threads");
    if (status == 0) copy_crew_run(crew, s->result, s->color, s->bytes);
    for (int i = 0; status == 0 && i < runs; i++) {
        copies[i] = copy_crew_run(crew, s->result, s->color, s->bytes);
        status = take_turn(s, work, m, stats, base, &times[i]);
        for (int b = 0; status == 0 && b < BASELINES; b++)
            ratios[b * runs + i] = times[i] / base[b];
    }
    if (status == 0) {
        m->solve = spread_of(times, runs);
        m->copy = spread_of(copies, runs);
        for (int b = 0; b < BASELINES; b++)
            m->ratio[b] = spread_of(ratios + b * runs, runs);
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
static const char *kernel_text(const scene *s, char *text, size_t size) {
    const bool disc = s->settings.kernel == DDOF_KERNEL_DISC;
    snprintf(text, size, "%s%s%s", kernel_name(s->settings.kernel), disc ? " " : "",
             disc ? quality_name(s->settings.quality) : "");
    return text;
}

static void add_method(const scene *s, const ddof_stats *stats, cJSON *object) {
    const ddof_settings *settings = &s->settings;
    char kernel[32];
    json_text(object, "method", method_name(bokeh_method(settings)));
    if (bokeh_method(settings) == DDOF_METHOD_DIFFUSION)
        json_text(object, "kernel", kernel_text(s, kernel, sizeof kernel));
    json_text(object, "bokeh", bokeh_name(settings->bokeh));
    json_integer(object, "sprites", (double)stats->sprites);
    json_integer(object, "sprites_dropped", (double)stats->sprites_dropped);
    json_integer(object, "sprites_large", (double)stats->sprites_large);
}

static int report_json(const scene *s, const session *work, const ddof_stats *stats, const measured *m, int runs) {
    char processor[128];
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
    add_method(s, stats, object);
    json_text(object, "backend", backend_name(work->backend));
    json_text(object, "device", stats->device);
    json_integer(object, "threads", stats->threads);
    json_integer(object, "runs", runs);
    json_number(object, "median_ms", m->solve.median);
    json_number(object, "min_ms", m->solve.least);
    json_number(object, "q1_ms", m->solve.quarter);
    json_number(object, "q3_ms", m->solve.three_quarters);
    json_number(object, "max_ms", m->solve.most);
    json_number(object, "memcpy_ms", m->copy.median);
    json_number(object, "memcpy_min_ms", m->copy.least);
    json_number(object, "memcpy_ratio", m->solve.median / m->copy.median);
    if (m->compared[BY_HEAT]) json_number(object, "heat_ratio", m->ratio[BY_HEAT].median);
    if (m->compared[BY_PLAIN]) json_number(object, "bokeh_ratio", m->ratio[BY_PLAIN].median);
    json_number(object, "megapixels_per_s", megapixels / m->solve.median * 1e3);
    json_integer(object, "scratch_bytes", (double)stats->scratch_bytes);
    json_integer(object, "peak_rss_bytes", (double)peak_rss_bytes());
    session_add_gpu(work, object, &s->settings, stats, (double)s->width * s->height);
    return json_finish(object);
}

static void print_ratio(const char *what, const spread *ratio, const char *of) {
    printf("%-7s %9.2f times %s, median (quartiles %.2f to %.2f)\n", what, ratio->median, of, ratio->quarter,
           ratio->three_quarters);
}

static void print_ratios(const scene *s, const ddof_stats *stats, const measured *m) {
    const ddof_method method = bokeh_method(&s->settings);
    if (m->compared[BY_HEAT])
        print_ratio(method == DDOF_METHOD_DIFFUSION ? quality_name(s->settings.quality) : method_name(method),
                    &m->ratio[BY_HEAT], "the heat kernel");
    if (m->compared[BY_PLAIN]) print_ratio("bokeh", &m->ratio[BY_PLAIN], "the same without sprites");
    if (s->settings.bokeh != DDOF_BOKEH_OFF)
        printf(
            "sprites %9lld pixels drawn, %lld beyond --max-sprites or --max-sprite-area, %lld beyond --bokeh-limit\n",
            (long long)stats->sprites, (long long)stats->sprites_dropped, (long long)stats->sprites_large);
}

static int report_human(const scene *s, const session *work, const ddof_stats *stats, const measured *m, int runs) {
    char processor[128];
    processor_name(processor, sizeof processor);
    const double pixels = (double)s->width * s->height;
    printf("%s; %s; ddof %s %s\n", processor, compiler_name(), ddof_version(), DDOF_COMMIT);
    printf("%dx%d, %d channels, %s, %s%s, %s; %s, %d thread%s, %d runs\n", s->width, s->height, s->channels,
           type_name(s), layout_name(s), s->in_place ? ", in place" : "", s->depth ? "depth and lens" : "CoC",
           stats->device, stats->threads, stats->threads == 1 ? "" : "s", runs);
    printf("solve   %9.3f ms median (quartiles %.3f to %.3f, %.3f to %.3f in all)\n", m->solve.median, m->solve.quarter,
           m->solve.three_quarters, m->solve.least, m->solve.most);
    printf("memcpy  %9.3f ms median (quartiles %.3f to %.3f) of the same picture\n", m->copy.median, m->copy.quarter,
           m->copy.three_quarters);
    printf("ratio   %9.2f times the memcpy\n", m->solve.median / m->copy.median);
    print_ratios(s, stats, m);
    printf("speed   %9.1f megapixels/s\n", pixels * 1e-3 / m->solve.median);
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
    static const option_id not_in_table[] = {OPT_SOLVER,   OPT_SHARED_CHAIN, OPT_TYPE,    OPT_LAYOUT, OPT_CHANNELS,
                                             OPT_IN_PLACE, OPT_KERNEL,       OPT_QUALITY, OPT_METHOD, OPT_BOKEH};
    int status = method_check_options(o);
    if (status == 0) status = bokeh_check_options(o);
    if (status) return status;
    if (option_given(o, OPT_IN_PLACE) && bokeh_of_options(o) == DDOF_BOKEH_HIGHLIGHTS)
        return fail_usage("--in-place: the first solve would leave no highlights for the next one; leave it out with "
                          "--bokeh highlights");
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
    measured m = {0};
    const int runs = (int)option_number(o, OPT_RUNS, 31);
    work->progress = false; /* drawing it would be timed */
    int status = scene_create(&s, o, (int)option_number(o, OPT_SIZE, 1920),
                              option_given(o, OPT_SIZE) ? (int)o->value[OPT_SIZE].number_y : 1080);
    if (status == 0) status = measure(&s, work, runs, &stats, &m);
    if (status == 0 && option_given(o, OPT_JSON))
        status = report_json(&s, work, &stats, &m, runs);
    else if (status == 0 && !option_given(o, OPT_QUIET))
        status = report_human(&s, work, &stats, &m, runs);
    scene_destroy(&s);
    return status;
}

int command_bench(const options *o) {
    const char *backend = option_text(o, OPT_BACKEND);
    backend_choice choice;
    session work = {0};
    bool stand_in = false;
    int status = method_none(o) ? fail_usage("--method: none is for render; there is nothing to time") : bench_check(o);
    if (status) return status;
    if (option_given(o, OPT_TABLE) && !(backend && strcmp(backend, "vulkan") == 0)) return bench_table(o);
    status = backend_choose(&choice, o);
    if (status) return status;
    if (choice.backend == DDOF_BACKEND_VULKAN) {
        if (option_given(o, OPT_KERNEL))
            return fail_usage("--kernel: is not for the bench of the Vulkan backend; leave it out");
        status = bench_vulkan_command(o, &choice, &stand_in);
        if (!stand_in) return status;
    }
    status = stand_in ? session_open_as(&work, o, DDOF_BACKEND_CPU) : session_open(&work, o);
    if (status == 0) status = bench_session(o, &work);
    session_close(&work);
    return status;
}
