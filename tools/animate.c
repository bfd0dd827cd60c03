/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "animate.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "json.h"
#include "message.h"

enum { LARGEST_FRAME = 999999999 };

/* What is interpolated in the place of a number, so that equal steps look equal. */
typedef enum scale { SCALE_LINEAR, SCALE_RECIPROCAL /* dioptres; inf is 0 */, SCALE_LOGARITHM /* stops */ } scale;

typedef struct track_spec {
    option_id id;
    scale scale;
} track_spec;

static const track_spec specs[] = {{OPT_FOCUS, SCALE_RECIPROCAL},
                                   {OPT_FOCUS_AT, SCALE_LINEAR},
                                   {OPT_FOCUS_RANGE, SCALE_LINEAR},
                                   {OPT_FSTOP, SCALE_LOGARITHM},
                                   {OPT_FOCAL_LENGTH, SCALE_LOGARITHM}};
enum { TRACKS = sizeof specs / sizeof *specs };

/* One coordinate of one key. */
typedef struct knot {
    double number; /* as written */
    double scaled;
    double slope; /* of `scaled`, a frame */
} knot;

typedef struct track {
    int count; /* 0: there are no keys */
    int *frame;
    knot *knot[2]; /* the second of --focus-at only */
    bool percent[2];
} track;

struct animation {
    bool smooth;
    track track[TRACKS];
};

/* ------------------------------------------------------------------------- interpolation */

static double to_scale(scale s, double number) {
    return s == SCALE_RECIPROCAL ? 1 / number : s == SCALE_LOGARITHM ? log2(number) : number;
}

static double from_scale(scale s, double scaled) {
    return s == SCALE_RECIPROCAL ? 1 / scaled : s == SCALE_LOGARITHM ? exp2(scaled) : scaled;
}

/* Slopes of a cubic that never leaves the range of the two keys around it: 0 where the direction changes and at both ends
 * (what is held does not move), else a weighted harmonic mean (Fritsch and Butland, "A method for constructing local monotone
 * piecewise cubic interpolants", 1984), which does not stop at a key that is passed. */
static void find_slopes(knot *k, const int *frame, int count) {
    for (int i = 1; i + 1 < count; i++) {
        const double before = (double)frame[i] - frame[i - 1], after = (double)frame[i + 1] - frame[i];
        const double rise = (k[i].scaled - k[i - 1].scaled) / before, next = (k[i + 1].scaled - k[i].scaled) / after;
        if ((rise > 0 && next > 0) || (rise < 0 && next < 0))
            k[i].slope = 3 * (before + after) / ((2 * after + before) / rise + (after + 2 * before) / next);
    }
}

static double between(const knot *from, const knot *to, double width, double t, bool smooth, scale s) {
    double scaled = from->scaled + t * (to->scaled - from->scaled);
    if (smooth) { /* Hermite's cubic */
        const double rest = 1 - t, a = from->slope * width, b = to->slope * width;
        scaled = from->scaled + (to->scaled - from->scaled) * t * t * (3 - 2 * t) + t * rest * (rest * a - t * b);
    }
    /* rounding does not leave the range of the keys either */
    const double number = from_scale(s, scaled);
    return fmin(fmax(number, fmin(from->number, to->number)), fmax(from->number, to->number));
}

static double number_at(const track *t, int axis, int frame, bool smooth, scale s) {
    const knot *k = t->knot[axis];
    int low = 0, high = t->count - 1;
    if (frame <= t->frame[0]) return k[0].number;
    if (frame >= t->frame[high]) return k[high].number;
    while (high - low > 1) {
        const int middle = low + (high - low) / 2;
        *(t->frame[middle] <= frame ? &low : &high) = middle;
    }
    if (frame == t->frame[low]) return k[low].number;
    const double width = (double)t->frame[high] - t->frame[low];
    return between(&k[low], &k[high], width, ((double)frame - t->frame[low]) / width, smooth, s);
}

bool animation_has(const animation *a, option_id id) {
    for (int i = 0; a && i < TRACKS; i++)
        if (specs[i].id == id) return a->track[i].count > 0;
    return false;
}

int animation_apply(const animation *a, frame_options *f, int frame) {
    for (int i = 0; i < TRACKS; i++) {
        const track *t = &a->track[i];
        if (t->count == 0) continue;
        option_value value = {.given = true, .percent = t->percent[0], .percent_y = t->percent[1]};
        value.number = number_at(t, 0, frame, a->smooth, specs[i].scale);
        if (t->knot[1]) value.number_y = number_at(t, 1, frame, a->smooth, specs[i].scale);
        const int status = frame_options_set(f, specs[i].id, value);
        if (status) return status;
    }
    return 0;
}

/* ------------------------------------------------------------------------- the file */

/* Where in the file a key is. */
typedef struct place {
    const char *path, *name;
    int index; /* from 1 */
} place;

static int fail_key(const place *at, const cJSON *item, const char *must) {
    char *written = cJSON_PrintUnformatted(item);
    const int status = fail("%s: %s: key %d: %.60s %s", at->path, at->name, at->index, written ? written : "?", must);
    cJSON_free(written);
    return status;
}

static int read_key_frame(const place *at, const cJSON *item, track *t) {
    const double number = cJSON_IsNumber(item) ? item->valuedouble : NAN;
    if (!(fabs(number) <= LARGEST_FRAME) || number != floor(number))
        return fail_key(at, item, "is no frame; a key is [FRAME, VALUE], its frame a whole number");
    if (t->count > 0 && number <= t->frame[t->count - 1])
        return fail_key(at, item, "does not come after the frame before it; write each frame once, the lowest first");
    t->frame[t->count] = (int)number;
    return 0;
}

static int put_number(const place *at, const cJSON *item, int spec, double number, track *t, int axis) {
    const option_spec *option = &option_table[specs[spec].id];
    const double scaled = to_scale(specs[spec].scale, number);
    char range[64], text[160];
    if (number < option->low || number > option->high || (option->above && number == option->low) || !isfinite(scaled)) {
        option_range_text(option, range, sizeof range);
        snprintf(text, sizeof text, "is out of range; it must be %s, like %s", range, option->example);
        return fail_key(at, item, text);
    }
    t->knot[axis][t->count] = (knot){.number = number, .scaled = scaled};
    return 0;
}

static int read_number_value(const place *at, const cJSON *item, int spec, track *t) {
    const bool infinite = option_table[specs[spec].id].kind == KIND_NUMBER_OR_INF;
    double number = cJSON_IsNumber(item) ? item->valuedouble : NAN;
    if (infinite && cJSON_IsString(item) && strcmp(item->valuestring, "inf") == 0)
        number = INFINITY;
    else if (!isfinite(number))
        return fail_key(at, item,
                        infinite ? "is not a number; write one, like 3.2, or \"inf\"" : "is not a number; write one, like 2.8");
    return put_number(at, item, spec, number, t, 0);
}

static int read_point_value(const place *at, const cJSON *item, int spec, track *t) {
    static const char must[] = "is not \"X,Y\"; write pixels, \"640,360\", or percent, \"50%,50%\"";
    const char *text = cJSON_IsString(item) ? item->valuestring : "", *comma = strchr(text, ',');
    double number[2];
    bool percent[2];
    if (!comma || !read_extent(text, comma, &number[0], &percent[0]) || !read_extent(comma + 1, NULL, &number[1], &percent[1]))
        return fail_key(at, item, must);
    for (int i = 0; i < 2; i++) {
        if (percent[i] && number[i] > 100) return fail_key(at, item, "lies outside of the picture, which ends at 100%,100%");
        if (t->count > 0 && percent[i] != t->percent[i])
            return fail_key(at, item, "mixes pixels and percent with the key before it; write all keys in one of them");
        t->percent[i] = percent[i];
        const int status = put_number(at, item, spec, number[i], t, i);
        if (status) return status;
    }
    return 0;
}

static int read_track(const char *path, const cJSON *list, int spec, track *t) {
    place at = {path, option_table[specs[spec].id].name, 0};
    const bool point = option_table[specs[spec].id].kind == KIND_POINT;
    const int count = cJSON_IsArray(list) ? cJSON_GetArraySize(list) : 0;
    if (t->count) return fail("%s: %s: is there twice; write all of its keys into one list", path, at.name);
    if (count == 0) return fail("%s: %s: has no list of keys; write [[FRAME, VALUE], ...]", path, at.name);
    t->frame = malloc((size_t)count * sizeof *t->frame);
    for (int i = 0; i < 1 + point; i++)
        t->knot[i] = malloc((size_t)count * sizeof *t->knot[i]);
    if (!t->frame || !t->knot[0] || (point && !t->knot[1])) return fail("%s: out of memory for %d keys", path, count);
    const cJSON *key;
    cJSON_ArrayForEach(key, list) {
        at.index++;
        if (!cJSON_IsArray(key) || cJSON_GetArraySize(key) != 2)
            return fail_key(&at, key, "is not a key; write [FRAME, VALUE]");
        const cJSON *value = key->child->next;
        int status = read_key_frame(&at, key->child, t);
        if (status == 0) status = point ? read_point_value(&at, value, spec, t) : read_number_value(&at, value, spec, t);
        if (status) return status;
        t->count++;
    }
    for (int i = 0; i < 1 + point; i++)
        find_slopes(t->knot[i], t->frame, count);
    return 0;
}

static int read_interpolation(const char *path, const cJSON *item, bool *given, bool *smooth) {
    const char *word = cJSON_IsString(item) ? item->valuestring : "";
    *smooth = strcmp(word, "smooth") == 0;
    if (*given) return fail("%s: interpolation: is there twice; leave one out", path);
    *given = true;
    if (*smooth || strcmp(word, "linear") == 0) return 0;
    return fail("%s: interpolation: is neither \"linear\" nor \"smooth\"; write one of them", path);
}

static int read_members(const char *path, const cJSON *root, animation *a) {
    const cJSON *item;
    bool interpolation = false, any = false;
    cJSON_ArrayForEach(item, root) {
        int status, spec = 0;
        while (spec < TRACKS && strcmp(item->string, option_table[specs[spec].id].name) != 0)
            spec++;
        if (strcmp(item->string, "interpolation") == 0)
            status = read_interpolation(path, item, &interpolation, &a->smooth);
        else if (spec == TRACKS)
            status = fail("%s: %.60s: cannot be animated; there are focus, focus-at, focus-range, fstop, focal-length and "
                          "interpolation",
                          path, item->string);
        else
            status = read_track(path, item, spec, &a->track[spec]);
        if (status) return status;
        any |= spec < TRACKS;
    }
    if (!any) return fail("%s: has no keys; write some, like {\"focus\": [[1001, 3.2], [1040, 1.5]]}", path);
    if (animation_has(a, OPT_FOCUS) && animation_has(a, OPT_FOCUS_AT))
        return fail("%s: has keys for both focus and focus-at; leave one out", path);
    return 0;
}

int animation_read(animation **result, const char *path) {
    cJSON *root = NULL;
    *result = NULL;
    animation *a = calloc(1, sizeof *a);
    int status = a ? 0 : fail("%s: out of memory", path);
    if (status == 0) status = json_read(&root, path, option_table[OPT_ANIMATE].name, "{\"focus\": [[1001, 3.2], ...");
    if (status == 0) status = read_members(path, root, a);
    cJSON_Delete(root);
    if (status) {
        animation_free(a);
        return status;
    }
    *result = a;
    return 0;
}

void animation_free(animation *a) {
    for (int i = 0; a && i < TRACKS; i++) {
        free(a->track[i].frame);
        free(a->track[i].knot[0]);
        free(a->track[i].knot[1]);
    }
    free(a);
}
