/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* io_write: nobody ever sees half a picture under the name of the output. It is written under another name in the same
 * folder, flushed to the disk and renamed. */
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "format.h"

#ifndef PATH_MAX
#define PATH_MAX 4096
#endif

enum { MOST_LINKS = 40 };

typedef struct destination {
    const char *shown;        /* the name the user gave */
    char path[PATH_MAX];      /* where symbolic links lead */
    char folder[PATH_MAX];    /* of `path`, with its slash; "" is the current one */
    char temporary[PATH_MAX]; /* "" when there is none */
    bool exists, regular;
    mode_t mode;
} destination;

int io_fail_write(io_error *error, const char *path, int code) {
    const char *slash = strrchr(path, '/');
    int length = slash ? (int)(slash - path) + 1 : 1;
    const char *folder = slash ? path : ".";
    switch (code) {
    case ENOSPC:
    case EDQUOT:
        return io_fail(error, "%s: the disk or the quota is full; free space or write elsewhere", path);
    case EFBIG:
        return io_fail(error, "%s: would be larger than files may be here; write elsewhere", path);
    case ENOENT:
    case ENOTDIR:
        return io_fail(error, "%s: the folder '%.*s' does not exist; make it first", path, length, folder);
    case EACCES:
    case EPERM:
    case EROFS:
        return io_fail(error, "%s: the folder '%.*s' cannot be written to (%s); write elsewhere or change that", path,
                       length, folder, strerror(code));
    default:
        return io_fail(error, "%s: cannot be written: %s", path, strerror(code));
    }
}

static void split_folder(destination *d) {
    const char *slash = strrchr(d->path, '/');
    size_t length = slash ? (size_t)(slash - d->path) + 1 : 0;
    memcpy(d->folder, d->path, length);
    d->folder[length] = '\0';
}

/* Links whose targets are no names: an open file of this process, "pipe:[123]". */
static bool names_open_file(const char *path) {
    return strncmp(path, "/proc/", 6) == 0 || strncmp(path, "/dev/fd/", 8) == 0;
}

/* Follows symbolic links by hand: the last one may lead to a file that does not exist yet. */
static int follow_links(destination *d, io_error *error) {
    struct stat status;
    for (int links = 0; !names_open_file(d->path) && lstat(d->path, &status) == 0 && S_ISLNK(status.st_mode); links++) {
        char target[PATH_MAX], joined[2 * PATH_MAX];
        ssize_t length = readlink(d->path, target, sizeof target - 1);
        if (length < 0 || links == MOST_LINKS) return io_fail_write(error, d->shown, length < 0 ? errno : ELOOP);
        target[length] = '\0';
        split_folder(d);
        snprintf(joined, sizeof joined, "%s%s", target[0] == '/' ? "" : d->folder, target);
        if (strlen(joined) >= sizeof d->path) return io_fail_write(error, d->shown, ENAMETOOLONG);
        strcpy(d->path, joined);
    }
    split_folder(d);
    return 0;
}

static int resolve(destination *d, const char *path, io_error *error) {
    struct stat status;
    *d = (destination){.shown = path};
    if (strlen(path) >= sizeof d->path) return io_fail_write(error, path, ENAMETOOLONG);
    strcpy(d->path, path);
    if (follow_links(d, error) != 0) return -1;
    d->exists = stat(d->path, &status) == 0;
    d->regular = !d->exists || (S_ISREG(status.st_mode) && !names_open_file(d->path));
    d->mode = d->exists ? status.st_mode & 07777 : 0;
    if (d->exists && S_ISDIR(status.st_mode)) return io_fail(error, "%s: is a folder; give the name of a file", path);
    return 0;
}

/* A new file next to the output, or in the temporary folder when the output is a device or a pipe. Not mkstemp, which
 * gives every file mode 600: the permissions are those any other program's file would have. */
static int make_temporary(destination *d, io_error *error) {
    static atomic_uint serial;
    const char *shared = getenv("TMPDIR");
    if (!d->regular) snprintf(d->folder, sizeof d->folder, "%s/", shared && shared[0] ? shared : "/tmp");
    for (int attempt = 0; attempt < 100; attempt++) {
        int length = snprintf(d->temporary, sizeof d->temporary, "%s.ddof-%ld-%u.tmp", d->folder, (long)getpid(),
                              atomic_fetch_add(&serial, 1));
        errno = ENAMETOOLONG;
        int file = length < (int)sizeof d->temporary
                       ? open(d->temporary, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, d->regular ? 0666 : 0600)
                       : -1;
        if (file >= 0) {
            /* An existing output keeps its permissions; a file system without them is no reason to fail. */
            if (d->exists && d->regular && fchmod(file, d->mode) != 0) errno = 0;
            close(file);
            return 0;
        }
        if (errno != EEXIST) break;
    }
    d->temporary[0] = '\0';
    return io_fail_write(error, d->shown, errno);
}

int io_open_temporary(const char *name) {
    return open(name, O_RDWR | O_NOFOLLOW | O_CLOEXEC);
}

FILE *io_open_temporary_stream(const char *name) {
    int file = io_open_temporary(name);
    FILE *stream = file >= 0 ? fdopen(file, "r+b") : NULL;
    if (file >= 0 && !stream) close(file);
    return stream;
}

/* The data reach the disk before the name does: a crash leaves the old file or the new one. */
static int move_into_place(destination *d, io_error *error) {
    int file = open(d->temporary, O_RDONLY | O_CLOEXEC);
    if (file < 0 || fsync(file) != 0) {
        int code = errno;
        if (file >= 0) close(file);
        /* Some network file systems cannot flush; what was written was checked by close(). */
        if (file < 0 || (code != EINVAL && code != ENOTSUP && code != ENOSYS))
            return io_fail_write(error, d->shown, code);
    } else {
        close(file);
    }
    if (rename(d->temporary, d->path) != 0) return io_fail_write(error, d->shown, errno);
    d->temporary[0] = '\0';
    int folder = open(d->folder[0] ? d->folder : ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (folder >= 0) {
        (void)!fsync(folder);
        close(folder);
    }
    return 0;
}

/* /dev/stdout, a pipe: formats seek while they write, so the finished file is poured into it. */
static int pour(const destination *d, io_error *error) {
    static const size_t size = 1 << 20;
    char *buffer = malloc(size);
    int in = open(d->temporary, O_RDONLY | O_CLOEXEC), out = open(d->path, O_WRONLY | O_CLOEXEC);
    int code = !buffer ? ENOMEM : in < 0 || out < 0 ? errno : 0;
    while (!code) {
        ssize_t got = read(in, buffer, size), sent = 0;
        if (got < 0) code = errno;
        if (got <= 0) break;
        for (ssize_t done = 0; !code && done < got; done += sent)
            if ((sent = write(out, buffer + done, (size_t)(got - done))) < 0) code = errno;
    }
    if (in >= 0) close(in);
    if (out >= 0 && close(out) != 0 && !code) code = errno;
    free(buffer);
    return code ? io_fail_write(error, d->shown, code) : 0;
}

int io_write(const io_picture *picture, const char *path, const io_options *options, io_error *note, io_error *error) {
    static const io_options defaults;
    destination d;
    io_format format;
    if (note) note->text[0] = '\0';
    if (resolve(&d, path, error) != 0) return -1;
    if (io_format_of_name(path, &format) ? format != picture->format : d.regular)
        return io_fail(error, "%s: the picture is %s; give the output such an ending", path,
                       io_format_name(picture->format));
    if (make_temporary(&d, error) != 0) return -1;
    int result =
        io_handler_of(picture->format)->write(picture, d.temporary, path, options ? options : &defaults, note, error);
    result = io_check_unchanged(picture, result, error); /* parts are copied from it */
    if (result == 0) result = d.regular ? move_into_place(&d, error) : pour(&d, error);
    if (d.temporary[0]) unlink(d.temporary);
    return result;
}
