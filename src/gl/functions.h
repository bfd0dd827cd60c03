/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The GL functions that are used, each once. */
#ifndef DDOF_GL_FUNCTIONS_H
#define DDOF_GL_FUNCTIONS_H

#include <stdbool.h>

#include <GLES3/gl3.h>

#include <ddof/gl.h>

/* In OpenGL ES 3.0 and WebGL2. */
#define GL_FUNCTIONS(X)                                                                                                \
    X(PFNGLACTIVETEXTUREPROC, ActiveTexture)                                                                           \
    X(PFNGLATTACHSHADERPROC, AttachShader)                                                                             \
    X(PFNGLBINDBUFFERPROC, BindBuffer)                                                                                 \
    X(PFNGLBINDFRAMEBUFFERPROC, BindFramebuffer)                                                                       \
    X(PFNGLBINDSAMPLERPROC, BindSampler)                                                                               \
    X(PFNGLBINDTEXTUREPROC, BindTexture)                                                                               \
    X(PFNGLBINDVERTEXARRAYPROC, BindVertexArray)                                                                       \
    X(PFNGLBLENDEQUATIONSEPARATEPROC, BlendEquationSeparate)                                                           \
    X(PFNGLBLENDFUNCSEPARATEPROC, BlendFuncSeparate)                                                                   \
    X(PFNGLCHECKFRAMEBUFFERSTATUSPROC, CheckFramebufferStatus)                                                         \
    X(PFNGLCLEARBUFFERFVPROC, ClearBufferfv)                                                                           \
    X(PFNGLCOLORMASKPROC, ColorMask)                                                                                   \
    X(PFNGLCOMPILESHADERPROC, CompileShader)                                                                           \
    X(PFNGLCREATEPROGRAMPROC, CreateProgram)                                                                           \
    X(PFNGLCREATESHADERPROC, CreateShader)                                                                             \
    X(PFNGLDELETEFRAMEBUFFERSPROC, DeleteFramebuffers)                                                                 \
    X(PFNGLDELETEPROGRAMPROC, DeleteProgram)                                                                           \
    X(PFNGLDELETESAMPLERSPROC, DeleteSamplers)                                                                         \
    X(PFNGLDELETESHADERPROC, DeleteShader)                                                                             \
    X(PFNGLDELETETEXTURESPROC, DeleteTextures)                                                                         \
    X(PFNGLDELETEVERTEXARRAYSPROC, DeleteVertexArrays)                                                                 \
    X(PFNGLDISABLEPROC, Disable)                                                                                       \
    X(PFNGLDRAWARRAYSPROC, DrawArrays)                                                                                 \
    X(PFNGLDRAWARRAYSINSTANCEDPROC, DrawArraysInstanced)                                                               \
    X(PFNGLDRAWBUFFERSPROC, DrawBuffers)                                                                               \
    X(PFNGLENABLEPROC, Enable)                                                                                         \
    X(PFNGLFRAMEBUFFERTEXTURE2DPROC, FramebufferTexture2D)                                                             \
    X(PFNGLGENFRAMEBUFFERSPROC, GenFramebuffers)                                                                       \
    X(PFNGLGENSAMPLERSPROC, GenSamplers)                                                                               \
    X(PFNGLGENTEXTURESPROC, GenTextures)                                                                               \
    X(PFNGLGENVERTEXARRAYSPROC, GenVertexArrays)                                                                       \
    X(PFNGLGETBOOLEANVPROC, GetBooleanv)                                                                               \
    X(PFNGLGETERRORPROC, GetError)                                                                                     \
    X(PFNGLGETFRAMEBUFFERATTACHMENTPARAMETERIVPROC, GetFramebufferAttachmentParameteriv)                               \
    X(PFNGLGETINTEGERVPROC, GetIntegerv)                                                                               \
    X(PFNGLGETINTEGERI_VPROC, GetIntegeri_v)                                                                           \
    X(PFNGLGETPROGRAMINFOLOGPROC, GetProgramInfoLog)                                                                   \
    X(PFNGLGETPROGRAMIVPROC, GetProgramiv)                                                                             \
    X(PFNGLGETSHADERINFOLOGPROC, GetShaderInfoLog)                                                                     \
    X(PFNGLGETSHADERIVPROC, GetShaderiv)                                                                               \
    X(PFNGLGETSTRINGPROC, GetString)                                                                                   \
    X(PFNGLGETSTRINGIPROC, GetStringi)                                                                                 \
    X(PFNGLGETUNIFORMLOCATIONPROC, GetUniformLocation)                                                                 \
    X(PFNGLISENABLEDPROC, IsEnabled)                                                                                   \
    X(PFNGLISTEXTUREPROC, IsTexture)                                                                                   \
    X(PFNGLLINKPROGRAMPROC, LinkProgram)                                                                               \
    X(PFNGLPIXELSTOREIPROC, PixelStorei)                                                                               \
    X(PFNGLREADPIXELSPROC, ReadPixels)                                                                                 \
    X(PFNGLSAMPLERPARAMETERIPROC, SamplerParameteri)                                                                   \
    X(PFNGLSHADERSOURCEPROC, ShaderSource)                                                                             \
    X(PFNGLTEXSTORAGE2DPROC, TexStorage2D)                                                                             \
    X(PFNGLTEXSUBIMAGE2DPROC, TexSubImage2D)                                                                           \
    X(PFNGLUNIFORM1FPROC, Uniform1f)                                                                                   \
    X(PFNGLUNIFORM1IPROC, Uniform1i)                                                                                   \
    X(PFNGLUNIFORM2FPROC, Uniform2f)                                                                                   \
    X(PFNGLUNIFORM2IPROC, Uniform2i)                                                                                   \
    X(PFNGLUNIFORM3FPROC, Uniform3f)                                                                                   \
    X(PFNGLUNIFORM4FPROC, Uniform4f)                                                                                   \
    X(PFNGLUNIFORM4IVPROC, Uniform4iv)                                                                                 \
    X(PFNGLUSEPROGRAMPROC, UseProgram)                                                                                 \
    X(PFNGLVIEWPORTPROC, Viewport)

typedef struct gl_functions {
#define MEMBER(type, name) type name;
    GL_FUNCTIONS(MEMBER)
#undef MEMBER
    /* Where there are any, else NULL: of ES 3.1, ES 3.2 and the robustness extensions. */
    void(GL_APIENTRY *GetTexLevelParameteriv)(GLenum target, GLint level, GLenum name, GLint *value);
    void(GL_APIENTRY *Enablei)(GLenum cap, GLuint index);
    void(GL_APIENTRY *Disablei)(GLenum cap, GLuint index);
    GLboolean(GL_APIENTRY *IsEnabledi)(GLenum cap, GLuint index);
    void(GL_APIENTRY *ColorMaski)(GLuint index, GLboolean r, GLboolean g, GLboolean b, GLboolean a);
    void(GL_APIENTRY *GetBooleani_v)(GLenum name, GLuint index, GLboolean *value);
    void(GL_APIENTRY *BlendFuncSeparatei)(GLuint index, GLenum from, GLenum to, GLenum from_alpha, GLenum to_alpha);
    void(GL_APIENTRY *BlendEquationSeparatei)(GLuint index, GLenum rgb, GLenum alpha);
    GLenum(GL_APIENTRY *GetGraphicsResetStatus)(void);
} gl_functions;

/* Loads all; NULL, or the name of one that is missing. */
const char *gl_functions_load(gl_functions *f, const ddof_gl_config *config);

/* Loads those that a context of this version may have beyond ES 3.0. */
void gl_functions_load_later(gl_functions *f, const ddof_gl_config *config, int version);

#endif
