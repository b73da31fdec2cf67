// SPDX-License-Identifier: BSD-3-Clause
// The options of `weft antialias`.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/antialias/job.h"
#include "tools/common/report.h"
#include "tools/methods/jitter_sets.h"
#include "tools/options/saved.h"
#include "tools/ranks/ranks.h"

const char *const antialias_depth_choices[] = {"24", "32", NULL};

static bool is_given(const struct antialias_job *job, enum antialias_option option)
{
    return job->option[option].given;
}

bool antialias_job_help(const struct antialias_job *job)
{
    if (options_ask_for_help(&job->option[ASK_SCENE]))
        scene_options_print_scenes();
    else if (options_ask_for_help(&job->option[ASK_PATTERN]))
        jitter_sets_print();
    else if (options_ask_for_help(&job->option[ASK_FILTER]))
        kernels_print();
    else
        return false;
    return true;
}

// ---- what contradicts what ----------------------------------------------------------------------

enum { ACAA = 1 << ANTIALIAS_ACAA, MSAA = 1 << ANTIALIAS_MSAA, ADAPTIVE = 1 << ANTIALIAS_ADAPTIVE };
enum { SUPERSAMPLE = 1 << ANTIALIAS_SUPERSAMPLE, NONE = 1 << ANTIALIAS_NONE };

// Options that are not of all ways.
static const struct {
    enum antialias_option option;
    const char *name;
    unsigned ways;
} way_options[] = {
    {ASK_WEIGHT_MAP, "--weight-map", ACAA},
    {ASK_SAMPLES, "--samples", ACAA | MSAA | ADAPTIVE | SUPERSAMPLE},
    {ASK_FILTER, "--kernel", ACAA | ADAPTIVE | SUPERSAMPLE},
    {ASK_FILTER_WIDTH, "--kernel-width", ACAA | ADAPTIVE | SUPERSAMPLE},
    {ASK_FORM, "--form", ACAA},
    {ASK_COINCIDENT, "--coincident", ACAA},
    {ASK_SUMS, "--sums", ACAA},
    {ASK_SUM_RANGE, "--sum-range", ACAA | MSAA},
    {ASK_ALLOW_WEIGHT, "--allow-weight", ACAA},
    {ASK_RESOLVE, "--resolve", MSAA},
    {ASK_DEPTH, "--depth", ACAA | MSAA | NONE},
    {ASK_FORMAT, "--sample-format", MSAA | ADAPTIVE | SUPERSAMPLE | NONE},
    {ASK_MARK, "--mark", ADAPTIVE},
    {ASK_CONTRAST, "--contrast", ADAPTIVE},
    {ASK_MAX_EDGE_SHARE, "--max-edge-share", ADAPTIVE},
    {ASK_STORE, "--store", ADAPTIVE | SUPERSAMPLE},
    {ASK_METHOD, "--method", ADAPTIVE | SUPERSAMPLE},
    {ASK_PATTERN, "--pattern", ADAPTIVE | SUPERSAMPLE},
};

static bool has_foreign_option(const struct antialias_job *job)
{
    for (size_t i = 0; i < sizeof way_options / sizeof *way_options; i++) {
        char names[ANTIALIAS_TEXT];
        if (!is_given(job, way_options[i].option) || way_options[i].ways >> job->params.way & 1)
            continue;
        options_join_names(antialias_way_names, way_options[i].ways, "and", names, sizeof names);
        report_error("%s is of %s: it makes no sense with %s", way_options[i].name, names,
                     antialias_way_names[job->params.way]);
        return true;
    }
    return false;
}

struct preview_options antialias_job_preview(const struct antialias_job *job)
{
    static const struct option_value none = {.given = false};
    const struct option_value *o = job->option;
    return (struct preview_options){.range = &o[ASK_RANGE],
                                    .colour_map = &none,
                                    .exposure = &o[ASK_EXPOSURE],
                                    .annotate = &o[ASK_ANNOTATE],
                                    .title = &o[ASK_TITLE],
                                    .no_clobber = o[ASK_NO_CLOBBER].given};
}

static const char *output_conflict(const struct antialias_job *job)
{
    const bool picture = is_given(job, ASK_OUTPUT), preview = is_given(job, ASK_PREVIEW),
               map = is_given(job, ASK_WEIGHT_MAP);
    const bool map_is_exr = map && job->option[ASK_WEIGHT_MAP].integer[0] != 1;
    if (is_given(job, ASK_QUIET) && is_given(job, ASK_VERBOSE))
        return "-q and -v exclude each other";
    const struct preview_options how = antialias_job_preview(job);
    if (!preview && is_given(job, ASK_RANGE))
        return "--range needs --preview OUT.png";
    if (preview_conflict(&how, preview))
        return preview_conflict(&how, preview);
    if (!picture && is_given(job, ASK_TYPE))
        return "--type needs -o OUT.exr";
    if (!picture && !map_is_exr && is_given(job, ASK_COMPRESSION))
        return "--compression needs -o OUT.exr or --weight-map OUT.exr";
    if (saved_conflict(&job->option[ASK_COMPRESSION], &job->option[ASK_OUTPUT]))
        return saved_conflict(&job->option[ASK_COMPRESSION], &job->option[ASK_OUTPUT]);
    if (!picture && !preview && !map && !is_given(job, ASK_FRAMES) && !is_given(job, ASK_VERIFY) &&
        !is_given(job, ASK_EXPLAIN) && !is_given(job, ASK_JSON))
        return "nothing to do: give -o OUT.exr, --preview OUT.png, --frames N to time pictures, "
               "--verify, --json or --explain";
    return NULL;
}

// Options of the forms that know which samples are visible; NULL: none is given.
const char *antialias_job_form_option(const struct antialias_job *job)
{
    static const struct {
        enum antialias_option option;
        const char *name;
    } of_forms[] = {{ASK_COINCIDENT, "--coincident"},
                    {ASK_SUMS, "--sums"},
                    {ASK_SUM_RANGE, "--sum-range"},
                    {ASK_DEPTH, "--depth"}};
    for (size_t i = 0; i < sizeof of_forms / sizeof *of_forms; i++)
        if (is_given(job, of_forms[i].option))
            return of_forms[i].name;
    return NULL;
}

static bool has_other_form_option(const struct antialias_job *job)
{
    const char *const name = antialias_job_form_option(job);
    if (!name || job->option[ASK_FORM].integer[0] != WEFT_ACAA_JITTER)
        return false;
    report_error("%s makes no sense with --form jitter, which draws each sample as a picture of "
                 "its own",
                 name);
    return true;
}

static const char *sums_conflict(const struct antialias_job *job)
{
    const struct option_value *o = job->option;
    const bool acaa = job->params.way == ANTIALIAS_ACAA;
    if (is_given(job, ASK_SUM_RANGE) && acaa && o[ASK_SUMS].integer[0] == WEFT_ACAA_FLOAT)
        return "--sum-range is of integers: it makes no sense with --sums float";
    if (is_given(job, ASK_SUM_RANGE) && !acaa && o[ASK_RESOLVE].integer[0] != WEFT_MSAA_SUM)
        return "--sum-range needs --resolve sum";
    if (is_given(job, ASK_EXPLAIN) && is_given(job, ASK_VERIFY))
        return "--verify needs pictures, and --explain draws none";
    return NULL;
}

static enum weft_result check_conflicts(const struct antialias_job *job)
{
    const char *conflict = output_conflict(job);
    if (!conflict && (has_foreign_option(job) || has_other_form_option(job)))
        return WEFT_ERR_ARGUMENT;
    if (!conflict)
        conflict = sums_conflict(job);
    if (conflict)
        report_error("%s", conflict);
    return conflict ? WEFT_ERR_ARGUMENT : WEFT_OK;
}

// ---- single options -----------------------------------------------------------------------------

static enum weft_result read_way(struct antialias_job *job)
{
    const char *const name = job->operands[0];
    if (!name) {
        report_error("no way given: weft antialias acaa|msaa|adaptive|supersample|none -o OUT.exr "
                     "(see weft help antialias)");
        return WEFT_ERR_ARGUMENT;
    }
    for (int i = 0; i < ANTIALIAS_WAY_COUNT; i++)
        if (strcmp(name, antialias_way_names[i]) == 0) {
            job->params.way = (enum antialias_way)i;
            return WEFT_OK;
        }
    char explanation[256];
    report_error("no way '%s' of anti-aliasing%s", name,
                 weft_closest_explain(name, strlen(name), antialias_way_names, explanation,
                                      sizeof explanation));
    return WEFT_ERR_ARGUMENT;
}

// A number of points that it names stands for as many samples.
static enum weft_result read_pattern(struct antialias_job *job)
{
    const struct option_value *o = &job->option[ASK_PATTERN];
    struct antialias_params *p = &job->params;
    int count = 0;
    if (!o->given)
        return WEFT_OK;
    const enum weft_result res = weft_jitter_parse(report_log(), o->text, &p->pattern, &count);
    if (res != WEFT_OK)
        return res;
    if (count == 0 && p->pattern->counts && !p->pattern->counts[1])
        count = p->pattern->counts[0];
    if (count && job->option[ASK_SAMPLES].given && p->samples != count) {
        report_error("--pattern %s has %d points, for %d samples", o->text, count, p->samples);
        return WEFT_ERR_ARGUMENT;
    }
    if (count > WEFT_PATTERN_MAX) {
        report_error("--pattern %s: a pixel has %d samples at most", o->text, WEFT_PATTERN_MAX);
        return WEFT_ERR_ARGUMENT;
    }
    p->samples = count ? count : p->samples;
    return WEFT_OK;
}

static enum weft_result read_samples(struct antialias_job *job)
{
    static const int usual[ANTIALIAS_WAY_COUNT] = {4, 4, 16, 16, 1};
    struct antialias_params *p = &job->params;
    p->samples = usual[p->way];
    enum weft_result res =
        options_read_whole(&job->option[ASK_SAMPLES], "samples", 1, WEFT_PATTERN_MAX, &p->samples);
    if (res == WEFT_OK)
        res = read_pattern(job);
    const int side = (int)lround(sqrt(p->samples));
    const bool grid = p->way == ANTIALIAS_ADAPTIVE || p->way == ANTIALIAS_SUPERSAMPLE;
    if (res != WEFT_OK || !grid || p->pattern || side * side == p->samples)
        return res;
    report_error("--samples %d: a grid has 1, 4, 9, 16 ... samples; --pattern SET has others",
                 p->samples);
    return WEFT_ERR_ARGUMENT;
}

// Above 0, as a number or in percent.
static enum weft_result read_share(const struct option_value *o, double *out)
{
    char *end;
    if (!o->given)
        return WEFT_OK;
    *out = strtod(o->text, &end);
    const bool percent = *end == '%';
    *out /= percent ? 100.0 : 1.0;
    if (end != o->text && !end[percent] && *out > 0.0 && *out <= 1.0)
        return WEFT_OK;
    report_error("--max-edge-share %s: not a share above 0, up to 1 or 100%%", o->text);
    return WEFT_ERR_ARGUMENT;
}

static enum weft_result read_edges(struct antialias_job *job)
{
    const struct option_value *o = job->option;
    struct antialias_params *p = &job->params;
    enum weft_result res = options_read_number(
        &o[ASK_CONTRAST], "contrast", 0x1p-1022, HUGE_VAL,
        "a difference of neighbouring pixels that is an edge is above 0", &p->contrast);
    if (res == WEFT_OK)
        res = read_share(&o[ASK_MAX_EDGE_SHARE], &p->max_share);
    return res == WEFT_OK ? options_read_number(&o[ASK_SUM_RANGE], "sum-range", 0x1p-100, 0x1p100,
                                                "the largest component of a colour is from 2^-100 "
                                                "to 2^100",
                                                &p->sum_range)
                          : res;
}

static void read_choices(struct antialias_job *job)
{
    const struct option_value *o = job->option;
    struct antialias_params *p = &job->params;
    p->form = (enum weft_acaa_form)o[ASK_FORM].integer[0];
    p->coincident = (enum weft_acaa_coincident)o[ASK_COINCIDENT].integer[0];
    p->sums = (enum weft_acaa_sums)o[ASK_SUMS].integer[0];
    p->resolve = (enum weft_msaa_resolve)o[ASK_RESOLVE].integer[0];
    p->depth_bits = o[ASK_DEPTH].integer[0] == 1 ? 32 : 24;
    p->format = o[ASK_FORMAT].given ? (enum weft_antialias_format)o[ASK_FORMAT].integer[0]
                                    : WEFT_ANTIALIAS_RGBA32F;
    p->mark = (enum weft_mark)o[ASK_MARK].integer[0];
    p->store = (enum weft_supersample_store)o[ASK_STORE].integer[0];
    p->method = (enum weft_accumulate_method)o[ASK_METHOD].integer[0];
}

static enum weft_result read_params(struct antialias_job *job)
{
    const struct option_value *o = job->option;
    struct antialias_params *p = &job->params;
    enum weft_result res = scene_options_read(&o[ASK_SCENES], &job->request);
    memcpy(p->size, job->request.size, sizeof p->size);
    p->seed = job->request.seed;
    p->log = report_log();
    read_choices(job);
    job->frames = 1;
    if (res == WEFT_OK)
        res = options_read_whole(&o[ASK_FRAMES], "frames", 1, ANTIALIAS_MAX_FRAMES, &job->frames);
    if (res == WEFT_OK)
        res = read_samples(job);
    if (res == WEFT_OK)
        res = kernels_read_filter(&o[ASK_FILTER], &o[ASK_FILTER_WIDTH], &p->filter,
                                  &job->filter_file, &p->filter_width);
    if (res == WEFT_OK)
        res = read_edges(job);
    if (res == WEFT_OK && o[ASK_CONTEXT].given)
        res = weft_context_kind_parse(report_log(), o[ASK_CONTEXT].text, &job->kind);
    return res;
}

// ---- ranks --------------------------------------------------------------------------------------

// Pictures for each rank from which on they are not divided where nothing else is asked for.
enum { FRAMES_EACH = 4 };

// Sums that depend on the order in which fragments of several pixels come; NULL: they do not.
static const char *ordered_sums(const struct antialias_params *p)
{
    if (p->way != ANTIALIAS_ACAA || p->form == WEFT_ACAA_JITTER)
        return NULL;
    return p->sums == WEFT_ACAA_FLOAT               ? "--sums float"
           : p->coincident == WEFT_COINCIDENT_ALPHA ? "--coincident alpha"
                                                    : NULL;
}

static enum weft_result read_divided(struct antialias_job *job)
{
    struct antialias_divided *d = &job->divided;
    struct rank_request *r = &d->request;
    const enum weft_result res = rank_options_read(&job->option[ASK_RANKS], r);
    if (res != WEFT_OK)
        return res;
    const char *ordered = ordered_sums(&job->params);
    const bool whole = r->region[0]<0, parts = r->region[1]> 0 || r->granularity || r->cost_map ||
                       r->schedule == WEFT_SCHEDULE_DYNAMIC;
    d->is = (ranks_size() > 1 || r->given) && !is_given(job, ASK_EXPLAIN);
    d->by_frame =
        whole || ordered || (!parts && job->frames >= (int64_t)FRAMES_EACH * ranks_size());
    if (whole && r->cost_map)
        report_error("--cost-map is of parts of a picture, and --region frame leaves pictures "
                     "whole");
    else if (parts && ordered)
        report_error("%s depends on the order of fragments, which parts of a picture do not keep: "
                     "--region frame leaves pictures whole",
                     ordered);
    else
        return WEFT_OK;
    return WEFT_ERR_ARGUMENT;
}

enum weft_result antialias_job_read_options(struct antialias_job *job)
{
    const struct option_value *o = job->option;
    const struct preview_options preview = antialias_job_preview(job);
    const struct weft_colour_map *no_map;
    enum weft_result res = read_way(job);
    if (res == WEFT_OK)
        res = check_conflicts(job);
    if (res == WEFT_OK)
        res = read_params(job);
    if (res == WEFT_OK)
        res = read_divided(job);
    job->scene_name = o[ASK_SCENE].given ? o[ASK_SCENE].text : scene_find_default("antialias")[0];
    return res == WEFT_OK ? preview_check(&preview, &no_map) : res;
}

double antialias_job_time(const struct antialias_job *job, int frame)
{
    const double *time = job->request.time;
    return time[0] + (time[1] - time[0]) * ((double)frame + 0.5) / (double)job->frames;
}
