// SPDX-License-Identifier: BSD-3-Clause
// tests/passes/gl/own_contexts.h - a caller's own contexts, of EGL and OSMesa, with targets of
// 4 x 4 pixels. Include after cmocka.h.
#ifndef WEFT_TESTS_PASSES_GL_OWN_CONTEXTS_H
#define WEFT_TESTS_PASSES_GL_OWN_CONTEXTS_H

#include <dlfcn.h>
#include <string.h>

#include "passes/gl/context.h"
#include "passes/gl/gl.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/osmesa.h>

struct own {
    const char *name;
    bool egl;
    int version; // that is asked for, 10 * major + minor
    bool core;
    void *library;
    EGLDisplay display;
    EGLSurface surface;
    EGLContext context; // or of OSMesa
    float pixels[4 * 4 * 4];
    GladGLContext gl;
    // Of the callbacks.
    bool refuses;
    int calls, releases;
};

#define OWN_CALL(own, name) ((__typeof__(&name))dlsym((own)->library, #name))

static inline weft_gl_function own_find(void *priv, const char *name)
{
    const struct own *o = priv;
    return o->egl ? (weft_gl_function)OWN_CALL(o, eglGetProcAddress)(name)
                  : (weft_gl_function)OWN_CALL(o, OSMesaGetProcAddress)(name);
}

static inline bool own_make_current(void *priv)
{
    struct own *o = priv;
    o->calls++;
    if (o->refuses)
        return false;
    return o->egl ? OWN_CALL(o, eglBindAPI)(EGL_OPENGL_API) &&
                        OWN_CALL(o, eglMakeCurrent)(o->display, o->surface, o->surface, o->context)
                  : OWN_CALL(o, OSMesaMakeCurrent)(o->context, o->pixels, GL_FLOAT, 4, 4);
}

static inline void own_release(void *priv)
{
    struct own *o = priv;
    o->releases++;
    if (o->egl)
        OWN_CALL(o, eglMakeCurrent)(o->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    else
        OWN_CALL(o, OSMesaMakeCurrent)(NULL, NULL, 0, 0, 0);
}

static inline bool own_is_current(const struct own *o)
{
    return o->egl ? OWN_CALL(o, eglGetCurrentContext)() == o->context &&
                        OWN_CALL(o, eglGetCurrentSurface)(EGL_DRAW) == o->surface
                  : OWN_CALL(o, OSMesaGetCurrentContext)() == o->context;
}

static inline bool own_egl_start(struct own *o)
{
    static const EGLint config_attributes[] = {EGL_SURFACE_TYPE, EGL_PBUFFER_BIT,
                                               EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE};
    static const EGLint size[] = {EGL_WIDTH, 4, EGL_HEIGHT, 4, EGL_NONE};
    const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                                 o->version / 10,
                                 EGL_CONTEXT_MINOR_VERSION,
                                 o->version % 10,
                                 EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                 o->core ? EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT
                                         : EGL_CONTEXT_OPENGL_COMPATIBILITY_PROFILE_BIT,
                                 EGL_NONE};
    EGLConfig config = NULL;
    EGLint count = 0;
    o->library = dlopen("libEGL.so.1", RTLD_LAZY | RTLD_LOCAL);
    if (!o->library)
        return false;
    PFNEGLGETPLATFORMDISPLAYEXTPROC get_display =
        (PFNEGLGETPLATFORMDISPLAYEXTPROC)OWN_CALL(o, eglGetProcAddress)("eglGetPlatformDisplayEXT");
    o->display = get_display ? get_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, NULL)
                             : EGL_NO_DISPLAY;
    if (o->display == EGL_NO_DISPLAY || !OWN_CALL(o, eglInitialize)(o->display, NULL, NULL) ||
        !OWN_CALL(o, eglBindAPI)(EGL_OPENGL_API) ||
        !OWN_CALL(o, eglChooseConfig)(o->display, config_attributes, &config, 1, &count) ||
        count == 0)
        return false;
    o->surface = OWN_CALL(o, eglCreatePbufferSurface)(o->display, config, size);
    o->context = OWN_CALL(o, eglCreateContext)(o->display, config, EGL_NO_CONTEXT, attributes);
    return o->surface && o->context;
}

static inline bool own_osmesa_start(struct own *o)
{
    const int attributes[] = {OSMESA_FORMAT,
                              OSMESA_RGBA,
                              OSMESA_PROFILE,
                              o->core ? OSMESA_CORE_PROFILE : OSMESA_COMPAT_PROFILE,
                              OSMESA_CONTEXT_MAJOR_VERSION,
                              o->version / 10,
                              OSMESA_CONTEXT_MINOR_VERSION,
                              o->version % 10,
                              0};
    o->library = dlopen("libOSMesa.so.8", RTLD_LAZY | RTLD_LOCAL);
    if (o->library)
        o->context = OWN_CALL(o, OSMesaCreateContextAttribs)(attributes, NULL);
    return o->context != NULL;
}

// Makes one, and makes it current. false: it is not to be had here.
static inline bool own_start(struct own *o)
{
    if (!(o->egl ? own_egl_start(o) : own_osmesa_start(o)) || !own_make_current(o))
        return false;
    o->calls = 0;
    return weft_gl_load(&o->gl, own_find, o);
}

static inline void own_stop(struct own *o)
{
    own_release(o);
    if (o->egl) {
        OWN_CALL(o, eglDestroySurface)(o->display, o->surface);
        OWN_CALL(o, eglDestroyContext)(o->display, o->context);
    } else {
        OWN_CALL(o, OSMesaDestroyContext)(o->context);
    }
}

#endif
