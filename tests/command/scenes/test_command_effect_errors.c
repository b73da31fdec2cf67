// SPDX-License-Identifier: BSD-3-Clause
// What weft effect refuses: one line that names what, where and the numbers, the documented exit
// code, and the folder as it was. And how signals end it.
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

#include "tests/command/scenes/pictures.h"
#include "tests/command/scenes/refused.h"
#include "tests/support/command.h"

#define fails(code, text, ...) command_fails(code, text, "effect", __VA_ARGS__)

// ---- options ------------------------------------------------------------------------------------

static void effects_are_named(void **state)
{
    (void)state;
    fails(2, "no effect given: weft effect NAME", "-o", "p.exr");
    command_fails(2, "no effect given: weft effect NAME", "effect");
    fails(2, "no effect 'bloom'; there are fade, motion-blur,", "bloom", "-o", "p.exr");
    fails(2, "no effect ''", "antialias+", "-o", "p.exr");
    fails(2, "no effect ''", "", "-o", "p.exr");
    fails(2, "effect dof is named twice", "dof+antialias+dof", "-o", "p.exr");
    fails(2, "radiosity has soft shadows: leave soft-shadow out", "radiosity+soft-shadow", "-o",
          "p.exr");
    fails(2, "one argument too many: 'dof'", "antialias", "dof", "-o", "p.exr");
    fails(2, "nothing to do: give -o OUT.exr", "antialias");
    fails(2, "nothing to do", "antialias", "-q");
}

// Each option needs its effect.
static void options_of_other_effects_are_refused(void **state)
{
    (void)state;
    static const struct {
        const char *option[2], *message;
    } cases[] = {
        {{"--weights", "1,2"}, "--weights is of fade: name it with the others, as %s+fade"},
        {{"--fade", "0.5"}, "--fade is of fade"},
        {{"--shutter", "tent"}, "--shutter is of motion-blur"},
        {{"--jitter", "j8"}, "--jitter is of antialias, dof or soft-shadow"},
        {{"--centre", "off"}, "--centre is of antialias, dof or soft-shadow"},
        {{"--kernel", "mitchell"}, "--kernel is of antialias"},
        {{"--kernel-width", "2"}, "--kernel-width is of antialias"},
        {{"--aperture", "1"}, "--aperture is of dof"},
        {{"--focus", "1"}, "--focus is of dof"},
        {{"--light-size", "1"}, "--light-size is of soft-shadow or radiosity"},
        {{"--paths", "8"}, "--paths is of radiosity"},
        {{"--light-clamp", "off"}, "--light-clamp is of radiosity"},
    };
    int refused = 0;
    for (size_t i = 0; i < COUNT(cases); i++)
        for (int e = 0; e < 2; e++) {
            const char *effect = e ? "motion-blur" : "fade";
            char message[200];
            if (strstr(cases[i].message, e ? "of motion-blur" : "of fade"))
                continue;
            snprintf(message, sizeof message, cases[i].message, effect);
            fails(2, message, effect, "-o", "p.exr", cases[i].option[0], cases[i].option[1]);
            refused++;
        }
    assert_int_equal(refused, 2 * COUNT(cases) - 3);
}

// One effect, and up to four more arguments.
static void bad_values_are_refused(void **state)
{
    (void)state;
    static const struct refused_value cases[] = {
        {"antialias", {"--frames", "0"}, "--frames 0: not a whole number from 1 to "},
        {"antialias",
         {"--frames", "many"},
         "--frames many: not a whole number from 1 to 131072, "
         "or auto"},
        {"antialias", {"--frames", "2.5"}, "--frames 2.5: not a whole number"},
        {"antialias", {"--frames", "999999999"}, "--frames 999999999: not a whole number"},
        {"antialias", {"--size", "0x4"}, "--size 0x4: each is 1 to 16384 pixels"},
        {"antialias", {"--size", "99999x4"}, "--size 99999x4: each is 1 to 16384 pixels"},
        {"antialias", {"--seed", "-1"}, "--seed -1: not a whole number from 0"},
        {"antialias", {"--seed", "0.5"}, "--seed 0.5: not a whole number from 0"},
        {"antialias", {"--jitter", "j7"}, "j7"},
        {"antialias", {"--jitter", "j8:9"}, "j8"},
        {"antialias", {"--jitter", "j8", "--frames", "9"}, "j8"},
        {"antialias",
         {"--jitter", "halton:9", "--frames", "8"},
         "--jitter halton:9 has 9 points, for 8 frames"},
        {"antialias", {"--centre", "off"}, "--centre needs --jitter SET"},
        {"antialias", {"--kernel", "mitchel"}, "did you mean mitchell?"},
        {"antialias", {"--kernel", "d-bspline3"}, "d-bspline3"},
        {"antialias", {"--kernel-width", "0"}, "--kernel-width 0: not a width in pixels"},
        {"antialias",
         {"--kernel", "mitchell", "--method", "tree"},
         "--method tree takes no negative weights"},
        {"antialias",
         {"--kernel", "mitchell", "--method", "blend"},
         "--method blend takes no negative weights"},
        {"motion-blur", {"--shutter", "slow"}, "slow"},
        {"motion-blur", {"--shutter", "0.7:0.2"}, "a shutter is open from 0.7 to 0.2"},
        {"motion-blur", {"--time", "0.5..0.2"}, "0.5..0.2"},
        {"motion-blur", {"--time", "0..2"}, "--time 0..2: not a time from 0 to 1"},
        {"dof", {"--aperture", "-1"}, "--aperture -1: a lens's diameter is 0 or more"},
        {"dof", {"--focus", "0"}, "--focus 0: the distance of what is in focus is above 0"},
        {"dof", {"--fov", "180"}, "--fov 180: not an angle"},
        {"dof", {"--eye", "1,1,1", "--target", "1,1,1"}, "target"},
        {"dof", {"--up", "0,0,0"}, "up"},
        {"soft-shadow", {"--light-size", "0"}, "--light-size 0: the longer side"},
        {"soft-shadow", {"--shadow-size", "0"}, "--shadow-size 0: not a whole number of texels"},
        {"soft-shadow", {"--shadow-size", "1.5"}, "--shadow-size 1.5: not a whole number"},
        {"soft-shadow", {"--scene", "cube"}, "no square or round lamp"},
        {"soft-shadow",
         {"--light-size", "1", "--scene", "cornell"},
         "--light-size: scene cornell has no lamp that has an area that can be changed"},
        {"antialias",
         {"--light", "1,1,1", "--scene", "cube"},
         "--light: scene cube has no lamp that can be moved"},
        {"antialias",
         {"--shadow-size", "64", "--scene", "cube"},
         "--shadow-size: scene cube has no lamp that throws shadows"},
        {"radiosity", {"--paths", "8", "--frames", "8"}, "--paths and --frames exclude each other"},
        {"radiosity", {"--paths", "0"}, "--paths 0: not a whole number from 1"},
        {"radiosity", {"--light-clamp", "0"}, "--light-clamp 0: not auto, off, or a factor above 0"},
        {"radiosity", {"--light-clamp", "1x"}, "--light-clamp 1x: not auto, off"},
        {"radiosity", {"--scene", "cube"}, ""},
        {"fade", {"--scene", "cube"}, "--scene cube: a fade needs two scenes or more"},
        {"fade", {"--scene", "cube,,plane"}, "--scene cube,,plane: an empty name"},
        {"fade", {"--scene", "cube,"}, "--scene cube,: an empty name"},
        {"fade", {"--weights", "1"}, "--weights 1: 1 weights for 2 scenes"},
        {"fade", {"--weights", "1,2,3"}, "--weights 1,2,3: 3 weights for 2 scenes"},
        {"fade", {"--weights", "1,nan"}, "--weights 1,nan: not numbers with commas"},
        {"fade", {"--weights", "1,"}, "--weights 1,: not numbers with commas"},
        {"fade", {"--weights", "1;2"}, "--weights 1;2: not numbers with commas"},
        {"fade", {"--weights=1,-1"}, "they add up to 0, which must be above 0"},
        {"fade", {"--weights", "1,2", "--fade", "0.5"}, "--weights and --fade exclude each other"},
        {"fade", {"--fade", "1.5"}, "--fade 1.5: not from 0, the first scene, to 1"},
        {"antialias", {"--scene", "cubes"}, "no scene 'cubes'; did you mean cube? there are cube,"},
        {"antialias", {"--scene", "cube:3"}, "the scene cube has no arguments"},
        {"antialias", {"--scene", "polygons:x"}, "polygons"},
        {"antialias", {"--method", "nearest"}, "'nearest' is not one of: auto, exact"},
        {"antialias", {"--method", "exact", "--bits", "8"}, "--bits needs --method tree, buffer"},
        {"antialias", {"--batch", "2"}, "--batch is of the standard error"},
        {"antialias",
         {"--method", "tree", "--branching", "2x2"},
         "such a tree has 4 leaves, for 16 frames"},
        {"antialias", {"--until", "0"}, "'0' is not a standard error above 0"},
        {"antialias", {"--max-error", "0"}, "--max-error 0: it must be above 0"},
        {"antialias", {"--range", "0,1"}, "--range needs --preview OUT.png"},
        {"antialias", {"--range", "1,0", "--preview", "p.png"}, "--range 1,0: LO must be less"},
        {"antialias", {"--threads", "0"}, "--threads 0: not a whole number"},
        {"antialias", {"--context", "metal"}, "metal"},
        {"antialias", {"--stderr", "p.exr"}, "-o p.exr and --stderr p.exr are the same file"},
        {"antialias", {"-q", "-v"}, "-q and -v exclude each other"},
        {"antialias", {"-o", "p.png"}, "output"},
    };
    refuse_values("effect", cases, COUNT(cases));
}

static void errors_beyond_the_wanted_are_refused(void **state)
{
    (void)state;
    fails(1, "--max-error 0.001: the bound of --method tree is 0.0", "antialias", "--method",
          "tree", "--max-error", "0.001", "-o", "p.exr", "--size", "16x16");
    // Known once the frames are.
    fails(1, "--max-error 0.0001: the bound of --method tree is 0.0", "antialias", "--method",
          "tree", "--max-error", "0.0001", "-o", "p.exr", "--size", "16x16", "--until", "0.5",
          "--jitter", "sobol", "--frames", "20");
    fails(1, "no method is within 1e-12", "antialias", "--max-error", "1e-12", "-o", "p.exr",
          "--size", "16x16");
}

// ---- files --------------------------------------------------------------------------------------

static void outputs_are_checked_beforehand(void **state)
{
    (void)state;
    assert_int_equal(mkdir("folder", 0700), 0);
    put("there.exr", "an earlier picture");
    put("square.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n");
    fails(4, "no/p.exr cannot be written: folder no/: No such file", "antialias", "-o", "no/p.exr");
    fails(4, "no/p.png cannot be written", "antialias", "--preview", "no/p.png");
    fails(4, "there.exr exists, and --no-clobber is given", "antialias", "-o", "there.exr",
          "--no-clobber");
    assert_int_equal(rename("folder", "folder.exr"), 0);
    fails(4, "folder.exr cannot be written: it is a folder", "antialias", "-o", "folder.exr");
    assert_int_equal(symlink("square.obj", "link.exr"), 0);
    fails(2, "the output link.exr is the input square.obj", "antialias", "--scene", "square.obj",
          "-o", "link.exr");
    fails(2, "the output square.exr is the input square.exr", "antialias", "--keyframes",
          "square.exr", "-o", "square.exr");
    fails(4, "/dev/full", "antialias", "--size", "64x64", "--frames", "1", "--compression", "none",
          "-o", "/dev/full");
    size_t size;
    char *kept = command_read_file("there.exr", &size);
    assert_int_equal(size, 18);
    free(kept);
    assert_int_equal(rmdir("folder.exr"), 0);
}

static void bad_meshes_get_one_line(void **state)
{
    (void)state;
    for (size_t i = 0; i < COUNT(bad_meshes); i++) {
        put(bad_meshes[i].path, bad_meshes[i].text);
        fails(3, bad_meshes[i].path, "antialias", "--scene", bad_meshes[i].path, "-o", "p.exr");
    }
    fails(3, "gone.obj", "antialias", "--scene", "gone.obj", "-o", "p.exr");
    fails(3, "gone.obj", "fade", "--scene", "cube;gone.obj", "-o", "p.exr");
}

static void bad_keyframes_name_their_line(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        int line;
        int code;
    } files[] = {
        {"cube 0\n", 1, 3},
        {"# none\n\ncube 0 0,0\n", 3, 3},
        {"cube 0 0,0,0\ncube 0 1,0,0\n", 2, 3},
        {"cube 0 0,0,0 0,0,0,90\n", 1, 3},
        {"nobody 0 0,0,0\n", 1, 2},
    };
    fails(3, "none: No such file or directory", "motion-blur", "--keyframes", "none", "-o",
          "p.exr");
    for (size_t i = 0; i < COUNT(files); i++) {
        char where[32];
        put("keys", files[i].text);
        snprintf(where, sizeof where, "keys, line %d: ", files[i].line);
        fails(files[i].code, where, "motion-blur", "--scene", "cube", "--keyframes", "keys", "-o",
              "p.exr");
    }
}

// ---- signals ------------------------------------------------------------------------------------

// Many frames, and at moments all over them.
static void signals_while_it_draws(void **state)
{
    (void)state;
    static const int signals[] = {SIGTERM, SIGINT, SIGHUP};
    const int before = command_folder_size();
    if (!command_has_gl())
        skip();
    for (size_t i = 0; i < COUNT(signals); i++) {
        const pid_t pid = command_start(-1, -1,
                                        (const char *[]){"weft", "effect", "radiosity", "--frames",
                                                         "100000", "-o", "p.exr", "--preview",
                                                         "p.png", "--stderr", "e.exr", NULL});
        usleep((useconds_t)(100000 + 250000 * i));
        assert_dies(pid, signals[i]);
    }
    assert_int_equal(command_folder_size(), before);
}

// A program in the reader's place that never answers.
static void signals_while_a_mesh_is_waited_for(void **state)
{
    (void)state;
    char variable[4200], folder[4096];
    assert_non_null(getcwd(folder, sizeof folder));
    put("weft-read-mesh", "#!/bin/sh\ntrap '' TERM INT HUP; sleep 99 & sleep 98\n");
    assert_int_equal(chmod("weft-read-mesh", 0755), 0);
    put("square.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n");
    snprintf(variable, sizeof variable, "WEFT_LIBEXEC=%s", folder);
    command_environment(variable);
    const pid_t pid = command_start(-1, -1,
                                    (const char *[]){"weft", "effect", "antialias", "--scene",
                                                     "square.obj", "-o", "p.exr", NULL});
    assert_true(command_wait_for_programs(4));
    assert_dies(pid, SIGTERM);
    unlink("weft-read-mesh");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(effects_are_named),
        cmocka_unit_test(options_of_other_effects_are_refused),
        cmocka_unit_test(bad_values_are_refused),
        cmocka_unit_test(errors_beyond_the_wanted_are_refused),
        cmocka_unit_test(outputs_are_checked_beforehand),
        cmocka_unit_test(bad_meshes_get_one_line),
        cmocka_unit_test(bad_keyframes_name_their_line),
        cmocka_unit_test(signals_while_it_draws),
        cmocka_unit_test(signals_while_a_mesh_is_waited_for),
    };
    return cmocka_run_group_tests(tests, command_setup_folder, command_teardown);
}
