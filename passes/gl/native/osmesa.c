// SPDX-License-Identifier: BSD-3-Clause
#include "passes/gl/native/native.h"

#include <stdio.h>
#include <stdlib.h>

#include <GL/osmesa.h>

// Rendering goes to framebuffer objects; OSMesa only wants some default buffer to be current with.
enum { BUFFER_SIZE = 16 };

#define FUNCTIONS(F)                                                                               \
    F(CreateContextAttribs)                                                                        \
    F(DestroyContext)                                                                              \
    F(MakeCurrent)                                                                                 \
    F(GetCurrentContext)                                                                           \
    F(GetColorBuffer)                                                                              \
    F(GetIntegerv)                                                                                 \
    F(GetProcAddress)

struct functions {
#define DECLARE(name) __typeof__(&OSMesa##name) name;
    FUNCTIONS(DECLARE)
#undef DECLARE
};

#define NAME(name) "OSMesa" #name,
static const struct weft_library library = {
    .names = (const char *const[]){"libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so", NULL},
    .functions = (const char *const[]){FUNCTIONS(NAME) NULL},
};
#undef NAME

struct osmesa {
    struct functions call;
    OSMesaContext context;
    unsigned char buffer[4 * BUFFER_SIZE * BUFFER_SIZE];
};

static bool osmesa_create(const struct weft_native_request *request, void **native, char *why,
                          size_t why_size)
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
    (void)request;
    if (!osmesa) {
        snprintf(why, why_size, "out of memory");
        return false;
    }
    if (weft_library_load(&library, &osmesa->call, why, why_size)) {
        osmesa->context = osmesa->call.CreateContextAttribs(attributes, NULL);
        if (!osmesa->context)
            snprintf(why, why_size, "no core 3.3 context");
    }
    if (!osmesa->context) {
        free(osmesa);
        return false;
    }
    *native = osmesa;
    return true;
}

static void osmesa_destroy(void *native)
{
    struct osmesa *osmesa = native;
    osmesa->call.DestroyContext(osmesa->context);
    free(osmesa);
}

static bool osmesa_make_current(void *native)
{
    struct osmesa *osmesa = native;
    return osmesa->call.MakeCurrent(osmesa->context, osmesa->buffer, GL_UNSIGNED_BYTE, BUFFER_SIZE,
                                    BUFFER_SIZE);
}

static void osmesa_release(void *native)
{
    struct osmesa *osmesa = native;
    osmesa->call.MakeCurrent(NULL, NULL, 0, 0, 0);
}

static GLADapiproc osmesa_function(void *native, const char *name)
{
    struct osmesa *osmesa = native;
    return (GLADapiproc)osmesa->call.GetProcAddress(name);
}

void weft_osmesa_take(struct weft_osmesa_current *out)
{
    struct functions call;
    GLint format = 0;
    *out = (struct weft_osmesa_current){.context = NULL};
    if (!weft_library_loaded(&library, &call) || !(out->context = call.GetCurrentContext()))
        return;
    call.GetIntegerv(OSMESA_TYPE, &out->type);
    call.GetColorBuffer(out->context, &out->width, &out->height, &format, &out->buffer);
    call.MakeCurrent(NULL, NULL, 0, 0, 0);
}

void weft_osmesa_give_back(const struct weft_osmesa_current *current)
{
    struct functions call;
    if (current->context && weft_library_loaded(&library, &call))
        call.MakeCurrent(current->context, current->buffer, (GLenum)current->type, current->width,
                         current->height);
}

const struct weft_context_backend weft_backend_osmesa = {
    .platform = "OSMesa",
    .library = &library,
    .create = osmesa_create,
    .destroy = osmesa_destroy,
    .make_current = osmesa_make_current,
    .release = osmesa_release,
    .function = osmesa_function,
};
