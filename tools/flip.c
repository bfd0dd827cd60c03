/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "flip.h"

#include <math.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846

/* ------------------------------------------------------------------------- colour */

/* X/Xn, Y/Yn, Z/Zn of linear Rec. 709, white D65 = (0.950428545, 1, 1.088900371): white has 1, 1, 1. */
static void xyz_of_rgb(const float rgb[3], float xyz[3]) {
    static const float m[3][3] = {{0.433895389f, 0.376242373f, 0.189862239f},
                                  {0.212636822f, 0.715182982f, 0.072180197f},
                                  {0.017752423f, 0.109465629f, 0.872781948f}};
    for (int i = 0; i < 3; i++)
        xyz[i] = m[i][0] * rgb[0] + m[i][1] * rgb[1] + m[i][2] * rgb[2];
}

static void opponent_of_rgb(const float rgb[3], float ycc[3]) {
    float t[3];
    xyz_of_rgb(rgb, t);
    ycc[0] = 116 * t[1] - 16;
    ycc[1] = 500 * (t[0] - t[1]);
    ycc[2] = 200 * (t[1] - t[2]);
}

/* Back, and clamped to what a display can show. */
static void rgb_of_opponent(const float ycc[3], float rgb[3]) {
    static const float m[3][3] = {{3.080341987f, -1.537398970f, -0.542943019f},
                                  {-0.921178396f, 1.875929984f, 0.045248413f},
                                  {0.052881293f, -0.204011206f, 1.151129914f}};
    const float y = (ycc[0] + 16) / 116, x = y + ycc[1] / 500, z = y - ycc[2] / 200;
    for (int i = 0; i < 3; i++)
        rgb[i] = fminf(fmaxf(m[i][0] * x + m[i][1] * y + m[i][2] * z, 0), 1);
}

static float lab_curve(float t) {
    return t > 216.0f / 24389 ? cbrtf(t) : t * (841.0f / 108) + 4.0f / 29;
}

/* CIE Lab, a and b scaled by L/100: colours look paler in the dark (Hunt). */
static void hunt_of_rgb(const float rgb[3], float lab[3]) {
    float t[3];
    xyz_of_rgb(rgb, t);
    const float x = lab_curve(t[0]), y = lab_curve(t[1]), z = lab_curve(t[2]);
    lab[0] = 116 * y - 16;
    lab[1] = 0.01f * lab[0] * 500 * (x - y);
    lab[2] = 0.01f * lab[0] * 200 * (y - z);
}

static float hyab(const float p[3], const float q[3]) {
    return fabsf(p[0] - q[0]) + hypotf(p[1] - q[1], p[2] - q[2]);
}

/* Distances to the power q_c = 0.7; up to p_c = 0.4 of the largest one they fill 0..p_t = 0.95, the others the rest. */
static float color_difference(float distance, float largest) {
    const float d = powf(distance, 0.7f), knee = 0.4f * largest;
    return d < knee ? 0.95f / knee * d : 0.95f + (d - knee) / (largest - knee) * 0.05f;
}

/* From pure green to pure blue, which are farthest apart. */
static float largest_difference(void) {
    float green[3], blue[3];
    hunt_of_rgb((const float[3]){0, 1, 0}, green);
    hunt_of_rgb((const float[3]){0, 0, 1}, blue);
    return powf(hyab(green, blue), 0.7f);
}

/* ------------------------------------------------------------------------- tones */

/* (k0 x^2 + k1 x) / (k3 x^2 + k4 x + k5): Narkowicz's fit of ACES, exposed as the paper does. */
static const double aces[6] = {0.36 * 2.51, 0.6 * 0.03, 0, 0.36 * 2.43, 0.6 * 0.59, 0.14};

static float shown(float linear, const flip_view *view, float gain) {
    const double x = linear > 0 ? (double)linear : 0;
    if (view->tone == FLIP_COMPACT) return (float)(x / (1 + x));
    if (view->tone == FLIP_DISPLAY) return x < 1 ? (float)x : 1;
    const double v = x * (double)gain;
    const double y = v > 1e6 ? 1 : (aces[0] * v + aces[1]) * v / ((aces[3] * v + aces[4]) * v + aces[5]);
    return y < 1 ? (float)y : 1;
}

/* ------------------------------------------------------------------------- filters */

/* Seven rows are what all filters have in common along x; along y follow the eight below. */
enum row { ROW_Y, ROW_CX, ROW_CZ1, ROW_CZ2, ROW_SMOOTH, ROW_SLOPE, ROW_CURVE, ROWS };
enum tap { TAP_Y, TAP_CX, TAP_CZ1, TAP_CZ2, TAP_SMOOTH, TAP_SLOPE, TAP_CURVE, TAPS };

typedef struct filters {
    int radius; /* of all; narrower ones end in zeros */
    float *tap[TAPS];
    float cz_share[2]; /* of the two Gaussians of blue-yellow */
    float largest;
} filters;

/* exp(-k^2 fall) for |k| <= reach, sum 1; returns the sum it had. */
static double make_gaussian(float *tap, int radius, int reach, double fall) {
    double sum = 0;
    for (int k = -reach; k <= reach; k++)
        sum += exp(-k * k * fall);
    for (int k = -radius; k <= radius; k++)
        tap[k + radius] = abs(k) <= reach ? (float)(exp(-k * k * fall) / sum) : 0;
    return sum;
}

/* First or second derivative of a Gaussian; the positive weights have the sum 1, the negative ones -1. */
static void make_derivative(float *tap, int radius, int reach, double sigma, bool second) {
    double positive = 0, negative = 0;
    for (int pass = 0; pass < 2; pass++)
        for (int k = -radius; k <= radius; k++) {
            const double g = abs(k) <= reach ? exp(-k * k / (2 * sigma * sigma)) : 0;
            const double w = second ? (k * k / (sigma * sigma) - 1) * g : -k * g;
            if (pass) tap[k + radius] = (float)(w > 0 ? w / positive : w < 0 ? -w / negative : 0);
            if (w > 0) positive += pass ? 0 : w;
            if (w < 0) negative += pass ? 0 : w;
        }
}

/* Contrast sensitivity a1 sqrt(pi/b1) exp(-pi^2 x^2/b1) + a2 sqrt(pi/b2) exp(-pi^2 x^2/b2), x in degrees (table 1 of
 * the paper); edges and points: sigma is half of 0.082 degrees. */
static int make_filters(filters *f, double ppd) {
    static const double b[4] = {0.0047, 0.0053, 0.04, 0.025};
    const double sigma = 0.5 * 0.082 * ppd;
    const int reach = (int)ceil(3 * sqrt(0.04 / (2 * PI * PI)) * ppd), feature_reach = (int)ceil(3 * sigma);
    f->radius = reach > feature_reach ? reach : feature_reach;
    const size_t taps = 2 * (size_t)f->radius + 1;
    float *all = malloc(TAPS * taps * sizeof *all);
    if (!all) return 1;
    double sum[4];
    for (size_t i = 0; i < TAPS; i++)
        f->tap[i] = all + i * taps;
    for (int i = 0; i < 4; i++)
        sum[i] = make_gaussian(f->tap[TAP_Y + i], f->radius, reach, PI * PI / (b[i] * ppd * ppd));
    make_gaussian(f->tap[TAP_SMOOTH], f->radius, feature_reach, 1 / (2 * sigma * sigma));
    make_derivative(f->tap[TAP_SLOPE], f->radius, feature_reach, sigma, false);
    make_derivative(f->tap[TAP_CURVE], f->radius, feature_reach, sigma, true);
    const double first = 34.1 * sqrt(PI / b[2]) * sum[2] * sum[2], second = 13.5 * sqrt(PI / b[3]) * sum[3] * sum[3];
    f->cz_share[0] = (float)(first / (first + second));
    f->cz_share[1] = (float)(second / (first + second));
    f->largest = largest_difference();
    return 0;
}

static void free_filters(filters *f) {
    free(f->tap[0]);
}

/* out[x] = sum of tap[k] in[k][x], in[k] being another row, or the same one shifted. */
static void filter(float *restrict out, const float *const *in, const float *restrict tap, int taps, int width) {
    for (int x = 0; x < width; x++)
        out[x] = tap[0] * in[0][x];
    int k = 1;
    for (; k + 1 < taps; k += 2) {
        const float *restrict p = in[k], *restrict q = in[k + 1];
        const float u = tap[k], v = tap[k + 1];
        for (int x = 0; x < width; x++)
            out[x] += u * p[x] + v * q[x];
    }
}

/* ------------------------------------------------------------------------- a band of rows */

typedef struct task {
    const float *a, *b;
    float *map;
    int width, height;
    const flip_view *view;
    const filters *filters;
    bool keep_larger; /* than what the map holds already */
} task;

typedef struct seen {
    float *color[3];          /* a row of filtered Y Cx Cz */
    float *edge_x, *edge_y;   /* first derivatives of luminance */
    float *point_x, *point_y; /* second ones */
} seen;

typedef struct band {
    const task *task;
    int from, to; /* rows */
    float *memory;
    const float **line; /* pointers to what a filter takes */
    float *padded;      /* three rows with their borders */
    float *ring[2];     /* of either picture: 2 radius + 1 times ROWS rows */
    float *spare;
    seen seen[2];
    pthread_t thread;
} band;

static int taps_of(const task *j) {
    return 2 * j->filters->radius + 1;
}

static float *ring_row(const band *b, int picture, int y, enum row row) {
    const task *j = b->task;
    const int slot = y % taps_of(j);
    return b->ring[picture] + ((size_t)slot * ROWS + (size_t)row) * (size_t)j->width;
}

static bool finite_pixel(const float *p) {
    return isfinite(p[0]) && isfinite(p[1]) && isfinite(p[2]);
}

/* Row y of a picture: tone, opponent colours, the filters along x. */
static void load_row(band *b, int picture, int y) {
    const task *j = b->task;
    const int radius = j->filters->radius, width = j->width, taps = taps_of(j);
    const size_t padded_width = (size_t)width + 2 * (size_t)radius;
    const size_t at = 3 * (size_t)y * (size_t)width;
    const float gain = (float)exp2(j->view->exposure), *const source = (picture ? j->b : j->a) + at;
    float *const plane[3] = {b->padded, b->padded + padded_width, b->padded + 2 * padded_width};
    for (int x = 0; x < width; x++) {
        float rgb[3] = {0}, ycc[3];
        if (finite_pixel(j->a + at + 3 * x) && finite_pixel(j->b + at + 3 * x))
            for (int c = 0; c < 3; c++)
                rgb[c] = shown(source[3 * x + c], j->view, gain);
        opponent_of_rgb(rgb, ycc);
        for (int c = 0; c < 3; c++)
            plane[c][radius + x] = ycc[c];
    }
    static const int plane_of[ROWS] = {[ROW_CX] = 1, [ROW_CZ1] = 2, [ROW_CZ2] = 2};
    for (int c = 0; c < 3; c++)
        for (int k = 0; k < radius; k++) {
            plane[c][k] = plane[c][radius];
            plane[c][radius + width + k] = plane[c][radius + width - 1];
        }
    for (int row = 0; row < ROWS; row++) {
        for (int k = 0; k < taps; k++)
            b->line[k] = plane[plane_of[row]] + k;
        filter(ring_row(b, picture, y, (enum row)row), b->line, j->filters->tap[row], taps, width);
    }
}

static void filter_down(band *b, int picture, int y, enum row row, enum tap tap, float *out) {
    const task *j = b->task;
    const int radius = j->filters->radius, taps = taps_of(j);
    for (int k = 0; k < taps; k++) {
        const int from = y + k - radius;
        b->line[k] = ring_row(b, picture, from < 0 ? 0 : from >= j->height ? j->height - 1 : from, row);
    }
    filter(out, b->line, j->filters->tap[tap], taps, j->width);
}

static void see_row(band *b, int picture, int y) {
    const task *j = b->task;
    const seen *s = &b->seen[picture];
    filter_down(b, picture, y, ROW_Y, TAP_Y, s->color[0]);
    filter_down(b, picture, y, ROW_CX, TAP_CX, s->color[1]);
    filter_down(b, picture, y, ROW_CZ1, TAP_CZ1, s->color[2]);
    filter_down(b, picture, y, ROW_CZ2, TAP_CZ2, b->spare);
    for (int x = 0; x < j->width; x++)
        s->color[2][x] = j->filters->cz_share[0] * s->color[2][x] + j->filters->cz_share[1] * b->spare[x];
    filter_down(b, picture, y, ROW_SLOPE, TAP_SMOOTH, s->edge_x);
    filter_down(b, picture, y, ROW_SMOOTH, TAP_SLOPE, s->edge_y);
    filter_down(b, picture, y, ROW_CURVE, TAP_SMOOTH, s->point_x);
    filter_down(b, picture, y, ROW_SMOOTH, TAP_CURVE, s->point_y);
}

/* The filters see Y, the definition (Y + 16)/116: the constant has no derivative. */
static float feature_difference(const seen *p, const seen *q, int x) {
    const float edge = fabsf(hypotf(p->edge_x[x], p->edge_y[x]) - hypotf(q->edge_x[x], q->edge_y[x]));
    const float point = fabsf(hypotf(p->point_x[x], p->point_y[x]) - hypotf(q->point_x[x], q->point_y[x]));
    return sqrtf(fmaxf(edge, point) / 116 * 0.707106781f);
}

static void hunt_of_seen(const seen *s, int x, float lab[3]) {
    float rgb[3];
    rgb_of_opponent((const float[3]){s->color[0][x], s->color[1][x], s->color[2][x]}, rgb);
    hunt_of_rgb(rgb, lab);
}

static void compare_row(band *b, int y) {
    const task *j = b->task;
    float *const map = j->map + (size_t)y * (size_t)j->width;
    const size_t at = 3 * (size_t)y * (size_t)j->width;
    for (int x = 0; x < j->width; x++) {
        float p[3], q[3];
        hunt_of_seen(&b->seen[0], x, p);
        hunt_of_seen(&b->seen[1], x, q);
        const float color = color_difference(hyab(p, q), j->filters->largest);
        const float feature = feature_difference(&b->seen[0], &b->seen[1], x);
        const float value = fminf(powf(color, 1 - fminf(feature, 1)), 1);
        if (!finite_pixel(j->a + at + 3 * x) || !finite_pixel(j->b + at + 3 * x))
            map[x] = NAN;
        else if (!j->keep_larger || value > map[x])
            map[x] = value;
    }
}

static void *work(void *argument) {
    band *b = argument;
    const task *j = b->task;
    const int radius = j->filters->radius;
    int loaded = b->from - radius > 0 ? b->from - radius : 0;
    for (int y = b->from; y < b->to; y++) {
        for (; loaded < j->height && loaded <= y + radius; loaded++)
            for (int picture = 0; picture < 2; picture++)
                load_row(b, picture, loaded);
        for (int picture = 0; picture < 2; picture++)
            see_row(b, picture, y);
        compare_row(b, y);
    }
    return NULL;
}

/* ------------------------------------------------------------------------- all bands */

static int band_open(band *b) {
    const task *j = b->task;
    const size_t width = (size_t)j->width, taps = (size_t)taps_of(j), ring = taps * ROWS * width;
    const size_t padded = 3 * (width + taps - 1);
    b->memory = malloc((2 * ring + padded + 15 * width) * sizeof *b->memory);
    b->line = malloc(taps * sizeof *b->line);
    if (!b->memory || !b->line) return 1;
    b->ring[0] = b->memory;
    b->ring[1] = b->memory + ring;
    b->padded = b->memory + 2 * ring;
    b->spare = b->padded + padded;
    for (int i = 0; i < 2; i++) {
        float *row = b->spare + width + 7 * width * (size_t)i;
        for (int c = 0; c < 3; c++, row += width)
            b->seen[i].color[c] = row;
        b->seen[i].edge_x = row;
        b->seen[i].edge_y = row + width;
        b->seen[i].point_x = row + 2 * width;
        b->seen[i].point_y = row + 3 * width;
    }
    return 0;
}

static int run(const task *j) {
    enum { MAX_BANDS = 256 };
    static const int least = 32; /* rows; each band loads twice the radius more */
    int bands = j->view->threads < 1 ? 1 : j->view->threads > MAX_BANDS ? MAX_BANDS : j->view->threads;
    if (bands > (j->height + least - 1) / least) bands = (j->height + least - 1) / least;
    band *b = calloc((size_t)bands, sizeof *b);
    int status = !b, started = 1;
    for (int i = 0; b && i < bands; i++) {
        b[i].task = j;
        b[i].from = (int)((long long)j->height * i / bands);
        b[i].to = (int)((long long)j->height * (i + 1) / bands);
        status |= band_open(&b[i]);
    }
    if (!status) {
        while (started < bands && pthread_create(&b[started].thread, NULL, work, &b[started]) == 0)
            started++;
        work(&b[0]);
        for (int i = started; i < bands; i++)
            work(&b[i]); /* a thread that cannot be had is no error */
        for (int i = 1; i < started; i++)
            pthread_join(b[i].thread, NULL);
    }
    for (int i = 0; b && i < bands; i++) {
        free(b[i].memory);
        free(b[i].line);
    }
    free(b);
    return status;
}

int flip_ldr(float *map, const float *a, const float *b, int width, int height, const flip_view *view) {
    filters f;
    if (make_filters(&f, view->ppd)) return 1;
    const task j = {.a = a, .b = b, .map = map, .width = width, .height = height, .view = view, .filters = &f};
    const int status = run(&j);
    free_filters(&f);
    return status;
}

/* ------------------------------------------------------------------------- exposures */

static int by_value(const void *p, const void *q) {
    const double a = *(const double *)p, b = *(const double *)q;
    return (a > b) - (a < b);
}

/* The middle of n sorted values, the mean of the two in the middle when n is even. */
static double middle(const double *sorted, size_t n) {
    return n ? 0.5 * (sorted[(n - 1) / 2] + sorted[n / 2]) : 0;
}

/* Where the curve reaches t: the positive root of (k0 - t k3) x^2 + (k1 - t k4) x + (k2 - t k5). */
static double aces_inverse(double t) {
    const double a = aces[0] - t * aces[3], p = (aces[1] - t * aces[4]) / a, q = (aces[2] - t * aces[5]) / a;
    return -0.5 * p + sqrt(0.25 * p * p - q);
}

int flip_choose_exposures(flip_exposures *exposures, const float *reference, int width, int height) {
    const size_t pixels = (size_t)width * (size_t)height;
    double *luminance = malloc(pixels * sizeof *luminance);
    if (!luminance) return 1;
    size_t n = 0, black = 0;
    for (size_t i = 0; i < pixels; i++) {
        const float *p = reference + 3 * i;
        if (!finite_pixel(p)) continue;
        luminance[n++] =
            0.2126 * fmax((double)p[0], 0) + 0.7152 * fmax((double)p[1], 0) + 0.0722 * fmax((double)p[2], 0);
    }
    qsort(luminance, n, sizeof *luminance, by_value);
    while (black < n && luminance[black] <= 0)
        black++;
    double median = middle(luminance, n);
    if (median <= 0) median = middle(luminance + black, n - black);
    *exposures = (flip_exposures){0, 0, 2};
    if (black < n) {
        const double x = aces_inverse(0.85);
        exposures->start = log2(x / luminance[n - 1]);
        exposures->stop = log2(x / median);
        exposures->count = (int)fmax(2, ceil(exposures->stop - exposures->start));
    }
    free(luminance);
    return 0;
}

int flip_hdr(float *map, const float *test, const float *reference, int width, int height, const flip_view *view,
             flip_exposures *used) {
    flip_exposures e;
    filters f;
    flip_view now = *view;
    now.tone = FLIP_ACES;
    if (flip_choose_exposures(&e, reference, width, height) || make_filters(&f, view->ppd)) return 1;
    if (used) *used = e;
    task j = {.a = test, .b = reference, .map = map, .width = width, .height = height, .view = &now, .filters = &f};
    int status = 0;
    for (int i = 0; i < e.count && !status; i++) {
        now.exposure = e.start + i * (e.stop - e.start) / (e.count - 1);
        j.keep_larger = i > 0;
        status = run(&j);
    }
    free_filters(&f);
    return status;
}

double flip_mean(const float *map, const unsigned char *mask, int width, int height) {
    const size_t pixels = (size_t)width * (size_t)height;
    double sum = 0;
    size_t n = 0;
    for (size_t i = 0; i < pixels; i++) {
        if (isnan(map[i]) || (mask && !mask[i])) continue;
        sum += (double)map[i];
        n++;
    }
    return n ? sum / (double)n : NAN;
}
