/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* bench_gl [WIDTH HEIGHT [FRAMES]]: the solvers of the GL backend on this machine's GL: medians of the draws alone
 * (glFinish and wall clock; picture, CoC and result are rgba16f, r32f and rgba16f textures), bytes per pixel of the
 * surfaces, and cr4+pack against cr, taken in turns. */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include <GLES3/gl3.h>

#include "gl/egl.h"

enum { MOST = 99 };

static double milliseconds(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec * 1e3 + (double)t.tv_nsec * 1e-6;
}

static int compare(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void say(void *user, ddof_log_level level, const char *text) {
    (void)user, (void)level;
    fprintf(stderr, "%s\n", text);
}

typedef struct bench {
    egl_session session;
    ddof_gl *gl;
    ddof_gl_frame frame;
    ddof_gl_stats stats;
    PFNGLFINISHPROC finish;
} bench;

static ddof_gl_texture make_texture(bench *b, GLenum format, GLenum layout, const float *values) {
    PFNGLGENTEXTURESPROC gen = (PFNGLGENTEXTURESPROC)egl_get_proc(&b->session, "glGenTextures");
    PFNGLBINDTEXTUREPROC bind = (PFNGLBINDTEXTUREPROC)egl_get_proc(&b->session, "glBindTexture");
    PFNGLTEXSTORAGE2DPROC storage = (PFNGLTEXSTORAGE2DPROC)egl_get_proc(&b->session, "glTexStorage2D");
    PFNGLTEXSUBIMAGE2DPROC image = (PFNGLTEXSUBIMAGE2DPROC)egl_get_proc(&b->session, "glTexSubImage2D");
    ddof_gl_texture t = {0, format};
    gen(1, &t.name);
    bind(GL_TEXTURE_2D, t.name);
    storage(GL_TEXTURE_2D, 1, format, b->frame.width, b->frame.height);
    if (values) image(GL_TEXTURE_2D, 0, 0, 0, b->frame.width, b->frame.height, layout, GL_FLOAT, values);
    return t;
}

static double frame_time(bench *b, ddof_solver solver, int shared) {
    const ddof_settings settings = {.solver = solver, .shared_chain = shared};
    const double start = milliseconds();
    if (ddof_gl_render(b->gl, &b->frame, &settings, &b->stats) != DDOF_OK) {
        fprintf(stderr, "%s\n", ddof_gl_error(b->gl));
        exit(1);
    }
    b->finish();
    return milliseconds() - start;
}

static void table(bench *b, int frames) {
    static const char *const names[] = {"", "cr-vanilla", "cr", "cr+pack", "cr4", "cr4+pack", "cr+pcr"};
    double time[MOST];
    for (int k = 0; k < 12; k++) {
        const int solver = k % 6 + 1, shared = k / 6;
        frame_time(b, (ddof_solver)solver, shared); /* makes surfaces and programs */
        for (int i = 0; i < frames; i++)
            time[i] = frame_time(b, (ddof_solver)solver, shared);
        qsort(time, (size_t)frames, sizeof *time, compare);
        printf("%-10s %-12s %8.2f ms (%.2f to %.2f) %6.2f bytes per pixel, %d draws\n", names[solver],
               shared ? "shared chain" : "", time[frames / 2], time[0], time[frames - 1],
               (double)b->stats.surface_bytes / b->frame.width / b->frame.height, (int)b->stats.draws);
    }
}

static void ratio(bench *b, int frames) {
    double time[2][MOST];
    for (int i = 0; i < frames; i++)
        for (int k = 0; k < 2; k++) {
            const ddof_solver solver = k ? DDOF_SOLVER_CR4_PACK : DDOF_SOLVER_CR;
            frame_time(b, solver, 0);
            time[k][i] = frame_time(b, solver, 0);
        }
    for (int k = 0; k < 2; k++)
        qsort(time[k], (size_t)frames, sizeof **time, compare);
    printf("cr4+pack / cr = %.3f\n", time[1][frames / 2] / time[0][frames / 2]);
}

int main(int argc, char **argv) {
    bench b = {
        .frame = {.width = argc > 2 ? atoi(argv[1]) : 1600, .height = argc > 2 ? atoi(argv[2]) : 1200, .channels = 3}};
    int frames = argc > 3 ? atoi(argv[3]) : 9;
    char text[300];
    if (b.frame.width < 1 || b.frame.height < 1 || frames < 1) return 2;
    if (frames > MOST) frames = MOST;
    if (!egl_open(&b.session, text, sizeof text) || !egl_enter(&b.session, text, sizeof text)) {
        fprintf(stderr, "%s\n", text);
        return 1;
    }
    const ddof_gl_config config = {.get_proc = egl_get_proc, .get_proc_user = &b.session, .log = say};
    if (ddof_gl_create(&b.gl, &config) != DDOF_OK) return 1;
    b.finish = (PFNGLFINISHPROC)egl_get_proc(&b.session, "glFinish");

    const size_t n = (size_t)b.frame.width * (size_t)b.frame.height;
    float *color = malloc(n * 4 * sizeof *color), *coc = malloc(n * sizeof *coc);
    if (!color || !coc) return 1;
    for (size_t i = 0; i < 4 * n; i++)
        color[i] = (float)(i * 2654435761u % 1000) / 1000;
    for (size_t i = 0; i < n; i++)
        coc[i] = (float)(i % (size_t)b.frame.width) / 50;
    b.frame.color = make_texture(&b, GL_RGBA16F, GL_RGBA, color);
    b.frame.coc = make_texture(&b, GL_R32F, GL_RED, coc);
    b.frame.output = make_texture(&b, GL_RGBA16F, GL_RGBA, NULL);
    free(color);
    free(coc);
    frame_time(&b, DDOF_SOLVER_DEFAULT, 0);
    printf("%s, %d x %d, medians of %d frames\n", b.stats.device, b.frame.width, b.frame.height, frames);
    table(&b, frames);
    ratio(&b, frames);
    ddof_gl_destroy(&b.gl);
    egl_leave(&b.session);
    egl_close(&b.session);
    return 0;
}
