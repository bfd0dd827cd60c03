/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The table of formats and what all of them share: memory of pictures, types of channels. Output: output.c. */
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

#include "coding.h"

static const io_handler *const handlers[] = {&io_exr, &io_png, &io_tiff, &io_pfm, &io_heif, &io_jxl};
enum { HANDLERS = sizeof handlers / sizeof handlers[0], HEAD = 32, LONGEST_SIDE = 1 << 20 };

const io_handler *io_handler_of(io_format format) {
    for (int i = 0; i < HANDLERS; i++)
        if (handlers[i]->format == format) return handlers[i];
    return NULL;
}

const char *io_format_name(io_format format) {
    static const char *const names[] = {[IO_EXR] = "EXR", [IO_PNG] = "PNG", [IO_TIFF] = "TIFF", [IO_PFM] = "PFM", [IO_HEIF] = "HEIF", [IO_JXL] = "JPEG XL"};
    return names[format];
}

bool io_format_of_name(const char *path, io_format *format) {
    static const struct {
        const char *ending;
        io_format format;
    } endings[] = {{".exr", IO_EXR},   {".png", IO_PNG},   {".tif", IO_TIFF}, {".tiff", IO_TIFF}, {".pfm", IO_PFM},
                   {".heic", IO_HEIF}, {".heif", IO_HEIF}, {".hif", IO_HEIF}, {".avif", IO_HEIF}, {".jxl", IO_JXL}};
    const char *dot = strrchr(path, '.');
    for (size_t i = 0; dot && i < sizeof endings / sizeof endings[0]; i++)
        if (strcasecmp(dot, endings[i].ending) == 0) {
            *format = endings[i].format;
            return true;
        }
    return false;
}

bool io_format_writes(io_format format) {
    return io_handler_of(format)->write != NULL;
}

int io_fail(io_error *error, const char *format, ...) {
    if (!error) return -1;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(error->text, sizeof error->text, format, arguments);
    va_end(arguments);
    for (char *c = error->text; *c; c++)
        if ((unsigned char)*c < ' ' || *c == 127) *c = '?';
    return -1;
}

/* ------------------------------------------------------------------------- memory */

size_t io_type_size(io_type type) {
    return type == IO_HALF ? 2 : 4;
}

uint64_t io_channel_bytes(const io_channel *channel) {
    return (uint64_t)channel->width * (uint64_t)channel->height * io_type_size(channel->type);
}

static bool grow(void **array, int count, size_t size) {
    /* Powers of two: room is there unless count is one. */
    if (count & (count - 1)) return true;
    void *larger = realloc(*array, (size_t)(count ? 2 * count : 1) * size);
    if (!larger) return false;
    *array = larger;
    return true;
}

io_part *io_add_part(io_picture *picture, const char *name, const char *view, io_box data, io_box display) {
    if (!grow((void **)&picture->part, picture->part_count, sizeof(io_part))) return NULL;
    io_part *part = &picture->part[picture->part_count];
    *part = (io_part){.name = strdup(name ? name : ""),
                      .view = strdup(view ? view : ""),
                      .data = data,
                      .display = display,
                      .pixel_aspect = 1,
                      .compression = "none",
                      .storage = "scanline"};
    picture->part_count++;
    return part->name && part->view ? part : NULL;
}

/* Samples of a subsampled channel lie at the coordinates that are multiples of the sampling. */
static int samples(int origin, int size, int sampling) {
    int64_t last = (int64_t)origin + size - 1, before = (int64_t)origin - 1;
    int64_t below_last = last >= 0 ? last / sampling : -((-last + sampling - 1) / sampling);
    int64_t below = before >= 0 ? before / sampling : -((-before + sampling - 1) / sampling);
    return (int)(below_last - below);
}

io_channel *io_add_channel(io_part *part, const char *name, io_type type, int x_sampling, int y_sampling) {
    if (!grow((void **)&part->channel, part->channel_count, sizeof(io_channel))) return NULL;
    io_channel *channel = &part->channel[part->channel_count];
    *channel = (io_channel){.name = strdup(name),
                            .type = type,
                            .x_sampling = x_sampling,
                            .y_sampling = y_sampling,
                            .width = samples(part->data.x, part->data.width, x_sampling),
                            .height = samples(part->data.y, part->data.height, y_sampling)};
    if (!channel->name) return NULL;
    part->channel_count++;
    return channel;
}

/* Lies right before a channel's data. */
typedef struct data_origin {
    void *block;
    const io_memory *memory; /* NULL: calloc */
} data_origin;

static data_origin origin_of(const io_channel *channel) {
    data_origin origin;
    memcpy(&origin, (const unsigned char *)channel->data - sizeof origin, sizeof origin);
    return origin;
}

int io_channel_allocate(io_channel *channel, const io_memory *memory, io_error *error, const char *path) {
    enum { ALIGNMENT = 64 };
    size_t bytes = (size_t)io_channel_bytes(channel);
    /* calloc, and not aligned_alloc and memset: large blocks come from the system as zeroes, at no cost until used. */
    unsigned char *block = memory ? memory->allocate(memory->user, bytes + 2 * ALIGNMENT, error)
                                  : calloc(1, bytes + 2 * ALIGNMENT);
    if (!block && memory) return -1;
    if (!block)
        return io_fail(error, "%s: not enough memory for channel '%s' (%zu MiB); close other programs or use a proxy",
                       path, channel->name, bytes >> 20);
    const data_origin origin = {block, memory};
    unsigned char *data = block + ALIGNMENT;
    data += (ALIGNMENT - (uintptr_t)data % ALIGNMENT) % ALIGNMENT;
    memcpy(data - sizeof origin, &origin, sizeof origin);
    io_channel_release(channel);
    channel->data = data;
    return 0;
}

void io_channel_release(io_channel *channel) {
    if (!channel->data) return;
    const data_origin origin = origin_of(channel);
    if (origin.memory)
        origin.memory->release(origin.memory->user, origin.block);
    else
        free(origin.block);
    channel->data = NULL;
}

void *io_block_allocate(const io_options *options, size_t bytes, io_error *error, const char *path) {
    const io_memory *memory = options ? options->memory : NULL;
    void *block = memory ? memory->allocate(memory->user, bytes, error) : calloc(1, bytes);
    if (!block && !memory) io_fail(error, "%s: not enough memory (%zu MiB)", path, bytes >> 20);
    return block;
}

void io_block_release(const io_options *options, void *block) {
    const io_memory *memory = options ? options->memory : NULL;
    if (memory && block)
        memory->release(memory->user, block);
    else
        free(block);
}

int io_check_size(const char *path, int64_t width, int64_t height, const io_options *options, io_error *error) {
    uint64_t limit = options && options->max_pixels ? options->max_pixels : UINT64_C(1) << 31;
    if (width < 1 || height < 1)
        return io_fail(error, "%s: declares a size of %lld x %lld; the header is damaged", path, (long long)width,
                       (long long)height);
    if (width > LONGEST_SIDE || height > LONGEST_SIDE)
        return io_fail(error, "%s: %lld x %lld is too large, the longest side possible is %d", path, (long long)width,
                       (long long)height, LONGEST_SIDE);
    if ((uint64_t)width * (uint64_t)height > limit)
        return io_fail(error, "%s: %lld x %lld is more than the limit of %llu pixels", path, (long long)width,
                       (long long)height, (unsigned long long)limit);
    return 0;
}

int io_check_memory(const char *path, uint64_t bytes, io_error *error) {
    long pages = sysconf(_SC_PHYS_PAGES), page = sysconf(_SC_PAGESIZE);
    if (pages <= 0 || page <= 0 || bytes / (uint64_t)page < (uint64_t)pages) return 0;
    return io_fail(error, "%s: needs %llu MiB of memory, this machine has %llu; use a smaller picture", path,
                   (unsigned long long)(bytes >> 20), (unsigned long long)pages * (unsigned long long)page >> 20);
}

bool io_attribute_number(const io_picture *picture, int part, const char *name, double *number) {
    const io_handler *handler = io_handler_of(picture->format);
    return part >= 0 && part < picture->part_count && handler->number && handler->number(picture, part, name, number);
}

const char *io_attribute_name(const io_picture *picture, int part, int index) {
    const io_handler *handler = io_handler_of(picture->format);
    if (part < 0 || part >= picture->part_count || index < 0 || !handler->attribute) return NULL;
    return handler->attribute(picture, part, index);
}

void io_close(io_picture **picture) {
    if (!picture || !*picture) return;
    io_picture *p = *picture;
    const io_handler *handler = io_handler_of(p->format);
    if (handler && p->source) handler->close(p);
    if (p->file >= 0) close(p->file);
    for (int i = 0; i < p->part_count; i++) {
        io_part *part = &p->part[i];
        for (int c = 0; c < part->channel_count; c++) {
            io_channel_release(&part->channel[c]);
            free(part->channel[c].name);
        }
        free(part->channel);
        free(part->name);
        free(part->view);
        for (int v = 0; v < part->view_count; v++) free(part->views[v]);
        free(part->views);
    }
    free(p->part);
    free(p->path);
    free(p);
    *picture = NULL;
}

static io_picture *new_picture(const char *path, io_format format, io_error *error) {
    io_picture *picture = calloc(1, sizeof *picture);
    if (picture && (picture->path = strdup(path))) {
        picture->format = format;
        picture->file = -1;
        return picture;
    }
    free(picture);
    io_fail(error, "%s: not enough memory", path);
    return NULL;
}

/* ------------------------------------------------------------------------- the file */

int io_reopen(const io_picture *picture, io_error *error) {
    int file = fcntl(picture->file, F_DUPFD_CLOEXEC, 0);
    if (file >= 0 && lseek(file, 0, SEEK_SET) == 0) return file;
    io_fail(error, "%s: cannot be opened: %s", picture->path, strerror(errno));
    if (file >= 0) close(file);
    return -1;
}

FILE *io_reopen_stream(const io_picture *picture, io_error *error) {
    int file = io_reopen(picture, error);
    FILE *stream = file >= 0 ? fdopen(file, "rb") : NULL;
    if (file >= 0 && !stream) {
        io_fail(error, "%s: cannot be opened: %s", picture->path, strerror(errno));
        close(file);
    }
    return stream;
}

int io_read_whole(const io_picture *picture, unsigned char **bytes, size_t *size, io_error *error) {
    *bytes = NULL;
    *size = (size_t)picture->stamp.size;
    if (io_check_memory(picture->path, (uint64_t)picture->stamp.size, error) != 0) return -1;
    FILE *file = io_reopen_stream(picture, error);
    if (!file) return -1;
    unsigned char *read = malloc(*size ? *size : 1);
    int result = 0;
    if (!read)
        result = io_fail(error, "%s: not enough memory to read it", picture->path);
    else if (fread(read, 1, *size, file) != *size)
        result = io_fail(error, "%s: cannot be read: %s", picture->path, ferror(file) ? strerror(errno) : "it ends early");
    fclose(file);
    if (result == 0)
        *bytes = read;
    else
        free(read);
    return result;
}

static bool take_stamp(int file, io_stamp *stamp) {
    struct stat status;
    if (fstat(file, &status) != 0) return false;
    *stamp = (io_stamp){status.st_size, status.st_mtim.tv_sec, status.st_mtim.tv_nsec};
    return true;
}

int io_check_unchanged(const io_picture *picture, int result, io_error *error) {
    io_stamp now;
    if (picture->file < 0) return result;
    if (!take_stamp(picture->file, &now))
        return io_fail(error, "%s: cannot be read: %s", picture->path, strerror(errno));
    const io_stamp *then = &picture->stamp;
    if (now.size == then->size && now.seconds == then->seconds && now.nanoseconds == then->nanoseconds) return result;
    return io_fail(error, "%s: changed while it was read; render it again", picture->path);
}

/* ------------------------------------------------------------------------- reading */

/* Asked before it is opened: to open a pipe is to wait for someone at its other end. And after that, since the name may
 * mean something else by then. */
static int open_regular(const char *path, io_error *error) {
    struct stat status;
    if (stat(path, &status) == 0) {
        int file = S_ISREG(status.st_mode) ? open(path, O_RDONLY | O_NONBLOCK | O_CLOEXEC) : -2;
        if (file >= 0 && fstat(file, &status) == 0 && S_ISREG(status.st_mode)) return file;
        if (file >= 0) close(file);
        if (file != -1)
            return io_fail(error, "%s: is %s; give a picture file", path,
                           S_ISDIR(status.st_mode) ? "a folder" : "no regular file (pictures are not read from pipes)");
    }
    return io_fail(error, "%s: cannot be opened: %s", path, strerror(errno));
}

static const io_handler *recognise(int file, const char *path, io_error *error) {
    unsigned char head[HEAD];
    ssize_t size = pread(file, head, sizeof head, 0);
    if (size < 0) {
        io_fail(error, "%s: cannot be read: %s", path, strerror(errno));
        return NULL;
    }
    for (int i = 0; i < HANDLERS; i++)
        if (handlers[i]->matches(head, (size_t)size)) return handlers[i];
    io_fail(error,
            size ? "%s: is no EXR, PNG, TIFF, PFM, HEIC, AVIF or JPEG XL picture; convert it to one of these"
                 : "%s: is empty; write or copy it again",
            path);
    return NULL;
}

int io_open(io_picture **picture, const char *path, io_meaning meaning, const io_options *options, io_error *error) {
    static const io_options defaults;
    *picture = NULL;
    int file = open_regular(path, error);
    if (file < 0) return -1;
    const io_handler *handler = recognise(file, path, error);
    io_picture *opened = handler ? new_picture(path, handler->format, error) : NULL;
    if (!opened) {
        close(file);
        return -1;
    }
    if (options) opened->memory = options->memory;
    opened->file = file; /* io_close's from here on */
    int result = take_stamp(file, &opened->stamp) ? handler->open(opened, meaning, options ? options : &defaults, error)
                                                  : io_fail(error, "%s: cannot be read: %s", path, strerror(errno));
    if (io_check_unchanged(opened, result, error) != 0) {
        io_close(&opened);
        return -1;
    }
    *picture = opened;
    return 0;
}

/* A small file may declare a large picture and be right: compressed white is short. */
static int check_wanted(const io_picture *picture, const io_part *part, const char *const *names, int name_count,
                        io_error *error) {
    uint64_t bytes = 0;
    for (int i = 0; !picture->memory && i < part->channel_count; i++) {
        const io_channel *channel = &part->channel[i];
        if (!channel->data && io_name_wanted(channel->name, names, name_count))
            bytes += io_channel_bytes(channel);
    }
    return io_check_memory(picture->path, bytes, error);
}

int io_read_channels(io_picture *picture, int part, const char *const *names, int name_count, io_error *error) {
    if (check_wanted(picture, &picture->part[part], names, name_count, error) != 0) return -1;
    int result = io_handler_of(picture->format)->read(picture, part, names, name_count, error);
    return io_check_unchanged(picture, result, error);
}

int io_read_rows(io_picture *picture, int part, const char *const *names, int name_count, int row, int rows, io_error *error) {
    picture->row = row;
    picture->rows = rows;
    const int result = io_read_channels(picture, part, names, name_count, error);
    picture->row = picture->rows = 0;
    return result;
}

int io_read(io_picture *picture, io_error *error) {
    for (int i = 0; i < picture->part_count; i++)
        if (!picture->part[i].deep && io_read_channels(picture, i, NULL, 0, error) != 0) return -1;
    return 0;
}

/* ------------------------------------------------------------------------- making */

int io_create(io_picture **picture, io_format format, int width, int height, const char *const *names, int name_count,
              io_type type, int bits, io_meaning meaning, io_error *error) {
    return io_create_in(picture, format, width, height, names, name_count, type, bits, meaning, NULL, error);
}

int io_create_in(io_picture **picture, io_format format, int width, int height, const char *const *names,
                 int name_count, io_type type, int bits, io_meaning meaning, const io_memory *memory, io_error *error) {
    *picture = NULL;
    io_picture *made = new_picture("new picture", format, error);
    if (!made) return -1;
    if (!io_format_writes(format)) {
        io_fail(error, "%s: %s is read, but not written; choose EXR, PNG, TIFF or PFM", made->path, io_format_name(format));
        goto failed;
    }
    io_box box = {0, 0, width, height};
    io_part *part = NULL;
    if (io_check_size(made->path, width, height, NULL, error) != 0) goto failed;
    part = io_add_part(made, "", "", box, box);
    for (int i = 0; part && i < name_count; i++) {
        io_channel *channel = io_add_channel(part, names[i], type, 1, 1);
        if (!channel) {
            part = NULL;
        } else {
            channel->modified = true;
            if (io_channel_allocate(channel, memory, error, made->path) != 0) goto failed;
        }
    }
    if (!part) {
        io_fail(error, "%s: not enough memory", made->path);
        goto failed;
    }
    part->bits = bits;
    if (io_handler_of(format)->create(made, meaning, error) != 0) goto failed;
    *picture = made;
    return 0;
failed:
    io_close(&made);
    return -1;
}

/* ------------------------------------------------------------------------- values */

void io_channel_modified(io_channel *channel) {
    channel->modified = true;
}

int io_channel_retype(io_channel *channel, io_type type, io_error *error) {
    io_type old = channel->type;
    channel->type = type;
    const io_memory *memory = channel->data ? origin_of(channel).memory : NULL;
    if (io_channel_allocate(channel, memory, error, channel->name) != 0) {
        channel->type = old;
        return -1;
    }
    channel->modified = true;
    return 0;
}

void io_channel_to_float(const io_channel *channel, float *out, size_t pixel_floats, size_t row_floats) {
    size_t width = (size_t)channel->width;
    for (size_t y = 0; y < (size_t)channel->height; y++) {
        float *row = out + y * row_floats;
        if (channel->type == IO_HALF) {
            io_half_to_float((const uint16_t *)channel->data + y * width, row, width, pixel_floats);
        } else if (channel->type == IO_FLOAT) {
            const float *in = (const float *)channel->data + y * width;
            for (size_t x = 0; x < width; x++)
                row[x * pixel_floats] = in[x];
        } else {
            const uint32_t *in = (const uint32_t *)channel->data + y * width;
            for (size_t x = 0; x < width; x++)
                row[x * pixel_floats] = (float)in[x];
        }
    }
}

static uint32_t to_uint(float value) {
    if (!(value > 0)) /* NaN too */
        return 0;
    return value >= 0x1p32f ? UINT32_MAX : (uint32_t)rint((double)value);
}

void io_channel_from_float(io_channel *channel, const float *in, size_t pixel_floats, size_t row_floats) {
    size_t width = (size_t)channel->width;
    for (size_t y = 0; y < (size_t)channel->height; y++) {
        const float *row = in + y * row_floats;
        if (channel->type == IO_HALF) {
            io_float_to_half(row, (uint16_t *)channel->data + y * width, width, pixel_floats);
        } else if (channel->type == IO_FLOAT) {
            float *out = (float *)channel->data + y * width;
            for (size_t x = 0; x < width; x++)
                out[x] = row[x * pixel_floats];
        } else {
            uint32_t *out = (uint32_t *)channel->data + y * width;
            for (size_t x = 0; x < width; x++)
                out[x] = to_uint(row[x * pixel_floats]);
        }
    }
    channel->modified = true;
}
