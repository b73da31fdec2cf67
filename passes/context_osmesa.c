// SPDX-License-Identifier: BSD-3-Clause
#include "passes/context_backend.h"

#include <stdio.h>
#include <stdlib.h>

#include <GL/osmesa.h>

// Rendering goes to framebuffer objects; OSMesa only wants some default buffer to be current with.
enum { BUFFER_SIZE = 16 };

struct osmesa {
    OSMesaContext context;
    unsigned char buffer[4 * BUFFER_SIZE * BUFFER_SIZE];
};

static bool osmesa_create(void **native, char *why, size_t why_size)
{
    static const int attributes[] = {OSMESA_FORMAT,
                                     OSMESA_RGBA,
                                     OSMESA_PROFILE,
                                     OSMESA_CORE_PROFILE,
                                     OSMESA_CONTEXT_MAJOR_VERSION,
                                     3,
                                     OSMESA_CONTEXT_MINOR_VERSION,
                                     3,
                                     0};
    struct osmesa *osmesa = calloc(1, sizeof *osmesa);
    if (!osmesa) {
        snprintf(why, why_size, "out of memory");
        return false;
    }
    osmesa->context = OSMesaCreateContextAttribs(attributes, NULL);
    if (!osmesa->context) {
        snprintf(why, why_size, "no core 3.3 context");
        free(osmesa);
        return false;
    }
    *native = osmesa;
    return true;
}

static void osmesa_destroy(void *native)
{
    struct osmesa *osmesa = native;
    OSMesaDestroyContext(osmesa->context);
    free(osmesa);
}

static bool osmesa_make_current(void *native)
{
    struct osmesa *osmesa = native;
    return OSMesaMakeCurrent(osmesa->context, osmesa->buffer, GL_UNSIGNED_BYTE, BUFFER_SIZE,
                             BUFFER_SIZE);
}

static void osmesa_release(void *native)
{
    (void)native;
    OSMesaMakeCurrent(NULL, NULL, 0, 0, 0);
}

const struct weft_context_backend weft_backend_osmesa = {
    .platform = "OSMesa",
    .create = osmesa_create,
    .destroy = osmesa_destroy,
    .make_current = osmesa_make_current,
    .release = osmesa_release,
    .function = (GLADapiproc(*)(const char *))OSMesaGetProcAddress,
};
