// SPDX-License-Identifier: BSD-3-Clause
// What a finished resampling tells: EXR attributes, JSON, text.
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tools/methods/candidates.h"
#include "tools/options/kernels.h"
#include "tools/common/paths.h"
#include "tools/common/report.h"
#include "tools/common/run_report.h"
#include "tools/ranks/load_report.h"
#include "tools/resample/job.h"
#include "tools/options/saved.h"

static const weft_pass_plan *first_plan(const struct resample_job *job)
{
    return job->single ? job->single : job->together;
}

static const char *method_name(const struct resample_job *job)
{
    if (job->warp.is)
        return "warp";
    return weft_algorithm_names[job->separable ? WEFT_ALGORITHM_SEPARABLE
                                               : WEFT_ALGORITHM_MULTIPASS];
}

// Rather than OpenGL, or passes that are emulated.
static bool ran_on_cpu(const struct resample_job *job)
{
    return job->warp.is ? job->engine.engine == WEFT_ENGINE_CPU
                        : job->separable &&
                              weft_resample_plan_get_info(job->plan[0])->engine == WEFT_ENGINE_CPU;
}

// ---- EXR attributes -----------------------------------------------------------------------------

// "R 0,1; G 0,0.5": of as many groups as fit.
static void add_list(const struct resample_job *job, struct weft_metadata *list, size_t *count,
                     const char *key, bool ranges)
{
    run_report_add(list, count, key, "%s", "");
    char *value = list[*count - 1].value;
    size_t used = 0;
    for (size_t g = 0; g < job->group_count; g++) {
        const struct resample_group *group = &job->group[g];
        const char *separator = g ? "; " : "";
        char name[300], one[400];
        resample_group_name(job, group, name, sizeof name);
        const int size =
            ranges ? snprintf(one, sizeof one, "%s%s %.9g,%.9g", separator, name,
                              group->statistics.low, group->statistics.high)
                   : snprintf(one, sizeof one, "%s%s %.3g", separator, name, group->bound.total);
        if (used + (size_t)size + sizeof "; ..." > sizeof list->value) {
            strcpy(value + used, &"; ..."[used ? 0 : 2]);
            return;
        }
        memcpy(value + used, one, (size_t)size + 1);
        used += (size_t)size;
    }
}

size_t resample_attributes(const struct resample_job *job,
                           struct weft_metadata out[RESAMPLE_ATTRIBUTES])
{
    char kernel[KERNELS_TEXT], summary[PASS_TEXT];
    size_t count = 0;
    weft_kernel_format(&job->kernel, kernel, sizeof kernel);
    run_report_add(out, &count, "version", "%s", weft_version());
    run_report_add(out, &count, "image", "%s", paths_base_name(job->input));
    run_report_add(out, &count, "kernel", "%s", kernel);
    run_report_add(out, &count, "size", "%dx%d from %dx%d", job->result.width, job->result.height,
                   job->image.width, job->image.height);
    if (job->boundary != WEFT_BOUNDARY_CLAMP)
        run_report_add(out, &count, "boundary", "%s", job->option[RESAMPLE_BOUNDARY].text);
    if (resample_is_unstretched(job))
        run_report_add(out, &count, "antialias", "off");
    if (job->option[RESAMPLE_CLAMP].given)
        run_report_add(out, &count, "clamp", "on");
    run_report_add(out, &count, "method", "%s", method_name(job));
    if (job->warp.is) {
        char map[256];
        resample_warp_text(job, map, sizeof map);
        run_report_add(out, &count, "map", "%s", map);
    } else if (!job->separable) {
        const struct weft_pass_plan_info *plan = weft_pass_plan_get_info(first_plan(job));
        run_report_add(out, &count, "profile", "%s", plan->profile.name);
        run_report_add(out, &count, "technique", "%s", weft_technique_names[plan->technique]);
        run_report_add(out, &count, "plan", "%s", pass_plan_summary(first_plan(job), summary));
    }
    if (job->option[RESAMPLE_MAX_ERROR].given)
        run_report_add(out, &count, "max_error", "%s", job->option[RESAMPLE_MAX_ERROR].text);
    add_list(job, out, &count, "source_range", true);
    add_list(job, out, &count, "bound", false);
    if (!ran_on_cpu(job)) {
        run_report_add_renderer(out, &count, job->context);
        return count;
    }
    run_report_add_renderer(out, &count, NULL);
    return count + engine_attributes(&job->engine,
                                     job->warp.is ? job->engine.sums
                                                  : weft_resample_plan_get_info(job->plan[0])->sums,
                                     out + count);
}

// ---- JSON ---------------------------------------------------------------------------------------

static json_t *names_json(const struct resample_job *job, const struct resample_group *group)
{
    json_t *names = json_array();
    for (int c = 0; c < group->count; c++)
        json_array_append_new(names, json_text(job->result.channels[group->channel[c]].name));
    return names;
}

static json_t *error_json(const struct resample_job *job, const struct resample_group *group)
{
    const struct weft_verify_report *e = &group->error;
    json_t *error = run_report_verify_error(e, (const int32_t[]){e->at_x, e->at_y}, 2);
    json_object_set_new(error, "channel",
                        json_text(job->result.channels[group->channel[e->at_channel]].name));
    return error;
}

// Without ranges and errors when only explained.
static json_t *groups_json(const struct resample_job *job)
{
    json_t *groups = json_array();
    for (size_t g = 0; g < job->group_count; g++) {
        const struct resample_group *group = &job->group[g];
        const struct weft_resample_statistics *of = &group->statistics;
        json_t *one = json_pack("{s:o}", "channels", names_json(job, group));
        json_array_append_new(groups, one);
        if (job->option[RESAMPLE_EXPLAIN].given)
            continue;
        json_object_update_new(
            one, json_pack("{s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o}", "low", json_number(of->low),
                           "high", json_number(of->high), "sample_low", json_number(of->sample_low),
                           "sample_high", json_number(of->sample_high), "clamped",
                           json_count(of->clamped), "minimum", json_number(group->minimum),
                           "maximum", json_number(group->maximum), "not_finite",
                           json_count(group->not_finite), "bound", json_number(group->bound.total),
                           "bound_parts", pass_bound_json(&group->bound)));
        json_object_set_new(one, "e1", json_number(group->e1));
        if (job->option[RESAMPLE_MAX_ERROR].given)
            json_object_set_new(one, "max_error", json_number(group->max_error));
        if (job->option[RESAMPLE_VERIFY].given)
            json_object_set_new(one, "error", error_json(job, group));
    }
    return groups;
}

static json_t *windows_json(const struct weft_image *image)
{
    return json_pack("{s:i,s:i,s:i,s:i,s:o,s:o}", "x", image->x, "y", image->y, "width",
                     image->width, "height", image->height, "display_min",
                     json_counts(image->display_min, 2), "display_max",
                     json_counts(image->display_max, 2));
}

static json_t *separable_json(const struct resample_job *job)
{
    const struct weft_resample_work *r = &job->work;
    const struct weft_resample_info *info = weft_resample_plan_get_info(job->plan[0]);
    json_t *object =
        json_pack("{s:o,s:[o,o]}", "relative_bound", json_number(info->bound.relative), "stretch",
                  json_number(info->stretch[0]), json_number(info->stretch[1]));
    if (!job->option[RESAMPLE_EXPLAIN].given)
        json_object_update_new(
            object,
            json_pack("{s:i,s:o,s:i,s:{s:o,s:o}}", "first_axis", r->first_axis, "fetches_per_pixel",
                      json_number(r->fetches_per_pixel), "passes", r->draws, "bytes", "uploaded",
                      json_count(r->uploaded_bytes), "peak", json_count(r->peak_bytes)));
    return object;
}

static bool has_choices(const struct resample_job *job)
{
    return job->choices[0].count + job->choices[1].count > 0;
}

static json_t *choices_json(const struct resample_job *job)
{
    json_t *list = json_array();
    for (int i = 0; i < 2; i++) {
        for (size_t k = 0; k < job->choices[i].count; k++) {
            json_t *candidate = candidate_json(&job->choices[i].candidates[k]);
            json_object_set_new(candidate, "channels", json_integer(i ? RESAMPLE_MAX_TOGETHER : 1));
            json_array_append_new(list, candidate);
        }
    }
    return list;
}

static double mpixels_per_second(const struct resample_job *job)
{
    return 1e-6 * (double)job->result.width * (double)job->result.height *
           (double)job->group_count / job->work.pass_seconds;
}

static json_t *seconds_json(const struct resample_job *job)
{
    const struct weft_resample_work *r = &job->work;
    const struct run_stage stages[] = {
        {"load", job->load_seconds},       {"plan", job->plan_seconds},
        {"context", job->context_seconds}, {"prepare", r->prepare_seconds},
        {"upload", r->upload_seconds},     {"passes", r->pass_seconds},
        {"readback", r->readback_seconds}, {"verify", job->verify_seconds},
        {"write", job->write_seconds},
    };
    return run_report_seconds(stages, sizeof stages / sizeof *stages,
                              report_now_seconds() - job->start);
}

static void set_context(json_t *root, const struct resample_job *job)
{
    json_object_set_new(root, "emulated",
                        json_boolean(!job->context && !job->separable && !job->warp.is));
    json_object_set_new(root, "context", run_report_context(ran_on_cpu(job) ? NULL : job->context));
}

static void set_run(json_t *root, const struct resample_job *job)
{
    const struct weft_resample_work *r = &job->work;
    json_object_update_new(
        root, json_pack("{s:i,s:{s:o,s:o,s:o,s:o},s:o,s:o}", "tiles_run", r->tiles, "bytes",
                        "source", json_count(r->source_bytes), "tiles", json_count(r->tile_bytes),
                        "targets", json_count(r->target_bytes), "positions",
                        json_count(r->position_bytes), "seconds", seconds_json(job),
                        "mpixels_per_second", json_number(mpixels_per_second(job))));
    set_context(root, job);
    json_t *ranks = load_report_json(&job->divided.work, true);
    if (ranks)
        json_object_set_new(root, "ranks", ranks);
    if (!job->context && !job->separable && !job->warp.is)
        json_object_update_new(root, json_pack("{s:o,s:o}", "clamps", json_count(r->clamps),
                                               "largest_clamp", json_number(r->largest_clamp)));
    if (job->option[RESAMPLE_PREVIEW].given)
        json_object_set_new(
            root, "preview",
            run_report_preview(job->option[RESAMPLE_PREVIEW].text, job->preview_range));
    if (job->errors.plane)
        json_object_set_new(
            root, "error_image",
            run_report_preview(job->option[RESAMPLE_ERROR_IMAGE].text, job->errors_range));
}

static json_t *job_json(const struct resample_job *job)
{
    char kernel[KERNELS_TEXT];
    json_t *plans = json_array();
    weft_kernel_format(&job->kernel, kernel, sizeof kernel);
    if (job->single)
        json_array_append_new(plans, pass_plan_json(job->single));
    if (job->together)
        json_array_append_new(plans, pass_plan_json(job->together));
    json_t *root =
        json_pack("{s:s,s:o,s:o,s:o,s:o,s:o}", "method", method_name(job), "kernel",
                  json_text(kernel), "from", windows_json(&job->image), "to",
                  windows_json(&job->result), "plans", plans, "groups", groups_json(job));
    if (job->warp.is) {
        engine_set_json(root, &job->engine, job->engine.engine, job->engine.sums);
        json_object_set_new(root, "warp", resample_warp_json(job));
    }
    if (job->separable) {
        const struct weft_resample_info *info = weft_resample_plan_get_info(job->plan[0]);
        engine_set_json(root, &job->engine, info->engine, info->sums);
        json_object_set_new(root, "separable", separable_json(job));
    }
    json_object_update_new(root,
                           json_pack("{s:s,s:b}", "boundary", weft_boundary_names[job->boundary],
                                     "clamp", job->option[RESAMPLE_CLAMP].given));
    if (job->boundary == WEFT_BOUNDARY_BORDER)
        json_object_set_new(root, "border", json_number(job->border));
    if (has_choices(job))
        json_object_set_new(root, "choices", choices_json(job));
    if (job->kernel.prefiltered && job->group->source && !job->warp.is)
        json_object_set_new(root, "prefilter_overlap",
                            json_integer(weft_resample_plan_get_info(job->group->plan)->overlap));
    if (!job->option[RESAMPLE_EXPLAIN].given)
        set_run(root, job);
    return root;
}

enum weft_result resample_print_json(const struct resample_job *jobs, size_t count)
{
    json_t *root = count == 1 ? job_json(jobs) : json_object();
    json_t *parts = count > 1 ? json_array() : NULL;
    for (size_t i = 0; count > 1 && i < count; i++) {
        json_t *part = job_json(&jobs[i]);
        json_object_set_new(part, "name", json_text(jobs[i].image.name));
        json_array_append_new(parts, part);
    }
    if (count > 1)
        json_object_set_new(root, "parts", parts);
    if (jobs->saved.values)
        json_object_set_new(root, "file", saved_json(&jobs->saved));
    return json_print(root);
}

// ---- text ---------------------------------------------------------------------------------------

void resample_print_choices(const struct resample_job *job)
{
    for (int i = 0; i < 2; i++) {
        const struct weft_resample_choice *choice = &job->choices[i];
        if (!choice->count)
            continue;
        if (job->separable)
            puts("one axis after the other:");
        else
            printf("passes for %d channel%s at once, of which %d were planned:\n",
                   i ? RESAMPLE_MAX_TOGETHER : 1, i ? "s" : "", choice->planned);
        candidates_print(choice->candidates, choice->count,
                         job->separable ? "bound/max-error" : "bound/range");
    }
}

static void explain_budget(const struct resample_job *job)
{
    for (size_t g = 0; g < job->group_count; g++) {
        const struct resample_group *group = &job->group[g];
        char name[300];
        resample_group_name(job, group, name, sizeof name);
        const struct weft_resample_statistics *of = &group->statistics;
        const struct weft_bound bound = resample_group_bound(group, 0.0);
        printf("%s: samples from %.9g to %.9g; bound %.3g, --max-error %.3g, E1 %.3g\n", name,
               of->sample_low, of->sample_high, bound.total, group->max_error, group->e1);
    }
}

static void explain(const struct resample_job *job)
{
    char file[300];
    snprintf(file, sizeof file, "%s", paths_base_name(job->input));
    printf("resample %s: %d x %d -> %d x %d, channels", weft_text_clean(file, false),
           job->image.width, job->image.height, job->result.width, job->result.height);
    for (size_t g = 0; g < job->group_count; g++) {
        char name[300];
        resample_group_name(job, &job->group[g], name, sizeof name);
        printf("%s %s", g ? "," : "", name);
    }
    putchar('\n');
    if (job->warp.is) {
        char engine[ENGINE_TEXT];
        printf("%s\n", engine_format(&job->engine, job->engine.engine, job->engine.sums, engine));
        fputs(weft_warp_plan_get_info(job->warp.plan)->text, stdout);
    }
    if (job->separable) {
        const struct weft_resample_info *info = weft_resample_plan_get_info(job->plan[0]);
        char engine[ENGINE_TEXT];
        printf("%s\n", engine_format(&job->engine, info->engine, info->sums, engine));
        fputs(info->text, stdout);
    }
    if (job->option[RESAMPLE_MAX_ERROR].given)
        explain_budget(job);
    resample_print_choices(job);
    if (job->single)
        pass_plan_print(job->single);
    if (job->together)
        pass_plan_print(job->together);
}

static void print_error(const struct resample_job *job, const struct resample_group *group)
{
    const struct weft_verify_report *e = &group->error;
    char name[300], bound[PASS_TEXT];
    resample_group_name(job, group, name, sizeof name);
    printf("%s: max error %.3g at pixel (%d, %d), rms %.3g; bound %s, for samples from %.9g to "
           "%.9g; E1 %.3g\n",
           name, e->maximum, e->at_x, e->at_y, e->rms, pass_bound_format(&group->bound, bound),
           group->statistics.sample_low, group->statistics.sample_high, group->e1);
    if (e->not_finite_mismatches)
        printf("%s: finite on one side only: %llu values\n", name,
               (unsigned long long)e->not_finite_mismatches);
}

static void note_times(const struct resample_job *job)
{
    const struct weft_resample_work *r = &job->work;
    report_note("load %.3f s, plan %.3f, context %.3f, prepare %.3f, upload %.3f, passes %.3f "
                "(%.1f Mpixel/s), read-back %.3f, verify %.3f, write %.3f, total %.3f s",
                job->load_seconds, job->plan_seconds, job->context_seconds, r->prepare_seconds,
                r->upload_seconds, r->pass_seconds, mpixels_per_second(job), r->readback_seconds,
                job->verify_seconds, job->write_seconds, report_now_seconds() - job->start);
    for (size_t g = 0; g < job->group_count; g++) {
        char name[300];
        resample_group_name(job, &job->group[g], name, sizeof name);
        report_note("%s: samples from %.9g to %.9g, pixels from %.9g to %.9g, %llu not finite",
                    name, job->group[g].statistics.sample_low, job->group[g].statistics.sample_high,
                    job->group[g].minimum, job->group[g].maximum,
                    (unsigned long long)job->group[g].not_finite);
    }
}

void resample_print_text(const struct resample_job *job)
{
    if (job->option[RESAMPLE_EXPLAIN].given) {
        explain(job);
        return;
    }
    if (job->option[RESAMPLE_PREVIEW].given)
        run_report_print_preview(job->option[RESAMPLE_PREVIEW].text, job->preview_range);
    if (job->errors.plane)
        run_report_print_preview(job->option[RESAMPLE_ERROR_IMAGE].text, job->errors_range);
    for (size_t g = 0; job->option[RESAMPLE_VERIFY].given && g < job->group_count; g++)
        print_error(job, &job->group[g]);
    note_times(job);
}
