// SPDX-License-Identifier: BSD-3-Clause
// A caller's own context, by callbacks and in a share group: every engine makes the same pixels,
// and leaves the context as it was.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdlib.h>

#include "tests/passes/gl/every_engine.h"
#include "tests/passes/gl/odd_state.h"
#include "tests/passes/gl/own_contexts.h"
#include "tests/support/common.h"

static const struct {
    const char *name;
    bool egl, core;
} kinds[] = {
    {"EGL, core", true, true},
    {"EGL, compatibility", true, false},
    {"OSMesa, core", false, true},
    {"OSMesa, compatibility", false, false},
};

static bool start(size_t kind, struct own *own)
{
    *own = (struct own){
        .name = kinds[kind].name, .egl = kinds[kind].egl, .version = 33, .core = kinds[kind].core};
    const bool done = own_start(own);
    if (!done)
        print_message("[  SKIPPED ] %s is not to be had\n", own->name);
    return done;
}

static struct weft_context_params *callers(struct own *own)
{
    static struct weft_context_params params;
    params = (struct weft_context_params){.caller = {own_find, own_make_current, own_release, own},
                                          .log = &log_to_stderr};
    return &params;
}

static struct every_engine expected, found;

static void expect_same(const char *what)
{
    assert_int_equal(expected.count, found.count);
    for (int i = 0; i < found.count; i++)
        if (memcmp(expected.pixels[i], found.pixels[i], sizeof expected.pixels[i]) != 0)
            fail_msg("%s: pixels of %s differ", what, found.name[i]);
}

// What weft's own context of the same library makes.
static bool make_expected(bool egl)
{
    weft_context *context = NULL;
    if (weft_context_create(
            weft_context_params(.kind = egl ? WEFT_CONTEXT_EGL : WEFT_CONTEXT_OSMESA), &context) !=
        WEFT_OK)
        return false;
    run_every_engine(context, &expected);
    weft_context_destroy(&context);
    return true;
}

static void a_callers_context_is_used_and_left_as_it_was(void **state)
{
    static struct odd_values before, after;
    int ran = 0;
    (void)state;
    for (size_t kind = 0; kind < WEFT_COUNT(kinds); kind++) {
        struct own own;
        weft_context *context = NULL;
        if (!make_expected(kinds[kind].egl) || !start(kind, &own))
            continue;
        odd_set(&own.gl,
                own.core ? NULL : (void (*)(GLenum, GLfloat))own_find(&own, "glPixelTransferf"));
        odd_read(&own.gl, &before);
        own_release(&own);
        ENGINE_OK(weft_context_create(callers(&own), &context));
        const struct weft_context_info *info = weft_context_get_info(context);
        assert_string_equal(info->platform, "caller's");
        run_every_engine(context, &found);
        expect_same(own.name);
        assert_int_equal(own.calls, own.releases - 1);
        assert_true(own_make_current(&own));
        odd_read(&own.gl, &after);
        odd_compare(&before, &after, own.name);
        weft_context_destroy(&context);
        assert_true(own_make_current(&own));
        odd_read(&own.gl, &after);
        odd_compare(&before, &after, own.name);
        own_stop(&own);
        ran++;
    }
    if (ran == 0)
        skip();
}

// Weft's context has the caller's objects, and the caller's is current again.
static void objects_are_shared(void **state)
{
    static const float texel[4] = {0.25f, -3.0f, 4e6f, 1.0f};
    struct own own;
    weft_context *context = NULL;
    GLuint texture = 0;
    GLint width = 0;
    (void)state;
    if (!make_expected(true) || !start(0, &own))
        skip();
    own.gl.GenTextures(1, &texture);
    own.gl.BindTexture(GL_TEXTURE_2D, texture);
    own.gl.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F, 1, 1, 0, GL_RGBA, GL_FLOAT, texel);
    ENGINE_OK(
        weft_context_create(weft_context_params(.egl_display = own.display,
                                                .egl_share = own.context, .log = &log_to_stderr),
                            &context));
    assert_true(own_is_current(&own));
    assert_string_equal(weft_context_get_info(context)->platform, "EGL share group");
    run_every_engine(context, &found);
    expect_same("a share group");
    assert_true(own_is_current(&own));
    ENGINE_OK(weft_context_enter(context));
    assert_true(context->gl.IsTexture(texture));
    context->gl.BindTexture(GL_TEXTURE_2D, texture);
    context->gl.GetTexLevelParameteriv(GL_TEXTURE_2D, 0, GL_TEXTURE_WIDTH, &width);
    weft_context_leave(context);
    assert_int_equal(width, 1);
    weft_context_destroy(&context);
    assert_true(own_is_current(&own));
    ENGINE_OK(weft_context_create(
        weft_context_params(.kind = WEFT_CONTEXT_EGL, .egl_display = own.display), &context));
    assert_string_equal(weft_context_get_info(context)->platform, "EGL display");
    weft_context_destroy(&context);
    own_stop(&own);
}

static bool weft_can_be_used(weft_context *context)
{
    if (weft_context_enter(context) != WEFT_OK)
        return false;
    weft_context_leave(context);
    return true;
}

// Without callbacks but one, the context has to be current, and another one in its place is found.
static void a_context_that_is_always_current(void **state)
{
    struct own own, other;
    struct message message = {.count = 0};
    const struct weft_log log = {keep_message, &message};
    weft_context *context = NULL;
    (void)state;
    if (!start(2, &own))
        skip();
    ENGINE_OK(weft_context_create(
        weft_context_params(.caller = {.get_proc_address = own_find, .priv = &own}, .log = &log),
        &context));
    assert_true(weft_can_be_used(context));
    assert_true(own_is_current(&own));
    assert_int_equal(message.count, 0);
    weft_context_destroy(&context);
    // One that is begun is made in this thread, when it is waited for.
    weft_context_making *making = NULL;
    ENGINE_OK(weft_context_begin(
        weft_context_params(.caller = {.get_proc_address = own_find, .priv = &own}, .log = &log),
        &making));
    ENGINE_OK(weft_context_await(&making, &context));
    assert_true(weft_can_be_used(context));
    assert_true(start(3, &other));
    assert_false(weft_can_be_used(context));
    assert_non_null(strstr(message.text, "another context is current, or none"));
    own_stop(&other);
    assert_true(own_make_current(&own));
    // An error of the caller's is told, and no failure; queries that count are refused.
    own.gl.Enable(GL_TEXTURE_2D_ARRAY);
    assert_true(weft_can_be_used(context));
    assert_non_null(strstr(message.text, "0x0500"));
    GLuint query = 0;
    own.gl.GenQueries(1, &query);
    own.gl.BeginQuery(GL_SAMPLES_PASSED, query);
    assert_false(weft_can_be_used(context));
    assert_non_null(strstr(message.text, "GL_SAMPLES_PASSED"));
    own.gl.EndQuery(GL_SAMPLES_PASSED);
    own.gl.DeleteQueries(1, &query);
    assert_true(weft_can_be_used(context));
    weft_context_destroy(&context);
    assert_true(own_is_current(&own));
    assert_int_equal(own.gl.GetError(), GL_NO_ERROR);
    own_stop(&own);
}

static weft_gl_function find_none(void *priv, const char *name)
{
    return strcmp(name, "glTexBuffer") == 0 ? NULL : own_find(priv, name);
}

static void expect_refused(const struct weft_context_params *params, enum weft_result res,
                           const char *text)
{
    struct message message = {.count = 0};
    const struct weft_log log = {keep_message, &message};
    struct weft_context_params p = *params;
    weft_context *context = NULL;
    p.log = &log;
    assert_int_equal(weft_context_create(&p, &context), res);
    assert_null(context);
    assert_int_equal(message.count, 1);
    if (!strstr(message.text, text))
        fail_msg("'%s' lacks '%s'", message.text, text);
}

// Calls fail while it cannot be made current, and succeed when it can.
static void a_context_that_is_refused(void **state)
{
    struct own own;
    struct message message = {.count = 0};
    const struct weft_log log = {keep_message, &message};
    struct weft_context_params params;
    weft_context *context = NULL;
    (void)state;
    if (!start(2, &own))
        skip();
    own_release(&own);
    params = *callers(&own);
    own.refuses = true;
    expect_refused(&params, WEFT_ERR_CONTEXT, "make_current fails");
    own.refuses = false;
    params.caller.get_proc_address = find_none;
    expect_refused(&params, WEFT_ERR_CONTEXT, "get_proc_address knows no glTexBuffer");
    params.caller.get_proc_address = NULL;
    expect_refused(&params, WEFT_ERR_ARGUMENT, "get_proc_address");
    params = (struct weft_context_params){.caller = {.get_proc_address = own_find, .priv = &own}};
    expect_refused(&params, WEFT_ERR_CONTEXT, "no context is current");
    params.kind = WEFT_CONTEXT_OSMESA;
    expect_refused(&params, WEFT_ERR_ARGUMENT, "WEFT_CONTEXT_AUTO");
    params = *callers(&own);
    params.log = &log;
    ENGINE_OK(weft_context_create(&params, &context));
    own.refuses = true;
    assert_false(weft_can_be_used(context));
    assert_non_null(strstr(message.text, "caller's context cannot be made current"));
    own.refuses = false;
    assert_true(weft_can_be_used(context));
    weft_context_destroy(&context);
    assert_true(own_make_current(&own));
    own_stop(&own);
}

// A context of the first device's display, where EGL has devices.
static void expect_other_display_refused(const struct own *own)
{
    PFNEGLQUERYDEVICESEXTPROC query =
        (PFNEGLQUERYDEVICESEXTPROC)OWN_CALL(own, eglGetProcAddress)("eglQueryDevicesEXT");
    PFNEGLGETPLATFORMDISPLAYEXTPROC get_display = (PFNEGLGETPLATFORMDISPLAYEXTPROC)OWN_CALL(
        own, eglGetProcAddress)("eglGetPlatformDisplayEXT");
    EGLDeviceEXT device = NULL;
    EGLint count = 0;
    if (!query || !get_display || !query(1, &device, &count) || count < 1)
        return;
    const EGLDisplay display = get_display(EGL_PLATFORM_DEVICE_EXT, device, NULL);
    expect_refused(weft_context_params(.egl_display = display), WEFT_ERR_CONTEXT,
                   "not initialised");
    if (!OWN_CALL(own, eglInitialize)(display, NULL, NULL))
        return;
    OWN_CALL(own, eglBindAPI)(EGL_OPENGL_API);
    const EGLContext context = OWN_CALL(own, eglCreateContext)(display, NULL, EGL_NO_CONTEXT, NULL);
    assert_non_null(context);
    expect_refused(weft_context_params(.egl_display = own->display, .egl_share = context),
                   WEFT_ERR_CONTEXT, "none of the display's (0x3006)");
    OWN_CALL(own, eglDestroyContext)(display, context);
}

static void versions_that_are_refused(void **state)
{
    const struct weft_context_params *params;
    struct own own = {.egl = true, .version = 33, .core = true};
    (void)state;
    if (!own_start(&own))
        skip();
    // A context of OpenGL ES, on the same display.
    const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION, 3, EGL_NONE};
    const EGLContext desktop = own.context;
    assert_true(OWN_CALL(&own, eglBindAPI)(EGL_OPENGL_ES_API));
    own.context = OWN_CALL(&own, eglCreateContext)(own.display, NULL, EGL_NO_CONTEXT, attributes);
    assert_non_null(own.context);
    expect_refused(weft_context_params(.egl_display = own.display, .egl_share = own.context),
                   WEFT_ERR_CONTEXT, "not OpenGL");
    assert_true(
        OWN_CALL(&own, eglMakeCurrent)(own.display, EGL_NO_SURFACE, EGL_NO_SURFACE, own.context));
    params = weft_context_params(.caller = {.get_proc_address = own_find, .priv = &own});
    expect_refused(params, WEFT_ERR_CONTEXT, "\"OpenGL ES");
    OWN_CALL(&own, eglMakeCurrent)(own.display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    OWN_CALL(&own, eglDestroyContext)(own.display, own.context);
    // What is no display, no context, or a context of no display.
    expect_refused(weft_context_params(.egl_display = &own), WEFT_ERR_CONTEXT, "display");
    expect_refused(weft_context_params(.egl_display = own.display, .egl_share = &own),
                   WEFT_ERR_CONTEXT, "none of the display's (0x3006)");
    expect_other_display_refused(&own);
    expect_refused(weft_context_params(.egl_share = desktop), WEFT_ERR_ARGUMENT, "egl_display");
    expect_refused(weft_context_params(.kind = WEFT_CONTEXT_OSMESA, .egl_display = own.display),
                   WEFT_ERR_ARGUMENT, "WEFT_CONTEXT_OSMESA");
    own.context = desktop;
    own_stop(&own);
}

// An old version, which Mesa has to be told of before anything else: this program again.
static int refuse_old_version(bool egl)
{
    struct own own = {.egl = egl, .version = 0, .core = false};
    struct message message = {.count = 0};
    const struct weft_log log = {keep_message, &message};
    weft_context *context = NULL;
    own.version = 30;
    if (!own_start(&own))
        return EXIT_SUCCESS;
    const enum weft_result res = weft_context_create(
        weft_context_params(.caller = {.get_proc_address = own_find, .priv = &own}, .log = &log),
        &context);
    own_stop(&own);
    return res == WEFT_ERR_CONTEXT && strstr(message.text, "\"3.0") &&
                   strstr(message.text, "OpenGL 3.3 is needed")
               ? EXIT_SUCCESS
               : EXIT_FAILURE;
}

static void an_old_version_is_refused(void **state)
{
    (void)state;
    assert_int_equal(
        system("MESA_GL_VERSION_OVERRIDE=3.0 " WEFT_BINARY_DIR "/test_own_context --old egl && "
               "MESA_GL_VERSION_OVERRIDE=3.0 " WEFT_BINARY_DIR "/test_own_context --old osmesa"),
        0);
}

int main(int argc, char **argv)
{
    if (argc == 3 && strcmp(argv[1], "--old") == 0)
        return refuse_old_version(strcmp(argv[2], "egl") == 0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_callers_context_is_used_and_left_as_it_was),
        cmocka_unit_test(objects_are_shared),
        cmocka_unit_test(a_context_that_is_always_current),
        cmocka_unit_test(a_context_that_is_refused),
        cmocka_unit_test(versions_that_are_refused),
        cmocka_unit_test(an_old_version_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
