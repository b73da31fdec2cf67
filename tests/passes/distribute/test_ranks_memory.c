// SPDX-License-Identifier: BSD-3-Clause
// Where a rank has no memory for what comes, all ranks return the same, and go on.
#include <setjmp.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "filter/check.h"
#include "tests/passes/distribute/threads_transport.h"

enum { SCARCE = (3 << 20) + 4321, FEW = 77 };

void *__real_malloc(size_t size);
void *__wrap_malloc(size_t size);

// Of this size nobody gets so many any more.
static atomic_size_t scarce;
static atomic_int refusals, lines;

void *__wrap_malloc(size_t size)
{
    if (size == atomic_load(&scarce) && atomic_fetch_sub(&refusals, 1) > 0)
        return NULL;
    return __real_malloc(size);
}

static void count_line(void *priv, enum weft_log_level level, const char *message)
{
    (void)priv, (void)message;
    atomic_fetch_add(&lines, level == WEFT_LOG_ERROR);
}

static enum weft_result share(weft_ranks *ranks, int rank, size_t size)
{
    void *data = rank == 0 ? __real_malloc(size) : NULL;
    size_t shared = rank == 0 ? size : 0;
    if (data)
        memset(data, 5, size);
    const enum weft_result res = weft_ranks_share(ranks, &data, &shared);
    THREADS_CHECK(res != WEFT_OK || (shared == size && ((const char *)data)[size - 1] == 5));
    THREADS_CHECK(rank == 0 || res == WEFT_OK || !data);
    free(data);
    return res;
}

static enum weft_result gather(weft_ranks *ranks, int rank, size_t size)
{
    struct weft_ranks_part parts[3];
    char *data = __real_malloc(size);
    memset(data, rank, size);
    const enum weft_result res = weft_ranks_gather(ranks, data, size, parts);
    free(data);
    for (int r = 0; rank == 0 && res == WEFT_OK && r < 3; r++)
        THREADS_CHECK(parts[r].size == size && ((const char *)parts[r].data)[size - 1] == r);
    THREADS_CHECK(rank != 0 || res == WEFT_OK || !parts[0].data);
    if (rank == 0)
        weft_ranks_free_parts(3, parts);
    return res;
}

static enum weft_result make(void *priv, int64_t item, void **data, size_t *size)
{
    (void)item;
    *size = *(const size_t *)priv;
    *data = __real_malloc(*size);
    memset(*data, 9, *size);
    return WEFT_OK;
}

static enum weft_result take(void *priv, int64_t item, const void *data, size_t size)
{
    THREADS_CHECK(size == *(const size_t *)priv && item < 6 && *(const char *)data == 9);
    return WEFT_OK;
}

static enum weft_result do_items(weft_ranks *ranks, int rank, size_t size)
{
    struct weft_items_report report = {0};
    const struct weft_items work = {
        .count = 6, .schedule = WEFT_SCHEDULE_STATIC, .run = make, .take = take, .priv = &size};
    const enum weft_result res = weft_ranks_do_items(ranks, &work, &report);
    THREADS_CHECK(report.failed_rank == (res == WEFT_OK ? -1 : 0));
    THREADS_CHECK(rank != 0 || report.load.ranks == 3);
    weft_items_report_clear(&report);
    return res;
}

static enum weft_result lack_memory(void *priv, weft_ranks *ranks)
{
    static enum weft_result (*const calls[])(weft_ranks *, int, size_t) = {share, gather, do_items};
    static const size_t sizes[] = {SCARCE, FEW};
    struct weft_ranks_info info;
    char line[8] = "";
    (void)priv;
    weft_ranks_get_info(ranks, &info);
    for (size_t c = 0; c < WEFT_COUNT(calls); c++)
        for (size_t s = 0; s < WEFT_COUNT(sizes); s++) {
            if (info.rank == 0) {
                atomic_store(&refusals, 1);
                atomic_store(&scarce, sizes[s]);
            }
            THREADS_CHECK(weft_ranks_agree(ranks, WEFT_OK, line, sizeof line, NULL) == WEFT_OK);
            THREADS_CHECK(calls[c](ranks, info.rank, sizes[s]) == WEFT_ERR_MEMORY);
            THREADS_CHECK(calls[c](ranks, info.rank, sizes[s]) == WEFT_OK);
        }
    return WEFT_OK;
}

static void all_return_the_same(void **state)
{
    (void)state;
    const struct weft_log log = {.write = count_line};
    for (unsigned seed = 0; seed < 3; seed++) {
        struct threads_outcome out;
        atomic_store(&lines, 0);
        threads_run(
            &(struct threads_params){
                .ranks = 3, .seed = seed, .delay = 0.001, .log = &log, .body = lack_memory},
            &out);
        assert_int_equal(threads_faults(), 0);
        assert_int_equal(atomic_load(&lines), 6);
        assert_int_equal(out.lines + out.left, 0);
        for (int r = 0; r < 3; r++)
            assert_int_equal(out.result[r], WEFT_OK);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(all_return_the_same)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
