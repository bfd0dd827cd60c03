/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Which channels are taken for colour and depth. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "format.h"
#include "support.h"

/* A picture without pixels: "part/view: channel channel ...; part...", channels ending in '/' are subsampled. */
static io_picture *make(const char *text) {
    char copy[2000];
    io_picture *picture = calloc(1, sizeof *picture);
    assert_non_null(picture);
    picture->path = strdup("shot.exr");
    snprintf(copy, sizeof copy, "%s", text);
    char *next_part;
    for (char *at = strtok_r(copy, ";", &next_part); at; at = strtok_r(NULL, ";", &next_part)) {
        char *colon = strchr(at, ':'), *slash = strchr(at, '/'), *next;
        *colon = '\0';
        if (slash && slash < colon) *slash++ = '\0';
        io_box box = {0, 0, 8, 8};
        io_part *part = io_add_part(picture, at + strspn(at, " "), slash && slash < colon ? slash : "", box, box);
        assert_non_null(part);
        for (char *name = strtok_r(colon + 1, " ", &next); name; name = strtok_r(NULL, " ", &next)) {
            size_t length = strlen(name);
            bool half = name[length - 1] == '/';
            if (half) name[length - 1] = '\0';
            if (strcmp(name, "(deep)") == 0)
                part->deep = true;
            else
                assert_non_null(io_add_channel(part, name, IO_HALF, half ? 2 : 1, half ? 2 : 1));
        }
    }
    return picture;
}

/* "2 R G B A" for channels of part 2, "R G B A" for part 0; with '+' where the last is alpha. The message otherwise. */
static const char *describe(const io_picture *picture, int result, const io_selection *s, const io_error *error) {
    static char text[1200];
    if (result != 0) {
        assert_one_line(error, "shot.exr");
        return strcpy(text, error->text);
    }
    int used = s->part ? snprintf(text, sizeof text, "%d ", s->part) : 0;
    for (int i = 0; i < s->count; i++)
        used += snprintf(text + used, sizeof text - (size_t)used, "%s%s%s", i ? " " : "",
                         s->alpha && i == s->count - 1 ? "+" : "", picture->part[s->part].channel[s->channel[i]].name);
    return text;
}

static void color(const char *channels, const char *layer, const char *expected) {
    io_picture *picture = make(channels);
    io_selection s;
    io_error error = {{0}};
    int result = io_select_color(picture, layer, &s, &error);
    const char *got = describe(picture, result, &s, &error);
    if (result == 0 ? strcmp(got, expected) != 0 : !strstr(got, expected))
        fail_msg("colour of '%s' is '%s', not '%s'", channels, got, expected);
    io_close(&picture);
}

static void depth(const char *channels, const char *layer, const char *name, const char *expected) {
    io_picture *picture = make(channels);
    io_selection s, near = {.part = -1};
    io_error error = {{0}};
    bool has_color = io_select_color(picture, layer, &near, &error) == 0;
    int result = io_select_depth(picture, name, has_color ? &near : NULL, &s, &error);
    const char *got = describe(picture, result, &s, &error);
    if (result == 0 ? strcmp(got, expected) != 0 : !strstr(got, expected))
        fail_msg("depth of '%s' is '%s', not '%s'", channels, got, expected);
    io_close(&picture);
}

static void test_color(void **state) {
    (void)state;
    color(":A B G R Z", NULL, "R G B +A");
    color(":B G R Z", NULL, "R G B");
    color(":B G R diffuse.R diffuse.G diffuse.B", NULL, "R G B");
    color(":Y A", NULL, "Y +A");
    color(":Y", NULL, "Y");
    color(":Red green BLUE alpha", NULL, "Red green BLUE +alpha");
    color(":r g b a", NULL, "r g b +a");
    color(":diffuse.R diffuse.G diffuse.B VL.Combined.R VL.Combined.G VL.Combined.B VL.Combined.A", NULL,
          "VL.Combined.R VL.Combined.G VL.Combined.B +VL.Combined.A");
    color(":b.R b.G b.B a.R a.G a.B", NULL, "b.R b.G b.B");
    color(":x.Y R G", NULL, "has no colour");
    color("depth: Z; rgba: R G B A", NULL, "1 R G B +A");
    color("diffuse: R G B; beauty: R G B A", NULL, "1 R G B +A");
    color("diffuse: R G B; spec: R G B A", NULL, "R G B");
    color("a: (deep) R G B; b: R G B", NULL, "1 R G B");
    color("a: (deep) R G B A Z", NULL, "flatten");
}

static void test_named_layers(void **state) {
    (void)state;
    const char *layers = ":R G B left.R left.G left.B left.A fg.diffuse.R fg.diffuse.G fg.diffuse.B";
    color(layers, "left", "left.R left.G left.B +left.A");
    color(layers, "fg.diffuse", "fg.diffuse.R fg.diffuse.G fg.diffuse.B");
    color(layers, "fg", "its channels are: R, G, B, left.R");
    color(layers, "lef", "no layer or part 'lef'");
    color("one: R G B; two: R G B A", "two", "1 R G B +A");
    color("one/left: R G B; two/right: R G B A", "right", "1 R G B +A");
    color("one: a.R a.G a.B; two: a.R a.G a.B", "two:a", "1 a.R a.G a.B");
    color("one: a.Y", "a", "a.Y");
}

static void test_refused_color(void **state) {
    (void)state;
    color(":BY/ RY/ Y", NULL, "luminance and chroma");
    color(":left.BY/ left.RY/ left.Y", "left", "luminance and chroma");
    color(":R G/ B", NULL, "subsampled");
}

static void test_depth(void **state) {
    (void)state;
    depth(":A B G R Z", NULL, NULL, "Z");
    depth(":A B G R depth.Z", NULL, NULL, "depth.Z");
    depth(":A B G R N.X N.Y N.Z Depth.V", NULL, NULL, "Depth.V");
    depth(":A B G R X Y Z", NULL, NULL, "has no depth");
    depth(":VL.Combined.R VL.Combined.G VL.Combined.B VL.Depth.Z VL.Vector.W VL.Vector.X VL.Vector.Y VL.Vector.Z", NULL,
          NULL, "VL.Depth.Z");
    depth(":Fg.Combined.R Fg.Combined.G Fg.Combined.B Bg.Depth.Z Fg.Depth.Z", NULL, NULL, "Fg.Depth.Z");
    depth(":R G B VRayZDepth.R", NULL, NULL, "VRayZDepth.R");
    depth(":R G B depth.A depth.B depth.G depth.R", NULL, NULL, "depth.R");
    depth(":R G B zdepth", NULL, NULL, "zdepth");
    depth(":R G B mask", NULL, NULL, "name its channel");
    depth(":R G B Z left.R left.G left.B left.Z", NULL, NULL, "Z");
    depth(":R G B Z left.R left.G left.B left.Z", "left", NULL, "left.Z");
    depth("rgba: R G B; Zdepth: Y", NULL, NULL, "1 Y");
    depth("rgba_right/right: R G B A; depth_left/left: Z; rgba_left/left: R G B A; depth_right/right: Z", NULL, NULL,
          "3 Z");
    depth("rgba_right/right: R G B A; depth_left/left: Z; rgba_left/left: R G B A; depth_right/right: Z", "left", NULL,
          "1 Z");
    depth("rgba: R G B A Z; depth: Z", NULL, NULL, "Z");
    depth("rgba: R G B A; deep: (deep) Z; depth: Z", NULL, NULL, "2 Z");
    depth(":R G B Z/", NULL, NULL, "subsampled");
    depth("a: (deep) R G B A Z", NULL, NULL, "flatten");
}

static void test_named_depth(void **state) {
    (void)state;
    depth(":R G B Z far.Z", NULL, "far.Z", "far.Z");
    depth(":R G B Z far.Z", NULL, "far", "far.Z");
    depth(":R G B Z far.Z", NULL, "fa", "no channel 'fa'");
    depth(":R G B Z", NULL, "G", "G");
    depth("rgba: R G B; a: Z; b: Z", NULL, "b:Z", "2 Z");
    depth("rgba: R G B; a: Z; b: Z", NULL, "b", "2 Z");
    depth("rgba: R G B; a: Z; b: Z", NULL, "Z", "1 Z");
    depth("rgba: R G B; a: Z", NULL, "z", "its channels are: rgba:R, rgba:G, rgba:B, a:Z");
}

static void test_picture_that_is_a_depth(void **state) {
    static const char *const channels[] = {":Y", ":distance", ":Y A", ":A B G R", "one: a; two: b"};
    static const char *const expected[] = {"Y", "distance", "Y", "name its channel", "name its channel"};
    (void)state;
    for (int i = 0; i < 5; i++) {
        io_picture *picture = make(channels[i]);
        io_selection s;
        io_error error = {{0}};
        int result = io_select_depth(picture, NULL, NULL, &s, &error);
        assert_non_null(strstr(describe(picture, result, &s, &error), expected[i]));
        io_close(&picture);
    }
}

static void test_hostile_names(void **state) {
    char text[1900] = ":";
    (void)state;
    /* Lists end somewhere, and stay one line. */
    for (int i = 0; i < 150; i++)
        snprintf(text + strlen(text), sizeof text - strlen(text), " chan\nnel%d", i);
    color(text, NULL, ", ...");
    color(": .R .G .B", NULL, ".R .G .B");
    color(": ..R", NULL, "has no colour");
}

static void test_sample_pictures(void **state) {
    static const struct {
        const char *file, *color, *depth;
    } samples[] = {
        {"scenes/row/pinhole.exr", "R G B +A", "Z"},
        {"scenes/seq/pinhole.0001.exr", "R G B +A", "Z"},
        {"scenes/motion/pinhole.exr",
         "ViewLayer.Combined.R ViewLayer.Combined.G ViewLayer.Combined.B +ViewLayer.Combined.A", "ViewLayer.Depth.Z"},
        {"openexr-images/Beachball/multipart.0001.exr", "R G B +A", "5 Z"},
        {"openexr-images/Beachball/singlepart.0001.exr", "R G B +A", "Z"},
        {"openexr-images/Tiles/GoldenGate.exr", "R G B", NULL},
        {"openexr-images/LuminanceChroma/Garden.exr", "Y", NULL},
        {"openexr-images/v2/LowResLeftView/Trunks.exr", NULL, NULL},
    };
    (void)state;
    for (size_t i = 0; i < sizeof samples / sizeof samples[0]; i++) {
        const char *path = data_file(samples[i].file);
        if (!path) skip();
        io_picture *picture = open_picture(path);
        io_selection c, d;
        io_error error = {{0}};
        int result = io_select_color(picture, NULL, &c, &error);
        assert_int_equal(result == 0, samples[i].color != NULL);
        if (result == 0) assert_string_equal(describe(picture, 0, &c, NULL), samples[i].color);
        result = io_select_depth(picture, NULL, &c, &d, &error);
        assert_int_equal(result == 0, samples[i].depth != NULL);
        if (result == 0) assert_string_equal(describe(picture, 0, &d, NULL), samples[i].depth);
        io_close(&picture);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_color),         cmocka_unit_test(test_named_layers),
        cmocka_unit_test(test_refused_color), cmocka_unit_test(test_depth),
        cmocka_unit_test(test_named_depth),   cmocka_unit_test(test_picture_that_is_a_depth),
        cmocka_unit_test(test_hostile_names), cmocka_unit_test(test_sample_pictures),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
