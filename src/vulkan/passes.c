/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "passes.h"

#include <string.h>

#include "sprites.h"

enum {
    THREADS = 64, /* of a workgroup of the passes that have a thread for each unknown */
    SYSTEMS = 8,  /* that three steps of PCR leave */
    ROW_WORDS = 2 /* of 16 bytes, of a row in a table; a packed one has 1 */
};

static const size_t most_levels_bytes = (size_t)64 << 20; /* lines are solved in bands that need no more than this */

/* One direction of one substep; or, with `frame` to be prepared, the wish for its pipelines. */
typedef struct direction {
    const ddof_vulkan_frame *frame;
    ddof_vulkan_frame *prepare; /* not NULL: nothing is recorded, pipelines are made */
    VkCommandBuffer commands;
    vulkan_push push;
    int vertical; /* as in vulkan_constants */
    bool last, add;
    vulkan_picture from, to;
    int length, lines; /* pixels of a line */
    int *dispatches;
    ddof_status status;
} direction;

/* ---- one pass */

static const line_plan *plan_of(const direction *d) {
    return &d->frame->line[d->vertical != 0];
}

static vulkan_constants constants_of(const direction *d, vulkan_module module) {
    const ddof_vulkan_frame *f = d->frame;
    const line_plan *line = plan_of(d);
    const VkFormat target = vulkan_place(f, d->to) == PICTURE_OUTPUT ? f->images.output.format : f->work_format;
    const bool is_line = module <= MODULE_DISC_LINE_SUBGROUPS;
    vulkan_constants c;
    memset(&c, 0, sizeof c);
    c.workgroup = is_line ? line->workgroup : THREADS;
    c.vertical = d->vertical;
    c.depth = f->is_depth ? 1 + (int)f->depth_kind : 0;
    c.alpha = f->alpha;
    c.half = f->work_format == VK_FORMAT_R16G16B16A16_SFLOAT || f->solver == DDOF_SOLVER_CR4_PACK;
    c.target_half = target == VK_FORMAT_R16G16B16A16_SFLOAT;
    c.last = d->last;
    if (is_line) {
        c.k = line->k;
        c.strip = line->strip;
        c.subgroup = line->subgroup;
    }
    if (f->disc) {
        c.from_real = d->from == f->first;
        c.add = d->add;
    }
    return c;
}

static VkPipeline find_pipeline(const ddof_vulkan_frame *f, vulkan_module module, const vulkan_constants *c) {
    for (int i = 0; i < f->pipelines; i++)
        if (f->pipeline[i].module == module && !memcmp(&f->pipeline[i].constants, c, sizeof *c))
            return f->pipeline[i].handle;
    return VK_NULL_HANDLE;
}

static void prepare(direction *d, vulkan_module module) {
    ddof_vulkan_frame *f = d->prepare;
    const vulkan_constants c = constants_of(d, module);
    if (find_pipeline(f, module, &c)) return;
    if (f->pipelines == VULKAN_FRAME_PIPELINES) {
        d->status = context_fail(&f->vk->shell, DDOF_ERROR_UNSUPPORTED, "a frame has too many kinds of passes");
        return;
    }
    const VkPipeline handle = vulkan_pipeline_get(f->vk, module, &c, &d->status);
    if (handle) f->pipeline[f->pipelines++] = (vulkan_pipeline){module, c, handle};
}

static VkDescriptorSet find_set(const direction *d) {
    const ddof_vulkan_frame *f = d->frame;
    for (int i = 0; i < f->sets; i++)
        if (f->set[i].from == d->from && f->set[i].to == d->to) return f->set[i].handle;
    return VK_NULL_HANDLE; /* never */
}

static void barrier(const ddof_vulkan_frame *f, VkCommandBuffer commands, const VkImageMemoryBarrier2 *image,
                    uint32_t images) {
    const VkMemoryBarrier2 memory = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
                                     .srcStageMask = VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
                                     .srcAccessMask = VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
                                     .dstStageMask = VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
                                     .dstAccessMask = VK_ACCESS_2_SHADER_SAMPLED_READ_BIT |
                                                      VK_ACCESS_2_SHADER_STORAGE_READ_BIT |
                                                      VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT};
    const VkDependencyInfo info = {.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
                                   .memoryBarrierCount = 1,
                                   .pMemoryBarriers = &memory,
                                   .imageMemoryBarrierCount = images,
                                   .pImageMemoryBarriers = image};
    f->vk->f.CmdPipelineBarrier2(commands, &info);
}

/* One pass with as many workgroups; every pass but the first waits for the one before. */
static void pass(direction *d, vulkan_module module, int x, int y) {
    const ddof_vulkan_frame *f = d->frame;
    if (d->status != DDOF_OK) return;
    if (d->prepare) {
        prepare(d, module);
        return;
    }
    const VkDescriptorSet set = find_set(d);
    const vulkan_constants c = constants_of(d, module);
    const vulkan_functions *v = &f->vk->f;
    if ((*d->dispatches)++ > 0) barrier(f, d->commands, NULL, 0);
    v->CmdBindPipeline(d->commands, VK_PIPELINE_BIND_POINT_COMPUTE, find_pipeline(f, module, &c));
    v->CmdBindDescriptorSets(d->commands, VK_PIPELINE_BIND_POINT_COMPUTE, f->vk->pipeline_layout, 0, 1, &set, 0, NULL);
    v->CmdPushConstants(d->commands, f->vk->pipeline_layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof d->push, &d->push);
    v->CmdDispatch(d->commands, (uint32_t)x, (uint32_t)y, 1);
}

static int groups(int n, int size) {
    return (n + size - 1) / size;
}

/* A pass with a thread for each of `count` unknowns of each line of the band. */
static void level_pass(direction *d, vulkan_module module, int count) {
    d->push.to_unknowns = count;
    if (d->vertical)
        pass(d, module, groups(d->push.lines, THREADS), count);
    else
        pass(d, module, groups(count, THREADS), d->push.lines);
}

/* ---- the solvers */

static void line(direction *d) {
    static const vulkan_module module[2][2] = {{MODULE_LINE, MODULE_LINE_SUBGROUPS},
                                               {MODULE_DISC_LINE, MODULE_DISC_LINE_SUBGROUPS}};
    const line_plan *plan = plan_of(d);
    d->push.unknowns = d->length;
    d->push.lines = d->lines;
    d->push.first_line = 0;
    pass(d, module[d->frame->disc != NULL][plan->subgroup > 1], groups(d->lines, plan->strip), 1);
}

/* PCR of the first `steps` steps, from the picture to one of two tables. Returns where it ends. */
static uint32_t pcr_steps(direction *d, int most, uint32_t table[2]) {
    int turn = 0;
    for (int stride = 1; stride < most; stride *= 2, turn ^= 1) {
        d->push.unknowns = d->length;
        d->push.stride = stride;
        d->push.rows_at = table[turn ^ 1];
        d->push.to_at = table[turn];
        level_pass(d, stride == 1 ? MODULE_PCR_FIRST : MODULE_PCR, d->length);
    }
    return table[turn ^ 1];
}

static void pcr(direction *d) {
    const uint32_t words = (uint32_t)d->length * (uint32_t)d->push.lines * ROW_WORDS;
    uint32_t table[2] = {0, words};
    int last = 1; /* stride of the last step, which writes the unknowns */
    while (2 * last < d->length)
        last *= 2;
    d->push.rows_at = pcr_steps(d, last, table);
    d->push.stride = last;
    level_pass(d, MODULE_PCR_LAST, d->length);
}

static void pcr3_sweep(direction *d) {
    const uint32_t words = (uint32_t)d->length * (uint32_t)d->push.lines * ROW_WORDS;
    uint32_t table[2] = {0, words};
    d->push.rows_at = pcr_steps(d, SYSTEMS, table);
    d->push.to_at = table[0] + table[1] - d->push.rows_at;
    d->push.stride = SYSTEMS;
    if (d->vertical)
        pass(d, MODULE_SWEEP, groups(d->push.lines, THREADS), SYSTEMS);
    else
        pass(d, MODULE_SWEEP, groups(SYSTEMS * d->push.lines, THREADS), 1);
}

/* The chain of CR4: unknowns of its levels, and where they begin for one line, in words of 16 bytes. */
typedef struct chain {
    int levels;
    int unknowns[32];
    uint32_t rows[32], y[2], words; /* for each line */
} chain;

static chain chain_of(int length) {
    chain c = {0};
    for (int n = length / 4;; n /= 2) {
        c.unknowns[c.levels] = n;
        c.rows[c.levels++] = c.words;
        c.words += (uint32_t)n;
        if (n <= 3) break;
    }
    for (int i = 0; i < 2; i++) { /* colours of two unknowns fit into a word */
        c.y[i] = c.words;
        c.words += ((uint32_t)c.unknowns[i < c.levels ? i : 0] + 1) / 2;
    }
    return c;
}

static void cr4_pack(direction *d) {
    const chain c = chain_of(d->length);
    const uint32_t lines = (uint32_t)d->push.lines;
    const int end = c.levels - 1;
    vulkan_push *p = &d->push;
    p->unknowns = d->length;
    p->to_at = c.rows[0] * lines;
    level_pass(d, MODULE_INITIAL_REDUCE4, c.unknowns[0]);
    for (int k = 1; k <= end; k++) {
        p->unknowns = c.unknowns[k - 1];
        p->rows_at = c.rows[k - 1] * lines;
        p->to_at = c.rows[k] * lines;
        level_pass(d, MODULE_REDUCE, c.unknowns[k]);
    }
    p->unknowns = c.unknowns[end];
    p->rows_at = c.rows[end] * lines;
    p->to_at = c.y[end % 2] * lines;
    level_pass(d, MODULE_SOLVE, c.unknowns[end]);
    for (int k = end - 1; k >= 0; k--) {
        p->unknowns = c.unknowns[k];
        p->known = c.unknowns[k + 1];
        p->rows_at = c.rows[k] * lines;
        p->y_at = c.y[(k + 1) % 2] * lines;
        p->to_at = c.y[k % 2] * lines;
        level_pass(d, MODULE_SUBSTITUTE, c.unknowns[k]);
    }
    p->unknowns = d->length;
    p->known = c.unknowns[0];
    p->y_at = c.y[0] * lines;
    level_pass(d, MODULE_FINAL_SOLVE4, d->length);
}

static size_t bytes_per_line(ddof_solver solver, int length) {
    if (solver == DDOF_SOLVER_LINE || length < VULKAN_SHORT) return 0;
    if (solver == DDOF_SOLVER_CR4_PACK) return (size_t)chain_of(length).words * 16;
    return (size_t)length * 2 * ROW_WORDS * 16;
}

static size_t band_bytes(ddof_solver solver, int length, int lines) {
    const size_t one = bytes_per_line(solver, length);
    if (!one) return 0;
    const size_t most = most_levels_bytes / one, n = (size_t)lines < most ? (size_t)lines : most;
    return one * (n ? n : 1);
}

size_t vulkan_levels_bytes(ddof_solver solver, int width, int height) {
    const size_t rows = band_bytes(solver, width, height), columns = band_bytes(solver, height, width);
    return rows > columns ? rows : columns;
}

static void solve(direction *d) {
    const ddof_solver solver = d->frame->solver;
    const size_t one = bytes_per_line(solver, d->length);
    if (!one) {
        line(d);
        return;
    }
    const size_t fit = d->frame->scratch.buffer_bytes[BUFFER_LEVELS] / one;
    const int band = fit < (size_t)d->lines ? (int)fit : d->lines;
    for (int first = 0; first < d->lines && d->status == DDOF_OK; first += band) {
        d->push.first_line = first;
        d->push.lines = d->lines - first < band ? d->lines - first : band;
        if (solver == DDOF_SOLVER_PCR)
            pcr(d);
        else if (solver == DDOF_SOLVER_PCR3_SWEEP)
            pcr3_sweep(d);
        else
            cr4_pack(d);
        if (d->prepare) break; /* all bands are alike */
    }
}

/* ---- the frame */

vulkan_picture_push vulkan_picture_push_of(const ddof_vulkan_frame *f, const frame_job *job,
                                           const vulkan_region *region) {
    const lens_curve *c = &job->curve;
    return (vulkan_picture_push){
        .lens_curve = {c->q_far, lens_q_near(c), c->gain_far, c->gain_near},
        .depth_axis = {c->x_center - (float)job->frame->offset_x, c->y_center - (float)job->frame->offset_y,
                       c->x_tangent, c->y_tangent},
        .depth_linear = {c->offset, c->slope},
        .lens_limit = {c->limit_far, c->limit_near},
        .color_place = {region->x, region->y},
        .map_place = {region->x >> f->map_shift, region->y >> f->map_shift},
        .map_shift = f->map_shift,
    };
}

static void substeps(direction *d, const frame_job *job, const vulkan_region *region) {
    const ddof_vulkan_frame *f = d->frame;
    const vulkan_picture between = f->scratch.image[PICTURE_ROWS] ? PICTURE_ROWS : PICTURE_WORK;
    for (int i = 0; i < job->substeps; i++) {
        d->push.first_pass = i == 0;
        d->push.scale = (float)job->row_scale;
        d->vertical = false;
        d->last = false;
        d->from = i == 0 ? d->frame->first : PICTURE_WORK;
        d->to = between;
        d->length = region->width;
        d->lines = region->height;
        solve(d);
        d->push.first_pass = 0;
        d->push.scale = (float)job->column_scale;
        d->vertical = true;
        d->last = i == job->substeps - 1;
        d->from = between;
        d->to = d->last ? PICTURE_OUTPUT : PICTURE_WORK;
        d->length = region->height;
        d->lines = region->width;
        solve(d);
    }
}

static vulkan_disc_push disc_push(const disc_kernel *kernel, int component, int way, double pixel_aspect) {
    const disc_component *c = &kernel->component[component];
    const disc_share share = disc_direction(kernel, way, pixel_aspect);
    return (vulkan_disc_push){.fade = (float)kernel->fade,
                              .beta = {(float)c->beta_re, (float)c->beta_im},
                              .offset = {(float)c->offset_re, (float)c->offset_im},
                              .weight = {(float)c->weight_re, (float)c->weight_im},
                              .level = (float)share.level,
                              .slope = (float)share.slope,
                              .excess = (float)disc_excess(kernel)};
}

/* One component after the other; the first, whose weight is the largest, comes last, and is not rounded in the sum. */
static void disc(direction *d, const frame_job *job, const vulkan_region *region) {
    const disc_kernel *kernel = d->frame->disc;
    const int ways = kernel->directions * kernel->substeps;
    for (int j = kernel->components - 1; j >= 0; j--)
        for (int i = 0; i < ways; i++) {
            const int way = i % kernel->directions;
            d->push.disc = disc_push(kernel, j, way, job->pixel_aspect);
            d->push.first_pass = i == 0;
            d->vertical = way;
            d->last = i == ways - 1;
            d->add = d->last && j < kernel->components - 1;
            d->from = i == 0 ? d->frame->first : PICTURE_WORK;
            d->to = !d->last ? PICTURE_WORK : j > 0 ? PICTURE_SUM : PICTURE_OUTPUT;
            d->length = way == DISC_ROWS ? region->width : region->height;
            d->lines = way == DISC_ROWS ? region->height : region->width;
            line(d);
        }
}

static void all_passes(direction *d, const frame_job *job, const vulkan_region *region) {
    if (d->frame->disc)
        disc(d, job, region);
    else
        substeps(d, job, region);
}

ddof_status vulkan_passes_prepare(ddof_vulkan_frame *frame) {
    const int width = (int)frame->images.color.width, height = (int)frame->images.color.height;
    const vulkan_region all = {0, 0, width, height}, least = {0, 0, 1, 1};
    /* between two substeps passes are others than before and after */
    const frame_job job = {.substeps = 2, .pixel_aspect = 1};
    direction d = {.frame = frame, .prepare = frame};
    all_passes(&d, &job, &all);
    if (frame->solver != DDOF_SOLVER_LINE) all_passes(&d, &job, &least);
    return d.status;
}

/* Scratch images are discarded, and whatever used scratch memory before is waited for. */
static void begin(const ddof_vulkan_frame *f, VkCommandBuffer commands) {
    VkImageMemoryBarrier2 image[VULKAN_PICTURES];
    uint32_t images = 0;
    for (int i = 0; i < VULKAN_PICTURES; i++)
        if (f->scratch.image[i] && i != PICTURE_LIGHT && i != PICTURE_WEIGHT) /* the render pass does that */
            image[images++] = (VkImageMemoryBarrier2){.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2,
                                                      .srcStageMask = VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
                                                      .srcAccessMask = VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
                                                      .dstStageMask = VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
                                                      .dstAccessMask = VK_ACCESS_2_SHADER_SAMPLED_READ_BIT |
                                                                       VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
                                                      .oldLayout = VK_IMAGE_LAYOUT_UNDEFINED,
                                                      .newLayout = VK_IMAGE_LAYOUT_GENERAL,
                                                      .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                                      .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                                      .image = f->scratch.image[i],
                                                      .subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1}};
    if (f->scratch.total.size) barrier(f, commands, image, images);
}

int vulkan_passes_record(const ddof_vulkan_frame *frame, VkCommandBuffer commands, const frame_job *job,
                         const vulkan_region *region) {
    int dispatches = 0;
    direction d = {.frame = frame,
                   .commands = commands,
                   .push = {.picture = vulkan_picture_push_of(frame, job, region)},
                   .dispatches = &dispatches};
    begin(frame, commands);
    if (frame->sprites) dispatches += vulkan_sprites_draw(frame, commands, job, region);
    if (frame->sprite_kind.bokeh != DDOF_BOKEH_FULL) all_passes(&d, job, region);
    if (frame->sprites) dispatches += vulkan_sprites_resolve(frame, commands, job, region);
    return dispatches;
}
