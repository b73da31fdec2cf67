// SPDX-License-Identifier: BSD-3-Clause
// What `weft effect` tells as JSON.
#include <math.h>

#include "tools/common/report.h"
#include "tools/common/run_report.h"
#include "tools/options/saved.h"
#include "tools/effect/job.h"

static json_t *effects_json(const struct effect_job *job)
{
    json_t *list = json_array();
    for (int i = 0; i < EFFECT_COUNT; i++)
        if (job->params.effects >> i & 1)
            json_array_append_new(list, json_text(effect_names[i]));
    return list;
}

static json_t *scene_json(const struct effect_job *job, int i)
{
    double share = 0.0;
    for (int64_t k = 0; k < job->plan.count; k++)
        share += job->plan.frames[k].scene == i ? job->plan.frames[k].weight : 0.0;
    json_t *object = scene_options_json(job->scene[i].name, &job->scene[i].scene);
    json_object_set_new(object, "weight", json_number(share));
    return object;
}

static json_t *scenes_json(const struct effect_job *job)
{
    json_t *list = json_array();
    for (int i = 0; i < job->scene_count; i++)
        json_array_append_new(list, scene_json(job, i));
    return list;
}

// Why there are so many frames.
static json_t *needs_json(const struct effect_job *job)
{
    json_t *list = json_array();
    for (int i = 0; i < EFFECT_COUNT; i++) {
        const struct effect_need *need = &job->plan.need[i];
        if (job->params.effects >> i & 1)
            json_array_append_new(list, json_pack("{s:s,s:o,s:o}", "effect", effect_names[i],
                                                  "frames", json_count((uint64_t)need->frames),
                                                  "pixels", json_number(need->figure)));
    }
    return list;
}

static json_t *sets_json(const struct effect_job *job)
{
    json_t *object = json_object();
    for (int i = 0; i < EFFECT_PLACE_COUNT; i++) {
        const struct effect_set *set = &job->plan.set[i];
        if (set->info)
            json_object_set_new(
                object, effect_place_names[i],
                json_pack("{s:s,s:i,s:s,s:o,s:o,s:o,s:o}", "set", set->info->name, "points",
                          set->count, "shape", weft_jitter_shape_names[set->shape], "size",
                          json_number(set->size), "mean", json_numbers(set->mean, 2), "shift",
                          json_numbers(set->shift, 2), "discrepancy",
                          json_number(set->discrepancy)));
    }
    return object;
}

static json_t *weights_json(const struct effect_job *job)
{
    const struct weft_weights_report *w = &job->plan.weights;
    return json_pack("{s:o,s:o,s:o,s:o,s:i,s:o}", "largest", json_number(w->largest), "negative",
                     json_number(w->negative), "gain", json_number(w->gain), "effective",
                     json_number(w->effective), "zeros", w->zeros, "change",
                     json_number(job->report.weight_change));
}

static void set_effects(json_t *root, const struct effect_job *job)
{
    const struct effect_params *p = &job->params;
    char kernel[KERNELS_TEXT] = "box";
    if (p->effects & EFFECT_ANTIALIAS) {
        if (job->filter.info)
            weft_kernel_format(&job->filter, kernel, sizeof kernel);
        json_object_set_new(root, "filter",
                            json_pack("{s:o,s:o}", "kernel", json_text(kernel), "width",
                                      json_number(job->plan.set[EFFECT_PIXEL].size)));
    }
    if (p->effects & EFFECT_MOTION_BLUR)
        json_object_set_new(
            root, "shutter",
            json_text(job->option[ASK_SHUTTER].given ? job->option[ASK_SHUTTER].text : "box"));
    if (p->effects & EFFECT_DOF)
        json_object_set_new(
            root, "lens",
            json_pack("{s:o,s:o,s:{s:o,s:o},s:{s:o,s:o}}", "aperture",
                      json_number(job->plan.aperture), "focus", json_number(job->plan.focus),
                      "nearest", "depth", json_number(job->depth[0]), "circle",
                      json_number(job->circle[0]), "farthest", "depth", json_number(job->depth[1]),
                      "circle", json_number(job->circle[1])));
    if (p->effects & EFFECT_RADIOSITY)
        json_object_set_new(root, "radiosity",
                            json_pack("{s:o,s:o,s:o,s:o,s:o,s:o}", "lights",
                                      json_count((uint64_t)job->plan.count), "paths",
                                      json_count((uint64_t)job->plan.paths), "mean_reflectance",
                                      json_number(job->plan.mean_reflectance), "clamp",
                                      json_number(job->plan.clamp), "lost_share",
                                      job->lost.frames ? json_number(job->lost.share) : json_null(),
                                      "lost_frames", json_count((uint64_t)job->lost.frames)));
}

static json_t *seconds_json(const struct effect_job *job)
{
    const struct effect_seconds *s = &job->seconds;
    const struct run_stage stages[] = {
        {"scene", s->scene},     {"plan", s->plan},     {"context", s->context},
        {"prepare", s->prepare}, {"draw", s->draw},     {"judge", s->judge},
        {"lost", s->lost},       {"result", s->result}, {"write", s->write},
    };
    return run_report_seconds(stages, sizeof stages / sizeof *stages,
                              report_now_seconds() - job->start);
}

static void set_outputs(json_t *root, const struct effect_job *job)
{
    const struct option_value *o = job->option;
    if (o[ASK_OUTPUT].given)
        json_object_set_new(root, "file", saved_json(&job->mean.saved));
    if (o[ASK_STDERR].given)
        json_object_set_new(root, "stderr_file", saved_json(&job->error.saved));
    if (o[ASK_PREVIEW].given)
        json_object_set_new(root, "preview",
                            run_report_preview(o[ASK_PREVIEW].text, job->preview_range));
}

static void set_results(json_t *root, const struct effect_job *job)
{
    const struct accumulation_stop stop = effect_job_stop(job);
    json_object_update_new(
        root, json_pack("{s:o,s:o,s:o,s:o,s:o}", "channels", picture_json(job->statistics),
                        "context", run_report_context(job->context), "bytes",
                        run_report_bytes("held", job->report.bytes), "seconds", seconds_json(job),
                        "frames_per_second", json_number((double)job->added / job->seconds.draw)));
    if (job->shadow.faces)
        json_object_set_new(root, "shadow", scene_options_shadow_json(&job->shadow));
    json_t *ranks = rank_frames_json(&job->divided.report);
    if (ranks)
        json_object_set_new(root, "ranks", ranks);
    if (job->option[ASK_UNTIL].given)
        json_object_set_new(root, "until", accumulation_stop_json(&stop));
    set_outputs(root, job);
}

enum weft_result effect_job_print_json(const struct effect_job *job)
{
    const bool explain = job->option[ASK_EXPLAIN].given;
    const struct weft_accumulator_report *method = explain ? &job->planned : &job->report;
    const struct effect_plan *plan = &job->plan;
    json_t *root =
        json_pack("{s:o,s:o,s:i,s:i,s:o,s:o,s:o,s:o,s:o,s:o,s:b,s:o,s:o,s:o,s:o}", "effects",
                  effects_json(job), "scenes", scenes_json(job), "width", plan->size[0], "height",
                  plan->size[1], "seed", json_count(job->params.seed), "frames",
                  json_count((uint64_t)plan->count), "added", json_count((uint64_t)job->added),
                  "needed", json_count((uint64_t)plan->needed), "needs", needs_json(job), "sets",
                  sets_json(job), "extends", plan->extends, "time",
                  json_numbers(job->params.time, 2), "weights", weights_json(job), "method",
                  accumulation_json(method), "bound", json_number(method->bound));
    set_effects(root, job);
    if (!explain)
        set_results(root, job);
    return json_print(root);
}
