/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "job.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "bokeh.h"
#include "memory.h"
#include "message.h"
#include "metadata.h"
#include "scratch.h"

/* ------------------------------------------------------------------------- files and channels */

int split_channel(const char *option, const char *text, char **file, const char **channel) {
    struct stat info;
    *channel = NULL;
    *file = strdup(text);
    if (!*file) return fail("--%s: out of memory", option);
    if (stat(text, &info) == 0) return 0;
    for (char *colon = *file + strlen(*file); colon-- > *file;) {
        if (*colon != ':') continue;
        *colon = 0;
        if (colon == *file || stat(*file, &info) == 0) {
            *channel = text + (colon - *file) + 1;
            if (**channel) return 0;
            free(*file);
            *file = NULL;
            return fail_usage("--%s: '%s' ends in ':'; name a channel after it or leave it out", option, text);
        }
    }
    free(*file);
    *file = NULL;
    return fail("--%s: %s: no such file; give FILE or FILE:CHANNEL", option, text);
}

const io_part *job_part(const job *j) {
    return &j->input->part[j->color.part];
}

io_channel *job_color(const job *j, int i) {
    return job_image_channel(j, &j->color, i);
}

io_channel *job_image_channel(const job *j, const io_selection *color, int i) {
    return &j->input->part[color->part].channel[color->channel[i]];
}

void job_modified(const job *j) {
    for (int g = 0; g < j->group_count; g++)
        for (int n = 0; n < j->group[g].count; n++)
            for (int i = 0; i < j->group[g].color[n].count; i++) io_channel_modified(job_image_channel(j, &j->group[g].color[n], i));
}

static const io_picture *blur_picture(const job *j) {
    return j->second ? j->second : j->input;
}

io_channel *job_blur_channel(const job *j, const job_group *g) {
    return &blur_picture(j)->part[g->blur.part].channel[g->blur.channel[0]];
}

static const char *blur_option(const options *o) {
    return option_given(o, OPT_COC) ? "coc" : "depth";
}

/* Luma and chroma of different sizes are no linear channels of their own: blurring Y alone would leave the colours
 * sharp. */
static int check_color(const job *j, const io_selection *color) {
    const io_part *part = &j->input->part[color->part];
    for (int i = 0; i < color->count; i++) {
        const io_channel *channel = job_image_channel(j, color, i);
        if (channel->x_sampling != 1 || channel->y_sampling != 1)
            return fail("%s: channel %s is subsampled; convert the picture to R G B first", j->input->path,
                        channel->name);
        if (channel->type == IO_UINT)
            return fail("%s: channel %s holds integers, not colour; choose another with --layer", j->input->path,
                        channel->name);
    }
    if (color->count > 2) return 0;
    for (int i = 0; i < part->channel_count; i++) {
        const char *dot = strrchr(part->channel[i].name, '.'), *name = dot ? dot + 1 : part->channel[i].name;
        if (strcmp(name, "RY") == 0 || strcmp(name, "BY") == 0)
            return fail("%s: has luma and chroma (Y RY BY), not colours; convert the picture to R G B first",
                        j->input->path);
    }
    return 0;
}

static int open_input(job *j, const options *o) {
    io_error error = {0};
    if (io_open(&j->input, o->file[0], IO_COLOR, &j->reading, &error)) return fail("%s", error.text);
    int status = channels_choose(&j->choice, j->input, o);
    if (status) return status;
    j->group = calloc((size_t)j->choice.count, sizeof *j->group);
    if (!j->group) return fail("%s: out of memory for its channels", j->input->path);
    j->group_count = j->choice.count;
    for (int g = 0; g < j->group_count; g++) {
        const channel_group *from = &j->choice.group[g];
        j->group[g] = (job_group){.view = from->view, .count = from->count, .color = from->color};
        for (int n = 0; n < from->count && status == 0; n++) status = check_color(j, &from->color[n]);
    }
    j->color = j->group[0].color[0];
    return status;
}

/* The CoC of a file has no convention for its name but ours. */
static int select_coc(job *j, job_group *g, const char *name, io_error *error) {
    const io_selection *near_color = j->second ? NULL : &g->color[0];
    if (!name && io_select_depth(blur_picture(j), "CoC", near_color, &g->blur, error) == 0) return 0;
    return io_select_depth(blur_picture(j), name, near_color, &g->blur, error);
}

static int select_depth(job *j, job_group *g, const char *name, io_error *error) {
    const io_selection *near_color = j->second ? NULL : &g->color[0];
    /* the camera file's channel is a hint: "Z" there may be "ViewLayer.Depth.Z" in the file */
    if (!name && *j->file.depth_channel &&
        io_select_depth(blur_picture(j), j->file.depth_channel, near_color, &g->blur, error) == 0)
        return 0;
    return io_select_depth(blur_picture(j), name, near_color, &g->blur, error);
}

/* What one view sees lies elsewhere in the other. */
static int check_view(const job *j, const job_group *g, const options *o) {
    const char *what = option_given(o, OPT_COC) ? "CoC" : "depth";
    bool several = false;
    for (int i = 1; i < j->group_count; i++) several |= strcmp(j->group[i].view, j->group[0].view) != 0;
    if (several && option_given(o, OPT_HOLDOUT))
        return fail_usage("--holdout: one mask does not fit several views; render them one by one with --views NAME");
    if (several && j->second)
        return fail_usage("--%s: %s does not fit several views; render them one by one with --views NAME", blur_option(o),
                          j->second->path);
    if (j->second) return 0;
    const char *view = io_channel_view(&j->input->part[g->blur.part], g->blur.channel[0]);
    if (strcmp(view, g->view) == 0 || (!several && !view[0])) return 0;
    return fail("%s: the view '%s' has no %s of its own (there is %s%s%s); leave it out with --views NAME, or give it a file with --%s "
                "FILE",
                j->input->path, g->view, what, job_blur_channel(j, g)->name, view[0] ? " of the view " : "", view, blur_option(o));
}

/* A channel that the blur follows must stay as it is. */
static int check_blur(const job *j, const job_group *g, const options *o) {
    const io_channel *channel = job_blur_channel(j, g);
    for (int k = 0; !j->second && k < j->group_count; k++)
        for (int n = 0; n < j->group[k].count; n++)
            for (int i = 0; i < j->group[k].color[n].count; i++) {
                if (job_image_channel(j, &j->group[k].color[n], i) != channel) continue;
                if (option_given(o, OPT_RENDER_CHANNELS))
                    return fail_usage("--channels: %s is the %s that the blur follows; leave it out", channel->name,
                                      option_given(o, OPT_COC) ? "CoC" : "depth");
                return fail("%s: has no depth beside its colour (channel %s); give --depth FILE or --coc FILE",
                            j->input->path, channel->name);
            }
    if (channel->x_sampling != 1 || channel->y_sampling != 1)
        return fail("--%s: channel %s of %s is subsampled; use a channel of full size", blur_option(o), channel->name,
                    blur_picture(j)->path);
    return check_view(j, g, o);
}

static int open_blur(job *j, const options *o) {
    bool coc = option_given(o, OPT_COC);
    const char *text = option_text(o, coc ? OPT_COC : OPT_DEPTH), *name = NULL;
    io_error error = {0};
    if (text) {
        char *file;
        int status = split_channel(blur_option(o), text, &file, &name);
        if (status) return status;
        int bad = *file ? io_open(&j->second, file, IO_DATA, &j->reading, &error) : 0;
        free(file);
        if (bad) return fail("--%s: %s", blur_option(o), error.text);
    }
    for (int i = 0; i < j->group_count; i++) {
        job_group *g = &j->group[i];
        int bad = coc ? select_coc(j, g, name, &error) : select_depth(j, g, name, &error);
        if (bad && text) return fail("--%s: %s", blur_option(o), error.text);
        if (bad) return fail("%s (--depth FILE[:CHANNEL], or --coc FILE)", error.text);
        int status = check_blur(j, g, o);
        if (status) return status;
    }
    return 0;
}

/* An integer file holds 0..1, which is never a distance by itself. */
static int check_integer_depth(const job *j, const options *o) {
    const io_channel *channel = job_blur_channel(j, &j->group[0]);
    if (!channel->integer || channel->depth.kind != IO_DEPTH_UNSAID || option_given(o, OPT_COC) ||
        option_given(o, OPT_DEPTH_KIND))
        return 0;
    return fail_usage("--depth-kind: missing; %s holds values from 0 to 1: say what they mean with --depth-kind "
                      "normalized or device (disparity), --near Z and --far Z",
                      blur_picture(j)->path);
}

/* What the picture says of its depth, where the camera file says nothing. */
static void take_depth_meaning(job *j) {
    const io_depth *said = &job_blur_channel(j, &j->group[0])->depth;
    if (said->kind == IO_DEPTH_UNSAID || j->file.has_depth_kind) return;
    j->file.has_depth_kind = true;
    j->file.depth_kind = said->kind == IO_DEPTH_LINEAR ? DDOF_DEPTH_NORMALIZED : DDOF_DEPTH_DEVICE;
    j->file.z_at_0 = said->at_0;
    j->file.z_at_1 = said->at_1;
}

/* What a file says and nobody heeds is worth a line. */
static void pass_notes(const job *j) {
    if (*j->input->note.text) note("note: %s", j->input->note.text);
    if (j->second && *j->second->note.text) note("note: %s", j->second->note.text);
}

/* ------------------------------------------------------------------------- one grid */

/* Where a part's pixels lie in its picture. */
static io_box box_in_picture(const io_part *part) {
    io_box box = part->data;
    box.x -= part->display.x;
    box.y -= part->display.y;
    return box;
}

/* The place in the depth's or CoC's channel that belongs to the colour's first pixel. The two agree when they have one
 * size, or when the colour is a window into a picture of which the depth covers more. */
static int align_blur(const job *j, const job_group *g, const options *o, ptrdiff_t *first) {
    const io_part *color = &j->input->part[g->color[0].part], *blur = &blur_picture(j)->part[g->blur.part];
    const io_channel *channel = job_blur_channel(j, g);
    const io_box c = box_in_picture(color), b = box_in_picture(blur);
    const io_channel *picture = job_image_channel(j, &g->color[0], 0);
    *first = 0;
    bool one_display = color->display.width == blur->display.width && color->display.height == blur->display.height;
    bool one_size = channel->width == picture->width && channel->height == picture->height;
    if (one_size && (!one_display || (b.x == c.x && b.y == c.y))) return 0;
    bool covers = b.x <= c.x && b.y <= c.y && b.x + (int64_t)b.width >= c.x + (int64_t)c.width &&
                  b.y + (int64_t)b.height >= c.y + (int64_t)c.height;
    if (one_display && covers) {
        *first = (ptrdiff_t)(c.y - b.y) * channel->width + (c.x - b.x);
        return 0;
    }
    const char *what = option_given(o, OPT_COC) ? "CoC" : "depth";
    if (one_size)
        return fail("%s: its %s lies elsewhere in the picture (data window at %d,%d) than the colour of %s (at %d,%d); "
                    "give a %s of the same place",
                    blur_picture(j)->path, what, b.x, b.y, j->input->path, c.x, c.y, what);
    return fail("%s: its %s is %dx%d, but the colour of %s is %dx%d; give a %s of the same size", blur_picture(j)->path,
                what, channel->width, channel->height, j->input->path, picture->width, picture->height, what);
}

/* ------------------------------------------------------------------------- pixels */

bool job_part_is_blurred(const job *j, int part) {
    for (int g = 0; g < j->group_count; g++)
        for (int n = 0; n < j->group[g].count; n++)
            if (j->group[g].color[n].part == part) return true;
    return false;
}

/* The channels of one part of IN that are blurred, or say how much; a part is written again with all its channels, so then
 * all of them are needed. */
static int read_part(job *j, int part, bool rewrite) {
    io_error error = {0};
    const int most = j->input->part[part].channel_count;
    if (rewrite && job_part_is_blurred(j, part))
        return io_read_channels(j->input, part, NULL, 0, &error) ? fail("%s", error.text) : 0;
    const char **names = calloc((size_t)most, sizeof *names);
    if (!names) return fail("%s: out of memory for its channels", j->input->path);
    int count = 0, status = 0;
    for (int g = 0; g < j->group_count; g++) {
        const job_group *group = &j->group[g];
        for (int n = 0; n < group->count; n++)
            for (int i = 0; i < group->color[n].count && group->color[n].part == part && count < most; i++)
                names[count++] = job_image_channel(j, &group->color[n], i)->name;
        if (!j->second && group->blur.part == part && count < most) names[count++] = job_blur_channel(j, group)->name;
    }
    if (count && io_read_channels(j->input, part, names, count, &error)) status = fail("%s", error.text);
    free(names);
    return status;
}

static int read_pixels(job *j, bool rewrite) {
    io_error error = {0};
    int status = 0;
    for (int p = 0; p < j->input->part_count && status == 0; p++) status = read_part(j, p, rewrite);
    for (int g = 0; g < j->group_count && status == 0 && j->second; g++) {
        const char *name = job_blur_channel(j, &j->group[g])->name;
        if (io_read_channels(j->second, j->group[g].blur.part, &name, 1, &error)) status = fail("%s", error.text);
    }
    return status;
}

const char *job_blame(const options *o, ddof_status status) {
    return status == DDOF_ERROR_INVALID && option_given(o, OPT_FOCUS_AT) ? "--focus-at" : o->file[0];
}

ddof_plane plane_of_channel(const io_channel *channel) {
    return (ddof_plane){.data = channel->data, .type = channel->type == IO_HALF ? DDOF_HALF : DDOF_FLOAT};
}

static ddof_image image_of(const job *j, const io_selection *color) {
    const io_channel *first = job_image_channel(j, color, 0);
    ddof_image image = {.width = first->width, .height = first->height, .channels = color->count};
    for (int i = 0; i < color->count; i++) image.plane[i] = plane_of_channel(job_image_channel(j, color, i));
    return image;
}

static int describe_color(job *j, job_group *g) {
    const io_part *part = &j->input->part[g->color[0].part];
    const io_box box = box_in_picture(part);
    ddof_frame *frame = &g->frame;
    frame->color = image_of(j, &g->color[0]);
    frame->picture_width = part->display.width;
    frame->picture_height = part->display.height;
    frame->offset_x = box.x;
    frame->offset_y = box.y;
    frame->pixel_aspect = part->pixel_aspect;
    if (g->count == 1) return 0;
    g->more = calloc((size_t)g->count - 1, sizeof *g->more);
    if (!g->more) return fail("%s: out of memory for its channels", j->input->path);
    for (int n = 1; n < g->count; n++) g->more[n - 1].color = g->more[n - 1].output = image_of(j, &g->color[n]);
    return 0;
}

static int describe_blur(job *j, job_group *g, const options *o, ptrdiff_t first) {
    const io_channel *channel = job_blur_channel(j, g);
    const size_t count = (size_t)channel->width * (size_t)channel->height;
    const float scale = (float)option_number(o, OPT_COC_SCALE, 1);
    ddof_image image = {.width = g->frame.color.width, .height = g->frame.color.height, .channels = 1};
    image.plane[0] = plane_of_channel(channel);
    if (channel->type == IO_UINT || scale != 1) {
        g->converted = scratch_allocate(count * sizeof(float));
        if (!g->converted) return fail("%s", scratch_error());
        io_channel_to_float(channel, g->converted, 1, (size_t)channel->width);
        for (size_t i = 0; scale != 1 && i < count; i++)
            g->converted[i] *= scale;
        image.plane[0] = (ddof_plane){.data = g->converted};
    }
    const size_t value = image.plane[0].type == DDOF_HALF ? 2 : 4;
    image.plane[0].data = (char *)image.plane[0].data + first * (ptrdiff_t)value;
    image.plane[0].row_stride = (ptrdiff_t)((size_t)channel->width * value);
    *(option_given(o, OPT_COC) ? &g->frame.coc : &g->frame.depth) = image;
    return 0;
}

static int describe_group(job *j, job_group *g, const options *o) {
    ptrdiff_t first;
    int status = align_blur(j, g, o, &first);
    if (status == 0) status = describe_color(j, g);
    if (status == 0) status = describe_blur(j, g, o, first);
    g->frame.more = g->more;
    g->frame.more_count = g->count - 1;
    return status;
}

/* --focus-at is a place in the picture, the library's focus a place in the image. */
static int place_focus(job *j, const options *o) {
    if (!option_given(o, OPT_FOCUS_AT)) return 0;
    const option_value *at = &o->value[OPT_FOCUS_AT];
    const int width = j->frame.picture_width, height = j->frame.picture_height;
    double x = at->percent ? at->number / 100 * width : at->number;
    double y = at->percent_y ? at->number_y / 100 * height : at->number_y;
    /* 100 % is the far edge of the last pixel */
    x = floor(at->percent ? fmin(x, width - 1) : x);
    y = floor(at->percent_y ? fmin(y, height - 1) : y);
    double column = x - j->frame.offset_x, row = y - j->frame.offset_y;
    if (x >= width || y >= height)
        return fail_usage("--focus-at: %s lies outside of %s, which is %dx%d; count from 0,0 at the top left", at->text,
                          j->input->path, width, height);
    if (column < 0 || row < 0 || column >= j->frame.color.width || row >= j->frame.color.height)
        return fail_usage("--focus-at: %s holds no pixel there: its data window is %dx%d at %d,%d", j->input->path,
                          j->frame.color.width, j->frame.color.height, j->frame.offset_x, j->frame.offset_y);
    j->settings.lens.focus_x = (int)column;
    j->settings.lens.focus_y = (int)row;
    return 0;
}

/* ------------------------------------------------------------------------- all of it */

static int read_metadata(job *j, const options *o) {
    metadata m;
    const int status = metadata_find(&m, j->input, j->color.part, o, option_text(o, OPT_METADATA), true);
    if (status == 0) metadata_apply(&j->file, &m, o);
    return status;
}

/* Their headers. */
static int open_files(job *j, const options *o) {
    int status = 0;
    if (option_given(o, OPT_CAMERA))
        status = camera_read(&j->file, option_text(o, OPT_CAMERA), option_text(o, OPT_RENDER), o->file[0]);
    if (status == 0) status = open_input(j, o);
    if (status == 0 && option_given(o, OPT_METADATA)) status = read_metadata(j, o);
    if (status == 0) status = open_blur(j, o);
    if (status == 0) status = check_integer_depth(j, o);
    if (status == 0) take_depth_meaning(j);
    if (status == 0 && !option_given(o, OPT_COC))
        status = lens_settings(&j->settings, o, &j->file, job_part(j)->display.width);
    ptrdiff_t first;
    for (int g = 0; g < j->group_count && status == 0; g++) status = align_blur(j, &j->group[g], o, &first);
    return status;
}

static int open_and_check(job *j, const options *o) {
    int status = lens_check_options(o);
    if (status == 0) status = method_check_options(o);
    if (status == 0) status = bokeh_check_options(o);
    if (status == 0) status = iris_read(&j->iris, option_text(o, OPT_IRIS), &j->reading);
    return status ? status : open_files(j, o);
}

/* Files that are not written again hold one image. */
static int check_images(const job *j, const io_format *rewrite, const options *o) {
    const int count = channels_count(&j->choice);
    if (!rewrite || *rewrite == j->input->format || count == 1) return 0;
    return fail_usage("--output: %s: holds one image, and %d are to be blurred; name an %s, or choose one with --layer",
                      option_text(o, OPT_OUTPUT), count, io_format_name(j->input->format));
}

int job_open(job *j, const options *o, const session *s, const io_format *rewrite) {
    *j = (job){.reading = {.threads = (int)option_number(o, OPT_THREADS, 0), .memory = scratch_memory()}};
    const double begin = now_ms();
    int status = open_and_check(j, o);
    if (status == 0) status = check_images(j, rewrite, o);
    method_settings(&j->settings, o);
    if (status == 0) status = bokeh_settings(&j->settings, o, &j->iris, job_part(j)->display.width);
    if (status == 0) status = memory_plan(j, o, s, rewrite);
    if (status == 0) status = read_pixels(j, rewrite && *rewrite == j->input->format);
    j->decode_ms = now_ms() - begin;
    for (int g = 0; g < j->group_count && status == 0; g++) status = describe_group(j, &j->group[g], o);
    if (status == 0) j->frame = j->group[0].frame;
    if (status == 0) status = place_focus(j, o);
    if (status == 0 && option_given(o, OPT_HOLDOUT)) {
        status = holdout_read(&j->holdout, option_text(o, OPT_HOLDOUT), o->file[0], &j->frame.color, &j->reading);
        for (int g = 0; g < j->group_count; g++) j->group[g].frame.holdout = &j->holdout.image;
        j->frame.holdout = &j->holdout.image;
    }
    if (status == 0) pass_notes(j);
    if (status == 0 && rewrite) channels_note(&j->choice, j->input, o);
    if (status) job_close(j);
    return status;
}

int job_open_depth(job *j, const options *o) {
    *j = (job){.reading.threads = (int)option_number(o, OPT_THREADS, 0)};
    int status = lens_check_options(o);
    if (status == 0) status = open_files(j, o);
    if (status == 0) status = describe_color(j, &j->group[0]);
    if (status == 0) {
        j->frame = j->group[0].frame;
        j->frame.depth = (ddof_image){.width = j->frame.color.width, .height = j->frame.color.height, .channels = 1};
        j->frame.color = (ddof_image){0};
    }
    if (status) job_close(j);
    return status;
}

int job_read_depth(job *j, const options *o, int row, int rows) {
    io_error error = {0};
    ptrdiff_t first = 0;
    job_group *g = &j->group[0];
    int status = align_blur(j, g, o, &first);
    const io_channel *channel = job_blur_channel(j, g);
    const int from = row + (int)(first / channel->width);
    const char *name = channel->name;
    io_picture *picture = j->second ? j->second : j->input;
    if (status == 0 && io_read_rows(picture, g->blur.part, &name, 1, from, rows, &error))
        status = fail("%s", error.text);
    if (status == 0) status = describe_blur(j, g, o, first);
    if (status == 0) j->frame.depth = g->frame.depth;
    return status;
}

void job_close(job *j) {
    io_close(&j->input);
    io_close(&j->second);
    for (int g = 0; g < j->group_count; g++) {
        scratch_release(j->group[g].converted);
        free(j->group[g].more);
    }
    free(j->group);
    channels_free(&j->choice);
    holdout_close(&j->holdout);
    iris_close(&j->iris);
    *j = (job){0};
}

bool job_coc_range(const job *j, session *s, double focus, float *low, float *high) {
    enum { ROWS = 32 };
    const int width = j->frame.color.width, height = j->frame.color.height;
    float *strip = malloc((size_t)width * ROWS * sizeof(float));
    if (!strip) return false;
    ddof_settings settings = j->settings;
    settings.lens.focus = DDOF_FOCUS_DISTANCE; /* the pixel may lie outside the strip */
    settings.lens.focus_distance = focus;
    ddof_image blur = j->frame.coc.channels ? j->frame.coc : j->frame.depth;
    *low = INFINITY;
    *high = -INFINITY;
    for (int y = 0; y < height; y += ROWS) {
        ddof_frame frame = j->frame;
        const int rows = height - y < ROWS ? height - y : ROWS;
        frame.color = (ddof_image){0};
        frame.offset_y += y;
        frame.output = ddof_image_interleaved(strip, width, rows, 1, DDOF_FLOAT, 0);
        blur.height = rows;
        *(j->frame.coc.channels ? &frame.coc : &frame.depth) = blur;
        if (ddof_coc(s->context, &frame, &settings, NULL) != DDOF_OK) break;
        for (size_t i = 0; i < (size_t)width * (size_t)rows; i++) {
            if (!isfinite(strip[i])) continue;
            if (strip[i] < *low) *low = strip[i];
            if (strip[i] > *high) *high = strip[i];
        }
        blur.plane[0].data = (char *)blur.plane[0].data + rows * blur.plane[0].row_stride;
    }
    free(strip);
    return *low <= *high;
}
