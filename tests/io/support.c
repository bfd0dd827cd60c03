/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "support.h"

/* ------------------------------------------------------------------------- files */

static char folder[256];

int make_folder(void **state) {
    (void)state;
    const char *base = getenv("TMPDIR");
    snprintf(folder, sizeof folder, "%s/ddof-io-XXXXXX", base ? base : "/tmp");
    return mkdtemp(folder) ? 0 : -1;
}

static void each_file(void (*visit)(const char *path)) {
    DIR *dir = opendir(folder);
    for (struct dirent *entry; dir && (entry = readdir(dir));)
        if (strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0) visit(in_folder(entry->d_name));
    if (dir) closedir(dir);
}

static int counted;
static void count(const char *path) {
    (void)path;
    counted++;
}

static void erase(const char *path) {
    if (unlink(path) != 0) rmdir(path);
}

int count_files(void) {
    counted = 0;
    each_file(count);
    return counted;
}

int remove_folder(void **state) {
    (void)state;
    each_file(erase);
    return rmdir(folder);
}

const char *in_folder(const char *name) {
    static char paths[16][600];
    static int next;
    char *path = paths[next++ % 16];
    snprintf(path, sizeof paths[0], "%s/%s", folder, name);
    return path;
}

const char *data_file(const char *name) {
    static char path[1024];
    const char *data = getenv("DDOF_DATA");
    snprintf(path, sizeof path, "%s/%s", data ? data : DDOF_SOURCE_ROOT "/../shared/data", name);
    return access(path, R_OK) == 0 ? path : NULL;
}

unsigned char *read_file(const char *path, size_t *size) {
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    fseek(file, 0, SEEK_END);
    *size = (size_t)ftell(file);
    rewind(file);
    unsigned char *data = malloc(*size + 1);
    assert_non_null(data);
    assert_int_equal(fread(data, 1, *size, file), *size);
    fclose(file);
    return data;
}

void write_file(const char *path, const void *data, size_t size) {
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(data, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

void assert_same_files(const char *a, const char *b) {
    size_t a_size, b_size;
    unsigned char *a_data = read_file(a, &a_size), *b_data = read_file(b, &b_size);
    assert_int_equal(a_size, b_size);
    assert_memory_equal(a_data, b_data, a_size);
    free(a_data);
    free(b_data);
}

/* ------------------------------------------------------------------------- pictures */

static void assert_done(int result, const io_error *error) {
    if (result != 0) fail_msg("%s", error->text);
}

io_picture *open_picture(const char *path) {
    io_picture *picture = NULL;
    io_error error = {{0}};
    assert_done(io_open(&picture, path, IO_COLOR, NULL, &error), &error);
    return picture;
}

io_picture *read_picture(const char *path) {
    io_picture *picture = open_picture(path);
    io_error error = {{0}};
    assert_done(io_read(picture, &error), &error);
    return picture;
}

void write_picture(const io_picture *picture, const char *path, const char *note) {
    io_error got = {{0}}, error = {{0}};
    assert_done(io_write(picture, path, NULL, &got, &error), &error);
    if (note ? !strstr(got.text, note) : got.text[0] != '\0')
        fail_msg("the note is '%s', not '%s'", got.text, note ? note : "");
}

io_channel *channel_of(io_picture *picture, int part, const char *name) {
    for (int i = 0; i < picture->part[part].channel_count; i++)
        if (strcmp(picture->part[part].channel[i].name, name) == 0) return &picture->part[part].channel[i];
    fail_msg("%s has no channel %s", picture->path, name);
    return NULL;
}

size_t channel_bytes(const io_channel *channel) {
    return (size_t)channel->width * (size_t)channel->height * io_type_size(channel->type);
}

void assert_same_channel(const io_channel *a, const io_channel *b) {
    assert_string_equal(a->name, b->name);
    assert_int_equal(a->type, b->type);
    assert_int_equal(a->width, b->width);
    assert_int_equal(a->height, b->height);
    if (memcmp(a->data, b->data, channel_bytes(a)) != 0) fail_msg("pixels of %s differ", a->name);
}

void assert_same_pixels(const io_picture *a, const io_picture *b, const char *except) {
    assert_int_equal(a->part_count, b->part_count);
    for (int p = 0; p < a->part_count; p++) {
        assert_int_equal(a->part[p].channel_count, b->part[p].channel_count);
        for (int c = 0; c < a->part[p].channel_count && !a->part[p].deep; c++)
            if (!except || strcmp(a->part[p].channel[c].name, except) != 0)
                assert_same_channel(&a->part[p].channel[c], &b->part[p].channel[c]);
    }
}

void change_channel(io_channel *channel) {
    size_t width = (size_t)channel->width, count = width * (size_t)channel->height;
    float *values = malloc(count * sizeof *values);
    assert_non_null(values);
    io_channel_to_float(channel, values, 1, width);
    for (size_t i = 0; i < count; i++)
        values[i] += 0.25f;
    io_channel_from_float(channel, values, 1, width);
    free(values);
}

void assert_one_line(const io_error *error, const char *path) {
    assert_int_not_equal(error->text[0], '\0');
    assert_null(strchr(error->text, '\n'));
    if (strncmp(error->text, path, strlen(path)) != 0)
        fail_msg("'%s' does not begin with the file's name", error->text);
}
