/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* A call of the library: sizes, strides, types, settings are made of the bytes. Whatever it is, it is refused with a
 * sentence, or gives finite numbers inside of the output alone, the same ones with one thread and with two. */
#include <ddof/ddof.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fuzz.h"

enum { LARGEST_SIDE = 40, ARENA = 1 << 18, GUARD = 0xa5, IMAGES = 5, IRIS_SIDE = 6 };

typedef struct call {
    fuzz_bytes in;
    ddof_frame frame;
    ddof_image holdout;
    ddof_settings settings;
    unsigned char *arena[IMAGES]; /* of color, depth, coc, output, holdout */
    float iris[IRIS_SIDE * IRIS_SIDE];
    bool tame;    /* colour is finite, of a modest range */
    bool outside; /* some stride leads out of its arena: only asked about, never rendered */
    bool in_place;
} call;

/* ------------------------------------------------------------------------- numbers */

/* Zero, which means the default, most often; what is never allowed now and then. */
static double number(fuzz_bytes *in, double usual) {
    static const double wild[] = {-1, NAN, INFINITY, -INFINITY, 1e300, -1e300, 1e-300, 1e-30, 1e6, 1e20};
    const unsigned byte = fuzz_byte(in);
    if (byte < 64) return 0;
    if (byte < 64 + sizeof wild / sizeof *wild) return wild[byte - 64];
    if (byte < 128) return usual;
    return usual * (double)(byte - 127) / 32;
}

/* One of 0..last, seldom outside. */
static int choice(fuzz_bytes *in, int last) {
    const unsigned byte = fuzz_byte(in);
    if (byte >= 250) return byte == 255 ? -1 : last + (int)(byte - 249);
    return (int)byte % (last + 1);
}

static uint32_t hash(uint32_t a) {
    a = (a ^ a >> 16) * 0x7feb352du;
    a = (a ^ a >> 15) * 0x846ca68bu;
    return a ^ a >> 16;
}

static float value_of(uint32_t noise, unsigned kind, float scale) {
    static const float wild[] = {NAN, INFINITY, -INFINITY, 3e38f, -3e38f, 1e-42f, 0, 65504};
    if (kind & 1 && noise % 23 == 0) return wild[noise / 23 % 8];
    if (kind & 2) return noise % 5 ? 0 : scale;
    return scale * ((float)(noise >> 8) * 0x1p-24f - (kind & 4 ? 0.5f : 0));
}

/* Rounded towards zero: which half it becomes does not matter here. */
static uint16_t half_of(float value) {
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    const uint32_t sign = bits >> 16 & 0x8000, exponent = bits >> 23 & 255, fraction = bits >> 13 & 0x3ff;
    if (exponent == 255) return (uint16_t)(sign | 0x7c00 | (bits & 0x7fffff ? 0x200 : 0));
    if (exponent < 113) return (uint16_t)sign;
    return (uint16_t)(exponent > 142 ? sign | 0x7bff : sign | (exponent - 112) << 10 | fraction);
}

static float float_of(uint16_t half) {
    const int exponent = half >> 10 & 31, fraction = half & 0x3ff;
    if (exponent == 31) return fraction ? NAN : INFINITY;
    return exponent ? ldexpf((float)(1024 + fraction), exponent - 25) : ldexpf((float)fraction, -24);
}

/* ------------------------------------------------------------------------- pictures */

static ptrdiff_t size_of(ddof_type type) {
    return type == DDOF_HALF ? 2 : 4;
}

static ptrdiff_t pixel_stride_of(const ddof_plane *p) {
    return p->pixel_stride ? p->pixel_stride : size_of(p->type);
}

static ptrdiff_t row_stride_of(const ddof_plane *p, int width) {
    return p->row_stride ? p->row_stride : width * llabs(pixel_stride_of(p));
}

/* Whether all pixels of the plane lie in its arena. */
static bool is_inside(const ddof_image *image, const ddof_plane *p, const unsigned char *arena) {
    const ptrdiff_t x = pixel_stride_of(p) * (image->width - 1), y = row_stride_of(p, image->width) * (image->height - 1);
    const ptrdiff_t first = (unsigned char *)p->data - arena, low = first + (x < 0 ? x : 0) + (y < 0 ? y : 0),
                    high = first + (x > 0 ? x : 0) + (y > 0 ? y : 0) + 4;
    return low >= 0 && high <= ARENA;
}

static void tight_strides(ddof_image *image, int arrangement, int c, ptrdiff_t *at) {
    ddof_plane *p = &image->plane[c];
    const ptrdiff_t size = size_of(p->type), width = image->width, height = image->height;
    switch (arrangement) {
    case 0: /* interleaved, all of the size of a float */
        p->pixel_stride = 4 * image->channels;
        *at = 4 * c;
        break;
    case 1: /* planar, strides left out */
        break;
    case 2: /* planar, rows apart */
        p->row_stride = width * size + 16 * size;
        break;
    case 3: /* upside down */
        p->row_stride = -(width * size);
        *at += (height - 1) * width * size;
        break;
    default: /* from right to left */
        p->pixel_stride = -size;
        *at += (width - 1) * size;
        break;
    }
}

static void describe(call *c, ddof_image *image, int index, int width, int height, int channels) {
    fuzz_bytes *in = &c->in;
    *image = (ddof_image){.width = width, .height = height, .channels = channels, .alpha = (ddof_alpha)choice(in, 1)};
    const int arrangement = fuzz_range(in, 0, 4);
    const unsigned types = fuzz_byte(in), wild = fuzz_byte(in);
    for (int i = 0; i < channels && i < 4; i++) {
        ddof_plane *p = &image->plane[i];
        ptrdiff_t at = 0;
        p->type = types >> i & 1 ? DDOF_HALF : DDOF_FLOAT;
        tight_strides(image, arrangement, i, &at);
        if (arrangement != 0) at += i * (ARENA / 4);
        p->data = c->arena[index] + at;
        if (wild < 250) continue;
        if (wild & 1) p->pixel_stride = fuzz_range(in, -40, 40);
        if (wild & 2) p->row_stride = fuzz_range(in, -4000, 4000);
        if (wild & 4) p->data = c->arena[index] + fuzz_range(in, 0, 4000);
        if (wild == 255) p->row_stride = fuzz_byte(in) & 1 ? PTRDIFF_MAX - 3 : PTRDIFF_MIN;
        if (wild == 253) p->data = NULL;
        c->outside |= wild == 255 || !is_inside(image, p, c->arena[index]);
    }
}

static void put(const ddof_image *image, int channel, int x, int y, float value) {
    const ddof_plane *p = &image->plane[channel];
    unsigned char *to = (unsigned char *)p->data + x * pixel_stride_of(p) + y * row_stride_of(p, image->width);
    const uint16_t half = half_of(value);
    memcpy(to, p->type == DDOF_HALF ? (const void *)&half : &value, (size_t)size_of(p->type));
}

static float get(const ddof_image *image, int channel, int x, int y) {
    const ddof_plane *p = &image->plane[channel];
    const unsigned char *from = (unsigned char *)p->data + x * pixel_stride_of(p) + y * row_stride_of(p, image->width);
    float value;
    uint16_t half;
    memcpy(&value, from, p->type == DDOF_HALF ? 0 : sizeof value);
    memcpy(&half, from, sizeof half);
    return p->type == DDOF_HALF ? float_of(half) : value;
}

static void fill(const ddof_image *image, uint32_t seed, unsigned kind, float scale) {
    for (int i = 0; i < image->channels && i < 4 && image->plane[i].data; i++)
        for (int y = 0; y < image->height; y++)
            for (int x = 0; x < image->width; x++)
                put(image, i, x, y, value_of(hash(seed + (uint32_t)(i * 1000003 + y * 1009 + x)), kind, scale));
}

/* ------------------------------------------------------------------------- settings */

static void make_lens(fuzz_bytes *in, ddof_lens *lens, ddof_depth *depth) {
    lens->kind = (ddof_lens_kind)choice(in, 1);
    lens->focus = (ddof_focus_kind)choice(in, 1);
    lens->focal_length = number(in, 85);
    lens->f_number = number(in, 2);
    lens->sensor_width = number(in, 36);
    lens->unit = number(in, 1000);
    lens->focus_distance = number(in, 4);
    lens->focus_x = fuzz_range(in, -1, LARGEST_SIDE);
    lens->focus_y = fuzz_range(in, -1, LARGEST_SIDE);
    lens->in_focus_range = number(in, 1);
    lens->max_coc_near = number(in, 0.2);
    lens->max_coc_far = number(in, 0.2);
    lens->limit_near = number(in, 0.3);
    lens->limit_far = number(in, 0.3);
    depth->kind = (ddof_depth_kind)choice(in, 4);
    depth->z_at_0 = number(in, 1);
    depth->z_at_1 = number(in, 20);
}

static void make_bokeh(call *c) {
    fuzz_bytes *in = &c->in;
    ddof_sprites *sprites = &c->settings.sprites;
    ddof_iris *iris = &c->settings.iris;
    c->settings.bokeh = (ddof_bokeh)choice(in, 2);
    sprites->threshold = number(in, 0.5);
    sprites->limit = number(in, 0.5);
    sprites->max_sprites = fuzz_range(in, -1, 200);
    sprites->max_area = fuzz_range(in, -1, 30);
    sprites->resolution = (ddof_resolution)choice(in, 2);
    iris->shape = (ddof_iris_shape)choice(in, 2);
    iris->blades = iris->shape == DDOF_IRIS_POLYGON ? fuzz_range(in, 2, 65) : 0;
    iris->rotation = number(in, 90);
    iris->curvature = iris->shape == DDOF_IRIS_POLYGON ? number(in, 0.5) : 0;
    iris->edge = number(in, 0.5);
    iris->cats_eye = number(in, 0.5);
    iris->squeeze = number(in, 2);
    iris->fringe = number(in, 0.2);
    if (iris->shape != DDOF_IRIS_IMAGE) return;
    const int width = fuzz_range(in, 1, IRIS_SIDE), height = fuzz_range(in, 1, IRIS_SIDE);
    iris->image = ddof_image_interleaved(c->iris, width, height, 1, DDOF_FLOAT, 0);
    fill(&iris->image, fuzz_byte(in), fuzz_byte(in), 1);
}

static void make_method(call *c) {
    fuzz_bytes *in = &c->in;
    ddof_settings *s = &c->settings;
    s->conductance = (ddof_conductance)choice(in, 1);
    s->substeps = fuzz_range(in, -1, 8);
    s->kernel = (ddof_kernel)choice(in, 1);
    s->quality = (ddof_quality)choice(in, 3);
    s->layers = (ddof_layers)choice(in, 1);
    s->method = (ddof_method)choice(in, 3);
}

/* ------------------------------------------------------------------------- the call */

static void make_frame(call *c) {
    fuzz_bytes *in = &c->in;
    const int width = fuzz_range(in, 1, LARGEST_SIDE), height = fuzz_range(in, 1, LARGEST_SIDE), channels = choice(in, 3) + 1;
    const unsigned what = fuzz_byte(in), kind = fuzz_byte(in) & 7, scale = fuzz_byte(in);
    static const float scales[] = {1, 0.01f, 5, 100, 3000};
    describe(c, &c->frame.color, 0, width, height, channels);
    if (what & 1) describe(c, &c->frame.depth, 1, width, height, 1);
    if (!(what & 1) || (what & 14) == 14) describe(c, &c->frame.coc, 2, width, height, 1);
    if (what & 16) describe(c, &c->holdout, 4, width, height - (what == 0xff), 1);
    c->in_place = what & 32;
    if (c->in_place)
        c->frame.output = c->frame.color;
    else
        describe(c, &c->frame.output, 3, width, height, channels);
    if (what & 16) c->frame.holdout = &c->holdout;
    if (what & 64) {
        /* Sprites grow with it, up to minutes of work: 300 pixels have a CoC of several levels. */
        c->frame.picture_width = fuzz_range(in, -1, 300);
        c->frame.picture_height = fuzz_range(in, -1, 300);
        c->frame.offset_x = fuzz_range(in, -3000, 3000);
        c->frame.offset_y = fuzz_range(in, -3000, 3000);
    }
    c->frame.pixel_aspect = what & 128 ? number(in, 1) : 0;
    c->tame = !(kind & 1);
    if (c->outside) return;
    fill(&c->frame.color, 1, kind, scales[scale % 5]);
    fill(&c->frame.depth, 2, fuzz_byte(in), 10);
    fill(&c->frame.coc, 3, fuzz_byte(in), scales[fuzz_byte(in) % 5] * 10);
    fill(&c->holdout, 4, fuzz_byte(in), 1);
}

static void make(call *c, const uint8_t *data, size_t size) {
    memset(c, 0, sizeof *c);
    c->in = (fuzz_bytes){data, size};
    for (int i = 0; i < IMAGES; i++) {
        c->arena[i] = malloc(ARENA);
        fuzz_require(c->arena[i] != NULL, "there is memory for an image", NULL);
        memset(c->arena[i], GUARD, ARENA);
    }
    make_frame(c);
    make_method(c);
    make_bokeh(c);
    make_lens(&c->in, &c->settings.lens, &c->settings.depth);
}

static void drop(call *c) {
    for (int i = 0; i < IMAGES; i++)
        free(c->arena[i]);
}

static void require_sentence(const ddof_context *context, ddof_status status) {
    const char *text = ddof_error(context);
    fuzz_require((status == DDOF_OK) == (text[0] == '\0'), "an error has a sentence, a success has none", text);
    fuzz_require(strchr(text, '\n') == NULL, "a sentence is one line", text);
}

static ddof_status render(call *c, int threads) {
    static ddof_context *contexts[3]; /* kept: what earlier calls left behind must not matter */
    ddof_context **context = &contexts[threads];
    const ddof_config config = {.backend = DDOF_BACKEND_CPU, .threads = threads};
    if (!*context) fuzz_require(ddof_create(context, &config) == DDOF_OK, "a context can be made", NULL);
    size_t bytes;
    const ddof_status asked = ddof_scratch_bytes(*context, &c->frame, &c->settings, &bytes);
    require_sentence(*context, asked);
    if (c->outside) return DDOF_ERROR_INVALID;
    ddof_stats stats;
    const ddof_status status = ddof_render(*context, &c->frame, &c->settings, &stats);
    require_sentence(*context, status);
    fuzz_require(status == DDOF_OK || status == DDOF_ERROR_INVALID || status == DDOF_ERROR_UNSUPPORTED,
                 "only arguments can be wrong", ddof_error(*context));
    fuzz_require(status != DDOF_OK || asked == DDOF_OK, "what can be rendered can be asked about", NULL);
    return status;
}

/* Whatever is not a pixel of the output still has its first value. Leaves GUARD in the pixels. */
static void require_guards(const call *c) {
    const ddof_image *image = &c->frame.output;
    if (c->in_place) return; /* the input's padding: ASan's business */
    float guard;
    memset(&guard, GUARD, sizeof guard);
    for (int i = 0; i < image->channels && i < 4; i++)
        for (int y = 0; y < image->height; y++)
            for (int x = 0; x < image->width; x++) {
                const ddof_plane *p = &image->plane[i];
                memset((unsigned char *)p->data + x * pixel_stride_of(p) + y * row_stride_of(p, image->width), GUARD,
                       (size_t)size_of(p->type));
            }
    for (int i = 0; i < ARENA; i++)
        fuzz_require(c->arena[3][i] == GUARD, "nothing is written outside of the picture", NULL);
}

static void require_finite(const call *c) {
    const ddof_image *image = &c->frame.output;
    for (int i = 0; c->tame && i < image->channels; i++)
        for (int y = 0; y < image->height; y++)
            for (int x = 0; x < image->width; x++)
                fuzz_require(isfinite(get(image, i, x, y)), "finite colour gives finite colour", NULL);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    if (size > 512) return 0;
    static call one, two;
    make(&one, data, size);
    make(&two, data, size);
    const ddof_status status = render(&one, 1);
    fuzz_require(render(&two, 2) == status, "threads do not change what is refused", NULL);
    if (status == DDOF_OK) {
        require_finite(&one);
        const int output = one.in_place ? 0 : 3;
        fuzz_require(memcmp(one.arena[output], two.arena[output], ARENA) == 0, "threads do not change bits", NULL);
        require_guards(&one);
    }
    drop(&one);
    drop(&two);
    return 0;
}
