/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "memory.h"

#include "message.h"
#include "scratch.h"

enum {
    MIB = 1 << 20,
    SPARE = 16 * MIB,      /* for what is small */
    BLOCK_ROWS = 16,       /* of the CPU engine, at most */
    BLOCK_PIXEL = 96,      /* bytes of a block's pixel in all the places it passes through */
    CHUNKS_AT_ONCE = 5     /* per thread: packed, unpacked, filtered, waiting to be written */
};

static uint64_t pixels_of(const io_channel *c) {
    return (uint64_t)c->width * (uint64_t)c->height;
}

static uint64_t colour_bytes(const job *j, const job_group *g) {
    uint64_t bytes = 0;
    for (int n = 0; n < g->count; n++)
        for (int i = 0; i < g->color[n].count; i++)
            bytes += io_channel_bytes(job_image_channel(j, &g->color[n], i));
    return bytes;
}

/* What is read. */
static uint64_t input_bytes(const job *j, const options *o, bool whole_parts) {
    uint64_t bytes = 0;
    for (int p = 0; p < j->input->part_count && whole_parts; p++)
        for (int i = 0; i < j->input->part[p].channel_count && job_part_is_blurred(j, p); i++)
            bytes += io_channel_bytes(&j->input->part[p].channel[i]);
    for (int g = 0; g < j->group_count; g++) {
        const io_channel *blur = job_blur_channel(j, &j->group[g]);
        const bool read = whole_parts && !j->second && job_part_is_blurred(j, j->group[g].blur.part);
        if (!whole_parts) bytes += colour_bytes(j, &j->group[g]);
        if (!read) bytes += io_channel_bytes(blur);
        if (blur->type == IO_UINT || option_number(o, OPT_COC_SCALE, 1) != 1) bytes += pixels_of(blur) * sizeof(float);
    }
    if (option_given(o, OPT_HOLDOUT)) bytes += pixels_of(job_color(j, 0)) * sizeof(float);
    return bytes;
}

/* What is made of it: a CoC, a picture in another format, rows of a PNG. */
static uint64_t output_bytes(const job *j, const options *o, io_format format, bool whole_part) {
    const io_part *part = job_part(j);
    const uint64_t display = (uint64_t)part->display.width * (uint64_t)part->display.height;
    uint64_t bytes = 0;
    if (o->command == COMMAND_COC) bytes = display * sizeof(float) * (format == IO_PNG ? 4 : 2);
    if (o->command != COMMAND_COC && !whole_part) bytes = display * sizeof(float) * (uint64_t)j->color.count;
    if (format == IO_PNG) bytes += display * 2 * (uint64_t)j->color.count;
    return bytes;
}

/* The library looks at sizes and types, and compares the addresses of planes: these are apart, and never used. */
static ddof_image pretend(int width, int height, int channels, ddof_type type, int at) {
    ddof_image image = {.width = width, .height = height, .channels = channels};
    for (int c = 0; c < channels; c++)
        image.plane[c] = (ddof_plane){.data = (void *)((uintptr_t)(at + c + 1) << 43), .type = type};
    return image;
}

static uint64_t larger(uint64_t a, uint64_t b) {
    return a > b ? a : b;
}

static int image_bytes(const job *j, const io_selection *color, const options *o, const session *s, uint64_t *bytes) {
    const io_channel *first = job_image_channel(j, color, 0);
    const ddof_type type = first->type == IO_HALF ? DDOF_HALF : DDOF_FLOAT;
    ddof_frame frame = {0};
    ddof_settings settings = j->settings;
    size_t scratch = 0;
    const ddof_image mask = pretend(first->width, first->height, 1, DDOF_FLOAT, 5);
    frame.color = frame.output = pretend(first->width, first->height, color->count, type, 0);
    frame.coc = pretend(first->width, first->height, 1, DDOF_FLOAT, 4);
    if (option_given(o, OPT_HOLDOUT)) frame.holdout = &mask;
    const ddof_status status = ddof_scratch_bytes(s->context, &frame, &settings, &scratch);
    *bytes = larger(*bytes, scratch);
    return status == DDOF_OK ? 0 : session_fail(s, status, o->file[0]);
}

/* Of the image that needs most: they are solved one after the other. */
static int solver_bytes(const job *j, const options *o, const session *s, uint64_t *bytes) {
    int status = 0;
    *bytes = 0;
    for (int g = 0; g < j->group_count; g++)
        for (int n = 0; n < j->group[g].count && status == 0; n++) status = image_bytes(j, &j->group[g].color[n], o, s, bytes);
    return status;
}

/* What must be in memory at one time. */
static uint64_t least_bytes(const job *j, const options *o) {
    const uint64_t threads = (uint64_t)io_thread_count((int)option_number(o, OPT_THREADS, 0));
    const uint64_t width = (uint64_t)job_color(j, 0)->width;
    uint64_t chunk = job_part(j)->chunk_bytes;
    for (int p = 0; p < j->input->part_count; p++)
        if (job_part_is_blurred(j, p)) chunk = larger(chunk, j->input->part[p].chunk_bytes);
    if (j->second) chunk = larger(chunk, j->second->part[j->group[0].blur.part].chunk_bytes);
    return threads * (chunk * CHUNKS_AT_ONCE + width * BLOCK_ROWS * BLOCK_PIXEL) + SPARE;
}

static uint64_t in_mib(uint64_t bytes) {
    return (bytes + MIB - 1) / MIB;
}

int memory_plan(const job *j, const options *o, const session *s, const io_format *rewrite) {
    const uint64_t limit = scratch_limit();
    if (!limit) return 0;
    io_format format = IO_EXR;
    io_format_of_name(option_text(o, OPT_OUTPUT), &format);
    const bool whole_part = rewrite && *rewrite == j->input->format;
    uint64_t solver;
    const int status = solver_bytes(j, o, s, &solver);
    if (status) return status;
    const uint64_t frames = (uint64_t)scratch_frames();
    const uint64_t large = frames * (solver + input_bytes(j, o, whole_part) + output_bytes(j, o, format, whole_part));
    const uint64_t least = scratch_base() + frames * least_bytes(j, o);
    if (least + large <= limit) return 0;
    if (s->backend != DDOF_BACKEND_CPU)
        return fail("--max-memory: %s needs %llu MiB with --backend %s, which works on whole pictures; use --backend cpu, or "
                    "give at least %lluM",
                    o->file[0], (unsigned long long)in_mib(least + large), backend_name(s->backend),
                    (unsigned long long)in_mib(least + large));
    const uint64_t smallest = least / 5 * 8 + 8;
    if (limit < smallest)
        return fail_usage("--max-memory: %s is too little for a picture %d pixels wide; give at least %lluM%s",
                          option_text(o, OPT_MAX_MEMORY), job_color(j, 0)->width, (unsigned long long)in_mib(smallest),
                          frames > 1                              ? ", or --in-flight 1"
                          : option_number(o, OPT_THREADS, 0) == 1 ? ""
                                                                  : ", or fewer --threads");
    return scratch_stream(large);
}
