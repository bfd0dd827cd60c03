/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* ddof: depth of field for finished pictures, by simulated heat diffusion.
 *
 *     ddof_context *ctx = NULL;
 *     if (ddof_create(&ctx, NULL) != DDOF_OK) return 1;
 *     ddof_frame frame = {
 *         .color = ddof_image_interleaved(rgba, width, height, 4, DDOF_FLOAT, 0),
 *         .depth = ddof_image_interleaved(z, width, height, 1, DDOF_FLOAT, 0),
 *         .output = ddof_image_interleaved(result, width, height, 4, DDOF_FLOAT, 0),
 *     };
 *     ddof_settings settings = {
 *         .lens = {.focal_length = 85, .f_number = 2, .focus_distance = 4},
 *     };
 *     if (ddof_render(ctx, &frame, &settings, NULL) != DDOF_OK) puts(ddof_error(ctx));
 *     ddof_destroy(&ctx);
 *
 * Conventions. Pictures are scene-linear; row 0 is the top row, column 0 the left one. A zeroed
 * struct means defaults, and every default is stated at its field. The circle of confusion (CoC) is
 * a SIGNED DIAMETER IN PIXELS: negative lies nearer than the focus, positive farther. Every function
 * that can fail returns a ddof_status; ddof_error() then says which argument was wrong and what
 * to do. The library never prints, never aborts, reads no file and no environment variable, and
 * keeps no global state. `reserved` members must be 0 (INVALID otherwise): within a major version structs keep
 * their size, and 0 in a member keeps its meaning.
 */
#ifndef DDOF_DDOF_H
#define DDOF_DDOF_H

#include <stddef.h>
#include <stdint.h>

#include <ddof/version.h>

#if defined(__GNUC__)
#define DDOF_API __attribute__((visibility("default")))
#else
#define DDOF_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

typedef enum ddof_status {
    DDOF_OK = 0,
    DDOF_ERROR_INVALID = 1,     /* an argument is wrong: see ddof_error() */
    DDOF_ERROR_MEMORY = 2,      /* the allocator returned NULL */
    DDOF_ERROR_CANCELLED = 3,   /* the progress callback asked to stop */
    DDOF_ERROR_UNSUPPORTED = 4, /* this build or this machine cannot do it */
    DDOF_ERROR_BUSY = 5,        /* the context is in use by another thread, or by this call's own callback */
    DDOF_ERROR_DEVICE = 6       /* a GPU was lost or ran out of its memory */
} ddof_status;

/* A short fixed text for a status, never NULL. Thread-safety: any thread. */
DDOF_API const char *ddof_status_text(ddof_status status);

/* The version of the library that runs, "major.minor.patch". Thread-safety: any thread. */
DDOF_API const char *ddof_version(void);

/* ------------------------------------------------------------------------- pictures */

typedef enum ddof_type {
    DDOF_FLOAT = 0, /* IEEE binary32 */
    DDOF_HALF = 1   /* IEEE binary16; values beyond its range are written as infinity */
} ddof_type;

/* One channel of a picture in the caller's memory. Strides are in bytes, may be negative and must be multiples of the size
 * of the type; data must be aligned to the size of the type. 0 means tight, so a broadcast array (stride 0) cannot be
 * described: copy it first. Distinct pixels of an output must not share memory. */
typedef struct ddof_plane {
    void *data;             /* the value of pixel (0, 0) */
    ddof_type type;         /* default DDOF_FLOAT */
    ptrdiff_t pixel_stride; /* from a pixel to its right neighbour; 0: the size of the type */
    ptrdiff_t row_stride;   /* from a row to the one below; 0: width * |pixel_stride| */
} ddof_plane;

typedef enum ddof_alpha {
    DDOF_ALPHA_PREMULTIPLIED = 0, /* colour is multiplied by alpha already, or there is no alpha */
    DDOF_ALPHA_STRAIGHT = 1       /* the last of 2 or 4 channels is alpha and colour is not multiplied by it: multiplied
                                     before the blur, divided again after (colour 0 where alpha is 0). Looked at in
                                     frame.color only; the output is written the same way */
} ddof_alpha;

/* A picture: 1 to 4 channels of one size, each described by itself, so that interleaved, planar,
 * mixed types and an alpha of its own memory are all the same thing. Owns nothing. Fastest: four float
 * channels interleaved, rows aligned to 64 bytes. */
typedef struct ddof_image {
    int width, height; /* pixels, 1 to 2^20 each */
    int channels;      /* 1 to 4; 0: no image */
    ddof_alpha alpha;
    ddof_plane plane[4];
} ddof_image;

/* Interleaved channels (RGBARGBA...); row_stride in bytes, 0: width * channels * size of type. Channels outside 1..4 or no
 * data make an image that every call refuses. */
static inline ddof_image ddof_image_interleaved(void *data, int width, int height, int channels, ddof_type type,
                                                ptrdiff_t row_stride) {
    ddof_image image = {width, height, channels, DDOF_ALPHA_PREMULTIPLIED, {{NULL, DDOF_FLOAT, 0, 0}}};
    ptrdiff_t size = type == DDOF_HALF ? 2 : 4;
    int c;
    for (c = 0; c < channels && c < 4; c++) {
        image.plane[c].data = data ? (char *)data + c * size : NULL;
        image.plane[c].type = type;
        image.plane[c].pixel_stride = channels * size;
        image.plane[c].row_stride = row_stride;
    }
    return image;
}

/* One array per channel (data[0..channels-1]); row_stride in bytes, 0: width * size of type. */
static inline ddof_image ddof_image_planar(void *const data[], int width, int height, int channels, ddof_type type,
                                           ptrdiff_t row_stride) {
    ddof_image image = {width, height, channels, DDOF_ALPHA_PREMULTIPLIED, {{NULL, DDOF_FLOAT, 0, 0}}};
    int c;
    for (c = 0; c < channels && c < 4; c++) {
        image.plane[c].data = data[c];
        image.plane[c].type = type;
        image.plane[c].row_stride = row_stride;
    }
    return image;
}

/* ------------------------------------------------------------------------- depth, lens, circle of confusion */

typedef enum ddof_depth_kind {
    DDOF_DEPTH_PLANAR = 0,     /* distance along the optical axis, in the scene's unit */
    DDOF_DEPTH_RAY = 1,        /* length of the ray from the camera's centre; needs lens.focal_length, sensor_width */
    DDOF_DEPTH_INVERSE = 2,    /* 1 / planar distance (disparity): 0 is infinitely far */
    DDOF_DEPTH_NORMALIZED = 3, /* planar distance linear in the value: z_at_0 where it is 0, z_at_1 where it is 1 */
    DDOF_DEPTH_DEVICE = 4      /* 1 / planar distance linear in the value: a graphics API's depth buffer, or a
                                  normalised disparity map */
} ddof_depth_kind;

/* How the values of the depth image become planar distances z, in scene units.
 * RAY: z = r f / sqrt(f^2 + X^2 + Y^2), with X, Y the place on the sensor of the pixel's centre; the axis meets the centre
 * of the picture. Values outside 0..1 of NORMALIZED and DEVICE follow the same formula.
 * Stated rules: NaN makes the pixel a hole, see ddof_render(); so does +infinity with INVERSE. Otherwise +-infinity, and
 * any z <= 0 (renderers write 0 where nothing was hit), are infinitely far: the CoC takes its limit. */
typedef struct ddof_depth {
    ddof_depth_kind kind;  /* default DDOF_DEPTH_PLANAR */
    double z_at_0, z_at_1; /* NORMALIZED and DEVICE: the distances meant by 0 and 1, > 0 and different. Classic depth
                              buffer: near, far; reversed-Z: far, near; a map where white is near: far, near. With
                              DEVICE one may be INFINITY (reversed-Z with infinite far plane: INFINITY, near) */
    uint64_t reserved[4];
} ddof_depth;

typedef enum ddof_lens_kind {
    DDOF_LENS_THIN = 0,  /* a real lens: focal length, f-number, sensor width, focus distance */
    DDOF_LENS_ARTIST = 1 /* focus distance and the largest blur wanted on either side */
} ddof_lens_kind;

typedef enum ddof_focus_kind {
    DDOF_FOCUS_DISTANCE = 0, /* focus_distance is given */
    DDOF_FOCUS_PIXEL = 1     /* focus on what is seen at pixel (focus_x, focus_y) of the depth image */
} ddof_focus_kind;

/* The lens. With W the width of the whole picture in pixels, z the planar distance, s0, s1 = s -+ in_focus_range/2:
 *     q(z) = (z - s1)/z beyond s1,  (z - s0)/z before s0,  0 between
 *   THIN    CoC = (f/N) * q * f/(s - f) * W/sensor_width          (Riguer et al. 2004), all lengths in one unit
 *   ARTIST  CoC = max_coc_far * W * q beyond the focus, max_coc_near * W * max(q, -1) before it: the law of the lens,
 *           scaled so that it tends to max_coc_far at infinity and reaches max_coc_near at half the focus distance.
 * Then |CoC| is limited to limit_near * W, limit_far * W and 1e5 pixels.
 * Blur is a fraction of the picture in both, so a half-size proxy shows the same picture. */
typedef struct ddof_lens {
    ddof_lens_kind kind;   /* default DDOF_LENS_THIN */
    double focal_length;   /* f, millimetres, > 0. No default for THIN; ARTIST needs it for ray depth only */
    double f_number;       /* N, > 0. No default for THIN */
    double sensor_width;   /* of the whole picture's WIDTH, millimetres, > 0; 0: 36 */
    double unit;           /* millimetres in one scene unit, > 0; 0: 1000 (the scene is in metres) */
    ddof_focus_kind focus; /* default DDOF_FOCUS_DISTANCE */
    double focus_distance; /* s, scene units, > 0; THIN: beyond the focal length, may be INFINITY */
    int focus_x, focus_y;  /* DDOF_FOCUS_PIXEL: column and row in the depth image, inside it and not NaN there */
    double in_focus_range; /* scene units, >= 0: depth kept sharp around s; 0: none */
    double max_coc_near, max_coc_far; /* ARTIST: diameters reached, fractions of the picture's width; 0: stays sharp */
    double limit_near, limit_far;     /* THIN and ARTIST: no CoC is larger than this fraction of the width; 0: no limit */
    uint64_t reserved[8];
} ddof_lens;

typedef enum ddof_conductance {
    DDOF_CONDUCTANCE_MATCHED = 0, /* beta = d^2/32: as wide as the disc a lens makes (same variance) */
    DDOF_CONDUCTANCE_CLASSIC = 1  /* beta = d^2: the convention of Kass 2006 and Gruen 2011, 5.66 times wider */
} ddof_conductance;

typedef enum ddof_kernel {
    DDOF_KERNEL_HEAT = 0, /* real conductance: what a point becomes is a bell */
    DDOF_KERNEL_DISC = 1  /* complex conductance, whose real part is the even disc that a lens makes (docs/disc.md). Not on GL:
                             UNSUPPORTED there */
} ddof_kernel;

/* How close to a disc DDOF_KERNEL_DISC comes; the cost does not depend on the blur. */
typedef enum ddof_quality {
    DDOF_QUALITY_DEFAULT = 0, /* GOOD */
    DDOF_QUALITY_DRAFT = 1,   /* one component along rows and columns: a rounded diamond */
    DDOF_QUALITY_GOOD = 2,    /* two components along rows, columns and both diagonals: round */
    DDOF_QUALITY_BEST = 3     /* the same in two substeps: a flatter disc with a sharper rim */
} ddof_quality;

/* The next two are looked at by the GPU backends only: the CPU backends solve exactly, and differently. GL has 1 to 6
 * (docs/gl.md), Vulkan 5 and 7 to 9 (docs/vulkan.md); a solver that the backend lacks is UNSUPPORTED. All of 2 to 5 stop at two
 * or three unknowns. */
typedef enum ddof_solver {
    DDOF_SOLVER_DEFAULT = 0,    /* GL: CR4_PACK; Vulkan: LINE, with DDOF_KERNEL_DISC nothing else */
    DDOF_SOLVER_CR_VANILLA = 1, /* cyclic reduction 2:1 to one unknown, the coefficients of every pixel stored */
    DDOF_SOLVER_CR = 2,         /* those of full resolution made on the fly */
    DDOF_SOLVER_CR_PACK = 3,    /* the same, a row and its colour in 128 bits: colour in half floats */
    DDOF_SOLVER_CR4 = 4,        /* the first step 4:1, the last 1:4, coefficients from quarter resolution down */
    DDOF_SOLVER_CR4_PACK = 5,   /* the same, packed */
    DDOF_SOLVER_CR_PCR = 6,     /* 2:1 to at most 64 unknowns, which parallel cyclic reduction solves */
    DDOF_SOLVER_LINE =
        7,               /* a workgroup holds a whole line: k:1 in registers, PCR in subgroups and shared memory, 1:k */
    DDOF_SOLVER_PCR = 8, /* parallel cyclic reduction from the pixels on, through memory */
    DDOF_SOLVER_PCR3_SWEEP = 9 /* three steps of it, then a serial sweep along each of the 8 systems */
} ddof_solver;

typedef enum ddof_surface {
    DDOF_SURFACE_DEFAULT = 0, /* RGBA16F */
    DDOF_SURFACE_RGBA16F = 1, /* colour under way in half floats: error up to 2e-3 of the range for each substep, 5e-3
                                 with DDOF_KERNEL_DISC */
    DDOF_SURFACE_RGBA32F = 2  /* in floats: 1e-4 (2e-3 where the solver packs), twice the memory for colour */
} ddof_surface;

typedef enum ddof_layers {
    DDOF_LAYERS_OFF = 0, /* one layer: sharp things keep their edge by keeping everything behind them from blurring into them */
    DDOF_LAYERS_AUTO = 1 /* near things blur over what is sharp, and what lies behind goes on behind them, where the picture
                            has such things (docs/layers.md). Constants stay; the sum and the range do not hold any more. By
                            ddof_render() only: UNSUPPORTED in recorded GL and Vulkan work */
} ddof_layers;

/* How a picture is blurred. The last three are the classical ones, kept for comparison (docs/methods.md): on the CPU and GL
 * backends, UNSUPPORTED on the others, but for SCATTER, which Vulkan has too. Kernel, quality, conductance, substeps and solver
 * are DIFFUSION's alone. */
typedef enum ddof_method {
    DDOF_METHOD_DIFFUSION = 0,
    DDOF_METHOD_GAUSSIAN = 1, /* separable Gaussian, sigma |CoC|/4, of taps weighted by their own CoC */
    DDOF_METHOD_HEXAGON = 2,  /* three sheared box passes along the sides of a hexagon (Frostbite 2, 2011) */
    DDOF_METHOD_SCATTER = 3   /* the same as DDOF_BOKEH_FULL */
} ddof_method;

/* Sprites: pixels drawn as the picture of the iris that they are out of focus (docs/bokeh.md). */
typedef enum ddof_bokeh {
    DDOF_BOKEH_OFF = 0,        /* diffusion alone */
    DDOF_BOKEH_HIGHLIGHTS = 1, /* what of a pixel is brighter than sprites.threshold is taken out of the picture before it is
                                  blurred, and drawn afterwards with the same sum. Needs DDOF_METHOD_DIFFUSION */
    DDOF_BOKEH_FULL = 2        /* every pixel out of focus is drawn; nothing is diffused. Far, in focus and near are gathered by
                                  themselves and laid over each other. The cost grows with the square of the CoC up to 64 pixels */
} ddof_bokeh;

typedef enum ddof_resolution {
    DDOF_RESOLUTION_DEFAULT = 0, /* HIGHLIGHTS: FULL; DDOF_BOKEH_FULL: HALF */
    DDOF_RESOLUTION_FULL = 1,
    DDOF_RESOLUTION_HALF = 2     /* sprites are added up in a picture of half the size, rounded up, which is then interpolated. In
                                    either case those larger than 64 pixels are in smaller ones: of 1/2 from there on, of 1/4
                                    from 128 on, and so on */
} ddof_resolution;

/* How the Vulkan backend appends and draws sprites; the pictures are the same. For comparison: others ignore it. */
typedef enum ddof_append {
    DDOF_APPEND_DEFAULT = 0,  /* COUNTER */
    DDOF_APPEND_COUNTER = 1,  /* a workgroup counts its sprites and adds them to a counter at once; the counter is copied to the
                                 draw's arguments */
    DDOF_APPEND_ARGUMENTS = 2 /* every sprite is one atomic addition to the draw's arguments themselves */
} ddof_append;
typedef enum ddof_quads {
    DDOF_QUADS_DEFAULT = 0,   /* INSTANCED */
    DDOF_QUADS_INSTANCED = 1, /* a quad an instance, expanded in the vertex shader */
    DDOF_QUADS_GEOMETRY = 2   /* points, expanded by a geometry shader: UNSUPPORTED where the device has or enables none */
} ddof_quads;

/* Which pixels become sprites. With v the largest of a pixel's R, G and B (fewer channels: of those), it is a highlight where
 * v > threshold; 1 - (threshold/v)^2 of its colour is taken, alpha stays. Its CoC is that of the brightest pixel at most 2
 * pixels away. Below 2 pixels of |CoC| nothing is taken, from 4 on all; beyond `limit` again nothing.
 * A sprite farther than what is seen at a pixel does not cover it: light that falls on something nearer is lost, as in a lens.
 * What would fall out of the picture is diffused, and so stays in it. */
typedef struct ddof_sprites {
    double threshold;           /* scene-linear, > 0; 0: 1. Of HIGHLIGHTS */
    double limit;               /* HIGHLIGHTS: pixels of a larger CoC are left to diffusion; FULL: CoC is limited to it. Fraction of
                                   the picture's width, 0 to 1, and at most 4096 pixels; 0: 0.25 */
    int max_sprites;            /* HIGHLIGHTS: 1 to 2^20; 0: 65536. Where there are more highlights, or their areas add up to more
                                   than `max_area`, the threshold is raised until they do not: the brightest stay, and what is no
                                   longer above it is diffused. So no light is lost, and memory and time are bounded */
    int max_area;               /* HIGHLIGHTS: of all sprites, each as the square around it at the resolution it is drawn at: so many times
                                   the pixels of the picture, 1 to 1024; 0: 64 */
    ddof_resolution resolution;
    ddof_append append;         /* Vulkan only */
    ddof_quads quads;           /* Vulkan only */
    int reserved_int;           /* must be 0 */
    uint64_t reserved[4];
} ddof_sprites;

typedef enum ddof_iris_shape {
    DDOF_IRIS_DISC = 0,
    DDOF_IRIS_POLYGON = 1, /* of `blades` corners on the circle of the CoC */
    DDOF_IRIS_IMAGE = 2    /* what `image` shows */
} ddof_iris_shape;

/* The iris as a sprite shows it, of a light behind the focus; before the focus it is turned by 180 degrees. */
typedef struct ddof_iris {
    ddof_iris_shape shape;
    int blades;          /* POLYGON: 3 to 64, no default. Else 0 */
    double rotation;     /* degrees, counter-clockwise as seen in the picture, -3600 to 3600; 0: a corner points right, the image is
                            upright */
    double curvature;    /* POLYGON: of its sides, 0 straight to 1 a disc */
    double edge;         /* spherical aberration, -1 to 1: brightness goes as 1 + edge (2 r^2 - 1), r = 1 the rim; of lights before the
                            focus with the other sign. 0: even */
    double cats_eye;     /* 0 to 1: in the corner of the picture the iris is cut by a circle of its size, so many radii towards the
                            middle (before the focus: away from it). 0: nowhere. What is left has all the light */
    double squeeze;      /* anamorphic: the iris is so many times as tall as wide, 1 to 4; 0: 1. Its height is the CoC */
    double fringe;       /* axial colour, -0.5 to 0.5: behind the focus red is larger and blue smaller by this fraction, before it the
                            other way round. Each keeps its light. 0: none */
    ddof_image image;    /* IMAGE: 1 channel, how much light passes, >= 0; the CoC is its longer side, and it is laid down in the middle.
                            1 to 4096 pixels a side. Not a number, or below 0, counts as 0; all of it 0 is INVALID. Read during the call */
    uint64_t reserved[4];
} ddof_iris;

typedef struct ddof_settings {
    ddof_lens lens;               /* not used when frame.coc is given */
    ddof_depth depth;             /* not used when frame.coc is given */
    ddof_conductance conductance; /* default DDOF_CONDUCTANCE_MATCHED, and nothing else with DDOF_KERNEL_DISC */
    int substeps;                 /* HEAT: 1 to 64; 0: 1. More substeps round the kernel, at that many times the cost. DISC: 0,
                                     its quality says how many */
    ddof_solver solver;           /* GPU backends only; default see DDOF_SOLVER_DEFAULT */
    ddof_surface surface;         /* GPU backends only; default DDOF_SURFACE_RGBA16F */
    int shared_chain;             /* GL backend only; 0 or 1: the vertical pass reuses the surfaces of the horizontal one */
    ddof_kernel kernel;           /* default DDOF_KERNEL_HEAT */
    ddof_quality quality;         /* DDOF_KERNEL_DISC only, else 0 */
    ddof_layers layers;           /* default DDOF_LAYERS_OFF */
    ddof_method method;           /* default DDOF_METHOD_DIFFUSION */
    ddof_bokeh bokeh;             /* default DDOF_BOKEH_OFF */
    ddof_sprites sprites;         /* looked at unless bokeh is OFF */
    ddof_iris iris;               /* likewise; defaults are those of an even disc */
    uint64_t reserved[5];
} ddof_settings;

/* One more image of a frame, and its result: 1 to 4 channels, as frame.color and frame.output are. */
typedef struct ddof_pair {
    ddof_image color, output;
} ddof_pair;

/* What goes in and what comes out. All images have the size of `color`. */
typedef struct ddof_frame {
    ddof_image color;  /* read only */
    ddof_image depth;  /* 1 channel. Exactly one of `depth` and `coc` has channels */
    ddof_image coc;    /* 1 channel, signed diameter in pixels of this picture; |d| is limited to 1e5 */
    ddof_image output; /* as many channels as `color`; either the very planes of `color` (in place: data, type and
                          strides equal) or memory that overlaps no input. With DDOF_HALF the intermediate is kept
                          in float scratch and rounded once, to nearest even */
    /* Where this image lies in the camera's picture, for images that hold a part of it (an EXR data window smaller or
     * larger than the display window). All 0: the image is the picture. */
    int picture_width, picture_height; /* pixels; both or neither */
    int offset_x, offset_y;            /* of pixel (0, 0), in pixels of the picture */
    double pixel_aspect;               /* width / height of a pixel; 0: 1. CoC is in pixel widths; the blur is round
                                          on the screen */
    const void *next; /* must be NULL */
    /* NULL, or 1 channel: pixels that neither blur nor bleed where it is 1, 0 leaves them alone, between is a mixture of both
     * (an antialiased mask); limited to 0..1, not a number counts as 0. Overlaps no output. Lives as long as the call */
    const ddof_image *holdout;
    /* NULL, or more images of the same depth or CoC, `more_count` of them, up to 255: the layers of a renderer's file. Each becomes
     * what it would by a call of its own, bit by bit, and its own pixels alone decide where it has holes; what follows from
     * the CoC is computed once for several of them. An output may be its own color's planes, else it overlaps no color and no
     * other output; planes count as overlapping when the memory from their first to their last value does. With layers the CoC
     * alone says what lies where. Each image is one of light by itself: highlights are those of each one. Lives as long
     * as the call. By ddof_render() only */
    const ddof_pair *more;
    int more_count;
    int reserved_int; /* must be 0 */
    uint64_t reserved[5];
} ddof_frame;

/* ------------------------------------------------------------------------- context */

/* Holds threads, scratch memory (kept between frames, so that the second frame of a size allocates
 * nothing) and the last error. Thread-safety: one call at a time per context; a second one gets
 * DDOF_ERROR_BUSY. Any number of contexts may work at once. */
typedef struct ddof_context ddof_context;

typedef enum ddof_log_level { DDOF_LOG_ERROR = 0, DDOF_LOG_WARNING = 1, DDOF_LOG_INFO = 2 } ddof_log_level;

typedef enum ddof_backend {
    DDOF_BACKEND_AUTO = 0,     /* the best engine that needs no device of its own: the CPU engine */
    DDOF_BACKEND_CPU = 1,      /* the fused streaming engine, all threads, best instruction set */
    DDOF_BACKEND_REFERENCE = 2, /* float64 Thomas solver, one thread: slow, what every other path is checked against */
    DDOF_BACKEND_GL = 3,       /* pixel shaders on OpenGL ES 3.0, by EGL, without a window. UNSUPPORTED where the library was
                                  built without it, or this machine has no such GL */
    DDOF_BACKEND_VULKAN = 4    /* compute shaders on a Vulkan device, see ddof_config.device. UNSUPPORTED likewise */
} ddof_backend;

/* Instruction sets, for ddof_config.cpu_mask and ddof_cpu_available(). */
enum {
    DDOF_CPU_BASELINE = 1, /* always there: SSE2 on x86-64, plain vector code elsewhere */
    DDOF_CPU_AVX2 = 2,     /* with FMA and F16C */
    DDOF_CPU_AVX512 = 4,   /* F, BW, DQ, VL */
    DDOF_CPU_NEON = 8      /* arm64 */
};

/* One job of a parallel loop. `worker` tells calls that run at the same time apart: 0 <= worker < threads. */
typedef void (*ddof_task)(void *task_data, int index, int worker);

/* Callbacks get their own `user` pointer, which must live until ddof_destroy(). They return normally (no exception, no
 * longjmp) and do not call the context they belong to. The config is copied. Pool threads block all signals. A context does
 * not survive fork(): make one in the child. */
typedef struct ddof_config {
    ddof_backend backend; /* default DDOF_BACKEND_AUTO */
    int threads;          /* 1 to 256; 0: as many as the process may use. Results do not depend on it */
    unsigned cpu_mask;    /* DDOF_CPU_* allowed; 0: all. BASELINE is always allowed */

    /* Memory. Both or neither; default malloc/free. `allocate` returns memory aligned to 64 bytes
     * or NULL. Called from the thread that calls the library. */
    void *(*allocate)(void *user, size_t bytes);
    void (*release)(void *user, void *memory);
    void *memory_user;

    /* One line of text, without newline. Called from the thread that calls the library. */
    void (*log)(void *user, ddof_log_level level, const char *text);
    void *log_user;

    /* Called now and then with 0 <= done <= 1, which never falls within one call of ddof_render(); return nonzero to
     * stop it with DDOF_ERROR_CANCELLED. One call at a time, but from any of the worker threads. */
    int (*progress)(void *user, double done);
    void *progress_user;

    /* Runs task(task_data, i, worker) once for every 0 <= i < count, in any order, on any threads (one alone is allowed), and
     * returns 0 when all have returned; nonzero, if it could start none. `threads` must then be given and bounds
     * `worker`. Tasks wait briefly for tasks already started, never for others: once started, one keeps its thread.
     * Default: the context's own pthread pool. */
    int (*parallel_for)(void *user, int count, ddof_task task, void *task_data);
    void *parallel_user;
    int device;       /* DDOF_BACKEND_VULKAN: index in the list of ddof_devices(); default 0, the best. Else 0 */
    int reserved_int; /* must be 0 */
    uint64_t reserved[7];
} ddof_config;

/* Makes a context. config may be NULL for defaults. On failure *context is NULL.
 * Errors: INVALID (context is NULL, bad config), MEMORY, UNSUPPORTED. Thread-safety: any thread. */
DDOF_API ddof_status ddof_create(ddof_context **context, const ddof_config *config);

/* Frees everything and sets *context to NULL; NULL and pointers to NULL are allowed. Not while a call is in flight. */
DDOF_API void ddof_destroy(ddof_context **context);

/* What was wrong with the last call on this context that failed: one line, no newline, "" after a call that went well.
 * The text is the context's and lives until its next call; BUSY leaves it alone. ddof_error(NULL) is "": a ddof_create()
 * that fails gives its sentence to config->log. Thread-safety: as a call on the context. */
DDOF_API const char *ddof_error(const ddof_context *context);

/* Frees scratch memory kept between frames. Errors: BUSY. */
DDOF_API ddof_status ddof_trim(ddof_context *context);

/* The instruction sets of this machine that this build can use, as DDOF_CPU_* bits. Thread-safety: any thread. */
DDOF_API unsigned ddof_cpu_available(void);

/* A device of the GPU backends. */
typedef struct ddof_device {
    char name[256], driver[256]; /* "" where it cannot be told */
    char refused[256];           /* why ddof cannot use it; "": it can */
    int is_software;             /* a driver that computes on the CPU */
    int subgroup_least, subgroup_most; /* sizes of its subgroups; 0: unknown, or not used */
    int max_side;                /* of a picture, pixels */
    int max_workgroup;           /* threads; 0: no compute */
    int shared_bytes;            /* shared memory of a workgroup */
    uint64_t memory_bytes;       /* its own, or what it shares with the CPU; 0: unknown */
    uint64_t reserved[8];        /* written as 0 */
} ddof_device;

/* Lists the devices of DDOF_BACKEND_GL (at most one) or VULKAN, the best first: those ddof can use before others, discrete
 * before integrated, virtual and software ones. Writes up to `capacity` of them and returns how many there are; 0 also
 * where the backend was not built in, or has no driver here. Slow (drivers are loaded). Thread-safety: any thread. */
DDOF_API int ddof_devices(ddof_backend backend, ddof_device *devices, int capacity);

/* ------------------------------------------------------------------------- work */

typedef struct ddof_stats {
    int64_t nonfinite_pixels; /* pixels whose colour, depth or CoC was not finite (infinite depth is allowed); with frame.more of the
                                 image that has most of them */
    double focus_distance;    /* the distance focused on, scene units, may be INFINITY; 0 when a CoC image was given */
    size_t scratch_bytes;     /* memory the context holds for its work, beyond the caller's images */
    int threads;              /* workers used */
    size_t surface_bytes;     /* of the GPU's surfaces it holds, beyond the picture, depth and result; 0: no GPU */
    const char *device;       /* what did the work, e.g. "avx512"; lives until ddof_destroy() */
    int64_t sprites;          /* drawn; with layers in all of them, with frame.more in all images, as the next two */
    int64_t sprites_dropped;  /* highlights that sprites.max_sprites or max_area left to diffusion */
    int64_t sprites_large;    /* highlights whose CoC is beyond sprites.limit: left to diffusion, too */
    uint64_t reserved[4];     /* written as 0 */
} ddof_stats;

/* Blurs frame->color into frame->output as the lens would have.
 * Guarantees (tested), for premultiplied colour without holes and DDOF_FLOAT output: a constant picture stays constant to
 * 1e-6; the sum over all pixels is kept to 1e-5; output lies within the input's range, per channel, to 1e-6 of it; the
 * error against a float64 solve is at most 1e-5 of the range (measured: 6e-6 for |CoC| up to 1e4 at 2500 x 1900). Where
 * the blur reaches farther than 400 pixels it may grow, by at most 2.5e-8 for each pixel of reach, sqrt(beta), and
 * substep; so may that of the sum. The bits do not depend on threads,
 * parallel_for, strides, alignment, in place or not, or earlier calls; they may differ between instruction sets with and
 * without fused multiply-add.
 * With DDOF_KERNEL_DISC the result may leave the range: by 2.5 % of the disc's brightness around a light, 1 % of the step at
 * an edge, by up to 1.2 times the range where the CoC is noise; the error against float64 is at most 2e-5 of the range. With layers or a holdout the sum is not kept.
 * With DDOF_BOKEH_HIGHLIGHTS the sum is kept as without, but for light that falls on something nearer: to 1 % of the highlights' light with a
 * cat's eye, to 2 % of it where they are cut off by the border. A channel that is constant stays so only where nothing is a highlight.
 * Non-finite values: a pixel with a non-finite colour channel, a NaN depth or a non-finite CoC is a hole. Its colour is
 * not used: along its row the neighbours fill it by the same diffusion, however sharp they are (along its column where the
 * whole row is holes). With layers or a holdout they fill it from all sides. A hole without a CoC blurs as its neighbours do. Holes are counted in stats; a picture of holes gives
 * zeros. To keep colour where only depth is unknown, replace the NaN depth before the call.
 * Cancelled or failed: `output` holds no picture; in place, the input is lost too when it was cancelled under way.
 * stats may be NULL and is zeroed when the call fails. Errors: INVALID, MEMORY, CANCELLED, UNSUPPORTED, BUSY. */
DDOF_API ddof_status ddof_render(ddof_context *context, const ddof_frame *frame, const ddof_settings *settings,
                                 ddof_stats *stats);

/* Writes the signed CoC that ddof_render() would use into frame->output (1 channel, the size of depth or coc); frame->color
 * is not used. Handed back as frame.coc (DDOF_FLOAT) it renders the same bits, by a GPU backend the same to 1e-5. NaN where
 * a pixel is a hole for want of depth. Errors as ddof_render(). */
DDOF_API ddof_status ddof_coc(ddof_context *context, const ddof_frame *frame, const ddof_settings *settings,
                              ddof_stats *stats);

/* The scratch memory ddof_render() would hold for such a frame (only sizes, types and strides are looked at; data
 * pointers are compared but not read). Errors: INVALID, BUSY. */
DDOF_API ddof_status ddof_scratch_bytes(ddof_context *context, const ddof_frame *frame, const ddof_settings *settings,
                                        size_t *bytes);

#ifdef __cplusplus
}
#endif

#endif
