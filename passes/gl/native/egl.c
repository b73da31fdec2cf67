// SPDX-License-Identifier: BSD-3-Clause
#include "passes/gl/native/native.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <EGL/egl.h>
#include <EGL/eglext.h>

#define FUNCTIONS(F)                                                                               \
    F(BindAPI)                                                                                     \
    F(ChooseConfig)                                                                                \
    F(CreateContext)                                                                               \
    F(DestroyContext)                                                                              \
    F(GetCurrentContext)                                                                           \
    F(GetCurrentDisplay)                                                                           \
    F(GetCurrentSurface)                                                                           \
    F(GetError)                                                                                    \
    F(GetProcAddress)                                                                              \
    F(Initialize)                                                                                  \
    F(MakeCurrent)                                                                                 \
    F(QueryAPI)                                                                                    \
    F(QueryContext)                                                                                \
    F(QueryString)                                                                                 \
    F(WaitClient)

struct functions {
#define DECLARE(name) __typeof__(&egl##name) name;
    FUNCTIONS(DECLARE)
#undef DECLARE
};

#define NAME(name) "egl" #name,
static const struct weft_library library = {
    .names = (const char *const[]){"libEGL.so.1", "libEGL.so", NULL},
    .functions = (const char *const[]){FUNCTIONS(NAME) NULL},
};
#undef NAME

struct egl {
    struct functions call;
    EGLDisplay display;
    EGLContext context;
};

static bool has_extension(const char *list, const char *name)
{
    size_t length = strlen(name);
    for (const char *at = list; at && (at = strstr(at, name)); at += length)
        if ((at == list || at[-1] == ' ') && (at[length] == ' ' || at[length] == '\0'))
            return true;
    return false;
}

// A surfaceless core context on an initialised display, which shares the objects of another one.
static bool create_on(EGLDisplay display, EGLContext share, struct egl *egl, char *why,
                      size_t why_size)
{
    static const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                                        3,
                                        EGL_CONTEXT_MINOR_VERSION,
                                        3,
                                        EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                        EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                        EGL_NONE};
    static const EGLint config_attributes[] = {EGL_SURFACE_TYPE, EGL_DONT_CARE, EGL_RENDERABLE_TYPE,
                                               EGL_OPENGL_BIT, EGL_NONE};
    const char *extensions = egl->call.QueryString(display, EGL_EXTENSIONS);
    if (!has_extension(extensions, "EGL_KHR_surfaceless_context")) {
        snprintf(why, why_size, "EGL_KHR_surfaceless_context is missing");
        return false;
    }
    EGLConfig config = NULL;
    EGLint count = 0;
    if (!has_extension(extensions, "EGL_KHR_no_config_context") &&
        (!egl->call.ChooseConfig(display, config_attributes, &config, 1, &count) || count == 0)) {
        snprintf(why, why_size, "no OpenGL configuration");
        return false;
    }
    if (!egl->call.BindAPI(EGL_OPENGL_API)) {
        snprintf(why, why_size, "no OpenGL in EGL (0x%04x)", (unsigned)egl->call.GetError());
        return false;
    }
    EGLContext context = egl->call.CreateContext(display, config, share, attributes);
    if (context == EGL_NO_CONTEXT) {
        snprintf(why, why_size, "no core 3.3 context%s (0x%04x)",
                 share ? " that shares the caller's objects" : "", (unsigned)egl->call.GetError());
        return false;
    }
    egl->display = display;
    egl->context = context;
    return true;
}

// Initialises a platform's display and creates a context on it; leaves nothing behind on failure.
static bool create_platform(EGLenum platform, void *device, struct egl *egl, char *why,
                            size_t why_size)
{
    PFNEGLGETPLATFORMDISPLAYEXTPROC get_display =
        (PFNEGLGETPLATFORMDISPLAYEXTPROC)egl->call.GetProcAddress("eglGetPlatformDisplayEXT");
    EGLDisplay display = get_display ? get_display(platform, device, NULL) : EGL_NO_DISPLAY;
    if (display == EGL_NO_DISPLAY) {
        snprintf(why, why_size, "no display (0x%04x)", (unsigned)egl->call.GetError());
        return false;
    }
    if (!egl->call.Initialize(display, NULL, NULL)) {
        snprintf(why, why_size, "the display cannot be initialised (0x%04x)",
                 (unsigned)egl->call.GetError());
        return false;
    }
    // eglTerminate is never called: it would end the display for every other context on it.
    return create_on(display, EGL_NO_CONTEXT, egl, why, why_size);
}

// A context on the first device that is no software rasterizer.
static bool create_device(struct egl *egl, char *why, size_t why_size)
{
    enum { MAX_DEVICES = 16 };
    PFNEGLQUERYDEVICESEXTPROC query_devices =
        (PFNEGLQUERYDEVICESEXTPROC)egl->call.GetProcAddress("eglQueryDevicesEXT");
    PFNEGLQUERYDEVICESTRINGEXTPROC query_string =
        (PFNEGLQUERYDEVICESTRINGEXTPROC)egl->call.GetProcAddress("eglQueryDeviceStringEXT");
    EGLDeviceEXT devices[MAX_DEVICES];
    EGLint count = 0;
    if (!query_devices || !query_string || !query_devices(MAX_DEVICES, devices, &count)) {
        snprintf(why, why_size, "devices cannot be listed");
        return false;
    }
    snprintf(why, why_size, "no hardware device");
    for (EGLint i = 0; i < count; i++) {
        const char *extensions = query_string(devices[i], EGL_EXTENSIONS);
        if (has_extension(extensions, "EGL_MESA_device_software"))
            continue;
        if (create_platform(EGL_PLATFORM_DEVICE_EXT, devices[i], egl, why, why_size))
            return true;
    }
    return false;
}

// A context on a caller's display, and in the share group of a context there, if one is given.
static bool create_callers(const struct weft_native_request *request, struct egl *egl, char *why,
                           size_t why_size)
{
    EGLint api = EGL_OPENGL_API;
    if (!egl->call.QueryString(request->display, EGL_VERSION)) {
        snprintf(why, why_size, "the display is none, or not initialised (0x%04x)",
                 (unsigned)egl->call.GetError());
        return false;
    }
    if (request->share &&
        !egl->call.QueryContext(request->display, request->share, EGL_CONTEXT_CLIENT_TYPE, &api)) {
        snprintf(why, why_size, "the share context is none of the display's (0x%04x)",
                 (unsigned)egl->call.GetError());
        return false;
    }
    if (api != EGL_OPENGL_API) {
        snprintf(why, why_size, "the share context is of API 0x%04x, not OpenGL (0x%04x)",
                 (unsigned)api, EGL_OPENGL_API);
        return false;
    }
    return create_on(request->display, request->share ? request->share : EGL_NO_CONTEXT, egl, why,
                     why_size);
}

static bool create(const struct weft_native_request *request, bool device, void **native, char *why,
                   size_t why_size)
{
    struct egl *egl = calloc(1, sizeof *egl);
    if (!egl) {
        snprintf(why, why_size, "out of memory");
        return false;
    }
    bool done = weft_library_load(&library, &egl->call, why, why_size) &&
                (request->display ? create_callers(request, egl, why, why_size)
                 : device         ? create_device(egl, why, why_size)
                          : create_platform(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, egl,
                                            why, why_size));
    if (!done) {
        free(egl);
        return false;
    }
    *native = egl;
    return true;
}

static bool egl_device_create(const struct weft_native_request *request, void **native, char *why,
                              size_t why_size)
{
    return create(request, true, native, why, why_size);
}

static bool egl_create(const struct weft_native_request *request, void **native, char *why,
                       size_t why_size)
{
    return create(request, false, native, why, why_size);
}

static void egl_destroy(void *native)
{
    struct egl *egl = native;
    egl->call.DestroyContext(egl->display, egl->context);
    free(egl);
}

static bool egl_make_current(void *native)
{
    struct egl *egl = native;
    // The API is bound per thread, and egl->call.MakeCurrent(NO_CONTEXT) unbinds only that API's
    // context.
    return egl->call.BindAPI(EGL_OPENGL_API) &&
           egl->call.MakeCurrent(egl->display, EGL_NO_SURFACE, EGL_NO_SURFACE, egl->context);
}

static void egl_release(void *native)
{
    struct egl *egl = native;
    egl->call.MakeCurrent(egl->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
}

static GLADapiproc egl_function(void *native, const char *name)
{
    struct egl *egl = native;
    return egl->call.GetProcAddress(name);
}

void weft_egl_take(const void *awaited, struct weft_egl_current *out)
{
    struct functions call;
    *out = (struct weft_egl_current){.api = EGL_OPENGL_ES_API}; // of a thread without EGL so far
    if (!weft_library_loaded(&library, &call))
        return;
    out->api = call.QueryAPI();
    out->context = call.GetCurrentContext();
    if (!out->context)
        return;
    out->display = call.GetCurrentDisplay();
    out->draw = call.GetCurrentSurface(EGL_DRAW);
    out->read = call.GetCurrentSurface(EGL_READ);
    if (awaited && out->context == awaited)
        call.WaitClient();
    // EGL does nothing about a context that it believes to be current.
    call.MakeCurrent(out->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
}

void weft_egl_give_back(const struct weft_egl_current *current)
{
    struct functions call;
    if (!weft_library_loaded(&library, &call))
        return;
    call.BindAPI(current->api);
    if (current->context)
        call.MakeCurrent(current->display, current->draw, current->read, current->context);
}

const struct weft_context_backend weft_backend_egl_device = {
    .platform = "EGL device",
    .library = &library,
    .create = egl_device_create,
    .destroy = egl_destroy,
    .make_current = egl_make_current,
    .release = egl_release,
    .function = egl_function,
    .hardware_only = true,
};

const struct weft_context_backend weft_backend_egl_surfaceless = {
    .platform = "EGL surfaceless",
    .library = &library,
    .create = egl_create,
    .destroy = egl_destroy,
    .make_current = egl_make_current,
    .release = egl_release,
    .function = egl_function,
};

const struct weft_context_backend weft_backend_egl_display = {
    .platform = "EGL display",
    .library = &library,
    .create = egl_create,
    .destroy = egl_destroy,
    .make_current = egl_make_current,
    .release = egl_release,
    .function = egl_function,
};

const struct weft_context_backend weft_backend_egl_share = {
    .platform = "EGL share group",
    .library = &library,
    .create = egl_create,
    .destroy = egl_destroy,
    .make_current = egl_make_current,
    .release = egl_release,
    .function = egl_function,
    .outlived = true,
};
