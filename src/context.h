/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* What a context holds, and the table a backend implements. */
#ifndef DDOF_CONTEXT_H
#define DDOF_CONTEXT_H

#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>

#include <ddof/ddof.h>

#include "disc.h"
#include "lens.h"
#include "threads.h"

/* One frame on its way through the pipeline: the caller's description, and what its first stages made of it. */
typedef struct frame_job {
    const ddof_frame *frame;
    const ddof_settings *settings;
    ddof_image coc_source; /* depth, turned into CoC by `curve`, or CoC itself */
    bool is_depth;
    lens_curve curve;
    double row_scale, column_scale; /* conductance of a link of CoC 1 px, per substep */
    int substeps;
    const disc_kernel *disc; /* NULL: the heat kernel, and the three above are its */
    double pixel_aspect;
    const float *const *source_rows; /* NULL, or for each row of the colour NULL or what is to be diffused in its place: RGBA float */
    ddof_method method;       /* SCATTER also where the bokeh is FULL */
    bool highlights;          /* bokeh HIGHLIGHTS */
    float nearest;            /* of the picture, where it is a filled_picture */
    const struct iris *iris;  /* of sprites; NULL where there are none */
    double focus_distance;    /* as in ddof_stats */
    int64_t nonfinite_pixels; /* out */
    int64_t sprites, sprites_dropped, sprites_large; /* out, as in ddof_stats */
} frame_job;

/* The same job for a part of the picture in memory of the library's own, blurred in place. */
typedef struct inner_job {
    frame_job job;
    ddof_frame frame;
    ddof_settings settings;
} inner_job;

/* The stages a backend implements. Validation is done: it gets nothing it may refuse. */
typedef struct backend {
    ddof_backend id;
    bool disc; /* diffuses with the disc kernel too */
    bool rows; /* diffuse() looks at job.source_rows */
    size_t (*scratch_bytes)(const ddof_context *ctx, const frame_job *job);
    ddof_status (*coc)(ddof_context *ctx, frame_job *job, void *scratch);
    ddof_status (*diffuse)(ddof_context *ctx, frame_job *job, void *scratch);
    /* The other methods; NULL: it has none. */
    ddof_status (*gaussian)(ddof_context *ctx, frame_job *job, void *scratch);
    ddof_status (*hexagon)(ddof_context *ctx, frame_job *job, void *scratch);
    /* job.highlights, with the diffusion between taking and drawing, and DDOF_METHOD_SCATTER. NULL: bokeh.c does it. */
    ddof_status (*sprites)(ddof_context *ctx, frame_job *job, void *scratch);
    const char *(*device)(const ddof_context *ctx);
    /* Of a backend with a device of its own, else NULL. A stage that fails otherwise than by cancelling has set the error. */
    ddof_status (*open)(ddof_context *ctx);
    void (*close)(ddof_context *ctx);
    void (*trim)(ddof_context *ctx);
    size_t (*surface_bytes)(const ddof_context *ctx);
    int (*list)(ddof_device *devices, int capacity); /* as ddof_devices(); needs no context */
} backend;

extern const backend backend_cpu, backend_reference, backend_gl, backend_vulkan;

struct ddof_context {
    ddof_config config; /* all callbacks filled in */
    int threads;
    const backend *backend;
    const struct cpu_kernels *kernels;
    void *device;      /* of the backend */
    struct iris *iris; /* NULL until sprites are asked for */
    thread_pool *pool; /* NULL when the caller runs the loops */
    void *scratch;
    size_t scratch_bytes;
    atomic_flag busy;
    char error[512];

    /* progress of the call under way */
    pthread_mutex_t progress_lock;
    double image_from, image_share;    /* what the image under way is of the whole, 0..1 */
    double progress_from, progress_to; /* what the stage under way is of the image */
    double progress_total;             /* units of the stage */
    _Atomic int64_t progress_done;
    double progress_shown; /* of the whole */
    atomic_bool cancelled;
};

/* What memory callbacks are where the caller gives none. */
void *context_allocate(void *user, size_t bytes);
void context_release(void *user, void *memory);

/* Whether all `reserved` members of a struct are 0. */
bool context_all_zero(const uint64_t *reserved, size_t count);
#define RESERVED_ZERO(p) context_all_zero((p)->reserved, sizeof(p)->reserved / sizeof *(p)->reserved)

/* Sets the error text and returns the status. */
ddof_status context_fail(ddof_context *ctx, ddof_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
void context_log(ddof_context *ctx, ddof_log_level level, const char *format, ...) __attribute__((format(printf, 3, 4)));

/* Counts `units` of progress_total as done and asks the caller whether to go on; false: stop. Any thread. */
bool context_progress(ddof_context *ctx, int64_t units);
/* Begins an image that is `share` of the whole from `from` on. */
void context_image(ddof_context *ctx, double from, double share);
/* Begins a stage that takes the work from `from` to `to` of the image; whoever does it sets progress_total. */
void context_stage(ddof_context *ctx, double from, double to);

/* Validation (check.c): DDOF_OK or context_fail. `work`: with color and output, as ddof_render wants them. */
ddof_status check_config(const ddof_config *config, const char **wrong);
ddof_status check_frame(ddof_context *ctx, const ddof_frame *frame, bool work);
ddof_status check_geometry(ddof_context *ctx, const ddof_frame *frame); /* its place in the picture */
ddof_status check_settings(ddof_context *ctx, const ddof_frame *frame, const ddof_settings *settings);

/* THE METHOD (pipeline.c). */
ddof_status pipeline_prepare(ddof_context *ctx, frame_job *job, const ddof_frame *frame, const ddof_settings *settings,
                             bool read, double *focus_distance);
ddof_status pipeline_run(ddof_context *ctx, frame_job *job, bool coc_only);
size_t pipeline_scratch_bytes(const ddof_context *ctx, const frame_job *job, bool coc_only);
size_t pipeline_iris_bytes(const frame_job *job); /* of ctx->iris, which is not part of it */
/* x, y: of the part, in the picture of `job`. */
void pipeline_inner(inner_job *inner, const frame_job *job, const ddof_image *part, const ddof_image *coc, int x, int y);
/* Makes job.iris, of the context's, where the job asks for sprites. */
ddof_status pipeline_iris(ddof_context *ctx, frame_job *job);
/* One layer: by the method, and with the sprites, that the job asks for. */
ddof_status pipeline_blur(ddof_context *ctx, frame_job *job, void *scratch);
size_t pipeline_blur_bytes(const ddof_context *ctx, const frame_job *job);

#endif
