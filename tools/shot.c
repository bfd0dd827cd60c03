/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "shot.h"

#include <pthread.h>
#include <signal.h>
#include <picture.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

#include "message.h"
#include "pull.h"
#include "resume.h"
#include "scratch.h"
#include "sequence.h"

enum { IN_FLIGHT = 3, MOST_IN_FLIGHT = 64, MOST_TOLD = 20 /* failed frames by name */ };

typedef enum outcome_kind { FRAME_RENDERED, FRAME_SKIPPED, FRAME_FAILED, FRAME_DROPPED, FRAME_KINDS } outcome_kind;

/* Of one frame, until it is printed. */
typedef struct outcome {
    outcome_kind kind;
    int status;
    double seconds;
    char *input, *output;
    frame_report report;
    message_log log;
} outcome;

typedef struct shot {
    const options *o;
    frame_work *work;
    sequence frames;
    pull pull; /* what changes from frame to frame */
    double start;
    options each;     /* `o` with the threads of one frame */
    session *session; /* one for each worker */
    int workers;
    pthread_mutex_t mutex; /* of all below */
    outcome **outcome;     /* by place in the sequence; those printed are NULL again */
    int next, printed, worker;
    int count[FRAME_KINDS];
    int told;    /* failures printed */
    int noted;   /* frames with notes */
    int *failed; /* numbers */
    int status;  /* the first that is not 0 */
    bool usage;  /* a frame met an option that is wrong */
    bool stop;   /* no more frames are begun */
} shot;

/* ------------------------------------------------------------------------- one frame */

static void render(shot *s, session *own, const frame_options *f, outcome *out) {
    const options *o = &f->o;
    const double begin = now_ms();
    char *key = resume_key(o);
    out->log = (message_log){0}; /* what it lacks the frame itself will miss, and say so better */
    if (key && option_given(o, OPT_RESUME) && resume_complete(o, key)) {
        out->kind = FRAME_SKIPPED;
    } else {
        out->status = interrupted() ? fail_interrupted() : s->work(o, own, begin, &out->report);
        out->kind = out->status == 0 ? FRAME_RENDERED : out->status == EXIT_INTERRUPTED ? FRAME_DROPPED : FRAME_FAILED;
        if (key && out->kind == FRAME_RENDERED) resume_record(o, key);
    }
    free(key);
    out->seconds = (now_ms() - begin) / 1e3;
}

static void make_frame(shot *s, session *own, int index, outcome *out) {
    frame_options f;
    message_keep(&out->log);
    out->status = frame_options_make(&f, &s->each, &s->frames, s->frames.frame[index]);
    out->kind = FRAME_FAILED;
    if (out->status == 0) out->status = pull_apply(&s->pull, &f);
    if (out->status == EXIT_INTERRUPTED) out->kind = FRAME_DROPPED;
    if (out->status == 0) {
        out->input = strdup(f.o.file[0]);
        out->output = strdup(option_text(&f.o, OPT_OUTPUT));
        render(s, own, &f, out);
    }
    frame_options_free(&f);
    message_keep(NULL);
}

/* ------------------------------------------------------------------------- what is told of it */

static int frame_json(int frame, outcome *out) {
    static const char *const words[FRAME_KINDS] = {"rendered", "skipped", "failed", "dropped"};
    cJSON *object = out->report.object ? out->report.object : cJSON_CreateObject();
    out->report.object = NULL;
    json_integer(object, "frame", frame);
    json_text(object, "status", words[out->kind]);
    if (!cJSON_HasObjectItem(object, "input") && out->input) json_text(object, "input", out->input);
    if (!cJSON_HasObjectItem(object, "output") && out->output) json_text(object, "output", out->output);
    if (*out->log.error) json_text(object, "error", out->log.error);
    if (out->log.notes) {
        cJSON *notes = cJSON_AddArrayToObject(object, "notes");
        for (int i = 0; i < out->log.notes; i++)
            cJSON_AddItemToArray(notes, json_text_item(out->log.note[i]));
    }
    return json_line(object);
}

/* The reason is told of some, of the others only that they failed. An option that is wrong is no matter of the frame.
 */
static void tell_failure(shot *s, int frame, const outcome *out) {
    if (out->status == EXIT_USAGE && !s->usage)
        fail("%s", out->log.error);
    else if (out->status != EXIT_USAGE && s->told++ < MOST_TOLD)
        fail("frame %d: %s", frame, out->log.error);
    s->usage |= out->status == EXIT_USAGE;
}

static int tell(shot *s, int frame, outcome *out) {
    s->count[out->kind]++;
    if (out->kind == FRAME_FAILED) {
        s->failed[s->count[FRAME_FAILED] - 1] = frame;
        tell_failure(s, frame, out);
    }
    if (out->log.notes && s->noted++ == 0) /* those of the other frames are the same, nearly always */
        for (int i = 0; i < out->log.notes; i++)
            note("%s", out->log.note[i]);
    if (option_given(s->o, OPT_JSON)) return frame_json(frame, out);
    if (option_given(s->o, OPT_QUIET) || out->kind == FRAME_FAILED || out->kind == FRAME_DROPPED) return 0;
    progress_clear();
    if (out->kind == FRAME_SKIPPED)
        printf("%s: complete, left out\n", out->output ? out->output : "?");
    else
        printf("%s: %.2f s\n", out->output ? out->output : "?", out->seconds);
    return finish_output();
}

static void show_progress(const shot *s) {
    char text[128];
    const int made = s->count[FRAME_RENDERED], past = s->printed, left = s->frames.count - past;
    const double seconds = (now_ms() - s->start) / 1e3, rate = made / seconds, rest = rate > 0 ? left / rate : 0;
    if (left == 0) return;
    snprintf(text, sizeof text, "ddof: %d of %d frames, %.2f frames/s, %d:%02d left", past, s->frames.count, rate,
             (int)(rest / 60), (int)rest % 60);
    progress_text(text);
}

static void free_outcome(outcome *out) {
    cJSON_Delete(out->report.object);
    free(out->report.text);
    free(out->input);
    free(out->output);
    free(out);
}

/* Frames end in any order and are told in theirs. Called with the mutex. */
static void hand_in(shot *s, int index, outcome *out) {
    s->outcome[index] = out;
    if (s->status == 0) s->status = out->status;
    /* an option that is wrong is wrong for every frame */
    s->stop |= out->status == EXIT_USAGE || interrupted() || (out->status && !option_given(s->o, OPT_KEEP_GOING));
    while (s->printed < s->next && s->outcome[s->printed]) {
        outcome *first = s->outcome[s->printed];
        const int told = tell(s, s->frames.frame[s->printed], first);
        if (told) {
            s->status = told;
            s->stop = true;
        }
        free_outcome(first);
        s->outcome[s->printed++] = NULL;
    }
    show_progress(s);
}

/* ------------------------------------------------------------------------- all of them */

static void *work(void *argument) {
    shot *s = argument;
    pthread_mutex_lock(&s->mutex);
    session *own = &s->session[s->worker++];
    while (!s->stop && !interrupted() && s->next < s->frames.count) {
        const int index = s->next++;
        pthread_mutex_unlock(&s->mutex);
        outcome *out = calloc(1, sizeof *out);
        if (out) make_frame(s, own, index, out);
        pthread_mutex_lock(&s->mutex);
        if (out) {
            hand_in(s, index, out);
        } else {
            s->status = fail("%s: out of memory", s->o->file[0]);
            s->stop = true;
        }
    }
    pthread_mutex_unlock(&s->mutex);
    return NULL;
}

static double cpu_seconds(void) {
    struct rusage usage;
    if (getrusage(RUSAGE_SELF, &usage) != 0) return 0;
    return (double)(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
           1e-6 * (double)(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}

/* Not begun, or dropped. */
static int untouched_count(const shot *s) {
    return s->frames.count - s->count[FRAME_RENDERED] - s->count[FRAME_SKIPPED] - s->count[FRAME_FAILED];
}

static int summary_json(const shot *s, double seconds) {
    cJSON *object = cJSON_CreateObject();
    json_integer(object, "frames", s->frames.count);
    json_integer(object, "rendered", s->count[FRAME_RENDERED]);
    json_integer(object, "skipped", s->count[FRAME_SKIPPED]);
    cJSON *failed = cJSON_AddArrayToObject(object, "failed");
    for (int i = 0; i < s->count[FRAME_FAILED]; i++)
        cJSON_AddItemToArray(failed, cJSON_CreateNumber(s->failed[i]));
    json_integer(object, "untouched", untouched_count(s));
    json_integer(object, "in_flight", s->workers);
    json_number(object, "total_ms", seconds * 1e3);
    json_number(object, "cores_busy", cpu_seconds() / seconds);
    json_integer(object, "peak_rss_bytes", (double)peak_rss_bytes());
    return json_line(object);
}

static int summarise(const shot *s) {
    const double seconds = (now_ms() - s->start) / 1e3;
    const int made = s->count[FRAME_RENDERED], skipped = s->count[FRAME_SKIPPED], failed = s->count[FRAME_FAILED];
    const int untouched = untouched_count(s);
    progress_clear();
    if (s->usage && made + skipped == 0) return s->status;
    if (option_given(s->o, OPT_JSON)) {
        const int status = summary_json(s, seconds);
        if (status) return status;
    } else if (!option_given(s->o, OPT_QUIET)) {
        printf("%d frames: %d rendered, %d left out, %d failed; %.1f s, %.2f frames/s, %.2f cores busy, %.0f MB\n",
               s->frames.count, made, skipped, failed, seconds, made / seconds, cpu_seconds() / seconds,
               (double)peak_rss_bytes() / 1e6);
        const int status = finish_output();
        if (status) return status;
    }
    if (s->noted > 1) note("%d frames have notes; --json tells those of each", s->noted);
    if (failed > MOST_TOLD) fail("%d more frames failed; --json tells why", failed - MOST_TOLD);
    if (interrupted()) {
        fail("interrupted; %d frames are complete, %d were not begun or dropped; the same command with --resume does "
             "the rest",
             made + skipped, untouched);
        return EXIT_INTERRUPTED;
    }
    if (failed && untouched)
        fail("stopped at the first failure, %d frames were not begun; --keep-going does the others first", untouched);
    return s->status;
}

/* Each worker has a context of its own; between them they have as many threads as one would have. */
static int open_sessions(shot *s) {
    const options *o = s->o;
    s->workers = (int)option_number(o, OPT_IN_FLIGHT, IN_FLIGHT);
    if (s->workers > s->frames.count) s->workers = s->frames.count;
    const int limited = scratch_open(o, s->workers);
    if (limited) return limited;
    const int threads = io_thread_count((int)option_number(o, OPT_THREADS, 0));
    s->each = *o;
    s->each.value[OPT_THREADS].given = true;
    s->each.value[OPT_THREADS].number = (threads + s->workers - 1) / s->workers;
    s->session = calloc((size_t)s->workers, sizeof *s->session);
    s->outcome = calloc((size_t)s->frames.count, sizeof *s->outcome);
    s->failed = malloc((size_t)s->frames.count * sizeof *s->failed);
    if (!s->session || !s->outcome || !s->failed) return fail("%s: out of memory", o->file[0]);
    message_log unheard = {0}; /* what the first says need not be said again */
    for (int i = 0; i < s->workers; i++) {
        if (i == 1) message_keep(&unheard);
        const int status = session_open(&s->session[i], &s->each);
        s->session[i].progress = false;
        message_keep(NULL);
        if (status && i == 0) return status;
        if (status) { /* memory or a device for one may be all there is */
            s->workers = i;
            break;
        }
    }
    return 0;
}

/* Signals go to the main thread, which only waits. */
static int run_workers(shot *s) {
    pthread_t thread[MOST_IN_FLIGHT];
    sigset_t all, before;
    int started = 0;
    sigfillset(&all);
    pthread_sigmask(SIG_BLOCK, &all, &before);
    while (started < s->workers && pthread_create(&thread[started], NULL, work, s) == 0)
        started++;
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    for (int i = 0; i < started; i++)
        pthread_join(thread[i], NULL);
    return started ? 0 : fail("--in-flight: no thread can be had; close other programs");
}

int shot_run(const options *o, frame_work *frame, double start) {
    shot s = {.o = o, .work = frame, .start = start};
    int status = sequence_open(&s.frames, o);
    if (status) return status;
    signals_hold();
    pthread_mutex_init(&s.mutex, NULL);
    status = open_sessions(&s);
    if (status == 0) status = pull_open(&s.pull, &s.each, &s.frames);
    if (status == 0) status = run_workers(&s);
    if (status == 0) status = summarise(&s);
    for (int i = 0; s.outcome && i < s.frames.count; i++)
        if (s.outcome[i]) free_outcome(s.outcome[i]);
    for (int i = 0; s.session && i < s.workers; i++)
        session_close(&s.session[i]);
    scratch_close();
    pthread_mutex_destroy(&s.mutex);
    free(s.session);
    free(s.outcome);
    free(s.failed);
    pull_close(&s.pull);
    sequence_close(&s.frames);
    return status;
}
