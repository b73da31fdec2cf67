// SPDX-License-Identifier: BSD-3-Clause
// What is told of the load of ranks: the figures of hand-made loads, as JSON, text and chart.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "tests/support/json.h"
#include "tests/tools/ranks/told.h"
#include "tools/draw/plot.h"
#include "tools/ranks/load_report.h"

// Rank i of `ranks` is busy 8 - i mod 4 of 10 s; rank 0 takes results for 1 s.
static struct weft_items_report make_report(int ranks, int64_t items)
{
    struct weft_items_report report = {
        .schedule = WEFT_SCHEDULE_PULL, .count = items, .failed_rank = -1};
    assert_int_equal(weft_load_create(ranks, &report.load), WEFT_OK);
    report.item_seconds = calloc((size_t)items, sizeof *report.item_seconds);
    report.item_rank = calloc((size_t)items, sizeof *report.item_rank);
    assert_true(report.item_seconds && report.item_rank);
    report.load.seconds = 10.0;
    for (int64_t i = 0; i < items; i++) {
        report.item_rank[i] = (int)(i % ranks);
        report.item_seconds[i] = 0.25 * (double)(i % 3);
        report.load.rank[i % ranks].items++;
    }
    for (int i = 0; i < ranks; i++) {
        struct weft_rank_load *rank = &report.load.rank[i];
        rank->busy = 8.0 - i % 4;
        rank->taking = i ? 0.0 : 1.0;
        rank->bytes = i ? (uint64_t)1000 * (uint64_t)i : 0;
        rank->threads = i % 2 + 1;
        snprintf(rank->host, sizeof rank->host, "node%d", i / 32);
    }
    return report;
}

static void clear(struct weft_items_report *report)
{
    free(report->item_seconds);
    free(report->item_rank);
    weft_load_clear(&report->load);
}

static const char *text_of(const json_t *object, const char *key)
{
    const char *text = json_string_value(json_object_get(object, key));
    assert_non_null(text);
    return text;
}

static void json_holds_every_rank(void **state)
{
    (void)state;
    struct weft_items_report report = make_report(4, 10);
    json_t *root = load_report_json(&report, false);
    assert_non_null(root);
    assert_true(number(root, "count") == 4.0);
    assert_string_equal(text_of(root, "schedule"), "pull");
    assert_true(number(root, "items") == 10.0);
    assert_true(number(json_object_get(root, "seconds"), "total") == 10.0);
    // Busy 8, 7, 6 and 5 of 10 s: 1 - 26 / 40; 8 / 6.5.
    assert_float_equal(number(root, "idle_share"), 0.35, 1e-15);
    assert_float_equal(number(root, "imbalance"), 8.0 / 6.5, 1e-15);
    assert_null(json_object_get(root, "item_seconds"));
    const json_t *each = json_object_get(root, "each");
    assert_int_equal(json_array_size(each), 4);
    for (size_t i = 0; i < 4; i++) {
        const json_t *rank = json_array_get(each, i);
        const double busy = 8.0 - (double)i, taking = i ? 0.0 : 1.0;
        assert_true(number(rank, "rank") == (double)i);
        assert_string_equal(text_of(rank, "host"), "node0");
        assert_true(number(rank, "threads") == (double)(i % 2 + 1));
        assert_true(number(rank, "busy") == busy);
        assert_true(number(rank, "taking") == taking);
        assert_true(number(rank, "idle") == 10.0 - busy - taking);
        assert_true(number(rank, "items") == (i < 2 ? 3.0 : 2.0));
        assert_true(number(json_object_get(rank, "bytes"), "sent") == 1000.0 * (double)i);
    }
    json_decref(root);
    clear(&report);
}

static void json_holds_every_item_where_asked_for(void **state)
{
    (void)state;
    struct weft_items_report report = make_report(3, 7);
    json_t *root = load_report_json(&report, true);
    const json_t *seconds = json_object_get(root, "item_seconds"),
                 *rank = json_object_get(root, "item_rank");
    assert_int_equal(json_array_size(seconds), 7);
    assert_int_equal(json_array_size(rank), 7);
    for (size_t i = 0; i < 7; i++) {
        assert_true(json_number_value(json_array_get(seconds, i)) == 0.25 * (double)(i % 3));
        assert_int_equal(json_integer_value(json_array_get(rank, i)), i % 3);
    }
    json_decref(root);
    clear(&report);
}

static void what_was_not_divided_has_no_load(void **state)
{
    (void)state;
    const struct weft_items_report none = {0};
    char told[64];
    assert_null(load_report_json(&none, true));
    report_set_level(false, true);
    const struct told file = told_begin();
    load_report_print(&none);
    told_end(file, told, sizeof told);
    assert_string_equal(told, "");
}

// Several ranks are a line; one is none, but with -v; then each has one of its own.
static void text_tells_of_several_ranks(void **state)
{
    (void)state;
    static const struct {
        int ranks;
        bool quiet, verbose;
        int lines;
        const char *said;
    } cases[] = {
        {4, false, false, 1, "4 ranks of 1 to 2 threads, pull: 10 items in 10 s, idle 35.0 %"},
        {2, true, false, 0, NULL},
        {1, false, false, 0, NULL},
        {1, false, true, 2, "1 rank of 1 thread, pull: 10 items in 10 s, idle 20.0 %"},
        {3, false, true, 4, "rank 2 (node0): 3 items, busy 6 s, taking 0 s, idle 4 s, 2000 bytes"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct weft_items_report report = make_report(cases[i].ranks, 10);
        char told[2048];
        report_set_level(cases[i].quiet, cases[i].verbose);
        const struct told file = told_begin();
        load_report_print(&report);
        told_end(file, told, sizeof told);
        int lines = 0;
        for (const char *c = told; *c; c++)
            lines += *c == '\n';
        if (lines != cases[i].lines || (cases[i].said && !strstr(told, cases[i].said)))
            fail_msg("%d lines instead of %d, or no '%s' in: %s", lines, cases[i].lines,
                     cases[i].said, told);
        clear(&report);
    }
    report_set_level(false, false);
}

// ---- chart --------------------------------------------------------------------------------------

static char *read_text(const char *path)
{
    FILE *file = fopen(path, "rb");
    char *text = calloc(1, 1 << 21);
    assert_true(file && text);
    assert_true(fread(text, 1, (1 << 21) - 1, file) > 0);
    fclose(file);
    return text;
}

// What a chart says is there, for one rank and for many; so is a bar of three parts for each.
static void charts_have_a_bar_for_each_rank(void **state)
{
    (void)state;
    static const struct {
        int ranks;
        const char *said[5], *not_said;
    } cases[] = {
        {1,
         {"1 rank of 1 thread, pull: 2000 items in 10 s", "idle 20.0 %", "all on node0"},
         "> 1<"},
        {2, {"2 ranks of 1 to 2 threads", "idle 25.0 %", "all on node0", "> 1<"}, "> 2<"},
        {64, {"64 ranks", "idle 35.0 %", "on 2 nodes", "> 60<", "mean 1.23"}, "> 64<"},
        {1000, {"1000 ranks", "on 32 nodes", "> 950<"}, "> 975<"},
    };
    if (!plot_can_draw())
        skip();
    const char *path = WEFT_BINARY_DIR "/load-chart.svg";
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct weft_items_report report = make_report(cases[i].ranks, 2000);
        assert_int_equal(load_report_plot(&report, path), WEFT_OK);
        char *text = read_text(path);
        for (int s = 0; s < 5 && cases[i].said[s]; s++)
            if (!strstr(text, cases[i].said[s]))
                fail_msg("%d ranks: no '%s'", cases[i].ranks, cases[i].said[s]);
        assert_null(strstr(text, cases[i].not_said));
        int bars = 0;
        for (const char *at = text; (at = strstr(at, "<polygon fill ")); at++)
            bars++;
        assert_in_range(bars, 3 * cases[i].ranks, 3 * cases[i].ranks + 8); // and the key's
        free(text);
        clear(&report);
        assert_int_equal(unlink(path), 0);
    }
}

static void a_chart_that_cannot_be_is_refused(void **state)
{
    (void)state;
    static const struct {
        const char *path;
        enum weft_result result;
    } cases[] = {
        {"load.txt", WEFT_ERR_ARGUMENT},
        {"/nowhere/load.svg", WEFT_ERR_WRITE},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char told[512];
        const struct told file = told_begin();
        const enum weft_result res = load_report_check_plot(cases[i].path);
        told_end(file, told, sizeof told);
        assert_int_equal(res, cases[i].result);
        assert_non_null(strstr(told, cases[i].path));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(json_holds_every_rank),
        cmocka_unit_test(json_holds_every_item_where_asked_for),
        cmocka_unit_test(what_was_not_divided_has_no_load),
        cmocka_unit_test(text_tells_of_several_ranks),
        cmocka_unit_test(charts_have_a_bar_for_each_rank),
        cmocka_unit_test(a_chart_that_cannot_be_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
