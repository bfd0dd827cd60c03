/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "resume.h"

#include <ddof/ddof.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "commit.h"
#include "iris.h"
#include "job.h"
#include "json.h"
#include "message.h"
#include "sequence.h"

#define FOLDER ".ddof"

enum { MOST_RECORD = 1 << 20 };

/* ------------------------------------------------------------------------- what a frame is made of */

/* Options that change nothing in the picture. */
static bool is_immaterial(option_id id) {
    static const option_id ids[] = {OPT_OUTPUT,  OPT_FRAMES,  OPT_RESUME, OPT_KEEP_GOING, OPT_IN_FLIGHT,
                                    OPT_PREVIEW, OPT_THREADS, OPT_QUIET,  OPT_JSON, OPT_MAX_MEMORY, OPT_SCRATCH};
    for (size_t i = 0; i < sizeof ids / sizeof *ids; i++)
        if (ids[i] == id) return true;
    return false;
}

/* Size and time of change of a file, as a line; false: it is not there. */
static bool add_file(cJSON *list, const char *path) {
    struct stat info;
    char text[96];
    if (stat(path, &info) != 0) return false;
    snprintf(text, sizeof text, "%lld bytes, changed %lld.%09ld", (long long)info.st_size,
             (long long)info.st_mtim.tv_sec, info.st_mtim.tv_nsec);
    cJSON *file = cJSON_CreateObject();
    json_text(file, "path", path);
    json_text(file, "state", text);
    cJSON_AddItemToArray(list, file);
    return true;
}

/* The same of FILE[:CHANNEL]; ":CHANNEL" is one of IN. */
static bool add_channel_file(cJSON *list, const char *text) {
    char *file;
    const char *channel;
    if (split_channel("depth", text, &file, &channel)) return false;
    const bool there = !*file || add_file(list, file);
    free(file);
    return there;
}

static bool add_inputs(cJSON *list, const options *o) {
    static const option_id ids[] = {OPT_DEPTH, OPT_COC, OPT_HOLDOUT};
    if (!add_file(list, o->file[0])) return false;
    for (size_t i = 0; i < sizeof ids / sizeof *ids; i++)
        if (option_text(o, ids[i]) && !add_channel_file(list, option_text(o, ids[i]))) return false;
    if (option_text(o, OPT_CAMERA) && !add_file(list, option_text(o, OPT_CAMERA))) return false;
    char *image = iris_image(option_text(o, OPT_IRIS));
    const bool there = !image || add_channel_file(list, image);
    free(image);
    return there;
}

static void add_settings(cJSON *object, const options *o) {
    for (int id = 0; id < OPT_COUNT; id++) {
        const option_value *value = &o->value[id];
        if (!value->given || is_immaterial((option_id)id)) continue;
        if (value->text)
            json_text(object, option_table[id].name, value->text);
        else
            json_number(object, option_table[id].name, value->number);
    }
}

char *resume_key(const options *o) {
    cJSON *object = cJSON_CreateObject(), *inputs;
    json_text(object, "ddof", ddof_version());
    json_text(object, "commit", DDOF_COMMIT);
    json_text(object, "command", command_table[o->command].name);
    json_integer(object, "frame", o->frame);
    add_settings(cJSON_AddObjectToObject(object, "settings"), o);
    inputs = cJSON_AddArrayToObject(object, "inputs");
    char *text = inputs && add_inputs(inputs, o) ? cJSON_PrintUnformatted(object) : NULL;
    cJSON_Delete(object);
    return text;
}

/* ------------------------------------------------------------------------- the record */

/* Its name, or with `folder` that of the folder it lies in. To be freed. */
static char *record_name(const options *o, bool folder) {
    const char *path = option_text(o, OPT_OUTPUT), *name = base_name(path);
    char *made = NULL;
    const int length = (int)(name - path);
    const int size = folder ? asprintf(&made, "%.*s" FOLDER, length, path)
                            : asprintf(&made, "%.*s" FOLDER "/%s.json", length, path, name);
    return size < 0 ? NULL : made;
}

/* All that was written, as it is now; NULL: one of it is not there. */
static cJSON *outputs_of(const options *o) {
    cJSON *list = cJSON_CreateArray();
    const char *preview = option_text(o, OPT_PREVIEW);
    if (list && add_file(list, option_text(o, OPT_OUTPUT)) && (!preview || add_file(list, preview))) return list;
    cJSON_Delete(list);
    return NULL;
}

static char *read_record(const char *path) {
    FILE *file = fopen(path, "rbe");
    char *text = file ? malloc(MOST_RECORD) : NULL;
    if (text) text[fread(text, 1, MOST_RECORD - 1, file)] = 0;
    if (file) fclose(file);
    return text;
}

static bool prints_as(const cJSON *item, const char *expected) {
    char *text = item ? cJSON_PrintUnformatted(item) : NULL;
    const bool same = text && expected && strcmp(text, expected) == 0;
    cJSON_free(text);
    return same;
}

bool resume_complete(const options *o, const char *key) {
    char *path = record_name(o, false), *text = path ? read_record(path) : NULL;
    cJSON *record = text ? cJSON_Parse(text) : NULL, *outputs = outputs_of(o);
    char *now = outputs ? cJSON_PrintUnformatted(outputs) : NULL;
    const bool complete = prints_as(cJSON_GetObjectItem(record, "made_of"), key) &&
                          prints_as(cJSON_GetObjectItem(record, "outputs"), now);
    cJSON_free(now);
    cJSON_Delete(outputs);
    cJSON_Delete(record);
    free(text);
    free(path);
    return complete;
}

/* In one go. A record that is cut off is none, and costs no more than another rendering. */
static bool write_record(const char *path, const char *text) {
    const size_t size = strlen(text);
    const int file = open(path, O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW | O_CLOEXEC, 0666);
    if (file < 0) return false;
    const bool written = write(file, text, size) == (ssize_t)size;
    return close(file) == 0 && written;
}

void resume_record(const options *o, const char *key) {
    char *folder = record_name(o, true), *path = record_name(o, false);
    cJSON *record = cJSON_CreateObject();
    cJSON_AddItemToObject(record, "made_of", cJSON_Parse(key));
    cJSON_AddItemToObject(record, "outputs", outputs_of(o));
    char *text = record ? cJSON_Print(record) : NULL;
    errno = ENOMEM;
    const bool there = folder && (mkdir(folder, 0777) == 0 || errno == EEXIST);
    if (!there || !path || !text || !write_record(path, text))
        note("note: %s: %s: %s; --resume will render this frame again", option_text(o, OPT_OUTPUT),
             path ? path : FOLDER, strerror(errno));
    cJSON_free(text);
    cJSON_Delete(record);
    free(folder);
    free(path);
}
