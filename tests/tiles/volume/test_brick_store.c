// SPDX-License-Identifier: BSD-3-Clause
#include "tests/support/samples.h"
#include "tiles/volume/brick_store.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

static weft_brick_store *make_store(float background)
{
    weft_brick_store *store = NULL;
    assert_int_equal(weft_brick_store_create(NULL, 0, background, &store), WEFT_OK);
    return store;
}

static void test_many_bricks(void **state)
{
    (void)state;
    enum { SIDE = 20 };
    weft_brick_store *store = make_store(-3);
    float *values = malloc(sizeof *values * SIDE * SIDE * SIDE * WEFT_BRICK_VOXELS);
    assert_non_null(values);
    for (int n = 0; n < SIDE * SIDE * SIDE; n++) {
        // Every second brick, around the origin and so with negative coordinates too.
        int32_t origin[3] = {16 * (n % SIDE - 10), 16 * (n / SIDE % SIDE - 10),
                             16 * (n / SIDE / SIDE - 10)};
        for (int v = 0; v < WEFT_BRICK_VOXELS; v++)
            values[n * WEFT_BRICK_VOXELS + v] = (float)(n * WEFT_BRICK_VOXELS + v);
        assert_int_equal(weft_brick_store_add_brick(store, origin, values + n * WEFT_BRICK_VOXELS),
                         WEFT_OK);
    }
    struct weft_brick_cursor cursor = {.store = store};
    for (int k = -170; k < 170; k += 3)
        for (int j = -170; j < 170; j += 5)
            for (int i = -170; i < 170; i++) {
                bool inside = i >= -160 && i < 160 && j >= -160 && j < 160 && k >= -160 &&
                              k < 160 && !(i & 8) && !(j & 8) && !(k & 8);
                int n = ((k + 160) / 16 * SIDE + (j + 160) / 16) * SIDE + (i + 160) / 16;
                float expected =
                    inside ? (float)(n * WEFT_BRICK_VOXELS + (k & 7) * 64 + (j & 7) * 8 + (i & 7))
                           : -3;
                assert_true(weft_brick_cursor_voxel(&cursor, i, j, k) == expected);
                assert_true(brick_voxel(store, i, j, k) == expected);
            }
    assert_int_equal(weft_brick_store_check_disjoint(store), WEFT_OK);
    weft_brick_store_destroy(&store);
    assert_null(store);
    free(values);
}

static void test_tiles(void **state)
{
    (void)state;
    weft_brick_store *store = make_store(9);
    float values[WEFT_BRICK_VOXELS] = {0};
    struct weft_volume_tile tiles[] = {
        {{-4096, 0, 0}, 4096, 1}, {{0, 128, -128}, 128, 2}, {{8, 0, 0}, 8, 3}};
    for (size_t i = 0; i < WEFT_COUNT(tiles); i++)
        assert_int_equal(weft_brick_store_add_tile(store, &tiles[i]), WEFT_OK);
    assert_int_equal(weft_brick_store_add_brick(store, (int32_t[3]){0, 0, 0}, values), WEFT_OK);
    assert_true(brick_voxel(store, -1, 0, 0) == 1);
    assert_true(brick_voxel(store, -4096, 4095, 4095) == 1);
    assert_true(brick_voxel(store, -4097, 0, 0) == 9);
    assert_true(brick_voxel(store, 127, 255, -1) == 2);
    assert_true(brick_voxel(store, 127, 256, -1) == 9);
    assert_true(brick_voxel(store, 15, 7, 7) == 3);
    assert_true(brick_voxel(store, 7, 7, 7) == 0);
    assert_int_equal(weft_brick_store_check_disjoint(store), WEFT_OK);

    const float *found;
    float constant;
    assert_int_equal(weft_brick_store_find(store, (int32_t[3]){0, 0, 0}, &found, &constant),
                     WEFT_BRICK_VALUES);
    assert_ptr_equal(found, values);
    assert_int_equal(weft_brick_store_find(store, (int32_t[3]){-8, 8, 0}, &found, &constant),
                     WEFT_BRICK_CONSTANT);
    assert_true(constant == 1);

    int32_t inside[3] = {-8, 0, 0};
    assert_int_equal(weft_brick_store_add_brick(store, inside, values), WEFT_OK);
    assert_int_equal(weft_brick_store_check_disjoint(store), WEFT_ERR_ARGUMENT);
    weft_brick_store_destroy(&store);
}

static void test_bad_arguments(void **state)
{
    (void)state;
    weft_brick_store *store = make_store(0);
    float values[WEFT_BRICK_VOXELS] = {0};
    const int32_t bad[][3] = {{1, 0, 0}, {0, -4, 0}, {0, 0, INT32_C(1) << 30}};
    for (size_t i = 0; i < WEFT_COUNT(bad); i++)
        assert_int_equal(weft_brick_store_add_brick(store, bad[i], values), WEFT_ERR_ARGUMENT);
    assert_int_equal(weft_brick_store_add_brick(store, (int32_t[3]){0}, NULL), WEFT_ERR_ARGUMENT);
    assert_int_equal(weft_brick_store_add_brick(store, (int32_t[3]){0}, values), WEFT_OK);
    assert_int_equal(weft_brick_store_add_brick(store, (int32_t[3]){0}, values), WEFT_ERR_ARGUMENT);
    const struct weft_volume_tile tiles[] = {
        {{0, 0, 0}, 8, 1}, {{8, 0, 0}, 16, 1}, {{8, 0, 0}, 128, 1}, {{128, 0, 0}, 4096, 1}};
    for (size_t i = 0; i < WEFT_COUNT(tiles); i++)
        assert_int_equal(weft_brick_store_add_tile(store, &tiles[i]), WEFT_ERR_ARGUMENT);
    weft_brick_store_destroy(&store);
    weft_brick_store_destroy(&store);
}

static void test_clamp(void **state)
{
    (void)state;
    weft_brick_store *store = make_store(0);
    float values[WEFT_BRICK_VOXELS], copy[WEFT_BRICK_VOXELS];
    for (int v = 0; v < WEFT_BRICK_VOXELS; v++)
        values[v] = (float)v;
    assert_int_equal(weft_brick_store_add_brick(store, (int32_t[3]){0, 0, 0}, values), WEFT_OK);
    weft_brick_store_clamp(store, (int32_t[3]){0, 0, 0}, (int32_t[3]){7, 7, 7});
    assert_true(brick_voxel(store, -100, 3, 1000000) == 7 * 64 + 3 * 8);
    const float *found;
    float constant;
    assert_int_equal(weft_brick_store_find(store, (int32_t[3]){8, 0, 0}, &found, &constant),
                     WEFT_BRICK_EDGE);
    weft_brick_store_copy(store, (int32_t[3]){8, 0, 0}, copy);
    for (int v = 0; v < WEFT_BRICK_VOXELS; v++)
        assert_true(copy[v] == (float)(v | 7));
    weft_brick_store_destroy(&store);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_many_bricks),
        cmocka_unit_test(test_tiles),
        cmocka_unit_test(test_bad_arguments),
        cmocka_unit_test(test_clamp),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
