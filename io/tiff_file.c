/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* libtiff on a file of our own: its complaints are kept instead of printed, no memory is mapped (a file that shrinks
 * under a mapping ends the process), and every write that fails is remembered. */
#include <errno.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "tiff_source.h"

static void keep(io_error *kept, const char *format, va_list arguments) {
    if (kept->text[0] == '\0') vsnprintf(kept->text, sizeof kept->text, format, arguments);
}

static int on_error(TIFF *tiff, void *data, const char *module, const char *format, va_list arguments) {
    (void)tiff;
    (void)module;
    keep(&((io_tiff_file *)data)->message, format, arguments);
    return 1;
}

/* The JPEG decoder invents pixels for what is missing, and only warns. */
static int on_warning(TIFF *tiff, void *data, const char *module, const char *format, va_list arguments) {
    (void)tiff;
    if (module != NULL && strcmp(module, "JPEGLib") == 0) keep(&((io_tiff_file *)data)->damage, format, arguments);
    return 1;
}

static tmsize_t read_bytes(thandle_t handle, void *out, tmsize_t size) {
    io_tiff_file *file = handle;
    tmsize_t done = 0;
    while (done < size) {
        ssize_t got = read(file->descriptor, (char *)out + done, (size_t)(size - done));
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) break;
        done += got;
    }
    return done;
}

static tmsize_t write_bytes(thandle_t handle, void *bytes, tmsize_t size) {
    io_tiff_file *file = handle;
    tmsize_t done = 0;
    while (done < size) {
        ssize_t put = write(file->descriptor, (const char *)bytes + done, (size_t)(size - done));
        if (put < 0 && errno == EINTR) continue;
        if (put < 0 && file->write_error == 0) file->write_error = errno;
        if (put <= 0) break;
        done += put;
    }
    return done;
}

static toff_t seek(thandle_t handle, toff_t offset, int whence) {
    io_tiff_file *file = handle;
    return (toff_t)lseek(file->descriptor, (off_t)offset, whence);
}

static toff_t length(thandle_t handle) {
    io_tiff_file *file = handle;
    struct stat status;
    return fstat(file->descriptor, &status) == 0 ? (toff_t)status.st_size : 0;
}

static int leave_open(thandle_t handle) {
    (void)handle; /* io_tiff_close_file does it, and looks at the result */
    return 0;
}

static int open_client(io_tiff_file *file, const char *mode, tmsize_t most, const char *path, io_error *error) {
    TIFFOpenOptions *options = TIFFOpenOptionsAlloc();
    if (options == NULL) return io_fail(error, "%s: not enough memory", path);
    TIFFOpenOptionsSetErrorHandlerExtR(options, on_error, file);
    TIFFOpenOptionsSetWarningHandlerExtR(options, on_warning, file);
    TIFFOpenOptionsSetMaxSingleMemAlloc(options, most);
    file->tiff =
        TIFFClientOpenExt("TIFF", mode, file, read_bytes, write_bytes, seek, leave_open, length, NULL, NULL, options);
    TIFFOpenOptionsFree(options);
    return file->tiff != NULL ? 0 : -1;
}

int io_tiff_read_file(io_tiff_file *file, const io_picture *picture, io_error *error) {
    *file = (io_tiff_file){.descriptor = io_reopen(picture, error)};
    if (file->descriptor < 0) return -1;
    /* m: no memory mapping; c: strips as they are in the file, to be written so again. No single block that libtiff
     * allocates for tags or decoding comes near this size in an honest file. */
    const tmsize_t most = (tmsize_t)((1u << 30) + 2 * length(file));
    if (open_client(file, "rmc", most, picture->path, error) == 0) return 0;
    return io_fail(error, "%s: the TIFF header is damaged or cut off (%s); export the picture again", picture->path,
                   file->message.text);
}

int io_tiff_write_file(io_tiff_file *file, const char *temporary, const char *mode, const char *path, io_error *error) {
    *file = (io_tiff_file){.descriptor = io_open_temporary(temporary)};
    if (file->descriptor < 0) return io_fail_write(error, path, errno);
    if (open_client(file, mode, 0, path, error) == 0) return 0;
    return io_fail(error, "%s: cannot be written: %s", path,
                   file->write_error != 0 ? strerror(file->write_error) : file->message.text);
}

int io_tiff_close_file(io_tiff_file *file) {
    if (file->tiff != NULL) TIFFClose(file->tiff);
    file->tiff = NULL;
    if (file->descriptor >= 0 && close(file->descriptor) != 0 && file->write_error == 0) file->write_error = errno;
    file->descriptor = -1;
    if (file->write_error == 0) return 0;
    snprintf(file->message.text, sizeof file->message.text, "%s", strerror(file->write_error));
    return -1;
}
