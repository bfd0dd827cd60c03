/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* How a file comes to be: whole, under its name, with the permissions it should have; or not at all. */
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "support.h"

static io_picture *new_exr(int size) {
    static const char *const names[] = {"R", "G", "B"};
    io_picture *picture;
    io_error error;
    assert_int_equal(io_create(&picture, IO_EXR, size, size, names, 3, IO_FLOAT, 32, IO_COLOR, &error), 0);
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < size * size; i++)
            ((uint32_t *)picture->part[0].channel[c].data)[i] = (uint32_t)i * 2654435761u >> 2; /* does not compress */
    return picture;
}

static void refuse(const io_picture *picture, const char *path, const char *message) {
    io_error error = {{0}};
    assert_int_equal(io_write(picture, path, NULL, NULL, &error), -1);
    assert_one_line(&error, path);
    if (!strstr(error.text, message)) fail_msg("'%s' is not about '%s'", error.text, message);
}

static void assert_readable(const io_picture *written, const char *path) {
    io_picture *picture = read_picture(path);
    for (int c = 0; c < 3; c++)
        assert_same_channel(channel_of(picture, 0, "G"), &written->part[0].channel[1]);
    io_close(&picture);
}

static mode_t mode_of(const char *path) {
    struct stat status;
    assert_int_equal(stat(path, &status), 0);
    return status.st_mode & 07777;
}

static void test_permissions(void **state) {
    (void)state;
    io_picture *picture = new_exr(8);
    const char *path = in_folder("mode.exr");
    mode_t mask = umask(027);
    write_picture(picture, path, NULL);
    assert_int_equal(mode_of(path), 0640);
    chmod(path, 0604);
    write_picture(picture, path, NULL); /* an existing file's stay */
    assert_int_equal(mode_of(path), 0604);
    umask(mask);
    unlink(path);
    io_close(&picture);
    assert_int_equal(count_files(), 0);
}

static void test_over_its_own_source(void **state) {
    (void)state;
    io_picture *picture = new_exr(40);
    const char *path = in_folder("same.exr");
    write_picture(picture, path, NULL);
    io_picture *opened = open_picture(path);
    io_error error;
    const char *red[] = {"R"};
    assert_int_equal(io_read_channels(opened, 0, red, 1, &error), 0);
    change_channel(channel_of(opened, 0, "R"));
    write_picture(opened, path, NULL);
    assert_readable(picture, path);
    write_picture(opened, path, NULL); /* the source is still the old file */
    assert_readable(picture, path);
    io_close(&opened);
    unlink(path);
    io_close(&picture);
    assert_int_equal(count_files(), 0);
}

static void test_symbolic_links(void **state) {
    (void)state;
    io_picture *picture = new_exr(8);
    struct stat status;
    assert_int_equal(symlink("target.exr", in_folder("middle.exr")), 0);
    assert_int_equal(symlink(in_folder("middle.exr"), in_folder("link.exr")), 0);
    for (int existing = 0; existing < 2; existing++) {
        write_picture(picture, in_folder("link.exr"), NULL);
        assert_int_equal(lstat(in_folder("link.exr"), &status), 0);
        assert_true(S_ISLNK(status.st_mode));
        assert_int_equal(lstat(in_folder("target.exr"), &status), 0);
        assert_true(S_ISREG(status.st_mode));
        assert_readable(picture, in_folder("link.exr"));
    }
    assert_int_equal(symlink("loop.exr", in_folder("loop.exr")), 0);
    refuse(picture, in_folder("loop.exr"), "symbolic links");
    const char *names[] = {"target.exr", "middle.exr", "link.exr", "loop.exr"};
    for (int i = 0; i < 4; i++)
        unlink(in_folder(names[i]));
    io_close(&picture);
    assert_int_equal(count_files(), 0);
}

static void test_refused_names(void **state) {
    (void)state;
    io_picture *picture = new_exr(8);
    char path[600];
    assert_int_equal(mkdir(in_folder("folder.exr"), 0777), 0);
    refuse(picture, in_folder("folder.exr"), "folder");
    rmdir(in_folder("folder.exr"));
    refuse(picture, in_folder("missing/out.exr"), "does not exist");
    refuse(picture, in_folder("out.png"), "EXR");
    refuse(picture, in_folder("out"), "EXR");
    refuse(picture, in_folder("out.txt"), "EXR");
    memset(path, 'x', sizeof path);
    strcpy(path + sizeof path - 5, ".exr");
    io_error error;
    assert_int_equal(io_write(picture, path, NULL, NULL, &error), -1);
    if (geteuid() != 0) { /* root may write anywhere */
        assert_int_equal(mkdir(in_folder("locked"), 0555), 0);
        refuse(picture, in_folder("locked/out.exr"), "cannot be written to");
        rmdir(in_folder("locked"));
    }
    io_close(&picture);
    assert_int_equal(count_files(), 0);
}

static void test_devices_and_pipes(void **state) {
    (void)state;
    io_picture *picture = new_exr(64);
    struct stat status;
    write_picture(picture, "/dev/null", NULL);
    assert_int_equal(stat("/dev/null", &status), 0);
    assert_true(S_ISCHR(status.st_mode));
    refuse(picture, "/dev/full", "full");
    const char *pipe = in_folder("pipe"), *out = in_folder("out.exr");
    assert_int_equal(mkfifo(pipe, 0600), 0);
    pid_t child = fork();
    if (child == 0) {
        char command[1400];
        snprintf(command, sizeof command, "cat '%s' > '%s'", pipe, out);
        execl("/bin/sh", "sh", "-c", command, (char *)NULL);
        _exit(1);
    }
    write_picture(picture, pipe, NULL);
    int ended;
    assert_int_equal(waitpid(child, &ended, 0), child);
    assert_readable(picture, out);
    unlink(pipe);
    unlink(out);

    /* What a shell redirects to a file. */
    int file = open(out, O_WRONLY | O_CREAT | O_TRUNC, 0600);
    char path[40];
    snprintf(path, sizeof path, "/dev/fd/%d", file);
    write_picture(picture, path, NULL);
    close(file);
    assert_readable(picture, out);
    unlink(out);
    io_close(&picture);
    assert_int_equal(count_files(), 0);
}

/* A limit on the size of files stands in for a full disk: the same calls fail, at any byte wanted. */
static void test_full_disk(void **state) {
    (void)state;
    io_picture *picture = new_exr(200);
    const char *path = in_folder("out.exr");
    io_picture *old = new_exr(8);
    struct rlimit before, limit;
    struct stat whole;
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    write_picture(picture, path, NULL);
    assert_int_equal(stat(path, &whole), 0);
    unlink(path);
    signal(SIGXFSZ, SIG_IGN);
    for (int existing = 0; existing < 2; existing++) {
        for (rlim_t size = 0; size < (rlim_t)whole.st_size; size = size < 1000 ? size + 211 : size * 3 / 2) {
            limit = (struct rlimit){size, before.rlim_max};
            assert_int_equal(setrlimit(RLIMIT_FSIZE, &limit), 0);
            refuse(picture, path, "larger than files may be");
            assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
            assert_int_equal(count_files(), existing); /* nothing is left behind */
        }
        if (existing)
            assert_readable(old, path);
        else
            write_picture(old, path, NULL);
    }
    unlink(path);
    io_close(&picture);
    io_close(&old);
    assert_int_equal(count_files(), 0);
}

static void test_what_is_no_picture(void **state) {
    (void)state;
    io_picture *picture;
    io_error error = {{0}};
    static const struct {
        const char *name, *text, *message;
    } cases[] = {
        {"empty.exr", "", "is empty"}, {"text.exr", "hello, world", "is no EXR"}, {"short.exr", "v", "is no EXR"}};
    for (int i = 0; i < 3; i++) {
        write_file(in_folder(cases[i].name), cases[i].text, strlen(cases[i].text));
        assert_int_equal(io_open(&picture, in_folder(cases[i].name), IO_COLOR, NULL, &error), -1);
        assert_null(picture);
        assert_non_null(strstr(error.text, cases[i].message));
        assert_one_line(&error, in_folder(cases[i].name));
        unlink(in_folder(cases[i].name));
    }
    assert_int_equal(io_open(&picture, in_folder("missing.exr"), IO_COLOR, NULL, &error), -1);
    assert_one_line(&error, in_folder("missing.exr"));
    assert_int_equal(io_open(&picture, in_folder(""), IO_COLOR, NULL, &error), -1);
    assert_non_null(strstr(error.text, "folder"));
    assert_int_equal(mkfifo(in_folder("pipe.exr"), 0600), 0);
    assert_int_equal(io_open(&picture, in_folder("pipe.exr"), IO_COLOR, NULL, &error), -1);
    assert_one_line(&error, in_folder("pipe.exr"));
    unlink(in_folder("pipe.exr"));
    assert_int_equal(io_open(&picture, "/dev/null", IO_COLOR, NULL, &error), -1);
    assert_one_line(&error, "/dev/null");
}

static void test_messages_stay_one_line(void **state) {
    (void)state;
    io_picture *picture;
    io_error error = {{0}};
    assert_int_equal(io_open(&picture, "a\nb\033[31m.exr", IO_COLOR, NULL, &error), -1);
    assert_null(strchr(error.text, '\n'));
    assert_null(strchr(error.text, '\033'));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_permissions),        cmocka_unit_test(test_over_its_own_source),
        cmocka_unit_test(test_symbolic_links),     cmocka_unit_test(test_refused_names),
        cmocka_unit_test(test_devices_and_pipes),  cmocka_unit_test(test_full_disk),
        cmocka_unit_test(test_what_is_no_picture), cmocka_unit_test(test_messages_stay_one_line),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
