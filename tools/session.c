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

/* Whether something was asked for that the GL backend alone knows; NULL or its name. */
static const char *gl_option_given(const options *o) {
    static const option_id only_gl[] = {OPT_SOLVER, OPT_SURFACE, OPT_SHARED_CHAIN};
    for (size_t i = 0; i < sizeof only_gl / sizeof *only_gl; i++)
        if (option_given(o, only_gl[i])) return option_table[only_gl[i]].name;
    return NULL;
}

/* "auto" said in so many words, beside an option for GL: GL where it can be had. */
static bool prefers_gl(const options *o) {
    return option_given(o, OPT_BACKEND) && option_number(o, OPT_BACKEND, 0) == 0 && gl_option_given(o);
}

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

/* Returns 0 or an exit code; where the library refused, nothing is printed and s->error says why. */
static int open_quietly(session *s, const options *o, ddof_backend backend, bool *refused) {
    *s = (session){.progress = !option_given(o, OPT_QUIET), .backend = backend};
    ddof_config config = {
        .backend = backend,
        .threads = (int)option_number(o, OPT_THREADS, 0),
        .log = on_log,
        .log_user = s,
        .progress = on_progress,
        .progress_user = s,
    };
    *refused = false;
    int status = cpu_mask_of_options(o, &config.cpu_mask);
    if (status) return status;
    ddof_status made = ddof_create(&s->context, &config);
    if (made == DDOF_OK) return 0;
    *refused = true;
    if (!*s->error) snprintf(s->error, sizeof s->error, "%s", ddof_status_text(made));
    return EXIT_WORK;
}

int session_open(session *s, const options *o) {
    const ddof_backend backend = backend_of_options(o);
    const char *option = gl_option_given(o);
    bool refused;
    if (prefers_gl(o)) {
        int status = open_quietly(s, o, DDOF_BACKEND_GL, &refused);
        if (!refused) return status;
        note("note: --backend auto: %s; the CPU engine does the work, without --%s", s->error, option);
    } else if (option && backend != DDOF_BACKEND_GL) {
        return fail_usage("--%s: belongs to the GL backend; add --backend gl", option);
    }
    return session_open_as(s, o, backend);
}

int session_open_as(session *s, const options *o, ddof_backend backend) {
    bool refused;
    int status = open_quietly(s, o, backend, &refused);
    if (!refused) return status;
    if (backend == DDOF_BACKEND_GL) return fail("--backend gl: %s; use --backend cpu", s->error);
    return fail("--backend: %s: %s; try --backend cpu --threads 1", session_backend_name(s), s->error);
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
