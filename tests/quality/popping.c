/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Does a focus pull run smoothly? The second difference in time, p(t-1) - 2 p(t) + p(t+1) of tone-mapped pixels, outside
 * silhouettes: what jumps from frame to frame has a large one.
 *
 * quality_popping N OURS.exr... TRUTH.exr... COC.exr... (N of each): root mean square of ours and of the truth, each frame,
 *     and over all; the ratio of the two is the last word.
 * quality_popping N OURS.exr... COC.exr...: of ours alone; the last word is the largest frame's over the median of all.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "frame.h"
#include "metrics.h"
#include "regions.h"

typedef struct sequence {
    frame *at;
    int count;
} sequence;

static sequence read_sequence(char **path, int count, bool coc, const sequence *like) {
    sequence s = {allocate((size_t)count, sizeof *s.at), count};
    for (int t = 0; t < count; t++) {
        if (coc) {
            s.at[t] = (frame){.width = like->at[0].width, .height = like->at[0].height};
            frame_read_coc(&s.at[t], path[t]);
            continue;
        }
        s.at[t] = frame_read(path[t], IO_COLOR);
        if (s.at[t].width != s.at[0].width || s.at[t].height != s.at[0].height) die("is of another size", path[t]);
        for (size_t i = 0; i < 3 * (size_t)s.at[t].width * (size_t)s.at[t].height; i++)
            s.at[t].rgb[i] = metrics_tone_map(s.at[t].rgb[i]);
    }
    return s;
}

/* Pixels that are in no silhouette in frames t-1, t, t+1. */
static unsigned char *usable(const sequence *coc, int t) {
    const int width = coc->at[0].width, height = coc->at[0].height;
    const size_t count = (size_t)width * (size_t)height;
    unsigned char *kind = allocate(count, 1), *good = allocate(count, 1);
    for (size_t i = 0; i < count; i++)
        good[i] = 1;
    for (int k = t - 1; k <= t + 1; k++) {
        if (regions_divide(kind, coc->at[k].coc, width, height)) die("out of memory", "quality_popping");
        for (size_t i = 0; i < count; i++)
            good[i] &= kind[i] == REGION_IN_FOCUS || kind[i] == REGION_DEFOCUSED;
    }
    free(kind);
    return good;
}

/* Mean square of the second difference. */
static double second_difference(const sequence *s, const unsigned char *good, int t) {
    const frame *a = &s->at[t - 1], *b = &s->at[t], *c = &s->at[t + 1];
    double sum = 0, count = 0;
    for (size_t i = 0; i < 3 * (size_t)b->width * (size_t)b->height; i++) {
        if (!good[i / 3]) continue;
        const double d = (double)a->rgb[i] - 2 * (double)b->rgb[i] + (double)c->rgb[i];
        sum += d * d;
        count++;
    }
    return count > 0 ? sum / count : 0;
}

static int by_size(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

int main(int words, char **word) {
    const int count = words > 1 ? atoi(word[1]) : 0;
    const bool truth = words == 2 + 3 * count;
    if (count < 3 || !(truth || words == 2 + 2 * count)) die("usage: N OURS... [TRUTH...] COC...", word[0]);
    const sequence ours = read_sequence(word + 2, count, false, NULL);
    const sequence theirs = truth ? read_sequence(word + 2 + count, count, false, NULL) : ours;
    const sequence coc = read_sequence(word + 2 + (truth ? 2 : 1) * count, count, true, &ours);
    if (theirs.at[0].width != ours.at[0].width || theirs.at[0].height != ours.at[0].height)
        die("the truth is of another size", word[0]);
    double *size = allocate((size_t)count, sizeof *size), total = 0, total_truth = 0;
    for (int t = 1; t < count - 1; t++) {
        unsigned char *good = usable(&coc, t);
        const double a = second_difference(&ours, good, t), b = second_difference(&theirs, good, t);
        printf("frame %d: %.6f", t + 1, sqrt(a));
        if (truth) printf(", truth %.6f", sqrt(b));
        puts("");
        size[t - 1] = sqrt(a);
        total += a;
        total_truth += b;
        free(good);
    }
    qsort(size, (size_t)count - 2, sizeof *size, by_size);
    if (truth)
        printf("all: %.6f, truth %.6f, ratio %.4f\n", sqrt(total / (count - 2)), sqrt(total_truth / (count - 2)),
               sqrt(total / total_truth));
    else
        printf("all: median %.6f, largest over median %.4f\n", size[(count - 2) / 2], size[count - 3] / size[(count - 2) / 2]);
    return 0; /* memory goes with the program */
}
