// SPDX-License-Identifier: BSD-3-Clause
// Trees of every kind of node, in every compression and type, that OpenVDB wrote: bricks, tiles,
// counts and every voxel are what OpenVDB reads from the same file, to the bit.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "tests/support/vdb_files.h"

// As make_vdb_fixtures.cc writes it.
struct peer_grid {
    uint64_t bricks, tiles, active;
    int32_t low[3], high[3];
};

struct peer_tile {
    int32_t origin[3], size;
    float value;
};

static const void *take(const unsigned char **at, size_t bytes)
{
    const void *data = *at;
    *at += bytes;
    return data;
}

static void compare_grid(const char *file, const char *name, const unsigned char **at)
{
    struct peer_grid peer;
    struct weft_brick_list list;
    weft_volume *volume = NULL;
    const struct weft_volume_open_params params = {
        .path = file_path(file), .grid = name, .log = &test_log};
    if (weft_volume_open(&params, &volume) != WEFT_OK)
        fail_msg("%s, %s: %s", file, name, last_error.message);
    const struct weft_volume_info *info = weft_volume_get_info(volume);
    memcpy(&peer, take(at, sizeof peer), sizeof peer);
    assert_int_equal(info->bricks, peer.bricks);
    assert_int_equal(info->active_voxels, peer.active);
    assert_memory_equal(info->active_min, peer.low, sizeof peer.low);
    assert_memory_equal(info->active_max, peer.high, sizeof peer.high);
    assert_int_equal(weft_volume_find(volume, &everywhere, &list), WEFT_OK);
    assert_int_equal(list.brick_count, peer.bricks);
    assert_int_equal(list.tile_count, peer.tiles);
    assert_true(peer.bricks > 100 && peer.tiles > 20);

    const size_t count = list.brick_count, origin_bytes = count * sizeof *list.brick_origin;
    float *values = malloc(count * 2048);
    assert_non_null(values);
    assert_memory_equal(list.brick_origin, take(at, origin_bytes), origin_bytes);
    assert_int_equal(
        weft_volume_read(volume, count, (const int32_t(*)[3])list.brick_origin, values), WEFT_OK);
    assert_memory_equal(values, take(at, count * 2048), count * 2048);
    for (size_t i = 0; i < list.tile_count; i++) {
        struct peer_tile tile;
        memcpy(&tile, take(at, sizeof tile), sizeof tile);
        assert_memory_equal(list.tiles[i].origin, tile.origin, sizeof tile.origin);
        assert_int_equal(list.tiles[i].size, tile.size);
        assert_memory_equal(&list.tiles[i].value, &tile.value, sizeof tile.value);
    }
    free(values);
    weft_brick_list_clear(&list);
    weft_volume_destroy(&volume);
}

static void test_peer(void **state)
{
    (void)state;
    static const char *const grids[] = {"float", "double",     "half", "half double",
                                        "int32", "half int32", "bool"};
    char command[1024];
    snprintf(command, sizeof command, "%s/make_vdb_fixtures %s", WEFT_BINARY_DIR, test_folder);
    assert_int_equal(system(command), 0);
    for (int i = 0; i < 6; i++) {
        char file[32], peer[32];
        size_t size;
        snprintf(file, sizeof file, "wild-%d.vdb", i);
        snprintf(peer, sizeof peer, "wild-%d.peer", i);
        unsigned char *data = read_whole(file_path(peer), &size);
        assert_non_null(data);
        const unsigned char *at = data;
        for (size_t g = 0; g < sizeof grids / sizeof *grids; g++)
            compare_grid(file, grids[g], &at);
        assert_int_equal(at - data, size);
        free(data);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_peer)};
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
