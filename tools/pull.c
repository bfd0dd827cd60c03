/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "pull.h"

#include "message.h"

/* Two sources of one thing. Of what is interpolated from frame to frame one of the two would be ignored. */
static int check_animated(const options *o, const animation *keys) {
    static const option_id both[][2] = {{OPT_FOCUS, OPT_FOCUS},
                                        {OPT_FOCUS, OPT_FOCUS_AT},
                                        {OPT_FOCUS, OPT_AUTOFOCUS},
                                        {OPT_FOCUS_AT, OPT_FOCUS},
                                        {OPT_FOCUS_AT, OPT_FOCUS_AT},
                                        {OPT_FOCUS_AT, OPT_AUTOFOCUS},
                                        {OPT_FOCUS_RANGE, OPT_FOCUS_RANGE},
                                        {OPT_FSTOP, OPT_FSTOP},
                                        {OPT_FOCAL_LENGTH, OPT_FOCAL_LENGTH}};
    for (size_t i = 0; i < sizeof both / sizeof *both; i++)
        if (animation_has(keys, both[i][0]) && option_given(o, both[i][1]))
            return fail_usage(
                "--%s: cannot be used together with --animate, whose file %s has keys for %s; leave one of them out",
                option_table[both[i][1]].name, option_text(o, OPT_ANIMATE), option_table[both[i][0]].name);
    return 0;
}

int pull_open(pull *p, const options *o, const sequence *frames) {
    *p = (pull){0};
    int status = option_given(o, OPT_ANIMATE) ? animation_read(&p->keys, option_text(o, OPT_ANIMATE)) : 0;
    if (status == 0 && p->keys) status = check_animated(o, p->keys);
    if (status == 0 && option_given(o, OPT_FOCUS_SMOOTH) && !option_given(o, OPT_AUTOFOCUS))
        status = fail_usage("--focus-smooth: needs --autofocus too");
    if (status == 0 && option_given(o, OPT_AUTOFOCUS)) status = autofocus_open(&p->focus, o, frames, p->keys);
    if (status) pull_close(p);
    return status;
}

void pull_close(pull *p) {
    animation_free(p->keys);
    autofocus_close(p->focus);
    *p = (pull){0};
}

int pull_apply(const pull *p, frame_options *f) {
    const long named = frame_of_name(f->o.file[0]);
    const int frame = f->o.frame >= 0 ? f->o.frame : named >= 0 ? (int)named : 1;
    const int status = p->keys ? animation_apply(p->keys, f, frame) : 0;
    return status || !p->focus ? status : autofocus_apply(p->focus, f, frame);
}
