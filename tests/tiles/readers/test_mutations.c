// SPDX-License-Identifier: BSD-3-Clause
// Mutated VDB, NRRD and NIfTI files: each must be read, or refused with a clean error, within the
// limits, and at a cost that its size explains. WEFT_MUTATIONS is their number (default 40),
// WEFT_MUTATION_SEED their seed (default 1).
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/resource.h>

#include <cmocka.h>

#include "filter/check.h"
#include "tests/support/vdb_files.h"

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
    struct bytes bytes;
    bytes.data = read_whole(path, &bytes.size);
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
    write_whole(path, data, size);
    free(data);
}

// memory_bytes: 0 = the default for the file.
static enum weft_result try_file(const char *path, uint64_t memory_bytes)
{
    weft_volume *volume = NULL;
    struct weft_brick_list list = {0};
    struct weft_volume_open_params params = {
        .path = path,
        .limits = {.memory_bytes = memory_bytes, .cpu_seconds = 5, .wall_seconds = 10},
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

static void mutate(const char *path, const char *name, int count)
{
    static const enum weft_result clean[] = {WEFT_OK,         WEFT_ERR_UNSUPPORTED, WEFT_ERR_LIMIT,
                                             WEFT_ERR_FORMAT, WEFT_ERR_READER,      WEFT_ERR_OPEN};
    size_t counts[WEFT_COUNT(clean)] = {0};
    double longest = 0;
    char mutant[512];
    snprintf(mutant, sizeof mutant, "%s/mutant.vdb", test_folder);
    struct bytes source = load(path);
    if (!source.size)
        skip();
    const int fds = count_fds();
    uint64_t seed = (uint64_t)setting("WEFT_MUTATION_SEED", 1);
    for (int i = 0; i < count; i++) {
        random_state = seed << 32 | (uint64_t)i;
        save_mutation(mutant, source);
        double start = weft_now_seconds();
        enum weft_result res = try_file(mutant, UINT64_C(1) << 30);
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
                  "%zu readers lost, %zu without their files; longest %.2f s\n",
                  name, count, counts[0], counts[1], counts[2], counts[3], counts[4], counts[5],
                  longest);
    free(source.data);
    assert_true(count < 40 || counts[0] < (size_t)count); // few damages are none
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
    mutate(path, "generated", setting("WEFT_MUTATIONS", 40));
}

static void test_smoke(void **state)
{
    (void)state;
    mutate(WEFT_TEST_DATA "/smoke.vdb", "smoke.vdb", setting("WEFT_MUTATIONS", 40));
}

// Their share each; the detached header is damaged alone, and may name files that are not there.
static void test_dense(void **state)
{
    (void)state;
    static const char *const names[] = {"nrrd/BallBinary30x30x30.nrrd",
                                        "nrrd/BallBinary30x30x30_gz.nrrd",
                                        "nrrd/BallBinary30x30x30_bz2.nrrd",
                                        "nrrd/BallBinary30x30x30.nhdr",
                                        "nrrd/test2d_ascii.nrrd",
                                        "nrrd/test_simple4d_raw.nrrd",
                                        "nifti/anatomical.nii",
                                        "nifti/example4d.nii.gz",
                                        "nifti/example_nifti2.nii.gz",
                                        "nifti/functional.nii"};
    char path[512];
    for (size_t i = 0; i < WEFT_COUNT(names); i++) {
        snprintf(path, sizeof path, WEFT_TEST_DATA "/%s", names[i]);
        mutate(path, names[i], setting("WEFT_MUTATIONS", 40) / (int)WEFT_COUNT(names));
    }
}

// ---- lengths and counts -------------------------------------------------------------------------

#if defined(__SANITIZE_ADDRESS__)
enum { SANITIZED = 1 };
#else
enum { SANITIZED = 0 };
#endif

static uint32_t word_at(struct bytes source, size_t at)
{
    uint32_t word;
    memcpy(&word, source.data + at, sizeof word);
    return word;
}

static bool text_at(struct bytes source, size_t at, size_t length)
{
    for (size_t i = 0; i < length; i++)
        if (source.data[at + i] < 0x20 || source.data[at + i] > 0x7e)
            return false;
    return true;
}

static bool length_at(struct bytes source, size_t at)
{
    if (at + 8 > source.size)
        return false;
    uint32_t length = word_at(source, at);
    return length >= 2 && length <= 64 && at + 4 + length <= source.size &&
           text_at(source, at + 4, length);
}

// Lengths of texts, counts before texts, and lengths of values behind their type's name.
static size_t find_lengths(struct bytes source, size_t *places)
{
    size_t count = 0;
    for (size_t at = 4; at + 8 <= source.size; at++) {
        bool behind = text_at(source, at - 4, 4) && word_at(source, at) <= 256;
        if (length_at(source, at) || length_at(source, at + 4) || behind)
            places[count++] = at;
    }
    return count;
}

static double children_seconds(void)
{
    struct rusage used;
    getrusage(RUSAGE_CHILDREN, &used);
    return (double)(used.ru_utime.tv_sec + used.ru_stime.tv_sec) +
           1e-6 * (double)(used.ru_utime.tv_usec + used.ru_stime.tv_usec);
}

static long children_kilobytes(void)
{
    struct rusage used;
    getrusage(RUSAGE_CHILDREN, &used);
    return used.ru_maxrss;
}

// No length makes the readers allocate or do what the file's bytes do not need: 64 MiB more than
// for the good file, a second of processor time.
static void test_lengths(void **state)
{
    (void)state;
    char command[1024], mutant[512];
    snprintf(command, sizeof command, "%s/make_vdb_fixtures %s", WEFT_BINARY_DIR, test_folder);
    assert_int_equal(system(command), 0);
    struct bytes source = load(file_path("kinds.vdb"));
    assert_non_null(source.data);
    size_t *places = malloc(source.size * sizeof *places);
    assert_non_null(places);
    const size_t place_count = find_lengths(source, places);
    assert_true(place_count > 100);
    snprintf(mutant, sizeof mutant, "%s", file_path("mutant.vdb"));
    assert_int_equal(try_file(file_path("kinds.vdb"), 0), WEFT_OK);
    const long usual = children_kilobytes();
    double longest = 0;
    int read = 0, count = setting("WEFT_MUTATIONS", 40);
    random_state = (uint64_t)setting("WEFT_MUTATION_SEED", 1);
    for (int i = 0; i < count; i++) {
        const size_t at = places[next_random() % place_count];
        const uint32_t good = word_at(source, at), size = (uint32_t)source.size;
        const uint32_t bad[] = {UINT32_MAX, INT32_MAX, 0x10000000, size, size + 1, good + 1, 0};
        const uint32_t value = bad[next_random() % WEFT_COUNT(bad)];
        memcpy(source.data + at, &value, sizeof value);
        write_whole(mutant, source.data, source.size);
        memcpy(source.data + at, &good, sizeof good);
        const double start = children_seconds();
        const enum weft_result res = try_file(mutant, 0);
        const double seconds = children_seconds() - start;
        longest = seconds > longest ? seconds : longest;
        read += res == WEFT_OK;
        if (!SANITIZED && (seconds > 1.0 || children_kilobytes() > usual + 65536))
            fail_msg("word %zu of kinds.vdb = %u: %.2f s, %ld KiB (usually %ld): %s", at, value,
                     seconds, children_kilobytes(), usual, last_error.message);
        if (res != WEFT_OK && !*last_error.message)
            fail_msg("word %zu of kinds.vdb = %u: no message", at, value);
        if (res == WEFT_ERR_READER)
            fail_msg("word %zu of kinds.vdb = %u: %s", at, value, last_error.message);
    }
    print_message("kinds.vdb: %d lengths at %zu places: %d read; up to %.2f s and %ld KiB, usually "
                  "%ld KiB\n",
                  count, place_count, read, longest, children_kilobytes(), usual);
    assert_true(count < 40 || read < count);
    free(places);
    free(source.data);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_lengths), // first: it measures the largest child so far
        cmocka_unit_test(test_generated),
        cmocka_unit_test(test_smoke),
        cmocka_unit_test(test_dense),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
