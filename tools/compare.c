/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include <math.h>
#include <picture.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "commands.h"
#include "difference.h"
#include "flip.h"
#include "job.h"
#include "json.h"
#include "message.h"
#include "metrics.h"
#include "regions.h"

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

/* ------------------------------------------------------------------------- regions */

typedef struct region {
    const char *name, *key; /* for people, in JSON */
    unsigned char *inside;  /* NULL: everywhere */
    metrics_result result;
    double flip, flip_hdr;
} region;

typedef struct comparison {
    region region[4]; /* all; inside and outside of a mask, or the three of regions.h */
    int regions;
    flip_exposures exposures;
} comparison;

static int add_region(comparison *c, const char *name, const char *key, size_t pixels) {
    region *r = &c->region[c->regions++];
    *r = (region){.name = name, .key = key, .inside = malloc(pixels)};
    return r->inside ? 0 : fail("out of memory for %zu pixels", pixels);
}

typedef struct map {
    io_picture *picture;
    io_selection selection;
    float *value;
} map;

/* The values of one channel of a file that is no picture to compare, as large as the pictures. select: finds it. */
static int map_read(map *m, const char *option, const char *path, const char *channel_name, const side *like,
                    const io_options *reading,
                    int (*select)(const io_picture *, const char *, io_selection *, io_error *)) {
    io_error error = {0};
    const size_t count = (size_t)like->width * (size_t)like->height;
    if (io_open(&m->picture, path, IO_DATA, reading, &error)) return fail("--%s: %s", option, error.text);
    if (select(m->picture, channel_name, &m->selection, &error)) return fail("--%s: %s", option, error.text);
    m->selection.count = 1;
    const io_channel *channel = &m->picture->part[m->selection.part].channel[m->selection.channel[0]];
    if (channel->width != like->width || channel->height != like->height)
        return fail("--%s: %s is %dx%d, but the pictures are %dx%d; give one of the same size", option, path,
                    channel->width, channel->height, like->width, like->height);
    const int status = read_selected(m->picture, &m->selection);
    if (status) return status;
    m->value = malloc(count * sizeof(float));
    if (!m->value) return fail("--%s: %s: out of memory", option, path);
    io_channel_to_float(channel, m->value, 1, (size_t)like->width);
    return 0;
}

static void map_close(map *m) {
    io_close(&m->picture);
    free(m->value);
}

/* Colour masks count by their first channel. */
static int select_mask(const io_picture *picture, const char *name, io_selection *selection, io_error *error) {
    (void)name;
    return io_select_color(picture, NULL, selection, error) && io_select_depth(picture, NULL, NULL, selection, error);
}

static int select_coc(const io_picture *picture, const char *name, io_selection *selection, io_error *error) {
    if (!name && io_select_depth(picture, "CoC", NULL, selection, error) == 0) return 0;
    return io_select_depth(picture, name, NULL, selection, error);
}

static int divide_by_mask(comparison *c, const char *path, const side *like, const io_options *reading) {
    map m = {0};
    const size_t count = (size_t)like->width * (size_t)like->height;
    int status = map_read(&m, "mask", path, NULL, like, reading, select_mask);
    if (status == 0) status = add_region(c, "inside", "inside", count);
    if (status == 0) status = add_region(c, "outside", "outside", count);
    for (size_t i = 0; status == 0 && i < count; i++) {
        c->region[1].inside[i] = m.value[i] >= 0.5f;
        c->region[2].inside[i] = !c->region[1].inside[i];
    }
    map_close(&m);
    return status;
}

static int divide_by_coc(comparison *c, const char *text, const side *like, const io_options *reading) {
    static const char *const names[REGION_COUNT][2] = {[REGION_IN_FOCUS] = {"in focus", "in_focus"},
                                                       [REGION_DEFOCUSED] = {"defocused", "defocused"},
                                                       [REGION_SILHOUETTE] = {"silhouette", "silhouette"}};
    map m = {0};
    char *file = NULL;
    const char *name = NULL;
    const size_t count = (size_t)like->width * (size_t)like->height;
    unsigned char *kind = malloc(count);
    int status = kind ? split_channel("coc", text, &file, &name) : fail("--coc: out of memory for %zu pixels", count);
    if (status == 0 && !*file) status = fail_usage("--coc: %s: the file's name is missing; write FILE:CHANNEL", text);
    if (status == 0) status = map_read(&m, "coc", file, name, like, reading, select_coc);
    if (status == 0 && regions_divide(kind, m.value, like->width, like->height))
        status = fail("--coc: %s: out of memory", file);
    for (int r = 1; status == 0 && r < REGION_COUNT; r++) {
        status = add_region(c, names[r][0], names[r][1], count);
        for (size_t i = 0; status == 0 && i < count; i++)
            c->region[r].inside[i] = kind[i] == r;
    }
    map_close(&m);
    free(kind);
    free(file);
    return status;
}

static int divide(comparison *c, const options *o, const side *like, const io_options *reading) {
    c->region[0] = (region){.name = "all", .key = "all"};
    c->regions = 1;
    if (option_given(o, OPT_MASK)) return divide_by_mask(c, option_text(o, OPT_MASK), like, reading);
    if (option_given(o, OPT_COMPARE_COC)) return divide_by_coc(c, option_text(o, OPT_COMPARE_COC), like, reading);
    return 0;
}

/* ------------------------------------------------------------------------- measuring */

/* B is the reference, whose light chooses HDR-FLIP's exposures. */
static int measure_flip(comparison *c, const options *o, const side *a, const side *b) {
    const int threads = (int)option_number(o, OPT_THREADS, 0);
    const flip_view view = {.ppd = option_number(o, OPT_PPD, FLIP_PPD),
                            .tone = FLIP_COMPACT,
                            .threads = threads > 0 ? threads : (int)sysconf(_SC_NPROCESSORS_ONLN)};
    const int width = a->width, height = a->height;
    float *error = malloc((size_t)width * (size_t)height * sizeof *error);
    int status = !error || flip_ldr(error, a->rgb, b->rgb, width, height, &view);
    for (int r = 0; !status && r < c->regions; r++)
        c->region[r].flip = flip_mean(error, c->region[r].inside, width, height);
    status = status || flip_hdr(error, a->rgb, b->rgb, width, height, &view, &c->exposures);
    for (int r = 0; !status && r < c->regions; r++)
        c->region[r].flip_hdr = flip_mean(error, c->region[r].inside, width, height);
    free(error);
    return status;
}

static int measure(comparison *c, const options *o, const side *a, const side *b) {
    int status = 0;
    for (int r = 0; r < c->regions && !status; r++)
        status = metrics_compare(&c->region[r].result, a->rgb, b->rgb, a->width, a->height, c->region[r].inside);
    const metrics_result *all = &c->region[0].result;
    if (!status && all->pixels == 0)
        return fail("%s: no pixel is finite in both pictures; there is nothing to compare", b->picture->path);
    if (status || measure_flip(c, o, a, b))
        return fail("%s: out of memory to compare %dx%d pixels", a->picture->path, a->width, a->height);
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

static void add_result(cJSON *object, const region *r) {
    const metrics_result *result = &r->result;
    json_number(object, "psnr", limited(result->psnr));
    json_number(object, "ssim", result->ssim);
    json_number(object, "psnr_tonemapped", limited(result->psnr_tonemapped));
    json_number(object, "ssim_tonemapped", result->ssim_tonemapped);
    json_number(object, "flip", r->flip);
    json_number(object, "flip_hdr", r->flip_hdr);
    json_number(object, "max_error", result->max_error);
    json_integer(object, "pixels", (double)result->pixels);
    json_integer(object, "nonfinite_pixels", (double)result->nonfinite);
}

static int report_json(const comparison *c, const options *o) {
    cJSON *object = cJSON_CreateObject();
    json_text(object, "a", o->file[0]);
    json_text(object, "b", o->file[1]);
    if (option_given(o, OPT_OUTPUT)) json_text(object, "output", option_text(o, OPT_OUTPUT));
    add_result(object, &c->region[0]);
    json_number(object, "ppd", option_number(o, OPT_PPD, FLIP_PPD));
    json_number(object, "flip_hdr_start", c->exposures.start);
    json_number(object, "flip_hdr_stop", c->exposures.stop);
    json_integer(object, "flip_hdr_exposures", c->exposures.count);
    const bool named = option_given(o, OPT_COMPARE_COC); /* a mask's regions are a list */
    cJSON *regions = named ? cJSON_CreateObject() : cJSON_CreateArray();
    for (int r = 1; r < c->regions; r++) {
        cJSON *item = cJSON_CreateObject();
        if (!named) json_text(item, "name", c->region[r].key);
        add_result(item, &c->region[r]);
        if (named)
            cJSON_AddItemToObject(regions, c->region[r].key, item);
        else
            cJSON_AddItemToArray(regions, item);
    }
    if (c->regions > 1)
        cJSON_AddItemToObject(object, "regions", regions);
    else
        cJSON_Delete(regions);
    return json_finish(object);
}

static int report_human(const comparison *c) {
    printf("%-10s %10s %8s %8s %14s %14s %8s %8s %10s\n", "", "pixels", "PSNR", "SSIM", "PSNR tone-map",
           "SSIM tone-map", "FLIP", "HDR-FLIP", "max error");
    for (int i = 0; i < c->regions; i++) {
        const region *r = &c->region[i];
        const metrics_result *m = &r->result;
        printf("%-10s %10zu %8.2f %8.4f %14.2f %14.4f %8.4f %8.4f %10.4g\n", r->name, m->pixels, limited(m->psnr),
               m->ssim, limited(m->psnr_tonemapped), m->ssim_tonemapped, r->flip, r->flip_hdr, m->max_error);
    }
    return finish_output();
}

int command_compare(const options *o) {
    const io_options reading = {.threads = (int)option_number(o, OPT_THREADS, 0)};
    side a = {0}, b = {0};
    comparison found = {0};
    int status = difference_check(o);
    if (status == 0 && option_given(o, OPT_MASK) && option_given(o, OPT_COMPARE_COC))
        status = fail_usage("--coc: cannot be given with --mask; both divide the picture, give one of them");
    if (status == 0) status = side_open(&a, o, o->file[0], &reading);
    if (status == 0) status = side_open(&b, o, o->file[1], &reading);
    if (status == 0) status = check_same_grid(&a, &b);
    if (status == 0) status = divide(&found, o, &a, &reading);
    if (status == 0) status = side_read(&a);
    if (status == 0) status = side_read(&b);
    if (status == 0) status = measure(&found, o, &a, &b);
    if (status == 0 && option_given(o, OPT_OUTPUT))
        status = difference_write(o, &a.picture->part[a.color.part], a.rgb, b.rgb, &reading);
    if (status == 0 && option_given(o, OPT_JSON))
        status = report_json(&found, o);
    else if (status == 0 && !option_given(o, OPT_QUIET))
        status = report_human(&found);
    side_close(&a);
    side_close(&b);
    for (int r = 1; r < found.regions; r++)
        free(found.region[r].inside);
    return status;
}
