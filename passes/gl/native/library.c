// SPDX-License-Identifier: BSD-3-Clause
#include "passes/gl/native/native.h"

#include <dlfcn.h>
#include <stdio.h>
#include <string.h>

static void *open_library(const struct weft_library *library, int mode)
{
    void *handle = NULL;
    for (size_t i = 0; !handle && library->names[i]; i++)
        handle = dlopen(library->names[i], RTLD_LAZY | RTLD_LOCAL | mode);
    return handle;
}

static bool find_functions(const struct weft_library *library, void *handle, void *functions)
{
    for (size_t i = 0; library->functions[i]; i++) {
        void *function = dlsym(handle, library->functions[i]);
        if (!function)
            return false;
        memcpy((void **)functions + i, &function, sizeof function);
    }
    return true;
}

bool weft_library_load(const struct weft_library *library, void *functions, char *why,
                       size_t why_size)
{
    // It is never closed: Mesa leaves threads and thread-local data behind.
    void *handle = open_library(library, 0);
    if (!handle) {
        const char *error = dlerror();
        snprintf(why, why_size, "%s", error ? error : library->names[0]);
        return false;
    }
    if (find_functions(library, handle, functions))
        return true;
    snprintf(why, why_size, "%s lacks functions", library->names[0]);
    return false;
}

bool weft_library_loaded(const struct weft_library *library, void *functions)
{
    void *handle = open_library(library, RTLD_NOLOAD);
    if (!handle)
        return false;
    const bool found = !functions || find_functions(library, handle, functions);
    dlclose(handle);
    return found;
}
