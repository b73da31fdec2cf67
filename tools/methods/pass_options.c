// SPDX-License-Identifier: BSD-3-Clause
#include "tools/methods/pass_options.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tools/common/report.h"

// ---- options ------------------------------------------------------------------------------------

// The same options as `weft plan` has them.
static void copy_options(const struct option_value *first,
                         struct option_value out[PLAN_COMMON_COUNT])
{
    memset(out, 0, PLAN_COMMON_COUNT * sizeof *out);
    out[PLAN_PROFILE] = first[RESAMPLE_PLAN_PROFILE];
    out[PLAN_TECHNIQUE] = first[RESAMPLE_PLAN_TECHNIQUE];
    out[PLAN_RESOLUTION] = first[RESAMPLE_PLAN_RESOLUTION];
    out[PLAN_BITS] = first[RESAMPLE_PLAN_BITS];
    out[PLAN_TAPS_PER_PASS] = first[RESAMPLE_PLAN_TAPS_PER_PASS];
    out[PLAN_WORST_CASE] = first[RESAMPLE_PLAN_WORST_CASE];
}

bool resample_plan_help(const struct option_value *kernel, const struct option_value *first)
{
    struct option_value options[PLAN_COMMON_COUNT];
    copy_options(first, options);
    if (kernel)
        options[PLAN_KERNEL] = *kernel;
    return plan_options_help(options);
}

enum weft_result resample_plan_check(const struct option_value *first)
{
    const struct option_value *range = &first[RESAMPLE_PLAN_SOURCE_RANGE];
    struct option_value options[PLAN_COMMON_COUNT];
    struct weft_pass_plan_params *params = weft_pass_plan_params();
    weft_kernel_file *file = NULL; // without --kernel there is none
    copy_options(first, options);
    if (range->given && !(range->number[0] < range->number[1])) {
        report_error("--source-range %s: LO must be less than HI", range->text);
        return WEFT_ERR_ARGUMENT;
    }
    return plan_options_read(options, params, &file);
}

enum weft_result resample_plan_params(const struct option_value *first, const char *default_profile,
                                      const struct weft_kernel *kernel, int dims, int channels,
                                      struct weft_pass_plan_params *params)
{
    struct option_value options[PLAN_COMMON_COUNT];
    weft_kernel_file *file = NULL;
    copy_options(first, options);
    if (!options[PLAN_PROFILE].given)
        options[PLAN_PROFILE] = (struct option_value){.given = true, .text = default_profile};
    enum weft_result res = plan_options_read(options, params, &file);
    params->kernel = *kernel;
    params->dims = dims;
    params->channels = channels;
    params->order = (enum weft_order)first[RESAMPLE_PLAN_ORDER].integer[0];
    params->progress = report_progress("planning passes");
    return res;
}

enum weft_result resample_plan_create(const struct option_value *first, const char *default_profile,
                                      const struct weft_kernel *kernel, int dims, int channels,
                                      weft_pass_plan **out)
{
    struct weft_pass_plan_params *params = weft_pass_plan_params();
    enum weft_result res =
        resample_plan_params(first, default_profile, kernel, dims, channels, params);
    return res == WEFT_OK ? weft_pass_plan_create(params, out) : res;
}

// ---- bounds -------------------------------------------------------------------------------------

json_t *resample_bound_json(const struct weft_bound *b)
{
    return json_pack("{s:o,s:o,s:o,s:o,s:o,s:o,s:o}", "source", json_number(b->source), "e2",
                     json_number(b->e2), "e3", json_number(b->e3), "clamp", json_number(b->clamp),
                     "rounding", json_number(b->rounding), "prefilter", json_number(b->prefilter),
                     "total", json_number(b->total));
}

const char *resample_bound_format(const struct weft_bound *b, char text[RESAMPLE_PLAN_TEXT])
{
    int used = snprintf(text, RESAMPLE_PLAN_TEXT, "%.3g (source %.3g, E2 %.3g, E3 %.3g", b->total,
                        b->source, b->e2, b->e3);
    if (b->clamp > 1e-9 * b->total) // not what rounding leaves
        used +=
            snprintf(text + used, RESAMPLE_PLAN_TEXT - (size_t)used, ", clamping %.3g", b->clamp);
    if (b->prefilter > 0.0)
        used += snprintf(text + used, RESAMPLE_PLAN_TEXT - (size_t)used, ", prefilter %.3g",
                         b->prefilter);
    snprintf(text + used, RESAMPLE_PLAN_TEXT - (size_t)used, ")");
    return text;
}

// ---- plans --------------------------------------------------------------------------------------

json_t *resample_plan_json(const weft_pass_plan *plan)
{
    const struct weft_pass_plan_info *info = weft_pass_plan_get_info(plan);
    const struct weft_pass_plan_error *e = &info->error;
    json_t *error =
        json_pack("{s:o,s:o,s:o,s:o,s:o,s:o}", "source", json_number(e->source), "e2",
                  json_number(e->e2), "e3", json_number(e->e3), "clamp", json_number(e->clamp),
                  "bound", json_number(e->bound), "bound_any", json_number(e->bound_any));
    return json_pack(
        "{s:o,s:s,s:s,s:s,s:i,s:i,s:i,s:i,s:i,s:i,s:i,s:b,s:o,s:o,s:o,s:o,s:o}", "profile",
        json_text(info->profile.name), "technique", weft_technique_names[info->technique],
        "worst_case", weft_worst_case_names[info->worst_case], "order",
        weft_order_names[info->order], "resolution", info->samples, "bits", info->bits, "channels",
        info->channels, "passes", info->passes->pass_count, "tiles", info->tile_count, "splits",
        info->split_count, "fetches", info->fetches, "valid", info->valid, "scale_bits",
        json_number(info->scale_bits), "tile_bytes", json_count(info->tile_bytes), "relative_error",
        error, "search_seconds", json_number(info->search_seconds), "text", json_text(info->text));
}

const char *resample_plan_summary(const weft_pass_plan *plan, char text[RESAMPLE_PLAN_TEXT])
{
    const struct weft_pass_plan_info *info = weft_pass_plan_get_info(plan);
    snprintf(text, RESAMPLE_PLAN_TEXT,
             "%s order, %d passes, %d tiles of %d samples an axis, %d fetches",
             weft_order_names[info->order], info->passes->pass_count, info->tile_count,
             info->samples, info->fetches);
    return text;
}

void resample_plan_print(const weft_pass_plan *plan)
{
    const char *text = weft_pass_plan_get_info(plan)->text;
    const size_t size = strlen(text);
    printf("%s%s", text, size && text[size - 1] == '\n' ? "" : "\n");
}
