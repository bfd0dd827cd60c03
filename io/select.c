/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Which channels are the colour and which one is the depth. Names are all there is to go by: "R", "layer.R",
 * "view.layer.R" (https://openexr.com/en/latest/TechnicalIntroduction.html, "Layers"), and the habits of renderers. */
#include <ctype.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "format.h"

/* ------------------------------------------------------------------------- names */

static const char *last_name(const char *name) {
    const char *dot = strrchr(name, '.');
    return dot ? dot + 1 : name;
}

static size_t prefix_length(const char *name) {
    return (size_t)(last_name(name) - name);
}

static bool same_prefix(const char *a, const char *b) {
    return prefix_length(a) == prefix_length(b) && memcmp(a, b, prefix_length(a)) == 0;
}

static bool contains(const char *text, const char *word) {
    size_t length = strlen(word);
    for (; *text; text++)
        if (strncasecmp(text, word, length) == 0) return true;
    return false;
}

static bool like_beauty(const char *text) {
    return contains(text, "combined") || contains(text, "rgba") || contains(text, "beauty");
}

static bool like_depth(const char *text) {
    return contains(text, "depth") || contains(text, "zbuf");
}

static bool is_z(const char *name) {
    return strcasecmp(name, "Z") == 0;
}

static bool usable(const io_part *part) {
    return !part->deep;
}

/* The channel `prefix` + one of the names, in any case when `any_case`. */
static int find(const io_part *part, const char *prefix, size_t length, const char *const *names, bool any_case) {
    for (; *names; names++)
        for (int i = 0; i < part->channel_count; i++) {
            const char *name = part->channel[i].name;
            if (prefix_length(name) == length && memcmp(name, prefix, length) == 0 &&
                (any_case ? strcasecmp : strcmp)(name + length, *names) == 0)
                return i;
        }
    return -1;
}

static int find_one(const io_part *part, const char *prefix, size_t length, const char *name) {
    const char *const names[] = {name, NULL};
    return find(part, prefix, length, names, false);
}

void io_list_channels(const io_picture *picture, char *text, size_t size) {
    size_t used = 0;
    text[0] = '\0';
    for (int p = 0; p < picture->part_count; p++)
        for (int c = 0; c < picture->part[p].channel_count; c++) {
            const io_part *part = &picture->part[p];
            const char *colon = picture->part_count > 1 && part->name[0] ? ":" : "";
            int length = snprintf(text + used, size - used, "%s%s%s%s%s", used ? ", " : "", colon[0] ? part->name : "",
                                  colon, part->channel[c].name, part->deep ? " (deep)" : "");
            if (length < 0 || used + (size_t)length + 8 > size) {
                snprintf(text + used, size - used, ", ...");
                return;
            }
            used += (size_t)length;
        }
}

/* ------------------------------------------------------------------------- views */

static bool is_word(const char *text, size_t length, const char *word) {
    return strlen(word) == length && memcmp(text, word, length) == 0;
}

/* Where in the channel's name the word lies that is a view, or NULL; with the dot behind it it has *length characters. */
static const char *view_word(const io_part *part, const char *name, const char **view, size_t *length) {
    const char *last = last_name(name), *start = last > name ? last - 1 : name;
    while (start > name && start[-1] != '.') start--;
    const char *const places[] = {start, name};
    for (int i = 0; i < 2 && last > name; i++)
        for (int v = 0; v < part->view_count; v++) {
            const size_t size = strcspn(places[i], ".");
            if (!is_word(places[i], size, part->views[v])) continue;
            *view = part->views[v];
            *length = size + 1;
            return places[i];
        }
    return NULL;
}

const char *io_channel_view(const io_part *part, int channel) {
    const char *view = part->view;
    size_t length;
    view_word(part, part->channel[channel].name, &view, &length);
    return view;
}

void io_channel_plain_name(const io_part *part, int channel, char *name, size_t size) {
    const char *whole = part->channel[channel].name, *view;
    size_t length;
    const char *word = view_word(part, whole, &view, &length);
    if (word)
        snprintf(name, size, "%.*s%s", (int)(word - whole), whole, word + length);
    else
        snprintf(name, size, "%s", whole);
}

static int add_view(const char **views, int count, int most, const char *view) {
    for (int i = 0; i < count && i < most; i++)
        if (strcmp(views[i], view) == 0) return count;
    if (!view[0]) return count;
    if (count < most) views[count] = view;
    return count + 1;
}

int io_views(const io_picture *picture, const char **views, int most) {
    int count = 0;
    for (int p = 0; p < picture->part_count; p++) {
        const io_part *part = &picture->part[p];
        if (!usable(part)) continue;
        count = add_view(views, count, most, part->view);
        for (int v = 0; v < part->view_count; v++) count = add_view(views, count, most, part->views[v]);
    }
    return count;
}

/* ------------------------------------------------------------------------- colour */

static void choose(io_selection *s, const io_part *part, int index, size_t prefix, const int *channels, int count,
                   int alpha) {
    *s = (io_selection){.part = index, .count = count};
    memcpy(s->channel, channels, (size_t)count * sizeof *channels);
    if (alpha >= 0) {
        s->channel[s->count++] = alpha;
        s->alpha = true;
    }
    if (prefix < sizeof s->prefix) memcpy(s->prefix, part->channel[channels[0]].name, prefix);
}

static bool choose_rgb(const io_picture *picture, int index, const char *prefix, size_t length, bool any_case,
                       io_selection *s) {
    static const char *const exact[4][3] = {{"R"}, {"G"}, {"B"}, {"A"}};
    static const char *const loose[4][3] = {{"R", "red"}, {"G", "green"}, {"B", "blue"}, {"A", "alpha"}};
    const io_part *part = &picture->part[index];
    int channels[4];
    for (int i = 0; i < 4; i++)
        channels[i] = find(part, prefix, length, any_case ? loose[i] : exact[i], any_case);
    if (channels[0] < 0 || channels[1] < 0 || channels[2] < 0) return false;
    choose(s, part, index, length, channels, 3, channels[3]);
    return true;
}

static bool choose_grey(const io_picture *picture, int index, const char *prefix, size_t length, io_selection *s) {
    const io_part *part = &picture->part[index];
    int y = find_one(part, prefix, length, "Y");
    if (y < 0) return false;
    choose(s, part, index, length, &y, 1, find_one(part, prefix, length, "A"));
    return true;
}

/* Any prefix of the part that `accept` likes (NULL: any). */
static bool choose_prefixed(const io_picture *picture, int index, bool (*accept)(const char *), bool any_case,
                            io_selection *s) {
    const io_part *part = &picture->part[index];
    for (int i = 0; i < part->channel_count; i++) {
        const char *name = part->channel[i].name;
        char prefix[256];
        snprintf(prefix, sizeof prefix, "%.*s", (int)prefix_length(name), name);
        if ((!accept || accept(prefix)) && choose_rgb(picture, index, name, prefix_length(name), any_case, s))
            return true;
    }
    return false;
}

enum { UNPREFIXED_BEAUTY, UNPREFIXED, BEAUTY, PREFIXED, GREY, LOOSE, RULES };

static bool by_rule(const io_picture *picture, int index, int rule, io_selection *s) {
    const io_part *part = &picture->part[index];
    switch (rule) {
    /* Renderers that write each layer as a part give them all plain names of channels. */
    case UNPREFIXED_BEAUTY:
        return like_beauty(part->name) && choose_rgb(picture, index, "", 0, false, s);
    case UNPREFIXED:
        return choose_rgb(picture, index, "", 0, false, s);
    case BEAUTY:
        return choose_prefixed(picture, index, like_beauty, false, s);
    case PREFIXED:
        return choose_prefixed(picture, index, NULL, false, s);
    case GREY:
        return choose_grey(picture, index, "", 0, s);
    default:
        return choose_prefixed(picture, index, NULL, true, s);
    }
}

/* Among the parts with this name or view (NULL: all). */
static bool by_rules(const io_picture *picture, const char *part_name, const char *view, io_selection *s) {
    for (int rule = 0; rule < RULES; rule++)
        for (int p = 0; p < picture->part_count; p++) {
            const io_part *part = &picture->part[p];
            if (usable(part) && (!part_name || strcmp(part->name, part_name) == 0) &&
                (!view || strcmp(part->view, view) == 0) && by_rule(picture, p, rule, s))
                return true;
        }
    return false;
}

/* "layer" is a prefix; "part:layer" one in the part of that name. */
static bool by_layer(const io_picture *picture, const char *layer, io_selection *s) {
    for (int p = 0; p < picture->part_count; p++) {
        const io_part *part = &picture->part[p];
        size_t name = strlen(part->name);
        bool in_part = name && strncmp(layer, part->name, name) == 0 && layer[name] == ':';
        char prefix[256];
        int length = snprintf(prefix, sizeof prefix, "%s.", in_part ? layer + name + 1 : layer);
        if (!usable(part) || length >= (int)sizeof prefix) continue;
        if (choose_rgb(picture, p, prefix, (size_t)length, false, s) ||
            choose_grey(picture, p, prefix, (size_t)length, s) ||
            choose_rgb(picture, p, prefix, (size_t)length, true, s))
            return true;
    }
    return by_rules(picture, layer, NULL, s) || by_rules(picture, NULL, layer, s);
}

/* Channels that were found, but whose pixels are not those of a plain picture. */
static int check_selection(const io_picture *picture, const io_selection *s, io_error *error) {
    const io_part *part = &picture->part[s->part];
    size_t length = strlen(s->prefix);
    const char *first = part->channel[s->channel[0]].name;
    if (strcmp(last_name(first), "Y") == 0 &&
        (find_one(part, first, length, "RY") >= 0 || find_one(part, first, length, "BY") >= 0))
        return io_fail(error, "%s: holds luminance and chroma (Y, RY, BY), not R, G, B; convert it to RGB first",
                       picture->path);
    for (int i = 0; i < s->count; i++) {
        const io_channel *channel = &part->channel[s->channel[i]];
        if (channel->x_sampling != 1 || channel->y_sampling != 1)
            return io_fail(error, "%s: the channel '%s' is subsampled; convert the file to full resolution first",
                           picture->path, channel->name);
    }
    return 0;
}

/* Whether two parts' names differ in nothing but the name of their view. */
static bool same_but_view(const io_part *a, const io_part *b) {
    const size_t va = strlen(a->view), vb = strlen(b->view);
    const char *at = va ? strstr(a->name, a->view) : NULL;
    if (!at || !vb) return false;
    const size_t before = (size_t)(at - a->name);
    return strncmp(a->name, b->name, before) == 0 && strncmp(b->name + before, b->view, vb) == 0 &&
           strcmp(at + va, b->name + before + vb) == 0;
}

/* In its own part the other view's name is a word of the prefix. */
static bool by_view_prefix(const io_picture *picture, const io_selection *other, const char *view, io_selection *s) {
    const io_part *part = &picture->part[other->part];
    char plain[256], prefix[2][600];
    io_channel_plain_name(part, other->channel[0], plain, sizeof plain);
    plain[prefix_length(plain)] = 0;
    snprintf(prefix[0], sizeof prefix[0], "%s%s.", plain, view);
    snprintf(prefix[1], sizeof prefix[1], "%s.%s", view, plain);
    for (int i = 0; i < 2 && part->view_count; i++)
        if (choose_rgb(picture, other->part, prefix[i], strlen(prefix[i]), true, s) ||
            choose_grey(picture, other->part, prefix[i], strlen(prefix[i]), s))
            return true;
    if (!part->view_count || strcmp(view, part->view) != 0) return false;
    return choose_rgb(picture, other->part, plain, strlen(plain), true, s) ||
           choose_grey(picture, other->part, plain, strlen(plain), s);
}

int io_select_color_of_view(const io_picture *picture, const io_selection *other, const char *view, io_selection *selection,
                            io_error *error) {
    const io_part *from = &picture->part[other->part];
    *selection = *other;
    if (strcmp(io_channel_view(from, other->channel[0]), view) == 0) return 0;
    if (by_view_prefix(picture, other, view, selection)) return check_selection(picture, selection, error);
    for (int p = 0; p < picture->part_count; p++) {
        const io_part *part = &picture->part[p];
        if (usable(part) && strcmp(part->view, view) == 0 && same_but_view(from, part) &&
            choose_rgb(picture, p, other->prefix, strlen(other->prefix), true, selection))
            return check_selection(picture, selection, error);
    }
    if (by_rules(picture, NULL, view, selection)) return check_selection(picture, selection, error);
    return io_fail(error, "%s: the view '%s' has no colour (R, G, B or Y)", picture->path, view);
}

static bool all_deep(const io_picture *picture) {
    for (int p = 0; p < picture->part_count; p++)
        if (usable(&picture->part[p])) return false;
    return true;
}

/* The first part that is deep, for a message; NULL where none is. */
static const io_part *deep_part(const io_picture *picture) {
    for (int p = 0; p < picture->part_count; p++)
        if (!usable(&picture->part[p])) return &picture->part[p];
    return NULL;
}

/* Samples at many depths in a pixel are no picture; what to do is the same for colour and for depth. */
static int fail_deep(const io_picture *picture, const char *what, io_error *error) {
    const io_part *part = deep_part(picture);
    return io_fail(error,
                   "%s: %s in deep samples (%s%s%s, %dx%d); flatten it in the compositor (Nuke: DeepToImage) to R G B A and Z, and give "
                   "that picture",
                   picture->path, what, part->storage, part->name[0] ? ", part " : "", part->name, part->data.width, part->data.height);
}

static bool deep_has(const io_picture *picture, int (*wanted)(const io_part *part, int channel)) {
    for (int p = 0; p < picture->part_count; p++)
        for (int c = 0; !usable(&picture->part[p]) && c < picture->part[p].channel_count; c++)
            if (wanted(&picture->part[p], c) >= 0) return true;
    return false;
}

int io_select_color(const io_picture *picture, const char *layer, io_selection *selection, io_error *error) {
    char list[600];
    *selection = (io_selection){.part = -1};
    if (layer ? by_layer(picture, layer, selection) : by_rules(picture, NULL, NULL, selection))
        return check_selection(picture, selection, error);
    if (all_deep(picture)) return fail_deep(picture, "its colour lies", error);
    io_list_channels(picture, list, sizeof list);
    if (layer)
        return io_fail(error, "%s: has no layer or part '%s' with R, G, B or Y; its channels are: %s", picture->path,
                       layer, list);
    return io_fail(error, "%s: has no colour (R, G, B or Y); its channels are: %s", picture->path, list);
}

/* ------------------------------------------------------------------------- depth */

/* One of X, Y, Z of a direction or a position, not a depth. */
static bool in_vector(const io_part *part, const char *name) {
    static const char *const x[] = {"X", NULL}, *const y[] = {"Y", NULL};
    size_t length = prefix_length(name);
    return find(part, name, length, x, true) >= 0 && find(part, name, length, y, true) >= 0;
}

/* How good a name for a depth this is: 0 the best, -1 none. */
static int depth_rank(const io_part *part, int channel) {
    static const char *const values[] = {"Z", "Y", "R", "V", "X"};
    const char *name = part->channel[channel].name, *last = last_name(name);
    if (strcmp(name, "Z") == 0) return in_vector(part, name) ? -1 : 0;
    if (is_z(last)) return in_vector(part, name) ? -1 : 1;
    if (like_depth(last)) return 2;
    bool named = like_depth(name) || like_depth(part->name) || is_z(part->name);
    if (named && part->channel_count == 1) return 3;
    /* depth.R or depth.Y of renderers that write a depth as a colour: one of them, and not its alpha. */
    for (int i = 0; named && i < (int)(sizeof values / sizeof values[0]); i++)
        if (strcasecmp(last, values[i]) == 0) return 4 + i;
    return -1;
}

/* Names share the dotted beginning of the colour's: view.layer. Counts the shared words. */
static int shared_words(const char *name, const char *prefix) {
    int words = 0;
    for (size_t i = 0; name[i] && name[i] == prefix[i]; i++)
        words += prefix[i] == '.';
    return words;
}

/* Larger is nearer to the colour. */
static int nearness(const io_picture *picture, int part, int channel, const io_selection *color) {
    if (!color || color->part < 0) return 0;
    const io_part *a = &picture->part[part];
    const char *name = a->channel[channel].name, *view = io_channel_view(a, channel);
    const char *wanted = io_channel_view(&picture->part[color->part], color->channel[0]);
    bool same_view = strcmp(view, wanted) == 0, some_view = view[0] && wanted[0];
    return (same_view ? 2 : some_view ? 0 : 1) * 1000 + shared_words(name, color->prefix) * 2 + (part == color->part);
}

static void choose_depth(io_selection *s, const io_picture *picture, int part, int channel) {
    const io_part *p = &picture->part[part];
    choose(s, p, part, prefix_length(p->channel[channel].name), &channel, 1, -1);
}

static bool find_depth(const io_picture *picture, const io_selection *color, io_selection *s) {
    int best_near = -1, best_rank = 0;
    for (int p = 0; p < picture->part_count; p++)
        for (int c = 0; usable(&picture->part[p]) && c < picture->part[p].channel_count; c++) {
            int rank = depth_rank(&picture->part[p], c);
            int near = nearness(picture, p, c, color);
            if (rank < 0 || near < best_near || (near == best_near && rank >= best_rank)) continue;
            best_near = near;
            best_rank = rank;
            choose_depth(s, picture, p, c);
        }
    return best_near >= 0;
}

/* "channel", "part:channel", or the name of a layer or part that has one channel only. */
static bool find_named(const io_picture *picture, const char *name, const io_selection *color, io_selection *s) {
    int best = -1;
    for (int p = 0; p < picture->part_count; p++) {
        const io_part *part = &picture->part[p];
        size_t length = strlen(part->name), asked = strlen(name);
        bool in_part = length && strncmp(name, part->name, length) == 0 && name[length] == ':';
        for (int c = 0; usable(part) && c < part->channel_count; c++) {
            const char *have = part->channel[c].name;
            bool whole = strcmp(have, in_part ? name + length + 1 : name) == 0 || strcmp(have, name) == 0;
            bool only = (strcmp(part->name, name) == 0 && part->channel_count == 1) ||
                        (prefix_length(have) == asked + 1 && strncmp(have, name, asked) == 0);
            for (int i = 0; only && i < part->channel_count; i++)
                only = i == c || !same_prefix(part->channel[i].name, have);
            int near = 2 * nearness(picture, p, c, color) + whole;
            if ((whole || only) && near > best) {
                best = near;
                choose_depth(s, picture, p, c);
            }
        }
    }
    return best >= 0;
}

/* A picture that holds nothing else: one channel, or grey with alpha. */
static bool find_only(const io_picture *picture, io_selection *s) {
    const io_part *part = &picture->part[0];
    if (picture->part_count != 1 || !usable(part) || part->channel_count < 1) return false;
    int y = find_one(part, "", 0, "Y"), a = find_one(part, "", 0, "A");
    if (part->channel_count == 1)
        choose_depth(s, picture, 0, 0);
    else if (part->channel_count == 2 && y >= 0 && a >= 0)
        choose_depth(s, picture, 0, y);
    else
        return false;
    return true;
}

int io_select_depth(const io_picture *picture, const char *name, const io_selection *near_color,
                    io_selection *selection, io_error *error) {
    char list[600];
    *selection = (io_selection){.part = -1};
    bool found = name ? find_named(picture, name, near_color, selection)
                      : find_depth(picture, near_color, selection) || (!near_color && find_only(picture, selection));
    if (found) return check_selection(picture, selection, error);
    if (all_deep(picture) || (!name && deep_has(picture, depth_rank))) return fail_deep(picture, "its depth lies", error);
    io_list_channels(picture, list, sizeof list);
    if (name) return io_fail(error, "%s: has no channel '%s'; its channels are: %s", picture->path, name, list);
    return io_fail(error,
                   "%s: has no depth (Z, depth...); name its channel, or give another file; its channels are: %s",
                   picture->path, list);
}
