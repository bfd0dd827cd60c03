/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "camera.h"

#include <cjson/cJSON.h>
#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "json.h"
#include "message.h"
#include "sequence.h"

/* ------------------------------------------------------------------------- members */

static const cJSON *member(const cJSON *object, const char *key) {
    return cJSON_GetObjectItemCaseSensitive(object, key);
}

static const char *text_member(const cJSON *object, const char *key) {
    const cJSON *item = member(object, key);
    return cJSON_IsString(item) ? item->valuestring : NULL;
}

/* A length or ratio that must be above 0. Absent or null: left alone. */
static int positive_member(const char *path, const cJSON *object, const char *key, double *number) {
    const cJSON *item = member(object, key);
    if (!item || cJSON_IsNull(item)) return 0;
    if (!cJSON_IsNumber(item) || !(item->valuedouble > 0) || !isfinite(item->valuedouble)) {
        char *written = cJSON_PrintUnformatted(item);
        int status = fail("%s: %s is %.60s; it must be a number above 0", path, key, written ? written : "?");
        cJSON_free(written);
        return status;
    }
    *number = item->valuedouble;
    return 0;
}

static int read_unit(const char *path, const char *unit, double *millimetres) {
    static const struct {
        const char *name;
        double millimetres;
    } units[] = {{"m", 1000},    {"metre", 1000}, {"meter", 1000}, {"metres", 1000},   {"meters", 1000},
                 {"mm", 1},      {"cm", 10},      {"dm", 100},     {"km", 1e6},        {"in", 25.4},
                 {"inch", 25.4}, {"ft", 304.8},   {"feet", 304.8}, {"millimetres", 1}, {"centimetres", 10}};
    for (size_t i = 0; i < sizeof units / sizeof *units; i++)
        if (strcmp(unit, units[i].name) == 0) {
            *millimetres = units[i].millimetres;
            return 0;
        }
    return fail("%s: depth.unit '%s' is not known; use m, cm, mm, km, in or ft, or give --unit", path, unit);
}

/* "planar distance from the camera centre ..." and the like: the first word decides. */
static int read_convention(const char *path, const char *text, camera *result) {
    static const struct {
        const char *word;
        ddof_depth_kind kind;
    } words[] = {{"planar", DDOF_DEPTH_PLANAR},         {"ray", DDOF_DEPTH_RAY},
                 {"inverse", DDOF_DEPTH_INVERSE},       {"disparity", DDOF_DEPTH_INVERSE},
                 {"normalized", DDOF_DEPTH_NORMALIZED}, {"normalised", DDOF_DEPTH_NORMALIZED},
                 {"device", DDOF_DEPTH_DEVICE}};
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        if (strncmp(text, words[i].word, strlen(words[i].word)) == 0) {
            result->has_depth_kind = true;
            result->depth_kind = words[i].kind;
            return 0;
        }
    return fail("%s: depth.convention '%.60s' begins with none of planar, ray, inverse, normalized, device; "
                "correct it or give --depth-kind",
                path, text);
}

static int read_depth(const char *path, const cJSON *depth, camera *result) {
    const char *unit = text_member(depth, "unit"), *convention = text_member(depth, "convention");
    const char *channel = text_member(depth, "channel");
    if (channel) snprintf(result->depth_channel, sizeof result->depth_channel, "%s", channel);
    int status = unit ? read_unit(path, unit, &result->unit) : 0;
    if (status == 0 && convention) status = read_convention(path, convention, result);
    return status;
}

/* ------------------------------------------------------------------------- which entry of "renders" */

static long frame_of_entry(const cJSON *entry) {
    const cJSON *frame = member(entry, "frame");
    bool usable = cJSON_IsNumber(frame) && frame->valuedouble >= 0 && frame->valuedouble < 1e9;
    return usable ? (long)frame->valuedouble : -1;
}

static bool has_name(const cJSON *entry, const char *name) {
    const char *file = text_member(entry, "file");
    return file && strcmp(base_name(file), base_name(name)) == 0;
}

static int named_entry(const char *path, const cJSON *renders, const char *name, const cJSON **found) {
    char known[512] = "";
    const cJSON *entry;
    cJSON_ArrayForEach(entry, renders) {
        if (has_name(entry, name)) {
            *found = entry;
            return 0;
        }
        const char *file = text_member(entry, "file");
        size_t used = strlen(known);
        if (file && cJSON_IsTrue(member(entry, "dof")) && used + strlen(file) + 3 < sizeof known)
            snprintf(known + used, sizeof known - used, "%s%s", used ? ", " : "", file);
    }
    return fail_usage("--render: %s has no entry '%s'; those with depth of field are: %s", path, name,
                      *known ? known : "none");
}

/* The first picture with depth of field of the same frame as the input; an input or entry without a frame fits every
 * other. Failing that, the input's own entry, which may suggest a focus. */
static int matching_entry(const char *path, const cJSON *renders, const char *input, const cJSON **found) {
    const cJSON *entry, *own = NULL;
    cJSON_ArrayForEach(entry, renders) if (!own && has_name(entry, input)) own = entry;
    long frame = own ? frame_of_entry(own) : frame_of_name(input);
    bool other_frames = false;
    cJSON_ArrayForEach(entry, renders) {
        if (!cJSON_IsTrue(member(entry, "dof"))) continue;
        long its = frame_of_entry(entry);
        if (its < 0 || frame < 0 || its == frame) {
            *found = entry;
            return 0;
        }
        other_frames = true;
    }
    if (!own && other_frames)
        return fail("%s: has no entry with \"dof\": true for frame %ld of %s; name one with --render", path, frame,
                    base_name(input));
    *found = own;
    return 0;
}

static int read_entry(const char *path, const cJSON *entry, camera *result) {
    const char *file = text_member(entry, "file");
    if (file) snprintf(result->entry, sizeof result->entry, "%s", base_name(file));
    double focus = 0; /* metres */
    int status = positive_member(path, entry, "suggested_f_number", &result->f_number);
    if (status == 0) status = positive_member(path, entry, "f_number", &result->f_number);
    if (status == 0) status = positive_member(path, entry, "suggested_focus_distance_m", &focus);
    if (status == 0) status = positive_member(path, entry, "focus_distance_m", &focus);
    result->focus_distance = focus * 1000;
    return status;
}

static int read_root(camera *result, const char *path, const char *name, const char *input, const cJSON *root) {
    const cJSON *body = member(root, "camera"), *renders = member(root, "renders"), *entry = NULL;
    if (!cJSON_IsObject(body)) return fail("%s: has no \"camera\" object; is it a scene.json?", path);
    int status = positive_member(path, body, "focal_length_mm", &result->focal_length);
    if (status == 0) status = positive_member(path, body, "sensor_width_mm", &result->sensor_width);
    if (status == 0) status = read_depth(path, member(root, "depth"), result);
    if (status) return status;
    status = name ? named_entry(path, renders, name, &entry) : matching_entry(path, renders, input, &entry);
    if (status || !entry) return status;
    return read_entry(path, entry, result);
}

int camera_read(camera *result, const char *path, const char *entry, const char *input) {
    *result = (camera){0};
    cJSON *root = NULL;
    int status = json_read(&root, path, "camera", "{\"camera\": {...");
    if (status == 0) status = read_root(result, path, entry, input, root);
    cJSON_Delete(root);
    return status;
}
