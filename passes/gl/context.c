// SPDX-License-Identifier: BSD-3-Clause
#include "passes/gl/context.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"
#include "passes/gl/context_backend.h"

// In the order in which they are tried; a device of EGL counts only when it is hardware.
static const struct {
    const struct weft_context_backend *backend;
    bool in_osmesa, in_egl;
} backends[] = {
#ifdef WEFT_HAVE_EGL
    {&weft_backend_egl_device, false, true},
#endif
#ifdef WEFT_HAVE_OSMESA
    {&weft_backend_osmesa, true, false},
#endif
#ifdef WEFT_HAVE_EGL
    {&weft_backend_egl_surfaceless, false, true},
#endif
};

static const char *const kind_names[] = {"auto", "osmesa", "egl"};

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
    else
        return read_info(context, why, why_size);
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

enum weft_result weft_context_create(const struct weft_context_params *params, weft_context **out)
{
    *out = NULL;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    struct weft_context *context = NULL;
    weft_require_enum(params->log, params->kind, WEFT_CONTEXT_EGL);
    res = WEFT_ERR_MEMORY;
    char reasons[768] = "none is built in";
    size_t used = 0;
    context = calloc(1, sizeof *context);
    if (!context)
        goto fail;
    context->log = params->log;
    for (size_t i = 0; i < WEFT_COUNT(backends); i++) {
        if ((params->kind == WEFT_CONTEXT_OSMESA && !backends[i].in_osmesa) ||
            (params->kind == WEFT_CONTEXT_EGL && !backends[i].in_egl))
            continue;
        char why[200] = "";
        context->backend = backends[i].backend;
        if (weft_context_trial(context->backend, why, sizeof why) &&
            weft_context_start(context, why, sizeof why)) {
            weft_debug(context->log, "GL context: %s, %s, %s", context->info.platform,
                       context->info.renderer, context->info.version);
            *out = context;
            return WEFT_OK;
        }
        if (used < sizeof reasons)
            used += (size_t)snprintf(reasons + used, sizeof reasons - used, "%s%s: %s",
                                     used ? "; " : "", context->backend->platform, why);
    }
    char reason[200] = "";
    const bool feared = weft_context_trial_reason(reason, sizeof reason);
    weft_error(params->log, "no usable GL context (%s%s%s): %s", kind_names[params->kind],
               feared ? ", with " : "", reason, reasons);
    res = WEFT_ERR_CONTEXT;
fail:
    free(context);
    return res;
}

void weft_context_destroy(weft_context **context)
{
    if (!context || !*context)
        return;
    // The programs themselves end with the native context.
    for (size_t i = 0; i < WEFT_PROGRAM_CACHE; i++)
        free((*context)->programs[i].key);
    take_callers(*context);
    (*context)->backend->destroy((*context)->native);
    give_back(*context);
    free(*context);
    *context = NULL;
}

const struct weft_context_info *weft_context_get_info(const weft_context *context)
{
    return &context->info;
}

enum weft_result weft_context_kind_parse(const struct weft_log *log, const char *text,
                                         enum weft_context_kind *out)
{
    for (size_t i = 0; i < WEFT_COUNT(kind_names); i++) {
        if (strcmp(text, kind_names[i]) == 0) {
            *out = (enum weft_context_kind)i;
            return WEFT_OK;
        }
    }
    weft_error(log, "unknown context '%.64s'; there are: auto, osmesa, egl", text);
    return WEFT_ERR_ARGUMENT;
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
