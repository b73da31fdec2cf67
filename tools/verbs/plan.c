// SPDX-License-Identifier: BSD-3-Clause
// weft plan: which passes reconstruct with a kernel on a target of limited precision, at what cost
// and with what error.
#include <stdio.h>
#include <string.h>

#include "tools/plan_json/plan_json.h"
#include "tools/methods/plan_options.h"
#include "tools/common/report.h"
#include "tools/verbs/verb.h"

enum { PLAN_NO_SPLITS = PLAN_COMMON_COUNT, PLAN_OPTION_COUNT };

static const struct option_spec options[PLAN_OPTION_COUNT] = {
    PLAN_COMMON_OPTIONS,
    [PLAN_PASSES + PASS_ORDER] = PASS_SPEC_ORDER(
        "of the passes. planned: searched for, so that no store clamps (default); greedy: the "
        "first tap that fits comes next, the baseline; natural: tap by tap, as naive code has "
        "it. The last two may clamp, and the plan says so"),
    [PLAN_NO_SPLITS] = {.name = "no-splits",
                        0,
                        OPTION_FLAG,
                        NULL,
                        "do not split tiles where no order is found without",
                        .group = OPTION_METHOD},
};

static enum weft_result print_plan(const weft_pass_plan *plan, bool json)
{
    if (json)
        return json_print(plan_json(plan));
    const char *text = weft_pass_plan_get_info(plan)->text;
    fputs(text, stdout);
    if (*text && text[strlen(text) - 1] != '\n')
        puts("");
    return WEFT_OK;
}

static int run(const char *const *operands, const struct option_value *values)
{
    const char *operand = operands[0];
    report_set_level(values[PLAN_QUIET].given, values[PLAN_VERBOSE].given);
    if (pass_options_help(&values[PLAN_KERNEL], &values[PLAN_PASSES]))
        return report_finish(WEFT_OK);
    if (operand) {
        report_error("'%s' is too much: weft plan takes options only (see weft help plan)",
                     operand);
        return EXIT_CODE_USAGE;
    }
    weft_kernel_file *file = NULL;
    weft_pass_plan *plan = NULL;
    struct weft_pass_plan_params *params =
        weft_pass_plan_params(.progress = report_progress("planning"),
                              .no_splits = values[PLAN_NO_SPLITS].given);
    enum weft_result res = plan_options_read(values, params, &file);
    if (res == WEFT_OK)
        res = weft_pass_plan_create(params, &plan);
    if (res == WEFT_OK)
        res = print_plan(plan, values[PLAN_JSON].given);
    weft_pass_plan_destroy(&plan);
    weft_kernel_file_destroy(&file);
    return report_finish(res);
}

static const char *const epilogue[] = {
    "Taps are counted from 0, (x,y) or (x,y,z), with + or - where a tap's weights of both signs "
    "are tiles of their own. Errors are bounds of |result - exact| for a source in [0, 1].",
    NULL,
};

static const char *const examples[] = {
    "weft plan --profile geforce3 --dims 2 --technique dot4",
    "weft plan --profile radeon8500,taps=2 --worst-case any --json >plan.json; weft validate "
    "plan.json",
    NULL,
};

const struct verb verb_plan = {
    .name = "plan",
    .group = VERB_METHODS,
    .summary = "the passes that reconstruct with a kernel, their cost and error",
    .usage = "[--kernel NAME] [--dims D] [--profile P] [--json] [options]",
    .description = "Plans the rendering passes that reconstruct with a kernel on a target of "
                   "limited precision, in an order in which no store clamps (roundings "
                   "included; with --no-scale they can, and it says by how much), and prints "
                   "them with ranges, memory, fetches and error bounds. Needs no file and no GL.",
    .examples = examples,
    .epilogue = epilogue,
    .options = options,
    .option_count = PLAN_OPTION_COUNT,
    .run = run,
};
