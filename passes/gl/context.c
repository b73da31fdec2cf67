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

const char *const weft_context_kind_names[] = {
    [WEFT_CONTEXT_AUTO] = "auto",
    [WEFT_CONTEXT_OSMESA] = "osmesa",
    [WEFT_CONTEXT_EGL] = "egl",
    NULL,
};

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
    weft_error(params->log, "no usable GL context (%s%s%s): %s",
               weft_context_kind_names[params->kind], feared ? ", with " : "", reason, reasons);
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
    for (size_t i = 0; i < (*context)->program_count; i++)
        free((*context)->programs[i].key);
    free((*context)->programs);
    weft_context_stop(*context);
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
    weft_error(log, "unknown context '%.64s'; there are: %s, %s, %s", text,
               weft_context_kind_names[WEFT_CONTEXT_AUTO],
               weft_context_kind_names[WEFT_CONTEXT_OSMESA],
               weft_context_kind_names[WEFT_CONTEXT_EGL]);
    return WEFT_ERR_ARGUMENT;
}
