// SPDX-License-Identifier: BSD-3-Clause
// weft where GL is in a bad way: drivers that end the process, and too little memory for them.
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cmocka.h>

#include "tests/support/command.h"

static struct command_result result;

// A picture, or exit 5 and one line; never a signal. Returns whether it was a picture.
static bool slice_ends_well(const char *where)
{
    command_run(&result, "weft", "slice", "ml.vdb", "--axis", "z", "--size", "16x16", "-o", "o.exr",
                "--engine", "gl", "-q");
    const bool drawn = access("o.exr", F_OK) == 0;
    const char *line_end = strchr(result.err, '\n');
    if (result.code == 0 && drawn) {
        remove("o.exr");
        return true;
    }
    if (drawn || result.code != 5 || !line_end || line_end[1] ||
        strncmp(result.err, "weft: error: no usable GL context", 33) != 0)
        fail_msg("%s: exit code %d, %s", where, result.code, result.err);
    return false;
}

static void drivers_that_fail_are_told(void **state)
{
    (void)state;
    if (!command_has_gl())
        skip();
    static const struct {
        const char *variable;
        int draws; // 1: it must; 0: it cannot; -1: that depends on the machine
    } cases[] = {
        {"GALLIUM_DRIVER=llvmpipe", 1},
        {"GALLIUM_DRIVER=softpipe", -1},
        {"GALLIUM_DRIVER=zink", -1},
        {"GALLIUM_DRIVER=virgl", -1},
        {"GALLIUM_DRIVER=d3d12", -1},
        {"GALLIUM_DRIVER=nonsense", 0},
        {"MESA_GLSL_VERSION_OVERRIDE=130", 0},
        {"MESA_GL_VERSION_OVERRIDE=2.1", 0},
        {"LP_NATIVE_VECTOR_WIDTH=512", -1},
        {"MESA_EXTENSION_OVERRIDE=-GL_ARB_texture_buffer_object", -1},
    };
    int drew = 0, refused = 0;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        command_environment(cases[i].variable);
        const bool drawn = slice_ends_well(cases[i].variable);
        if (cases[i].draws >= 0)
            assert_int_equal(drawn, cases[i].draws);
        if (!drawn) // the line names what is to blame
            assert_non_null(strstr(result.err, cases[i].variable));
        drew += drawn;
        refused += !drawn;
    }
    assert_true(drew > 0 && refused > 0);
}

static void too_little_address_space_is_told(void **state)
{
    (void)state;
#ifdef __SANITIZE_ADDRESS__
    skip(); // its shadow alone takes terabytes
#endif
    if (!command_has_gl())
        skip();
    struct rlimit before;
    assert_int_equal(getrlimit(RLIMIT_AS, &before), 0);
    int drew = 0, refused = 0;
    for (int mib = 140; mib <= 2240; mib *= 2) {
        char where[64];
        snprintf(where, sizeof where, "%d MiB", mib);
        const struct rlimit limit = {(rlim_t)mib << 20, before.rlim_max};
        assert_int_equal(setrlimit(RLIMIT_AS, &limit), 0);
        const bool drawn = slice_ends_well(where);
        assert_int_equal(setrlimit(RLIMIT_AS, &before), 0);
        assert_false(drew && !drawn); // more room is never less
        drew += drawn;
        refused += !drawn;
    }
    assert_true(refused > 0);
}

// What draws nothing runs where no GL library can be loaded, and does not depend on one.
static void verbs_that_draw_nothing_need_no_gl(void **state)
{
    (void)state;
    static const char *const verbs[][5] = {
        {"weft", "info", "ml.vdb", NULL},
        {"weft", "kernel", "catmull-rom", NULL},
        {"weft", "plan", "--kernel", "linear", NULL},
        {"weft", "table", "--help", NULL},
    };
    for (size_t i = 0; i < sizeof verbs / sizeof *verbs; i++) {
        command_environment("LD_DEBUG=files");
        command_run_list(&result, verbs[i]);
        assert_int_equal(result.code, 0);
        assert_non_null(strstr(result.err, "libweft"));
        assert_null(strstr(result.err, "libOSMesa"));
        assert_null(strstr(result.err, "libEGL"));
        assert_null(strstr(result.err, "libLLVM"));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(drivers_that_fail_are_told),
        cmocka_unit_test(too_little_address_space_is_told),
        cmocka_unit_test(verbs_that_draw_nothing_need_no_gl),
    };
    return cmocka_run_group_tests(tests, command_setup, command_teardown);
}
