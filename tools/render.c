/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "bokeh.h"
#include "commands.h"
#include "frame.h"
#include "job.h"
#include "json.h"
#include "message.h"
#include "output.h"
#include "scratch.h"

typedef struct timing {
    double prepare, solve, encode, preview;
} timing; /* milliseconds */

typedef struct report {
    ddof_stats stats;
    timing time;
    bool has_range;
    float coc_low, coc_high;
} report;

/* ------------------------------------------------------------------------- before and after */

enum { PREVIEW_SIDE = 1920 }; /* pixels: wider pictures are shown smaller */

static int preview_shrink(const job *j) {
    return (job_part(j)->display.width + PREVIEW_SIDE - 1) / PREVIEW_SIDE;
}

/* Of one of the two pictures; between them lies a gap. */
static int preview_side(const job *j) {
    return (job_part(j)->display.width + preview_shrink(j) - 1) / preview_shrink(j);
}

static int preview_width(const job *j) {
    return 2 * preview_side(j) + preview_side(j) / 100;
}

static double preview_gain(const options *o) {
    return exp2(option_number(o, OPT_EXPOSURE, 0));
}

/* The picture is blurred in place, so its left half is filled while the picture is still sharp. */
static int preview_begin(io_picture **preview, const job *j, const options *o) {
    const char *path = option_text(o, OPT_PREVIEW);
    if (!path) return 0;
    const int shrink = preview_shrink(j), height = (job_part(j)->display.height + shrink - 1) / shrink;
    int status = output_create_rgb(preview, preview_width(j), height, path, &j->reading);
    return status ? status : output_place_color(*preview, 0, j->input, &j->color, shrink, preview_gain(o));
}

static int preview_end(io_picture *preview, const job *j, const options *o, timing *time) {
    if (!preview) return 0;
    const double begin = now_ms();
    const int right = preview_width(j) - preview_side(j);
    int status = output_place_color(preview, right, j->input, &j->color, preview_shrink(j), preview_gain(o));
    if (status == 0) status = output_write(preview, option_text(o, OPT_PREVIEW), &j->reading);
    time->preview += now_ms() - begin;
    return status;
}

/* ------------------------------------------------------------------------- report */

static void report_human(FILE *out, const job *j, const options *o, const session *s, const report *r, double total) {
    char lens[128] = "CoC from --coc", range[64] = "", extra[96] = "";
    if (!j->frame.coc.channels)
        lens_describe(lens, sizeof lens, &j->settings, r->stats.focus_distance, j->frame.picture_width);
    if (r->has_range) snprintf(range, sizeof range, ", CoC %.1f to %.1f px", (double)r->coc_low, (double)r->coc_high);
    if (*j->file.entry && !option_given(o, OPT_FSTOP)) snprintf(extra, sizeof extra, " (%.80s)", j->file.entry);
    fprintf(out, "%s: %dx%d, %s%s%s\n", option_text(o, OPT_OUTPUT), j->frame.color.width, j->frame.color.height, lens, extra,
           range);
    const int images = channels_count(&j->choice);
    if (images > 1) fprintf(out, "%d images blurred, with %d depth%s\n", images, j->group_count, j->group_count == 1 ? "" : "s");
    fprintf(out, "solve %.1f ms (%s, %d thread%s), decode %.0f ms, encode %.0f ms, total %.0f ms\n", r->time.solve,
           r->stats.device, r->stats.threads, r->stats.threads == 1 ? "" : "s", j->decode_ms, r->time.encode, total);
    session_print_gpu(out, s, &j->settings, &r->stats, (double)j->frame.color.width * j->frame.color.height);
    if (j->settings.bokeh == DDOF_BOKEH_HIGHLIGHTS)
        fprintf(out, "bokeh: %lld highlight pixel%s drawn, iris %s\n", (long long)r->stats.sprites, r->stats.sprites == 1 ? "" : "s",
               bokeh_iris_text(o));
    if (j->settings.bokeh == DDOF_BOKEH_FULL) fprintf(out, "bokeh: all pixels out of focus drawn, iris %s\n", bokeh_iris_text(o));
    if (option_given(o, OPT_PREVIEW)) fprintf(out, "%s: before and after\n", option_text(o, OPT_PREVIEW));
}

static void add_method(const job *j, const options *o, const ddof_stats *stats, cJSON *object) {
    const ddof_settings *settings = &j->settings;
    const bool diffusion = bokeh_method(settings) == DDOF_METHOD_DIFFUSION, disc = settings->kernel == DDOF_KERNEL_DISC;
    json_text(object, "method", method_none(o) ? "none" : method_name(bokeh_method(settings)));
    if (diffusion) json_text(object, "kernel", kernel_name(settings->kernel));
    if (diffusion && disc) json_text(object, "quality", quality_name(settings->quality));
    json_text(object, "bokeh", bokeh_name(settings->bokeh));
    if (settings->bokeh == DDOF_BOKEH_OFF)
        cJSON_AddNullToObject(object, "iris");
    else
        json_text(object, "iris", bokeh_iris_text(o));
    json_integer(object, "sprites", (double)stats->sprites);
    json_integer(object, "sprites_dropped", (double)stats->sprites_dropped);
    json_integer(object, "sprites_large", (double)stats->sprites_large);
}

/* What was blurred, and what was not though a wildcard names it. */
static void add_choice(const job *j, cJSON *object) {
    cJSON *layers = cJSON_AddArrayToObject(object, "layers"), *views = cJSON_AddArrayToObject(object, "views"),
          *sharp = cJSON_AddArrayToObject(object, "left_sharp");
    char name[512];
    for (int g = 0; g < j->group_count; g++) {
        const char *view = j->group[g].view;
        bool said = !view[0];
        for (int k = 0; k < g; k++) said |= strcmp(j->group[k].view, view) == 0;
        if (!said) cJSON_AddItemToArray(views, json_text_item(view));
        for (int n = 0; n < j->group[g].count; n++) {
            channels_image_name(j->input, &j->group[g].color[n], name, sizeof name);
            cJSON_AddItemToArray(layers, json_text_item(name));
        }
    }
    for (int i = 0; i < j->choice.sharp_count; i++) {
        channels_image_name(j->input, &j->choice.sharp[i], name, sizeof name);
        cJSON_AddItemToArray(sharp, json_text_item(name));
    }
}

static cJSON *report_json(const job *j, const options *o, const session *s, const report *r, double total) {
    cJSON *object = cJSON_CreateObject();
    json_text(object, "input", o->file[0]);
    json_text(object, "output", option_text(o, OPT_OUTPUT));
    if (option_given(o, OPT_PREVIEW)) json_text(object, "preview", option_text(o, OPT_PREVIEW));
    json_integer(object, "width", j->frame.color.width);
    json_integer(object, "height", j->frame.color.height);
    json_integer(object, "channels", j->frame.color.channels);
    add_choice(j, object);
    json_text(object, "backend", backend_name(s->backend));
    json_text(object, "device", r->stats.device);
    json_integer(object, "threads", r->stats.threads);
    add_method(j, o, &r->stats, object);
    json_number(object, "solve_ms", r->time.solve);
    json_number(object, "decode_ms", j->decode_ms);
    json_number(object, "prepare_ms", r->time.prepare);
    json_number(object, "encode_ms", r->time.encode);
    json_number(object, "preview_ms", r->time.preview);
    json_number(object, "total_ms", total);
    json_integer(object, "nonfinite_pixels", (double)r->stats.nonfinite_pixels);
    json_number(object, "focus_distance", r->stats.focus_distance);
    json_number(object, "coc_min_px", r->has_range ? (double)r->coc_low : NAN);
    json_number(object, "coc_max_px", r->has_range ? (double)r->coc_high : NAN);
    if (*j->file.entry) json_text(object, "camera_render", j->file.entry);
    json_integer(object, "scratch_bytes", (double)r->stats.scratch_bytes);
    json_integer(object, "peak_rss_bytes", (double)peak_rss_bytes());
    cJSON_AddBoolToObject(object, "streamed", scratch_streams());
    session_add_gpu(s, object, &j->settings, &r->stats, (double)j->frame.color.width * j->frame.color.height);
    return object;
}

static int report_work(frame_report *made, const job *j, const options *o, const session *s, const report *r, double total) {
    if (option_given(o, OPT_JSON)) {
        made->object = report_json(j, o, s, r, total);
        return made->object ? 0 : fail("--json: out of memory");
    }
    if (option_given(o, OPT_QUIET) || o->frame >= 0) return 0;
    size_t size;
    FILE *out = open_memstream(&made->text, &size);
    if (!out) return fail("%s: out of memory for its report", o->file[0]);
    report_human(out, j, o, s, r, total);
    return fclose(out) == 0 ? 0 : fail("%s: out of memory for its report", o->file[0]);
}

/* ------------------------------------------------------------------------- work */

static void add_stats(ddof_stats *all, const ddof_stats *group) {
    if (group->nonfinite_pixels > all->nonfinite_pixels) all->nonfinite_pixels = group->nonfinite_pixels;
    if (group->scratch_bytes > all->scratch_bytes) all->scratch_bytes = group->scratch_bytes;
    all->sprites += group->sprites;
    all->sprites_dropped += group->sprites_dropped;
    all->sprites_large += group->sprites_large;
}

/* All images that share a depth, in place. The first group says what all of them focus on: the eyes of a pair see one thing. */
static int solve_group(job *j, int index, const options *o, session *s, ddof_stats *all) {
    ddof_frame frame = j->group[index].frame;
    ddof_settings settings = j->settings;
    ddof_stats stats;
    frame.output = frame.color;
    if (index && !frame.coc.channels) {
        settings.lens.focus = DDOF_FOCUS_DISTANCE;
        settings.lens.focus_distance = all->focus_distance;
    }
    ddof_status done = ddof_render(s->context, &frame, &settings, &stats);
    progress_clear();
    if (done != DDOF_OK) return session_fail(s, done, job_blame(o, done));
    if (interrupted()) return fail_interrupted();
    const int64_t pixels = (int64_t)frame.color.width * frame.color.height;
    if (stats.nonfinite_pixels == pixels)
        return fail("%s: no pixel has finite colour and depth; nothing can be rendered", o->file[0]);
    if (index)
        add_stats(all, &stats);
    else
        *all = stats;
    return 0;
}

static int solve(job *j, const options *o, session *s, report *r) {
    const double begin = now_ms();
    int status = 0;
    signals_hold();
    for (int g = 0; g < j->group_count && status == 0; g++) status = solve_group(j, g, o, s, &r->stats);
    r->time.solve = now_ms() - begin;
    if (status) return status;
    bokeh_note(&r->stats, o->file[0]);
    /* of sprites the library warns in its own words, of pixels after that */
    if (r->stats.nonfinite_pixels > 0) session_note(s, o->file[0]);
    job_modified(j);
    return 0;
}

/* "--method none" */
static int leave_sharp(const job *j, report *r) {
    signals_hold();
    r->stats.device = "none";
    job_modified(j);
    return interrupted() ? fail_interrupted() : 0;
}

static int encode(const job *j, const options *o, io_format format, timing *time) {
    const char *path = option_text(o, OPT_OUTPUT);
    const double begin = now_ms();
    io_picture *made = NULL;
    int status = 0;
    if (format != j->input->format) status = output_convert(&made, j->input, &j->color, format, path, &j->reading);
    if (status == 0) status = output_write(made ? made : j->input, path, &j->reading);
    io_close(&made);
    time->encode = now_ms() - begin;
    return status;
}

/* Of a shot nobody is told of it but by --json. */
static bool range_wanted(const options *o) {
    return option_given(o, OPT_JSON) || (!option_given(o, OPT_QUIET) && o->frame < 0);
}

static int work(job *j, const options *o, session *s, io_format format, report *r) {
    io_picture *preview = NULL;
    const double begin = now_ms();
    int status = preview_begin(&preview, j, o);
    r->time.preview = now_ms() - begin;
    if (status == 0) status = method_none(o) ? leave_sharp(j, r) : solve(j, o, s, r);
    if (status == 0 && !method_none(o) && range_wanted(o))
        r->has_range = job_coc_range(j, s, r->stats.focus_distance, &r->coc_low, &r->coc_high);
    /* its files need not reach the disk, and make room for the output */
    if (scratch_streams()) ddof_trim(s->context);
    if (status == 0) status = encode(j, o, format, &r->time);
    if (status == 0) status = preview_end(preview, j, o, &r->time);
    io_close(&preview);
    return status;
}

static int check_outputs(const options *o, io_format *format) {
    const char *path = option_text(o, OPT_OUTPUT), *preview = option_text(o, OPT_PREVIEW);
    int status = output_check(OPT_OUTPUT, path, format);
    if (status || !preview) return status;
    io_format preview_format;
    status = output_check(OPT_PREVIEW, preview, &preview_format);
    if (status == 0 && preview_format != IO_PNG)
        status = fail_usage("--preview: %s: previews are PNG; give it a name that ends in .png", preview);
    if (status == 0 && strcmp(path, preview) == 0)
        status = fail_usage("--preview: %s is the output too; give it a name of its own", preview);
    return status;
}

static int render_frame(const options *o, session *s, double start, frame_report *made) {
    job j;
    report r = {0};
    io_format format;
    int status = check_outputs(o, &format);
    if (status == 0) r.time.prepare = now_ms() - start;
    if (status == 0) status = job_open(&j, o, s, &format);
    if (status) return status;
    status = work(&j, o, s, format, &r);
    if (status == 0) status = report_work(made, &j, o, s, &r, now_ms() - start);
    job_close(&j);
    return status;
}

int command_render(const options *o, double start) {
    return frame_run(o, render_frame, start);
}
