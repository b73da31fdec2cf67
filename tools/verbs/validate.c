// SPDX-License-Identifier: BSD-3-Clause
// weft validate: whether a plan, or an order of taps, keeps its targets in their range.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/plan_json/plan_check.h"
#include "tools/plan_json/plan_claims.h"
#include "tools/plan_json/plan_json.h"
#include "tools/plan_json/plan_names.h"
#include "tools/methods/plan_options.h"
#include "tools/common/report.h"
#include "tools/verbs/verb.h"

enum {
    VALIDATE_ORDER = PLAN_PASSES + PASS_ORDER, // a list of taps here
    VALIDATE_WORST_CASE = PLAN_PASSES + PASS_WORST_CASE,
    VALIDATE_SPLIT = PLAN_COMMON_COUNT,
    VALIDATE_OPTION_COUNT
};

static const struct option_spec options[VALIDATE_OPTION_COUNT] = {
    PLAN_COMMON_OPTIONS,
    [PLAN_PASSES + PASS_TAPS_PER_PASS] = {.name = "taps-per-pass",
                                          't',
                                          OPTION_NUMBER,
                                          "N",
                                          "of the order, that one pass takes (default 1)",
                                          .group = OPTION_METHOD},
    [VALIDATE_ORDER] = {.name = "order",
                        0,
                        OPTION_TEXT,
                        "TAPS",
                        "instead of a plan: taps as 'x,y' or 'x,y,z', counted from 0, in the order "
                        "of their passes, between blanks or semicolons; + or - behind a tap means "
                        "its part of that sign, where it has both, /N the Nth piece of what was "
                        "split from it",
                        .group = OPTION_METHOD,
                        .brief = "of taps, instead of a plan"},
    [VALIDATE_SPLIT] = {.name = "split",
                        0,
                        OPTION_TEXT,
                        "TAP@T;...",
                        "with --order: the tap keeps weights from T on, the others become its next "
                        "piece",
                        .group = OPTION_METHOD},
};

// What is checked, and what came out.
struct verdict {
    const struct weft_pass_list *list;
    enum weft_worst_case worst_case;
    struct plan_fault fault;
    const struct weft_range *ranges; // of each pass; NULL after a fault
    struct weft_range_report report;
};

static bool is_valid(const struct verdict *v)
{
    return v->fault.kind == PLAN_FAULT_NONE && v->report.valid;
}

// ---- which range was left -----------------------------------------------------------------------

enum excursion { LEFT_TARGET, LEFT_INSIDE, LEFT_SUM };

static const char *const excursion_words[] = {"target", "inside", "sum"};

// The simulator tells how far something went; whether that was the target, its range tells.
static enum excursion excursion_of(const struct verdict *v)
{
    const struct weft_range *range = &v->ranges[v->report.pass];
    const double value = v->report.value;
    if (value == range->minimum || value == range->maximum)
        return LEFT_TARGET;
    return !v->list->exact_inside && value > v->list->range ? LEFT_INSIDE : LEFT_SUM;
}

// In codes of the target.
static double excess_codes(const struct verdict *v)
{
    const double value = v->report.value;
    const double high = excursion_of(v) == LEFT_INSIDE ? v->list->range : 1.0;
    return weft_target_one(v->list->target) * (value < 0.0 ? value : value - high);
}

// ---- text ---------------------------------------------------------------------------------------

static const char *name_tile(const struct verdict *v, int tile, char text[WEFT_TILE_NAME_TEXT])
{
    const struct weft_tile_name name = weft_tile_name_of(v->list->tiles, tile, true);
    return weft_tile_name_format(&name, v->list->dims, text);
}

static void print_taps(const struct verdict *v, const struct weft_pass *pass)
{
    static const char *const parts[] = {"", ", high", ", low"};
    char text[WEFT_TILE_NAME_TEXT];
    const char *before = "taps ";
    for (int i = 0; i < pass->group_count; i++) {
        const struct weft_tap_group *group = &v->list->groups[pass->group_first + i];
        for (int c = 0; c < (v->list->dot4 ? 4 : 1); c++) {
            if (group->tile[c] < 0)
                continue;
            printf("%s%s", before, name_tile(v, group->tile[c], text));
            before = " ";
        }
    }
    printf("%s%s%s", *before == ' ' ? "" : "no taps", parts[pass->part],
           pass->subtract ? ", subtract" : "");
}

static void print_pass(const struct verdict *v, int number)
{
    const struct weft_pass *pass = &v->list->passes[number];
    printf("pass %02d (", number);
    if (pass->kind == WEFT_PASS_TAPS)
        print_taps(v, pass);
    else
        for (int i = 0; i < pass->input_count; i++)
            printf("%s%d", i ? ", " : "combine targets ", pass->input[i]);
    printf(")");
}

static void print_range_fault(const struct verdict *v)
{
    const struct weft_range_report *r = &v->report;
    static const char *const left[] = {" leaves [0, 1]", " leaves its range inside",
                                       " blends a sum outside [0, 1]"};
    printf("invalid: ");
    print_pass(v, r->pass);
    printf("%s: %.6g (%+.1f LSB) at sample position (%d, %d", left[excursion_of(v)], r->value,
           excess_codes(v), r->position[0], r->position[1]);
    if (v->list->dims == 3)
        printf(", %d", r->position[2]);
    puts(")");
}

static void print_tile_fault(const struct verdict *v)
{
    char text[WEFT_TILE_NAME_TEXT];
    const double times = v->fault.times;
    printf("invalid: tap %s ", name_tile(v, v->fault.tile, text));
    if (times == 0.0)
        puts("is missing");
    else if (fabs(times - 2.0) < 1e-6)
        puts("is there twice");
    else
        printf("counts %.6g times\n", times);
}

static void find_range(const struct verdict *v, double *low, double *high)
{
    *low = (double)INFINITY;
    *high = -(double)INFINITY;
    for (int i = 0; i < v->list->pass_count; i++) {
        *low = fmin(*low, v->ranges[i].minimum);
        *high = fmax(*high, v->ranges[i].maximum);
    }
}

static void print_text(const struct verdict *v)
{
    double low, high;
    if (v->fault.kind == PLAN_FAULT_TILE) {
        print_tile_fault(v);
    } else if (v->fault.kind == PLAN_FAULT_SCALE) {
        printf("invalid: the scale of the passes is %.10g, not result_scale %.10g\n",
               v->fault.times * v->list->result_scale, v->list->result_scale);
    } else if (v->fault.kind == PLAN_FAULT_BIAS) {
        printf("invalid: the bias of the passes is %.6g, not %.6g\n", v->fault.times,
               v->list->result_bias);
    } else if (!v->report.valid) {
        print_range_fault(v);
    } else {
        find_range(v, &low, &high);
        printf("valid: range [%.6g, %.6g] over %d pass%s\n", fabs(low) < 1e-12 ? 0.0 : low, high,
               v->list->pass_count, v->list->pass_count == 1 ? "" : "es");
    }
}

// ---- JSON ---------------------------------------------------------------------------------------

static json_t *tap_json(const struct verdict *v, int tile)
{
    char text[WEFT_TILE_NAME_TEXT];
    return json_text(name_tile(v, tile, text));
}

static json_t *pass_taps_json(const struct verdict *v, const struct weft_pass *pass)
{
    json_t *taps = json_array();
    for (int i = 0; i < pass->group_count; i++) {
        const struct weft_tap_group *group = &v->list->groups[pass->group_first + i];
        for (int c = 0; c < (v->list->dot4 ? 4 : 1); c++)
            if (group->tile[c] >= 0)
                json_array_append_new(taps, tap_json(v, group->tile[c]));
    }
    return taps;
}

static json_t *problem_json(const struct verdict *v)
{
    const struct weft_range_report *r = &v->report;
    if (v->fault.kind == PLAN_FAULT_TILE)
        return json_pack("{s:s,s:o,s:o}", "kind", "tap", "tap", tap_json(v, v->fault.tile), "times",
                         json_number(v->fault.times));
    if (v->fault.kind == PLAN_FAULT_BIAS)
        return json_pack("{s:s,s:o,s:o}", "kind", "bias", "bias", json_number(v->fault.times),
                         "expected", json_number(v->list->result_bias));
    if (v->fault.kind == PLAN_FAULT_SCALE)
        return json_pack("{s:s,s:o,s:o}", "kind", "scale", "scale",
                         json_number(v->fault.times * v->list->result_scale), "expected",
                         json_number(v->list->result_scale));
    if (r->valid)
        return json_null();
    return json_pack("{s:s,s:s,s:i,s:o,s:o,s:o,s:o}", "kind", "range", "range",
                     excursion_words[excursion_of(v)], "pass", r->pass, "taps",
                     pass_taps_json(v, &v->list->passes[r->pass]), "position",
                     plan_integers_json(r->position, v->list->dims), "value", json_number(r->value),
                     "lsb", json_number(excess_codes(v)));
}

static enum weft_result print_json(const struct verdict *v)
{
    json_t *ranges = json_array();
    for (int i = 0; v->ranges && i < v->list->pass_count; i++)
        json_array_append_new(ranges, plan_range_json(&v->ranges[i], v->list->dims));
    return json_print(json_pack("{s:b,s:s,s:i,s:o,s:o,s:o}", "valid", is_valid(v), "worst_case",
                                weft_worst_case_names[v->worst_case], "pass_count",
                                v->list->pass_count, "overflow", json_number(v->report.overflow),
                                "problem", problem_json(v), "ranges", ranges));
}

// ---- a plan, an order ---------------------------------------------------------------------------

static enum weft_result answer(const struct verdict *v, const struct option_value *o, bool *valid)
{
    *valid = is_valid(v);
    if (o[PLAN_JSON].given)
        return print_json(v);
    print_text(v);
    return WEFT_OK;
}

// What a plan's numbers get the library to refuse is wrong with the file.
static enum weft_result simulate(struct verdict *v, struct weft_range *ranges)
{
    const enum weft_result res = weft_range_simulate(
        report_log(), v->list, v->worst_case, report_progress("simulating"), ranges, &v->report);
    v->ranges = ranges;
    return res == WEFT_ERR_ARGUMENT ? WEFT_ERR_FORMAT : res;
}

static enum weft_result validate_file(const char *path, const struct option_value *o, bool *valid)
{
    struct plan_file file;
    weft_pass_plan *plan = NULL;
    struct weft_range *ranges = NULL;
    enum weft_result res = plan_file_load(path, (uint64_t)o[PLAN_MEMORY].integer[0], &file);
    if (res != WEFT_OK)
        return res;
    struct verdict v = {.list = &file.list, .worst_case = file.worst_case};
    res = plan_claims_judge(path, &file, report_progress("judging"), &v.fault, &plan);
    if (o[VALIDATE_WORST_CASE].given)
        v.worst_case = (enum weft_worst_case)o[VALIDATE_WORST_CASE].integer[0];
    if (res == WEFT_OK && v.fault.kind == PLAN_FAULT_NONE) {
        ranges = calloc((size_t)v.list->pass_count, sizeof *ranges);
        res = ranges ? simulate(&v, ranges) : WEFT_ERR_MEMORY;
    }
    if (res == WEFT_OK)
        res = answer(&v, o, valid);
    free(ranges);
    weft_pass_plan_destroy(&plan);
    plan_file_clear(&file);
    return res;
}

static enum weft_result answer_plan(const weft_pass_plan *plan, const struct option_value *o,
                                    bool *valid)
{
    const struct weft_pass_plan_info *info = weft_pass_plan_get_info(plan);
    struct verdict v = {.list = info->passes,
                        .worst_case = info->worst_case,
                        .ranges = info->ranges,
                        .report = info->range};
    return answer(&v, o, valid);
}

static enum weft_result validate_order(const struct option_value *o, bool *valid)
{
    struct weft_pass_plan_params *params =
        weft_pass_plan_params(.progress = report_progress("simulating"));
    weft_kernel_file *file = NULL;
    weft_pass_plan *plan = NULL;
    struct weft_tile_name *names = NULL;
    struct weft_pass_plan_split *splits = NULL;
    enum weft_result res = plan_options_read(o, params, &file);
    params->order = WEFT_ORDER_GIVEN;
    params->taps_per_pass = params->taps_per_pass ? params->taps_per_pass : 1;
    if (res == WEFT_OK)
        res = plan_names_parse(o[VALIDATE_ORDER].text, params->dims, &names,
                               &params->tile_order_count);
    if (res == WEFT_OK && o[VALIDATE_SPLIT].given)
        res =
            plan_splits_parse(o[VALIDATE_SPLIT].text, params->dims, &splits, &params->split_count);
    params->tile_order = names;
    params->splits = splits;
    if (res == WEFT_OK)
        res = weft_pass_plan_create(params, &plan);
    if (res == WEFT_OK)
        res = answer_plan(plan, o, valid);
    weft_pass_plan_destroy(&plan);
    weft_kernel_file_destroy(&file);
    free(names);
    free(splits);
    return res;
}

// ---- the verb -----------------------------------------------------------------------------------

// What contradicts itself; false after an error line.
static bool check_options(const char *operand, const struct option_value *o)
{
    const bool order = o[VALIDATE_ORDER].given;
    if (operand && order) {
        report_error("a plan and --order exclude each other");
    } else if (!operand && !order) {
        report_error("nothing to validate: weft validate PLAN.json, or --order TAPS (see weft help "
                     "validate)");
    } else if (!order && o[VALIDATE_SPLIT].given) {
        report_error("--split needs --order");
    } else {
        for (int i = 0; !order && i < PLAN_MEMORY; i++) {
            if (o[i].given && i != VALIDATE_WORST_CASE) {
                report_error("--%s goes with --order; %s says it itself", options[i].name, operand);
                return false;
            }
        }
        return true;
    }
    return false;
}

static int run(const char *const *operands, const struct option_value *values)
{
    const char *operand = operands[0];
    report_set_level(values[PLAN_QUIET].given, values[PLAN_VERBOSE].given);
    if (pass_options_help(&values[PLAN_KERNEL], &values[PLAN_PASSES]))
        return report_finish(WEFT_OK);
    if (!check_options(operand, values))
        return EXIT_CODE_USAGE;
    bool valid = false;
    const enum weft_result res =
        operand ? validate_file(operand, values, &valid) : validate_order(values, &valid);
    const int code = report_finish(res);
    return code == EXIT_CODE_DONE && !valid ? EXIT_CODE_FAILED : code;
}

static const char *const epilogue[] = {
    "It answers with one line, 'valid: ...' or 'invalid: ...', and with exit code 0 or 1. "
    "Positions "
    "are samples of a tile, from 0 to resolution - 1 along each axis; an LSB is one code of the "
    "target. Of a plan it also finds the first tap that is missing, is there twice or has the "
    "wrong factor, and refuses it (exit code 3) where an error, a range, a count or a cost that it "
    "claims is not what its passes give. Plans that are read name kernels of the catalogue only.",
    NULL,
};

static const char *const examples[] = {
    "weft plan --profile unorm8 --json | weft validate - --worst-case any",
    "weft validate --kernel linear --order '0,0 1,0 0,1 1,1'",
    NULL,
};

const struct verb verb_validate = {
    .name = "validate",
    .group = VERB_METHODS,
    .summary = "whether a plan or an order of taps keeps its range",
    .usage = "PLAN.json | - | --order TAPS [options]",
    .description = "Simulates the passes of a plan (JSON, as weft plan --json prints it; - is "
                   "standard input), or of an order of taps of your own, on the worst input, and "
                   "names the first pass, sample position and value that leaves the range.",
    .examples = examples,
    .epilogue = epilogue,
    .options = options,
    .option_count = VALIDATE_OPTION_COUNT,
    .operand_names = OPTION_NAMES_FILE,
    .run = run,
};
