/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "commands.h"
#include "frame.h"
#include "job.h"
#include "json.h"
#include "message.h"
#include "output.h"
#include "scratch.h"

typedef struct summary {
    float low, high; /* pixels, of the finite values */
    size_t in_focus; /* pixels with |CoC| < 1 */
    size_t counted;  /* finite pixels */
    ddof_stats stats;
} summary;

static void summarise(const float *coc, size_t count, summary *s) {
    s->low = INFINITY;
    s->high = -INFINITY;
    for (size_t i = 0; i < count; i++) {
        if (!isfinite(coc[i])) continue;
        s->counted++;
        s->in_focus += fabsf(coc[i]) < 1;
        s->low = fminf(s->low, coc[i]);
        s->high = fmaxf(s->high, coc[i]);
    }
}

/* ------------------------------------------------------------------------- as values */

static int write_values(const job *j, const char *path, io_format format, const float *coc) {
    static const char *const exr_name[] = {"CoC"}, *const grey_name[] = {"Y"};
    const io_part *part = job_part(j);
    const int width = j->frame.color.width, height = j->frame.color.height;
    io_picture *made;
    io_error error = {0};
    if (io_create_in(&made, format, width, height, format == IO_EXR ? exr_name : grey_name, 1, IO_FLOAT, 32, IO_DATA,
                     j->reading.memory, &error))
        return fail("%s: %s", path, error.text);
    if (format == IO_EXR) {
        made->part[0].data = part->data;
        made->part[0].display = part->display;
        made->part[0].pixel_aspect = part->pixel_aspect;
    }
    io_channel_from_float(&made->part[0].channel[0], coc, 1, (size_t)width);
    int status = output_write(made, path, &j->reading);
    io_close(&made);
    return status;
}

/* ------------------------------------------------------------------------- as false colour */

/* Near orange, far blue, stronger with the blur; |CoC| < 1 greenish; holes magenta. On the picture's luminance, which
 * is compressed to leave the tints room. */
static void false_color(float coc, float luminance, float largest, float rgb[3]) {
    static const float near_tint[3] = {1, 0.22f, 0.02f}, far_tint[3] = {0.03f, 0.2f, 1},
                       focus_tint[3] = {0.5f, 1, 0.5f};
    const float light = isfinite(luminance) && luminance > 0 ? luminance / (1 + luminance) : 0;
    const float size = fabsf(coc);
    if (!isfinite(coc)) {
        rgb[0] = rgb[2] = 0.8f;
        rgb[1] = 0;
        return;
    }
    const float *tint = size < 1 ? focus_tint : coc < 0 ? near_tint : far_tint;
    /* the square root keeps small blurs visible beside large ones */
    const float strength = size < 1 ? 0.5f : 0.35f + 0.6f * sqrtf(size / fmaxf(largest, 1));
    for (int i = 0; i < 3; i++)
        rgb[i] = light * (1 - strength) + strength * tint[i] * (0.08f + 0.92f * light);
}

/* Of row y; `room`: another one. */
static void luminance_row(const job *j, int y, float gain, float *luminance, float *room) {
    static const float weights[3] = {0.2126f, 0.7152f, 0.0722f}; /* Rec. 709 */
    const size_t width = (size_t)j->frame.color.width;
    const int channels = j->color.count > 2 ? 3 : 1;
    memset(luminance, 0, width * sizeof(float));
    for (int c = 0; c < channels; c++) {
        const float weight = gain * (channels == 3 ? weights[c] : 1);
        output_load_row(job_color(j, c), y, room);
        for (size_t i = 0; i < width; i++)
            luminance[i] += weight * room[i];
    }
}

static void false_color_row(const float *coc, const float *luminance, float largest, int c, size_t width, float *row) {
    for (size_t i = 0; i < width; i++) {
        float rgb[3];
        false_color(coc[i], luminance[i], largest, rgb);
        row[i] = rgb[c];
    }
}

static int write_false_color(const job *j, const options *o, const char *path, const float *coc, const summary *s) {
    const io_part *part = job_part(j);
    const int width = j->frame.color.width, height = j->frame.color.height;
    const float largest = fmaxf(fabsf(s->low), fabsf(s->high)), gain = exp2f((float)option_number(o, OPT_EXPOSURE, 0));
    io_picture *made = NULL;
    float *luminance = malloc(2 * (size_t)width * sizeof(float)), *row = luminance + width;
    int status = luminance ? 0 : fail("%s: out of memory for a row of %d pixels", path, width);
    if (status == 0) status = output_create_rgb(&made, part->display.width, part->display.height, path, &j->reading);
    for (int y = 0; status == 0 && y < height; y++) {
        luminance_row(j, y, gain, luminance, row);
        const io_box box = {j->frame.offset_x, j->frame.offset_y + y, width, 1};
        for (int c = 0; c < 3; c++) {
            false_color_row(coc + (size_t)y * (size_t)width, luminance, largest, c, (size_t)width, row);
            output_place(&made->part[0].channel[c], row, box);
        }
    }
    if (status == 0) status = output_write(made, path, &j->reading);
    io_close(&made);
    free(luminance);
    return status;
}

/* ------------------------------------------------------------------------- report */

static cJSON *report_json(const job *j, const options *o, const summary *s, double share) {
    cJSON *object = cJSON_CreateObject();
    json_text(object, "input", o->file[0]);
    json_text(object, "output", option_text(o, OPT_OUTPUT));
    json_integer(object, "width", j->frame.color.width);
    json_integer(object, "height", j->frame.color.height);
    json_number(object, "coc_min_px", (double)s->low);
    json_number(object, "coc_max_px", (double)s->high);
    json_number(object, "in_focus_fraction", share);
    json_number(object, "focus_distance", s->stats.focus_distance);
    json_integer(object, "nonfinite_pixels", (double)s->stats.nonfinite_pixels);
    if (*j->file.entry) json_text(object, "camera_render", j->file.entry);
    return object;
}

static int report(frame_report *made, const job *j, const options *o, const summary *s) {
    const double share = s->counted ? (double)s->in_focus / (double)s->counted : 0;
    char focus[48] = "";
    if (option_given(o, OPT_JSON)) {
        made->object = report_json(j, o, s, share);
        return made->object ? 0 : fail("--json: out of memory");
    }
    if (option_given(o, OPT_QUIET)) return 0;
    if (!j->frame.coc.channels) snprintf(focus, sizeof focus, ", focus %.4g", s->stats.focus_distance);
    if (asprintf(&made->text, "%s: CoC %.2f to %.2f px, %.1f %% in focus (below 1 px)%s\n", option_text(o, OPT_OUTPUT),
                 (double)s->low, (double)s->high, 100 * share, focus) >= 0)
        return 0;
    made->text = NULL;
    return fail("%s: out of memory for its report", o->file[0]);
}

static int work(const job *j, const options *o, session *s, io_format format, float *coc, frame_report *made) {
    const char *path = option_text(o, OPT_OUTPUT);
    const int width = j->frame.color.width, height = j->frame.color.height;
    ddof_frame frame = j->frame;
    frame.color = (ddof_image){0};
    frame.output = ddof_image_interleaved(coc, width, height, 1, DDOF_FLOAT, 0);
    summary found = {0};
    signals_hold();
    ddof_status done = ddof_coc(s->context, &frame, &j->settings, &found.stats);
    if (done != DDOF_OK) return session_fail(s, done, job_blame(o, done));
    if (interrupted()) return fail_interrupted();
    summarise(coc, (size_t)width * (size_t)height, &found);
    if (found.counted == 0) return fail("%s: no pixel has finite depth; there is no CoC", o->file[0]);
    session_note(s, o->file[0]);
    int status = format == IO_PNG ? write_false_color(j, o, path, coc, &found) : write_values(j, path, format, coc);
    return status ? status : report(made, j, o, &found);
}

static int coc_frame(const options *o, session *s, double start, frame_report *made) {
    (void)start;
    job j;
    io_format format;
    int status = output_check(OPT_OUTPUT, option_text(o, OPT_OUTPUT), &format);
    if (status == 0) status = job_open(&j, o, s, NULL);
    if (status) return status;
    float *coc = scratch_allocate((size_t)j.frame.color.width * (size_t)j.frame.color.height * sizeof(float));
    if (!coc) status = fail("%s", scratch_error());
    if (status == 0) status = work(&j, o, s, format, coc, made);
    scratch_release(coc);
    job_close(&j);
    return status;
}

int command_coc(const options *o, double start) {
    return frame_run(o, coc_frame, start);
}
