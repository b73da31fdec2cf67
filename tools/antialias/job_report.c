// SPDX-License-Identifier: BSD-3-Clause
// What `weft antialias` tells in words: attributes, the plan, what came of it.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/antialias/job.h"
#include "tools/common/paths.h"
#include "tools/common/report.h"
#include "tools/common/run_report.h"
#include "tools/ranks/load_report.h"

static bool is_supersampled(const struct antialias_job *job)
{
    return job->params.way == ANTIALIAS_ADAPTIVE || job->params.way == ANTIALIAS_SUPERSAMPLE;
}

const char *antialias_job_filter(const struct antialias_job *job, char text[KERNELS_TEXT])
{
    if (job->params.filter.info)
        weft_kernel_format(&job->params.filter, text, KERNELS_TEXT);
    else
        snprintf(text, KERNELS_TEXT, "box");
    return text;
}

static const char *scene_text(const struct antialias_job *job, char text[ANTIALIAS_TEXT])
{
    snprintf(text, ANTIALIAS_TEXT, "%s", paths_base_name(job->scene_name));
    return weft_text_clean(text, false);
}

static double filter_width(const struct antialias_job *job)
{
    const struct antialias_params *p = &job->params;
    return p->filter_width != 0.0 ? p->filter_width
           : p->filter.info       ? 2.0 * p->filter.support
                                  : 1.0;
}

// ---- times --------------------------------------------------------------------------------------

static int compare_seconds(const void *a, const void *b)
{
    const double *x = a, *y = b;
    return (*x > *y) - (*x < *y);
}

double antialias_job_median(const struct antialias_job *job)
{
    const size_t count = (size_t)job->drawn;
    double *sorted = malloc((count + 1) * sizeof *sorted);
    if (!sorted || count == 0) {
        free(sorted);
        return NAN;
    }
    memcpy(sorted, job->seconds_each, count * sizeof *sorted);
    qsort(sorted, count, sizeof *sorted, compare_seconds);
    const double median = 0.5 * (sorted[(count - 1) / 2] + sorted[count / 2]);
    free(sorted);
    return median;
}

// ---- attributes ---------------------------------------------------------------------------------

static void add_acaa(const struct antialias_job *job, struct weft_metadata *out, size_t *count)
{
    const struct antialias_params *p = &job->params;
    const struct weft_acaa_report *r = &job->report.acaa;
    run_report_add(out, count, "form", "%s", weft_acaa_form_names[r->form]);
    if (r->form == WEFT_ACAA_JITTER)
        return;
    run_report_add(out, count, "coincident", "%s", weft_acaa_coincident_names[p->coincident]);
    run_report_add(out, count, "sums", "%s", weft_acaa_sums_names[p->sums]);
    run_report_add(out, count, "weights", "%lld less, %lld more", (long long)r->less,
                   (long long)r->more);
}

static void add_supersampled(const struct antialias_job *job, struct weft_metadata *out,
                             size_t *count)
{
    const struct antialias_params *p = &job->params;
    const struct weft_marks *marks = job->report.marks;
    run_report_add(out, count, "pattern", "%s", p->pattern ? p->pattern->name : "grid");
    run_report_add(out, count, "store", "%s", weft_supersample_store_names[p->store]);
    run_report_add(out, count, "method", "%s",
                   weft_accumulate_method_names[job->report.supersample.method]);
    if (!marks)
        return;
    run_report_add(out, count, "mark", "%s", weft_mark_names[p->mark]);
    run_report_add(out, count, "marked", "%lld pixels, %lld left out", (long long)marks->count,
                   (long long)marks->left);
    if (p->contrast > 0.0)
        run_report_add(out, count, "contrast", "%.9g", p->contrast);
    if (p->max_share > 0.0)
        run_report_add(out, count, "max_edge_share", "%.9g", p->max_share);
}

size_t antialias_job_attributes(const struct antialias_job *job, const char *what, int frame,
                                struct weft_metadata out[PICTURE_ATTRIBUTES])
{
    const struct antialias_params *p = &job->params;
    char text[KERNELS_TEXT];
    size_t count = 0;
    run_report_add(out, &count, "version", "%s", weft_version());
    if (what)
        run_report_add(out, &count, "what", "%s", what);
    run_report_add(out, &count, "antialias", "%s", antialias_way_names[p->way]);
    run_report_add(out, &count, "scene", "%s", scene_text(job, text));
    run_report_add(out, &count, "samples", "%d", job->report.samples);
    run_report_add(out, &count, "discrepancy", "%.9g", job->report.discrepancy);
    if (p->way == ANTIALIAS_ACAA || is_supersampled(job)) {
        run_report_add(out, &count, "filter", "%.180s", antialias_job_filter(job, text));
        run_report_add(out, &count, "filter_width", "%.9g", filter_width(job));
    }
    if (p->way != ANTIALIAS_ACAA)
        run_report_add(out, &count, "format", "%s", weft_antialias_format_names[p->format]);
    if (p->way == ANTIALIAS_ACAA)
        add_acaa(job, out, &count);
    else if (is_supersampled(job))
        add_supersampled(job, out, &count);
    else if (p->way == ANTIALIAS_MSAA)
        run_report_add(out, &count, "resolve", "%s", weft_msaa_resolve_names[p->resolve]);
    if (job->frames > 1)
        run_report_add(out, &count, "frame", "%d of %d", frame, job->frames);
    run_report_add(out, &count, "time", "%.9g", antialias_job_time(job, frame));
    run_report_add(out, &count, "seed", "%llu", (unsigned long long)p->seed);
    run_report_add_renderer(out, &count, job->context);
    return count;
}

// ---- how it is drawn ----------------------------------------------------------------------------

// A line of its own: on standard output, or as a message.
typedef void (*line)(const char *format, ...) __attribute__((format(printf, 1, 2)));

static void tell_way(const struct antialias_job *job, line tell)
{
    const struct antialias_params *p = &job->params;
    const struct antialias_report *r = &job->report;
    char text[KERNELS_TEXT];
    if (p->way == ANTIALIAS_ACAA && r->acaa.form == WEFT_ACAA_JITTER)
        tell("form: jitter: %s", r->acaa.why);
    else if (p->way == ANTIALIAS_ACAA)
        tell("form: %s: %s; coincident surfaces: %s, sums: %s, depths of %d bits",
             weft_acaa_form_names[r->acaa.form], r->acaa.why,
             weft_acaa_coincident_names[p->coincident], weft_acaa_sums_names[p->sums],
             p->depth_bits);
    else if (is_supersampled(job))
        tell("store: %s, sums by %s, colours: %s", weft_supersample_store_names[p->store],
             weft_accumulate_method_names[r->supersample.method],
             weft_antialias_format_names[p->format]);
    else
        tell("resolve: %s, colours: %s, depths of %d bits", weft_msaa_resolve_names[p->resolve],
             weft_antialias_format_names[p->format], p->depth_bits);
    if (p->way == ANTIALIAS_ADAPTIVE)
        tell("marks: %s edges, contrast above %g (0: none), up to a share of %g (0: any)",
             weft_mark_names[p->mark], p->contrast, p->max_share);
    if (p->way == ANTIALIAS_ACAA || is_supersampled(job))
        tell("filter: %.180s, %.4g pixels wide: a sample reaches %d pixels to each side",
             antialias_job_filter(job, text), filter_width(job), r->radius);
}

// Million bytes, as the papers count.
static double mega(uint64_t bytes)
{
    return 1e-6 * (double)bytes;
}

static void tell_formulas(const struct antialias_job *job, line tell)
{
    const struct antialias_report *r = &job->report;
    if (job->params.way == ANTIALIAS_ADAPTIVE && !r->marks)
        return;
    if (job->params.way == ANTIALIAS_ADAPTIVE)
        tell("bytes: %.4g MB by the paper's formula for %lld marked pixels, %.4g MB for full "
             "supersampling",
             mega(r->formula_bytes), (long long)r->marks->count, mega(r->full_bytes));
    else
        tell("bytes: %.4g MB by formula", mega(r->formula_bytes));
    if (job->params.way == ANTIALIAS_ACAA)
        tell("  MSAA of as many samples has %.4g MB with colours of 8 bits, %.4g MB of 16f, %.4g "
             "MB of 32f",
             mega(r->multisample_bytes[0]), mega(r->multisample_bytes[1]),
             mega(r->multisample_bytes[2]));
}

static void tell_plan(const struct antialias_job *job, line tell)
{
    const struct antialias_report *r = &job->report;
    const struct antialias_params *p = &job->params;
    char text[ANTIALIAS_TEXT], discrepancy[48] = "";
    if (r->discrepancy > 0.0)
        snprintf(discrepancy, sizeof discrepancy, " of discrepancy %.4f", r->discrepancy);
    tell("%s of %s, %d x %d: %d picture%s of %d sample%s%s in %d pass%s",
         antialias_way_names[p->way], scene_text(job, text), p->size[0], p->size[1], job->frames,
         job->frames == 1 ? "" : "s", r->samples, r->samples == 1 ? "" : "s", discrepancy,
         r->passes, r->passes == 1 ? "" : "es");
    tell_way(job, tell);
}

void antialias_job_explain(const struct antialias_job *job)
{
    const struct antialias_params *p = &job->params;
    tell_plan(job, report_line);
    if (p->way == ANTIALIAS_ADAPTIVE)
        report_line("bytes: by the paper's formula %.4g MB and %d for each marked pixel; %.4g MB "
                    "for full supersampling",
                    mega(weft_bytes_adaptive(p->size[0], p->size[1], 0, p->samples, 3, 4)),
                    7 * p->samples, mega(job->report.full_bytes));
    else
        tell_formulas(job, report_line);
}

// ---- what came of it ----------------------------------------------------------------------------

static void note_times(const struct antialias_job *job)
{
    const struct antialias_seconds *s = &job->seconds;
    report_note("scene %.3f s, context %.3f, prepare %.3f, draw %.3f, verify %.3f, write %.3f, "
                "total %.3f s",
                s->scene, s->context, s->prepare, s->draw, s->verify, s->write,
                report_now_seconds() - job->start);
    if (job->shadow.faces)
        report_note("shadows: %d faces of %d x %d texels, bias %.3g, %llu bytes", job->shadow.faces,
                    job->shadow.size, job->shadow.size, job->shadow.bias,
                    (unsigned long long)job->shadow.bytes);
}

static void print_marks(const struct antialias_job *job)
{
    const struct weft_marks *m = job->report.marks;
    const double pixels = (double)job->params.size[0] * (double)job->params.size[1];
    report_line("marked: %.2f %% of the pixels, %lld by edges and %lld by contrast",
                100.0 * (double)m->count / pixels, (long long)m->by_edges,
                (long long)m->by_contrast);
    if (m->left)
        report_line("  %lld of them are left out, which makes an rms error of about %.3g",
                    (long long)m->left, m->left_error);
}

static void print_summary(const struct antialias_job *job)
{
    char text[ANTIALIAS_TEXT];
    const struct antialias_report *r = &job->report;
    report_line("%s of %s: %d picture%s of %d sample%s, %.4g s each until read back%s (median; the "
                "first %.4g s)",
                antialias_way_names[job->params.way], scene_text(job, text), job->drawn,
                job->drawn == 1 ? "" : "s", r->samples, r->samples == 1 ? "" : "s",
                antialias_job_median(job),
                job->divided.is && !job->divided.by_frame ? ", its parts added up" : "",
                job->seconds_each[0]);
    if (job->params.way == ANTIALIAS_ACAA && job->weights.frames == 0)
        report_line("weights: all pixels have that of their %d samples", r->samples);
    if (r->marks)
        print_marks(job);
    tell_formulas(job, report_line);
    report_line("  held: %.4g MB", mega(r->bytes));
}

static void print_exactness(const struct antialias_job *job)
{
    const struct antialias_exactness *e = &job->exactness;
    if (e->values)
        report_line("against exact coverage, known to %.1g: rms error %.4g, the largest %.4g, in "
                    "%s at %d,%d",
                    e->known_to, sqrt(e->square / (double)e->values), e->largest,
                    picture_channel_names[e->channel], e->at[0], e->at[1]);
}

void antialias_job_print_text(const struct antialias_job *job)
{
    const struct option_value *o = job->option;
    if (o[ASK_JSON].given)
        return;
    if (!report_is_quiet())
        print_summary(job);
    print_exactness(job);
    if (o[ASK_PREVIEW].given)
        run_report_print_preview(o[ASK_PREVIEW].text, job->preview_range);
    load_report_print(&job->divided.work);
    tell_plan(job, report_note);
    note_times(job);
}
