// SPDX-License-Identifier: BSD-3-Clause
// A caller's own context, by its callbacks.
#include <stdio.h>
#include <string.h>

#include "filter/check.h"
#include "passes/gl/context_backend.h"

// One function of each version that is needed: loaders that know extensions alone lack them.
static const char *const probes[] = {
    "glGetString",   "glTexSubImage2D", "glTexImage3D",      "glActiveTexture",
    "glBlendColor",  "glBindBuffer",    "glUseProgram",      "glUniformMatrix2x3fv",
    "glBindSampler", "glTexBuffer",     "glBindVertexArray", "glTexImage2DMultisample",
    "glGetIntegerv",
};

static bool caller_make_current(void *native)
{
    const struct weft_context_caller *c = native;
    return !c->make_current || c->make_current(c->priv);
}

static void caller_release(void *native)
{
    const struct weft_context_caller *c = native;
    if (c->release)
        c->release(c->priv);
}

static GLADapiproc caller_function(void *native, const char *name)
{
    const struct weft_context_caller *c = native;
    return c->get_proc_address(c->priv, name);
}

// ---- what it is ---------------------------------------------------------------------------------

// The functions are asked for while the context is current, as some window systems want it.
static bool knows_functions(void *native, char *why, size_t why_size)
{
    for (size_t i = 0; i < WEFT_COUNT(probes); i++) {
        if (caller_function(native, probes[i]))
            continue;
        snprintf(why, why_size, "get_proc_address knows no %s", probes[i]);
        return false;
    }
    return true;
}

static bool is_new_enough(void *native, char *why, size_t why_size)
{
    const PFNGLGETSTRINGPROC get_string =
        (PFNGLGETSTRINGPROC)caller_function(native, "glGetString");
    const char *version = (const char *)get_string(GL_VERSION);
    int major = 0, minor = 0;
    if (!version) {
        snprintf(why, why_size, "no context is current in this thread");
        return false;
    }
    if (strncmp(version, "OpenGL ES", 9) == 0 || sscanf(version, "%d.%d", &major, &minor) != 2 ||
        10 * major + minor < 33) {
        snprintf(why, why_size, "its version is \"%.80s\", and OpenGL 3.3 is needed", version);
        return false;
    }
    return true;
}

static bool caller_create(const struct weft_native_request *request, void **native, char *why,
                          size_t why_size)
{
    *native = (void *)request->caller;
    if (!caller_make_current(*native)) {
        snprintf(why, why_size, "make_current fails");
        return false;
    }
    const bool done =
        knows_functions(*native, why, why_size) && is_new_enough(*native, why, why_size);
    caller_release(*native);
    return done;
}

static void caller_destroy(void *native)
{
    (void)native;
}

const struct weft_context_backend weft_backend_caller = {
    .platform = "caller's",
    .create = caller_create,
    .destroy = caller_destroy,
    .make_current = caller_make_current,
    .release = caller_release,
    .function = caller_function,
    .outlived = true,
    .callers = true,
};
