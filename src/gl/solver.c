/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The method, pass by pass: along rows from the colour to a surface, along columns from there to the output. In either
 * direction equations are reduced until few unknowns are left, these are solved, and the others substituted. */
#include <string.h>

#include "device.h"

/* One pass: what it reads and what it writes. */
typedef struct pass {
    gl_stage stage;
    const gl_target *rows; /* NULL: of the picture */
    int unknowns;
    const gl_target *y; /* NULL: none is read */
    int known;
    const gl_target *to; /* NULL: the picture that this direction writes */
    int to_unknowns;
    bool to_rows;
    int stride;
} pass;

/* One direction of one substep. */
typedef struct direction {
    ddof_gl *gl;
    const gl_frame *frame;
    const gl_chain *chain;
    bool vertical, coc_decides;
    float scale;
    GLuint source;        /* texture that is blurred */
    GLuint target;        /* framebuffer of the result */
    const gl_target *abc; /* cr-vanilla: the coefficients of the picture, once there are any */
    ddof_status status;
} direction;

void gl_set_lens(const gl_functions *f, const GLint *u, const gl_frame *frame) {
    const lens_curve *c = &frame->job->curve;
    const ddof_frame *in = frame->job->frame;
    f->Uniform2f(u[U_DEPTH_LINEAR], c->offset, c->slope);
    f->Uniform4f(u[U_DEPTH_AXIS], c->x_center - (float)in->offset_x, c->y_center - (float)in->offset_y, c->x_tangent,
                 c->y_tangent);
    f->Uniform4f(u[U_LENS_CURVE], c->q_far, lens_q_near(c), c->gain_far, c->gain_near);
    f->Uniform2f(u[U_LENS_LIMIT], c->limit_far, c->limit_near);
}

void gl_bind(const gl_functions *f, GLuint unit, GLuint texture) {
    f->ActiveTexture(GL_TEXTURE0 + unit);
    f->BindTexture(GL_TEXTURE_2D, texture);
}

/* Whether what is written, or its colours, are half floats. */
static bool writes_half(const direction *d, const pass *p) {
    if (p->to) return p->to->format[p->to->format[1] ? 1 : 0] == GL_RGBA16F;
    return p->stage != STAGE_COC &&
           (d->vertical ? d->frame->half_output : d->gl->surfaces.picture->format[0] == GL_RGBA16F);
}

static gl_variant variant_of(const direction *d, const pass *p) {
    const gl_layout *l = &d->gl->surfaces.layout;
    const bool picture = !p->rows || p->rows == d->abc;
    gl_variant v;
    memset(&v, 0, sizeof v);
    v.stage = p->stage;
    v.rows = !p->rows                  ? FROM_PICTURE
             : p->rows == d->abc       ? FROM_BOTH
             : solver_packs(l->solver) ? FROM_PACKED
                                       : FROM_TABLE;
    v.vertical = d->vertical;
    v.shared = d->vertical && l->shared;
    v.alpha = d->frame->alpha;
    v.depth = !p->rows && d->frame->job->is_depth ? 1 + (int)d->frame->job->curve.kind : 0;
    v.half = picture && (l->surface == DDOF_SURFACE_RGBA16F || solver_packs(l->solver));
    v.to_rows = p->to_rows;
    v.to_packed = p->to_rows && solver_packs(l->solver);
    v.to_picture = !p->to || p->to == d->gl->surfaces.abc;
    v.to_half = writes_half(d, p);
    v.last = d->vertical && !p->to;
    return v;
}

/* Rows and unknowns that the pass reads. */
static void set_sources(const direction *d, const pass *p, const GLint *u) {
    const gl_functions *f = &d->gl->f;
    f->Uniform1i(u[U_UNKNOWNS], p->unknowns);
    f->Uniform1i(u[U_KNOWN], p->known);
    f->Uniform1i(u[U_STRIDE], p->stride);
    f->Uniform1f(u[U_SCALE], d->scale);
    f->Uniform1i(u[U_COC_DECIDES], d->coc_decides);
    if (!p->rows || p->rows == d->abc) gl_bind(f, UNIT_COLOR, d->source);
    if (!p->rows) {
        gl_bind(f, UNIT_COC, d->frame->map);
    } else if (p->rows->format[0] == GL_RGBA32UI) {
        gl_bind(f, UNIT_PACKED, p->rows->texture[0]);
    } else {
        gl_bind(f, UNIT_ABC, p->rows->texture[0]);
        if (p->rows->texture[1]) gl_bind(f, UNIT_X, p->rows->texture[1]);
    }
    if (p->rows) f->Uniform2i(u[U_ROWS_FOLD], p->rows->width, p->unknowns);
    if (p->y) {
        gl_bind(f, UNIT_Y, p->y->texture[0]);
        f->Uniform2i(u[U_Y_FOLD], p->y->width, p->known);
    }
}

/* The framebuffer, and the part of it that this level fills. */
static void set_target(const direction *d, const pass *p, const GLint *u) {
    const gl_functions *f = &d->gl->f;
    const int lines = d->chain->lines, n = p->to_unknowns;
    f->BindFramebuffer(GL_DRAW_FRAMEBUFFER, p->to ? p->to->framebuffer : d->target);
    if (!d->vertical) {
        f->Viewport(0, 0, n, lines);
    } else if (p->to && d->gl->surfaces.layout.shared && p->to != d->gl->surfaces.abc) {
        const int width = p->to->width < lines ? p->to->width : lines;
        f->Uniform2i(u[U_TARGET_FOLD], p->to->width, n);
        f->Viewport(0, 0, width, (lines + width - 1) / width * n);
    } else {
        f->Viewport(0, 0, lines, n);
    }
}

static void draw(direction *d, const pass *p) {
    ddof_gl *gl = d->gl;
    if (d->status != DDOF_OK) return;
    const gl_variant variant = variant_of(d, p);
    const gl_program *program = gl_program_get(gl, &variant, &d->status);
    if (!program) return;
    gl->f.UseProgram(program->name);
    if (variant.depth) gl_set_lens(&gl->f, program->uniform, d->frame);
    set_sources(d, p, program->uniform);
    set_target(d, p, program->uniform);
    gl->f.DrawArrays(GL_TRIANGLES, 0, 3);
    gl->draws++;
}

/* PCR over `n` unknowns per line, from `rows` (NULL: the picture) to `to` (NULL: likewise). */
static void pcr(direction *d, const gl_target *rows, int n, const gl_target *to) {
    int turn = 0;
    for (int stride = 1; stride < n; stride *= 2, turn ^= 1) {
        const bool last = 2 * stride >= n;
        const gl_target *next = last ? to : d->chain->pcr[turn];
        draw(d, &(pass){STAGE_PCR, .rows = rows, .unknowns = n, .to = next, .to_unknowns = n, .to_rows = !last,
                        .stride = stride});
        rows = next;
    }
}

/* Lines so short that nothing is to be reduced. */
static void solve_picture(direction *d, ddof_solver solver) {
    const int n = d->chain->length;
    if (solver == DDOF_SOLVER_CR_PCR && n > 1)
        pcr(d, NULL, n, NULL);
    else
        draw(d, &(pass){STAGE_SOLVE, .unknowns = n, .to_unknowns = n});
}

static void solve_direction(direction *d, ddof_solver solver) {
    const gl_chain *c = d->chain;
    const int n = c->length, last = c->levels - 1;
    const gl_target *picture = NULL;
    if (c->levels == 0) {
        solve_picture(d, solver);
        return;
    }

    if (solver == DDOF_SOLVER_CR_VANILLA) {
        picture = d->gl->surfaces.abc;
        draw(d, &(pass){STAGE_CONSTRUCT, .unknowns = n, .to = picture, .to_unknowns = n, .to_rows = true});
        d->abc = picture;
    }
    draw(d, &(pass){solver_is_cr4(solver) ? STAGE_INITIAL_REDUCE4 : STAGE_REDUCE, .rows = picture, .unknowns = n,
                    .to = c->rows[0], .to_unknowns = c->unknowns[0], .to_rows = true});
    for (int k = 1; k <= last; k++)
        draw(d, &(pass){STAGE_REDUCE, .rows = c->rows[k - 1], .unknowns = c->unknowns[k - 1], .to = c->rows[k],
                        .to_unknowns = c->unknowns[k], .to_rows = true});

    if (solver == DDOF_SOLVER_CR_PCR)
        pcr(d, c->rows[last], c->unknowns[last], c->y[last % 2]);
    else
        draw(d, &(pass){STAGE_SOLVE, .rows = c->rows[last], .unknowns = c->unknowns[last], .to = c->y[last % 2],
                        .to_unknowns = c->unknowns[last]});

    for (int k = last - 1; k >= 0; k--)
        draw(d, &(pass){STAGE_SUBSTITUTE, .rows = c->rows[k], .unknowns = c->unknowns[k], .y = c->y[(k + 1) % 2],
                        .known = c->unknowns[k + 1], .to = c->y[k % 2], .to_unknowns = c->unknowns[k]});
    draw(d, &(pass){solver_is_cr4(solver) ? STAGE_FINAL_SOLVE4 : STAGE_SUBSTITUTE, .rows = picture, .unknowns = n,
                    .y = c->y[0], .known = c->unknowns[0], .to_unknowns = n});
}

bool gl_attach_output(ddof_gl *gl, GLuint texture) {
    static const GLenum buffer = GL_COLOR_ATTACHMENT0;
    gl->f.BindFramebuffer(GL_DRAW_FRAMEBUFFER, gl->output);
    gl->f.FramebufferTexture2D(GL_DRAW_FRAMEBUFFER, buffer, GL_TEXTURE_2D, texture, 0);
    gl->f.DrawBuffers(1, &buffer);
    return gl->f.CheckFramebufferStatus(GL_DRAW_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
}

void gl_detach_output(ddof_gl *gl) {
    gl->f.BindFramebuffer(GL_DRAW_FRAMEBUFFER, gl->output);
    gl->f.FramebufferTexture2D(GL_DRAW_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, 0, 0);
}

ddof_status gl_check_solver(ddof_context *owner, const ddof_settings *settings) {
    if (settings->solver <= DDOF_SOLVER_CR_PCR) return DDOF_OK;
    return context_fail(owner, DDOF_ERROR_UNSUPPORTED,
                        "settings.solver is %d, which the GL backend does not have: give 1 to %d, or 0 for the best",
                        (int)settings->solver, (int)DDOF_SOLVER_CR_PCR);
}

ddof_status gl_solve(ddof_gl *gl, const gl_frame *frame) {
    const gl_layout layout = gl_layout_make(frame->width, frame->height, gl->max_size, frame->settings);
    ddof_status status = gl_surfaces_make(gl, &layout);
    if (status != DDOF_OK) return status;
    if (!gl_attach_output(gl, frame->output)) {
        gl_detach_output(gl);
        return context_fail(gl->owner, DDOF_ERROR_INVALID, "frame.output: this GL cannot render to that texture");
    }
    const gl_surfaces *s = &gl->surfaces;
    for (int i = 0; i < frame->job->substeps && status == DDOF_OK; i++) {
        direction rows = {.gl = gl, .frame = frame, .chain = &s->chain[0], .coc_decides = i == 0};
        rows.scale = (float)frame->job->row_scale;
        rows.source = i == 0 ? frame->color : frame->output;
        rows.target = s->picture->framebuffer;
        solve_direction(&rows, layout.solver);

        direction columns = {.gl = gl, .frame = frame, .chain = &s->chain[1], .vertical = true, .status = rows.status};
        columns.scale = (float)frame->job->column_scale;
        columns.source = s->picture->texture[0];
        columns.target = gl->output;
        solve_direction(&columns, layout.solver);
        status = columns.status;
    }
    gl_detach_output(gl);
    return status != DDOF_OK ? status : gl_device_check(gl);
}

ddof_status gl_coc(ddof_gl *gl, const gl_frame *frame) {
    const gl_chain chain = {.lines = frame->height, .length = frame->width};
    direction d = {.gl = gl, .frame = frame, .chain = &chain, .target = gl->output};
    if (!gl_attach_output(gl, frame->output)) {
        gl_detach_output(gl);
        return context_fail(gl->owner, DDOF_ERROR_UNSUPPORTED, "this GL (%s) does not render to R32F", gl->renderer);
    }
    draw(&d, &(pass){STAGE_COC, .unknowns = frame->width, .to_unknowns = frame->width});
    gl_detach_output(gl);
    return d.status != DDOF_OK ? d.status : gl_device_check(gl);
}
