/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "autofocus.h"

#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "job.h"
#include "message.h"

enum { BUCKETS = 1024 };

/* X,Y,WxH: pixels or percent of the picture, each as written. */
typedef struct region {
    double number[4];
    bool percent[4];
} region;

/* What was found in one frame. */
typedef struct found {
    struct found *next; /* of its bucket */
    int frame;
    enum { UNDER_WAY, MEASURED, FAILED } state;
    bool any;        /* there is a pixel with depth in the region */
    double dioptres; /* 1/m */
    double unit;     /* millimetres in one unit of the frame's depth */
} found;

struct autofocus {
    const options *o;
    const sequence *frames; /* NULL: one picture */
    const animation *keys;
    region region;
    int reach; /* frames on either side */
    ddof_context *context;
    pthread_mutex_t mutex, context_mutex; /* of the buckets; of the context */
    pthread_cond_t changed;
    found *bucket[BUCKETS];
};

/* ------------------------------------------------------------------------- the region */

static int read_region(region *r, const char *text) {
    const char separator[] = {',', ',', 'x', 0}, *at = text;
    const option_spec *spec = &option_table[OPT_AUTOFOCUS];
    for (int i = 0; i < 4; i++) {
        const char *end = separator[i] ? strchr(at, separator[i]) : at + strlen(at);
        if (!end || !read_extent(at, end, &r->number[i], &r->percent[i]))
            return fail_usage("--%s: '%s' is not X,Y,WxH; write it like --%s %s", spec->name, text, spec->name, spec->example);
        const double most = r->percent[i] ? 100 : 1 << 20;
        if (r->number[i] < 0 || r->number[i] > most || (i >= 2 && r->number[i] == 0))
            return fail_usage(
                "--%s: '%.*s' in %s is out of range; places are 0 and more, sizes above 0, and the picture ends at 100%%",
                spec->name, (int)(end - at), at, text);
        at = end + 1;
    }
    return 0;
}

/* Its pixels in a picture: whatever it touches. Empty where it lies outside. */
static io_box place_region(const region *r, int width, int height) {
    double value[4];
    for (int i = 0; i < 4; i++)
        value[i] = r->percent[i] ? r->number[i] / 100 * (i % 2 ? height : width) : r->number[i];
    const double right = fmin(ceil(value[0] + value[2]), width), bottom = fmin(ceil(value[1] + value[3]), height);
    const double left = floor(value[0]), top = floor(value[1]);
    if (right <= left || bottom <= top) return (io_box){0};
    return (io_box){(int)left, (int)top, (int)(right - left), (int)(bottom - top)};
}

/* What of it lies in the image, from whose first pixel it is counted then. */
static io_box cut_region(io_box box, const ddof_frame *frame) {
    const int64_t x = (int64_t)box.x - frame->offset_x, y = (int64_t)box.y - frame->offset_y;
    const int64_t left = x > 0 ? x : 0, top = y > 0 ? y : 0;
    const int64_t right = x + box.width < frame->depth.width ? x + box.width : frame->depth.width;
    const int64_t bottom = y + box.height < frame->depth.height ? y + box.height : frame->depth.height;
    if (right <= left || bottom <= top) return (io_box){0};
    return (io_box){(int)left, (int)top, (int)(right - left), (int)(bottom - top)};
}

/* ------------------------------------------------------------------------- the median */

/* The value of given rank (from 0) of numbers that are not negative: their bits have the order of the numbers. */
static float of_rank(const float *value, size_t count, size_t rank) {
    static const int shifts[] = {16, 0};
    size_t *histogram = calloc(1 << 16, sizeof *histogram);
    uint32_t high = 0;
    if (!histogram) return NAN;
    for (int pass = 0; pass < 2; pass++) {
        for (size_t i = 0; i < count; i++) {
            uint32_t bits;
            memcpy(&bits, &value[i], sizeof bits);
            if (pass == 0 || bits >> 16 == high) histogram[bits >> shifts[pass] & 0xffff]++;
        }
        uint32_t place = 0;
        while (rank >= histogram[place])
            rank -= histogram[place++];
        high = high << 16 | place;
        memset(histogram, 0, (1 << 16) * sizeof *histogram);
    }
    free(histogram);
    float result;
    memcpy(&result, &high, sizeof result);
    return result;
}

static double median(const float *value, size_t count) {
    return ((double)of_rank(value, count, (count - 1) / 2) + (double)of_rank(value, count, count / 2)) / 2;
}

/* ------------------------------------------------------------------------- one frame */

/* The library's CoC of a lens that is focused at infinity is proportional to 1/z, whatever the depth means; of this f-number,
 * it is that in 1/m. */
static void dioptre_lens(ddof_settings *settings, const ddof_frame *frame) {
    const ddof_lens given = settings->lens;
    const double focal = given.focal_length > 0 ? given.focal_length : 50;
    settings->lens = (ddof_lens){.focal_length = focal,
                                 .f_number = focal * focal * frame->picture_width / (1000 * given.sensor_width),
                                 .sensor_width = given.sensor_width,
                                 .unit = given.unit,
                                 .focus_distance = INFINITY};
}

static int read_dioptres(autofocus *a, const job *j, io_box box, float *dioptres, size_t *count) {
    ddof_frame frame = j->frame;
    ddof_settings settings = j->settings;
    ddof_plane *plane = &frame.depth.plane[0];
    const size_t all = (size_t)box.width * (size_t)box.height;
    dioptre_lens(&settings, &frame);
    frame.depth.width = box.width;
    frame.depth.height = box.height;
    frame.offset_x += box.x;
    frame.offset_y += box.y;
    plane->data = (char *)plane->data + box.y * plane->row_stride + box.x * (plane->type == DDOF_HALF ? 2 : 4);
    frame.output = ddof_image_interleaved(dioptres, box.width, box.height, 1, DDOF_FLOAT, 0);
    pthread_mutex_lock(&a->context_mutex);
    const ddof_status done = ddof_coc(a->context, &frame, &settings, NULL);
    const int status = done == DDOF_OK ? 0 : fail("--autofocus: %s: %s", j->input->path, ddof_error(a->context));
    pthread_mutex_unlock(&a->context_mutex);
    for (size_t i = 0; status == 0 && i < all; i++) /* all are nearer than the focus, so negative */
        if (!isnan(dioptres[i])) dioptres[(*count)++] = fabsf(dioptres[i]);
    return status;
}

static int measure_job(autofocus *a, job *j, const options *o, found *f) {
    const int width = j->frame.picture_width, height = j->frame.picture_height;
    const io_box box = place_region(&a->region, width, height);
    if (box.width == 0)
        return fail_usage("--autofocus: %s lies outside of %s, which is %dx%d; count from 0,0 at the top left",
                          option_text(a->o, OPT_AUTOFOCUS), j->input->path, width, height);
    f->unit = j->settings.lens.unit;
    const io_box inside = cut_region(box, &j->frame);
    if (inside.width == 0) return 0;
    int status = job_read_depth(j, o, inside.y, inside.height);
    if (status) return status;
    float *dioptres = malloc((size_t)inside.width * (size_t)inside.height * sizeof *dioptres);
    if (!dioptres) return fail("--autofocus: %s: out of memory for %dx%d pixels", j->input->path, inside.width, inside.height);
    size_t count = 0;
    status = read_dioptres(a, j, inside, dioptres, &count);
    f->any = count > 0;
    if (status == 0 && f->any) f->dioptres = median(dioptres, count);
    free(dioptres);
    return status || !isnan(f->dioptres) ? status : fail("--autofocus: %s: out of memory for a median", j->input->path);
}

/* `own`: the options of this frame when they are at hand. A frame whose file is not there has nothing to measure. */
static int measure(autofocus *a, const frame_options *own, found *f) {
    frame_options made = {.count = 0};
    int status = 0;
    job j;
    if (!own) {
        char *file = sequence_file(a->frames, f->frame);
        const bool there = file && file_exists(file);
        free(file);
        if (!there) return 0;
        status = frame_options_make(&made, a->o, a->frames, f->frame);
        if (status == 0 && a->keys) status = animation_apply(a->keys, &made, f->frame);
    }
    const options *o = own ? &own->o : &made.o;
    if (status == 0) status = job_open_depth(&j, o);
    if (status == 0) {
        status = measure_job(a, &j, o, f);
        job_close(&j);
    }
    frame_options_free(&made);
    return status;
}

/* ------------------------------------------------------------------------- of all frames, once */

/* Called with the mutex. */
static found *find(autofocus *a, int frame) {
    found *f = a->bucket[(unsigned)frame % BUCKETS];
    while (f && f->frame != frame)
        f = f->next;
    return f;
}

/* Called with the mutex. A frame that failed is measured again by whoever needs it: each says why it cannot be. */
static int measured(autofocus *a, const frame_options *own, int frame, const found **result) {
    found *f = find(a, frame);
    while (f && f->state == UNDER_WAY)
        pthread_cond_wait(&a->changed, &a->mutex);
    *result = f;
    if (f && f->state == MEASURED) return 0;
    if (!f) {
        f = calloc(1, sizeof *f);
        if (!f) return fail("--autofocus: out of memory");
        f->frame = frame;
        f->next = a->bucket[(unsigned)frame % BUCKETS];
        a->bucket[(unsigned)frame % BUCKETS] = f;
    }
    f->state = UNDER_WAY;
    pthread_mutex_unlock(&a->mutex);
    const int status = measure(a, own, f);
    pthread_mutex_lock(&a->mutex);
    f->state = status ? FAILED : MEASURED;
    pthread_cond_broadcast(&a->changed);
    *result = f;
    return status;
}

/* Weights fall evenly to either side: 1 2 3 2 1. Called with the mutex. */
static int mean_dioptres(autofocus *a, const frame_options *own, int frame, double *dioptres, double *unit) {
    double sum = 0, weights = 0;
    for (int d = -a->reach; d <= a->reach; d++) {
        const found *f;
        if (frame + (int64_t)d < 0 || frame + (int64_t)d > INT32_MAX) continue;
        const int status = interrupted() ? fail_interrupted() : measured(a, d ? NULL : own, frame + d, &f);
        if (status) return status;
        if (d == 0 && !f->any)
            return fail("--autofocus: %s: has no depth in the region %s; choose another", own->o.file[0],
                        option_text(a->o, OPT_AUTOFOCUS));
        if (d == 0) *unit = f->unit;
        const double weight = f->any ? a->reach + 1 - abs(d) : 0;
        sum += weight * f->dioptres;
        weights += weight;
    }
    *dioptres = sum / weights;
    return 0;
}

int autofocus_distance(autofocus *a, const frame_options *f, int frame, double *distance) {
    double dioptres = 0, unit = 0;
    pthread_mutex_lock(&a->mutex);
    const int status = mean_dioptres(a, f, frame, &dioptres, &unit);
    pthread_mutex_unlock(&a->mutex);
    if (status == 0) *distance = 1000 / unit / dioptres;
    return status;
}

int autofocus_apply(autofocus *a, frame_options *f, int frame) {
    option_value value = {.given = true};
    const int status = autofocus_distance(a, f, frame, &value.number);
    return status ? status : frame_options_set(f, OPT_FOCUS, value);
}

int autofocus_open(autofocus **result, const options *o, const sequence *frames, const animation *keys) {
    static const option_id others[] = {OPT_FOCUS, OPT_FOCUS_AT};
    *result = NULL;
    for (int i = 0; i < 2; i++)
        if (option_given(o, others[i]))
            return fail_usage("--autofocus: cannot be used together with --%s; give one of them", option_table[others[i]].name);
    if (option_given(o, OPT_FOCUS_SMOOTH) && !frames)
        return fail_usage("--focus-smooth: is for several frames; give IN a pattern, like shot.####.exr");
    autofocus *a = calloc(1, sizeof *a);
    if (!a) return fail("--autofocus: out of memory");
    *a = (autofocus){.o = o, .frames = frames, .keys = keys, .reach = (int)option_number(o, OPT_FOCUS_SMOOTH, 0)};
    pthread_mutex_init(&a->mutex, NULL);
    pthread_mutex_init(&a->context_mutex, NULL);
    pthread_cond_init(&a->changed, NULL);
    int status = read_region(&a->region, option_text(o, OPT_AUTOFOCUS));
    /* the same bits on every machine of a farm */
    const ddof_config config = {.backend = DDOF_BACKEND_CPU, .threads = 1, .cpu_mask = DDOF_CPU_BASELINE};
    if (status == 0 && ddof_create(&a->context, &config) != DDOF_OK) status = fail("--autofocus: out of memory");
    if (status)
        autofocus_close(a);
    else
        *result = a;
    return status;
}

void autofocus_close(autofocus *a) {
    if (!a) return;
    for (int i = 0; i < BUCKETS; i++)
        for (found *f = a->bucket[i], *next; f; f = next) {
            next = f->next;
            free(f);
        }
    ddof_destroy(&a->context);
    pthread_cond_destroy(&a->changed);
    pthread_mutex_destroy(&a->context_mutex);
    pthread_mutex_destroy(&a->mutex);
    free(a);
}
