/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "pictures.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

const ddof_settings depth_settings = {.lens = {.focal_length = 50, .f_number = 2.8, .focus_distance = 2},
                                      .depth = {.kind = DDOF_DEPTH_DEVICE, .z_at_0 = 0.5, .z_at_1 = 20}};

/* ---- the images of a frame */

/* Rounds to what the format holds. */
static void round_to(VkFormat format, float rgba[4]) {
    unsigned char texel[16];
    texel_encode(format, rgba, texel);
    texel_decode(format, texel, rgba);
}

static int half_of(int n, bool half) {
    return half ? (n + 1) / 2 : n;
}

static void fill_values(frame_set *set, rng *r) {
    const frame_kind *k = &set->kind;
    scene *s = &set->values;
    fill_color(s->color, k->width, k->height, k->pattern, r);
    fill_coc(s->coc, k->width, k->height, k->coc, r);
    for (int i = 0; i < k->width * k->height; i++) {
        round_to(k->color, s->color + 4 * i);
        float map[4] = {k->is_depth ? (float)rng_unit(r) : s->coc[i], 0, 0, 0};
        round_to(k->map, map);
        s->coc[i] = map[0];
    }
    for (int y = 0; k->half_map && y < k->height; y++)
        for (int x = 0; x < k->width; x++)
            s->coc[y * k->width + x] = s->coc[y / 2 * 2 * k->width + x / 2 * 2];
}

void set_upload(frame_set *set) {
    const frame_kind *k = &set->kind;
    const int shift = k->half_map, w = half_of(k->width, k->half_map), h = half_of(k->height, k->half_map);
    float *map = fenced((size_t)(w * h) * 4 * sizeof *map, true);
    for (int y = 0; y < h; y++)
        for (int x = 0; x < w; x++)
            map[4 * (y * w + x)] = set->values.coc[(y << shift) * k->width + (x << shift)];
    picture_put(&set->color, set->values.color);
    picture_put(&set->map, map);
    fenced_free(map);
}

static picture part_or_all(const frame_kind *k, VkFormat format, int width, int height, VkImageUsageFlags usage,
                           VkImageLayout layout) {
    return k->parts ? picture_part(format, width, height, usage) : picture_make(format, width, height, usage, layout);
}

frame_set set_make(frame_kind kind, uint64_t seed) {
    const bool in_place = kind.output == VK_FORMAT_UNDEFINED;
    const VkImageUsageFlags both = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_STORAGE_BIT;
    rng r = {seed};
    if (!kind.color) kind.color = VK_FORMAT_R32G32B32A32_SFLOAT;
    if (!kind.map) kind.map = VK_FORMAT_R32_SFLOAT;
    frame_set set = {.kind = kind, .values = scene_make(kind.width, kind.height, true)};
    const int w = half_of(kind.width, kind.half_map), h = half_of(kind.height, kind.half_map);
    fill_values(&set, &r);
    set.color = part_or_all(&kind, kind.color, kind.width, kind.height, in_place ? both : VK_IMAGE_USAGE_SAMPLED_BIT,
                            in_place ? 0 : kind.layout);
    set.map = part_or_all(&kind, kind.map, w, h, VK_IMAGE_USAGE_SAMPLED_BIT, kind.layout);
    if (!in_place) {
        const bool wide = kind.sampled || kind.output == VK_FORMAT_R32G32B32A32_SFLOAT || kind.output == VK_FORMAT_R16G16B16A16_SFLOAT;
        set.output =
            part_or_all(&kind, kind.output, kind.width, kind.height, wide ? both : VK_IMAGE_USAGE_STORAGE_BIT, 0);
    }
    set.images = (ddof_vulkan_images){
        .color = set.color.d, .output = in_place ? set.color.d : set.output.d, .channels = kind.channels};
    *(kind.is_depth ? &set.images.depth : &set.images.coc) = set.map.d;
    set_upload(&set);
    return set;
}

void set_free(frame_set *set) {
    picture_free(&set->color);
    picture_free(&set->map);
    if (set->kind.output) picture_free(&set->output);
    scene_free(&set->values);
}

/* ---- what is wanted */

static ddof_vulkan_view whole(const frame_set *set, const ddof_vulkan_view *view) {
    ddof_vulkan_view v = view ? *view : (ddof_vulkan_view){0};
    if (!v.width && !v.height) v.width = set->kind.width, v.height = set->kind.height;
    return v;
}

float *set_want(const frame_set *set, const ddof_vulkan_view *view, const ddof_settings *settings) {
    const ddof_vulkan_view v = whole(set, view);
    const int w = v.width, h = v.height, stride = set->kind.width;
    float *want = fenced((size_t)(w * h) * 4 * sizeof *want, true);
    const int first = v.y * stride + v.x;
    const ddof_image map =
        ddof_image_interleaved(set->values.coc + first, w, h, 1, DDOF_FLOAT, stride * (ptrdiff_t)sizeof(float));
    ddof_frame frame = {.color = ddof_image_interleaved(set->values.color + 4 * (ptrdiff_t)first, w, h, 4, DDOF_FLOAT,
                                                        stride * (ptrdiff_t)16),
                        .output = ddof_image_interleaved(want, w, h, 4, DDOF_FLOAT, 0),
                        .picture_width = v.picture_width,
                        .picture_height = v.picture_height,
                        .offset_x = v.offset_x,
                        .offset_y = v.offset_y,
                        .pixel_aspect = v.pixel_aspect};
    *(set->kind.is_depth ? &frame.depth : &frame.coc) = map;
    if (set->kind.channels == 3) frame.color.channels = frame.output.channels = 3;
    ddof_context *reference = reference_context();
    render(reference, &frame, settings);
    DESTROY(reference);
    for (int i = 0; set->kind.channels == 3 && i < w * h; i++)
        want[4 * i + 3] = 1;
    return want;
}

ddof_settings method(int k, ddof_surface surface) {
    static const ddof_solver solvers[SOLVERS] = {DDOF_SOLVER_LINE, DDOF_SOLVER_PCR, DDOF_SOLVER_PCR3_SWEEP,
                                                 DDOF_SOLVER_CR4_PACK};
    ddof_settings s = {.surface = surface};
    k %= METHODS;
    if (k < SOLVERS) s.solver = solvers[k];
    if (k >= SOLVERS) s.kernel = DDOF_KERNEL_DISC; /* of one quality: disc.c has all, and they compile long */
    return s;
}

ddof_settings heat_method(int k, ddof_surface surface, ddof_conductance conductance, int substeps) {
    ddof_settings s = method(k, surface);
    if (s.kernel == DDOF_KERNEL_DISC) return s;
    s.conductance = conductance;
    s.substeps = substeps;
    return s;
}

double tolerance(const frame_set *set, const ddof_settings *settings, double aspect) {
    const bool exact = settings->surface == DDOF_SURFACE_RGBA32F && settings->solver != DDOF_SOLVER_CR4_PACK;
    if (settings->kernel == DDOF_KERNEL_DISC) return disc_tolerance(settings->surface);
    if (!exact) return 2e-3;
    return set->kind.is_depth ? 1e-5 : tolerance_of(&set->values, settings, aspect);
}

/* The disc kernel undershoots and overshoots, some formats do not. */
static double stored(VkFormat format, double v, int c) {
    if (format == VK_FORMAT_R32G32B32A32_SFLOAT || format == VK_FORMAT_R16G16B16A16_SFLOAT) return v;
    if (format == VK_FORMAT_B10G11R11_UFLOAT_PACK32) return c == 3 ? 1 : fmax(v, 0);
    return fmin(fmax(v, 0), 1);
}

static double range_of(const frame_set *set) {
    double range = 0;
    for (int i = 0; i < set->kind.width * set->kind.height * 4; i++)
        if (isfinite(set->values.color[i])) range = fmax(range, fabs(set->values.color[i]));
    return range;
}

/* ---- rendering */

ddof_vulkan_frame *frame_of(ddof_vulkan *vk, const frame_set *set, const ddof_settings *settings) {
    ddof_vulkan_frame *frame = NULL;
    const ddof_status status = ddof_vulkan_frame_create(vk, &frame, &set->images, settings);
    if (status != DDOF_OK)
        fail_msg("ddof_vulkan_frame_create: %s: %s", ddof_status_text(status), ddof_vulkan_error(vk));
    assert_string_equal(ddof_vulkan_error(vk), "");
    return frame;
}

void record(ddof_vulkan_frame *frame, VkCommandBuffer commands, const ddof_vulkan_view *view,
            const ddof_settings *settings, ddof_vulkan_stats *stats) {
    ddof_vulkan_stats ignored;
    if (!stats) stats = &ignored;
    memset(stats, 0xff, sizeof *stats);
    const ddof_status status = ddof_vulkan_record(frame, commands, view, settings, stats);
    if (status != DDOF_OK)
        fail_msg("ddof_vulkan_record: %s: %s", ddof_status_text(status), ddof_vulkan_frame_error(frame));
    assert_string_equal(ddof_vulkan_frame_error(frame), "");
    assert_true(stats->solver >= DDOF_SOLVER_CR4_PACK && stats->solver <= DDOF_SOLVER_PCR3_SWEEP);
    for (int i = 0; i < COUNT(stats->reserved); i++)
        assert_int_equal(stats->reserved[i], 0);
}

ddof_vulkan_stats set_render(ddof_vulkan *vk, const frame_set *set, const ddof_vulkan_view *view,
                             const ddof_settings *settings) {
    ddof_vulkan_stats stats;
    const int dispatches = tap.dispatches;
    ddof_vulkan_frame *frame = frame_of(vk, set, settings);
    VkCommandBuffer commands = own_begin();
    record(frame, commands, view, settings, &stats);
    assert_int_equal(tap.dispatches - dispatches, stats.dispatches);
    own_finish(commands);
    ddof_vulkan_frame_destroy(&frame);
    assert_null(frame);
    return stats;
}

void set_compare(const frame_set *set, const ddof_vulkan_view *view, const float *want, double allowed,
                 const char *format, ...) {
    const ddof_vulkan_view v = whole(set, view);
    const picture *output = set->kind.output ? &set->output : &set->color;
    float *got = fenced((size_t)set->kind.width * (size_t)set->kind.height * 16, true);
    char what[300];
    va_list args;
    va_start(args, format);
    vsnprintf(what, sizeof what, format, args);
    va_end(args);
    picture_get(output, got);
    for (int y = 0; y < v.height; y++)
        for (int x = 0; x < v.width; x++)
            for (int c = 0; c < 4; c++) {
                const float a = got[4 * ((y + v.y) * set->kind.width + x + v.x) + c];
                const double b = stored(output->d.format, want[4 * (y * v.width + x) + c], c);
                if (!(fabs(a - b) <= allowed + texel_step(output->d.format, fabs(b) * 1.03, c)))
                    fail_msg("%s: channel %d of pixel (%d, %d) is %.9g, not %.9g; allowed %.3g and a step of %s", what,
                             c, x, y, a, b, allowed, format_name(output->d.format));
            }
    fenced_free(got);
}

ddof_vulkan_stats set_check(ddof_vulkan *vk, const frame_set *set, const ddof_vulkan_view *view,
                            const ddof_settings *settings, const char *what) {
    float *want = set_want(set, view, settings);
    const ddof_vulkan_stats stats = set_render(vk, set, view, settings);
    double allowed = tolerance(set, settings, view ? view->pixel_aspect : 1);
    if (set->kind.color == VK_FORMAT_R8G8B8A8_SRGB || set->kind.color == VK_FORMAT_B8G8R8A8_SRGB)
        allowed += 0.5 / 255; /* drivers take a polynomial for the power: half a step of the format */
    set_compare(set, view, want, range_of(set) * allowed, "%s, %s to %s, map %s, %s", what,
                format_name(set->kind.color), format_name(set->kind.output), format_name(set->kind.map),
                settings->kernel ? "disc" : solver_name(settings->solver));
    fenced_free(want);
    return stats;
}
