// SPDX-License-Identifier: BSD-3-Clause
// Native contexts: made, entered, left and ended, with what the caller had current kept.
#include <stdio.h>
#include <stdlib.h>
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
// A caller's own context is made current and given back by the caller alone.
static void take_callers(struct weft_context *context)
{
    if (context->backend->callers)
        return;
#ifdef WEFT_HAVE_EGL
    weft_egl_take(context->request.share, &context->callers_egl);
#endif
#ifdef WEFT_HAVE_OSMESA
    weft_osmesa_take(&context->callers_osmesa);
#endif
}

static void give_back(struct weft_context *context)
{
    if (context->backend->callers)
        return;
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
    else
        return read_info(context, why, why_size);
    return false;
}

// Errors of the caller's would be taken for weft's.
static void drop_errors(const weft_context *context)
{
    for (int i = 0; i < 8; i++) {
        const GLenum error = context->gl.GetError();
        if (error == GL_NO_ERROR)
            return;
        weft_warn(context->log, "GL: an error of the caller's was pending (0x%04x)", error);
    }
}

// GL draws nothing without a vertex array; what passes draw needs nothing of it. A caller's context
// has it bound in calls only.
static bool make_array(struct weft_context *context, char *why, size_t why_size)
{
    const GladGLContext *gl = &context->gl;
    GLint before = 0;
    if (context->backend->callers) {
        drop_errors(context);
        context->state = weft_gl_state_create(gl, context->backend->function, context->native);
        if (!context->state) {
            snprintf(why, why_size, "there is not enough memory, or no glPixelTransferf");
            return false;
        }
        gl->GetIntegerv(GL_VERTEX_ARRAY_BINDING, &before);
    }
    gl->GenVertexArrays(1, &context->vertex_array);
    gl->BindVertexArray(context->vertex_array);
    if (context->backend->callers)
        gl->BindVertexArray((GLuint)before);
    return true;
}

bool weft_context_start(struct weft_context *context, char *why, size_t why_size)
{
    bool done = false;
    take_callers(context);
    if (!context->backend->create(&context->request, &context->native, why, why_size))
        goto fail;
    if (context->backend->make_current(context->native))
        done = load_functions(context, why, why_size) && make_array(context, why, why_size);
    else
        snprintf(why, why_size, "the context cannot be made current");
    context->backend->release(context->native);
    if (!done) {
        context->backend->destroy(context->native);
        free(context->state);
        context->state = NULL;
        context->native = NULL;
    }
fail:
    give_back(context);
    return done;
}

static void delete_objects(struct weft_context *context)
{
    for (size_t i = 0; i < context->program_count; i++)
        context->gl.DeleteProgram(context->programs[i].program);
    context->gl.UseProgram(0); // nothing is in use that was deleted
    context->gl.DeleteVertexArrays(1, &context->vertex_array);
}

void weft_context_stop(struct weft_context *context)
{
    if (context->backend->outlived && weft_context_enter(context) == WEFT_OK) {
        delete_objects(context);
        weft_context_leave(context);
    }
    take_callers(context);
    context->backend->destroy(context->native);
    give_back(context);
    free(context->state);
}

// ---- calls --------------------------------------------------------------------------------------

// A caller's context is looked at, as another one may be current in its place: vertex arrays are no
// one else's. Its state is kept, and made what weft counts on.
static enum weft_result take_over(weft_context *context)
{
    const GladGLContext *gl = &context->gl;
    char why[200] = "another context is current, or none";
    if (gl->IsVertexArray(context->vertex_array)) {
        drop_errors(context);
        if (weft_gl_state_is_free(gl, why, sizeof why)) {
            weft_gl_state_save(gl, context->state);
            weft_gl_reset_state(gl, context->vertex_array);
            return WEFT_OK;
        }
    }
    weft_error(context->log, "GL: the caller's context cannot be used: %s", why);
    return WEFT_ERR_GL;
}

enum weft_result weft_context_enter(weft_context *context)
{
    enum weft_result res = WEFT_OK;
    take_callers(context);
    if (!context->backend->make_current(context->native)) {
        give_back(context);
        weft_error(context->log, "GL: the %s context cannot be made current",
                   context->info.platform);
        return WEFT_ERR_GL;
    }
    if (context->backend->callers)
        res = take_over(context);
    if (res != WEFT_OK)
        context->backend->release(context->native);
    return res;
}

void weft_context_leave(weft_context *context)
{
    if (context->backend->callers)
        weft_gl_state_restore(&context->gl, context->state);
    else if (context->backend->outlived)
        context->gl.Finish(); // others see what is done
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
    res = call(priv);
    const enum weft_result pending = weft_gl_check(context->log, &context->gl, "drawing");
    weft_gl_reset_state(&context->gl, context->vertex_array);
    weft_context_leave(context);
    return res == WEFT_OK ? pending : res;
}

weft_gl_function weft_context_find_function(const weft_context *context, const char *name)
{
    return name ? context->backend->function(context->native, name) : NULL;
}
