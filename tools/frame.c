/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "frame.h"

#include <stdio.h>
#include <stdlib.h>

#include "message.h"
#include "pull.h"
#include "scratch.h"
#include "sequence.h"
#include "shot.h"

static int print_report(frame_report *report) {
    if (report->object) {
        cJSON *object = report->object;
        report->object = NULL;
        return json_finish(object);
    }
    if (!report->text) return 0;
    fputs(report->text, stdout);
    return finish_output();
}

/* Options that have no meaning for one picture. */
static int check_single(const options *o) {
    static const option_id of_shots[] = {OPT_RESUME, OPT_KEEP_GOING, OPT_IN_FLIGHT};
    for (size_t i = 0; i < sizeof of_shots / sizeof *of_shots; i++)
        if (option_given(o, of_shots[i]))
            return fail_usage("--%s: is for several frames; give IN a pattern, like shot.####.exr",
                              option_table[of_shots[i]].name);
    return 0;
}

int frame_run(const options *o, frame_work *work, double start) {
    if (sequence_wanted(o)) return shot_run(o, work, start);
    session s = {0};
    pull changes;
    frame_options f = {.o = *o};
    frame_report report = {0};
    int status = check_single(o);
    if (status == 0) status = pull_open(&changes, o, NULL);
    if (status) return status;
    status = scratch_open(o, 1);
    if (status == 0) status = session_open(&s, o); /* what cannot be had is said before minutes of decoding */
    if (status == 0) status = pull_apply(&changes, &f);
    if (status == 0) status = work(&f.o, &s, start, &report);
    session_close(&s);
    pull_close(&changes);
    frame_options_free(&f);
    scratch_close();
    if (status == 0) status = print_report(&report);
    cJSON_Delete(report.object);
    free(report.text);
    return status;
}
