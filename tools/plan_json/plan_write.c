// SPDX-License-Identifier: BSD-3-Clause
// Plans to JSON.
#include "tools/plan_json/plan_json.h"

#include <math.h>
#include <stdlib.h>

#include "tools/options/kernels.h"

json_t *plan_integers_json(const int *value, int count)
{
    json_t *array = json_array();
    for (int i = 0; i < count; i++)
        json_array_append_new(array, json_integer(value[i]));
    return array;
}

json_t *plan_range_json(const struct weft_range *range, int dims)
{
    return json_pack("{s:o,s:o,s:o,s:o}", "minimum", json_number(range->minimum), "maximum",
                     json_number(range->maximum), "minimum_at",
                     plan_integers_json(range->minimum_at, dims), "maximum_at",
                     plan_integers_json(range->maximum_at, dims));
}

static json_t *profile_json(const struct weft_profile *p)
{
    return json_pack("{s:o,s:o,s:s,s:i,s:o,s:i,s:i,s:i,s:b}", "name", json_text(p->name),
                     "description", json_text(p->description), "target",
                     weft_target_names[p->target], "internal_bits", p->internal_bits, "range",
                     json_number(p->internal_range), "taps", p->taps_per_pass, "dot", p->dot_width,
                     "max_scale", p->max_scale, "ping_pong", p->ping_pong);
}

static json_t *bound_json(const struct weft_pass_plan_error *e)
{
    return json_pack("{s:o,s:o,s:o,s:o,s:o,s:o}", "source", json_number(e->source), "e2",
                     json_number(e->e2), "e3", json_number(e->e3), "clamp", json_number(e->clamp),
                     "total", json_number(e->bound), "any", json_number(e->bound_any));
}

static json_t *report_json(const struct weft_pass_plan_info *info)
{
    const struct weft_range_report *r = &info->range;
    double low = (double)INFINITY, high = -(double)INFINITY;
    for (int i = 0; i < info->passes->pass_count; i++) {
        low = fmin(low, info->ranges[i].minimum);
        high = fmax(high, info->ranges[i].maximum);
    }
    json_t *first = r->valid ? json_null()
                             : json_pack("{s:i,s:o,s:o}", "pass", r->pass, "position",
                                         plan_integers_json(r->position, info->dims), "value",
                                         json_number(r->value));
    return json_pack("{s:o,s:o,s:o,s:o}", "minimum", json_number(low), "maximum", json_number(high),
                     "overflow", json_number(r->overflow), "first_outside", first);
}

// ---- tiles --------------------------------------------------------------------------------------

static json_t *name_json(const struct weft_tile_name *name, int dims)
{
    return json_pack("{s:o,s:s,s:i}", "tap", plan_integers_json(name->tap, dims), "part",
                     weft_tile_part_names[name->part], "piece", name->piece);
}

static json_t *splits_json(const struct weft_pass_plan_info *info)
{
    json_t *splits = json_array();
    for (int i = 0; i < info->tile_split_count; i++) {
        json_t *split = name_json(&info->tile_splits[i].tile, info->dims);
        json_object_set_new(split, "threshold", json_number(info->tile_splits[i].threshold));
        json_array_append_new(splits, split);
    }
    return splits;
}

static json_t *tile_name_json(const struct weft_pass_list *list, int tile)
{
    const struct weft_tile_name name = weft_tile_name_of(list->tiles, tile, false);
    return name_json(&name, list->dims);
}

static json_t *tiles_json(const struct weft_pass_plan_info *info)
{
    const struct weft_kernel_tiles_params *p = &info->tile_params;
    json_t *tiles = json_array();
    for (int i = 0; i < info->tile_count; i++) {
        const struct weft_kernel_tile *tile = weft_kernel_tiles_get(info->passes->tiles, i);
        json_t *entry = tile_name_json(info->passes, i);
        json_object_set_new(entry, "scale", json_number(tile->scale));
        json_object_set_new(entry, "minimum", json_number(tile->minimum));
        json_object_set_new(entry, "maximum", json_number(tile->maximum));
        json_array_append_new(tiles, entry);
    }
    return json_pack(
        "{s:s,s:i,s:s,s:s,s:s,s:s,s:b,s:o,s:b,s:b,s:o,s:o}", "format",
        weft_tile_format_names[p->format], "bits", p->bits, "rounding",
        weft_tile_rounding_names[p->rounding], "placement", weft_tile_placement_names[p->placement],
        "signs", weft_tile_signs_names[p->signs], "scaling", weft_tile_scaling_names[p->scaling],
        "exact_scale", p->exact_scale, "max_scale", json_number(p->max_scale), "normalise",
        p->normalise, "mirror", !p->store_all, "splits", splits_json(info), "tiles", tiles);
}

// ---- passes -------------------------------------------------------------------------------------

static json_t *group_json(const struct weft_pass_list *list, const struct weft_tap_group *group)
{
    json_t *taps = json_array();
    for (int c = 0; c < (list->dot4 ? 4 : 1); c++) {
        json_t *tap = group->tile[c] < 0 ? json_null() : tile_name_json(list, group->tile[c]);
        if (group->tile[c] >= 0) {
            json_object_set_new(tap, "sign", json_integer(group->sign[c]));
            json_object_set_new(tap, "shift", json_integer(group->shift[c]));
        }
        json_array_append_new(taps, tap);
    }
    return json_pack("{s:o,s:o}", "offset", plan_integers_json(group->offset, list->dims), "taps",
                     taps);
}

static void set_taps(json_t *out, const struct weft_pass_list *list, const struct weft_pass *pass)
{
    json_t *groups = json_array();
    for (int i = 0; i < pass->group_count; i++)
        json_array_append_new(groups, group_json(list, &list->groups[pass->group_first + i]));
    json_object_set_new(out, "initial", json_integer(pass->initial));
    json_object_set_new(out, "part", json_string(weft_pass_part_names[pass->part]));
    json_object_set_new(out, "subtract", json_boolean(pass->subtract));
    json_object_set_new(out, "ping_pong", json_boolean(pass->reads_target));
    json_object_set_new(out, "bias", json_integer(pass->bias));
    json_object_set_new(out, "divisor", json_integer(pass->divisor));
    json_object_set_new(out, "groups", groups);
}

static void set_inputs(json_t *out, const struct weft_pass *pass)
{
    json_t *inputs = json_array();
    for (int i = 0; i < pass->input_count; i++)
        json_array_append_new(inputs, json_pack("{s:i,s:i}", "slot", pass->input[i], "numerator",
                                                pass->numerator[i]));
    json_object_set_new(out, "inputs", inputs);
    json_object_set_new(out, "bias", json_integer(pass->bias));
    json_object_set_new(out, "denominator", json_integer(pass->denominator));
}

static json_t *passes_json(const struct weft_pass_plan_info *info)
{
    const struct weft_pass_list *list = info->passes;
    json_t *passes = json_array();
    for (int i = 0; i < list->pass_count; i++) {
        const struct weft_pass *pass = &list->passes[i];
        json_t *out = json_pack("{s:s,s:i,s:b}", "kind", weft_pass_kind_names[pass->kind], "slot",
                                pass->target, "clears", pass->clears);
        if (pass->kind == WEFT_PASS_TAPS)
            set_taps(out, list, pass);
        else
            set_inputs(out, pass);
        json_object_set_new(out, "range", plan_range_json(&info->ranges[i], info->dims));
        json_array_append_new(passes, out);
    }
    return passes;
}

static json_t *list_json(const struct weft_pass_list *list)
{
    json_t *pattern = json_array(), *table = list->log_table ? json_array() : json_null();
    for (int c = 0; list->dot4 && c < 4; c++)
        json_array_append_new(pattern, plan_integers_json(list->pattern[c], list->dims));
    for (int i = 0; list->log_table && i <= 2 * weft_target_one(list->target); i++)
        json_array_append_new(table, json_integer(list->log_table[i]));
    return json_pack("{s:s,s:b,s:i,s:o,s:b,s:i,s:o,s:i,s:i,s:i,s:o,s:o,s:o,s:o}", "target",
                     weft_target_names[list->target], "dot4", list->dot4, "dot_width",
                     list->dot_width, "pattern", pattern, "exact_inside", list->exact_inside,
                     "extra_bits", list->extra_bits, "range", json_number(list->range), "slots",
                     list->slot_count, "scratch", list->scratch_count, "result", list->result,
                     "result_scale", json_number(list->result_scale), "result_bias",
                     json_number(list->result_bias), "log_octaves", json_number(list->log_octaves),
                     "log_table", table);
}

// ---- the plan -----------------------------------------------------------------------------------

static json_t *head_json(const struct weft_pass_plan_info *info)
{
    char kernel[KERNELS_TEXT], along[WEFT_DERIVATIVE_TEXT];
    weft_kernel_format(&info->kernel, kernel, sizeof kernel);
    return json_pack("{s:s,s:i,s:o,s:i,s:s,s:o,s:i,s:i,s:i,s:s,s:s,s:s,s:b}", "format", "weft-plan",
                     "version", 1, "kernel", json_text(kernel), "dims", info->dims, "derivative",
                     weft_derivative_format(&info->derivative, along), "profile",
                     profile_json(&info->profile), "bits", info->bits, "resolution", info->samples,
                     "channels", info->channels, "technique", weft_technique_names[info->technique],
                     "worst_case", weft_worst_case_names[info->worst_case], "order",
                     weft_order_names[info->order], "valid", info->valid);
}

static void set_figures(json_t *root, const struct weft_pass_plan_info *info)
{
    json_object_set_new(root, "bound", json_number(info->error.bound));
    json_object_set_new(root, "bound_parts", bound_json(&info->error));
    json_object_set_new(root, "range", report_json(info));
    json_object_set_new(root, "tap_count", json_integer(info->tap_count));
    json_object_set_new(root, "tile_count", json_integer(info->tile_count));
    json_object_set_new(root, "split_count", json_integer(info->split_count));
    json_object_set_new(root, "pass_count", json_integer(info->passes->pass_count));
    json_object_set_new(root, "fetches", json_integer(info->fetches));
    json_object_set_new(root, "kept_bits", json_integer(info->kept_bits));
    json_object_set_new(root, "scale_bits", json_number(info->scale_bits));
    json_object_set_new(root, "tile_bytes", json_count(info->tile_bytes));
    json_object_set_new(root, "target_bytes_per_pixel", json_count(info->target_bytes_per_pixel));
    json_object_set_new(root, "search_seconds", json_number(info->search_seconds));
}

json_t *plan_json(const weft_pass_plan *plan)
{
    const struct weft_pass_plan_info *info = weft_pass_plan_get_info(plan);
    json_t *root = head_json(info);
    set_figures(root, info);
    json_object_set_new(root, "tile_set", tiles_json(info));
    json_object_set_new(root, "targets", list_json(info->passes));
    json_object_set_new(root, "passes", passes_json(info));
    return root;
}
