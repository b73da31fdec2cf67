// SPDX-License-Identifier: BSD-3-Clause
// What ranks do together, over transports that are late and out of order: every rank gets what the
// header says, whatever the sizes, and all that was sent was taken when it ends.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "filter/check.h"
#include "tests/passes/distribute/threads_transport.h"

static const int rank_counts[] = {1, 2, 3, 7};

static struct weft_ranks_info info_of(weft_ranks *ranks)
{
    struct weft_ranks_info info;
    weft_ranks_get_info(ranks, &info);
    return info;
}

// Runs it on so many ranks, which all end well.
static void run_well(weft_body body, void *priv, int ranks, unsigned seed, double delay)
{
    struct threads_params params = {.ranks = ranks, .seed = seed, .delay = delay, .body = body};
    struct threads_outcome out;
    for (int r = 0; r < ranks; r++)
        params.priv[r] = priv;
    threads_run(&params, &out);
    assert_int_equal(threads_faults(), 0);
    assert_int_equal(out.exit_code, -1);
    assert_int_equal(out.lines, 0);
    assert_int_equal(out.left, 0);
    for (int r = 0; r < ranks; r++)
        assert_int_equal(out.result[r], WEFT_OK);
}

static void fill(unsigned char *data, size_t size, unsigned seed)
{
    for (size_t i = 0; i < size; i++)
        data[i] = (unsigned char)((i * 2654435761u + seed) >> 13);
}

static bool is_filled(const unsigned char *data, size_t size, unsigned seed)
{
    for (size_t i = 0; i < size; i++)
        if (data[i] != (unsigned char)((i * 2654435761u + seed) >> 13))
            return false;
    return true;
}

// ---- share and gather ---------------------------------------------------------------------------

static void share_bytes(weft_ranks *ranks, size_t wanted, unsigned seed)
{
    const int rank = info_of(ranks).rank;
    void *data = rank == 0 && wanted > 0 ? malloc(wanted) : NULL;
    size_t size = rank == 0 ? wanted : 12345;
    if (data)
        fill(data, wanted, seed);
    THREADS_CHECK(weft_ranks_share(ranks, &data, &size) == WEFT_OK);
    THREADS_CHECK(size == wanted && (size > 0) == (data != NULL) && is_filled(data, size, seed));
    free(data);
}

// Each rank has another size.
static void gather_bytes(weft_ranks *ranks, size_t most, unsigned seed)
{
    const struct weft_ranks_info info = info_of(ranks);
    struct weft_ranks_part parts[THREADS_RANKS_MAX];
    memset(parts, 0x5a, sizeof parts);
    const size_t size = most * (size_t)(info.rank + 1) / (size_t)info.size;
    unsigned char *data = size > 0 ? malloc(size) : NULL;
    fill(data, size, seed + (unsigned)info.rank);
    THREADS_CHECK(weft_ranks_gather(ranks, data, size, parts) == WEFT_OK);
    memset(data ? data : (unsigned char[1]){0}, 0, size);
    free(data);
    if (info.rank != 0) {
        THREADS_CHECK(parts[0].size == (size_t)0x5a5a5a5a5a5a5a5a);
        return;
    }
    for (int r = 0; r < info.size; r++)
        THREADS_CHECK(parts[r].size == most * (size_t)(r + 1) / (size_t)info.size &&
                      is_filled(parts[r].data, parts[r].size, seed + (unsigned)r));
    weft_ranks_free_parts(info.size, parts);
    THREADS_CHECK(!parts[0].data && parts[0].size == 0);
}

static enum weft_result move_bytes(void *priv, weft_ranks *ranks)
{
    static const size_t sizes[] = {0, 1, 191, 192, 193, 5000, (1 << 20) - 1, 1 << 20, 3200000};
    const size_t count = *(const size_t *)priv;
    for (size_t i = 0; i < count; i++) {
        share_bytes(ranks, sizes[i], (unsigned)i);
        gather_bytes(ranks, sizes[i], 100u + (unsigned)i);
    }
    return WEFT_OK;
}

static void bytes_of_all_sizes_arrive(void **state)
{
    (void)state;
    size_t all = 9, few = 6;
    for (size_t i = 0; i < WEFT_COUNT(rank_counts); i++) {
        run_well(move_bytes, &all, rank_counts[i], (unsigned)i, 0.0);
        for (unsigned seed = 1; seed < 4; seed++)
            run_well(move_bytes, &few, rank_counts[i], seed, 0.002);
    }
}

static enum weft_result move_much(void *priv, weft_ranks *ranks)
{
    (void)priv;
    share_bytes(ranks, (size_t)70000001, 1);
    return WEFT_OK;
}

static void large_messages_arrive(void **state)
{
    (void)state;
    run_well(move_much, NULL, 2, 5, 0.0);
}

// ---- agree and compare --------------------------------------------------------------------------

struct opinion {
    enum weft_result result[THREADS_RANKS_MAX];
    const char *line[THREADS_RANKS_MAX];
    enum weft_result agreed;
    int failed;
    const char *told;
};

static const struct opinion opinions[] = {
    {.failed = -1},
    {{WEFT_ERR_GL}, {"no GL"}, WEFT_ERR_GL, 0, "no GL"},
    {{0, WEFT_ERR_OPEN}, {"", "no file"}, WEFT_ERR_OPEN, 1, "no file"},
    {{WEFT_ERR_GL, WEFT_ERR_OPEN}, {"no GL", "no file"}, WEFT_ERR_GL, 0, "no GL"},
    // A rank that only heard of it has nothing to say.
    {{WEFT_ERR_OPEN, WEFT_ERR_OPEN}, {"", "no file"}, WEFT_ERR_OPEN, 1, "no file"},
    {{WEFT_ERR_OPEN, WEFT_ERR_OPEN}, {"", ""}, WEFT_ERR_OPEN, 0, ""},
    {{0, WEFT_ERR_FORMAT}, {"said without a need", ""}, WEFT_ERR_FORMAT, 1, ""},
};

static enum weft_result agree(void *priv, weft_ranks *ranks)
{
    const struct weft_ranks_info info = info_of(ranks);
    (void)priv;
    for (size_t i = 0; i < WEFT_COUNT(opinions); i++) {
        const struct opinion *o = &opinions[i];
        char line[64] = "";
        int failed = 99;
        if (info.size == 1 && o->failed > 0)
            continue;
        if (o->line[info.rank])
            (void)snprintf(line, sizeof line, "%s", o->line[info.rank]);
        THREADS_CHECK(weft_ranks_agree(ranks, o->result[info.rank], line, sizeof line, &failed) ==
                      o->agreed);
        THREADS_CHECK(info.size == 1 || failed == o->failed);
        THREADS_CHECK(info.rank != 0 || o->failed < 0 || strcmp(line, o->told) == 0);
    }
    char cut[4] = "abc";
    THREADS_CHECK(weft_ranks_agree(ranks, info.rank == info.size - 1 ? WEFT_ERR_LIMIT : WEFT_OK,
                                   cut, sizeof cut, NULL) == WEFT_ERR_LIMIT);
    THREADS_CHECK(strcmp(cut, "abc") == 0);
    return WEFT_OK;
}

static void all_agree(void **state)
{
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(rank_counts); i++)
        for (unsigned seed = 0; seed < 3; seed++)
            run_well(agree, NULL, rank_counts[i], seed, 0.003);
}

static char logged[1024];

static void keep_line(void *priv, enum weft_log_level level, const char *message)
{
    (void)priv, (void)level;
    (void)snprintf(logged, sizeof logged, "%s", message);
}

static enum weft_result compare(void *priv, weft_ranks *ranks)
{
    const int rank = info_of(ranks).rank;
    (void)priv;
    THREADS_CHECK(weft_ranks_compare(ranks, "the version", "0.1.0") == WEFT_OK);
    THREADS_CHECK(weft_ranks_compare(ranks, "the renderer", rank == 2 ? "iron" : "pipes") ==
                  WEFT_ERR_UNSUPPORTED);
    THREADS_CHECK(weft_ranks_compare(ranks, "the nothing", rank == 1 ? "" : "x") ==
                  WEFT_ERR_UNSUPPORTED);
    return WEFT_OK;
}

static void what_differs_is_named(void **state)
{
    (void)state;
    const struct weft_log log = {.write = keep_line};
    struct threads_outcome out;
    threads_run(&(struct threads_params){.ranks = 3, .body = compare, .log = &log, .node_ranks = 1},
                &out);
    assert_int_equal(threads_faults(), 0);
    assert_string_equal(logged,
                        "the nothing of rank 1 on node1 is '', of rank 0 on node0 it is 'x'");
}

// ---- bodies -------------------------------------------------------------------------------------

static enum weft_result return_own(void *priv, weft_ranks *ranks)
{
    (void)ranks;
    return *(const enum weft_result *)priv;
}

static void each_rank_has_its_result(void **state)
{
    (void)state;
    enum weft_result results[3] = {WEFT_ERR_GL, WEFT_OK, WEFT_ERR_OPEN};
    struct threads_params params = {.ranks = 3, .body = return_own};
    struct threads_outcome out;
    for (int r = 0; r < 3; r++)
        params.priv[r] = &results[r];
    threads_run(&params, &out);
    for (int r = 0; r < 3; r++)
        assert_int_equal(out.result[r], results[r]);
    assert_int_equal(out.lines + out.left, 0);
}

static enum weft_result tell_info(void *priv, weft_ranks *ranks)
{
    const struct weft_ranks_info info = info_of(ranks);
    (void)priv;
    char host[16];
    (void)snprintf(host, sizeof host, "node%d", info.rank / 2);
    THREADS_CHECK(info.size == 7 && info.rank < 7 && info.timeout == 60.0);
    THREADS_CHECK(info.node_size == 2 && info.node_rank == info.rank % 2 &&
                  info.node == info.rank / 2 * 2);
    THREADS_CHECK(info.threads == info.rank + 1 && strcmp(info.host, host) == 0);
    return WEFT_OK;
}

static void ranks_know_where_they_are(void **state)
{
    (void)state;
    struct threads_outcome out;
    threads_run(&(struct threads_params){.ranks = 7, .node_ranks = 2, .body = tell_info}, &out);
    assert_int_equal(threads_faults(), 0);
}

// ---- mistakes of callers ------------------------------------------------------------------------

static void transports_are_checked(void **state)
{
    (void)state;
    const struct weft_log log = {.write = keep_line};
    struct weft_transport bad[] = {
        {.rank = 0, .size = 0, .node_size = 1, .threads = 1},
        {.rank = 2, .size = 2, .node_size = 1, .threads = 1},
        {.rank = -1, .size = 2, .node_size = 1, .threads = 1},
        {.rank = 0, .size = 2, .node_size = 1, .threads = 1},            // no functions
        {.rank = 1, .size = 2, .node = 2, .node_size = 1, .threads = 1}, // a node of others
        {.rank = 0, .size = 1, .node_size = 1},                          // no threads
    };
    for (size_t i = 0; i < WEFT_COUNT(bad); i++) {
        logged[0] = '\0';
        enum weft_result none = WEFT_OK;
        assert_int_equal(
            weft_distribute_over(&bad[i], weft_distribute_params(.log = &log), return_own, &none),
            WEFT_ERR_ARGUMENT);
        assert_true(logged[0]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bytes_of_all_sizes_arrive),
        cmocka_unit_test(large_messages_arrive),
        cmocka_unit_test(all_agree),
        cmocka_unit_test(what_differs_is_named),
        cmocka_unit_test(each_rank_has_its_result),
        cmocka_unit_test(ranks_know_where_they_are),
        cmocka_unit_test(transports_are_checked),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
