/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "scratch.h"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <time.h>
#include <unistd.h>
#if defined(__linux__)
#include <sys/vfs.h>
#endif

#include "message.h"

enum {
    LARGE = 1 << 20,      /* bytes: what is smaller is plain memory */
    PERIOD = 1000 * 1000, /* nanoseconds between two looks at the memory in use */
    ALIGNMENT = 64
};

typedef struct block {
    struct block *next;
    void *at;
    size_t bytes;
    bool file;
} block;

static struct {
    uint64_t limit; /* 0: none was given */
    uint64_t base;
    int frames;
    char *folder;
    int statm; /* /proc/self/statm, open while there is a limit; else -1 */
    atomic_bool streams, stop;
    pthread_t watcher;
    pthread_mutex_t start; /* of `streams` becoming true */
    pthread_mutex_t mutex; /* of the list */
    block *first;
} scratch = {.statm = -1, .start = PTHREAD_MUTEX_INITIALIZER, .mutex = PTHREAD_MUTEX_INITIALIZER};

static _Thread_local char last_error[512];

/* ------------------------------------------------------------------------- how much the process holds */

static uint64_t page_size(void) {
    return (uint64_t)sysconf(_SC_PAGESIZE);
}

static uint64_t resident_bytes(void) {
    char text[128];
    const ssize_t size = pread(scratch.statm, text, sizeof text - 1, 0);
    unsigned long long total, resident = 0;
    if (size <= 0) return 0;
    text[size] = 0;
    return sscanf(text, "%llu %llu", &total, &resident) == 2 ? resident * page_size() : 0;
}

uint64_t scratch_base(void) {
    return scratch.base;
}

int scratch_frames(void) {
    return scratch.frames;
}

uint64_t scratch_limit(void) {
    const long pages = sysconf(_SC_PHYS_PAGES);
    const uint64_t most = pages > 0 ? (uint64_t)pages / 4 * 3 * page_size() : UINT64_MAX;
    return scratch.limit < most ? scratch.limit : most;
}

uint64_t scratch_threshold(uint64_t limit) {
    return limit / 8 * 5;
}

/* Shared pages lose nothing: what was written to them is the file's. */
static void give_back(void) {
#if defined(__linux__)
    pthread_mutex_lock(&scratch.mutex);
    for (const block *b = scratch.first; b; b = b->next)
        if (b->file) madvise(b->at, b->bytes, MADV_DONTNEED);
    pthread_mutex_unlock(&scratch.mutex);
#endif
}

void scratch_pace(void) {
    if (scratch.streams && resident_bytes() > scratch_threshold(scratch_limit())) give_back();
}

static void *watch(void *unused) {
    const struct timespec period = {.tv_nsec = PERIOD};
    (void)unused;
    while (!atomic_load(&scratch.stop)) {
        scratch_pace();
        nanosleep(&period, NULL);
    }
    return NULL;
}

/* ------------------------------------------------------------------------- files */

static void say(const char *format, ...) __attribute__((format(printf, 1, 2)));
static void say(const char *format, ...) {
    va_list list;
    va_start(list, format);
    vsnprintf(last_error, sizeof last_error, format, list);
    va_end(list);
}

static void say_full(uint64_t bytes) {
    struct statvfs info;
    const uint64_t left = statvfs(scratch.folder, &info) == 0 ? (uint64_t)info.f_bavail * info.f_frsize : 0;
    say("--scratch: '%s': the disk is full: %llu MiB are needed, %llu are free; free space or give --scratch a folder on "
        "another disk",
        scratch.folder, (unsigned long long)(bytes >> 20), (unsigned long long)(left >> 20));
}

static void say_failed(int code, uint64_t bytes) {
    if (code == ENOSPC || code == EDQUOT)
        say_full(bytes);
    else if (code == EFBIG)
        say("--scratch: '%s': a file of %llu MiB is larger than files may be here; give --scratch another folder, or more "
            "memory",
            scratch.folder, (unsigned long long)(bytes >> 20));
    else
        say("--scratch: '%s': no file can be made there: %s; give --scratch a folder that can be written to", scratch.folder,
            strerror(code));
}

/* A file that is gone when the process is, however it ends. */
static int open_nameless(void) {
    int file = -1;
#if defined(O_TMPFILE)
    file = open(scratch.folder, O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
    if (file >= 0 || (errno != EOPNOTSUPP && errno != EISDIR && errno != EINVAL)) return file;
#endif
    /* this file system cannot: it has a name for a moment, in which no signal of ours ends the process */
    char path[4096];
    sigset_t all, before;
    const int length = snprintf(path, sizeof path, "%s/.ddof-scratch-XXXXXX", scratch.folder);
    errno = ENAMETOOLONG;
    if (length >= (int)sizeof path) return -1;
    sigfillset(&all);
    pthread_sigmask(SIG_BLOCK, &all, &before);
    file = mkstemp(path);
    if (file >= 0) {
        unlink(path);
        fcntl(file, F_SETFD, FD_CLOEXEC);
    }
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    return file;
}

/* All of the file is reserved: a full disk is known here, and not when a row is written to memory and there is no error to
 * return. */
static void *map_file(size_t bytes) {
    const int file = open_nameless();
    int code = file < 0 ? errno : posix_fallocate(file, 0, (off_t)bytes);
    void *at = MAP_FAILED;
    if (code == 0 && (at = mmap(NULL, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0)) == MAP_FAILED) code = errno;
    if (file >= 0) close(file); /* the mapping keeps it */
    if (at != MAP_FAILED) return at;
    say_failed(code, bytes);
    return NULL;
}

static void *map_memory(size_t bytes) {
    void *at = mmap(NULL, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (at == MAP_FAILED) {
        say("out of memory: %zu bytes were refused; close other programs or give --max-memory less", bytes);
        return NULL;
    }
#if defined(MADV_HUGEPAGE)
    madvise(at, bytes, MADV_HUGEPAGE);
#endif
    return at;
}

/* ------------------------------------------------------------------------- blocks */

static void *allocate_small(size_t bytes) {
    void *at = aligned_alloc(ALIGNMENT, (bytes + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT);
    if (at) return memset(at, 0, bytes);
    say("out of memory: %zu bytes were refused; close other programs", bytes);
    return NULL;
}

void *scratch_allocate(size_t bytes) {
    if (bytes < LARGE) return allocate_small(bytes);
    block *b = allocate_small(sizeof *b);
    if (!b) return NULL;
    *b = (block){.bytes = bytes, .file = scratch.streams};
    b->at = b->file ? map_file(bytes) : map_memory(bytes);
    void *at = b->at;
    if (!at) {
        free(b);
        return NULL;
    }
    pthread_mutex_lock(&scratch.mutex);
    b->next = scratch.first;
    scratch.first = b;
    pthread_mutex_unlock(&scratch.mutex);
    return at;
}

void scratch_release(void *at) {
    if (!at) return;
    pthread_mutex_lock(&scratch.mutex);
    block **link = &scratch.first;
    while (*link && (*link)->at != at)
        link = &(*link)->next;
    block *found = *link;
    if (found) *link = found->next;
    pthread_mutex_unlock(&scratch.mutex);
    if (!found) {
        free(at);
        return;
    }
    munmap(found->at, found->bytes);
    free(found);
}

const char *scratch_error(void) {
    return last_error;
}

static void *allocate_for_io(void *user, size_t bytes, io_error *error) {
    (void)user;
    void *at = scratch_allocate(bytes);
    if (!at && error) snprintf(error->text, sizeof error->text, "%s", last_error);
    return at;
}

static void release_for_io(void *user, void *at) {
    (void)user;
    scratch_release(at);
}

const io_memory *scratch_memory(void) {
    static const io_memory memory = {allocate_for_io, release_for_io, NULL};
    return scratch.limit ? &memory : NULL;
}

/* ------------------------------------------------------------------------- life */

/* The output's folder, on which there must be room anyway: /tmp may be memory. Into devices and pipes: one that is a disk by
 * convention. */
static char *folder_of_output(const char *path) {
    struct stat info;
    if (stat(path, &info) == 0 && !S_ISREG(info.st_mode)) return strdup("/var/tmp");
    const char *slash = strrchr(path, '/');
    return slash ? strndup(path, (size_t)(slash - path) + (slash == path)) : strdup(".");
}

static int check_folder(const char *folder) {
    struct stat info;
    if (stat(folder, &info) != 0)
        return fail("--scratch: '%s': %s; give it a folder that can be written to", folder, strerror(errno));
    if (!S_ISDIR(info.st_mode)) return fail("--scratch: '%s': is no folder; give it one that can be written to", folder);
    if (access(folder, W_OK | X_OK) != 0)
        return fail("--scratch: '%s': %s; give it a folder that can be written to", folder, strerror(errno));
    return 0;
}

int scratch_open(const options *o, int frames) {
    const char *folder = option_text(o, OPT_SCRATCH);
    if (!option_given(o, OPT_MAX_MEMORY))
        return folder ? fail_usage("--scratch: needs --max-memory too; larger pictures are then worked on from there") : 0;
#if !defined(__linux__)
    return fail_usage("--max-memory: only on Linux; leave it out");
#endif
    scratch.statm = open("/proc/self/statm", O_RDONLY | O_CLOEXEC);
    scratch.base = scratch.statm >= 0 ? resident_bytes() : 0;
    scratch.frames = frames;
    scratch.folder = folder ? strdup(folder) : folder_of_output(option_text(o, OPT_OUTPUT));
    if (!scratch.folder) return fail("--scratch: out of memory");
    int status = folder ? check_folder(folder) : 0;
    if (status == 0 && !scratch.base)
        status = fail("--max-memory: /proc/self/statm cannot be read, so the memory in use is not known; mount /proc");
    if (status == 0) scratch.limit = (uint64_t)option_number(o, OPT_MAX_MEMORY, 0);
    if (status) scratch_close();
    return status;
}

/* Where a disk fails, or someone takes the room we reserved, access to a page has no other way to fail. */
static void on_bus_error(int number) {
    static const char line[] = "ddof: --scratch: the disk failed; check it, or give --scratch another folder\n";
    (void)number;
    if (write(STDERR_FILENO, line, sizeof line - 1) < 0) _exit(EXIT_WORK);
    _exit(EXIT_WORK);
}

static void note_memory_folder(void) {
#if defined(__linux__)
    enum { TMPFS = 0x01021994, RAMFS = (int)0x858458f6u };
    struct statfs info;
    if (statfs(scratch.folder, &info) == 0 && ((int)info.f_type == TMPFS || (int)info.f_type == RAMFS))
        note("note: --scratch: '%s' is itself in memory; give it a folder on a disk", scratch.folder);
#endif
}

static bool start_watching(void) {
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before); /* signals go to the main thread */
    const bool started = pthread_create(&scratch.watcher, NULL, watch, NULL) == 0;
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    return started;
}

static int start_streaming(uint64_t bytes) {
    struct statvfs info;
    if (statvfs(scratch.folder, &info) == 0 && (uint64_t)info.f_bavail * info.f_frsize < bytes) {
        say_full(bytes);
        return fail("%s", last_error);
    }
    note_memory_folder();
    struct sigaction action = {.sa_handler = on_bus_error};
    sigemptyset(&action.sa_mask);
    sigaction(SIGBUS, &action, NULL);
    if (!start_watching()) return fail("--max-memory: no thread can be started to watch over it; close other programs");
    scratch.streams = true;
    return 0;
}

int scratch_stream(uint64_t bytes) {
    pthread_mutex_lock(&scratch.start);
    const int status = scratch.streams ? 0 : start_streaming(bytes);
    pthread_mutex_unlock(&scratch.start);
    return status;
}

bool scratch_streams(void) {
    return scratch.streams;
}

void scratch_close(void) {
    if (scratch.streams) {
        scratch.stop = true;
        pthread_join(scratch.watcher, NULL);
    }
    if (scratch.statm >= 0) close(scratch.statm);
    free(scratch.folder);
    scratch.folder = NULL;
    scratch.statm = -1;
    scratch.limit = 0;
    scratch.streams = scratch.stop = false;
}
