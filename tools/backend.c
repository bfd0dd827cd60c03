/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "backend.h"

#include <stdio.h>
#include <string.h>

#include "lens.h"
#include "message.h"

/* In the order of the words of --backend. */
static const ddof_backend backends[] = {DDOF_BACKEND_AUTO, DDOF_BACKEND_CPU, DDOF_BACKEND_GL, DDOF_BACKEND_VULKAN,
                                        DDOF_BACKEND_REFERENCE};

enum { ON_GL = 1 << DDOF_BACKEND_GL, ON_VULKAN = 1 << DDOF_BACKEND_VULKAN, ON_GPU = ON_GL | ON_VULKAN };

/* Options that the CPU's backends do not have, and who has them. */
static const struct gpu_option {
    option_id id;
    unsigned owners;
} gpu_options[] = {{OPT_SOLVER, ON_GPU},    {OPT_SURFACE, ON_GPU},  {OPT_SHARED_CHAIN, ON_GL},
                   {OPT_APPEND, ON_VULKAN}, {OPT_QUADS, ON_VULKAN}, {OPT_DEVICE, ON_VULKAN}};

enum { GPU_OPTIONS = sizeof gpu_options / sizeof *gpu_options };

static const ddof_solver gl_solvers[] = {DDOF_SOLVER_CR4_PACK, DDOF_SOLVER_CR_VANILLA, DDOF_SOLVER_CR,
                                         DDOF_SOLVER_CR_PACK,  DDOF_SOLVER_CR4,        DDOF_SOLVER_CR_PCR};
static const ddof_solver vulkan_solvers[] = {DDOF_SOLVER_LINE, DDOF_SOLVER_PCR, DDOF_SOLVER_PCR3_SWEEP,
                                             DDOF_SOLVER_CR4_PACK};

/* ------------------------------------------------------------------------- names */

const char *backend_name(ddof_backend backend) {
    return backend == DDOF_BACKEND_GL          ? "gl"
           : backend == DDOF_BACKEND_VULKAN    ? "vulkan"
           : backend == DDOF_BACKEND_REFERENCE ? "reference"
                                               : "cpu";
}

static const char *backend_title(ddof_backend backend) {
    return backend == DDOF_BACKEND_GL ? "GL" : "Vulkan";
}

const ddof_solver *backend_solvers(ddof_backend backend, size_t *count) {
    *count = backend == DDOF_BACKEND_GL       ? sizeof gl_solvers / sizeof *gl_solvers
             : backend == DDOF_BACKEND_VULKAN ? sizeof vulkan_solvers / sizeof *vulkan_solvers
                                              : 0;
    return backend == DDOF_BACKEND_GL ? gl_solvers : vulkan_solvers;
}

const char *solver_name(ddof_backend backend, ddof_solver solver) {
    static const char *const names[] = {"default",  "cr-vanilla", "cr",   "cr+pack", "cr4",
                                        "cr4+pack", "cr+pcr",     "line", "pcr",     "pcr3+sweep"};
    size_t count;
    const ddof_solver *all = backend_solvers(backend, &count);
    return names[solver == DDOF_SOLVER_DEFAULT && count > 0 ? all[0] : solver];
}

const char *surface_name(ddof_surface surface) {
    return surface == DDOF_SURFACE_RGBA32F ? "rgba32f" : "rgba16f";
}

/* ------------------------------------------------------------------------- choice */

/* The backends that have a solver, as bits. */
static unsigned owners_of_solver(ddof_solver solver) {
    unsigned owners = 0;
    for (ddof_backend b = DDOF_BACKEND_GL; b <= DDOF_BACKEND_VULKAN; b++) {
        size_t count;
        const ddof_solver *all = backend_solvers(b, &count);
        for (size_t i = 0; i < count; i++)
            if (all[i] == solver) owners |= 1u << b;
    }
    return owners;
}

/* Of --solver, whose words stand in the order of the library's names, the first of which is 1. */
static ddof_solver solver_of_options(const options *o) {
    return (ddof_solver)(option_number(o, OPT_SOLVER, DDOF_SOLVER_DEFAULT - 1) + 1);
}

static int fail_solver(ddof_backend backend, const char *typed) {
    char known[128] = "";
    size_t count;
    const ddof_solver *all = backend_solvers(backend, &count);
    for (size_t i = 0; i < count; i++)
        snprintf(known + strlen(known), sizeof known - strlen(known), "%s%s", i > 0 ? ", " : "",
                 solver_name(backend, all[i]));
    return fail_usage("--solver: the %s backend has no '%s'; it has: %s", backend_title(backend), typed, known);
}

static int fail_owner(const options *o, option_id id, unsigned owners) {
    const char *verb = option_given(o, OPT_BACKEND) ? "take" : "add", *name = option_table[id].name;
    if (owners == ON_GPU)
        return fail_usage("--%s: belongs to the GPU backends; %s --backend gl or --backend vulkan", name, verb);
    const ddof_backend owner = owners == ON_GL ? DDOF_BACKEND_GL : DDOF_BACKEND_VULKAN;
    return fail_usage("--%s: belongs to the %s backend; %s --backend %s", name, backend_title(owner), verb,
                      backend_name(owner));
}

/* The float64 reference and the compute shaders have no use for what diffusion is compared with. */
static int check_method(const options *o, ddof_backend chosen) {
    const ddof_method method = method_of_options(o);
    if (method != DDOF_METHOD_GAUSSIAN && method != DDOF_METHOD_HEXAGON) return 0;
    if (chosen == DDOF_BACKEND_CPU || chosen == DDOF_BACKEND_GL) return 0;
    return fail_usage("--method: the %s backend has no '%s'; take --backend cpu or --backend gl", backend_name(chosen),
                      method_name(method));
}

/* Whether the backend has what was asked for. */
static int check_options(const options *o, ddof_backend asked, ddof_backend chosen) {
    for (int i = 0; i < GPU_OPTIONS; i++) {
        const option_id id = gpu_options[i].id;
        if (!option_given(o, id)) continue;
        /* "the second device" is no wish that another backend could stand in for: "auto" does not choose for it */
        const ddof_backend backend = id == OPT_DEVICE ? asked : chosen;
        const unsigned owners = id == OPT_SOLVER ? owners_of_solver(solver_of_options(o)) : gpu_options[i].owners;
        if (owners & 1u << backend) continue;
        if (id == OPT_SOLVER && ON_GPU & 1u << backend) return fail_solver(backend, option_text(o, OPT_SOLVER));
        return fail_owner(o, id, owners);
    }
    return check_method(o, chosen);
}

int backend_choose(backend_choice *choice, const options *o) {
    const ddof_backend asked = backends[(int)option_number(o, OPT_BACKEND, 0)];
    *choice = (backend_choice){.backend = asked == DDOF_BACKEND_AUTO ? DDOF_BACKEND_CPU : asked};
    /* "auto" said in so many words, beside an option of the GPU backends: one that has it, where it can be had */
    if (asked == DDOF_BACKEND_AUTO && option_given(o, OPT_BACKEND))
        for (int i = GPU_OPTIONS - 1; i >= 0; i--)
            if (option_given(o, gpu_options[i].id)) choice->because = option_table[gpu_options[i].id].name;
    if (choice->because)
        choice->backend = option_given(o, OPT_SOLVER) && owners_of_solver(solver_of_options(o)) == ON_VULKAN
                              ? DDOF_BACKEND_VULKAN
                              : DDOF_BACKEND_GL;
    return check_options(o, asked, choice->backend);
}

void backend_note_fallback(const backend_choice *choice, const char *why) {
    note("note: --backend auto: %s; the CPU engine does the work, without --%s", why, choice->because);
}
