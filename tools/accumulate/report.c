// SPDX-License-Identifier: BSD-3-Clause
// What `weft accumulate` tells: attributes, JSON, text.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/accumulate/job.h"
#include "tools/common/paths.h"
#include "tools/common/report.h"
#include "tools/common/run_report.h"
#include "tools/options/saved.h"

static bool is_given(const struct accumulate_job *job, enum accumulate_option option)
{
    return job->option[option].given;
}

static struct accumulation_stop stop_of(const struct accumulate_job *job)
{
    return (struct accumulation_stop){.asked = job->option[ACCUMULATE_UNTIL].text,
                                      .frames = job->added,
                                      .planned = job->counting,
                                      .judged = job->judged,
                                      .stopped = job->stopped,
                                      .convergence = job->convergence};
}

// ---- attributes ---------------------------------------------------------------------------------

size_t accumulate_attributes(const struct accumulate_job *job, const char *what,
                             struct weft_metadata out[ACCUMULATE_ATTRIBUTES])
{
    const struct weft_accumulator_report *r = &job->report;
    char text[ACCUMULATE_TEXT];
    size_t count = 0;
    run_report_add(out, &count, "version", "%s", weft_version());
    if (what)
        run_report_add(out, &count, "what", "%s", what);
    run_report_add(out, &count, "method", "%s",
                   accumulation_format(&job->option[ACCUMULATE_ADDING], r, text));
    run_report_add(out, &count, "frames", "%lld", (long long)job->added);
    run_report_add(out, &count, "first_frame", "%s", paths_base_name(job->frame[job->first].path));
    if (job->skipped)
        run_report_add(out, &count, "skipped", "%lld", (long long)job->skipped);
    run_report_add(out, &count, "weights", "%.180s", job->weights.text);
    run_report_add(out, &count, "total_weight", "%.17g", r->total_weight);
    if (isfinite(r->bound))
        run_report_add(out, &count, "bound", "%.9g", r->bound);
    if (job->transfer.curve != WEFT_CURVE_LINEAR)
        run_report_add(out, &count, "transfer", "%s",
                       accumulate_transfer_text(&job->transfer, text));
    if (is_given(job, ACCUMULATE_UNTIL))
        run_report_add(out, &count, "until", "%s", job->option[ACCUMULATE_UNTIL].text);
    if (job->planned.method != WEFT_ACCUMULATE_EXACT)
        run_report_add_renderer(out, &count, job->context);
    return count;
}

// ---- JSON ---------------------------------------------------------------------------------------

static const char *type_text(const struct accumulate_job *job, size_t c)
{
    const bool made = c < job->result.channel_count;
    return weft_pixel_type_names[made ? job->result.channels[c].type : job->image.channels[c].type];
}

static json_t *channels_json(const struct accumulate_job *job)
{
    json_t *list = json_array();
    for (size_t c = 0; c < job->image.channel_count; c++) {
        json_t *channel =
            json_pack("{s:o,s:s,s:b}", "name", json_text(job->image.channels[c].name), "type",
                      type_text(job, c), "averaged", job->channel[c].averaged >= 0);
        if (job->statistics)
            json_object_update_new(channel,
                                   json_pack("{s:o,s:o,s:o}", "minimum",
                                             json_number(job->statistics[c].minimum), "maximum",
                                             json_number(job->statistics[c].maximum), "not_finite",
                                             json_count(job->statistics[c].not_finite)));
        json_array_append_new(list, channel);
    }
    return list;
}

static json_t *skipped_json(const struct accumulate_job *job)
{
    json_t *list = json_array();
    for (int64_t i = 0; i < job->frame_count; i++)
        if (job->frame[i].problem)
            json_array_append_new(list, json_pack("{s:I,s:o,s:o}", "frame", (json_int_t)i, "path",
                                                  json_text(job->frame[i].path), "problem",
                                                  json_text(job->frame[i].problem)));
    return list;
}

static json_t *weights_json(const struct accumulate_job *job)
{
    json_t *object = json_pack(
        "{s:o,s:o,s:o,s:o,s:o}", "kind", json_text(job->weights.text), "total",
        json_number(job->weights.total), "least", json_number(job->weights.least), "largest",
        json_number(job->weights.largest), "change", json_number(job->report.weight_change));
    json_t *values = json_array();
    for (int64_t i = 0; i < job->frame_count && is_given(job, ACCUMULATE_WEIGHTS); i++)
        json_array_append_new(values, json_number(job->frame[i].weight));
    if (is_given(job, ACCUMULATE_WEIGHTS))
        json_object_set_new(object, "values", values);
    else
        json_decref(values);
    return object;
}

static json_t *seconds_json(const struct accumulate_job *job)
{
    const struct run_stage stages[] = {
        {"plan", job->plan_seconds},     {"context", job->context_seconds},
        {"read", job->read_seconds},     {"decode", job->decode_seconds},
        {"add", job->add_seconds},       {"judge", job->judge_seconds},
        {"result", job->result_seconds}, {"write", job->write_seconds},
    };
    return run_report_seconds(stages, sizeof stages / sizeof *stages,
                              report_now_seconds() - job->start);
}

// resumed: frames of earlier runs.
static json_t *state_json(const struct accumulate_job *job)
{
    const struct accumulate_kept *kept = &job->kept;
    const struct run_stage last = {"last", kept->saves ? kept->cost : 0.0};
    return json_pack("{s:[o],s:I,s:I,s:I,s:o}", "output",
                     json_file(job->option[ACCUMULATE_RESUME].text), "held", (json_int_t)kept->held,
                     "resumed", (json_int_t)kept->resumed, "saves", (json_int_t)kept->saves,
                     "seconds", run_report_seconds(&last, 1, kept->seconds));
}

static void set_outputs(json_t *root, const struct accumulate_job *job)
{
    const struct option_value *o = job->option;
    if (o[ACCUMULATE_OUTPUT].given)
        json_object_set_new(root, "file", saved_json(&job->saved));
    if (o[ACCUMULATE_STDERR].given)
        json_object_set_new(root, "stderr_file", saved_json(&job->error_saved));
    if (o[ACCUMULATE_RESUME].given) {
        json_object_set_new(root, "state", state_json(job));
        json_add_output(o[ACCUMULATE_RESUME].text);
    }
    if (o[ACCUMULATE_PREVIEW].given)
        json_object_set_new(root, "preview",
                            run_report_preview(o[ACCUMULATE_PREVIEW].text, job->preview_range));
}

enum weft_result accumulate_print_json(const struct accumulate_job *job)
{
    const bool explain = is_given(job, ACCUMULATE_EXPLAIN);
    const struct weft_accumulator_report *method = explain ? &job->planned : &job->report;
    const struct accumulation_stop stop = stop_of(job);
    char transfer[ACCUMULATE_TEXT];
    json_t *root = json_pack(
        "{s:I,s:I,s:I,s:I,s:o,s:s,s:i,s:i,s:o,s:o,s:o,s:o}", "frames", (json_int_t)job->frame_count,
        "counting", (json_int_t)job->counting, "added", (json_int_t)job->added, "skipped_count",
        (json_int_t)job->skipped, "skipped", skipped_json(job), "kind",
        weft_image_file_kind_names[job->kind], "width", job->image.width, "height",
        job->image.height, "channels", channels_json(job), "weights", weights_json(job), "method",
        accumulation_json(method), "bound", json_number(method->bound));
    if (!explain)
        json_object_update_new(
            root, json_pack("{s:o,s:o,s:o}", "transfer",
                            json_text(accumulate_transfer_text(&job->transfer, transfer)), "bytes",
                            run_report_bytes("held", method->bytes), "seconds", seconds_json(job)));
    if (!explain && is_given(job, ACCUMULATE_UNTIL))
        json_object_set_new(root, "until", accumulation_stop_json(&stop));
    json_t *ranks = rank_frames_json(&job->divided.report);
    if (ranks)
        json_object_set_new(root, "ranks", ranks);
    if (!explain)
        json_object_set_new(root, "context", run_report_context(job->context));
    if (!explain)
        set_outputs(root, job);
    return json_print(root);
}

// ---- text ---------------------------------------------------------------------------------------

static void explain_channels(const struct accumulate_job *job, bool averaged)
{
    const char *separator = "";
    for (size_t c = 0; c < job->image.channel_count; c++) {
        char name[256];
        if ((job->channel[c].averaged >= 0) != averaged)
            continue;
        snprintf(name, sizeof name, "%s", job->image.channels[c].name);
        printf("%s%s", separator, weft_text_clean(name, false));
        separator = ", ";
    }
    putchar('\n');
}

// Sums and stacks are made with the first frame: exact ones are of 128 bits for floats and of 64
// for others, and a stack has `textures` of RGBA.
static double planned_bytes(const struct accumulate_job *job, int textures)
{
    const double pixels = (double)job->image.width * (double)job->image.height;
    double bytes = (double)job->planned.bytes;
    for (size_t c = 0; job->planned.method == WEFT_ACCUMULATE_EXACT && c < job->image.channel_count;
         c++)
        if (job->channel[c].averaged >= 0)
            bytes += pixels * (job->kind == WEFT_IMAGE_FILE_EXR &&
                                       job->image.channels[c].type == WEFT_PIXEL_FLOAT
                                   ? 16.0
                                   : 8.0);
    return bytes + textures * pixels * 4.0 * job->planned.bits / 8.0;
}

static void explain_passes(const struct accumulate_job *job)
{
    const int textures = accumulation_explain_passes(&job->request.how, job->planned.method,
                                                     (job->averaged_count + 3) / 4, job->counting);
    printf("memory: about %.3g MB of sums, and up to %d MB of frames that are decoded ahead\n",
           1e-6 * planned_bytes(job, textures), ACCUMULATE_AHEAD_MB);
}

void accumulate_explain(const struct accumulate_job *job)
{
    report_line("accumulate %lld frames, from %s: %s, %d x %d", (long long)job->counting,
                job->frame[job->sequence[0]].path, weft_image_file_kind_names[job->kind],
                job->image.width, job->image.height);
    if (job->counting < job->frame_count)
        printf("not read: %lld frames of weight 0\n",
               (long long)(job->frame_count - job->counting));
    printf("averaged: ");
    explain_channels(job, true);
    if (job->averaged_count < (int)job->image.channel_count) {
        printf("copied from the first frame: ");
        explain_channels(job, false);
    }
    report_line("weights: %s, from %.9g to %.9g, in all %.9g", job->weights.text,
                job->weights.least, job->weights.largest, job->weights.total);
    accumulation_explain(&job->option[ACCUMULATE_ADDING], &job->planned);
    explain_passes(job);
}

static void note_times(const struct accumulate_job *job)
{
    report_note("plan %.3f s, context %.3f, read %.3f, decode %.3f, add %.3f, judge %.3f, result "
                "%.3f, write %.3f, total %.3f s: %.1f frames/s",
                job->plan_seconds, job->context_seconds, job->read_seconds, job->decode_seconds,
                job->add_seconds, job->judge_seconds, job->result_seconds, job->write_seconds,
                report_now_seconds() - job->start,
                (double)job->added / (report_now_seconds() - job->start));
    if (job->kept.saves)
        report_note("%s: saved %lld times in %.3f s, the last time in %.3f s",
                    job->option[ACCUMULATE_RESUME].text, (long long)job->kept.saves,
                    job->kept.seconds, job->kept.cost);
    report_note("method %s: %s; bound %.3g", weft_accumulate_method_names[job->report.method],
                job->report.why, job->report.bound);
}

void accumulate_print_text(const struct accumulate_job *job)
{
    const struct accumulation_stop stop = stop_of(job);
    if (is_given(job, ACCUMULATE_UNTIL))
        accumulation_tell_stop(&stop);
    if (is_given(job, ACCUMULATE_JSON))
        return;
    if (is_given(job, ACCUMULATE_PREVIEW))
        run_report_print_preview(job->option[ACCUMULATE_PREVIEW].text, job->preview_range);
    rank_frames_print(&job->divided.report);
    note_times(job);
}
