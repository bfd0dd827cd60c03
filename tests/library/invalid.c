/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Every way to call the library wrongly: the status, and a sentence that names the argument; nothing is written, and
 * the context goes on working. */
#include "parallel.h"
#include "support.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { W = 8, H = 6, BIG = 1 << 20 };

/* A frame and settings that are right. */
typedef struct request {
    ddof_frame frame;
    ddof_settings settings;
} request;

static float color[W * H * 4 + 1], map[W * H + 1], output[W * H * 4 + 1];

static request good_request(bool depth) {
    request r = {.frame = {.color = ddof_image_interleaved(color, W, H, 4, DDOF_FLOAT, 0),
                           .output = ddof_image_interleaved(output, W, H, 4, DDOF_FLOAT, 0)},
                 .settings = {.lens = {.focal_length = 50, .f_number = 2, .focus_distance = 3},
                              .depth = {.z_at_0 = 1, .z_at_1 = 10}}};
    *(depth ? &r.frame.depth : &r.frame.coc) = ddof_image_interleaved(map, W, H, 1, DDOF_FLOAT, 0);
    return r;
}

static void fill_request_memory(void) {
    for (int i = 0; i < W * H * 4; i++)
        color[i] = (float)(i % 7), output[i] = -1;
    for (int i = 0; i < W * H; i++)
        map[i] = 1 + 0.1f * (float)i;
}

/* One sentence that says `word`. */
static void assert_sentence(const char *text, const char *word, const char *what) {
    if (!text[0] || strchr(text, '\n') || !strstr(text, word)) fail_msg("%s: '%s' does not say '%s'", what, text, word);
}

static void assert_untouched(const char *what) {
    for (int i = 0; i < W * H * 4; i++)
        if (output[i] != -1) fail_msg("%s: refused, but the output was written", what);
}

static void assert_zero(const ddof_stats *stats) {
    static const ddof_stats none;
    assert_memory_equal(stats, &none, sizeof none);
}

/* Refused by ddof_render() and ddof_scratch_bytes(). */
static void assert_refused(ddof_context *ctx, const request *r, const char *word, const char *what) {
    ddof_stats stats;
    size_t bytes;
    memset(&stats, 0xff, sizeof stats);
    ddof_status status = ddof_render(ctx, &r->frame, &r->settings, &stats);
    if (status != DDOF_ERROR_INVALID) fail_msg("%s: %s", what, ddof_status_text(status));
    assert_sentence(ddof_error(ctx), word, what);
    assert_zero(&stats);
    assert_untouched(what);
    status = ddof_scratch_bytes(ctx, &r->frame, &r->settings, &bytes);
    if (status != DDOF_ERROR_INVALID) fail_msg("ddof_scratch_bytes, %s: %s", what, ddof_status_text(status));
    assert_sentence(ddof_error(ctx), word, what);
}

static void assert_works(ddof_context *ctx) {
    request r = good_request(true);
    render(ctx, &r.frame, &r.settings);
    for (int i = 0; i < W * H * 4; i++)
        output[i] = -1;
}

/* ---- one member wrong */

typedef enum member_type { INT, REAL, STRIDE, ADDRESS, WORD } member_type;

typedef struct wrong {
    const char *what, *word; /* what is set, and what the sentence must say */
    size_t offset;
    member_type type;
    double value;
} wrong;

#define WRONG(type, member, value, word)                                                                               \
    { #member " = " #value, word, offsetof(request, member), type, (double)(value) }

static void set_member(request *r, const wrong *w) {
    char *member = (char *)r + w->offset;
    switch (w->type) {
    case INT:
        memcpy(member, &(int){(int)w->value}, sizeof(int));
        break;
    case REAL:
        memcpy(member, &w->value, sizeof(double));
        break;
    case STRIDE:
        memcpy(member, &(ptrdiff_t){(ptrdiff_t)w->value}, sizeof(ptrdiff_t));
        break;
    case WORD:
        memcpy(member, &(uint64_t){(uint64_t)w->value}, sizeof(uint64_t));
        break;
    case ADDRESS: { /* moved by so many bytes; 0: NULL */
        char *p;
        memcpy(&p, member, sizeof p);
        p = w->value != 0 ? p + (ptrdiff_t)w->value : NULL;
        memcpy(member, &p, sizeof p);
    }
    }
}

static void check_wrongs(const wrong *list, int count, const request *base) {
    ddof_context *ctx = context_of(0, 2);
    fill_request_memory();
    for (int i = 0; i < count; i++) {
        request r = *base;
        set_member(&r, &list[i]);
        assert_refused(ctx, &r, list[i].word, list[i].what);
        if (i % 8 == 0) assert_works(ctx);
    }
    assert_works(ctx);
    DESTROY(ctx);
}

static void images(void **state) {
    static const wrong list[] = {
        WRONG(INT, frame.color.width, 0, "frame.color"),
        WRONG(INT, frame.color.width, -8, "frame.color"),
        WRONG(INT, frame.color.width, BIG + 1, "frame.color"),
        WRONG(INT, frame.color.width, INT_MIN, "frame.color"),
        WRONG(INT, frame.color.height, 0, "frame.color"),
        WRONG(INT, frame.color.height, INT_MAX, "frame.color"),
        WRONG(INT, frame.color.width, 7, "sizes must agree"),
        WRONG(INT, frame.color.channels, 0, "frame.color has 0 channels"),
        WRONG(INT, frame.color.channels, -1, "frame.color has -1 channels"),
        WRONG(INT, frame.color.channels, 5, "frame.color has 5 channels"),
        WRONG(INT, frame.color.channels, 3, "frame.output has 4 channels, it must have 3"),
        WRONG(INT, frame.color.alpha, 2, "alpha"),
        WRONG(INT, frame.color.alpha, -1, "alpha"),
        WRONG(INT, frame.color.plane[2].type, 2, "frame.color.plane[2].type"),
        WRONG(INT, frame.color.plane[0].type, -1, "frame.color.plane[0].type"),
        WRONG(ADDRESS, frame.color.plane[3].data, 0, "frame.color.plane[3].data is NULL"),
        WRONG(ADDRESS, frame.color.plane[0].data, 1, "frame.color.plane[0]"),
        WRONG(ADDRESS, frame.color.plane[0].data, 2, "frame.color.plane[0]"),
        WRONG(STRIDE, frame.color.plane[1].pixel_stride, 18, "frame.color.plane[1]"),
        WRONG(STRIDE, frame.color.plane[1].row_stride, 130, "frame.color.plane[1]"),
        WRONG(STRIDE, frame.color.plane[1].pixel_stride, 0x1p40 + 4, "frame.color.plane[1]"),
        WRONG(STRIDE, frame.color.plane[1].row_stride, -0x1p40 - 4, "frame.color.plane[1]"),
        WRONG(STRIDE, frame.color.plane[1].row_stride, 0x1p62, "frame.color.plane[1]"),
        WRONG(INT, frame.output.width, 9, "frame.output"),
        WRONG(INT, frame.output.height, -1, "frame.output"),
        WRONG(INT, frame.output.channels, 0, "frame.output"),
        WRONG(INT, frame.output.channels, 3, "frame.output"),
        WRONG(ADDRESS, frame.output.plane[1].data, 0, "frame.output.plane[1].data is NULL"),
        WRONG(ADDRESS, frame.output.plane[0].data, 2, "frame.output.plane[0]"),
        WRONG(INT, frame.output.plane[0].type, 7, "frame.output.plane[0].type"),
        WRONG(INT, frame.depth.channels, 0, "exactly one of frame.depth and frame.coc"),
        WRONG(INT, frame.coc.channels, 1, "exactly one of frame.depth and frame.coc"),
        WRONG(INT, frame.depth.channels, 2, "frame.depth has 2 channels"),
        WRONG(INT, frame.depth.channels, -1, "frame.depth has -1 channels"),
        WRONG(INT, frame.depth.width, 9, "frame.depth"),
        WRONG(INT, frame.depth.height, 5, "frame.depth"),
        WRONG(ADDRESS, frame.depth.plane[0].data, 0, "frame.depth.plane[0].data is NULL"),
        WRONG(ADDRESS, frame.depth.plane[0].data, 3, "frame.depth.plane[0]"),
        WRONG(STRIDE, frame.depth.plane[0].row_stride, 33, "frame.depth.plane[0]"),
    };
    (void)state;
    request base = good_request(true);
    check_wrongs(list, COUNT(list), &base);
}

static void geometry(void **state) {
    static const wrong list[] = {
        WRONG(ADDRESS, frame.next, 8, "frame.next"),
        WRONG(WORD, frame.reserved[0], 1, "reserved"),
        WRONG(INT, frame.reserved_int, 1, "reserved"),
        WRONG(WORD, frame.reserved[4], 1, "reserved"),
        WRONG(INT, frame.picture_width, 0, "picture"),
        WRONG(INT, frame.picture_height, 0, "picture"),
        WRONG(INT, frame.picture_width, -4, "picture"),
        WRONG(INT, frame.picture_height, INT_MIN, "picture"),
        WRONG(INT, frame.picture_width, (1 << 24) + 1, "picture"),
        WRONG(INT, frame.offset_x, (1 << 24) + 1, "offset"),
        WRONG(INT, frame.offset_y, -(1 << 24) - 1, "offset"),
        WRONG(INT, frame.offset_x, INT_MIN, "offset"),
        WRONG(INT, frame.offset_y, INT_MIN, "offset"),
        WRONG(INT, frame.offset_y, INT_MAX, "offset"),
        WRONG(REAL, frame.pixel_aspect, -1, "pixel_aspect"),
        WRONG(REAL, frame.pixel_aspect, 1e-4, "pixel_aspect"),
        WRONG(REAL, frame.pixel_aspect, 1e4, "pixel_aspect"),
        WRONG(REAL, frame.pixel_aspect, INFINITY, "pixel_aspect"),
        WRONG(REAL, frame.pixel_aspect, NAN, "pixel_aspect"),
    };
    static const wrong alone[] = {
        WRONG(INT, frame.offset_x, 1, "offset"),
        WRONG(INT, frame.offset_y, -1, "offset"),
    };
    (void)state;
    request base = good_request(true);
    check_wrongs(alone, COUNT(alone), &base);
    base.frame.picture_width = 100;
    base.frame.picture_height = 80;
    check_wrongs(list, COUNT(list), &base);
}

static void thin_lens(void **state) {
    static const wrong list[] = {
        WRONG(WORD, settings.reserved[0], 1, "settings.reserved"),
        WRONG(WORD, settings.reserved[3], 1, "settings.reserved"),
        WRONG(INT, settings.conductance, 2, "settings.conductance"),
        WRONG(INT, settings.conductance, -1, "settings.conductance"),
        WRONG(INT, settings.substeps, -1, "settings.substeps"),
        WRONG(INT, settings.substeps, 65, "settings.substeps"),
        WRONG(WORD, settings.lens.reserved[7], 1, "lens.reserved"),
        WRONG(INT, settings.lens.kind, 2, "lens.kind"),
        WRONG(INT, settings.lens.focus, 2, "lens.focus"),
        WRONG(INT, settings.lens.focus, -1, "lens.focus"),
        WRONG(REAL, settings.lens.focal_length, 0, "lens.focal_length"),
        WRONG(REAL, settings.lens.focal_length, -50, "lens.focal_length"),
        WRONG(REAL, settings.lens.focal_length, NAN, "lens.focal_length"),
        WRONG(REAL, settings.lens.focal_length, INFINITY, "lens.focal_length"),
        WRONG(REAL, settings.lens.focal_length, 3000, "focal length"),
        WRONG(REAL, settings.lens.f_number, 0, "lens.f_number"),
        WRONG(REAL, settings.lens.f_number, -1, "lens.f_number"),
        WRONG(REAL, settings.lens.f_number, NAN, "lens.f_number"),
        WRONG(REAL, settings.lens.sensor_width, -36, "lens.sensor_width"),
        WRONG(REAL, settings.lens.sensor_width, NAN, "lens.sensor_width"),
        WRONG(REAL, settings.lens.unit, -1, "lens.unit"),
        WRONG(REAL, settings.lens.unit, INFINITY, "lens.unit"),
        WRONG(REAL, settings.lens.focus_distance, 0, "focus distance"),
        WRONG(REAL, settings.lens.focus_distance, -3, "focus distance"),
        WRONG(REAL, settings.lens.focus_distance, NAN, "focus distance"),
        WRONG(REAL, settings.lens.focus_distance, 0.05, "focal length"),
        WRONG(REAL, settings.lens.focus_distance, 0.01, "focal length"),
        WRONG(REAL, settings.lens.in_focus_range, -1, "lens.in_focus_range"),
        WRONG(REAL, settings.lens.in_focus_range, NAN, "lens.in_focus_range"),
        WRONG(REAL, settings.lens.limit_near, -0.1, "lens.limit_near"),
        WRONG(REAL, settings.lens.limit_far, NAN, "lens.limit_far"),
    };
    (void)state;
    request base = good_request(true);
    check_wrongs(list, COUNT(list), &base);
}

static void artist_lens(void **state) {
    static const wrong list[] = {
        WRONG(REAL, settings.lens.max_coc_near, -0.1, "lens.max_coc_near"),
        WRONG(REAL, settings.lens.max_coc_far, NAN, "lens.max_coc_far"),
        WRONG(REAL, settings.lens.max_coc_far, INFINITY, "lens.max_coc_far"),
        WRONG(REAL, settings.lens.focus_distance, INFINITY, "finite"),
        WRONG(REAL, settings.lens.focus_distance, 0, "focus distance"),
        WRONG(INT, settings.depth.kind, DDOF_DEPTH_RAY, "lens.focal_length"),
    };
    (void)state;
    request base = good_request(true);
    base.settings.lens = (ddof_lens){.kind = DDOF_LENS_ARTIST, .focus_distance = 3, .max_coc_far = 0.02};
    check_wrongs(list, COUNT(list), &base);
}

static void depth_kinds(void **state) {
    static const wrong list[] = {
        WRONG(INT, settings.depth.kind, 5, "depth.kind"),
        WRONG(INT, settings.depth.kind, -1, "depth.kind"),
        WRONG(WORD, settings.depth.reserved[3], 1, "depth.reserved"),
        WRONG(REAL, settings.depth.z_at_0, 0, "depth.z_at_0"),
        WRONG(REAL, settings.depth.z_at_0, 10, "depth.z_at_0"),
        WRONG(REAL, settings.depth.z_at_1, -1, "depth.z_at_1"),
        WRONG(REAL, settings.depth.z_at_1, NAN, "depth.z_at_1"),
    };
    static const wrong normalized = WRONG(REAL, settings.depth.z_at_0, INFINITY, "finite");
    static const wrong device = WRONG(REAL, settings.depth.z_at_1, INFINITY, "depth.z_at_1");
    (void)state;
    request base = good_request(true);
    base.settings.depth.kind = DDOF_DEPTH_NORMALIZED;
    check_wrongs(list, COUNT(list), &base);
    check_wrongs(&normalized, 1, &base);
    base.settings.depth.kind = DDOF_DEPTH_DEVICE;
    check_wrongs(list, COUNT(list), &base);
    base.settings.depth.z_at_0 = INFINITY;
    check_wrongs(&device, 1, &base);
}

/* Without depth the lens is not looked at. */
static void unused_lens(void **state) {
    (void)state;
    ddof_context *ctx = context_of(0, 1);
    request r = good_request(false);
    fill_request_memory();
    r.settings.lens = (ddof_lens){.focal_length = -1, .f_number = NAN};
    assert_true(render(ctx, &r.frame, &r.settings).focus_distance == 0);
    DESTROY(ctx);
}

/* ---- NULL */

static void nulls(void **state) {
    (void)state;
    ddof_context *ctx = context_of(0, 1), *none = NULL;
    request r = good_request(true);
    size_t bytes;
    fill_request_memory();
    assert_int_equal(ddof_render(NULL, &r.frame, &r.settings, NULL), DDOF_ERROR_INVALID);
    assert_int_equal(ddof_coc(NULL, &r.frame, &r.settings, NULL), DDOF_ERROR_INVALID);
    assert_int_equal(ddof_scratch_bytes(NULL, &r.frame, &r.settings, &bytes), DDOF_ERROR_INVALID);
    assert_int_equal(ddof_trim(NULL), DDOF_ERROR_INVALID);
    assert_int_equal(ddof_create(NULL, NULL), DDOF_ERROR_INVALID);
    assert_string_equal(ddof_error(NULL), "");
    ddof_destroy(NULL);
    ddof_destroy(&none);

    assert_int_equal(ddof_render(ctx, NULL, &r.settings, NULL), DDOF_ERROR_INVALID);
    assert_sentence(ddof_error(ctx), "frame is NULL", "render");
    assert_int_equal(ddof_coc(ctx, NULL, &r.settings, NULL), DDOF_ERROR_INVALID);
    assert_sentence(ddof_error(ctx), "frame is NULL", "coc");
    assert_int_equal(ddof_render(ctx, &r.frame, NULL, NULL), DDOF_ERROR_INVALID);
    assert_sentence(ddof_error(ctx), "settings is NULL", "render");
    assert_int_equal(ddof_scratch_bytes(ctx, &r.frame, &r.settings, NULL), DDOF_ERROR_INVALID);
    assert_sentence(ddof_error(ctx), "bytes is NULL", "scratch_bytes");
    assert_int_equal(ddof_render(ctx, &r.frame, &r.settings, NULL), DDOF_OK); /* stats may be */
    assert_string_equal(ddof_error(ctx), "");
    ddof_destroy(&ctx);
    assert_null(ctx);
    ddof_destroy(&ctx);
}

/* A zeroed or half-made image is refused, whatever made it. */
static void no_image(void **state) {
    (void)state;
    ddof_context *ctx = context_of(0, 1);
    static const ddof_frame nothing;
    request r = good_request(true);
    fill_request_memory();
    assert_int_equal(ddof_render(ctx, &nothing, &r.settings, NULL), DDOF_ERROR_INVALID);
    r.frame.color = ddof_image_interleaved(NULL, W, H, 4, DDOF_FLOAT, 0);
    assert_refused(ctx, &r, "frame.color.plane[0].data is NULL", "no memory");
    r.frame.color = ddof_image_interleaved(color, W, H, 9, DDOF_FLOAT, 0);
    assert_refused(ctx, &r, "frame.color has 9 channels", "9 channels");
    r.frame.color = ddof_image_interleaved(color, W, H, -2, DDOF_FLOAT, 0);
    assert_refused(ctx, &r, "frame.color has -2 channels", "-2 channels");
    r.frame.color = ddof_image_planar((void *[]){color, NULL}, W, H, 2, DDOF_FLOAT, 0);
    r.frame.output.channels = 2;
    assert_refused(ctx, &r, "frame.color.plane[1].data is NULL", "half of the planes");
    DESTROY(ctx);
}

/* ---- memory that overlaps */

static void overlap(void **state) {
    (void)state;
    ddof_context *ctx = context_of(0, 2);
    static float room[4 * W * H * 4];
    request r = good_request(true);
    fill_request_memory();
    r.frame.color = ddof_image_interleaved(room, W, H, 4, DDOF_FLOAT, 0);
    const ptrdiff_t floats = W * H * 4;
    for (ptrdiff_t shift = 1 - floats; shift < floats; shift++) {
        if (shift == 0) continue;
        r.frame.color = ddof_image_interleaved(room + floats, W, H, 4, DDOF_FLOAT, 0);
        r.frame.output = ddof_image_interleaved(room + floats + shift, W, H, 4, DDOF_FLOAT, 0);
        assert_refused(ctx, &r, "frame.output overlaps frame.color", "shifted");
    }
    r.frame.output = r.frame.color; /* in place, */
    render(ctx, &r.frame, &r.settings);
    r.frame.output.plane[0] = r.frame.color.plane[2]; /* but not with channels exchanged */
    r.frame.output.plane[2] = r.frame.color.plane[0];
    assert_refused(ctx, &r, "overlaps frame.color", "exchanged channels");
    r.frame.output = ddof_image_interleaved(room + floats, W, H, 4, DDOF_HALF, 0); /* nor another type, */
    assert_refused(ctx, &r, "overlaps frame.color", "another type");
    r.frame.output = r.frame.color;
    for (int c = 0; c < 4; c++) { /* nor upside down */
        r.frame.output.plane[c].row_stride = -W * 16;
        r.frame.output.plane[c].data = room + floats + (H - 1) * W * 4 + c;
    }
    assert_refused(ctx, &r, "overlaps frame.color", "upside down");
    r.frame.output = ddof_image_interleaved(room, W, H, 4, DDOF_FLOAT, 0); /* side by side is fine */
    render(ctx, &r.frame, &r.settings);
    r.frame.depth =
        ddof_image_interleaved(room + floats, W, H, 1, DDOF_FLOAT, W * 16); /* and inputs may share memory */
    render(ctx, &r.frame, &r.settings);
    for (int i = 0; i < 2; i++) {
        r = good_request(i);
        *(i ? &r.frame.depth : &r.frame.coc) = ddof_image_interleaved(output, W, H, 1, DDOF_FLOAT, 0);
        assert_refused(ctx, &r, i ? "overlaps frame.depth" : "overlaps frame.coc", "the map in the output");
    }
    DESTROY(ctx);
}

/* Sizes and strides that lead out of the address space are refused or measured, without overflow on the way. */
static void enormous(void **state) {
    (void)state;
    ddof_context *ctx = context_of(0, 1);
    request r = good_request(true);
    size_t bytes = 0;
    const uintptr_t somewhere = sizeof(uintptr_t) == 8 ? (uintptr_t)UINT64_C(0x100000000000) : 4096; /* not read */
    r.frame.color = ddof_image_interleaved((void *)somewhere, BIG, BIG, 4, DDOF_FLOAT, 0);
    r.frame.depth = ddof_image_interleaved((void *)(somewhere / 4), BIG, BIG, 1, DDOF_FLOAT, 0);
    r.frame.output = r.frame.color;
    if (sizeof(size_t) == 8) {
        assert_int_equal(ddof_scratch_bytes(ctx, &r.frame, &r.settings, &bytes), DDOF_OK);
        assert_true(bytes >= (size_t)BIG * BIG * 4);
    }
    for (int c = 0; c < 4; c++)
        r.frame.color.plane[c].pixel_stride = (ptrdiff_t)1 << (sizeof(ptrdiff_t) == 8 ? 40 : 28);
    assert_int_equal(ddof_scratch_bytes(ctx, &r.frame, &r.settings, &bytes), DDOF_ERROR_INVALID);
    for (int c = 0; c < 4; c++)
        r.frame.color.plane[c].row_stride = -((ptrdiff_t)1 << (sizeof(ptrdiff_t) == 8 ? 40 : 28));
    (void)ddof_scratch_bytes(ctx, &r.frame, &r.settings, &bytes);
    DESTROY(ctx);
}

/* ---- ddof_coc */

static void coc_requests(void **state) {
    (void)state;
    ddof_context *ctx = context_of(0, 1);
    request r = good_request(true);
    fill_request_memory();
    memset(&r.frame.color, 0, sizeof r.frame.color); /* not used */
    assert_int_equal(ddof_coc(ctx, &r.frame, &r.settings, NULL), DDOF_ERROR_INVALID);
    assert_sentence(ddof_error(ctx), "frame.output has 4 channels", "output");
    r.frame.output = ddof_image_interleaved(output, W, H - 1, 1, DDOF_FLOAT, 0);
    assert_int_equal(ddof_coc(ctx, &r.frame, &r.settings, NULL), DDOF_ERROR_INVALID);
    assert_sentence(ddof_error(ctx), "sizes must agree", "size");
    r.frame.output = ddof_image_interleaved(map + 1, W, H, 1, DDOF_FLOAT, 0);
    assert_int_equal(ddof_coc(ctx, &r.frame, &r.settings, NULL), DDOF_ERROR_INVALID);
    assert_sentence(ddof_error(ctx), "overlaps frame.depth", "overlap");
    assert_int_equal(ddof_coc(ctx, &r.frame, NULL, NULL), DDOF_ERROR_INVALID);
    r.frame.output = ddof_image_interleaved(output, W, H, 1, DDOF_FLOAT, 0);
    r.frame.depth.channels = 0;
    assert_int_equal(ddof_coc(ctx, &r.frame, &r.settings, NULL), DDOF_ERROR_INVALID);
    assert_sentence(ddof_error(ctx), "exactly one", "no map");
    assert_untouched("ddof_coc");
    r.frame.depth.channels = 1;
    write_coc(ctx, &r.frame, &r.settings);
    DESTROY(ctx);
}

/* ---- ddof_create */

static void *refuse(void *user, size_t bytes) {
    (void)user, (void)bytes;
    return NULL;
}

static void release_nothing(void *user, void *memory) {
    (void)user, (void)memory;
}

static char logged[256];

static void keep_log(void *user, ddof_log_level level, const char *text) {
    (void)user;
    assert_int_equal(level, DDOF_LOG_ERROR);
    strncpy(logged, text, sizeof logged - 1);
}

static void configs(void **state) {
    const struct {
        ddof_config config;
        ddof_status status;
        const char *word;
    } list[] = {
        {{.backend = (ddof_backend)99}, DDOF_ERROR_INVALID, "config.backend"},
        {{.backend = (ddof_backend)-1}, DDOF_ERROR_INVALID, "config.backend"},
        {{.threads = -1}, DDOF_ERROR_INVALID, "config.threads"},
        {{.threads = 257}, DDOF_ERROR_INVALID, "config.threads"},
        {{.allocate = refuse}, DDOF_ERROR_INVALID, "config.allocate"},
        {{.release = release_nothing}, DDOF_ERROR_INVALID, "config.release"},
        {{.parallel_for = parallel_serial}, DDOF_ERROR_INVALID, "config.parallel_for"},
        {{.reserved = {1}}, DDOF_ERROR_INVALID, "config.reserved"},
        {{.reserved = {0, 0, 0, 0, 0, 0, 1}}, DDOF_ERROR_INVALID, "config.reserved"},
        {{.reserved_int = 1}, DDOF_ERROR_INVALID, "config.reserved"},
        {{.device = -1}, DDOF_ERROR_INVALID, "config.device"},
        {{.device = 1}, DDOF_ERROR_INVALID, "config.device"},
        {{.allocate = refuse, .release = release_nothing}, DDOF_ERROR_MEMORY, "memory"},
    };
    (void)state;
    for (int i = 0; i < COUNT(list); i++) {
        ddof_context *ctx = (ddof_context *)&logged; /* anything but NULL */
        ddof_config config = list[i].config;
        assert_int_equal(ddof_create(&ctx, &config), list[i].status);
        assert_null(ctx);
        config.log = keep_log;
        assert_int_equal(ddof_create(&ctx, &config), list[i].status);
        assert_sentence(logged, list[i].word, "config");
    }
    logged[0] = 0;
    assert_int_equal(ddof_create(NULL, &(ddof_config){.log = keep_log}), DDOF_ERROR_INVALID);
    assert_sentence(logged, "context is NULL", "ddof_create");
}

/* Backends without devices have none, and no more is written than there is room for. */
static void device_lists(void **state) {
    static const ddof_backend none[] = {DDOF_BACKEND_AUTO, DDOF_BACKEND_CPU, DDOF_BACKEND_REFERENCE, (ddof_backend)99,
                                        (ddof_backend)-1};
    static const ddof_backend gpus[] = {DDOF_BACKEND_GL, DDOF_BACKEND_VULKAN};
    (void)state;
    ddof_device devices[3], untouched;
    memset(&untouched, 0x77, sizeof untouched);
    for (int i = 0; i < COUNT(none); i++) {
        devices[0] = untouched;
        assert_int_equal(ddof_devices(none[i], devices, 3), 0);
        assert_memory_equal(&devices[0], &untouched, sizeof untouched);
    }
    for (int i = 0; i < COUNT(gpus); i++) {
        devices[0] = devices[1] = untouched;
        const int count = ddof_devices(gpus[i], NULL, 0);
        assert_true(count >= 0);
        assert_int_equal(ddof_devices(gpus[i], devices, 0), count);
        assert_int_equal(ddof_devices(gpus[i], devices, -1), count);
        assert_memory_equal(&devices[0], &untouched, sizeof untouched);
        assert_int_equal(ddof_devices(gpus[i], devices, 1), count);
        assert_memory_equal(&devices[1], &untouched, sizeof untouched);
    }
}

int main(void) {
    static const test tests[] = {
        {"images", images, false, 0, 0},
        {"place in the picture", geometry, false, 0, 0},
        {"settings and thin lens", thin_lens, false, 0, 0},
        {"artist's lens", artist_lens, false, 0, 0},
        {"kinds of depth", depth_kinds, false, 0, 0},
        {"a lens that is not used", unused_lens, false, 0, 0},
        {"NULL", nulls, false, 0, 0},
        {"no image", no_image, false, 0, 0},
        {"overlap", overlap, false, 0, 0},
        {"enormous sizes and strides", enormous, false, 0, 0},
        {"ddof_coc", coc_requests, false, 0, 0},
        {"ddof_create", configs, false, 0, 0},
        {"ddof_devices", device_lists, false, 0, 0},
    };
    return run_library_tests("invalid", tests, COUNT(tests));
}
