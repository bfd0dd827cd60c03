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

int cpu_mask_of_options(const options *o, unsigned *mask) {
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

int session_open(session *s, const options *o) {
    static const char *const names[] = {"auto", "cpu", "reference"};
    *s = (session){.progress = !option_given(o, OPT_QUIET)};
    ddof_config config = {
        .backend = (ddof_backend)option_number(o, OPT_BACKEND, DDOF_BACKEND_AUTO),
        .threads = (int)option_number(o, OPT_THREADS, 0),
        .log = on_log,
        .log_user = s,
        .progress = on_progress,
        .progress_user = s,
    };
    s->backend = names[config.backend];
    int status = cpu_mask_of_options(o, &config.cpu_mask);
    if (status) return status;
    ddof_status made = ddof_create(&s->context, &config);
    if (made == DDOF_OK) return 0;
    return fail("--backend: %s: %s; try --backend cpu --threads 1", s->backend,
                *s->error ? s->error : ddof_status_text(made));
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
