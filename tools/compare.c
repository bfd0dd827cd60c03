/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include <math.h>
#include <picture.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "commands.h"
#include "difference.h"
#include "json.h"
#include "message.h"
#include "metrics.h"

typedef struct side {
    io_picture *picture;
    io_selection color;
    float *rgb; /* interleaved */
    int width, height;
} side;

/* ------------------------------------------------------------------------- reading */

static int read_selected(io_picture *picture, const io_selection *selection) {
    const io_part *part = &picture->part[selection->part];
    const char *names[4];
    io_error error = {0};
    for (int i = 0; i < selection->count; i++) {
        const io_channel *channel = &part->channel[selection->channel[i]];
        if (channel->x_sampling != 1 || channel->y_sampling != 1)
            return fail("%s: channel %s is subsampled; convert the picture to R G B first", picture->path,
                        channel->name);
        names[i] = channel->name;
    }
    if (io_read_channels(picture, selection->part, names, selection->count, &error)) return fail("%s", error.text);
    return 0;
}

static int side_open(side *s, const options *o, const char *path, const io_options *reading) {
    io_error error = {0};
    if (io_open(&s->picture, path, IO_COLOR, reading, &error)) return fail("%s", error.text);
    if (io_select_color(s->picture, option_text(o, OPT_LAYER), &s->color, &error)) return fail("%s", error.text);
    const io_part *part = &s->picture->part[s->color.part];
    const io_channel *first = &part->channel[s->color.channel[0]];
    s->width = first->width;
    s->height = first->height;
    return 0;
}

/* One channel is grey: the same in R, G and B. Alpha is not compared. */
static int side_read(side *s) {
    int status = read_selected(s->picture, &s->color);
    if (status) return status;
    s->rgb = malloc((size_t)s->width * (size_t)s->height * 3 * sizeof(float));
    if (!s->rgb) return fail("%s: out of memory for %dx%d pixels", s->picture->path, s->width, s->height);
    const io_part *part = &s->picture->part[s->color.part];
    for (int i = 0; i < 3; i++)
        io_channel_to_float(&part->channel[s->color.channel[s->color.count > 2 ? i : 0]], s->rgb + i, 3,
                            3 * (size_t)s->width);
    return 0;
}

static void side_close(side *s) {
    io_close(&s->picture);
    free(s->rgb);
}

static int check_same_grid(const side *a, const side *b) {
    const io_part *p = &a->picture->part[a->color.part], *q = &b->picture->part[b->color.part];
    if (a->width != b->width || a->height != b->height)
        return fail("%s: is %dx%d, but %s is %dx%d; compare pictures of one size", b->picture->path, b->width,
                    b->height, a->picture->path, a->width, a->height);
    const int dx = q->data.x - q->display.x - (p->data.x - p->display.x);
    const int dy = q->data.y - q->display.y - (p->data.y - p->display.y);
    if (dx || dy)
        return fail("%s: its data window lies %d,%d pixels from that of %s; compare pictures of one place",
                    b->picture->path, dx, dy, a->picture->path);
    return 0;
}

/* true: inside. Colour masks count by their first channel. */
static int read_mask(unsigned char **inside, const char *path, const side *like, const io_options *reading) {
    io_picture *picture = NULL;
    io_selection selection;
    io_error error = {0};
    float *value = NULL;
    const size_t count = (size_t)like->width * (size_t)like->height;
    int status = 0;
    if (io_open(&picture, path, IO_DATA, reading, &error)) return fail("--mask: %s", error.text);
    if (io_select_color(picture, NULL, &selection, &error) && io_select_depth(picture, NULL, NULL, &selection, &error))
        status = fail("--mask: %s", error.text);
    if (status == 0) selection.count = 1;
    const io_channel *channel = status ? NULL : &picture->part[selection.part].channel[selection.channel[0]];
    if (channel && (channel->width != like->width || channel->height != like->height))
        status = fail("--mask: %s is %dx%d, but the pictures are %dx%d; give a mask of the same size", path,
                      channel->width, channel->height, like->width, like->height);
    if (status == 0) status = read_selected(picture, &selection);
    if (status == 0) value = malloc(count * sizeof(float));
    if (status == 0) *inside = malloc(count);
    if (status == 0 && (!value || !*inside)) status = fail("--mask: %s: out of memory", path);
    if (status == 0) {
        io_channel_to_float(channel, value, 1, (size_t)like->width);
        for (size_t i = 0; i < count; i++)
            (*inside)[i] = value[i] >= 0.5f;
    }
    free(value);
    io_close(&picture);
    return status;
}

/* ------------------------------------------------------------------------- measuring */

typedef struct region {
    const char *name;
    metrics_result result;
} region;

typedef struct comparison {
    region region[3]; /* all, inside, outside */
    int regions;
} comparison;

static int measure(comparison *c, const side *a, const side *b, unsigned char *inside) {
    static const char *const names[] = {"all", "inside", "outside"};
    const size_t count = (size_t)a->width * (size_t)a->height;
    c->regions = inside ? 3 : 1;
    for (int r = 0; r < c->regions; r++) {
        for (size_t i = 0; r == 2 && i < count; i++)
            inside[i] = !inside[i];
        c->region[r].name = names[r];
        if (metrics_compare(&c->region[r].result, a->rgb, b->rgb, a->width, a->height, r > 0 ? inside : NULL))
            return fail("%s: out of memory to compare %dx%d pixels", a->picture->path, a->width, a->height);
    }
    const metrics_result *all = &c->region[0].result;
    if (all->pixels == 0)
        return fail("%s: no pixel is finite in both pictures; there is nothing to compare", b->picture->path);
    if (all->nonfinite)
        note("note: %zu pixels are NaN or infinite in %s or %s and do not count", all->nonfinite, a->picture->path,
             b->picture->path);
    return 0;
}

/* ------------------------------------------------------------------------- report */

/* Equal pictures have no finite PSNR; a number is kinder to those who compare it with a threshold. */
static double limited(double psnr) {
    return psnr > 999 ? 999 : psnr; /* NaN, where nothing was counted, stays NaN */
}

static void add_result(cJSON *object, const metrics_result *result) {
    json_number(object, "psnr", limited(result->psnr));
    json_number(object, "ssim", result->ssim);
    json_number(object, "psnr_tonemapped", limited(result->psnr_tonemapped));
    json_number(object, "ssim_tonemapped", result->ssim_tonemapped);
    json_number(object, "max_error", result->max_error);
    json_integer(object, "pixels", (double)result->pixels);
    json_integer(object, "nonfinite_pixels", (double)result->nonfinite);
}

static int report_json(const comparison *c, const options *o) {
    cJSON *object = cJSON_CreateObject();
    json_text(object, "a", o->file[0]);
    json_text(object, "b", o->file[1]);
    if (option_given(o, OPT_OUTPUT)) json_text(object, "output", option_text(o, OPT_OUTPUT));
    add_result(object, &c->region[0].result);
    if (c->regions > 1) {
        cJSON *list = cJSON_CreateArray();
        for (int r = 1; r < c->regions; r++) {
            cJSON *item = cJSON_CreateObject();
            json_text(item, "name", c->region[r].name);
            add_result(item, &c->region[r].result);
            cJSON_AddItemToArray(list, item);
        }
        cJSON_AddItemToObject(object, "regions", list);
    }
    return json_finish(object);
}

static int report_human(const comparison *c) {
    printf("%-8s %10s %8s %8s %14s %14s %10s\n", "", "pixels", "PSNR", "SSIM", "PSNR tone-map", "SSIM tone-map",
           "max error");
    for (int r = 0; r < c->regions; r++) {
        const metrics_result *m = &c->region[r].result;
        printf("%-8s %10zu %8.2f %8.4f %14.2f %14.4f %10.4g\n", c->region[r].name, m->pixels, limited(m->psnr), m->ssim,
               limited(m->psnr_tonemapped), m->ssim_tonemapped, m->max_error);
    }
    return finish_output();
}

int command_compare(const options *o) {
    const io_options reading = {.threads = (int)option_number(o, OPT_THREADS, 0)};
    side a = {0}, b = {0};
    unsigned char *inside = NULL;
    comparison found = {0};
    int status = difference_check(o);
    if (status == 0) status = side_open(&a, o, o->file[0], &reading);
    if (status == 0) status = side_open(&b, o, o->file[1], &reading);
    if (status == 0) status = check_same_grid(&a, &b);
    if (status == 0 && option_given(o, OPT_MASK)) status = read_mask(&inside, option_text(o, OPT_MASK), &a, &reading);
    if (status == 0) status = side_read(&a);
    if (status == 0) status = side_read(&b);
    if (status == 0) status = measure(&found, &a, &b, inside);
    if (status == 0 && option_given(o, OPT_OUTPUT))
        status = difference_write(o, &a.picture->part[a.color.part], a.rgb, b.rgb, &reading);
    if (status == 0 && option_given(o, OPT_JSON))
        status = report_json(&found, o);
    else if (status == 0 && !option_given(o, OPT_QUIET))
        status = report_human(&found);
    side_close(&a);
    side_close(&b);
    free(inside);
    return status;
}
