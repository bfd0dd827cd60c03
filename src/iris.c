/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "iris.h"

#include <math.h>
#include <string.h>

#include "image.h"

static const double PI = 3.14159265358979323846;

/* ---- what is asked for */

static bool within(double v, double least, double most) {
    return v >= least && v <= most;
}

static const char *check_image(const ddof_iris *s) {
    const ddof_image *i = &s->image;
    if (s->shape != DDOF_IRIS_IMAGE) return i->channels ? "iris.image is for DDOF_IRIS_IMAGE: set iris.shape, or channels 0" : NULL;
    if (i->channels != 1 || !i->plane[0].data) return "iris.image needs 1 channel and its data";
    if (i->width < 1 || i->height < 1 || i->width > IRIS_IMAGE_MOST || i->height > IRIS_IMAGE_MOST)
        return "iris.image must have 1 to 4096 pixels a side";
    if (i->plane[0].type != DDOF_FLOAT && i->plane[0].type != DDOF_HALF) return "iris.image: its type is none of ddof_type";
    const size_t size = i->plane[0].type == DDOF_HALF ? 2 : 4;
    if (((uintptr_t)i->plane[0].data | (uintptr_t)i->plane[0].pixel_stride | (uintptr_t)i->plane[0].row_stride) % size)
        return "iris.image: data and strides must be multiples of the size of its type";
    const int64_t most = INT64_C(1) << 40, pixel = i->plane[0].pixel_stride, line = i->plane[0].row_stride;
    if (pixel > most || pixel < -most || line > most || line < -most) return "iris.image: a stride is beyond 2^40 bytes";
    return NULL;
}

const char *iris_check(const ddof_iris *s) {
    for (size_t i = 0; i < sizeof s->reserved / sizeof *s->reserved; i++)
        if (s->reserved[i]) return "iris.reserved must be 0";
    if (s->shape < DDOF_IRIS_DISC || s->shape > DDOF_IRIS_IMAGE) return "iris.shape is none of ddof_iris_shape";
    if (s->shape == DDOF_IRIS_POLYGON && (s->blades < 3 || s->blades > IRIS_BLADES)) return "iris.blades must be 3 to 64";
    if (s->shape != DDOF_IRIS_POLYGON && s->blades) return "iris.blades is for DDOF_IRIS_POLYGON: set iris.shape, or 0";
    if (!within(s->rotation, -3600, 3600)) return "iris.rotation must be -3600 to 3600 degrees";
    if (!within(s->curvature, 0, 1)) return "iris.curvature must be 0 to 1";
    if (!within(s->edge, -1, 1)) return "iris.edge must be -1 to 1";
    if (!within(s->cats_eye, 0, 1)) return "iris.cats_eye must be 0 to 1";
    if (s->squeeze != 0 && !within(s->squeeze, 1, 4)) return "iris.squeeze must be 1 to 4, or 0 for 1";
    if (!within(s->fringe, -0.5, 0.5)) return "iris.fringe must be -0.5 to 0.5";
    return check_image(s);
}

/* ---- nodes */

int iris_node(float diameter) {
    const float node = log2f(diameter) * IRIS_OCTAVE + 0.5f;
    return node > 0 ? node < IRIS_NODES - 1 ? (int)node : IRIS_NODES - 1 : 0;
}

float iris_diameter(int node) {
    return exp2f((float)node / IRIS_OCTAVE);
}

int iris_level(int node, bool half) {
    const int below = 7 * IRIS_OCTAVE + (half ? IRIS_OCTAVE : 0) - node; /* 128 texels across */
    const int level = below > 0 ? below / IRIS_OCTAVE : 0;
    return level < IRIS_LEVELS ? level : IRIS_LEVELS - 1;
}

const float *iris_texels(const iris *of, int level) {
    const float *at = of->texel;
    for (int l = 0; l < level; l++) at += iris_level_side(l) * iris_level_side(l);
    return at;
}

float iris_reach(const ddof_iris *s) {
    const double turn = s->rotation * PI / 180;
    return s->shape == DDOF_IRIS_IMAGE ? (float)(fabs(cos(turn)) + fabs(sin(turn))) : 1;
}

/* ---- tables */

/* Sum of `out`'s box of the image, which lies in the middle of a square of its longer side. */
static double box_sum(const ddof_image *image, double x0, double x1, double y0, double y1) {
    double sum = 0;
    const int left = (int)fmax(floor(x0), 0), top = (int)fmax(floor(y0), 0);
    for (int y = top; y < image->height && y < y1; y++)
        for (int x = left; x < image->width && x < x1; x++) {
            const double v = image_value(image, 0, x, y);
            const double wide = fmin(x + 1, x1) - fmax(x, x0), tall = fmin(y + 1, y1) - fmax(y, y0);
            if (v > 0 && isfinite(v) && wide > 0 && tall > 0) sum += v * wide * tall;
        }
    return sum;
}

/* The mean of what each texel covers; the brightest is returned, `changed` is set where it is not what was read before. */
static float read_texels(float *read, const ddof_image *given, bool *changed) {
    ddof_image image = *given;
    image_resolve(&image);
    const double side = image.width > image.height ? image.width : image.height, step = side / IRIS_SIDE;
    const double left = (side - image.width) / 2, top = (side - image.height) / 2;
    float most = 0;
    for (int y = 0; y < IRIS_SIDE; y++)
        for (int x = 0; x < IRIS_SIDE; x++) {
            const double v = box_sum(&image, x * step - left, (x + 1) * step - left, y * step - top, (y + 1) * step - top) / (step * step);
            const float texel = (float)fmin(v, 3e38);
            *changed |= read[y * IRIS_SIDE + x] != texel;
            read[y * IRIS_SIDE + x] = texel;
            most = fmaxf(most, texel);
        }
    return most;
}

/* The brightest 1; then each level from the one before. */
static void make_texels(float *texel, const float *read, float most) {
    for (int i = 0; i < IRIS_SIDE * IRIS_SIDE; i++) texel[i] = read[i] / most;
    float *from = texel;
    for (int l = 1; l < IRIS_LEVELS; l++) {
        const int half = iris_level_side(l), whole = 2 * half;
        float *to = from + whole * whole;
        for (int i = 0; i < half * half; i++) {
            const float *p = from + i / half * 2 * whole + i % half * 2;
            to[i] = 0.25f * ((p[0] + p[1]) + (p[whole] + p[whole + 1]));
        }
        from = to;
    }
}

/* Of a mask whose middle lies (off_x, off_y) from a pixel of the target. */
static double mask_sum(const iris *of, const sprite_kernels *k, const iris_row *like, float off_x, float off_y) {
    enum { ROOM = 192 };
    float row[ROOM];
    iris_row at = *like;
    const float reach = like->diameter / 2 * of->reach;
    const int wide = (int)reach + 2, tall = (int)(reach * of->shape.aspect) + 2;
    /* Pixels a thousand times as wide as tall, which no camera has, would take a thousand times as long: 512 rows of a half are
     * as exact. */
    const int step = 1 + tall / 512;
    double sum = 0;
    at.dx = off_x - (float)wide;
    for (int y = -tall; y <= tall; y += step) {
        at.dy = off_y + (float)y;
        k->mask(of, &at, 2 * wide + 1, row);
        for (int x = 0; x <= 2 * wide; x++) sum += (double)row[x];
    }
    return sum * step;
}

enum {
    WIDEST = 6 * IRIS_OCTAVE,     /* that is drawn: 64 pixels */
    WIDEST_FRINGE = WIDEST + IRIS_OCTAVE * 5 / 8 /* and with fringe half as much again; beyond that a sum grows with the area */
};

/* place: -1 in a picture of its size, else one of four in half of it, bit 0 to the right, bit 1 below. */
static void make_inverse_sums(const iris *of, const sprite_kernels *k, int place, bool near, float *inverse) {
    const bool half = place >= 0;
    const float off_x = half ? place & 1 ? -0.25f : 0.25f : 0, off_y = half ? place & 2 ? -0.25f : 0.25f : 0;
    const int last = (of->shape.fringe != 0 ? WIDEST_FRINGE : WIDEST) + half * IRIS_OCTAVE;
    for (int node = 0; node < IRIS_NODES; node++)
        if (node <= last) {
            const iris_row like = {.diameter = of->diameter[node] / (half ? 2 : 1), .side = near ? -1 : 1, .level = iris_level(node, half)};
            const double sum = mask_sum(of, k, &like, off_x, off_y);
            inverse[node] = sum > 1e-6 ? (float)(1 / sum) : 0;
        } else {
            const double across = (double)of->diameter[node] / (double)of->diameter[last];
            inverse[node] = (float)((double)inverse[last] / (across * across));
        }
}

/* Discs are alike in all four places, and before the focus what is turned by half a turn is in the opposite one, but for its edge. */
static void make_all_inverse_sums(iris *out, const sprite_kernels *k) {
    for (int i = 0; i < IRIS_SUMS; i++) {
        const int place = i % 5 - 1;
        const bool near = i >= 5;
        const float *same = NULL;
        if (near && out->shape.edge == 0) same = out->inverse_sum[place < 0 ? 0 : 1 + (place ^ 3)];
        if (out->shape.kind == DDOF_IRIS_DISC && place > 0) same = out->inverse_sum[5 * near + 1];
        if (same)
            memcpy(out->inverse_sum[i], same, sizeof out->inverse_sum[i]);
        else
            make_inverse_sums(out, k, place, near, out->inverse_sum[i]);
    }
}

static void make_sums(iris *out, const sprite_kernels *k) {
    for (int node = 0; node < IRIS_NODES; node++) out->diameter[node] = iris_diameter(node);
    make_all_inverse_sums(out, k);
    const double whole = 1.0 / (double)out->inverse_sum[0][WIDEST];
    for (int i = 0; i < IRIS_CATS; i++) {
        const iris_row like = {.diameter = iris_diameter(WIDEST), .side = 1, .cat_x = (float)i / (IRIS_CATS - 1), .level = iris_level(WIDEST, false)};
        const double sum = mask_sum(out, k, &like, 0, 0);
        out->cats_gain[i] = sum * 1e3 > whole ? (float)(whole / sum) : 1e3f;
    }
}

static iris_shape shape_of(const ddof_iris *s, double aspect) {
    const double turn = s->rotation * PI / 180;
    iris_shape shape = {.kind = (int)s->shape, .blades = s->blades, .cosine = (float)cos(turn), .sine = (float)sin(turn)};
    shape.apothem = s->blades ? (float)cos(PI / s->blades) : 1;
    for (int k = 0; k < s->blades; k++) {
        shape.normal_x[k] = (float)cos((2 * k + 1) * PI / s->blades);
        shape.normal_y[k] = (float)sin((2 * k + 1) * PI / s->blades);
    }
    shape.curvature = (float)s->curvature;
    shape.edge = (float)s->edge;
    shape.cats_eye = (float)s->cats_eye;
    shape.squeeze = s->squeeze > 0 ? (float)s->squeeze : 1;
    shape.fringe = (float)s->fringe;
    shape.aspect = (float)aspect;
    return shape;
}

bool iris_make(iris *out, const ddof_iris *s, double aspect, const sprite_kernels *k) {
    const iris_shape shape = shape_of(s, aspect);
    bool changed = !out->made || memcmp(&shape, &out->shape, sizeof shape) != 0;
    if (s->shape == DDOF_IRIS_IMAGE) {
        const float most = read_texels(out->read, &s->image, &changed);
        out->made = out->made && most > 0;
        if (!(most > 0)) return false;
        if (changed) make_texels(out->texel, out->read, most);
    }
    if (!changed) return true;
    out->shape = shape;
    out->reach = iris_reach(s);
    make_sums(out, k);
    out->made = true;
    return true;
}
