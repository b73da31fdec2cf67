// SPDX-License-Identifier: BSD-3-Clause
// Places for cells, and cached volumes: against lists that are searched from end to end.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdlib.h>
#include <string.h>

#include "tests/support/common.h"
#include "tiles/volume/cell_cache.h"
#include "tiles/volume/volume_cache.h"
#include "tiles/volume/volume_impl.h"

static uint64_t random_state;

static int below(int n)
{
    uint64_t h = random_state += UINT64_C(0x9e3779b97f4a7c15);
    h = (h ^ h >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    return (int)((h ^ h >> 27) % (uint64_t)n);
}

// ---- places -------------------------------------------------------------------------------------

enum { MOST = 40 };

// What a cache has to hold, from the one most recently used.
struct model {
    int count;
    struct weft_cell_key keys[MOST];
    int64_t places[MOST];
};

static int find(const struct model *m, const struct weft_cell_key *key)
{
    int i = 0;
    while (i < m->count && memcmp(&m->keys[i], key, sizeof *key) != 0)
        i++;
    return i;
}

static void take_out(struct model *m, int i)
{
    m->count--;
    memmove(&m->keys[i], &m->keys[i + 1], (size_t)(m->count - i) * sizeof m->keys[0]);
    memmove(&m->places[i], &m->places[i + 1], (size_t)(m->count - i) * sizeof m->places[0]);
}

static void put_first(struct model *m, struct weft_cell_key key, int64_t place)
{
    memmove(&m->keys[1], &m->keys[0], (size_t)m->count * sizeof m->keys[0]);
    memmove(&m->places[1], &m->places[0], (size_t)m->count * sizeof m->places[0]);
    m->keys[0] = key;
    m->places[0] = place;
    m->count++;
}

static void check(const struct weft_cell_cache *cache, const struct model *m)
{
    uint32_t n = cache->newest;
    assert_int_equal(cache->count, m->count);
    for (int i = 0; i < m->count; i++, n = cache->places[n - 1].older) {
        assert_int_equal(n - 1, m->places[i]);
        assert_int_equal(weft_cell_cache_find(cache, m->keys[i].at), m->places[i]);
        for (int j = 0; j < i; j++)
            assert_true(m->places[j] != m->places[i]);
    }
    assert_int_equal(n, 0);
}

static void places_go_by_use(void **state)
{
    (void)state;
    int evictions = 0, removals = 0, uses = 0;
    for (int limit = 1; limit <= MOST - 1; limit += 6) {
        struct weft_cell_cache cache = {.limit = (size_t)limit};
        struct model m = {.count = 0};
        random_state = (uint64_t)limit;
        for (int step = 0; step < 3000; step++) {
            struct weft_cell_key key = {{below(4) - 2, below(4), below(5) * 100}};
            const int i = find(&m, &key);
            const int64_t place = weft_cell_cache_find(&cache, key.at);
            assert_int_equal(place, i < m.count ? m.places[i] : WEFT_CELL_NONE);
            if (i == m.count) {
                bool evicted;
                const bool full = m.count == limit;
                if (full)
                    take_out(&m, m.count - 1);
                put_first(&m, key, weft_cell_cache_add(&cache, key, &evicted));
                assert_true(m.places[0] >= 0 && m.places[0] < limit);
                assert_int_equal(evicted, full);
                evictions += full;
            } else if (below(3)) {
                weft_cell_cache_use(&cache, place);
                take_out(&m, i);
                put_first(&m, key, place);
                uses++;
            } else {
                weft_cell_cache_remove(&cache, place);
                take_out(&m, i);
                removals++;
            }
            check(&cache, &m);
        }
        weft_cell_cache_clear(&cache);
        assert_int_equal(weft_cell_cache_find(&cache, (const int32_t[]){0, 0, 0}), WEFT_CELL_NONE);
    }
    assert_true(evictions > 1000 && removals > 500 && uses > 1000);
}

static void without_places_nothing_is_added(void **state)
{
    (void)state;
    struct weft_cell_cache cache = {.limit = 0};
    bool evicted = true;
    assert_int_equal(weft_cell_cache_add(&cache, (struct weft_cell_key){{1, 2, 3}}, &evicted),
                     WEFT_CELL_NONE);
    assert_false(evicted);
    assert_int_equal(weft_cell_cache_remove_oldest(&cache), WEFT_CELL_NONE);
    weft_cell_cache_clear(&cache);
}

// ---- cached volumes -----------------------------------------------------------------------------

// Bricks whose voxels are their own first coordinate / 8, counted when they are read.
struct source {
    uint64_t reads;
};

static enum weft_result find_source(weft_volume *volume, const struct weft_region *region,
                                    struct weft_brick_list *out)
{
    (void)volume;
    (void)region;
    *out = (struct weft_brick_list){0};
    return WEFT_OK;
}

static enum weft_result read_source(weft_volume *volume, size_t count, const int32_t (*origin)[3],
                                    float *values)
{
    ((struct source *)volume->data)->reads += count;
    for (size_t i = 0; i < count * WEFT_BRICK_VOXELS; i++)
        values[i] = (float)(origin[i / WEFT_BRICK_VOXELS][0] / WEFT_BRICK_SIZE);
    return WEFT_OK;
}

static void clear_source(void *data)
{
    (void)data;
}

static uint64_t read_bricks(weft_volume *cache, const struct source *source, int count,
                            const int *bricks)
{
    static float values[16 * WEFT_BRICK_VOXELS];
    const uint64_t before = source->reads;
    int32_t origin[16][3] = {{0}};
    for (int i = 0; i < count; i++)
        origin[i][0] = WEFT_BRICK_SIZE * bricks[i];
    assert_int_equal(weft_volume_read(cache, (size_t)count, (const int32_t(*)[3])origin, values),
                     WEFT_OK);
    for (int i = 0; i < count * WEFT_BRICK_VOXELS; i++)
        assert_true(values[i] == (float)bricks[i / WEFT_BRICK_VOXELS]);
    return source->reads - before;
}
#define READ(...)                                                                                  \
    read_bricks(cache, source, sizeof((const int[]){__VA_ARGS__}) / sizeof(int),                   \
                (const int[]){__VA_ARGS__})

static void bricks_least_recently_asked_for_go_first(void **state)
{
    static const struct weft_volume_backend backend = {sizeof(struct source), find_source,
                                                       read_source, clear_source};
    enum { BRICK_BYTES = WEFT_BRICK_VOXELS * sizeof(float) };
    (void)state;
    weft_volume *base = NULL, *cache = NULL;
    assert_int_equal(weft_volume_make(&log_to_stderr, &backend, &base), WEFT_OK);
    assert_int_equal(weft_volume_cache(base, &log_to_stderr, &cache), WEFT_OK);
    const struct source *source = base->data;
    const struct weft_volume_cache_info *info = weft_volume_cache_get_info(cache);
    assert_int_equal(READ(1, 2), 2); // nothing is kept yet
    assert_int_equal(READ(1, 2), 2);
    weft_volume_cache_limit(cache, 4 * BRICK_BYTES);
    assert_int_equal(READ(1, 2, 3, 4), 4);
    assert_int_equal(info->kept_bytes, 4 * BRICK_BYTES);
    assert_int_equal(READ(4, 1, 1), 0);
    assert_int_equal(READ(5), 1);       // in the place of 2
    assert_int_equal(READ(3, 4, 1), 0); // which stayed
    assert_int_equal(READ(2, 3), 1);    // in the place of 5
    assert_int_equal(READ(1, 2, 3, 4), 0);
    assert_int_equal(info->kept_bytes, 4 * BRICK_BYTES);
    weft_volume_cache_limit(cache, 2 * BRICK_BYTES + 1);
    assert_int_equal(info->kept_bytes, 2 * BRICK_BYTES);
    assert_int_equal(READ(3, 4), 0);
    assert_int_equal(READ(6, 7, 8, 9, 8), 5); // more than is kept, one of them twice
    assert_int_equal(info->kept_bytes, 2 * BRICK_BYTES);
    weft_volume_cache_limit(cache, 8 * BRICK_BYTES);
    assert_int_equal(READ(10, 11, 12, 13, 14, 15), 6);
    assert_int_equal(READ(10, 11, 12, 13, 14, 15), 0);
    assert_int_equal(info->bricks_read, source->reads);
    weft_volume_cache_limit(cache, 0);
    assert_int_equal(info->kept_bytes, 0);
    assert_int_equal(READ(10), 1);
    weft_volume_destroy(&cache);
    weft_volume_destroy(&base);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(places_go_by_use),
        cmocka_unit_test(without_places_nothing_is_added),
        cmocka_unit_test(bricks_least_recently_asked_for_go_first),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
