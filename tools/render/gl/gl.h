// SPDX-License-Identifier: BSD-3-Clause
// tools/render/gl/gl.h - the functions of OpenGL, as an application gets them.
#ifndef WEFT_TOOLS_RENDER_GL_GL_H
#define WEFT_TOOLS_RENDER_GL_GL_H

#include <glad/gl.h>

#include "weft.h"

// Fills the table from the context, which is current (weft_context_call). false: it lacks 3.3.
bool scene_gl_load(GladGLContext *gl, const weft_context *context);

#endif
