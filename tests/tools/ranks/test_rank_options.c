// SPDX-License-Identifier: BSD-3-Clause
// The options that verbs share which run on several ranks, read and turned into regions; how many
// ranks there are is the test's own.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <string.h>
#include <unistd.h>

#include "tests/tools/ranks/told.h"
#include "tools/ranks/options.h"
#include "tools/ranks/ranks.h"

static int size = 1;
static double timeout;

weft_ranks *ranks_get(void)
{
    return NULL;
}

int ranks_size(void)
{
    return size;
}

bool ranks_tells(void)
{
    return true;
}

enum weft_result weft_ranks_set_timeout(weft_ranks *ranks, double seconds)
{
    (void)ranks;
    timeout = seconds;
    return WEFT_OK;
}

static const struct option_spec options[RANK_OPTION_COUNT] = {RANK_OPTIONS(0)};

// The words of `line` as options. Returns as rank_options_read; what is told is kept.
static enum weft_result read_line(const char *line, struct rank_request *out, char *told,
                                  size_t told_size)
{
    static char text[512];
    static struct option_value values[RANK_OPTION_COUNT];
    char *argv[16], *rest = NULL;
    int argc = 0;
    snprintf(text, sizeof text, "%s", line);
    for (char *word = strtok_r(text, " ", &rest); word; word = strtok_r(NULL, " ", &rest))
        argv[argc++] = word;
    memset(values, 0, sizeof values);
    struct option_parse parse = {"antialias", options, RANK_OPTION_COUNT, values, NULL, 0, 0,
                                 OPTION_HELP_NONE, false};
    const struct told file = told_begin();
    const bool parsed = options_parse(&parse, argc, argv);
    enum weft_result res = parsed ? rank_options_read(values, out) : WEFT_ERR_ARGUMENT;
    told_end(file, told, told_size);
    return res;
}

static void options_are_read(void **state)
{
    (void)state;
    static const struct {
        const char *line;
        struct rank_request want;
        double timeout;
    } cases[] = {
        {"", {.given = false}, 0.0},
        {"--region 7", {.given = true, .region = {7, 7}}, 0.0},
        {"--region 64x32", {.given = true, .region = {64, 32}}, 0.0},
        {"--region rows:1", {.given = true, .region = {0, 1}}, 0.0},
        {"--region frame --schedule pull",
         {.given = true, .region = {-1, -1}, .schedule = WEFT_SCHEDULE_PULL},
         0.0},
        {"--granularity 12 --schedule dynamic --mixed",
         {.given = true, .granularity = 12, .schedule = WEFT_SCHEDULE_DYNAMIC, .mixed = true},
         0.0},
        {"--region 16777216x1", {.given = true, .region = {16777216, 1}}, 0.0},
        {"--rank-timeout 0.5", {.given = true}, 0.5},
        {"--mixed", {.given = true, .mixed = true}, 0.0},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct rank_request got;
        char told[512];
        timeout = 0.0;
        const enum weft_result res = read_line(cases[i].line, &got, told, sizeof told);
        if (res != WEFT_OK)
            fail_msg("%s: %s", cases[i].line, told);
        assert_string_equal(told, "");
        assert_int_equal(got.given, cases[i].want.given);
        assert_int_equal(got.schedule, cases[i].want.schedule);
        assert_memory_equal(got.region, cases[i].want.region, sizeof got.region);
        assert_int_equal(got.granularity, cases[i].want.granularity);
        assert_int_equal(got.mixed, cases[i].want.mixed);
        assert_null(got.cost_map);
        assert_null(got.chart);
        assert_true(timeout == cases[i].timeout);
    }
}

// Every one in a line that holds what was written.
static void what_is_wrong_is_said(void **state)
{
    (void)state;
    static const struct {
        const char *line, *said[3];
        enum weft_result result;
    } cases[] = {
        {"--region 0", {"--region 0:", "1 to 16777216"}, WEFT_ERR_ARGUMENT},
        {"--region 7x", {"--region 7x:", "WxH"}, WEFT_ERR_ARGUMENT},
        {"--region 7x0", {"--region 7x0:"}, WEFT_ERR_ARGUMENT},
        {"--region=-7", {"--region -7:"}, WEFT_ERR_ARGUMENT},
        {"--region +7", {"--region +7:"}, WEFT_ERR_ARGUMENT},
        {"--region 7.5", {"--region 7.5:"}, WEFT_ERR_ARGUMENT},
        {"--region 7x7x7", {"--region 7x7x7:"}, WEFT_ERR_ARGUMENT},
        {"--region rows:", {"--region rows::", "rows:N"}, WEFT_ERR_ARGUMENT},
        {"--region rows:4x4", {"--region rows:4x4:"}, WEFT_ERR_ARGUMENT},
        {"--region rows", {"--region rows:"}, WEFT_ERR_ARGUMENT},
        {"--region frames", {"--region frames:", "frame"}, WEFT_ERR_ARGUMENT},
        {"--region 16777217", {"--region 16777217:"}, WEFT_ERR_ARGUMENT},
        {"--region 99999999999999999999", {"--region 9999", "16777216"}, WEFT_ERR_ARGUMENT},
        {"--region 7 --granularity 3", {"--region 7", "--granularity 3"}, WEFT_ERR_ARGUMENT},
        {"--region frame --schedule dynamic", {"--schedule dynamic", "pull"}, WEFT_ERR_ARGUMENT},
        {"--granularity 0", {"--granularity 0:", "1 to 4194304"}, WEFT_ERR_ARGUMENT},
        {"--granularity 1.5", {"--granularity 1.5:"}, WEFT_ERR_ARGUMENT},
        {"--schedule guided", {"guided", "static, dynamic, pull"}, WEFT_ERR_ARGUMENT},
        {"--rank-timeout 0.4", {"--rank-timeout 0.4:", "0.5"}, WEFT_ERR_ARGUMENT},
        {"--rank-timeout 1e6", {"--rank-timeout 1e6:", "86400"}, WEFT_ERR_ARGUMENT},
        {"--cost-map -- -", {"--cost-map"}, WEFT_ERR_ARGUMENT},
        {"--cost-map=-", {"--cost-map -:", "file"}, WEFT_ERR_ARGUMENT},
        {"--cost-map /dev/stdout", {"--cost-map /dev/stdout:"}, WEFT_ERR_ARGUMENT},
        {"--cost-map /nowhere/map", {"/nowhere"}, WEFT_ERR_WRITE},
        {"--load-chart load.gif", {"load.gif", ".pdf or .eps"}, WEFT_ERR_ARGUMENT},
        {"--load-chart load", {"--load-chart load:", ".pdf or .eps"}, WEFT_ERR_ARGUMENT},
        {"--load-chart /nowhere/load.svg", {"/nowhere"}, WEFT_ERR_WRITE},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct rank_request got;
        char told[1024];
        const enum weft_result res = read_line(cases[i].line, &got, told, sizeof told);
        if (res != cases[i].result)
            fail_msg("%s: result %d instead of %d: %s", cases[i].line, res, cases[i].result, told);
        for (int s = 0; s < 3 && cases[i].said[s]; s++)
            if (!strstr(told, cases[i].said[s]))
                fail_msg("%s: no '%s' in: %s", cases[i].line, cases[i].said[s], told);
        const char *end = strchr(told, '\n');
        assert_non_null(end);
        assert_string_equal(end, "\n"); // one line
    }
}

// ---- regions ------------------------------------------------------------------------------------

static enum weft_result divide(const struct rank_request *request, const int picture[2],
                               int granularity, int least, weft_regions **out)
{
    const struct weft_regions_params params =
        rank_options_regions(request, picture, granularity, least);
    return weft_regions_create(&params, out);
}

static void pictures_are_divided_as_asked_for(void **state)
{
    (void)state;
    static const struct {
        const char *line;
        int ranks, size[2], granularity, least;
        int64_t count;
        struct weft_rectangle first, last;
    } cases[] = {
        {"--region 64", 2, {200, 100}, 8, 1, 8, {0, 0, 64, 64}, {192, 64, 8, 36}},
        {"--region 7x5", 3, {7, 5}, 8, 1, 1, {0, 0, 7, 5}, {0, 0, 7, 5}},
        {"--region 1", 7, {4, 3}, 8, 4, 12, {0, 0, 1, 1}, {3, 2, 1, 1}},
        {"--region rows:3", 2, {50, 10}, 8, 1, 4, {0, 0, 50, 3}, {0, 9, 50, 1}},
        {"--region frame", 7, {50, 10}, 8, 1, 1, {0, 0, 50, 10}, {0, 0, 50, 10}},
        {"--region 4096", 2, {50, 10}, 8, 1, 1, {0, 0, 50, 10}, {0, 0, 50, 10}},
        {"--region 4096x2", 2, {50, 10}, 8, 1, 5, {0, 0, 50, 2}, {0, 8, 50, 2}},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct rank_request request;
        char told[512];
        weft_regions *regions = NULL;
        size = cases[i].ranks;
        assert_int_equal(read_line(cases[i].line, &request, told, sizeof told), WEFT_OK);
        assert_int_equal(
            divide(&request, cases[i].size, cases[i].granularity, cases[i].least, &regions),
            WEFT_OK);
        assert_int_equal(weft_regions_count(regions), cases[i].count);
        const struct weft_rectangle first = weft_regions_get(regions, 0),
                                    last = weft_regions_get(regions, cases[i].count - 1);
        assert_memory_equal(&first, &cases[i].first, sizeof first);
        assert_memory_equal(&last, &cases[i].last, sizeof last);
        weft_regions_destroy(&regions);
    }
    size = 1;
}

// The verb's number of regions a rank, or the one that is asked for; sides of `least` at least.
static void without_a_size_ranks_have_their_share(void **state)
{
    (void)state;
    static const struct {
        const char *line;
        int ranks, granularity, least;
        int64_t least_count, most_count;
    } cases[] = {
        {"", 1, 1, 1, 1, 1},
        {"", 2, 8, 1, 16, 24},
        {"--granularity 3", 7, 8, 1, 21, 32},
        {"", 64, 8, 64, 1, 64}, // no side below 64 of 512 pixels
    };
    static const int picture[2] = {512, 512};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct rank_request request;
        char told[512];
        weft_regions *regions = NULL;
        size = cases[i].ranks;
        assert_int_equal(read_line(cases[i].line, &request, told, sizeof told), WEFT_OK);
        assert_int_equal(divide(&request, picture, cases[i].granularity, cases[i].least, &regions),
                         WEFT_OK);
        const int64_t count = weft_regions_count(regions);
        assert_in_range(count, cases[i].least_count, cases[i].most_count);
        for (int64_t r = 0; r < count; r++) {
            const struct weft_rectangle region = weft_regions_get(regions, r);
            assert_true(region.width >= cases[i].least && region.height >= cases[i].least);
        }
        weft_regions_destroy(&regions);
    }
    size = 1;
}

static void too_many_regions_are_refused_in_a_line(void **state)
{
    (void)state;
    static const int picture[2] = {4096, 4096};
    struct rank_request request;
    char told[1024];
    weft_regions *regions = NULL;
    assert_int_equal(read_line("--region 1", &request, told, sizeof told), WEFT_OK);
    const struct told file = told_begin();
    const enum weft_result res = divide(&request, picture, 8, 1, &regions);
    told_end(file, told, sizeof told);
    assert_int_equal(res, WEFT_ERR_LIMIT);
    assert_null(regions);
    assert_non_null(strstr(told, "4194304"));
    assert_non_null(strstr(told, "4096"));
    const char *end = strchr(told, '\n');
    assert_non_null(end);
    assert_string_equal(end, "\n");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(options_are_read),
        cmocka_unit_test(what_is_wrong_is_said),
        cmocka_unit_test(pictures_are_divided_as_asked_for),
        cmocka_unit_test(without_a_size_ranks_have_their_share),
        cmocka_unit_test(too_many_regions_are_refused_in_a_line),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
