// SPDX-License-Identifier: BSD-3-Clause
// What weft antialias refuses: one line that names what, where and the numbers, the documented exit
// code, and the folder as it was. And how signals end it.
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#include "tests/command/scenes/pictures.h"
#include "tests/command/scenes/refused.h"
#include "tests/support/command.h"

#define fails(code, text, ...) command_fails(code, text, "antialias", __VA_ARGS__)

// ---- options ------------------------------------------------------------------------------------

static void ways_are_named(void **state)
{
    (void)state;
    fails(2, "no way given: weft antialias acaa|msaa|", "-o", "p.exr");
    command_fails(2, "no way given", "antialias");
    fails(2, "no way 'fxaa' of anti-aliasing; there are acaa, msaa, adaptive,", "fxaa", "-o",
          "p.exr");
    fails(2, "did you mean supersample?", "supersampling", "-o", "p.exr");
    fails(2, "one argument too many: 'msaa'", "acaa", "msaa", "-o", "p.exr");
    fails(2, "nothing to do: give -o OUT.exr", "acaa");
    fails(2, "nothing to do", "none", "-q");
}

// What an option is of, and the ways that it makes no sense with.
static void options_of_other_ways_are_refused(void **state)
{
    (void)state;
    static const char *const ways[] = {"acaa", "msaa", "adaptive", "supersample", "none"};
    static const struct {
        const char *option[2], *ways;
    } cases[] = {
        {{"--weight-map", "m.exr"}, "acaa"},
        {{"--samples", "4"}, "acaa, msaa, adaptive and supersample"},
        {{"--kernel", "mitchell"}, "acaa, adaptive and supersample"},
        {{"--kernel-width", "2"}, "acaa, adaptive and supersample"},
        {{"--form", "auto"}, "acaa"},
        {{"--coincident", "mask"}, "acaa"},
        {{"--sums", "float"}, "acaa"},
        {{"--sum-range", "2"}, "acaa and msaa"},
        {{"--allow-weight", NULL}, "acaa"},
        {{"--resolve", "sum"}, "msaa"},
        {{"--depth", "32"}, "acaa, msaa and none"},
        {{"--sample-format", "8"}, "msaa, adaptive, supersample and none"},
        {{"--mark", "visible"}, "adaptive"},
        {{"--contrast", "0.1"}, "adaptive"},
        {{"--max-edge-share", "0.5"}, "adaptive"},
        {{"--store", "blocks"}, "adaptive and supersample"},
        {{"--method", "float"}, "adaptive and supersample"},
        {{"--pattern", "halton"}, "adaptive and supersample"},
    };
    int refused = 0;
    for (size_t i = 0; i < COUNT(cases); i++)
        for (size_t w = 0; w < COUNT(ways); w++) {
            char message[200];
            const char *at = strstr(cases[i].ways, ways[w]);
            if (at)
                continue;
            snprintf(message, sizeof message, "%s is of %s: it makes no sense with %s",
                     cases[i].option[0], cases[i].ways, ways[w]);
            fails(2, message, ways[w], "-o", "p.exr", cases[i].option[0], cases[i].option[1]);
            refused++;
        }
    assert_int_equal(refused, 56);
}

// A way, and up to four more arguments.
static void bad_values_are_refused(void **state)
{
    (void)state;
    static const struct refused_value cases[] = {
        {"acaa", {"--samples", "0"}, "--samples 0: not a whole number from 1 to 256"},
        {"acaa", {"--samples", "257"}, "--samples 257: not a whole number"},
        {"acaa", {"--samples", "nan"}, "nan"},
        {"acaa", {"--samples", "2.5"}, "--samples 2.5: not a whole number"},
        {"supersample", {"--samples", "8"}, "--samples 8: a grid has 1, 4, 9, 16 ... samples"},
        {"adaptive", {"--samples", "15"}, "--samples 15: a grid has"},
        {"adaptive", {"--pattern", "halton:8", "--samples", "9"}, "has 8 points, for 9 samples"},
        {"adaptive", {"--pattern", "j8", "--samples", "9"}, "has 8 points, for 9 samples"},
        {"adaptive", {"--pattern", "j7"}, "j7"},
        {"adaptive", {"--pattern", "halton:999"}, "a pixel has 256 samples at most"},
        {"msaa", {"--size", "0x4"}, "--size 0x4: each is 1 to 16384 pixels"},
        {"msaa", {"--size", "99999x4"}, "--size 99999x4: each is 1 to 16384 pixels"},
        {"msaa", {"--size", "8x"}, "8x"},
        {"msaa", {"--frames", "0"}, "--frames 0: not a whole number from 1 to 10000"},
        {"msaa", {"--frames", "1e9"}, "--frames 1e9: not a whole number"},
        {"msaa", {"--frames", "2"}, "p.exr"},
        {"msaa", {"--seed", "-1"}, "--seed -1: not a whole number from 0"},
        {"msaa", {"--time", "0.5..0.2"}, "--time 0.5..0.2: not a time from 0 to 1"},
        {"msaa", {"--time", "nan"}, "nan"},
        {"msaa", {"--depth", "16"}, "'16' is not one of: 24, 32"},
        {"msaa", {"--sample-format", "9"}, "'9' is not one of: 8, 16f, 32f"},
        {"msaa", {"--resolve", "mean"}, "'mean' is not one of: blit, sum"},
        {"msaa", {"--sum-range", "2"}, "--sum-range needs --resolve sum"},
        {"msaa", {"--sum-range", "0", "--resolve", "sum"}, "--sum-range 0: the largest component"},
        {"acaa", {"--sum-range", "-1"}, "--sum-range -1: the largest component"},
        {"acaa", {"--sum-range", "2", "--sums", "float"}, "--sum-range is of integers"},
        {"acaa", {"--form", "magic"}, "'magic' is not one of: auto, post-depth"},
        {"acaa", {"--coincident", "all"}, "'all' is not one of: stencil, mask, alpha, none"},
        {"acaa", {"--form", "jitter", "--coincident", "mask"}, "--coincident makes no sense with"},
        {"acaa", {"--form", "jitter", "--sums", "float"}, "--sums makes no sense with --form"},
        {"acaa", {"--form", "jitter", "--depth", "32"}, "--depth makes no sense with --form"},
        {"acaa", {"--kernel", "mitchel"}, "did you mean mitchell?"},
        {"acaa", {"--kernel", "d-bspline3"}, "d-bspline3"},
        {"acaa", {"--kernel-width", "0"}, "--kernel-width 0: not a width in pixels"},
        {"acaa", {"--kernel-width", "inf"}, "inf"},
        {"adaptive", {"--mark", "some"}, "'some' is not one of: complete, visible"},
        {"adaptive", {"--contrast", "0"}, "--contrast 0: a difference of neighbouring pixels"},
        {"adaptive", {"--contrast", "nan"}, "nan"},
        {"adaptive", {"--max-edge-share", "0"}, "--max-edge-share 0: not a share above 0"},
        {"adaptive", {"--max-edge-share", "101%"}, "--max-edge-share 101%: not a share"},
        {"adaptive", {"--max-edge-share", "1.5"}, "--max-edge-share 1.5: not a share"},
        {"adaptive", {"--max-edge-share", "nan"}, "--max-edge-share nan: not a share"},
        {"adaptive", {"--max-edge-share", "5%%"}, "--max-edge-share 5%%: not a share"},
        {"adaptive", {"--store", "lists"}, "'lists' is not one of: sums, blocks"},
        {"adaptive", {"--method", "nearest"}, "'nearest' is not one of: auto, exact"},
        {"none", {"--fov", "180"}, "--fov 180: not an angle"},
        {"none", {"--eye", "1,1,1", "--target", "1,1,1"}, "target"},
        {"none", {"--up", "0,0,0"}, "up"},
        {"none", {"--light", "1,1,1", "--scene", "cube"}, "cube has no lamp that can be moved"},
        {"none", {"--shadow-size", "64", "--scene", "cube"}, "no lamp that throws shadows"},
        {"none", {"--shadow-size", "1.5"}, "--shadow-size 1.5: not a whole number"},
        {"none", {"--scene", "cubes"}, "no scene 'cubes'; did you mean cube? there are cube,"},
        {"none", {"--scene", "cube:3"}, "the scene cube has no arguments"},
        {"none", {"--range", "0,1"}, "--range needs --preview OUT.png"},
        {"none", {"--range", "1,0", "--preview", "p.png"}, "--range 1,0: LO must be less"},
        {"none", {"--context", "metal"}, "metal"},
        {"none", {"--preview", "p.png", "-q", "-v"}, "-q and -v exclude each other"},
        {"none", {"--verify", "--explain"}, "--verify needs pictures"},
        {"acaa", {"--weight-map", "p.exr"}, "-o p.exr and --weight-map p.exr are the same file"},
        {"none", {"-o", "p.png"}, "output"},
    };
    refuse_values("antialias", cases, COUNT(cases));
    fails(2, "--type needs -o OUT.exr", "none", "--preview", "p.png", "--type", "half");
    fails(2, "--compression needs -o OUT.exr or --weight-map", "acaa", "--weight-map", "m.png",
          "--compression", "zip");
}

static void what_a_device_has_not_is_refused(void **state)
{
    (void)state;
    if (!command_has_gl())
        skip();
    fails(3, "prefiltered", "acaa", "--kernel", "bspline3i", "-o", "p.exr");
    fails(3, "256", "msaa", "--samples", "256", "-o", "p.exr");
    fails(3, "", "none", "--verify", "--scene", "cornell", "--size", "16x16");
    fails(3, "", "none", "--verify", "--scene", "plane", "--size", "16x16", "-o", "p.exr");
}

// ---- files --------------------------------------------------------------------------------------

static void outputs_are_checked_beforehand(void **state)
{
    (void)state;
    put("there.exr", "an earlier picture");
    put("there_1.png", "an earlier preview");
    put("square.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n");
    fails(4, "no/p.exr cannot be written: folder no/: No such file", "none", "-o", "no/p.exr");
    fails(4, "no/m.png cannot be written", "acaa", "--weight-map", "no/m.png");
    fails(4, "there.exr exists, and --no-clobber is given", "none", "-o", "there.exr",
          "--no-clobber");
    fails(4, "there_1.png exists, and --no-clobber is given", "none", "--preview", "there_%d.png",
          "--frames", "2", "--no-clobber");
    assert_int_equal(mkdir("folder.exr", 0700), 0);
    fails(4, "folder.exr cannot be written: it is a folder", "none", "-o", "folder.exr");
    assert_int_equal(symlink("square.obj", "link.exr"), 0);
    fails(2, "the output link.exr is the input square.obj", "none", "--scene", "square.obj", "-o",
          "link.exr");
    fails(2, "the output keys.exr is the input keys.exr", "none", "--keyframes", "keys.exr", "-o",
          "keys.exr");
    fails(2, "a_10.exr is written by frame 0, and written by frame 10", "acaa", "-o", "a_%d.exr",
          "--weight-map", "a_1%d.exr", "--frames", "12");
    fails(2, "--preview ", "none", "-o", "a_%d.exr", "--preview", "a.png", "--frames", "2");
    size_t size;
    char *kept = command_read_file("there.exr", &size);
    assert_int_equal(size, 18);
    free(kept);
    if (!command_has_gl())
        skip();
    fails(4, "/dev/full", "none", "--size", "64x64", "--compression", "none", "-o", "/dev/full");
    fails(4, "/dev/full", "acaa", "--size", "64x64", "--weight-map", "/dev/full");
    assert_int_equal(rmdir("folder.exr"), 0);
}

static void bad_meshes_get_one_line(void **state)
{
    (void)state;
    for (size_t i = 0; i < COUNT(bad_meshes); i++) {
        put(bad_meshes[i].path, bad_meshes[i].text);
        fails(3, bad_meshes[i].path, "none", "--scene", bad_meshes[i].path, "-o", "p.exr");
    }
    fails(3, "gone.obj", "acaa", "--scene", "gone.obj", "-o", "p.exr");
    put("keys", "cube 0\n");
    fails(3, "keys, line 1: ", "msaa", "--scene", "cube", "--keyframes", "keys", "-o", "p.exr");
}

// ---- signals ------------------------------------------------------------------------------------

// Many pictures, and at moments all over them.
static void signals_while_it_draws(void **state)
{
    (void)state;
    static const int signals[] = {SIGTERM, SIGINT, SIGHUP};
    static const char *const ways[] = {"acaa", "adaptive", "supersample"};
    if (!command_has_gl())
        skip();
    for (size_t i = 0; i < COUNT(signals); i++) {
        const pid_t pid =
            command_start(-1, -1,
                          (const char *[]){"weft", "antialias", ways[i], "--frames", "10000",
                                           "--size", "2048x1024", "--json", NULL});
        usleep((useconds_t)(100000 + 250000 * i));
        assert_dies(pid, signals[i]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ways_are_named),
        cmocka_unit_test(options_of_other_ways_are_refused),
        cmocka_unit_test(bad_values_are_refused),
        cmocka_unit_test(what_a_device_has_not_is_refused),
        cmocka_unit_test(outputs_are_checked_beforehand),
        cmocka_unit_test(bad_meshes_get_one_line),
        cmocka_unit_test(signals_while_it_draws),
    };
    return cmocka_run_group_tests(tests, command_setup_folder, command_teardown);
}
