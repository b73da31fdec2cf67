// SPDX-License-Identifier: BSD-3-Clause
// tests/support/plan_runs.h - plans that run once, for tests that look at what comes out.
#ifndef WEFT_TESTS_SUPPORT_PLAN_RUNS_H
#define WEFT_TESTS_SUPPORT_PLAN_RUNS_H

#include "passes/verify/verify.h"

// Compiles a plan, for GL or for the CPU (NULL), runs it once and ends it.
static inline enum weft_result run_plan(weft_context *context, const weft_pass_plan *plan,
                                        const struct weft_multipass_run_params *params,
                                        struct weft_multipass_report *report)
{
    weft_multipass *compiled = NULL;
    enum weft_result res = weft_multipass_compile(
        context, weft_multipass_params(.plan = plan, .log = params->log), &compiled);
    if (res == WEFT_OK)
        res = weft_multipass_run(compiled, params, report);
    weft_multipass_destroy(&compiled);
    return res;
}

// What a run left, to be verified.
static inline struct weft_multipass_verify_params
verify_params(const weft_pass_plan *plan, const struct weft_multipass_run_params *run)
{
    return (struct weft_multipass_verify_params){
        .plan = plan,
        .samples = run->samples,
        .grid = run->grid,
        .pixels = {run->pixels[0], run->pixels[1], run->pixels[2], run->pixels[3]},
        .stride = run->stride,
        .how = {.progress = run->progress},
        .log = run->log,
    };
}

static inline enum weft_result verify_plan(const weft_pass_plan *plan,
                                           const struct weft_multipass_run_params *run,
                                           struct weft_verify_report *error)
{
    const struct weft_multipass_verify_params params = verify_params(plan, run);
    return weft_multipass_verify(&params, error);
}

#endif
