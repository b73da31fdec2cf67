// SPDX-License-Identifier: BSD-3-Clause
// weft effect as its users see it: pictures of every effect, values of fades against their weights,
// methods within their bounds, files and cameras against what the thin lens and the frustum say,
// reports. What is refused is in test_command_effect_errors.c.
#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>
#include <jansson.h>

#include "tests/command/scenes/pictures.h"
#include "tests/support/command.h"
#include "tests/support/json.h"
#include "weft.h"

// ---- pictures -----------------------------------------------------------------------------------

static const char *const effects[] = {"fade",
                                      "motion-blur",
                                      "antialias",
                                      "dof",
                                      "soft-shadow",
                                      "radiosity",
                                      "antialias+dof+motion-blur",
                                      "fade+antialias",
                                      "soft-shadow+dof+antialias",
                                      "radiosity+antialias+dof"};

static void every_effect_makes_its_picture(void **state)
{
    (void)state;
    char text[300];
    for (size_t i = 0; i < COUNT(effects); i++) {
        struct weft_image image;
        command_succeeds("effect", effects[i], SIZE, "--frames", "4", "-o", "p.exr", "--preview",
                         "p.png");
        load("p.exr", &image);
        assert_int_equal(image.width, WIDTH);
        assert_int_equal(image.height, HEIGHT);
        check_values(effects[i], &image);
        check_preview("p.png", &image);
        assert_string_equal(attribute(&image, "weft.effect", text), effects[i]);
        assert_string_equal(attribute(&image, "weft.frames", text),
                            strstr(effects[i], "fade") ? "8" : "4");
        assert_string_equal(attribute(&image, "weft.method", text), "exact");
        attribute(&image, "weft.scene", text);
        attribute(&image, "weft.renderer", text);
        weft_image_clear(&image);
    }
}

static void row_0_is_on_top(void **state)
{
    (void)state;
    command_succeeds("effect", "antialias", SIZE, "--scene", "plane", "--frames", "1", "-o",
                     "p.exr");
    check_sky("p.exr");
}

static void the_same_request_gives_the_same_bytes(void **state)
{
    (void)state;
    struct command_result result;
    for (size_t i = 0; i < COUNT(effects); i++) {
        command_succeeds("effect", effects[i], SIZE, "--frames", "3", "-o", "a.exr");
        command_succeeds("effect", effects[i], SIZE, "--frames", "3", "-o", "b.exr", "--threads",
                         "3");
        assert_same_bytes("a.exr", "b.exr", true);
    }
    command_succeeds("effect", "antialias", SIZE, "-o", "a.exr", "--seed", "1");
    command_succeeds("effect", "antialias", SIZE, "-o", "b.exr", "--seed", "2");
    assert_same_bytes("a.exr", "b.exr", false);
    command_succeeds("effect", "antialias", SIZE, "-o", "b.exr", "--seed", "1", "--context",
                     "auto");
    assert_same_bytes("a.exr", "b.exr", true);
    command_run(&result, "weft", "effect", "antialias", SIZE, "-o", "-", "--seed", "1");
    assert_int_equal(result.code, 0);
    assert_memory_equal(result.out, "v/1\x01", 4);
}

// ---- values -------------------------------------------------------------------------------------

// One frame of each scene in the pixels' middles, and their mean in linear light.
static void fades_are_their_weights(void **state)
{
    (void)state;
    static const char *const weights[] = {"0.25,0.75", "1,3"};
    struct weft_image part[2], mean;
    const char *const scenes[2] = {"cube", "plane"};
    int compared = 0;
    for (int i = 0; i < 2; i++) {
        command_succeeds("effect", "antialias", SIZE, "--frames", "1", "--scene", scenes[i], "-o",
                         "p.exr");
        load("p.exr", &part[i]);
    }
    for (size_t w = 0; w < COUNT(weights); w++) {
        command_succeeds("effect", "fade", SIZE, "--scene", "cube,plane", "--weights", weights[w],
                         "-o", "m.exr");
        load("m.exr", &mean);
        for (int c = 0; c < 4; c++)
            for (int i = 0; i < PIXELS; i++) {
                const double a = (double)plane_of(&part[0], channel_names[c])[i],
                             b = (double)plane_of(&part[1], channel_names[c])[i],
                             expected = 0.25 * a + 0.75 * b,
                             m = (double)plane_of(&mean, channel_names[c])[i];
                if (!(fabs(m - expected) <= (double)FLT_EPSILON * (1e-6 + expected)))
                    fail_msg("%s %d: %.9g of %.9g and %.9g", channel_names[c], i, m, a, b);
                compared++;
            }
        weft_image_clear(&mean);
    }
    assert_int_equal(compared, 2 * 4 * PIXELS);
    command_succeeds("effect", "fade", SIZE, "--fade", "0.75", "-o", "n.exr", "--type", "half");
    load("n.exr", &mean);
    assert_int_equal(mean.channels[0].type, WEFT_PIXEL_HALF);
    for (int i = 0; i < PIXELS; i++) {
        const double expected =
            0.25 * (double)plane_of(&part[0], "R")[i] + 0.75 * (double)plane_of(&part[1], "R")[i];
        assert_true(fabs((double)plane_of(&mean, "R")[i] - expected) <=
                    0x1p-11 * expected + 0x1p-24);
    }
    for (int i = 0; i < 2; i++)
        weft_image_clear(&part[i]);
    weft_image_clear(&mean);
}

// Against exact sums of the same frames: each method's bound, and half a code more where frames
// themselves are drawn into codes (and 1/4 more for the renderer's rounding).
static void methods_keep_their_bounds(void **state)
{
    (void)state;
    static const struct {
        const char *option[4];
        double frame_error;
    } methods[] = {
        {{"--method", "float"}, 0.0},
        {{"--method", "tree", "--bits", "32"}, 0.0},
        {{"--method", "tree", "--branching", "2x4"}, 0.75 / 255.0},
        {{"--method", "tree", "--bits", "16"}, 0.75 / 65535.0},
        {{"--method", "blend", "--bits", "32"}, 0.0},
        {{"--method", "blend"}, 0.75 / 255.0},
        {{"--method", "buffer"}, 0.0},
        {{"--method", "float", "--emulate"}, 0.0},
    };
    struct weft_image exact, other;
    command_succeeds("effect", "antialias", SIZE, "--frames", "8", "-o", "e.exr");
    load("e.exr", &exact);
    for (size_t i = 0; i < COUNT(methods); i++) {
        const char *const *o = methods[i].option;
        json_t *root = parse(command_succeeds(
            "effect", "antialias", SIZE, "--frames", "8", "-o", "o.exr", "--json", o[0], o[1],
            o[2] ? o[2] : "--threads=1", o[3] ? o[3] : "--compression=none"));
        const double bound = number(json_object_get(root, "method"), "bound");
        double largest = 0.0;
        load("o.exr", &other);
        for (int c = 0; c < 4; c++)
            for (int k = 0; k < PIXELS; k++)
                largest = fmax(largest, fabs((double)plane_of(&exact, channel_names[c])[k] -
                                             (double)plane_of(&other, channel_names[c])[k]));
        if (!(largest <= bound + methods[i].frame_error + (double)FLT_EPSILON))
            fail_msg("%s %s: %g, beyond %g", o[1], o[2] ? o[2] : "", largest, bound);
        weft_image_clear(&other);
        json_decref(root);
    }
    weft_image_clear(&exact);
}

// ---- files and the camera -----------------------------------------------------------------------

// A square of side 2 in the plane z = 0 that shines, and faces z.
static void make_square(void)
{
    put("square.mtl", "newmtl white\nKd 0 0 0\nKe 1 1 1\n");
    put("square.obj", "mtllib square.mtl\nusemtl white\no square\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\n"
                      "v -1 1 0\nf 1 2 3 4\n");
}
#define BEFORE_IT "--eye", "0,0,4", "--target", "0,0,0", "--fov", "90"

// A picture of 90 degrees is 8 wide at distance 4: the square covers a quarter of each side.
static void files_are_seen_by_the_camera_asked_for(void **state)
{
    (void)state;
    struct weft_image image;
    int inside = 0;
    make_square();
    command_succeeds("effect", "antialias", "--size", "32x32", "--scene", "square.obj", BEFORE_IT,
                     "--frames", "1", "-o", "p.exr");
    load("p.exr", &image);
    for (int y = 0; y < 32; y++)
        for (int x = 0; x < 32; x++) {
            const bool in = x >= 12 && x < 20 && y >= 12 && y < 20;
            const float red = plane_of(&image, "R")[32 * y + x];
            if (in != (red > 0.9f))
                fail_msg("pixel (%d, %d) is %g", x, y, (double)red);
            inside += in;
        }
    assert_int_equal(inside, 64);
    weft_image_clear(&image);
}

// The thin lens: c = A |1/f - 1/z| H / (2 tan(fovy/2)), here 0.5 (1/2 - 1/4) 32 / 2 = 2.
static void the_lens_is_the_thin_one(void **state)
{
    (void)state;
    make_square();
    json_t *root = parse(command_succeeds("effect", "dof", "--size", "32x32", "--scene",
                                          "square.obj", BEFORE_IT, "--focus", "2", "--aperture",
                                          "0.5", "--json", "--explain"));
    const json_t *lens = json_object_get(root, "lens");
    const json_t *nearest = json_object_get(lens, "nearest"),
                 *farthest = json_object_get(lens, "farthest");
    assert_true(number(lens, "aperture") == 0.5 && number(lens, "focus") == 2.0);
    assert_true(fabs(number(nearest, "depth") - 4.0) < 1e-6);
    assert_true(fabs(number(nearest, "circle") - 2.0) < 1e-6);
    assert_true(fabs(number(farthest, "circle") - 2.0) < 1e-6);
    assert_true(number(root, "frames") == ceil(M_PI)); // pi / 4 c^2
    json_decref(root);
}

// One unit in z = 0 is 4 pixels at distance 4 of 32: over half the way while the shutter is open.
static void keyframes_move_what_they_name(void **state)
{
    (void)state;
    make_square();
    put("keys", "# to the right\nsquare 0 0,0,0\nsquare 1 2,0,0\n");
    json_t *root = parse(command_succeeds("effect", "motion-blur", "--size", "32x32", "--scene",
                                          "square.obj", BEFORE_IT, "--keyframes", "keys", "--time",
                                          "0.25..0.75", "--json", "-o", "p.exr"));
    const json_t *need = json_array_get(json_object_get(root, "needs"), 0);
    assert_true(fabs(number(need, "pixels") - 4.0) < 0.05);
    assert_true(number(root, "frames") == number(need, "frames"));
    struct weft_image image;
    load("p.exr", &image);
    // Its left edge goes from pixel 14 to 18, and N midpoints are within 1/(2N) of the ramp.
    const double dark = (double)plane_of(&image, "R")[32 * 16 + 2],
                 light = (double)plane_of(&image, "R")[32 * 16 + 19];
    for (int x = 14; x < 18; x++) {
        const double share = ((double)plane_of(&image, "R")[32 * 16 + x] - dark) / (light - dark);
        assert_true(fabs(share - (x + 0.5 - 14.0) / 4.0) <= 0.5 / number(root, "frames") + 0.01);
    }
    weft_image_clear(&image);
    json_decref(root);
}

static double brightest(const char *light)
{
    json_t *root =
        parse(command_succeeds("effect", "antialias", "--size", "32x32", "--scene", "plain.obj",
                               BEFORE_IT, "--frames", "1", "--json", "--light", light));
    const double most = number(json_array_get(json_object_get(root, "channels"), 0), "maximum");
    json_decref(root);
    return most;
}

static double penumbra(const char *size)
{
    json_t *root = parse(
        command_succeeds("effect", "soft-shadow", "--json", "--explain", "--light-size", size));
    const double pixels = number(json_array_get(json_object_get(root, "needs"), 0), "pixels");
    json_decref(root);
    return pixels;
}

// A lamp far away lights what faces it by the cosine: from the side, from behind not at all. A
// penumbra is as wide as the lamp, where that is small.
static void lamps_are_moved_and_sized(void **state)
{
    (void)state;
    put("plain.obj", "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3 4\n");
    const double before = brightest("0,0,90"), slanted = brightest("90,0,90"),
                 behind = brightest("0,0,-90");
    assert_true(behind > 0.0 && behind < slanted);
    assert_true(fabs((slanted - behind) / (before - behind) - sqrt(0.5)) < 0.02);
    const double narrow = penumbra("0.1"), wide = penumbra("0.2");
    assert_true(narrow > 1.0 && fabs(wide / narrow - 2.0) < 0.1);
}

static void files_of_others_are_drawn(void **state)
{
    (void)state;
    static const char *const files[] = {"spot.obj", "suzanne.obj", "teapot.obj"};
    int drawn = 0;
    for (size_t i = 0; i < COUNT(files); i++) {
        char path[4200];
        struct weft_image image;
        snprintf(path, sizeof path, "%s/../shared/data/mesh/%s", WEFT_SOURCE_DIR, files[i]);
        if (access(path, R_OK) != 0)
            continue;
        command_succeeds("effect", "antialias+soft-shadow+dof", "--scene", path, SIZE, "--frames",
                         "4", "-o", "p.exr");
        load("p.exr", &image);
        check_values(files[i], &image);
        weft_image_clear(&image);
        drawn++;
    }
    if (drawn == 0) {
        print_message("[  SKIPPED ] no meshes in ../shared/data/mesh\n");
        skip();
    }
}

// ---- how many frames ----------------------------------------------------------------------------

static void frames_are_as_many_as_the_picture_needs(void **state)
{
    (void)state;
    static const struct {
        const char *effect;
        double factor, power;
    } cases[] = {{"motion-blur", 1.0, 1.0}, {"dof", 0.25 * M_PI, 2.0}};
    for (size_t i = 0; i < COUNT(cases); i++) {
        json_t *root = parse(command_succeeds("effect", cases[i].effect, "--size", "96x64",
                                              "--frames", "auto", "--json", "--explain"));
        const json_t *need = json_array_get(json_object_get(root, "needs"), 0);
        const double pixels = number(need, "pixels");
        assert_true(pixels > 1.0);
        assert_true(number(need, "frames") == ceil(cases[i].factor * pow(pixels, cases[i].power)));
        assert_true(number(root, "frames") == number(need, "frames"));
        json_decref(root);
    }
    // Of a fade they are of each scene.
    json_t *root = parse(
        command_succeeds("effect", "fade+antialias", SIZE, "--json", "--explain", "--fade", "0.3"));
    assert_true(number(root, "frames") == 32.0 && number(root, "needed") == 16.0);
    json_decref(root);
    root = parse(command_succeeds("effect", "fade+antialias", SIZE, "--json", "--explain"));
    assert_true(number(root, "frames") == 32.0);
    json_decref(root);
}

// As weft accumulate judges: after 16, and whenever a sixteenth has come on top.
static void until_stops_at_numbers_of_its_own(void **state)
{
    (void)state;
    struct weft_image image;
    int64_t judged = 16;
    json_t *root = parse(command_succeeds("effect", "soft-shadow+antialias", SIZE, "--frames",
                                          "600", "--jitter", "sobol", "--until", "0.03", "-o",
                                          "p.exr", "--stderr", "e.exr", "--json"));
    const json_t *until = json_object_get(root, "until");
    const int64_t added = (int64_t)number(root, "added");
    assert_true(json_is_true(json_object_get(until, "met")));
    assert_true(json_is_true(json_object_get(until, "stopped")));
    assert_true(added < 600 && added > 16);
    while (judged < added)
        judged += judged / 16 + 1;
    assert_int_equal(judged, added);
    assert_true(number(until, "judged_after") == (double)added);
    json_decref(root);
    load("e.exr", &image);
    int positive = 0;
    for (int i = 0; i < PIXELS; i++) {
        const double error = (double)plane_of(&image, "R")[i];
        assert_true(error >= 0.0 && error < 0.5);
        positive += error > 0.0;
    }
    assert_true(positive > 0);
    weft_image_clear(&image);
    // Bytes are those of a run that was asked for as many.
    char count[32], text[300];
    snprintf(count, sizeof count, "%lld", (long long)added);
    load("p.exr", &image);
    assert_string_equal(attribute(&image, "weft.frames", text), count);
    weft_image_clear(&image);
}

static void what_does_not_extend_is_told(void **state)
{
    (void)state;
    struct command_result result;
    command_run(&result, "weft", "effect", "antialias", SIZE, "--frames", "66", "--jitter", "j66",
                "--until", "0.5", "--preview", "p.png");
    assert_int_equal(result.code, 0);
    assert_non_null(strstr(result.err, "--until: the first frames of this plan are chosen"));
    assert_non_null(strstr(result.err, "--until 0.5 is met after 16 of 66 frames"));
}

// ---- radiosity ----------------------------------------------------------------------------------

static void radiosity_says_what_clamping_takes(void **state)
{
    (void)state;
    double share[3];
    static const char *const clamps[] = {"off", "auto", "0.00002"};
    for (size_t i = 0; i < COUNT(clamps); i++) {
        json_t *root =
            parse(command_succeeds("effect", "radiosity", SIZE, "--frames", "64", "--light-clamp",
                                   clamps[i], "--json", "--preview", "p.png"));
        const json_t *radiosity = json_object_get(root, "radiosity");
        assert_true(number(radiosity, "lights") == 64.0);
        // Lights are chosen from those of more paths.
        assert_true(number(radiosity, "paths") >= 64.0);
        assert_true((number(radiosity, "clamp") == 0.0) == (i == 0));
        assert_true(number(radiosity, "mean_reflectance") > 0.3);
        assert_true(number(radiosity, "mean_reflectance") < 0.8);
        const json_t *lost = json_object_get(radiosity, "lost_share");
        assert_true(json_is_null(lost) == (i == 0));
        share[i] = i ? json_number_value(lost) : 0.0;
        json_decref(root);
    }
    assert_true(share[1] >= 0.0 && share[2] > share[1] && share[2] < 1.0);
    json_t *root = parse(
        command_succeeds("effect", "radiosity", SIZE, "--paths", "16", "--json", "--explain"));
    assert_true(number(json_object_get(root, "radiosity"), "paths") == 16.0);
    assert_true(number(root, "frames") > 16.0);
    json_decref(root);
}

// ---- reports ------------------------------------------------------------------------------------

static void lists_are_printed(void **state)
{
    (void)state;
    assert_non_null(strstr(command_succeeds("effect", "--scene", "help"), "  cornell "));
    assert_non_null(strstr(command_succeeds("effect", "dof", "--jitter", "help"), "  j66 "));
    assert_non_null(strstr(command_succeeds("effect", "--kernel", "help"), "mitchell"));
}

static void the_plan_is_explained_and_nothing_drawn(void **state)
{
    (void)state;
    const int before = command_folder_size();
    const char *text =
        command_succeeds("effect", "antialias+dof", SIZE, "--jitter", "j66", "--kernel", "mitchell",
                         "--explain", "-o", "never.exr", "--method", "float");
    static const char *const parts[] = {"antialias+dof of plane, 48 x 32: 66 frames",
                                        "pixel: j66 of 66 points on a square of 4",
                                        "lens: j66 of 66 points on a disc of ",
                                        "filter: mitchell",
                                        "lens: aperture ",
                                        "weights: the largest is ",
                                        "method: float",
                                        "bound: ",
                                        "passes: 66, one a frame"};
    for (size_t i = 0; i < COUNT(parts); i++)
        if (!strstr(text, parts[i]))
            fail_msg("no \"%s\" in:\n%s", parts[i], text);
    assert_int_equal(command_folder_size(), before);
}

static void lines_say_what_came_of_it(void **state)
{
    (void)state;
    struct command_result result;
    const char *text =
        command_succeeds("effect", "dof", SIZE, "--frames", "4", "--preview", "p.png");
    assert_non_null(strstr(text, "dof of plane: 4 frames, exact, "));
    assert_non_null(strstr(text, "lens: aperture "));
    assert_non_null(strstr(text, "p.png: values from 0 to 1"));
    assert_string_equal(
        command_succeeds("effect", "dof", SIZE, "--frames", "4", "--preview", "p.png", "-q"), "");
    // What targets of codes cut off is told: the lamp of the Cornell box.
    command_run(&result, "weft", "effect", "antialias", SIZE, "--scene", "cornell", "--method",
                "tree", "--preview", "p.png");
    assert_int_equal(result.code, 0);
    assert_non_null(strstr(result.err, "targets of 8 bits hold light from 0 to 1, and there is"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_effect_makes_its_picture),
        cmocka_unit_test(row_0_is_on_top),
        cmocka_unit_test(the_same_request_gives_the_same_bytes),
        cmocka_unit_test(fades_are_their_weights),
        cmocka_unit_test(methods_keep_their_bounds),
        cmocka_unit_test(files_are_seen_by_the_camera_asked_for),
        cmocka_unit_test(the_lens_is_the_thin_one),
        cmocka_unit_test(keyframes_move_what_they_name),
        cmocka_unit_test(lamps_are_moved_and_sized),
        cmocka_unit_test(files_of_others_are_drawn),
        cmocka_unit_test(frames_are_as_many_as_the_picture_needs),
        cmocka_unit_test(until_stops_at_numbers_of_its_own),
        cmocka_unit_test(what_does_not_extend_is_told),
        cmocka_unit_test(radiosity_says_what_clamping_takes),
        cmocka_unit_test(lists_are_printed),
        cmocka_unit_test(the_plan_is_explained_and_nothing_drawn),
        cmocka_unit_test(lines_say_what_came_of_it),
    };
    return cmocka_run_group_tests(tests, set_up, command_teardown);
}
