// SPDX-License-Identifier: BSD-3-Clause
// Mutated VDB files: each must be read, or refused with a clean error, within the limits.
// WEFT_MUTATIONS is their number (default 60), WEFT_MUTATION_SEED their seed (default 1).
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/stat.h>

#include <cmocka.h>

#include "filter/check.h"
#include "tests/vdb_files.h"

struct bytes {
    unsigned char *data;
    size_t size;
};

static uint64_t random_state;

static uint64_t next_random(void)
{
    uint64_t z = random_state += UINT64_C(0x9e3779b97f4a7c15);
    z = (z ^ z >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ z >> 27) * UINT64_C(0x94d049bb133111eb);
    return z ^ z >> 31;
}

static int setting(const char *name, int otherwise)
{
    const char *text = getenv(name);
    return text && *text ? atoi(text) : otherwise;
}

static struct bytes load(const char *path)
{
    struct bytes bytes = {0};
    struct stat info;
    FILE *file = stat(path, &info) ? NULL : fopen(path, "rb");
    if (!file)
        return bytes;
    bytes.data = malloc((size_t)info.st_size + 1);
    if (bytes.data)
        bytes.size = fread(bytes.data, 1, (size_t)info.st_size, file);
    fclose(file);
    return bytes;
}

// Bits, bytes or whole words, mostly near the start, where the structure lies; some files are cut.
static void save_mutation(const char *path, struct bytes source)
{
    static const uint32_t words[] = {0, 1, 0x7fffffff, 0x80000000, 0xffffffff, 0x10000, 4096, 512};
    unsigned char *data = malloc(source.size + 4);
    assert_non_null(data);
    memcpy(data, source.data, source.size);
    size_t size = source.size;
    int changes = 1 + (int)(next_random() % 8);
    for (int i = 0; i < changes; i++) {
        size_t reach = next_random() % 3 ? (source.size < 4096 ? source.size : 4096) : source.size;
        size_t at = next_random() % reach;
        switch (next_random() % 4) {
        case 0:
            data[at] ^= (unsigned char)(1u << next_random() % 8);
            break;
        case 1:
            data[at] = (unsigned char)next_random();
            break;
        case 2:
            memcpy(data + at, &words[next_random() % WEFT_COUNT(words)], 4);
            break;
        default:
            if (next_random() % 8 == 0)
                size = 1 + next_random() % size;
        }
    }
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(data, 1, size, file), size);
    fclose(file);
    free(data);
}

static enum weft_result try_file(const char *path)
{
    weft_volume *volume = NULL;
    struct weft_brick_list list = {0};
    struct weft_volume_open_params params = {
        .path = path,
        .limits = {.memory_bytes = UINT64_C(1) << 30, .cpu_seconds = 5, .wall_seconds = 10},
        .log = &test_log};
    struct weft_volume_list grids;
    *last_error.message = 0;
    if (weft_volume_list_load(&params, &grids) == WEFT_OK)
        weft_volume_list_clear(&grids);
    enum weft_result res = weft_volume_open(&params, &volume);
    if (!res)
        res = weft_volume_find(volume, &everywhere, &list);
    if (!res && list.brick_count) {
        size_t count = list.brick_count < 20000 ? list.brick_count : 20000;
        float *values = malloc(count * 2048);
        assert_non_null(values);
        res = weft_volume_read(volume, count, (const int32_t(*)[3])list.brick_origin, values);
        free(values);
    }
    weft_brick_list_clear(&list);
    weft_volume_destroy(&volume);
    return res;
}

static void mutate(const char *path, const char *name)
{
    static const enum weft_result clean[] = {WEFT_OK, WEFT_ERR_UNSUPPORTED, WEFT_ERR_LIMIT,
                                             WEFT_ERR_FORMAT, WEFT_ERR_READER};
    size_t counts[WEFT_COUNT(clean)] = {0};
    double longest = 0;
    char mutant[512];
    snprintf(mutant, sizeof mutant, "%s/mutant.vdb", test_folder);
    struct bytes source = load(path);
    if (!source.size)
        skip();
    int count = setting("WEFT_MUTATIONS", 60), fds = count_fds();
    uint64_t seed = (uint64_t)setting("WEFT_MUTATION_SEED", 1);
    for (int i = 0; i < count; i++) {
        random_state = seed << 32 | (uint64_t)i;
        save_mutation(mutant, source);
        double start = weft_now_seconds();
        enum weft_result res = try_file(mutant);
        double seconds = weft_now_seconds() - start;
        longest = seconds > longest ? seconds : longest;
        size_t which = 0;
        while (which < WEFT_COUNT(clean) && clean[which] != res)
            which++;
        if (which == WEFT_COUNT(clean) || (res && !*last_error.message))
            fail_msg("mutation %d of seed %llu: %s: %s", i, (unsigned long long)seed,
                     weft_result_text(res), last_error.message);
        counts[which]++;
        if (res == WEFT_ERR_READER && getenv("WEFT_MUTATION_VERBOSE"))
            print_message("mutation %d: %s\n", i, last_error.message);
    }
    print_message("%s: %d mutations: %zu read, %zu unsupported, %zu over a limit, %zu refused, "
                  "%zu readers lost; longest %.2f s\n",
                  name, count, counts[0], counts[1], counts[2], counts[3], counts[4], longest);
    free(source.data);
    assert_int_equal(count_fds(), fds);
}

static void test_generated(void **state)
{
    (void)state;
    char path[512];
    snprintf(path, sizeof path, "%s/source.vdb", test_folder);
    weft_volume *sphere = make_sphere(30, (int32_t[3]){0}, NULL);
    struct weft_volume_save_params params = {.path = path, .log = &test_log};
    assert_int_equal(weft_volume_save(sphere, &params), WEFT_OK);
    weft_volume_destroy(&sphere);
    mutate(path, "generated");
}

static void test_smoke(void **state)
{
    (void)state;
    mutate(WEFT_TEST_DATA "/smoke.vdb", "smoke.vdb");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_generated),
        cmocka_unit_test(test_smoke),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
