// SPDX-License-Identifier: BSD-3-Clause
// Names of tiles: what is written is read again, and every tile of a set is found by its name.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>
#include <math.h>

#include "filter/check.h"
#include "passes/plan/tile_name.h"

static void test_texts(void **state)
{
    (void)state;
    static const struct {
        const char *text, *shown;
        int dims;
        struct weft_tile_name name;
    } cases[] = {
        {"3", "(3)", 1, {{3, 0, 0}, WEFT_TILE_WHOLE, 0}},
        {"1,2", "(1,2)", 2, {{1, 2, 0}, WEFT_TILE_WHOLE, 0}},
        {"1,2-/1", "(1,2)-/1", 2, {{1, 2, 0}, WEFT_TILE_NEGATIVE, 1}},
        {"15,0,7+", "(15,0,7)+", 3, {{15, 0, 7}, WEFT_TILE_POSITIVE, 0}},
        {"0,0,99999/12", "(0,0,99999)/12", 3, {{0, 0, 99999}, WEFT_TILE_WHOLE, 12}},
    };
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        struct weft_tile_name name;
        char text[WEFT_TILE_NAME_TEXT], longer[64];
        snprintf(longer, sizeof longer, "%s;1", cases[i].text);
        const char *end = weft_tile_name_parse(longer, cases[i].dims, &name);
        assert_non_null(end);
        assert_string_equal(end, ";1");
        assert_memory_equal(name.tap, cases[i].name.tap, sizeof name.tap);
        assert_int_equal(name.part, cases[i].name.part);
        assert_int_equal(name.piece, cases[i].name.piece);
        assert_string_equal(weft_tile_name_format(&name, cases[i].dims, text), cases[i].shown);
    }
}

static void test_no_names(void **state)
{
    (void)state;
    static const char *const texts[] = {"",    "x",    "1",    "1,",    ",1",      "-1,0",
                                        "1;2", "1, 2", "1,2/", "1,2/x", "100000,0"};
    for (size_t i = 0; i < WEFT_COUNT(texts); i++) {
        struct weft_tile_name name;
        assert_null(weft_tile_name_parse(texts[i], 2, &name));
    }
}

// Split sets, and sets with taps of one sign and of both.
static void test_sets(void **state)
{
    (void)state;
    int brief = 0, pieces = 0, signs = 0;
    struct weft_kernel_tiles_params *p =
        weft_kernel_tiles_params(.dims = 2, .samples = 16, .signs = WEFT_TILE_SEPARATE);
    weft_kernel_tiles *tiles = NULL;
    assert_int_equal(weft_kernel_parse(NULL, "mitchell", &p->kernel), WEFT_OK);
    assert_int_equal(weft_kernel_tiles_create(p, &tiles), WEFT_OK);
    for (int i = 0; i < 3; i++)
        assert_int_equal(weft_kernel_tiles_split(tiles, i, (double)NAN), WEFT_OK);
    const int count = weft_kernel_tiles_get_info(tiles)->tile_count;
    for (int i = 0; i < count; i++) {
        const struct weft_tile_name full = weft_tile_name_of(tiles, i, false);
        const struct weft_tile_name shown = weft_tile_name_of(tiles, i, true);
        assert_int_equal(weft_tile_name_find(tiles, &full), i);
        assert_int_equal(weft_tile_name_find(tiles, &shown), i);
        brief += shown.part != full.part;
        signs += shown.part == WEFT_TILE_NEGATIVE;
        pieces += full.piece > 0;
    }
    assert_true(brief > 0 && signs > 0);
    assert_int_equal(pieces, 3);
    assert_int_equal(weft_tile_name_of(tiles, count, false).tap[0], -1);
    const struct weft_tile_name none = {{4, 0, 0}, WEFT_TILE_WHOLE, 0};
    assert_int_equal(weft_tile_name_find(tiles, &none), -1);
    weft_kernel_tiles_destroy(&tiles);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_texts),
        cmocka_unit_test(test_no_names),
        cmocka_unit_test(test_sets),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
