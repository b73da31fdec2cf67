// SPDX-License-Identifier: BSD-3-Clause
// What is up in a picture, how it is mirrored and framed, and where its volume is: pixels against
// the voxels that they must be, and against those of the slice as it is by itself.
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include <cmocka.h>

#include "tests/support/command.h"
#include "tests/support/json.h"
#include "weft.h"

// Voxels 0.5 wide that are alike under no turn: every cell's edge is a fraction that is exact.
enum { NX = 12, NY = 7, NZ = 9 };
static const int voxels[3] = {NX, NY, NZ};
static const char layout[] = "12x7x9:uint8:spacing=0.5,0.5,0.5";

static struct command_result result;

static uint8_t voxel(const int at[3])
{
    return (uint8_t)((at[0] * 31 + at[1] * 57 + at[2] * 101 + at[0] * at[1] * 7) % 251);
}

static int make_volumes(void **state)
{
    uint8_t data[NX * NY * NZ];
    if (command_setup(state) != 0)
        return -1;
    for (int i = 0; i < NX * NY * NZ; i++)
        data[i] = voxel((int[]){i % NX, i / NX % NY, i / NX / NY});
    command_write_file("a.raw", data, sizeof data);
    return 0;
}

// Runs weft slice a.raw -o o.exr with these options, and loads the pixels; to be freed.
static float *slice_pixels(const char *const *options, int *width, int *height)
{
    const char *args[32] = {"weft", "slice", "a.raw",    "--raw", layout,
                            "-o",   "o.exr", "--engine", "cpu"};
    int count = 9;
    for (int i = 0; options[i]; i++)
        args[count++] = options[i];
    command_run_list(&result, args);
    if (result.code != 0)
        fail_msg("%s", result.err);
    struct weft_image image;
    assert_int_equal(weft_image_load(weft_image_load_params(.path = "o.exr"), &image), WEFT_OK);
    const size_t bytes = (size_t)image.width * (size_t)image.height * sizeof(float);
    float *pixels = malloc(bytes);
    assert_non_null(pixels);
    memcpy(pixels, image.channels[0].plane, bytes);
    *width = image.width;
    *height = image.height;
    weft_image_clear(&image);
    return pixels;
}

// ---- up and flip --------------------------------------------------------------------------------

// Of a picture with a pixel for each voxel: which voxel it is, by the rule in words.
static int expected_voxel(int axis, int right, int up, int sign, int x, int y)
{
    int at[3];
    at[axis] = 3;
    at[right] = x;
    at[up] = sign > 0 ? voxels[up] - 1 - y : y;
    return voxel(at);
}

// The named axis runs up, and the other one to the right.
static void the_named_axis_points_up(void **state)
{
    (void)state;
    static const char *const axes[] = {"x", "y", "z"};
    int checked = 0;
    for (int axis = 0; axis < 3; axis++)
        for (int up = 0; up < 3; up++)
            for (int sign = -1; sign <= 1; sign += 2) {
                char option[16], size[32], at[16];
                const int right = 3 - axis - up;
                if (up == axis)
                    continue;
                snprintf(option, sizeof option, "--up=%s%s", sign < 0 ? "-" : "", axes[up]);
                snprintf(size, sizeof size, "%dx%d", voxels[right], voxels[up]);
                snprintf(at, sizeof at, "%g", 3 * 0.5);
                int width, height;
                float *pixels =
                    slice_pixels((const char *[]){"--axis", axes[axis], "--at", at, "--size", size,
                                                  option, "--kernel", "nearest", NULL},
                                 &width, &height);
                assert_string_equal(result.err, "");
                assert_true(width == voxels[right] && height == voxels[up]);
                for (int y = 0; y < height; y++)
                    for (int x = 0; x < width; x++)
                        assert_int_equal((int)pixels[y * width + x],
                                         expected_voxel(axis, right, up, sign, x, y));
                checked++;
                free(pixels);
            }
    assert_int_equal(checked, 12);
}

// Between voxels, with a cubic kernel: to the bit what the slice by itself has.
static void mirrored_pixels_are_the_same(void **state)
{
    (void)state;
    static const struct {
        const char *options[3];
        bool columns, rows;
    } cases[] = {{{"--flip", "x"}, true, false},  {{"--flip", "y"}, false, true},
                 {{"--flip", "xy"}, true, true},  {{"--up", "y"}, false, true},
                 {{"--up", "-y"}, false, false},  {{"--up", "y", "--flip=y"}, false, false},
                 {{"--up", "0,3,8"}, false, true}};
    int width, height, w, h;
    float *plain =
        slice_pixels((const char *[]){"--at", "1.125", "--size", "48", NULL}, &width, &height);
    assert_true(width == 48 && height == 28);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const char *const *o = cases[i].options;
        float *turned = slice_pixels(
            (const char *[]){"--at", "1.125", "--size", "48x0", o[0], o[1], o[2], NULL}, &w, &h);
        assert_true(w == width && h == height);
        for (int y = 0; y < h; y++)
            for (int x = 0; x < w; x++) {
                const int from_x = cases[i].columns ? w - 1 - x : x;
                const int from_y = cases[i].rows ? h - 1 - y : y;
                const float *a = &turned[y * w + x], *b = &plain[from_y * w + from_x];
                if (memcmp(a, b, sizeof *a) != 0)
                    fail_msg("%s: pixel (%d, %d) is %.9g instead of %.9g", o[0], x, y, (double)*a,
                             (double)*b);
            }
        free(turned);
    }
    free(plain);
}

static void wrong_framing_is_one_line(void **state)
{
    (void)state;
    static const struct {
        const char *text, *args[10];
    } cases[] = {
        {"x, -x, y and -y lie in it", {"--up", "z"}},
        {"y, -y, z and -z lie in it", {"--up", "3,0,0", "--axis", "x"}},
        {"it is x, -x", {"--up", "up"}},
        {"it is x, -x", {"--up", "0,0,0"}},
        {"it is x, -x", {"--up", "1,2"}},
        {"square to the plane",
         {"--origin", "0,0,1", "--u", "1,1,0", "--v", "1,-1,0", "--up", "z"}},
        {"is not one of: x, y, xy", {"--flip", "z"}},
        {"--up is of planes, and not of --positions", {"--positions", "p.exr", "--up", "y"}},
        {"--flip is of planes, and not of --along",
         {"--along", "p", "--width", "1", "--flip", "x"}},
        {"tells what their image must be", {"--positions", "p.exr", "--size", "9"}},
        {"--box is what planes of --axis show",
         {"--origin", "0,0,1", "--u", "1,0,0", "--v", "0,1,0", "--box", "0,0,0,1,1,1"}},
        {"with a volume each", {"--box", "first"}},
        {"it is all, first, or a box", {"--box", "0,0,0,1,1"}},
        {"along y it reaches from 2 to 1", {"--box", "0,2,0,1,1,1"}},
        {"or N, the longer side", {"--size", "2x"}},
        {"one of them 0", {"--size", "0x0"}},
        {"one of them 0", {"--size", "0"}},
        {"one of them 0", {"--size", "2000000x0"}},
        {"--at: '5%%'", {"--at", "5%%"}},
        {"--up is not of --planes",
         {"--planes", "p.txt", "--frames", "0-1", "--up", "y", "--preview", "a%d.png"}},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const char *args[16] = {"weft", "slice", "ml.vdb", "-o", "x.exr"};
        int count = 5;
        if (!strcmp(cases[i].args[0], "--planes"))
            count = 3;
        for (int j = 0; cases[i].args[j]; j++)
            args[count++] = cases[i].args[j];
        command_fails_list(__FILE__, __LINE__, 2, cases[i].text, args);
    }
}

// ---- sizes and places ---------------------------------------------------------------------------

static void explain(json_t **root, const char *const *options)
{
    const char *args[32] = {"weft", "slice"};
    int count = 2;
    for (int i = 0; options[i]; i++)
        args[count++] = options[i];
    args[count++] = "--explain";
    args[count++] = "--json";
    command_run_list(&result, args);
    if (result.code != 0)
        fail_msg("%s", result.err);
    *root = parse(result.out);
}

static double number_at(const json_t *object, const char *key, int i)
{
    return json_number_value(json_array_get(json_object_get(object, key), (size_t)i));
}

// The picture is 6 x 3.5 world units.
static void pixels_stay_square(void **state)
{
    (void)state;
    static const struct {
        const char *size, *up, *told;
        int width, height;
    } cases[] = {
        {"48", "--up=-y", NULL, 48, 28},
        {"48", "--up=x", NULL, 28, 48},
        {"0x56", "--up=y", NULL, 96, 56},
        {"24x0", "--up=y", NULL, 24, 14},
        {"24x13", "--up=y", NULL, 24, 13},
        {"48x56", "--up=y", "2 times as wide as high", 48, 56},
        {"48x30", "--up=y", "7.1 % wider than high in world space; 48x0 or 0x30 keeps", 48, 30},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        json_t *root;
        explain(&root, (const char *[]){"a.raw", "--raw", layout, "--size", cases[i].size,
                                        cases[i].up, NULL});
        const json_t *g = json_object_get(root, "geometry");
        assert_int_equal((int)number(g, "width"), cases[i].width);
        assert_int_equal((int)number(g, "height"), cases[i].height);
        if (cases[i].told ? !strstr(result.err, cases[i].told) : *result.err)
            fail_msg("%s: %s", cases[i].size, result.err);
        json_decref(root);
    }
}

static void places_are_parts_of_the_box(void **state)
{
    (void)state;
    json_t *root;
    explain(&root, (const char *[]){"a.raw", "--raw", layout, "--axis", "x", "--at", "25%", NULL});
    assert_true(number_at(json_object_get(root, "geometry"), "origin", 0) == -0.25 + 0.25 * 6.0);
    json_decref(root);
    explain(&root, (const char *[]){"a.raw", "--raw", layout, "--at", "75%", "--box", "1,1,0,2,3,8",
                                    NULL});
    const json_t *g = json_object_get(root, "geometry");
    assert_true(number_at(g, "origin", 2) == 6.0 && number_at(g, "origin", 0) == 1.0);
    assert_true(number_at(g, "u", 0) == 1.0 && number_at(g, "v", 1) == 2.0);
    json_decref(root);
}

// ---- sequences ----------------------------------------------------------------------------------

static json_t *world_box(const char *path)
{
    const char *out = command_succeeds("info", path, "--json");
    json_t *root = parse(out);
    json_t *box = json_incref(
        json_object_get(json_array_get(json_object_get(root, "grids"), 0), "world_box"));
    json_decref(root);
    return box;
}

// The second volume lies beside the first: what all frames show holds both.
static void all_frames_show_one_box(void **state)
{
    (void)state;
    command_succeeds("make", "sphere", "-o", "puff_1.vdb", "--size", "16", "--offset", "1,2,3");
    command_succeeds("make", "sphere", "-o", "puff_2.vdb", "--size", "20", "--offset", "40,-8,0");
    json_t *box[2] = {world_box("puff_1.vdb"), world_box("puff_2.vdb")}, *root;
    double low[3], high[3];
    for (int a = 0; a < 3; a++) {
        const double from[2] = {number_at(box[0], "min", a), number_at(box[1], "min", a)};
        const double to[2] = {number_at(box[0], "max", a), number_at(box[1], "max", a)};
        low[a] = from[0] < from[1] ? from[0] : from[1];
        high[a] = to[0] > to[1] ? to[0] : to[1];
    }
    static const char *const boxes[] = {"--box=all", "--box=first", "--box=0,0,0,9,8,7"};
    for (int i = 0; i < 3; i++) {
        explain(&root, (const char *[]){"puff_%d.vdb", "--frames", "1-2", i ? boxes[i] : "--axis=z",
                                        NULL});
        if (i == 0)
            assert_string_equal(result.err, "");
        const json_t *frames = json_object_get(root, "frames");
        assert_int_equal(json_array_size(frames), 2);
        for (int f = 0; f < 2; f++) {
            const json_t *g = json_object_get(json_array_get(frames, (size_t)f), "geometry");
            const double wanted[3][2] = {{low[0], high[0]},
                                         {number_at(box[0], "min", 0), number_at(box[0], "max", 0)},
                                         {0.0, 9.0}};
            assert_true(number_at(g, "origin", 0) == wanted[i][0]);
            assert_true(number_at(g, "u", 0) == wanted[i][1] - wanted[i][0]);
            if (i == 0)
                assert_true(number_at(g, "origin", 1) == low[1] &&
                            number_at(g, "origin", 2) == 0.5 * (low[2] + high[2]));
        }
        json_decref(root);
    }
    json_decref(box[0]);
    json_decref(box[1]);
}

// ---- boxes and misses ---------------------------------------------------------------------------

static void boxes_are_in_the_world(void **state)
{
    (void)state;
    static const char turned[] = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\n"
                                 "space dimension: 3\nspace directions: (1,1,0) (-1,1,0) (0,0,2)\n"
                                 "space origin: (10,0,0)\nencoding: raw\n\n12345678";
    json_t *box;
    command_write_file("turned.nrrd", turned, sizeof turned - 1);
    command_run(&result, "weft", "info", "a.raw", "--raw", layout);
    assert_non_null(
        strstr(result.out, "(-0.25, -0.25, -0.25) to (5.75, 3.25, 4.25): 6 x 3.5 x 4.5\n"));
    box = world_box("turned.nrrd");
    assert_true(json_is_true(json_object_get(box, "encloses")));
    // Cells from -1/2 to 3/2: x = 10 + i - j, y = i + j, z = 2 k.
    static const double low[3] = {8, -1, -1}, high[3] = {12, 3, 3};
    for (int a = 0; a < 3; a++)
        assert_true(number_at(box, "min", a) == low[a] && number_at(box, "max", a) == high[a]);
    json_decref(box);
    command_run(&result, "weft", "info", "turned.nrrd");
    assert_non_null(strstr(result.out, "whose axes are not the world's"));
}

static void what_misses_says_what_would_not(void **state)
{
    (void)state;
    static const char far[] = "20,20,20\n30,30,30\n";
    json_t *root;
    explain(&root, (const char *[]){"ml.vdb", "--at", "20", NULL});
    json_decref(root);
    assert_non_null(
        strstr(result.err, "nearest plane across z that meets it is at 15.5; in index"));
    explain(&root, (const char *[]){"ml.vdb", "--at=-20", "--space", "index", "--axis", "y", NULL});
    json_decref(root);
    assert_non_null(strstr(result.err, "nearest plane across y that meets it is at 0\n"));
    // Of a slab one line, and none where a part of it meets the volume.
    command_run(&result, "weft", "slice", "ml.vdb", "--at", "30", "--slab", "4", "--size", "8",
                "--engine", "cpu", "-o", "s.exr");
    assert_int_equal(result.code, 0);
    assert_non_null(strstr(result.err, "misses grid"));
    assert_ptr_equal(strchr(result.err, '\n'), result.err + strlen(result.err) - 1);
    command_run(&result, "weft", "slice", "ml.vdb", "--at", "18", "--slab", "6", "--size", "8",
                "--engine", "cpu", "-o", "s.exr");
    assert_string_equal(result.err, "");
    command_write_file("far.csv", far, sizeof far - 1);
    command_run(&result, "weft", "probe", "ml.vdb", "--points", "far.csv");
    assert_non_null(strstr(result.err, "to (15.75, 15.75, 15.75) in world space"));
    assert_non_null(strstr(result.err, "in index space 2 of them would lie inside"));
}

static void grids_are_suggested(void **state)
{
    (void)state;
    command_fails(2, "did you mean 'marschner-lobb'?", "slice", "ml.vdb", "--grid", "marschner-lob",
                  "-o", "o.exr");
    command_fails(2, "did you mean 'sphere'? capitals count", "probe", "sphere.vdb", "--points",
                  "far.csv", "--grid", "Sphere");
    command_fails(2, "did you mean 'sphere'", "convert", "sphere.vdb", "c.nrrd", "--grid",
                  "spehre");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_named_axis_points_up),
        cmocka_unit_test(mirrored_pixels_are_the_same),
        cmocka_unit_test(wrong_framing_is_one_line),
        cmocka_unit_test(pixels_stay_square),
        cmocka_unit_test(places_are_parts_of_the_box),
        cmocka_unit_test(all_frames_show_one_box),
        cmocka_unit_test(boxes_are_in_the_world),
        cmocka_unit_test(what_misses_says_what_would_not),
        cmocka_unit_test(grids_are_suggested),
    };
    return cmocka_run_group_tests(tests, make_volumes, command_teardown);
}
