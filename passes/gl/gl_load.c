// SPDX-License-Identifier: BSD-3-Clause
// The generated loader, compiled as a part of this file: none of its names is a symbol of weft's.
#define GLAD_API_CALL static
#include "passes/gl/gl.h"

#include "src/gl.c"

bool weft_gl_load(GladGLContext *gl, GLADapiproc (*find)(void *priv, const char *name), void *priv)
{
    return gladLoadGLContextUserPtr(gl, find, priv) != 0;
}
