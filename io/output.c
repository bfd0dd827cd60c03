/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* io_write: nobody ever sees half a picture under the name of the output. It is written under another name in the same
 * folder, flushed to the disk and renamed. */
#if defined(__linux__)
#define _GNU_SOURCE /* O_TMPFILE */
#endif
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
    int file;                 /* the temporary one, open */
    bool nameless;            /* `temporary` is only this process's word for it */
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
    *d = (destination){.shown = path, .file = -1};
    if (strlen(path) >= sizeof d->path) return io_fail_write(error, path, ENAMETOOLONG);
    strcpy(d->path, path);
    if (follow_links(d, error) != 0) return -1;
    d->exists = stat(d->path, &status) == 0;
    d->regular = !d->exists || (S_ISREG(status.st_mode) && !names_open_file(d->path));
    d->mode = d->exists ? status.st_mode & 07777 : 0;
    if (d->exists && S_ISDIR(status.st_mode)) return io_fail(error, "%s: is a folder; give the name of a file", path);
    /* rename() would replace it all the same, and root may write to anything; but someone wants it kept. */
    if (d->exists && d->regular && ((d->mode & 0222) == 0 || access(d->path, W_OK) != 0))
        return io_fail(error, "%s: is write-protected; allow writing to it or give another name", path);
    return 0;
}

int io_check_output(const char *path, io_error *error) {
    destination d;
    return resolve(&d, path, error);
}

/* Another name in the folder each time; false: too long. */
static bool next_name(const destination *d, char name[PATH_MAX]) {
    static atomic_uint serial;
    const int length =
        snprintf(name, PATH_MAX, "%s.ddof-%ld-%u.tmp", d->folder, (long)getpid(), atomic_fetch_add(&serial, 1));
    errno = ENAMETOOLONG;
    return length < PATH_MAX;
}

static mode_t new_mode(const destination *d) {
    return d->regular ? 0666 : 0600;
}

/* A file that has no name until it is complete: a process that is killed leaves nothing behind. Where the file system
 * has no such files, or /proc is not there, -1. */
static int open_nameless(destination *d) {
#if defined(O_TMPFILE)
    const int file = open(d->folder[0] ? d->folder : ".", O_TMPFILE | O_RDWR | O_CLOEXEC, new_mode(d));
    snprintf(d->temporary, sizeof d->temporary, "/proc/self/fd/%d", file);
    if (file < 0 || access(d->temporary, R_OK | W_OK) == 0) return file;
    close(file);
#else
    (void)d;
#endif
    return -1;
}

/* One with a name. Not mkstemp, which gives every file mode 600: the permissions are those any other program's file
 * would have. */
static int open_named(destination *d) {
    for (int attempt = 0; attempt < 100 && next_name(d, d->temporary); attempt++) {
        const int file = open(d->temporary, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, new_mode(d));
        if (file >= 0 || errno != EEXIST) return file;
    }
    return -1;
}

/* A new file in the folder of the output, or in the temporary folder when the output is a device or a pipe. */
static int make_temporary(destination *d, io_error *error) {
    const char *shared = getenv("TMPDIR");
    if (!d->regular) snprintf(d->folder, sizeof d->folder, "%s/", shared && shared[0] ? shared : "/tmp");
    d->file = open_nameless(d);
    d->nameless = d->file >= 0;
    if (!d->nameless) d->file = open_named(d);
    if (d->file < 0) {
        d->temporary[0] = '\0';
        return io_fail_write(error, d->shown, errno);
    }
    /* An existing output keeps its permissions; a file system without them is no reason to fail. */
    if (d->exists && d->regular && fchmod(d->file, d->mode) != 0) errno = 0;
    return 0;
}

static void drop_temporary(destination *d) {
    if (d->temporary[0] && !d->nameless) unlink(d->temporary);
    d->temporary[0] = '\0';
    if (d->file >= 0) close(d->file);
    d->file = -1;
}

int io_open_temporary(const char *name) {
    return open(name, O_RDWR | (names_open_file(name) ? 0 : O_NOFOLLOW) | O_CLOEXEC);
}

FILE *io_open_temporary_stream(const char *name) {
    int file = io_open_temporary(name);
    FILE *stream = file >= 0 ? fdopen(file, "r+b") : NULL;
    if (file >= 0 && !stream) close(file);
    return stream;
}

/* Gives a nameless file the name of the output, or, where there is a file of that name already, one to be renamed. */
static int give_name(destination *d) {
    char name[PATH_MAX];
    if (!d->nameless) return 0;
    if (linkat(AT_FDCWD, d->temporary, AT_FDCWD, d->path, AT_SYMLINK_FOLLOW) == 0) {
        d->temporary[0] = '\0';
        return 0;
    }
    for (int attempt = 0; errno == EEXIST && attempt < 100 && next_name(d, name); attempt++)
        if (linkat(AT_FDCWD, d->temporary, AT_FDCWD, name, AT_SYMLINK_FOLLOW) == 0) {
            strcpy(d->temporary, name);
            d->nameless = false;
            return 0;
        }
    return -1;
}

/* The data reach the disk before the name does: a crash leaves the old file or the new one. */
static int move_into_place(destination *d, io_error *error) {
    /* Some network file systems cannot flush; what was written was checked by close(). */
    if (fsync(d->file) != 0 && errno != EINVAL && errno != ENOTSUP && errno != ENOSYS)
        return io_fail_write(error, d->shown, errno);
    if (give_name(d) != 0) return io_fail_write(error, d->shown, errno);
    if (d->temporary[0] && rename(d->temporary, d->path) != 0) return io_fail_write(error, d->shown, errno);
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
    if (!io_format_writes(picture->format))
        return io_fail(error, "%s: %s is read, but not written; convert the picture", path, io_format_name(picture->format));
    if (make_temporary(&d, error) != 0) return -1;
    int result =
        io_handler_of(picture->format)->write(picture, d.temporary, path, options ? options : &defaults, note, error);
    result = io_check_unchanged(picture, result, error); /* parts are copied from it */
    if (result == 0) result = d.regular ? move_into_place(&d, error) : pour(&d, error);
    drop_temporary(&d);
    return result;
}
