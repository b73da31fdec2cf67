// SPDX-License-Identifier: BSD-3-Clause
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "passes/context_backend.h"

struct egl {
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

// A surfaceless core context on an initialised display.
static bool create_on(EGLDisplay display, struct egl *egl, char *why, size_t why_size)
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
    const char *extensions = eglQueryString(display, EGL_EXTENSIONS);
    if (!has_extension(extensions, "EGL_KHR_surfaceless_context")) {
        snprintf(why, why_size, "EGL_KHR_surfaceless_context is missing");
        return false;
    }
    EGLConfig config = NULL;
    EGLint count = 0;
    if (!has_extension(extensions, "EGL_KHR_no_config_context") &&
        (!eglChooseConfig(display, config_attributes, &config, 1, &count) || count == 0)) {
        snprintf(why, why_size, "no OpenGL configuration");
        return false;
    }
    if (!eglBindAPI(EGL_OPENGL_API)) {
        snprintf(why, why_size, "no OpenGL in EGL (0x%04x)", (unsigned)eglGetError());
        return false;
    }
    EGLContext context = eglCreateContext(display, config, EGL_NO_CONTEXT, attributes);
    if (context == EGL_NO_CONTEXT) {
        snprintf(why, why_size, "no core 3.3 context (0x%04x)", (unsigned)eglGetError());
        return false;
    }
    *egl = (struct egl){.display = display, .context = context};
    return true;
}

// Initialises a platform's display and creates a context on it; leaves nothing behind on failure.
static bool create_platform(EGLenum platform, void *device, struct egl *egl, char *why,
                            size_t why_size)
{
    PFNEGLGETPLATFORMDISPLAYEXTPROC get_display =
        (PFNEGLGETPLATFORMDISPLAYEXTPROC)eglGetProcAddress("eglGetPlatformDisplayEXT");
    EGLDisplay display = get_display ? get_display(platform, device, NULL) : EGL_NO_DISPLAY;
    if (display == EGL_NO_DISPLAY) {
        snprintf(why, why_size, "no display (0x%04x)", (unsigned)eglGetError());
        return false;
    }
    if (!eglInitialize(display, NULL, NULL)) {
        snprintf(why, why_size, "the display cannot be initialised (0x%04x)",
                 (unsigned)eglGetError());
        return false;
    }
    // eglTerminate is never called: it would end the display for every other context on it.
    return create_on(display, egl, why, why_size);
}

// A context on the first device that is no software rasterizer.
static bool create_device(struct egl *egl, char *why, size_t why_size)
{
    enum { MAX_DEVICES = 16 };
    PFNEGLQUERYDEVICESEXTPROC query_devices =
        (PFNEGLQUERYDEVICESEXTPROC)eglGetProcAddress("eglQueryDevicesEXT");
    PFNEGLQUERYDEVICESTRINGEXTPROC query_string =
        (PFNEGLQUERYDEVICESTRINGEXTPROC)eglGetProcAddress("eglQueryDeviceStringEXT");
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

static bool create(void **native, bool device, char *why, size_t why_size)
{
    struct egl *egl = calloc(1, sizeof *egl);
    if (!egl) {
        snprintf(why, why_size, "out of memory");
        return false;
    }
    bool done = device ? create_device(egl, why, why_size)
                       : create_platform(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, egl,
                                         why, why_size);
    if (!done) {
        free(egl);
        return false;
    }
    *native = egl;
    return true;
}

static bool egl_device_create(void **native, char *why, size_t why_size)
{
    return create(native, true, why, why_size);
}

static bool egl_surfaceless_create(void **native, char *why, size_t why_size)
{
    return create(native, false, why, why_size);
}

static void egl_destroy(void *native)
{
    struct egl *egl = native;
    eglDestroyContext(egl->display, egl->context);
    free(egl);
}

static bool egl_make_current(void *native)
{
    struct egl *egl = native;
    // The API is bound per thread, and eglMakeCurrent(NO_CONTEXT) unbinds only that API's context.
    return eglBindAPI(EGL_OPENGL_API) &&
           eglMakeCurrent(egl->display, EGL_NO_SURFACE, EGL_NO_SURFACE, egl->context);
}

static void egl_release(void *native)
{
    struct egl *egl = native;
    eglMakeCurrent(egl->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
}

const struct weft_context_backend weft_backend_egl_device = {
    .platform = "EGL device",
    .create = egl_device_create,
    .destroy = egl_destroy,
    .make_current = egl_make_current,
    .release = egl_release,
    .function = eglGetProcAddress,
    .hardware_only = true,
};

const struct weft_context_backend weft_backend_egl_surfaceless = {
    .platform = "EGL surfaceless",
    .create = egl_surfaceless_create,
    .destroy = egl_destroy,
    .make_current = egl_make_current,
    .release = egl_release,
    .function = eglGetProcAddress,
};
