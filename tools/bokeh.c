/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "bokeh.h"

#include "lens.h"
#include "message.h"

static const option_id highlight_options[] = {OPT_BOKEH_THRESHOLD, OPT_MAX_SPRITES, OPT_MAX_SPRITE_AREA};
static const option_id sprite_options[] = {OPT_IRIS, OPT_BOKEH_LIMIT, OPT_BOKEH_RESOLUTION, OPT_APPEND, OPT_QUADS};

ddof_bokeh bokeh_of_options(const options *o) {
    const ddof_method method = method_of_options(o);
    if (option_given(o, OPT_BOKEH)) return (ddof_bokeh)option_number(o, OPT_BOKEH, 0);
    if (method == DDOF_METHOD_SCATTER) return DDOF_BOKEH_FULL;
    /* the figures of a bench stay comparable */
    if (method != DDOF_METHOD_DIFFUSION || o->command == COMMAND_BENCH) return DDOF_BOKEH_OFF;
    return option_number(o, OPT_KERNEL, DDOF_KERNEL_HEAT) == DDOF_KERNEL_DISC ? DDOF_BOKEH_HIGHLIGHTS : DDOF_BOKEH_OFF;
}

/* --bokeh beside a method that is not diffusion. */
static int check_method(ddof_method method, ddof_bokeh bokeh) {
    if (method == DDOF_METHOD_SCATTER && bokeh != DDOF_BOKEH_FULL)
        return fail_usage(
            "--bokeh: %s cannot be used together with --method scatter, which draws every pixel; leave one of them out",
            bokeh_name(bokeh));
    if (method != DDOF_METHOD_SCATTER && bokeh == DDOF_BOKEH_HIGHLIGHTS)
        return fail_usage("--bokeh: highlights cannot be used together with --method %s; take --method diffusion",
                          method_name(method));
    if (method != DDOF_METHOD_SCATTER && bokeh == DDOF_BOKEH_FULL)
        return fail_usage("--bokeh: full cannot be used together with --method %s; it is --method scatter",
                          method_name(method));
    return 0;
}

int bokeh_check_options(const options *o) {
    const ddof_method method = method_of_options(o);
    const ddof_bokeh bokeh = bokeh_of_options(o);
    const int status = method == DDOF_METHOD_DIFFUSION ? 0 : check_method(method, bokeh);
    if (status) return status;
    for (size_t i = 0; bokeh != DDOF_BOKEH_HIGHLIGHTS && i < sizeof highlight_options / sizeof *highlight_options; i++)
        if (option_given(o, highlight_options[i]))
            return fail_usage("--%s: needs --bokeh highlights%s", option_table[highlight_options[i]].name,
                              bokeh == DDOF_BOKEH_OFF ? " too"
                                                      : "; here every pixel out of focus is drawn, so leave it out");
    for (size_t i = 0; bokeh == DDOF_BOKEH_OFF && i < sizeof sprite_options / sizeof *sprite_options; i++)
        if (option_given(o, sprite_options[i]))
            return fail_usage("--%s: needs --bokeh highlights or --bokeh full too",
                              option_table[sprite_options[i]].name);
    return 0;
}

static int read_limit(double *fraction, const option_value *limit, int picture_width) {
    if (!limit->given) return 0;
    *fraction = extent_fraction(limit, picture_width);
    if (*fraction <= 1) return 0;
    return fail_usage("--bokeh-limit: %s is more than the picture's width of %d pixels; give at most that", limit->text,
                      picture_width);
}

int bokeh_settings(ddof_settings *settings, const options *o, const iris_input *in, int picture_width) {
    ddof_sprites *sprites = &settings->sprites;
    settings->bokeh = bokeh_of_options(o);
    if (settings->bokeh == DDOF_BOKEH_OFF) return 0;
    settings->iris = in->settings;
    sprites->threshold = option_number(o, OPT_BOKEH_THRESHOLD, 0);
    sprites->max_sprites = (int)option_number(o, OPT_MAX_SPRITES, 0);
    sprites->max_area = (int)option_number(o, OPT_MAX_SPRITE_AREA, 0);
    /* the words stand in the order of the library's names, the first of which is 1 */
    sprites->resolution = (ddof_resolution)(option_number(o, OPT_BOKEH_RESOLUTION, DDOF_RESOLUTION_DEFAULT - 1) + 1);
    sprites->append = (ddof_append)(option_number(o, OPT_APPEND, DDOF_APPEND_DEFAULT - 1) + 1);
    sprites->quads = (ddof_quads)(option_number(o, OPT_QUADS, DDOF_QUADS_DEFAULT - 1) + 1);
    return read_limit(&sprites->limit, &o->value[OPT_BOKEH_LIMIT], picture_width);
}

ddof_method bokeh_method(const ddof_settings *settings) {
    return settings->bokeh == DDOF_BOKEH_FULL ? DDOF_METHOD_SCATTER : settings->method;
}

const char *bokeh_name(ddof_bokeh bokeh) {
    return bokeh == DDOF_BOKEH_OFF ? "off" : bokeh == DDOF_BOKEH_FULL ? "full" : "highlights";
}

const char *bokeh_iris_text(const options *o) {
    return option_given(o, OPT_IRIS) ? option_text(o, OPT_IRIS) : "disc";
}

void bokeh_note(const ddof_stats *stats, const char *about) {
    if (stats->sprites_dropped > 0)
        note("note: %s: %lld bright pixel%s left to diffusion; --max-sprites or --max-sprite-area would let them be "
             "drawn",
             about, (long long)stats->sprites_dropped, stats->sprites_dropped == 1 ? " was" : "s were");
    if (stats->sprites_large > 0)
        note("note: %s: %lld bright pixel%s left to diffusion, out of focus by more than --bokeh-limit", about,
             (long long)stats->sprites_large, stats->sprites_large == 1 ? " was" : "s were");
}
