// SPDX-License-Identifier: BSD-3-Clause
// weft slice of several grids, of vectors and of quantities: what channels are called and hold.
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
                     "--size", "16x12", "-q");
    struct weft_image all = loaded("a.exr");
    assert_int_equal(all.channel_count, 4);
    for (size_t i = 0; i < WEFT_COUNT(grids); i++) {
        command_succeeds("slice", "types.vdb", "--grid", grids[i], "-o", "b.exr", "--size", "16x12",
                         "-q");
        struct weft_image one = loaded("b.exr");
        assert_int_equal(one.channel_count, 1);
        assert_memory_equal(channel(&all, grids[i]), channel(&one, "Y"), 16 * 12 * sizeof(float));
        weft_image_clear(&one);
    }
    weft_image_clear(&all);
    command_succeeds("slice", "types.vdb", "--grid", "all", "-o", "a.exr", "--size", "8x8", "-q");
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
    command_succeeds("slice", "types.vdb", "--grid", "float", "-o", "b.exr", "--size", "16x12",
                     "-q");
    struct weft_image scalar = loaded("b.exr");
    const float *base = channel(&scalar, "Y");
    for (size_t k = 0; k < WEFT_COUNT(kinds); k++) {
        command_succeeds("slice", "types.vdb", "--grid", kinds[k], "-o", "a.exr", "--size", "16x12",
                         "-q", "--verify", "--preview", "a.png");
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
                                          "--size", "8x8", "--verify"));
    json_t *channels = json_object_get(root, "channels");
    assert_int_equal(json_array_size(channels), 3);
    assert_true(number(json_object_get(root, "verify"), "maximum") <=
                number(json_object_get(root, "verify"), "bound"));
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
                     "1..5", "-o", "f%d.exr", "--size", "8x8", "-q");
    command_succeeds("slice", "types.vdb", "--grid", "float,vec3i", "--at", "3", "-o", "a.exr",
                     "--size", "8x8", "-q");
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
        cmocka_unit_test(bad_quantities_are_refused),
    };
    return cmocka_run_group_tests(tests, setup, command_teardown);
}
