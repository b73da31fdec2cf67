// SPDX-License-Identifier: BSD-3-Clause
// Native contexts: made, entered, left and ended, with what the caller had current kept.
#include <stdio.h>
#include <string.h>

#include "filter/check.h"
#include "passes/gl/context_backend.h"

static bool is_software(const char *renderer)
{
    static const char *const names[] = {"llvmpipe", "softpipe", "swrast", "SWR"};
    for (size_t i = 0; i < WEFT_COUNT(names); i++)
        if (strstr(renderer, names[i]))
            return true;
    return false;
}

static bool read_info(struct weft_context *context, char *why, size_t why_size)
{
    const GladGLContext *gl = &context->gl;
    GLint target = 0, texels = 0;
    gl->GetIntegerv(GL_MAX_TEXTURE_SIZE, &target);
    gl->GetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &texels);
    context->info = (struct weft_context_info){
        .platform = context->backend->platform,
        .vendor = (const char *)gl->GetString(GL_VENDOR),
        .renderer = (const char *)gl->GetString(GL_RENDERER),
        .version = (const char *)gl->GetString(GL_VERSION),
        .max_target_size = target,
        .max_buffer_texels = texels,
    };
    const struct weft_context_info *info = &context->info;
    if (!info->vendor || !info->renderer || !info->version || target <= 0 || texels <= 0) {
        snprintf(why, why_size, "the context does not answer");
        return false;
    }
    context->info.hardware = !is_software(info->renderer);
    if (context->backend->hardware_only && !context->info.hardware) {
        snprintf(why, why_size, "only a software renderer (%s)", info->renderer);
        return false;
    }
    return true;
}

// Mesa's libraries share one slot for what is current, so both are asked whatever is made current.
static void take_callers(struct weft_context *context)
{
#ifdef WEFT_HAVE_EGL
    weft_egl_take(&context->callers_egl);
#endif
#ifdef WEFT_HAVE_OSMESA
    weft_osmesa_take(&context->callers_osmesa);
#endif
}

static void give_back(struct weft_context *context)
{
#ifdef WEFT_HAVE_EGL
    weft_egl_give_back(&context->callers_egl);
#endif
#ifdef WEFT_HAVE_OSMESA
    weft_osmesa_give_back(&context->callers_osmesa);
#endif
}

static bool load_functions(struct weft_context *context, char *why, size_t why_size)
{
    if (!weft_gl_load(&context->gl, context->backend->function, context->native))
        snprintf(why, why_size, "the functions of GL cannot be loaded");
    else if (!context->gl.VERSION_3_3)
        snprintf(why, why_size, "GL 3.3 is needed");
    else if (read_info(context, why, why_size)) {
        // GL draws nothing without one; what passes draw needs nothing of it.
        GLuint vertex_array = 0;
        context->gl.GenVertexArrays(1, &vertex_array);
        context->gl.BindVertexArray(vertex_array);
        return true;
    }
    return false;
}

bool weft_context_start(struct weft_context *context, char *why, size_t why_size)
{
    bool done = false;
    take_callers(context);
    if (!context->backend->create(&context->native, why, why_size))
        goto fail;
    if (context->backend->make_current(context->native))
        done = load_functions(context, why, why_size);
    else
        snprintf(why, why_size, "the context cannot be made current");
    context->backend->release(context->native);
    if (!done) {
        context->backend->destroy(context->native);
        context->native = NULL;
    }
fail:
    give_back(context);
    return done;
}

void weft_context_stop(struct weft_context *context)
{
    take_callers(context);
    context->backend->destroy(context->native);
    give_back(context);
}

enum weft_result weft_context_enter(weft_context *context)
{
    take_callers(context);
    if (context->backend->make_current(context->native))
        return WEFT_OK;
    give_back(context);
    weft_error(context->log, "GL: the %s context cannot be made current", context->info.platform);
    return WEFT_ERR_GL;
}

void weft_context_leave(weft_context *context)
{
    context->backend->release(context->native);
    give_back(context);
}

enum weft_result weft_context_call(weft_context *context, enum weft_result (*call)(void *priv),
                                   void *priv)
{
    if (!context || !call)
        return WEFT_ERR_ARGUMENT;
    enum weft_result res = weft_context_enter(context);
    if (res != WEFT_OK)
        return res;
    GLint vertex_array = 0;
    context->gl.GetIntegerv(GL_VERTEX_ARRAY_BINDING, &vertex_array);
    res = call(priv);
    const enum weft_result pending = weft_gl_check(context->log, &context->gl, "drawing");
    weft_gl_reset_state(&context->gl, (GLuint)vertex_array);
    weft_context_leave(context);
    return res == WEFT_OK ? pending : res;
}

weft_gl_function weft_context_find_function(const weft_context *context, const char *name)
{
    return name ? context->backend->function(context->native, name) : NULL;
}
