// SPDX-License-Identifier: BSD-3-Clause
#include "tools/methods/plan_options.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tools/common/cells.h"
#include "tools/common/kernels.h"
#include "tools/common/report.h"

const char *const plan_dims_choices[] = {"2", "3", NULL};
const char *const plan_derivative_choices[] = {"x", "y", "z", NULL};
const char *const plan_channels_choices[] = {"1", "4", NULL};

// ---- help ---------------------------------------------------------------------------------------

enum { PROFILE_COLUMNS = 8 };

static bool set_profile(struct cells *cells, int row, const struct weft_profile *p)
{
    int c = 0;
    return cells_set(cells, row, c++, "%s", p->name) &&
           cells_set(cells, row, c++, "%s", weft_target_name(p->target)) &&
           cells_set(cells, row, c++, "%d", p->internal_bits) &&
           cells_set(cells, row, c++, "%g", p->internal_range) &&
           cells_set(cells, row, c++, "%d", p->taps_per_pass) &&
           cells_set(cells, row, c++, "%d", p->dot_width) &&
           cells_set(cells, row, c++, "%d", p->max_scale) &&
           cells_set(cells, row, c++, "%s", p->ping_pong ? "yes" : "no");
}

static void print_profile_table(int count)
{
    static const char *const head[PROFILE_COLUMNS] = {
        "profile", "target", "internal-bits", "range", "taps", "dot", "max-scale", "ping-pong"};
    struct cells cells;
    bool good = cells_create(&cells, count + 1, PROFILE_COLUMNS);
    cells.text_columns = 2;
    for (int c = 0; c < PROFILE_COLUMNS && good; c++)
        good = cells_set(&cells, 0, c, "%s", head[c]);
    for (int i = 0; i < count && good; i++)
        good = set_profile(&cells, i + 1, weft_profile_list[i]);
    if (good)
        cells_print(&cells, CELLS_TEXT, stdout);
    cells_destroy(&cells);
}

static void print_profiles(void)
{
    int count = 0;
    while (weft_profile_list[count])
        count++;
    print_profile_table(count);
    puts("");
    for (int i = 0; i < count; i++)
        printf("%-10s  %s\n", weft_profile_list[i]->name, weft_profile_list[i]->description);
    puts("");
    options_print_wrapped(
        "The columns are the keys of key=value: target (unorm8, unorm16, half, float); "
        "internal-bits, fraction bits of products and sums inside a pass (0: exact, rounded once); "
        "range, at which sums inside saturate (inf: never); taps, pairs of a source and a tile "
        "texture in a pass; dot, components of a dot product (1, 3 or 4); max-scale, the largest "
        "power of two that a result can be multiplied by (0: any factor); ping-pong, whether a "
        "pass can read what the one before wrote, or else only blends (yes, no).",
        0);
}

static bool asks_for_list(const struct option_value *value)
{
    return value->given && strcmp(value->text, "help") == 0;
}

bool plan_options_help(const struct option_value *options)
{
    if (asks_for_list(&options[PLAN_KERNEL]))
        kernels_print();
    else if (asks_for_list(&options[PLAN_PROFILE]))
        print_profiles();
    else
        return false;
    return true;
}

// ---- parameters ---------------------------------------------------------------------------------

static enum weft_result read_whole(const struct option_value *value, const char *name, int low,
                                   int high, int *out)
{
    if (!value->given)
        return WEFT_OK;
    const double number = value->number[0];
    if (number >= low && number <= high && number == floor(number)) {
        *out = (int)number;
        return WEFT_OK;
    }
    report_error("--%s %s: not a whole number from %d to %d", name, value->text, low, high);
    return WEFT_ERR_ARGUMENT;
}

static enum weft_result read_numbers(const struct option_value *o, struct weft_pass_plan_params *p)
{
    enum weft_result res = read_whole(&o[PLAN_TAPS_PER_PASS], "taps-per-pass", 1,
                                      WEFT_PASS_MAX_GROUPS, &p->taps_per_pass);
    if (res == WEFT_OK)
        res = read_whole(&o[PLAN_BITS], "bits", 4, 16, &p->bits);
    if (res == WEFT_OK)
        res = read_whole(&o[PLAN_RESOLUTION], "resolution", 1, WEFT_TILES_MAX_SAMPLES, &p->samples);
    return res;
}

enum weft_result plan_options_read(const struct option_value *o, struct weft_pass_plan_params *p,
                                   weft_kernel_file **file)
{
    p->dims = o[PLAN_DIMS].given ? (int)o[PLAN_DIMS].integer[0] + 2 : 2;
    p->derivative = o[PLAN_DERIVATIVE].given ? (int)o[PLAN_DERIVATIVE].integer[0] + 1 : 0;
    p->technique = (enum weft_technique)o[PLAN_TECHNIQUE].integer[0];
    p->worst_case = (enum weft_worst_case)o[PLAN_WORST_CASE].integer[0];
    p->round_singly = o[PLAN_ROUND_SINGLY].given;
    p->single_bias = o[PLAN_SINGLE_BIAS].given;
    p->no_scale = o[PLAN_NO_SCALE].given;
    p->blend_only = o[PLAN_BLEND_ONLY].given;
    p->channels = o[PLAN_CHANNELS].integer[0] ? 4 : 1;
    p->memory_bytes = (uint64_t)o[PLAN_MEMORY].integer[0];
    p->log = report_log();
    enum weft_result res = read_numbers(o, p);
    if (res == WEFT_OK && p->derivative > p->dims) {
        report_error("--derivative z needs --dims 3");
        return WEFT_ERR_ARGUMENT;
    }
    if (res == WEFT_OK && o[PLAN_PROFILE].given)
        res = weft_profile_parse(report_log(), o[PLAN_PROFILE].text, &p->profile);
    if (res == WEFT_OK && o[PLAN_KERNEL].given)
        res = kernels_load(o[PLAN_KERNEL].text, &p->kernel, file);
    return res;
}
