/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "damage.h"

uint32_t next_random(uint32_t *state) {
    *state = *state * 1664525u + 1013904223u;
    return *state >> 8;
}

bool reads(const char *path, io_error *error) {
    io_picture *picture = NULL;
    const io_options options = {.max_pixels = 1 << 22};
    error->text[0] = '\0';
    bool good = io_open(&picture, path, IO_COLOR, &options, error) == 0;
    if (!good) assert_null(picture);
    good = good && io_read(picture, error) == 0;
    io_close(&picture);
    if (!good) assert_one_line(error, path);
    return good;
}

void assert_refused(const char *path, const char *words) {
    io_error error;
    if (reads(path, &error)) fail_msg("it is read, not refused with \"%s\"", words);
    if (!strstr(error.text, words)) fail_msg("\"%s\" does not say \"%s\"", error.text, words);
}

/* ------------------------------------------------------------------------- silence */

bool library_prints;
static int saved[2], sink;

static void begin_silence(void) {
    const char *path = in_folder("printed");
    fflush(stdout);
    fflush(stderr);
    sink = open(path, O_RDWR | O_CREAT | O_TRUNC, 0600);
    assert_true(sink >= 0);
    unlink(path);
    for (int i = 0; i < 2; i++) {
        saved[i] = dup(1 + i);
        dup2(sink, 1 + i);
    }
}

static void end_silence(void) {
    struct stat status = {0};
    fflush(stdout);
    fflush(stderr);
    for (int i = 0; i < 2; i++) {
        dup2(saved[i], 1 + i);
        close(saved[i]);
    }
    assert_int_equal(fstat(sink, &status), 0);
    close(sink);
    if (!library_prints) assert_int_equal(status.st_size, 0);
}

/* ------------------------------------------------------------------------- damage */

void check_truncation(const char *path, size_t spare) {
    size_t size, accepted = 0;
    io_error error;
    unsigned char *bytes = read_file(path, &size);
    begin_silence();
    for (size_t n = 0; n + spare < size; n++) {
        write_file(path, bytes, n);
        accepted += reads(path, &error);
    }
    end_silence();
    write_file(path, bytes, size);
    if (!reads(path, &error)) fail_msg("%s", error.text);
    free(bytes);
    assert_int_equal(accepted, 0);
}

/* What could be read can be written, or is refused in one line: some properties are possible in files but not for
 * writers. */
static void try_writing(const char *input, const char *output) {
    io_error error = {""};
    const io_options options = {.max_pixels = 1 << 22};
    io_picture *picture = NULL;
    assert_int_equal(io_open(&picture, input, IO_COLOR, &options, &error), 0);
    assert_int_equal(io_read(picture, &error), 0);
    for (int c = 0; c < picture->part[0].channel_count; c++)
        io_channel_modified(&picture->part[0].channel[c]);
    if (io_write(picture, output, NULL, NULL, &error) != 0) assert_one_line(&error, output);
    io_close(&picture);
}

void check_mutations(const char *path, int rounds, uint32_t seed) {
    size_t size;
    io_error error;
    unsigned char *bytes = read_file(path, &size), *changed = malloc(size);
    assert_non_null(changed);
    char output[600];
    snprintf(output, sizeof output, "%s", in_folder("mutated"));
    strcat(output, strrchr(path, '.'));
    begin_silence();
    for (int i = 0; i < rounds; i++) {
        memcpy(changed, bytes, size);
        for (uint32_t k = 1 + next_random(&seed) % 4; k > 0; k--) {
            unsigned char *at = changed + next_random(&seed) % size;
            *at = (unsigned char)(next_random(&seed) % 3 == 0 ? *at ^ (1u << next_random(&seed) % 8)
                                                              : next_random(&seed));
        }
        write_file(path, changed, size);
        if (reads(path, &error) && i % 8 == 0) try_writing(path, output);
    }
    end_silence();
    write_file(path, bytes, size);
    unlink(output);
    free(bytes);
    free(changed);
}

void check_full_disk(const char *input, const char *output, size_t limit) {
    static const char old[] = "the old file";
    io_error error = {""};
    struct rlimit before, small;
    size_t size;
    io_picture *picture = read_picture(input);
    for (int c = 0; c < picture->part[0].channel_count; c++)
        io_channel_modified(&picture->part[0].channel[c]);
    write_file(output, old, sizeof old);
    const int files = count_files();
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    small = before;
    small.rlim_cur = limit;
    void (*handler)(int) = signal(SIGXFSZ, SIG_IGN);
    begin_silence();
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
    const int status = io_write(picture, output, NULL, NULL, &error);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
    end_silence();
    signal(SIGXFSZ, handler);
    io_close(&picture);
    assert_int_equal(status, -1);
    assert_one_line(&error, output);
    if (!strstr(error.text, strerror(EFBIG))) fail_msg("\"%s\" does not say why", error.text);
    assert_int_equal(count_files(), files);
    unsigned char *bytes = read_file(output, &size);
    assert_int_equal(size, sizeof old);
    assert_memory_equal(bytes, old, sizeof old);
    free(bytes);
}

/* ------------------------------------------------------------------------- no damage */

const char *rewrite(const char *input, const char *output, io_meaning meaning) {
    static io_error note;
    io_error error = {""};
    io_picture *picture = NULL;
    note.text[0] = '\0';
    if (io_open(&picture, input, meaning, NULL, &error) != 0 || io_read(picture, &error) != 0)
        fail_msg("%s", error.text);
    for (int c = 0; c < picture->part[0].channel_count; c++)
        io_channel_modified(&picture->part[0].channel[c]);
    if (io_write(picture, output, NULL, &note, &error) != 0) fail_msg("%s", error.text);
    io_close(&picture);
    if (note.text[0]) assert_one_line(&note, output);
    return note.text;
}

const float *values_of(io_picture *picture, const char *name) {
    const io_channel *channel = channel_of(picture, 0, name);
    assert_int_equal(channel->type, IO_FLOAT);
    assert_non_null(channel->data);
    return channel->data;
}
