// SPDX-License-Identifier: BSD-3-Clause
// weft convert, and every verb that takes a volume on NRRD, NIfTI and raw files.
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

#include "tests/support/command.h"
#include "tests/support/json.h"
#include "weft.h"

static const struct weft_region everywhere = {
    .min = {-WEFT_INDEX_LIMIT, -WEFT_INDEX_LIMIT, -WEFT_INDEX_LIMIT},
    .max = {WEFT_INDEX_LIMIT, WEFT_INDEX_LIMIT, WEFT_INDEX_LIMIT}};

static weft_volume *open_volume(const char *path, const char *grid, int component)
{
    weft_volume *volume = NULL;
    assert_int_equal(
        weft_volume_open(
            weft_volume_open_params(.path = path, .grid = grid, .component = component), &volume),
        WEFT_OK);
    return volume;
}

// The voxels of the box of active ones, to be freed.
static float *read_box(weft_volume *volume, size_t size[3])
{
    const struct weft_volume_info *info = weft_volume_get_info(volume);
    struct weft_brick_list list;
    for (int i = 0; i < 3; i++)
        size[i] = (size_t)(info->active_max[i] - info->active_min[i]) + 1;
    float *out = malloc(size[0] * size[1] * size[2] * sizeof *out);
    assert_non_null(out);
    for (size_t i = 0; i < size[0] * size[1] * size[2]; i++)
        out[i] = info->background;
    assert_int_equal(weft_volume_find(volume, &everywhere, &list), WEFT_OK);
    float *values = malloc(list.brick_count * 2048 + 1);
    assert_non_null(values);
    assert_int_equal(
        weft_volume_read(volume, list.brick_count, (const int32_t(*)[3])list.brick_origin, values),
        WEFT_OK);
    for (size_t v = 0; v < list.brick_count * 512; v++) {
        const int32_t *o = list.brick_origin[v / 512];
        const int64_t at[3] = {o[0] + (int)(v & 7) - info->active_min[0],
                               o[1] + (int)(v >> 3 & 7) - info->active_min[1],
                               o[2] + (int)(v >> 6 & 7) - info->active_min[2]};
        if (at[0] < 0 || at[1] < 0 || at[2] < 0 || at[0] >= (int64_t)size[0] ||
            at[1] >= (int64_t)size[1] || at[2] >= (int64_t)size[2])
            continue;
        out[((size_t)at[2] * size[1] + (size_t)at[1]) * size[0] + (size_t)at[0]] = values[v];
    }
    free(values);
    weft_brick_list_clear(&list);
    return out;
}

// Equal in all voxels of the boxes, which lie in the same place of the world.
static void assert_same(weft_volume *a, weft_volume *b)
{
    const struct weft_volume_info *ia = weft_volume_get_info(a), *ib = weft_volume_get_info(b);
    size_t sa[3], sb[3];
    float *va = read_box(a, sa), *vb = read_box(b, sb);
    assert_memory_equal(sa, sb, sizeof sa);
    assert_memory_equal(va, vb, sa[0] * sa[1] * sa[2] * sizeof *va);
    for (int r = 0; r < 3; r++) {
        double first[2] = {ia->index_to_world[r][3], ib->index_to_world[r][3]};
        for (int c = 0; c < 3; c++) {
            if (ia->index_to_world[r][c] != ib->index_to_world[r][c])
                fail_msg("[%d][%d]: %.17g, not %.17g", r, c, ib->index_to_world[r][c],
                         ia->index_to_world[r][c]);
            first[0] += ia->index_to_world[r][c] * ia->active_min[c];
            first[1] += ib->index_to_world[r][c] * ib->active_min[c];
        }
        assert_true(fabs(first[0] - first[1]) <= 1e-12 * (1.0 + fabs(first[0])));
    }
    free(va);
    free(vb);
}

static void assert_same_files(const char *a, const char *grid_a, const char *b, const char *grid_b)
{
    weft_volume *va = open_volume(a, grid_a, 0), *vb = open_volume(b, grid_b, 0);
    assert_same(va, vb);
    weft_volume_destroy(&va);
    weft_volume_destroy(&vb);
}

static const char *const data_files[] = {"nrrd/BallBinary30x30x30.nrrd",
                                         "nrrd/BallBinary30x30x30_gz.nrrd",
                                         "nrrd/BallBinary30x30x30_bz2.nrrd",
                                         "nrrd/BallBinary30x30x30.nhdr",
                                         "nrrd/test2d_ascii.nrrd",
                                         "nrrd/test_simple4d_raw.nrrd",
                                         "nifti/anatomical.nii",
                                         "nifti/example4d.nii.gz",
                                         "nifti/example_nifti2.nii.gz",
                                         "nifti/functional.nii"};

// To NRRD, to VDB, and from there to NRRD: the same voxels at the same places.
static void data_goes_round(void **state)
{
    (void)state;
    char path[512];
    for (size_t i = 0; i < sizeof data_files / sizeof *data_files; i++) {
        snprintf(path, sizeof path, WEFT_TEST_DATA "/%s", data_files[i]);
        if (access(path, R_OK))
            skip();
        command_succeeds("convert", path, "a.nrrd");
        command_succeeds("convert", path, "b.vdb");
        command_succeeds("convert", "b.vdb", "c.nrrd");
        assert_same_files(path, NULL, "a.nrrd", NULL);
        assert_same_files(path, NULL, "b.vdb", NULL);
        assert_same_files(path, NULL, "c.nrrd", NULL);
        unlink("a.nrrd");
        unlink("b.vdb");
        unlink("c.nrrd");
    }
}

// Teem reads what is written: the same bytes as of the input.
static void teem_reads_it(void **state)
{
    (void)state;
    if (system("command -v unu cmp >/dev/null") || access(WEFT_TEST_DATA "/nrrd", R_OK))
        skip();
    command_succeeds("convert", WEFT_TEST_DATA "/nrrd/BallBinary30x30x30_gz.nrrd", "a.nrrd");
    assert_int_equal(
        system("unu data a.nrrd | cmp - " WEFT_TEST_DATA "/nrrd/BallBinary30x30x30.raw"), 0);
    assert_int_equal(system("unu head a.nrrd | grep -q 'space: left-posterior-superior'"), 0);
    command_succeeds("convert", WEFT_TEST_DATA "/nifti/anatomical.nii", "a.nrrd");
    assert_int_equal(system("unu head a.nrrd | grep -q 'space: right-anterior-superior'"), 0);
    assert_int_equal(system("unu head a.nrrd | grep -q 'space units: \"mm\" \"mm\" \"mm\"'"), 0);
    unlink("a.nrrd");
}

static void types_are_told(void **state)
{
    (void)state;
    struct command_result r;
    static const float values[] = {-1.0f, 0.5f, 1.5f, 254.6f, 300.0f, 7.0f, 8.0f, 9.0f};
    static const unsigned char expected[] = {0, 0, 2, 255, 255, 7, 8, 9};
    command_write_file("v.raw", values, sizeof values);
    command_run(&r, "weft", "convert", "v.raw", "--raw", "2x2x2:float:spacing=1,2,-3:origin=4,5,6",
                "v.nrrd", "--type", "uint8");
    assert_int_equal(r.code, 0);
    assert_non_null(strstr(r.err, "3 values are rounded"));
    assert_non_null(strstr(r.err, "2 values are none of uint8"));
    size_t size;
    char *file = command_read_file("v.nrrd", &size);
    assert_memory_equal(file + size - 8, expected, 8);
    assert_non_null(strstr(file, "space directions: (1,0,0) (0,2,0) (0,0,-3)\n"));
    assert_non_null(strstr(file, "space origin: (4,5,6)\n"));
    free(file);
    // Integers that no float holds are written whole.
    static const int32_t whole[] = {16777217, -2147483647, 3, 4, 5, 6, 7, 8};
    command_write_file("v.raw", whole, sizeof whole);
    command_run(&r, "weft", "convert", "v.raw", "--raw", "2x2x2:int32", "v.nrrd");
    assert_int_equal(r.code, 0);
    assert_string_equal(r.err, "");
    file = command_read_file("v.nrrd", &size);
    assert_memory_equal(file + size - sizeof whole, whole, sizeof whole);
    free(file);
    unlink("v.raw");
    unlink("v.nrrd");
}

static void background_makes_it_sparse(void **state)
{
    (void)state;
    static unsigned char voxels[32 * 32 * 32];
    voxels[(9 * 32 + 10) * 32 + 11] = 200;
    voxels[(20 * 32 + 10) * 32 + 11] = 3;
    command_write_file("v.raw", voxels, sizeof voxels);
    command_succeeds("convert", "v.raw", "all.vdb", "--raw", "32x32x32:uint8");
    command_succeeds("convert", "v.raw", "some.vdb", "--raw", "32x32x32:uint8", "--background",
                     "0");
    command_succeeds("convert", "v.raw", "few.vdb", "--raw", "32x32x32:uint8", "--background", "0",
                     "--prune", "3");
    static const struct {
        const char *path;
        uint64_t bricks, active;
    } cases[] = {{"all.vdb", 64, 32768}, {"some.vdb", 2, 2}, {"few.vdb", 1, 1}};
    for (size_t i = 0; i < 3; i++) {
        weft_volume *volume = open_volume(cases[i].path, "v", 0);
        assert_int_equal(weft_volume_get_info(volume)->bricks, cases[i].bricks);
        assert_int_equal(weft_volume_get_info(volume)->active_voxels, cases[i].active);
        weft_volume_destroy(&volume);
        unlink(cases[i].path);
    }
    unlink("v.raw");
}

// A slice across an axis, at voxels, by a kernel that takes them as they are.
static void slices_are_the_files(void **state)
{
    (void)state;
    static uint16_t voxels[5 * 12 * 11];
    for (int i = 0; i < 5 * 12 * 11; i++)
        voxels[i] = (uint16_t)(i * 97);
    command_write_file("v.raw", voxels, sizeof voxels);
    command_succeeds("convert", "v.raw", "v.nrrd", "--raw", "11x12x5:uint16");
    static const char *const inputs[] = {"v.nrrd", "v.raw"};
    for (int i = 0; i < 2; i++) {
        struct command_result r;
        const char *const raw[] = {"weft",
                                   "slice",
                                   inputs[i],
                                   "-o",
                                   "s.exr",
                                   "--axis",
                                   "z",
                                   "--at",
                                   "3",
                                   "--size",
                                   "11x12",
                                   "--kernel",
                                   "nearest",
                                   "--engine",
                                   "cpu",
                                   i ? "--raw" : NULL,
                                   "11x12x5:uint16",
                                   NULL};
        command_run_list(&r, raw);
        if (r.code)
            fail_msg("%s", r.err);
        struct weft_image image;
        assert_int_equal(weft_image_load(weft_image_load_params(.path = "s.exr"), &image), WEFT_OK);
        assert_int_equal(image.width, 11);
        const float *pixels = image.channels[0].plane;
        int seen = 0;
        for (int p = 0; p < 11 * 12; p++, seen++)
            if (pixels[p] != (float)voxels[3 * 11 * 12 + p])
                fail_msg("%s: pixel %d is %g, not %d", inputs[i], p, pixels[p],
                         voxels[3 * 11 * 12 + p]);
        assert_int_equal(seen, 132);
        weft_image_clear(&image);
    }
    unlink("s.exr");
    unlink("v.raw");
    unlink("v.nrrd");
}

static void every_file_is_sliced(void **state)
{
    (void)state;
    char path[512];
    for (size_t i = 0; i < sizeof data_files / sizeof *data_files; i++) {
        snprintf(path, sizeof path, WEFT_TEST_DATA "/%s", data_files[i]);
        if (access(path, R_OK))
            skip();
        command_succeeds("slice", path, "-o", "s.exr", "--size", "16x16", "--engine", "cpu");
        command_write_file("p.csv", "0,0,0\n", 6);
        command_succeeds("probe", path, "--points", "p.csv", "--space", "index");
        json_t *info = parse(command_succeeds("info", "--json", path));
        assert_string_equal(json_string_value(json_object_get(info, "format")),
                            *data_files[i] == 'n' && data_files[i][1] == 'r' ? "nrrd" : "nifti");
        json_decref(info);
    }
    unlink("s.exr");
    unlink("p.csv");
}

// The same raw file for the verbs that no other case here shows it to.
static void raw_is_taken_by_all(void **state)
{
    (void)state;
    static unsigned char voxels[16 * 16 * 16];
    for (int i = 0; i < 16 * 16 * 16; i++)
        voxels[i] = (unsigned char)(i / 256);
    command_write_file("v.raw", voxels, sizeof voxels);
    command_write_file("p.csv", "3,4,5\n", 6);
    const char *table = command_succeeds("probe", "v.raw", "--raw", "16x16x16:uint8", "--points",
                                         "p.csv", "--space", "index", "--kernel", "nearest");
    assert_non_null(strstr(table, "3,4,5,5\n"));
    command_succeeds("lattice", "v.raw", "--raw", "16x16x16:uint8", "--scale", "2", "-o", "l.vdb");
    weft_volume *volume = open_volume("l.vdb", NULL, 0);
    assert_false(weft_volume_get_info(volume)->empty);
    weft_volume_destroy(&volume);
    unlink("v.raw");
    unlink("p.csv");
    unlink("l.vdb");
}

static void bad_input_is_one_line(void **state)
{
    (void)state;
    command_write_file("v.raw", "12345678", 8);
    command_write_file(
        "lie.nrrd", "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 99 99 99\nencoding: raw\n\n", 65);
    command_fails(2, "0 files given", "convert");
    command_fails(2, "1 file given", "convert", "v.raw");
    command_fails(2, "ends in .vdb or .nrrd", "convert", "v.raw", "v.txt");
    command_fails(2, "a size is NXxNYxNZ", "convert", "v.raw", "v.nrrd", "--raw", "2x2:uint8");
    command_fails(2, "a size is NXxNYxNZ", "info", "v.raw", "--raw", "2x-2x2:uint8");
    command_fails(2, "a type is", "convert", "v.raw", "v.nrrd", "--raw", "2x2x2:uint7");
    command_fails(2, "behind the type", "convert", "v.raw", "v.nrrd", "--raw",
                  "2x2x2:uint8:spacing=0,1,1");
    command_fails(3, "8 bytes", "convert", "v.raw", "v.nrrd", "--raw", "2x2x2:uint8:skip=1");
    command_fails(3, "neither a VDB, an NRRD nor a NIfTI file", "convert", "v.raw", "v.nrrd");
    command_fails(3, "970299 bytes of samples", "convert", "lie.nrrd", "v.vdb");
    command_fails(3, "970299 bytes of samples", "slice", "lie.nrrd", "-o", "s.exr");
    command_fails(2, "missing", "convert", "v.raw", "v.vdb", "--prune", "1");
    command_fails(4, "no/such", "convert", "v.raw", "no/such/v.vdb", "--raw", "2x2x2:uint8");
    unlink("v.raw");
    unlink("lie.nrrd");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(data_goes_round),      cmocka_unit_test(teem_reads_it),
        cmocka_unit_test(types_are_told),       cmocka_unit_test(background_makes_it_sparse),
        cmocka_unit_test(slices_are_the_files), cmocka_unit_test(every_file_is_sliced),
        cmocka_unit_test(raw_is_taken_by_all),  cmocka_unit_test(bad_input_is_one_line),
    };
    return cmocka_run_group_tests(tests, command_setup_folder, command_teardown);
}
