/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "state.h"

static const GLenum caps[STATE_CAPS] = {
    GL_BLEND,
    GL_CULL_FACE,
    GL_DEPTH_TEST,
    GL_DITHER,
    GL_RASTERIZER_DISCARD,
    GL_SAMPLE_COVERAGE,
    GL_SCISSOR_TEST,
    GL_STENCIL_TEST,
    GL_POLYGON_OFFSET_FILL,
    GL_SAMPLE_ALPHA_TO_COVERAGE,
};

static const GLenum blendings[STATE_BLENDS] = {
    GL_BLEND_EQUATION_RGB, GL_BLEND_EQUATION_ALPHA, GL_BLEND_SRC_RGB,
    GL_BLEND_DST_RGB,      GL_BLEND_SRC_ALPHA,      GL_BLEND_DST_ALPHA,
};

static const struct {
    GLenum name;
    GLint set;
} unpacks[STATE_UNPACKS] = {
    {GL_UNPACK_ALIGNMENT, 4}, {GL_UNPACK_ROW_LENGTH, 0}, {GL_UNPACK_SKIP_ROWS, 0}, {GL_UNPACK_SKIP_PIXELS, 0}};

void gl_state_save(const ddof_gl *gl, gl_state *s) {
    const gl_functions *f = &gl->f;
    f->GetIntegerv(GL_CURRENT_PROGRAM, &s->program);
    f->GetIntegerv(GL_VERTEX_ARRAY_BINDING, &s->vertex_array);
    f->GetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &s->framebuffer);
    f->GetIntegerv(GL_ACTIVE_TEXTURE, &s->active_texture);
    f->GetIntegerv(GL_VIEWPORT, s->viewport);
    for (GLuint i = 0; i < GL_UNITS; i++) {
        f->ActiveTexture(GL_TEXTURE0 + i);
        f->GetIntegerv(GL_TEXTURE_BINDING_2D, &s->texture[i]);
        f->GetIntegerv(GL_SAMPLER_BINDING, &s->sampler[i]);
    }
    for (int i = 0; i < STATE_CAPS; i++)
        s->cap[i] = f->IsEnabled(caps[i]);
    f->GetBooleanv(GL_COLOR_WRITEMASK, s->mask);
    f->GetIntegerv(GL_PIXEL_UNPACK_BUFFER_BINDING, &s->unpack_buffer);
    for (int i = 0; i < STATE_UNPACKS; i++)
        f->GetIntegerv(unpacks[i].name, &s->unpack[i]);
    for (int i = 0; i < STATE_BLENDS; i++)
        f->GetIntegerv(blendings[i], &s->blending[0][i]);
    s->buffers = 0;
    if (!f->Enablei) return;
    GLint most = 0;
    f->GetIntegerv(GL_MAX_DRAW_BUFFERS, &most);
    s->buffers = most < STATE_BUFFERS ? most : STATE_BUFFERS;
    for (GLuint i = 0; i < (GLuint)s->buffers; i++) {
        s->blend[i] = f->IsEnabledi(GL_BLEND, i);
        f->GetBooleani_v(GL_COLOR_WRITEMASK, i, s->buffer_mask[i]);
        for (int k = 0; k < STATE_BLENDS; k++)
            f->GetIntegeri_v(blendings[k], i, &s->blending[i][k]);
    }
}

void gl_state_set(const ddof_gl *gl) {
    const gl_functions *f = &gl->f;
    for (int i = 0; i < STATE_CAPS; i++)
        f->Disable(caps[i]);
    f->ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    f->BindVertexArray(gl->vertex_array);
    f->BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
    for (int i = 0; i < STATE_UNPACKS; i++)
        f->PixelStorei(unpacks[i].name, unpacks[i].set);
    /* A sampler object of our own: the caller's filters could make a texture incomplete. */
    for (GLuint i = 0; i < GL_UNITS; i++)
        f->BindSampler(i, gl->sampler);
}

void gl_state_restore(const ddof_gl *gl, const gl_state *s) {
    const gl_functions *f = &gl->f;
    for (GLuint i = 0; i < GL_UNITS; i++) {
        f->ActiveTexture(GL_TEXTURE0 + i);
        f->BindTexture(GL_TEXTURE_2D, (GLuint)s->texture[i]);
        f->BindSampler(i, (GLuint)s->sampler[i]);
    }
    f->ActiveTexture((GLenum)s->active_texture);
    for (int i = 0; i < STATE_CAPS; i++) {
        if (s->cap[i])
            f->Enable(caps[i]);
        else
            f->Disable(caps[i]);
    }
    f->ColorMask(s->mask[0], s->mask[1], s->mask[2], s->mask[3]);
    const GLint *blending = s->blending[0];
    f->BlendEquationSeparate((GLenum)blending[0], (GLenum)blending[1]);
    f->BlendFuncSeparate((GLenum)blending[2], (GLenum)blending[3], (GLenum)blending[4], (GLenum)blending[5]);
    for (GLuint i = 0; i < (GLuint)s->buffers; i++) {
        const GLboolean *m = s->buffer_mask[i];
        if (s->blend[i])
            f->Enablei(GL_BLEND, i);
        else
            f->Disablei(GL_BLEND, i);
        f->ColorMaski(i, m[0], m[1], m[2], m[3]);
        const GLint *b = s->blending[i];
        f->BlendEquationSeparatei(i, (GLenum)b[0], (GLenum)b[1]);
        f->BlendFuncSeparatei(i, (GLenum)b[2], (GLenum)b[3], (GLenum)b[4], (GLenum)b[5]);
    }
    f->BindBuffer(GL_PIXEL_UNPACK_BUFFER, (GLuint)s->unpack_buffer);
    for (int i = 0; i < STATE_UNPACKS; i++)
        f->PixelStorei(unpacks[i].name, s->unpack[i]);
    f->BindVertexArray((GLuint)s->vertex_array);
    f->BindFramebuffer(GL_DRAW_FRAMEBUFFER, (GLuint)s->framebuffer);
    f->Viewport(s->viewport[0], s->viewport[1], s->viewport[2], s->viewport[3]);
    f->UseProgram((GLuint)s->program);
}
