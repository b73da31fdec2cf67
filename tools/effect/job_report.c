// SPDX-License-Identifier: BSD-3-Clause
// What `weft effect` tells in words: attributes, the plan, what came of it.
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tools/common/paths.h"
#include "tools/common/report.h"
#include "tools/common/run_report.h"
#include "tools/effect/job.h"

static bool has(const struct effect_job *job, enum effect_bit effect)
{
    return job->params.effects & effect;
}

// The names of all scenes, without folders.
static void name_scenes(const struct effect_job *job, char text[EFFECT_TEXT])
{
    *text = 0;
    for (int i = 0; i < job->scene_count; i++) {
        const size_t used = strlen(text);
        snprintf(text + used, EFFECT_TEXT - used, "%s%s", i ? ", " : "",
                 paths_base_name(job->scene[i].name));
    }
    weft_text_clean(text, false);
}

static const char *filter_text(const struct effect_job *job, char text[KERNELS_TEXT])
{
    if (job->filter.info)
        weft_kernel_format(&job->filter, text, KERNELS_TEXT);
    else
        snprintf(text, KERNELS_TEXT, "box");
    return text;
}

static const char *shutter_text(const struct effect_job *job)
{
    const struct option_value *o = &job->option[ASK_SHUTTER];
    return o->given ? o->text : "box";
}

// ---- attributes ---------------------------------------------------------------------------------

static void add_set(const struct effect_job *job, struct weft_metadata *out, size_t *count)
{
    for (int i = 0; i < EFFECT_PLACE_COUNT; i++) {
        const struct effect_set *set = &job->plan.set[i];
        char key[32];
        if (!set->info)
            continue;
        snprintf(key, sizeof key, "jitter_%s", effect_place_names[i]);
        run_report_add(out, count, key, "%s, %d points, D %.5g, mean %.6g %.6g", set->info->name,
                       set->count, set->discrepancy, set->mean[0], set->mean[1]);
    }
}

static void add_effects(const struct effect_job *job, struct weft_metadata *out, size_t *count)
{
    const struct effect_params *p = &job->params;
    char kernel[KERNELS_TEXT];
    if (has(job, EFFECT_ANTIALIAS)) {
        run_report_add(out, count, "filter", "%.180s", filter_text(job, kernel));
        run_report_add(out, count, "filter_width", "%.9g", job->plan.set[EFFECT_PIXEL].size);
    }
    if (has(job, EFFECT_MOTION_BLUR))
        run_report_add(out, count, "shutter", "%s", shutter_text(job));
    run_report_add(out, count, "time", "%.9g %.9g", p->time[0], p->time[1]);
    if (has(job, EFFECT_DOF)) {
        run_report_add(out, count, "aperture", "%.9g", job->plan.aperture);
        run_report_add(out, count, "focus", "%.9g", job->plan.focus);
    }
    if (has(job, EFFECT_RADIOSITY)) {
        run_report_add(out, count, "paths", "%lld", (long long)job->plan.paths);
        run_report_add(out, count, "clamp", "%.9g", job->plan.clamp);
        if (job->lost.frames)
            run_report_add(out, count, "lost", "%.5g", job->lost.share);
    }
    if (job->shadow.faces)
        run_report_add(out, count, "shadow", "%d x %d texels, %d faces, bias %.5g",
                       job->shadow.size, job->shadow.size, job->shadow.faces, job->shadow.bias);
}

size_t effect_job_attributes(const struct effect_job *job, const char *what,
                             struct weft_metadata out[PICTURE_ATTRIBUTES])
{
    const struct weft_accumulator_report *r = &job->report;
    char text[EFFECT_TEXT];
    size_t count = 0;
    run_report_add(out, &count, "version", "%s", weft_version());
    if (what)
        run_report_add(out, &count, "what", "%s", what);
    run_report_add(out, &count, "effect", "%s", job->operands[0]);
    name_scenes(job, text);
    run_report_add(out, &count, "scene", "%s", text);
    run_report_add(out, &count, "frames", "%lld", (long long)job->added);
    run_report_add(out, &count, "seed", "%llu", (unsigned long long)job->params.seed);
    add_set(job, out, &count);
    add_effects(job, out, &count);
    if (has(job, EFFECT_FADE) && job->option[ASK_WEIGHTS].given)
        run_report_add(out, &count, "weights", "%.180s", job->option[ASK_WEIGHTS].text);
    if (has(job, EFFECT_FADE) && job->option[ASK_AT].given)
        run_report_add(out, &count, "at", "%s", job->option[ASK_AT].text);
    run_report_add(out, &count, "method", "%s",
                   accumulation_format(&job->option[ASK_ADDING], r, text));
    if (isfinite(r->bound))
        run_report_add(out, &count, "bound", "%.9g", r->bound);
    if (job->option[ASK_UNTIL].given)
        run_report_add(out, &count, "until", "%s", job->option[ASK_UNTIL].text);
    run_report_add_renderer(out, &count, job->context);
    return count;
}

// ---- the plan -----------------------------------------------------------------------------------

// A line of its own: on standard output, or as a message.
typedef void (*line)(const char *format, ...) __attribute__((format(printf, 1, 2)));

static const char *figure_text(int effect)
{
    switch (1 << effect) {
    case EFFECT_MOTION_BLUR:
        return "of motion";
    case EFFECT_DOF:
        return "across the widest circle of confusion";
    case EFFECT_SOFT_SHADOW:
        return "across the widest penumbra";
    default:
        return NULL;
    }
}

static void tell_frames(const struct effect_job *job, line tell)
{
    const struct effect_plan *plan = &job->plan;
    const struct option_value *o = job->option;
    const bool asked = o[ASK_PATHS].given || job->params.frames > 0;
    char scenes[EFFECT_TEXT];
    name_scenes(job, scenes);
    tell("%s of %s, %d x %d: %lld frame%s, %s", job->operands[0], scenes, plan->size[0],
         plan->size[1], (long long)plan->count, plan->count == 1 ? "" : "s",
         o[ASK_PATHS].given ? "for the paths asked for"
         : asked            ? "as asked for"
                            : "as the picture needs");
    for (int i = 0; i < EFFECT_COUNT; i++) {
        const struct effect_need *need = &plan->need[i];
        if (need->frames && figure_text(i))
            tell("  %s needs %lld: %.1f pixels %s", effect_names[i], (long long)need->frames,
                 need->figure, figure_text(i));
        else if (need->frames && 1 << i == EFFECT_ANTIALIAS)
            tell("  antialias needs %lld: %d for each pixel of its filter's area",
                 (long long)need->frames, EFFECT_FRAMES_ANTIALIAS);
        else if (need->frames)
            tell("  %s needs %lld, by default", effect_names[i], (long long)need->frames);
    }
}

static void tell_sets(const struct effect_job *job, line tell)
{
    for (int i = 0; i < EFFECT_PLACE_COUNT; i++) {
        const struct effect_set *set = &job->plan.set[i];
        char discrepancy[64] = "discrepancy not computed of so many";
        if (!set->info)
            continue;
        if (!isnan(set->discrepancy))
            snprintf(discrepancy, sizeof discrepancy, "discrepancy %.4f", set->discrepancy);
        tell("%s: %s of %d points on a %s of %.6g: %s; mean (%.3g, %.3g), centred by (%.3g, %.3g)",
             effect_place_names[i], set->info->name, set->count,
             weft_jitter_shape_names[set->shape], set->size, discrepancy, set->mean[0],
             set->mean[1], set->shift[0], set->shift[1]);
    }
    if (!job->plan.extends && job->plan.count > job->scene_count)
        tell("  the first frames are chosen from all at random");
}

static void tell_weights(const struct effect_job *job, line tell)
{
    const struct weft_weights_report *w = &job->plan.weights;
    tell("weights: the largest is %.4g, %.3g %% are negative, as good as %.1f even ones",
         w->largest, 100.0 * w->negative, w->effective);
}

static void tell_effects(const struct effect_job *job, line tell)
{
    const struct effect_params *p = &job->params;
    char kernel[KERNELS_TEXT];
    if (has(job, EFFECT_ANTIALIAS))
        tell("filter: %.180s, %.4g pixels wide", filter_text(job, kernel),
             job->plan.set[EFFECT_PIXEL].size);
    if (has(job, EFFECT_MOTION_BLUR))
        tell("shutter: %s, open from %g to %g", shutter_text(job), p->time[0], p->time[1]);
    if (has(job, EFFECT_DOF))
        tell("lens: aperture %.6g, focus %.6g; circle of confusion %.1f pixels at depth %.4g, the "
             "nearest, and %.1f at %.4g, the farthest",
             job->plan.aperture, job->plan.focus, job->circle[0], job->depth[0], job->circle[1],
             job->depth[1]);
    if (has(job, EFFECT_RADIOSITY))
        tell("radiosity: %lld virtual lights on %lld paths, mean reflectance %.4f, clamped to a "
             "factor of %.4g (0: not)",
             (long long)job->plan.count, (long long)job->plan.paths, job->plan.mean_reflectance,
             job->plan.clamp);
}

static void tell_plan(const struct effect_job *job, line tell)
{
    tell_frames(job, tell);
    tell_sets(job, tell);
    tell_effects(job, tell);
    tell_weights(job, tell);
}

void effect_job_explain(const struct effect_job *job)
{
    const size_t pixels = (size_t)job->params.size[0] * (size_t)job->params.size[1];
    tell_plan(job, report_line);
    accumulation_explain(&job->option[ASK_ADDING], &job->planned);
    const int textures =
        accumulation_explain_passes(&job->how, job->planned.method, 1, job->plan.count);
    // Exact sums are of 128 bits a value, a stack's textures of RGBA.
    const double bytes =
        (double)job->planned.bytes +
        (job->planned.method == WEFT_ACCUMULATE_EXACT ? 64.0 * (double)pixels : 0.0) +
        textures * (double)pixels * 4.0 * job->planned.bits / 8.0;
    printf("memory: about %.3g MB of sums\n", 1e-6 * bytes);
}

// ---- what came of it ----------------------------------------------------------------------------

struct accumulation_stop effect_job_stop(const struct effect_job *job)
{
    return (struct accumulation_stop){.asked = job->option[ASK_UNTIL].text,
                                      .frames = job->added,
                                      .planned = job->plan.count,
                                      .judged = job->judged,
                                      .stopped = job->stopped,
                                      .convergence = job->convergence};
}

static void note_times(const struct effect_job *job)
{
    const struct effect_seconds *s = &job->seconds;
    report_note("scene %.3f s, plan %.3f, context %.3f, prepare %.3f, draw %.3f, judge %.3f, lost "
                "%.3f, result %.3f, write %.3f, total %.3f s",
                s->scene, s->plan, s->context, s->prepare, s->draw, s->judge, s->lost, s->result,
                s->write, report_now_seconds() - job->start);
    report_note("method %s: %s; bound %.3g, %d textures, %llu bytes, %llu passes",
                weft_accumulate_method_names[job->report.method], job->report.why,
                job->report.bound, job->report.textures, (unsigned long long)job->report.bytes,
                (unsigned long long)job->report.passes);
    if (job->shadow.faces)
        report_note("shadows: %d faces of %d x %d texels, bias %.3g, %llu bytes", job->shadow.faces,
                    job->shadow.size, job->shadow.size, job->shadow.bias,
                    (unsigned long long)job->shadow.bytes);
}

static void print_summary(const struct effect_job *job)
{
    char scenes[EFFECT_TEXT], method[ACCUMULATION_TEXT];
    name_scenes(job, scenes);
    report_line("%s of %s: %lld frame%s, %s, %.1f a second", job->operands[0], scenes,
                (long long)job->added, job->added == 1 ? "" : "s",
                accumulation_format(&job->option[ASK_ADDING], &job->report, method),
                (double)job->added / job->seconds.draw);
    if (has(job, EFFECT_DOF))
        report_line("lens: aperture %.6g, focus %.6g; circles of confusion up to %.1f pixels",
                    job->plan.aperture, job->plan.focus, fmax(job->circle[0], job->circle[1]));
    if (job->lost.frames)
        report_line("clamping to a factor of %.4g took %.2f %% of the light", job->plan.clamp,
                    100.0 * job->lost.share);
}

void effect_job_print_text(const struct effect_job *job)
{
    const struct option_value *o = job->option;
    const struct accumulation_stop stop = effect_job_stop(job);
    if (o[ASK_UNTIL].given)
        accumulation_tell_stop(&stop);
    if (o[ASK_JSON].given)
        return;
    if (!report_is_quiet())
        print_summary(job);
    if (o[ASK_PREVIEW].given)
        run_report_print_preview(o[ASK_PREVIEW].text, job->preview_range);
    rank_frames_print(&job->divided.report);
    tell_plan(job, report_note);
    note_times(job);
}
