// SPDX-License-Identifier: BSD-3-Clause
#include "tools/methods/accumulate_report.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tools/common/report.h"
#include "tools/common/run_report.h"

// ---- the method ---------------------------------------------------------------------------------

const char *accumulation_format(const struct option_value *first,
                                const struct weft_accumulator_report *report,
                                char text[ACCUMULATION_TEXT])
{
    const char *name = weft_accumulate_method_names[report->method];
    if (report->bits == WEFT_ACCUMULATE_HALF)
        snprintf(text, ACCUMULATION_TEXT, "%s of half floats", name);
    else if (report->bits)
        snprintf(text, ACCUMULATION_TEXT, "%s of %d bits", name, report->bits);
    else
        snprintf(text, ACCUMULATION_TEXT, "%s", name);
    if (report->method == WEFT_ACCUMULATE_TREE)
        snprintf(text + strlen(text), ACCUMULATION_TEXT - strlen(text), ", branching %s",
                 first[ACCUMULATION_BRANCHING].given ? first[ACCUMULATION_BRANCHING].text : "4");
    return text;
}

json_t *accumulation_json(const struct weft_accumulator_report *r)
{
    return json_pack("{s:s,s:o,s:i,s:o,s:o,s:i,s:o,s:o,s:o}", "name",
                     weft_accumulate_method_names[r->method], "why",
                     json_text(r->why ? r->why : ""), "bits", r->bits, "bound",
                     json_number(r->bound), "bias", json_number(r->bias), "textures", r->textures,
                     "bytes", run_report_bytes("held", r->bytes), "passes", json_count(r->passes),
                     "not_finite", json_count(r->nonfinite));
}

// ---- --until ------------------------------------------------------------------------------------

json_t *accumulation_stop_json(const struct accumulation_stop *stop)
{
    const struct weft_convergence *c = &stop->convergence;
    return json_pack("{s:o,s:b,s:b,s:o,s:o,s:o,s:o}", "asked", json_text(stop->asked), "met",
                     c->enough, "stopped", stop->stopped, "judged_after",
                     json_count((uint64_t)stop->judged), "share", json_number(c->share), "largest",
                     json_number(c->largest), "median", json_number(c->median));
}

void accumulation_tell_stop(const struct accumulation_stop *stop)
{
    const struct weft_convergence *c = &stop->convergence;
    if (stop->stopped)
        report_tell("--until %s is met after %lld of %lld frames: %.2f %% of the pixels",
                    stop->asked, (long long)stop->frames, (long long)stop->planned,
                    100.0 * c->share);
    else if (!c->enough)
        report_warning("--until %s is not met by all %lld frames: %.2f %% of the pixels are, the "
                       "median of the standard errors is %.3g",
                       stop->asked, (long long)stop->frames, 100.0 * c->share, c->median);
}

// ---- beforehand ---------------------------------------------------------------------------------

// Of each group of four channels: frames that are put in, and nodes. Returns how many textures.
static int explain_tree(const struct accumulation *a, int groups, int64_t frames)
{
    struct weft_tree_params params = {.leaf_count = (int)frames, .branching = a->branching};
    weft_tree *tree = NULL;
    memcpy(params.level_branching, a->level_branching, sizeof params.level_branching);
    if (frames > WEFT_TREE_MAX_LEAVES || weft_tree_create(&params, &tree) != WEFT_OK)
        return 0;
    const struct weft_tree_info *info = weft_tree_get_info(tree);
    printf("passes: %d, of %d frames and %d nodes, on a stack of %d textures\n",
           groups * info->step_count, info->leaf_count, info->node_count,
           groups * info->stack_size);
    const int textures = groups * info->stack_size;
    weft_tree_destroy(&tree);
    return textures;
}

int accumulation_explain_passes(const struct accumulation *a, enum weft_accumulate_method method,
                                int groups, int64_t frames)
{
    switch (method) {
    case WEFT_ACCUMULATE_TREE:
        return explain_tree(a, groups, frames);
    case WEFT_ACCUMULATE_BLEND:
    case WEFT_ACCUMULATE_FLOAT:
        printf("passes: %lld, one a frame%s\n", (long long)(groups * frames),
               groups > 1 ? " and four channels" : "");
        return 0;
    default:
        puts("passes: none, all is done by the CPU");
        return 0;
    }
}

void accumulation_explain(const struct option_value *first,
                          const struct weft_accumulator_report *planned)
{
    char text[ACCUMULATION_TEXT];
    printf("method: %s (%s)\n", accumulation_format(first, planned, text), planned->why);
    if (isfinite(planned->bound))
        printf("bound: %.3g in the frames' values\n", planned->bound);
    else
        puts("bound: not known before the frames are");
}
