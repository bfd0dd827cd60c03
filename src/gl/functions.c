/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "functions.h"

#include <stddef.h>

const char *gl_functions_load(gl_functions *f, const ddof_gl_config *config) {
#define LOAD(type, name)                                                                                               \
    f->name = (type)config->get_proc(config->get_proc_user, "gl" #name);                                               \
    if (!f->name) return "gl" #name;
    GL_FUNCTIONS(LOAD)
#undef LOAD
    return NULL;
}

/* get_proc may return a function for any name: what the version does not promise is not asked for. */
void gl_functions_load_later(gl_functions *f, const ddof_gl_config *config, int version) {
    void *user = config->get_proc_user;
    ddof_gl_function get[8] = {NULL};
    if (version >= 31) get[0] = config->get_proc(user, "glGetTexLevelParameteriv");
    if (version >= 32) {
        get[1] = config->get_proc(user, "glEnablei");
        get[2] = config->get_proc(user, "glDisablei");
        get[3] = config->get_proc(user, "glIsEnabledi");
        get[4] = config->get_proc(user, "glColorMaski");
        get[6] = config->get_proc(user, "glBlendFuncSeparatei");
        get[7] = config->get_proc(user, "glBlendEquationSeparatei");
    }
    if (version >= 31) get[5] = config->get_proc(user, "glGetBooleani_v");
    f->GetTexLevelParameteriv = (void(GL_APIENTRY *)(GLenum, GLint, GLenum, GLint *))get[0];
    if (get[1] && get[2] && get[3] && get[4] && get[5] && get[6] && get[7]) {
        f->Enablei = (void(GL_APIENTRY *)(GLenum, GLuint))get[1];
        f->Disablei = (void(GL_APIENTRY *)(GLenum, GLuint))get[2];
        f->IsEnabledi = (GLboolean(GL_APIENTRY *)(GLenum, GLuint))get[3];
        f->ColorMaski = (void(GL_APIENTRY *)(GLuint, GLboolean, GLboolean, GLboolean, GLboolean))get[4];
        f->GetBooleani_v = (void(GL_APIENTRY *)(GLenum, GLuint, GLboolean *))get[5];
        f->BlendFuncSeparatei = (void(GL_APIENTRY *)(GLuint, GLenum, GLenum, GLenum, GLenum))get[6];
        f->BlendEquationSeparatei = (void(GL_APIENTRY *)(GLuint, GLenum, GLenum))get[7];
    }
}
