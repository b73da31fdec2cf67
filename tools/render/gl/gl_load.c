// SPDX-License-Identifier: BSD-3-Clause
// The generated loader, compiled as a part of this file: none of its names is a symbol of ours.
#define GLAD_API_CALL static
#include "tools/render/gl/gl.h"

#include "src/gl.c"

static GLADapiproc find(void *context, const char *name)
{
    return (GLADapiproc)weft_context_find_function(context, name);
}

bool scene_gl_load(GladGLContext *gl, const weft_context *context)
{
    return gladLoadGLContextUserPtr(gl, find, (void *)context) != 0 && gl->VERSION_3_3;
}
