/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Sprites and irises that are refused: INVALID and a sentence that names the member, wherever they are looked at and nowhere else. */
#include "support.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { W = 12, H = 9 };

static float color[W * H * 4], coc[W * H], output[W * H * 4], light[16 * 16 + 1];

static ddof_frame good_frame(void) {
    for (int i = 0; i < W * H * 4; i++) color[i] = (float)(i % 9), output[i] = -1, coc[i / 4] = 3;
    for (int i = 0; i < COUNT(light); i++) light[i] = 1;
    return (ddof_frame){.color = ddof_image_interleaved(color, W, H, 4, DDOF_FLOAT, 0),
                        .coc = ddof_image_interleaved(coc, W, H, 1, DDOF_FLOAT, 0),
                        .output = ddof_image_interleaved(output, W, H, 4, DDOF_FLOAT, 0)};
}

/* Good settings, with sprites of each kind. */
static ddof_settings good_settings(ddof_bokeh bokeh, ddof_iris_shape shape) {
    ddof_settings s = {.bokeh = bokeh, .iris = {.shape = shape, .blades = shape == DDOF_IRIS_POLYGON ? 6 : 0}};
    if (shape == DDOF_IRIS_IMAGE) s.iris.image = ddof_image_interleaved(light, 16, 16, 1, DDOF_FLOAT, 0);
    return s;
}

static void assert_refused(ddof_context *ctx, const ddof_frame *frame, const ddof_settings *s, const char *word, const char *what) {
    ddof_stats stats;
    const ddof_stats zero = {0};
    memset(&stats, 0xff, sizeof stats);
    const ddof_status status = ddof_render(ctx, frame, s, &stats);
    if (status != DDOF_ERROR_INVALID) fail_msg("%s: %s", what, ddof_status_text(status));
    if (!strstr(ddof_error(ctx), word) || strchr(ddof_error(ctx), '\n')) fail_msg("%s: '%s' does not say '%s'", what, ddof_error(ctx), word);
    assert_memory_equal(&stats, &zero, sizeof zero);
    for (int i = 0; i < COUNT(output); i++)
        if (output[i] != -1) fail_msg("%s: refused, but the output was written", what);
}

typedef enum member_type { INT, REAL, STRIDE, ADDRESS, WORD } member_type;

/* A member of the settings, what it is set to, and what the sentence must say. */
typedef struct wrong {
    const char *what, *word;
    size_t offset;
    member_type type;
    double value;
} wrong;

#define WRONG(type, member, value, word) {#member " = " #value, word, offsetof(ddof_settings, member), type, (double)(value)}

static void set_member(ddof_settings *s, const wrong *w) {
    char *member = (char *)s + w->offset;
    const int whole = w->type == INT ? (int)w->value : 0;
    const ptrdiff_t bytes = w->type == STRIDE ? (ptrdiff_t)w->value : 0;
    const uint64_t word = w->type == WORD ? (uint64_t)w->value : 0;
    char *moved = NULL;
    if (w->type == INT) memcpy(member, &whole, sizeof whole);
    if (w->type == REAL) memcpy(member, &w->value, sizeof w->value);
    if (w->type == STRIDE) memcpy(member, &bytes, sizeof bytes);
    if (w->type == WORD) memcpy(member, &word, sizeof word);
    if (w->type == ADDRESS && w->value != 0) moved = (char *)light + (ptrdiff_t)w->value;
    if (w->type == ADDRESS) memcpy(member, &moved, sizeof moved);
}

/* Each is refused with highlights, with FULL and by the method; without sprites nobody looks. */
static void check_wrongs(const wrong *list, int count, ddof_iris_shape shape) {
    ddof_context *ctx = context_of(0, 2);
    for (int i = 0; i < count; i++)
        for (int kind = 0; kind < 4; kind++) {
            const ddof_frame frame = good_frame();
            ddof_settings s = good_settings((ddof_bokeh)(kind % 3), shape);
            size_t bytes;
            if (kind == 3) s.method = DDOF_METHOD_SCATTER;
            render(ctx, &frame, &s);
            good_frame();
            set_member(&s, &list[i]);
            if (kind == 0) {
                render(ctx, &frame, &s);
                continue;
            }
            assert_refused(ctx, &frame, &s, list[i].word, list[i].what);
            assert_int_equal(ddof_scratch_bytes(ctx, &frame, &s, &bytes), DDOF_ERROR_INVALID);
        }
    DESTROY(ctx);
}

static void sprites(void **state) {
    static const wrong list[] = {
        WRONG(REAL, sprites.threshold, -1, "settings.sprites.threshold"),
        WRONG(REAL, sprites.threshold, NAN, "settings.sprites.threshold"),
        WRONG(REAL, sprites.threshold, INFINITY, "settings.sprites.threshold"),
        WRONG(REAL, sprites.limit, -0.1, "settings.sprites.limit"),
        WRONG(REAL, sprites.limit, 1.1, "settings.sprites.limit"),
        WRONG(REAL, sprites.limit, NAN, "settings.sprites.limit"),
        WRONG(INT, sprites.max_sprites, -1, "settings.sprites.max_sprites"),
        WRONG(INT, sprites.max_sprites, (1 << 20) + 1, "settings.sprites.max_sprites"),
        WRONG(INT, sprites.max_sprites, INT_MIN, "settings.sprites.max_sprites"),
        WRONG(INT, sprites.max_area, -1, "settings.sprites.max_area"),
        WRONG(INT, sprites.max_area, 1025, "settings.sprites.max_area"),
        WRONG(INT, sprites.resolution, 3, "settings.sprites.resolution"),
        WRONG(INT, sprites.resolution, -1, "settings.sprites.resolution"),
        WRONG(INT, sprites.append, 3, "settings.sprites.append"),
        WRONG(INT, sprites.append, -1, "settings.sprites.append"),
        WRONG(INT, sprites.quads, 3, "settings.sprites.quads"),
        WRONG(INT, sprites.quads, -1, "settings.sprites.quads"),
        WRONG(INT, sprites.reserved_int, 1, "settings.sprites.reserved_int"),
        WRONG(WORD, sprites.reserved[0], 1, "settings.sprites.reserved"),
        WRONG(WORD, sprites.reserved[3], 1, "settings.sprites.reserved"),
    };
    (void)state;
    check_wrongs(list, COUNT(list), DDOF_IRIS_DISC);
}

static void irises(void **state) {
    static const wrong disc[] = {
        WRONG(INT, iris.shape, 3, "settings.iris.shape"),
        WRONG(INT, iris.shape, -1, "settings.iris.shape"),
        WRONG(INT, iris.shape, DDOF_IRIS_POLYGON, "settings.iris.blades"),
        WRONG(INT, iris.shape, DDOF_IRIS_IMAGE, "settings.iris.image"),
        WRONG(INT, iris.blades, 5, "settings.iris.blades"),
        WRONG(INT, iris.image.channels, 1, "settings.iris.image"),
        WRONG(REAL, iris.rotation, 3601, "settings.iris.rotation"),
        WRONG(REAL, iris.rotation, -3601, "settings.iris.rotation"),
        WRONG(REAL, iris.rotation, NAN, "settings.iris.rotation"),
        WRONG(REAL, iris.edge, 1.5, "settings.iris.edge"),
        WRONG(REAL, iris.edge, NAN, "settings.iris.edge"),
        WRONG(REAL, iris.cats_eye, -0.1, "settings.iris.cats_eye"),
        WRONG(REAL, iris.cats_eye, 1.1, "settings.iris.cats_eye"),
        WRONG(REAL, iris.cats_eye, NAN, "settings.iris.cats_eye"),
        WRONG(REAL, iris.squeeze, 0.9, "settings.iris.squeeze"),
        WRONG(REAL, iris.squeeze, 4.1, "settings.iris.squeeze"),
        WRONG(REAL, iris.squeeze, NAN, "settings.iris.squeeze"),
        WRONG(REAL, iris.fringe, 0.6, "settings.iris.fringe"),
        WRONG(REAL, iris.fringe, -0.6, "settings.iris.fringe"),
        WRONG(REAL, iris.fringe, NAN, "settings.iris.fringe"),
        WRONG(WORD, iris.reserved[0], 1, "settings.iris.reserved"),
        WRONG(WORD, iris.reserved[3], 1, "settings.iris.reserved"),
    };
    static const wrong polygon[] = {
        WRONG(INT, iris.blades, 0, "settings.iris.blades"),
        WRONG(INT, iris.blades, 2, "settings.iris.blades"),
        WRONG(INT, iris.blades, 65, "settings.iris.blades"),
        WRONG(INT, iris.blades, -3, "settings.iris.blades"),
        WRONG(REAL, iris.curvature, -0.1, "settings.iris.curvature"),
        WRONG(REAL, iris.curvature, 1.1, "settings.iris.curvature"),
        WRONG(REAL, iris.curvature, NAN, "settings.iris.curvature"),
    };
    (void)state;
    check_wrongs(disc, COUNT(disc), DDOF_IRIS_DISC);
    check_wrongs(polygon, COUNT(polygon), DDOF_IRIS_POLYGON);
}

static void images(void **state) {
    static const wrong list[] = {
        WRONG(INT, iris.image.channels, 0, "settings.iris.image"),
        WRONG(INT, iris.image.channels, 2, "settings.iris.image"),
        WRONG(INT, iris.image.channels, -1, "settings.iris.image"),
        WRONG(INT, iris.image.width, 0, "settings.iris.image"),
        WRONG(INT, iris.image.width, 5000, "settings.iris.image"),
        WRONG(INT, iris.image.width, INT_MIN, "settings.iris.image"),
        WRONG(INT, iris.image.height, 0, "settings.iris.image"),
        WRONG(INT, iris.image.height, 4097, "settings.iris.image"),
        WRONG(INT, iris.blades, 3, "settings.iris.blades"),
        WRONG(ADDRESS, iris.image.plane[0].data, 0, "settings.iris.image"),
        WRONG(ADDRESS, iris.image.plane[0].data, 2, "settings.iris.image"),
        WRONG(INT, iris.image.plane[0].type, 2, "settings.iris.image"),
        WRONG(INT, iris.image.plane[0].type, -1, "settings.iris.image"),
        WRONG(STRIDE, iris.image.plane[0].pixel_stride, 6, "settings.iris.image"),
        WRONG(STRIDE, iris.image.plane[0].row_stride, -2, "settings.iris.image"),
        WRONG(STRIDE, iris.image.plane[0].row_stride, 0x1p62, "settings.iris.image"),
        WRONG(STRIDE, iris.image.plane[0].pixel_stride, -0x1p62, "settings.iris.image"),
    };
    (void)state;
    check_wrongs(list, COUNT(list), DDOF_IRIS_IMAGE);
}

/* No light comes through; and one texel is enough. */
static void dark_images(void **state) {
    static const float dark[] = {0, -0.0f, -1, NAN, -INFINITY};
    ddof_context *ctx = context_of(0, 2);
    (void)state;
    for (int i = 0; i < COUNT(dark); i++)
        for (int full = 0; full < 2; full++) {
            const ddof_frame frame = good_frame();
            const ddof_settings s = good_settings(full ? DDOF_BOKEH_FULL : DDOF_BOKEH_HIGHLIGHTS, DDOF_IRIS_IMAGE);
            for (int k = 0; k < COUNT(light); k++) light[k] = dark[i];
            assert_refused(ctx, &frame, &s, "settings.iris.image", "a dark image");
            light[77] = 1e-30f;
            render(ctx, &frame, &s);
        }
    DESTROY(ctx);
}

static void methods(void **state) {
    static const wrong list[] = {
        WRONG(INT, bokeh, 3, "settings.bokeh"),
        WRONG(INT, bokeh, -1, "settings.bokeh"),
    };
    ddof_context *ctx = context_of(0, 2);
    (void)state;
    for (int i = 0; i < COUNT(list); i++) {
        const ddof_frame frame = good_frame();
        ddof_settings s = {0};
        set_member(&s, &list[i]);
        assert_refused(ctx, &frame, &s, list[i].word, list[i].what);
    }
    DESTROY(ctx);
}

/* The ends of all ranges are allowed. */
static void ends(void **state) {
    static const ddof_iris irises_allowed[] = {
        {.shape = DDOF_IRIS_POLYGON, .blades = 3, .rotation = -3600, .edge = -1, .cats_eye = 1, .squeeze = 4, .fringe = -0.5},
        {.shape = DDOF_IRIS_POLYGON, .blades = 64, .rotation = 3600, .curvature = 1, .edge = 1, .squeeze = 1, .fringe = 0.5},
    };
    static const ddof_sprites sprites_allowed[] = {
        {.threshold = 1e-30, .limit = 1, .max_sprites = 1, .max_area = 1, .append = DDOF_APPEND_ARGUMENTS, .quads = DDOF_QUADS_GEOMETRY},
        {.threshold = 1e30, .limit = 1e-9, .max_sprites = 1 << 20, .max_area = 1024, .resolution = DDOF_RESOLUTION_HALF},
    };
    ddof_context *ctx = context_of(0, 2);
    (void)state;
    for (int i = 0; i < 8; i++) {
        const ddof_frame frame = good_frame();
        const ddof_settings s = {.bokeh = i / 4 ? DDOF_BOKEH_FULL : DDOF_BOKEH_HIGHLIGHTS, .iris = irises_allowed[i % 2], .sprites = sprites_allowed[i / 2 % 2]};
        render(ctx, &frame, &s);
        for (int k = 0; k < COUNT(output); k++) assert_true(isfinite(output[k]));
    }
    DESTROY(ctx);
}

int main(void) {
    static const test tests[] = {
        {"sprites", sprites, false, 0, 0},
        {"irises", irises, false, 0, 0},
        {"images of irises", images, false, 0, 0},
        {"images that let no light through", dark_images, false, 0, 0},
        {"bokeh", methods, false, 0, 0},
        {"ends of ranges", ends, false, 0, 0},
    };
    return run_library_tests("bokeh_invalid", tests, COUNT(tests));
}
