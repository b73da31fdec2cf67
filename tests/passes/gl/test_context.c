// SPDX-License-Identifier: BSD-3-Clause
// Contexts, and what they leave of a caller's own.
#include <dlfcn.h>
#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "tests/support/contexts.h"
#include "passes/gl/gl.h"
#include "weft.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/osmesa.h>

// A caller that has GL of its own: a context, current with a target of 4 x 4 pixels.
struct caller {
    const char *name;
    bool (*start)(void); // false: not to be had here
    bool (*is_current)(void);
    GLADapiproc (*find)(void *priv, const char *name);
    void (*stop)(void);
};

static void *library;
#define CALL(name) ((__typeof__(&name))dlsym(library, #name))

static EGLDisplay display;
static EGLSurface surface;
static EGLContext egl;

static bool egl_start(void)
{
    static const EGLint config_attributes[] = {EGL_SURFACE_TYPE, EGL_PBUFFER_BIT,
                                               EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE};
    static const EGLint size[] = {EGL_WIDTH, 4, EGL_HEIGHT, 4, EGL_NONE};
    EGLConfig config = NULL;
    EGLint count = 0;
    library = dlopen("libEGL.so.1", RTLD_LAZY | RTLD_LOCAL);
    if (!library)
        return false;
    PFNEGLGETPLATFORMDISPLAYEXTPROC get_display =
        (PFNEGLGETPLATFORMDISPLAYEXTPROC)CALL(eglGetProcAddress)("eglGetPlatformDisplayEXT");
    display = get_display ? get_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, NULL)
                          : EGL_NO_DISPLAY;
    if (display == EGL_NO_DISPLAY || !CALL(eglInitialize)(display, NULL, NULL) ||
        !CALL(eglBindAPI)(EGL_OPENGL_API) ||
        !CALL(eglChooseConfig)(display, config_attributes, &config, 1, &count) || count == 0)
        return false;
    surface = CALL(eglCreatePbufferSurface)(display, config, size);
    egl = CALL(eglCreateContext)(display, config, EGL_NO_CONTEXT, NULL);
    return surface && egl && CALL(eglMakeCurrent)(display, surface, surface, egl);
}

static bool egl_is_current(void)
{
    return CALL(eglGetCurrentContext)() == egl && CALL(eglGetCurrentDisplay)() == display &&
           CALL(eglGetCurrentSurface)(EGL_DRAW) == surface &&
           CALL(eglGetCurrentSurface)(EGL_READ) == surface && CALL(eglQueryAPI)() == EGL_OPENGL_API;
}

static GLADapiproc egl_find(void *priv, const char *name)
{
    (void)priv;
    return CALL(eglGetProcAddress)(name);
}

static void egl_stop(void)
{
    CALL(eglMakeCurrent)(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    CALL(eglDestroySurface)(display, surface);
    CALL(eglDestroyContext)(display, egl);
}

static OSMesaContext osmesa;
static float osmesa_pixels[4 * 4 * 4];

static bool osmesa_start(void)
{
    library = dlopen("libOSMesa.so.8", RTLD_LAZY | RTLD_LOCAL);
    if (!library)
        return false;
    osmesa = CALL(OSMesaCreateContext)(OSMESA_RGBA, NULL);
    return osmesa && CALL(OSMesaMakeCurrent)(osmesa, osmesa_pixels, GL_FLOAT, 4, 4);
}

static bool osmesa_is_current(void)
{
    GLint width = 0, height = 0, format = 0, type = 0;
    void *buffer = NULL;
    if (CALL(OSMesaGetCurrentContext)() != osmesa)
        return false;
    CALL(OSMesaGetColorBuffer)(osmesa, &width, &height, &format, &buffer);
    CALL(OSMesaGetIntegerv)(OSMESA_TYPE, &type);
    return width == 4 && height == 4 && buffer == osmesa_pixels && type == GL_FLOAT;
}

static GLADapiproc osmesa_find(void *priv, const char *name)
{
    (void)priv;
    return (GLADapiproc)CALL(OSMesaGetProcAddress)(name);
}

static void osmesa_stop(void)
{
    CALL(OSMesaMakeCurrent)(NULL, NULL, 0, 0, 0);
    CALL(OSMesaDestroyContext)(osmesa);
}

static const struct caller callers[] = {
    {"EGL", egl_start, egl_is_current, egl_find, egl_stop},
    {"OSMesa", osmesa_start, osmesa_is_current, osmesa_find, osmesa_stop},
};

// The caller's context is the one that answers, draws and reads, with its state as it was.
static void caller_goes_on(const struct caller *caller, const GladGLContext *gl)
{
    float pixel[4] = {0.0f}, clear[4] = {0.0f};
    if (!caller->is_current())
        fail_msg("%s: the caller's context is not current", caller->name);
    gl->GetFloatv(GL_COLOR_CLEAR_VALUE, clear);
    assert_true(clear[0] == 1.0f);
    gl->Clear(GL_COLOR_BUFFER_BIT);
    gl->ReadPixels(1, 1, 1, 1, GL_RGBA, GL_FLOAT, pixel);
    assert_true(pixel[0] == 1.0f);
    assert_int_equal(gl->GetError(), GL_NO_ERROR);
}

static void slice(weft_context *context)
{
    static const float data[8] = {1, 2, 3, 4, 5, 6, 7, 8};
    float pixels[4];
    weft_volume *volume = NULL;
    weft_slice_plan *plan = NULL;
    const struct weft_volume_params *v = weft_volume_params(.size = {2, 2, 2}, .data = data);
    assert_int_equal(weft_volume_create(v, &volume), WEFT_OK);
    struct weft_slice_params params = {.space = WEFT_SPACE_INDEX};
    assert_int_equal(
        weft_slice_axis_geometry(NULL, volume, params.space, 2, 0.0, 2, 2, &params.geometry),
        WEFT_OK);
    assert_int_equal(weft_slice_plan_create(volume, &params, &plan), WEFT_OK);
    assert_int_equal(weft_slice_run_once(plan, weft_slice_compile_params(.context = context),
                                         weft_slice_run_params(.pixels = pixels), NULL),
                     WEFT_OK);
    for (int i = 0; i < 4; i++)
        assert_true(pixels[i] == data[i]); // on the lattice, with an interpolating kernel
    weft_slice_plan_destroy(&plan);
    weft_volume_destroy(&volume);
}

static void a_callers_context_stays_current(void **state)
{
    static const enum weft_context_kind kinds[] = {WEFT_CONTEXT_OSMESA, WEFT_CONTEXT_EGL};
    (void)state;
    int ran = 0;
    for (size_t c = 0; c < WEFT_COUNT(callers); c++) {
        const struct caller *caller = &callers[c];
        GladGLContext gl = {0};
        if (!caller->start()) {
            print_message("[  SKIPPED ] no %s of the caller's own\n", caller->name);
            continue;
        }
        assert_true(weft_gl_load(&gl, caller->find, NULL));
        gl.ClearColor(1.0f, 0.0f, 0.0f, 1.0f);
        for (size_t k = 0; k < WEFT_COUNT(kinds); k++) {
            weft_context *context = NULL;
            if (weft_context_create(&(struct weft_context_params){.kind = kinds[k]}, &context) !=
                WEFT_OK) {
                caller_goes_on(caller, &gl);
                continue;
            }
            caller_goes_on(caller, &gl);
            slice(context);
            caller_goes_on(caller, &gl);
            weft_context_destroy(&context);
            caller_goes_on(caller, &gl);
            ran++;
        }
        caller->stop();
    }
    if (ran == 0)
        skip();
}

static void without_a_callers_context_none_is_left_current(void **state)
{
    (void)state;
    library = dlopen("libEGL.so.1", RTLD_LAZY | RTLD_LOCAL);
    weft_context *context = NULL;
    if (!library || weft_context_create(&(struct weft_context_params){.kind = WEFT_CONTEXT_EGL},
                                        &context) != WEFT_OK)
        skip();
    CALL(eglBindAPI)(EGL_OPENGL_ES_API);
    slice(context);
    assert_null(CALL(eglGetCurrentContext)());
    assert_int_equal(CALL(eglQueryAPI)(), EGL_OPENGL_ES_API);
    weft_context_destroy(&context);
}

// What is told comes to the thread that waits, and not before.
struct listener {
    pthread_t thread;
    bool waits;
    int messages;
};

static void listen(void *priv, enum weft_log_level level, const char *message)
{
    struct listener *listener = priv;
    (void)level;
    (void)message;
    if (!listener->waits || !pthread_equal(listener->thread, pthread_self()))
        abort();
    listener->messages++;
}

static void make_meanwhile(enum weft_context_kind kind)
{
    struct listener listener = {.thread = pthread_self()};
    const struct weft_log log = {listen, &listener};
    const struct weft_context_params params = {.kind = kind, .log = &log};
    weft_context_making *making = NULL;
    weft_context *context = NULL;
    assert_int_equal(weft_context_begin(&params, &making), WEFT_OK);
    assert_int_equal(listener.messages, 0);
    listener.waits = true;
    assert_int_equal(weft_context_await(&making, &context), WEFT_OK);
    assert_null(making);
    assert_true(listener.messages > 0);
    slice(context);
    weft_context_destroy(&context);
    listener.waits = false;
    assert_int_equal(weft_context_begin(&params, &making), WEFT_OK);
    weft_context_abandon(&making);
    assert_null(making);
}

static void a_context_is_made_meanwhile(void **state)
{
    static const enum weft_context_kind kinds[] = {WEFT_CONTEXT_OSMESA, WEFT_CONTEXT_EGL};
    (void)state;
    int ran = 0;
    for (size_t k = 0; k < WEFT_COUNT(kinds); k++) {
        weft_context *context = NULL;
        if (weft_context_create(&(struct weft_context_params){.kind = kinds[k]}, &context) !=
            WEFT_OK)
            continue;
        weft_context_destroy(&context);
        make_meanwhile(kinds[k]);
        // With a variable that Mesa reads a child tries first, when the context is awaited.
        setenv("MESA_OF_THIS_TEST", "1", 1);
        make_meanwhile(kinds[k]);
        unsetenv("MESA_OF_THIS_TEST");
        ran++;
    }
    if (ran == 0)
        skip();
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_context_is_made_meanwhile), // first: no library is loaded yet
        cmocka_unit_test(a_callers_context_stays_current),
        cmocka_unit_test(without_a_callers_context_none_is_left_current),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
