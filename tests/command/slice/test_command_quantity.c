// SPDX-License-Identifier: BSD-3-Clause
// weft slice of several grids, vectors and quantities, of slabs and along curves: what channels are
// called and hold.
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "tests/support/command.h"
#include "tests/support/common.h"
#include "tests/support/json.h"
#include "tiles/image/image.h"

static struct weft_image loaded(const char *path)
{
    struct weft_image image;
    setenv("WEFT_LIBEXEC", WEFT_BINARY_DIR, 1);
    assert_int_equal(
        weft_image_load(weft_image_load_params(.path = path, .log = &log_to_stderr), &image),
        WEFT_OK);
    return image;
}

static const float *channel(const struct weft_image *image, const char *name)
{
    for (size_t i = 0; i < image->channel_count; i++)
        if (strcmp(image->channels[i].name, name) == 0)
            return image->channels[i].plane;
    fail_msg("no channel %s among %zu", name, image->channel_count);
    return NULL;
}

// ---- grids --------------------------------------------------------------------------------------

// The bytes of a channel are those of a slice of that grid alone.
static void grids_are_channels_by_name(void **state)
{
    (void)state;
    static const char *const grids[] = {"float", "double", "int32", "twin[1]"};
    command_succeeds("slice", "types.vdb", "--grid", "float,double,int32,twin[1]", "-o", "a.exr",
                     "--engine", "cpu", "--size", "16x12", "-q");
    struct weft_image all = loaded("a.exr");
    assert_int_equal(all.channel_count, 4);
    for (size_t i = 0; i < WEFT_COUNT(grids); i++) {
        command_succeeds("slice", "types.vdb", "--grid", grids[i], "-o", "b.exr", "--engine", "cpu",
                         "--size", "16x12", "-q");
        struct weft_image one = loaded("b.exr");
        assert_int_equal(one.channel_count, 1);
        assert_memory_equal(channel(&all, grids[i]), channel(&one, "Y"), 16 * 12 * sizeof(float));
        weft_image_clear(&one);
    }
    weft_image_clear(&all);
    command_succeeds("slice", "types.vdb", "--grid", "all", "-o", "a.exr", "--engine", "cpu",
                     "--size", "8x8", "-q");
    all = loaded("a.exr");
    assert_int_equal(all.channel_count, 7 + 4 * 3);
    channel(&all, "vec3i.Z");
    weft_image_clear(&all);
    unlink("a.exr");
    unlink("b.exr");
}

// Component c of these vectors is 100 c more than the scalar grid.
static void vectors_have_three_channels(void **state)
{
    (void)state;
    static const char *const kinds[] = {"vec3s", "vec3d", "vec3h", "vec3i"};
    command_succeeds("slice", "types.vdb", "--grid", "float", "-o", "b.exr", "--engine", "cpu",
                     "--size", "16x12", "-q");
    struct weft_image scalar = loaded("b.exr");
    const float *base = channel(&scalar, "Y");
    for (size_t k = 0; k < WEFT_COUNT(kinds); k++) {
        command_succeeds("slice", "types.vdb", "--grid", kinds[k], "-o", "a.exr", "--engine", "cpu",
                         "--size", "16x12", "-q", "--verify", "--preview", "a.png");
        struct weft_image image = loaded("a.exr");
        const float *of[3] = {channel(&image, "X"), channel(&image, "Y"), channel(&image, "Z")};
        assert_int_equal(image.channel_count, 3);
        // Away from the background; halves of values up to 275 are off by 0.13 at most.
        for (int i = 3 * 16; i < 9 * 16; i++)
            for (int c = 0; c < 3 && i % 16 >= 3 && i % 16 < 13; c++)
                assert_near((double)of[c][i], (double)base[i] + 100.0 * c, 0.3, kinds[k]);
        weft_image_clear(&image);
    }
    weft_image_clear(&scalar);
    unlink("a.exr");
    unlink("a.png");
    unlink("b.exr");
}

// The samples of component c lie half a voxel along -c: the values are linear in the index, so that
// each component is off by half of that from one at the cells' middles.
static void staggered_grids_lie_at_faces(void **state)
{
    (void)state;
    json_t *root = parse(command_succeeds("slice", "kinds.vdb", "--grid", "vector", "--json",
                                          "--engine", "cpu", "--size", "8x8", "--verify"));
    json_t *channels = json_object_get(root, "channels");
    assert_int_equal(json_array_size(channels), 3);
    assert_true(number(json_object_get(root, "error"), "max") <= number(root, "bound"));
    json_decref(root);
    command_fails(2, "do not lie at the same places", "slice", "kinds.vdb", "--grid", "vector",
                  "--json", "--space", "index");
}

static void bad_lists_are_refused(void **state)
{
    (void)state;
    command_fails(2, "float is there twice", "slice", "types.vdb", "--json", "--grid",
                  "float,half,float");
    command_fails(2, "is empty", "slice", "types.vdb", "--json", "--grid", "float,");
    command_fails(2, "no grid 'flot'", "slice", "types.vdb", "--json", "--grid", "float,flot");
    command_fails(2, "--max-error chooses", "slice", "types.vdb", "--json", "--grid", "float,half",
                  "--max-error", "8bit");
    command_fails(2, "--max-error chooses", "slice", "types.vdb", "--json", "--grid", "vec3s",
                  "--max-error", "8bit");
    command_fails(2, "needs --range", "slice", "types.vdb", "--grid", "float,half", "--frames",
                  "1-2", "--at", "1..2", "--preview", "a%02d.png");
}

// Frames of several grids are those slices.
static void frames_have_the_same_channels(void **state)
{
    (void)state;
    command_succeeds("slice", "types.vdb", "--grid", "float,vec3i", "--frames", "1-3", "--at",
                     "1..5", "--engine", "cpu", "-o", "f%d.exr", "--size", "8x8", "-q");
    command_succeeds("slice", "types.vdb", "--grid", "float,vec3i", "--at", "3", "--engine", "cpu",
                     "-o", "a.exr", "--size", "8x8", "-q");
    struct weft_image frame = loaded("f2.exr"), one = loaded("a.exr");
    assert_int_equal(frame.channel_count, 4);
    for (int i = 0; i < 4; i++)
        assert_memory_equal(frame.channels[i].plane, one.channels[i].plane, 64 * sizeof(float));
    weft_image_clear(&frame);
    weft_image_clear(&one);
    for (int i = 1; i <= 3; i++) {
        char name[16];
        snprintf(name, sizeof name, "f%d.exr", i);
        assert_int_equal(unlink(name), 0);
    }
    unlink("a.exr");
}

// ---- quantities ---------------------------------------------------------------------------------

#define PLANE_U "6,1,0.5"
#define PLANE_V "-1,6,2"
enum { W = 12, H = 10 };

// An oblique plane through the middle, moved along x by `by` world units; kernel and engine too.
static struct weft_image cut(const char *volume, const char *origin, const char *quantity,
                             const char *engine)
{
    command_succeeds("slice", volume, "--origin", origin, "--u", PLANE_U, "--v", PLANE_V, "--size",
                     "12x10", "--kernel", "bspline", "--quantity", quantity, "--engine", engine,
                     "-o", "q.exr", "-q");
    struct weft_image image = loaded("q.exr");
    unlink("q.exr");
    return image;
}

// Of values half a tenth of a voxel apart along each axis of the world.
static void gradients_are_differences(void **state)
{
    (void)state;
    static const char *const moved[3][2] = {
        {"4.475,5,6", "4.525,5,6"}, {"4.5,4.975,6", "4.5,5.025,6"}, {"4.5,5,5.975", "4.5,5,6.025"}};
    static const char *const names[] = {"gradient.X", "gradient.Y", "gradient.Z"};
    struct weft_image whole = cut("ml.vdb", "4.5,5,6", "gradient,value,laplacian", "cpu");
    assert_int_equal(whole.channel_count, 5);
    double steepest = 0.0;
    for (int a = 0; a < 3; a++) {
        struct weft_image from = cut("ml.vdb", moved[a][0], "value", "cpu"),
                          to = cut("ml.vdb", moved[a][1], "value", "cpu");
        for (int i = 0; i < W * H; i++) {
            const double slope =
                ((double)channel(&to, "Y")[i] - (double)channel(&from, "Y")[i]) / 0.05;
            // Third derivatives are at most 8 of voxels from 0 to 1, that is 64, times step^2 / 24;
            // and floats are off by 2^-24 at either end.
            assert_near((double)channel(&whole, names[a])[i], slope, 64.0 * 0.0025 / 24.0 + 1e-5,
                        names[a]);
            steepest = fmax(steepest, fabs(slope));
        }
        weft_image_clear(&from);
        weft_image_clear(&to);
    }
    assert_true(steepest > 0.05);
    weft_image_clear(&whole);
}

// The value's bytes do not depend on what else is made of the voxels; both engines agree within
// what --verify holds them to.
static void quantities_are_verified(void **state)
{
    (void)state;
    static const char all[] = "value,gradient,gradient-magnitude,normal,hessian,laplacian,"
                              "mean-curvature,gaussian-curvature,principal-curvatures";
    for (int gl = 0; gl <= (int)command_has_gl(); gl++) {
        const char *engine = gl ? "gl" : "cpu";
        json_t *root =
            parse(command_succeeds("slice", "sphere.vdb", "--kernel", "bspline", "--quantity", all,
                                   "--size", "24x20", "--engine", engine, "--verify", "--json"));
        json_t *outputs = json_object_get(root, "outputs");
        json_t *channels = json_object_get(root, "channels");
        assert_int_equal(json_array_size(outputs), 10);
        assert_int_equal(json_array_size(channels), 19);
        for (size_t i = 0; i < 10; i++) {
            const json_t *o = json_array_get(outputs, i);
            assert_true(number(json_object_get(o, "error"), "max") <= number(o, "bound") &&
                        number(o, "bound") > 0.0);
        }
        assert_string_equal(json_string_value(json_object_get(json_array_get(channels, 9), "name")),
                            "hessian.XY");
        json_decref(root);
    }
    struct weft_image plain = cut("sphere.vdb", "-3,-4,0", "value", "cpu");
    struct weft_image more = cut("sphere.vdb", "-3,-4,0", "normal,value", "cpu");
    for (int i = 0; i < W * H; i++)
        assert_near((double)channel(&more, "Y")[i], (double)channel(&plain, "Y")[i], 1e-5, "value");
    weft_image_clear(&plain);
    weft_image_clear(&more);
}

static void passes_make_one_after_another(void **state)
{
    (void)state;
    if (!command_has_gl())
        skip();
    json_t *root = parse(command_succeeds("slice", "ml.vdb", "--kernel", "bspline", "--quantity",
                                          "value,gradient", "--size", "16x12", "--profile",
                                          "unorm16", "--verify", "--json", "--resolution", "16"));
    json_t *outputs = json_object_get(root, "outputs");
    assert_int_equal(json_array_size(outputs), 4);
    for (size_t i = 0; i < 4; i++) {
        const json_t *o = json_array_get(outputs, i);
        assert_true(number(json_object_get(o, "error"), "max") <= number(o, "bound"));
        assert_true(number(json_object_get(o, "error"), "max") > 0.0); // 16 bits are not floats
    }
    json_decref(root);
}

static void previews_of_vectors_are_colours(void **state)
{
    (void)state;
    const char *out = command_succeeds("slice", "sphere.vdb", "--quantity", "normal", "--size",
                                       "16x16", "--engine", "cpu", "--preview", "n.png");
    assert_non_null(strstr(out, "values from -1 to 1"));
    const char *info = command_succeeds("info", "n.png");
    assert_non_null(strstr(info, "16 x 16"));
    unlink("n.png");
}

// ---- slabs --------------------------------------------------------------------------------------

static float *slab(const char *thickness, const char *combine, const char *quantity)
{
    command_succeeds("slice", "ml.vdb", "--origin", "4.5,5,6", "--u", PLANE_U, "--v", PLANE_V,
                     "--size", "12x10", "--engine", "cpu", "--slab", thickness, "--combine",
                     combine, "--quantity", quantity, "-o", "q.exr", "-q");
    struct weft_image image = loaded("q.exr");
    float *out = malloc(W * H * sizeof *out);
    memcpy(out, image.channels[0].plane, W * H * sizeof *out);
    weft_image_clear(&image);
    unlink("q.exr");
    return out;
}

static void slabs_are_combined(void **state)
{
    (void)state;
    float *mean = slab("2", "mean", "value"), *sum = slab("2", "sum", "value");
    float *least = slab("2", "min", "value"), *most = slab("2", "max", "value");
    float *steep = slab("2", "max", "gradient-magnitude");
    int apart = 0;
    for (int i = 0; i < W * H; i++) {
        assert_true(least[i] <= mean[i] && mean[i] <= most[i]);
        assert_near((double)sum[i], 2.0 * (double)mean[i], 1e-6, "integral");
        assert_true(steep[i] >= 0.0f);
        apart += most[i] > least[i] + 0.01f;
    }
    assert_true(apart > W * H / 2);
    free(mean);
    free(sum);
    free(least);
    free(most);
    free(steep);
    json_t *root = parse(command_succeeds("slice", "ml.vdb", "--slab", "1", "--size", "8x8",
                                          "--engine", "cpu", "--json"));
    const json_t *told = json_object_get(root, "slab");
    assert_true(number(told, "cuts") == 4.0 && number(told, "spacing") == 0.25);
    json_decref(root);
}

static void bad_slabs_are_refused(void **state)
{
    (void)state;
    command_fails(2, "a length above 0, not 0", "slice", "ml.vdb", "--json", "--slab", "0");
    command_fails(2, "'nan' is not one finite number", "slice", "ml.vdb", "--json", "--slab",
                  "nan");
    command_fails(3, "there may be at most 65536", "slice", "ml.vdb", "--json", "--slab", "1e12");
    command_fails(2, "--combine is of a --slab", "slice", "ml.vdb", "--json", "--combine", "max");
    command_fails(2, "--slab excludes --verify", "slice", "ml.vdb", "--slab", "1", "--verify");
    command_fails(2, "--slab excludes --profile", "slice", "ml.vdb", "--json", "--slab", "1",
                  "--profile", "unorm8");
}

// ---- curves -------------------------------------------------------------------------------------

static void write_positions(const char *path, const char *const names[3], bool holes)
{
    static float plane[3][W * H];
    static const float u[3] = {6.0f, 1.0f, 0.5f}, v[3] = {-1.0f, 6.0f, 2.0f};
    static const float origin[3] = {4.5f, 5.0f, 6.0f};
    struct weft_image_channel channels[3] = {{.type = WEFT_PIXEL_FLOAT}};
    for (int a = 0; a < 3; a++) {
        for (int i = 0; i < W * H; i++)
            plane[a][i] = holes && i == 17 + a ? NAN
                                               : origin[a] + ((float)(i % W) + 0.5f) / W * u[a] +
                                                     ((float)(i / W) + 0.5f) / H * v[a];
        channels[a] = (struct weft_image_channel){.type = WEFT_PIXEL_FLOAT, .plane = plane[a]};
        snprintf(channels[a].name, sizeof channels[a].name, "%s", names[a]);
    }
    const struct weft_image image = {
        .width = W, .height = H, .channel_count = 3, .channels = channels};
    assert_int_equal(
        weft_image_save(&image, weft_image_save_params(.path = path, .log = &log_to_stderr)),
        WEFT_OK);
}

static const char *const xyz[] = {"X", "Y", "Z"};

// Points at a plane's pixels have its values, as far as floats hold where they are.
static void positions_are_where_pixels_lie(void **state)
{
    (void)state;
    struct command_result r;
    write_positions("p.exr", xyz, true);
    command_run(&r, "weft", "slice", "ml.vdb", "--positions", "p.exr", "--kernel", "bspline",
                "--quantity", "value,gradient", "-o", "q.exr");
    assert_int_equal(r.code, 0);
    assert_non_null(strstr(r.err, "3 of 120 positions are not finite"));
    struct weft_image curve = loaded("q.exr");
    struct weft_image plane = cut("ml.vdb", "4.5,5,6", "value,gradient", "cpu");
    assert_int_equal(curve.channel_count, 4);
    int holes = 0;
    for (size_t c = 0; c < 4; c++)
        for (int i = 0; i < W * H; i++) {
            const double value = (double)channel(&curve, plane.channels[c].name)[i];
            holes += isnan(value);
            assert_int_equal(isnan(value), i >= 17 && i < 20);
            if (!isnan(value)) // positions are off by 2^-21; slopes are at most 8
                assert_near(value, (double)plane.channels[c].plane[i], 2e-5, "a point");
        }
    assert_int_equal(holes, 12);
    weft_image_clear(&curve);
    weft_image_clear(&plane);
    unlink("p.exr");
    unlink("q.exr");
}

// Along a straight line it is a plane: rows across it, in the direction of the axis farthest away.
static void straight_lines_are_planes(void **state)
{
    (void)state;
    static const char line[] = "# a line\n2,8,8\n\n5 8 8\n12,8,8\n";
    command_write_file("line.csv", line, strlen(line));
    json_t *root = parse(command_succeeds("slice", "ml.vdb", "--along", "line.csv", "--width", "4",
                                          "--size", "20x8", "-o", "q.exr", "--json"));
    assert_near(number(root, "length"), 10.0, 1e-12, "length");
    assert_true(number(root, "width") == 20.0 && number(root, "height") == 8.0);
    json_decref(root);
    struct weft_image curve = loaded("q.exr");
    command_succeeds("slice", "ml.vdb", "--origin", "2,6,8", "--u", "10,0,0", "--v", "0,4,0",
                     "--size", "20x8", "--engine", "cpu", "-o", "y.exr", "-q");
    command_succeeds("slice", "ml.vdb", "--origin", "2,8,6", "--u", "10,0,0", "--v", "0,0,4",
                     "--size", "20x8", "--engine", "cpu", "-o", "z.exr", "-q");
    struct weft_image y = loaded("y.exr"), z = loaded("z.exr");
    double off[2] = {0.0, 0.0};
    for (int i = 0; i < 160; i++) {
        const double value = (double)channel(&curve, "Y")[i];
        off[0] = larger(off[0], fabs(value - (double)channel(&y, "Y")[i]));
        off[1] = larger(off[1], fabs(value - (double)channel(&z, "Y")[i]));
    }
    assert_true(fmin(off[0], off[1]) <= 2e-6);
    weft_image_clear(&curve);
    weft_image_clear(&y);
    weft_image_clear(&z);
    unlink("q.exr");
    unlink("y.exr");
    unlink("z.exr");
    unlink("line.csv");
}

static void bad_curves_are_refused(void **state)
{
    (void)state;
    static const char *const rgb[] = {"R", "G", "B"};
    command_write_file("one.csv", "1,2,3\n", 6);
    command_write_file("bad.csv", "1,2,3\n1,2\n", 10);
    command_write_file("same.csv", "1,2,3\n1,2,3\n", 12);
    write_positions("rgb.exr", rgb, false);
    write_positions("p.exr", xyz, false);
    command_fails(3, "no channel X", "slice", "ml.vdb", "--json", "--positions", "rgb.exr");
    command_fails(2, "12 x 10 positions, and --size asks for 8 x 10", "slice", "ml.vdb", "--json",
                  "--positions", "p.exr", "--size", "8x10");
    command_fails(3, "one.csv has 1 point", "slice", "ml.vdb", "--json", "--along", "one.csv",
                  "--width", "1");
    command_fails(3, "bad.csv, line 2: not a point", "slice", "ml.vdb", "--json", "--along",
                  "bad.csv", "--width", "1");
    command_fails(3, "neighbouring points must be apart", "slice", "ml.vdb", "--json", "--along",
                  "same.csv", "--width", "1");
    command_fails(2, "go together", "slice", "ml.vdb", "--json", "--along", "same.csv");
    command_fails(2, "a length above 0", "slice", "ml.vdb", "--json", "--along", "same.csv",
                  "--width", "0");
    command_fails(2, "--axis is of planes", "slice", "ml.vdb", "--json", "--positions", "p.exr",
                  "--axis", "x");
    command_fails(2, "exclude each other", "slice", "ml.vdb", "--json", "--positions", "p.exr",
                  "--along", "one.csv", "--width", "1");
    command_fails(3, "cannot be opened", "slice", "ml.vdb", "--json", "--along", "none.csv",
                  "--width", "1");
    unlink("one.csv");
    unlink("bad.csv");
    unlink("same.csv");
    unlink("rgb.exr");
    unlink("p.exr");
}

static void bad_quantities_are_refused(void **state)
{
    (void)state;
    command_fails(2, "did you mean gradient?", "slice", "ml.vdb", "--json", "--quantity",
                  "gradent");
    command_fails(2, "normal is asked for twice", "slice", "ml.vdb", "--json", "--quantity",
                  "normal,value,normal");
    command_fails(2, "--clamp is of values", "slice", "ml.vdb", "--json", "--quantity", "gradient",
                  "--clamp");
    command_fails(2, "--hardware filters values", "slice", "ml.vdb", "--json", "--quantity",
                  "value,gradient", "--hardware");
    command_fails(2, "--max-error chooses", "slice", "ml.vdb", "--json", "--quantity", "hessian",
                  "--max-error", "8bit");
    command_fails(2, "--quantity gradient", "slice", "ml.vdb", "--json", "--kernel",
                  "d-catmull-rom");
}

static int setup(void **state)
{
    char line[512];
    snprintf(line, sizeof line, "'%s/make_vdb_fixtures' .", WEFT_BINARY_DIR);
    return command_setup(state) || system(line);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(grids_are_channels_by_name),
        cmocka_unit_test(vectors_have_three_channels),
        cmocka_unit_test(staggered_grids_lie_at_faces),
        cmocka_unit_test(bad_lists_are_refused),
        cmocka_unit_test(frames_have_the_same_channels),
        cmocka_unit_test(gradients_are_differences),
        cmocka_unit_test(quantities_are_verified),
        cmocka_unit_test(passes_make_one_after_another),
        cmocka_unit_test(previews_of_vectors_are_colours),
        cmocka_unit_test(bad_quantities_are_refused),
        cmocka_unit_test(slabs_are_combined),
        cmocka_unit_test(bad_slabs_are_refused),
        cmocka_unit_test(positions_are_where_pixels_lie),
        cmocka_unit_test(straight_lines_are_planes),
        cmocka_unit_test(bad_curves_are_refused),
    };
    return cmocka_run_group_tests(tests, setup, command_teardown);
}
