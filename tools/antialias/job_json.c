// SPDX-License-Identifier: BSD-3-Clause
// What `weft antialias` tells as JSON.
#include <math.h>

#include "tools/antialias/job.h"
#include "tools/common/report.h"
#include "tools/common/run_report.h"
#include "tools/options/saved.h"
#include "tools/ranks/load_report.h"

static json_t *place_json(const int at[2])
{
    return at[0] < 0 ? json_null() : json_counts((const int32_t[2]){at[0], at[1]}, 2);
}

// ---- of each way --------------------------------------------------------------------------------

static json_t *acaa_json(const struct antialias_job *job)
{
    const struct weft_acaa_report *r = &job->report.acaa;
    const struct antialias_params *p = &job->params;
    return json_pack("{s:s,s:o,s:s,s:s,s:i,s:i,s:o,s:o,s:i,s:o}", "form",
                     weft_acaa_form_names[r->form], "why", json_text(r->why), "coincident",
                     weft_acaa_coincident_names[p->coincident], "sums",
                     weft_acaa_sums_names[p->sums], "device_samples", r->device_samples, "depth",
                     p->depth_bits, "range", json_number(r->range), "scale", json_number(r->scale),
                     "redone", r->redone, "callbacks", json_count(r->callbacks));
}

static json_t *weights_json(const struct antialias_job *job)
{
    const struct antialias_weights *w = &job->weights;
    const bool any = w->frames > 0;
    return json_pack("{s:b,s:o,s:o,s:o,s:o,s:o,s:i}", "whole", !any, "less",
                     json_count((uint64_t)w->less), "more", json_count((uint64_t)w->more),
                     "first_less", any ? place_json(w->first_less) : json_null(), "first_more",
                     any ? place_json(w->first_more) : json_null(), "largest",
                     json_number(w->largest), "pictures", w->frames);
}

static json_t *multisample_json(const struct antialias_job *job)
{
    const struct antialias_params *p = &job->params;
    return json_pack("{s:s,s:s,s:i,s:o}", "resolve", weft_msaa_resolve_names[p->resolve], "format",
                     weft_antialias_format_names[p->format], "depth", p->depth_bits, "scale",
                     json_number(job->report.msaa.scale));
}

static json_t *supersample_json(const struct antialias_job *job)
{
    const struct weft_supersample_report *r = &job->report.supersample;
    const struct antialias_params *p = &job->params;
    return json_pack("{s:s,s:s,s:s,s:s,s:o,s:o}", "pattern", p->pattern ? p->pattern->name : "grid",
                     "store", weft_supersample_store_names[p->store], "method",
                     weft_accumulate_method_names[r->method], "format",
                     weft_antialias_format_names[p->format], "pixels",
                     json_count((uint64_t)r->pixels), "sampled", json_count((uint64_t)r->sampled));
}

static json_t *marks_json(const struct antialias_job *job)
{
    const struct weft_marks *m = job->report.marks;
    const struct antialias_params *p = &job->params;
    const double pixels = (double)p->size[0] * (double)p->size[1];
    return json_pack(
        "{s:s,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o}", "mark", weft_mark_names[p->mark], "contrast",
        json_number(p->contrast), "max_edge_share", json_number(p->max_share), "pixels",
        json_count((uint64_t)m->count), "share", json_number((double)m->count / pixels), "by_edges",
        json_count((uint64_t)m->by_edges), "by_contrast", json_count((uint64_t)m->by_contrast),
        "left", json_count((uint64_t)m->left), "left_error", json_number(m->left_error));
}

static json_t *bytes_json(const struct antialias_job *job)
{
    const struct antialias_report *r = &job->report;
    json_t *object = json_pack("{s:o,s:o}", "formula", json_count(r->formula_bytes), "held",
                               json_count(r->bytes));
    if (r->full_bytes)
        json_object_set_new(object, "full_supersampling", json_count(r->full_bytes));
    for (int f = 0; f < WEFT_ANTIALIAS_FORMAT_COUNT && job->params.way == ANTIALIAS_ACAA; f++) {
        char key[32];
        snprintf(key, sizeof key, "msaa_%s", weft_antialias_format_names[f]);
        json_object_set_new(object, key, json_count(r->multisample_bytes[f]));
    }
    return object;
}

static json_t *filter_json(const struct antialias_job *job)
{
    char kernel[KERNELS_TEXT];
    return json_pack(
        "{s:o,s:o,s:i}", "kernel", json_text(antialias_job_filter(job, kernel)), "width",
        job->params.filter_width != 0.0 ? json_number(job->params.filter_width) : json_null(),
        "radius", job->report.radius);
}

static void set_way(json_t *root, const struct antialias_job *job)
{
    switch (job->params.way) {
    case ANTIALIAS_ACAA:
        json_object_set_new(root, "filter", filter_json(job));
        json_object_set_new(root, "acaa", acaa_json(job));
        return;
    case ANTIALIAS_ADAPTIVE:
    case ANTIALIAS_SUPERSAMPLE:
        json_object_set_new(root, "filter", filter_json(job));
        json_object_set_new(root, "supersample", supersample_json(job));
        return;
    default:
        json_object_set_new(root, "multisample", multisample_json(job));
    }
}

// ---- what came of it ----------------------------------------------------------------------------

static json_t *seconds_json(const struct antialias_job *job)
{
    const struct antialias_seconds *s = &job->seconds;
    const struct run_stage stages[] = {
        {"scene", s->scene}, {"context", s->context}, {"prepare", s->prepare},
        {"draw", s->draw},   {"verify", s->verify},   {"write", s->write},
    };
    return run_report_seconds(stages, sizeof stages / sizeof *stages,
                              report_now_seconds() - job->start);
}

static json_t *exactness_json(const struct antialias_job *job)
{
    const struct antialias_exactness *e = &job->exactness;
    json_t *error =
        run_report_error(e->largest, sqrt(e->square / (double)e->values), (uint64_t)e->values,
                         "light", e->at[0] < 0 ? NULL : (const int32_t[]){e->at[0], e->at[1]}, 2);
    json_object_update_new(error,
                           json_pack("{s:s,s:i,s:o}", "channel", picture_channel_names[e->channel],
                                     "frame", e->frame, "known_to", json_number(e->known_to)));
    return error;
}

static void set_outputs(json_t *root, const struct antialias_job *job)
{
    const struct option_value *o = job->option;
    if (o[ASK_OUTPUT].given)
        json_object_set_new(root, "file", saved_json(&job->picture.saved));
    if (o[ASK_WEIGHT_MAP].given)
        json_object_set_new(root, "weight_map", json_text(o[ASK_WEIGHT_MAP].text));
    if (o[ASK_PREVIEW].given)
        json_object_set_new(root, "preview",
                            run_report_preview(o[ASK_PREVIEW].text, job->preview_range));
}

static void set_results(json_t *root, const struct antialias_job *job)
{
    json_object_update_new(root, json_pack("{s:{s:o,s:o},s:o,s:o,s:o}", "picture_seconds", "median",
                                           json_number(antialias_job_median(job)), "first",
                                           json_number(job->seconds_each[0]), "channels",
                                           picture_json(job->statistics), "context",
                                           run_report_context(job->context), "seconds",
                                           seconds_json(job)));
    if (job->params.way == ANTIALIAS_ACAA)
        json_object_set_new(root, "weights", weights_json(job));
    if (job->report.marks)
        json_object_set_new(root, "marks", marks_json(job));
    json_t *ranks = load_report_json(&job->divided.work, true);
    if (ranks)
        json_object_set_new(root, "ranks", ranks);
    if (job->shadow.faces)
        json_object_set_new(root, "shadow", scene_options_shadow_json(&job->shadow));
    if (job->exactness.values)
        json_object_set_new(root, "error", exactness_json(job));
    set_outputs(root, job);
}

enum weft_result antialias_job_print_json(const struct antialias_job *job)
{
    const struct antialias_report *r = &job->report;
    json_t *root =
        json_pack("{s:s,s:o,s:i,s:i,s:o,s:i,s:o,s:i,s:i,s:o,s:o,s:o}", "way",
                  antialias_way_names[job->params.way], "scene",
                  scene_options_json(job->scene_name, &job->scene), "width", job->params.size[0],
                  "height", job->params.size[1], "seed", json_count(job->params.seed), "frames",
                  job->frames, "time", json_numbers(job->request.time, 2), "samples", r->samples,
                  "passes", r->passes, "discrepancy", json_number(r->discrepancy), "sums_bound",
                  json_number(r->bound), "bytes", bytes_json(job));
    set_way(root, job);
    if (!job->option[ASK_EXPLAIN].given)
        set_results(root, job);
    return json_print(root);
}
