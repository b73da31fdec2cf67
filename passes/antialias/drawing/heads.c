// SPDX-License-Identifier: BSD-3-Clause
#include <string.h>

#include "passes/antialias/drawing/run.h"

const char weft_head_depth[] = WEFT_HEAD_33 "void weft_write(vec4 colour, uint surface)\n"
                                            "{\n"
                                            "}\n";

#define WRITE_COLOUR                                                                               \
    "layout(location = 0) out vec4 weft_colour;\n"                                                 \
    "void weft_write(vec4 colour, uint surface)\n"                                                 \
    "{\n"                                                                                          \
    "    weft_colour = colour;\n"                                                                  \
    "}\n"

const char *weft_head_colour(const GladGLContext *gl, bool in_middle)
{
    return in_middle && gl->VERSION_4_0 ? WEFT_HEAD_40 WRITE_COLOUR : WEFT_HEAD_33 WRITE_COLOUR;
}

bool weft_drawing_has_extension(const GladGLContext *gl, const char *name)
{
    GLint count = 0;
    gl->GetIntegerv(GL_NUM_EXTENSIONS, &count);
    for (GLint i = 0; i < count; i++) {
        const char *extension = (const char *)gl->GetStringi(GL_EXTENSIONS, (GLuint)i);
        if (extension && strcmp(extension, name) == 0)
            return true;
    }
    return false;
}
