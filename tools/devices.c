/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* ddof devices: everything that could do the work on this machine, and why what cannot, cannot. */
#include <ddof/ddof.h>
#include <stdio.h>
#include <stdlib.h>

#include "bench_report.h"
#include "commands.h"
#include "json.h"
#include "message.h"
#include "session.h"

/* The devices of one backend. */
typedef struct device_list {
    ddof_backend backend;
    ddof_device *device;
    int count;
    char why[512]; /* there is none; "": there are some */
} device_list;

/* ------------------------------------------------------------------------- asking */

static void keep_error(void *user, ddof_log_level level, const char *text) {
    device_list *list = user;
    if (level == DDOF_LOG_ERROR) snprintf(list->why, sizeof list->why, "%s", text);
}

/* A list can be empty for several reasons; the attempt to use the backend says which it was. */
static void ask_why(device_list *list) {
    const ddof_config config = {.backend = list->backend, .threads = 1, .log = keep_error, .log_user = list};
    ddof_context *context = NULL;
    const ddof_status made = ddof_create(&context, &config);
    ddof_destroy(&context);
    if (!*list->why) snprintf(list->why, sizeof list->why, "%s", ddof_status_text(made));
}

static int list_devices(device_list *list, ddof_backend backend) {
    enum { ROOM = 16 };
    *list = (device_list){.backend = backend, .count = ROOM};
    /* asking loads drivers, so that asking for the number alone first would take twice as long */
    for (int room = 0; list->count > room;) {
        room = list->count;
        free(list->device);
        list->device = calloc((size_t)room, sizeof *list->device);
        if (!list->device) return fail("devices: out of memory");
        list->count = ddof_devices(backend, list->device, room);
    }
    if (list->count == 0) ask_why(list);
    return 0;
}

/* The best instruction set's place in cpu_sets; `available`: its bits. */
static int best_cpu_set(unsigned available) {
    int best = 0;
    for (int i = 0; i < CPU_SETS; i++)
        if (available & cpu_sets[i].bit) best = i;
    return best;
}

/* ------------------------------------------------------------------------- for people */

static void print_cpu(unsigned available) {
    char processor[128];
    const int best = best_cpu_set(available);
    processor_name(processor, sizeof processor);
    printf("cpu: %s\n  %s (best)", processor, cpu_sets[best].word);
    for (int i = best - 1; i >= 0; i--)
        if (available & cpu_sets[i].bit) printf(", %s", cpu_sets[i].word);
    putchar('\n');
}

static void print_abilities(const ddof_device *d) {
    printf("     pictures up to %d pixels a side", d->max_side);
    if (d->subgroup_most > 0 && d->subgroup_least == d->subgroup_most)
        printf(", subgroups of %d", d->subgroup_most);
    else if (d->subgroup_most > 0)
        printf(", subgroups of %d to %d", d->subgroup_least, d->subgroup_most);
    if (d->max_workgroup > 0)
        printf(", workgroups of %d threads and %.4g KiB", d->max_workgroup, d->shared_bytes / 1024.0);
    if (d->memory_bytes > 0) printf(", %.1f GiB of memory", (double)d->memory_bytes / (1 << 30));
    putchar('\n');
}

static void print_list(const device_list *list) {
    printf("%s:", backend_name(list->backend));
    if (list->count == 0) printf(" no device: %s", list->why);
    putchar('\n');
    for (int i = 0; i < list->count; i++) {
        const ddof_device *d = &list->device[i];
        printf("  %d: %s", i, *d->name ? d->name : "a device without a name");
        if (*d->driver) printf("; %s", d->driver);
        printf("%s\n", d->is_software ? "; computes on the CPU" : "");
        if (*d->refused)
            printf("     refused: %s\n", d->refused);
        else
            print_abilities(d);
    }
}

/* ------------------------------------------------------------------------- for programs */

static cJSON *cpu_object(unsigned available) {
    char processor[128];
    cJSON *object = cJSON_CreateObject(), *sets = cJSON_CreateArray();
    processor_name(processor, sizeof processor);
    json_text(object, "name", processor);
    json_text(object, "best", cpu_sets[best_cpu_set(available)].word);
    for (int i = 0; i < CPU_SETS; i++)
        if (available & cpu_sets[i].bit) cJSON_AddItemToArray(sets, json_text_item(cpu_sets[i].word));
    cJSON_AddItemToObject(object, "available", sets);
    return object;
}

static cJSON *device_object(const ddof_device *d, int index) {
    cJSON *object = cJSON_CreateObject();
    json_integer(object, "index", index);
    json_text(object, "name", d->name);
    json_text(object, "driver", d->driver);
    cJSON_AddBoolToObject(object, "usable", !*d->refused);
    if (*d->refused)
        json_text(object, "refused", d->refused);
    else
        cJSON_AddNullToObject(object, "refused");
    cJSON_AddBoolToObject(object, "is_software", d->is_software);
    json_integer(object, "max_side", d->max_side);
    json_integer(object, "subgroup_least", d->subgroup_least);
    json_integer(object, "subgroup_most", d->subgroup_most);
    json_integer(object, "max_workgroup", d->max_workgroup);
    json_integer(object, "shared_bytes", d->shared_bytes);
    json_integer(object, "memory_bytes", (double)d->memory_bytes);
    return object;
}

static cJSON *list_object(const device_list *list) {
    cJSON *object = cJSON_CreateObject(), *devices = cJSON_CreateArray();
    for (int i = 0; i < list->count; i++)
        cJSON_AddItemToArray(devices, device_object(&list->device[i], i));
    cJSON_AddItemToObject(object, "devices", devices);
    if (list->count == 0)
        json_text(object, "why_none", list->why);
    else
        cJSON_AddNullToObject(object, "why_none");
    return object;
}

static int print_json(unsigned available, const device_list *gl, const device_list *vulkan) {
    cJSON *object = cJSON_CreateObject();
    json_text(object, "version", ddof_version());
    cJSON_AddItemToObject(object, "cpu", cpu_object(available));
    cJSON_AddItemToObject(object, "gl", list_object(gl));
    cJSON_AddItemToObject(object, "vulkan", list_object(vulkan));
    return json_finish(object);
}

int command_devices(const options *o) {
    const unsigned available = ddof_cpu_available() | DDOF_CPU_BASELINE;
    device_list gl = {0}, vulkan = {0};
    int status = list_devices(&gl, DDOF_BACKEND_GL);
    if (status == 0) status = list_devices(&vulkan, DDOF_BACKEND_VULKAN);
    if (status == 0 && option_given(o, OPT_JSON)) {
        status = print_json(available, &gl, &vulkan);
    } else if (status == 0 && !option_given(o, OPT_QUIET)) {
        print_cpu(available);
        print_list(&gl);
        print_list(&vulkan);
        status = finish_output();
    }
    free(gl.device);
    free(vulkan.device);
    return status;
}
