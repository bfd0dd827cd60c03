/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "metadata.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "lens.h"
#include "message.h"

enum { MOST_NAMES = 6 };

/* Of auto, the first that is there: OpenEXR's own, as https://openexr.com/en/latest/StandardAttributes.html has them; then
 * V-Ray's camera... and Blender's Lens, a text. */
static const struct known {
    option_id id;
    const char *name[MOST_NAMES];
} known[METADATA_ITEMS] = {
    {OPT_FOCUS, {"focus"}},
    {OPT_FSTOP, {"aperture", "cameraFNumber"}},
    {OPT_FOCAL_LENGTH, {"pinholeFocalLength", "effectiveFocalLength", "nominalFocalLength", "cameraFocalLength", "Lens"}},
    {OPT_SENSOR_WIDTH, {"cameraAperture"}},
};

/* ------------------------------------------------------------------------- the header */

static bool find_number(const io_picture *picture, int part, const char *name, double *number) {
    if (io_attribute_number(picture, part, name, number)) return true;
    for (int i = 0; i < picture->part_count; i++)
        if (io_attribute_number(picture, i, name, number)) return true;
    return false;
}

/* "a (1), b (2.5)": the numbers that a part has. */
static void list_numbers(const io_picture *picture, int part, char *text, size_t size) {
    const char *name;
    double number;
    size_t used = 0;
    snprintf(text, size, "none");
    for (int i = 0; (name = io_attribute_name(picture, part, i)) && used + 1 < size; i++)
        if (io_attribute_number(picture, part, name, &number))
            used += (size_t)snprintf(text + used, size - used, "%s%.80s (%g)", used ? ", " : "", name, number);
}

static int fail_missing(const io_picture *picture, int part, const char *what) {
    char there[640];
    list_numbers(picture, part, there, sizeof there);
    return fail("--metadata: %s: has no %s; numbers in its header: %s", picture->path, what, there);
}

static int take(metadata_item *item, const io_picture *picture, const char *name, double number) {
    const option_spec *spec = &option_table[item->id];
    const bool infinite = isinf(number) && spec->kind != KIND_NUMBER_OR_INF;
    if (!(number > spec->low && number <= spec->high) || infinite) {
        char range[64];
        option_range_text(spec, range, sizeof range);
        return fail("--metadata: %s: %.80s is %g, but must be %s; give --%s", picture->path, name, number, range, spec->name);
    }
    snprintf(item->name, sizeof item->name, "%s", name);
    item->number = number;
    item->metres = strcmp(name, known[0].name[0]) == 0;
    return 0;
}

/* ------------------------------------------------------------------------- which attributes */

static int find_known(metadata_item *item, const struct known *k, const io_picture *picture, int part) {
    double number;
    for (int i = 0; i < MOST_NAMES && k->name[i]; i++)
        if (find_number(picture, part, k->name[i], &number)) return take(item, picture, k->name[i], number);
    return 0;
}

static int find_auto(metadata *m, const io_picture *picture, int part, const options *o, bool needed) {
    bool any = false, wanted = false;
    for (int i = 0; i < METADATA_ITEMS; i++) {
        if (option_given(o, known[i].id)) continue;
        const int status = find_known(&m->item[i], &known[i], picture, part);
        if (status) return status;
        wanted = true;
        any |= *m->item[i].name != 0;
    }
    if (any || !wanted || !needed) return 0;
    return fail_missing(picture, part,
                        "attribute of a lens that is known (focus, aperture, ...; name one, like --metadata fstop=NAME)");
}

static int fail_list(const char *item, size_t length) {
    return fail_usage(
        "--metadata: '%.*s' is neither auto nor one of focus=, fstop=, focal-length=, sensor-width= and the name of an "
        "attribute; write it like --metadata %s",
        (int)length, item, option_table[OPT_METADATA].example);
}

/* "fstop=aperture" */
static int find_named(metadata *m, const io_picture *picture, int part, const options *o, const char *text, size_t length) {
    const char *equals = memchr(text, '=', length);
    const size_t key = equals ? (size_t)(equals - text) : 0;
    char name[sizeof m->item->name], what[320];
    double number;
    int i = 0;
    while (i < METADATA_ITEMS &&
           (strlen(option_table[known[i].id].name) != key || strncmp(option_table[known[i].id].name, text, key) != 0))
        i++;
    if (i == METADATA_ITEMS || key + 1 == length || length - key - 1 >= sizeof name) return fail_list(text, length);
    snprintf(name, sizeof name, "%.*s", (int)(length - key - 1), equals + 1);
    if (*m->item[i].name) return fail_usage("--metadata: has %s twice; leave one out", option_table[known[i].id].name);
    if (option_given(o, known[i].id)) return 0;
    if (find_number(picture, part, name, &number)) return take(&m->item[i], picture, name, number);
    snprintf(what, sizeof what, "number named '%s' for %s", name, option_table[known[i].id].name);
    return fail_missing(picture, part, what);
}

int metadata_find(metadata *m, const io_picture *picture, int part, const options *o, const char *text, bool needed) {
    *m = (metadata){0};
    for (int i = 0; i < METADATA_ITEMS; i++)
        m->item[i].id = known[i].id;
    if (!text || strcmp(text, "auto") == 0) return find_auto(m, picture, part, o, needed);
    for (;;) {
        const size_t length = strcspn(text, ",");
        const int status = find_named(m, picture, part, o, text, length);
        if (status || !text[length]) return status;
        text += length + 1;
    }
}

void metadata_apply(camera *file, const metadata *m, const options *o) {
    double *const place[METADATA_ITEMS] = {&file->focus_distance, &file->f_number, &file->focal_length, &file->sensor_width};
    for (int i = 0; i < METADATA_ITEMS; i++) {
        const metadata_item *item = &m->item[i];
        if (!*item->name) continue;
        const double unit = item->metres ? 1000 : lens_unit(o, file);
        *place[i] = item->id == OPT_FOCUS ? item->number * unit : item->number;
    }
}
