/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Pictures in files, one table for all formats: EXR, PNG, TIFF, PFM, HEIF, JPEG XL. A picture is opened (header only),
 * its pixels are read, channels are replaced, and it is written whole under a temporary name, then renamed.
 *
 * No other part of the project knows a file format; the library (src/) knows no files at all.
 * Errors: functions return 0 on success, -1 on failure with one line in `error` (may be NULL) that names the file, what
 * is wrong and what to do. Nothing prints. Thread-safety: one picture, one thread; pictures are independent. */
#ifndef IO_PICTURE_H
#define IO_PICTURE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { IO_ERROR_SIZE = 1024 };
typedef struct io_error {
    char text[IO_ERROR_SIZE];
} io_error; /* "" when nothing is wrong */

/* Value types in memory. Integer files (PNG, integer TIFF) become IO_FLOAT; see io_open. */
typedef enum io_type { IO_HALF, IO_FLOAT, IO_UINT } io_type;
size_t io_type_size(io_type type);

typedef enum io_format { IO_EXR, IO_PNG, IO_TIFF, IO_PFM, IO_HEIF /* HEIC, AVIF */, IO_JXL } io_format;
const char *io_format_name(io_format format); /* "EXR", ... */
/* By the name's ending (.exr .png .tif .tiff .pfm .heic .heif .hif .avif .jxl, any case); false when it is none. */
bool io_format_of_name(const char *path, io_format *format);
/* HEIF and JPEG XL are read only. */
bool io_format_writes(io_format format);

typedef struct io_box {
    int x, y, width, height;
} io_box; /* top-left inclusive */

/* What the values of a depth channel mean, as far as its file says. */
typedef enum io_depth_kind {
    IO_DEPTH_UNSAID,
    IO_DEPTH_LINEAR,   /* the distance is linear in the value */
    IO_DEPTH_DISPARITY /* 1 / distance is linear in the value */
} io_depth_kind;

typedef struct io_depth {
    io_depth_kind kind;
    double at_0, at_1; /* the distances meant by 0 and 1: > 0 and different, one may be infinite with IO_DEPTH_DISPARITY;
                          0 both when the file does not say */
} io_depth;

typedef struct io_channel {
    char *name; /* "R", "diffuse.R", "left.Z": as in the file. PNG/TIFF/PFM: R G B A or Y (A); HEIF, JPEG XL: also depth */
    io_type type;
    bool integer;   /* the file holds integers v, this v / maximum: 0 to 1 */
    io_depth depth;
    int x_sampling, y_sampling; /* 1 but for subsampled EXR chroma */
    int width, height;          /* of the data */
    void *data;                 /* NULL until io_read; planar, tightly packed, row 0 on top, 64-byte aligned;
                                   owned by the picture; may be written to: call io_channel_modified() then */
    bool modified;              /* io_write encodes it anew; parts without such a channel are copied as they are */
} io_channel;

/* Of its data, which need not be there. */
uint64_t io_channel_bytes(const io_channel *channel);

typedef struct io_part {
    char *name, *view;    /* "" when the file gives none; of several views in one part (multiView) the one whose
                             channels have no prefix */
    int view_count;
    char **views;         /* of several in one part (multiView): all of them, that one first */
    io_box data, display; /* windows */
    double pixel_aspect;
    const char *compression; /* "ZIP", "DWAA", "deflate", "none", ... static text */
    const char *storage;     /* "scanline", "tiled", "deep scanline", "deep tiled", "mipmap tiled", ... */
    int bits;                /* of the largest sample in the file: 8, 16, 32 */
    bool deep, multi_level;
    uint64_t chunk_bytes; /* of a row, chunk, tile or compressed strip: what one thread works on at a time */
    int channel_count;
    io_channel *channel; /* in the order of the file */
} io_part;

/* What tells that a file was written to: its size, and when that was last done. */
typedef struct io_stamp {
    int64_t size, seconds, nanoseconds;
} io_stamp;

/* Where what grows with the picture comes from: the data of channels, and blocks of a whole picture on its way from or
 * into a file. All of it is gone through in the order of rows, or backwards. `allocate` returns zeroed memory aligned to
 * 64 bytes, or NULL with the line to show in `error`. Any thread may call. Outlives the pictures. */
typedef struct io_memory {
    void *(*allocate)(void *user, size_t bytes, io_error *error);
    void (*release)(void *user, void *block);
    void *user;
} io_memory;

typedef struct io_picture {
    char *path;
    io_format format;
    int file;       /* what it was opened from, held open; -1: made by io_create */
    io_stamp stamp; /* of that file, when it was opened */
    int part_count;
    io_part *part;
    const io_memory *memory;  /* of the options it was opened with */
    io_error note;            /* one line of what is not as the file says, profiles of colour for one; "" for nothing */
    struct io_source *source; /* what the format keeps: header attributes, text chunks, raw tags */
    int row, rows;            /* of the data that are being read, see io_read_rows(); rows 0: all */
} io_picture;

typedef enum io_meaning {
    IO_COLOR, /* integer files hold sRGB-encoded colour: decoded to scene-linear on reading, encoded on writing */
    IO_DATA   /* depth, CoC, masks: integer values v become v / maximum (0..1), no transfer curve */
} io_meaning;

typedef struct io_options {
    int threads;         /* for codecs; 0: as many as the process may use */
    uint64_t max_pixels; /* refuse larger declared sizes before allocating anything; 0: 2^31 pixels a channel */
    const io_memory *memory; /* NULL: the process's own, and what the machine does not have is refused */
} io_options;

/* What `threads` of io_options means: itself, or for 0 the processors this process may use. 1 to 256. */
int io_thread_count(int threads);

/* Opens a file and reads its header: parts, channels, windows. The format is known by the file's first bytes, not its
 * name. A declared size that the file's length cannot hold is refused here. On failure *picture is NULL. */
int io_open(io_picture **picture, const char *path, io_meaning meaning, const io_options *options, io_error *error);

/* Reads the pixels of all parts (those that are not deep; of those with levels, the largest). Truncated or damaged
 * pixels are an error that says which rows. So is a file that was written to since io_open, here and in io_write. One
 * that was replaced under its name is no such file: what was opened is read to its end. */
int io_read(io_picture *picture, io_error *error);

/* Reads only the named channels of one part (names NULL: all channels of that part). Channels read before are left
 * alone. */
int io_read_channels(io_picture *picture, int part, const char *const *names, int name_count, io_error *error);

/* The same, but all that is needed are `rows` rows from `row` on, counted from the first of the data. Of EXR, chunks that have
 * none of them are left out, and their pixels are 0. */
int io_read_rows(io_picture *picture, int part, const char *const *names, int name_count, int row, int rows, io_error *error);

void io_close(io_picture **picture);

/* Says that the caller wrote into channel->data. io_channel_from_float and io_channel_retype do it themselves. */
void io_channel_modified(io_channel *channel);

/* Same size, a new type (e.g. half -> float): data is reallocated, zeroed. */
int io_channel_retype(io_channel *channel, io_type type, io_error *error);

/* Channels -> contiguous float rows, whatever the type: out[y * row_floats + x * pixel_floats]. And back, rounding to
 * nearest for half and clamping uint. */
void io_channel_to_float(const io_channel *channel, float *out, size_t pixel_floats, size_t row_floats);
void io_channel_from_float(io_channel *channel, const float *in, size_t pixel_floats, size_t row_floats);

/* A new picture in memory, to be written: one part, `names` channels of one type, zeroed data, data window = display
 * window = width x height; for EXR part->data.x, .y, ->display and ->pixel_aspect may be set before it is written. The
 * channels are in the order of `names`, those of an EXR read again in the order of the alphabet. bits: 8 or 16 for PNG,
 * 8/16/32 for TIFF, 32 for PFM, 16 (half) or 32 for EXR follow from type. */
int io_create(io_picture **picture, io_format format, int width, int height, const char *const *names, int name_count,
              io_type type, int bits, io_meaning meaning, io_error *error);

/* The same with memory from elsewhere; NULL: the process's own. */
int io_create_in(io_picture **picture, io_format format, int width, int height, const char *const *names,
                 int name_count, io_type type, int bits, io_meaning meaning, const io_memory *memory, io_error *error);

/* Writes the whole picture to `path`: all parts, all channels (also those never read), all metadata, windows, pixel
 * types and compression of the file it was opened from. EXR parts without a modified channel are copied as they are,
 * deep and lossy ones and those with levels too; in others DWA becomes ZIP and levels but the largest are dropped:
 * *note says so. Written to a file of the same folder that has no name (where there are no such files: ".ddof-<process>-<n>.tmp"),
 * flushed, then given its name: nothing is ever visible under `path` unless it is complete, and a failure leaves nothing behind. An existing
 * file keeps its permissions, one without that to write is refused, a symbolic link stays one and its target is written; `path` may be the file the picture
 * was read from. Into devices and pipes
 * (/dev/stdout) the finished file is poured. The name's ending must fit the picture's format, but for those.
 * note: receives one line of what could not be kept, "" when nothing; may be NULL. */
int io_write(const io_picture *picture, const char *path, const io_options *options, io_error *note, io_error *error);

/* What io_write would say about the name alone, before any work is done: a folder, a file that is write-protected. */
int io_check_output(const char *path, io_error *error);

/* ---- what else a header says */

/* The number that the attribute `name` of a part holds: an EXR float, double, int, rational, or a string that is a number and
 * nothing else; it may be infinite or NaN. false: it has none. Other formats have none. */
bool io_attribute_number(const io_picture *picture, int part, const char *name, double *number);
/* The name of attribute number `index` of a part, whatever it holds; NULL: there are no more. */
const char *io_attribute_name(const io_picture *picture, int part, int index);

/* ---- which channels are what (io/select.c) */

typedef struct io_selection {
    int part;         /* index, -1: none found */
    int count;        /* 1..4 */
    int channel[4];   /* indices in the part: R G B (A), Y (A), or one depth channel */
    bool alpha;       /* the last one is alpha */
    char prefix[256]; /* "" or "layer." or "view.layer." */
} io_selection;

/* Colour: `layer` NULL: the first of "R G B (A)" without prefix (parts named like "beauty", "combined" or "rgba" before
 * others), layers named like those, then the first prefix that has R G B, then Y (A), then red green blue in any case;
 * in the first flat part that has it. `layer` given: exactly that prefix, or "part:prefix", or a part or a view of that
 * name. The error lists what there is. Luminance with chroma (Y RY BY) and subsampled channels are refused. */
int io_select_color(const io_picture *picture, const char *layer, io_selection *selection, io_error *error);

/* The colour of `view` that corresponds to that of another view: the same layer, else what would be taken if the view were alone. */
int io_select_color_of_view(const io_picture *picture, const io_selection *other, const char *view, io_selection *selection,
                            io_error *error);

/* The view a channel belongs to: the word of its name that is one (OpenEXR: the last but one; others: the first), else that of
 * its part; "" where nothing says. */
const char *io_channel_view(const io_part *part, int channel);
/* Its name without that word. */
void io_channel_plain_name(const io_part *part, int channel, char *name, size_t size);
/* The views of the flat parts, in the order of the file; how many there are, of which `most` are written. */
int io_views(const io_picture *picture, const char **views, int most);

/* What there is, for messages, by commas; ends in "..." where it is long. */
void io_list_channels(const io_picture *picture, char *text, size_t size);

/* Depth: `name` NULL: Z, then *.Z (but not of a vector X Y Z), *depth, and what else is named like depth: a part's only
 * channel, or one of depth.Y, depth.R...; of these the one of the same view as `near_color` (may be NULL), then with
 * the same prefixes, then in the same part. Without near_color a picture with one channel (or Y A) is its own depth.
 * `name` given: exactly that channel ("layer.Z", or "part:channel" when parts share names), or a part or layer with
 * that channel only. The error lists the channels there are. */
int io_select_depth(const io_picture *picture, const char *name, const io_selection *near_color,
                    io_selection *selection, io_error *error);

#endif
