// SPDX-License-Identifier: BSD-3-Clause
#include "tools/methods/pass_options.h"

#include <stdio.h>
#include <string.h>

#include "tools/common/cells.h"
#include "tools/options/kernels.h"
#include "tools/common/report.h"
#include "tools/common/run_report.h"

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

bool pass_options_help(const struct option_value *kernel, const struct option_value *first)
{
    if (options_ask_for_help(kernel))
        kernels_print();
    else if (options_ask_for_help(&first[PASS_PROFILE]))
        print_profiles();
    else
        return false;
    return true;
}

// ---- parameters ---------------------------------------------------------------------------------

static enum weft_result read_numbers(const struct option_value *o, struct weft_pass_plan_params *p)
{
    enum weft_result res = options_read_whole(&o[PASS_TAPS_PER_PASS], "taps-per-pass", 1,
                                              WEFT_PASS_MAX_GROUPS, &p->taps_per_pass);
    if (res == WEFT_OK)
        res = options_read_whole(&o[PASS_BITS], "bits", 4, 16, &p->bits);
    if (res == WEFT_OK)
        res = options_read_whole(&o[PASS_RESOLUTION], "resolution", 1, WEFT_TILES_MAX_SAMPLES,
                                 &p->samples);
    return res;
}

enum weft_result pass_options_read(const struct option_value *first, const char *default_profile,
                                   struct weft_pass_plan_params *p)
{
    const struct option_value *profile = &first[PASS_PROFILE];
    const char *text = profile->given ? profile->text : default_profile;
    p->technique = (enum weft_technique)first[PASS_TECHNIQUE].integer[0];
    p->worst_case = (enum weft_worst_case)first[PASS_WORST_CASE].integer[0];
    p->order = (enum weft_order)first[PASS_ORDER].integer[0];
    p->log = report_log();
    const enum weft_result res = read_numbers(first, p);
    return res == WEFT_OK && text ? weft_profile_parse(p->log, text, &p->profile) : res;
}

enum weft_result pass_options_check(const struct option_value *first)
{
    const struct option_value *range = &first[PASS_SOURCE_RANGE];
    if (range->given && !(range->number[0] < range->number[1])) {
        report_error("--source-range %s: LO must be less than HI", range->text);
        return WEFT_ERR_ARGUMENT;
    }
    return pass_options_read(first, NULL, weft_pass_plan_params());
}

enum weft_result pass_plan_params(const struct option_value *first, const char *default_profile,
                                  const struct weft_kernel *kernel, int dims, int channels,
                                  struct weft_pass_plan_params *params)
{
    const enum weft_result res = pass_options_read(first, default_profile, params);
    params->kernel = *kernel;
    params->dims = dims;
    params->channels = channels;
    params->progress = report_progress("planning passes");
    return res;
}

enum weft_result pass_plan_create(const struct option_value *first, const char *default_profile,
                                  const struct weft_kernel *kernel, int dims, int channels,
                                  weft_pass_plan **out)
{
    struct weft_pass_plan_params *params = weft_pass_plan_params();
    enum weft_result res = pass_plan_params(first, default_profile, kernel, dims, channels, params);
    return res == WEFT_OK ? weft_pass_plan_create(params, out) : res;
}

// ---- bounds -------------------------------------------------------------------------------------

json_t *pass_bound_json(const struct weft_bound *b)
{
    return json_pack("{s:o,s:o,s:o,s:o,s:o,s:o,s:o}", "source", json_number(b->source), "e2",
                     json_number(b->e2), "e3", json_number(b->e3), "clamp", json_number(b->clamp),
                     "rounding", json_number(b->rounding), "prefilter", json_number(b->prefilter),
                     "total", json_number(b->total));
}

const char *pass_bound_format(const struct weft_bound *b, char text[PASS_TEXT])
{
    int used = snprintf(text, PASS_TEXT, "%.3g (source %.3g, E2 %.3g, E3 %.3g", b->total, b->source,
                        b->e2, b->e3);
    if (b->clamp > 1e-9 * b->total) // not what rounding leaves
        used += snprintf(text + used, PASS_TEXT - (size_t)used, ", clamping %.3g", b->clamp);
    if (b->prefilter > 0.0)
        used += snprintf(text + used, PASS_TEXT - (size_t)used, ", prefilter %.3g", b->prefilter);
    snprintf(text + used, PASS_TEXT - (size_t)used, ")");
    return text;
}

// ---- plans --------------------------------------------------------------------------------------

json_t *pass_plan_json(const weft_pass_plan *plan)
{
    const struct weft_pass_plan_info *info = weft_pass_plan_get_info(plan);
    const struct weft_pass_plan_error *e = &info->error;
    json_t *bound =
        json_pack("{s:o,s:o,s:o,s:o,s:o,s:o}", "source", json_number(e->source), "e2",
                  json_number(e->e2), "e3", json_number(e->e3), "clamp", json_number(e->clamp),
                  "total", json_number(e->bound), "any", json_number(e->bound_any));
    return json_pack(
        "{s:o,s:s,s:s,s:s,s:i,s:i,s:i,s:i,s:i,s:i,s:i,s:b,s:o,s:o,s:o,s:o,s:o}", "profile",
        json_text(info->profile.name), "technique", weft_technique_names[info->technique],
        "worst_case", weft_worst_case_names[info->worst_case], "order",
        weft_order_names[info->order], "resolution", info->samples, "bits", info->bits, "channels",
        info->channels, "passes", info->passes->pass_count, "tiles", info->tile_count, "splits",
        info->split_count, "fetches", info->fetches, "valid", info->valid, "scale_bits",
        json_number(info->scale_bits), "bytes", run_report_bytes("tiles", info->tile_bytes),
        "bound_parts", bound, "search_seconds", json_number(info->search_seconds), "text",
        json_text(info->text));
}

const char *pass_plan_summary(const weft_pass_plan *plan, char text[PASS_TEXT])
{
    const struct weft_pass_plan_info *info = weft_pass_plan_get_info(plan);
    snprintf(text, PASS_TEXT, "%s order, %d passes, %d tiles of %d samples an axis, %d fetches",
             weft_order_names[info->order], info->passes->pass_count, info->tile_count,
             info->samples, info->fetches);
    return text;
}

void pass_plan_print(const weft_pass_plan *plan)
{
    const char *text = weft_pass_plan_get_info(plan)->text;
    const size_t size = strlen(text);
    printf("%s%s", text, size && text[size - 1] == '\n' ? "" : "\n");
}
