/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "session.h"

#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "message.h"

#define INTERRUPTED "interrupted; nothing was written"

static volatile sig_atomic_t caught_signal, held;

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
    if (s->progress) progress_show(done);
    return interrupted();
}

static void on_log(void *user, ddof_log_level level, const char *text) {
    session *s = user;
    if (level == DDOF_LOG_WARNING) snprintf(s->warning, sizeof s->warning, "%s", text);
    if (level == DDOF_LOG_ERROR) snprintf(s->error, sizeof s->error, "%s", text);
}

/* In the order of the words of --cpu. */
static const unsigned cpu_bit[] = {DDOF_CPU_BASELINE, DDOF_CPU_AVX2, DDOF_CPU_AVX512, DDOF_CPU_NEON};
static const char *const cpu_word[] = {"baseline", "avx2", "avx512", "neon"};
enum { CPU_WORDS = 4 };

/* The mask of --cpu, checked against this machine; 0: all. Returns 0 or an exit code. */
static int cpu_mask_of_options(const options *o, unsigned *mask) {
    *mask = 0;
    unsigned words = (unsigned)option_number(o, OPT_CPU, 1u << CPU_WORDS);
    if (words & 1u << CPU_WORDS) return 0; /* "all" */
    unsigned available = ddof_cpu_available() | DDOF_CPU_BASELINE;
    char known[64] = "";
    for (int i = 0; i < CPU_WORDS; i++)
        if (available & cpu_bit[i])
            snprintf(known + strlen(known), sizeof known - strlen(known), "%s%s", *known ? ", " : "", cpu_word[i]);
    for (int i = 0; i < CPU_WORDS; i++) {
        if (!(words & 1u << i)) continue;
        if (!(available & cpu_bit[i]))
            return fail_usage("--cpu: '%s' is not on this machine or not in this build; there are: %s", cpu_word[i],
                              known);
        *mask |= cpu_bit[i];
    }
    return 0;
}

/* In the order of the words of --backend. */
static const ddof_backend backends[] = {DDOF_BACKEND_AUTO, DDOF_BACKEND_CPU, DDOF_BACKEND_GL, DDOF_BACKEND_REFERENCE};

ddof_backend backend_of_options(const options *o) {
    const ddof_backend asked = backends[(int)option_number(o, OPT_BACKEND, 0)];
    return asked == DDOF_BACKEND_AUTO ? DDOF_BACKEND_CPU : asked;
}

const char *session_backend_name(const session *s) {
    return s->backend == DDOF_BACKEND_GL ? "gl" : s->backend == DDOF_BACKEND_REFERENCE ? "reference" : "cpu";
}

const char *solver_name(ddof_solver solver) {
    static const char *const names[] = {"cr4+pack", "cr-vanilla", "cr", "cr+pack", "cr4", "cr4+pack", "cr+pcr"};
    return names[solver];
}

const char *surface_name(ddof_surface surface) {
    return surface == DDOF_SURFACE_RGBA32F ? "rgba32f" : "rgba16f";
}

void session_add_gl(const session *s, cJSON *object, const ddof_settings *settings, const ddof_stats *stats,
                    double pixels) {
    if (s->backend != DDOF_BACKEND_GL) return;
    json_text(object, "solver", solver_name(settings->solver));
    json_text(object, "surface", surface_name(settings->surface));
    cJSON_AddBoolToObject(object, "shared_chain", settings->shared_chain);
    json_integer(object, "surface_bytes", (double)stats->surface_bytes);
    json_number(object, "surface_bytes_per_pixel", (double)stats->surface_bytes / pixels);
}

static int check_gl_options(const options *o, ddof_backend backend) {
    static const option_id only_gl[] = {OPT_SOLVER, OPT_SURFACE, OPT_SHARED_CHAIN};
    for (size_t i = 0; i < sizeof only_gl / sizeof *only_gl; i++)
        if (option_given(o, only_gl[i]) && backend != DDOF_BACKEND_GL)
            return fail_usage("--%s: belongs to the GL backend; add --backend gl", option_table[only_gl[i]].name);
    return 0;
}

int session_open(session *s, const options *o) {
    const ddof_backend backend = backend_of_options(o);
    int status = check_gl_options(o, backend);
    return status ? status : session_open_as(s, o, backend);
}

int session_open_as(session *s, const options *o, ddof_backend backend) {
    *s = (session){.progress = !option_given(o, OPT_QUIET), .backend = backend};
    ddof_config config = {
        .backend = backend,
        .threads = (int)option_number(o, OPT_THREADS, 0),
        .log = on_log,
        .log_user = s,
        .progress = on_progress,
        .progress_user = s,
    };
    int status = cpu_mask_of_options(o, &config.cpu_mask);
    if (status) return status;
    ddof_status made = ddof_create(&s->context, &config);
    if (made == DDOF_OK) return 0;
    const char *why = *s->error ? s->error : ddof_status_text(made);
    if (backend == DDOF_BACKEND_GL) return fail("--backend gl: %s; use --backend cpu", why);
    return fail("--backend: %s: %s; try --backend cpu --threads 1", session_backend_name(s), why);
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
    if (status == DDOF_ERROR_MEMORY)
        return fail("%s: %s; close other programs or render a smaller picture", about,
                    *text ? text : ddof_status_text(status));
    return fail("%s: %s", about, *text ? text : ddof_status_text(status));
}
