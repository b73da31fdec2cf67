// SPDX-License-Identifier: BSD-3-Clause
// tests/support/plans.h - profiles and plans for tests, where failing to make them fails the test.
// Include after common.h.
#ifndef WEFT_TESTS_SUPPORT_PLANS_H
#define WEFT_TESTS_SUPPORT_PLANS_H

#include "passes/plan/plan.h"

static inline struct weft_profile profile_named(const char *text)
{
    struct weft_profile profile;
    assert_int_equal(weft_profile_parse(&log_to_stderr, text, &profile), WEFT_OK);
    return profile;
}

static inline weft_pass_plan *make_plan(const struct weft_pass_plan_params *params)
{
    weft_pass_plan *plan = NULL;
    struct weft_pass_plan_params p = *params;
    p.log = &log_to_stderr;
    if (weft_pass_plan_create(&p, &plan) != WEFT_OK)
        fail_msg("%s in %dD, profile %s, technique %s: no plan",
                 p.kernel.info ? p.kernel.info->name : "catmull-rom", p.dims, p.profile.name,
                 weft_technique_names[p.technique]);
    return plan;
}

#endif
