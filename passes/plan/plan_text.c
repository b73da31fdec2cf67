// SPDX-License-Identifier: BSD-3-Clause
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "passes/plan/plan_impl.h"

static const char *plural(int count)
{
    return count == 1 ? "" : "s";
}

static char slot_letter(int slot)
{
    return (char)('A' + slot % 26);
}

// ---- taps ---------------------------------------------------------------------------------------

static void print_tap(FILE *out, const struct weft_planner *planner, int tile)
{
    char text[WEFT_TILE_NAME_TEXT];
    const struct weft_tile_name name = weft_tile_name_of(planner->plan->tiles, tile, true);
    fputs(weft_tile_name_format(&name, planner->p.dims, text), out);
}

static void print_group(FILE *out, const struct weft_planner *planner,
                        const struct weft_tap_group *group)
{
    int first = -1, last = -1;
    for (int c = 0; c < (planner->plan->list.dot4 ? 4 : 1); c++) {
        if (group->tile[c] < 0)
            continue;
        first = first < 0 ? c : first;
        last = c;
    }
    if (first < 0) {
        fputs("none", out);
        return;
    }
    print_tap(out, planner, group->tile[first]);
    if (last != first) {
        fputc('-', out);
        print_tap(out, planner, group->tile[last]);
    }
}

static void print_taps(FILE *out, const struct weft_planner *planner, const struct weft_pass *pass)
{
    fputs("taps", out);
    for (int g = 0; g < pass->group_count; g++) {
        fputc(' ', out);
        print_group(out, planner, &planner->plan->groups[pass->group_first + g]);
    }
    fprintf(out, ", %s", pass->reads_target ? "mixed" : pass->subtract ? "subtract" : "add");
    if (pass->part != WEFT_PASS_WHOLE)
        fprintf(out, " %s parts", pass->part == WEFT_PASS_HIGH ? "high" : "low");
    if (pass->initial)
        fprintf(out, ", from %d", pass->initial);
    if (pass->bias)
        fprintf(out, ", bias %g", (double)pass->bias / (1 << planner->plan->list.extra_bits));
}

static void print_combine(FILE *out, const struct weft_pass *pass)
{
    fputs("combine", out);
    for (int i = 0; i < pass->input_count; i++)
        fprintf(out, " %+d%c", pass->numerator[i], slot_letter(pass->input[i]));
    fprintf(out, " / %d", pass->denominator);
}

static void print_pass(FILE *out, const struct weft_planner *planner, int n)
{
    const struct weft_pass *pass = &planner->plan->passes[n];
    const struct weft_range *range = &planner->plan->ranges[n];
    fprintf(out, "pass %02d: ", n);
    if (pass->kind == WEFT_PASS_TAPS)
        print_taps(out, planner, pass);
    else
        print_combine(out, pass);
    fprintf(out, ", -> %s %c, range [%.3f, %.3f]\n", weft_target_name(planner->p.profile.target),
            slot_letter(pass->target), range->minimum + 0.0, range->maximum + 0.0);
}

// ---- the plan as a whole ------------------------------------------------------------------------

static void print_head(FILE *out, const struct weft_planner *planner)
{
    const struct weft_pass_plan_info *info = &planner->plan->info;
    const struct weft_pass_list *list = &planner->plan->list;
    char kernel[512], along[WEFT_DERIVATIVE_TEXT];
    weft_kernel_format(&info->kernel, kernel, sizeof kernel);
    fprintf(out, "plan: %s", kernel);
    if (weft_derivative_order(&info->derivative))
        fprintf(out, ", derivative along %s", weft_derivative_format(&info->derivative, along));
    fprintf(out, ", %dD, %s, %s; tiles of %d^%d samples", info->dims, info->profile.name,
            weft_name(weft_technique_names, info->technique), info->samples, info->dims);
    if (!planner->real && !planner->logarithms)
        fprintf(out, " in %d bits", info->bits);
    fprintf(out, "\n%d taps, %d tiles", info->tap_count, info->tile_count);
    if (info->split_count)
        fprintf(out, " (%d split%s)", info->split_count, plural(info->split_count));
    fprintf(out, ", %d pass%s, %d fetches, %d target%s", list->pass_count,
            list->pass_count == 1 ? "" : "es", info->fetches, list->slot_count,
            plural(list->slot_count));
    if (list->scratch_count)
        fprintf(out, " and a scratch");
    fprintf(out, "; tiles %.0f bytes, targets %.0f bytes a pixel\n", (double)info->tile_bytes,
            (double)info->target_bytes_per_pixel);
    if (list->dot4) {
        fputs("dot4: offsets", out);
        for (int c = 0; c < 4; c++)
            fprintf(out, " (%d,%d,%d)", list->pattern[c][0], list->pattern[c][1],
                    list->pattern[c][2]);
        fputc('\n', out);
    }
    if (info->technique == WEFT_TECHNIQUE_SPLIT_PRECISION)
        fprintf(out, "split: %d bits kept over the passes, %d of them in the low target\n",
                info->kept_bits, list->extra_bits);
}

static void print_verdict(FILE *out, const struct weft_planner *planner)
{
    const struct weft_pass_plan_info *info = &planner->plan->info;
    const char *input = info->worst_case == WEFT_WORST_ANY ? "any input" : "constants of any level";
    if (planner->real) {
        fprintf(out, "range: %s does not clamp\n", weft_target_name(info->profile.target));
        return;
    }
    fprintf(out, "stored: %.6g value + %.6g", planner->plan->list.result_scale,
            planner->plan->list.result_bias);
    if (info->scale_bits > 0.005)
        fprintf(out, "; scaling costs %.2f bits", info->scale_bits);
    if (info->valid)
        fprintf(out, "\nrange: valid, no store clamps for %s\n", input);
    else
        fprintf(
            out,
            "\nrange: INVALID for %s: stores clamp by up to %.0f codes; the first is pass %02d, "
            "with %.4f at sample position (%d, %d, %d)\n",
            input, ceil(planner->full * info->range.overflow - 1e-6), info->range.pass,
            info->range.value, info->range.position[0], info->range.position[1],
            info->range.position[2]);
}

static void print_error(FILE *out, const struct weft_planner *planner)
{
    const struct weft_pass_plan_error *e = &planner->plan->info.error;
    fprintf(out,
            "error, of the source's range: source %.3g + E2 %.3g + E3 %.3g = %.3g; "
            "with clamping of any input %.3g\n",
            e->source, e->e2, e->e3, e->bound, e->bound_any);
}

enum weft_result weft_planner_write_text(struct weft_planner *planner)
{
    size_t size = 0;
    FILE *out = open_memstream(&planner->plan->text, &size);
    bool written = out != NULL;
    if (out) {
        print_head(out, planner);
        for (int n = 0; n < planner->plan->list.pass_count; n++)
            print_pass(out, planner, n);
        print_verdict(out, planner);
        print_error(out, planner);
        written = !ferror(out);
        written = fclose(out) == 0 && written;
    }
    if (!written) {
        weft_error(planner->p.log, "plan: not enough memory for its text");
        return WEFT_ERR_MEMORY;
    }
    planner->plan->info.text = planner->plan->text;
    return WEFT_OK;
}
