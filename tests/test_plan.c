// SPDX-License-Identifier: BSD-3-Clause
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "filter/check.h"
#include "weft.h"

static inline struct weft_profile profile_named(const char *text)
{
    struct weft_profile profile;
    assert_int_equal(weft_profile_parse(&log_to_stderr, text, &profile), WEFT_OK);
    return profile;
}

static weft_plan *make(const struct weft_plan_params *params)
{
    weft_plan *plan = NULL;
    struct weft_plan_params p = *params;
    p.log = &log_to_stderr;
    if (weft_plan_create(&p, &plan) != WEFT_OK)
        fail_msg("%s in %dD, profile %s, technique %s: no plan",
                 p.kernel.info ? p.kernel.info->name : "catmull-rom", p.dims, p.profile.name,
                 weft_technique_names[p.technique]);
    return plan;
}

static const struct weft_plan_info *info_of(const weft_plan *plan)
{
    return weft_plan_get_info(plan);
}

// ---- every tile once ----------------------------------------------------------------------------

static bool is_zero(const struct weft_kernel_tile *tile)
{
    return tile->minimum == 0.0 && tile->maximum == 0.0;
}

// The offsets of a group's components are those of its tiles' taps, and every tile that is not zero
// is in one group of all passes of a part.
static void check_cover(const weft_plan *plan)
{
    const struct weft_pass_list *list = info_of(plan)->passes;
    const int tiles = info_of(plan)->tile_count;
    int *seen = calloc((size_t)tiles, sizeof *seen);
    assert_non_null(seen);
    for (int n = 0; n < list->pass_count; n++) {
        const struct weft_pass *pass = &list->passes[n];
        if (pass->kind != WEFT_PASS_TAPS || pass->part == WEFT_PASS_LOW)
            continue;
        for (int g = 0; g < pass->group_count; g++) {
            const struct weft_tap_group *group = &list->groups[pass->group_first + g];
            for (int c = 0; c < 4; c++) {
                if (group->tile[c] < 0)
                    continue;
                seen[group->tile[c]]++;
                const int *tap = weft_kernel_tiles_get(list->tiles, group->tile[c])->tap;
                for (int a = 0; a < 3; a++)
                    assert_int_equal(group->offset[a] + list->pattern[c][a], tap[a]);
            }
        }
    }
    for (int i = 0; i < tiles; i++)
        assert_int_equal(seen[i], is_zero(weft_kernel_tiles_get(list->tiles, i)) ? 0 : 1);
    free(seen);
}

// ---- the catalogue ------------------------------------------------------------------------------

static void every_kernel_has_a_valid_plan(void **state)
{
    (void)state;
    print_message("%-22s dims  taps tiles splits passes  bits lost  verdict   search\n", "kernel");
    for (const struct weft_kernel_info *const *k = weft_kernel_list; *k; k++) {
        const struct weft_kernel kernel = kernel_named((*k)->name);
        for (int dims = 2; kernel.width <= 4 && dims <= 3; dims++) {
            weft_plan *plan = make(weft_plan_params(.kernel = kernel, .dims = dims,
                                                    .samples = dims > 2 ? 16 : 64,
                                                    .taps_per_pass = 1));
            const struct weft_plan_info *info = info_of(plan);
            print_message("%-22s %dD   %4d  %4d   %4d   %4d   %8.2f  %s  %7.3f s\n", (*k)->name,
                          dims, info->tap_count, info->tile_count, info->split_count,
                          info->passes->pass_count, info->scale_bits,
                          info->valid ? "valid  " : "INVALID", info->search_seconds);
            assert_true(info->valid);
            check_cover(plan);
            weft_plan_destroy(&plan);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_kernel_has_a_valid_plan),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
