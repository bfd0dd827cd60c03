/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* What stands in for libFuzzer in builds without it: replay FOLDER... runs the target once for every file there. */
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>

#include "fuzz.h"

static bool run_file(const char *path) {
    struct stat status;
    if (stat(path, &status) != 0 || !S_ISREG(status.st_mode)) return false;
    FILE *file = fopen(path, "rb");
    const size_t size = (size_t)status.st_size;
    /* Not a byte more than there is, so that a sanitizer sees who reads beyond. */
    uint8_t *data = malloc(size ? size : 1);
    fuzz_require(file && data && fread(data, 1, size, file) == size, "the corpus can be read", path);
    fclose(file);
    LLVMFuzzerTestOneInput(data, size);
    free(data);
    return true;
}

static int run_folder(const char *folder) {
    DIR *list = opendir(folder);
    if (!list) return 0;
    int count = 0;
    for (struct dirent *entry; (entry = readdir(list));) {
        char path[4096];
        snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
        /* Known before it runs: an abort says the rule, not the file. */
        fprintf(stdout, "# %s\n", entry->d_name);
        fflush(stdout);
        count += run_file(path);
    }
    closedir(list);
    return count;
}

int main(int argc, char **argv) {
    for (int i = 1; i < argc; i++) {
        const int count = run_folder(argv[i]);
        fuzz_require(count > 0, "there is a corpus", argv[i]);
        printf("ok %d - %d files of %s\n", i, count, argv[i]);
    }
    printf("1..%d\n", argc - 1);
    return 0;
}
