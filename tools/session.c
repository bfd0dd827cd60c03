/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "session.h"

#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "message.h"
#include "scratch.h"

#define INTERRUPTED "interrupted; nothing was written"

static atomic_int caught_signal, held; /* lock-free: a handler may write what threads read */

static void on_signal(int number) {
    static const char line[] = "ddof: " INTERRUPTED "\n";
    caught_signal = number;
    if (held) return;
    if (write(STDERR_FILENO, line, sizeof line - 1) < 0) _exit(EXIT_WORK); /* the result of write must be looked at */
    _exit(EXIT_INTERRUPTED);
}

void catch_signals(void) {
    struct sigaction action = {.sa_handler = on_signal, .sa_flags = (int)SA_RESETHAND | SA_RESTART};
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    /* A file size limit is an error of the write that meets it, not the end of the process with half a file left. */
    struct sigaction ignore = {.sa_handler = SIG_IGN};
    sigemptyset(&ignore.sa_mask);
    sigaction(SIGXFSZ, &ignore, NULL);
}

void signals_hold(void) {
    held = 1;
}

bool interrupted(void) {
    return caught_signal != 0;
}

int fail_interrupted(void) {
    fail(INTERRUPTED);
    return EXIT_INTERRUPTED;
}

static int on_progress(void *user, double done) {
    const session *s = user;
    scratch_pace();
    if (s->progress) progress_show(done);
    return interrupted();
}

static void *allocate(void *user, size_t bytes) {
    (void)user;
    return scratch_allocate(bytes);
}

static void release(void *user, void *block) {
    (void)user;
    scratch_release(block);
}

static void on_log(void *user, ddof_log_level level, const char *text) {
    session *s = user;
    if (level == DDOF_LOG_WARNING) snprintf(s->warning, sizeof s->warning, "%s", text);
    if (level == DDOF_LOG_ERROR) snprintf(s->error, sizeof s->error, "%s", text);
}

const cpu_set cpu_sets[CPU_SETS] = {
    {DDOF_CPU_BASELINE, "baseline"}, {DDOF_CPU_AVX2, "avx2"}, {DDOF_CPU_AVX512, "avx512"}, {DDOF_CPU_NEON, "neon"}};

/* The mask of --cpu, checked against this machine; 0: all. Returns 0 or an exit code. */
static int cpu_mask_of_options(const options *o, unsigned *mask) {
    *mask = 0;
    unsigned words = (unsigned)option_number(o, OPT_CPU, 1u << CPU_SETS);
    if (words & 1u << CPU_SETS) return 0; /* "all" */
    unsigned available = ddof_cpu_available() | DDOF_CPU_BASELINE;
    char known[64] = "";
    for (int i = 0; i < CPU_SETS; i++)
        if (available & cpu_sets[i].bit)
            snprintf(known + strlen(known), sizeof known - strlen(known), "%s%s", *known ? ", " : "", cpu_sets[i].word);
    for (int i = 0; i < CPU_SETS; i++) {
        if (!(words & 1u << i)) continue;
        if (!(available & cpu_sets[i].bit))
            return fail_usage("--cpu: '%s' is not on this machine or not in this build; there are: %s",
                              cpu_sets[i].word, known);
        *mask |= cpu_sets[i].bit;
    }
    return 0;
}

/* ------------------------------------------------------------------------- what a GPU backend adds to a report */

static bool on_gpu(const session *s) {
    return s->backend == DDOF_BACKEND_GL || s->backend == DDOF_BACKEND_VULKAN;
}

void session_add_gpu(const session *s, cJSON *object, const ddof_settings *settings, const ddof_stats *stats,
                     double pixels) {
    if (!on_gpu(s)) return;
    json_text(object, "solver", solver_name(s->backend, settings->solver));
    json_text(object, "surface", surface_name(settings->surface));
    if (s->backend == DDOF_BACKEND_GL) cJSON_AddBoolToObject(object, "shared_chain", settings->shared_chain);
    if (s->backend == DDOF_BACKEND_VULKAN) json_integer(object, "device_index", s->device);
    json_integer(object, "surface_bytes", (double)stats->surface_bytes);
    json_number(object, "surface_bytes_per_pixel", (double)stats->surface_bytes / pixels);
}

void session_print_gpu(FILE *out, const session *s, const ddof_settings *settings, const ddof_stats *stats, double pixels) {
    if (!on_gpu(s)) return;
    fprintf(out, "%s: %s%s, %s, %.1f bytes of surfaces per pixel\n", backend_name(s->backend),
           solver_name(s->backend, settings->solver), settings->shared_chain ? ", shared chain" : "",
           surface_name(settings->surface), (double)stats->surface_bytes / pixels);
}

/* ------------------------------------------------------------------------- life */

/* Returns 0 or an exit code; where the library refused, nothing is printed, *made says how and s->error why. */
static int open_quietly(session *s, const options *o, ddof_backend backend, ddof_status *made) {
    *s = (session){.progress = !option_given(o, OPT_QUIET), .backend = backend};
    if (backend == DDOF_BACKEND_VULKAN) s->device = (int)option_number(o, OPT_DEVICE, 0);
    ddof_config config = {
        .backend = backend,
        .threads = (int)option_number(o, OPT_THREADS, 0),
        .log = on_log,
        .log_user = s,
        .progress = on_progress,
        .progress_user = s,
        .device = s->device,
    };
    if (scratch_memory()) {
        config.allocate = allocate;
        config.release = release;
    }
    *made = DDOF_OK;
    int status = cpu_mask_of_options(o, &config.cpu_mask);
    if (status) return status;
    *made = ddof_create(&s->context, &config);
    if (*made == DDOF_OK) return 0;
    if (!*s->error) snprintf(s->error, sizeof s->error, "%s", ddof_status_text(*made));
    return EXIT_WORK;
}

static int fail_open(const session *s, const options *o, ddof_status made) {
    if (s->backend == DDOF_BACKEND_VULKAN && made == DDOF_ERROR_INVALID && option_given(o, OPT_DEVICE))
        return fail_usage("--device: there is no Vulkan device %d; 'ddof devices' lists those there are", s->device);
    if (on_gpu(s)) return fail("--backend %s: %s; use --backend cpu", backend_name(s->backend), s->error);
    return fail("--backend: %s: %s; try --backend cpu --threads 1", backend_name(s->backend), s->error);
}

int session_open(session *s, const options *o) {
    backend_choice choice;
    int status = backend_choose(&choice, o);
    if (status) return status;
    if (choice.because) {
        ddof_status made;
        status = open_quietly(s, o, choice.backend, &made);
        if (made == DDOF_OK) return status;
        backend_note_fallback(&choice, s->error);
        choice.backend = DDOF_BACKEND_CPU;
    }
    return session_open_as(s, o, choice.backend);
}

int session_open_as(session *s, const options *o, ddof_backend backend) {
    ddof_status made;
    int status = open_quietly(s, o, backend, &made);
    return made == DDOF_OK ? status : fail_open(s, o, made);
}

void session_note(session *s, const char *about) {
    if (*s->warning) note("note: %s: %s", about, s->warning);
    *s->warning = 0;
}

void session_close(session *s) {
    ddof_destroy(&s->context);
}

int session_fail(const session *s, ddof_status status, const char *about) {
    progress_clear();
    if (status == DDOF_ERROR_CANCELLED) return fail_interrupted();
    const char *text = ddof_error(s->context);
    if (status == DDOF_ERROR_MEMORY && *scratch_error()) return fail("%s", scratch_error());
    if (status == DDOF_ERROR_MEMORY)
        return fail("%s: %s; close other programs or render a smaller picture", about,
                    *text ? text : ddof_status_text(status));
    return fail("%s: %s", about, *text ? text : ddof_status_text(status));
}
