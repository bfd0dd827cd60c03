/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "channels.h"

#include <ctype.h>
#include <fnmatch.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "message.h"

enum { MOST_VIEWS = 64, NAME = 600, LIST = 600 };

/* ------------------------------------------------------------------------- what is no light */

/* Names of layers, or of channels by themselves, in any case but for `exact`. What is listed in docs/cli.md. */
static const struct {
    const char *pattern, *what;
    bool exact;
} data_names[] = {
    {"z", "depth", false},           {"*depth*", "depth", false},        {"zbuf*", "depth", false},
    {"zback", "depth", false},       {"coc", "CoC", false},              {"*crypto*", "ids", false},
    {"id", "ids", false},            {"*[a-z_]ID", "ids", true},         {"*[a-z]Id", "ids", true},
    {"*[_-]id", "ids", false},       {"id[_-]*", "ids", false},          {"*objectid*", "ids", false},
    {"*materialid*", "ids", false},  {"*instanceid*", "ids", false},     {"index[om][ba]", "ids", false},
    {"*matte*", "mattes", false},    {"*mask*", "masks", false},         {"n", "normals", false},
    {"n[gs]", "normals", false},     {"*normal", "normals", false},      {"*normals", "normals", false},
    {"normal[_-]*", "normals", false}, {"p", "positions", false},        {"pref", "positions", false},
    {"pworld", "positions", false},  {"*position*", "positions", false}, {"*motion*", "motion", false},
    {"*velocity*", "motion", false}, {"vector", "motion", false},        {"*motionvector*", "motion", false},
    {"mv", "motion", false},         {"disparity*", "offsets", false},         {"forward", "motion", false},       {"backward", "motion", false},
    {"uv", "coordinates", false},    {"st", "coordinates", false},       {"*[_-]uv", "coordinates", false},
    {"uv[_0-9]*", "coordinates", false}, {"*texcoord*", "coordinates", false}, {"*samplecount*", "counts", false},
    {"*variance*", "variances", false},
};

static const char *data_name(const char *word) {
    char lower[NAME];
    size_t i = 0;
    for (; word[i] && i + 1 < sizeof lower; i++) lower[i] = (char)tolower((unsigned char)word[i]);
    lower[i] = 0;
    for (size_t n = 0; n < sizeof data_names / sizeof *data_names; n++)
        if (fnmatch(data_names[n].pattern, data_names[n].exact ? word : lower, 0) == 0) return data_names[n].what;
    return NULL;
}

/* Of a name's words between dots. */
static const char *data_words(const char *text) {
    const char *what = NULL;
    char copy[NAME], *next = NULL;
    snprintf(copy, sizeof copy, "%s", text);
    for (char *word = strtok_r(copy, ".", &next); !what && word; word = strtok_r(NULL, ".", &next)) what = data_name(word);
    return what;
}

static const char *last_word(const char *name) {
    const char *dot = strrchr(name, '.');
    return dot ? dot + 1 : name;
}

static bool has_sibling(const io_part *part, const char *name, const char *word) {
    const size_t length = (size_t)(last_word(name) - name);
    for (int i = 0; i < part->channel_count; i++) {
        const char *other = part->channel[i].name;
        if (strncmp(other, name, length) == 0 && strcasecmp(other + length, word) == 0) return true;
    }
    return false;
}

/* X Y (Z), or u v: parts of one direction or place. */
static bool in_vector(const io_part *part, const char *name) {
    static const char *const pairs[][2] = {{"X", "Y"}, {"X", "Z"}, {"Y", "Z"}, {"U", "V"}};
    const char *last = last_word(name);
    for (size_t p = 0; p < sizeof pairs / sizeof *pairs; p++)
        for (int i = 0; i < 2; i++)
            if (strcasecmp(last, pairs[p][i]) == 0 && has_sibling(part, name, pairs[p][!i])) return true;
    return false;
}

const char *channels_data(const io_part *part, int channel) {
    char name[NAME];
    if (part->channel[channel].type == IO_UINT) return "integers";
    io_channel_plain_name(part, channel, name, sizeof name);
    const char *what = data_words(name);
    if (!what) what = data_words(part->name);
    if (!what && in_vector(part, part->channel[channel].name)) what = "vectors";
    return what;
}

/* ------------------------------------------------------------------------- choosing */

enum { UNNAMED, DATA, BY_PATTERN, BY_NAME, TAKEN };

typedef struct chooser {
    channel_choice *choice;
    const io_picture *picture;
    const options *o;
    unsigned char **mark; /* [part][channel] */
    int view_count;
    const char *view[MOST_VIEWS]; /* those that are wanted; "": the picture has none */
    const char *home;             /* the view of what belongs to none */
    bool has_base;
    io_selection base; /* what is taken without --channels */
    io_error no_base;
} chooser;

static const char *view_of(const chooser *c, int part, int channel) {
    const char *view = io_channel_view(&c->picture->part[part], channel);
    return view[0] ? view : c->home;
}

static bool view_wanted(const chooser *c, const char *view) {
    for (int i = 0; i < c->view_count; i++)
        if (strcmp(c->view[i], view) == 0) return true;
    return false;
}

static void list_views(const char *const *view, int count, const char *except, char *text, size_t size) {
    size_t used = 0;
    text[0] = 0;
    for (int i = 0; i < count && i < MOST_VIEWS && used < size; i++)
        if (!except || strcmp(view[i], except) != 0)
            used += (size_t)snprintf(text + used, size - used, "%s%s", used ? ", " : "", view[i]);
}

static int wanted_views(chooser *c, const char *const *all, int count) {
    char list[LIST], copy[NAME], *next = NULL;
    const char *text = option_text(c->o, OPT_VIEWS);
    list_views(all, count, NULL, list, sizeof list);
    if (count == 0)
        return fail_usage("--views: %s has no views (a multiView header, or parts with a view); leave it out", c->picture->path);
    if (strcmp(text, "all") == 0) {
        memcpy(c->view, all, (size_t)count * sizeof *all);
        c->view_count = count;
        return 0;
    }
    if (strlen(text) >= sizeof copy) return fail_usage("--views: longer than %d characters", NAME - 1);
    strcpy(copy, text);
    for (char *word = strtok_r(copy, ",", &next); word; word = strtok_r(NULL, ",", &next)) {
        int i = 0;
        while (i < count && strcmp(all[i], word) != 0) i++;
        if (i == count) return fail_usage("--views: %s has no view '%s'; its views are: %s", c->picture->path, word, list);
        if (!view_wanted(c, all[i])) c->view[c->view_count++] = all[i];
    }
    return c->view_count ? 0 : fail_usage("--views: '%s' names no view; its views are: %s", text, list);
}

static int list_all_views(const io_picture *picture, const char **all) {
    const int found = io_views(picture, all, MOST_VIEWS);
    return found < MOST_VIEWS ? found : MOST_VIEWS;
}

static int choose_views(chooser *c) {
    const char *all[MOST_VIEWS];
    const int count = list_all_views(c->picture, all);
    c->home = count ? all[0] : "";
    const char *base = c->has_base ? io_channel_view(&c->picture->part[c->base.part], c->base.channel[0]) : "";
    if (base[0]) c->home = base;
    if (option_given(c->o, OPT_VIEWS)) return wanted_views(c, all, count);
    c->view[c->view_count++] = c->home;
    return 0;
}

/* ------------------------------------------------------------------------- patterns */

/* The name as it stands, without its view, and behind that of its part. */
static bool names_match(const chooser *c, const char *pattern, int p, int channel) {
    const io_part *part = &c->picture->part[p];
    char plain[NAME], with_part[2 * NAME];
    io_channel_plain_name(part, channel, plain, sizeof plain);
    if (fnmatch(pattern, part->channel[channel].name, 0) == 0 || fnmatch(pattern, plain, 0) == 0) return true;
    for (int i = 0; i < 2 && c->picture->part_count > 1 && part->name[0]; i++) {
        snprintf(with_part, sizeof with_part, "%.*s%c%s", NAME - 2, part->name, ".:"[i], plain);
        if (fnmatch(pattern, with_part, 0) == 0) return true;
    }
    return false;
}

static void mark(chooser *c, int p, int channel, bool wildcard) {
    unsigned char *m = &c->mark[p][channel];
    const int found = !wildcard ? BY_NAME : channels_data(&c->picture->part[p], channel) ? DATA : BY_PATTERN;
    if (*m < found) *m = (unsigned char)found;
}

static int fail_unmatched(const chooser *c, const char *pattern, const char *other_view, bool deep) {
    char list[LIST];
    io_list_channels(c->picture, list, sizeof list);
    if (other_view)
        return fail_usage("--channels: '%s' names channels of the view '%s' only; add --views all, or its name", pattern, other_view);
    if (deep)
        return fail("%s: what --channels '%s' names are deep samples; flatten them in the compositor first", c->picture->path,
                    pattern);
    return fail_usage("--channels: %s has no channel '%s'; its channels are: %s", c->picture->path, pattern, list);
}

static int apply_pattern(chooser *c, const char *pattern) {
    const bool wildcard = strpbrk(pattern, "*?[") != NULL;
    const char *other_view = NULL;
    bool any = false, deep = false;
    for (int p = 0; p < c->picture->part_count; p++)
        for (int i = 0; i < c->picture->part[p].channel_count; i++) {
            const io_part *part = &c->picture->part[p];
            if (!names_match(c, pattern, p, i)) continue;
            const char *view = view_of(c, p, i);
            if (part->deep) {
                deep = true;
            } else if (!view_wanted(c, view)) {
                other_view = view;
            } else {
                if (!wildcard && part->channel[i].type == IO_UINT)
                    return fail("%s: the channel %s holds integers, which cannot be blurred; leave it out of --channels",
                                c->picture->path, part->channel[i].name);
                mark(c, p, i, wildcard);
                any = true;
            }
        }
    return any ? 0 : fail_unmatched(c, pattern, other_view, deep);
}

/* ------------------------------------------------------------------------- images and groups */

static bool same_box(io_box a, io_box b) {
    return a.x == b.x && a.y == b.y && a.width == b.width && a.height == b.height;
}

static channel_group *group_for(chooser *c, const io_selection *s) {
    const io_part *part = &c->picture->part[s->part];
    const char *view = view_of(c, s->part, s->channel[0]);
    for (int g = 0; g < c->choice->count; g++) {
        channel_group *group = &c->choice->group[g];
        const io_part *other = &c->picture->part[group->color[0].part];
        if (strcmp(group->view, view) == 0 && same_box(part->data, other->data) && same_box(part->display, other->display))
            return group;
    }
    channel_group *larger = realloc(c->choice->group, (size_t)(c->choice->count + 1) * sizeof *larger);
    if (!larger) return NULL;
    c->choice->group = larger;
    larger[c->choice->count] = (channel_group){.view = view};
    return &larger[c->choice->count++];
}

static int add_image(chooser *c, const io_selection *s) {
    channel_group *group = group_for(c, s);
    io_selection *larger = group ? realloc(group->color, (size_t)(group->count + 1) * sizeof *larger) : NULL;
    if (!larger) return fail("%s: out of memory for its channels", c->picture->path);
    group->color = larger;
    larger[group->count++] = *s;
    for (int i = 0; i < s->count; i++) c->mark[s->part][s->channel[i]] = TAKEN;
    return 0;
}

/* "RGBA" in each view. */
static int add_base(chooser *c) {
    if (!c->has_base) return fail("%s", c->no_base.text);
    for (int v = 0; v < c->view_count; v++) {
        io_selection s = c->base;
        io_error error = {0};
        if (c->view[v][0] && (c->view_count > 1 || option_given(c->o, OPT_VIEWS)) &&
            io_select_color_of_view(c->picture, &c->base, c->view[v], &s, &error))
            return fail("%s", error.text);
        if (c->mark[s.part][s.channel[0]] == TAKEN) continue;
        const int status = add_image(c, &s);
        if (status) return status;
    }
    return 0;
}

/* The channel of the same layer with this last word, if it is to be blurred; else -1. */
static int companion(const chooser *c, int p, int channel, const char *word, const char *long_word) {
    const io_part *part = &c->picture->part[p];
    const char *name = part->channel[channel].name;
    const size_t length = (size_t)(last_word(name) - name);
    for (int i = 0; i < part->channel_count; i++) {
        const char *other = part->channel[i].name, *last = last_word(other);
        if (c->mark[p][i] != BY_PATTERN && c->mark[p][i] != BY_NAME) continue;
        if ((size_t)(last - other) == length && memcmp(other, name, length) == 0 &&
            (strcasecmp(last, word) == 0 || strcasecmp(last, long_word) == 0))
            return i;
    }
    return -1;
}

/* The image that a channel is part of: R G B and A of its layer, Y and A, or itself. */
static io_selection image_of(const chooser *c, int p, int channel) {
    const char *name = c->picture->part[p].channel[channel].name;
    const int r = companion(c, p, channel, "R", "red"), g = companion(c, p, channel, "G", "green"),
              b = companion(c, p, channel, "B", "blue"), y = companion(c, p, channel, "Y", "Y"), a = companion(c, p, channel, "A", "alpha");
    io_selection s = {.part = p, .count = 1, .channel = {channel}};
    snprintf(s.prefix, sizeof s.prefix, "%.*s", (int)(last_word(name) - name), name);
    if (r >= 0 && g >= 0 && b >= 0 && (channel == r || channel == g || channel == b || channel == a)) {
        s = (io_selection){.part = p, .count = 3, .channel = {r, g, b}};
    } else if (y >= 0 && a >= 0 && (channel == y || channel == a)) {
        s = (io_selection){.part = p, .count = 1, .channel = {y}};
    } else {
        return s;
    }
    snprintf(s.prefix, sizeof s.prefix, "%.*s", (int)(last_word(name) - name), name);
    s.alpha = a >= 0;
    if (a >= 0) s.channel[s.count++] = a;
    return s;
}

static int add_marked(chooser *c) {
    int status = 0;
    for (int p = 0; p < c->picture->part_count; p++)
        for (int i = 0; status == 0 && i < c->picture->part[p].channel_count; i++)
            if (c->mark[p][i] == BY_PATTERN || c->mark[p][i] == BY_NAME) {
                const io_selection s = image_of(c, p, i);
                status = add_image(c, &s);
            }
    return status;
}

/* ------------------------------------------------------------------------- what stays sharp */

static void say_sharp(const channel_choice *choice, const io_picture *picture, char *list, size_t size) {
    size_t used = 0;
    list[0] = 0;
    for (int i = 0; i < choice->sharp_count; i++) {
        char name[NAME];
        channels_image_name(picture, &choice->sharp[i], name, sizeof name);
        if (used + 80 >= size) {
            snprintf(list + used, size - used, ", ...");
            return;
        }
        used += (size_t)snprintf(list + used, size - used, "%s%.60s (%s)", used ? ", " : "", name,
                                 channels_data(&picture->part[choice->sharp[i].part], choice->sharp[i].channel[0]));
    }
}

static int list_sharp(chooser *c) {
    char list[LIST];
    channel_choice *choice = c->choice;
    for (int p = 0; p < c->picture->part_count; p++)
        for (int i = 0; i < c->picture->part[p].channel_count; i++) {
            if (c->mark[p][i] != DATA) continue;
            io_selection *larger = realloc(choice->sharp, (size_t)(choice->sharp_count + 1) * sizeof *larger);
            if (!larger) return fail("%s: out of memory for its channels", c->picture->path);
            choice->sharp = larger;
            larger[choice->sharp_count++] = (io_selection){.part = p, .count = 1, .channel = {i}};
        }
    if (channels_count(choice)) return 0;
    say_sharp(choice, c->picture, list, sizeof list);
    return fail_usage("--channels: '%s' names nothing but data that a blur would spoil: %s; to blur a channel all the same, name it "
                      "without wildcard", option_text(c->o, OPT_RENDER_CHANNELS), list);
}

void channels_note(const channel_choice *choice, const io_picture *picture, const options *o) {
    const char *all[MOST_VIEWS];
    char list[LIST];
    if (choice->sharp_count) {
        say_sharp(choice, picture, list, sizeof list);
        note("note: %s: left sharp, since a blur would spoil them: %s; --channels blurs what it names without wildcard",
             picture->path, list);
    }
    list_views(all, list_all_views(picture, all), choice->group[0].view, list, sizeof list);
    if (list[0] && !option_given(o, OPT_VIEWS))
        note("note: %s: the view '%s' is blurred, %s stays sharp; --views all blurs each with its own depth", picture->path,
             choice->group[0].view, list);
}

/* ------------------------------------------------------------------------- all of it */

static int apply_list(chooser *c, const char *text) {
    char *copy = strdup(text), *next = NULL;
    int status = copy ? 0 : fail("--channels: out of memory"), count = 0;
    for (char *word = copy ? strtok_r(copy, ",", &next) : NULL; status == 0 && word; word = strtok_r(NULL, ",", &next), count++)
        if (strcmp(word, "RGBA") != 0) status = apply_pattern(c, word);
    if (status == 0 && count == 0) status = fail_usage("--channels: '%s' names no channel; write it like --channels 'diffuse.*,RGBA'", text);
    if (copy) strcpy(copy, text);
    /* the first image is the one to show */
    for (char *word = copy ? strtok_r(copy, ",", &next) : NULL; status == 0 && word; word = strtok_r(NULL, ",", &next))
        if (strcmp(word, "RGBA") == 0) status = add_base(c);
    free(copy);
    if (status == 0) status = add_marked(c);
    return status ? status : list_sharp(c);
}

static int choose(chooser *c) {
    const char *layer = option_text(c->o, OPT_LAYER), *text = option_text(c->o, OPT_RENDER_CHANNELS);
    c->has_base = io_select_color(c->picture, layer, &c->base, &c->no_base) == 0;
    if (!c->has_base && (layer || !text)) return fail("%s", c->no_base.text);
    c->mark = calloc((size_t)c->picture->part_count, sizeof *c->mark);
    for (int p = 0; c->mark && p < c->picture->part_count; p++)
        if (!(c->mark[p] = calloc((size_t)c->picture->part[p].channel_count + 1, 1)))
            return fail("%s: out of memory for its channels", c->picture->path);
    if (!c->mark) return fail("%s: out of memory for its channels", c->picture->path);
    const int status = choose_views(c);
    if (status) return status;
    return text ? apply_list(c, text) : add_base(c);
}

int channels_choose(channel_choice *choice, const io_picture *picture, const options *o) {
    chooser c = {.choice = choice, .picture = picture, .o = o};
    *choice = (channel_choice){0};
    const int status = choose(&c);
    for (int p = 0; c.mark && p < picture->part_count; p++) free(c.mark[p]);
    free(c.mark);
    if (status) channels_free(choice);
    return status;
}

void channels_free(channel_choice *choice) {
    for (int g = 0; g < choice->count; g++) free(choice->group[g].color);
    free(choice->group);
    free(choice->sharp);
    *choice = (channel_choice){0};
}

int channels_count(const channel_choice *choice) {
    int count = 0;
    for (int g = 0; g < choice->count; g++) count += choice->group[g].count;
    return count;
}

void channels_image_name(const io_picture *picture, const io_selection *color, char *name, size_t size) {
    const io_part *part = &picture->part[color->part];
    const char *first = part->channel[color->channel[0]].name;
    const size_t prefix = strlen(color->prefix);
    size_t used = 0;
    if (picture->part_count > 1 && part->name[0]) used = (size_t)snprintf(name, size, "%s:", part->name);
    if (used >= size) return;
    if (color->count == 1) {
        snprintf(name + used, size - used, "%s", first);
    } else if (prefix > 1) {
        snprintf(name + used, size - used, "%.*s", (int)prefix - 1, color->prefix);
    } else {
        for (int i = 0; i < color->count && used < size; i++)
            used += (size_t)snprintf(name + used, size - used, "%s", part->channel[color->channel[i]].name);
    }
}
