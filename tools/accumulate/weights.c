// SPDX-License-Identifier: BSD-3-Clause
// The weights of `weft accumulate`: frame k of N stands at t = (k + 1/2) / N of the shutter's time.
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/accumulate/job.h"
#include "tools/common/paths.h"
#include "tools/common/report.h"

enum { MAX_LINE = 256 };

static double midpoint(const struct accumulate_job *job, int64_t i)
{
    return ((double)i + 0.5) / (double)job->frame_count;
}

// ---- shapes -------------------------------------------------------------------------------------

static void set_tent(struct accumulate_job *job)
{
    for (int64_t i = 0; i < job->frame_count; i++)
        job->frame[i].weight = 1.0 - fabs(2.0 * midpoint(job, i) - 1.0);
}

// "gauss" or "gauss:SIGMA", of the shutter's time.
static enum weft_result set_gauss(struct accumulate_job *job, const char *text)
{
    double sigma = 1.0 / 6.0;
    char *end = NULL;
    if (text[5]) {
        sigma = strtod(text + 6, &end);
        if (end == text + 6 || *end || !(sigma >= 1e-3 && sigma <= 1e3)) {
            report_error("--weights %s: sigma is a share of the shutter's time from 0.001 to 1000, "
                         "as gauss:0.2",
                         text);
            return WEFT_ERR_ARGUMENT;
        }
    }
    for (int64_t i = 0; i < job->frame_count; i++) {
        const double d = (midpoint(job, i) - 0.5) / sigma;
        job->frame[i].weight = exp(-0.5 * d * d);
    }
    return WEFT_OK;
}

// Sampled at midpoints over the whole support.
static enum weft_result set_kernel(struct accumulate_job *job, const char *text)
{
    struct weft_kernel kernel;
    weft_kernel_file *file = NULL;
    enum weft_result res = kernels_load(text, &kernel, &file);
    if (res == WEFT_OK && (kernel.prefiltered || kernel.radial || kernel.normalised)) {
        report_error("--weights %s: weights of frames are the kernel's own, without a prefilter, "
                     "+radial or +unit",
                     text);
        res = WEFT_ERR_ARGUMENT;
    }
    for (int64_t i = 0; res == WEFT_OK && i < job->frame_count; i++)
        job->frame[i].weight =
            weft_kernel_weight(&kernel, kernel.support * (2.0 * midpoint(job, i) - 1.0));
    weft_kernel_file_destroy(&file);
    return res;
}

// ---- files --------------------------------------------------------------------------------------

struct weight_file {
    FILE *in;
    const char *path;
    int line;
    int64_t count;
};

static enum weft_result fail_line(const struct weight_file *f, const char *text, const char *why)
{
    report_error("%s:%d: '%.40s' %s", f->path, f->line, text, why);
    return WEFT_ERR_FORMAT;
}

// Whether the method takes weights below 0; what is chosen by itself takes any.
static bool takes_negative(enum weft_accumulate_method method)
{
    return method != WEFT_ACCUMULATE_TREE && method != WEFT_ACCUMULATE_BLEND;
}

static enum weft_result take_line(struct accumulate_job *job, struct weight_file *f, char *line)
{
    line[strcspn(line, "#\r\n")] = 0;
    char *text = line + strspn(line, " \t"), *end;
    for (size_t n = strlen(text); n && strchr(" \t", text[n - 1]); n--)
        text[n - 1] = 0;
    if (!*text)
        return WEFT_OK;
    const double weight = strtod(text, &end);
    if (*end || end == text)
        return fail_line(f, text, "is not one number");
    if (!isfinite(weight))
        return fail_line(f, text, "is no weight: it must be finite");
    if (weight < 0.0 && !takes_negative(job->request.how.method))
        return fail_line(f, text,
                         job->request.how.method == WEFT_ACCUMULATE_TREE
                             ? "is below 0, which --method tree does not take"
                             : "is below 0, which --method blend does not take");
    if (f->count < job->frame_count)
        job->frame[f->count].weight = weight;
    f->count++;
    return WEFT_OK;
}

static enum weft_result read_lines(struct accumulate_job *job, struct weight_file *f)
{
    char line[MAX_LINE];
    enum weft_result res = WEFT_OK;
    while (res == WEFT_OK && fgets(line, sizeof line, f->in)) {
        f->line++;
        const size_t length = strlen(line);
        if (length + 1 == sizeof line && line[length - 1] != '\n' && !strchr(line, '#'))
            return fail_line(f, line, "... is longer than a number");
        const bool cut = length + 1 == sizeof line && line[length - 1] != '\n';
        res = take_line(job, f, line);
        for (int c = 0; cut && c != '\n' && c != EOF;)
            c = fgetc(f->in);
    }
    if (res == WEFT_OK && ferror(f->in)) {
        report_error("%s cannot be read: %s", f->path, strerror(errno));
        return WEFT_ERR_OPEN;
    }
    if (res == WEFT_OK && f->count != job->frame_count) {
        report_error("%s has %lld weights, for %lld frames", f->path, (long long)f->count,
                     (long long)job->frame_count);
        return WEFT_ERR_FORMAT;
    }
    return res;
}

static enum weft_result load_file(struct accumulate_job *job, FILE *in, const char *path)
{
    struct weight_file f = {.in = in, .path = path};
    const enum weft_result res = read_lines(job, &f);
    fclose(in);
    return res;
}

// ---- all ----------------------------------------------------------------------------------------

// The record of a name that parameters may follow.
static bool is_kernel(const char *text)
{
    struct weft_kernel kernel;
    return strncmp(text, "table:", 6) == 0 || weft_kernel_parse(NULL, text, &kernel) == WEFT_OK;
}

static enum weft_result fail_file(const char *text)
{
    const char *names[256] = {"uniform", "gauss", "tent"}, *reason = strerror(errno);
    int count = 3;
    for (int i = 0; weft_kernel_list[i] && count < 255; i++)
        names[count++] = weft_kernel_list[i]->name;
    const char *meant =
        strpbrk(text, "/.") ? NULL : weft_closest_find(text, strcspn(text, ":"), names);
    report_error(
        "--weights %s: uniform, gauss, tent, a kernel, or a file of numbers; no kernel has "
        "this name%s%s%s, and the file: %s",
        text, meant ? " (did you mean " : "", meant ? meant : "", meant ? "?)" : "", reason);
    return WEFT_ERR_OPEN;
}

static enum weft_result set_by_text(struct accumulate_job *job, const char *text)
{
    if (strcmp(text, "uniform") == 0)
        return WEFT_OK;
    if (strcmp(text, "tent") == 0) {
        set_tent(job);
        return WEFT_OK;
    }
    if (strcmp(text, "gauss") == 0 || strncmp(text, "gauss:", 6) == 0)
        return set_gauss(job, text);
    if (is_kernel(text))
        return set_kernel(job, text);
    FILE *in = fopen(text, "r");
    job->weights.file = in != NULL;
    return in ? load_file(job, in, text) : fail_file(text);
}

enum weft_result accumulate_sum_weights(struct accumulate_job *job)
{
    double magnitude = 0.0;
    job->sequence = malloc((size_t)job->frame_count * sizeof *job->sequence);
    if (!job->sequence) {
        report_error("out of memory for %lld frames", (long long)job->frame_count);
        return WEFT_ERR_MEMORY;
    }
    job->weights.least = INFINITY;
    job->weights.largest = -INFINITY;
    for (int64_t i = 0; i < job->frame_count; i++) {
        const double weight = job->frame[i].weight;
        job->weights.total += weight;
        job->weights.least = fmin(job->weights.least, weight);
        job->weights.largest = fmax(job->weights.largest, weight);
        magnitude += fabs(weight);
        if (weight != 0.0)
            job->sequence[job->counting++] = i;
    }
    if (job->counting && fabs(job->weights.total) > 0x1p-40 * magnitude)
        return WEFT_OK;
    if (job->counting == 0)
        report_error("--weights %s: all %lld weights are 0", job->weights.text,
                     (long long)job->frame_count);
    else
        report_error("--weights %s: the weights add up to %g", job->weights.text,
                     job->weights.total);
    return job->weights.file ? WEFT_ERR_FORMAT : WEFT_ERR_ARGUMENT;
}

static enum weft_result check_negative(const struct accumulate_job *job)
{
    for (int64_t i = 0; i < job->frame_count && !takes_negative(job->request.how.method); i++) {
        if (job->frame[i].weight >= 0.0)
            continue;
        report_error("--weights %s: frame %lld, %s, has %g: --method %s takes none below 0",
                     job->weights.text, (long long)i, job->frame[i].path, job->frame[i].weight,
                     weft_accumulate_method_names[job->request.how.method]);
        return WEFT_ERR_ARGUMENT;
    }
    return WEFT_OK;
}

enum weft_result accumulate_set_weights(struct accumulate_job *job)
{
    const struct option_value *weights = &job->option[ACCUMULATE_WEIGHTS];
    if (job->joins)
        return accumulate_sum_weights(job);
    snprintf(job->weights.text, sizeof job->weights.text, "%s",
             weights->given ? weights->text : "uniform");
    enum weft_result res = set_by_text(job, job->weights.text);
    if (res == WEFT_OK)
        res = accumulate_sum_weights(job);
    return res == WEFT_OK ? check_negative(job) : res;
}
