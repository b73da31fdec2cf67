// SPDX-License-Identifier: BSD-3-Clause
// weft lattice as its users see it: files that weft and OpenVDB's own program read back.
#include <math.h>
#include <setjmp.h>
#include <signal.h>
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

static weft_volume *open_grid(const char *path, const char *grid, int component)
{
    weft_volume *volume = NULL;
    const struct weft_volume_open_params params = {
        .path = path, .grid = grid, .component = component};
    assert_int_equal(weft_volume_open(&params, &volume), WEFT_OK);
    return volume;
}

// All of a file's bricks, found by their origins.
struct bricks {
    weft_volume *volume;
    struct weft_brick_list list;
    float *values;
};

static struct bricks read_all(const char *path, const char *grid, int component)
{
    static const struct weft_region all = {
        {-(1 << 20), -(1 << 20), -(1 << 20)}, {1 << 20, 1 << 20, 1 << 20}, 0, {{{0}, 0, 0}}};
    struct bricks out = {.volume = open_grid(path, grid, component)};
    assert_int_equal(weft_volume_find(out.volume, &all, &out.list), WEFT_OK);
    out.values = malloc((out.list.brick_count + 1) * WEFT_BRICK_VOXELS * sizeof *out.values);
    assert_int_equal(weft_volume_read(out.volume, out.list.brick_count,
                                      (const int32_t(*)[3])out.list.brick_origin, out.values),
                     WEFT_OK);
    return out;
}

static void clear(struct bricks *b)
{
    weft_volume_destroy(&b->volume);
    weft_brick_list_clear(&b->list);
    free(b->values);
}

static float voxel(const struct bricks *b, const int32_t at[3])
{
    const int32_t o[3] = {at[0] & -8, at[1] & -8, at[2] & -8};
    size_t low = 0, high = b->list.brick_count; // they are sorted by z, y, x
    while (low < high) {
        const size_t middle = (low + high) / 2;
        const int32_t *m = b->list.brick_origin[middle];
        if (m[2] != o[2] ? m[2] < o[2] : m[1] != o[1] ? m[1] < o[1] : m[0] < o[0])
            low = middle + 1;
        else
            high = middle;
    }
    if (low < b->list.brick_count && memcmp(b->list.brick_origin[low], o, sizeof o) == 0)
        return b->values[low * WEFT_BRICK_VOXELS +
                         (size_t)((at[2] & 7) << 6 | (at[1] & 7) << 3 | (at[0] & 7))];
    for (size_t i = 0; i < b->list.tile_count; i++) {
        const struct weft_volume_tile *t = &b->list.tiles[i];
        bool in = true;
        for (int a = 0; a < 3; a++)
            in = in && at[a] >= t->origin[a] && at[a] < t->origin[a] + t->size;
        if (in)
            return t->value;
    }
    return weft_volume_get_info(b->volume)->background;
}

// ---- scales -------------------------------------------------------------------------------------

static void test_doubled(void **state)
{
    (void)state;
    command_succeeds("lattice", "ml.vdb", "--scale", "2", "-o", "double.vdb", "-q");
    struct bricks small = read_all("ml.vdb", NULL, 0), large = read_all("double.vdb", NULL, 0);
    const struct weft_volume_info *a = weft_volume_get_info(small.volume);
    const struct weft_volume_info *b = weft_volume_get_info(large.volume);
    for (int i = 0; i < 3; i++) {
        assert_true(b->index_to_world[i][i] == 0.5 * a->index_to_world[i][i]);
        assert_true(b->index_to_world[i][3] == a->index_to_world[i][3]);
    }
    assert_string_equal(a->name, b->name);
    assert_string_equal(a->grid_class, b->grid_class);
    // Every second voxel is the source's, to the bit.
    size_t same = 0;
    for (int32_t z = 0; z < 32; z += 3)
        for (int32_t y = 0; y < 32; y += 5)
            for (int32_t x = 0; x < 32; x++) {
                const int32_t from[3] = {x, y, z}, to[3] = {2 * x, 2 * y, 2 * z};
                assert_true(voxel(&small, from) == voxel(&large, to));
                same++;
            }
    assert_true(same > 1000);
    // Halved again, without a kernel that smooths: the source.
    command_succeeds("lattice", "double.vdb", "--scale", "0.5", "--kernel", "linear", "--antialias",
                     "off", "-o", "back.vdb", "-q");
    struct bricks back = read_all("back.vdb", NULL, 0);
    for (int32_t i = 0; i < 32 * 32; i++) {
        const int32_t at[3] = {i & 31, i >> 5, (i * 7) & 31};
        assert_true(voxel(&small, at) == voxel(&back, at));
    }
    clear(&small);
    clear(&large);
    clear(&back);
}

static void test_report(void **state)
{
    (void)state;
    json_t *root = parse(command_succeeds("lattice", "ml.vdb", "--voxel", "0.4", "--verify",
                                          "--json", "-o", "finer.vdb"));
    const json_t *grid = json_array_get(json_object_get(root, "grids"), 0);
    const json_t *verify = json_object_get(grid, "error");
    assert_true(json_number_value(json_object_get(verify, "share_of_bound")) <= 1.0);
    assert_true(json_integer_value(json_object_get(verify, "samples")) > 1000);
    assert_true(json_is_true(json_object_get(grid, "separable")));
    const json_t *out = json_array_get(json_object_get(grid, "results"), 0);
    // What it told is what the file has.
    weft_volume *volume = open_grid("finer.vdb", NULL, 0);
    const struct weft_volume_info *info = weft_volume_get_info(volume);
    assert_int_equal(info->active_voxels,
                     json_integer_value(json_object_get(out, "active_voxels")));
    assert_int_equal(info->bricks, json_integer_value(json_object_get(out, "bricks")));
    assert_true(fabs(info->index_to_world[0][0] - 0.4) < 1e-12);
    weft_volume_destroy(&volume);
    json_decref(root);
    const char *text =
        command_succeeds("lattice", "ml.vdb", "--scale", "0.5", "--explain", "--kernel", "linear");
    assert_non_null(strstr(text, "stretched by 2"));
    assert_non_null(strstr(text, "one axis after another"));
}

// The same bytes from other numbers of threads and other bounds of memory.
static void test_memory(void **state)
{
    (void)state;
    command_environment("WEFT_THREADS=1");
    command_succeeds("lattice", "ml.vdb", "--scale", "3", "-o", "a.vdb", "-q", "--memory", "2M");
    command_succeeds("lattice", "ml.vdb", "--scale", "3", "-o", "b.vdb", "-q");
    struct bricks a = read_all("a.vdb", NULL, 0), b = read_all("b.vdb", NULL, 0);
    assert_true(a.list.brick_count > 100);
    assert_int_equal(a.list.brick_count, b.list.brick_count);
    assert_memory_equal(a.values, b.values, a.list.brick_count * WEFT_BRICK_VOXELS * sizeof(float));
    clear(&a);
    clear(&b);
    command_fails(3, "memory", "lattice", "ml.vdb", "--scale", "3", "-o", "c.vdb", "--memory",
                  "1K");
}

// ---- level sets, moves, vectors -----------------------------------------------------------------

static void test_level_set(void **state)
{
    (void)state;
    command_succeeds("lattice", "sphere.vdb", "--scale", "1.5", "-o", "larger.vdb", "-q");
    struct bricks small = read_all("sphere.vdb", NULL, 0), large = read_all("larger.vdb", NULL, 0);
    const struct weft_volume_info *info = weft_volume_get_info(large.volume);
    assert_string_equal(info->grid_class, "level set");
    assert_true(info->background == weft_volume_get_info(small.volume)->background);
    // Three voxels of the source are 4.5 of the result, on either side of the surface.
    assert_true(info->active_voxels > 2 * weft_volume_get_info(small.volume)->active_voxels);
    for (int32_t i = -10; i <= 10; i++) {
        const int32_t from[3] = {2 * i, 2 * i, 0}, to[3] = {3 * i, 3 * i, 0};
        assert_true(fabsf(voxel(&small, from) - voxel(&large, to)) < 1e-6f);
    }
    clear(&small);
    clear(&large);
}

// A turn and the turn back; a half voxel and a half voxel more.
static void test_moved(void **state)
{
    (void)state;
    command_succeeds("lattice", "ml.vdb", "--matrix", "0,-1,0,2,1,0,0,-1.5,0,0,1,0", "-o",
                     "turned.vdb", "-q");
    command_succeeds("lattice", "turned.vdb", "--matrix", "0,1,0,1.5,-1,0,0,2,0,0,1,0", "-o",
                     "home.vdb", "-q");
    struct bricks a = read_all("ml.vdb", NULL, 0), b = read_all("home.vdb", NULL, 0);
    for (int32_t i = 0; i < 32 * 32; i++) {
        const int32_t at[3] = {i & 31, i >> 5, (i * 11) & 31};
        assert_true(voxel(&a, at) == voxel(&b, at));
    }
    clear(&b);
    // A quarter of the world's unit is half a voxel.
    command_succeeds("lattice", "ml.vdb", "--matrix", "1,0,0,0.25,0,1,0,0,0,0,1,0", "-o",
                     "half.vdb", "-q");
    command_succeeds("lattice", "half.vdb", "--scale", "2", "--kernel", "linear", "-o", "h2.vdb",
                     "-q");
    command_succeeds("lattice", "ml.vdb", "--scale", "2", "-o", "d.vdb", "-q");
    struct bricks h = read_all("h2.vdb", NULL, 0), d = read_all("d.vdb", NULL, 0);
    for (int32_t i = 0; i < 32 * 32; i++) {
        const int32_t at[3] = {2 * (i & 31), 2 * (i >> 5), 20}, by[3] = {at[0] - 1, at[1], at[2]};
        assert_true(voxel(&h, at) == voxel(&d, by));
    }
    clear(&a);
    clear(&h);
    clear(&d);
}

static void test_quantities(void **state)
{
    (void)state;
    command_succeeds("lattice", "ml.vdb", "--quantity", "value,gradient,laplacian", "--verify",
                     "-o", "q.vdb", "-q");
    struct bricks value = read_all("ml.vdb", NULL, 0);
    struct bricks x = read_all("q.vdb", "marschner-lobb.gradient", 0);
    assert_int_equal(weft_volume_get_info(x.volume)->components, 3);
    // Catmull-Rom's slope at a voxel is the central difference, per unit of the world.
    for (int32_t i = 0; i < 400; i++) {
        const int32_t at[3] = {5 + i % 20, 5 + i / 20, 14};
        const int32_t l[3] = {at[0] - 1, at[1], at[2]}, r[3] = {at[0] + 1, at[1], at[2]};
        const double h = weft_volume_get_info(value.volume)->index_to_world[0][0];
        const double want = ((double)voxel(&value, r) - (double)voxel(&value, l)) / (2.0 * h);
        assert_true(fabs((double)voxel(&x, at) - want) < 1e-6);
    }
    clear(&value);
    clear(&x);
}

static void test_like(void **state)
{
    (void)state;
    command_succeeds("lattice", "ml.vdb", "--scale", "0.7", "-o", "other.vdb", "-q");
    command_succeeds("lattice", "ml.vdb", "--like", "other.vdb", "-o", "like.vdb", "-q");
    struct bricks a = read_all("other.vdb", NULL, 0), b = read_all("like.vdb", NULL, 0);
    assert_memory_equal(weft_volume_get_info(a.volume)->index_to_world,
                        weft_volume_get_info(b.volume)->index_to_world, sizeof(double[3][4]));
    assert_int_equal(a.list.brick_count, b.list.brick_count);
    assert_memory_equal(a.values, b.values, a.list.brick_count * WEFT_BRICK_VOXELS * sizeof(float));
    clear(&a);
    clear(&b);
}

// ---- bad input ----------------------------------------------------------------------------------

static void test_refused(void **state)
{
    (void)state;
    command_fails(3, "voxels", "lattice", "ml.vdb", "--scale", "100000", "-o", "x.vdb");
    command_fails(3, "voxels", "lattice", "ml.vdb", "--scale", "100", "-o", "x.vdb");
    command_fails(2, "above 0", "lattice", "ml.vdb", "--scale", "0", "-o", "x.vdb");
    command_fails(2, "above 0", "lattice", "ml.vdb", "--voxel", "-1", "-o", "x.vdb");
    command_fails(2, "exclude", "lattice", "ml.vdb", "--voxel", "1", "--scale", "2", "-o", "x.vdb");
    command_fails(2, "no lattice", "lattice", "ml.vdb", "-o", "x.vdb");
    command_fails(2, "nothing to do", "lattice", "ml.vdb", "--scale", "2");
    command_fails(2, "12 finite numbers", "lattice", "ml.vdb", "--matrix", "1,2,3", "-o", "x.vdb");
    command_fails(2, "singular", "lattice", "ml.vdb", "--matrix", "1,0,0,0,1,0,0,0,0,0,1,0", "-o",
                  "x.vdb");
    command_fails(2, "prune", "lattice", "ml.vdb", "--scale", "2", "--prune=-1", "-o", "x.vdb");
    command_fails(2, "quantity", "lattice", "ml.vdb", "--quantity", "colour", "-o", "x.vdb");
    command_fails(3, "prefiltered", "lattice", "ml.vdb", "--scale", "0.5", "--kernel", "bspline3i",
                  "-o", "x.vdb");
    command_fails(2, "", "lattice", "ml.vdb", "--scale", "2", "-o", "ml.vdb");
    command_fails(4, "", "lattice", "ml.vdb", "--scale", "2", "-o", "nowhere/x.vdb");
    command_fails(3, "", "lattice", "missing.vdb", "--scale", "2", "-o", "x.vdb");
    // Far away from each other.
    command_succeeds("lattice", "ml.vdb", "--matrix", "1,0,0,1000,0,1,0,0,0,0,1,0", "-o",
                     "nothing.vdb", "-q");
    command_succeeds("make", "sphere", "-o", "far.vdb", "--size", "32", "--voxel", "0.5",
                     "--offset", "5000,0,0", "-q");
    command_fails(2, "do not overlap", "lattice", "ml.vdb", "--like", "far.vdb", "-o", "x.vdb");
}

// A signal leaves no half file and no process.
static void test_interrupted(void **state)
{
    (void)state;
    const int before = command_folder_size();
    const char *const argv[] = {"weft", "lattice", "ml.vdb", "--scale", "9", "-o", "big.vdb", NULL};
    const int code = command_interrupt(0.3, SIGINT, argv);
    if (code == -1) {
        unlink("big.vdb");
        skip();
    }
    assert_int_equal(code, 128 + SIGINT);
    assert_int_equal(command_folder_size(), before);
}

// ---- OpenVDB's own reader -----------------------------------------------------------------------

static void test_openvdb(void **state)
{
    (void)state;
    if (access("/usr/bin/vdb_print", X_OK)) {
        print_message("skipped: there is no vdb_print\n");
        skip();
    }
    command_succeeds("lattice", "ml.vdb", "--scale", "1.25", "--quantity", "value,gradient", "-o",
                     "o.vdb", "-q");
    FILE *pipe = popen("vdb_print o.vdb", "r");
    char text[4096];
    assert_non_null(pipe);
    text[fread(text, 1, sizeof text - 1, pipe)] = '\0';
    assert_int_equal(pclose(pipe), 0);
    assert_non_null(strstr(text, "marschner-lobb.gradient"));
    assert_non_null(strstr(text, "vec3s"));
    weft_volume *volume = open_grid("o.vdb", "marschner-lobb", 0);
    char active[64];
    // "1,234,567 voxels" or "1.23MVox", by version: the box is told in all.
    const struct weft_volume_info *info = weft_volume_get_info(volume);
    snprintf(active, sizeof active, "%dx%dx%d", info->active_max[0] - info->active_min[0] + 1,
             info->active_max[1] - info->active_min[1] + 1,
             info->active_max[2] - info->active_min[2] + 1);
    if (!strstr(text, active))
        fail_msg("no %s in %s", active, text);
    weft_volume_destroy(&volume);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_doubled),     cmocka_unit_test(test_report),
        cmocka_unit_test(test_memory),      cmocka_unit_test(test_level_set),
        cmocka_unit_test(test_moved),       cmocka_unit_test(test_quantities),
        cmocka_unit_test(test_like),        cmocka_unit_test(test_refused),
        cmocka_unit_test(test_interrupted), cmocka_unit_test(test_openvdb),
    };
    return cmocka_run_group_tests(tests, command_setup, command_teardown);
}
