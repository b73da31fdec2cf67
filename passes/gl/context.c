// SPDX-License-Identifier: BSD-3-Clause
#include "passes/gl/context.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"
#include "filter/closest.h"
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

const char *const weft_context_kind_names[] = {
    [WEFT_CONTEXT_AUTO] = "auto",
    [WEFT_CONTEXT_OSMESA] = "osmesa",
    [WEFT_CONTEXT_EGL] = "egl",
    NULL,
};

enum weft_result weft_context_check(const struct weft_context_params *p)
{
    const struct weft_context_caller *c = &p->caller;
    weft_require_enum(p->log, p->kind, WEFT_CONTEXT_EGL);
    weft_require(p->log, c->get_proc_address || (!c->make_current && !c->release));
    weft_require(p->log, !c->get_proc_address || (p->kind == WEFT_CONTEXT_AUTO && !p->egl_display));
    weft_require(p->log, !p->egl_display || p->kind != WEFT_CONTEXT_OSMESA);
    weft_require(p->log, !p->egl_share || p->egl_display);
    return WEFT_OK;
fail:
    return WEFT_ERR_ARGUMENT;
}

// Tries it, and tells of success. On failure *why has the reason.
static bool try_backend(weft_context *context, const struct weft_context_backend *backend,
                        char *why, size_t why_size)
{
    context->backend = backend;
    if (!weft_context_start(context, why, why_size))
        return false;
    weft_debug(context->log, "GL context: %s, %s, %s", context->info.platform,
               context->info.renderer, context->info.version);
    return true;
}

// What the caller has or nothing.
static enum weft_result create_callers(const struct weft_context_params *params,
                                       weft_context *context)
{
    char why[200] = "";
    const struct weft_context_backend *backend = &weft_backend_caller;
#ifdef WEFT_HAVE_EGL
    if (params->egl_display)
        backend = params->egl_share ? &weft_backend_egl_share : &weft_backend_egl_display;
#else
    if (params->egl_display) {
        weft_error(params->log, "no usable GL context: EGL is not built in");
        return WEFT_ERR_CONTEXT;
    }
#endif
    if (try_backend(context, backend, why, sizeof why))
        return WEFT_OK;
    weft_error(params->log, "no usable GL context (%s): %s", backend->platform, why);
    return WEFT_ERR_CONTEXT;
}

static enum weft_result create_own(const struct weft_context_params *params, weft_context *context)
{
    char reasons[768] = "none is built in";
    size_t used = 0;
    for (size_t i = 0; i < WEFT_COUNT(backends); i++) {
        if ((params->kind == WEFT_CONTEXT_OSMESA && !backends[i].in_osmesa) ||
            (params->kind == WEFT_CONTEXT_EGL && !backends[i].in_egl))
            continue;
        char why[200] = "";
        if (weft_context_trial(backends[i].backend, why, sizeof why) &&
            try_backend(context, backends[i].backend, why, sizeof why))
            return WEFT_OK;
        if (used < sizeof reasons)
            used += (size_t)snprintf(reasons + used, sizeof reasons - used, "%s%s: %s",
                                     used ? "; " : "", backends[i].backend->platform, why);
    }
    char reason[200] = "";
    const bool feared = weft_context_trial_reason(reason, sizeof reason);
    weft_error(params->log, "no usable GL context (%s%s%s): %s",
               weft_context_kind_names[params->kind], feared ? ", with " : "", reason, reasons);
    return WEFT_ERR_CONTEXT;
}

enum weft_result weft_context_create(const struct weft_context_params *params, weft_context **out)
{
    *out = NULL;
    enum weft_result res = weft_context_check(params);
    if (res != WEFT_OK)
        return res;
    struct weft_context *context = calloc(1, sizeof *context);
    if (!context) {
        weft_error(params->log, "not enough memory for a GL context");
        return WEFT_ERR_MEMORY;
    }
    context->log = params->log;
    context->caller = params->caller;
    context->request = (struct weft_native_request){
        .display = params->egl_display, .share = params->egl_share, .caller = &context->caller};
    res = params->egl_display || params->caller.get_proc_address ? create_callers(params, context)
                                                                 : create_own(params, context);
    if (res == WEFT_OK)
        *out = context;
    else
        free(context);
    return res;
}

void weft_context_destroy(weft_context **context)
{
    if (!context || !*context)
        return;
    weft_context_stop(*context);
    for (size_t i = 0; i < (*context)->program_count; i++)
        free((*context)->programs[i].key);
    free((*context)->programs);
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
    for (size_t i = 0; weft_context_kind_names[i]; i++) {
        if (strcmp(text, weft_context_kind_names[i]) == 0) {
            *out = (enum weft_context_kind)i;
            return WEFT_OK;
        }
    }
    char explanation[128];
    weft_error(log, "no context '%.64s'%s", text,
               weft_closest_explain(text, strlen(text), weft_context_kind_names, explanation,
                                    sizeof explanation));
    return WEFT_ERR_ARGUMENT;
}
