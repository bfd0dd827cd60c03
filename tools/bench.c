/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/utsname.h>
#include <unistd.h>

#include "bench_copy.h"
#include "commands.h"
#include "commit.h"
#include "json.h"
#include "lens.h"
#include "message.h"
#include "session.h"

typedef struct scene {
    int width, height, channels;
    ddof_type type;
    bool planar, in_place, depth;
    size_t bytes;         /* of the picture */
    void *color, *result; /* result: where the copy and, unless in place, the picture goes */
    float *blur;          /* CoC or depth */
    ddof_frame frame;
    ddof_settings settings;
} scene;

typedef struct spread {
    double least, quarter, median, three_quarters, most;
} spread; /* milliseconds */

/* ------------------------------------------------------------------------- a made-up scene */

static uint16_t half_of_float(float value) {
    /* for values between 2^-14 and 65504 only, which is all there is here; rounded down */
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return (uint16_t)((bits >> 13) - (112u << 10));
}

static float color_at(int x, int y, int channel) {
    uint32_t noise = (uint32_t)x * 73856093u ^ (uint32_t)y * 19349663u ^ (uint32_t)channel * 83492791u;
    noise = (noise ^ noise >> 13) * 0x5bd1e995u;
    float value = 0.05f + (float)(noise >> 8) * 0x1p-24f;
    return noise % 997 == 0 ? value * 50 : value; /* highlights */
}

static void fill_color(const scene *s) {
    const size_t pixels = (size_t)s->width * (size_t)s->height;
    for (int y = 0; y < s->height; y++)
        for (int x = 0; x < s->width; x++)
            for (int c = 0; c < s->channels; c++) {
                const size_t pixel = (size_t)y * (size_t)s->width + (size_t)x;
                const size_t at = s->planar ? (size_t)c * pixels + pixel : pixel * (size_t)s->channels + (size_t)c;
                const float value = color_at(x, y, c);
                if (s->type == DDOF_HALF)
                    ((uint16_t *)s->color)[at] = half_of_float(value);
                else
                    ((float *)s->color)[at] = value;
            }
}

/* Sharp in a disc in the middle, nearer on the left, farther on the right: smooth, with values of both signs. */
static void fill_blur(const scene *s, float largest) {
    const float radius = 0.2f * (float)s->height;
    for (int y = 0; y < s->height; y++)
        for (int x = 0; x < s->width; x++) {
            const float u = (float)x - 0.5f * (float)s->width, v = (float)y - 0.5f * (float)s->height;
            const float beyond = fmaxf(sqrtf(u * u + v * v) - radius, 0) / (0.5f * (float)s->width);
            float value = copysignf(largest * fminf(beyond, 1), u);
            if (s->depth) value = 4 * exp2f(3 * copysignf(fminf(beyond, 1), u)); /* 0.5 to 32 around the focus of 4 */
            s->blur[(size_t)y * (size_t)s->width + (size_t)x] = value;
        }
}

static ddof_image describe(const scene *s, void *data) {
    if (!s->planar) return ddof_image_interleaved(data, s->width, s->height, s->channels, s->type, 0);
    void *plane[4];
    for (int c = 0; c < s->channels; c++)
        plane[c] = (char *)data + s->bytes / (size_t)s->channels * (size_t)c;
    return ddof_image_planar(plane, s->width, s->height, s->channels, s->type, 0);
}

/* Whole pages, touched: the first use of memory must not be timed. */
static void *touched_memory(size_t bytes) {
    void *memory = NULL;
    if (posix_memalign(&memory, 4096, bytes) != 0) return NULL;
    memset(memory, 1, bytes);
    return memory;
}

static int check_memory(const scene *s, const options *o) {
    const double need = 2 * (double)s->bytes + 8.0 * s->width * s->height;
    const double have = (double)sysconf(_SC_PHYS_PAGES) * (double)sysconf(_SC_PAGESIZE);
    if (need < 0.9 * have) return 0;
    return fail_usage("--size: %s needs %.1f GB of memory, this machine has %.1f; make it smaller",
                      o->value[OPT_SIZE].text ? o->value[OPT_SIZE].text : "1920x1080", need * 1e-9, have * 1e-9);
}

static int scene_create(scene *s, const options *o) {
    *s = (scene){.width = (int)option_number(o, OPT_SIZE, 1920),
                 .height = option_given(o, OPT_SIZE) ? (int)o->value[OPT_SIZE].number_y : 1080,
                 .channels = (int)option_number(o, OPT_CHANNELS, 4),
                 .type = (ddof_type)option_number(o, OPT_TYPE, DDOF_FLOAT),
                 .planar = option_number(o, OPT_LAYOUT, 0) == 1,
                 .in_place = option_given(o, OPT_IN_PLACE),
                 .depth = option_given(o, OPT_BENCH_DEPTH)};
    const size_t pixels = (size_t)s->width * (size_t)s->height;
    s->bytes = pixels * (size_t)s->channels * (s->type == DDOF_HALF ? 2 : 4);
    int status = check_memory(s, o);
    if (status) return status;
    s->color = touched_memory(s->bytes);
    s->result = touched_memory(s->bytes);
    s->blur = touched_memory(pixels * sizeof(float));
    if (!s->color || !s->result || !s->blur) return fail("--size: out of memory; make it smaller");
    const double largest = option_number(o, OPT_BENCH_COC, 48);
    fill_color(s);
    fill_blur(s, (float)largest);
    s->frame.color = describe(s, s->color);
    s->frame.output = describe(s, s->in_place ? s->color : s->result);
    ddof_image blur = ddof_image_interleaved(s->blur, s->width, s->height, 1, DDOF_FLOAT, 0);
    *(s->depth ? &s->frame.depth : &s->frame.coc) = blur;
    s->settings.lens = (ddof_lens){.kind = DDOF_LENS_ARTIST,
                                   .focus_distance = 4,
                                   .max_coc_near = largest / s->width,
                                   .max_coc_far = largest / s->width};
    method_settings(&s->settings, o);
    return 0;
}

static void scene_destroy(scene *s) {
    free(s->color);
    free(s->result);
    free(s->blur);
}

/* ------------------------------------------------------------------------- measuring */

static int by_size(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double quantile(const double *sorted, int count, double place) {
    const double at = place * (count - 1);
    const int low = (int)at, high = low + 1 < count ? low + 1 : low;
    return sorted[low] + (at - low) * (sorted[high] - sorted[low]);
}

static spread spread_of(double *times, int count) {
    qsort(times, (size_t)count, sizeof *times, by_size);
    return (spread){times[0], quantile(times, count, 0.25), quantile(times, count, 0.5), quantile(times, count, 0.75),
                    times[count - 1]};
}

static int solve_once(scene *s, session *work, ddof_stats *stats, double *time) {
    const double begin = now_ms();
    ddof_status done = ddof_render(work->context, &s->frame, &s->settings, stats);
    *time = now_ms() - begin;
    return done == DDOF_OK ? 0 : session_fail(work, done, "bench");
}

/* One copy and one solve in turn, so that both meet the same state of the machine. */
static int measure(scene *s, session *work, int runs, ddof_stats *stats, spread *solve, spread *copy) {
    double ignored;
    for (int warm = 0; warm < 2; warm++) {
        int status = solve_once(s, work, stats, &ignored);
        if (status) return status;
    }
    double *times = malloc((size_t)runs * sizeof *times), *copies = malloc((size_t)runs * sizeof *copies);
    copy_crew *crew = copy_crew_create(stats->threads);
    int status = times && copies && crew ? 0 : fail("bench: out of memory or threads");
    if (status == 0) copy_crew_run(crew, s->result, s->color, s->bytes);
    for (int i = 0; status == 0 && i < runs; i++) {
        copies[i] = copy_crew_run(crew, s->result, s->color, s->bytes);
        status = solve_once(s, work, stats, &times[i]);
    }
    if (status == 0) {
        *solve = spread_of(times, runs);
        *copy = spread_of(copies, runs);
    }
    copy_crew_destroy(crew);
    free(times);
    free(copies);
    return status;
}

/* ------------------------------------------------------------------------- report */

static void processor_name(char *name, size_t size) {
    struct utsname machine;
    snprintf(name, size, "%s", uname(&machine) == 0 ? machine.machine : "unknown processor");
    FILE *file = fopen("/proc/cpuinfo", "r");
    char line[256];
    while (file && fgets(line, sizeof line, file)) {
        if (strncmp(line, "model name", 10) != 0) continue;
        const char *colon = strchr(line, ':');
        line[strcspn(line, "\n")] = 0;
        if (colon) snprintf(name, size, "%s", colon + 1 + strspn(colon + 1, " "));
        break;
    }
    if (file) fclose(file);
}

static const char *compiler_name(void) {
#if defined(__clang__)
    return "clang " __clang_version__;
#elif defined(__GNUC__)
    return "gcc " __VERSION__;
#else
    return "unknown compiler";
#endif
}

static const char *layout_name(const scene *s) {
    return s->planar ? "planar" : "interleaved";
}

static const char *type_name(const scene *s) {
    return s->type == DDOF_HALF ? "half" : "float";
}

static int report_json(const scene *s, const session *work, const ddof_stats *stats, const spread *solve,
                       const spread *copy, int runs) {
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
    json_text(object, "backend", work->backend);
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
    json_number(object, "megapixels_per_s", megapixels / solve->median * 1e3);
    json_integer(object, "scratch_bytes", (double)stats->scratch_bytes);
    json_integer(object, "peak_rss_bytes", (double)peak_rss_bytes());
    return json_finish(object);
}

static int report_human(const scene *s, const ddof_stats *stats, const spread *solve, const spread *copy, int runs) {
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
    printf("speed   %9.1f megapixels/s\n", pixels * 1e-3 / solve->median);
    printf("scratch %9.2f bytes per pixel (%zu bytes), peak memory of the process %.1f MB\n",
           (double)stats->scratch_bytes / pixels, stats->scratch_bytes, (double)peak_rss_bytes() * 1e-6);
    return finish_output();
}

int command_bench(const options *o) {
    scene s;
    session work = {0};
    ddof_stats stats = {0};
    spread solve, copy;
    const int runs = (int)option_number(o, OPT_RUNS, 31);
    int status = session_open(&work, o);
    if (status) return status;
    work.progress = false; /* drawing it would be timed */
    status = scene_create(&s, o);
    if (status == 0) status = measure(&s, &work, runs, &stats, &solve, &copy);
    if (status == 0 && option_given(o, OPT_JSON))
        status = report_json(&s, &work, &stats, &solve, &copy, runs);
    else if (status == 0 && !option_given(o, OPT_QUIET))
        status = report_human(&s, &stats, &solve, &copy, runs);
    scene_destroy(&s);
    session_close(&work);
    return status;
}
